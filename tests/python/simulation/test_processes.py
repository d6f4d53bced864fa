"""Threads and processes: a scene is shared, a simulation has one thread at a time."""

import os
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

import rustchain as rc

SCENE = rc.Scene(rc.paper_drive(25.0))


def end_of(scene):
    simulation = rc.Simulation(scene)
    simulation.step_to(5e-4)
    return simulation.positions.tobytes()


def test_threads_share_a_scene():
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(end_of, [SCENE] * 8)) == {end_of(SCENE)}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_simulation_continues_in_a_forked_child():
    simulation = rc.Simulation(SCENE)
    simulation.step_to(2e-4)
    out, into = os.pipe()
    if not os.fork():
        simulation.step_to(5e-4)
        with os.fdopen(into, "wb") as pipe:
            pipe.write(simulation.positions.tobytes())
        os._exit(0)
    os.close(into)
    simulation.step_to(5e-4)
    with os.fdopen(out, "rb") as pipe:
        assert pipe.read() == simulation.positions.tobytes()
    os.wait()


def test_a_simulation_in_use_by_another_thread_is_refused_and_that_thread_continues():
    simulation, under_way = rc.Simulation(SCENE), threading.Event()
    core = simulation._core  # noqa: SLF001

    def step():
        core.start_recording(0.1, 1e-2, [], False)
        under_way.set()
        core.advance(1e9)  # one call, which lets other threads run

    thread = threading.Thread(target=step)
    thread.start()
    under_way.wait()
    with pytest.raises(rc.SimulationError, match="in use by another thread; make a Simulation"):  # noqa: PT012
        while thread.is_alive():
            _ = simulation.time
    thread.join()
    assert simulation.time == pytest.approx(0.1)


def test_a_run_under_way_in_another_thread_is_told_as_such_and_goes_on():
    simulation, under_way, told = rc.Simulation(SCENE), threading.Event(), threading.Event()

    def wait(_):
        under_way.set()
        told.wait(60.0)

    with ThreadPoolExecutor(1) as pool:
        running = pool.submit(simulation.run, 1e-3, progress=False, callback=wait)
        under_way.wait()
        try:
            for move in (lambda: simulation.run(1e-3), lambda: simulation.step_to(1.0)):
                with pytest.raises(rc.SimulationError, match="in use by another thread; make a"):
                    move()
        finally:
            told.set()
        assert running.result().success
    simulation.step_to(2e-3)
