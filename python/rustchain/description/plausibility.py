"""Warnings of inputs of drives and mechanisms that are probably not in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rustchain import _rustchain
from rustchain.arguments import finite_number
from rustchain.description.signals import Sines, SmoothStep
from rustchain.description.teeth import CustomTooth

if TYPE_CHECKING:
    from rustchain.description.chain import Chain
    from rustchain.description.drive import ChainDrive
    from rustchain.description.mechanism.builder import Mechanism
    from rustchain.description.mechanism.parts import Body, Contact, Force, Joint
    from rustchain.description.scene import Scene
    from rustchain.description.sprocket import Sprocket


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
# Longer than hoists and conveyors of one outline [m].
_WAY = _Range(0.0, 500.0, "m", _MILLIMETRES)
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
                "Joint": ("point_a", "point_b", "radius"),
                "Force": ("point_a", "point_b"),
                "Contact": ("point_a", "point_b", "radius", "profile_radius"),
                "LinearContact": ("length",),
                "SurfaceContact": ("length",),
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
            _Range(1e-5, 5.0, "Pa s", "0.01 to 0.5 is usual; give it in Pa s, 1e-3 of mPa s"),
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
_ANGLE = _Range(0.0, _LARGEST_ANGLE, "rad", _DEGREES)
# Speed of the fastest rotors, 300 000 revolutions a minute [rad/s].
_FASTEST = 3.2e4
# Speed of the fastest roller chains [m/s]; 17 teeth of 12.7 mm at 1440 rad/s have 49.8.
_FASTEST_CHAIN = 40.0
# Mass of a link over the cube of its pitch [kg/m^3]: roller chains have 4e3, 4e6 with grams.
_DENSEST = 2e5
# What a link carries over the cube of its pitch [kg/m^3]: 8 kg on a link of 12.7 mm, ten times as
# much as the conveyors among the examples.
_LARGEST_CARRIED = 20.0 * _DENSEST
# What turns with a sprocket, as a mass on the chain at its pitch radius [kg].
_HEAVIEST = 1e6
# Breaking load of a strand over the square of its pitch [Pa]: 12,500 lbf with a pitch of an inch in
# ANSI/ASME B29.1. The largest of the catalogue, of ISO 08B, is 1.3 times as large.
_STRENGTH = 8.618e7
_TORQUE = "give it in N m, 1e-3 of N mm"
# Distance of a seated bushing from the pitch circle, in pitches: one tooth more moves it by 0.16.
_FARTHEST_SEAT = 0.05
# Coarsest accuracy [m] at which the steps of drives follow penetrations of 1e-6 m: at 1e-5 m a run
# of 50 ms dissipated 1.4e6 J.
_COARSEST = 1e-7
# Permitted error of velocities over that of lengths [1/s], as in `Solver.accuracy`.
_SPEED_PER_LENGTH = 1e5
# Minimum impact velocity [m/s] below which it is compared with that error: its default.
_SLOW = 1e-3


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
    """Tell of places far from each other, of loads, and of sprockets."""
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
    yield from _loads(drive)
    for number, sprocket in enumerate(drive.sprockets, 1):
        radius = _pitch_radius(drive.chain, sprocket.teeth)
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
        own = (getattr(sprocket.profile, size, None) for size in ("roller_diameter", "seat_radius"))
        if isinstance(sprocket.profile, CustomTooth) or any(own):
            yield from _seat(drive.chain, sprocket, number)


def _loads(drive: ChainDrive) -> Iterator[str]:
    """Tell of loads at which the chain would break."""
    torques = [
        (f"motion.{name} of sprocket {number}", _largest(given), sprocket.teeth)
        for number, sprocket in enumerate(drive.sprockets, 1)
        for name in ("torque", "curve")
        if (given := getattr(sprocket.motion, name, None)) is not None
    ]
    loads = [
        (f"{where} reaches {torque:.4g} N m", torque / _pitch_radius(drive.chain, teeth), _TORQUE)
        for where, torque, teeth in torques
    ]
    if drive.tensioner is not None:
        pull = drive.tensioner.pretension
        loads.append((f"tensioner.pretension = {pull:.4g} N", pull, "give it in N"))
    for number, end in enumerate(drive.ends or (), 1):
        mass = getattr(end, "mass", 0.0)
        weight = mass * math.hypot(*drive.gravity)
        loads.append((f"mass of end {number} = {mass:.4g} kg", weight, "give it in kg, 1e-3 of g"))
    strength = _STRENGTH * drive.chain.strands * drive.chain.pitch**2
    for where, pull, remedy in loads:
        if pull > strength:
            yield (
                f"{where}: pulls the chain with {pull:.4g} N, roller chains of its pitch break at "
                f"about {strength:.3g} N; {remedy}"
            )


def _seat(chain: Chain, sprocket: Sprocket, number: int) -> Iterator[str]:
    """Tell of a bushing that rests in the middle of a gap far from the pitch circle."""
    radius = _pitch_radius(chain, sprocket.teeth)
    offsets = np.linspace(-0.5, 0.5, 101) * chain.pitch
    places = np.column_stack([radius + offsets, np.zeros(len(offsets))])  # gap 0 lies along x
    _, penetration, _ = _rustchain.tooth_contacts(sprocket, chain, places, chain.contact_radius)
    offset = float(np.interp(0.0, -penetration, offsets))  # the penetration falls outward
    if abs(offset) > _FARTHEST_SEAT * chain.pitch:
        side = "below" if offset < 0.0 else "above"
        remedy = f"the chain needs a roller_diameter of {2e3 * chain.contact_radius:.4g} mm"
        if isinstance(sprocket.profile, CustomTooth):
            remedy = "draw the pieces for this tooth number"
        elif getattr(sprocket.profile, "seat_radius", None):
            remedy = "leave seat_radius out"
        yield (
            f"profile of sprocket {number}: a seated bushing stands {1e3 * abs(offset):.1f} mm "
            f"{side} the pitch circle of {sprocket.teeth} teeth; {remedy}"
        )


def _pitch_radius(chain: Chain, teeth: int) -> float:
    return 0.5 * chain.pitch / math.sin(math.pi / teeth)


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
    """Tell of the masses of links and of what they carry."""
    for name in ("inner", "outer", "offset"):
        link = getattr(chain, name)
        if link is not None and link.mass > _DENSEST * chain.pitch**3:
            yield (
                f"{prefix}{name}.mass{of} = {link.mass:.4g} kg: is much for a pitch of "
                f"{chain.pitch:.4g} m; give it in kg, 1e-3 of g"
            )
    link, heaviest = max(chain.carried, key=lambda row: row[1], default=(0, 0.0))
    if heaviest > _LARGEST_CARRIED * chain.pitch**3:
        yield (
            f"{prefix}carried{of}, link {link} = {heaviest:.4g} kg: is much for a pitch of "
            f"{chain.pitch:.4g} m; give it in kg, 1e-3 of g"
        )


def _scene(scene: Scene, *_: str) -> Iterator[str]:
    """Tell of accuracies of drives that do not resolve contacts, and of films without effect."""
    solver = scene.solver
    replaced = solver.rtol is not None or solver.atol is not None
    if scene.kind == "drive" and not replaced and solver.accuracy > _COARSEST:
        yield (
            f"solver.accuracy = {solver.accuracy:.4g} m: steps no longer resolve contacts of 1e-6 "
            "m; take 1e-8 or less"
        )
    slowest = scene.min_impact_velocity
    permitted = _SPEED_PER_LENGTH * solver.accuracy
    if scene.kind == "drive" and not replaced and slowest <= permitted and slowest < _SLOW:
        yield (
            f"min_impact_velocity = {slowest:.4g} m/s: is not above the error of velocities that "
            f"solver.accuracy = {solver.accuracy:.4g} m permits, {permitted:.4g} m/s; forces of "
            "slow contacts can be many times too large; take an accuracy of "
            f"{slowest / (30.0 * _SPEED_PER_LENGTH):.1g} or less, or a larger velocity"
        )
    law = scene.law_of_hinges
    dry = law.film is not None and law.friction is None
    if scene.kind == "drive" and scene.start == "static" and dry:
        yield (
            "start = 'static': loaded hinges begin in dry contact, where their film has no force "
            "until they unload; take start='generated', or give the law of hinges friction, too"
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


def _joint(joint: Joint, *_: str) -> Iterator[str]:
    """Tell of the length or angle that a joint holds, and of the motion of a driver."""
    if joint.value is not None and joint.kind in ("distance", "rack"):
        yield from _outside(_LENGTH, joint.value, f"value of joint {joint.name!r}")
    if joint.value is not None and joint.kind in ("fixed", "prismatic"):
        yield from _outside(_ANGLE, joint.value, f"value of joint {joint.name!r}")
    fastest = _largest(joint.motion)
    if joint.kind == "driven_angle" and joint.by_speed and fastest > _FASTEST:
        yield f"speed of driver {joint.name!r} reaches {fastest:.4g} rad/s: give it in rad/s"
    if joint.kind == "driven_position" and not joint.by_speed:
        yield from _outside(_WAY, fastest, f"position of driver {joint.name!r}")


def _force(force: Force, *_: str) -> Iterator[str]:
    """Tell of the length of a spring without force; torsion springs may have many turns."""
    if force.kind == "spring" and force.rest is not None:
        yield from _outside(_LENGTH, force.rest, f"rest of force {force.name!r}")


def _contact(contact: Contact, *_: str) -> Iterator[str]:
    """Tell of an outline of an unusual size."""
    points = [point for point in contact.points if len(point) == 2]
    farthest = max((abs(float(at)) for point in points for at in point), default=0.0)
    yield from _outside(_WAY, farthest, f"points of contact {contact.name!r}, the farthest")


_CHECKS: dict[str, Callable[..., Iterator[str]]] = {
    "Body": _body,
    "Chain": _chain,
    "ChainDrive": _drive,
    "Contact": _contact,
    "Force": _force,
    "Joint": _joint,
    "Scene": _scene,
}
