"""Outlines of the bodies of a scene, for pictures, animations and the player."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rustchain import _rustchain
from rustchain.description.drive import ChainDrive
from rustchain.description.ends import AnchoredEnd, LoadedEnd
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.mechanism.parts import GROUND, Contact, Force, Joint
from rustchain.description.scene import Scene
from rustchain.typing import Array

Kind = Literal[
    "sprocket",
    "hub",
    "mark",
    "arm",
    "spring",
    "ground",
    "rail",
    "anchor",
    "load",
    "inner",
    "outer",
    "roller",
    "bushing",
    "pin",
    "body",
    "profile",
]
"""What an outline stands for; it sets the colours."""

GROUND_ROW = -1
"""In place of the row of a body: the frame that does not move."""


@dataclass(frozen=True)
class Shape:
    """One outline that one or several bodies carry.

    Attributes
    ----------
    kind : str
        What it stands for.
    bodies : tuple of int
        Rows of the bodies in positions; `GROUND_ROW` is the ground.
    outline : ndarray, (points, 2)
        In the frame of the body [m].
    closed : bool
        Whether the last point is joined to the first.
    """

    kind: Kind
    bodies: tuple[int, ...]
    outline: Array
    closed: bool = True


@dataclass(frozen=True)
class Bar:
    """A bar, or a spring, from a point of one body to a point of another.

    Attributes
    ----------
    kind : {"arm", "spring"}
        What it stands for.
    bodies : (int, int)
        Rows of the bodies.
    points : ndarray, (2, 2)
        Its ends in the frames of the bodies [m].
    width : float
        [m].
    """

    kind: Kind
    bodies: tuple[int, int]
    points: Array
    width: float

    @property
    def closed(self) -> bool:
        """Whether the last point is joined to the first."""
        return self.kind != "spring"


@dataclass(frozen=True)
class Forces:
    """Recorded forces and the points of bodies on which they act.

    Attributes
    ----------
    kind : str
        "hinge", "tooth", "roller", "contact" or "joint".
    array : str
        Name of the recorded array, (times, forces, 2 or 3).
    bodies : tuple of int
        Rows of the bodies on which the forces act.
    points : ndarray, (forces, 2)
        Where, in the frames of the bodies [m].
    """

    kind: str
    array: str
    bodies: tuple[int, ...]
    points: Array


@dataclass(frozen=True)
class Shapes:
    """All outlines of a scene, from the back to the front, and the forces that can be drawn.

    Attributes
    ----------
    outlines : tuple of Shape and Bar
        In the order in which they are drawn.
    forces : tuple of Forces
        Groups of forces.
    size : float
        A typical length of a part [m]: the pitch of a chain.
    """

    outlines: tuple[Shape | Bar, ...]
    forces: tuple[Forces, ...]
    size: float

    def extent(self, poses: Array) -> tuple[Array, Array]:
        """Return the lower left and the upper right corner of all outlines at `poses`.

        Parameters
        ----------
        poses : ndarray, (..., bodies, 3)
            Positions [m, m, rad], at one time or several.
        """
        low, high = np.full(2, np.inf), np.full(2, -np.inf)
        for one in poses.reshape(-1, *poses.shape[-2:]):
            for shape in self.outlines:
                points = outlines_at(shape, one).reshape(-1, 2)
                low, high = (
                    np.minimum(low, points.min(axis=0)),
                    np.maximum(high, points.max(axis=0)),
                )
        return low, high


def shapes_of(scene: Scene) -> Shapes:
    """Return the outlines of a drive or of a mechanism."""
    if isinstance(scene.system, Mechanism):
        return _shapes_of_mechanism(scene.system)
    return shapes_of_drive(scene.system)


def outlines_at(shape: Shape | Bar, poses: Array) -> Array:
    """Return the outlines of a shape, or of a bar, with bodies at `poses`, (n, points, 2) [m]."""
    if isinstance(shape, Shape):
        return placed(_rows(poses, shape.bodies), shape.outline)
    start, end = (
        placed(_rows(poses, (body,)), point[None])[0, 0]
        for body, point in zip(shape.bodies, shape.points, strict=True)
    )
    draw = _coil if shape.kind == "spring" else _bar
    return draw(np.array([start, end]), shape.width)[None]


def force_points(forces: Forces, poses: Array) -> Array:
    """Return where forces act with bodies at `poses`, (forces, 2) [m]."""
    at = _rows(poses, forces.bodies)
    cosine, sine = np.cos(at[:, 2]), np.sin(at[:, 2])
    x, y = forces.points.T
    return np.stack([at[:, 0] + cosine * x - sine * y, at[:, 1] + sine * x + cosine * y], axis=1)


def _rows(poses: Array, bodies: Sequence[int]) -> Array:
    """Return the poses of bodies, of which the ground's is zero."""
    with_ground = np.concatenate([poses, np.zeros((1, 3))])  # row -1
    rows: Array = with_ground[list(bodies)]
    return rows


def placed(poses: Array, points: Array) -> Array:
    """Return `points`, (points, 2), of a body at each of its `poses`: (poses, points, 2)."""
    cosine, sine = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turn = np.array([[cosine, -sine], [sine, cosine]])
    found: Array = np.einsum("ijk,pj->kpi", turn, points) + poses[:, None, :2]
    return found


# --- drives


def shapes_of_drive(drive: ChainDrive) -> Shapes:
    """Return the outlines of a drive."""
    chain, links, hinges = drive.chain, drive.chain.links, drive.hinge_count
    pitch, half = chain.pitch, 0.5 * chain.pitch
    wheels = hinges if chain.roller is None else 2 * hinges
    found: list[Shape | Bar] = []
    for body, sprocket in enumerate(drive.sprockets, wheels):
        found += [
            Shape("sprocket", (body,), _rustchain.tooth_outline(sprocket, chain, 12)),
            Shape("hub", (body,), _circle(half)),
            # Points to gap 0.
            Shape("mark", (body,), pitch * np.array([[0.5, 0.0], [1.1, 0.0]]), closed=False),
        ]
    guides = range(wheels + len(drive.sprockets), wheels + len(drive.sprockets) + len(drive.guides))
    found += _arms(drive, wheels, guides)
    for body, guide in zip(guides, drive.guides, strict=True):
        found.append(Shape("rail", (body,), guide.outline() + _from_bearing(guide)))
    found += _ends(drive)
    # First link, height of the drawn plate over the pitch.
    for kind, first, share in (("inner", 0, 0.8), ("outer", 1, 0.7)):
        plate = _plate_outline(pitch, share * pitch)
        found.append(Shape(kind, tuple(range(first, links, 2)), plate))  # type: ignore[arg-type]
    places = hinge_places(drive)
    front = tuple(body for body, sign in places if sign > 0)
    rear = tuple(body for body, sign in places if sign < 0)
    if chain.roller is not None:
        rollers = tuple(hinges + k for k in range(hinges) if drive.ends is None or k != links)
        inner, outer = chain.roller.bore_radius, chain.roller.radius
        found += [
            Shape("roller", rollers, _circle(outer)),
            Shape("roller", rollers, _circle(inner)),
            # Shows how each has turned.
            Shape("roller", rollers, np.array([[inner, 0.0], [outer, 0.0]]), closed=False),
        ]
    for kind, radius in (("bushing", chain.bushing_radius), ("pin", chain.hinge.pin_radius)):
        for bodies, side in ((front, half), (rear, -half)):
            if bodies:
                circle = _circle(radius) + [side, 0.0]
                found.append(Shape(kind, bodies, circle))  # type: ignore[arg-type]
    anchors = np.array([[sign * half, 0.0] for _, sign in places])
    carriers = tuple(body for body, _ in places)
    forces = [Forces("hinge", "hinge_force_vector", carriers, anchors)]
    if chain.roller is not None:
        bodies = tuple(range(hinges, 2 * hinges))
        forces.append(Forces("tooth", "tooth_force_vector", bodies, np.zeros((hinges, 2))))
    else:
        forces.append(Forces("tooth", "tooth_force_vector", carriers, anchors))
    return Shapes(tuple(found), tuple(forces), pitch)


def hinge_places(drive: ChainDrive) -> list[tuple[int, float]]:
    """Return of each hinge in arrays its link and the end of it: 1 the front, -1 the rear.

    The one of an open chain that is none stands where the hinge before it does.
    """
    links = drive.chain.links
    places = [(link, 1.0) for link in range(links)]
    return places if drive.ends is None else [*places, (links - 1, 1.0), (0, -1.0)]


def load_size(load: LoadedEnd) -> float:
    """Return the radius of a ball of steel with the mass of a load [m]."""
    return float(np.cbrt(load.mass / (7850.0 * 4.0 / 3.0 * np.pi)))


def _arms(drive: ChainDrive, wheels: int, guides: range) -> Iterator[Shape | Bar]:
    """Yield the arms of tensioner and blades, with their pivots: as wide as links are."""
    width = 0.35 * drive.chain.pitch
    tensioner = drive.tensioner
    if tensioner is not None and tensioner.pivot is not None:
        body = wheels + tensioner.sprocket - 1
        ends = np.array([tensioner.pivot, (0.0, 0.0)])
        yield Bar("arm", (GROUND_ROW, body), ends, width)
        yield Shape("pin", (GROUND_ROW,), _circle(0.5 * width) + ends[0])
    for body, guide in zip(guides, drive.guides, strict=True):
        if isinstance(guide, SmoothIdler) or guide.arm is None:
            continue
        # To the nearer end of the blade, or to its middle where that is nearer; the body's frame
        # sits at the pivot.
        reach = guide.end_radius - 0.5 * guide.length
        marks = np.array([[0.0, reach], [0.0, 0.0], [0.0, -reach]]) + _from_bearing(guide)
        nearest = marks[np.argmin(np.hypot(*marks.T))]
        yield Bar("arm", (body, body), np.array([(0.0, 0.0), nearest]), width)
        yield Shape("pin", (body,), _circle(0.5 * width))


def _ends(drive: ChainDrive) -> Iterator[Shape]:
    """Yield what an open chain ends in: hatched anchors, loads that are balls on their hooks."""
    if drive.ends is None:
        return
    links, side = drive.chain.links, 0.55 * drive.chain.pitch
    # The end behind the last link comes first in arrays.
    for body, end, sign in zip((links, links + 1), drive.ends[::-1], (-1.0, 1.0), strict=True):
        if isinstance(end, AnchoredEnd):
            square = side * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
            yield Shape("anchor", (body,), square)
            yield Shape("anchor", (body,), square[[0, 2]], closed=False)
            yield Shape("anchor", (body,), square[[1, 3]], closed=False)
        elif isinstance(end, LoadedEnd):
            yield Shape("load", (body,), _circle(load_size(end)))
            hook = np.array([[sign * end.arm, 0.0], [0.0, 0.0]])
            yield Shape("load", (body,), hook, closed=False)


def _from_bearing(guide: GuideRail | SmoothIdler) -> Array:
    """Return a guide's middle in a frame at its bearing that turns with it [m]."""
    if isinstance(guide, SmoothIdler) or guide.arm is None:
        return np.zeros(2)
    out = np.array(guide.direction) / np.hypot(*guide.direction)
    arm = np.array(guide.center) - np.array(guide.arm.pivot)
    return np.array([arm @ out, out[0] * arm[1] - out[1] * arm[0]])


# --- mechanisms


def _shapes_of_mechanism(mechanism: Mechanism) -> Shapes:
    """Return outlines of the bodies of a mechanism, which follow from what is attached to them.

    A body is the convex hull of small circles about its points of attachment; without any it is a
    circle of its radius of gyration. Profiles and circles of contacts are drawn as they are.
    """
    rows = {body.name: row for row, body in enumerate(mechanism.bodies)} | {GROUND: GROUND_ROW}
    attached: dict[str, list[tuple[float, ...]]] = {name: [] for name in rows}
    parts: list[Joint | Force] = [*mechanism.joints, *filter(_is_drawn, mechanism.forces)]
    for part in parts:
        if part.kind in ("gear", "torque", "torque_by_speed", "torsion_spring", "custom"):
            continue
        places = ((part.body_b, part.point_b), (part.body_a, part.point_a))
        for name, point in places[: 1 if part.kind == "force" else 2]:
            attached[name].append(tuple(point))
    for contact in mechanism.contacts:
        attached[contact.body_b].append(tuple(contact.point_b))
        if contact.kind in ("bore", "disc"):
            attached[contact.body_a].append(tuple(contact.point_a))
    size = _typical_length(mechanism, attached)
    found: list[Shape | Bar] = []
    for body in mechanism.bodies:
        points = _distinct(attached[body.name], 1e-3 * size)
        if len(points) == 1 and np.hypot(*points[0]) > 1e-3 * size:
            points = np.concatenate([points, np.zeros((1, 2))])
        gyration = np.sqrt(body.inertia / body.mass) if body.mass > 0.0 else 0.0
        alone = len(points) < 2
        radius = min(max(float(gyration), 0.2 * size), size) if alone else 0.2 * size
        centers = points if len(points) else np.zeros((1, 2))
        rounds = (centers[:, None] + _circle(radius)).reshape(-1, 2)
        found.append(Shape("body", (rows[body.name],), _hull(rounds)))
        mark = np.array([[0.0, 0.0], [radius, 0.0]])
        if alone:
            found.append(Shape("mark", (rows[body.name],), mark, closed=False))
    for contact in mechanism.contacts:
        found += _contact_shapes(contact, rows)
    for part in filter(_is_drawn, mechanism.forces):
        if part.kind == "spring":
            bodies = rows[part.body_a], rows[part.body_b]
            ends = np.array([part.point_a, part.point_b], dtype=float)
            found.append(Bar("spring", bodies, ends, 0.25 * size))
    for point in _distinct(attached[GROUND], 1e-3 * size):
        foot = 0.35 * size * np.array([[0.0, 0.0], [-0.6, -1.0], [0.6, -1.0]]) + point
        found.append(Shape("ground", (GROUND_ROW,), foot))
    for joint in mechanism.joints:
        if joint.kind in ("revolute", "prismatic", "point_on_line", "distance"):
            circle = _circle(0.08 * size) + np.array(joint.point_b)
            found.append(Shape("pin", (rows[joint.body_b],), circle))
    forces = []
    if mechanism.contacts:
        carriers = tuple(rows[contact.body_b] for contact in mechanism.contacts)
        points = np.array([contact.point_b for contact in mechanism.contacts], dtype=float)
        forces.append(Forces("contact", "contact_force_vector", carriers, points))
    if mechanism.joints:
        carriers = tuple(rows[joint.body_b] for joint in mechanism.joints)
        points = np.array([joint.point_b for joint in mechanism.joints], dtype=float)
        forces.append(Forces("joint", "joint_reaction", carriers, points))
    # A drive as a mechanism has each sprocket in as many contacts as there are bushings.
    once = {_key(shape): shape for shape in reversed(found)}
    return Shapes(tuple(reversed(once.values())), tuple(forces), size)


def _is_drawn(force: Force) -> bool:
    """Whether a force element has a place: the dashpot of a slide is one to a point far away."""
    return force.kind != "spring" or bool(force.stiffness or force.cubic or force.table)


def _key(shape: Shape | Bar) -> tuple[object, ...]:
    """Return what tells shapes apart."""
    points = shape.outline if isinstance(shape, Shape) else shape.points
    return shape.kind, shape.bodies, points.tobytes()


def _typical_length(mechanism: Mechanism, attached: dict[str, list[tuple[float, ...]]]) -> float:
    """Return a length by which small things are drawn: of links that are of very unlike size."""
    spans = [
        np.ptp(np.array([*points, (0.0, 0.0)]), axis=0).max()
        for name, points in attached.items()
        if points and name != GROUND
    ]
    gyrations = [np.sqrt(b.inertia / b.mass) for b in mechanism.bodies if b.mass > 0.0]
    lengths = [span for span in spans if span > 0.0] or [g for g in gyrations if g > 0.0]
    return 0.5 * float(np.median(lengths)) if lengths else 0.1


def _contact_shapes(contact: Contact, rows: dict[str, int]) -> Iterator[Shape]:
    """Yield the profile of a contact, and its circle."""
    body = (rows[contact.body_a],)
    if contact.kind in ("bore", "disc"):
        circle = _circle(contact.profile_radius) + np.array(contact.point_a)
        yield Shape("profile", body, circle)
    elif contact.kind == "sprocket" and contact.sprocket is not None and contact.chain is not None:
        yield Shape("sprocket", body, _rustchain.tooth_outline(contact.sprocket, contact.chain, 12))
    elif contact.kind == "polyline":
        yield Shape("profile", body, np.array(contact.points, dtype=float), contact.closed)
    else:
        yield Shape("profile", body, _of_arcs(np.array(contact.points)), contact.closed)
    circle = _circle(contact.radius) + np.array(contact.point_b)
    yield Shape("bushing", (rows[contact.body_b],), circle)


def _of_arcs(pieces: Array) -> Array:
    """Return points along pieces (from, to, centre, 1 or -1: convex or hollow)."""
    points: list[Array] = []
    for start, end, center, sign in zip(
        pieces[:, :2], pieces[:, 2:4], pieces[:, 4:6], pieces[:, 6], strict=True
    ):
        points.append(start)
        if np.isfinite(center).all():
            first, last = (np.arctan2(*(p - center)[::-1]) for p in (start, end))
            turn = (last - first) % (2 * np.pi) if sign > 0 else -((first - last) % (2 * np.pi))
            angle = first + turn * np.linspace(0.0, 1.0, 17)[1:-1]
            radius = np.hypot(*(start - center))
            points += list(center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    points.append(pieces[-1, 2:4])
    return np.array(points)


def _distinct(points: list[tuple[float, ...]], apart: float) -> Array:
    """Return points without those that lie on others."""
    kept: list[Array] = []
    for point in map(np.array, points):
        if all(np.hypot(*(point - other)) > apart for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)


def _hull(points: Array) -> Array:
    """Return the convex hull of points, counterclockwise (Andrew's monotone chain)."""
    ordered = points[np.lexsort(points.T[::-1])]
    half: list[list[Array]] = []
    for way in (ordered, ordered[::-1]):
        side: list[Array] = []
        for point in way:
            while len(side) > 1:
                along, across = side[-1] - side[-2], point - side[-2]
                if along[0] * across[1] - along[1] * across[0] > 0.0:
                    break
                side.pop()
            side.append(point)
        half.append(side[:-1])
    return np.array(half[0] + half[1])


# --- outlines


def _bar(way: Array, width: float) -> Array:
    """Return the outline of a bar with round ends along `way`, (2, 2), as a polygon."""
    along = way[1] - way[0]
    angle = np.arctan2(along[1], along[0])
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 24) + angle
    half = 0.5 * width * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return np.concatenate([way[1] + half, way[0] - half])


def _coil(way: Array, width: float) -> Array:
    """Return a zigzag along `way`, (2, 2), as an open line."""
    along = way[1] - way[0]
    length = max(float(np.hypot(*along)), 1e-12)
    across = np.array([-along[1], along[0]]) / length
    share = np.array([0.0, 0.15, *np.linspace(0.2, 0.8, 9), 0.85, 1.0])
    aside = np.zeros(len(share))
    aside[2:-2] = 0.5 * width * np.where(np.arange(9) % 2, -1.0, 1.0)
    zigzag: Array = way[0] + share[:, None] * along + aside[:, None] * across
    return zigzag


def _circle(radius: float) -> Array:
    """Return a circle about the origin as a polygon, (points, 2)."""
    angle = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _plate_outline(pitch: float, height: float) -> Array:
    """Return the outline of a waisted link plate in its own frame, (points, 2)."""
    end, waist = 0.5 * height, 0.36 * height
    rise = ((0.5 * pitch) ** 2 - (end - waist) ** 2) / (2 * (end - waist))
    # The arc of the waist, about (0, rise), touches the round ends, about (+-pitch/2, 0).
    lean = np.arctan2(rise, 0.5 * pitch)
    round_end = np.linspace(lean - np.pi, np.pi - lean, 40)
    right = end * np.stack([np.cos(round_end), np.sin(round_end)], axis=-1) + [0.5 * pitch, 0.0]
    fall = np.linspace(-lean, lean - np.pi, 20)[1:-1]
    upper = (rise - waist) * np.stack([np.cos(fall), np.sin(fall)], axis=-1) + [0.0, rise]
    half = np.concatenate([right, upper])
    return np.concatenate([half, -half])
