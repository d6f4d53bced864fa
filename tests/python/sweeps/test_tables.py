"""Measured values of sweeps in tables of xarray and pandas."""

import numpy as np
import pytest

import rustchain as rc
from rustchain.sweeps.measure import check_names_of
from rustchain.sweeps.result import SweepResult

PAPER = rc.paper_drive()
SHORT = {"duration": 5e-3, "report_step": 1e-4, "progress": False}  # contacts begin at 4.1 ms


def peak(result):
    return result.peaks.tooth_force.max()


def test_measured_numbers_become_a_dataset_with_the_axes_as_dimensions():
    def measure(result):
        return {"peak": peak(result), "tension": result.strand("upper").tension[-3:]}

    axes = {
        "pretension": np.array([0.0, 25.0]),
        "hinge_law": [rc.Hertz(), rc.Johnson(damping="lankarani-nikravesh")],
    }
    swept = rc.sweep(PAPER, axes, measure, **SHORT)
    data = swept.to_xarray()
    assert data.sizes == {"pretension": 2, "hinge_law": 2, "tension_0": 3}
    assert data["tension"].dims == ("pretension", "hinge_law", "tension_0")
    assert list(data["hinge_law"].values) == ["Hertz", "Johnson"]
    for case, value in zip(swept.cases, swept.values, strict=True):
        there = data.sel(pretension=case["pretension"], hinge_law=type(case["hinge_law"]).__name__)
        assert float(there["peak"]) == value["peak"] > 0.0
        np.testing.assert_array_equal(there["tension"], value["tension"])
    table = swept.to_pandas()
    assert list(table.columns) == [*axes, "peak", "tension_0", "tension_1", "tension_2"]
    np.testing.assert_array_equal(table["peak"], data["peak"].values.ravel())
    assert list(table["pretension"]) == [0.0, 0.0, 25.0, 25.0]


def test_listed_cases_become_a_dataset_over_the_cases():
    swept = rc.sweep(PAPER, [{"pretension": 0}, {"pretension": 25, "rtol": 1e-4}], peak, **SHORT)
    data = swept.to_xarray()
    assert data["value"].dims == data["pretension"].dims == ("case",)
    np.testing.assert_array_equal(data["value"], swept.values)
    np.testing.assert_array_equal(data["rtol"], [np.nan, 1e-4])
    assert list(swept.to_pandas()["pretension"]) == [0, 25]


def test_laws_of_one_kind_are_told_apart():
    laws = [rc.Johnson(), rc.Johnson(damping="lankarani-nikravesh")]
    swept = rc.sweep(PAPER, {"force_law": laws}, peak, duration=1e-4, progress=False)
    assert list(swept.to_xarray()["force_law"].values) == list(map(repr, laws))


def test_measuring_arrays_of_different_shapes_leaves_them_as_values():
    def measure(result):
        return {"time": result.time, "end": result.time[-1]}

    swept = rc.sweep(PAPER, {"duration": [1e-3, 2e-3]}, measure, progress=False)
    assert [len(value["time"]) for value in swept.values] == [11, 21]
    with pytest.warns(
        UserWarning, match=r"'time' has shape \(11,\) .* and \(21,\) in another: NaN"
    ):
        data = swept.to_xarray()
    assert data["time"].shape == (2, 21)
    np.testing.assert_array_equal(data["time"].isnull().sum("time_0"), [10, 0])
    np.testing.assert_array_equal(data["time"][0, :11], swept.values[0]["time"])
    with pytest.warns(UserWarning, match="NaN fills the table"):
        assert list(swept.to_pandas()["end"]) == [1e-3, 2e-3]


def test_a_number_and_an_array_stand_in_one_table():
    def measure(result):
        return 3.0 if len(result.time) == 11 else [[1.0, 2.0]]

    swept = rc.sweep(PAPER, {"duration": [1e-3, 2e-3]}, measure, progress=False)
    with pytest.warns(UserWarning, match="NaN fills the table"):
        data = swept.to_xarray()
    np.testing.assert_array_equal(data["value"], [[[3.0, np.nan]], [[1.0, 2.0]]])


def test_whole_numbers_stay_whole_where_nothing_is_missing():
    swept = rc.sweep(PAPER, {"rtol": [1e-4, 1e-5]}, lambda r: r.stats["steps"], **SHORT)
    assert swept.to_xarray()["value"].dtype.kind == "i"


def test_results_are_kept_or_measured_and_each_says_so():
    kept = rc.sweep(PAPER, {"pretension": [0]}, duration=1e-4, progress=False)
    assert isinstance(kept.results[0], rc.Result)
    for table in (kept.to_xarray, kept.to_pandas):
        with pytest.raises(rc.NotRecorded, match="measure="):
            table()
    measured = rc.sweep(PAPER, {"pretension": [0]}, peak, duration=1e-4, progress=False)
    with pytest.raises(rc.NotRecorded, match="without measure"):
        _ = measured.results


@pytest.mark.parametrize("name", ["speed", "error", "case"])
def test_a_measured_name_that_is_taken_ends_the_sweep_with_its_first_case(name, tmp_path):
    calls = []

    def measure(result):
        calls.append(1)
        return {"peak": 1.0, name: 1.0}

    axes = {"speed": [1.0, 2.0, 3.0, 4.0]}
    for store in (None, tmp_path):
        with pytest.raises(rc.InvalidInput, match=f"measure: '{name}' is the name of a parameter"):
            rc.sweep(PAPER, axes, measure, store=store, threads=1, **SHORT)
    assert len(calls) == 2
    assert list(tmp_path.iterdir()) == []
    calls.clear()
    with pytest.raises(rc.InvalidInput, match=f"'{name}' is"):
        rc.study(PAPER, measure, axes=axes, threads=1, burn_in=0.0, **SHORT)
    assert len(calls) == 1


@pytest.mark.parametrize(
    ("measured", "named"),
    [
        ({"value": [1, 2], "value_0": 7}, "measured quantity 'value_0'"),
        ({"value": np.ones((5, 2)), "value_4": [1, 2]}, "measured quantity 'value_4'"),
        (np.ones((10, 2)), "parameter or dimension 'value_9_1'"),
    ],
)
def test_a_name_that_a_number_of_an_array_has_in_tables_is_refused(measured, named):
    """By the sweep with its first case, and by the tables."""
    calls = []

    def measure(result):
        calls.append(1)
        return measured

    axes = {"value_9_1": [0.0, 25.0]}
    said = f"the {named} and a dimension or a number of the array 'value' have the same name; name"
    with pytest.raises(rc.InvalidInput, match=said):
        rc.sweep(lambda value_9_1: rc.paper_drive(value_9_1), axes, measure, threads=1, **SHORT)
    assert len(calls) == 1
    found = SweepResult([{"value_9_1": 0.0}], None, [measured])
    for table in (found.to_xarray, found.to_pandas):
        with pytest.raises(rc.InvalidInput, match=said):
            table()


def test_names_of_two_cases_may_clash_in_tables():
    found = SweepResult([{"n": 0}, {"n": 1}], None, [{"a": [1, 2]}, {"a_1": 7}])
    with pytest.raises(rc.InvalidInput, match="'a_1' and a dimension or a number of the array 'a'"):
        found.to_pandas()


def test_two_measured_names_of_one_text_are_refused():
    """By the sweep with its first case, and by the tables of two cases."""
    said = "measure: 1 and '1' are one name in tables"
    with pytest.raises(rc.InvalidInput, match=said):
        rc.sweep(PAPER, {"pretension": [0.0]}, lambda _: {1: 2.0, "1": 3.0}, **SHORT)
    found = SweepResult([{"n": 0}, {"n": 1}], None, [{1: 2.0}, {"1": 3.0}])
    with pytest.raises(rc.InvalidInput, match=said):
        found.to_xarray()


def test_a_measured_array_with_rows_of_unlike_lengths_has_no_table():
    found = SweepResult([{"n": 0}], None, [{"a": 1.0, "b": [[1], [2, 3]]}])
    for table in (found.to_xarray, found.to_pandas):
        with pytest.raises(rc.InvalidInput, match=r"'b' = \[\[1\], \[2, 3\]\] has rows of"):
            table()


def test_names_that_no_number_of_an_array_has_are_kept():
    measured = {"a": np.ones((5, 2)), "a_4": 1.0, "a_00": 2.0, "a_5_0": 3.0, "b": [[1], [2, 3]]}
    check_names_of(measured, {"a_x", "b_0"})
    columns = SweepResult([{}], None, [{**measured, "b": 0.0}]).to_pandas().columns
    assert len(columns) == len(set(columns)) == 10 + 4
