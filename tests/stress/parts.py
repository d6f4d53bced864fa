"""Random parts of scenes: chains, tooth forms, laws, solvers, loads."""

from __future__ import annotations

import math
from dataclasses import replace

import rustchain as rc
from draw import Draw

DAMPINGS = (
    "lankarani-nikravesh",
    "hunt-crossley",
    "herbert-mcwhannell",
    "lee-wang",
    "flores",
    "gonthier",
    "hu-guo",
    "zhiying-qishao",
)
LAWS = (
    rc.LankaraniNikravesh,
    rc.Hertz,
    rc.Johnson,
    rc.EnhancedCylinder,
    rc.HertzCylinder,
    rc.Radzimovsky,
    rc.Esdu78035,
    rc.LiuConformal,
    rc.Linear,
)


def chain(draw: Draw, links: int = 100) -> rc.Chain:
    """Return a chain of the catalogue, often changed; `links` may be counted anew later."""
    name = draw.one_of(sorted(rc.chain_sizes()))
    rollers = (
        "bodies" if rc.chain_sizes()[name].has_rollers and draw.chance(0.2, "rollers") else "fixed"
    )
    plates = "elastic" if draw.chance(0.2, "elastic links") else "rigid"
    strands = draw.one_of((1, 1, 1, 2, 3))
    made = rc.catalogue_chain(name, links, strands=strands, rollers=rollers, plates=plates)
    if draw.chance(0.3):
        made = replace(made, material=replace(made.material, restitution=draw.between(0.05, 0.95)))
    if draw.chance(0.2, "clearance"):
        hinge = made.hinge
        bore = hinge.pin_radius + hinge.clearance * draw.log_between(0.2, 4.0)
        made = replace(made, hinge=replace(hinge, bore_radius=bore))
    if draw.chance(0.1, "elongation"):
        made = replace(made, elongation=draw.between(0.0, 0.01))
    if draw.chance(0.1, "pitch spread"):
        made = replace(made, pitch_spread=draw.log_between(1e-6, 1e-3), seed=draw.integer(0, 99))
    return made


def tooth_form(draw: Draw) -> rc.AnsiTooth | rc.IsoTooth | rc.StraightTooth:
    """Return a tooth form; custom ones are left to tests of their own."""
    kind = draw.one_of(("ansi", "ansi", "ansi cut", "iso", "iso", "straight"))
    seat = draw.one_of(("bottom-diameter", "bottom-diameter", "pitch-circle"))
    if kind == "straight":
        return rc.StraightTooth(flank_angle=draw.between(0.15, 0.45), seat=seat)
    if kind == "iso":
        return rc.IsoTooth(gap=draw.between(0.0, 1.0), seat=seat)
    return rc.AnsiTooth(seat=seat, tip="cut" if kind == "ansi cut" else "full")


def friction(draw: Draw) -> rc.Coulomb | rc.LuGre:
    """Return Coulomb's or LuGre friction."""
    coefficient = draw.between(0.02, 0.3)
    if draw.chance(0.3, "LuGre"):
        return rc.LuGre(coefficient * draw.between(1.0, 1.5), coefficient)
    draw.features.append("Coulomb")
    kind = draw.one_of(("tanh", "threlfall", "ambrosio"))
    dead = 1e-4 if kind == "ambrosio" else 0.0
    return rc.Coulomb(coefficient, kind, draw.log_between(1e-3, 1e-1), dead)


def law(draw: Draw) -> rc.ForceLaw:
    """Return a force law without friction; mostly damped, for undamped contacts never rest."""
    kind = draw.one_of(LAWS)
    made = kind(stiffness=draw.log_between(1e6, 1e9)) if kind is rc.Linear else kind()
    if draw.chance(0.85):
        made = replace(made, damping=draw.one_of(DAMPINGS))
    if draw.chance(0.15, "sharp regions"):
        made = replace(made, regions="sharp")
    draw.features.append(made.elastic)
    return made


def solver(draw: Draw) -> rc.Solver:
    """Return a solver; mostly the default accuracy."""
    method = draw.one_of(("auto", "auto", "auto", "newton", "pece"))
    if method != "auto":
        draw.features.append(method)
    if draw.chance(0.1, "tolerances"):
        tolerance = draw.log_between(1e-8, 1e-5)
        return rc.Solver(method, rtol=tolerance, atol=tolerance)
    if draw.chance(0.3):
        return rc.Solver(method, accuracy=draw.log_between(1e-11, 1e-9))
    return rc.Solver(method)


def speed(draw: Draw, radius: float) -> float | tuple[tuple[float, float], ...]:
    """Return a speed or a table of it [rad/s]: up to 15 m/s of a chain at `radius` [m]."""
    value = draw.sign() * draw.log_between(0.1, 15.0) / radius
    if draw.chance(0.2, "ramp"):
        return ((0.0, draw.one_of((0.0, 0.5 * value))), (draw.log_between(5e-3, 0.1), value))
    return value


def usual_tension(pitch: float) -> float:
    """Return a strand tension that suits a chain of this pitch [N]: 200 N at half an inch."""
    return 200.0 * (pitch / 0.0127) ** 2


def load(draw: Draw, tension: float, radius: float) -> rc.Free | rc.AppliedTorque:
    """Return what a driven sprocket bears: nothing, a torque, or a load that grows with speed."""
    if draw.chance(0.4):
        return rc.Free()
    torque = draw.sign() * draw.log_between(0.01, 1.0) * tension * radius
    if draw.chance(0.2, "load curve"):
        fast = 10.0 / radius
        return rc.AppliedTorque(0.0, ((-fast, abs(torque)), (fast, -abs(torque))))
    if draw.chance(0.2, "sudden load"):
        return rc.AppliedTorque(((5e-3, 0.0), (5.1e-3, torque)))
    draw.features.append("torque")
    return rc.AppliedTorque(torque)


def tensioner(draw: Draw, tension: float, sprocket: int) -> rc.Tensioner:
    """Return a tensioner on a slide of this sprocket."""
    draw.features.append("tensioner")
    ratchet = draw.log_between(1e-4, 1e-2) if draw.chance(0.1, "ratchet") else None
    return rc.Tensioner(
        pretension=tension * draw.log_between(0.05, 3.0),
        sprocket=sprocket,
        ramp_time=draw.log_between(1e-2, 0.3),
        damping=draw.log_between(50.0, 5000.0),
        stiffness=draw.one_of((0.0, draw.log_between(1e3, 1e5))),
        ratchet=ratchet,
    )


def pitch_radius(pitch: float, teeth: int) -> float:
    """Return the pitch radius [m]."""
    return 0.5 * pitch / math.sin(math.pi / teeth)
