"""The store of a sweep: nothing runs twice, all that changes a case makes it another one."""

import sys
import types
import warnings
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor

import numpy as np
import pytest

import load
import rustchain as rc

PAPER = rc.paper_drive()
SHORT = {"duration": 5e-3, "progress": False}
AXES = {"pretension": [0, 25], "speed": [10.0, 12.0]}
FAILING = {"chain.material.elastic_modulus": [1e300, 2e11]}
LIMIT = 1.0


counter = types.ModuleType("counter")  # of a module, the name counts alone
counter.calls = 0


class Counted:
    """A measure that counts its calls, which are no part of what it is."""

    def __call__(self, result):
        counter.calls += 1
        return {
            "peak": result.peaks.tooth_force.max(),
            "N/m (mean)": result.strand("upper").tension[-3:],
            "rows": len(result.time),
            "high": bool(result.peaks.tooth_force.max() > LIMIT),
            "none": None,
        }


def counted(*arguments, **keywords):
    before = counter.calls
    found = rc.sweep(*arguments, **keywords)
    return found, counter.calls - before


def assert_same(one, other):
    for value, expected in zip(one.values, other.values, strict=True):
        assert value.keys() == expected.keys()
        for name in value:
            np.testing.assert_array_equal(value[name], expected[name])


def test_what_is_stored_is_not_run_again_and_has_the_same_bits(tmp_path):
    plain = rc.sweep(PAPER, AXES, Counted(), **SHORT)
    first, ran = counted(PAPER, AXES, Counted(), store=tmp_path, **SHORT)
    assert ran == 4
    assert len(list(tmp_path.iterdir())) == 4
    second, again = counted(PAPER, AXES, Counted(), store=str(tmp_path), **SHORT)
    assert again == 0
    for value, other in zip(first.values, second.values, strict=True):
        assert {n: type(v) for n, v in value.items()} == {n: type(v) for n, v in other.items()}
        assert (type(value["rows"]), type(value["high"])) == (int, bool)
        assert np.isnan(value["none"])
    assert_same(first, second)
    for value in plain.values:
        value["none"] = np.nan
    assert_same(first, plain)
    assert second.success
    more, ran = counted(PAPER, AXES | {"speed": [12.0, 14.0]}, Counted(), store=tmp_path, **SHORT)
    assert ran == 2  # of 14 rad/s alone
    assert more.values[0]["peak"] == first.values[1]["peak"]


@pytest.mark.parametrize(
    "change",
    [
        {"duration": 4e-3},
        {"report_step": 5e-4},
        {"energy": False},
        {"record": ("teeth", "hinges")},
        {"stop": rc.TimeReached(3e-3)},
        {"callback": lambda _: False},
    ],
    ids=lambda change: next(iter(change)),
)
def test_another_run_is_another_case(change, tmp_path):
    axes = {"pretension": [0]}
    _, ran = counted(PAPER, axes, Counted(), store=tmp_path, **SHORT)
    _, other = counted(PAPER, axes, Counted(), store=tmp_path, **(SHORT | change))
    assert (ran, other) == (1, 1)
    assert len(list(tmp_path.iterdir())) == 2


def test_whole_numbers_are_the_same_case_as_integers(tmp_path):
    cases = [
        {"pretension": 25, "duration": 1e-3},
        {"speed": 10, "gravity.2": 0, "duration": 1e-3},
        {"sprockets.2.mass": 1, "report_step": 1, "duration": 1e-3},
        {"chain.seed": 2**32 - 1, "chain.pitch_spread": 1e-4, "duration": 1e-3},
    ]
    floats = [{n: v if n == "chain.seed" else float(v) for n, v in case.items()} for case in cases]
    for axes in (cases, floats):
        found, _ = counted(PAPER, axes, lambda r: r.time[-1], store=tmp_path, progress=False)
        assert found.success
    assert len(list(tmp_path.iterdir())) == 4


def test_groups_in_another_order_and_by_default_are_the_same_case(tmp_path):
    for record in (None, ("energy", "sprockets", "teeth", "hinges")):
        found, _ = counted(PAPER, {"rtol": [1e-5]}, Counted(), store=tmp_path, record=record,
                           **SHORT)  # fmt: skip
        assert found.success
    assert len(list(tmp_path.iterdir())) == 1


def test_results_themselves_are_stored_and_read_when_asked_for(tmp_path):
    kept = rc.sweep(PAPER, AXES, **SHORT)
    for _ in range(2):
        stored = rc.sweep(PAPER, AXES, store=tmp_path, **SHORT)
        assert len(stored.results) == 4
        for one, other in zip(stored.results, kept.results, strict=True):
            assert one == other
    (path, *_) = stored.values.paths
    assert rc.load_result(path).drive == kept.results[0].drive
    assert [result.time[-1] for result in stored.results[1:3]] == [5e-3, 5e-3]


def test_a_failed_case_has_no_result_in_a_store(tmp_path):
    for _ in range(2):
        with pytest.warns(rc.CaseWarning, match="1 of 2 cases failed"):
            found = rc.sweep(PAPER, FAILING, store=tmp_path, **SHORT)
        for results in (found.results, rc.load_sweep(tmp_path).results):
            assert sorted(result is None for result in results) == [False, True]


def test_results_of_two_stores_are_equal_where_their_numbers_are(tmp_path):
    run = {"duration": 1e-3, "progress": False}
    first, same, other = (
        rc.sweep(PAPER, {"speed": [speed]}, store=tmp_path / "runs" / name, **run)
        for name, speed in (("first", 10.0), ("same", 10.0), ("other", 12.0))
    )
    assert first.results == same.results
    assert first.results != other.results


@pytest.mark.parametrize("name", [".", "..", "./a", "a/b", "100 %"])
def test_a_measured_quantity_may_have_any_name(name, tmp_path):
    def measure(result):
        return {name: result.time.size, f"{name} of rows": result.time}

    once = rc.sweep(PAPER, {"pretension": [0.0, 25.0]}, measure, **SHORT, store=tmp_path)
    assert_same(once, rc.load_sweep(tmp_path))


def test_cases_that_differ_in_a_label_only_share_a_file(tmp_path):
    def drive(pretension, label):
        return rc.paper_drive(pretension)

    axes = {"pretension": [10.0, 20.0], "label": ["a", "b"]}
    once = rc.sweep(drive, axes, lambda result: result.time.size, **SHORT, store=tmp_path)
    assert once.success
    assert len(once.cases) == 4
    assert len(list(tmp_path.glob("*.nc"))) == len(rc.load_sweep(tmp_path).cases) == 2


def test_a_damaged_file_is_run_again(tmp_path):
    first, _ = counted(PAPER, AXES, Counted(), store=tmp_path, **SHORT)
    files = sorted(tmp_path.iterdir())
    files[0].write_bytes(files[0].read_bytes()[:-200])
    files[1].write_bytes(b"")
    rc.Simulation(PAPER).run(1e-3, progress=False).save(files[2])  # no case
    again, ran = counted(PAPER, AXES, Counted(), store=tmp_path, **SHORT)
    assert ran == 3
    assert_same(first, again)
    assert counted(PAPER, AXES, Counted(), store=tmp_path, **SHORT)[1] == 0


def test_failed_cases_are_stored_with_their_error_and_repeated_on_demand(tmp_path):
    with pytest.warns(RuntimeWarning, match="1 of 2 cases failed"):
        first, ran = counted(PAPER, FAILING, Counted(), store=tmp_path, **SHORT)
    assert ran == 1
    assert len(list(tmp_path.iterdir())) == 2
    runs = []

    def build():
        runs.append(1)
        return PAPER

    for retry, steps in ((False, 0), (True, 1)):
        seen = []
        with pytest.warns(RuntimeWarning, match="1 of 2 cases failed"):
            found = rc.sweep(build, FAILING, Counted(), store=tmp_path, retry=retry,
                             executor=_Watched(seen), **SHORT)  # fmt: skip
        assert len(seen) == steps
        error = found.errors[0]
        assert isinstance(error, rc.SimulationError)
        assert str(error) == str(first.errors[0])
        assert error.time == first.errors[0].time > 4e-3
        assert error.result is None
        table = found.to_pandas()
        assert table["error"][0] == f"SimulationError: {error}"
        assert np.isnan(table["peak"][0])
        assert table["peak"][1] == first.values[1]["peak"]


class _Watched(ThreadPoolExecutor):
    def __init__(self, seen):
        super().__init__(1)
        self._seen = seen

    def submit(self, *arguments, **keywords):
        self._seen.append(1)
        return super().submit(*arguments, **keywords)


def late(text):
    error = rc.SimulationError(text)
    error.time, error.step_size, error.contact = 0.25, 1e-9, "hinge 3"
    return error


def test_errors_of_a_measure_come_back_as_what_they_were(tmp_path):
    def measure(result):
        kinds = {10.0: LookupError, 12.0: KeyError, 14.0: late, 16.0: Own}
        raise kinds[result.drive.sprockets[0].motion.speed]("not there")

    for _ in range(2):
        with pytest.warns(RuntimeWarning, match="4 of 4 cases failed"):
            found = rc.sweep(PAPER, {"speed": [10.0, 12.0, 14.0, 16.0]}, measure, store=tmp_path,
                             **SHORT)  # fmt: skip
        *errors, own = found.errors.values()
        assert [type(error) for error in errors] == [LookupError, KeyError, rc.SimulationError]
        assert [str(error) for error in errors] == ["not there", "'not there'", "not there"]
        assert (errors[2].time, errors[2].step_size, errors[2].contact) == (0.25, 1e-9, "hinge 3")
        for error in (*errors, own):
            assert error.__notes__[0].startswith("raised at test_store.py, line ")
    assert str(own) == "Own: not there"


class Own(Exception):
    pass


class Timed(Exception):
    time = (1.0, object())
    step_size = 1e-9


def test_an_error_with_attributes_that_no_file_holds_fails_its_case_alone(tmp_path):
    def measure(result):
        raise Timed("late")

    for _ in range(2):
        with pytest.warns(RuntimeWarning, match="1 of 1 cases failed"):
            found = rc.sweep(PAPER, {"rtol": [1e-5]}, measure, store=tmp_path, **SHORT)
        assert "late" in str(found.errors[0])


@pytest.mark.parametrize("measured", ["text", {"a": [None, "b"]}, 1j])
def test_what_is_no_number_fails_its_case(measured, tmp_path):
    with pytest.warns(RuntimeWarning, match="1 of 1 cases failed"):
        found = rc.sweep(PAPER, {"rtol": [1e-5]}, lambda _: measured, store=tmp_path, **SHORT)
    assert isinstance(found.errors[0], rc.InvalidInput)


def test_an_executor_that_breaks_leaves_no_failures_in_the_store(tmp_path):
    closed = ThreadPoolExecutor(1)
    closed.shutdown()
    with pytest.raises(RuntimeError, match="after shutdown"):
        rc.sweep(PAPER, AXES, Counted(), store=tmp_path, executor=closed, **SHORT)
    assert list(tmp_path.iterdir()) == []


def test_a_case_without_a_start_is_not_stored_as_failed(tmp_path):
    scene = rc.Scene(PAPER, start="static")
    with pytest.warns(rc.CaseWarning, match="1 of 2 cases failed.*does not come to rest"):
        rc.sweep(scene, FAILING, Counted(), store=tmp_path, duration=1e-4, progress=False)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("told", ["a process has ended", "cannot pickle this"])
def test_a_case_that_an_executor_loses_is_not_stored_as_failed(told, tmp_path):
    class Loses(ThreadPoolExecutor):
        def submit(self, *arguments, **keywords):
            lost = Future()
            lost.set_exception(BrokenExecutor(told))
            return lost

    cases = {"pretension": [0.0, 25.0, 50.0]}
    with Loses(1) as executor:
        rc.sweep(PAPER, {"pretension": [0.0, 25.0]}, Counted(), store=tmp_path, **SHORT)
        with pytest.warns(rc.CaseWarning, match="1 of 3 cases failed"):
            found = rc.sweep(PAPER, cases, Counted(), store=tmp_path, executor=executor, **SHORT)
    assert told in str(found.errors[2])
    assert len(list(tmp_path.iterdir())) == 2
    again, ran = counted(PAPER, cases, Counted(), store=tmp_path, **SHORT)
    assert (again.success, ran) == (True, 1)


def no_measure(result):
    raise LookupError("not there")


@pytest.mark.parametrize("measure", [Counted(), None, no_measure])
def test_warnings_of_stored_cases_are_told_again(measure, tmp_path):
    drive = rc.two_sprocket_drive(chain="ANSI 160", teeth=(17, 17), links=38)
    for _ in range(2):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = rc.sweep(
                rc.Scene(drive, rc.EnhancedCylinder()), {"speed": [5.0]}, measure, duration=1e-4,
                store=tmp_path, progress=False,
            )  # fmt: skip
        told = [str(w.message) for w in caught if w.category is rc.RangeWarning]
        assert len(told) == 1
        assert "1 of 1 cases" in told[0]
        assert list(found.law_warnings) == [0]
        assert rc.load_sweep(tmp_path).law_warnings == found.law_warnings


def test_studies_and_loss_maps_have_stores_too(tmp_path):
    given = {"runs": 2, "duration": 8e-3, "burn_in": 4e-3, "store": tmp_path, "progress": False}
    one, other = rc.study(PAPER, **given), rc.study(PAPER, **given)
    assert one.samples.equals(other.samples)
    assert len(list(tmp_path.iterdir())) == 2
    drive = rc.two_sprocket_drive(teeth=(17, 17), links=40, pretension=50.0)
    arguments = (drive, [6.0, 12.0], [-1.0])
    keywords = {"duration": 0.02, "burn_in": 0.01, "store": tmp_path, "progress": False}
    losses = [rc.loss_map(*arguments, **keywords) for _ in range(2)]
    assert losses[0].equals(losses[1])
    np.testing.assert_allclose(losses[0]["loss"].sum("channel"), losses[0]["lost"])
    assert len(list(tmp_path.iterdir())) == 4


def test_a_further_axis_of_a_study_leaves_its_stored_cases(tmp_path):
    given = {"runs": 2, "duration": 2e-4, "burn_in": 1e-4, "progress": False, "store": tmp_path}
    rc.study(PAPER, Counted(), axes={"pretension": [0, 25]}, **given)
    speed = PAPER.sprockets[0].motion.speed
    rc.study(PAPER, Counted(), axes={"pretension": [0, 25], "speed": [speed, 10.0]}, **given)
    assert len(list(tmp_path.iterdir())) == 8


def pushed(factor):
    """A body that a Python function pushes."""
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("block", mass=1.0, inertia=1.0, position=(0.0, 0.0, 0.0))
    mechanism.add_prismatic("way", "ground", "block", (1.0, 0.0))
    mechanism.add_callable("push", "block", lambda t, *_: (factor * t, 0.0, 0.0))
    return mechanism


def test_functions_in_a_mechanism_count(tmp_path):
    def place(result):
        return float(result.body("block").position[-1, 0])

    found = {}
    for _ in range(2):
        for factor in (1.0, 2.0):
            given = {"duration": 0.1, "store": tmp_path, "progress": False}
            swept = rc.sweep(pushed(factor), {"rtol": [1e-6]}, place, **given)
            found.setdefault(factor, []).append(swept.values[0])
    assert len(list(tmp_path.iterdir())) == 2
    for factor, values in found.items():
        assert values[0] == values[1] == pytest.approx(factor * 0.1**3 / 6, rel=1e-4)


def test_a_folder_that_cannot_be_made_and_a_measure_without_identity_are_told(tmp_path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(OSError, match=r"store: the folder .*taken cannot be made"):
        rc.sweep(PAPER, AXES, Counted(), store=tmp_path / "taken", **SHORT)
    said = "has no identity by which a stored case"
    with (tmp_path / "open").open("w") as file, pytest.raises(rc.InvalidInput, match=said):
        rc.sweep(PAPER, AXES, lambda _: file.name, store=tmp_path, **SHORT)


def test_another_version_or_format_is_another_case(tmp_path, monkeypatch):
    for name in ("rustchain.__version__", "rustchain.sweeps.store.FORMAT", None):
        found, ran = counted(PAPER, {"rtol": [1e-5]}, Counted(), store=tmp_path, **SHORT)
        assert (found.success, ran) == (True, 1)
        if name is not None:
            monkeypatch.setattr(name, "other")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for workers in /proc")
def test_a_sweep_that_is_ended_or_loses_a_worker_goes_on_where_it_was(tmp_path):
    # Runs so long that the workers have not run all of them when one is killed.
    found = load.load(tmp_path, 60, 0.1)
    assert found.wrong == []
    for stored, (share, _) in zip(found.stored, load.DISTURBANCES, strict=True):
        assert 60 * share <= stored < 60
