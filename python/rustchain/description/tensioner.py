"""Tensioners of a chain."""

from __future__ import annotations

from rustchain.description.base import Description, description
from rustchain.typing import Pair, Point


@description(frozen=True)
class Tensioner(Description):
    """A force on the centre of a sprocket, which slides along a direction or swings about a pivot.

    Attributes
    ----------
    pretension : float
        Tension of the strands at rest [N], in the position where the slack is taken up.
    sprocket : int
        Number of the sprocket, from 1.
    ramp_time : float
        Time over which the force grows from zero [s].
    damping : float
        Damping coefficient of the slide [N s/m].
    damping_back : float, optional
        Damping coefficient while the centre moves back against the force [N s/m], by default the
        same. It describes the leak of a hydraulic tensioner with a check valve.
    direction : (float, float), optional
        Direction of the force; by default away from the other one of two sprockets. With more
        sprockets it is the bisector that tightens both strands alike.
    stiffness : float
        Reduction of the tensioner force per displacement along it [N/m]: the stiffness of a spring.
    travel : (float, float), optional
        Largest displacements of the centre against the force and along it [m], with stops of 1e7
        N/m. A first number of 0 permits no motion against the force. By default there are no stops.
    pivot : (float, float), optional
        Pivot of the arm that carries the sprocket [m]; by default the sprocket slides. Lengths,
        stiffness and damping are then those along the circle of the centre.
    arm_inertia : float
        Moment of inertia of the arm about its pivot, without the sprocket [kg m^2].
    ratchet : float, optional
        Distance of the teeth of a ratchet along the guide path [m], counted from the described
        position. The centre can move along the force and is held, with 1e7 N/m, behind the last
        tooth that it has passed. 0: it is held at any position. By default there is none.

    Examples
    --------
    >>> spring = rc.Tensioner(80.0, sprocket=2, stiffness=2000.0, direction=(0.0, -1.0))
    >>> spring.travel is None  # no stops
    True
    """

    pretension: float
    sprocket: int = 2
    ramp_time: float = 0.1
    damping: float = 2000.0
    direction: Point | None = None
    stiffness: float = 0.0
    travel: Pair | None = None
    pivot: Point | None = None
    arm_inertia: float = 0.0
    damping_back: float | None = None
    ratchet: float | None = None
