"""Many runs at once: the numbers of single runs, failures that stay alone, Ctrl-C, progress."""

import gc
import json
import signal
import subprocess
import sys
import threading
import time
import warnings
import weakref
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import rustchain as rc

PAPER = rc.paper_drive()
SHORT = {"duration": 5e-3, "report_step": 1e-4, "progress": False}  # contacts begin at 4.1 ms
FAR = 1000.0  # [s], hours of wall time away


def peak(result):
    return result.peaks.tooth_force.max()


def test_an_iterator_of_groups_is_read_once_and_serves_every_case():
    run = {"duration": 2e-4, "progress": False, "threads": 1}
    axes = {"pretension": [0.0, 25.0]}
    swept = rc.sweep(PAPER, axes, lambda r: r.groups, record=iter(["hinges", "teeth"]), **run)
    assert list(swept.values) == [("hinges", "teeth")] * 2
    with pytest.raises(rc.InvalidInput, match=r"record: 1\.0 is no group"):
        rc.sweep(PAPER, axes, lambda r: r.groups, record=iter([1.0]), **run)


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_every_case_is_its_single_run_to_the_last_bit(threads):
    """With pretensions that have and have not a tensioner, and laws and lengths that differ."""
    cases = [
        {"pretension": 0},
        {"pretension": 25},
        {"pretension": 25, "hinge_law": rc.Johnson(), "record": ("hinges", "bodies", "energy")},
        {"speed": 10.0, "rtol": 1e-7, "duration": 3e-3},
        {"pretension": 100.0, "min_impact_velocity": 1e-2, "energy": False},
    ]
    swept = rc.sweep(PAPER, cases, threads=threads, **SHORT)
    assert swept.success
    assert (swept.status, swept.errors, swept.axes) == ("finished", {}, None)
    driver = replace(PAPER.sprockets[0], motion=rc.PrescribedSpeed(10.0))
    slow = replace(PAPER, sprockets=[driver, PAPER.sprockets[1]])
    run = {"duration": 5e-3, "report_step": 1e-4, "progress": False}
    single = [
        rc.Simulation(PAPER).run(**run),
        rc.Simulation(rc.paper_drive(25)).run(**run),
        rc.Simulation(rc.paper_drive(25), hinge_law=rc.Johnson()).run(
            **run, record=("hinges", "bodies", "energy")
        ),
        rc.Simulation(slow, solver=rc.Solver(rtol=1e-7)).run(**(run | {"duration": 3e-3})),
        rc.Simulation(rc.paper_drive(100.0), min_impact_velocity=1e-2).run(**run, energy=False),
    ]
    for one, other in zip(swept.results, single, strict=True):
        assert one == other


def test_a_grid_is_ordered_as_nested_loops_and_measured_in_that_order():
    calls = []

    def measure(result):
        tensioner = result.drive.tensioner
        calls.append(threading.current_thread())
        return (tensioner.pretension if tensioner else 0.0), result.drive.chain.material.restitution

    swept = rc.sweep(
        PAPER,
        # The first cases take longest, so that others finish before them.
        {"pretension": [100, 0], "duration": [4e-3, 1e-4], "chain.material.restitution": [0.5, 1]},
        measure,
        threads=2,
        progress=False,
    )
    assert swept.cases[1] == {
        "pretension": 100,
        "duration": 4e-3,
        "chain.material.restitution": 1,
    }
    assert swept.values == [(p, r) for p in (100, 0) for _ in range(2) for r in (0.5, 1)]
    assert set(calls) == {threading.current_thread()}


# --- parameters


# --- failures


def test_failing_cases_leave_the_others_alone_and_are_told_once():
    cases = [
        {"pretension": 0},
        {"pretension": -1},  # refused as a value
        {"chain.links": 20},  # no initial configuration
        {"chain.material.elastic_modulus": 1e300},  # fails under way, at the first contact
        {"pretension": 25},
    ]
    with pytest.warns(RuntimeWarning) as caught:
        swept = rc.sweep(PAPER, cases, peak, **SHORT)
    assert [warning.filename for warning in caught] == [__file__]
    said = str(caught[0].message)
    assert said.startswith("3 of 5 cases failed, first case 1 (pretension=-1): InvalidInput: Tens")
    assert (swept.status, swept.success) == ("finished", False)
    assert "2 of 5 cases finished, 3 failed" in swept.message
    assert list(swept.errors) == [1, 2, 3]
    assert swept.values[1:4] == [None] * 3
    for place in (0, 4):
        drive = rc.paper_drive(cases[place]["pretension"])
        assert swept.values[place] == peak(rc.Simulation(drive).run(**SHORT))
    assert "Tensioner.pretension = -1" in str(swept.errors[1])
    assert "the chain has no initial configuration" in str(swept.errors[2])
    error = swept.errors[3]
    assert isinstance(error, rc.SimulationError)
    assert error.__notes__[-1].startswith("in case 3 (chain.material.elastic_modulus=1e+300")
    chain = replace(PAPER.chain, material=rc.Material(elastic_modulus=1e300))
    alone = rc.Simulation(replace(PAPER, chain=chain))
    with pytest.raises(rc.SimulationError) as single:
        alone.run(**SHORT)
    assert str(error) == str(single.value)
    assert len(error.result.time) >= 20
    assert error.result == single.value.result


def test_failed_cases_are_nan_in_the_tables():
    with pytest.warns(RuntimeWarning, match="1 of 2 cases failed"):
        swept = rc.sweep(PAPER, {"pretension": [-1, 0]}, lambda r: {"n": len(r.time)}, **SHORT)
    np.testing.assert_array_equal(swept.to_xarray()["n"], [np.nan, 51])
    np.testing.assert_array_equal(swept.to_pandas()["n"], [np.nan, 51])


def test_a_measure_that_raises_is_the_error_of_its_case():
    def measure(result):
        if result.drive.tensioner is None:
            raise LookupError("no tensioner")
        return peak(result)

    with pytest.warns(RuntimeWarning, match="case 1 .*LookupError: 'no tensioner'|no tensioner"):
        swept = rc.sweep(PAPER, {"pretension": [25, 0, 50]}, measure, threads=2, **SHORT)
    assert list(swept.errors) == [1]
    assert isinstance(swept.errors[1], LookupError)
    place, case = swept.errors[1].__notes__
    assert place.startswith("raised at test_sweep.py, line ")
    assert case == "in case 1 (pretension=0) of the sweep"
    assert [value is None for value in swept.values] == [False, True, False]


def test_the_error_of_a_measure_keeps_no_result_in_memory():
    results = []

    def measure(result):
        results.append(weakref.ref(result))
        own = result
        try:
            raise KeyError(own.time.size)
        except KeyError as error:
            raise ValueError("none") from error

    with pytest.warns(RuntimeWarning, match="2 of 2 cases failed"):
        swept = rc.sweep(PAPER, {"rtol": [1e-5, 1e-4]}, measure, **SHORT)
    gc.collect()
    assert [result() for result in results] == [None, None]
    assert swept.errors[0].__notes__[0].startswith("raised at test_sweep.py, line ")


def test_a_sweep_of_which_every_measure_fails_still_has_its_axes():
    with pytest.warns(RuntimeWarning, match="2 of 2"):
        swept = rc.sweep(PAPER, {"rtol": [1e-5, 1e-4]}, lambda r: 1 / 0, duration=1e-4)
    assert dict(swept.to_xarray().sizes) == {"rtol": 2}


def test_laws_out_of_their_range_are_told_once_for_the_whole_sweep():
    drive = rc.two_sprocket_drive(chain="ANSI 160", teeth=(17, 17), links=38)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        swept = rc.sweep(
            drive,
            {"force_law": [rc.Hertz(), rc.EnhancedCylinder()], "speed": [5.0, 6.0]},
            duration=1e-4,
        )
    assert [(w.category, w.filename) for w in caught] == [(rc.RangeWarning, __file__)]
    assert "2 of 4 cases, first case 2 (force_law=EnhancedCylinder(" in str(caught[0].message)
    assert list(swept.law_warnings) == [2, 3]
    assert all("enhanced" in note for notes in swept.law_warnings.values() for note in notes)


# --- under way


def test_others_run_on_while_a_case_is_measured():
    """The first case is measured until the second one, which runs meanwhile, has ended."""
    reached = []

    def callback(simulation):
        reached.append(simulation.time)

    def measure(result):
        if len(measured) == 0:
            while max(reached) < 0.05 - 1e-12:
                time.sleep(1e-3)
        measured.append(result.time[-1])

    measured = []
    axes = {"duration": [1e-3, 0.05]}
    rc.sweep(PAPER, axes, measure, callback=callback, threads=1, progress=False)
    assert measured == [1e-3, 0.05]


def test_an_interrupted_sweep_returns_soon_with_what_has_finished():
    script = f"""
import json, os, signal, threading
import rustchain as rc

# A job in the background is born deaf to it.
signal.signal(signal.SIGINT, signal.default_int_handler)
measured = []
def measure(result):
    measured.append(result.time[-1])
    if len(measured) == 2:
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    return float(result.time[-1])

axes = {{"duration": [1e-3, {FAR}, 2e-3, {FAR}, {FAR}]}}
swept = rc.sweep(rc.paper_drive(), axes, measure, threads=3, record=("energy",), energy=False)
print(json.dumps(dict(
    status=swept.status, message=swept.message, success=swept.success, values=swept.values,
    errors=len(swept.errors), missing=int(swept.to_xarray()["value"].isnull().sum()),
)))
"""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert (said["status"], said["success"], said["errors"]) == ("interrupted", False, 0)
    assert said["message"] == "interrupted: 2 of 5 cases finished, 0 failed"
    assert said["values"] == [1e-3, None, 2e-3, None, None]
    assert said["missing"] == 3


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="no interval timer here")
def test_a_handler_of_ones_own_is_heard_and_ends_the_runs():
    class Alarm(BaseException):
        pass

    def ring(number, frame):
        raise Alarm

    before = signal.signal(signal.SIGALRM, ring)
    threads = threading.active_count()
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(Alarm):
            rc.sweep(
                PAPER, {"duration": [FAR, FAR]}, record=("energy",), energy=False, progress=False
            )
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert threading.active_count() == threads


def test_what_ends_a_sweep_has_the_cases_that_are_done():
    def measure(result):
        if len(result.time) > 11:
            raise SystemExit(3)
        return 1.0

    axes = {"duration": [1e-3, 2e-3, 3e-3]}
    with pytest.raises(SystemExit) as caught:
        rc.sweep(PAPER, axes, measure, threads=1, progress=False)
    found = caught.value.result
    assert (found.status, found.finished, found.values[0]) == ("interrupted", 1, 1.0)


def test_a_warning_raised_as_an_error_has_the_result():
    drive = rc.two_sprocket_drive(chain="ANSI 160", teeth=(17, 17), links=38)
    scene = rc.Scene(drive, rc.EnhancedCylinder())
    with warnings.catch_warnings():
        warnings.simplefilter("error", rc.RangeWarning)
        with pytest.raises(rc.RangeWarning) as caught:
            rc.sweep(scene, {"speed": [5.0]}, duration=1e-4, progress=False)
    assert caught.value.result.finished == 1


@pytest.mark.parametrize("portion", [1, 64])
def test_progress_is_shown_in_cases_and_simulated_seconds(portion, monkeypatch):
    bars = []

    class Bar:
        disable = False

        def __init__(self, **keywords):
            self.n, self.keywords, self.said = 0.0, keywords, []
            bars.append(self)

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def update(self, n):
            assert n >= 0.0
            self.n += n

        def set_description(self, text):
            self.said.append(text)

    monkeypatch.setattr("tqdm.auto.tqdm", Bar)
    monkeypatch.setattr("rustchain.sweeps.running._PORTION", portion)
    rc.sweep(PAPER, {"duration": [1e-3, 2e-3]}, threads=1)
    rc.sweep(PAPER, {"duration": [1e-3]}, progress=False)
    (shown,) = bars
    assert shown.keywords["total"] == pytest.approx(3e-3)
    assert shown.n == pytest.approx(3e-3)
    assert shown.keywords["desc"] == "0 of 2 cases"
    assert shown.said == ["1 of 2 cases", "2 of 2 cases"]
    assert shown.keywords["disable"] is None  # where there is no terminal


def test_without_a_terminal_progress_is_lines_now_and_then(monkeypatch, capsys):
    rc.Simulation(PAPER).run(1e-3)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("rustchain.simulation.run._BETWEEN_LINES", 0.0)
    rc.Simulation(PAPER).run(1e-3, callback=lambda _: None)
    lines = capsys.readouterr().err.splitlines()
    assert 2 <= len(lines) <= 11
    assert lines[0] == "run: 0.0001 of 0.0010 s simulated (10%) in 0 s"
    rc.Simulation(PAPER).run(1e-3, 1e-6, callback=lambda _: None)
    assert 50 < len(capsys.readouterr().err.splitlines()) <= 100
    rc.sweep(PAPER, {"speed": [5.0, 6.0]}, duration=1e-3, callback=lambda _: None, threads=1)
    assert capsys.readouterr().err.splitlines()[-1].startswith("1 of 2 cases: 0.0020 of 0.0020 s")
    rc.Simulation(PAPER).run(1e-3, progress=False)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("sys.stderr", None)
    assert rc.Simulation(PAPER).run(1e-3).success


def test_the_start_is_a_parameter_and_cases_begin_there():
    drive = rc.paper_drive(pretension=100.0)
    found = rc.sweep(drive, {"start": ["generated", "static"]}, duration=5e-4, progress=False)
    for start, result in zip(["generated", "static"], found.values, strict=True):
        alone = rc.Simulation(drive, start=start).run(5e-4, progress=False)
        assert result.drive == alone.drive
        for name, values in alone.arrays.items():
            np.testing.assert_array_equal(result.arrays[name], values, err_msg=name)
    tension = [result.strand("upper").tension[0] for result in found.values]
    assert tension[0] == 0.0
    assert tension[1] > 50.0


def test_positions_and_velocities_of_ones_own_are_keywords_and_parameters():
    calm = rc.Simulation(PAPER)
    pushed = calm.velocities.copy()
    pushed[:38, 0] += 0.1
    found = rc.sweep(
        PAPER, {"velocities": [calm.velocities, pushed]}, duration=2e-4, progress=False
    )
    alone = rc.Simulation(PAPER, velocities=pushed).run(2e-4, progress=False)
    for name, values in alone.arrays.items():
        np.testing.assert_array_equal(found.values[1].arrays[name], values, err_msg=name)
    both = {"positions": calm.positions, "velocities": pushed}
    same = rc.sweep(rc.Scene(PAPER, **both), [{}], duration=2e-4, progress=False)
    np.testing.assert_array_equal(same.values[0].final_positions, alone.final_positions)


def test_a_start_that_ideal_hinges_change_is_told_once_as_by_a_single_run():
    drive = replace(PAPER, hinges="ideal")
    made = rc.Simulation(drive)
    moved = made.positions.copy()
    moved[3, 1] += 1e-3
    scene = rc.Scene(drive, positions=moved, velocities=made.velocities)
    with pytest.warns(UserWarning, match=r"links had to be moved by up to 7\.\d+e-04 m") as caught:
        rc.sweep(scene, {"rtol": [1e-5, 1e-6]}, duration=1e-4, progress=False)
    assert len(caught) == 1


def test_a_start_that_is_none_is_refused():
    with pytest.raises(rc.InvalidInput, match="start = 'rest': must be 'generated' or 'static'"):
        rc.sweep(PAPER, {"start": ["rest"]}, progress=False)


def test_cases_that_are_looked_at_are_those_of_single_runs_to_the_bit():
    drive = rc.paper_drive()
    axes = {"pretension": [0.0, 50.0]}
    plain = rc.sweep(drive, axes, duration=4e-3, progress=False)
    looked = rc.sweep(
        drive, axes, duration=4e-3, progress=False, callback=lambda _: None, threads=2
    )
    for one, other in zip(plain.results, looked.results, strict=True):
        np.testing.assert_array_equal(one.final_positions, other.final_positions)
    assert looked.success


def test_a_stop_condition_ends_its_case_alone():
    axes, given = {"pretension": [0.0, 100.0]}, {"duration": 8e-3, "progress": False}
    peaks = [run.peaks.tooth_force.max() for run in rc.sweep(PAPER, axes, **given).results]
    assert min(peaks) < 0.9 * max(peaks)
    stop = rc.ToothForceAbove(float(np.mean(peaks)))
    found = rc.sweep(PAPER, axes, stop=stop, **given)
    ends = ["stopped" if peak > stop.force else "finished" for peak in peaks]
    assert [run.status for run in found.results] == ends
    stopped = found.results[ends.index("stopped")]
    assert stopped.peaks.tooth_force[-1].max() > stop.force
    assert (stopped.peaks.tooth_force[:-1] <= stop.force).all()
    assert found.success
    with pytest.raises(rc.InvalidInput, match="stop = 3: must be a stop condition"):
        rc.sweep(rc.paper_drive(), {"speed": [1.0]}, stop=3)
    with pytest.raises(rc.InvalidInput, match="threads = 0: must be"):
        rc.sweep(rc.paper_drive(), {"speed": [1.0]}, stop=stop, threads=0)


def test_what_a_callback_raises_fails_its_case_and_leaves_the_others():
    def callback(simulation):
        if simulation.drive.sprockets[0].motion.speed > 15.0 and simulation.time > 1e-3:
            raise RuntimeError("not that fast")

    with pytest.warns(RuntimeWarning, match="1 of 2 cases failed"):
        sweep = rc.sweep(
            rc.paper_drive(),
            {"speed": [10.0, 20.0]},
            duration=3e-3,
            progress=False,
            callback=callback,
        )
    assert list(sweep.errors) == [1]
    assert sweep.results[0].success
    assert len(sweep.errors[1].result.time) == 12


def test_a_simulation_or_a_result_is_no_scene_but_has_one():
    simulation = rc.Simulation(PAPER)
    result = simulation.run(1e-4, progress=False)
    for given, name in ((simulation, "simulation"), (result, "result")):
        for call in (rc.Simulation, lambda given: rc.sweep(given, {"rtol": [1e-5]})):
            with pytest.raises(rc.InvalidInput, match=rf"; use {name}\.scene"):
                call(given)


@pytest.mark.parametrize("side", ["inside", "outside"])
def test_a_loss_map_refuses_a_torque_that_helps(side):
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(20.0)),
        rc.Sprocket(25, (0.3, 0.0), rc.Free() if side == "outside" else rc.AppliedTorque(-2.0)),
        rc.Sprocket(
            13, (0.15, 0.03), rc.AppliedTorque(2.0) if side == "outside" else rc.Free(),
            side="outside",
        ),
    ]  # fmt: skip
    drive = rc.chain_drive("ANSI 40", sprockets, adjust=2)
    loaded, helping = (3, -2.0) if side == "outside" else (2, 2.0)
    with pytest.raises(rc.InvalidInput, match=f"turns sprocket {loaded} the way it goes"):
        rc.loss_map(drive, [20.0], [helping], loaded=loaded, duration=1e-3, burn_in=5e-4)
    with pytest.raises(rc.InvalidInput, match="sprocket 1 is the driver"):
        rc.loss_map(drive, [20.0], [-2.0], loaded=1, duration=1e-3, burn_in=5e-4)


def test_a_data_frame_of_cases_is_refused_with_what_to_take():
    table = pd.DataFrame({"pretension": [25.0, 50.0]})
    with pytest.raises(rc.InvalidInput, match=r"of a DataFrame take \.to_dict\('records'\)"):
        rc.sweep(rc.paper_drive(), table, duration=1e-3)
    cases = table.to_dict("records")
    found = rc.sweep(rc.paper_drive(), cases, duration=1e-3, progress=False)
    assert found.cases == cases
