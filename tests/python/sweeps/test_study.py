"""Studies and loss maps: intervals that cover, starts that differ, runs that repeat."""

import re
from dataclasses import replace

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy import stats

import rustchain as rc
from rustchain.plot import draw_loss_map
from rustchain.sweeps.measure import numbers_of
from rustchain.sweeps.result import SweepResult
from rustchain.sweeps.study import StudyResult

PAPER = rc.paper_drive()
SHORT = {"duration": 8e-3, "burn_in": 4e-3, "progress": False}


def strand_mean(result):
    return {
        "upper": result.strand("upper").tension.mean(),
        "both": result.array("strand_tension").mean(0),
    }


@pytest.fixture(scope="module")
def study():
    return rc.study(PAPER, strand_mean, runs=4, axes={"pretension": [0.0, 50.0]}, **SHORT)


def made_study(values, confidence):
    """A study of one measure whose runs had these values."""
    sweep = SweepResult(
        [{"replicate": k} for k in range(len(values))],
        {"replicate": tuple(range(len(values)))},
        list(values),
    )
    return StudyResult(sweep, confidence, 0.0)


def test_intervals_cover_the_true_mean_as_often_as_they_say():
    """400 studies of 6 normal runs at 80 %: the count of those that cover is binomial."""
    rng = np.random.default_rng(7)
    covered = 0
    for _ in range(400):
        found = made_study(rng.normal(3.0, 0.5, 6), 0.8).statistics["value"]
        covered += float(found.sel(statistic="low")) < 3.0 < float(found.sel(statistic="high"))
    low, high = stats.binom.ppf([1e-4, 1 - 1e-4], 400, 0.8)
    assert low <= covered <= high


def test_statistics_are_those_of_the_runs_that_there_are():
    found = made_study([1.0, 2.0, None, 6.0], 0.9).statistics["value"]
    mean, std, low, high, count = found.to_numpy()
    assert (mean, count) == (3.0, 3)
    assert std == pytest.approx(np.std([1.0, 2.0, 6.0], ddof=1))
    expected = stats.t.interval(0.9, 2, 3.0, std / np.sqrt(3))
    assert (low, high) == pytest.approx(expected)


def test_the_first_run_is_the_drive_as_it_is_and_begins_after_the_burn_in(study):
    alone = rc.Simulation(PAPER).run(8e-3, progress=False)
    upper = alone.strand("upper").tension[alone.time >= 4e-3 - 1e-12].mean()
    assert float(study.samples["upper"].sel(pretension=0.0, run=0)) == upper


def test_starts_differ_a_little_and_paths_part(study):
    """Speeds at the start differ by less than 1e-4; forces soon differ by much more."""
    seen = rc.sweep(
        PAPER,
        {"replicate": [0, 1, 2, 3]},
        lambda r: r.initial_velocities[-1, 2],
        duration=1e-4,
        progress=False,
    )
    speeds = np.array(seen.values)
    assert speeds[0] == pytest.approx(4 * np.pi, rel=1e-12)
    assert len(set(speeds)) == 4
    np.testing.assert_allclose(speeds, speeds[0], rtol=1e-4)
    samples = study.samples["upper"].sel(pretension=0.0)
    assert float(samples.std("run") / samples.mean("run")) > 1e-3


def at_rest():
    """Return a drive that starts from rest, and a hoist that its torque holds."""
    start = (0.0, 0.0), (0.02, 20.0)
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=start, torque=-1.0)
    sprocket = rc.Sprocket(17, motion=rc.AppliedTorque(3.4), load_inertia=1e-3)
    ends = (rc.AnchoredEnd((-0.16, -0.02), links=50), rc.LoadedEnd(10.0, arm=0.08))
    hoist = rc.open_chain("ANSI 40", ends, 90, [sprocket])
    return rc.Scene(drive), rc.Scene(drive, start="static"), rc.Scene(hoist, start="static")


@pytest.mark.parametrize("place", [0, 1, 2])
def test_sprockets_at_rest_start_with_other_speeds_and_paths_part(place):
    found = rc.sweep(
        at_rest()[place],
        {"replicate": [0, 1, 2, 3]},
        lambda r: {"start": r.initial_velocities[:, 2], "force": r.peaks.hinge_force.sum()},
        duration=0.02,
        progress=False,
    ).to_xarray()
    start = np.abs(found["start"]).max("start_0").to_numpy()
    assert start[0] == 0.0
    assert ((start[1:] > 1e-8) & (start[1:] < 1e-4)).all()
    assert len(set(found["force"].to_numpy())) == 4


@pytest.mark.parametrize("speed", [20.0, -20.0])
def test_a_sprocket_starts_by_a_share_of_its_speed_faster_or_slower_whatever_its_sign(speed):
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=speed)
    axes = {"replicate": range(41)}
    swept = rc.sweep(
        drive, axes, lambda r: r.initial_velocities[-1, 2], duration=1e-4, progress=False
    )
    assert swept.values[0] == pytest.approx(speed * 17 / 25)
    changes = np.array(swept.values[1:]) / swept.values[0] - 1.0
    assert 0.9e-4 < changes.max() < 1e-4
    assert -1e-4 < changes.min() < -0.9e-4


def test_each_body_of_a_mechanism_starts_with_a_velocity_of_its_own():
    """Every component differs by up to 1e-4 of itself, faster and slower; zeros remain."""
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    for k, velocity in enumerate([(1.0, -2.0, 3.0), (0.5, 0.0, -4.0)]):
        mechanism.add_body(f"body {k}", 1.0, 0.1, (k, 0.0, 0.0), velocity)
    with pytest.warns(rc.RustchainWarning, match="nothing connects"):
        swept = rc.sweep(
            mechanism,
            {"replicate": range(41)},
            lambda result: result.initial_velocities,
            duration=1e-3,
            progress=False,
        )
    first, others = swept.values[0], np.array(swept.values[1:])
    changes = others[:, first != 0.0] / first[first != 0.0] - 1.0
    assert (others[:, first == 0.0] == 0.0).all()
    assert len(np.unique(changes)) == changes.size
    assert 0.9e-4 < changes.max() < 1e-4
    assert -1e-4 < changes.min() < -0.9e-4


def test_a_study_made_again_has_the_same_numbers(study):
    again = rc.study(PAPER, strand_mean, runs=4, axes={"pretension": [0.0, 50.0]}, **SHORT)
    assert again.samples.equals(study.samples)


def test_arrays_are_measured_too_and_tables_have_a_row_for_each_number(study):
    assert study.statistics["both"].dims == ("pretension", "both_0", "statistic")
    numbers = rc.study(PAPER, lambda r: r.time[0], runs=2, **SHORT)
    table = numbers.to_pandas()
    assert list(table.columns) == ["mean", "std", "low", "high", "count"]
    assert table["mean"].iloc[0] == pytest.approx(4e-3)


def test_the_default_measures_are_the_summary():
    found = rc.study(PAPER, runs=2, **SHORT)
    expected = rc.Simulation(PAPER).run(8e-3, progress=False).summary(start=4e-3)
    for name, value in expected.items():
        assert float(found.samples[name].sel(run=0)) == pytest.approx(value), name


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"runs": 1}, "runs = 1"),
        ({"runs": 2.5}, "runs = 2.5"),
        ({"confidence": 95}, "between 0 and 1"),
        ({"burn_in": 0.01}, "less than the duration"),
        ({"burn_in": 8e-3}, "less than the duration"),
        ({"axes": {"duration": [9e-3, 1e-3, 8e-3]}, "runs": 2}, "less than the duration, 0.001"),
        ({"axes": {"replicate": [1]}}, "runs="),
        ({"axes": [{"pretension": 1}]}, "sequences of values"),
        ({"axes": {"pretensoin": [1]}}, "did you mean 'pretension'"),
    ],
)
def test_what_makes_no_study_is_refused(keywords, words):
    with pytest.raises(rc.InvalidInput, match=words):
        rc.study(PAPER, **(SHORT | keywords))


@pytest.mark.parametrize("seed", [-1, 0.5, True, "one"])
def test_a_replicate_is_a_seed(seed):
    with pytest.raises(rc.InvalidInput, match="replicate = "):
        rc.sweep(PAPER, {"replicate": [seed]}, duration=1e-4, progress=False)


def test_a_mechanism_at_rest_has_no_replicates():
    mechanism = rc.Mechanism()
    mechanism.add_body("bob", mass=1.0, inertia=0.1)
    mechanism.add_revolute("pivot", "ground", "bob", at=(0.0, 0.1))
    run = {"duration": 1e-3, "burn_in": 0.0, "progress": False}
    told = "1 of 2 cases failed, first case 1 .*: replicate = 1: every body starts at rest"
    with pytest.warns(rc.CaseWarning, match=told):
        rc.study(mechanism, lambda result: result.time[-1], runs=2, **run)


def test_a_scene_with_velocities_of_its_own_has_no_other_start():
    made = rc.Simulation(PAPER)
    scene = rc.Scene(PAPER, positions=made.positions, velocities=made.velocities)
    with pytest.warns(rc.CaseWarning, match="1 of 2 cases failed"):
        found = rc.study(scene, lambda r: r.time[-1], runs=2, **SHORT)
    assert "velocities of its own" in str(found.sweep.errors[1])


def test_a_drive_whose_sprockets_are_all_prescribed_has_no_other_start():
    both = tuple(replace(s, motion=rc.PrescribedSpeed(4 * np.pi)) for s in PAPER.sprockets)
    drive = replace(PAPER, sprockets=both)
    with (
        pytest.warns(RuntimeWarning, match="1 of 2 cases failed"),
    ):
        found = rc.study(drive, lambda r: r.time[-1], runs=2, **SHORT)
    assert "PrescribedSpeed" in str(found.sweep.errors[1])


def test_a_drive_without_sprockets_has_no_other_start_and_no_loss_map():
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd((0.0, -0.127)))
    chain = rc.open_chain("ANSI 40", ends, links=10)
    with pytest.warns(RuntimeWarning, match="replicate = 1: the drive has no sprocket, so"):
        rc.study(chain, lambda r: r.time[-1], runs=2, **SHORT)
    with pytest.raises(rc.InvalidInput, match="loaded = 2: the drive has no sprocket"):
        rc.loss_map(chain, [10.0], [-1.0])


def test_a_loss_map_tells_how_its_cases_ended():
    given = {"duration": 2e-3, "burn_in": 1e-3, "progress": False}
    with pytest.warns(rc.CaseWarning, match="1 of 2 cases failed"):
        losses = rc.loss_map(rc.paper_drive(), [10.0, 1e9], [-1.0], **given)
    assert np.isfinite(losses["lost"].to_numpy()).tolist() == [[True], [False]]
    assert losses.attrs["message"] == "1 of 2 cases finished, 1 failed"


def test_a_loss_map_holds_the_balances_of_single_runs():
    drive = rc.two_sprocket_drive(teeth=(17, 17), links=40, pretension=50.0)
    speeds, torques = [6.0, 12.0], [-1.0, -2.0, -3.0]
    losses = rc.loss_map(drive, speeds, torques, duration=0.15, burn_in=0.1, progress=False)
    assert losses["efficiency"].shape == (2, 3)
    assert ((losses["efficiency"] > 0.8) & (losses["efficiency"] < 1.0)).all()
    np.testing.assert_allclose(losses["loss"].sum("channel"), losses["lost"])
    # What the load takes is its torque times its speed, which follows the driver's on average.
    asked = np.outer(speeds, np.abs(torques))
    np.testing.assert_allclose(losses["delivered"], asked, rtol=0.15)
    one = rc.two_sprocket_drive(teeth=(17, 17), links=40, pretension=50.0, speed=12.0, torque=-2.0)
    power = (
        rc.Simulation(one)
        .run(0.15, record=("sprockets", "energy"), progress=False)
        .power_balance(start=0.1)
    )
    found = losses.sel(speed=12.0, torque=-2.0)
    assert float(found["efficiency"]) == pytest.approx(float(power["efficiency"]), rel=1e-12)
    mpl.use("Agg")
    figure = draw_loss_map(losses)
    assert len(figure.axes) == 4  # two maps, two scales
    plt.close(figure)
    with pytest.raises(rc.InvalidInput, match="1 to 2"):
        rc.loss_map(drive, speeds, torques, loaded=3)


def test_a_loss_map_with_a_report_step_beyond_what_is_measured_is_refused_before_a_run(monkeypatch):
    monkeypatch.setattr("rustchain.sweeps.sweep.run_here", lambda *_: pytest.fail("it ran"))
    for step in (0.31, 1e300):
        said = f"report_step = {step}: must be at most the time that is measured, 0.3 s; take a sm"
        with pytest.raises(rc.InvalidInput, match=re.escape(said)):
            rc.loss_map(PAPER, [10.0], [-1.0], report_step=step)


@pytest.mark.parametrize("measures", [("upper",), ()])
def test_figures_of_a_study(study, measures):
    mpl.use("Agg")
    figure = study.plot(*measures)
    assert len(figure.axes) == 1
    assert len(figure.axes[0].get_lines()) > 1
    plt.close(figure)
    with pytest.raises(rc.InvalidInput, match="did you mean 'upper'"):
        study.plot("uper")


def test_a_study_without_a_single_value_tells_the_first_error():
    with pytest.warns(RuntimeWarning, match="2 of 2 cases failed"):
        found = rc.study(PAPER, lambda r: r.nothing, runs=2, **SHORT)
    with pytest.raises(rc.NotRecorded, match="nothing"):
        found.to_pandas()


def test_a_study_and_a_map_take_friction_and_a_start_at_rest():
    drive = rc.two_sprocket_drive("ANSI 40", links=78, torque=-1.0, pretension=50.0)
    lost = [
        rc.loss_map(
            rc.Scene(drive, rc.LankaraniNikravesh(friction=law)),
            [10.0],
            [-1.0],
            duration=0.04,
            burn_in=0.02,
            progress=False,
        )["lost"].item()
        for law in (None, rc.Coulomb(0.2))
    ]
    assert lost[1] > lost[0]
    static = rc.Scene(drive, start="static")
    rest = rc.study(static, runs=2, duration=0.01, burn_in=0.0, progress=False)
    laid = rc.study(drive, runs=2, duration=0.01, burn_in=0.0, progress=False)
    assert not rest.statistics.equals(laid.statistics)


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"measure": 3}, "measure = 3"),
        ({"duration": "a"}, "duration = 'a'"),
        ({"duration": -1.0}, "duration = -1.0"),
        ({"burn_in": "a"}, "burn_in = 'a'"),
        ({"confidence": "a"}, "confidence = 'a'"),
    ],
)
def test_a_study_names_what_is_wrong(keywords, said):
    with pytest.raises(rc.InvalidInput, match=re.escape(said)):
        rc.study(rc.paper_drive(25.0), **keywords)


BRIEF = {"runs": 2, "duration": 4e-3, "burn_in": 2e-3, "energy": False, "progress": False}


@pytest.mark.parametrize(
    ("measured", "text"),
    [
        ("text", "gave 'text': must be a number"),
        ({"a": "text"}, "gave 'text' for 'a': must be a number"),
        ({1: 1.0}, "1 is no name"),
        (1j, "complex numbers"),
    ],
)
def test_what_has_no_mean_is_refused(measured, text):
    with pytest.warns(RuntimeWarning, match="cases failed"):
        study = rc.study(rc.paper_drive(), lambda _: measured, **BRIEF)
    with pytest.raises(rc.NotRecorded, match=text):
        study.to_pandas()


def test_a_value_that_is_no_number_is_refused_without_mention_of_a_mean():
    """A sweep with a store refuses it, too."""
    with pytest.raises(rc.InvalidInput, match=r"an array of numbers or a dict of them$"):
        numbers_of("text", ())


@pytest.mark.parametrize("name", ["run", "statistic"])
def test_a_name_that_a_study_has_is_refused_with_the_first_run(name):
    with pytest.raises(rc.InvalidInput, match=f"'{name}' is what a study calls something else"):
        rc.study(rc.paper_drive(), lambda _: {name: 1.0}, **BRIEF)


def test_a_run_without_a_value_does_not_count():
    seen = []

    def measure(_):
        seen.append(1)
        return {"sometimes": None if len(seen) == 1 else 2.0, "never": None}

    table = rc.study(rc.paper_drive(), measure, **(BRIEF | {"runs": 3})).to_pandas()
    assert table.loc["sometimes", "count"] == 2
    assert table.loc["sometimes", "mean"] == 2.0
    assert table.loc["never", "count"] == 0


def test_rows_of_numbers_of_any_lengths_have_tables_and_figures():
    def measure(result):
        return {
            "a": np.arange(40.0) + result.time[-1],
            "b": np.arange(50.0),
            "c": result.time[-1],
            "d": np.ones((2, 2)),
        }

    study = rc.study(rc.paper_drive(), measure, **BRIEF)
    table = study.to_pandas()
    assert len(table) == 40 + 50 + 1 + 4
    assert table.loc["a_3", "mean"] == pytest.approx(3.004)
    assert table.loc["d_1_0", "mean"] == 1.0
    assert [len(study.plot().axes), len(study.plot("a", "b").axes)] == [1, 2]
    with pytest.raises(rc.InvalidInput, match="no measured number or row"):
        study.plot("d")
    two = rc.study(rc.paper_drive(), lambda _: np.arange(3.0), axes={"speed": [9.0, 10.0]}, **BRIEF)
    assert [axes.get_title("left") for axes in two.plot().axes] == [
        "value: speed 9",
        "value: speed 10",
    ]
    plt.close("all")


def test_an_axis_may_repeat_a_value():
    axes = {"pretension": [10.0, 10.0], "speed": [9.0, 12.0]}
    study = rc.study(rc.paper_drive(), lambda result: {"a": [result.time[-1]]}, axes=axes, **BRIEF)
    table = study.to_pandas()
    assert [name for name, *_ in table.index] == 4 * ["a_0"]
    assert [tuple(case) for _, *case in table.index] == [
        (10.0, 9.0), (10.0, 12.0), (10.0, 9.0), (10.0, 12.0),
    ]  # fmt: skip
    np.testing.assert_array_equal(table, study.statistics["a"].to_numpy().reshape(4, 5))
    assert "<table" in study._repr_html_()


@pytest.mark.parametrize("axes", [{}, {"pretension": [10.0, 25.0]}])
@pytest.mark.parametrize("measured", [{}, np.zeros(0), np.zeros((3, 0))])
def test_a_study_without_a_number_has_an_empty_table_and_no_figure(measured, axes):
    study = rc.study(rc.paper_drive(), lambda _: measured, axes=axes, **BRIEF)
    table = study.to_pandas()
    assert table.shape == (0, 5)
    assert list(table.index.names) == ["measure", *axes]
    with pytest.raises(rc.InvalidInput, match="nothing was measured"):
        study.plot()
    assert "<table" in study._repr_html_()


def test_a_study_stops_runs_and_calls_back():
    times = []

    def callback(simulation):
        times.append(simulation.time)

    given = {"stop": rc.TimeReached(3e-3), "callback": callback}
    study = rc.study(rc.paper_drive(), lambda result: result.time[-1], **BRIEF, **given)
    assert study.to_pandas().loc["value", "mean"] == pytest.approx(3e-3)
    assert len(times) == 2 * 31
