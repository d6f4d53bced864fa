"""Random states of a drive of two sprockets, near real ones, with contacts wherever they can be.

A real state is loosened (the tensioned sprocket comes inward, which gives the strands slack), then
the hinge points are solved for: link lengths kept, seated bushings in light contact, and at the
ends of the wraps some bushings on a chosen region of the tooth. Last the links get pins off their
bushings' centres and everything gets random velocities.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.geometry import circle_on_sprocket, pitch_radius, point_touching

if TYPE_CHECKING:
    from reference.dynamics import DriveEquations

Array = NDArray[np.float64]

SEATED_WITHIN = 1.0e-4  # of the pitch circle [m]
DEEPEST = 2.0e-5  # penetration beyond which a state is thrown away [m]


FIRST_OF_WRAP = (1, 2, 3, 5)  # regions a loosened chain can touch where the wrap begins
LAST_OF_WRAP = (3, 5, 6, 7)  # and where it ends; the seating region is touched in between


class State(NamedTuple):
    """Positions [m, m, rad] and velocities [m/s, m/s, rad/s], each of shape (bodies, 3)."""

    positions: Array
    velocities: Array


class Target(NamedTuple):
    """A bushing that is to touch a sprocket: angle of the gap [rad] and depth [m].

    ``chosen`` marks those whose region was asked for.
    """

    hinge: int
    sprocket: int
    gap_direction: float
    depth: float
    chosen: bool = False


def jiggled(equations: DriveEquations, base: State, rng: np.random.Generator) -> State:
    """Return ``base`` with every free coordinate moved by micrometres and every rate changed."""
    n = equations.links
    positions, velocities = base.positions.copy(), base.velocities.copy()
    positions[:n, :2] += rng.uniform(-1.5e-5, 1.5e-5, (n, 2))
    positions[:n, 2] += rng.uniform(-2e-3, 2e-3, n)
    positions[n:, 2] += rng.uniform(-2e-3, 2e-3, len(positions) - n)
    velocities[:n, :2] += rng.uniform(-0.05, 0.05, (n, 2))
    velocities[:, 2] += rng.uniform(-8.0, 8.0, len(velocities))
    _slide(equations, positions, velocities, rng.uniform(-2e-5, 2e-5), rng.uniform(-0.05, 0.05))
    return State(positions, velocities)


def with_rollers(equations: DriveEquations, base: State, rng: np.random.Generator) -> State:
    """Return a state of a roller chain: links and sprockets of ``base``, rollers on the bushings.

    ``equations`` are the roller chain's. Two rollers in three are pressed on their bushings, by up
    to 2 um; the others lie anywhere in their play.
    """
    n, c = equations.links, equations.roller_clearance
    angle = rng.uniform(-np.pi, np.pi, n)
    pressed = rng.random(n) < 2.0 / 3.0
    distance = np.where(pressed, c + rng.uniform(0.0, 2e-6, n), rng.uniform(0.0, 1.0, n) * c)
    bushings = np.where(
        (np.arange(n) % 2 == 0)[:, None],
        _end(equations, base.positions, 1.0),
        np.roll(_end(equations, base.positions, -1.0), -1, axis=0),
    )
    places = bushings + distance[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rollers = np.column_stack([places, rng.uniform(-np.pi, np.pi, n)])
    moving = base.velocities[:n].copy()
    moving[:, :2] += rng.uniform(-0.05, 0.05, (n, 2))
    moving[:, 2] = rng.uniform(-50.0, 50.0, n)
    return State(
        np.concatenate([base.positions[:n], rollers, base.positions[n:]]),
        np.concatenate([base.velocities[:n], moving, base.velocities[n:]]),
    )


def _end(equations: DriveEquations, positions: Array, side: float) -> Array:
    """Front (side 1) or rear (-1) of every link, (links, 2)."""
    links = positions[: equations.links]
    along = np.stack([np.cos(links[:, 2]), np.sin(links[:, 2])], axis=1)
    return np.asarray(links[:, :2] + 0.5 * side * equations.pitch * along)


def in_chosen_regions(
    equations: DriveEquations, base: State, regions: list[int], rng: np.random.Generator
) -> State:
    """Return a state near ``base`` with a bushing on each of four ``regions``, one a wrap end.

    The ends are, in this order: the driver's first and last, the driven sprocket's first and last;
    0 leaves an end as it falls. Regions from `FIRST_OF_WRAP` and `LAST_OF_WRAP` can be had.
    """
    for _ in range(200):
        state = _attempt(equations, base, regions, rng)
        if state is not None:
            return state
    raise RuntimeError(f"no state found with the regions {regions}")


def _attempt(
    equations: DriveEquations, base: State, regions: list[int], rng: np.random.Generator
) -> State | None:
    n, p = equations.links, equations.pitch
    positions, velocities = base.positions.copy(), base.velocities.copy()
    kin = equations.kinematics(positions, velocities)
    inner_first = np.arange(n) % 2 == 0
    hinges = np.where(inner_first[:, None], kin.front, kin.rear[(np.arange(n) + 1) % n])

    # Sprocket 2 comes inward with the hinges on it; the strands follow linearly.
    wraps = [_wrap(equations, positions, hinges, s) for s in range(2)]
    inward = -rng.uniform(0.5e-3, 2.0e-3)
    moved = _slide(equations, positions, velocities, inward, rng.uniform(-0.02, 0.02))
    share = np.zeros(n)
    share[wraps[1]] = 1.0
    for start, end, first in ((wraps[0][-1], wraps[1][0], 0.0), (wraps[1][-1], wraps[0][0], 1.0)):
        length = (end - start) % n
        for i in range(1, length):
            share[(start + i) % n] = abs(first - i / length)
    hinges = hinges + share[:, None] * moved

    weight = np.full(n, 1.0)
    targets: list[Target] = []
    for s, wrap in enumerate(wraps):
        center = positions[n + s]
        step = equations.profiles[s].gap_angle
        for place, hinge in enumerate(wrap):
            arm = hinges[hinge] - center[:2]
            gap = np.rint((np.arctan2(arm[1], arm[0]) - center[2]) / step)
            direction = float(center[2] + gap * step)
            from_end = min(place, len(wrap) - 1 - place)
            if from_end >= 3:
                weight[hinge] = 0.1
                if rng.random() < 0.5:
                    local = point_touching(
                        equations.profiles[s], 4, rng.uniform(0.2, 0.8), equations.bushing_radius
                    )
                    hinges[hinge] = _in_gap(equations, positions, s, direction, local)
                    targets.append(Target(int(hinge), s, direction, rng.uniform(1e-8, 2e-6)))
            elif from_end > 0:
                lift = rng.uniform(0.1e-3, 1.0e-3)
                hinges[hinge] += lift * arm / np.hypot(*arm)
        for end, region in zip((0, -1), regions[2 * s : 2 * s + 2], strict=True):
            if region == 0:
                continue
            outward = int(rng.integers(0, 2)) * (1 if end == -1 else -1)
            hinge = int((wrap[end] + outward) % n)
            last = wrap[end]
            arm = hinges[last] - center[:2]
            gap = np.rint((np.arctan2(arm[1], arm[0]) - center[2]) / step) + outward
            direction = float(center[2] + gap * step)
            local = point_touching(
                equations.profiles[s], region, rng.uniform(0.15, 0.85), equations.bushing_radius
            )
            hinges[hinge] = _in_gap(equations, positions, s, direction, local)
            weight[hinge] = 0.3
            depth = rng.uniform(1e-8, 3e-6)
            targets.append(Target(hinge, s, direction, depth, chosen=True))

    spread = 2.0 * equations.clearance
    lengths = np.full(n, p)  # from hinge k - 1 to hinge k: link k; odd links are outer
    lengths[1::2] += rng.uniform(-spread, spread, n // 2)
    ends = [target for target in targets if target.chosen]
    solved = hinges
    for _ in range(8):
        attempt = _solve(equations, positions, solved, lengths, targets, weight)
        if attempt is None:
            return None
        solved = attempt
        pressed = _pressed(equations, positions, solved, targets, rng)
        if not pressed:
            break
        targets = targets + pressed
    _lay_links(equations, positions, velocities, solved, rng)
    kin = equations.kinematics(positions, velocities)
    deepest = max(float(np.max(kin.tooth_penetration)), float(np.max(kin.hinge_penetration)))
    found = [int(kin.tooth_region[target.hinge, target.sprocket]) for target in ends]
    touching = all(kin.tooth_penetration[target.hinge, target.sprocket] > 0.0 for target in ends)
    if deepest > DEEPEST or found != [region for region in regions if region] or not touching:
        return None
    return State(positions, velocities)


def _pressed(
    equations: DriveEquations,
    positions: Array,
    hinges: Array,
    targets: list[Target],
    rng: np.random.Generator,
) -> list[Target]:
    """Bushings that came too deep, as targets of a light contact."""
    n = equations.links
    known = {(target.hinge, target.sprocket) for target in targets}
    found = []
    for s, profile in enumerate(equations.profiles):
        center, angle = positions[n + s, :2], float(positions[n + s, 2])
        contact = circle_on_sprocket(profile, center, angle, hinges, equations.bushing_radius)
        for hinge in np.flatnonzero(contact.penetration > 4e-6):
            if (int(hinge), s) not in known:
                direction = angle + float(contact.gap[hinge]) * profile.gap_angle
                found.append(Target(int(hinge), s, direction, rng.uniform(1e-8, 2e-6)))
    return found


def _slide(
    equations: DriveEquations, positions: Array, velocities: Array, shift: float, speed: float
) -> Array:
    """Move the tensioned sprocket along its slide by ``shift`` [m]; its displacement, (2,)."""
    if equations.drive.tensioner is None:
        return np.zeros(2)
    body = equations.links + equations.drive.tensioner.sprocket - 1
    displacement = shift * equations.tension_direction
    positions[body, :2] += displacement
    velocities[body, :2] += speed * equations.tension_direction
    return displacement


def _in_gap(
    equations: DriveEquations, positions: Array, s: int, direction: float, local: Array
) -> Array:
    """Point of the scene, (2,), at ``local`` (2,) of a sprocket's gap in ``direction`` [rad]."""
    out = np.array([np.cos(direction), np.sin(direction)])
    side = np.array([out[1], -out[0]])
    outward = equations.profiles[s].seat_radius + local[1]
    center = positions[equations.links + s, :2]
    return np.asarray(center + local[0] * side + outward * out)


def _wrap(equations: DriveEquations, positions: Array, hinges: Array, s: int) -> NDArray[np.int64]:
    """Hinges seated on a sprocket, in the order of the chain."""
    n = equations.links
    teeth = equations.profiles[s].teeth
    distance = np.hypot(*(hinges - positions[n + s, :2]).T)
    seated = np.abs(distance - pitch_radius(equations.pitch, teeth)) < SEATED_WITHIN
    starts = np.flatnonzero(seated & ~np.roll(seated, 1))
    runs = []
    for start in starts:
        length = 1
        while seated[(start + length) % n]:
            length += 1
        runs.append((start + np.arange(length)) % n)
    return np.asarray(max(runs, key=len), dtype=np.int64)


def _solve(
    equations: DriveEquations,
    positions: Array,
    hinges: Array,
    lengths: Array,
    targets: list[Target],
    weight: Array,
) -> Array | None:
    """Nearest hinge points with the given link lengths and tooth penetrations (Newton)."""
    n = equations.links
    previous = np.arange(n) - 1
    points = hinges.copy()
    scale = np.repeat(weight, 2)
    for _ in range(40):
        d = points - points[previous]
        distance = np.hypot(d[:, 0], d[:, 1])
        rows = np.zeros((n + len(targets), 2 * n))
        residual = np.empty(n + len(targets))
        residual[:n] = distance - lengths
        for k in range(n):
            direction = d[k] / distance[k]
            rows[k, 2 * k : 2 * k + 2] = direction
            j = int(previous[k]) % n
            rows[k, 2 * j : 2 * j + 2] = -direction
        for s, profile in enumerate(equations.profiles):
            chosen = [i for i, target in enumerate(targets) if target.sprocket == s]
            pressed = [targets[i].hinge for i in chosen]
            center, angle = positions[n + s, :2], float(positions[n + s, 2])
            radius = equations.bushing_radius
            contact = circle_on_sprocket(profile, center, angle, points[pressed], radius)
            if not contact.near.all():
                return None
            for k, (i, hinge) in enumerate(zip(chosen, pressed, strict=True)):
                residual[n + i] = contact.penetration[k] - targets[i].depth
                rows[n + i, 2 * hinge : 2 * hinge + 2] = contact.normal[k]
        if np.max(np.abs(residual)) < 1e-12:
            return points
        step = np.linalg.lstsq(rows * scale, -residual, rcond=1e-10)[0] * scale
        points += np.clip(step, -2e-3, 2e-3).reshape(n, 2)
    return None


def _lay_links(
    equations: DriveEquations,
    positions: Array,
    velocities: Array,
    hinges: Array,
    rng: np.random.Generator,
) -> None:
    """Put the links on their hinge points and give them velocities, in place.

    Inner links lie exactly; outer ones are moved across so that pins come near their clearance.
    """
    n, c = equations.links, equations.clearance
    rear, front = np.roll(hinges, 1, axis=0), hinges
    d = front - rear
    positions[:n, :2] = 0.5 * (front + rear)
    positions[:n, 2] = np.arctan2(d[:, 1], d[:, 0])
    outer = np.arange(1, n, 2)
    stretch = 0.5 * (np.hypot(d[outer, 0], d[outer, 1]) - equations.pitch)
    # Eccentricity of both pins: the stretch along the link, the rest across it.
    eccentricity = c + rng.uniform(-3e-6, 2e-6, len(outer))
    across = np.sqrt(np.maximum(eccentricity**2 - stretch**2, 0.0))
    across *= rng.choice([-1.0, 1.0], len(outer))
    sideways = np.stack([-d[outer, 1], d[outer, 0]], axis=1)
    sideways /= np.hypot(sideways[:, 0], sideways[:, 1])[:, None]
    positions[outer, :2] += across[:, None] * sideways
    positions[outer, 2] += rng.uniform(-1e-4, 1e-4, len(outer))
    velocities[:n, :2] += rng.uniform(-0.05, 0.05, (n, 2))
    velocities[:, 2] += rng.uniform(-8.0, 8.0, len(velocities))
