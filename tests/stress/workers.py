"""A process of its own for scenes: what hangs in it or kills it is an outcome like the others."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterable, Iterator
from multiprocessing.connection import Connection

from outcomes import Job, Outcome, outcome_of

# Limit of processor time of a scene [s], at which it is interrupted.
LIMIT = 20.0

# A scene that does not obey hangs: times the limit until its process is ended.
PATIENCE = 2.0

# Wall time after which a scene that uses no processor time is given up [s]. A busy machine may be
# slower than one by a factor of 50.
WALL = 1800.0


def outcomes_of(jobs: Iterable[Job], limit: float = LIMIT) -> Iterator[Outcome]:
    """Yield the outcome of each job; a process that a scene has ended is followed by another."""
    process = connection = None
    for job in jobs:
        if process is None:
            process, connection = _started()
        try:
            connection.send((job, limit))
            if not connection.poll(WALL):
                process.terminate()
            yield connection.recv()
        except EOFError:  # it has ended
            process.join()
            hung = -process.exitcode in (signal.SIGVTALRM, signal.SIGTERM)
            word = "hang" if hung else "abort"
            yield Outcome(job.name, job.kind, word, f"exit code {process.exitcode}")
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
        job, limit = asked
        # The default action of this signal ends the process, in whatever it is.
        signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE * limit)
        connection.send(outcome_of(job, limit))
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
