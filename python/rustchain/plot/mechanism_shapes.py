"""Shapes of the bodies of a mechanism."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rustchain import _rustchain
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.mechanism.parts import GROUND, Contact, Force, Joint
from rustchain.plot import outlines
from rustchain.plot.shapes import GROUND_ROW, Bar, Forces, Shape, Shapes


def shapes_of_mechanism(mechanism: Mechanism) -> Shapes:
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
        points = outlines.distinct(attached[body.name], 1e-3 * size)
        if len(points) == 1 and np.hypot(*points[0]) > 1e-3 * size:
            points = np.concatenate([points, np.zeros((1, 2))])
        gyration = np.sqrt(body.inertia / body.mass) if body.mass > 0.0 else 0.0
        alone = len(points) < 2
        radius = min(max(float(gyration), 0.2 * size), size) if alone else 0.2 * size
        centers = points if len(points) else np.zeros((1, 2))
        rounds = (centers[:, None] + outlines.circle(radius)).reshape(-1, 2)
        found.append(Shape("body", (rows[body.name],), outlines.hull(rounds)))
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
    for point in outlines.distinct(attached[GROUND], 1e-3 * size):
        foot = 0.35 * size * np.array([[0.0, 0.0], [-0.6, -1.0], [0.6, -1.0]]) + point
        found.append(Shape("ground", (GROUND_ROW,), foot))
    for joint in mechanism.joints:
        if joint.kind in ("revolute", "prismatic", "point_on_line", "distance"):
            circle = outlines.circle(0.08 * size) + np.array(joint.point_b)
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
    """Return whether a force element has a position; the dashpot of a slide has none."""
    return force.kind != "spring" or bool(force.stiffness or force.cubic or force.table)


def _key(shape: Shape | Bar) -> tuple[object, ...]:
    """Return the key of a shape: equal shapes have equal keys."""
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
        circle = outlines.circle(contact.profile_radius) + np.array(contact.point_a)
        yield Shape("profile", body, circle)
    elif contact.kind == "sprocket" and contact.sprocket is not None and contact.chain is not None:
        yield Shape("sprocket", body, _rustchain.tooth_outline(contact.sprocket, contact.chain, 12))
    elif contact.kind == "polyline":
        yield Shape("profile", body, np.array(contact.points, dtype=float), contact.closed)
    else:
        yield Shape("profile", body, outlines.of_arcs(np.array(contact.points)), contact.closed)
    circle = outlines.circle(contact.radius) + np.array(contact.point_b)
    yield Shape("bushing", (rows[contact.body_b],), circle)
