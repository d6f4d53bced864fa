"""Parts of a result: `between`, and `start` and `end` of the outputs, beside the whole."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import rustchain as rc
from checks.hand_made import THREE, made
from rustchain.analysis.window import rows_between

EVERYTHING = ("hinges", "teeth", "sprockets", "bodies", "energy")
START = 0.0101  # [s]


def guided():
    """Two sprockets, gravity, and a blade that presses the slack lower strand upward."""
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 17), links=60, center_distance=0.2715, speed=10.0, torque=-1.0
    )
    arm = rc.GuideArm((0.055, -0.075), force=40.0, ramp_time=2e-3)
    blade = rc.GuideRail((0.136, -0.07), (0.0, 1.0), length=0.12, radius=0.25, arm=arm)
    return replace(drive, gravity=(0.0, -9.81), guides=[blade])


@pytest.fixture(scope="module", params=["static", "generated"])
def run(request):
    """A run with the default record: without bodies."""
    return rc.Simulation(guided(), start=request.param).run(0.03, progress=False)


@pytest.fixture(scope="module")
def part(run):
    return run.between(START)


def test_a_part_without_bodies_has_a_report(part, tmp_path):
    path = tmp_path / "report.html"
    part.report(path)
    text = path.read_text(encoding="utf-8")
    assert '<figure class="drive">' in text
    assert "nan" not in text.partition("<details>")[0]


def test_a_part_without_bodies_has_no_picture_where_no_state_is_known(run, part):
    for time in (None, START, 0.0125):
        with (
            warnings.catch_warnings(action="error"),
            pytest.raises(rc.NotRecorded, match="bodies were not recorded"),
        ):
            part.plot.drive(time)
    assert part.plot.drive(0.03).axes[0].get_title() == run.plot.drive(0.03).axes[0].get_title()


def test_peaks_and_impulses_of_a_part_begin_at_its_first_row(run, part):
    first = len(run.time) - len(part.time)
    peaks = [name for name in run.arrays if name.startswith("peak_")]
    assert len(peaks) == 4
    for name in peaks:
        np.testing.assert_array_equal(part.array(name)[1:], run.array(name)[first + 1 :])
        expected = 0.0
        if name.endswith("_force"):
            expected = part.array(name.removeprefix("peak_"))[0]
            assert (run.array(name)[first] > expected).any()
        np.testing.assert_array_equal(part.array(name)[0], expected)
    np.testing.assert_array_equal(run.between(end=0.01).array(peaks[0])[0], run.array(peaks[0])[0])


def test_joints_and_contacts_of_a_part_have_no_impact_before_it():
    mechanism = rc.Mechanism()
    mechanism.add_body("ball", 1.0, 1e-3, position=(0.0, 0.06, 0.0))
    mechanism.add_body("bar", 0.2, 2e-4, position=(1.05, 0.0, 0.0))
    mechanism.add_revolute("bearing", "ground", "bar", at=(1.0, 0.0))
    law, floor = rc.LinearContact(1e5, 20.0), [(0.5, 0.0), (-0.5, 0.0)]
    mechanism.add_outline_contact("floor", "ground", "ball", floor, 0.05, law, closed=False)
    whole = rc.Simulation(mechanism).run(0.1, progress=False)
    hit = int(whole.array("contact_impact_velocity")[:, 0].argmax())
    part = whole.between(whole.time[hit])
    names = ("contact_impact_velocity", "peak_contact_impulse", "peak_joint_impulse")
    for name in names:
        assert whole.array(name)[hit] > 0.0
        assert part.array(name)[0] == 0.0
    assert part.array("peak_contact_force")[0] == part.array("contact_force")[0]


def test_sums_of_energy_in_a_part_begin_with_zero_and_levels_do_not(run, part):
    first = len(run.time) - len(part.time)
    levels = {f"energy_{name}" for name in ("kinetic", "gravity", "elastic")}
    sums = {name for name in run.arrays if name.startswith("energy_")} - levels
    assert {"energy_dissipated", "energy_external_work", "energy_residual"} < sums
    for name in sums:
        values = run.array(name)[first:]
        np.testing.assert_array_equal(part.array(name), values - values[0])
    for name in levels:
        np.testing.assert_array_equal(part.array(name), run.array(name)[first:])
    xr.testing.assert_allclose(part.power_balance(), run.power_balance(start=START), atol=1e-9)


def same(part, whole):
    """Assert that two datasets are equal, attributes too."""
    xr.testing.assert_allclose(part, whole, rtol=1e-12)
    assert part.attrs == pytest.approx(whole.attrs)


def test_loads_of_a_part_are_those_of_the_whole_from_start_to_end(run):
    span = {"start": START, "end": 0.0251}
    part = run.between(**span)
    same(part.hinge_loads(), run.hinge_loads(**span))
    same(part.pressure_cycles("hinge"), run.pressure_cycles("hinge", **span))
    figures, expected = part.summary(), run.summary(**span)
    for name in ("hinge_force_p99", "hinge_force_largest", "tooth_force_p99", "loss"):
        assert figures[name] == pytest.approx(expected[name])


def test_the_mean_of_a_load_is_the_impulse_after_the_first_row_over_the_time(run):
    first = rows_between(run, START, None).start
    impulse = run.array("peak_hinge_impulse")[first + 1 :].sum(axis=0)
    expected = impulse / (run.time[-1] - run.time[first])
    np.testing.assert_allclose(run.hinge_loads(start=START)["hinge_mean"], expected)
    np.testing.assert_allclose(run.between(START).hinge_loads()["hinge_mean"], expected)


@pytest.mark.parametrize("record", [None, EVERYTHING])
@pytest.mark.parametrize("start", ["static", "generated"])
def test_loads_of_a_guide_in_a_part_are_those_of_the_whole(record, start):
    given = {} if record is None else {"record": record}
    run = rc.Simulation(guided(), start=start).run(0.03, progress=False, **given)
    found, whole = run.between(START).guide_loads(), run.guide_loads(start=START)
    same(found, whole)
    assert found.attrs["mean_force"] > 1.0
    assert np.isfinite(found["mean"]).any()


def test_a_single_row_has_forces_and_no_mean(run):
    row = {"start": run.time[50], "end": run.time[50]}
    for found, part in ((run.hinge_loads(**row), "hinge"), (run.tooth_loads(1, **row), "tooth")):
        assert np.isnan(found[f"{part}_mean"]).all()
        assert np.isfinite(found[f"{part}_largest"]).all()
    assert np.isnan(run.guide_loads(**row).attrs["mean_force"])


# --- rows


@pytest.fixture(scope="module")
def short():
    return rc.Simulation(THREE).run(1e-3, record=EVERYTHING, progress=False)


def test_a_row_within_rounding_of_an_end_is_in_the_part(short):
    time = [0.01, math.nextafter(0.02, 0.0), math.nextafter(0.03, 1.0), 0.04]
    result = made(short, np.zeros(4), time)
    assert rows_between(result, None, 0.03) == slice(0, 3)
    assert rows_between(result, 0.02, None) == slice(1, 4)
    assert rows_between(result, 0.02, 0.03) == slice(1, 3)
    assert rows_between(result, 0.02 + 1e-9, 0.03 - 1e-9 + 1e-8) == slice(2, 3)
    with pytest.raises(rc.InvalidInput, match="no rows there"):
        rows_between(result, 0.021, 0.029)
    with pytest.raises(rc.InvalidInput, match=r"start=0\.03, end=0\.02: start is after end"):
        rows_between(result, 0.03, 0.02)


# --- reversals


@pytest.mark.parametrize(
    ("output", "arguments", "pitches"),
    [
        ("hinge_loads", (), 78),
        ("pressure_cycles", ("hinge",), 78),
        ("pressure_cycles", ("tooth",), 78),
        ("tooth_loads", (2,), 25),
        ("pressure_cycles", ("tooth", 2), 25),
    ],
)
def test_revolutions_count_the_path_forward_and_back(short, output, arguments, pitches):
    """Five pitches forward, six back; a part has the last four."""
    result = made(short, [0.0, 3.0, 5.0, 3.0, 1.0, -1.0], 0.1 * np.arange(6))
    found = getattr(result, output)(*arguments)
    assert found.attrs["revolutions"] == pytest.approx(11.0 / pitches)
    late = getattr(result, output)(*arguments, start=0.3)
    assert late.attrs["revolutions"] == pytest.approx(4.0 / pitches)


def contacts(rows, stays):
    """Return the arrays of stays: bushing, rows, sprocket, gap."""
    arrays = {name: np.zeros((rows, 78), np.int32) for name in ("sprocket", "index", "region")}
    for number, at, *values in stays:
        for array, value in zip(arrays.values(), (*values, 2), strict=True):
            array[list(at), number - 1] = value
    return {f"tooth_{name}": array for name, array in arrays.items()}


def test_an_impact_and_an_episode_of_a_chain_that_turns_back_are_as_long_as_its_path(short):
    """A quarter pitch a row, forward to row 3 and then back: the impact has rows 2 and 3."""
    pitches = 0.25 * np.array([0, 1, 2, 3, 2, 1, 0, -1, -2, -3])
    impulse = np.tile(2.0 ** np.arange(10)[:, None], 78)
    result = made(
        short,
        pitches,
        0.1 * np.arange(10),
        peak_tooth_impulse=impulse,
        **contacts(10, [(4, range(2, 9), 1, 5)]),
    )
    (found,) = result.engagements().to_dict("records")
    assert found["pitches"] == pytest.approx(0.25 * 6)
    assert found["impulse"] == 2.0**2 + 2.0**3


# --- engagements


@pytest.fixture(scope="module")
def turning():
    """Thirteen pitches come into each sprocket, after a static start that moved a tensioner."""
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=60.0, torque=-2.0, pretension=60.0
    )
    return rc.Simulation(drive, start="static").run(0.08, progress=False)


@pytest.mark.parametrize("start", [0.01, 0.023, 0.037, 0.0512])
def test_engagements_of_a_part_are_those_of_the_whole_in_that_time(turning, start):
    whole = turning.engagements()
    expected = whole[whole["time"] >= start].reset_index(drop=True)
    assert 6 < len(expected) < len(whole)
    pd.testing.assert_frame_equal(turning.engagements(start=start), expected)
    until = turning.engagements(start=start, end=0.07)
    pd.testing.assert_frame_equal(until, expected[expected["time"] <= 0.07])
    # A part does not know whether a bushing in flight at an end of a wrap has been in contact.
    found = turning.between(start).engagements()
    assert abs(len(found) - len(expected)) <= 1
    pitch = 2 * math.pi / 17 / 60.0  # [s]
    late, known = (each[each["time"] > start + pitch] for each in (found, expected))
    pd.testing.assert_frame_equal(late.reset_index(drop=True), known.reset_index(drop=True))


def test_engagements_do_not_depend_on_the_report_step():
    """At 1000 rpm bushings bounce by up to 0.8 pitches: rows show some only in a later contact."""
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=rc.rpm(1000), torque=-4.0, pretension=100.0
    )
    means = []
    for report_step in (1e-5, 1e-4, 2e-4, 5e-4):
        result = rc.Simulation(drive).run(
            0.2, report_step, record=("teeth", "sprockets"), progress=False
        )
        found = result.between(0.12).engagements()
        means.append(found[["force", "largest_force", "impulse", "pitches"]].mean())
    assert means[0]["force"] > 500.0
    for mean in means[1:]:
        np.testing.assert_allclose(mean, means[0], rtol=0.05)


def test_a_bushing_in_flight_at_the_first_row_of_a_part_continues_its_episode(short):
    """Bushing 4 lifts off before the part and returns; 30 comes into sprocket 2 within it."""
    stays = contacts(8, [(4, [1, 2, 5, 6], 1, 5), (30, [6, 7], 2, 9)])
    result = made(short, 0.05 * np.arange(8), 0.1 * np.arange(8), **stays)
    assert list(result.engagements()["bushing"]) == [4, 30]
    for late in (result.engagements(start=0.35), result.between(0.35).engagements()):
        assert list(late["bushing"]) == [30]


def test_the_load_along_a_wrap_is_that_of_its_teeth(short):
    """Beside the wrap, bushing 1 touches a rail; bushing 5 touches teeth, 6 between rows alone."""
    rail = rc.GuideRail((0.16, -0.2), (0.0, 1.0), length=0.1)
    system = replace(THREE, guides=[rail])
    force = np.zeros((4, 78))
    force[:, [0, 4, 5]] = 100.0, 3.0, 2.0
    result = made(
        short,
        np.zeros(4),
        0.1 * np.arange(4),
        tooth_force=force,
        peak_tooth_force=force,
        peak_tooth_impulse=0.1 * force,
        **contacts(4, [(1, range(4), 4, 0), (5, range(4), 1, 7)]),
    )
    result = replace(result, scene=replace(result.scene, system=system))
    found = result.wrap_loads(1, bins_per_pitch=1)
    assert found["largest"].max() == 3.0
    mean = found["mean"].to_numpy()
    np.testing.assert_allclose(np.sort(mean[mean > 0.0]), 0.4 / 0.3 * np.array([2.0, 3.0]))


def test_a_run_from_given_positions_counts_no_seated_bushing_as_an_engagement():
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=40.0, torque=-3.0, pretension=60.0
    )
    simulation = rc.Simulation(drive)
    simulation.step_to(0.16)
    drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.0))
    place = {"positions": simulation.positions, "velocities": simulation.velocities}
    again = rc.Simulation(drive, **place).run(3e-3, progress=False)
    continued = simulation.run(3e-3, progress=False)
    assert len(again.engagements()) == len(continued.engagements()) == 0
