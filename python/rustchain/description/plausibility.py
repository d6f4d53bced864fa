"""Warnings of inputs of drives and mechanisms that are probably not in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from rustchain.arguments import finite_number
from rustchain.description.signals import Sines, SmoothStep

if TYPE_CHECKING:
    from rustchain.description.chain import Chain
    from rustchain.description.drive import ChainDrive
    from rustchain.description.mechanism.builder import Mechanism
    from rustchain.description.mechanism.parts import Body
    from rustchain.description.scene import Scene


class _Range(NamedTuple):
    """Usual sizes of a field, its unit, and what is said of other sizes; zero is usual."""

    low: float
    high: float
    unit: str
    remedy: str


_MILLIMETRES = "lengths are in metres; divide millimetres by 1000"
_DEGREES = "angles are in radians; convert degrees by math.radians"
# Farther than parts of machines are from each other [m]; 0.1 m in millimetres are 100.
_LENGTH = _Range(0.0, 99.0, "m", _MILLIMETRES)
# Farther than the sprockets of long conveyors are from each other, in pitches.
_FARTHEST = 5000.0
# That of small moons to four times that of Jupiter.
_GRAVITY = _Range(0.05, 100.0, "m/s^2", "about 9.81 is usual; give it in m/s^2")
# From that of soft rubber; steel has 207 in GPa and 207e3 in MPa.
_MODULUS = _Range(
    3e5, math.inf, "Pa", "steel has 2.07e11; give it in Pa, 1e9 of GPa and 1e6 of MPa"
)
_DAMPING = _Range(0.0, 1e9, "N s/m", "10 to 1e6 is usual; give it in N s/m")
_FRICTION = _Range(0.0, 2.0, "", "0.05 to 0.5 is usual; it is friction force over normal force")
_RANGES = {
    f"{kind}.{name}": usual
    for usual, places in (
        (_GRAVITY, {"ChainDrive": ("gravity",), "Mechanism": ("gravity",)}),
        (
            _LENGTH,
            {
                "Joint": ("point_a", "point_b"),
                "Force": ("point_a", "point_b"),
                "Contact": ("point_a", "point_b", "radius"),
            },
        ),
        (_Range(0.0, 3.0, "m", _MILLIMETRES), {"Chain": ("pitch",)}),
        (_MODULUS, {"Material": ("elastic_modulus",), "Plates": ("elastic_modulus",)}),
        (_DAMPING, dict.fromkeys(("Tensioner", "GuideArm"), ("damping", "damping_back"))),
        (
            _FRICTION,
            {"Coulomb": ("coefficient",), "LuGre": ("static_coefficient", "kinetic_coefficient")},
        ),
        (
            _Range(1e-5, 50.0, "Pa s", "0.01 to 0.5 is usual; give it in Pa s, 1e-3 of mPa s"),
            {"LubricantFilm": ("viscosity",)},
        ),
        (
            _Range(0.01, 1e13, "N/m", "1e7 to 1e10 is usual; give it in N/m"),
            {"Linear": ("stiffness",)},
        ),
    )
    for kind, names in places.items()
    for name in names
}

# Radius of gyration of the largest bodies [m]; 0.1 kg with 1e-4 kg m^2 in kg mm^2 have 32.
_WIDEST = 10.0
# Angles at the start [rad]: 45 degrees given as a number are 7 turns.
_LARGEST_ANGLE = 4.0 * math.pi
# Speed of the fastest rotors, 300 000 revolutions a minute [rad/s].
_FASTEST = 3.2e4
# Speed of the fastest roller chains [m/s]; 17 teeth of 12.7 mm at 1440 rad/s have 49.8.
_FASTEST_CHAIN = 40.0
# Mass of a link over the cube of its pitch [kg/m^3]: roller chains have 4e3, 4e6 with grams.
_DENSEST = 2e5
# What turns with a sprocket, as a mass on the chain at its pitch radius [kg].
_HEAVIEST = 1e6


def implausible_inputs(described: Scene | ChainDrive | Mechanism) -> list[str]:
    """Return a sentence for each input of an unusual size: field, value and remedy."""
    return list(_unusual(described, "", "", set()))


def _unusual(value: Any, prefix: str, of: str, seen: set[int]) -> Iterator[str]:  # noqa: ANN401
    """Tell of a description and of all in it, of what is shared once.

    `prefix` is the path of the fields within the part, `of` the name of the part.
    """
    if id(value) in seen:
        return
    seen.add(id(value))
    kind = type(value).__name__
    if kind in _CHECKS:
        yield from _CHECKS[kind](value, prefix, of)
    for name in (field.name for field in fields(value)):
        inner, where = getattr(value, name), f"{prefix}{name}"
        if is_dataclass(inner):
            yield from _unusual(inner, "" if name == "system" else f"{where}.", of, seen)
        elif (usual := _RANGES.get(f"{kind}.{name}")) is not None:
            yield from _outside(usual, inner, f"{where}{of}")
        elif isinstance(inner, tuple):
            for number, each in enumerate(inner, 1):
                if is_dataclass(each):
                    called = repr(getattr(each, "name", number))
                    yield from _unusual(each, "", f" of {name.removesuffix('s')} {called}", seen)


def _outside(usual: _Range, given: Any, where: str) -> Iterator[str]:  # noqa: ANN401
    """Tell of a number, or of the length of a vector, that is not of a usual size."""
    size = math.hypot(*given) if isinstance(given, tuple) else finite_number(given)
    if size and not usual.low <= abs(size) <= usual.high:
        yield f"{where} = {size:.4g} {usual.unit}".rstrip() + f": {usual.remedy}"


def _drive(drive: ChainDrive, *_: str) -> Iterator[str]:
    """Tell of places far from each other, of speeds, and of what turns with the sprockets."""
    parts = {"sprocket": drive.sprockets, "guide": drive.guides, "end": drive.ends or ()}
    places = [
        (f"{name} of {part} {number}", getattr(each, name))
        for part, listed in parts.items()
        for number, each in enumerate(listed, 1)
        for name in ("center", "position")
        if getattr(each, name, None) is not None
    ]
    for place, (x, y) in places[1:]:
        far = math.dist((x, y), places[0][1])
        if far > max(_LENGTH.high, _FARTHEST * drive.chain.pitch):
            first = places[0][0].partition(" of ")[2]
            yield f"{place} = ({x:.4g}, {y:.4g}) m: is {far:.4g} m from {first}; {_MILLIMETRES}"
    for number, sprocket in enumerate(drive.sprockets, 1):
        radius = 0.5 * drive.chain.pitch / math.sin(math.pi / sprocket.teeth)
        if (mass := sprocket.load_inertia / radius**2) > _HEAVIEST:
            yield (
                f"load_inertia of sprocket {number} = {sprocket.load_inertia:.4g} kg m^2: at its "
                f"pitch radius that is {mass:.4g} kg on the chain; give it in kg m^2, 1e-6 of "
                "kg mm^2"
            )
        speeds = {"motion.speed": _largest(getattr(sprocket.motion, "speed", 0.0))}
        speeds["initial_speed"] = abs(sprocket.initial_speed or 0.0)
        for name, speed in speeds.items():
            if radius * speed > _FASTEST_CHAIN:
                yield (
                    f"{name} of sprocket {number} reaches {speed:.4g} rad/s: moves the chain at "
                    f"{radius * speed:.4g} m/s, roller chains run below {_FASTEST_CHAIN:g} m/s; "
                    "convert rev/min by rustchain.rpm"
                )


def _largest(signal: Any) -> float:  # noqa: ANN401
    """Return the largest absolute value of a signal, of a spline at its rows."""
    if isinstance(signal, Sines):
        values = [abs(signal.offset) + sum(abs(amplitude) for amplitude, *_ in signal.terms)]
    elif isinstance(signal, SmoothStep):
        values = [signal.before, signal.after]
    else:
        rows = getattr(signal, "rows", signal)
        values = [value for _, value in rows] if isinstance(rows, tuple) else [rows]
    return max(float(abs(value)) for value in values)


def _chain(chain: Chain, prefix: str, of: str) -> Iterator[str]:
    """Tell of the masses of links."""
    for name in ("inner", "outer", "offset"):
        link = getattr(chain, name)
        if link is not None and link.mass > _DENSEST * chain.pitch**3:
            yield (
                f"{prefix}{name}.mass{of} = {link.mass:.4g} kg: is much for a pitch of "
                f"{chain.pitch:.4g} m; give it in kg, 1e-3 of g"
            )


def _body(body: Body, *_: str) -> Iterator[str]:
    """Tell of place, speed and inertia of a body of a mechanism."""
    named = f"body {body.name!r}"
    x, y, angle = map(float, body.position)
    if max(abs(x), abs(y)) > _LENGTH.high:
        yield f"position of {named} = ({x:.4g}, {y:.4g}) m: {_MILLIMETRES}"
    if abs(angle) > _LARGEST_ANGLE:
        yield f"position of {named}, its angle = {angle:.4g} rad: {_DEGREES}"
    if (spin := abs(float(body.velocity[2]))) > _FASTEST:
        yield f"velocity of {named}, its rate of turning = {spin:.4g} rad/s: give it in rad/s"
    mass, inertia = float(body.mass), float(body.inertia)
    if mass > 0.0 and (radius := math.sqrt(max(inertia, 0.0) / mass)) > _WIDEST:
        yield (
            f"inertia of {named} = {inertia:.4g} kg m^2: with {mass:.4g} kg it has a radius of "
            f"gyration of {radius:.4g} m; give it in kg m^2, 1e-6 of kg mm^2"
        )


_CHECKS: dict[str, Callable[..., Iterator[str]]] = {
    "Body": _body,
    "Chain": _chain,
    "ChainDrive": _drive,
}
