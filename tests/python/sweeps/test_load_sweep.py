"""The cases of a store, read without a run; a store that several processes use at once."""

import subprocess
import sys

import numpy as np
import pytest

import rustchain as rc
from rustchain.plot import draw_map

SHORT = {"duration": 2e-3, "progress": False}
AXES = {"pretension": [25, 0, 100], "force_law": [rc.LankaraniNikravesh(), rc.Johnson()]}


def peak(result):
    return {"peak": result.peaks.tooth_force.max(), "rows": len(result.time)}


def end(result):
    return {"duration": result.time[-1]}


def test_a_store_gives_the_values_of_its_sweep_back(tmp_path):
    found = rc.sweep(rc.paper_drive(), AXES, peak, store=tmp_path, **SHORT)
    again = rc.load_sweep(tmp_path)
    assert again.success
    axes = {"pretension": (0, 25, 100), "force_law": (rc.Johnson(), rc.LankaraniNikravesh())}
    assert again.axes == axes
    assert len(again.cases) == 6
    for case, value in zip(again.cases, again.values, strict=True):
        number = found.cases.index(case)
        assert value == found.values[number]
    assert [case["pretension"] for case in again.cases] == [0, 0, 25, 25, 100, 100]
    table = again.to_pandas()
    assert list(table.columns) == ["pretension", "force_law", "peak", "rows"]
    assert table["peak"].sum() == pytest.approx(found.to_pandas()["peak"].sum(), rel=1e-14)
    assert again.to_xarray()["peak"].dims == ("pretension", "force_law")
    assert draw_map(again, "peak").axes[0].get_xlabel() == "pretension [N]"


def test_cases_that_are_no_grid_are_listed(tmp_path):
    cases = [{"pretension": 25, "speed": 10.0}, {"pretension": 0, "speed": 12.0}]
    rc.sweep(rc.paper_drive(), cases, peak, store=tmp_path, **SHORT)
    again = rc.load_sweep(tmp_path)
    assert again.axes is None
    assert again.to_xarray()["peak"].dims == ("case",)
    with pytest.raises(rc.InvalidInput, match=r"draw_map\(sweep\): got listed cases.*store"):
        draw_map(again, "peak")


def test_a_store_gives_results_back_when_they_are_accessed(tmp_path):
    found = rc.sweep(rc.paper_drive(), {"speed": [10.0, 12.0]}, store=tmp_path, **SHORT)
    again = rc.load_sweep(str(tmp_path))
    assert again.cases == [{"speed": 10.0}, {"speed": 12.0}]
    assert [result == found.results[k] for k, result in enumerate(again.results)] == [True, True]


def test_errors_and_warnings_of_a_store_are_those_of_its_sweep(tmp_path):
    axes = {"chain.material.elastic_modulus": [2e11, 1e300]}
    with pytest.warns(rc.CaseWarning):
        found = rc.sweep(
            rc.paper_drive(), axes, peak, duration=5e-3, store=tmp_path, progress=False
        )
    again = rc.load_sweep(tmp_path)
    assert again.errors.keys() == found.errors.keys() == {1}
    assert str(again.errors[1]) == str(found.errors[1])
    assert again.values == found.values
    assert again.law_warnings == found.law_warnings
    assert "error" in again.to_pandas().columns


def test_two_sweeps_share_a_store_unless_one_keeps_results(tmp_path):
    rc.sweep(rc.paper_drive(), {"speed": [10.0]}, peak, store=tmp_path, **SHORT)
    rc.sweep(rc.paper_drive(), {"pretension": [25]}, peak, store=tmp_path, **SHORT)
    again = rc.load_sweep(tmp_path)
    assert again.cases == [{"pretension": 25}, {"speed": 10.0}]
    assert np.isnan(again.to_pandas()["speed"][0])
    rc.sweep(rc.paper_drive(), {"speed": [10.0]}, store=tmp_path, **SHORT)
    with pytest.raises(rc.InvalidInput, match="has measured values and results"):
        rc.load_sweep(tmp_path)


def test_arguments_of_the_run_in_which_stored_cases_differ_are_parameters(tmp_path):
    def swept(axes, **run):
        rc.sweep(rc.paper_drive(), axes, peak, store=tmp_path, **(SHORT | run))

    swept({"speed": [10.0, 12.0]})
    assert list(rc.load_sweep(tmp_path).to_pandas().columns) == ["speed", "peak", "rows"]
    swept({"speed": [10.0, 12.0]}, duration=1e-3)
    again = rc.load_sweep(tmp_path)
    assert again.axes == {"speed": (10.0, 12.0), "duration": (1e-3, 2e-3)}
    assert list(again.to_xarray()["rows"].sel(speed=10.0)) == [11, 21]
    swept({"speed": [10.0], "duration": [2e-3, 3e-3]}, record=("teeth", "sprockets"))
    table = rc.load_sweep(tmp_path).to_pandas()
    assert list(table.columns) == ["speed", "duration", "record", "peak", "rows"]
    assert list(table["duration"]) == [1e-3, 2e-3, 2e-3, 3e-3, 1e-3, 2e-3]
    some = "('teeth', 'sprockets')"
    assert list(table["record"]) == ["None", some, "None", some, "None", "None"]


def test_cases_of_different_drives_with_the_same_parameters_are_told(tmp_path):
    for drive in (rc.paper_drive(), rc.paper_drive(hinges="ideal")):
        rc.sweep(drive, {"pretension": [0, 25]}, peak, store=tmp_path, **SHORT)
    told = "2 of 4 cases have the parameters of another: they are of 2 different drives, laws"
    with pytest.warns(rc.CaseWarning, match=told):
        assert len(rc.load_sweep(tmp_path).cases) == 4


def test_a_measured_quantity_keeps_the_name_of_an_argument_of_the_run(tmp_path):
    for duration in (1e-3, 2e-3):
        rc.sweep(
            rc.paper_drive(),
            {"speed": [10.0]},
            end,
            store=tmp_path,
            **(SHORT | {"duration": duration}),
        )
    again = rc.load_sweep(tmp_path)
    assert list(again.to_pandas().columns) == ["speed", "duration"]
    assert sorted(again.to_pandas()["duration"]) == pytest.approx([1e-3, 2e-3])


def test_files_of_a_store_that_are_damaged_are_left_out_with_a_warning(tmp_path):
    rc.sweep(rc.paper_drive(), {"speed": [10.0, 12.0]}, peak, store=tmp_path, **SHORT)
    first = sorted(tmp_path.glob("*.nc"))[0]
    content = bytearray(first.read_bytes())
    content[len(content) // 2] ^= 1
    first.write_bytes(content)
    rc.Simulation(rc.paper_drive()).run(1e-3, progress=False).save(tmp_path / "run.nc")
    with pytest.warns(rc.CaseWarning, match="2 files are damaged or no cases, first"):
        assert len(rc.load_sweep(tmp_path).cases) == 1


def test_what_is_no_store_is_refused(tmp_path):
    with pytest.raises(rc.InvalidInput, match="has no case; give a folder that sweep had as store"):
        rc.load_sweep(tmp_path)
    with pytest.raises(FileNotFoundError, match="is no folder; give the one"):
        rc.load_sweep(tmp_path / "none")
    (tmp_path / "file").touch()
    with pytest.raises(NotADirectoryError, match="is no folder; give the one"):
        rc.load_sweep(tmp_path / "file")
    for value in (None, 3, b"runs", ""):
        with pytest.raises(rc.InvalidInput, match="store"):
            rc.load_sweep(value)


SWEEPS = """
import sys
import rustchain as rc

def peak(result):
    return {"peak": result.peaks.tooth_force.max(), "rows": len(result.time)}

found = rc.sweep(rc.paper_drive(), {"speed": [8.0, 9.0, 10.0, 11.0, 12.0]}, peak, duration=2e-3,
                 store=sys.argv[1], progress=False, threads=1)
print([value["peak"] for value in found.values])
"""


def test_processes_at_once_on_one_store_leave_every_case_once_and_whole(tmp_path):
    command = [sys.executable, "-W", "error", "-c", SWEEPS, str(tmp_path)]
    children = [
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    outputs = [child.communicate() for child in children]
    assert [child.returncode for child in children] == [0, 0, 0], outputs
    assert len({told for told, _ in outputs}) == 1
    assert len(list(tmp_path.iterdir())) == 5  # nothing unfinished is left
    again = rc.load_sweep(tmp_path)
    assert [case["speed"] for case in again.cases] == [8.0, 9.0, 10.0, 11.0, 12.0]
    assert str([value["peak"] for value in again.values]) == outputs[0][0].strip()
