"""The parts of a mechanism: bodies, joints, forces, contacts, and their laws."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from rustchain.arguments import plain
from rustchain.description.base import Description, Typed, description
from rustchain.description.chain import Chain
from rustchain.description.laws.film import LubricantFilm
from rustchain.description.laws.force import ForceLaw, LankaraniNikravesh
from rustchain.description.laws.friction import Coulomb, LuGre
from rustchain.description.material import Material
from rustchain.description.mechanism.checks import check_part_name
from rustchain.description.signals import Curve, Signal
from rustchain.description.sprocket import Sprocket
from rustchain.typing import Numbers, Point, Rows

LoadFunction: TypeAlias = Callable[[float, list[float], list[float]], Numbers]

GROUND = "ground"
_LAW = LankaraniNikravesh()
_STEEL = Material()


@description(frozen=True)
class LinearContact(Typed):
    """Contact force: stiffness * penetration + damping * its rate, never tensile.

    Attributes
    ----------
    stiffness, damping : float
        Stiffness [N/m] and damping [N s/m]; with a `length` they are per metre of length, [N/m^2]
        and [N s/m^2].
    length : float, optional
        Length of contact [m].
    friction : Coulomb or LuGre, optional
        Friction of the surfaces.
    film : LubricantFilm, optional
        Lubricant, in clearance joints; without a length of its own it has the length of contact.

    Examples
    --------
    >>> rc.LinearContact(stiffness=1e8)
    LinearContact(stiffness=100000000.0)
    """

    stiffness: float
    damping: float = 0.0
    length: float | None = None
    friction: Coulomb | LuGre | None = dataclasses.field(default=None, kw_only=True)
    film: LubricantFilm | None = dataclasses.field(default=None, kw_only=True)


@description(frozen=True)
class HuntCrossley(Typed):
    """Contact force: stiffness * penetration**exponent * (1 + damping * rate), never tensile.

    Attributes
    ----------
    stiffness : float
        Stiffness [N/m**exponent].
    exponent : float
        Exponent of the penetration, 1 to 10.
    damping : float
        Factor of the penetration rate [s/m].
    friction : Coulomb or LuGre, optional
        Friction of the surfaces.
    film : LubricantFilm, optional
        Lubricant, in clearance joints; it needs a length.

    Examples
    --------
    >>> rc.HuntCrossley(stiffness=1e9, damping=0.3)
    HuntCrossley(stiffness=1000000000.0, damping=0.3)
    """

    stiffness: float
    exponent: float = 1.5
    damping: float = 0.0
    friction: Coulomb | LuGre | None = dataclasses.field(default=None, kw_only=True)
    film: LubricantFilm | None = dataclasses.field(default=None, kw_only=True)


@description(frozen=True)
class SurfaceContact(Typed):
    """Contact by a law of cylinders, its stiffness from radii, length and material.

    Attributes
    ----------
    law : ForceLaw
        Force law, with its friction and, in clearance joints, its film.
    length : float
        Length of contact along the axis of the cylinders [m], 0.01 m by default. The laws of Hertz
        and of Lankarani and Nikravesh do not depend on it.
    material : Material
        Material of both surfaces, by default the steel of the published drive. Its restitution
        determines the damping.
    min_impact_velocity : float
        Lower bound on the initial impact velocity used by the damping factor [m/s].

    Examples
    --------
    >>> rc.SurfaceContact(rc.Hertz(), length=0.02)
    SurfaceContact(law=Hertz(), length=0.02)
    """

    law: ForceLaw = _LAW
    length: float = 0.01
    material: Material = _STEEL
    min_impact_velocity: float = 1e-3


ContactLaw: TypeAlias = LinearContact | HuntCrossley | SurfaceContact


class Part(Description):
    """A part of a mechanism, which is checked when the mechanism is put together."""

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples."""
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, plain(getattr(self, field.name)))
        check_part_name(f"name of a {type(self).__name__.lower()}", getattr(self, "name", None))


@dataclass(frozen=True)
class Body(Part):
    """A rigid body; its frame sits at the centre of mass. See `Mechanism.add_body`.

    Attributes
    ----------
    name : str
        Name of the body.
    mass, inertia : float
        Mass [kg] and moment of inertia about the centre of mass [kg m^2].
    position, velocity : (float, float, float)
        Centre of mass and angle [m, m, rad], and their rates [m/s, m/s, rad/s].
    fixed : bool
        Whether the body is held where it is.
    """

    name: str
    mass: float
    inertia: float
    position: Numbers = (0.0, 0.0, 0.0)
    velocity: Numbers = (0.0, 0.0, 0.0)
    fixed: bool = False


@dataclass(frozen=True)
class Joint(Part):
    """An ideal joint or a driver. See the methods of `Mechanism`.

    Attributes
    ----------
    kind : str
        Kind of joint, as the methods of `Mechanism` name it.
    name : str
        Name of the part.
    body_a, body_b : str
        Names of the bodies; "ground" is the frame that does not move.
    point_a, point_b : (float, float)
        Points in the frames of the bodies [m].
    direction : (float, float)
        Line of the joint in the frame of body a.
    value : float, optional
        Length [m], angle [rad] or ratio that the joint holds; by default as placed.
    carrier : str, optional
        Body that carries the axes of two gears.
    motion : float or function of time
        Motion of a driver.
    by_speed : bool
        Whether `motion` is a speed.
    friction : Coulomb, optional
        Friction of the pin of a revolute joint.
    radius : float, optional
        Radius of that pin [m].
    """

    kind: str
    name: str
    body_a: str
    body_b: str
    point_a: Point = (0.0, 0.0)
    point_b: Point = (0.0, 0.0)
    direction: Point = (1.0, 0.0)
    value: float | None = None
    carrier: str | None = None
    motion: Signal = 0.0
    by_speed: bool = False
    friction: Coulomb | None = None
    radius: float | None = None


@dataclass(frozen=True)
class Force(Part):
    """A force element. See the methods of `Mechanism`.

    Attributes
    ----------
    kind : str
        Kind of element, as the methods of `Mechanism` name it.
    name : str
        Name of the part.
    body_a, body_b : str
        Names of the bodies; "ground" is the frame that does not move.
    point_a, point_b : (float, float)
        Points in the frames of the bodies [m].
    x, y : float or function of time
        Components of the force [N], or of the torque [N m] in x.
    follows : bool
        Whether the force turns with the body.
    stiffness, cubic, damping : float
        Coefficients of a spring [N/m, N/m^3, N s/m], or of a torsion spring by radian.
    rest : float, optional
        Length [m] or angle [rad] without force; by default as placed.
    table : sequence of rows, optional
        Force over elongation, or torque over speed.
    function : callable, optional
        Load by a Python function, which files do not hold.
    """

    kind: str
    name: str
    body_a: str
    body_b: str
    point_a: Point = (0.0, 0.0)
    point_b: Point = (0.0, 0.0)
    x: Signal = 0.0
    y: Signal = 0.0
    follows: bool = False
    stiffness: float = 0.0
    cubic: float = 0.0
    damping: float = 0.0
    rest: float | None = None
    table: Curve | None = None
    function: LoadFunction | None = None


@dataclass(frozen=True)
class Contact(Part):
    """A circle that may touch a profile. See the methods of `Mechanism`.

    Attributes
    ----------
    kind : str
        Kind of profile, as the methods of `Mechanism` name it.
    name : str
        Name of the part.
    body_a, body_b : str
        Names of the bodies; "ground" is the frame that does not move.
    radius : float
        Radius of the circle, on body b [m].
    law : LinearContact, HuntCrossley or SurfaceContact
        Contact law.
    point_a, point_b : (float, float)
        Points in the frames of the bodies [m].
    profile_radius : float
        Radius of a round profile [m].
    points : sequence of rows
        Points or pieces of an outline [m].
    closed : bool
        Whether the outline is closed.
    sprocket : Sprocket, optional
        Teeth that are the profile.
    chain : Chain, optional
        Chain that these are cut for.
    """

    kind: str
    name: str
    body_a: str
    body_b: str
    radius: float
    law: ContactLaw
    point_a: Point = (0.0, 0.0)
    point_b: Point = (0.0, 0.0)
    profile_radius: float = 0.0
    points: Rows = ()
    closed: bool = False
    sprocket: Sprocket | None = None
    chain: Chain | None = None
