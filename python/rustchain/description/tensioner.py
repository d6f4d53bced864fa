"""Tensioners of a chain."""

from __future__ import annotations

from rustchain.description.base import Description, Point, description


@description(frozen=True)
class Tensioner(Description):
    """A pull on a sprocket's centre, which slides along one direction or swings about a pivot.

    Attributes
    ----------
    pretension : float
        Tension that the pull gives the strands at rest [N], where the sprocket has taken up the
        chain's slack.
    sprocket : int
        Number of the sprocket, from 1.
    ramp_time : float
        Time over which the pull grows from zero [s].
    damping : float
        Damping of the slide [N s/m].
    damping_back : float, optional
        Damping while the centre gives way to the chain [N s/m], by default the same: a hydraulic
        tensioner follows the chain through its check valve and gives way by its leak.
    direction : (float, float), optional
        Direction of the pull; by default away from the other one of two sprockets, and along the
        bisector that tightens both strands alike of more.
    stiffness : float
        How much of the pull is lost as the centre moves along it [N/m]: a spring's stiffness.
    travel : (float, float), optional
        How far the centre can move against the pull and along it [m], where stops of 1e7 N/m are
        (0 for the first: the sprocket cannot give way); by default there are none.
    pivot : (float, float), optional
        Where the arm turns that carries the sprocket [m]; by default the sprocket slides. Lengths,
        stiffness and damping then count along the circle of the centre.
    arm_inertia : float
        Moment of inertia of the arm about its pivot, without the sprocket [kg m^2].
    ratchet : float, optional
        Distance of the teeth of a ratchet along the way [m], which lets the centre follow the pull
        and holds it, with 1e7 N/m, behind the last tooth that it has passed, counted from where the
        sprocket is described; 0: wherever it is. By default there is none.
    """

    pretension: float
    sprocket: int = 2
    ramp_time: float = 0.1
    damping: float = 2000.0
    direction: Point | None = None
    stiffness: float = 0.0
    travel: tuple[float, float] | None = None
    pivot: Point | None = None
    arm_inertia: float = 0.0
    damping_back: float | None = None
    ratchet: float | None = None
