"""A process of its own for scenes: what hangs in it or kills it is an outcome like the others."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection

from outcomes import Outcome, outcome_of
from scenes import Scene

# Limit of processor time of a scene [s]: the wall time of one that has a processor to itself.
LIMIT = 20.0

# Wall time after which a scene that uses no processor time is given up [s].
WALL_LIMIT = 20.0 * LIMIT


def outcomes_of(seeds: Iterable[int], longest: float, limit: float = LIMIT) -> Iterator[Outcome]:
    """Yield the outcome of each seed; a process that a scene has ended is followed by another."""
    process = connection = None
    for seed in seeds:
        if process is None:
            process, connection = _started()
        try:
            connection.send((seed, longest, limit))
            if not connection.poll(WALL_LIMIT):
                process.terminate()
            yield connection.recv()
        except EOFError:  # it has ended
            process.join()
            hung = -process.exitcode in (signal.SIGPROF, signal.SIGTERM)
            word = "hang" if hung else "abort"
            yield Outcome(seed, Scene(seed).kind, word, f"exit code {process.exitcode}")
            process = None
    if process is not None:
        connection.send(None)
        process.join()


def _started() -> tuple[multiprocessing.Process, Connection]:
    spawn = multiprocessing.get_context("spawn")
    here, there = spawn.Pipe()
    process = spawn.Process(target=_work, args=(there,), daemon=True)
    process.start()
    there.close()  # so that its end is seen here
    return process, here


def _work(connection: Connection) -> None:
    """Run the scenes that are asked for."""
    while (asked := connection.recv()) is not None:
        seed, longest, limit = asked
        # The default action of this signal ends the process, in whatever it is.
        signal.setitimer(signal.ITIMER_PROF, limit)
        connection.send(outcome_of(seed, longest))
        signal.setitimer(signal.ITIMER_PROF, 0.0)
