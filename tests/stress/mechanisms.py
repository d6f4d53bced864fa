"""Random legal mechanisms: trees of joints, linkages, gears, cams, bouncing bodies, drives."""

from __future__ import annotations

import math
from dataclasses import replace

import parts
import rustchain as rc
import signals
from draw import Draw

Law = rc.SurfaceContact | rc.LinearContact | rc.HuntCrossley
Point = tuple[float, float]

JOINTS = ("revolute",) * 4 + ("prismatic", "line", "distance", "fixed", "none")


def contact_law(draw: Draw, in_bore: bool = False) -> Law:
    """Return a contact law, often with friction, and in bores with a film."""
    kind = draw.one_of(("surface", "surface", "linear", "hunt-crossley"))
    draw.features.append(f"{kind} contact")
    others = {"friction": parts.friction(draw)} if draw.chance(0.3) else {}
    if in_bore and kind != "hunt-crossley" and draw.chance(0.15, "film"):
        others["film"] = parts.film(draw)
    length = draw.log_between(5e-3, 5e-2)
    if kind == "linear":
        stiffness = draw.log_between(1e4, 1e7)
        damping = 1e-4 * draw.between(0.0, 1.0) * stiffness
        if "film" in others or draw.chance(0.3):
            return rc.LinearContact(stiffness / length, damping / length, length, **others)
        return rc.LinearContact(stiffness, damping, **others)
    if kind == "hunt-crossley":
        exponent = draw.one_of((1.0, 1.5, draw.between(1.0, 3.0)))
        return rc.HuntCrossley(draw.log_between(1e6, 1e9), exponent, draw.between(0.0, 2.0))
    # A mechanism refuses sharp regions.
    law = replace(parts.law(draw), regions="kept", **others)
    floor = draw.log_between(1e-6, 1e-1)
    return rc.SurfaceContact(law, length, parts.material(draw), floor)


def _rod(draw: Draw, mechanism: rc.Mechanism, name: str, a: Point, b: Point) -> None:
    """Add a slender rod from a to b."""
    length, mass = math.dist(a, b), draw.log_between(0.05, 5.0)
    if draw.chance(0.05, "mass ratio"):
        mass *= draw.log_between(1e-4, 1e3)
    middle = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), math.atan2(b[1] - a[1], b[0] - a[0]))
    mechanism.add_body(name, mass, mass * length**2 / 12.0, middle)


def _load(draw: Draw, mechanism: rc.Mechanism, name: str, before: str) -> None:
    """Add springs, forces and torques to a body, some of them to the one before it."""
    at = (0.3, 0.4)
    if draw.chance(0.3, "spring"):
        stiffness, damping = draw.log_between(10.0, 1e4), draw.between(0.0, 10.0)
        cubic = draw.one_of((0.0, draw.log_between(1.0, 1e6)))
        ends = (f"spring {name}", "ground", name)
        mechanism.add_spring(*ends, stiffness, damping, point_a=at, cubic=cubic)
    if draw.chance(0.1, "spring of a table"):
        table = ((-0.1, -20.0), (0.0, 0.0), (0.05, 30.0), (0.2, 50.0))
        mechanism.add_spring(f"table {name}", "ground", name, damping=1.0, point_a=at, table=table)
    if draw.chance(0.2, "torsion spring"):
        mechanism.add_torsion_spring(f"torsion {name}", before, name, 5.0, 0.01)
    if draw.chance(0.2, "force"):
        size = draw.log_between(0.1, 100.0)
        force = (signals.about(draw, size), signals.about(draw, -size))
        mechanism.add_force(f"force {name}", name, force, (0.02, 0.01), draw.chance(0.5))
    if draw.chance(0.2, "torque"):
        mechanism.add_torque(f"torque {name}", name, signals.about(draw, draw.between(-5.0, 5.0)))
    if draw.chance(0.1, "torque by speed"):
        curve = ((-100.0, 2.0), (0.0, 0.0), (100.0, -2.0))
        mechanism.add_torque(f"brake {name}", name, by_speed=curve, reaction=before)


def _revolute(draw: Draw, mechanism: rc.Mechanism, ends: tuple[str, str, str], at: Point) -> None:
    """Add a revolute joint, sometimes with friction of its pin."""
    pin = {}
    if draw.chance(0.15, "pin friction"):
        pin = {"friction": parts.coulomb(draw, draw.between(0.01, 0.5)), "radius": 0.01}
    mechanism.add_revolute(*ends, at=at, **pin)


def tree(draw: Draw) -> rc.Mechanism:
    """Return rods one after the other, or from the ground, with joints of all kinds and loads."""
    mechanism = rc.Mechanism(gravity=draw.one_of(((0.0, -9.81), (0.0, 0.0), (3.0, -5.0))))
    before, point = "ground", (0.0, 0.0)
    for k in range(draw.integer(1, 7)):
        angle, length = draw.between(-math.pi, math.pi), draw.between(0.05, 0.5)
        end = (point[0] + length * math.cos(angle), point[1] + length * math.sin(angle))
        name = f"rod_{k}"
        _rod(draw, mechanism, name, point, end)
        kind, ends = draw.one_of(JOINTS), (f"joint_{k}", before, name)
        draw.features.append(kind)
        direction = (math.cos(angle + 1.0), math.sin(angle + 1.0))
        match kind:
            case "revolute":
                _revolute(draw, mechanism, ends, point)
            case "prismatic":
                mechanism.add_prismatic(*ends, direction, at=point)
            case "line":
                mechanism.add_point_on_line(*ends, direction, at=point)
            case "distance":
                mechanism.add_distance(*ends, point_a=(0.1, 0.05), point_b=(-0.5 * length, 0.0))
            case "fixed":
                mechanism.add_fixed(*ends, at=point)
        _load(draw, mechanism, name, before)
        before, point = (name, end) if draw.chance(0.8) else ("ground", (0.0, 0.0))
    return mechanism


def slider_crank(draw: Draw) -> rc.Mechanism:
    """Return a driven slider-crank, often with clearance in its wrist pin."""
    mechanism = rc.Mechanism()
    crank, rod = draw.between(0.03, 0.1), draw.between(0.15, 0.4)
    angle = draw.between(0.2, 2.9)
    pin = (crank * math.cos(angle), crank * math.sin(angle))
    x = pin[0] + math.sqrt(rod**2 - pin[1] ** 2)
    _rod(draw, mechanism, "crank", (0.0, 0.0), pin)
    _rod(draw, mechanism, "rod", pin, (x, 0.0))
    mechanism.add_body("slider", draw.log_between(0.1, 2.0), 1e-3, (x, 0.0, 0.0))
    mechanism.add_revolute("main", "ground", "crank", at=(0.0, 0.0))
    _revolute(draw, mechanism, ("big end", "crank", "rod"), pin)
    mechanism.add_prismatic("guide", "ground", "slider", (1.0, 0.0), at=(x, 0.0))
    if draw.chance(0.2, "driven by its angle"):
        mechanism.add_driver("motor", "ground", "crank", angle=signals.angle(draw, angle))
    elif draw.chance(0.2, "driven by its slider"):
        speed = rc.Sines([(draw.between(0.01, 0.5), draw.log_between(3.0, 300.0), 0.0)])
        ends = ("motor", "ground", "slider", (1.0, 0.0))
        mechanism.add_position_driver(*ends, speed=speed)
    else:
        speed = draw.sign() * draw.log_between(1.0, 2000.0 if draw.chance(0.05) else 300.0)
        mechanism.add_driver("motor", "ground", "crank", speed=signals.about(draw, speed))
    if draw.chance(0.6, "clearance joint"):
        bore = 0.01 + draw.log_between(1e-6, 5e-4)
        law = contact_law(draw, in_bore=True)
        ends = ("wrist", "rod", "slider", bore, 0.01, law)
        mechanism.add_clearance_joint(*ends, bore_point=(0.5 * rod, 0.0))
    else:
        _revolute(draw, mechanism, ("wrist", "rod", "slider"), (x, 0.0))
    return mechanism


def gears(draw: Draw) -> rc.Mechanism:
    """Return two or three wheels on the ground or a carrier, and often a rack."""
    mechanism = rc.Mechanism()
    carrier = None
    if draw.chance(0.4, "carrier"):
        _rod(draw, mechanism, "carrier", (0.0, 0.0), (0.2, 0.0))
        mechanism.add_revolute("axis", "ground", "carrier", at=(0.0, 0.0))
        carrier = "carrier"
    places = ((0.0, 0.0), (0.1, 0.0), (0.2, 0.0))[: draw.integer(2, 3)]
    for k, (x, y) in enumerate(places):
        mass = draw.log_between(0.01, 5.0)
        mechanism.add_body(f"wheel_{k}", mass, 1e-3 * mass, (x, y, draw.between(-3.0, 3.0)))
        on = carrier if carrier and k else "ground"
        _revolute(draw, mechanism, (f"pin_{k}", on, f"wheel_{k}"), (x, y))
        if k:
            ratio = draw.sign() * draw.log_between(0.05, 20.0)
            mechanism.add_gear(f"mesh_{k}", f"wheel_{k - 1}", f"wheel_{k}", ratio, carrier)
        _load(draw, mechanism, f"wheel_{k}", "ground")
    if carrier is None and draw.chance(0.5, "rack"):
        mechanism.add_body("rack", 1.0, 1e-2, (0.0, -0.05, 0.0))
        mechanism.add_prismatic("slide", "ground", "rack", (1.0, 0.0), at=(0.0, -0.05))
        mechanism.add_rack("teeth", "rack", "wheel_0", (1.0, 0.0), 0.05)
    if draw.chance(0.5, "driven"):
        speed = draw.sign() * draw.log_between(1.0, 300.0)
        mechanism.add_driver("motor", "ground", "wheel_0", speed=signals.about(draw, speed))
    return mechanism


def bouncing(draw: Draw) -> rc.Mechanism:
    """Return discs that fall on a fixed one or on an outline, or a pin in a bore."""
    mechanism = rc.Mechanism()
    velocity = (draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.one_of((0.0, 50.0)))
    mass = draw.log_between(0.01, 10.0)
    kind = draw.one_of(("pin in bore", "discs", "outline"))
    draw.features.append(kind)
    if kind == "pin in bore":
        play = draw.log_between(1e-6, 5e-4)
        mechanism.add_body("pin", mass, 1e-4 * mass, velocity=velocity)
        law = contact_law(draw, in_bore=True)
        mechanism.add_clearance_joint("joint", "ground", "pin", 0.01 + play, 0.01, law)
        return mechanism
    table = draw.log_between(0.1, 10.0)
    mechanism.add_body("table", table, 1e-3 * table, (0.0, -0.06, 0.0), fixed=draw.chance(0.8))
    names = ["table"]
    for k in range(draw.integer(1, 3)):
        name = f"disc_{k}"
        mechanism.add_body(name, mass, 1e-4 * mass, (0.002 * k, 0.041 * k, 0.0), velocity)
        for other in names:
            ends, law = (f"{other} {name}", other, name), contact_law(draw)
            if other == "table" and kind == "outline":
                _outline(draw, mechanism, ends, law)
            else:
                radius = 0.04 if other == "table" else 0.02
                mechanism.add_disc_contact(*ends, radius, 0.02, law)
        names.append(name)
    return mechanism


def _outline(draw: Draw, mechanism: rc.Mechanism, ends: tuple[str, str, str], law: Law) -> None:
    """Add a contact with a box of straight or round sides, or with an open profile."""
    top = 0.04 - 1e-3 * draw.between(0.0, 1.0)
    if draw.chance(0.3, "open outline"):
        points, closed = [(0.3, top), (0.0, top - 0.002), (-0.3, top)], False
    else:
        points, closed = [(0.3, top), (-0.3, top), (-0.3, -0.1), (0.3, -0.1)], True
    sides = len(points) if closed else len(points) - 1
    bulges = [draw.between(-0.02, 0.02) for _ in range(sides)] if draw.chance(0.5) else None
    mechanism.add_outline_contact(*ends, points, 0.02, law, bulges=bulges, closed=closed)


def of_a_drive(draw: Draw) -> rc.Mechanism:
    """Return a short drive as a mechanism."""
    teeth = (draw.integer(11, 15), draw.integer(11, 15))
    links = 2 * (sum(teeth) // 2 // 2 + draw.integer(6, 12)) + sum(teeth) % 2
    drive = rc.two_sprocket_drive(
        draw.one_of(("ANSI 35", "ANSI 40", "ISO 08B")),
        teeth,
        links=links,
        speed=signals.speed(draw, 0.03),
        pretension=draw.one_of((None, 50.0)),
    )
    law = replace(parts.law(draw), regions="kept") if draw.chance(0.5) else None
    mechanism = drive.to_mechanism(hinges=draw.one_of(("clearance", "ideal")), force_law=law)
    if draw.chance(0.2, "one driver less"):
        mechanism.joints = [j for j in mechanism.joints if not j.kind.startswith("driven")]
    return mechanism
