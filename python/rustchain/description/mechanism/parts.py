"""The parts of a mechanism: bodies, joints, forces, contacts, their laws, and functions of time."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias, get_type_hints

from rustchain.arguments import admitted, shown
from rustchain.description.base import Description, description, plain
from rustchain.description.drive import Chain, Sprocket
from rustchain.description.laws.film import LubricantFilm
from rustchain.description.laws.force import ForceLaw, LankaraniNikravesh
from rustchain.description.laws.friction import Coulomb, LuGre
from rustchain.description.material import Material
from rustchain.errors import InvalidInput

Point: TypeAlias = Sequence[float]
Rows: TypeAlias = Sequence[Sequence[float]]
LoadFunction: TypeAlias = Callable[[float, list[float], list[float]], Sequence[float]]

GROUND = "ground"
_LONGEST_NAME = 200  # characters: two lines of a message, and the width of a legend
_LAW = LankaraniNikravesh()
_STEEL = Material()


class _Part(Description):
    """A part of a mechanism, which is checked when the mechanism is put together."""

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples."""
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, plain(getattr(self, field.name)))
        check_part_name(f"name of a {type(self).__name__.lower()}", getattr(self, "name", None))


def check_part_name(field: str, name: object) -> None:
    """Refuse what results and messages cannot tell a part by."""
    if not isinstance(name, str):
        raise InvalidInput(f"{field} = {shown(name)}: must be text")
    if not name.strip():
        quoted = json.dumps(name[:_LONGEST_NAME])
        msg = f"{field} = {quoted}: must not be blank: results and messages are by name"
        raise InvalidInput(msg)
    if len(name) > _LONGEST_NAME:
        msg = (
            f"{field} = {shown(name)}: has {len(name)} characters; expected at most {_LONGEST_NAME}"
        )
        raise InvalidInput(msg)
    check_name(field, name)


def check_name(field: str, name: object) -> None:
    """Refuse a name that a file of results cannot hold; what is no text is refused elsewhere."""
    if not isinstance(name, str):
        return
    with suppress(UnicodeEncodeError):
        if b"\0" not in name.encode():
            return
    msg = f"{field} = {name!r}: cannot be saved; expected text without NUL and lone surrogates"
    raise InvalidInput(msg)


class _Function(_Part):
    """A function of time or of penetration: the types of its fields are checked at once."""

    def __post_init__(self) -> None:
        """Turn lists and arrays into tuples, and check the type of every field."""
        types = get_type_hints(type(self))
        for field in dataclasses.fields(self):
            where = f"{type(self).__name__}.{field.name}"
            value = admitted(where, getattr(self, field.name), types[field.name])
            object.__setattr__(self, field.name, value)


@description(frozen=True)
class SmoothStep(_Function):
    """From one value to another with two continuous derivatives.

    Attributes
    ----------
    start, end : float
        When it changes [s].
    before, after : float
        Values.
    """

    start: float
    end: float
    before: float
    after: float


@description(frozen=True)
class Table(_Function):
    """Straight lines between rows of (time [s], value), held at both ends; a ramp has two rows.

    Attributes
    ----------
    rows : sequence of (time, value)
        At least one; times increase.
    """

    rows: Rows


@description(frozen=True)
class Spline(_Function):
    """A cubic spline with free ends through rows of (time [s], value).

    Attributes
    ----------
    rows : sequence of (time, value)
        At least two; times increase.
    """

    rows: Rows


@description(frozen=True)
class Sines(_Function):
    """A sum of sines: offset + sum of amplitude * sin(frequency * t + phase).

    Attributes
    ----------
    terms : sequence of (amplitude, angular frequency, phase)
        The sines [rad/s], [rad].
    offset : float
        Mean value.
    """

    terms: Rows
    offset: float = 0.0


TimeFunction: TypeAlias = float | SmoothStep | Table | Spline | Sines


@description(frozen=True)
class LinearContact(_Function):
    """Contact force: stiffness * penetration + damping * its rate, never pulling.

    Attributes
    ----------
    stiffness, damping : float
        [N/m] and [N s/m]; with a length, [N/m^2] and [N s/m^2] of it.
    length : float, optional
        Length of contact [m].
    friction : Coulomb or LuGre, optional
        Friction of the surfaces.
    film : LubricantFilm, optional
        Lubricant, in clearance joints; without a length of its own it has the length of contact.
    """

    stiffness: float
    damping: float = 0.0
    length: float | None = None
    friction: Coulomb | LuGre | None = dataclasses.field(default=None, kw_only=True)
    film: LubricantFilm | None = dataclasses.field(default=None, kw_only=True)


@description(frozen=True)
class HuntCrossley(_Function):
    """Contact force: stiffness * penetration**exponent * (1 + damping * rate), never pulling.

    Attributes
    ----------
    stiffness : float
        [N/m**exponent].
    exponent : float
        1 to 10.
    damping : float
        [s/m].
    friction : Coulomb or LuGre, optional
        Friction of the surfaces.
    film : LubricantFilm, optional
        Lubricant, in clearance joints; it needs a length.
    """

    stiffness: float
    exponent: float = 1.5
    damping: float = 0.0
    friction: Coulomb | LuGre | None = dataclasses.field(default=None, kw_only=True)
    film: LubricantFilm | None = dataclasses.field(default=None, kw_only=True)


@description(frozen=True)
class SurfaceContact(_Function):
    """Contact by a law of cylinders, its stiffness from radii, length and material.

    Attributes
    ----------
    law : ForceLaw
        With its friction and, in clearance joints, its film.
    length : float
        Length of contact [m].
    material : Material
        Of both surfaces; its restitution goes into the damping.
    min_impact_velocity : float
        Least approach speed that the damping reckons with [m/s].
    """

    law: ForceLaw = _LAW
    length: float = 0.01
    material: Material = _STEEL
    min_impact_velocity: float = 1e-3


ContactLaw: TypeAlias = LinearContact | HuntCrossley | SurfaceContact


@dataclass(frozen=True)
class Body(_Part):
    """A rigid body; its frame sits at the centre of mass. See `Mechanism.add_body`.

    Attributes
    ----------
    name : str
        Name of the body.
    mass, inertia : float
        Mass [kg] and moment of inertia about the centre of mass [kg m^2].
    position, velocity : (float, float, float)
        Centre of mass and angle [m, m, rad], and their rates.
    fixed : bool
        Whether the body is held where it is.
    """

    name: str
    mass: float
    inertia: float
    position: Point
    velocity: Point
    fixed: bool


@dataclass(frozen=True)
class Joint(_Part):
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
    motion: TimeFunction = 0.0
    by_speed: bool = False
    friction: Coulomb | None = None
    radius: float | None = None


@dataclass(frozen=True)
class Force(_Part):
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
    x: TimeFunction = 0.0
    y: TimeFunction = 0.0
    follows: bool = False
    stiffness: float = 0.0
    cubic: float = 0.0
    damping: float = 0.0
    rest: float | None = None
    table: Rows | None = None
    function: LoadFunction | None = None


@dataclass(frozen=True)
class Contact(_Part):
    """A circle that may touch a profile. See the methods of `Mechanism`.

    Attributes
    ----------
    kind : str
        Kind of profile, as the methods of `Mechanism` name it.
    name : str
        Name of the part.
    body_a, body_b : str
        Names of the bodies; "ground" is the frame that does not move.
    point_a, point_b : (float, float)
        Points in the frames of the bodies [m].
    radius : float
        Radius of the circle, on body b [m].
    law : LinearContact, HuntCrossley or SurfaceContact
        Contact law.
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
    point_a: Point
    point_b: Point
    radius: float
    law: ContactLaw
    profile_radius: float = 0.0
    points: Rows = ()
    closed: bool = False
    sprocket: Sprocket | None = None
    chain: Chain | None = None
