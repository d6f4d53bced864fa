"""Axes: parameters that vary together, samples of distributions, cases made as needed."""

import gc
import re
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

import rustchain as rc
from rustchain.sweeps import running

PAPER = rc.paper_drive()
BRIEF = {"duration": 1e-4, "progress": False}


def place(result):
    tensioner = result.drive.tensioner
    pull = tensioner.pretension if tensioner else 0.0
    return {"pull": pull, "omega": result.drive.sprockets[0].motion.speed}


@pytest.mark.parametrize("together", [False, True])
def test_an_iterator_that_cases_share_is_read_once(together):
    groups = iter(["hinges"])
    axes = {("record", "rtol"): [(groups, 1e-4)]} if together else {"record": [groups]}
    found = rc.sweep(PAPER, axes | {"speed": [10.0, 12.0]}, **BRIEF)
    assert [result.groups for result in found.results] == [("hinges",), ("hinges",)]


def test_parameters_that_vary_together_are_one_dimension():
    rows = [(0.0, 10.0), (25.0, 12.0), (50.0, 14.0)]
    axes = {("pretension", "speed"): rows, "rtol": [1e-4, 1e-5]}
    found = rc.sweep(PAPER, axes, place, **BRIEF)
    assert found.cases[3] == {"pretension": 25.0, "speed": 12.0, "rtol": 1e-5}
    data = found.to_xarray()
    assert data.sizes == {"sample": 3, "rtol": 2}
    for name in ("pull", "omega"):
        assert data[name].dims == ("sample", "rtol")
    np.testing.assert_array_equal(data["pull"].isel(rtol=0), data["pretension"])
    np.testing.assert_array_equal(data["omega"].isel(rtol=1), data["speed"])
    assert list(found.to_pandas().columns) == ["pretension", "speed", "rtol", "pull", "omega"]


def test_an_array_of_qmc_is_such_an_axis():
    points = qmc.scale(qmc.Sobol(2, seed=1).random(4), [0.0, 5.0], [100.0, 15.0])
    found = rc.sweep(PAPER, {("pretension", "speed"): points}, place, **BRIEF)
    np.testing.assert_array_equal([list(value.values()) for value in found.values], points)


def test_two_such_axes_have_two_dimensions_and_a_study_takes_them():
    axes = {("pretension", "speed"): [(0, 10.0), (25, 12.0)], ("rtol", "atol"): [(1e-5, 1e-6)]}
    assert rc.sweep(PAPER, axes, place, **BRIEF).dims == ("sample", "sample_2")
    study = rc.study(PAPER, place, runs=2, axes=axes, burn_in=0.0, **BRIEF)
    assert study.dims == ("sample", "sample_2")
    assert study.statistics["pull"].dims == ("sample", "sample_2", "statistic")
    table = study.to_pandas()
    assert list(table.index.names) == ["measure", "sample", "sample_2"]
    assert table.loc[("pull", 1, 0), "mean"] == 25.0
    assert len(study.plot("pull").axes) == 1


@pytest.mark.parametrize(
    ("axes", "said"),
    [
        ({("pretension", "speed"): [(1.0,)]}, "got the row (1.0,); expected 2 values"),
        ({("pretension", "speed"): [1.0]}, "got the row 1.0; expected 2 values"),
        ({("rtol", "speed"): [(1e-5, 2.0)], "speed": [1.0]}, "'speed' is there twice"),
        ({("rtol", "sped"): [(1e-5, 2.0)]}, "did you mean 'speed'"),
        ({("rtol", "speed"): 3}, "must be a sequence of values"),
    ],
)
def test_rows_that_do_not_fit_are_refused(axes, said):
    with pytest.raises(rc.InvalidInput, match=re.escape(said)):
        rc.sweep(PAPER, axes, **BRIEF)
    with pytest.raises(rc.InvalidInput, match=re.escape(said)):
        rc.study(PAPER, axes=axes, burn_in=0.0, **BRIEF)


def drive_of(**given):
    """A drive of arguments that have names of tables."""
    return rc.paper_drive(given.get("pretension", 0.0))


@pytest.mark.parametrize(
    ("axes", "name"),
    [
        ({"sample": [1, 2], ("pretension", "speed"): [(0, 10.0), (25, 12.0)]}, "sample"),
        ({"error": [1, 2]}, "error"),
        ([{"case": 1}, {"case": 2}], "case"),
    ],
)
def test_an_argument_with_the_name_of_a_column_is_refused(axes, name):
    with pytest.raises(rc.InvalidInput, match=f"axes: '{name}' is the name of another column"):
        rc.sweep(drive_of, axes, place, **BRIEF)


@pytest.mark.parametrize("name", ["run", "statistic", "measure"])
def test_an_argument_with_the_name_of_a_column_of_studies_is_refused(name):
    with pytest.raises(rc.InvalidInput, match=f"axes: '{name}' is the name of another column"):
        rc.study(drive_of, place, axes={name: [1, 2]}, burn_in=0.0, **BRIEF)
    with pytest.raises(rc.InvalidInput, match=f"axes: '{name}' is no parameter"):
        rc.study(PAPER, place, axes={name: [1, 2]}, burn_in=0.0, **BRIEF)


@pytest.mark.parametrize("method", ["random", "latin-hypercube", "sobol", "halton"])
def test_samples_follow_their_distributions_and_seeds(method):
    laws = {"a": stats.norm(3.0, 0.5), "b": stats.randint(0, 1000), "c": stats.uniform(1, 2)}
    ((names, rows),) = rc.samples(laws, 512, seed=3, method=method).items()
    assert names == ("a", "b", "c")
    assert {tuple(map(type, row)) for row in rows} == {(float, int, float)}
    columns = np.array(rows).T
    for values, law in ((columns[0], laws["a"]), (columns[2], laws["c"])):
        assert stats.kstest(values, law.cdf).pvalue > 1e-3
    assert abs(columns[1].mean() - 499.5) < 5 * 289 / np.sqrt(512)
    assert np.abs(np.corrcoef(columns) - np.eye(3)).max() < 0.2
    assert rc.samples(laws, 512, seed=3, method=method)[names] == rows
    assert rc.samples(laws, 512, seed=4, method=method)[names] != rows


@pytest.mark.parametrize("frozen", [False, True])
def test_values_of_discrete_distributions_are_integers_where_they_are_whole(frozen):
    teeth = stats.rv_discrete(values=([15, 17], [0.5, 0.5]))
    force = stats.rv_discrete(values=([0.5, 25.5], [0.5, 0.5]))
    laws = {"teeth": teeth() if frozen else teeth, "force": force() if frozen else force}
    ((_, rows),) = rc.samples(laws, 32).items()
    assert set(rows) == {(15, 0.5), (15, 25.5), (17, 0.5), (17, 25.5)}
    assert {tuple(map(type, row)) for row in rows} == {(int, float)}


@pytest.mark.skipif(not hasattr(stats, "Binomial"), reason="SciPy before 1.16")
def test_classes_of_distributions_give_integers_where_they_are_discrete():
    laws = {"a": stats.Binomial(n=10, p=0.5), "b": stats.Normal(mu=0.0, sigma=1.0)}
    ((_, rows),) = rc.samples(laws, 8).items()
    assert {tuple(map(type, row)) for row in rows} == {(int, float)}


def test_even_samples_are_more_even_than_random_ones():
    law = {"a": stats.uniform(), "b": stats.uniform()}
    spread = {
        method: qmc.discrepancy(np.array(rc.samples(law, 64, method=method)["a", "b"]))
        for method in ("random", "latin-hypercube", "sobol", "halton")
    }
    assert all(spread[method] < 0.5 * spread["random"] for method in spread if method != "random")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (({"a": 3.0}, 4), "'a' has 3.0; expected a distribution of scipy.stats"),
        (({"a": stats.norm(0.0, -1.0)}, 4), "values that are not finite"),
        (({}, 4), "expected a distribution for each parameter"),
        (({"a": stats.norm()}, 0), "samples(count) = 0"),
        (({"a": stats.norm([0.0, 1.0])}, 2), "of several values; expected parameters"),
    ],
)
def test_what_gives_no_samples_is_refused(arguments, said):
    with pytest.raises(rc.InvalidInput, match=re.escape(said)):
        rc.samples(*arguments)
    with pytest.raises(rc.InvalidInput, match="did you mean 'sobol'"):
        rc.samples({"a": stats.norm()}, 4, method="sobl")


def test_tolerances_of_manufacture_are_samples_of_the_chain():
    laws = {"chain.hinge.bore_radius": stats.norm(3.1e-3, 1e-6), "chain.seed": stats.randint(0, 99)}
    drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, 17), links=40)
    axes = rc.samples(laws, 3) | {"chain.pitch_spread": [2e-4]}
    found = rc.sweep(drive, axes, **BRIEF)
    chains = [result.drive.chain for result in found.results]
    assert len({chain.hinge.clearance for chain in chains}) == 3
    assert len({tuple(chain.link_pitches) for chain in chains}) == 3
    for chain in chains:
        spread = chain.link_pitches / chain.pitch - 1.0
        assert 1e-4 < spread.std() < 4e-4


@pytest.mark.parametrize("how", ["pool", "threads", "executor"])
def test_scenes_are_made_as_they_are_needed(how, monkeypatch):
    """Of 300 scenes, those that wait and run on two threads are in memory, and no others."""
    monkeypatch.setattr(running, "_MOST_SUBMITTED", 40)
    alive, most = weakref.WeakSet(), 0

    def build(mass):
        nonlocal most
        gc.collect(0)
        drive = rc.paper_drive()
        alive.add(drive)
        most = max(most, len(alive))
        return drive

    run = {"duration": 1e-6, "energy": False, "record": ("sprockets",), "progress": False}
    with ThreadPoolExecutor(2) as pool:
        where = {
            "pool": {"threads": 2},
            "threads": {"threads": 2, "callback": lambda _: None},
            "executor": {"executor": pool},
        }
        found = rc.sweep(build, {"mass": range(300)}, lambda r: r.time[-1], **run, **where[how])
    assert found.success
    assert most < {"pool": 270, "threads": 30, "executor": 90}[how]


def test_a_distribution_that_raises_is_refused_with_its_name():
    class Broken:
        def ppf(self, places):
            raise ZeroDivisionError("no scale")

    said = "samples: 'rtol' has .* has no values .ZeroDivisionError: no scale"
    with pytest.raises(rc.InvalidInput, match=said):
        rc.samples({"rtol": Broken()}, 2)
