"""Random legal mechanisms: pendulums, four-bar linkages, slider-cranks, bouncing bodies."""

from __future__ import annotations

import math

import parts
import rustchain as rc
from draw import Draw


def _contact_law(draw: Draw) -> rc.SurfaceContact | rc.LinearContact | rc.HuntCrossley:
    kind = draw.one_of(("surface", "surface", "linear", "hunt-crossley"))
    draw.features.append(f"{kind} contact")
    if kind == "linear":
        stiffness = draw.log_between(1e4, 1e7)
        return rc.LinearContact(stiffness, 1e-4 * draw.between(0.0, 1.0) * stiffness)
    if kind == "hunt-crossley":
        return rc.HuntCrossley(draw.log_between(1e6, 1e9), 1.5, draw.between(0.0, 2.0))
    return rc.SurfaceContact(parts.law(draw), length=draw.log_between(5e-3, 5e-2))


def _rod(
    draw: Draw, mechanism: rc.Mechanism, name: str, a: tuple[float, float], b: tuple[float, float]
) -> None:
    """Add a slender rod from a to b."""
    length, mass = math.dist(a, b), draw.log_between(0.05, 5.0)
    middle = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), math.atan2(b[1] - a[1], b[0] - a[0]))
    mechanism.add_body(name, mass, mass * length**2 / 12.0, middle)


def pendulum(draw: Draw) -> rc.Mechanism:
    """Return a chain of rods that swings, with springs between some of them and the ground."""
    mechanism = rc.Mechanism()
    before, point = "ground", (0.0, 0.0)
    for k in range(draw.integer(1, 6)):
        angle, length = draw.between(-math.pi, math.pi), draw.between(0.05, 0.5)
        end = (point[0] + length * math.cos(angle), point[1] + length * math.sin(angle))
        _rod(draw, mechanism, f"rod_{k}", point, end)
        mechanism.add_revolute(f"joint_{k}", before, f"rod_{k}", at=point)
        if draw.chance(0.3, "spring"):
            stiffness = draw.log_between(10.0, 1e4)
            damping = draw.between(0.0, 10.0)
            ends = (f"spring_{k}", "ground", f"rod_{k}")
            mechanism.add_spring(*ends, stiffness, damping, point_a=(0.3, 0.4))
        if draw.chance(0.2, "torsion spring"):
            mechanism.add_torsion_spring(f"torsion_{k}", before, f"rod_{k}", 5.0, 0.01)
        before, point = f"rod_{k}", end
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
    mechanism.add_revolute("big end", "crank", "rod", at=pin)
    mechanism.add_prismatic("guide", "ground", "slider", (1.0, 0.0), at=(x, 0.0))
    mechanism.add_driver("motor", "ground", "crank", speed=draw.sign() * draw.log_between(1, 300))
    if draw.chance(0.6, "clearance joint"):
        bore = 0.01 + draw.log_between(5e-6, 5e-4)
        mechanism.add_clearance_joint(
            "wrist", "rod", "slider", bore, 0.01, _contact_law(draw), bore_point=(0.5 * rod, 0.0)
        )
    else:
        mechanism.add_revolute("wrist", "rod", "slider", at=(x, 0.0))
    return mechanism


def bouncing(draw: Draw) -> rc.Mechanism:
    """Return discs that fall on a fixed one, or a pin in a bore."""
    mechanism = rc.Mechanism()
    velocity = (draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), 0.0)
    mass = draw.log_between(0.01, 10.0)
    if draw.chance(0.5, "pin in bore"):
        play = draw.log_between(1e-6, 5e-4)
        mechanism.add_body("pin", mass, 1e-4 * mass, velocity=velocity)
        mechanism.add_clearance_joint(
            "joint", "ground", "pin", 0.01 + play, 0.01, _contact_law(draw)
        )
        return mechanism
    mechanism.add_body("table", 1.0, 1e-3, (0.0, -0.06, 0.0), fixed=True)
    names = ["table"]
    for k in range(draw.integer(1, 3)):
        name = f"disc_{k}"
        mechanism.add_body(name, mass, 1e-4 * mass, (0.002 * k, 0.041 * k, 0.0), velocity)
        for other in names:
            radius = 0.04 if other == "table" else 0.02
            mechanism.add_disc_contact(
                f"{other} {name}", other, name, radius, 0.02, _contact_law(draw)
            )
        names.append(name)
    return mechanism


def of_a_drive(draw: Draw) -> rc.Mechanism:
    """Return a short drive as a mechanism."""
    teeth = (draw.integer(11, 15), draw.integer(11, 15))
    links = 2 * (sum(teeth) // 2 // 2 + draw.integer(6, 12)) + sum(teeth) % 2
    drive = rc.two_sprocket_drive(
        draw.one_of(("ANSI 35", "ANSI 40", "ISO 08B")),
        teeth,
        links=links,
        speed=parts.speed(draw, 0.03),
        pretension=draw.one_of((None, 50.0)),
    )
    return drive.to_mechanism(hinges=draw.one_of(("clearance", "ideal")))
