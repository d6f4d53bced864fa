"""Loads, engagements and pressures of histories made by hand; sums are plain loops over rows."""

import math
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from checks.hand_made import THREE, made
from rustchain._rustchain import tooth_radii
from rustchain.analysis.circuit import Circuit
from rustchain.analysis.loads import nearest_contact

# With a flat rail, an arched one and a smooth idler.
STEEL, POLYMER = rc.Material(2.07e11, 0.3, 0.2), rc.Material(3e9, 0.4, 0.2)
DRIVE = replace(
    THREE,
    guides=[
        rc.GuideRail((0.16, -0.2), (0.0, 1.0), length=0.1),
        rc.GuideRail((0.16, -0.25), (0.0, 1.0), length=0.06, radius=0.2, material=POLYMER),
        rc.SmoothIdler(0.01, (0.16, -0.3), material=POLYMER),
    ],
)
LINKS = 78
PITCH = 0.0127  # [m]


@pytest.fixture(scope="module")
def run():
    record = ("hinges", "teeth", "sprockets", "bodies")
    return rc.Simulation(DRIVE).run(1e-3, record=record, progress=False)


def table(rows, entries, dtype=float):
    """Return an array (rows, bushings) with these entries by row and number of the bushing."""
    found = np.zeros((rows, LINKS), dtype)
    for (row, number), value in entries.items():
        found[row, number - 1] = value
    return found


def contacts(rows, *stays):
    """Return sprockets, gaps and regions of stays: bushing, rows, sprocket, gap, region."""
    arrays = {name: np.zeros((rows, LINKS), np.int32) for name in ("sprocket", "index", "region")}
    for number, at, *values in stays:
        for array, value in zip(arrays.values(), values, strict=True):
            array[list(at), number - 1] = value
    return {f"tooth_{name}": array for name, array in arrays.items()}


@pytest.fixture(scope="module")
def engaged(run):
    """Six bushings; the chain goes back by a quarter pitch a row, from two pitches ahead."""
    rows = 10
    stays = contacts(
        rows,
        (1, [3, 4, 6], 1, 4, 2),  # lifts off at row 5 and returns to its gap: one episode
        (1, [7, 8], 1, 5, 3),  # then the next gap
        (2, [0, 1], 1, 6, 2),  # in contact from the start
        (2, [2, 3], 3, 6, 7),  # the same gap of the third sprocket
        (3, [1, 2], 2, 9, 1),
        (4, [5], 3, 2, 1),
        (5, [2, 3], 5, 0, 2),  # of the arched rail, its face
        (6, [4], 6, 1, 1),  # of the idler, from behind
        (7, [9], 1, 8, 1),
        (8, [6], 4, 0, 1),  # of the flat rail
    )
    row, number = np.mgrid[:rows, 1 : LINKS + 1]
    seen = stays["tooth_sprocket"] > 0
    loaded = seen | np.vstack([seen[:1], seen[:-1]])  # in the interval that ends with the row
    peak = np.where(loaded, 100.0 * number + row**2 + 1.0, 0.0)
    impulse = np.where(loaded, number + 0.01 * 2.0**row, 0.0)
    return made(
        run,
        2.0 - 0.25 * np.arange(rows),
        0.1 * np.arange(rows),
        peak_tooth_force=peak,
        peak_tooth_impulse=impulse,
        **stays,
    )


def test_engagements_are_the_onsets_after_the_first_row(engaged):
    """An impact of half a pitch is two rows long; an episode ends with the row after its last."""
    found = engaged.engagements()
    columns = ["time", "bushing", "sprocket", "tooth", "region", "pitches"]
    expected = [
        (0.1, 3, 2, 9, 1, 0.25),
        (0.2, 2, 3, 6, 7, 0.25),
        (0.3, 1, 1, 4, 2, 0.75),
        (0.5, 4, 3, 2, 1, 0.0),
        (0.7, 1, 1, 5, 3, 0.25),
        (0.9, 7, 1, 8, 1, 0.0),
    ]
    assert list(found.index) == list(range(len(expected)))
    np.testing.assert_allclose(found[columns].to_numpy(), expected)
    # Rows of the impact, and of the episode with the row after it.
    impact = [(1, 2), (2, 3), (3, 4), (5, 6), (7, 8), (9,)]
    episode = [3, 4, 7, 6, 9, 9]
    for k, (rows, last) in enumerate(zip(impact, episode, strict=True)):
        number = expected[k][1]
        one = found.iloc[k]
        assert one["force"] == 100 * number + max(rows) ** 2 + 1
        assert one["largest_force"] == 100 * number + last**2 + 1
        assert one["impulse"] == pytest.approx(sum(number + 0.01 * 2.0**row for row in rows))


def test_a_bushing_in_the_wrap_at_the_first_row_of_a_part_begins_with_its_next_gap(engaged):
    """At the start of a run it is not in contact; of a part, its first gap is an old episode."""
    part = replace(engaged, arrays=engaged.arrays | {"time": engaged.time + 1.0})
    for result, gaps in ((engaged, [4, 5]), (part, [5])):
        found = result.engagements()
        assert list(found["tooth"][found["bushing"] == 1]) == gaps


def test_engagements_of_one_sprocket_or_guide_are_asked_for(engaged):
    for asked, bushings in ((1, [1, 1, 7]), (2, [3]), (3, [2, 4]), ("guide_2", [5])):
        assert sorted(engaged.engagements(asked)["bushing"]) == bushings
    assert list(engaged.engagements("guide_3")["tooth"]) == [1]
    assert list(engaged.engagements("guide_1")["bushing"]) == [8]


def test_a_longer_impact_takes_more_rows(engaged):
    """A pitch is four rows."""
    one = engaged.engagements(1, within=1.0).iloc[0]
    assert one["force"] == 100 + 6**2 + 1
    least = engaged.engagements(1, within=1e-6).iloc[0]
    assert least["force"] == 100 + 3**2 + 1
    with pytest.raises(rc.InvalidInput, match=r"within = 0\.0: must be a positive number"):
        engaged.engagements(2, within=0.0)


def test_impacts_that_are_over_before_a_row_belong_to_the_engagement(run):
    """Flights between the impacts are 2.25 pitches, along the strands 3.75."""
    rows = 50
    stays = contacts(rows, (4, [2, 3], 1, 3, 2), (4, [26, 27], 2, 9, 1))
    forces = {4: 70.0, 8: 60.0, 16: 90.0, 22: 50.0, 26: 3.0, 27: 2.0, 28: 1.0, 32: 8.0, 38: 90.0}
    peak = table(rows, {(row, 4): force for row, force in forces.items()})
    impulse = 0.1 * peak
    time = 0.1 * np.arange(rows)
    for turn in (0.75, -0.75):
        result = made(
            run,
            turn * np.arange(rows),
            time,
            peak_tooth_force=peak,
            peak_tooth_impulse=impulse,
            **stays,
        )
        former, found = result.engagements().to_dict("records")
        assert (found["time"], found["tooth"], found["region"]) == (pytest.approx(2.2), 9, 1)
        assert (found["force"], found["impulse"]) == (50.0, pytest.approx(5.0))
        assert found["largest_force"] == 50.0
        assert found["pitches"] == pytest.approx(0.75 * (31 - 22))
        assert (former["time"], former["largest_force"]) == (pytest.approx(0.2), 70.0)
        assert former["pitches"] == pytest.approx(0.75 * (7 - 2))
        assert len(result.engagements(start=2.3)) == 0  # the onset is in the interval before
        alone = np.where(np.arange(rows)[:, None] == 22, 0.0, peak)  # a flight of 6.75 pitches
        result = replace(result, arrays=result.arrays | {"peak_tooth_force": alone})
        _, found = result.engagements().to_dict("records")
        assert (found["time"], found["force"]) == (pytest.approx(2.6), 3.0)
        assert found["largest_force"] == 8.0


def random_forces(run, pitches, time, part, **arrays):
    """Return a result with random forces of a part, and these."""
    rng = np.random.default_rng(5)
    shape = (len(pitches), LINKS)
    names = (f"{part}_force", f"peak_{part}_force", f"peak_{part}_impulse")
    forces = dict(zip(names, rng.uniform(1.0, 9.0, (3, *shape)), strict=True))
    return made(run, pitches, time, **forces, **arrays), *forces.values()


# Uneven in time and in displacement; no place lies on the edge of a bin.
MOVED = np.array([3.3, 3.9, 5.2, 5.45, 7.1, 7.12])
TIME = np.array([0.5, 0.6, 0.9, 1.0, 1.5, 1.7])
MIDWAY = [3.3, 3.6, 4.55, 5.325, 6.275, 7.11]  # of the rows from 0.9 s on: 4.55 and so on
SPANS = [0.0, 0.1, 0.3, 0.1, 0.5, 0.2]  # [s]


def check_bins(found, members, bins, force, peak, impulse, quantiles, first=0):
    """Hold mean, quantiles and largest of each bin against its members: rows and columns.

    The interval before the first row does not count.
    """
    assert found["mean"].shape == (bins,)
    for k in range(bins):
        inside = members.get(k, [])
        span = sum(SPANS[row] for row, _ in inside if row > first)
        mean = sum(impulse[each] for each in inside) / span if span else math.nan
        np.testing.assert_allclose(found["mean"][k], mean)
        forces = [force[each] for each in inside]
        expected = np.quantile(forces, quantiles) if forces else [math.nan] * len(quantiles)
        np.testing.assert_allclose(found["quantiles"][k], expected)
        largest = max(peak[each] for each in inside) if inside else math.nan
        np.testing.assert_allclose(found["largest"][k], largest)


@pytest.mark.parametrize("per_pitch", [1, 2, 5])
def test_loads_of_hinges_are_gathered_by_their_place_on_the_chain_path(run, per_pitch):
    result, force, peak, impulse = random_forces(run, MOVED, TIME, "hinge")
    found = result.hinge_loads(bins_per_pitch=per_pitch, quantiles=(0.0, 0.3), start=0.9)
    members = defaultdict(list)
    # What came before the part is none of it.
    where = [MOVED[2], *MIDWAY[3:]]
    impulse[2], peak[2] = 0.0, force[2]
    for row in range(2, 6):
        for hinge in range(LINKS):
            place = (where[row - 2] + hinge) % LINKS
            members[math.floor(place * per_pitch)].append((row, hinge))
    check_bins(found, members, LINKS * per_pitch, force, peak, impulse, (0.0, 0.3), first=2)
    position = found["position"].to_numpy()
    assert position[0] == pytest.approx(0.5 / per_pitch)
    np.testing.assert_allclose(np.diff(position), 1.0 / per_pitch)
    np.testing.assert_allclose(found["hinge_mean"], impulse[3:].sum(axis=0) / 0.8)
    np.testing.assert_array_equal(found["hinge_largest"], peak[2:].max(axis=0))
    np.testing.assert_array_equal(found["hinge_quantiles"][:, 0], force[2:].min(axis=0))
    assert list(found["hinge"]) == list(range(1, LINKS + 1))
    assert found.attrs["revolutions"] == pytest.approx((7.12 - 5.2) / LINKS)


@pytest.mark.parametrize("per_pitch", [1, 3])
def test_loads_along_the_wrap_count_from_where_the_belt_line_meets_the_pitch_circle(run, per_pitch):
    """One and a half pitches more at each end of a wrap that is rounded up to whole pitches."""
    result, force, peak, impulse = random_forces(run, MOVED, TIME, "tooth")
    hinge = np.random.default_rng(6).uniform(1.0, 9.0, force.shape)
    result = replace(result, arrays=result.arrays | {"peak_hinge_impulse": hinge})
    for number, whole in ((1, 10), (3, 2)):
        section = Circuit.of(DRIVE).section(number)
        wrap = section.end - section.begin
        assert whole - 1 < wrap < whole
        found = result.wrap_loads(number, bins_per_pitch=per_pitch, quantiles=(1.0, 0.4))
        members = defaultdict(list)
        bins = (whole + 3) * per_pitch
        for row in range(6):
            for k in range(LINKS):
                along = MIDWAY[row] + k - section.begin
                along -= LINKS * round((along - 0.4 * LINKS) / LINKS)
                members[math.floor((along + 1.5) * per_pitch)].append((row, k))
        check_bins(found, members, bins, force, peak, impulse, (1.0, 0.4))
        for k in range(bins):
            span = sum(SPANS[row] for row, _ in members[k])
            mean = sum(hinge[each] for each in members[k]) / span if span else math.nan
            np.testing.assert_allclose(found["hinge_mean"][k], mean)
        assert float(found["position"][0]) == pytest.approx(-1.5 + 0.5 / per_pitch)
        np.testing.assert_allclose(np.diff(found["position"]), 1.0 / per_pitch)
        assert found.attrs == {"wrap": pytest.approx(wrap), "sprocket": number}


@pytest.fixture(scope="module")
def in_gaps(run):
    """Two bushings in gap 2 of sprocket 2, one in gap 24, one that bounces off between rows."""
    stays = contacts(
        6,
        (1, [1, 2, 3], 2, 2, 4),
        (2, [2, 3, 4], 2, 2, 4),
        (3, [3], 2, 24, 4),
        (4, [3], 1, 24, 1),
        (5, [1, 2], 4, 0, 1),
    )
    rows = {
        # Row 1 of bushing 2 counts in the gap that it is in at row 2.
        "tooth_force": {(1, 1): 5.0, (2, 1): 6.0, (2, 2): 2.0, (3, 2): 3.0, (3, 4): 50.0},
        "peak_tooth_force": {(1, 2): 8.0, (2, 1): 7.0, (2, 2): 4.0, (3, 3): 9.0, (3, 4): 60.0},
        "peak_tooth_impulse": {(1, 2): 0.8, (2, 1): 0.7, (2, 2): 0.4, (3, 3): 0.9, (3, 4): 6.0},
    }
    arrays = {name: table(6, entries) for name, entries in rows.items()}
    return made(run, MOVED, TIME, **stays, **arrays)


def test_between_two_contacts_the_nearer_one_counts_and_of_two_as_near_the_last(run):
    wheel = contacts(7, (1, [0, 5], 1, 3, 1), (2, [0, 4], 1, 3, 1), (3, [6], 1, 3, 1))
    found = nearest_contact(made(run, np.zeros(7), np.arange(7.0), **wheel))
    assert found[:, 0].tolist() == [0, 0, 0, 5, 5, 5, 5]
    assert found[:, 1].tolist() == [0, 0, 0, 4, 4, 4, 4]
    assert found[:, 2].tolist() == [6] * 7
    assert found[:, 3].tolist() == list(range(7))


@pytest.mark.parametrize("per_pitch", [1, 4])
def test_loads_of_teeth_are_gathered_by_the_direction_of_their_gap(in_gaps, per_pitch):
    found = in_gaps.tooth_loads(2, bins_per_pitch=per_pitch, quantiles=(0.0, 0.5, 1.0))
    force, peak, impulse = np.zeros((3, 6, 25))
    force[[1, 2, 3], 2] = 5.0, 8.0, 3.0
    peak[[1, 2], 2] = 8.0, 7.0
    impulse[[1, 2], 2] = 0.8, 1.1
    peak[3, 24], impulse[3, 24] = 9.0, 0.9
    phase = DRIVE.check().phase[1]
    bins = 25 * per_pitch
    members = defaultdict(list)
    for row in range(6):
        turned = phase + 2 * math.pi / 25 * MIDWAY[row]
        for gap in range(25):
            direction = math.degrees(turned) + 360.0 * gap / 25
            members[math.floor(direction % 360.0 / (360.0 / bins))].append((row, gap))
    check_bins(found, members, bins, force, peak, impulse, (0.0, 0.5, 1.0))
    angle = found["angle"].to_numpy()
    assert angle[0] == pytest.approx(math.pi / bins)
    np.testing.assert_allclose(np.diff(angle), 2 * math.pi / bins)
    np.testing.assert_allclose(found["tooth_mean"], impulse.sum(axis=0) / 1.2)
    np.testing.assert_array_equal(found["tooth_largest"], peak.max(axis=0))
    assert list(found["tooth"]) == list(range(25))
    assert found.attrs["revolutions"] == pytest.approx((7.12 - 3.3) / 25)


@pytest.mark.parametrize("wrong", [-0.1, 1.5])
def test_a_quantile_is_a_share(in_gaps, wrong):
    with pytest.raises(rc.InvalidInput, match=rf"quantiles\.2 = {wrong}: must be between 0 and 1"):
        in_gaps.tooth_loads(2, quantiles=(0.5, wrong, 2.0))


def test_loads_of_sprockets_that_are_none_name_the_last(in_gaps):
    for number in (0, 4, 1.0, True):
        with pytest.raises(rc.NoSuchPart, match=r"number of a sprocket, 1 to 3; the loads of"):
            in_gaps.tooth_loads(number)


def laid(run, place, side, angle, moved=0.0):
    """Return the result with a straight chain that passes the first guide at one side.

    The chain runs in the direction `angle`; the guide lies beside it, `place` links ahead of hinge
    1. Links 61 to 63 come to two pitches from the guide on its other side, and turn off. Hinge k is
    the front of link k. The chain has `moved` by so many pitches, as the first sprocket tells.
    """
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    center = np.array(run.drive.guides[0].center)
    number = np.arange(LINKS)
    hinges = center + side * across + PITCH * (number - place)[:, None] * along
    hinges[60:] = center - PITCH * 20.0 * across - PITCH * number[60:, None] * along
    hinges[60] = center - 3.0 * PITCH * across
    hinges[61] = center - 2.0 * PITCH * across
    hinges[62] = hinges[61] - PITCH * along - PITCH * across
    direction = np.arctan2(*(hinges - np.roll(hinges, 1, axis=0)).T[::-1])
    poses = run.initial_positions.copy()
    turn = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    poses[:LINKS, :2] = hinges - 0.5 * PITCH * turn
    poses[:LINKS, 2] = direction
    poses[LINKS, 2] += moved * 2 * math.pi / 17
    start = {"positions": poses, "velocities": run.initial_velocities}
    given = {name: tuple(map(tuple, rows.tolist())) for name, rows in start.items()}
    return replace(run, scene=replace(run.scene, **given))


@pytest.fixture(scope="module")
def on_guides(run):
    """Bushings 25 to 27 on the first guide, 40 on the third, and the first on a sprocket."""
    stays = contacts(
        6,
        (25, [1, 2], 4, 0, 1),
        (26, [2, 3, 4], 4, 0, 1),
        (27, [3], 4, 0, 1),
        (40, [4], 6, 0, 1),
        (1, [1, 2], 1, 3, 1),
    )
    rows = {
        "tooth_force": {
            (1, 25): 0.5, (2, 25): 5.0, (2, 26): 3.0, (3, 26): 7.0, (4, 40): 2.0, (1, 1): 90.0,
        },
        "peak_tooth_force": {
            (1, 25): 6.0, (3, 25): 9.0, (2, 26): 8.0, (3, 27): 1.5, (4, 40): 5.0, (1, 1): 99.0,
        },
        "peak_tooth_impulse": {
            (1, 25): 0.6, (3, 25): 0.9, (2, 26): 0.8, (3, 27): 0.1, (4, 40): 0.5, (1, 1): 9.0,
        },
    }  # fmt: skip
    arrays = {name: table(6, entries) for name, entries in rows.items()}
    return made(run, MOVED, TIME, **stays, **arrays), arrays


@pytest.mark.parametrize(
    ("place", "angle", "moved"), [(26.4, 0.3, 0.0), (25.8, 2.5, 1.7), (3.2, -1.0, -20.3)]
)
@pytest.mark.parametrize("per_pitch", [1, 4])
def test_loads_of_a_guide_count_from_its_middle(on_guides, place, angle, moved, per_pitch):
    """The middle is the foot on the chain at the start; forces after a contact's end are its own.

    Half of 0.1 m is 3.94 pitches: four, and one and a half to either side.
    """
    result, arrays = on_guides
    result = laid(result, place, 0.015, angle, moved)
    found = result.guide_loads("guide_1", bins_per_pitch=per_pitch, quantiles=(0.5, 1.0))
    force, peak, impulse = (array.copy() for array in arrays.values())
    for array in (force, peak, impulse):
        array[:, [0, 39]] = 0.0
    members = defaultdict(list)
    for row in range(6):
        for k in range(LINKS):
            along = MIDWAY[row] + k - place - moved
            along -= LINKS * round(along / LINKS)
            if -5.5 <= along < 5.5:
                members[math.floor((along + 5.5) * per_pitch)].append((row, k))
    check_bins(found, members, 11 * per_pitch, force, peak, impulse, (0.5, 1.0))
    position = found["position"].to_numpy()
    assert position[0] == pytest.approx(-5.5 + 0.5 / per_pitch)
    np.testing.assert_allclose(np.diff(position), 1.0 / per_pitch)
    np.testing.assert_array_equal(found["force"], [0.0, 0.5, 8.0, 7.0, 0.0, 0.0])
    # Bushing 27 and, at the last row, bushing 26 are in contact without a force.
    np.testing.assert_array_equal(found["bushings"], [0, 1, 2, 1, 0, 0])
    np.testing.assert_allclose(found["bushing_mean"], impulse.sum(axis=0) / 1.2)
    np.testing.assert_array_equal(found["bushing_largest"], peak.max(axis=0))
    assert found.attrs == {"guide": 1, "mean_force": pytest.approx(2.4 / 1.2)}
    assert list(found["bushing"]) == list(range(1, LINKS + 1))


def test_the_contact_of_a_smooth_idler_is_at_most_half_its_circumference(on_guides):
    """A radius of 10 mm: half of 31.4 mm is 1.24 pitches, so that two are looked at."""
    result, _ = on_guides
    found = laid(result, 26.4, 0.015, 0.3).guide_loads(3, bins_per_pitch=2)
    assert len(found["position"]) == 14
    assert float(found["position"][0]) == pytest.approx(-3.5 + 0.25)
    assert found.attrs["mean_force"] == pytest.approx(0.5 / 1.2)
    assert float(found["force"].sum()) == 2.0


def test_the_type_of_a_guide_is_checked(on_guides):
    for guide in (True, 1.0, None):
        with pytest.raises(rc.InvalidInput, match=r"guide_loads.*guide"):
            on_guides[0].guide_loads(guide)


@pytest.mark.parametrize("guide", [0, 4, -1, "guide_0", "guide_4", "rail", "guide_x"])
def test_guides_that_are_none_are_refused(on_guides, guide):
    with pytest.raises(rc.InvalidInput, match=r"number of a guide, 1 to 3, or 'guide_1' and so on"):
        on_guides[0].guide_loads(guide)


def test_a_drive_without_guides_has_no_load_of_one(run):
    bare = replace(run, scene=replace(run.scene, system=replace(DRIVE, guides=())))
    with pytest.raises(rc.InvalidInput, match="but the drive has none"):
        bare.guide_loads(1)


def with_jumps(run, *jumps):
    """Return six rows of a chain at rest, and jumps: time, sprocket, direction."""
    time, sprocket, direction = zip(*jumps, strict=True)
    columns = np.array(time), np.array(sprocket, int), np.array(direction, int)
    return replace(made(run, np.zeros(6), TIME), jumps=columns)


def test_jumps_of_a_part_are_those_after_its_first_row_up_to_its_last(run):
    times = (0.5, 0.55, 0.6, 0.9, 1.0, 1.4, 1.5, 1.6)
    result = with_jumps(run, *((time, 1, 1) for time in times))
    assert list(result.tooth_jumps["time"]) == [0.55, 0.6, 0.9, 1.0, 1.4, 1.5, 1.6]
    assert list(result.between(0.6, 1.5).tooth_jumps["time"]) == [0.9, 1.0, 1.4, 1.5]


def test_a_chain_that_jumped_has_no_transmission_error_between_its_sprockets(run):
    result = with_jumps(run, (0.7, 3, -1), (0.8, 2, 1), (1.5, 2, 1), (1.6, 1, -1))
    with pytest.raises(
        rc.InvalidInput,
        match=r"jumped 2 teeth in this part of the run, first on sprocket 2 at t = 0\.8 s",
    ):
        result.transmission_error(driven=2, driver=1, end=1.5)
    with pytest.raises(rc.InvalidInput, match=r"jumped 1 tooth in .* sprocket 3 at t = 0\.7 s"):
        result.transmission_error(driven=3, driver=1, end=1.5)


def test_a_jump_takes_the_displacement_of_the_chain_back_by_a_tooth(run):
    """Of the first sprocket, at rows from the time of the jump on."""
    result = with_jumps(run, (0.7, 1, 1), (0.8, 2, 1), (1.0, 1, 1), (1.6, 1, -1))
    moved = Circuit.of(DRIVE).moved(result)
    np.testing.assert_allclose(moved, [0.0, 0.0, -1.0, -2.0, -2.0, -1.0], atol=1e-12)
    np.testing.assert_array_equal(Circuit.of(DRIVE).moved(replace(result, jumps=None)), moved * 0)


def test_the_path_of_a_chain_that_jumped_is_that_at_a_sprocket_without_jumps(run):
    """Sprocket 1 slips by a tooth in four rows, its jump is counted in the middle of them."""
    row = np.arange(10)
    time, pitches = 0.1 * row, 0.25 * row
    stays = contacts(10, (3, [2, 3, 4, 5], 2, 9, 1))
    smooth = made(run, pitches, time, **stays)
    angle = smooth.array("sprocket_angle").copy()
    angle[:, 0] += 2 * math.pi / 17 * np.clip(0.25 * (row - 2), 0.0, 1.0)
    jumps = np.array([time[4]]), np.array([1]), np.array([1])
    result = replace(made(run, pitches, time, sprocket_angle=angle, **stays), jumps=jumps)
    for each in (smooth, result):
        assert each.hinge_loads().attrs["revolutions"] == pytest.approx(2.25 / LINKS)
        assert list(each.engagements()["pitches"]) == pytest.approx([0.75])


def test_pressures_are_those_of_surfaces_and_materials_in_contact(run):
    """A row of each region of a whole tooth and of each guide; forces 4 and, as peak, 9 N.

    Region 4 is the seat, 3 and 5 are the working curves, 2 and 6 flat; the rest is the topping
    curve. Without a contact a bushing counts as on a seat of the first sprocket, here of ISO 606.
    """
    plate = replace(DRIVE.guides[0], plate_height=0.0116)
    metric = replace(DRIVE.sprockets[0], profile=rc.IsoTooth())
    system = replace(
        DRIVE, guides=(plate, *DRIVE.guides[1:]), sprockets=(metric, *DRIVE.sprockets[1:])
    )
    of_radius = {
        # ANSI B29.1: R = 0.5025 Dr + 0.0015 in, E = 1.3025 Dr + 0.0015 in, Dr = 0.3125 in.
        "seat": 1 / 0.00396875 - 1 / (0.0254 * (0.5025 * 0.3125 + 0.0015)),
        "working": 1 / 0.00396875 - 1 / (0.0254 * (1.3025 * 0.3125 + 0.0015)),
        "flat": 1 / 0.00396875,
        # F = Dr (0.8 cos(18 - 56/n) + 1.4 cos(17 - 64/n) - 1.3025) - 0.0015 in, of n = 13.
        "topping": 1 / 0.00396875 + 1 / 0.006659398557170041,
    }
    names = ["topping", "topping", "flat", "working", "seat", "working", "flat", "topping"]
    names.append("topping")
    stays = [(k + 1, [0, 1], 3, 5, k) for k in range(9)]
    stays += [(11 + k, [0, 1], 4 + k, 0, 1) for k in range(3)]
    force, peak = np.full((2, LINKS), 4.0), np.full((2, LINKS), 9.0)
    peak[1] = 1.0  # the force at the row is larger
    result = made(
        run, [0.0, 1.0], [0.0, 1.0], tooth_force=force, peak_tooth_force=peak, **contacts(2, *stays)
    )
    result = replace(result, scene=replace(run.scene, system=system))
    found = result.contact_pressure("tooth")
    seat = tooth_radii(metric, DRIVE.chain)[0]
    assert seat == pytest.approx(0.505 * 7.9375e-3, rel=0.02)
    curvature = np.full(LINKS, 1 / 0.00396875 - 1 / seat)
    curvature[:9] = [of_radius[name] for name in names]
    curvature[10:13] = 2 / 0.0116, 1 / 0.00396875 + 1 / 0.2, 1 / 0.00396875 + 1 / 0.01
    steel, polymer = (1 - 0.3**2) / 2.07e11, (1 - 0.4**2) / 3e9
    modulus = np.full(LINKS, 1 / (2 * steel))
    modulus[11:13] = 1 / (steel + polymer)
    length = DRIVE.chain.tooth_contact_length
    scale = np.sqrt(curvature * modulus / (math.pi * length))
    np.testing.assert_allclose(found["pressure"], np.tile(2 * scale, (2, 1)))
    np.testing.assert_allclose(found["peak_pressure"], np.stack([3 * scale, 2 * scale]))
    width = 2 * np.sqrt(4.0 / (math.pi * length * curvature * modulus))
    np.testing.assert_allclose(found["half_width"], np.tile(width, (2, 1)))
    assert list(found["bushing"]) == list(range(1, LINKS + 1))
    assert found.attrs["contact_modulus"] == pytest.approx(1 / (2 * steel))


def test_a_chain_without_sprockets_is_pressed_on_flat_faces(run):
    """Where a bushing is in no contact."""
    ends = rc.AnchoredEnd((-0.3, 0.0), links=20), rc.LoadedEnd(5.0, arm=0.08)
    system = rc.open_chain("ANSI 40", ends=ends, links=LINKS, sprockets=[])
    force = np.full((2, LINKS), 4.0)
    result = made(run, [0.0, 1.0], [0.0, 1.0], tooth_force=force)
    result = replace(result, scene=replace(run.scene, system=system))
    modulus = 2.07e11 / (2 * (1 - 0.3**2))
    length = system.chain.tooth_contact_length
    expected = math.sqrt(4.0 * modulus / (math.pi * length * 0.00396875))
    np.testing.assert_allclose(result.contact_pressure("tooth")["pressure"], expected)


def of_hinge(run):
    """Return the pressure of a hinge by its force: pins in bores of 1.98755 and 2.00025 mm."""
    hinge = run.drive.chain.hinge
    curvature = 1 / 0.00198755 - 1 / 0.00200025
    modulus = 2.07e11 / (2 * (1 - 0.3**2))
    return lambda force: np.sqrt(force * modulus * curvature / (math.pi * hinge.length))


def test_a_pressed_surface_takes_no_pull(run):
    """A force that pulls, as damping can, has no pressure."""
    force = np.full((2, LINKS), -4.0)
    result = made(run, [0.0, 1.0], [0.0, 1.0], hinge_force=force)
    found = result.contact_pressure("hinge")
    for name in ("pressure", "half_width", "peak_pressure"):
        assert (found[name] == 0.0).all()


def test_pressures_of_a_part_are_those_of_the_whole(run, in_gaps):
    """Also of a contact that ended before the part; the first row's peak is its own pressure."""
    whole, part = in_gaps.contact_pressure("tooth"), in_gaps.contact_pressure("tooth", start=0.9)
    for name in whole:
        np.testing.assert_array_equal(part[name][1:], whole[name][3:])
    for name in ("pressure", "half_width"):
        np.testing.assert_array_equal(part[name][0], whole[name][2])
    np.testing.assert_array_equal(part["peak_pressure"][0], whole["pressure"][2])


def test_cycles_of_pressure_are_counted_per_revolution_of_the_chain(run):
    """Hinges 1 to 5 are pressed between rows: twice, once, below and above the gate, and held.

    The chain goes 3.82 pitches of 78.
    """
    peak, force = np.zeros((6, LINKS)), np.zeros((6, LINKS))
    peak[[1, 3], 0] = 400.0
    peak[2, 1] = 100.0  # half the pressure
    peak[2, 2] = 400.0 * 0.0099**2
    peak[2, 3] = 400.0 * 0.0101**2
    peak[1:, 4] = force[1:, 4] = 256.0  # 0.8 of the pressure: half a cycle
    result = made(run, MOVED, TIME, hinge_force=force, peak_hinge_force=peak)
    found = result.pressure_cycles("hinge", bins=5)
    turns = (7.12 - 3.3) / LINKS
    assert found.attrs["revolutions"] == pytest.approx(turns)
    expected = np.zeros((LINKS, 5))
    expected[0, 4], expected[1, 2], expected[3, 0] = 2.0, 1.0, 1.0
    expected[4, 4] = 0.5  # the class from 0.8 on
    counted = found["cycles"].to_numpy() * turns
    np.testing.assert_allclose(counted[:4], expected[:4], atol=1e-12)
    assert counted[4].sum() == pytest.approx(0.5)
    assert not counted[5:].any()
    pressure = of_hinge(run)
    np.testing.assert_allclose(found["range"], pressure(400.0) * (np.arange(5) + 0.5) / 5)
    np.testing.assert_allclose(
        found["largest"][:5], pressure(np.array([400.0, 100.0, 0.039204, 0.040804, 256.0]))
    )
    assert list(found["hinge"]) == list(range(1, LINKS + 1))


def test_cycles_in_gaps_are_those_of_whatever_bushing_is_there(in_gaps):
    """Gap 2 of sprocket 2 sees 8 and 7 N between rows, and 5 and 2 N at rows, of two bushings."""
    found = in_gaps.pressure_cycles("tooth", 2, bins=1)
    turns = (7.12 - 3.3) / 25
    assert found.attrs["revolutions"] == pytest.approx(turns)
    # In order: 8, 5, 7, 6, 3, 3. Turning points 0, 8, 5, 7, 0 make a cycle inside another one.
    curvature = 1 / 0.00396875 - 1 / (0.0254 * (0.5025 * 0.3125 + 0.0015))
    assert list(found["tooth"]) == list(range(25))
    assert (found["cycles"][:, 0].to_numpy() > 0.0).sum() == 2
    modulus = 2.07e11 / (2 * (1 - 0.3**2))
    length = DRIVE.chain.tooth_contact_length
    largest = math.sqrt(9.0 * modulus * curvature / (math.pi * length))
    assert float(found["largest"][24]) == pytest.approx(largest)
    assert float(found["cycles"][24, 0]) * turns == pytest.approx(1.0)
    assert float(found["cycles"][2, 0]) * turns == pytest.approx(2.0)


def test_unloaded_contacts_have_no_cycles_and_a_chain_at_rest_has_no_revolution(run):
    found = made(run, MOVED, TIME).pressure_cycles("hinge", bins=2)
    assert not found["cycles"].any()
    rest = made(run, [2.0, 2.0], [0.0, 1.0])
    for asked in (("hinge",), ("tooth",), ("tooth", 2)):
        with pytest.raises(
            rc.InvalidInput, match=r"nothing turns in this part.* of a drive at rest"
        ):
            rest.pressure_cycles(*asked)
