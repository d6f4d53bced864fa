"""Sprockets of each tooth form, and places of circles near their teeth."""

from dataclasses import replace

import numpy as np

import rustchain as rc
from reference import teeth as outline

PITCH, ROLLER = 0.0127, 0.0079375
RADIUS, EDGE = ROLLER / 2, 0.025 * ROLLER
CHAIN = replace(rc.paper_drive().chain, links=40)


def pitch_radius(teeth):
    return PITCH / (2 * np.sin(np.pi / teeth))


def iso_outside(teeth):
    """Middle of the standard's range of tip radii."""
    d = 2 * pitch_radius(teeth)
    return (d + PITCH * (1 - 1.6 / teeth) - ROLLER + d + 1.25 * PITCH - ROLLER) / 4


def ansi_outside(teeth):
    return PITCH / 2 * (0.6 + 1 / np.tan(np.pi / teeth))


def cases():
    for teeth in (9, 17, 40):
        for share in (0.0, 0.4):
            flank = outline.iso_flank(PITCH, teeth, ROLLER, share)
            yield teeth, rc.IsoTooth(gap=share), flank, iso_outside(teeth)
        flank = outline.iso_flank(PITCH, teeth, ROLLER, 1.0, seated=False)
        low = pitch_radius(teeth) + (PITCH * (1 - 1.6 / teeth) - ROLLER) / 2
        profile = rc.IsoTooth("maximum", seat="pitch-circle", tip_diameter=2 * low)
        yield teeth, profile, flank, low
        flank = outline.iso_flank(PITCH, teeth, ROLLER, 1.0)
        yield teeth, rc.IsoTooth(1.0, tip_diameter=2 * low), flank, low
        flank = outline.ansi_flank(PITCH, teeth, ROLLER)
        yield teeth, rc.AnsiTooth(tip="cut"), flank, ansi_outside(teeth)
        flank = outline.straight_flank(PITCH, teeth, ROLLER, 0.45)
        yield teeth, rc.StraightTooth(0.45), flank, iso_outside(teeth)


def near_the_surface(flanks, teeth, depths, rng):
    """Places of circles between 1 mm off and 0.1 mm in, in the frame of the teeth."""
    middle = pitch_radius(teeth)
    places = rng.uniform(-1, 1, 4000) * 1j * np.pi
    places = rng.uniform(middle - 3e-4, middle + 6e-3, 4000) * np.exp(places)
    found = outline.penetration(flanks, teeth, places, RADIUS)
    keep = (found > depths[0]) & (found < depths[1])
    return places[keep], found[keep]
