"""Executors: the same bits from each, lost workers, what cannot be sent."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import rustchain as rc
from rustchain.cli.executors import executor_of
from rustchain.sweeps.running import number_of_threads

PAPER = rc.paper_drive()
SHORT = {"duration": 5e-3, "progress": False}

SCRIPT = """
import contextlib, json, os, signal, sys, threading, time, warnings
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
import rustchain as rc

AXES = {"pretension": [0, 25, 50], "chain.material.elastic_modulus": [2e11, 1e300]}
SHORT = {"duration": 5e-3, "progress": False}

class Own(Exception):  # does not survive pickling
    def __init__(self, one, two):
        super().__init__(f"{one} {two}")

def measure(result):
    if result.drive.tensioner is None:
        raise Own("no", "tensioner")
    return {"peak": result.peaks.tooth_force.max(), "end": result.final_positions}

def stop(simulation):
    return simulation.time > 4e-3

def told(found):
    values = [v and [v["peak"].hex(), v["end"].tobytes().hex()] for v in found.values]
    # An error that cannot be sent is another one with its class in the message.
    errors = {n: [str(error).replace("Own: ", "")] for n, error in found.errors.items()}
    for n, error in found.errors.items():
        if isinstance(error, rc.SimulationError):
            errors[n].append(len(error.result.time))
    return json.dumps([found.status, values, errors])

def made(kind):
    if kind == "threads":
        return ThreadPoolExecutor(2)
    if kind == "processes":
        return ProcessPoolExecutor(2)
    if kind == "loky":
        import loky
        return loky.get_reusable_executor(2)
    if kind == "mpi":
        from mpi4py.futures import MPIPoolExecutor
        return MPIPoolExecutor()
    return contextlib.nullcontext()

if __name__ == "__main__":
    warnings.simplefilter("ignore")
    with made(sys.argv[1]) as executor:
        found = rc.sweep(rc.paper_drive(), AXES, measure, executor=executor, **SHORT)
        print(told(found))
        looked = rc.sweep(rc.paper_drive(), {"pretension": [25, 50]}, measure, executor=executor,
                          callback=stop, stop=[rc.ToothForceAbove(1e9)], **SHORT)
        print(told(looked))
        whole = rc.sweep(rc.paper_drive(), {"pretension": [25]}, executor=executor, **SHORT)
        print(whole.results[0].final_positions.tobytes().hex())
        study = rc.study(rc.paper_drive(), runs=3, burn_in=1e-3, executor=executor, **SHORT)
        print(study.samples.to_dict()["data_vars"])
"""


def said(tmp_path, kind, before=()):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    arguments = [*before, sys.executable]
    arguments += ["-m", "mpi4py.futures"] if kind == "mpi" else []
    done = subprocess.run([*arguments, str(script), kind], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    return said(tmp_path_factory.mktemp("here"), "none")


@pytest.mark.parametrize("kind", ["threads", "processes", "loky", "mpi"])
def test_every_executor_gives_the_same_bits_and_errors(kind, here, tmp_path):
    before = []
    if kind == "loky":
        pytest.importorskip("loky")
    if kind == "mpi":
        launcher = shutil.which(
            "mpiexec", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        )
        if importlib.util.find_spec("mpi4py") is None or launcher is None:
            pytest.skip("no MPI here")
        before = [launcher, "-n", "3"]
    first = json.loads(here.splitlines()[0])
    assert [value is None for value in first[1]] == [True, True, False, True, False, True]
    assert said(tmp_path, kind, before) == here


DASK = """
import json, os, signal, sys, threading, time
import rustchain as rc
from dask.distributed import Client, LocalCluster
from typer.testing import CliRunner
from rustchain.cli.app import app

def peak(result):
    return float(result.peaks.tooth_force.max())

def kill_a_busy_worker(client, pids):
    while not any(client.processing().values()):
        time.sleep(0.01)
    worker = next(name for name, tasks in client.processing().items() if tasks)
    os.kill(pids[worker], signal.SIGKILL)

if __name__ == "__main__":
    drive, axes = rc.paper_drive(), {"pretension": [0, 25, 50, 75], "speed": [10.0, 11.0]}
    run = {"duration": 1.5e-2, "progress": False}
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            pids = client.run(os.getpid)
            killer = threading.Thread(target=kill_a_busy_worker, args=(client, pids))
            killer.start()
            found = rc.sweep(drive, axes, peak, executor=client, store=sys.argv[1], **run)
            killer.join()
            lost = [pid for pid in pids.values() if not os.path.exists(f"/proc/{pid}")]
            command = ["sweep", "sweep.toml", "--executor", f"dask:{cluster.scheduler_address}"]
            told = CliRunner().invoke(app, [*command, "--json"])
            study = rc.study(drive, lambda r: r.time[-1], runs=2, burn_in=0.0, executor=client,
                             duration=1e-3, progress=False)
    here = rc.sweep(drive, axes, peak, **run)
    print(json.dumps([found.success, found.values == here.values, len(lost),
                      len(os.listdir(sys.argv[1])), study.sweep.success,
                      json.loads(told.stdout)["finished"]]))
"""


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for processes in /proc")
def test_a_worker_of_dask_that_is_killed_loses_no_case(tmp_path):
    pytest.importorskip("distributed")
    script = tmp_path / "script.py"
    script.write_text(DASK)
    (tmp_path / "measures.py").write_text("def end(result):\n    return float(result.time[-1])\n")
    (tmp_path / "sweep.toml").write_text(
        'drive = "paper"\nmeasure = "measures.py:end"\n[axes]\nduration = [1e-3, 2e-3, 3e-3]\n'
    )
    arguments = [sys.executable, str(script), str(tmp_path / "runs")]
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    done = subprocess.run(arguments, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [True, True, 1, 8, True, 3]


def test_a_lambda_that_cannot_be_sent_is_told():
    said = "cannot be sent to another process"
    with ProcessPoolExecutor(1) as pool, pytest.raises(rc.InvalidInput, match=said):
        rc.sweep(PAPER, {"speed": [10.0, 11.0]}, lambda r: r.time, executor=pool, **SHORT)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="not on this system")
def test_by_default_as_many_cases_run_at_once_as_the_process_may_use_cores():
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    try:
        assert number_of_threads(None) == 1
    finally:
        os.sched_setaffinity(0, allowed)


def test_what_runs_nothing_is_refused():
    with pytest.raises(rc.InvalidInput, match=r"executor = 4: runs nothing; expected an Executor"):
        rc.sweep(PAPER, {"speed": [10.0]}, executor=4, **SHORT)
    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(rc.InvalidInput, match="threads = 2: is for executor=None"):
            rc.sweep(PAPER, {"speed": [10.0]}, executor=pool, threads=2, **SHORT)
        with pytest.raises(rc.InvalidInput, match="duration = -1: must be a positive"):
            rc.sweep(PAPER, {"speed": [10.0]}, executor=pool, duration=-1, progress=False)


def test_an_executor_stays_open_and_measures_where_it_runs():
    threads = set()

    def measure(result):
        import threading

        threads.add(threading.current_thread().name)
        return float(result.time[-1])

    with ThreadPoolExecutor(2, thread_name_prefix="own") as pool:
        for _ in range(2):
            found = rc.sweep(PAPER, {"speed": [10.0, 11.0]}, measure, executor=pool, **SHORT)
            assert found.values == [5e-3, 5e-3]
    assert all(name.startswith("own") for name in threads)


@pytest.mark.parametrize("where", ["pool", "threads", "executor"])
def test_no_more_cases_are_made_ahead_than_run_at_once_and_wait(where, monkeypatch):
    """Of ten cases two, so that the memory of a sweep does not grow with their number."""
    monkeypatch.setattr("rustchain.sweeps.running._PORTION", 2)
    monkeypatch.setattr("rustchain.sweeps.running._MOST_SUBMITTED", 2)
    built, counts = [], []

    def build(pretension):
        built.append(pretension)
        return rc.paper_drive(pretension)

    def measure(result):
        counts.append(len(built))

    with ThreadPoolExecutor(1) as pool:
        keywords = {
            "pool": {"threads": 1},
            "threads": {"threads": 1, "callback": lambda _: False},
            "executor": {"executor": pool},
        }[where]
        axes = {"pretension": [10.0 + k for k in range(10)]}
        found = rc.sweep(build, axes, measure, duration=1e-3, progress=False, **keywords)
    assert len(counts) == found.finished == 10
    assert all(count <= place + 1 for place, count in enumerate(counts, 1))


def test_a_client_of_dask_runs_equal_cases_each_for_itself():
    asked = []

    class Client(ThreadPoolExecutor):
        def get_executor(self, *, pure):
            asked.append(pure)
            return self

    with Client(1) as client:
        found = rc.sweep(PAPER, {"speed": [10.0]}, executor=client, **SHORT)
    assert found.success
    assert asked == [False]


def test_a_loss_map_runs_on_an_executor():
    drive = rc.two_sprocket_drive(teeth=(17, 17), links=40, pretension=50.0)
    keywords = {"duration": 0.02, "burn_in": 0.01, "progress": False}
    here = rc.loss_map(drive, [6.0], [-1.0], **keywords)
    with ProcessPoolExecutor(1) as pool:
        there = rc.loss_map(drive, [6.0], [-1.0], executor=pool, **keywords)
    assert here.equals(there)
    assert np.isfinite(here["efficiency"]).all()


def test_a_pool_of_the_command_ends_in_the_middle_of_cases_without_an_error_of_its_thread(
    monkeypatch,
):
    """As after Ctrl-C: cases that wait are cancelled, and those that run are ended."""
    failed, before = [], set(threading.enumerate())
    monkeypatch.setattr(threading, "excepthook", failed.append)
    with executor_of("processes:2") as where:
        futures = [where["executor"].submit(time.sleep, 600.0) for _ in range(20)]
        while sum(future.running() for future in futures) < 3:  # as many as it sends ahead
            time.sleep(1e-3)
        for future in futures:
            future.cancel()
    del where
    for thread in set(threading.enumerate()) - before:
        thread.join(60.0)
        assert not thread.is_alive()
    assert failed == []
    assert all(future.done() for future in futures)
