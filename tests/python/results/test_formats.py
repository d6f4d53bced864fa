"""Formats of files: a number in each, one unit a variable, and stored files of the present one."""

import hashlib
import io
import sys
import threading
from pathlib import Path

import h5py
import numpy as np
import pint_xarray  # noqa: F401, gives datasets their .pint
import pytest
import xarray as xr

import rustchain as rc
from rustchain.results import netcdf

DATA = Path(__file__).parents[2] / "data"
RESULT, STATE = DATA / "result_format_1.nc", DATA / "state.npz"


def drive_run():
    everything = ("hinges", "teeth", "sprockets", "bodies")
    simulation = rc.Simulation(rc.paper_drive(25.0))
    return simulation.run(duration=2e-3, record=everything, progress=False)


def mechanism_run():
    pendulum = rc.Mechanism()
    pendulum.add_body("bob", 1.0, 0.1, velocity=(1.0, 0.0, 1.0))
    pendulum.add_revolute("pivot", "ground", "bob", at=(0.0, 1.0))
    return rc.Simulation(pendulum).run(duration=2e-3, progress=False)


RUNS = {"drive": drive_run, "mechanism": mechanism_run}


@pytest.mark.parametrize("kind", RUNS)
def test_every_variable_of_a_file_has_one_unit_that_pint_reads(kind, tmp_path):
    RUNS[kind]().save(tmp_path / "run.nc")
    data = xr.load_dataset(tmp_path / "run.nc", engine="h5netcdf", decode_times=False)
    units = {name: v.pint.units for name, v in data.pint.quantify().data_vars.items()}
    assert [name for name, unit in units.items() if unit is None] == []
    assert str(units["position"]) == "meter"
    assert str(units["angle"]) == "radian"
    assert str(units["angular_velocity"]) == "radian / second"


def test_a_dataset_goes_through_a_file_and_other_programs_read_it(tmp_path):
    variables = {
        "flag": (("case",), np.array([True, False, True])),
        "whole": (("case", "k"), np.arange(6).reshape(3, 2), {"units": "N"}),
        "single": ((), 2.5),
        "gaps": (("case",), [np.nan, 1.0, np.inf]),
        "text": (("case",), ["a", "bß", ""]),
        "nothing": (("z",), np.empty(0)),
        "byte": (("case",), np.array([1, 2, 3], np.uint8)),
        "nothing_0": (("gaps_0",), np.ones(2)),
        "gaps_0": (("k", "gaps_0"), np.ones((2, 2))),
    }
    coordinates = {"case": [10, 20, 30], "tension": ("case", [1.0, 2.0, 3.0])}
    dataset = xr.Dataset(variables, coordinates, {"text": "ä", "number": 3, "some": [1, 2]})
    netcdf.write(dataset, tmp_path / "any.nc")
    for found in (
        netcdf.read(tmp_path / "any.nc"),
        xr.load_dataset(tmp_path / "any.nc", engine="h5netcdf"),
    ):
        assert found.identical(dataset)
    assert list(netcdf.read(tmp_path / "any.nc").data_vars) == list(dataset.data_vars)


def test_a_file_that_cannot_be_read_leaves_the_next_one_readable(tmp_path):
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        file.create_group("a")  # no variable
        file["b"] = 1.0
    body = image.getvalue()
    line = f"\nrustchain sha256 {hashlib.sha256(body).hexdigest()}\n"
    (tmp_path / "group.nc").write_bytes(body + line.encode())
    with pytest.raises(rc.InvalidInput) as kept:  # with all that the error holds
        netcdf.read(tmp_path / "group.nc")
    dataset = xr.Dataset({"a": 1.0})
    after = threading.Thread(target=netcdf.write, args=(dataset, tmp_path / "a.nc"), daemon=True)
    after.start()
    after.join(60.0)
    assert not after.is_alive(), kept
    assert netcdf.read(tmp_path / "a.nc").identical(dataset)


@pytest.mark.parametrize("kind", RUNS)
def test_a_file_has_format_scene_version_and_platform(kind):
    attributes = RUNS[kind]().to_xarray().attrs
    assert attributes["format"] == 1
    assert attributes["rustchain_version"] == rc.__version__
    assert rc.instruction_set() in attributes["platform"]
    assert sys.platform in attributes["platform"].lower()
    assert attributes["scene"].startswith('{"type": "Scene"')


@pytest.mark.parametrize("kind", RUNS)
def test_arrays_go_through_a_file_with_every_bit(kind, tmp_path):
    result = RUNS[kind]()
    result.save(tmp_path / "run.nc")
    again = rc.load_result(tmp_path / "run.nc")
    assert again.arrays.keys() == result.arrays.keys()
    for name, array in result.arrays.items():
        np.testing.assert_array_equal(again.arrays[name], array)
    for name in ("initial_positions", "final_velocities"):
        np.testing.assert_array_equal(getattr(again, name), getattr(result, name))


def test_the_stored_result_of_this_format_loads():
    result = rc.load_result(RESULT)
    assert result.drive == rc.paper_drive(25.0)
    assert result.status == "finished"
    np.testing.assert_allclose(result.time, [0.0, 1e-3, 2e-3])
    assert result.sprocket(1).speed[-1] == pytest.approx(12.566, abs=1e-3)


@pytest.mark.parametrize("number", [2, None])
def test_a_result_of_another_format_is_refused_by_its_number(number, tmp_path):
    data = mechanism_run().to_xarray()
    data.attrs = {name: value for name, value in data.attrs.items() if name != "format"}
    data.attrs |= {} if number is None else {"format": number}
    netcdf.write(data, tmp_path / "run.nc")
    told = rf"has format {'none' if number is None else 2}, this rustchain reads 1: load it with"
    with pytest.raises(rc.InvalidInput, match=told) as refused:
        rc.load_result(tmp_path / "run.nc")
    assert rc.__version__ in str(refused.value)


def test_the_stored_state_of_an_older_version_is_refused_by_its_number():
    with pytest.raises(rc.InvalidInput, match=r"(format|version) \d+"):
        rc.Simulation.load_state(STATE)


def test_a_spectrum_is_of_one_unit():
    result = rc.Simulation(rc.paper_drive(25.0)).run(5e-3, record=("bodies",), progress=False)
    assert result.spectrum("angle").attrs["units"] == "rad^2/Hz"
    with pytest.raises(rc.InvalidInput, match="has two units; expected 'position' or 'angle'"):
        result.spectrum("positions")


@pytest.mark.parametrize("streamed", [False, True])
def test_an_open_chain_without_sprockets_keeps_its_groups_in_files(tmp_path, streamed):
    ends = rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(5.0)
    drive = rc.open_chain("ANSI 40", ends, links=6)
    path = tmp_path / "run.nc"
    record = ("hinges", "teeth", "sprockets", "energy")
    given = {"out": path} if streamed else {}
    result = rc.Simulation(drive).run(2e-3, record=record, progress=False, **given)
    if not streamed:
        result.save(path)
    found = rc.load_result(path)
    assert found.groups == result.groups
    assert "sprockets" in found.groups
    assert found.array("sprocket_center").shape == (21, 0, 2)
    assert found == result
    assert found.power_balance().equals(result.power_balance())
    assert found.between(1e-3) == result.between(1e-3)


def test_groups_that_were_not_recorded_stay_away_from_files_of_a_chain_without_sprockets(tmp_path):
    drive = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=6)
    result = rc.Simulation(drive).run(1e-3, record=("hinges",), progress=False)
    result.save(tmp_path / "run.nc")
    assert rc.load_result(tmp_path / "run.nc").groups == result.groups
    assert "sprockets" not in result.groups
