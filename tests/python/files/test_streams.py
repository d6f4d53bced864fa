"""Runs that write their rows while they go on: same bits, same parts, little memory."""

import json
import os
import pickle
import re
import shutil
import subprocess
import sys
import time
import weakref
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import xarray as xr

import rustchain as rc
from command import rustchain
from cores import CoreAround, cores_within
from rustchain.results import netcdf
from rustchain.results.stored import is_streamed
from rustchain.results.stream import Stream
from streamed_runs import ALL_OF_A_DRIVE, LITTLE, PIECE, RUNS, SCENES


@pytest.mark.parametrize("kind", SCENES)
def test_pieces_have_the_bits_of_a_run_in_memory(kind, tmp_path):
    whole, streamed = SCENES[kind](), SCENES[kind]()
    result = whole.run(**RUNS[kind], progress=False)
    out = tmp_path / "run.nc"
    written = streamed.run(**RUNS[kind], progress=False, out=out, memory=LITTLE[kind])
    with h5py.File(out) as file:
        assert file["time"].chunks[0] < len(result.time) / 2
    assert written == result
    assert rc.load_result(out) == result
    assert streamed.state()["snapshot"] == whole.state()["snapshot"]
    # What follows is the same, too: the recording has left nothing behind.
    assert streamed.run(1e-3, progress=False) == whole.run(1e-3, progress=False)


def test_pieces_of_time_have_the_bits_of_a_run_in_memory(tmp_path, monkeypatch):
    append, lengths = Stream.append, []

    def noted(stream, take, jumps):
        def taken():
            rows = take()
            lengths.append(len(rows["time"]))
            return rows

        append(stream, taken, jumps)

    monkeypatch.setattr(Stream, "append", noted)
    monkeypatch.setattr("rustchain.simulation.recording._BETWEEN_PIECES", 0.0)
    result = SCENES["clearance"]().run(**RUNS["clearance"], progress=False)
    out = tmp_path / "run.nc"
    assert SCENES["clearance"]().run(**RUNS["clearance"], progress=False, out=out) == result
    # Each chunk is written once.
    with h5py.File(out) as file:
        assert {length % file["time"].chunks[0] for length in lengths} == {0}


@pytest.mark.parametrize("kind", SCENES)
def test_stop_conditions_and_callbacks_see_the_same_rows(kind, tmp_path):
    def looked(keywords):
        times = []
        simulation = SCENES[kind]()
        end = 0.7 * RUNS[kind]["duration"]
        result = simulation.run(
            **RUNS[kind],
            **keywords,
            progress=False,
            stop=[rc.TimeReached(end)],
            callback=lambda simulation: times.append(simulation.time),
        )
        return result, times

    result, times = looked({})
    streamed, again = looked({"out": tmp_path / "run.nc", "memory": LITTLE[kind]})
    assert streamed.status == "stopped"
    assert times == again
    assert streamed == result


def test_a_callback_sees_each_row_where_a_piece_has_a_single_one(tmp_path):
    run = {"duration": 2e-3, "report_step": 1e-4, "progress": False, "out": tmp_path / "run.nc"}
    with pytest.raises(rc.InvalidInput, match="expected at least") as refused:
        SCENES["mechanism"]().run(**run, memory=1)
    least = int(re.search(r"at least (\d+)", str(refused.value))[1])
    times = []
    result = SCENES["mechanism"]().run(
        **run, memory=least, callback=lambda simulation: times.append(simulation.time)
    )
    with h5py.File(tmp_path / "run.nc") as file:
        assert file["time"].chunks == (1,)
    assert times == list(result.time)
    assert len(times) == 21


def test_the_energy_balance_of_a_run_with_a_file_is_judged_once(tmp_path):
    drive = rc.paper_drive(hinges="ideal", pretension=100.0)
    run = {"record": ("energy",), "progress": False}
    simulation = rc.Simulation(drive, solver=rc.Solver(method="pece", rtol=0.3, atol=0.03))
    with pytest.raises(rc.EnergyWarning, match="the energy balance is off") as raised:
        simulation.run(0.02, **run, out=tmp_path / "run.nc")
    assert raised.value.result.success
    assert simulation.run(1e-5, **run).success


class EndsInNoNumber(CoreAround):
    """A core whose last row has no residual, as after a step that failed."""

    def take_recording(self):
        return self.without_last(self.core.take_recording())

    def take_rows(self, count):
        return self.without_last(self.core.take_rows(count))

    @staticmethod
    def without_last(rows):
        if len(rows.get("time", ())):
            rows["energy_residual"] = rows["energy_residual"].copy()
            rows["energy_residual"][-1] = np.nan
        return rows


@pytest.mark.parametrize("out", [None, "run.nc"])
def test_the_largest_residual_is_that_of_the_rows_that_have_one(out, tmp_path):
    with cores_within(EndsInNoNumber):
        simulation = rc.Simulation(rc.paper_drive(25.0))
    path = None if out is None else tmp_path / out
    result = simulation.run(2e-3, 1e-4, progress=False, out=path)
    residual = result.energy.residual
    assert np.isnan(residual[-1])
    assert result.stats["largest_residual"] == np.abs(residual[:-1]).max() > 0.0


def test_tooth_jumps_are_in_the_file(tmp_path):
    drive = rc.two_sprocket_drive(links=60, torque=-1.0)
    moved = rc.Simulation(drive)
    result = moved.run(2e-3, progress=False, out=tmp_path / "run.nc")
    assert len(result.tooth_jumps) == 0
    with h5py.File(tmp_path / "run.nc") as file:
        assert file["jump_time"].shape == (0,)


def test_a_run_goes_on_when_its_rows_have_been_taken(tmp_path, monkeypatch):
    append, taken = Stream.append, []

    def slowly_taken(stream, take, jumps):
        def slow():
            time.sleep(0.05)
            rows = take()
            taken.append(rows)
            return rows

        before = len(taken)
        append(stream, slow, jumps)
        assert len(taken) == before + 1

    monkeypatch.setattr(Stream, "append", slowly_taken)
    SCENES["ideal"]().run(**RUNS["ideal"], out=tmp_path / "run.nc", memory="2 MB", progress=False)
    assert taken


def test_rows_that_not_every_array_has_are_left_out(streamed, tmp_path):
    path, result = streamed
    shutil.copyfile(path, tmp_path / "run.nc")
    with h5py.File(tmp_path / "run.nc", "r+") as file:
        file["tooth_force"].resize(len(result.time) - 3, axis=0)
    loaded = rc.load_result(tmp_path / "run.nc")
    for name in ("time", "hinge_force", "tooth_force"):
        np.testing.assert_array_equal(loaded.arrays[name], result.arrays[name][:-3])


@pytest.fixture(scope="module")
def streamed(tmp_path_factory):
    """A file of a drive, and the same run in memory."""
    path = tmp_path_factory.mktemp("streamed") / "run.nc"
    keywords = {"duration": 0.02, "report_step": 2e-5, "record": ALL_OF_A_DRIVE}
    rc.Simulation(rc.paper_drive(25.0)).run(**keywords, progress=False, out=path, memory=PIECE)
    return path, rc.Simulation(rc.paper_drive(25.0)).run(**keywords, progress=False)


def test_parts_of_a_streamed_result_are_those_of_one_in_memory(streamed):
    path, result = streamed
    loaded = rc.load_result(path)
    assert loaded.groups == result.groups
    assert loaded.hinge(6) == result.hinge(6)
    assert loaded.bushing(6) == result.bushing(6)
    assert loaded.strand("upper") == result.strand("upper")
    assert loaded.sprocket(2) == result.sprocket(2)
    assert loaded.body("link_3") == result.body("link_3")
    assert loaded.energy == result.energy
    assert loaded.between(0.005, 0.006) == result.between(0.005, 0.006)
    assert loaded.summary() == result.summary()
    assert loaded == rc.load_result(path)
    assert pickle.loads(pickle.dumps(loaded)) == result


def test_arrays_of_a_streamed_result_are_read_only_and_not_kept(streamed):
    loaded = rc.load_result(streamed[0])
    force = loaded.array("hinge_force")
    with pytest.raises(ValueError, match="read-only"):
        force[0, 0] = 1.0
    assert loaded.array("hinge_force") is force  # as long as it is in use
    kept = weakref.ref(force)
    del force
    assert kept() is None
    with pytest.raises(rc.NotRecorded, match="no such array"):
        loaded.array("hinge_forces")


def test_a_streamed_file_saved_again_is_a_file_of_save(streamed, tmp_path):
    path, result = streamed
    rc.load_result(path).save(tmp_path / "again.nc")
    assert is_streamed(path)
    assert not is_streamed(tmp_path / "again.nc")
    assert rc.load_result(tmp_path / "again.nc") == result


def test_a_streamed_result_that_is_saved_onto_its_own_file_is_to_be_loaded_again(tmp_path):
    path = tmp_path / "run.nc"
    result = rc.Simulation(rc.paper_drive()).run(duration=1e-3, progress=False, out=path)
    force = result.array("hinge_force").copy()
    result.save(path)
    with pytest.raises(rc.InvalidInput, match="was replaced since it was loaded; load it again"):
        result.array("hinge_force")
    np.testing.assert_array_equal(rc.load_result(path).array("hinge_force"), force)


def test_a_streamed_file_of_few_rows_is_small_and_on_the_disc(tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr(os, "fsync", lambda file: synced.append(os.fstat(file).st_size))
    simulation = rc.Simulation(rc.paper_drive(25.0))
    result = simulation.run(duration=1e-3, progress=False, out=tmp_path / "short.nc")
    numbers = sum(array.nbytes for array in result.arrays.values())
    assert len(result.time) == 11
    assert (tmp_path / "short.nc").stat().st_size < 2 * numbers + 40_000
    assert synced[-1:] == [(tmp_path / "short.nc").stat().st_size]


def test_zeros_in_the_place_of_a_block_are_no_rows(streamed, tmp_path):
    path, result = streamed
    name = next(name for name in ("hinge_force", "position") if name in result.arrays)
    with h5py.File(path) as file:
        block = file[name].id.get_chunk_info(0)
    content = bytearray(path.read_bytes())
    content[block.byte_offset : block.byte_offset + block.size] = bytes(block.size)
    (tmp_path / "hole.nc").write_bytes(content)
    with pytest.raises(rc.InvalidInput, match="is damaged"):
        rc.load_result(tmp_path / "hole.nc").arrays[name]


def test_programs_that_read_netcdf_read_a_streamed_file(streamed):
    path, result = streamed
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as data:
        expected = result.to_xarray()
        for name in expected.data_vars:
            if name.startswith("final_"):
                continue
            np.testing.assert_array_equal(data[name].values, expected[name].values, err_msg=name)
            assert data[name].attrs == expected[name].attrs, name
            assert data[name].dims == expected[name].dims, name
        assert list(data["body"].values) == list(result.body_names)
        assert data.encoding["unlimited_dims"] >= {"time"}
    with h5py.File(path) as file:
        end = json.loads(file["run/end"][:].tobytes())
    assert (end["status"], end["message"]) == (result.status, result.message)
    np.testing.assert_array_equal(end["positions"], result.final_positions)


def test_a_file_is_read_while_its_run_goes_on(tmp_path, monkeypatch):
    path = tmp_path / "run.nc"
    seen, attempts = [], []

    def in_a_piece_at_first(work, given):
        attempts.append(given)
        if len(attempts) < 3:
            raise OSError("half of an index")
        return work(given)

    def look(simulation):
        if simulation.time > 0.02:
            with monkeypatch.context() as patched:
                patched.setattr(netcdf, "beside", in_a_piece_at_first)
                seen.append(rc.load_result(path))
            return True
        return False

    run = {"duration": 0.03, "report_step": 4e-5, "progress": False}
    rc.Simulation(rc.paper_drive()).run(**run, out=path, memory=PIECE, callback=look)
    (found,) = seen
    assert found.status == "interrupted"
    assert "has not ended; it has rows until t = 0.0" in found.message
    assert np.isnan(found.final_positions).all()
    result = rc.Simulation(rc.paper_drive()).run(**run)
    rows = len(found.time)
    assert rows >= 256
    for name in result.arrays:
        if name not in found.arrays.empty:
            now = rc.load_result(path).arrays[name][:rows]
            np.testing.assert_array_equal(now, result.arrays[name][:rows], err_msg=name)


@pytest.mark.parametrize(
    ("memory", "told"),
    [
        ("lots", r"memory = 'lots': expected a size such as '256 MB'"),
        ("256", "memory = '256': expected a size"),
        ("-1 MB", "expected a size"),
        ("1e3 MB", "expected a size"),
        (True, "memory = True: expected a size"),
        (2.5e8, "expected a size"),
        (0, "memory = 0: expected a size"),
        (2**70, "expected a size"),
        ("9" * 400 + " MB", "expected a size"),
        ("10 kB", r"memory = '10 kB': is too little for rows of \d+ bytes; expected at least \d+"),
    ],
)
def test_what_is_no_memory_is_refused_before_a_file_is_made(memory, told, tmp_path):
    simulation = rc.Simulation(rc.paper_drive())
    with pytest.raises(rc.InvalidInput, match=told):
        simulation.run(1e-3, out=tmp_path / "run.nc", memory=memory, progress=False)
    assert list(tmp_path.iterdir()) == []
    assert simulation.time == 0.0


@pytest.mark.parametrize(
    "memory", ["20 MB", "20MB", "0.02 gb", "20 MiB", 20_000_000, np.int64(2e7)]
)
def test_memory_is_a_size_or_bytes(memory, tmp_path):
    run = {"duration": 1e-3, "progress": False, "out": tmp_path / "run.nc"}
    assert rc.Simulation(rc.paper_drive()).run(**run, memory=memory).success


def test_more_rows_than_the_disc_has_room_for_are_refused(tmp_path, monkeypatch):
    simulation = rc.Simulation(rc.paper_drive())
    long = {"duration": 1e-2, "report_step": 1e-5, "out": tmp_path / "run.nc", "progress": False}
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=3e6))
    told = (
        r"report_step = 1e-05: gives 1e\+03 rows .* where the disc has 0\.00279 GiB free: take 2\."
    )
    with pytest.raises(rc.InvalidInput, match=told):
        simulation.run(**long)
    assert simulation.time == 0.0
    assert list(tmp_path.iterdir()) == []
    # A run that a condition ends may have any duration; the file that it replaces gives room.
    assert simulation.run(**long, stop=rc.TimeReached(1e-3)).status == "stopped"
    assert simulation.run(**long, callback=lambda _: False).success
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=1e6))
    assert simulation.run(**long).success


def test_memory_without_a_file_is_refused():
    with pytest.raises(rc.InvalidInput, match="is for runs with a file; pass out= too"):
        rc.Simulation(rc.paper_drive()).run(1e-3, memory="1 MB", progress=False)


def test_a_path_that_cannot_be_written_is_refused_before_the_first_step(tmp_path):
    simulation = rc.Simulation(rc.paper_drive())
    (tmp_path / "file").touch()
    for path, error in (
        (tmp_path, IsADirectoryError),
        (tmp_path / "none" / "run.nc", FileNotFoundError),
        (tmp_path / "file" / "run.nc", NotADirectoryError),
    ):
        with pytest.raises(error, match=r"out = .*cannot be written") as refused:
            simulation.run(1e-3, out=path, progress=False)
        told = str(refused.value)
        assert any(words in told for words in ("(Is a dir", "(No such file", "(Not a dir"))
        assert ".part" not in told
        assert not hasattr(refused.value, "result")
    for path in (3, b"run.nc", "a\0b", ""):
        with pytest.raises(rc.InvalidInput, match="out"):
            simulation.run(1e-3, out=path, progress=False)
    assert simulation.time == 0.0
    assert simulation.run(1e-3, progress=False).success


def test_a_file_named_from_the_folder_stays_where_it_is_when_the_folder_changes(
    tmp_path, monkeypatch
):
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path)

    def leaves(simulation):
        os.chdir(tmp_path / "other")

    run = {"duration": 1e-3, "progress": False, "out": "run.nc"}
    result = rc.Simulation(rc.paper_drive()).run(**run, callback=leaves)
    assert rc.load_result(tmp_path / "run.nc") == result
    assert list((tmp_path / "other").iterdir()) == []


def test_other_programs_may_read_a_file_while_it_is_written(tmp_path):
    """Bits 1 and 3 of the superblock's marks: open for writing, by a single writer with readers."""
    path, marks = tmp_path / "run.nc", set()
    run = {"duration": 1e-3, "progress": False, "out": path}
    rc.Simulation(rc.paper_drive()).run(
        **run, callback=lambda simulation: marks.add(path.read_bytes()[11])
    )
    assert marks == {5}
    assert path.read_bytes()[11] == 0


GROWS = """
import sys
import rustchain as rc

rc.Simulation(rc.paper_drive(25.0)).run(
    float(sys.argv[1]), 1e-5, record=("hinges", "teeth", "sprockets", "bodies", "energy"),
    out=sys.argv[2], memory="64 MB", progress=False)
print(open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="/proc of Linux")
@pytest.mark.slow
def test_memory_does_not_grow_with_the_duration(tmp_path):
    peaks = []
    # One arena of malloc: what several keep depends on which threads meet.
    environment = os.environ | {"MALLOC_ARENA_MAX": "1"}
    for duration in (0.3, 0.7):  # 220 MB and 510 MB of rows
        command = [sys.executable, "-c", GROWS, str(duration), str(tmp_path / "run.nc")]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        peaks.append(1024 * int(done.stdout))
    assert max(peaks) < 200e6
    # Of 290 MB more. Whether the next piece is ready while one is written is left to chance: a
    # piece takes 13 MB, and as much again for its copy.
    assert peaks[1] - peaks[0] < 50e6


def test_the_command_streams(tmp_path):
    path = tmp_path / "run.nc"
    done = rustchain("run", "paper", "--duration", 1e-3, "--out", path, "--memory", "20 MB")
    assert done.exit_code == 0, done.output
    assert is_streamed(path)
    assert rc.load_result(path).success
    refused = rustchain("run", "paper", "--out", path, "--memory", "much")
    assert refused.exit_code == 1
    assert "memory = 'much': expected a size such as '256 MB'" in refused.output


def test_a_file_may_have_the_memory_of_its_run(tmp_path):
    text = '[drive]\ntype = "paper_drive"\n[run]\nduration = 1e-3\nmemory = "{}"\n'
    file = tmp_path / "drive.toml"
    file.write_text(text.format("20 MB"))
    run = ["run", file, "--out", tmp_path / "run.nc"]
    assert rustchain(*run).exit_code == 0
    file.write_text(text.format("much"))
    for command in (run, ["check", file]):
        done = rustchain(*command)
        assert done.exit_code == 1
        assert "memory = 'much': expected a size" in done.output
