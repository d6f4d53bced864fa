"""A drive's tensioner as parts of a mechanism: slide or arm, pull, spring, damper and stops."""

from __future__ import annotations

import math

import numpy as np

from rustchain import _rustchain
from rustchain.description.drive import ChainDrive, Tensioner
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.mechanism.parts import GROUND, Table, TimeFunction
from rustchain.errors import InvalidInput
from rustchain.typing import Array

_STOP_STIFFNESS = 1e7  # [N/m], as the drive's
# An arm is no body without mass. A bar of this share of its sprocket's mass, half of which the
# sprocket gives and which has a fourth of its mass times the arm's length squared for an inertia,
# leaves mass, weight and inertia about the pivot what they are.
_SHARE = 0.1
_ROOM = 1.0  # [m] behind the slide, where its spring begins, and past the stops


def add_tensioner(
    mechanism: Mechanism, drive: ChainDrive, placed: tuple[float, Array, Array]
) -> None:
    """Add the tensioner of `drive` to what has its sprocket, of (mass, position, velocity)."""
    tensioner = _tensioner(drive)
    if tensioner.ratchet is not None or tensioner.damping_back not in (None, tensioner.damping):
        msg = (
            "Tensioner: a ratchet or a leak do not go into a mechanism: leave ratchet out, and "
            "damping_back as damping, or take hinges='clearance'"
        )
        raise InvalidInput(msg)
    if tensioner.pivot is None:
        _add_slide(mechanism, drive, placed[1])
    else:
        _add_arm(mechanism, drive, placed)


def mass_beside_an_arm(tensioner: Tensioner | None, number: int, mass: float) -> float:
    """Return the mass [kg] that is left to sprocket `number` where it has an arm."""
    has_arm = tensioner is not None and tensioner.sprocket == number and tensioner.pivot is not None
    return mass * (1.0 - 0.5 * _SHARE) if has_arm else mass


def _add_slide(mechanism: Mechanism, drive: ChainDrive, position: Array) -> None:
    """Let the sprocket slide along the pull, with a spring from a point behind it."""
    tensioner = _tensioner(drive)
    k = tensioner.sprocket
    name = f"sprocket_{k}"
    x, y = way = _direction_of_pull(drive)
    center = (float(position[0]), float(position[1]))
    mechanism.add_point_on_line(f"slide_{k}", GROUND, name, way, point_a=center)
    pull = drive.check().tension_force
    ramp = [_grown(pull * part, tensioner.ramp_time) for part in way]
    mechanism.add_force(f"tensioner_{k}", name, ramp)
    described = drive.sprockets[k - 1].center
    moved = (center[0] - described[0]) * x + (center[1] - described[1]) * y
    room = moved + _ROOM + (0.0 if tensioner.travel is None else _finite(tensioner.travel[0]))
    behind = (center[0] - room * x, center[1] - room * y)
    rest = room - moved
    if tensioner.damping > 0.0 or tensioner.stiffness > 0.0:
        mechanism.add_spring(
            f"damper_{k}",
            GROUND,
            name,
            stiffness=tensioner.stiffness,
            damping=tensioner.damping,
            point_a=behind,
            rest_length=rest,
        )
    if (stops := _stops(tensioner)) is not None:
        mechanism.add_spring(
            f"stops_{k}", GROUND, name, point_a=behind, rest_length=rest, table=stops
        )


def _add_arm(mechanism: Mechanism, drive: ChainDrive, placed: tuple[float, Array, Array]) -> None:
    """Let the sprocket swing on an arm, a body of its own, whose torques are forces by the arm."""
    tensioner = _tensioner(drive)
    mass, position, velocity = placed
    k, pivot = tensioner.sprocket, tensioner.pivot
    if pivot is None:
        return
    radius, described, way = _arm(drive)
    row = _arm_row(pivot, described, position[:2], velocity[:2])
    inertia = tensioner.arm_inertia + 0.25 * _SHARE * mass * radius**2
    mechanism.add_body(f"arm_{k}", _SHARE * mass, inertia, row[0], row[1])
    center = (float(position[0]), float(position[1]))
    mechanism.add_revolute(f"pivot_{k}", GROUND, f"arm_{k}", at=pivot)
    mechanism.add_revolute(f"bearing_{k}", f"arm_{k}", f"sprocket_{k}", at=center)
    pull = way * radius * drive.check().tension_force
    mechanism.add_torque(f"tensioner_{k}", f"arm_{k}", _grown(pull, tensioner.ramp_time))
    if tensioner.damping > 0.0 or tensioner.stiffness > 0.0:
        mechanism.add_torsion_spring(
            f"damper_{k}",
            GROUND,
            f"arm_{k}",
            stiffness=tensioner.stiffness * radius**2,
            damping=tensioner.damping * radius**2,
            rest_angle=described,
        )
    if (stops := _stops(tensioner)) is not None:
        rows = [(way * s / radius, way * force * radius) for s, force in stops]
        mechanism.add_torsion_spring(
            f"stops_{k}", GROUND, f"arm_{k}", rest_angle=described, table=rows[:: int(way)]
        )


def arm_rows(drive: ChainDrive, positions: Array, velocities: Array) -> Array:
    """Return position and velocity of the arm, (2, 3), from those of a drive's bodies.

    Of a drive without an arm there is nothing, (0, 3).
    """
    tensioner = drive.tensioner
    if tensioner is None or tensioner.pivot is None:
        return np.empty((0, 3))
    row = drive.chain.links + tensioner.sprocket - 1
    return _arm_row(tensioner.pivot, _arm(drive)[1], positions[row, :2], velocities[row, :2])


def _arm_row(pivot: tuple[float, float], described: float, center: Array, velocity: Array) -> Array:
    """Return position and velocity of an arm that ends at `center`, less than half a turn off."""
    x, y = center[0] - pivot[0], center[1] - pivot[1]
    spin = (x * velocity[1] - y * velocity[0]) / (x * x + y * y)
    angle = described + math.remainder(math.atan2(y, x) - described, math.tau)
    half = [pivot[0] + 0.5 * x, pivot[1] + 0.5 * y]
    return np.array([[*half, angle], [0.5 * velocity[0], 0.5 * velocity[1], spin]])


def _arm(drive: ChainDrive) -> tuple[float, float, float]:
    """Return length and angle of the arm as described, and 1 or -1: which way the pull turns it."""
    tensioner = _tensioner(drive)
    x, y = drive.sprockets[tensioner.sprocket - 1].center
    pivot = tensioner.pivot or (0.0, 0.0)
    x, y = x - pivot[0], y - pivot[1]
    tight = _rustchain.bisector(drive, tensioner.sprocket)
    left = x * tight[1] - y * tight[0] >= 0.0
    return math.hypot(x, y), math.atan2(y, x), 1.0 if left else -1.0


def _stops(tensioner: Tensioner) -> list[tuple[float, float]] | None:
    """Return rows (way [m], force that holds it back [N]) of the stops, where there are any."""
    if tensioner.travel is None:
        return None
    back, forth = tensioner.travel
    rows = []
    if math.isfinite(back):
        rows += [(-back - _ROOM, -_ROOM * _STOP_STIFFNESS), (-back, 0.0)]
    if math.isfinite(forth):
        rows += [(forth, 0.0), (forth + _ROOM, _ROOM * _STOP_STIFFNESS)]
    return rows or None


def _direction_of_pull(drive: ChainDrive) -> tuple[float, float]:
    """Return the unit vector of the tensioner's pull."""
    tensioner = _tensioner(drive)
    k = tensioner.sprocket - 1
    if tensioner.direction is not None:
        x, y = tensioner.direction
    elif len(drive.sprockets) > 2:
        x, y = _rustchain.bisector(drive, k + 1)
    else:
        (x, y), (other_x, other_y) = drive.sprockets[k].center, drive.sprockets[1 - k].center
        x, y = x - other_x, y - other_y
    length = math.hypot(x, y)
    return x / length, y / length


def _tensioner(drive: ChainDrive) -> Tensioner:
    if drive.tensioner is None:
        msg = "ChainDrive.tensioner = None: there is none"
        raise InvalidInput(msg)
    return drive.tensioner


def _finite(value: float) -> float:
    return value if math.isfinite(value) else 0.0


def _grown(value: float, time: float) -> TimeFunction:
    """Return what grows to `value` within `time` [s]; within none, it is there from the start."""
    return Table([(0.0, 0.0), (time, value)]) if time > 0.0 else value
