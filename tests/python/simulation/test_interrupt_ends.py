"""Ctrl-C while a run gives its rows away, or while its file is opened or gets its end."""

import ctypes
import errno
import functools
import signal
import threading
from contextlib import contextmanager
from itertools import chain, repeat, starmap
from operator import itemgetter

import h5py
import pytest

import rustchain as rc
from cores import CoreAround, cores_within
from rustchain.results import netcdf
from rustchain.results import stream as stream_module
from rustchain.results.stream import Stream
from rustchain.results.superblock import is_marked


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


@contextmanager
def interrupts_of(*heard):
    """Let Ctrl-C set one event after the other, and interrupt each time."""

    def press(number, frame):
        for event in heard:
            if not event.is_set():
                event.set()
                raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, press)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


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

    def slow(stream, take, *arguments):
        def interrupted(count):  # in the thread that writes
            assert all(map(heard_by_main_thread, heard))
            return take(count)

        finish(stream, interrupted, *arguments)

    monkeypatch.setattr(Stream, "finish", slow)
    path = tmp_path / "run.nc"
    simulation = rc.Simulation(rc.paper_drive(25.0))
    with interrupts_of(*heard):
        result = simulation.run(1e-3, 1e-4, out=path, progress=False)
    assert all(event.is_set() for event in heard)
    assert result.status == rc.load_result(path).status == "finished"


@needs_signals_to_threads
@pytest.mark.parametrize("waits", [False, True])
def test_ctrl_c_while_a_file_is_opened_is_heard_before_the_first_step(waits, tmp_path, monkeypatch):
    """Before the main thread waits for the thread that opens the file, or during the wait."""
    opens, heard = vars(Stream)["_open"], threading.Event()
    wait, waiting = stream_module.wait, threading.Event()

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
    with interrupts_of(heard), pytest.raises(KeyboardInterrupt) as raised:
        simulation.run(1e-3, 1e-4, out=tmp_path / "run.nc", progress=False)
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

    def work(number):
        heard_by_main_thread(heard)
        heard_before.append(released.wait(60.0))
        return number

    others = set(threading.enumerate())
    with interrupts_of(heard):
        try:
            with pytest.raises(KeyboardInterrupt):
                netcdf.beside(work, 1)
        finally:
            released.set()
            # The thread may press once more while the first signal is heard.
            for thread in set(threading.enumerate()) - others:
                thread.join(60.0)
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
