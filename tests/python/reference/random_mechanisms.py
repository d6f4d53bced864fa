"""Random mechanisms with one joint, load or contact of each kind, compared with dense NumPy."""

import numpy as np

import rustchain as rc
from reference.mechanism import Reference

STATES = 8


# Points [m], bulges, whether closed, and the radius of the circle [m].
OUTLINES = {
    "polygon": ([(-0.4, -0.3), (0.5, -0.2), (0.3, 0.4)], None, True, 0.6),
    "polygon with an inward corner": (
        [(-0.6, -0.5), (0.6, -0.6), (0.5, 0.5), (0.0, -0.1), (-0.5, 0.6)],
        None,
        True,
        0.45,
    ),
    "open polyline": ([(1.2, 0.4), (0.4, 0.0), (-0.3, 0.1), (-1.3, 0.7)], None, False, 0.7),
    "convex arc": ([(1.1, 0.0), (-1.1, 0.0)], [0.6], False, 0.5),
    "concave arc": ([(1.3, 0.3), (-1.3, 0.3)], [-0.5], False, 0.6),
    "arc tighter than the circle": ([(0.5, 0.0), (-0.5, 0.1)], [-0.9], False, 1.1),
    "closed outline of arcs": (
        [(-0.5, -0.4), (0.6, -0.4), (0.5, 0.4), (-0.4, 0.5)],
        [0.3, 0.0, -0.5, 0.2],
        True,
        0.55,
    ),
    "lens": ([(-0.6, 0.0), (0.6, 0.1)], [0.4, 0.5], True, 0.4),
    "hole": ([(1.3, -1.2), (-1.2, -1.1), (0.0, 1.4)], [-0.3, -0.2, 0.0], True, 0.6),
}


def law_of(rng):
    if rng.random() < 0.5:
        return rc.LinearContact(stiffness=300.0, damping=2.0)
    return rc.HuntCrossley(stiffness=300.0, exponent=1.5, damping=0.1)


def bodies(rng, count):
    mechanism = rc.Mechanism(gravity=(0.7, -9.81))
    for k in range(count):
        mass = rng.uniform(0.5, 2.0)
        position = (*rng.uniform(-1.0, 1.0, 2), rng.uniform(-3.0, 3.0))
        mechanism.add_body(f"b{k}", mass, mass * rng.uniform(0.05, 0.3), position)
    return mechanism


def waves(rng):
    return rc.Sines(rng.uniform(0.1, 1.0, (2, 3)), offset=0.2)


def joined(kind, rng):
    """Three bodies, one of them on a hinge, and a joint of this kind between the others."""
    m = bodies(rng, 3)
    point = tuple(rng.uniform(-1.0, 1.0, 2))
    direction = tuple(rng.normal(size=2))
    m.add_revolute("hinge", "ground", "b0", at=rng.uniform(-1.0, 1.0, 2))
    ends = ("b0", "b1")
    match kind:
        case "revolute":
            m.add_revolute("joint", *ends, at=point)
        case "fixed":
            m.add_fixed("joint", *ends, at=point)
        case "prismatic":
            m.add_prismatic("joint", *ends, direction, at=point)
        case "point_on_line":
            m.add_point_on_line("joint", *ends, direction, at=point)
        case "distance":
            m.add_distance("joint", *ends, point_a=point, point_b=(0.3, -0.1))
        case "gear":
            m.add_gear("joint", *ends, ratio=-1.4)
        case "planet":
            m.add_gear("joint", "b1", "b2", ratio=0.6, carrier="b0")
        case "rack":
            m.add_rack("joint", *ends, direction, radius=0.4, point_a=point)
        case "driven angle":
            angle = m.bodies[1].position[2] - m.bodies[0].position[2]
            terms = rng.uniform(0.1, 1.0, (2, 3))
            start = (terms[:, 0] * np.sin(terms[:, 2])).sum()
            m.add_driver("joint", *ends, angle=rc.Sines(terms, offset=angle - start))
        case "driven speed":
            m.add_driver("joint", *ends, speed=waves(rng))
        case "driven position":
            m.add_position_driver("joint", *ends, direction, speed=waves(rng), point_b=point)
    return m


def loaded(kind, rng):
    """Three bodies, two on a common hinge, with a load of this kind."""
    m = bodies(rng, 3)
    m.add_revolute("hinge", "b0", "b1", at=rng.uniform(-1.0, 1.0, 2))
    point, other = rng.uniform(-0.5, 0.5, (2, 2))
    ends = ("b1", "b2")
    rows = [(-9.0, 20.0), (-0.1, 3.0), (0.4, -5.0), (9.0, 2.0)]
    match kind:
        case "spring":
            m.add_spring("load", *ends, 30.0, 4.0, point_a=point, point_b=other, cubic=9.0)
        case "spring by a table":
            m.add_spring(
                "load",
                *ends,
                damping=1.0,
                point_a=point,
                point_b=other,
                rest_length=0.5,
                table=rows,
            )
        case "torsion spring":
            m.add_torsion_spring("load", *ends, 30.0, 4.0, rest_angle=0.3, cubic=2.0)
        case "force":
            m.add_force("load", "b2", (3.0, -5.0), point)
        case "force that follows":
            m.add_force("load", "b1", (3.0, -5.0), point, follows=True)
        case "torque":
            m.add_torque("load", "b2", 7.0, reaction="b0")
        case "torque by speed":
            m.add_torque("load", "b2", by_speed=rows, reaction="b1")
        case "bore":
            law = rc.HuntCrossley(stiffness=300.0, exponent=1.5, damping=0.1)
            m.add_clearance_joint("load", *ends, 0.2, 0.19, law, point, other)
        case "disc":
            law = rc.LinearContact(stiffness=300.0, damping=2.0)
            m.add_disc_contact("load", *ends, 1.5, 1.6, law, point, other)
        case "segment":
            law = rc.HuntCrossley(stiffness=300.0, exponent=2.0, damping=0.1)
            line = [(50.0, -3.0), (-50.0, -2.0)]
            m.add_outline_contact("load", *ends, line, 4.0, law, circle_point=other, closed=False)
        case _:
            points, bulges, closed, radius = OUTLINES[kind]
            m.add_outline_contact(
                "load",
                *ends,
                points,
                radius,
                law_of(rng),
                circle_point=other,
                bulges=bulges,
                closed=closed,
            )
    return m


def compare(mechanism, rng):
    """Accelerations, reactions and contact forces at states off and on the constraints.

    Returns how many contacts were closed, and the largest error of an acceleration over its bound.
    """
    simulation = rc.Simulation(mechanism)
    reference = Reference(mechanism)
    placed = np.array([body.position for body in mechanism.bodies])
    pressed, worst = 0, 0.0
    for _ in range(STATES):
        q = placed + 0.2 * rng.normal(size=placed.shape)
        while not reference.is_in_front(q.ravel()):
            q = placed + 0.2 * rng.normal(size=placed.shape)
        v = rng.normal(size=placed.shape)
        t = rng.uniform(0.0, 2.0)
        found = simulation.evaluate(q, v, t)
        solution = reference.solve(q.ravel(), v.ravel(), t)
        acceleration, reactions, forces, condition, rounding = solution
        scale = 1.0 + np.abs(acceleration).max() + np.abs(v).max() ** 2
        # Cauchy's circle of 0.05 s leaves 1e-16 / 0.05^2 of the constraints; the rest is rounding.
        bound = (1e-12 + 1e-15 * condition) * scale + 10.0 * rounding / reference.mass.min()
        off = np.abs(found.accelerations.ravel() - acceleration).max() / bound
        assert off < 1.0
        worst = max(worst, float(off))
        weight = reference.mass.max() * (1.0 + np.abs(q).max())
        assert np.abs(found.joint_reaction - reactions).max() < 20.0 * bound * weight
        if len(forces):
            wrong = np.abs(found.contact_force - forces).max()
            assert wrong <= 1e-13 * forces.max() + 10.0 * rounding
            pressed += int((forces > 0.0).sum())
    return pressed, worst
