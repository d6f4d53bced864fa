"""Chain paths, belt lines, strands and key figures of histories made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg, signal
from scipy.integrate import trapezoid

import rustchain as rc
from checks.hand_made import SPEED, THREE, made
from rustchain.analysis.circuit import Belt, Circuit
from rustchain.analysis.strands import natural_frequencies

# In another order; and two in a line that is inclined.
OUTSIDE_FIRST = rc.chain_drive(
    "ANSI 40",
    [
        rc.Sprocket(13, (0.18, -0.005), SPEED, side="outside"),
        rc.Sprocket(17, (0.0, 0.0)),
        rc.Sprocket(25, (0.35, -0.05)),
    ],
)
INCLINED = rc.chain_drive(
    "ANSI 40",
    [rc.Sprocket(25, (0.1, 0.2), SPEED), rc.Sprocket(17, (0.0, 0.5), rc.AppliedTorque(-1.0))],
)
PITCH = 0.0127  # [m]


def pitch_radius(teeth):
    return PITCH / (2 * math.sin(math.pi / teeth))


@pytest.fixture(scope="module")
def run():
    record = ("hinges", "teeth", "sprockets", "bodies", "energy")
    return rc.Simulation(THREE).run(1e-3, record=record, progress=False)


def direction(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


@pytest.mark.parametrize("drive", [THREE, OUTSIDE_FIRST, INCLINED])
def test_the_belt_line_is_tangent_to_the_pitch_circles(drive):
    """At two times; wheels inside the loop lie left of the line, wheels outside right of it."""
    base = np.array([sprocket.center for sprocket in drive.sprockets])
    centers = np.stack([base, base + [[0.0, 0.0], [0.02, -0.01], [-0.01, 0.01]][: len(base)]])
    belt = Belt.around(drive, centers)
    count = len(base)
    for place, sprocket in enumerate(drive.sprockets):
        radius = pitch_radius(sprocket.teeth)
        following = (place + 1) % count
        next_radius = pitch_radius(drive.sprockets[following].teeth)
        begin, end = belt.strand(place)
        np.testing.assert_allclose(
            begin, centers[:, place] + radius * direction(belt.leaving[:, place]), atol=1e-12
        )
        entry = direction(belt.meeting[:, following])
        np.testing.assert_allclose(end, centers[:, following] + next_radius * entry, atol=1e-12)
        way = end - begin
        for center, touch, wheel, size in (
            (centers[:, place], begin, sprocket, radius),
            (centers[:, following], end, drive.sprockets[following], next_radius),
        ):
            arm = center - touch
            np.testing.assert_allclose((way * arm).sum(axis=1), 0.0, atol=1e-12)
            side = way[:, 0] * arm[:, 1] - way[:, 1] * arm[:, 0]
            sign = 1.0 if wheel.side == "inside" else -1.0
            expected = sign * np.hypot(*way.T) * size
            np.testing.assert_allclose(side, expected, rtol=1e-9)


@pytest.mark.parametrize("drive", [THREE, OUTSIDE_FIRST, INCLINED])
def test_sections_begin_and_end_where_the_belt_line_meets_and_leaves_the_pitch_circles(drive):
    """Seats are pitches apart; a wrap is as many pitches long as its angle has tooth angles.

    The first seats lie a whole number of pitches apart along the path, as the report has them.
    """
    report = drive.check()
    sections = Circuit.of(drive).sections
    count = len(drive.sprockets)
    belt = Belt.around(drive, np.array([[sprocket.center for sprocket in drive.sprockets]]))
    # Two strands are reported as upper and lower; a counterclockwise chain meets the lower first.
    strands = dict(zip(report.strands, report.strand_pitches, strict=True))
    names = list(report.strands)[:: -1 if count == 2 else 1]
    # Two sprockets have their first seats from the line of centres.
    line = np.subtract(drive.sprockets[1].center, drive.sprockets[0].center)
    line_angle = math.atan2(line[1], line[0]) if count == 2 else 0.0
    seat = 0
    for place, sprocket in enumerate(drive.sprockets):
        wrap, strand = sections[2 * place : 2 * place + 2]
        assert (wrap.name, wrap.sprocket) == (f"sprocket {place + 1}", place + 1)
        assert (strand.name, strand.sprocket) == (f"strand {names[place]}", None)
        sign = 1.0 if sprocket.side == "inside" else -1.0
        tooth = 2 * math.pi / sprocket.teeth
        meeting, leaving = belt.meeting[0, place], belt.leaving[0, place]
        wrapped = sign * (leaving - meeting) % (2 * math.pi) / tooth
        assert wrap.end - wrap.begin == pytest.approx(wrapped)
        first = report.first_seat_angle[place] + line_angle
        on_seat = meeting + sign * (seat - wrap.begin) * tooth
        np.testing.assert_allclose(direction(on_seat), direction(first), atol=1e-9)
        assert abs(wrap.begin - seat) <= 1.0
        assert strand.begin == wrap.end
        seat += report.wrap_pitches[place] + strands[names[place]]
        last = sections[0].begin + drive.chain.links
        following = sections[2 * place + 2].begin if place + 1 < count else last
        assert strand.end == pytest.approx(following)
    assert seat == drive.chain.links


def test_the_path_of_an_open_chain_is_none():
    drive = rc.open_chain(
        "ANSI 40",
        ends=(rc.AnchoredEnd((-0.16, -0.02), links=30), rc.LoadedEnd(5.0, arm=0.08)),
        links=60,
        sprockets=[rc.Sprocket(17, motion=SPEED)],
    )
    with pytest.raises(rc.InvalidInput, match="an open chain has no closed"):
        Circuit.of(drive)


def test_hinges_go_round_the_path_by_a_pitch_a_tooth(run):
    """Position 0 is that of hinge 1 at the start; a wheel outside turns against the chain."""
    result = made(run, [0.0, 3.3, 80.5, -1.25], [0.0, 1.0, 2.0, 3.0])
    found = Circuit.of(THREE).positions(result)
    start = np.arange(78)
    expected = np.stack([start, start + 3.3, start + 80.5, start - 1.25]) % 78
    apart = (found - expected + 39) % 78 - 39
    np.testing.assert_allclose(apart, 0.0, atol=1e-9)
    assert found.min() >= 0.0
    assert found.max() < 78.0
    phase = OUTSIDE_FIRST.check().phase[0]
    angle = np.zeros((2, 3))
    angle[:, 0] = phase, phase + 2.5 * 2 * math.pi / 13
    other = rc.Simulation(OUTSIDE_FIRST).run(1e-4, record=("sprockets",), progress=False)
    other = replace(other, arrays={"time": np.array([0.0, 1.0]), "sprocket_angle": angle})
    np.testing.assert_allclose(Circuit.of(OUTSIDE_FIRST).moved(other), [0.0, -2.5], atol=1e-12)


def test_sections_are_found_by_number_and_name_and_by_position():
    circuit = Circuit.of(THREE)
    assert circuit.section(2) == circuit.section("sprocket 2") == circuit.sections[2]
    assert circuit.section("2-3") == circuit.section("strand 2-3") == circuit.sections[3]
    with pytest.raises(rc.InvalidInput, match=r"'3-2' is no section .* known: 'sprocket 1', "):
        circuit.section("3-2")
    with pytest.raises(rc.InvalidInput, match="4 is no section"):
        circuit.section(4)
    first, strand, second = circuit.sections[:3]
    positions = [first.begin, first.end, second.begin, second.end, 0.1, 77.9, math.nan]
    names = ["sprocket 1", "strand 1-2", "sprocket 2", "strand 2-3", "strand 3-1", "strand 3-1", ""]
    assert circuit.names(np.array(positions)) == names
    assert strand.begin == first.end
    # Here the first wrap begins before position 0.
    before = Circuit.of(OUTSIDE_FIRST)
    assert before.sections[0].begin < -0.2
    assert before.names(np.array([77.8, 77.6, 0.0])) == ["sprocket 1", "strand 3-1", "sprocket 1"]


def seen(rows, *contacts):
    """Return the arrays of contacts: row, bushing, sprocket, gap."""
    wheel, gap = np.zeros((2, rows, 78), np.int32)
    for row, bushing, number, index in contacts:
        wheel[row, bushing - 1], gap[row, bushing - 1] = number, index
    return {"tooth_sprocket": wheel, "tooth_index": gap}


def begins(result, rows=slice(None)):
    """Return how far the sections begin behind those of the initial configuration [pitches]."""
    found, initial = Circuit.during(result, rows).sections, Circuit.of(THREE).sections
    return [one.begin - other.begin for one, other in zip(found, initial, strict=True)]


def test_a_sprocket_that_lags_behind_the_chain_has_its_wrap_farther_on(run):
    """Sprocket 2 lags by 0.6 and 0.2 teeth, 3 on the outside leads: means over the rows count."""
    lag = np.array([[0.0, 5.0, 5.0], [0.0, 0.6, -0.3], [0.0, 0.2, -0.1]])
    tooth = 2 * math.pi / np.array([17, 25, -13])
    result = made(run, [3.3, 4.0, 5.0], [0.0, 1.0, 2.0])
    angle = result.array("sprocket_angle") - lag * tooth
    result = replace(result, arrays=result.arrays | {"sprocket_angle": angle})
    found = begins(result, slice(1, 3))
    # A strand begins where the wrap before it ends.
    np.testing.assert_allclose(found, [0.0, 0.0, 0.4, 0.4, -0.2, -0.2], atol=1e-9)
    # A jump of sprocket 2 is a tooth that it turned against the chain, of 3 the other way round.
    jumps = (np.array([0.5, 0.5]), np.array([2, 3]), np.array([1, 1]))
    found = begins(replace(result, jumps=jumps), slice(1, 3))
    np.testing.assert_allclose(found, [0.0, 0.0, 1.4, 1.4, -1.2, -1.2], atol=1e-9)


def test_wraps_begin_and_end_with_the_belt_line_at_the_recorded_centres(run):
    """A sprocket that moves turns the lines beside it."""
    result = made(run, [3.3, 4.0], [0.0, 1.0])
    center = result.array("sprocket_center").copy()
    center[:, 1] += 0.01, 0.03
    result = replace(result, arrays=result.arrays | {"sprocket_center": center})
    initial = Belt.around(THREE, run.array("sprocket_center")[:1])
    belt = Belt.around(THREE, center)
    per_radian = np.array([17, 25, -13]) / (2 * math.pi)
    entered = (belt.meeting - initial.meeting).mean(axis=0) * per_radian
    left = (belt.leaving - initial.leaving).mean(axis=0) * per_radian
    assert np.abs(entered).max() > 0.3
    np.testing.assert_allclose(begins(result)[::2], entered, atol=1e-9)
    np.testing.assert_allclose(begins(result)[1::2], left, atol=1e-9)


@pytest.mark.parametrize("gaps", [(0, 0, 0), (0, 1, 0), (0, 0, -2), (3, 1, 1)])
def test_bushings_in_other_gaps_than_generated_are_found_by_their_contacts(run, gaps):
    """The chain stands so many gaps ahead on each sprocket; bushing 1 passes the last hinge."""
    report = THREE.check()
    turn, teeth = np.array([1, 1, -1]), np.array([17, 25, 13])
    seats = np.array([0, *np.cumsum(np.add(report.wrap_pitches, report.strand_pitches))[:2]])
    zero = np.round((np.array(report.first_seat_angle) - report.phase) * teeth / (2 * math.pi))
    contacts = []
    # Two rows: the chain has moved on by 0 and by 80 pitches.
    for row, moved in enumerate((0, 80)):
        for k in range(3):
            ahead = 0 if k == 2 else 2  # of the first seat; on the short wrap, the seat itself
            bushing = (seats[k] + ahead + gaps[k] - moved) % 78 + 1
            index = (zero[k] + turn[k] * (ahead - moved)) % teeth[k]
            contacts.append((row, bushing, k + 1, index))
    result = made(run, [0.0, 80.0], [0.0, 1.0], **seen(2, *contacts))
    expected = np.repeat(np.array(gaps) - gaps[0], 2)
    np.testing.assert_allclose(begins(result), expected, atol=1e-9)
    # Position 0 is the first seat of sprocket 1.
    moved = Circuit.during(result, slice(None)).moved(result)
    np.testing.assert_allclose(moved, [-gaps[0], 80.0 - gaps[0]], atol=1e-9)


@pytest.mark.parametrize(
    ("ahead", "shift"), [((1, 1, 1, 1, 7), 1), ((-7, 1, 1, 1, 1), 1), ((0, 0, 1, 1), 0)]
)
def test_the_median_of_the_contacts_says_in_which_gaps_the_bushings_are(run, ahead, shift):
    """A bushing that is recorded far from the others moves nothing; parts of gaps do not count."""
    report = THREE.check()
    first = report.wrap_pitches[0] + report.strand_pitches[0]
    zero = round((report.first_seat_angle[1] - report.phase[1]) * 25 / (2 * math.pi))
    contacts = [
        (0, (first + k + gaps) % 78 + 1, 2, (zero + k) % 25) for k, gaps in enumerate(ahead, 2)
    ]
    result = made(run, [0.0], [0.0], **seen(1, *contacts))
    np.testing.assert_allclose(begins(result), [0, 0, shift, shift, 0, 0], atol=1e-9)


def test_contacts_at_the_end_of_a_wrap_of_more_than_half_the_chain_leave_it_in_its_place():
    drive = rc.two_sprocket_drive("ANSI 40", teeth=(60, 11), links=68, speed=10.0)
    run = rc.Simulation(drive).run(1e-4, record=("teeth", "sprockets"), progress=False)
    initial = Circuit.of(drive).sections
    last = int(initial[0].end)
    assert last > 34 + 2
    report = drive.check()
    zero = round((report.first_seat_angle[0] - report.phase[0]) * 60 / (2 * math.pi))
    wheel, gap = np.zeros((2, *run.array("tooth_index").shape), np.int32)
    for bushing in (last - 2, last - 1):
        wheel[:, bushing], gap[:, bushing] = 1, (zero + bushing) % 60
    result = replace(run, arrays=run.arrays | {"tooth_sprocket": wheel, "tooth_index": gap})
    circuit = Circuit.during(result, slice(0, 1))
    np.testing.assert_allclose(
        [section.begin for section in circuit.sections],
        [section.begin for section in initial],
        atol=1e-9,
    )
    np.testing.assert_allclose(circuit.moved(result)[0], 0.0, atol=1e-9)


def test_the_tension_is_the_pull_along_the_links_ahead(run):
    """Pins are in links with odd number: forces on the pin count, of bushings their opposite.

    A pull of 7 N along the chain, and whatever there is across it, on links of any direction.
    """
    rng = np.random.default_rng(8)
    positions = np.zeros((3, *run.array("positions").shape[1:]))
    positions[:, :, :2] = rng.uniform(-1.0, 1.0, positions[:, :, :2].shape)
    links = 78
    step = np.empty((3, links, 2))
    for k in range(links):
        step[:, k] = positions[:, (k + 1) % links, :2] - positions[:, k, :2]
    along = step / np.linalg.norm(step, axis=2, keepdims=True)
    across = np.stack([-along[..., 1], along[..., 0]], axis=2)
    pull, beside = rng.uniform(-9.0, 9.0, (2, 3, links, 1))
    on_front = pull * along + beside * across
    has_bushings = np.arange(links) % 2 == 0  # inner links come first
    on_pin = np.where(has_bushings[:, None], -on_front, on_front)
    result = made(
        run, [0.0, 0.1, 0.2], [0.0, 0.1, 0.2], positions=positions, hinge_force_vector=on_pin
    )
    found = result.link_tension(start=0.1)
    np.testing.assert_allclose(found, pull[1:, :, 0], rtol=1e-9)
    assert list(found["hinge"]) == list(range(1, 79))


def test_the_motion_of_a_strand_is_refused_where_a_sprocket_has_run_away(run):
    """As in a chain that has come off: no tooth jumps are counted there."""
    angle = np.tile(run.drive.check().phase, (2, 1))
    angle[:, 1] += 4.0 * np.pi
    result = made(run, [0.0, 0.0], [0.0, 0.1], sprocket_angle=angle)
    with pytest.raises(rc.InvalidInput, match="have turned against the chain"):
        result.strand_motion("1-2")


@pytest.mark.parametrize(("strand", "moved"), [("1-2", 3.3), ("3-1", 70.6), (2, 12.45)])
def test_the_motion_of_a_strand_is_what_its_hinges_are_off_its_line(run, strand, moved):
    """Hinges within two pitches of the strand count, others lie about; the line moves too."""
    rng = np.random.default_rng(9)
    place = {"1-2": 0, 2: 1, "3-1": 2}[strand]
    rows = 3
    center = np.tile(run.array("sprocket_center")[:1], (rows, 1, 1))
    center[1, 1] += 0.004, 0.003
    positions = np.zeros((rows, *run.array("positions").shape[1:]))
    begin, end = Belt.around(THREE, center).strand(place)
    section = Circuit.of(THREE).sections[2 * place + 1]
    stations = (0.02, 0.35, 0.98)
    expected = np.empty((rows, 3))
    for row in range(rows):
        way = end[row] - begin[row]
        length = math.hypot(*way)
        along = way / length
        outward = np.array([along[1], -along[0]])
        inside = []
        for k in range(78):
            at = (k + moved - section.begin + 20.0) % 78 - 20.0  # pitches behind the strand's begin
            near = -2.0 < at < section.end - section.begin + 2.0
            x = at * PITCH / length if near else rng.uniform(0.0, 1.0)
            y = rng.uniform(-0.01, 0.01) if near else 5.0
            if near:
                inside.append((x, y))
            turn = rng.uniform(-3.0, 3.0)
            front = begin[row] + x * length * along + y * outward
            positions[row, k, :2] = front - 0.5 * PITCH * direction(turn)
            positions[row, k, 2] = turn
        expected[row] = np.interp(stations, *np.array(sorted(inside)).T)
    result = made(
        run,
        [moved] * rows,
        [0.0, 0.1, 0.2],
        positions=positions,
        sprocket_center=center,
    )
    found = result.strand_motion(strand, stations=stations, start=0.1)
    np.testing.assert_allclose(found, expected[1:], atol=1e-9)
    assert found.attrs["strand"] == THREE.check().strands[place]
    length = np.hypot(*(end - begin)[1:].T).mean()
    assert found.attrs["length"] == pytest.approx(length)


@pytest.mark.parametrize("stations", [(), (0.0, 0.5), (0.5, 1.0), (-0.1,), (1.5,)])
def test_stations_lie_between_the_ends_of_the_strand(run, stations):
    with pytest.raises(rc.InvalidInput, match="shares of the strand's length between 0 and 1"):
        run.strand_motion("1-2", stations=stations)


def test_the_spectrum_of_a_strand_is_that_of_its_motion(run):
    """Welch's with one segment; tension and speed are means over the rows of the part."""
    rng = np.random.default_rng(10)
    rows = 40
    time = 0.5 + 1e-3 * np.arange(rows)
    positions = np.tile(run.array("positions")[:1], (rows, 1, 1))
    positions[:, :78, :2] += rng.uniform(-1e-3, 1e-3, (rows, 78, 2))
    tension = rng.uniform(50.0, 90.0, (rows, 3))
    speed = rng.uniform(-2.0, 8.0, (rows, 3))
    result = made(
        run, [0.0] * rows, time, positions=positions, strand_tension=tension, sprocket_speed=speed
    )
    found = result.strand_spectrum("2-3", stations=(0.3, 0.6), modes=2, start=time[8])
    motion = result.strand_motion("2-3", stations=(0.3, 0.6))[8:].to_numpy()
    frequency, density = signal.welch(
        motion.T, 1e3, window="hann", nperseg=rows - 8, detrend="linear"
    )
    np.testing.assert_allclose(found["frequency"], frequency)
    np.testing.assert_allclose(found["density"], density, rtol=1e-9, atol=1e-20)
    mean = tension[8:, 1].mean()
    teeth_a_second = 17 * np.abs(speed[8:, 0]).mean() / (2 * math.pi)
    chain_speed = teeth_a_second * PITCH
    assert found.attrs["tension"] == pytest.approx(mean)
    assert found.attrs["speed"] == pytest.approx(chain_speed)
    assert found.attrs["tooth_frequency"] == pytest.approx(teeth_a_second)
    begin, end = Belt.around(THREE, result.array("sprocket_center")[:1]).strand(1)
    pitches = math.hypot(*(end - begin)[0]) / PITCH
    assert found.attrs["pitches"] == pytest.approx(pitches)
    expected = natural_frequencies(THREE.chain, pitches, mean, chain_speed, 2)
    np.testing.assert_allclose(found["natural_frequency"], expected)
    assert list(found["mode"]) == [1, 2]
    assert len(result.strand_spectrum("2-3")["mode"]) == 3
    one = result.strand_spectrum("2-3", modes=1, start=time[8])["natural_frequency"]
    np.testing.assert_allclose(one, expected[:1])
    with pytest.raises(rc.InvalidInput, match="modes"):
        result.strand_spectrum("2-3", modes=0)
    with pytest.raises(rc.InvalidInput, match="modes"):
        result.strand_spectrum("2-3", modes=79)


@pytest.mark.parametrize("speed", [0.0, 4.0])
@pytest.mark.parametrize("links", [2, 5, 12])
def test_natural_frequencies_are_the_eigenvalues_of_hinged_links(links, speed):
    """Equal rigid links between fixed ends under tension: matrices of stiffness and mass."""
    chain, tension = THREE.chain, 60.0
    mass = 0.5 * (chain.inner.mass + chain.outer.mass)
    inertia = 0.5 * (chain.inner.inertia + chain.outer.inertia)
    stretch = np.zeros((links, links - 1))  # of the two hinges of each link: difference
    middle = np.zeros((links, links - 1))
    for k in range(links - 1):
        stretch[[k, k + 1], k] = 1.0, -1.0
        middle[[k, k + 1], k] = 0.5
    stiffness = tension / PITCH * stretch.T @ stretch
    inertial = mass * middle.T @ middle + inertia / PITCH**2 * stretch.T @ stretch
    resting = np.sqrt(linalg.eigh(stiffness, inertial, eigvals_only=True)) / (2 * math.pi)
    slowed = 1.0 - speed**2 * mass / PITCH / tension
    found = natural_frequencies(chain, links, tension, speed, links + 1)
    np.testing.assert_allclose(found[:-2], slowed * resting, rtol=1e-9)
    assert np.isnan(found[-2:]).all()


def test_a_slack_strand_and_one_at_the_speed_of_its_waves_have_no_frequencies():
    chain = THREE.chain
    density = 0.5 * (chain.inner.mass + chain.outer.mass) / PITCH
    for tension in (0.0, -1.0, density * 4.0, density * 3.0):
        assert np.isnan(natural_frequencies(chain, 20.0, tension, 2.0, 3)).all()
    assert np.isfinite(natural_frequencies(chain, 20.0, 0.5, 0.0, 3)).all()


@pytest.fixture(scope="module")
def summed(run):
    """Ten rows, a quarter pitch of the chain each, in which two bushings come to sprocket 1."""
    rng = np.random.default_rng(11)
    rows = 10
    time = 0.1 * np.arange(rows)
    wheel = np.zeros((rows, 78), np.int32)
    wheel[2:4, 0] = wheel[3:6, 1] = 1
    impact = np.zeros((rows, 78))
    impact[2:6, :2] = [[3.0, 0.0], [5.0, 2.0], [90.0, 1.0], [0.0, 80.0]]
    penetration = rng.uniform(-2e-6, 1e-6, (rows, 78))
    penetration[3, 5:30] = 0.0  # pins that touch their bores without a force
    arrays = {
        "strand_tension": rng.uniform(20.0, 90.0, (rows, 3)),
        "hinge_penetration": penetration,
        "peak_hinge_force": rng.uniform(0.0, 50.0, (rows, 78)),
        "peak_tooth_force": impact,
        "tooth_sprocket": wheel,
        "tooth_index": wheel * 4,
        "sprocket_speed": rng.uniform(5.0, 9.0, (rows, 3)),
        "sprocket_torque": np.tile([4.0, -0.3, 0.0], (rows, 1)),
        "energy_external_work": 2.0 * time,
        "energy_dissipated": 0.4 * time,
    }
    result = made(run, 0.25 * np.arange(rows), time, **arrays)
    angle = result.array("sprocket_angle").copy()
    angle[:, 1:] += rng.uniform(-0.01, 0.01, (rows, 2))
    return replace(result, arrays=result.arrays | {"sprocket_angle": angle})


def without(result, *prefixes):
    kept = {name: v for name, v in result.arrays.items() if not name.startswith(prefixes)}
    return replace(result, arrays=kept)


def test_key_figures_are_those_of_the_recorded_rows(summed):
    found = summed.summary()
    tension = summed.array("strand_tension")
    expected = {}
    for k, name in enumerate(("1-2", "2-3", "3-1")):
        mean = trapezoid(tension[:, k], summed.time) / np.ptp(summed.time)
        square = trapezoid((tension[:, k] - mean) ** 2, summed.time) / np.ptp(summed.time)
        expected[f"tension_{name}"] = mean
        expected[f"tension_{name}_std"] = np.sqrt(square)
    expected["hinge_contact_share"] = (summed.array("hinge_penetration") > 0.0).mean()
    for part in ("hinge", "tooth"):
        peak = summed.array(f"peak_{part}_force")
        expected[f"{part}_force_p99"] = np.quantile(peak, 0.99)
        expected[f"{part}_force_largest"] = peak.max()
    expected["tooth_jumps"] = 0
    # The first half pitch from the onset has two rows: 3 and 5 N of bushing 1, 2 and 1 of 2.
    expected["engagement_force_mean"] = 3.5
    expected["engagement_force_p95"] = 2.0 + 0.95 * 3.0
    for number in (2, 3):
        error = summed.transmission_error(driven=number, driver=1).attrs["peak_to_peak_length"]
        expected[f"transmission_error_{number}"] = error
        expected[f"ripple_{number}"] = summed.speed_ripple(number).attrs["rms"]
    delivered = 0.3 * trapezoid(summed.array("sprocket_speed")[:, 1], dx=1 / 9)
    expected["loss"] = 0.4
    expected["efficiency"] = delivered / (delivered + 0.4)
    assert list(found) == list(expected)
    for name, value in expected.items():
        assert found[name] == pytest.approx(value), name
    late = summed.summary(start=0.15, end=0.55)
    assert late["tension_2-3"] == pytest.approx(trapezoid(tension[2:6, 1], dx=1.0) / 3.0)
    assert late["hinge_force_largest"] == summed.array("peak_hinge_force")[3:6].max()
    assert late["engagement_force_mean"] == 3.5  # bushing 1 comes into contact at the first row
    assert late["loss"] == pytest.approx(0.4)


def test_a_first_sprocket_has_a_ripple_where_its_speed_is_not_prescribed(summed):
    first, *others = summed.drive.sprockets
    assert isinstance(first.motion, rc.PrescribedSpeed)
    assert "ripple_1" not in summed.summary()
    for motion in (rc.Free(), rc.AppliedTorque(1.0)):
        drive = replace(summed.drive, sprockets=(replace(first, motion=motion), *others))
        found = replace(summed, scene=replace(summed.scene, system=drive)).summary()
        assert found["ripple_1"] == summed.speed_ripple(1).attrs["rms"]


def test_key_figures_have_units_and_print_as_a_table(summed):
    found = summed.summary()
    units = found.units
    assert units["tension_1-2"] == units["hinge_force_p99"] == units["engagement_force_p95"] == "N"
    assert (units["loss"], units["transmission_error_2"]) == ("W", "m")
    assert units["ripple_2"] == units["efficiency"] == units["tooth_jumps"] == "1"
    lines = repr(found).splitlines()
    assert len(lines) == len(found)
    width = max(map(len, found))
    line = next(line for line in lines if line.startswith("loss"))
    assert line == "loss".ljust(width) + "  " + "0.4".rjust(12) + " W"
    assert next(line for line in lines if line.startswith("tooth_jumps")).endswith("  0")
    empty = without(summed, "strand", "hinge", "peak", "tooth", "sprocket", "energy", "positions")
    assert repr(empty.summary()) == "nothing was recorded to sum up"


def test_key_figures_need_what_they_are_made_of(summed):
    """Groups of arrays that a run leaves out, and too few rows."""
    teeth, sprockets = ("tooth", "peak_tooth"), ("sprocket",)
    names = set(summed.summary())
    engaged = {"engagement_force_mean", "engagement_force_p95"}
    turning = {f"{name}_{k}" for name in ("transmission_error", "ripple") for k in (2, 3)}
    powers = {"loss", "efficiency"}
    impacts = {"tooth_force_p99", "tooth_force_largest", "tooth_jumps"}
    assert set(without(summed, *teeth).summary()) == names - engaged - impacts
    assert set(without(summed, *sprockets).summary()) == names - engaged - turning - powers
    assert set(without(summed, "energy").summary()) == names - powers
    bodies = ("positions", "velocities")
    alone = without(summed, "hinge", "peak_hinge", "strand", "energy", *bodies)
    assert set(alone.groups) == {"sprockets", "teeth"}
    assert set(alone.summary()) == engaged | impacts | turning
    alone = without(summed, "hinge", "peak", "strand", "tooth", *bodies)
    assert set(alone.groups) == {"sprockets", "energy"}
    assert set(alone.summary()) == turning | powers
    uncounted = replace(summed, jumps=None)
    assert set(uncounted.summary()) == names - {"tooth_jumps"}
    # Eight rows have an error, seven have none; two have a power.
    assert turning <= set(summed.summary(end=0.75))
    assert not turning & set(summed.summary(end=0.65))
    assert powers <= set(summed.summary(end=0.15))
    assert not powers & set(summed.summary(end=0.05))
    assert not powers & set(summed.summary(start=0.35, end=0.45))
    assert not engaged & set(summed.summary(end=0.15))


def test_a_sprocket_at_rest_has_no_ripple_and_a_driver_at_rest_gives_no_error(summed):
    angle = summed.array("sprocket_angle").copy()
    angle[:, 1] = 0.3
    rest = {"sprocket_angle": angle, "sprocket_speed": summed.array("sprocket_speed") * [1, 0, 1]}
    found = replace(summed, arrays=summed.arrays | rest).summary()
    assert not {"ripple_2", "efficiency"} & set(found)  # it delivers no power
    assert {"transmission_error_2", "ripple_3", "loss"} <= set(found)
    angle[:, 0] = 0.1
    found = replace(summed, arrays=summed.arrays | {"sprocket_angle": angle}).summary()
    assert not {"transmission_error_2", "transmission_error_3", "ripple_3"} & set(found)


@pytest.mark.parametrize(("sprocket", "errors"), [(1, set()), (2, {3}), (3, {2})])
def test_a_sprocket_whose_teeth_were_jumped_has_no_error(summed, sprocket, errors):
    jumps = np.array([0.35, 0.45]), np.array([sprocket] * 2), np.array([1, 1])
    found = replace(summed, jumps=jumps).summary()
    assert found["tooth_jumps"] == 2
    assert {name for name in found if name.startswith("transmission")} == {
        f"transmission_error_{number}" for number in errors
    }
    assert {"ripple_2", "ripple_3", "loss"} <= set(found)
    assert "efficiency" not in found
    assert "efficiency" in replace(summed, jumps=jumps).summary(end=0.35 - 1e-9)


def test_a_drive_whose_other_sprockets_have_no_torque_has_no_efficiency(summed):
    free = [replace(sprocket, motion=rc.Free()) for sprocket in THREE.sprockets[1:]]
    system = replace(THREE, sprockets=[THREE.sprockets[0], *free])
    made = replace(summed, scene=replace(summed.scene, system=system))
    assert (
        made.summary()["efficiency"] == summed.summary()["efficiency"]
    )  # by a torque that was set
    idle = {"sprocket_torque": summed.array("sprocket_torque") * [1.0, 0.0, 0.0]}
    found = replace(made, arrays=made.arrays | idle).summary()
    assert "loss" in found
    assert "efficiency" not in found


@pytest.mark.parametrize(("size", "strands"), [("ANSI 40", 1), ("ANSI 80", 1), ("ISO 08B", 2)])
def test_rollers_that_are_bodies_leave_the_natural_frequencies(size, strands):
    """At equal tension and speed, a strand weighs as much as with fixed rollers."""
    found = []
    for rollers in ("fixed", "bodies"):
        chain = rc.catalogue_chain(size, links=60, strands=strands, rollers=rollers)
        found.append(natural_frequencies(chain, 14.3, 300.0, 6.0, 5))
    np.testing.assert_allclose(*found, rtol=0.01)
    assert np.isfinite(found).all()


def test_the_spectrum_of_a_strand_counts_rollers_that_are_bodies():
    found, record = [], ("hinges", "teeth", "sprockets", "bodies")
    for rollers in ("fixed", "bodies"):
        drive = rc.two_sprocket_drive(teeth=(17, 17), links=60, pretension=100.0, rollers=rollers)
        result = rc.Simulation(drive).run(4e-3, record=record, progress=False)
        tension = np.full_like(result.array("strand_tension"), 50.0)
        result = replace(result, arrays=result.arrays | {"strand_tension": tension})
        found.append(result.strand_spectrum("upper")["natural_frequency"])
    np.testing.assert_allclose(*found, rtol=0.01)
