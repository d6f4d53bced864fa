"""Ctrl-C: a run stops soon, keeps its rows, and can go on; other threads run meanwhile."""

import ctypes
import functools
import json
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import rustchain as rc
from cores import CoreAround, cores_within
from rustchain import _rustchain
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
