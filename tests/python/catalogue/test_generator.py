"""The generated start: the paper's to its last digits, and others that nothing touches."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import rustchain as rc
from reference.dynamics import DriveEquations
from reference.generator import paper_start
from reference.geometry import pitch_radius

DATA = Path(__file__).parents[2] / "data" / "paper_start.csv"
LN = rc.LankaraniNikravesh()
PITCH = 0.0127
PAPER = rc.paper_drive().chain

LENGTH = 1e-14  # [m]
ANGLE = LENGTH / (0.5 * PITCH)  # turns a link's end by LENGTH
SPEED = 1e-13  # LENGTH at 4 pi rad/s
RATE = SPEED / (0.5 * PITCH)


@pytest.fixture(scope="module")
def published():
    """Rows of paper_start.csv: x, y, theta, and their rates."""
    return np.genfromtxt(DATA, delimiter=",", skip_header=1, usecols=range(2, 8))


def same_angle(one, other):
    return np.abs(np.angle(np.exp(1j * (np.asarray(one) - np.asarray(other)))))


def test_the_reference_reproduces_the_published_start(published):
    start = paper_start()
    assert np.max(np.abs(start.links[:, :2] - published[:, :2])) <= 1e-16
    assert np.max(same_angle(start.links[:, 2], published[:, 2])) <= 1e-14
    assert np.max(np.abs(start.link_rates[:, :2] - published[:, 3:5])) <= 1e-15
    assert np.max(np.abs(start.link_rates[:, 2] - published[:, 5])) <= 1e-13
    assert start.center_distance == pytest.approx(0.133348698813, abs=5e-13)
    assert start.eps == pytest.approx(0.0924007, abs=5e-8)
    assert np.degrees(start.first_seats) == pytest.approx([89.999948194, -89.999948194], abs=5e-10)


@pytest.mark.parametrize("pretension", [0.0, 25.0])
def test_paper_drive_starts_as_published(pretension, published):
    drive = rc.paper_drive(pretension=pretension)
    simulation = rc.Simulation(drive)
    start = paper_start()
    links = [f"link_{i}" for i in range(1, 39)]
    assert simulation.body_names == [*links, "sprocket_1", "sprocket_2"]
    assert simulation.time == 0.0
    q, v = simulation.positions, simulation.velocities
    for expected, rates in (
        (published[:, :3], published[:, 3:]),
        (start.links, start.link_rates),
    ):
        assert np.max(np.abs(q[:38, :2] - expected[:, :2])) <= LENGTH
        assert np.max(same_angle(q[:38, 2], expected[:, 2])) <= ANGLE
        assert np.max(np.abs(v[:38, :2] - rates[:, :2])) <= SPEED
        assert np.max(np.abs(v[:38, 2] - rates[:, 2])) <= RATE
    assert_allclose(q[38:, :2], [[0.0, 0.0], [start.center_distance, 0.0]], rtol=0.0, atol=LENGTH)
    # A gap centre under each seated hinge; which gap is 0 does not matter to the physics.
    step = 2.0 * np.pi / 17
    assert np.max(same_angle(17 * q[38:, 2], 17 * start.sprocket_angles)) / 17 <= ANGLE
    assert np.all(np.abs(q[38:, 2]) <= 0.5 * step)
    assert_allclose(v[38:], [[0.0, 0.0, 4.0 * np.pi]] * 2, rtol=1e-15)


def test_the_report_of_paper_drive_says_what_was_chosen():
    report = rc.paper_drive(pretension=25.0).check()
    start = paper_start()
    assert report.links == 38
    assert tuple(report.teeth) == (17, 17)
    assert tuple(report.wrap_pitches) == (8, 9)
    assert tuple(report.strand_pitches) == (10, 11)
    assert report.center_distance == pytest.approx(start.center_distance, abs=LENGTH)
    assert report.closing_center_distance == pytest.approx(start.center_distance, abs=LENGTH)
    assert report.first_seat_angle == pytest.approx(start.first_seats, abs=ANGLE)
    assert report.phase == pytest.approx(start.sprocket_angles, abs=ANGLE)
    assert report.pitch_radius == pytest.approx([0.03455791381362397] * 2, abs=LENGTH)
    assert report.strand_slack == pytest.approx([0.0, 0.0], abs=LENGTH)
    assert report.tension_force == pytest.approx(50.0)
    assert report.speed_ratio == pytest.approx(1.0)


# Name: keywords of two_sprocket_drive; how far sprocket 2 then comes inward [m].
CASES = {
    "equal, even wrap": ({"teeth": (17, 17), "links": 38}, 0.0),
    "equal, other wrap": ({"teeth": (18, 18), "links": 44}, 0.0),
    "reduction": ({"teeth": (17, 25), "links": 60}, 0.0),
    "increase": ({"teeth": (25, 17), "links": 60}, 0.0),
    "odd sum": ({"teeth": (19, 32), "links": 72}, 0.0),
    "large ratio": ({"teeth": (11, 60), "links": 120}, 0.0),
    "small": ({"teeth": (9, 9), "links": 24}, 0.0),
    "large": ({"teeth": (60, 60), "links": 180}, 0.0),
    "by distance": ({"teeth": (17, 25), "center_distance": 0.31}, 0.0),
    "by distance, equal": ({"teeth": (21, 21), "center_distance": 0.25}, 0.0),
    "turning back": ({"teeth": (17, 25), "links": 60, "speed": -12.566}, 0.0),
    "at rest": ({"teeth": (17, 25), "links": 60, "speed": 0.0}, 0.0),
    "slack of a tenth": ({"teeth": (17, 25), "links": 60}, 1e-4),
    "slack of a millimetre": ({"teeth": (17, 17), "links": 38}, 1e-3),
    "slack upwards": ({"teeth": (17, 25), "links": 60, "gravity": (0.0, 9.81)}, 1e-3),
    "ANSI 80": ({"chain": "ANSI 80", "teeth": (15, 40), "links": 80}, 0.0),
    "ANSI 25": ({"chain": "ANSI 25", "teeth": (24, 36), "links": 90}, 2e-4),
}


@pytest.mark.parametrize("seat", ["bottom-diameter", "pitch-circle"])
@pytest.mark.parametrize("case", CASES)
def test_a_generated_start_is_free_of_contact_and_consistent(case, seat):
    keywords, inward = CASES[case]
    drive = rc.two_sprocket_drive(**keywords, seat=seat)
    if inward:
        x, y = drive.sprockets[1].center
        drive = replace(
            drive,
            sprockets=[drive.sprockets[0], replace(drive.sprockets[1], center=(x - inward, y))],
        )
    simulation = rc.Simulation(drive)
    q, v = simulation.positions, simulation.velocities
    n, p = drive.chain.links, drive.chain.pitch
    equations = DriveEquations(drive, LN, LN)
    kin = equations.kinematics(q, v)

    # Nothing touches, on either side's reckoning; hinges are within their clearances.
    e = simulation.evaluate()
    for hinges, teeth in (
        (kin.hinge_penetration, kin.tooth_penetration),
        (e.hinge_penetration, e.tooth_penetration),
    ):
        assert np.max(hinges) < 0.0
        assert np.max(teeth) < 0.0
    assert not np.any(e.hinge_force)
    assert not np.any(e.tooth_force)
    assert np.max(kin.hinge_penetration) <= -1e-7, "a hinge is within 0.1 um of its clearance"
    assert np.max(kin.tooth_penetration) <= -0.9e-6, "a bushing is within 0.9 um of a tooth"

    # The chain goes round, once and counterclockwise, outside both wheels' seats.
    following = (np.arange(n) + 1) % n
    hinge = 0.5 * (kin.front + kin.rear[following])
    x, y = hinge.T
    assert 0.5 * np.sum(x * y[following] - y * x[following]) > 0.0
    turns = np.angle(np.exp(1j * (q[following, 2] - q[:n, 2])))
    assert np.sum(turns) == pytest.approx(2.0 * np.pi, abs=1e-9)
    for s, sprocket in enumerate(drive.sprockets):
        radius = pitch_radius(p, sprocket.teeth)
        distance = np.hypot(*(hinge - q[n + s, :2]).T)
        assert np.min(distance) >= radius - 2e-4 * p / PITCH
        tip = 0.5 * p * (0.6 + 1.0 / np.tan(np.pi / sprocket.teeth))
        # No link cuts through the wheel: the line between its hinges stays above the roots.
        middle = np.hypot(*(q[:n, :2] - q[n + s, :2]).T)
        assert np.min(middle) >= radius * np.cos(np.pi / sprocket.teeth) - 2e-4 * p / PITCH
        # A fair share of the hinges is seated.
        assert np.sum(distance < tip) >= 0.25 * sprocket.teeth

    # Hinge 1 lies in the driver's first seat, on its upper side; the strands lean the right way.
    assert hinge[0, 1] > 0.0
    assert np.hypot(*hinge[0]) == pytest.approx(
        pitch_radius(p, drive.sprockets[0].teeth), abs=3e-5 * p / PITCH
    )

    # Velocities: sprockets by the tooth ratio, seated links with their sprocket, hinges together.
    speed = keywords.get("speed", 12.566)
    ratio = drive.sprockets[0].teeth / drive.sprockets[1].teeth
    assert v[n, 2] == pytest.approx(speed)
    assert v[n + 1, 2] == pytest.approx(speed * ratio, rel=0.02, abs=1e-12)
    chain_speed = abs(speed) * pitch_radius(p, drive.sprockets[0].teeth)
    # A strand's first link cannot follow both its ends: the strand's length changes at the rate
    # of the polygon effect, a few thousandths of the speed.
    closing = np.abs(kin.tooth_rate[kin.tooth_penetration > -2e-6])
    assert np.all(closing <= 0.01 * chain_speed + 1e-12)
    half = 0.5 * p * np.stack([-np.sin(q[:n, 2]), np.cos(q[:n, 2])], axis=1) * v[:n, 2:]
    front, rear = v[:n, :2] + half, v[:n, :2] - half
    parting = np.hypot(*(front - rear[following]).T)
    assert np.max(parting) <= 0.01 * chain_speed + 1e-12
    assert np.max(np.abs(np.hypot(*v[:n, :2].T) - chain_speed)) <= 0.1 * chain_speed + 1e-12


def numbers(message):
    return [float(text) for text in re.findall(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?", str(message))]


def refusal(build):
    with pytest.raises(ValueError, match=r"\d") as caught:
        rc.Simulation(build())
    return caught.value


def works(build):
    try:
        rc.Simulation(build())
    except ValueError:
        return False
    return True


def shifted(drive, shift):
    x, y = drive.sprockets[1].center
    far = replace(drive.sprockets[1], center=(x + shift, y))
    return replace(drive, sprockets=[drive.sprockets[0], far])


def hinge_openings(drive, positions):
    """How far the ends of neighbouring links are apart, each link with its own length."""
    links = positions[: drive.chain.links]
    arm = drive.chain.link_pitches / 2 * np.exp(1j * links[:, 2])
    middle = links[:, 0] + 1j * links[:, 1]
    return np.abs(middle + arm - np.roll(middle - arm, -1))


@pytest.mark.parametrize("links", [39, 61])
def test_an_odd_number_of_links_ends_in_an_offset_link(links):
    drive = rc.two_sprocket_drive(chain=PAPER, teeth=(17, 17), links=links)
    simulation = rc.Simulation(drive)
    found = simulation.evaluate()
    assert np.max(hinge_openings(drive, simulation.positions)) < drive.chain.hinge.clearance
    assert np.max(found.tooth_penetration) < 0.0
    # Nothing touches: every link falls freely, the offset one too.
    assert_allclose(found.accelerations[:links, 1], -9.81, rtol=1e-14)
    given = replace(drive.chain, offset=rc.Link(mass=1e-2, inertia=2e-7))
    mean = [(getattr(PAPER.inner, q) + getattr(PAPER.outer, q)) / 2 for q in ("mass", "inertia")]
    heavier = rc.Simulation(replace(drive, chain=given))
    pushed = simulation.positions.copy()
    pushed[-3, 0] += 1e-4
    for sim, mass in ((simulation, mean[0]), (heavier, 1e-2)):
        e = sim.evaluate(positions=pushed)
        force = mass * (e.accelerations[links - 1, :2] - (0.0, -9.81))
        assert np.hypot(*force) > 1.0
        others = e.accelerations[: links - 1, :2] - (0.0, -9.81)
        k = np.arange(links - 1)
        masses = np.where(k % 2 == 0, PAPER.inner.mass, PAPER.outer.mass)
        teeth = np.array(e.tooth_force).sum()
        if teeth == 0.0:  # forces between links cancel
            total = force + (masses[:, None] * others).sum(axis=0)
            assert np.hypot(*total) < 1e-9 * np.hypot(*force)


def test_strands_multiply_masses_and_contacts():
    one = rc.two_sprocket_drive(chain=PAPER, teeth=(17, 17), links=38)
    three = replace(one, chain=replace(one.chain, strands=3))
    law = rc.Johnson(damping=None)  # a law in which the length of contact counts
    single, triple = (rc.Simulation(drive, law) for drive in (one, three))
    q = single.positions.copy()
    rng = np.random.default_rng(2)
    q[:38] += rng.uniform(-1, 1, (38, 3)) * (3e-5, 3e-5, 1e-3)
    a, b = single.evaluate(positions=q), triple.evaluate(positions=q)
    assert np.max(a.hinge_force) > 1.0
    assert_allclose(b.hinge_force, 3 * a.hinge_force, rtol=1e-9)
    assert_allclose(b.tooth_force, 3 * a.tooth_force, rtol=1e-9)
    assert_allclose(b.accelerations[:38], a.accelerations[:38], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "variation",
    [
        {"elongation": 0.01},
        {"elongation": -0.0005},
        {"pitch_spread": 5e-5, "seed": 4},
        {"elongation": 0.005, "pitch_spread": 1e-4, "seed": 9},
        {"elongation": tuple(0.002 + 0.001 * (k % 3) for k in range(60))},
    ],
    ids=str,
)
def test_links_of_other_lengths_are_laid_with_closed_hinges_and_free_teeth(variation):
    drive = rc.two_sprocket_drive(chain=replace(PAPER, links=60, **variation), teeth=(17, 25))
    simulation = rc.Simulation(drive)
    pitches = drive.chain.link_pitches
    assert drive.chain.mean_pitch == pytest.approx(np.mean(pitches), rel=1e-14)
    assert np.max(hinge_openings(drive, simulation.positions)) < 0.9 * drive.chain.hinge.clearance
    assert np.max(simulation.evaluate().tooth_penetration) < 0.0
    nominal = rc.two_sprocket_drive(chain=replace(PAPER, links=60), teeth=(17, 25))
    longer = np.sum(pitches) - 60 * PITCH
    moved = drive.sprockets[1].center[0] - nominal.sprockets[1].center[0]
    # Two strands share what the wraps, which grow with the pitch, leave over.
    wraps = 2 * np.pi * (pitch_radius(PITCH, 17) + pitch_radius(PITCH, 25)) / 2
    assert moved == pytest.approx((longer - wraps * longer / (60 * PITCH)) / 2, rel=0.05, abs=2e-6)


def test_a_spread_too_large_for_a_taut_chain_is_refused_and_fits_a_slack_one():
    chain = replace(PAPER, links=60, pitch_spread=2e-3, seed=4)
    drive = rc.two_sprocket_drive(chain=chain, teeth=(17, 25))
    error = refusal(lambda: drive)
    assert "a tooth of sprocket" in str(error) or "would open" in str(error)
    slack = shifted(replace(drive, chain=replace(chain, pitch_spread=4e-4)), -5e-4)
    assert np.max(rc.Simulation(slack).evaluate().tooth_penetration) < 0.0
    assert np.max(hinge_openings(slack, rc.Simulation(slack).positions)) < 2.3e-5


@pytest.mark.parametrize(
    ("name", "teeth", "links"),
    [("ANSI 60", (55, 31), 182), ("ISO 06B", (17, 36), 174), ("ANSI 40", (19, 38), 120)],
)
def test_a_spread_of_nanometres_leaves_the_chain_where_the_nominal_one_is(name, teeth, links):
    drive = rc.two_sprocket_drive(name, teeth, links=links)
    nominal, report = rc.Simulation(drive).positions, drive.check()
    for seed in range(20):
        worn = replace(drive, chain=replace(drive.chain, pitch_spread=1e-7, seed=seed))
        assert worn.check().wrap_pitches == report.wrap_pitches
        moved = np.linalg.norm((rc.Simulation(worn).positions - nominal)[:, :2], axis=1)
        # Five standard deviations of the sum of `links` deviations of 1e-7 pitches, by which a
        # straight strand may bow.
        length = 5e-7 * np.sqrt(links) * drive.chain.pitch
        assert np.max(moved) < length + np.sqrt(0.375 * max(report.strand_span) * length)


def test_a_spread_is_refused_only_where_the_nominal_chain_is_or_clearances_are_used_up():
    draw = np.random.default_rng(17)
    names, laid = list(rc.chain_sizes()), 0
    while laid < 30:
        teeth = tuple(int(n) for n in draw.integers(11, 60, 2))
        chain = rc.catalogue_chain(draw.choice(names), int(sum(teeth) / 2 + draw.integers(10, 120)))
        seat = draw.choice(["bottom-diameter", "pitch-circle"])
        try:
            drive = rc.two_sprocket_drive(chain, teeth, seat=str(seat))
            drive = shifted(drive, -float(draw.choice([0.0, 1e-3, 0.2])) * chain.pitch)
            report = drive.check()
        except rc.InvalidInput:
            continue  # of the nominal chain: overlapping sprockets, too few links
        laid += 1
        for share in (1e-9, 1e-6, 1e-3, 0.05, 0.2):
            deviation = share * chain.hinge.clearance / chain.pitch
            for elongation in (0.0, -deviation, deviation):
                seed = int(draw.integers(1000))
                worn = replace(chain, pitch_spread=deviation, elongation=elongation, seed=seed)
                off = np.array(worn.link_pitches) - chain.pitch
                opening = report.hinge_stretch + np.max(np.abs(off + np.roll(off, 1))) / 2
                if opening < 0.85 * chain.hinge.clearance:
                    replace(drive, chain=worn).check()


def test_the_spread_is_drawn_with_a_seed_and_has_its_deviation():
    chain = replace(PAPER, links=2000, pitch_spread=1e-3)
    pitches = chain.link_pitches
    assert not pitches.flags.writeable
    assert np.array_equal(pitches, replace(chain, seed=0).link_pitches)
    assert not np.array_equal(pitches, replace(chain, seed=1).link_pitches)
    # Five standard errors.
    assert np.std(pitches) / PITCH == pytest.approx(1e-3, rel=5 / np.sqrt(2 * 2000))
    assert np.mean(pitches) / PITCH == pytest.approx(1.0, abs=5e-3 / np.sqrt(2000))


def test_an_eccentric_sprocket_is_laid_with_its_teeth_where_they_are():
    drive = rc.two_sprocket_drive(chain=PAPER, teeth=(17, 25), links=60)
    (first, second) = drive.sprockets
    second = replace(second, eccentricity=2e-4, eccentricity_angle=0.7)
    x, _ = second.center
    drive = replace(drive, sprockets=[first, replace(second, center=(x - 3e-4, 0.0))])
    simulation = rc.Simulation(drive)
    found = simulation.evaluate()
    assert np.max(found.tooth_penetration) < 0.0
    assert np.max(found.hinge_penetration) < 0.0
    assert simulation.positions[-1, :2] == pytest.approx((x - 3e-4, 0.0), abs=1e-15)
    # Seated bushings lie on a circle about the teeth's centre, not about the bore's.
    q = simulation.positions
    angle = q[-1, 2] + 0.7
    teeth = x - 3e-4 + 2e-4 * np.exp(1j * angle)
    front = q[:60, 0] + 1j * q[:60, 1] + PITCH / 2 * np.exp(1j * q[:60, 2])
    radii = np.sort(np.abs(front - teeth))[:8]
    assert np.ptp(radii) < 2e-6


@pytest.mark.parametrize(("teeth", "links"), [((17, 25), 22), ((17, 17), 16), ((11, 60), 60)])
def test_too_few_links_are_refused_with_a_number_that_works(teeth, links):
    error = refusal(lambda: rc.two_sprocket_drive(teeth=teeth, links=links))
    assert links in numbers(error)
    candidates = {int(x) for x in numbers(error) if x == int(x) and links < x < 200 and x % 2 == 0}
    enough = [
        count
        for count in candidates
        if works(lambda count=count: rc.two_sprocket_drive(teeth=teeth, links=count))
    ]
    assert enough, error
    nearest = min(enough)
    assert not works(lambda: rc.two_sprocket_drive(teeth=teeth, links=nearest - 2)), error


def test_sprockets_that_overlap_are_not_cured_by_links():
    drive = rc.two_sprocket_drive("ISO 16B", (19, 38), center_distance=0.24)
    with pytest.raises(rc.InvalidInput, match=r"a centre distance of 0\.\d+ m takes 50 links$"):
        drive.check()


def test_sprockets_that_overlap_are_refused_with_the_distance_they_need():
    # Pitch radii 34.6 and 50.7 mm.
    teeth, distance = (17, 25), 0.05
    error = refusal(lambda: rc.two_sprocket_drive(teeth=teeth, center_distance=distance))
    found = numbers(error)
    assert any(x == pytest.approx(distance, rel=1e-3) or x == pytest.approx(50.0) for x in found)
    metres = [x * scale for x in found for scale in (1.0, 1e-3) if 0.05 < x * scale < 0.2]
    assert any(
        works(lambda d=d: rc.two_sprocket_drive(teeth=teeth, center_distance=d + 1e-6))
        for d in metres
    ), error


@pytest.mark.parametrize("shift", [2e-3, 5e-2])
def test_a_chain_too_short_for_its_centres_is_refused_with_what_would_close(shift):
    drive = rc.two_sprocket_drive(teeth=(17, 25), links=60)
    closing = drive.sprockets[1].center[0]
    error = refusal(lambda: shifted(drive, shift))
    found = numbers(error)

    def named(length):
        return any(
            x == pytest.approx(length, rel=1e-3) or x == pytest.approx(1e3 * length, rel=1e-3)
            for x in found
        )

    assert named(closing + shift), error
    more = [int(x) for x in found if x == int(x) and 60 < x < 100]
    assert named(closing) or more, error
    for links in more:
        longer = replace(drive, chain=replace(drive.chain, links=links))
        if links % 2 == 0:
            assert works(lambda longer=longer: shifted(longer, shift)), error


def test_a_hair_too_long_is_taken_up_by_the_clearances():
    drive = rc.two_sprocket_drive(teeth=(17, 25), links=60)
    clearance = drive.chain.hinge.bore_radius - drive.chain.hinge.pin_radius
    stretched = shifted(drive, 2.0 * clearance)  # some 40 hinges have 2 * 12.7 um each
    simulation = rc.Simulation(stretched)
    e = simulation.evaluate()
    assert np.max(e.hinge_penetration) < 0.0
    assert np.max(e.tooth_penetration) < 0.0
    assert min(stretched.check().strand_slack) < 0.0


@pytest.mark.parametrize("seat", ["bottom-diameter", "pitch-circle"])
@pytest.mark.parametrize("teeth", [(17, 17), (17, 25), (11, 60), (28, 31), (38, 15)])
@pytest.mark.parametrize("links", [84, 90, 108])
def test_at_its_own_centre_distance_a_chain_is_taut(seat, teeth, links):
    """With the standard's seat, seats that start 1 um farther out leave slack of the same size."""
    report = rc.two_sprocket_drive(teeth=teeth, links=links, seat=seat).check()
    slack = np.abs(report.strand_slack)
    assert np.max(slack) < (1e-6 if seat == "bottom-diameter" else 1e-12)
    span = np.multiply(report.strand_pitches, report.pitch)
    # A flat arc's rise; rounding of the slack itself is a few ulps of the span.
    assert np.all(np.asarray(report.sag) <= 1.01 * np.sqrt(0.375 * slack * span) + 1e-9)
