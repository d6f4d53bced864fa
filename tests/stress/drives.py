"""Random legal drives: closed chains round two sprockets and more, open chains."""

from __future__ import annotations

import math
from dataclasses import replace

import parts
import rustchain as rc
from draw import Draw


def _sprocket(draw: Draw, pitch: float, center: tuple[float, float], driver: bool) -> rc.Sprocket:
    teeth = draw.integer(11, 45)
    radius = parts.pitch_radius(pitch, teeth)
    if driver:
        motion = rc.PrescribedSpeed(parts.speed(draw, radius))
        if draw.chance(0.1, "driven by a torque"):
            motion = rc.AppliedTorque(draw.between(0.1, 1.0) * parts.usual_tension(pitch) * radius)
    else:
        motion = parts.load(draw, parts.usual_tension(pitch), radius)
    made = rc.Sprocket(teeth, center, motion, parts.tooth_form(draw))
    if draw.chance(0.1, "eccentric"):
        made = replace(made, eccentricity=draw.log_between(1e-6, 1e-3) * radius)
    if draw.chance(0.1, "damaged tooth"):
        made = replace(made, damaged_teeth=[(draw.integer(0, teeth - 1), draw.between(0.0, 0.9))])
    return made


def two_sprockets(draw: Draw) -> rc.ChainDrive:
    """Return a drive of two sprockets at any angle, taut or tensioned."""
    chain = parts.chain(draw)
    pitch = chain.pitch
    driver = _sprocket(draw, pitch, (0.0, 0.0), driver=True)
    driven = _sprocket(draw, pitch, (0.0, 0.0), driver=False)
    radii = [parts.pitch_radius(pitch, s.teeth) for s in (driver, driven)]
    distance = (sum(radii) + 2.0 * pitch) * draw.between(1.0, 2.0)
    angle = draw.one_of((0.0, draw.between(-math.pi, math.pi)))
    driven = replace(driven, center=(distance * math.cos(angle), distance * math.sin(angle)))
    pull = parts.usual_tension(pitch)
    return rc.chain_drive(
        chain,
        [driver, driven],
        adjust=None if draw.chance(0.1, "slack") else 2,
        tensioner=parts.tensioner(draw, pull, 2) if draw.chance(0.5) else None,
        gravity=draw.one_of(((0.0, -9.81), (0.0, 0.0), (9.81, 0.0))),
        guides=_guides(draw, distance, angle, radii) if draw.chance(0.25) else (),
    )


def _guides(
    draw: Draw, distance: float, angle: float, radii: list[float]
) -> list[rc.GuideRail | rc.SmoothIdler]:
    """Return a rail or a blade outside one strand of two sprockets, or a smooth idler inside it."""
    side = draw.sign()
    # Direction of the line of centres, and outward across the strand.
    ux, uy = math.cos(angle), math.sin(angle)
    nx, ny = -side * uy, side * ux
    mean = 0.5 * (radii[0] + radii[1])
    plastic = rc.Material(elastic_modulus=3e9, poisson_ratio=0.4)
    material = plastic if draw.chance(0.5) else None

    def beside(gap: float) -> tuple[float, float]:
        return (0.5 * distance * ux + gap * nx, 0.5 * distance * uy + gap * ny)

    if draw.chance(0.3, "smooth idler"):
        inertia = draw.one_of((None, 1e-4))
        radius = mean * draw.between(0.2, 0.4)
        center = beside(mean * draw.between(0.6, 0.95) - radius)
        return [rc.SmoothIdler(radius, center, inertia=inertia, material=material)]
    draw.features.append("rail")
    length = draw.between(0.2, 0.5) * distance
    radius = length * draw.between(1.0, 4.0) if draw.chance(0.5) else None
    if draw.chance(0.5, "blade"):
        center = beside(mean * draw.between(0.95, 1.15))
        pivot = (center[0] + 0.6 * length * ux, center[1] + 0.6 * length * uy)
        arm = rc.GuideArm(pivot, force=draw.log_between(1.0, 100.0))
    else:
        center, arm = beside(mean * draw.between(1.1, 1.4)), None
    return [rc.GuideRail(center, (-nx, -ny), length, radius, arm=arm, material=material)]


def layout(draw: Draw) -> rc.ChainDrive:
    """Return a drive of three to six sprockets on a ring, some of them outside the chain."""
    chain = parts.chain(draw)
    count = draw.integer(3, 6)
    ring = chain.pitch * draw.between(25.0, 45.0)
    sprockets = []
    for k in range(count):
        angle = 2.0 * math.pi * (k + draw.between(-0.15, 0.15)) / count
        far = ring * draw.between(0.8, 1.2)
        center = (far * math.cos(angle), far * math.sin(angle))
        made = _sprocket(draw, chain.pitch, center, driver=k == 0)
        made = replace(made, teeth=draw.integer(11, 25), damaged_teeth=())
        if 0 < k < count - 1 and count > 4 and draw.chance(0.3, "reverse idler"):
            # Just outside the strand between its neighbours, which it presses inward.
            far = 0.9 * ring * math.cos(2.0 * math.pi / count)
            center = (far * math.cos(angle), far * math.sin(angle))
            made = replace(made, center=center, side="outside", motion=rc.Free())
        sprockets.append(made)
    pull = parts.usual_tension(chain.pitch)
    return rc.chain_drive(
        chain,
        sprockets,
        adjust=count if draw.chance(0.8) else None,
        tensioner=parts.tensioner(draw, pull, count) if draw.chance(0.5) else None,
        gravity=draw.one_of(((0.0, -9.81), (0.0, 0.0))),
    )


def paper(draw: Draw) -> rc.ChainDrive:
    """Return the published drive under a pretension, loaded or not."""
    pretension = draw.one_of((0.0, draw.log_between(1.0, 1000.0)))
    rollers = "bodies" if draw.chance(0.2, "rollers") else "fixed"
    drive = rc.paper_drive(pretension, rollers=rollers)
    driver, driven = drive.sprockets
    driver = replace(driver, motion=rc.PrescribedSpeed(parts.speed(draw, 0.0346)))
    driven = replace(driven, motion=parts.load(draw, 0.5 * pretension + 10.0, 0.0346))
    return replace(drive, sprockets=[driver, driven])


def ideal_hinges(draw: Draw) -> rc.ChainDrive:
    """Return a drive of two small sprockets with ideal hinges."""
    teeth = (draw.integer(11, 19), draw.integer(11, 19))
    links = 2 * ((sum(teeth) // 2 + draw.integer(8, 30)) // 2) + sum(teeth) % 2
    return rc.two_sprocket_drive(
        draw.one_of(("ANSI 35", "ANSI 40", "ANSI 60", "ISO 08B")),
        teeth,
        links=links,
        speed=parts.speed(draw, 0.04),
        torque=draw.one_of((None, draw.between(-2.0, 2.0))),
        pretension=draw.one_of((None, draw.log_between(5.0, 200.0))),
        hinges="ideal",
    )


def open_chain(draw: Draw) -> rc.ChainDrive:
    """Return an open chain: hanging between two ends, or over a hoist's wheel."""
    links = draw.integer(4, 60)
    chain = parts.chain(draw, links)
    span = chain.pitch * links
    mass = draw.log_between(0.01, 20.0) * (chain.pitch / 0.0127) ** 2
    if draw.chance(0.5, "hoist"):
        wheel = _sprocket(draw, chain.pitch, (0.0, 0.0), driver=True)
        wheel = replace(wheel, teeth=draw.integer(11, 17), damaged_teeth=())
        ends = (
            rc.LoadedEnd(mass),
            draw.one_of((rc.LoadedEnd(0.5 * mass), rc.FreeEnd(links=links // 3))),
        )
        return rc.open_chain(chain, ends, max(links, 20), [wheel])
    anchor = rc.AnchoredEnd((0.0, 0.0), _anchor_motion(draw))
    far = span * draw.between(0.1, 0.98)
    angle = draw.between(-0.5 * math.pi, 0.0)
    place = (far * math.cos(angle), far * math.sin(angle))
    other = draw.one_of(
        (
            rc.AnchoredEnd(place),
            rc.LoadedEnd(mass),
            rc.FreeEnd(),
            rc.LoadedEnd(mass, arm=0.05),
            rc.AnchoredEnd(place),
        )
    )
    return rc.open_chain(chain, (anchor, other), links)


def _anchor_motion(draw: Draw) -> tuple[float, float] | tuple[tuple[float, float, float], ...]:
    """Return an anchor's velocity: none, or one that grows from rest."""
    if draw.chance(0.6):
        return (0.0, 0.0)
    draw.features.append("moved anchor")
    v = draw.between(-1.0, 1.0)
    return ((0.0, 0.0, 0.0), (0.01, v, draw.between(-1.0, 1.0)), (0.02, 0.0, 0.0))
