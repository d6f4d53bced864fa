"""Runs that end before their time: stop conditions, and callbacks at the rows."""

from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

import rustchain as rc

DURATION = 0.01  # [s]


def start():
    return rc.Simulation(rc.paper_drive(pretension=25.0))


@pytest.fixture(scope="module")
def whole():
    """The run that the others end before its end."""
    return start().run(DURATION, progress=False)


def stopped(stop, **keywords):
    return start().run(DURATION, progress=False, stop=stop, **keywords)


def assert_begins_like(result, whole):
    for name, values in result.arrays.items():
        np.testing.assert_array_equal(values, whole.arrays[name][: len(values)], err_msg=name)


@pytest.mark.parametrize(
    ("condition", "channel"),
    [(rc.ToothForceAbove, "tooth_force"), (rc.HingeForceAbove, "hinge_force")],
)
def test_a_run_stops_at_the_first_row_after_a_force_above_the_limit(whole, condition, channel):
    forces = getattr(whole.peaks, channel)
    limit = 0.5 * forces.max()
    first = int((forces > limit).any(axis=1).argmax())
    assert 0 < first < len(whole.time) - 1
    result = stopped(condition(limit))
    assert (result.status, result.success) == ("stopped", True)
    assert len(result.time) == first + 1
    number = int(forces[first].argmax()) + 1
    assert f"{number} had a force of {forces[first].max():.4g} N" in result.message
    assert_begins_like(result, whole)


def test_one_hinge_can_be_watched_alone(whole):
    forces = whole.peaks.hinge_force
    quiet = int(forces.max(axis=0).argmin())
    limit = forces[:, quiet].max() * 1.001
    assert (forces > limit).any()
    assert stopped(rc.HingeForceAbove(limit, hinge=quiet + 1)).status == "finished"
    assert stopped(rc.HingeForceAbove(0.5 * limit, hinge=quiet + 1)).status == "stopped"


def test_a_slack_strand_stops_where_it_has_been_slack_for_as_long_as_asked(whole):
    # Before the tensioner has pulled, nothing is in contact: both are slack from the first row on.
    assert len(stopped(rc.StrandSlack(from_start=True)).time) == 1
    lasting = stopped(rc.StrandSlack(strand="lower", lasting=1e-3, from_start=True))
    assert lasting.time[-1] == pytest.approx(1e-3)
    assert "strand 'lower' is slack for 0.001 s" in lasting.message
    most = whole.strand("upper").tension.max()
    assert stopped(rc.StrandSlack(2 * most, "upper", 5e-3, from_start=True)).time[-1] == (
        pytest.approx(5e-3)
    )


def test_a_strand_is_not_slack_before_it_has_been_tight(whole):
    tension = np.stack([whole.strand(name).tension for name in whole.strand_names], axis=-1)
    limit = 0.3 * tension.max()
    tight = np.logical_or.accumulate(tension > limit, axis=0)
    loose = (tight & (tension <= limit)).any(axis=1)
    found = stopped(rc.StrandSlack(limit))
    assert loose.argmax() > 0
    assert len(found.time) == loose.argmax() + 1
    # One that is never tight never stops a run.
    assert stopped(rc.StrandSlack(2 * tension.max())).status == "finished"


@pytest.mark.parametrize(("limit", "tight"), [(0.0, 1e-300), (2.0, 2.5)])
def test_a_strand_is_slack_from_the_first_row_without_more_than_the_limit(limit, tight):
    """The upper strand becomes tight at 1 ms, slack at 2 ms, tight for a row, and slack again."""
    told = []
    for lasting in (0.0, 2e-3):
        rows = []
        core = SimpleNamespace(last_row=lambda _, rows=rows: rows[-1])
        simulation = SimpleNamespace(drive=rc.paper_drive(), time=0.0, _core=core)
        look = rc.StrandSlack(limit, lasting=lasting).look_at(simulation)
        for k, upper in enumerate([limit, tight, limit, limit, tight, limit, limit, limit]):
            simulation.time = 1e-3 * k
            rows.append((upper, limit))
            if said := look():
                told.append((k, said))
    assert [k for k, _ in told] == [2, 3, 5, 6, 7, 7]
    assert {said.partition(" is slack")[0] for _, said in told} == {"strand 'upper'"}
    assert told[-1][1].startswith("strand 'upper' is slack for 0.002 s: its tension is ")


def test_a_time_is_that_of_the_simulation_and_the_first_of_several_conditions_counts():
    simulation = start()
    simulation.step_to(2e-3)
    conditions = [rc.TimeReached(5e-3), rc.TimeReached(4e-3), rc.ToothForceAbove(1e9)]
    result = simulation.run(DURATION, progress=False, stop=conditions)
    assert result.time[-1] == pytest.approx(4e-3)
    assert result.message == "stopped at t = 0.004 s: reached 0.004 s"


def test_all_that_stops_a_run_at_one_row_is_told():
    stop = [rc.TimeReached(1e-3), rc.TimeReached(2e-3), rc.TimeReached(0.9995e-3)]
    result = start().run(DURATION, 1e-3, progress=False, stop=stop, callback=lambda _: True)
    assert result.message == "stopped at t = 0 s: the callback returned True"
    result = start().run(
        DURATION, 1e-3, progress=False, stop=stop, callback=lambda s: s.time > 9e-4
    )
    told = "reached 0.001 s; reached 0.0009995 s; the callback returned True"
    assert result.message == f"stopped at t = 0.001 s: {told}"


def test_progress_counts_what_a_continued_run_has_simulated(monkeypatch):
    counted = []

    @contextmanager
    def counts(total, progress):
        bar = SimpleNamespace(n=0.0, total=total)
        bar.update = lambda n: setattr(bar, "n", bar.n + n)
        yield bar
        counted.append((bar.n, bar.total))

    monkeypatch.setattr("rustchain.simulation.recording.seconds_bar", counts)
    simulation = start()
    for duration in (2e-3, 1e-3):
        simulation.run(duration, progress=False)
    assert counted == [pytest.approx((2e-3, 2e-3)), pytest.approx((1e-3, 1e-3))]


def test_a_time_is_reached_to_rounding():
    look = rc.TimeReached(0.3).look_at
    for time, said in ((np.nextafter(0.3, 0.0), "reached 0.3 s"), (0.3 - 1e-9, None)):
        assert look(SimpleNamespace(time=time))() == said


def test_a_stopped_simulation_goes_on_as_if_it_had_never_stopped(whole):
    simulation = start()
    simulation.run(DURATION, progress=False, stop=rc.TimeReached(5.1e-3))
    rest = simulation.run(DURATION - simulation.time, progress=False)
    np.testing.assert_array_equal(rest.final_positions, whole.final_positions)


def test_a_callback_sees_every_row_at_its_time_and_leaves_the_path_alone(whole):
    seen = []
    result = start().run(
        DURATION,
        progress=False,
        callback=lambda simulation: seen.append((simulation.time, simulation.positions[-1, 2])),
    )
    assert_begins_like(result, whole)
    assert result.stats["steps"] == whole.stats["steps"]
    times, angles = np.transpose(seen)
    np.testing.assert_array_equal(times, whole.time)
    np.testing.assert_array_equal(angles, whole.sprocket(2).angle)


def test_a_callback_that_returns_true_stops_the_run():
    result = start().run(DURATION, progress=False, callback=lambda s: s.time > 3.05e-3)
    assert result.message == "stopped at t = 0.0031 s: the callback returned True"


@pytest.mark.parametrize("truth", [np.True_, True])
def test_truth_values_of_numpy_stop_too(truth):
    assert len(start().run(DURATION, progress=False, callback=lambda _: truth).time) == 1


@pytest.mark.parametrize("answer", [1, "yes", [0.0], np.ones(1, bool)])
def test_what_only_counts_as_true_stops_no_run(answer):
    run = start().run(2e-4, progress=False, callback=lambda _: answer)
    assert run.status == "finished"


def test_what_a_callback_raises_keeps_the_rows_and_the_simulation():
    simulation = start()

    def fails(simulation):
        if simulation.time > 3.05e-3:
            raise ZeroDivisionError("no more")

    with pytest.raises(ZeroDivisionError, match="no more") as caught:
        simulation.run(DURATION, progress=False, callback=fails)
    assert caught.value.result.status == "failed"
    assert len(caught.value.result.time) == 32
    assert simulation.time == pytest.approx(3.1e-3)
    assert simulation.run(1e-3, progress=False).success


@pytest.mark.parametrize(
    "move", [lambda s: s.step_to(1.0), lambda s: s.run(1.0), lambda s: s.set_state(s.state())]
)
def test_a_callback_cannot_move_the_simulation(move):
    with pytest.raises(rc.InvalidInput, match="under way"):
        start().run(DURATION, progress=False, callback=move)


def test_ctrl_c_in_a_callback_keeps_the_rows():
    def interrupts(simulation):
        if simulation.time > 2.05e-3:
            raise KeyboardInterrupt

    assert len(start().run(DURATION, progress=False, callback=interrupts).time) == 22


def test_ideal_hinges_stop_likewise():
    def ideal(**keywords):
        simulation = rc.Simulation(rc.paper_drive(hinges="ideal"))
        return simulation.run(3e-3, 1e-4, progress=False, **keywords)

    whole = ideal()
    limit = 0.5 * whole.peaks.hinge_force.max()
    first = int((whole.peaks.hinge_force > limit).any(axis=1).argmax())
    result = ideal(stop=[rc.HingeForceAbove(limit), rc.ToothForceAbove(1e9)])
    assert len(result.time) == first + 1
    most = whole.strand("upper").tension.max()
    slack = ideal(stop=rc.StrandSlack(1.01 * most, "upper", 1e-3, from_start=True))
    assert slack.time[-1] == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: stopped(rc.HingeForceAbove(1.0, hinge=39)), "number from 1 to 38"),
        (lambda: stopped(rc.StrandSlack(strand="uper")), "did you mean 'upper'"),
        (lambda: stopped(3), "stop = 3: must be a stop condition"),
        (lambda: stopped(lambda _: True), "must be .*; a function of your own goes into callback="),
        (lambda: stopped([lambda s: True]), "goes into callback="),
        (lambda: stopped(rc.ToothForceAbove(1.0), record=["hinges"]), "add 'teeth' to record"),
        (lambda: stopped((), callback=3), "callback = 3"),
    ],
)
def test_what_means_nothing_is_refused_before_any_step(call, text):
    with pytest.raises(rc.InvalidInput, match=text):
        call()


def test_conditions_of_mechanisms_look_at_the_joints_of_ideal_hinges():
    def ideal(**keywords):
        simulation = rc.Simulation(rc.paper_drive(pretension=25.0).to_mechanism(hinges="ideal"))
        return simulation.run(2e-3, report_step=1e-4, progress=False, **keywords)

    whole = ideal()
    peaks = whole.peaks.joint_force[:, whole.joint_names.index("hinge_6")]
    limit = 0.5 * peaks.max()
    first = int((peaks > limit).argmax())
    result = ideal(stop=rc.JointForceAbove(limit, joint="hinge_6"))
    assert len(result.time) == first + 1
    assert "joint 'hinge_6' had a force of" in result.message
    never = ideal(stop=rc.ContactForceAbove(1e9, contact="bushing_6_on_sprocket_2"))
    assert never.status == "finished"


@pytest.mark.parametrize(
    ("condition", "part"), [(rc.JointForceAbove, "joint"), (rc.ContactForceAbove, "contact")]
)
def test_a_force_equal_to_the_limit_is_not_above_it(condition, part):
    forces = {f"peak_{part}_force": np.array([9.0, 5.0, 5.25])}
    simulation = SimpleNamespace(
        _core=SimpleNamespace(last_row=forces.get), **{f"{part}_names": ("a", "b", "c")}
    )
    for name, expected in (
        (None, f"{part} 'a' had a force of 9 N, above 5 N"),
        ("b", None),
        ("c", f"{part} 'c' had a force of 5.25 N, above 5 N"),
    ):
        assert condition(5.0, name).look_at(simulation)() == expected
    drive = SimpleNamespace(hinge_count=3, ends=None, chain=SimpleNamespace(links=3))
    for of_drive, channel, one in (
        (rc.HingeForceAbove, "peak_hinge_force", "hinge 3"),
        (rc.ToothForceAbove, "peak_tooth_force", "bushing 3"),
    ):
        core = SimpleNamespace(last_row={channel: np.array([9.0, 5.0, 5.25])}.get)
        simulation = SimpleNamespace(drive=drive, _core=core)
        assert of_drive(5.0, 2).look_at(simulation)() is None
        said = f"{one} had a force of 5.25 N, above 5 N"
        assert of_drive(5.0, 3).look_at(simulation)() == said
        assert of_drive(9.0).look_at(simulation)() is None


def test_conditions_of_mechanisms_say_what_drives_want_instead():
    for condition, instead in (
        (rc.JointForceAbove(1.0), "HingeForceAbove"),
        (rc.ContactForceAbove(1.0), "ToothForceAbove"),
    ):
        for stop in (condition, [condition]):
            with pytest.raises(rc.InvalidInput, match=f"has no .*; take {instead}"):
                stopped(stop)
