"""Cases of a sweep that are looked at while they run: each a simulation on a thread of its own."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass

from rustchain.arguments import shown
from rustchain.errors import InvalidInput
from rustchain.results.result import Result
from rustchain.simulation.present import SCENE
from rustchain.simulation.run import WALL_BUDGET
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import StopCondition
from rustchain.sweeps.axes import Parameters


@dataclass(frozen=True)
class Ended:
    """What came of a case: its number, its result or error, and what there was to warn of."""

    number: int
    result: Result | None
    error: Exception | None
    law_warnings: list[str]
    energy_warnings: list[str]
    jump_warnings: list[str]


class _Quiet(Simulation):
    """A simulation that leaves its warnings to the sweep, and ends with it."""

    _given_up: threading.Event | None = None

    def _warn(self) -> None:
        pass

    def _slice(self) -> bool:
        if self._given_up is not None and self._given_up.is_set():
            raise KeyboardInterrupt
        return super()._slice()


def run_looked_at(
    scenes: Mapping[int, Parameters],
    stop: StopCondition | Sequence[StopCondition],
    callback: Callable[[Simulation], object] | None,
    threads: int | None,
) -> Generator[Ended | None, None, None]:
    """Run cases several at once, and yield each as it ends; None now and then, for Ctrl-C.

    When the caller goes on no more, the cases under way stop within a moment of wall time.
    """
    if threads is not None and (
        isinstance(threads, bool) or not isinstance(threads, int) or threads < 1
    ):
        msg = f"threads = {shown(threads)}: must be a whole number of at least 1, or None"
        raise InvalidInput(msg)
    given_up = threading.Event()

    def run(number: int) -> Ended:
        scene = scenes[number]
        if given_up.is_set():
            return Ended(number, None, None, [], [], [])
        given = {name: scene[name] for name in (*SCENE, "positions", "velocities")}
        simulation = _Quiet(**given)
        simulation._given_up = given_up

        names = ("duration", "report_step", "record", "energy")
        result, error = None, None
        try:
            run = {name: scene[name] for name in names}
            result = simulation.run(**run, progress=False, stop=stop, callback=callback)
        except Exception as raised:  # a callback of the user's may raise anything
            error = raised
        return Ended(number, result, error, *simulation._core.take_warnings())

    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        waiting = {pool.submit(run, number) for number in scenes}
        try:
            while waiting:
                done, waiting = wait(waiting, WALL_BUDGET, FIRST_COMPLETED)
                yield from (future.result() for future in done)
                if not done:
                    yield None
        finally:
            given_up.set()
            for future in waiting:
                future.cancel()
