"""Random legal drives: closed chains round two sprockets and more, open chains."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import guides
import parts
import rustchain as rc
import signals
from draw import Draw

GRAVITIES = ((0.0, -9.81), (0.0, 0.0), (9.81, 0.0))


def _sprocket(
    draw: Draw, chain: rc.Chain, center: tuple[float, float], driver: bool, most_teeth: int = 45
) -> rc.Sprocket:
    teeth = draw.integer(11, most_teeth)
    if draw.chance(0.06, "few or many teeth"):
        teeth = draw.one_of((draw.integer(9, 10), draw.integer(46, 120)))
    radius = parts.pitch_radius(chain.pitch, teeth)
    usual = parts.usual_tension(chain.pitch)
    if driver:
        motion = rc.PrescribedSpeed(signals.speed(draw, radius))
        if draw.chance(0.1, "driven by a torque"):
            motion = rc.AppliedTorque(signals.about(draw, draw.between(0.1, 1.0) * usual * radius))
    else:
        motion = signals.load(draw, usual, radius)
    made = rc.Sprocket(teeth, center, motion, parts.tooth_form(draw, chain, teeth))
    if draw.chance(0.1, "eccentric"):
        offset = draw.log_between(1e-6, 1e-3) * radius
        made = replace(made, eccentricity=offset, eccentricity_angle=draw.between(-3.0, 3.0))
    if draw.chance(0.1, "damaged tooth"):
        first = draw.integer(0, teeth - 1)
        damage = [(first, draw.between(0.0, 0.9))]
        if draw.chance(0.3, "two damaged teeth"):
            damage.append(((first + 1) % teeth, draw.between(0.0, 0.9)))
        made = replace(made, damaged_teeth=damage)
    if draw.chance(0.15, "load inertia"):
        made = replace(made, load_inertia=draw.log_between(1e-6, 10.0))
    if draw.chance(0.1, "own mass"):
        mass = draw.log_between(0.01, 100.0)
        made = replace(made, mass=mass, inertia=mass * radius**2 * draw.between(0.1, 1.0))
    if not driver and draw.chance(0.05, "initial speed"):
        made = replace(made, initial_speed=draw.sign() * draw.log_between(0.01, 5.0) / radius)
    return made


def two_sprockets(draw: Draw, hinges: Literal["clearance", "ideal"] = "clearance") -> rc.ChainDrive:
    """Return a drive of two sprockets at any angle, taut or tensioned."""
    chain = parts.chain(draw)
    if hinges == "ideal":
        chain = replace(chain, link_stiffness=None)
    pitch = chain.pitch
    driver = _sprocket(draw, chain, (0.0, 0.0), driver=True)
    driven = _sprocket(draw, chain, (0.0, 0.0), driver=False)
    radii = [parts.pitch_radius(pitch, s.teeth) for s in (driver, driven)]
    distance = (sum(radii) + 2.0 * pitch) * draw.between(1.0, 2.0)
    angle = draw.one_of((0.0, draw.between(-math.pi, math.pi)))
    driven = replace(driven, center=(distance * math.cos(angle), distance * math.sin(angle)))
    strands = guides.Strands(distance, angle, (radii[0], radii[1]), pitch, chain.contact_radius)
    tensioner = None
    if draw.chance(0.5):
        tensioner = parts.tensioner(draw, parts.usual_tension(pitch), 2)
        if draw.chance(0.1, "tensioner on an arm"):
            side = draw.between(0.5, 1.5) * distance
            x, y = driven.center
            pivot = (x - side * math.sin(angle), y + side * math.cos(angle))
            tensioner = replace(
                tensioner, pivot=pivot, arm_inertia=draw.one_of((0.0, draw.log_between(1e-4, 1.0)))
            )
        elif draw.chance(0.1, "direction of its own"):
            lean = angle + draw.between(-0.5, 0.5)
            tensioner = replace(tensioner, direction=(math.cos(lean), math.sin(lean)))
    elif draw.chance(0.06, "floating bearing"):
        driven = replace(driven, bearing="floating")
    drive = rc.chain_drive(
        chain,
        [driver, driven],
        adjust=None if draw.chance(0.1, "slack") else 2,
        tensioner=tensioner,
        gravity=draw.one_of(GRAVITIES),
        guides=guides.guides(draw, strands) if draw.chance(0.25) else (),
        hinges=hinges,
    )
    return replace(drive, chain=parts.of_known_links(draw, drive.chain))


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
        sprockets.append(_sprocket(draw, chain, center, driver=k == 0, most_teeth=25))
    if count > 4 and draw.chance(0.4, "reverse idler"):
        _press_inward(draw, chain.pitch, sprockets, draw.integer(1, count - 2))
    pull = parts.usual_tension(chain.pitch)
    drive = rc.chain_drive(
        chain,
        sprockets,
        adjust=count if draw.chance(0.8) else None,
        tensioner=parts.tensioner(draw, pull, count) if draw.chance(0.5) else None,
        gravity=draw.one_of(GRAVITIES),
    )
    return replace(drive, chain=parts.of_known_links(draw, drive.chain))


def _press_inward(draw: Draw, pitch: float, sprockets: list[rc.Sprocket], k: int) -> None:
    """Let sprocket k, counted from 0, press the strand between its neighbours inward."""
    (ax, ay), (bx, by) = sprockets[k - 1].center, sprockets[k + 1].center
    radii = [parts.pitch_radius(pitch, s.teeth) for s in sprockets[k - 1 : k + 2]]
    half = 0.5 * math.hypot(bx - ax, by - ay)
    # Outward across the strand, since the centres are in counterclockwise order.
    nx, ny = 0.5 * (by - ay) / half, -0.5 * (bx - ax) / half
    far = 0.5 * (radii[0] + radii[2]) + radii[1] - draw.between(0.3, 0.5) * half
    center = (0.5 * (ax + bx) + far * nx, 0.5 * (ay + by) + far * ny)
    sprockets[k] = replace(sprockets[k], center=center, side="outside", motion=rc.Free())


def paper(draw: Draw) -> rc.ChainDrive:
    """Return the published drive under a pretension, loaded or not."""
    pretension = draw.one_of((0.0, draw.log_between(1.0, 1000.0)))
    rollers = "bodies" if draw.chance(0.2, "rollers") else "fixed"
    drive = rc.paper_drive(pretension, rollers=rollers)
    driver, driven = drive.sprockets
    driver = replace(driver, motion=rc.PrescribedSpeed(signals.speed(draw, 0.0346)))
    driven = replace(driven, motion=signals.load(draw, 0.5 * pretension + 10.0, 0.0346))
    return replace(drive, sprockets=[driver, driven])


def ideal_hinges(draw: Draw) -> rc.ChainDrive:
    """Return a drive of two sprockets with ideal hinges."""
    return two_sprockets(draw, "ideal")


def open_chain(draw: Draw) -> rc.ChainDrive:
    """Return an open chain, some with ideal hinges."""
    drive = _open_chain(draw)
    if draw.chance(0.2, "open ideal"):
        return replace(drive, chain=replace(drive.chain, link_stiffness=None), hinges="ideal")
    return drive


def _open_chain(draw: Draw) -> rc.ChainDrive:
    """Return an open chain: hanging between two ends, or over a hoist's wheel."""
    links = draw.integer(4, 60)
    chain = parts.chain(draw, links)
    chain = parts.of_known_links(draw, replace(chain, links=links), closed=False)
    span = chain.pitch * links
    mass = draw.log_between(0.01, 20.0) * (chain.pitch / 0.0127) ** 2
    if draw.chance(0.5, "hoist"):
        chain = replace(chain, carried=(), elongation=0.0)
        wheel = _sprocket(draw, chain, (0.0, 0.0), driver=True, most_teeth=17)
        inertia = draw.one_of((None, mass * draw.log_between(1e-6, 1e-2)))
        ends = (
            rc.LoadedEnd(mass, inertia),
            draw.one_of((rc.LoadedEnd(0.5 * mass), rc.FreeEnd(links=links // 3))),
        )
        links = max(links, wheel.teeth + 8)
        return rc.open_chain(replace(chain, links=links), ends, links, [wheel])
    anchor = rc.AnchoredEnd((0.0, 0.0), signals.anchor_velocity(draw))
    far = span * draw.between(0.1, 0.98)
    angle = draw.between(-0.5 * math.pi, 0.0)
    place = (far * math.cos(angle), far * math.sin(angle))
    other = draw.one_of(
        (
            rc.AnchoredEnd(place),
            rc.LoadedEnd(mass),
            rc.FreeEnd(),
            rc.LoadedEnd(mass, arm=0.05),
            rc.LoadedEnd(mass, position=place),
            rc.AnchoredEnd(place),
        )
    )
    return rc.open_chain(chain, (anchor, other), links)
