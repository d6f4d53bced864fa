"""Drives of many sprockets in Python: geometry, choices, results, refusals."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rustchain as rc

PITCH = 0.0127


def four_sprockets(**keywords):
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(20.0)),
        rc.Sprocket(25, (0.35, -0.05)),
        rc.Sprocket(21, (0.25, 0.22)),
        rc.Sprocket(13, (0.092, 0.107), side="outside"),
    ]
    return rc.chain_drive("ANSI 40", sprockets, **keywords)


def pitch_radius(teeth):
    return PITCH / (2.0 * math.sin(math.pi / teeth))


def belt_pitches(circles):
    """Return the pitches of a taut chain round circles (x, y, signed teeth), by complex numbers.

    On the line from one centre to the next, the tangent leaves at the angle whose sine is the
    difference of the signed radii over the distance.
    """
    count = len(circles)
    directions, straight = [], 0.0
    for i, (x, y, teeth) in enumerate(circles):
        x2, y2, teeth2 = circles[(i + 1) % count]
        line = complex(x2 - x, y2 - y)
        r1, r2 = (math.copysign(pitch_radius(abs(n)), n) for n in (teeth, teeth2))
        straight += math.sqrt(abs(line) ** 2 - (r1 - r2) ** 2)
        directions.append(line / abs(line) * np.exp(1j * math.asin((r1 - r2) / abs(line))))
    seated = 0.0
    for i, (_, _, teeth) in enumerate(circles):
        turn = float(np.angle(directions[i] / directions[i - 1])) * math.copysign(1.0, teeth)
        seated += (turn % (2.0 * math.pi)) / (2.0 * math.pi) * abs(teeth)
    return straight / PITCH + seated


def test_the_belt_line_has_the_length_of_an_independent_formula():
    drive = four_sprockets()
    circles = [(*s.center, s.teeth if s.side == "inside" else -s.teeth) for s in drive.sprockets]
    report = drive.check()
    assert report.belt_pitches == pytest.approx(belt_pitches(circles), abs=1e-9)
    assert report.links == 2 * math.ceil(report.belt_pitches / 2.0)
    assert sum(report.wrap_pitches) + sum(report.strand_pitches) == report.links
    assert report.speed_ratios == pytest.approx((1.0, 17 / 25, 17 / 21, -17 / 13))
    turned = sum(
        w * (1 if s == "inside" else -1)
        for w, s in zip(report.belt_wrap_angle, report.sides, strict=True)
    )
    assert turned == pytest.approx(2.0 * math.pi)


def test_the_report_reads_as_a_table_of_all_sprockets():
    text = str(four_sprockets().check())
    assert "outside" in text
    assert "4-1" in text
    assert "sag [% of span]" in text
    for line in text.splitlines():
        assert not line.endswith(" ")


@pytest.mark.parametrize("adjust", [1, 2, 3, 4])
def test_a_moved_centre_makes_the_chain_taut(adjust):
    drive = four_sprockets(adjust=adjust)
    report = drive.check()
    # Seats start 1 um outside the pitch circles: 2 pi um over the loop, for each sprocket's share.
    assert max(np.abs(report.strand_slack)) < 2e-5
    assert report.hinge_stretch < 1e-6


def test_links_that_meet_the_teeth_are_refused_with_sprocket_value_and_remedies():
    blunt = rc.StraightTooth(0.1)  # [rad]: no room for a bushing that leaves along the strand
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(5.0)),
        rc.Sprocket(25, (0.4, 0.0), profile=blunt),
        rc.Sprocket(13, (0.2, 0.3)),
    ]
    drive = rc.chain_drive("ANSI 40", sprockets, adjust=1)
    said = (
        r"Chain\.links = 108, .* a bushing would start [\d.]+ um inside a tooth of sprocket 2; .* "
        r"take 110 links \(Chain\.links\), move .*\(Sprocket\.center\), .*\(Sprocket\.profile\)"
    )
    with pytest.raises(rc.InvalidInput, match=said):
        drive.check()
    wider = replace(sprockets[1], profile=rc.StraightTooth(0.2))
    rc.chain_drive("ANSI 40", [sprockets[0], wider, sprockets[2]], adjust=1).check()


def test_a_given_number_of_links_is_met_by_the_sprocket_that_moves():
    more = four_sprockets(links=104, adjust=2, direction=(1.0, 0.0))
    less = four_sprockets(links=100, adjust=2, direction=(1.0, 0.0))
    assert more.chain.links == 104
    assert more.sprockets[1].center[0] > less.sprockets[1].center[0] + PITCH
    assert more.sprockets[1].center[1] == -0.05
    with pytest.raises(rc.InvalidInput, match="suits 400 links"):
        four_sprockets(links=400, adjust=4)


def test_what_rounds_to_zero_is_printed_without_a_sign():
    drive = four_sprockets()
    report = replace(drive.check(), strand_slack=(-1e-18, 0.0, -0.002, 0.5), start_gap=-1e-12)
    text = str(report)
    (slack,) = (line.split()[2:] for line in text.splitlines() if line.startswith("slack"))
    assert slack == ["0.000", "0.000", "-2000.000", "500000.000"]
    assert "smallest gap at the start 0.000 um" in text


def test_a_report_has_lengths_in_millimetres_or_micrometres_and_angles_in_degrees():
    """No two rows have the same numbers; half a pitch of 12.7 mm, 2 % longer, is to spare."""
    drive = four_sprockets(adjust=2)
    drive = replace(drive, chain=replace(drive.chain, elongation=0.02))
    links, angles = drive.chain.links, [math.radians(k) for k in range(1, 5)]
    report = replace(
        drive.check(),
        belt_pitches=links - 0.5,
        hinge_stretch=1.5e-6,
        start_gap=2.5e-6,
        roller_play=3.5e-6,
        center_distance=0.25,
        closing_center_distance=0.26,
        pitch_radius=(0.01, 0.02, 0.03, 0.04),
        wrap_angle=tuple(angles),
        belt_wrap_angle=tuple(10 * angle for angle in angles),
        first_seat_angle=tuple(-angle for angle in angles),
        phase=tuple(0.1 * angle for angle in angles),
        strand_span=(0.1, 0.2, 0.3, 0.4),
        strand_slack=(1e-6, 2e-6, 3e-6, 4e-6),
        sag=(1e-3, 4e-3, 9e-3, 16e-3),
        guide_gap=(5e-3, 6e-3),
        guide_turn=(angles[0], 0.0),
        guide_travel=((7e-3, 8e-3), (0.0, 0.0)),
        guide_bushings=(3, 5),
        guide_place=("strand 1-2", "sprocket 1"),
    )
    rows = dict(report.rows())
    expected = {
        "chain": f"{links} links of 12.7000 mm",
        "  taut": f"{links - 0.5:.4f} pitches; 6.477 mm to spare",
        "play of the rollers": "3.500 um",
        "centre distance": "250.000000 mm",
        "  taut and straight at": "260.000000 mm",
        "hinge stretch": "1.500 um",
        "smallest gap at the start": "2.500 um",
        "pitch radius [mm]": ("10.0000", "20.0000", "30.0000", "40.0000"),
        "wrap of these [deg]": ("1.000", "2.000", "3.000", "4.000"),
        "wrap of the belt [deg]": ("10.000", "20.000", "30.000", "40.000"),
        "first seat at [deg]": ("-1.000000", "-2.000000", "-3.000000", "-4.000000"),
        "phase [deg]": ("0.100000", "0.200000", "0.300000", "0.400000"),
        "span [mm]": ("100.0000", "200.0000", "300.0000", "400.0000"),
        "slack [um]": ("1.000", "2.000", "3.000", "4.000"),
        "sag [mm]": ("1.0000", "4.0000", "9.0000", "16.0000"),
        "sag [% of span]": ("1.00", "2.00", "3.00", "4.00"),
        "gap to the chain [mm]": ("5.0000", "6.0000"),
        "bushings along it": ("3", "5"),
        "arm swung by [deg]": ("1.000", ""),
        "plunger to inner stop [mm]": ("7.000", ""),
        "plunger to outer stop [mm]": ("8.000", ""),
        "at": ("1-2", "sprocket 1"),
    }
    assert {name: rows[name] for name in expected} == expected
    assert report.speed_ratio == pytest.approx(17 / 25)


def test_strands_have_names_numbers_and_a_tension():
    result = rc.Simulation(four_sprockets(adjust=2)).run(
        duration=0.004, report_step=1e-3, record=["hinges", "sprockets", "bodies", "energy"]
    )
    assert result.strand_names == ("1-2", "2-3", "3-4", "4-1")
    assert np.array_equal(result.strand(3).tension, result.strand("3-4").tension)
    assert result.arrays["strand_tension"].shape == (5, 4)
    assert result.sprocket(4).speed[0] < 0.0
    with pytest.raises(rc.InvalidInput, match="did you mean '2-3'"):
        result.strand("1-3")
    with pytest.raises(IndexError):
        result.strand(5)
    assert list(result.to_xarray()["strand"].values) == ["1-2", "2-3", "3-4", "4-1"]
    result.plot.drive()
    result.plot.tension()


def test_a_strand_has_the_tension_of_its_hinges_beside_a_wrap_of_more_than_half_a_turn():
    idler = rc.Sprocket(15, center=(0.2, -0.045), motion=rc.Free(), side="outside")
    drive = rc.chain_drive(
        rc.catalogue_chain("ISO 08B", 94),
        [
            rc.Sprocket(19, motion=rc.PrescribedSpeed(0.0)),
            idler,
            rc.Sprocket(38, center=(0.4, 0.0), motion=rc.AppliedTorque(-20.0)),
        ],
        tensioner=rc.Tensioner(80.0, sprocket=2, direction=(0.0, 1.0), stiffness=2000.0),
        gravity=(0.0, 0.0),
    )
    simulation = rc.Simulation(drive, start="static")
    result = simulation.run(
        duration=2e-4, report_step=1e-4, record=["hinges", "sprockets", "bodies"]
    )
    # Links 17, 35 and 81 are in the middle of the strands.
    assert result.strand_names == ("1-2", "2-3", "3-1")
    middle = result.link_tension().values[0][[16, 34, 80]]
    tensions = [result.strand(name).tension[0] for name in result.strand_names]
    assert tensions == pytest.approx(middle, rel=0.01)
    assert middle[2] - middle[1] == pytest.approx(20.0 / (6.35e-3 / np.sin(np.pi / 38)), rel=0.01)


def test_two_sprockets_keep_their_strands_and_have_numbers_too():
    result = rc.Simulation(rc.paper_drive()).run(duration=1e-3, report_step=5e-4)
    assert result.strand_names == ("upper", "lower")
    assert np.array_equal(result.strand(1).tension, result.strand("upper").tension)


def test_a_static_start_rests_under_its_loads_and_has_the_tension_it_is_asked_for():
    drive = four_sprockets()
    drive = replace(drive, gravity=(0.0, 0.0), tensioner=rc.Tensioner(60.0, sprocket=4))
    held = replace(drive.sprockets[0], motion=rc.PrescribedSpeed(0.0))
    drive = replace(drive, sprockets=(held, *drive.sprockets[1:]))
    simulation = rc.Simulation(drive, start="static")
    assert simulation.rest["residual"] <= 1e-6 * simulation.rest["largest_force"]
    result = simulation.run(duration=0.002, report_step=1e-3)
    for name in result.strand_names:
        assert result.strand(name).tension == pytest.approx(60.0, abs=4.0)
    with pytest.raises(rc.InvalidInput, match="start"):
        rc.Simulation(drive, start="rest")


def test_elongations_of_each_link_count_for_the_links_that_are_there():
    links = four_sprockets().chain.links
    chain = rc.catalogue_chain("ANSI 40", links)
    sprockets = four_sprockets().sprockets
    worn = [0.001 * (k % 3) for k in range(links)]
    drive = rc.chain_drive(replace(chain, elongation=worn), sprockets)
    assert drive.chain.links == links
    assert drive.chain.elongation == tuple(worn)
    few = replace(chain, links=60, elongation=worn[:60])
    with pytest.raises(rc.InvalidInput, match=f"60 numbers: .* each of the {links} links"):
        rc.chain_drive(few, sprockets)


@pytest.mark.parametrize("away", [0.0, 1e3])
def test_a_spread_that_the_clearances_take_lays_a_taut_chain_round_many_sprockets(away):
    sprockets = [
        replace(s, center=(s.center[0] + away, s.center[1])) for s in four_sprockets().sprockets
    ]
    drive = rc.chain_drive("ANSI 40", sprockets, adjust=3)
    clearance, pitch = drive.chain.hinge.clearance, drive.chain.pitch
    for share in (1e-6, 1e-3, 0.1):
        for seed in range(5):
            worn = replace(drive.chain, pitch_spread=share * clearance / pitch, seed=seed)
            report = replace(drive, chain=worn).check()
            assert report.wrap_pitches == drive.check().wrap_pitches
            assert report.hinge_stretch < 0.9 * clearance


def test_a_chain_whose_links_press_into_teeth_is_not_told_to_take_as_many():
    links = four_sprockets().chain.links
    chain = replace(rc.catalogue_chain("ANSI 40", links), pitch_spread=5e-3)
    drive = rc.chain_drive(chain, four_sprockets().sprockets)
    with pytest.raises(rc.InvalidInput, match=r"Chain\.pitch_spread or Chain\.e") as caught:
        drive.check()
    assert f"take {drive.chain.links} links" not in str(caught.value)


BAD = {
    "side": (lambda: rc.Sprocket(17, side="out"), "side"),
    "all but one outside": (
        lambda: rc.ChainDrive(
            four_sprockets().chain,
            [rc.Sprocket(17), rc.Sprocket(17, (0.2, 0.0), side="outside")],
        ),
        "inside the chain",
    ),
    "load inertia": (lambda: rc.Sprocket(17, load_inertia=-1.0), "load_inertia"),
    "falling speeds": (
        lambda: rc.AppliedTorque(curve=((10.0, 1.0), (0.0, 2.0))),
        "speeds must increase",
    ),
    "travel": (lambda: rc.Tensioner(10.0, travel=(-1.0, 1.0)), "travel"),
    "pivot and direction": (
        lambda: rc.Tensioner(10.0, pivot=(0.0, 0.0), direction=(1.0, 0.0)),
        "direction",
    ),
    "a pull that slackens": (
        lambda: replace(
            four_sprockets(), tensioner=rc.Tensioner(10.0, sprocket=4, direction=(-1.0, 1.0))
        ).check(),
        "must tighten",
    ),
    "adjust": (lambda: four_sprockets(adjust=7), "adjust = 7"),
    "adjust as text": (lambda: four_sprockets(adjust="2"), "adjust = '2': must be the number"),
    "adjust as a float": (lambda: four_sprockets(adjust=2.0), "adjust = 2.0: must be the number"),
    "direction alone": (lambda: four_sprockets(direction=(1.0, 0.0)), "no sprocket to adjust"),
    "too short": (lambda: four_sprockets(links=96).check(), "mm too short"),
    "wrong order": (
        lambda: replace(
            four_sprockets(), sprockets=[four_sprockets().sprockets[i] for i in (0, 1, 3, 2)]
        ).check(),
        "1, 2, 4, 3 would do",
    ),
    "side of an idler": (
        lambda: crossed("outside").check(),
        r"strands 1-3 and 2-1 cross: give sprocket 3 side=\"inside\" \(it has",
    ),
}


def crossed(side):
    wheels = rc.Sprocket(17), rc.Sprocket(17, (0.4, 0.0))
    return rc.chain_drive("ANSI 40", [*wheels, rc.Sprocket(13, (0.2, 0.1), side=side)])


def test_the_proposed_side_of_a_crossing_chain_has_a_layout():
    assert crossed("inside").check()


def refusal(sprockets):
    """Return the text of the refusal of a drive; empty for none."""
    try:
        rc.chain_drive("ANSI 40", sprockets)
    except rc.InvalidInput as error:
        return str(error)
    return ""


def test_every_proposed_order_and_side_has_a_chain_path():
    rng = np.random.default_rng(1)
    proposals = {"order": 0, "side": 0}
    for _ in range(300):
        sprockets = [
            rc.Sprocket(
                int(rng.integers(9, 30)),
                tuple(rng.uniform(0.0, 0.4, 2)),
                side="outside" if i > 0 and rng.random() < 0.3 else "inside",
            )
            for i in range(rng.integers(3, 6))
        ]
        text = refusal(sprockets)
        order = re.search(r": ([\d, ]+) would do", text)
        side = re.search(r"sprocket (\d) stands where .* it (\w+);", text)
        side = side or re.search(r'give sprocket (\d) side="(\w+)"', text)
        if order:
            sprockets = [sprockets[int(i) - 1] for i in order[1].split(", ")]
        elif side:
            i = int(side[1]) - 1
            sprockets[i] = replace(sprockets[i], side=side[2])
        else:
            continue
        proposals["order" if order else "side"] += 1
        assert "no chain path" not in refusal(sprockets), text
    assert proposals["order"] > 3
    assert proposals["side"] > 10


@pytest.mark.parametrize("case", BAD)
def test_what_does_not_hold_is_refused_by_name(case):
    build, text = BAD[case]
    with pytest.raises(ValueError, match=text):
        build()


@pytest.mark.parametrize("turn", range(20, 30))
def test_eccentric_teeth_between_two_ways_to_lie_are_laid(turn):
    drive = four_sprockets()
    third = replace(drive.sprockets[2], eccentricity=3e-4, eccentricity_angle=0.0523 * turn)
    drive = replace(drive, sprockets=(*drive.sprockets[:2], third, drive.sprockets[3]))
    simulation = rc.Simulation(drive)
    assert np.max(simulation.evaluate().tooth_penetration) < 0.0
    # What was laid round are the teeth where the start has them.
    angle = simulation.positions[-2, 2] + third.eccentricity_angle
    teeth = np.array(third.center) + 3e-4 * np.array([math.cos(angle), math.sin(angle)])
    q = simulation.positions[: drive.chain.links]
    front = q[:, :2] + 0.5 * PITCH * np.stack([np.cos(q[:, 2]), np.sin(q[:, 2])], axis=1)
    radii = np.sort(np.hypot(*(front - teeth).T))[:4]
    assert np.ptp(radii) < 2e-6


@st.composite
def layouts(draw):
    """Return sprockets on a circle, far enough apart, turned anyhow."""
    count = draw(st.integers(3, 5))
    teeth = [draw(st.integers(9, 30)) for _ in range(count)]
    radius = draw(st.floats(0.35, 0.7))
    tilt = draw(st.floats(-3.0, 3.0))
    angles = [tilt + 2.0 * math.pi * k / count for k in range(count)]
    return [
        rc.Sprocket(
            n,
            (radius * math.cos(a), radius * math.sin(a)),
            rc.PrescribedSpeed(12.0) if k == 0 else rc.Free(),
        )
        for k, (n, a) in enumerate(zip(teeth, angles, strict=True))
    ]


@given(layouts(), st.integers(0, 1))
@settings(max_examples=25)
def test_any_layout_starts_closed_and_free_of_contact(sprockets, pairs):
    drive = rc.chain_drive("ANSI 40", sprockets)
    drive = replace(drive, chain=replace(drive.chain, links=drive.chain.links + 2 * pairs))
    simulation = rc.Simulation(drive)
    e = simulation.evaluate()
    assert np.max(e.hinge_penetration) < 0.0
    assert np.max(e.tooth_penetration) < 0.0
    n = drive.chain.links
    q = simulation.positions[:n]
    half = 0.5 * PITCH * np.stack([np.cos(q[:, 2]), np.sin(q[:, 2])], axis=1)
    opening = np.hypot(*(q[:, :2] + half - np.roll(q[:, :2] - half, -1, axis=0)).T)
    assert np.max(opening) <= drive.check().hinge_stretch + 1e-12


PAIR = (rc.Sprocket(17, motion=rc.PrescribedSpeed(12.0)), rc.Sprocket(25, (0.4, 0.0)))


def test_the_length_of_a_direction_does_not_count():
    centers = [
        rc.chain_drive("ANSI 40", PAIR, links=86, adjust=2, direction=direction).sprockets[1].center
        for direction in ((1.0, 0.1), (5.0, 0.5), (-0.2, -0.02))
    ]
    assert centers[0][0] > 0.41
    np.testing.assert_allclose(centers[1:], [centers[0]] * 2, rtol=1e-12)


def test_without_a_reach_a_centre_moves_by_at_most_a_thousand_pitches():
    """Each pitch of the move takes two links; 80 close round the first place, 31.5 pitches away."""
    pair = (PAIR[0], rc.Sprocket(17, (0.4, 0.0)))
    moved = rc.chain_drive("ANSI 40", pair, links=2078, adjust=2).sprockets[1].center[0]
    assert 0.4 + 999 * PITCH - 1e-9 < moved < 0.4 + 1000 * PITCH
    with pytest.raises(rc.InvalidInput, match=r"suits 2082 links: .* to 12700\.000 mm"):
        rc.chain_drive("ANSI 40", pair, links=2082, adjust=2)
    farther = rc.chain_drive("ANSI 40", pair, links=2082, adjust=2, reach=1001.5 * PITCH)
    assert farther.sprockets[1].center[0] == pytest.approx(moved + 2 * PITCH, abs=1e-9)


def test_a_centre_moves_up_to_the_reach_also_within_the_last_half_pitch():
    moved = rc.chain_drive("ANSI 40", PAIR, links=86, adjust=2).sprockets[1].center[0] - 0.4
    assert 1.5 * PITCH / 2 < moved < 2 * PITCH / 2
    near = rc.chain_drive("ANSI 40", PAIR, links=86, adjust=2, reach=moved + 5e-5)
    assert near.sprockets[1].center[0] - 0.4 == pytest.approx(moved, abs=1e-11)
    with pytest.raises(rc.InvalidInput, match=r"from -12\.400 mm to 12\.400 mm along it"):
        rc.chain_drive("ANSI 40", PAIR, links=86, adjust=2, reach=0.0124)


def test_an_offset_link_needs_an_odd_number_of_links_to_be_given():
    chain = replace(rc.catalogue_chain("ANSI 40", 85), offset=rc.Link(8e-3, 2e-7))
    with pytest.raises(rc.InvalidInput, match=r"^links = None: even numbers .* Chain\.offset$"):
        rc.chain_drive(chain, PAIR)
    assert rc.chain_drive(chain, PAIR, links=85, adjust=2).chain.links == 85


def test_links_of_different_elongation_are_counted_by_their_mean_and_keep_their_own():
    made = rc.catalogue_chain("ANSI 40", 100)
    links = rc.chain_drive(replace(made, elongation=0.02), PAIR).chain.links
    assert links < rc.chain_drive(made, PAIR).chain.links
    each = (0.01, 0.03) * (links // 2)
    worn = replace(made, links=links, elongation=each)
    assert rc.chain_drive(worn, PAIR).chain == worn
    assert rc.chain_drive(worn, PAIR, links=links, adjust=2).chain == worn


def test_a_report_with_eccentric_teeth_is_of_the_places_as_described():
    centered = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(20.0)),
        rc.Sprocket(25, (0.41, 0.0), rc.AppliedTorque(-2.0)),
    ]
    tensioner = rc.Tensioner(60.0, stiffness=2e4)
    expected = rc.chain_drive("ANSI 40", centered, tensioner=tensioner).check()
    eccentric = [replace(centered[0], eccentricity=1e-3), centered[1]]
    found = rc.chain_drive("ANSI 40", eccentric, tensioner=tensioner).check()
    assert found.tension_force == expected.tension_force
    assert found.center_distance == pytest.approx(0.41, abs=1e-15)
    assert found.belt_pitches == expected.belt_pitches


@pytest.mark.parametrize(("end", "warned"), [(40.0, True), (40.0 * 17 / 25, False)])
def test_ramps_of_two_motors_that_do_not_agree_are_warned_of(end, warned):
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed([(0.0, 0.0), (0.02, 40.0)])),
        rc.Sprocket(25, (0.35, 0.0), rc.PrescribedSpeed(rc.Table([(0.0, 0.0), (0.02, end)]))),
    ]
    told = " ".join(rc.chain_drive("ANSI 40", sprockets).check().warnings)
    assert ("have 10.0000 and 10.0000 rad/s at 0.005 s" in told) is warned
    assert ("different speeds" in told) is warned


@pytest.mark.parametrize(("frequency", "warned"), [(100.0, False), (101.0, True), (0.0, True)])
def test_sines_of_two_motors_that_do_not_agree_later_are_warned_of(frequency, warned):
    def motor(teeth, frequency):
        terms = [(2.0 / teeth, frequency, 0.0)] if frequency else []
        return rc.PrescribedSpeed(rc.Sines(terms, offset=170.0 / teeth))

    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), motor(17, 100.0)),
        rc.Sprocket(25, (0.35, 0.0), motor(25, frequency)),
    ]
    told = " ".join(rc.chain_drive("ANSI 40", sprockets).check().warnings)
    assert ("which move the chain at different speeds" in told) is warned


def test_a_sine_beside_the_same_speed_as_a_table_is_no_reason_for_a_warning():
    time = np.linspace(0.0, 2.0, 2001)
    rows = np.column_stack([time, (170.0 + 5.0 * np.sin(30.0 * time)) / 25.0])
    sines = rc.Sines([(5.0 / 17.0, 30.0, 0.0)], offset=10.0)
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(sines)),
        rc.Sprocket(25, (0.35, 0.0), rc.PrescribedSpeed(rc.Table(rows.tolist()))),
    ]
    assert "speeds" not in " ".join(rc.chain_drive("ANSI 40", sprockets).check().warnings)


def test_the_length_to_spare_of_a_worn_chain_is_that_of_its_links():
    chain = replace(rc.catalogue_chain("ANSI 40", 86), elongation=0.02)
    sprockets = [rc.Sprocket(17, (0.0, 0.0)), rc.Sprocket(25, (0.4, 0.0))]
    report = rc.chain_drive(chain, sprockets).check()
    spare = 1e3 * (report.links - report.belt_pitches) * 1.02 * PITCH
    assert spare > 0.0
    assert f"{spare:.3f} mm to spare" in str(report)
