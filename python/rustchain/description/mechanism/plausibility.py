"""Warnings of inputs of a mechanism that are probably not in SI units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rustchain.description.mechanism.builder import Mechanism

# Farther than parts of machines are from each other [m]; 0.1 m in millimetres are 100.
_LONGEST = 99.0
# Radius of gyration of the largest bodies [m]; 0.1 kg with 1e-4 kg m^2 in kg mm^2 have 32.
_WIDEST = 10.0
# Angles at the start [rad]: 45 degrees given as a number are 7 turns.
_LARGEST_ANGLE = 4.0 * math.pi
_GRAVITY = (0.05, 100.0)  # [m/s^2]: that of small moons to four times that of Jupiter
# Speed of the fastest rotors, 300 000 revolutions a minute [rad/s].
_FASTEST = 3.2e4


def implausible_inputs(mechanism: Mechanism) -> list[str]:
    """Return a sentence for each input of an unusual size: field, value and remedy."""
    return [*_gravity(mechanism), *_bodies(mechanism), *_lengths(mechanism)]


def _gravity(mechanism: Mechanism) -> Iterator[str]:
    size = math.hypot(*mechanism.gravity)
    if size > 0.0 and not _GRAVITY[0] <= size <= _GRAVITY[1]:
        yield f"gravity = {size:.4g} m/s^2: about 9.81 is usual; give it in m/s^2"


def _bodies(mechanism: Mechanism) -> Iterator[str]:
    for body in mechanism.bodies:
        named = f"body {body.name!r}"
        x, y, angle = map(float, body.position)
        if max(abs(x), abs(y)) > _LONGEST:
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


def _lengths(mechanism: Mechanism) -> Iterator[str]:
    for kind, parts in (
        ("joint", mechanism.joints),
        ("force", mechanism.forces),
        ("contact", mechanism.contacts),
    ):
        for part in parts:
            for field in ("point_a", "point_b"):
                farthest = max(map(abs, map(float, getattr(part, field))))
                if farthest > _LONGEST:
                    yield f"{field} of {kind} {part.name!r} = {farthest:.4g} m: {_MILLIMETRES}"
    for contact in mechanism.contacts:
        if (radius := float(contact.radius)) > _LONGEST:
            yield f"radius of contact {contact.name!r} = {radius:.4g} m: {_MILLIMETRES}"


_MILLIMETRES = "lengths are in metres; divide millimetres by 1000"
_DEGREES = "angles are in radians; convert degrees by math.radians"
