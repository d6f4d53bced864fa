"""Wild arguments: refused by name in few words, or converted exactly once."""

from __future__ import annotations

import copy
import math
import pickle
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import call_table
import calls
import rustchain as rc
import wild_values
from rustchain.arguments import count_within

SEED, COUNT = 20, 300  # some seconds; `python tests/stress/calls.py` makes thousands


def test_the_table_of_calls_has_every_public_name():
    assert call_table.not_called() == set()


def test_every_call_of_the_table_is_accepted_as_it_is():
    refused = [
        found for each in call_table.targets_once() if (found := calls.outcome(each, {})).said
    ]
    # Only open chains have ends, and only drives with ideal hinges have joints to draw.
    assert [found.call for found in refused] == ["Result.end()", "Plots.joint_loads()"]


def test_wild_arguments_are_refused_by_name_in_few_words(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    holes = [
        str(found) for found in calls.trials(SEED, range(COUNT)) if found.kind.startswith("hole")
    ]
    assert holes == []


@pytest.fixture(scope="module")
def result():
    simulation = rc.Simulation(rc.paper_drive())
    return simulation.run(
        2e-3, record=("hinges", "teeth", "sprockets", "bodies", "energy"), progress=False
    )


@pytest.mark.parametrize("kind", wild_values.ALL)
def test_a_message_shows_any_value_on_one_line_of_eighty_characters(kind):
    from rustchain.arguments import shown

    text = shown(wild_values.ALL[kind]())
    assert len(text) <= 80
    assert "\n" not in text


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda r: r.between(end=math.nan), r"between\(end\): got nan; expected a finite number"),
        (lambda r: r.between(end=1j), r"between\(end\): got 1j; expected a finite number"),
        (lambda r: r.between(end="x"), r"between\(end\): got 'x'; expected a finite number"),
        (lambda r: r.hinge(True), r"hinge\(number\): got True; expected a whole number"),
        (
            lambda r: r.hinge_loads(quantiles=(0.5, "x")),
            r"hinge_loads\(quantiles\.2\): got 'x'; expected a finite number",
        ),
        (lambda r: r.hinge_loads(quantiles=(0.5, 2.0)), r"quantiles.2 = 2.0: must be between"),
        (
            lambda r: rc.Simulation(r.drive).run(10**6000, progress=False),
            "duration = <int>: must be a number in s",
        ),
        (
            lambda r: r.strand_spectrum("upper", segment=-1.0),
            "segment = -1: must be a positive number in s",
        ),
        (
            lambda r: rc.Hertz().elastic_force(1e-6, (1e-3, 2e-3), length=-1.0),
            "length = -1: must be a positive number in m",
        ),
        (lambda r: rc.loss_map(None, [1.0], [1.0]), r"loss_map\(scene\): got None; .* ChainDrive"),
        (lambda r: rc.SmoothStep(0.0, 1.0, "x", 1.0), r"SmoothStep.before: got 'x'; expected"),
        (
            lambda r: rc.sweep(r.drive, {"min_impact_velocity": [math.nan]}),
            "min_impact_velocity = nan: must be a positive number in m/s",
        ),
        (
            lambda r: rc.Simulation(r.drive, force_law="x" * 5000),
            r"force_law = 'x{76}\.\.\.: expected a force law such as LankaraniNikravesh\(\)",
        ),
        (
            lambda r: rc.Simulation(Path("a.toml")),
            r"system of the scene = \w+Path\('a.toml'\): must be a ChainDrive or a Mechanism$",
        ),
        (
            lambda r: rc.Scene(r),
            "scene = Result: must .*; use result.scene",
        ),
        (
            lambda r: rc.Scene(rc.paper_drive, start="static"),
            "must be a ChainDrive or a Mechanism; call it, or for sweep and study let it return",
        ),
        (lambda r: rc.Scene(rc.Scene(rc.Mechanism())), "scene = Scene: must .*; use scene.system"),
        (lambda r: rc.sweep(int, {"x": [1]}), "scene: got <class 'int'>; expected a Scene, a Chai"),
        (lambda r: rc.sweep(r, {"x": [1]}), "scene: got Result; .*; use result.scene"),
        (lambda r: rc.sweep(r.drive, {}, threads=10**30), r"threads = 1000\d+: must be a whole nu"),
        (lambda r: rc.sweep(r.drive, {}, retry=1), "retry = 1: must be True or False"),
        (lambda r: rc.loss_map(r.drive, [], [1.0]), r"speeds = \(\): must hold at least one value"),
        (
            lambda r: rc.loss_map(r.drive, [1.0], []),
            r"torques = \(\): must hold at least one",
        ),
        (
            lambda r: rc.Simulation(r.scene).evaluate(time=np.complex128(1.0)),
            r"time = \(1\+0j\): must be a number in s",
        ),
        (
            lambda r: rc.Simulation(r.scene).evaluate(time=np.True_),
            "time = True: must be a number in s",
        ),
        (
            lambda r: rc.Mechanism().add_force("pull", "a", np.array(1.0)),
            r"force of 'pull' = array\(1.\): must be two components \(x, y\)",
        ),
        (
            lambda r: rc.Mechanism().add_force("pull", "a", (0, 1), point=bytearray(b"ab")),
            r"point of force 'pull' = bytearray\(b'ab'\): must be two finite numbers",
        ),
        (
            lambda r: rc.Hertz().elastic_force(1e-6, bytearray(b"ab"), length=0.01),
            r"radii\): got bytearray\(b'ab'\); expected a sequence",
        ),
    ],
)
def test_nonsense_is_refused_with_function_argument_and_element(call, says, result):
    with pytest.raises(rc.InvalidInput, match=says):
        call(result)


def test_numbers_and_truths_of_numpy_are_those_of_python(result):
    first = result.wrap_loads(1)
    assert result.wrap_loads(np.int64(1)).equals(first)
    assert result.wrap_loads(np.array(1)).equals(first)
    run = {"duration": 2e-4, "progress": False}
    swept = rc.sweep(result.drive, {}, threads=np.int64(1), retry=np.False_, **run)
    assert swept.success


EXACT = [Decimal("25"), Fraction(25), np.longdouble(25), np.float32(25), np.array(25.0), 25]


@pytest.mark.parametrize("value", EXACT, ids=lambda value: type(value).__name__)
def test_numbers_of_any_kind_become_python_floats_once(value, tmp_path):
    drive = rc.paper_drive(pretension=value)
    assert type(drive.tensioner.pretension) in (float, int)
    simulation = rc.Simulation(drive, min_impact_velocity=Fraction(1, 1000))
    simulation.run(Decimal("2e-4"), np.longdouble("1e-4"), progress=False).save(tmp_path / "run.nc")
    simulation.save_state(tmp_path / "state.npz")
    assert rc.Simulation.load_state(tmp_path / "state.npz").drive == drive


@pytest.mark.parametrize(
    "value",
    [Decimal("snan"), Decimal("1e5000"), Fraction(10**400), 10**400, np.timedelta64(3, "ns")],
    ids=str,
)
def test_a_number_that_no_float_is_exactly_is_refused(value):
    with pytest.raises(rc.InvalidInput, match=r"Material\.elastic_modulus = "):
        rc.Material(elastic_modulus=value)


def test_a_count_may_be_the_least_and_the_largest():
    for count in (2, np.int64(5)):
        assert count_within("runs", count, 2, 5) == count
    for count in (1, 6, 2.0, True):
        with pytest.raises(rc.InvalidInput, match=r"runs = .*: must be a whole number from 2 to 5"):
            count_within("runs", count, 2, 5)


def test_a_masked_value_is_no_value():
    masked = np.ma.masked_invalid([0.0, 25.0, np.nan])
    for value in (masked[2], np.ma.masked, masked):
        with pytest.raises(rc.InvalidInput, match=r"pretension.* = masked"):
            rc.paper_drive(pretension=value)
    assert rc.paper_drive(pretension=masked[1]).tensioner is not None
    with pytest.raises(rc.InvalidInput, match=r"rpm\(speed\): got masked_array"):
        rc.rpm(np.ma.masked_array([1.0, 2.0], mask=[False, True]))
    axes = {"pretension": masked}
    with pytest.warns(rc.CaseWarning, match="1 of 3 cases failed.*pretension = masked"):
        rc.sweep(rc.paper_drive, axes, duration=1e-4, progress=False)
    drive = rc.paper_drive()
    begun = rc.Simulation(drive)
    start = {"positions": np.ma.masked_array(begun.positions), "velocities": begun.velocities}
    assert (rc.Simulation(drive, **start).positions == begun.positions).all()
    start["positions"][3, 1] = np.ma.masked
    with pytest.raises(rc.InvalidInput, match=r"positions = masked_array"):
        rc.Simulation(drive, **start)


@pytest.mark.parametrize(
    ("look", "nearest"),
    [
        (lambda r: r.hinge_load, "Result has no attribute 'hinge_load'; did you mean 'hinge_loads"),
        (lambda r: r.peaks.hinge, "did you mean 'hinge_force'"),
        (lambda r: r.energy.kinetik, "did you mean 'kinetic'"),
        (lambda r: r.hinge(1).forc, "did you mean 'force'"),
        (lambda r: r.plot.hinge_forces, "did you mean 'hinge_force'"),
        (lambda r: r.drive.check().slack, "DriveReport has no attribute 'slack'"),
    ],
)
def test_a_missing_attribute_of_a_result_names_the_nearest(look, nearest, result):
    with pytest.raises(AttributeError, match=nearest):
        look(result)


def test_results_are_still_copied_and_pickled(result):
    for again in (copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
        assert again.hinge(1).force.tolist() == result.hinge(1).force.tolist()
