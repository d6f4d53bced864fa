"""A full disc, a replaced file, a kill or Ctrl-C loses no row that a run has written."""

import errno
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from itertools import pairwise

import h5py
import numpy as np
import pytest

import rustchain as rc
from rustchain.results.stream import Stream
from streamed_runs import ALL_OF_A_DRIVE, LITTLE, PIECE, RUNS, SCENES

KILLS = 6
posix = pytest.mark.skipif(os.name != "posix", reason="POSIX signals and limits")


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
    assert loaded == failed.value.result


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


def test_an_error_of_the_disc_as_a_file_is_closed_is_told(tmp_path, monkeypatch):
    def fails(file):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "fsync", fails)
    path = tmp_path / "run.nc"
    with pytest.raises(OSError, match=r"cannot be written \(Input/output error\).*first 11 rows"):
        rc.Simulation(rc.paper_drive()).run(1e-3, progress=False, out=path)


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
    assert loaded == failed.value.result


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
    assert rc.load_result(path) == SCENES["mechanism"]().run(**RUNS["mechanism"], progress=False)
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
    assert loaded == failed.value.result


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
    assert rc.load_result(path) == done[0]
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
