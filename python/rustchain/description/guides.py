"""Guides of a chain: rails, blades on arms, idlers without teeth."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import checked
from rustchain.description.base import Description, description
from rustchain.description.material import Material
from rustchain.typing import Pair, Point


@description(frozen=True)
class GuideArm(Description):
    """An arm that carries a rail, swung by a plunger that presses on the rail's middle.

    Force, spring, dashpot and stops act along the line of the plunger, the direction of the rail.

    Attributes
    ----------
    pivot : (float, float)
        Position of the pivot of the arm [m].
    force : float
        Full force of the plunger at the described position of the rail [N].
    ramp_time : float
        Time over which the force grows from zero [s].
    stiffness : float
        Reduction of the force per displacement of the plunger outward from the described position
        of the rail [N/m].
    damping : float
        Damping coefficient of the dashpot of the plunger [N s/m].
    damping_back : float, optional
        Damping coefficient while the arm moves back [N s/m], by default the same. It describes the
        leak of a hydraulic tensioner with a check valve.
    travel : (float, float), optional
        Largest displacements of the plunger, back and out, from the described position of the rail
        [m], with stops of 1e7 N/m. By default there are no stops.
    inertia : float
        Moment of inertia of arm and rail about the pivot [kg m^2].
    ratchet : float, optional
        Distance of the teeth of a ratchet along the path of the plunger [m], counted from the
        described position of the rail. The plunger can move out and is held behind the last tooth
        that it has passed. 0: it is held at any position. By default there is none.

    Examples
    --------
    >>> arm = rc.GuideArm(pivot=(0.1, 0.05), force=40.0, stiffness=2e3, ratchet=1e-3)
    >>> arm.damping
    100.0
    """

    pivot: Point
    force: float
    ramp_time: float = 0.1
    stiffness: float = 0.0
    damping: float = 100.0
    damping_back: float | None = None
    travel: Pair | None = None
    inertia: float = 2e-4
    ratchet: float | None = None


@description(frozen=True)
class GuideRail(Description):
    """A bar with round ends in contact with the chain's bushings: a rail, or with an arm a blade.

    Attributes
    ----------
    center : (float, float)
        Middle of the rail [m], half-way between the centres of its round ends.
    direction : (float, float)
        Direction out of the face on which the chain runs.
    length : float
        Length over the round ends [m].
    radius : float, optional
        Radius of the arched faces [m], negative for hollow faces; by default they are straight. The
        depth of a hollow bar follows from its hollow face.
    end_radius : float
        Radius of the ends [m]: half the thickness of a straight bar.
    arm : GuideArm, optional
        Arm that carries the rail; by default the rail is fixed.
    material : Material, optional
        Elastic constants of the guide; by default those of the chain. The restitution is that of
        the chain.
    plate_height : float, optional
        Height of the link plates [m] if plates are in contact with the guide; their ends are round
        about the hinges. By default the bushings are in contact.

    Examples
    --------
    >>> rc.GuideRail(center=(0.1, 0.06), direction=(1.0, 0.0), length=0.1)
    GuideRail(center=(0.1, 0.06), direction=(1.0, 0.0), length=0.1)
    """

    center: Point
    direction: Point
    length: float
    radius: float | None = None
    end_radius: float = 0.005
    arm: GuideArm | None = None
    material: Material | None = None
    plate_height: float | None = None

    @checked
    def outline(self, points: int = 24) -> npt.NDArray[np.float64]:
        """Return the closed outline [m], shape (points in all, 2), counterclockwise.

        About `center`; the x axis points out of the face. Arcs have `points` points each, 2
        to 1000.
        """
        return _rustchain.guide_outline(self, points)


@description(frozen=True)
class SmoothIdler(Description):
    """A wheel without teeth in contact with the chain's bushings.

    Attributes
    ----------
    radius : float
        Radius [m].
    center : (float, float)
        Centre [m].
    inertia : float, optional
        Moment of inertia [kg m^2] of an idler that can turn; by default it does not turn.
    material : Material, optional
        Elastic constants of the guide; by default those of the chain. The restitution is that of
        the chain.
    plate_height : float, optional
        Height of the link plates [m] if plates are in contact with the guide; their ends are round
        about the hinges. By default the bushings are in contact.

    Examples
    --------
    >>> rc.SmoothIdler(radius=0.02, center=(0.1, 0.08))
    SmoothIdler(radius=0.02, center=(0.1, 0.08))
    """

    radius: float
    center: Point
    inertia: float | None = None
    material: Material | None = None
    plate_height: float | None = None

    @checked
    def outline(self, points: int = 24) -> npt.NDArray[np.float64]:
        """Return the closed outline [m], shape (points in all, 2), counterclockwise."""
        return _rustchain.guide_outline(self, points)
