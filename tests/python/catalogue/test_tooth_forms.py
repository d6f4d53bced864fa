"""Tooth forms against distances from every piece of the outline, alone and in a drive."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from reference import teeth as outline
from reference.tooth_cases import (
    CHAIN,
    EDGE,
    PITCH,
    RADIUS,
    ROLLER,
    ansi_outside,
    cases,
    iso_outside,
    near_the_surface,
    pitch_radius,
)
from rustchain import _rustchain


def drawn(teeth):
    """A custom tooth: seat, line, arc, and an arc over the middle of the tooth."""
    flank = outline.straight_flank(PITCH, teeth, ROLLER, 0.5)
    whole = outline.cut(flank, teeth, pitch_radius(teeth) + 0.0025, 0.0008)
    pieces = []
    for piece in whole:
        start, end = ((p.real, p.imag) for p in (piece.start, piece.end))
        if piece.center is None:
            pieces.append(rc.ToothLine(start, end))
        else:
            pieces.append(rc.ToothArc(start, end, (piece.center.real, piece.center.imag)))
    return rc.CustomTooth(pieces), whole


def assert_same(profile, damaged, flanks, teeth):
    sprocket = rc.Sprocket(teeth, profile=profile, damaged_teeth=damaged)
    rng = np.random.default_rng(teeth)
    places, expected = near_the_surface(flanks, teeth, (-1e-3, 1e-4), rng)
    points = np.stack([places.real, places.imag], axis=1)
    _, depth, normal = _rustchain.tooth_contacts(sprocket, CHAIN, points, RADIUS)
    # Coordinates of the sprocket's size go through some ten roundings on either side.
    bound = 40 * np.finfo(float).eps * np.max(np.abs(places))
    assert len(places) > 100
    assert np.max(np.abs(depth - expected)) <= bound
    # The normal is the slope of the depth: by differences over 1 um, curved by 0.2 mm at the least.
    step = 1e-6
    for axis, direction in ((0, 1.0), (1, 1j)):
        ahead = outline.penetration(flanks, teeth, places + step * direction, RADIUS)
        behind = outline.penetration(flanks, teeth, places - step * direction, RADIUS)
        slope = (ahead - behind) / (2 * step)
        off = np.abs(slope - normal[:, axis])
        assert np.mean(off < 1e-5) > 0.99  # the rest astride the middle of a gap or a tooth


@pytest.mark.parametrize(("teeth", "profile", "flank", "outside"), list(cases()))
def test_each_form_is_as_deep_as_the_outline_is_near(teeth, profile, flank, outside):
    whole = outline.cut(flank, teeth, outside, EDGE)
    assert_same(profile, (), {-1: whole}, teeth)
    bottom = abs(whole[0].start)
    damaged = ((0, 0.0), (2, 0.3), (teeth - 2, 0.75))
    stumps = {
        tooth: outline.cut(flank, teeth, bottom + height * (outside - bottom), EDGE)
        for tooth, height in damaged
    }
    assert_same(profile, damaged, {-1: whole} | stumps, teeth)


@pytest.mark.parametrize("teeth", [13, 29])
def test_a_tooth_drawn_piece_by_piece_is_as_deep_as_its_outline_is_near(teeth):
    profile, whole = drawn(teeth)
    assert_same(profile, (), {-1: whole}, teeth)


def test_a_drive_of_other_teeth_finds_the_depths_of_the_outlines():
    """Random poses of ISO teeth and of eccentric, damaged, cut ANSI ones, links of all lengths."""
    teeth, links = (17, 21), 47
    chain = replace(CHAIN, links=links, elongation=0.003, pitch_spread=1e-4, seed=3)
    drive = rc.two_sprocket_drive(chain, teeth, links=links)
    first = replace(drive.sprockets[0], profile=rc.IsoTooth(0.5))
    second = replace(
        drive.sprockets[1],
        center=(drive.sprockets[1].center[0] - 3e-4, 0.0),
        profile=rc.AnsiTooth(tip="cut"),
        eccentricity=4e-5,
        eccentricity_angle=2.0,
        damaged_teeth=((4, 0.5), (5, 0.0)),
    )
    drive = replace(drive, sprockets=(first, second))
    simulation = rc.Simulation(drive)
    flank = outline.ansi_flank(PITCH, 21, ROLLER)
    ansi = outline.cut(flank, 21, ansi_outside(21), EDGE)
    bottom, outside = abs(ansi[0].start), ansi_outside(21)
    flanks = [
        {-1: outline.cut(outline.iso_flank(PITCH, 17, ROLLER, 0.5), 17, iso_outside(17), EDGE)},
        {-1: ansi, 4: outline.cut(flank, 21, (bottom + outside) / 2, EDGE)}
        | {5: outline.cut(flank, 21, bottom, EDGE)},
    ]
    half = chain.link_pitches / 2
    k = np.arange(links)
    on_front = (k % 2 == 0) & (k < links - 1)
    rng = np.random.default_rng(1)
    compared = 0
    for _ in range(40):
        q = simulation.positions.copy()
        q[:links] += rng.uniform(-1, 1, (links, 3)) * (2e-4, 2e-4, 0.02)
        q[links:, 2] += rng.uniform(-0.02, 0.02, 2)
        q[links:, 2] += 2 * np.pi * rng.integers(0, teeth) / teeth
        found = simulation.evaluate(positions=q).tooth_penetration
        arm = half * np.exp(1j * q[:links, 2])
        middle = q[:links, 0] + 1j * q[:links, 1]
        bushings = np.where(on_front, middle + arm, np.roll(middle - arm, -1))
        for s, sprocket in enumerate(drive.sprockets):
            x, y, angle = q[links + s]
            places = (bushings - (x + 1j * y)) * np.exp(-1j * angle)
            places -= sprocket.eccentricity * np.exp(1j * sprocket.eccentricity_angle)
            expected = outline.penetration(flanks[s], teeth[s], places, RADIUS)
            here = (expected > -1e-3) & (expected < 3e-4) & np.isfinite(found[:, s])
            bound = 60 * np.finfo(float).eps * np.max(np.abs(q))
            assert np.max(np.abs(found[here, s] - expected[here]), initial=0.0) <= bound
            assert np.max(expected[~np.isfinite(found[:, s])], initial=-1.0) < 0.0
            compared += np.count_nonzero(here)
    assert compared > 400


def test_a_gap_may_be_named():
    sprocket = rc.Sprocket(17, profile=rc.IsoTooth("maximum"))
    numbered = rc.Sprocket(17, profile=rc.IsoTooth(1.0))
    outlines = [_rustchain.tooth_outline(each, CHAIN, 9) for each in (sprocket, numbered)]
    assert np.array_equal(*outlines)
    with pytest.raises(rc.InvalidInput, match=r'IsoTooth.gap.*"minimum" or "maximum"'):
        rc.IsoTooth("medium")
    with pytest.raises(rc.InvalidInput, match=r"IsoTooth.gap"):
        rc.IsoTooth(1.5)


@pytest.mark.parametrize(
    ("profile", "faults"),
    [
        (rc.IsoTooth(0.3), {}),
        (rc.AnsiTooth(tip="cut"), {"damaged_teeth": ((2, 0.0), (9, 0.5))}),
        (rc.StraightTooth(0.4), {"eccentricity": 5e-5}),
    ],
    ids=["iso", "damaged", "eccentric"],
)
def test_a_drive_of_other_teeth_runs_with_a_closed_balance(profile, faults):
    """Over a gap's passage; the residual is 1e-3 of the dissipation with ANSI teeth."""
    drive = rc.two_sprocket_drive(CHAIN, (17, 21), links=46, profile=profile, pretension=50.0)
    first = replace(drive.sprockets[0], **faults)
    x, y = drive.sprockets[1].center
    second = replace(drive.sprockets[1], center=(x - 1e-4, y))
    drive = replace(
        drive, sprockets=(first, second), tensioner=replace(drive.tensioner, ramp_time=5e-3)
    )
    result = rc.Simulation(drive).run(duration=0.04, report_step=1e-3, progress=False)
    assert result.success
    energy = result.energy
    assert energy.dissipated[-1] > 1e-4
    assert np.max(np.abs(energy.residual)) < 0.02 * energy.dissipated[-1]
    regions = {int(r) for k in range(1, 47) for r in result.bushing(k).region}
    assert len(regions - {0}) >= 3


@pytest.mark.parametrize("room", [-2e-5, 0.0, 5e-5])
def test_a_seat_that_leaves_no_room_for_the_bushing_is_refused(room):
    tooth = rc.StraightTooth(flank_angle=0.3, seat_radius=(1.0 + room) * RADIUS)
    sprockets = [rc.Sprocket(17, profile=tooth), rc.Sprocket(17, (0.3, 0.0))]
    with pytest.raises(rc.InvalidInput, match=r"its radius must be at least|a seat wider than"):
        rc.chain_drive("ANSI 40", sprockets, adjust=2)


@pytest.mark.parametrize(
    ("profile", "says"),
    [
        (rc.StraightTooth(0.35, seat_radius=3.9e-3), r"StraightTooth\.seat_radius = 0\.0039: "),
        (
            rc.IsoTooth(roller_diameter=0.012),
            r"IsoTooth\.roller_diameter = 0\.012: leaves no tooth",
        ),
        (rc.StraightTooth(1.0), r"StraightTooth\.tip_diameter = None: .* even at the smallest"),
        (rc.StraightTooth(1.0, tip_diameter=0.073), r"StraightTooth\.tip_diameter = 0\.073: "),
    ],
)
def test_teeth_are_refused_by_the_field_that_is_given(profile, says):
    with pytest.raises(rc.InvalidInput, match=f"^{says}"):
        rc.two_sprocket_drive("ANSI 40", (17, 17), links=60, profile=profile)


def test_a_roller_below_the_limit_of_the_refusal_leaves_a_tip_above_the_pitch_circle():
    with pytest.raises(rc.InvalidInput, match=r"must be below") as refused:
        rc.Sprocket(17, profile=rc.IsoTooth(roller_diameter=0.012)).outline(CHAIN)
    limit = float(re.search(r"must be below ([\d.]+) m", str(refused.value))[1])
    # p (1 - 1.6/z)
    assert limit == pytest.approx(CHAIN.pitch * (1 - 1.6 / 17), abs=1e-6)
