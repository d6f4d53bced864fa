"""Runs that write their rows while they go on: same bits, little memory, nothing lost."""

import errno
import json
import os
import pickle
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import weakref
from itertools import pairwise
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import rustchain as rc
from cores import CoreAround, cores_within
from rustchain.cli.app import app
from rustchain.results import netcdf
from rustchain.results.stored import is_streamed
from rustchain.results.stream import Stream

ALL_OF_A_DRIVE = ("hinges", "teeth", "sprockets", "bodies", "energy")
PIECE = "10 MB"  # of the rows of the paper's drive: 256 rows at once
KILLS = 6
posix = pytest.mark.skipif(os.name != "posix", reason="POSIX signals and limits")


def pendulum():
    mechanism = rc.Mechanism(name="pendulum")
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", point_b=(-0.5, 0.0))
    return mechanism


SCENES = {
    "clearance": lambda: rc.Simulation(rc.paper_drive(25.0)),
    "ideal": lambda: rc.Simulation(rc.paper_drive(25.0, hinges="ideal")),
    "mechanism": lambda: rc.Simulation(pendulum()),
}
RUNS = {
    "clearance": {"duration": 0.03, "report_step": 4e-5, "record": ALL_OF_A_DRIVE},
    "ideal": {"duration": 3e-3, "report_step": 1e-5, "record": ALL_OF_A_DRIVE},
    "mechanism": {"duration": 0.3, "report_step": 1e-4},
}
LITTLE = {"clearance": PIECE, "ideal": "2 MB", "mechanism": "100 kB"}


def same(one, other):
    """Check that two results are the same, but for times of the wall."""
    assert one.arrays.keys() == other.arrays.keys()
    for name, array in one.arrays.items():
        np.testing.assert_array_equal(other.arrays[name], array, err_msg=name, strict=True)
    for name, value in vars(one).items():
        if name == "stats":
            value, again = (
                {n: x for n, x in found.stats.items() if not n.startswith("wall_")}
                for found in (one, other)
            )
            assert again == value
        elif name == "jumps":
            assert (other.jumps is None) == (value is None)
            for column, again in zip(value or (), other.jumps or (), strict=True):
                np.testing.assert_array_equal(again, column)
        elif name != "arrays":
            assert np.array_equal(getattr(other, name), value), name


@pytest.mark.parametrize("kind", SCENES)
def test_pieces_have_the_bits_of_a_run_in_memory(kind, tmp_path):
    whole, streamed = SCENES[kind](), SCENES[kind]()
    result = whole.run(**RUNS[kind], progress=False)
    out = tmp_path / "run.nc"
    written = streamed.run(**RUNS[kind], progress=False, out=out, memory=LITTLE[kind])
    with h5py.File(out) as file:
        assert file["time"].chunks[0] < len(result.time) / 2
    same(result, written)
    same(result, rc.load_result(out))
    assert streamed.state()["snapshot"] == whole.state()["snapshot"]
    # What follows is the same, too: the recording has left nothing behind.
    same(whole.run(1e-3, progress=False), streamed.run(1e-3, progress=False))


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
    same(result, SCENES["clearance"]().run(**RUNS["clearance"], progress=False, out=out))
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
    same(result, streamed)


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


def test_each_tooth_jump_is_once_in_a_file_of_several_pieces(tmp_path):
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=20, torque=-10, pretension=50
    )
    law = rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
    run = {"duration": 0.5, "report_step": 1e-3, "record": ("teeth",), "progress": False}
    path = tmp_path / "run.nc"
    with pytest.warns(rc.ToothJumpWarning):
        result = rc.Simulation(drive, law).run(**run, out=path, memory="1 MB")
    jumps = rc.load_result(path).tooth_jumps
    assert len(jumps) >= 2
    assert jumps.equals(result.tooth_jumps)
    assert jumps["time"].is_monotonic_increasing
    with h5py.File(path, "r+") as file:  # as a kill between two columns leaves it
        file["jump_direction"].resize(1, axis=0)
    assert rc.load_result(path).tooth_jumps.equals(result.tooth_jumps[:1])


def test_a_file_has_whole_rows_whenever_its_process_is_killed(tmp_path, monkeypatch):
    path, resize, states = tmp_path / "run.nc", h5py.Dataset.resize, []

    def resized(dataset, *arguments, **keywords):
        resize(dataset, *arguments, **keywords)
        dataset.file.flush()
        if path.exists():
            states.append(path.read_bytes())

    monkeypatch.setattr(h5py.Dataset, "resize", resized)
    run = {"duration": 0.03, "report_step": 1e-4, "progress": False}
    SCENES["mechanism"]().run(**run, out=path, memory=LITTLE["mechanism"])
    expected = SCENES["mechanism"]().run(**run)
    lengths = []
    for content in states:
        path.write_bytes(content)
        try:
            found = rc.load_result(path)
        except rc.InvalidInput:  # no row has been written
            lengths.append(0)
            continue
        assert found.status == "interrupted"
        lengths.append(len(found.time))
        for name in found.arrays:
            whole = expected.arrays[name][: len(found.time)]
            np.testing.assert_array_equal(found.arrays[name], whole, err_msg=name)
    assert lengths == sorted(lengths)
    assert len(set(lengths)) > 3
    assert lengths[-1] == len(expected.time)


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


def test_a_piece_that_cannot_be_taken_fails_its_run(tmp_path, monkeypatch):
    append, pieces = Stream.append, []

    def second_fails(stream, take, jumps):
        pieces.append(take)
        append(stream, (lambda: bytes(2**62)) if len(pieces) == 2 else take, jumps)

    monkeypatch.setattr(Stream, "append", second_fails)
    path = tmp_path / "run.nc"
    run = {"duration": 0.03, "report_step": 4e-5, "progress": False, "memory": PIECE}
    with pytest.raises(MemoryError) as failed:
        rc.Simulation(rc.paper_drive()).run(**run, out=path)
    loaded = rc.load_result(path)
    assert (loaded.status, len(loaded.time)) == ("failed", 256)
    same(failed.value.result, loaded)


def test_rows_that_not_every_array_has_are_left_out(streamed, tmp_path):
    path, result = streamed
    shutil.copyfile(path, tmp_path / "run.nc")
    with h5py.File(tmp_path / "run.nc", "r+") as file:
        file["tooth_force"].resize(len(result.time) - 3, axis=0)
    loaded = rc.load_result(tmp_path / "run.nc")
    for name in ("time", "hinge_force", "tooth_force"):
        np.testing.assert_array_equal(loaded.arrays[name], result.arrays[name][:-3])


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room is kept here")
def test_room_for_each_piece_is_kept_before_it_is_written(tmp_path, monkeypatch):
    kept, reserve = [], os.posix_fallocate

    def reserved(file, offset, size):
        kept.append((offset, offset + size))
        reserve(file, offset, size)

    monkeypatch.setattr(os, "posix_fallocate", reserved)
    run = {"duration": 0.03, "report_step": 1e-5, "record": ALL_OF_A_DRIVE, "progress": False}
    rc.Simulation(rc.paper_drive()).run(**run, out=tmp_path / "run.nc", memory="40 MB")
    assert len(kept) >= 3
    for (_, room), (end, _) in pairwise(kept):
        assert end <= room
    assert (tmp_path / "run.nc").stat().st_size <= kept[-1][1]


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
    same(result.between(0.005, 0.006), loaded.between(0.005, 0.006))
    assert loaded.summary() == result.summary()
    assert loaded == rc.load_result(path)
    same(result, pickle.loads(pickle.dumps(loaded)))


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
    same(result, rc.load_result(tmp_path / "again.nc"))


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


def test_an_error_of_the_disc_as_a_file_is_closed_is_told(tmp_path, monkeypatch):
    def fails(file):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "fsync", fails)
    path = tmp_path / "run.nc"
    with pytest.raises(OSError, match=r"cannot be written \(Input/output error\).*first 11 rows"):
        rc.Simulation(rc.paper_drive()).run(1e-3, progress=False, out=path)


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


def test_a_run_that_cannot_go_on_leaves_its_rows_in_the_file(tmp_path):
    def fails(simulation):
        if simulation.time > 0.015:
            raise ZeroDivisionError

    path = tmp_path / "run.nc"
    simulation = rc.Simulation(rc.paper_drive())
    run = {"duration": 0.03, "report_step": 4e-5, "progress": False}
    with pytest.raises(ZeroDivisionError) as failed:
        simulation.run(**run, out=path, memory=PIECE, callback=fails)
    loaded = rc.load_result(path)
    assert loaded.status == "failed"
    assert loaded.message == "ZeroDivisionError()"
    assert loaded.time[-1] == pytest.approx(0.015, abs=1e-4)
    same(failed.value.result, loaded)


@pytest.mark.parametrize("after", [0.015, 0.0299])
def test_a_file_that_another_program_replaced_keeps_every_byte(after, tmp_path):
    path = tmp_path / "run.nc"
    content = bytes(25_600)

    def another(simulation):
        if simulation.time > after and not (tmp_path / "moved.nc").exists():
            path.rename(tmp_path / "moved.nc")
            path.write_bytes(content)

    run = {"duration": 0.03, "report_step": 4e-5, "progress": False, "memory": PIECE}
    with pytest.raises(OSError, match="was replaced or removed while the run wrote it"):
        rc.Simulation(rc.paper_drive()).run(**run, out=path, callback=another)
    assert path.read_bytes() == content
    moved = rc.load_result(tmp_path / "moved.nc")
    assert moved.status == "interrupted"
    assert len(moved.time) >= 256


def test_a_file_that_is_removed_during_its_run_ends_it(tmp_path):
    path = tmp_path / "run.nc"

    def removed(simulation):
        if simulation.time > 0.015:
            path.unlink(missing_ok=True)

    run = {"duration": 0.03, "report_step": 4e-5, "progress": False, "memory": PIECE}
    with pytest.raises(OSError, match=r"was replaced .* wrote it; give each run its own file$"):
        rc.Simulation(rc.paper_drive()).run(**run, out=path, callback=removed)
    assert not path.exists()


def test_a_file_named_from_the_folder_stays_where_it_is_when_the_folder_changes(
    tmp_path, monkeypatch
):
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path)

    def leaves(simulation):
        os.chdir(tmp_path / "other")

    run = {"duration": 1e-3, "progress": False, "out": "run.nc"}
    result = rc.Simulation(rc.paper_drive()).run(**run, callback=leaves)
    same(result, rc.load_result(tmp_path / "run.nc"))
    assert list((tmp_path / "other").iterdir()) == []


def test_an_error_of_hdf5_is_told_in_one_line(tmp_path, monkeypatch):
    def fails(dataset, *arguments, **keywords):
        raise RuntimeError("no room (file 1)\n  of another piece")

    monkeypatch.setattr(h5py.Dataset, "resize", fails)
    told = r"cannot be written \(no room \(file 1\)\); expected .*; its first 0 rows are in .*\.nc$"
    with pytest.raises(OSError, match=told):
        rc.Simulation(rc.paper_drive()).run(1e-3, progress=False, out=tmp_path / "run.nc")


def test_a_file_that_is_replaced_when_it_is_opened_for_rows_keeps_every_byte(tmp_path, monkeypatch):
    path, opens = tmp_path / "run.nc", h5py.File
    content = bytes(25_600)

    def opened(where, mode, **keywords):
        made = opens(where, mode, **keywords)
        if mode == "r+":
            (tmp_path / "new.nc").write_bytes(content)
            (tmp_path / "new.nc").replace(path)
        return made

    simulation = rc.Simulation(rc.paper_drive())
    with monkeypatch.context() as patched:
        patched.setattr(h5py, "File", opened)
        with pytest.raises(OSError, match="was replaced or removed while the run wrote it"):
            simulation.run(1e-3, progress=False, out=path)
    assert path.read_bytes() == content
    assert simulation.time == 0.0


def test_other_programs_may_read_a_file_while_it_is_written(tmp_path):
    """Bits 1 and 3 of the superblock's marks: open for writing, by a single writer with readers."""
    path, marks = tmp_path / "run.nc", set()
    run = {"duration": 1e-3, "progress": False, "out": path}
    rc.Simulation(rc.paper_drive()).run(
        **run, callback=lambda simulation: marks.add(path.read_bytes()[11])
    )
    assert marks == {5}
    assert path.read_bytes()[11] == 0


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room is kept here")
def test_a_piece_that_fails_ends_the_run_before_another_one_is_taken(tmp_path, monkeypatch):
    """The second is handed over while the first is being written."""
    append, pieces, second = Stream.append, [], threading.Event()

    def appended(stream, take, jumps):
        def noted():
            pieces.append(take)
            return take()

        if pieces:
            second.set()
        append(stream, noted, jumps)

    def full(file, offset, size):
        second.wait(600.0)
        time.sleep(0.2)  # with less, a run that does not wait may go unnoticed
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Stream, "append", appended)
    monkeypatch.setattr(os, "posix_fallocate", full)
    run = {"duration": 0.03, "report_step": 4e-5, "progress": False, "memory": PIECE}
    with pytest.raises(OSError, match=r"No space left.*its first 0 rows are in"):
        rc.Simulation(rc.paper_drive()).run(**run, out=tmp_path / "run.nc")
    assert len(pieces) == 1


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room is kept here")
def test_a_disc_that_keeps_no_room_is_written_nevertheless(tmp_path, monkeypatch):
    def unable(file, offset, size):
        raise OSError(errno.EOPNOTSUPP, "Operation not supported")

    monkeypatch.setattr(os, "posix_fallocate", unable)
    path = tmp_path / "run.nc"
    result = SCENES["mechanism"]().run(**RUNS["mechanism"], out=path, progress=False)
    same(SCENES["mechanism"]().run(**RUNS["mechanism"], progress=False), rc.load_result(path))
    assert result.success


def refuse_room(monkeypatch, piece, number=errno.ENOSPC):
    """Let a piece of a file, counted from 1, have no room; return the sizes of all pieces."""
    reserve, sizes = os.posix_fallocate, []

    def reserved(file, offset, size):
        sizes.append(size)
        if len(sizes) == piece:
            raise OSError(number, "No room left")
        reserve(file, offset, size)

    monkeypatch.setattr(os, "posix_fallocate", reserved)
    return sizes


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room is kept here")
def test_a_file_without_room_for_its_end_is_not_of_a_finished_run(tmp_path, monkeypatch):
    refuse_room(monkeypatch, 2)
    path = tmp_path / "run.nc"
    with pytest.raises(OSError, match=r"No room left.*its first 11 rows are in"):
        rc.Simulation(rc.paper_drive()).run(1e-3, out=path, progress=False)
    loaded = rc.load_result(path)
    assert (loaded.status, len(loaded.time)) == ("interrupted", 11)


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room is kept here")
def test_a_run_that_fails_on_a_full_disc_has_its_own_error_in_the_file(tmp_path, monkeypatch):
    sizes = refuse_room(monkeypatch, 1)

    def fails(simulation):
        raise ZeroDivisionError

    path = tmp_path / "run.nc"
    with pytest.raises(ZeroDivisionError):
        rc.Simulation(rc.paper_drive()).run(1e-3, out=path, progress=False, callback=fails)
    assert len(sizes) == 2
    with h5py.File(path) as file:
        end = json.loads(file["run/end"][:].tobytes())
    assert (end["status"], end["message"]) == ("failed", "ZeroDivisionError()")


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="no room is kept here")
@pytest.mark.parametrize(
    ("piece", "number"), [(2, errno.ENOSPC), (3, errno.ENOSPC), (2, errno.EDQUOT), (2, errno.EFBIG)]
)
def test_a_file_without_its_last_pieces_is_not_of_a_finished_run(
    piece, number, tmp_path, monkeypatch
):
    # The end, which is short, has room.
    refuse_room(monkeypatch, piece, number)
    path = tmp_path / "run.nc"
    run = {"duration": 0.03, "report_step": 4e-5, "progress": False, "memory": PIECE}
    with pytest.raises(OSError, match=r"No room left.*its first \d+ rows are in") as failed:
        rc.Simulation(rc.paper_drive()).run(**run, out=path)
    loaded = rc.load_result(path)
    assert loaded.status == "failed"
    assert "No room left" in loaded.message
    assert len(loaded.time) == 256 * (piece - 1)
    same(failed.value.result, loaded)


def test_a_file_that_another_run_replaced_is_left_to_it(tmp_path):
    path = tmp_path / "run.nc"
    run = {"duration": 0.03, "report_step": 4e-5, "progress": False, "memory": PIECE}

    def another(simulation):
        if not done and simulation.time > 0.015:
            done.append(rc.Simulation(rc.paper_drive()).run(2e-3, progress=False, out=path))

    done = []
    with pytest.raises(OSError, match="was replaced or removed while the run wrote it") as failed:
        rc.Simulation(rc.paper_drive()).run(**run, out=path, callback=another)
    assert len(failed.value.result.time) == 0
    same(done[0], rc.load_result(path))
    before = rc.load_result(path)
    rc.Simulation(rc.paper_drive()).run(1e-3, progress=False, out=path)
    with pytest.raises(rc.InvalidInput, match="was replaced since it was loaded; load it again"):
        before.array("hinge_force")
    path.unlink()
    with pytest.raises(FileNotFoundError, match=r"run\.nc: there is no such file"):
        before.array("hinge_force")


STREAMS = """
import sys
import rustchain as rc

run = rc.Simulation(rc.paper_drive(25.0)).run
print("begins", flush=True)
run(5.0, 1e-5, record=("hinges", "teeth", "sprockets", "bodies", "energy"), out=sys.argv[1],
    memory=sys.argv[2], progress=False)
"""


@posix
@pytest.mark.slow
def test_a_killed_run_leaves_all_rows_that_were_written(tmp_path):
    every = {"report_step": 1e-5, "record": ALL_OF_A_DRIVE, "progress": False}
    expected = rc.Simulation(rc.paper_drive(25.0)).run(0.2, **every)
    moment = random.Random(1)
    lengths = []
    for number in range(KILLS):
        path = tmp_path / f"{number}.nc"
        command = [sys.executable, "-c", STREAMS, str(path), PIECE]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
            assert child.stdout.readline() == "begins\n"
            deadline = time.monotonic() + 60.0
            # Until there are some rows, by their size: on a busy machine a time says little.
            enough = 5e6 * moment.uniform(1.0, 4.0)
            while time.monotonic() < deadline:
                if path.exists() and path.stat().st_size > enough:
                    break
                time.sleep(0.01)
            time.sleep(moment.uniform(0.0, 0.1))
            child.kill()
        assert child.returncode == -signal.SIGKILL
        loaded = rc.load_result(path)
        assert loaded.status == "interrupted"
        rows = len(loaded.time)
        lengths.append(rows)
        assert rows >= 256
        assert rows % 256 == 0
        both = min(rows, len(expected.time) - 1)  # the last row is at the end of the run
        for name, array in expected.arrays.items():
            again = loaded.arrays[name]
            assert len(again) == rows
            np.testing.assert_array_equal(again[:both], array[:both], err_msg=name)
        np.testing.assert_array_equal(loaded.final_positions, loaded.arrays["positions"][-1])
        path.unlink()
    assert len(set(lengths)) > 1


FILLS = """
import resource, sys
import rustchain as rc
import rustchain.simulation.run as sizes

sizes._free_space = lambda out: float("inf")  # by which the run would be refused

if len(sys.argv) > 3:
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]),) * 2)
simulation = rc.Simulation(rc.paper_drive(25.0))
try:
    simulation.run(20.0, 1e-5, record=("hinges", "teeth", "sprockets", "bodies", "energy"),
                   out=sys.argv[1], memory=sys.argv[2], progress=False)
except OSError as error:
    print(error)
    print(len(error.result.time), error.result.status)
simulation.run(1e-3, progress=False)  # it can go on
"""


def check_rows_kept(path, told):
    """Check what a child said whose disc was full, and that the rows before are in the file."""
    message, said = told.splitlines()
    assert f"out = {path}: cannot be written (" in message
    loaded = rc.load_result(path)
    rows = len(loaded.time)
    assert said == f"{rows} failed"
    assert f"its first {rows} rows are in {path}" in message
    assert rows >= 256
    every = {"report_step": 1e-5, "record": ALL_OF_A_DRIVE, "progress": False}
    expected = rc.Simulation(rc.paper_drive(25.0)).run(1.1e-5 * rows, **every)
    for name, array in loaded.arrays.items():
        np.testing.assert_array_equal(array, expected.arrays[name][:rows], err_msg=name)


def fill(path, *limit):
    command = [sys.executable, "-W", "error", "-c", FILLS, str(path), PIECE, *map(str, limit)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@posix
@pytest.mark.parametrize("limit", [12_345_678, 20_000_000])
def test_a_limit_of_the_size_of_files_loses_nothing_before(limit, tmp_path):
    path = tmp_path / "run.nc"
    done = fill(path, limit)
    assert (done.returncode, done.stderr) == (0, "")
    assert "File too large" in done.stdout
    check_rows_kept(path, done.stdout)
    assert path.stat().st_size <= limit


@pytest.fixture
def disc_of_12_mb(tmp_path):
    disc = tmp_path / "disc"
    disc.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=12m", "none", str(disc)]
    if sys.platform != "linux" or os.geteuid() != 0:
        pytest.skip("mounting needs root on Linux")
    if subprocess.run(command, capture_output=True, check=False).returncode != 0:
        pytest.skip("mounting is not allowed here")
    yield disc
    subprocess.run(["umount", str(disc)], check=True)


def test_a_full_disc_loses_nothing_before(disc_of_12_mb):
    path = disc_of_12_mb / "run.nc"
    done = fill(path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "No space left" in done.stdout
    check_rows_kept(path, done.stdout)


STOPS = """
import os, signal, sys, threading, time
import rustchain as rc

signal.signal(signal.SIGINT, signal.default_int_handler)
simulation = rc.Simulation(rc.paper_drive(25.0))

def ring():
    while not os.path.exists(sys.argv[1]) or os.path.getsize(sys.argv[1]) < 2e6:
        time.sleep(0.01)
    time.sleep(float(sys.argv[2]))
    os.kill(os.getpid(), signal.SIGINT)

threading.Thread(target=ring, daemon=True).start()
result = simulation.run(10.0, 1e-5, out=sys.argv[1], memory="20 MB", progress=False)
print(result.status, len(result.time), simulation.time)
"""


@posix
@pytest.mark.parametrize("after", [0.0, 0.1, 0.37])
def test_ctrl_c_keeps_every_row(after, tmp_path):
    path = tmp_path / "run.nc"
    command = [sys.executable, "-W", "error", "-c", STOPS, str(path), str(after)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    status, rows, now = done.stdout.split()
    loaded = rc.load_result(path)
    assert (status, int(rows)) == ("interrupted", len(loaded.time))
    assert loaded.status == "interrupted"
    # No gap between pieces, and none at the end.
    np.testing.assert_allclose(np.diff(loaded.time), 1e-5, rtol=1e-6)
    assert float(now) - loaded.time[-1] < 1e-4
    expected = rc.Simulation(rc.paper_drive(25.0)).run(0.01, 1e-5, progress=False)
    rows = min(len(loaded.time), len(expected.time)) - 1
    for name, array in expected.arrays.items():
        np.testing.assert_array_equal(loaded.arrays[name][:rows], array[:rows], err_msg=name)


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
    for duration in (0.5, 1.5):  # 370 MB and 1100 MB of rows
        command = [sys.executable, "-c", GROWS, str(duration), str(tmp_path / "run.nc")]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        peaks.append(1024 * int(done.stdout))
    assert max(peaks) < 200e6
    # Of 730 MB more. Whether the next piece is ready while one is written is left to chance: a
    # piece takes 13 MB, and as much again for its copy.
    assert peaks[1] - peaks[0] < 50e6


def test_the_command_streams(tmp_path):
    path = tmp_path / "run.nc"
    done = CliRunner().invoke(
        app, ["run", "paper", "--duration", "1e-3", "--out", str(path), "--memory", "20 MB"]
    )
    assert done.exit_code == 0, done.output
    assert is_streamed(path)
    assert rc.load_result(path).success
    refused = CliRunner().invoke(app, ["run", "paper", "--out", str(path), "--memory", "much"])
    assert refused.exit_code == 1
    assert "memory = 'much': expected a size such as '256 MB'" in refused.output


def test_a_file_may_have_the_memory_of_its_run(tmp_path):
    text = '[drive]\ntype = "paper_drive"\n[run]\nduration = 1e-3\nmemory = "{}"\n'
    file = tmp_path / "drive.toml"
    file.write_text(text.format("20 MB"))
    run = ["run", str(file), "--out", str(tmp_path / "run.nc")]
    assert CliRunner().invoke(app, run).exit_code == 0
    file.write_text(text.format("much"))
    for command in (run, ["check", str(file)]):
        done = CliRunner().invoke(app, command)
        assert done.exit_code == 1
        assert "memory = 'much': expected a size" in done.output
