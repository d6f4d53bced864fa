"""Ctrl-C: a run stops soon, keeps its rows, and can go on; other threads run meanwhile."""

import ctypes
import errno
import functools
import json
import random
import signal
import subprocess
import sys
import threading
import time
from itertools import chain, repeat, starmap
from operator import itemgetter

import h5py
import numpy as np
import pytest

import rustchain as rc
from cores import CoreAround, cores_within
from rustchain import _rustchain
from rustchain.results import netcdf
from rustchain.results import stream as stream_module
from rustchain.results.stream import Stream
from rustchain.results.superblock import is_marked
from rustchain.simulation import simulation as module
from rustchain.simulation.core import core_of, start_of

# A child that interrupts itself, as Ctrl-C would, once its run is well under way.
PRELUDE = """
import json, os, signal, sys, threading
import rustchain as rc

# Children of jobs in the background are born deaf to it.
signal.signal(signal.SIGINT, signal.default_int_handler)
under_way = threading.Event()

class Watched:
    def __init__(self, core):
        self.core, self.calls = core, 0
    def __getattr__(self, name):
        return getattr(self.core, name)
    def advance(self, budget):
        return self.count(self.core.advance(budget))
    def step_to(self, t, budget):
        return self.count(self.core.step_to(t, budget))
    def count(self, finished):
        self.calls += 1
        if self.calls == 4:
            under_way.set()
        return finished

def interrupt():
    under_way.wait()
    os.kill(os.getpid(), signal.SIGINT)

from rustchain.simulation import simulation as module
core_of, cores = module.core_of, []
def watched(*arguments):
    cores.append(Watched(core_of(*arguments)))
    return cores[-1]
module.core_of = watched
threading.Thread(target=interrupt, daemon=True).start()
"""

FAR = 1000.0  # [s], hours of wall time away; its rows have to fit into any machine's memory


def child(script, *arguments, **keywords):
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", PRELUDE + script, *map(str, arguments)],
        capture_output=True,
        text=True,
        **keywords,
    )


def test_an_interrupt_at_the_first_use_of_numpy_is_one_and_the_next_call_goes_on():
    """The compiled module imports NumPy's interface there, in Python."""
    script = """
import numpy as np
Version = np.lib.NumpyVersion
class Interrupted:
    def __init__(self, version):
        np.lib.NumpyVersion = Version
        raise KeyboardInterrupt
np.lib.NumpyVersion = Interrupted
try:
    rc.Simulation(rc.paper_drive()).positions
except KeyboardInterrupt:
    print("interrupted")
print(rc.Simulation(rc.paper_drive()).positions.shape)
"""
    found = child(script)
    assert found.stdout == "interrupted\n(40, 3)\n", found.stderr


def test_an_interrupted_run_keeps_its_rows_and_can_go_on():
    done = child(
        f"""
# So fine that the energy balance is closed wherever the run ends.
simulation = rc.Simulation(rc.paper_drive(), solver=rc.Solver(accuracy=1e-12))
result = simulation.run({FAR}, 1e-3, record=("teeth",), progress=False)
stopped = simulation.time
calls = cores[0].calls
more = simulation.run(1e-3, 1e-4, record=("teeth",), progress=False)
print(json.dumps(dict(
    status=result.status, message=result.message, success=result.success, stopped=stopped,
    calls=calls, rows=len(result.time), begin=result.time[0], end=result.time[-1],
    forces=len(result.array("tooth_force")), finite=bool(result.final_positions.any()),
    more=more.status, again=more.time[0], last=more.time[-1],
)))
"""
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["status"] == "interrupted"
    assert not said["success"]
    assert "interrupted at t = " in said["message"]
    assert 0.0 < said["stopped"] < 0.1 * FAR
    # All rows up to there, and no more.
    assert said["begin"] == 0.0
    assert said["rows"] == said["forces"] > 1
    assert said["end"] <= said["stopped"] < said["end"] + 2e-3
    assert said["finite"]
    assert said["more"] == "finished"
    assert said["again"] == said["stopped"]
    assert said["last"] == pytest.approx(said["stopped"] + 1e-3)


@pytest.mark.parametrize("out", [None, "run.nc"])
@pytest.mark.parametrize("raised", [SystemExit, GeneratorExit])
def test_an_exit_keeps_the_rows_of_a_run(raised, out, tmp_path):
    def callback(simulation):
        if simulation.time > 1e-3:
            raise raised(3)

    path = None if out is None else tmp_path / out
    simulation = rc.Simulation(rc.paper_drive())
    with pytest.raises(raised) as caught:
        simulation.run(5e-3, callback=callback, out=path, progress=False)
    result = caught.value.result
    assert (result.status, len(result.time)) == ("interrupted", 12)
    if path is not None:
        assert rc.load_result(path).status == "interrupted"


def test_sigterm_ends_the_command_as_ctrl_c_does(tmp_path):
    path = tmp_path / "run.nc"
    called = ["run", "paper", "--duration", str(FAR), "--report-step", "1e-3", "--out", str(path)]
    running = subprocess.Popen(
        [sys.executable, "-m", "rustchain", *called],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while running.poll() is None and not path.exists():
        time.sleep(0.05)
    time.sleep(0.5)
    running.terminate()
    out, err = running.communicate()
    assert running.returncode == 130, err
    assert "interrupted at t = " in out
    assert rc.load_result(path).status == "interrupted"


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="no interval timer here")
def test_the_assembly_of_a_large_mechanism_is_interrupted_and_leaves_other_threads_alone():
    class Alarm(Exception):
        pass

    def ring(number, frame):
        raise Alarm

    # Bars of 1 m between the bodies of a net, too far from their places for an assembly.
    scatter, size = np.random.default_rng(0), 50
    net = rc.Mechanism()
    for i, j in np.ndindex(size, size):
        shift = 0.3 * scatter.normal(size=3)
        net.add_body(f"{i} {j}", mass=1.0, inertia=0.1, position=(i + shift[0], j + shift[1], 0.0))
    for i, j in np.ndindex(size, size):
        for k, n in ((i + 1, j), (i, j + 1)):
            if max(k, n) < size:
                net.add_distance(f"{i} {j} to {k} {n}", f"{i} {j}", f"{k} {n}", length=1.0)

    # Times of this process on a core, which other processes do not change.
    begin = time.process_time()
    with pytest.raises(rc.InvalidInput, match="cannot be assembled"):
        rc.Simulation(net)
    whole = time.process_time() - begin

    ticks, ended = [], threading.Event()

    def tick():
        while not ended.wait(1e-3):
            ticks.append(time.process_time())

    before = signal.signal(signal.SIGALRM, ring)
    other = threading.Thread(target=tick)
    other.start()
    begin = time.process_time()
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        with pytest.raises(Alarm):
            rc.Simulation(net)
    finally:
        end = time.process_time()
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        ended.set()
        other.join()
    assert end - begin < 0.5 * whole
    assert sum(begin < tick < end for tick in ticks) > 5


def test_an_interrupted_step_to_leaves_the_simulation_where_it_is():
    done = child(
        f"""
simulation = rc.Simulation(rc.paper_drive())
try:
    simulation.step_to({FAR})
except KeyboardInterrupt:
    stopped = simulation.time
simulation.step_to(stopped + 1e-4)
print(json.dumps(dict(stopped=stopped, time=simulation.time)))
"""
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert 0.0 < said["stopped"] < 0.1 * FAR
    assert said["time"] == said["stopped"] + 1e-4


def test_the_command_saves_its_file_and_says_how_it_ended(tmp_path):
    path = tmp_path / "run.nc"
    done = child(
        "from rustchain.cli import main; main()",
        "run", "paper", "--duration", FAR, "--report-step", 1e-3, "--out", path,
    )  # fmt: skip
    assert done.returncode == 130, done.stderr
    assert "Traceback" not in done.stderr
    assert "interrupted at t = " in done.stdout
    assert str(path) in done.stdout
    result = rc.load_result(path)
    assert result.status == "interrupted"
    assert 1 < len(result.time) < 0.1 * FAR / 1e-3
    assert f"{len(result.time)} rows" in done.stdout
    assert result.array("tooth_force").shape == (len(result.time), 38)


IN_HDF5 = """
from h5py._objects import phil
import time

def press_in_hdf5(times):
    with phil:  # the lock of h5py: a thread that ends with it keeps it
        for _ in range(times):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.2)
"""


def test_further_interrupts_wait_until_the_file_of_the_command_is_ended(tmp_path):
    path = tmp_path / "run.nc"
    done = child(
        IN_HDF5
        + """
from rustchain.cli import main
from rustchain.results.stream import Stream

finish = Stream._finish
def slow(*arguments):
    press_in_hdf5(3)
    finish(*arguments)
Stream._finish = slow
main()
""",
        "run", "paper", "--duration", FAR, "--report-step", 1e-3, "--out", path,
        timeout=120,
    )  # fmt: skip
    assert done.returncode == 130, done.stderr
    assert "Traceback" not in done.stderr
    result = rc.load_result(path)
    assert result.status == "interrupted"
    assert "interrupted at t = " in result.message
    assert len(result.time) > 1


def test_an_interrupt_of_the_end_of_python_does_not_wait_for_hdf5_forever(tmp_path):
    """The main thread waits for the others, until an interrupt; then it ends them."""
    done = child(
        IN_HDF5
        + """
import h5py
from concurrent.futures import thread

rc.Simulation(rc.paper_drive()).run(1e-4, out=sys.argv[1], progress=False)
file = h5py.File(sys.argv[1])

def work():
    while not thread._shutdown:  # set before the main thread waits
        time.sleep(0.01)
    press_in_hdf5(5)

thread.ThreadPoolExecutor(1).submit(work)
""",
        tmp_path / "run.nc",
        timeout=120,
    )
    assert done.returncode == 0, done.stderr


# Calls that stay long in the compiled module, or in threads of their own.
LONG_CALLS = {
    "search for an initial configuration": "rc.Simulation(hopeless)",
    "static start": "rc.Simulation(restless, start='static')",
    "study from static starts": (
        "rc.study(rc.Scene(restless, start='static'), progress=False).sweep"
    ),
    "loss map": (
        "rc.loss_map(rc.Scene(rc.two_sprocket_drive(links=38, torque=-1.0), "
        "rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))), speeds=[10.0], torques=[-1.0], "
        f"duration={FAR}, progress=False)"
    ),
    "sweep": (
        f"rc.sweep(rc.paper_drive(), [dict(duration={FAR})], report_step=1e-2, progress=False)"
    ),
    "sweep that looks at rare reports": (
        f"rc.sweep(rc.paper_drive(), [dict(duration={FAR})], report_step={FAR / 2}, "
        "stop=rc.HingeForceAbove(1e9), progress=False)"
    ),
}


@pytest.mark.parametrize("call", LONG_CALLS)
def test_ctrl_c_ends_a_long_call_before_it_ends_by_itself(call):
    done = child(
        f"""
import dataclasses
import math
import xarray  # a loss map imports it, which takes long the first time
# Between blunt teeth there is no room for the links: the search, of 2,000 links of lengths of their
# own round 24 sprockets, takes seconds and finds nothing.
blunt, angles = rc.StraightTooth(0.05), [k * math.pi / 12 for k in range(24)]
ring = [rc.Sprocket(40, (4 * math.cos(a), 4 * math.sin(a)), profile=blunt) for a in angles]
round_them = rc.chain_drive("ANSI 40", ring)
spread = dataclasses.replace(round_them.chain, pitch_spread=1e-5)
hopeless = dataclasses.replace(round_them, chain=spread)
drive = rc.two_sprocket_drive(links=2000)
# A torque that nothing holds has no static equilibrium: it is refused after 100,000 iterations,
# which take some 10 s.
first = dataclasses.replace(drive.sprockets[0], motion=rc.AppliedTorque(1.0))
restless = dataclasses.replace(drive, sprockets=(first, drive.sprockets[1]))
threading.Timer(0.3, under_way.set).start()
try:
    said = {LONG_CALLS[call]}
    said = said.status
except KeyboardInterrupt as interrupted:
    # A handler that only runs after a refusal has that for its context.
    said = repr(interrupted.__context__)
print(json.dumps(said))
""",
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) in ("interrupted", "None")


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="no interval timer here")
def test_a_handler_of_ones_own_is_heard_during_a_run():
    """Python looks for signals between slices of the run, whoever handles them."""

    class Alarm(Exception):
        pass

    def ring(number, frame):
        raise Alarm

    simulation = rc.Simulation(rc.paper_drive())
    before = signal.signal(signal.SIGALRM, ring)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(Alarm):
            simulation.run(FAR, 1e-2, progress=False)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert 0.0 < simulation.time < 0.1 * FAR
    assert simulation.run(1e-4, progress=False).success


class Slices(CoreAround):
    """A core that notes the wall time it is given."""

    def __init__(self, core):
        super().__init__(core)
        self.budgets = []

    def advance(self, budget):
        self.budgets.append(budget)
        return self.core.advance(budget)

    def step_to(self, t, budget):
        self.budgets.append(budget)
        return self.core.step_to(t, budget)


def test_the_keyboard_is_looked_at_well_within_a_fifth_of_a_second():
    with cores_within(Slices) as made:
        simulation = rc.Simulation(rc.paper_drive())
    (slices,) = made
    simulation.run(2e-3, progress=False)
    simulation.step_to(4e-3)
    assert len(slices.budgets) >= 2
    assert set(slices.budgets) == {module.WALL_BUDGET}
    assert 0.0 < module.WALL_BUDGET <= 0.1


def core_of_paper_drive():
    scene = rc.Scene(rc.paper_drive())
    place, _ = start_of(scene)
    return core_of(scene, place)


@pytest.mark.parametrize("stepping", [False, True])
def test_without_wall_time_left_a_slice_is_short(stepping):
    """The budget is looked at every few steps: a slice of none at all makes few."""
    core = core_of_paper_drive()
    assert core.step_to(5e-3, 1e9)
    core.start_recording(FAR, 1e-4, [], False)
    for _ in range(20):
        before = core.stats()["steps"]
        finished = core.step_to(FAR, 0.0) if stepping else core.advance(0.0)
        assert not finished
        assert 0 < core.stats()["steps"] - before <= 100


def test_other_threads_run_during_a_slice():
    core = core_of_paper_drive()
    ticks, begin, end = 0, threading.Event(), threading.Event()

    def tick():
        nonlocal ticks
        begin.wait()
        while not end.is_set():
            time.sleep(1e-3)
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    core.start_recording(0.05, 1e-4, [], False)
    begin.set()
    finished = core.advance(1e9)  # one call; a held lock would let one tick through at most
    ticks_during, _ = ticks, end.set()
    thread.join()
    assert finished
    assert ticks_during >= 5


def test_reports_closer_than_steps_do_not_hold_a_slice_up():
    """With 100 reports in every step, a slice of no wall time ends after one or two."""
    core = core_of_paper_drive()
    core.start_recording(4e-3, 1e-8, ["hinges", "teeth"], True)
    for _ in range(39):
        assert not core.advance(0.0)
    assert 39 <= len(core.take_recording()["time"]) <= 2 * 39  # the first also takes a step


class EndsBehindItsRows(CoreAround):
    """A core during whose last calls, behind that which gives the rows away, Ctrl-C is pressed."""

    def __init__(self, core):
        super().__init__(core)
        self.pressed = False

    def tooth_jumps(self):
        if not self.pressed:
            self.pressed = True
            raise KeyboardInterrupt
        return self.core.tooth_jumps()


def test_ctrl_c_while_a_result_is_made_loses_no_row():
    with cores_within(EndsBehindItsRows):
        simulation = rc.Simulation(rc.paper_drive())
    result = simulation.run(1e-3, 1e-4, record=("teeth",), progress=False)
    assert result.status == "interrupted"
    assert len(result.time) == len(result.array("tooth_force")) == 11


class PressedInIts(CoreAround):
    """A core that presses Ctrl-C as it gives the rows away, without a step of the interpreter."""

    def __init__(self, core):
        super().__init__(core)
        rows = starmap(core.take_recording, [()])
        pressed = starmap(ctypes.pythonapi.PyErr_SetInterrupt, [()])
        first = map(itemgetter(0), zip(rows, pressed, strict=True))
        later = starmap(core.take_recording, repeat(()))
        self.take_recording = functools.partial(next, chain(first, later))


def test_ctrl_c_as_the_core_gives_its_rows_away_loses_none():
    with cores_within(PressedInIts):
        simulation = rc.Simulation(rc.paper_drive())
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        result = simulation.run(1e-3, 1e-4, record=("teeth",), progress=False)
    finally:
        signal.signal(signal.SIGINT, before)
    assert result.status == "interrupted"
    assert len(result.time) == len(result.array("tooth_force")) == 11


@pytest.mark.parametrize(("behind", "status"), [(False, "interrupted"), (True, "finished")])
def test_ctrl_c_while_a_file_gets_its_end_leaves_file_and_result_alike(
    behind, status, tmp_path, monkeypatch
):
    """Before the end is handed to the thread that writes, the run is interrupted; behind, not."""
    finish, pressed = Stream.finish, []

    def interrupted(stream, *arguments):
        if behind or pressed:
            finish(stream, *arguments)
        if not pressed:
            pressed.append(True)
            raise KeyboardInterrupt

    monkeypatch.setattr(Stream, "finish", interrupted)
    path = tmp_path / "run.nc"
    result = rc.Simulation(rc.paper_drive(25.0)).run(1e-3, 1e-4, out=path, progress=False)
    rows = rc.load_result(path)
    assert pressed
    assert result.status == rows.status == status
    assert result.message == rows.message
    assert result.stats == rows.stats
    assert result.stats["largest_residual"] > 0.0
    assert len(result.time) == len(rows.time) == 11


def test_ctrl_c_twice_before_a_file_gets_its_end_leaves_it_whole(tmp_path, monkeypatch):
    finish, pressed = Stream.finish, []

    def interrupted(stream, *arguments):
        if len(pressed) < 2:
            pressed.append(True)
            raise KeyboardInterrupt
        finish(stream, *arguments)

    monkeypatch.setattr(Stream, "finish", interrupted)
    path = tmp_path / "run.nc"
    with pytest.raises(KeyboardInterrupt) as raised:
        rc.Simulation(rc.paper_drive(25.0)).run(1e-3, 1e-4, out=path, progress=False)
    rows = rc.load_result(path)
    assert rows.message == "interrupted at t = 0.001 s"
    assert len(rows.time) == len(raised.value.result.time) == 11
    assert raised.value.result.status == "interrupted"


def heard_by_main_thread(heard):
    """Press Ctrl-C until the main thread has heard it; return whether it has.

    A thread that is just about to wait for a lock does not hear a single signal before it has the
    lock: Python has looked for signals already, and the system call has not begun.
    """
    for _ in range(600):
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        if heard.wait(0.1):
            return True
    return False


needs_signals_to_threads = pytest.mark.skipif(
    not hasattr(signal, "pthread_kill"), reason="no signals to threads here"
)


@needs_signals_to_threads
@pytest.mark.parametrize("times", [1, 3])
def test_ctrl_c_during_the_wait_for_the_end_of_a_file_changes_no_status(
    times, tmp_path, monkeypatch
):
    finish, heard = Stream.finish, [threading.Event() for _ in range(times)]

    def press(number, frame):
        for event in heard:
            if not event.is_set():
                event.set()
                raise KeyboardInterrupt

    def slow(stream, take, *arguments):
        def interrupted(count):  # in the thread that writes
            assert all(map(heard_by_main_thread, heard))
            return take(count)

        finish(stream, interrupted, *arguments)

    monkeypatch.setattr(Stream, "finish", slow)
    path = tmp_path / "run.nc"
    simulation = rc.Simulation(rc.paper_drive(25.0))
    before = signal.signal(signal.SIGINT, press)
    try:
        result = simulation.run(1e-3, 1e-4, out=path, progress=False)
    finally:
        signal.signal(signal.SIGINT, before)
    assert all(event.is_set() for event in heard)
    assert result.status == rc.load_result(path).status == "finished"


@needs_signals_to_threads
@pytest.mark.parametrize("waits", [False, True])
def test_ctrl_c_while_a_file_is_opened_is_heard_before_the_first_step(waits, tmp_path, monkeypatch):
    """Before the main thread waits for the thread that opens the file, or during the wait."""
    opens, heard = vars(Stream)["_open"], threading.Event()
    wait, waiting = stream_module.wait, threading.Event()

    def press(number, frame):
        if not heard.is_set():
            heard.set()
            raise KeyboardInterrupt

    def waited(futures):
        waiting.set()
        return wait(futures)

    def slow(stream):
        if waits:
            waiting.wait(60.0)
        assert heard_by_main_thread(heard)
        opens(stream)

    monkeypatch.setattr(stream_module, "wait", waited)
    monkeypatch.setattr(Stream, "_open", slow)
    simulation = rc.Simulation(rc.paper_drive(25.0))
    before = signal.signal(signal.SIGINT, press)
    try:
        with pytest.raises(KeyboardInterrupt) as raised:
            simulation.run(1e-3, 1e-4, out=tmp_path / "run.nc", progress=False)
    finally:
        signal.signal(signal.SIGINT, before)
    assert simulation.time == 0.0
    # Closed, although the traceback still has the object that opened it.
    assert raised.tb is not None
    assert not is_marked(tmp_path / "run.nc")


def test_an_error_of_the_disc_behind_ctrl_c_has_its_rows(tmp_path, monkeypatch):
    finish, pressed = Stream.finish, []

    def full(stream, *arguments):
        finish(stream, *arguments)
        if not pressed:
            pressed.append(True)
            raise KeyboardInterrupt
        raise OSError(errno.ENOSPC, "No space left")

    monkeypatch.setattr(Stream, "finish", full)
    with pytest.raises(OSError, match="No space left") as raised:
        rc.Simulation(rc.paper_drive(25.0)).run(1e-3, 1e-4, out=tmp_path / "run.nc", progress=False)
    assert raised.value.result.status == "failed"
    assert len(raised.value.result.time) == 11


@needs_signals_to_threads
def test_ctrl_c_ends_the_wait_for_the_thread_of_hdf5():
    heard, released, heard_before = threading.Event(), threading.Event(), []

    def press(number, frame):
        if not heard.is_set():
            heard.set()
            raise KeyboardInterrupt

    def work(number):
        heard_by_main_thread(heard)
        heard_before.append(released.wait(60.0))
        return number

    others = set(threading.enumerate())
    before = signal.signal(signal.SIGINT, press)
    try:
        with pytest.raises(KeyboardInterrupt):
            netcdf.beside(work, 1)
    finally:
        released.set()
        for thread in set(threading.enumerate()) - others:
            thread.join(60.0)
        # Not before: the thread may press once more while the first signal is heard.
        signal.signal(signal.SIGINT, before)
    assert heard_before == [True]
    assert netcdf.beside(lambda number: number + 1, 1) == 2


def test_hdf5_is_used_in_threads_of_its_own(tmp_path, monkeypatch):
    """In the main thread, weak references of h5py swallow Ctrl-C."""
    opens, opened = h5py.File, []

    def noted(*arguments, **keywords):
        opened.append(threading.current_thread())
        return opens(*arguments, **keywords)

    monkeypatch.setattr(h5py, "File", noted)
    simulation = rc.Simulation(rc.paper_drive())
    saved, streamed = tmp_path / "saved.nc", tmp_path / "streamed.nc"
    calls = [
        lambda: simulation.run(1e-3, progress=False).save(saved),
        lambda: rc.load_result(saved),
        lambda: simulation.run(1e-3, progress=False, out=streamed),
        lambda: rc.load_result(streamed),
        lambda: rc.load_result(streamed).array("hinge_force"),
    ]
    for call in calls:
        count = len(opened)
        call()
        assert len(opened) > count
    assert threading.main_thread() not in opened


END = 0.05  # [s]


def state_of(simulation):
    return simulation.positions.tobytes() + simulation.velocities.tobytes()


class Stepped:
    """A simulation that steps to a time."""

    def __init__(self, folder):
        self.simulation = rc.Simulation(rc.paper_drive())

    def attempt(self):
        self.simulation.step_to(END)

    def found(self):
        return state_of(self.simulation)


class Run(Stepped):
    """A run, which continues where an interrupt has ended it."""

    def attempt(self):
        begin = self.simulation.time
        if begin < END:
            keywords = {"record": ("teeth",), "progress": False}
            result = self.simulation.run(END - begin, 1e-4, **keywords)
            # All rows up to there: the last is less than a report step, or a step, old.
            assert np.allclose(np.diff(result.time[:-1]), 1e-4, rtol=0.0, atol=1e-9)
            assert len(result.array("tooth_force")) == len(result.time)
            assert result.time[0] == begin
            assert result.time[-1] > self.simulation.time - 2e-4
            if result.status == "interrupted":
                raise KeyboardInterrupt


class Streamed(Stepped):
    """A run whose rows go to a file, a new one after each interrupt."""

    def __init__(self, folder):
        super().__init__(folder)
        self.path = folder / "run.nc"

    def attempt(self):
        begin = self.simulation.time
        if begin < END:
            keywords = {"out": self.path, "memory": "20 MB", "progress": False}
            result = self.simulation.run(END - begin, 1e-4, **keywords)
            if not len(result.time):
                assert result.status == "interrupted"
                with pytest.raises(rc.InvalidInput, match="no row has been written yet"):
                    rc.load_result(self.path)
                raise KeyboardInterrupt
            rows = rc.load_result(self.path)
            assert rows.status == result.status
            assert np.array_equal(rows.time, result.time)
            assert rows.time[-1] > self.simulation.time - 2e-4
            if result.status == "interrupted":
                raise KeyboardInterrupt


class Started:
    """Searches for an initial configuration and for a static equilibrium."""

    def __init__(self, folder):
        self.simulation = None

    def attempt(self):
        self.simulation = rc.Simulation(rc.two_sprocket_drive(links=400), start="static")

    def found(self):
        return state_of(self.simulation)


class Files:
    """A result and a state, which are written over older ones and read."""

    def __init__(self, folder):
        self.result, self.state = folder / "run.nc", folder / "state.npz"
        self.simulation = rc.Simulation(rc.paper_drive())
        self.run = self.simulation.run(1e-3, progress=False)
        self.simulation.save_state(self.state)
        self.run.save(self.result)

    def attempt(self):
        self.run.save(self.result)
        self.simulation.save_state(self.state)
        self.found()

    def found(self):
        assert sorted(path.name for path in self.result.parent.iterdir()) == ["run.nc", "state.npz"]
        rows = rc.load_result(self.result)
        return rows.final_positions.tobytes() + state_of(rc.Simulation.load_state(self.state))


class Swept:
    """A sweep that keeps its cases in a folder."""

    def __init__(self, folder):
        self.folder, self.result = folder, None

    def attempt(self):
        cases = [{"duration": duration} for duration in (1e-3, 2e-3, 3e-3, 4e-3)]
        keywords = {"store": self.folder, "report_step": 1e-3, "progress": False}
        self.result = rc.sweep(rc.paper_drive(), cases, **keywords)
        if self.result.status == "interrupted":
            raise KeyboardInterrupt

    def found(self):
        return b"".join(run.final_positions.tobytes() for run in self.result.results)


class Studied:
    """A study that keeps its runs in a folder."""

    def __init__(self, folder):
        self.folder, self.result = folder, None

    def attempt(self):
        times = {"duration": 2e-3, "burn_in": 1e-3, "report_step": 1e-3}
        keywords = {"runs": 4, "store": self.folder, "progress": False}
        self.result = rc.study(rc.paper_drive(), **times, **keywords)
        if self.result.sweep.status == "interrupted":
            raise KeyboardInterrupt

    def found(self):
        samples = self.result.samples.data_vars
        assert len(samples) > 1
        return b"".join(values.to_numpy().tobytes() for values in samples.values())


# A file that is opened while the signal comes is closed by the garbage collector.
@pytest.mark.parametrize("teeth", [18, "many"])
def test_ctrl_c_while_a_description_is_checked_is_no_error_of_the_description(teeth):
    """Python's `str` and `repr` look for signals: their exceptions are no reason for a refusal."""
    sprocket = rc.paper_drive().sprockets[0]
    object.__setattr__(sprocket, "teeth", teeth)
    calls = [ctypes.pythonapi.PyErr_SetInterrupt, functools.partial(_rustchain.validate, sprocket)]
    # Without a step of the interpreter, which would hear the signal, between the calls.
    together = map(functools.partial.__call__, map(functools.partial, calls))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            list(together)
    finally:
        signal.signal(signal.SIGINT, before)


# A run that is interrupted early has dissipated little beside its residual.
@pytest.mark.filterwarnings("ignore::rustchain.EnergyWarning")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.skipif(not hasattr(signal, "SIGPROF"), reason="no timer of processor time here")
@pytest.mark.parametrize("operation", [Stepped, Run, Streamed, Started, Files, Swept, Studied])
def test_interrupts_at_random_moments_lose_nothing_and_change_no_bit(operation, tmp_path):
    """Interrupted again and again, each operation ends in the bits of an undisturbed one."""

    def press(number, frame):
        raise KeyboardInterrupt

    (tmp_path / "calm").mkdir()
    calm = operation(tmp_path / "calm")
    begin = time.process_time()
    calm.attempt()
    takes = time.process_time() - begin  # [s]
    draw = random.Random(1)
    heard = 0
    before = signal.signal(signal.SIGPROF, press)
    try:
        for number in range(40):
            if heard >= 4:
                break
            folder = tmp_path / str(number)
            folder.mkdir()
            disturbed = operation(folder)
            done = False
            while not done:
                try:
                    # The longest waits let it end.
                    signal.setitimer(signal.ITIMER_PROF, draw.uniform(1e-4, 2.0 * takes))
                    try:
                        disturbed.attempt()
                        done = True
                    finally:
                        signal.setitimer(signal.ITIMER_PROF, 0.0)
                except KeyboardInterrupt:
                    heard += 1
            assert disturbed.found() == calm.found()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    assert heard >= 4
