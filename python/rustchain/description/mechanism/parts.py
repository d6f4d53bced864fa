"""The parts of a mechanism: bodies, joints, forces, contacts, their laws, and functions of time."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias, get_type_hints

from rustchain.arguments import admitted, shown
from rustchain.description.base import Description, plain
from rustchain.description.drive import Chain, Sprocket
from rustchain.description.laws.film import LubricantFilm
from rustchain.description.laws.force import ForceLaw, LankaraniNikravesh
from rustchain.description.laws.friction import Coulomb, LuGre
from rustchain.description.material import Material
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords

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


@known_keywords
@dataclass(frozen=True)
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


@known_keywords
@dataclass(frozen=True)
class Table(_Function):
    """Straight lines between rows of (time [s], value), held at both ends; a ramp has two rows."""

    rows: Rows


@known_keywords
@dataclass(frozen=True)
class Spline(_Function):
    """A cubic spline with free ends through rows of (time [s], value)."""

    rows: Rows


@known_keywords
@dataclass(frozen=True)
class Sines(_Function):
    """A sum of sines: offset + sum of amplitude * sin(frequency * t + phase).

    Attributes
    ----------
    terms : sequence of (amplitude, angular frequency [rad/s], phase [rad])
    offset : float
        Mean value.
    """

    terms: Rows
    offset: float = 0.0


TimeFunction: TypeAlias = float | SmoothStep | Table | Spline | Sines


@known_keywords
@dataclass(frozen=True)
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


@known_keywords
@dataclass(frozen=True)
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


@known_keywords
@dataclass(frozen=True)
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
    """A rigid body; its frame sits at the centre of mass. See `Mechanism.add_body`."""

    name: str
    mass: float
    inertia: float
    position: Point
    velocity: Point
    fixed: bool


@dataclass(frozen=True)
class Joint(_Part):
    """An ideal joint or a driver. See the methods of `Mechanism`."""

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
    """A force element. See the methods of `Mechanism`."""

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
    """A circle that may touch a profile. See the methods of `Mechanism`."""

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
