"""Random parts of scenes: chains, tooth forms, laws, friction, films, solvers, tensioners."""

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


def material(draw: Draw) -> rc.Material:
    """Return steel, often with another restitution, rarely another material."""
    restitution = draw.between(0.05, 0.95) if draw.chance(0.3) else 0.71
    if draw.chance(0.05, "restitution at its end"):
        restitution = draw.one_of((0.01, 1.0))
    if draw.chance(0.1, "soft material"):
        return rc.Material(draw.log_between(1e9, 2e11), draw.between(0.0, 0.49), restitution)
    return rc.Material(restitution=restitution)


def chain(draw: Draw, links: int = 100) -> rc.Chain:
    """Return a chain of the catalogue, often changed; `links` may be counted anew later."""
    name = draw.one_of(sorted(rc.chain_sizes()))
    has_rollers = rc.chain_sizes()[name].has_rollers and draw.chance(0.2, "rollers")
    plates = "elastic" if draw.chance(0.2, "elastic links") else "rigid"
    strands = draw.one_of((1, 1, 1, 2, 3))
    rollers = "bodies" if has_rollers else "fixed"
    made = rc.catalogue_chain(name, links, strands=strands, rollers=rollers, plates=plates)
    made = replace(made, material=material(draw))
    if plates == "elastic" and draw.chance(0.3, "stiffness in numbers"):
        made = replace(made, link_stiffness=draw.log_between(1e6, 1e9))
    hinge = made.hinge
    if draw.chance(0.25, "clearance"):
        smallest = 0.02 if draw.chance(0.2) else 0.2
        bore = hinge.pin_radius + hinge.clearance * draw.log_between(smallest, 4.0)
        made = replace(made, hinge=replace(hinge, bore_radius=bore))
    if made.roller is not None and draw.chance(0.3, "roller clearance"):
        play = made.roller.bore_radius - made.bushing_radius
        bore = made.bushing_radius + play * draw.log_between(0.1, 3.0)
        made = replace(made, roller=replace(made.roller, bore_radius=bore))
    if draw.chance(0.1, "elongation"):
        made = replace(made, elongation=draw.between(0.0, 0.01))
    if draw.chance(0.1, "pitch spread"):
        made = replace(made, pitch_spread=draw.log_between(1e-6, 1e-3), seed=draw.integer(0, 99))
    if draw.chance(0.1, "link masses"):
        factors = [draw.log_between(0.05, 20.0) for _ in range(2)]
        links_of = (made.inner, made.outer)
        inner, outer = (
            replace(link, mass=link.mass * f, inertia=link.inertia * f)
            for link, f in zip(links_of, factors, strict=True)
        )
        made = replace(made, inner=inner, outer=outer)
    return made


def of_known_links(draw: Draw, made: rc.Chain, closed: bool = True) -> rc.Chain:
    """Return the chain with what belongs to single links, whose number is known."""
    if draw.chance(0.1, "carried masses"):
        mass = made.inner.mass * draw.log_between(0.1, 30.0)
        every = draw.integer(1, 6)
        made = replace(made, carried=[(k, mass) for k in range(1, made.links + 1, every)])
    if draw.chance(0.05, "worn links"):
        wear = [draw.between(0.0, 2e-3) for _ in range(made.links)]
        made = replace(made, elongation=wear)
    if closed and made.links % 2 and draw.chance(0.3, "offset link"):
        offset = replace(made.inner, mass=made.inner.mass * draw.between(0.5, 2.0))
        made = replace(made, offset=offset)
    return made


def tooth_form(
    draw: Draw, made: rc.Chain, teeth: int
) -> rc.AnsiTooth | rc.IsoTooth | rc.StraightTooth | rc.CustomTooth:
    """Return a tooth form that suits the chain, often with dimensions of its own."""
    kind = draw.one_of(("ansi",) * 4 + ("ansi cut",) * 2 + ("iso",) * 3 + ("straight", "custom"))
    diameter = 2.0 * made.contact_radius
    draw.features.append(kind)
    if kind == "custom":
        return _custom(draw, made, teeth)
    common = {"seat": draw.one_of(("bottom-diameter", "bottom-diameter", "pitch-circle"))}
    if draw.chance(0.15, "cut for another roller"):
        common["roller_diameter"] = diameter * draw.between(1.0, 1.04)
    if draw.chance(0.15) and kind != "ansi":
        common["edge_radius"] = diameter * draw.log_between(0.01, 0.06)
    if draw.chance(0.15) and kind in ("iso", "straight"):
        middle = 2.0 * pitch_radius(made.pitch, teeth) + 0.9 * made.pitch - diameter
        common["tip_diameter"] = middle * draw.between(0.99, 1.01)
    if kind == "straight":
        own_seat = 0.505 * diameter * draw.between(1.0, 1.03) if draw.chance(0.2) else None
        return rc.StraightTooth(draw.between(0.15, 0.45), own_seat, **common)
    if kind == "iso":
        gap = draw.one_of(("minimum", "maximum", draw.between(0.0, 1.0)))
        return rc.IsoTooth(gap=gap, **common)
    return rc.AnsiTooth(tip="cut" if kind == "ansi cut" else "full", **common)


def _custom(draw: Draw, made: rc.Chain, teeth: int) -> rc.CustomTooth:
    """Return a round seat with a straight flank, as pieces."""
    seat = made.contact_radius * draw.between(1.005, 1.03)
    center = pitch_radius(made.pitch, teeth) - made.contact_radius + seat
    lean = draw.between(0.2, 0.5)  # of the flank to the middle of the gap
    direction = (math.sin(lean), math.cos(lean))
    end = (seat * math.cos(lean), center - seat * math.sin(lean))
    length = made.pitch * draw.between(0.35, 0.6)
    top = (end[0] + length * direction[0], end[1] + length * direction[1])
    pieces = [rc.ToothArc((0.0, center - seat), end, (0.0, center)), rc.ToothLine(end, top)]
    tip = math.hypot(*top) - 0.1 * made.pitch
    return rc.CustomTooth(pieces, tip_diameter=2.0 * tip)


def friction(draw: Draw) -> rc.Coulomb | rc.LuGre:
    """Return Coulomb's or LuGre friction."""
    coefficient = draw.between(0.02, 0.3)
    if draw.chance(0.05, "great friction"):
        coefficient = draw.between(0.3, 2.0)
    if draw.chance(0.35, "LuGre"):
        made = rc.LuGre(coefficient * draw.between(1.0, 1.5), coefficient)
        if draw.chance(0.4, "bristles"):
            made = replace(
                made,
                stiffness=draw.log_between(1e3, 1e6),
                damping=draw.between(0.0, 10.0),
                viscous_coefficient=draw.between(0.0, 0.1),
                stribeck_speed=draw.log_between(1e-4, 1e-1),
                stribeck_exponent=draw.between(0.5, 4.0),
            )
        return made
    return coulomb(draw, coefficient)


def coulomb(draw: Draw, coefficient: float) -> rc.Coulomb:
    """Return Coulomb's friction, regularized in one of the three ways."""
    kind = draw.one_of(("tanh", "threlfall", "ambrosio"))
    draw.features.append(f"Coulomb {kind}")
    dead = 1e-4 if kind == "ambrosio" else 0.0
    return rc.Coulomb(coefficient, kind, draw.log_between(1e-3, 1e-1), dead)


def film(draw: Draw) -> rc.LubricantFilm:
    """Return a lubricant, often with numbers of its own."""
    made = rc.LubricantFilm(draw.log_between(0.005, 0.5))
    if draw.chance(0.4, "film of its own"):
        made = replace(
            made,
            length=draw.one_of((None, draw.log_between(2e-3, 2e-2))),
            handover=draw.between(0.2, 0.98),
            tension=draw.one_of((0.0, 2e3, 1e5)),
        )
    return made


def law(draw: Draw) -> rc.ForceLaw:
    """Return a force law without friction; mostly damped, for undamped contacts never rest."""
    kind = draw.one_of(LAWS)
    made = kind(stiffness=draw.log_between(1e6, 1e9)) if kind is rc.Linear else kind()
    if kind is rc.EnhancedCylinder and draw.chance(0.5):
        made = replace(made, coefficients="2015")
    if draw.chance(0.85):
        made = replace(made, damping=draw.one_of(DAMPINGS))
    if draw.chance(0.1, "sharp regions"):
        made = replace(made, regions="sharp")
    draw.features.append(made.elastic if made.damping else f"{made.elastic} undamped")
    return made


def solver(draw: Draw) -> rc.Solver:
    """Return a solver; mostly the default accuracy."""
    method = draw.one_of(("auto", "auto", "auto", "newton", "pece"))
    if method != "auto":
        draw.features.append(method)
    others = {}
    if draw.chance(0.1, "largest step"):
        others["max_step"] = draw.log_between(1e-6, 1e-3)
    if draw.chance(0.1, "highest order"):
        others["max_order"] = draw.integer(1, 12)
    if draw.chance(0.1, "tolerances"):
        tolerance = draw.log_between(1e-8, 1e-5)
        rtol, atol = draw.one_of(((1.0, 1.0), (1.0, 1e-3), (0.0, 1.0), (None, 1.0), (1.0, None)))
        scaled = (None if share is None else share * tolerance for share in (rtol, atol))
        return rc.Solver(method, *scaled, **others)
    if draw.chance(0.3):
        return rc.Solver(method, accuracy=draw.log_between(1e-11, 1e-9), **others)
    return rc.Solver(method, **others)


def usual_tension(pitch: float) -> float:
    """Return a strand tension that suits a chain of this pitch [N]: 200 N at half an inch."""
    return 200.0 * (pitch / 0.0127) ** 2


def tensioner(draw: Draw, tension: float, sprocket: int) -> rc.Tensioner:
    """Return a tensioner on a slide or an arm of this sprocket."""
    draw.features.append("tensioner")
    greatest = 1000.0 if draw.chance(0.04, "pretension to its limit") else 3.0
    made = rc.Tensioner(
        pretension=tension * draw.log_between(0.05, greatest),
        sprocket=sprocket,
        ramp_time=draw.log_between(1e-2, 0.3),
        damping=draw.log_between(50.0, 5000.0),
        stiffness=draw.one_of((0.0, draw.log_between(1e3, 1e5))),
    )
    if draw.chance(0.1, "ratchet"):
        made = replace(made, ratchet=draw.one_of((0.0, draw.log_between(1e-4, 1e-2))))
    if draw.chance(0.15, "dashpot one way"):
        made = replace(made, damping_back=draw.log_between(500.0, 50_000.0))
    if draw.chance(0.15, "stops"):
        back = draw.one_of((0.0, draw.log_between(1e-5, 1e-2)))
        made = replace(made, travel=(back, draw.log_between(1e-5, 1e-2)))
    return made


def pitch_radius(pitch: float, teeth: int) -> float:
    """Return the pitch radius [m]."""
    return 0.5 * pitch / math.sin(math.pi / teeth)
