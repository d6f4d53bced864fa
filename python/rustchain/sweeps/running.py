"""Cases of a sweep on their way: in the compiled pool, on threads, or where an executor is."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from functools import partial
from itertools import islice
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from rustchain import _rustchain
from rustchain.arguments import count_within, shown
from rustchain.caller import warn_caller
from rustchain.description.plausibility import implausible_inputs
from rustchain.errors import InvalidInput, SimulationError
from rustchain.simulation.core import changes_of_start, start_of
from rustchain.simulation.recording import Recording
from rustchain.simulation.run import (
    WALL_BUDGET,
    Bar,
    check_rows_fit,
    numbers_of_drive_row,
)
from rustchain.simulation.simulation import Simulation
from rustchain.sweeps.case_run import (
    Case,
    Looks,
    Measure,
    Outcome,
    Quiet,
    lean,
    measured,
    run_and_measure,
    run_case,
)
from rustchain.sweeps.cases import seconds_of

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

# Cases per thread that are made ahead for the compiled pool. Between two such portions threads wait
# for the last case of one: with 64, less than 1 % of the time where cases are about equally long.
_PORTION = 64
# Cases that an executor holds at once: enough for some hundred workers, some 20 MB of scenes.
_MOST_SUBMITTED = 1024
_MOST_THREADS = 10_000  # more than any machine has cores


class DaskClient(Protocol):
    """Methods of a Dask client that sweeps use."""

    def get_executor(self, *, pure: bool) -> Executor:
        """Return an executor that runs on the client's cluster."""


Running: TypeAlias = Generator["tuple[Case, Outcome]", None, None]
"""Cases as they end."""


def cores() -> int:
    """Return the number of cores that this process may use: in a job of a cluster, not all."""
    allowed = getattr(os, "sched_getaffinity", None)  # on Linux
    return (os.cpu_count() or 1) if allowed is None else len(allowed(0))


def number_of_threads(threads: object) -> int:
    """Return the number of threads; None: as many as there are cores."""
    if threads is None:
        return cores()
    return count_within("threads", threads, 1, _MOST_THREADS)


def run_here(
    cases: Iterator[Case], looks: Looks, measure: Measure | None, threads: int | None, bar: Bar
) -> Running:
    """Run cases in this process: in the compiled pool, or on threads where it does not run them.

    The pool runs drives, without stop conditions and callbacks.
    Cases are measured in this thread.
    """
    count = number_of_threads(threads)
    told: set[str] = set()
    while portion := list(islice(cases, _PORTION * count)):
        pooled: list[Case] = []
        others: list[Case] = []
        for case in portion:
            alone = looks.any or case.scene.kind == "mechanism"
            (others if alone else pooled).append(case)
        yield from _run_in_pool(pooled, measure, threads, bar, told)
        yield from _run_on_threads(iter(others), looks, measure, count, bar)


def _run_in_pool(
    cases: list[Case], measure: Measure | None, threads: int | None, bar: Bar, told: set[str]
) -> Running:
    """Run cases in the compiled pool; warn of inputs that are implausible unless it was `told`."""

    def warn(texts: Iterable[str]) -> None:
        for text in texts:
            if text not in told:
                warn_caller(text)
                told.add(text)

    ready, compiled = [], []
    for case in cases:
        try:
            made = _compiled(case)
            warn(implausible_inputs(case.scene))
            compiled.append(made)
            ready.append(case)
        except Exception as error:  # what is refused
            yield case, Outcome(error=lean(error), made=False)
    if not ready:
        return
    ensemble, before = _rustchain.Ensemble(compiled, threads), bar.n
    try:
        for _ in ready:
            fetched = None
            while fetched is None:  # after a moment of wall time, for Ctrl-C
                fetched = ensemble.fetch(WALL_BUDGET)
                bar.update(before + ensemble.simulated - bar.n)
            number, core, failure = fetched
            case = ready[number]
            if core is not None and case.scene.positions is not None:
                positions, velocities = core.start()
                place, _ = start_of(case.scene)
                warn(changes_of_start(case.scene, place, (positions, velocities)))
            yield case, _fetched(case, core, failure, measure)
    finally:
        ensemble.close()


def _compiled(case: Case) -> _rustchain.Case:
    """Return a case as the compiled pool runs it, checked."""
    groups, energy = case.groups()
    times = {name: case.run[name] for name in ("duration", "report_step")}
    place, _ = start_of(case.scene)
    compiled = _rustchain.Case(case.scene, **place, **times, groups=groups, energy=energy)
    numbers = numbers_of_drive_row(case.scene.drive, groups, energy)
    check_rows_fit(times["duration"], times["report_step"], numbers)
    return compiled


def _fetched(
    case: Case,
    core: _rustchain.Core | None,
    error: Exception | None,
    measure: Measure | None,
) -> Outcome:
    """Return the outcome of a case that the pool has run."""
    if core is None:
        return Outcome(error=error, made=False)
    positions, velocities = core.start()
    recording = Recording(Simulation._around(core, case.scene), (positions, velocities), {})
    if error is None:
        ended = measured(Outcome(recording.result("finished")), measure)
    else:
        if isinstance(error, SimulationError):
            error.result = recording.result("failed", str(error))
        ended = Outcome(error=error)
    # The energy balance is judged when its recording has been taken.
    return ended._replace(notes=core.take_warnings())


def _run_on_threads(
    cases: Iterator[Case], looks: Looks, measure: Measure | None, threads: int, bar: Bar
) -> Running:
    """Run cases as simulations on threads.

    When the caller does not continue, the cases under way stop within a moment of wall time.
    """
    from concurrent.futures import ThreadPoolExecutor

    given_up = threading.Event()

    def submit(case: Case) -> Future[Outcome]:
        # Made here, where warnings have the line of the caller.
        return pool.submit(run_case, case, Quiet(case.scene), looks, given_up)

    with ThreadPoolExecutor(threads) as pool:
        try:
            for case, outcome in _in_turn(cases, submit, 2 * threads):
                bar.update(seconds_of(case.run))
                yield case, measured(outcome, measure)
        finally:
            given_up.set()


def run_on(
    executor: Executor | DaskClient,
    cases: Iterator[Case],
    looks: Looks,
    measure: Measure | None,
    bar: Bar,
) -> Running:
    """Run cases where an executor is; they are measured there."""
    dask = getattr(executor, "get_executor", None)
    pool: Any = executor if dask is None else dask(pure=False)
    run = partial(run_and_measure, looks=looks, measure=measure)
    for case, outcome in _in_turn(cases, partial(pool.submit, run), _MOST_SUBMITTED):
        bar.update(seconds_of(case.run))
        yield case, outcome


def check_executor(executor: object) -> None:
    """Refuse what runs nothing."""
    if not callable(getattr(executor, "submit", None)):
        msg = (
            f"executor = {shown(executor)}: runs nothing; expected an Executor as in "
            "concurrent.futures, a Client of Dask, or None for threads of this process"
        )
        raise InvalidInput(msg)


def _in_turn(
    cases: Iterator[Case], submit: Callable[[Case], Future[Outcome]], most: int
) -> Running:
    """Submit cases, so many at once at the most, and yield each as it ends."""
    ended: SimpleQueue[Future[Outcome]] = SimpleQueue()
    waiting: dict[Future[Outcome], Case] = {}
    left = True
    try:
        while left or waiting:
            while left and len(waiting) < most:
                case = next(cases, None)
                if case is None:
                    left = False
                    break
                try:
                    future = submit(case)
                except Exception as error:  # of a scene, or of a pool that is broken or closed
                    yield case, Outcome(error=lean(error), made=False)
                    continue
                waiting[future] = case
                future.add_done_callback(ended.put)
            if waiting:
                try:
                    future = ended.get(timeout=WALL_BUDGET)
                except Empty:  # after a moment of wall time, for Ctrl-C
                    continue
                yield waiting.pop(future), _outcome(future)
    finally:
        for future in waiting:
            future.cancel()


def _outcome(future: Future[Outcome]) -> Outcome:
    """Return the outcome of a case; what an executor raises is no failure of the case's run."""
    try:
        return future.result()
    except Exception as error:
        if "pickle" not in str(error).lower():
            return Outcome(error=error, made=False)
        msg = (
            f"executor: the case cannot be sent to another process ({error}); expected functions "
            "of a module; take a def in a file in place of a lambda, or loky"
        )
        return Outcome(error=InvalidInput(msg), made=False)
