"""Files that the package writes: whole or not at all, and refused where a bit has changed."""

import errno
import io
import os
import random
import shutil
import signal
import stat
import subprocess
import sys
import threading
import time
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

import rustchain as rc
from command import rustchain

KILLS = 3
INTERRUPTS = 6
OF_DRIVE, OF_MECHANISM, STATE = "result of a drive", "result of a mechanism", "state"
posix = pytest.mark.skipif(os.name != "posix", reason="POSIX files and signals")


def pendulum(angle=0.3):
    mechanism = rc.Mechanism(name="pendulum")
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5, 0.0, angle))
    mechanism.add_revolute("pin", "ground", "bar", point_a=(0.5, 0.0), point_b=(0.0, 0.0))
    return mechanism


@pytest.fixture(scope="module")
def kinds():
    """How each kind of file is written and read."""
    short = {"duration": 3e-4, "progress": False}
    drive = rc.Simulation(rc.paper_drive())
    return {
        OF_DRIVE: (drive.run(record=("teeth", "energy"), **short).save, rc.load_result),
        OF_MECHANISM: (rc.Simulation(pendulum()).run(**short).save, rc.load_result),
        STATE: (drive.save_state, rc.Simulation.load_state),
    }


@pytest.fixture(params=[OF_DRIVE, OF_MECHANISM, STATE])
def save_and_load(request, kinds):
    return kinds[request.param]


def device(folder):
    """Return a device that is always full; as root a new one, which may be lost."""
    if os.geteuid() != 0:
        return Path("/dev/full")
    path = folder / "full"
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 7))
    except OSError:
        pytest.skip("no devices can be made here")
    return path


def fifo(folder):
    path = folder / "fifo"
    os.mkfifo(path)
    return path


@posix
@pytest.mark.parametrize(("make", "kind"), [(device, "device"), (fifo, "FIFO")])
def test_devices_and_fifos_are_refused_and_stay_what_they_are(make, kind, tmp_path, save_and_load):
    save, load = save_and_load
    path = make(tmp_path)
    mode = path.stat().st_mode
    link = tmp_path / "link"
    link.symlink_to(path)
    for name in (path, link):
        with pytest.raises(OSError, match=rf"path = .*written \(Is a {kind}; expected a regular"):
            save(name)
        with pytest.raises(OSError, match=rf"path = .*read \(Is a {kind}; expected a regular file"):
            load(name)
    assert path.stat().st_mode == mode
    assert link.is_symlink()


def test_a_directory_is_refused(tmp_path, save_and_load):
    for call, done in zip(save_and_load, ("written", "read"), strict=True):
        with pytest.raises(IsADirectoryError, match=rf"path = .*{done} \(Is a directory; expected"):
            call(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_empty_name_of_a_file_is_refused(save_and_load):
    for call in save_and_load:
        with pytest.raises(rc.InvalidInput, match="path = '': is empty; expected a file name"):
            call("")


@pytest.mark.parametrize("path", [io.StringIO(), io.BytesIO(), None, 3, b"run.nc"])
def test_what_is_no_path_is_refused(path, save_and_load):
    for call in save_and_load:
        with pytest.raises(
            rc.InvalidInput,
            match=r"path\)?: got .+; expected the name of a file, str or P",
        ):
            call(path)


def test_a_nul_in_a_name_is_refused(tmp_path, save_and_load):
    for call in save_and_load:
        with pytest.raises(rc.InvalidInput, match=r"path = .*a\\x00b': has a NUL character"):
            call(tmp_path / "a\0b")
    assert list(tmp_path.iterdir()) == []


@posix
def test_a_link_stays_and_the_file_that_it_points_to_is_replaced(tmp_path, save_and_load):
    save, load = save_and_load
    (tmp_path / "far").mkdir()
    file, link = tmp_path / "far" / "file", tmp_path / "link"
    link.symlink_to(file)
    for _ in range(2):  # dangling at first
        save(link)
        assert link.is_symlink()
        load(file)
    assert len(list(tmp_path.rglob("*"))) == 3


@posix
def test_a_replaced_file_hands_on_its_permissions(tmp_path, save_and_load):
    save, _ = save_and_load
    path = tmp_path / "file"
    save(path)
    plain = tmp_path / "plain"
    plain.touch()
    assert path.stat().st_mode == plain.stat().st_mode
    path.chmod(0o640)
    save(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_name_as_long_as_the_system_allows_is_written(tmp_path, save_and_load):
    save, load = save_and_load
    path = tmp_path / ("n" * 255)
    save(path)
    load(path)
    with pytest.raises(OSError, match="cannot be written") as refused:
        save(tmp_path / ("n" * 5000))
    assert len(str(refused.value)) < 600


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left"), KeyboardInterrupt()])
@pytest.mark.parametrize("function", ["fsync", "replace"])
def test_a_save_that_fails_leaves_the_old_file_alone(
    error, function, tmp_path, save_and_load, monkeypatch
):
    save, _ = save_and_load
    path = tmp_path / "file"
    save(path)
    before = path.read_bytes()

    def fails(*arguments, **keywords):
        raise error

    monkeypatch.setattr(os, function, fails)
    with pytest.raises(type(error)) as told:
        save(path)
    monkeypatch.undo()
    if isinstance(error, OSError):
        assert f"path = {path}: cannot be written (No space left); expected" in str(told.value)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
    assert path.read_bytes() == before


@pytest.fixture
def small_disc(tmp_path):
    """A disc of 1 MB of its own."""
    if sys.platform != "linux" or os.geteuid() != 0 or shutil.which("mount") is None:
        pytest.skip("mounting needs root on Linux")
    disc = tmp_path / "disc"
    disc.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=1m", "none", str(disc)]
    if subprocess.run(command, capture_output=True, check=False).returncode != 0:
        pytest.skip("mounting is not allowed here")
    yield disc
    subprocess.run(["umount", str(disc)], check=True)


def test_a_full_disc_leaves_the_old_file_alone(small_disc, save_and_load):
    save, load = save_and_load
    path = small_disc / "file"
    save(path)
    before = path.read_bytes()
    room = os.statvfs(small_disc)
    (small_disc / "rest").write_bytes(bytes(room.f_bavail * room.f_frsize))
    with pytest.raises(OSError, match=r"cannot be written \(No space left"):
        save(path)
    assert sorted(p.name for p in small_disc.iterdir()) == ["file", "rest"]
    assert path.read_bytes() == before
    (small_disc / "rest").unlink()
    save(path)
    load(path)


def test_writers_at_once_leave_one_of_their_files_whole(tmp_path, save_and_load):
    save, load = save_and_load
    path = tmp_path / "file"
    failures = []

    def write():
        try:
            for _ in range(2):
                save(path)
                load(path)
        except Exception as error:
            failures.append(error)

    writers = [threading.Thread(target=write) for _ in range(4)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert failures == []
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


SAVES_AGAIN_AND_AGAIN = """
import sys
import rustchain as rc

simulation = rc.Simulation(rc.paper_drive())
result = simulation.run(2e-3, progress=False)
print("begins", flush=True)
while True:
    result.save(sys.argv[1])
    simulation.save_state(sys.argv[2])
    print("saved", flush=True)
"""


@pytest.mark.slow
@posix
def test_a_kill_during_a_save_leaves_a_whole_file(tmp_path):
    result, state = tmp_path / "run.nc", tmp_path / "state.npz"
    rc.Simulation(rc.paper_drive()).run(1e-3, progress=False).save(result)
    rc.Simulation(rc.paper_drive()).save_state(state)
    moment = random.Random(1)
    for _ in range(KILLS):
        command = [sys.executable, "-c", SAVES_AGAIN_AND_AGAIN, str(result), str(state)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
            assert child.stdout.readline() == "begins\n"
            time.sleep(moment.uniform(0.0, 1.0))
            child.kill()
        assert child.returncode == -signal.SIGKILL
        rc.load_result(result)
        rc.Simulation.load_state(state)


def test_a_result_is_saved_when_python_ends(tmp_path):
    path = tmp_path / "run.nc"
    # h5py crashes after the last function of `atexit` when it is imported in one; xarray imports
    # dask, which refuses to be.
    code = "import atexit, sys, h5py, dask, rustchain as rc\n"
    code += "run = rc.Simulation(rc.paper_drive()).run(1e-4)\n"
    code += "atexit.register(run.save, sys.argv[1])"
    subprocess.run([sys.executable, "-c", code, str(path)], check=True, capture_output=True)
    assert rc.load_result(path).success


HEARS = """
import os, random, signal, sys, threading, time
import rustchain as rc

# Children of jobs in the background are born deaf to it.
signal.signal(signal.SIGINT, signal.default_int_handler)
path, times = sys.argv[1], int(sys.argv[2])
result = rc.Simulation(rc.paper_drive()).run(2e-3, progress=False)
result.save(path)
begin = time.monotonic()
result.save(path)
span = time.monotonic() - begin
moment = random.Random(1)
for call in (lambda: result.save(path), lambda: rc.load_result(path)):
    for _ in range(times):
        rings = (os.getpid(), signal.SIGINT)
        bell = threading.Timer(moment.uniform(0.0, 0.5 * span), os.kill, rings)
        try:
            bell.start()
            while True:
                call()
                if not bell.is_alive():
                    time.sleep(0.1)  # it is raised here if it was late
                    sys.exit("swallowed")
        except KeyboardInterrupt:
            pass
        bell.join()
        rc.load_result(path)
"""


@pytest.mark.slow
@posix
def test_ctrl_c_during_a_save_or_a_load_is_heard(tmp_path):
    path = tmp_path / "run.nc"
    command = [sys.executable, "-c", HEARS, str(path), str(INTERRUPTS)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Exception ignored" not in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.parametrize("kind", [OF_DRIVE, OF_MECHANISM])
def test_programs_that_read_netcdf_leave_the_checksum_unread(kind, tmp_path, kinds):
    save, load = kinds[kind]
    path = tmp_path / "run.nc"
    save(path)
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["time"][:], load(path).time)
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as file:
        assert file.identical(load(path).to_xarray())


@pytest.mark.parametrize("kind", [OF_DRIVE, OF_MECHANISM])
def test_a_result_that_another_program_changed_is_refused(kind, tmp_path, kinds):
    save, load = kinds[kind]
    path = tmp_path / "file"

    def number(file):
        file["energy_kinetic"][0] += 1e-12

    def time_of_a_row(file):
        file["time"][0] += 1e-12

    def name(file):
        file["body"][0] = "rod"

    def unit(file):
        file["energy_kinetic"].attrs["units"] = "W"

    def status(file):
        file.attrs["status"] = "stopped"

    for change in (number, time_of_a_row, name, unit, status):
        save(path)
        load(path)
        with h5py.File(path, "r+") as file:
            change(file)
        with pytest.raises(rc.InvalidInput, match=r"is damaged .* checksum"):
            load(path)


@pytest.mark.parametrize(
    "number", [Fraction(251, 10), Decimal("25.1"), np.longdouble(25.1), np.float32(25.1)], ids=type
)
def test_every_kind_of_number_that_a_scene_takes_is_saved(number, tmp_path):
    scene = rc.Simulation(
        rc.paper_drive(pretension=number),
        rc.LankaraniNikravesh(),
        min_impact_velocity=type(number)(1) / type(number)(1000),
        solver=rc.Solver(accuracy=type(number)(1) / type(number)(10**9)),
    )
    result = scene.run(2e-4, progress=False)
    result.save(tmp_path / "run.nc")
    scene.save_state(tmp_path / "state.npz")
    assert type(result.drive.tensioner.pretension) is float
    for loaded in (
        rc.load_result(tmp_path / "run.nc"),
        rc.Simulation.load_state(tmp_path / "state.npz"),
    ):
        for name in ("drive", "hinge_law", "tooth_law", "min_impact_velocity", "solver"):
            assert getattr(loaded, name) == getattr(result, name)


@posix
def test_the_command_refuses_an_out_that_is_no_regular_file_before_it_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(rc.Simulation, "run", lambda *_, **__: pytest.fail("it ran"))
    for path in (device(tmp_path), fifo(tmp_path)):
        done = rustchain("run", "paper", "--out", path)
        assert done.exit_code == 1
        assert f"out = {path}: cannot be written (Is a " in done.output
        assert "Traceback" not in done.output


@posix
def test_the_command_replaces_figures_whole_or_not_at_all(tmp_path, kinds, monkeypatch):
    save, _ = kinds[OF_DRIVE]
    save(tmp_path / "run.nc")
    figure = tmp_path / "drive.png"
    figure.write_text("of before")

    def fails(*arguments, **keywords):
        raise OSError(errno.ENOSPC, "No space left")

    monkeypatch.setattr(os, "fsync", fails)
    done = rustchain("plot", tmp_path / "run.nc", "--out", tmp_path)
    assert done.exit_code == 1
    assert f"out = {figure}: cannot be written (No space left)" in done.output
    assert figure.read_text() == "of before"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["drive.png", "run.nc"]
