"""Cases of a sweep: ready to run, and run on threads where the compiled pool does not."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass

from rustchain import _rustchain
from rustchain.arguments import shown
from rustchain.description.scene import Scene
from rustchain.errors import InvalidInput
from rustchain.results.result import Result
from rustchain.simulation.core import keywords_of, start_of
from rustchain.simulation.run import (
    WALL_BUDGET,
    check_rows_fit,
    known_groups,
    numbers_of_drive_row,
)
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


class Quiet(Simulation):
    """A simulation that leaves its warnings to the sweep, and ends with it."""

    given_up: threading.Event | None = None

    def _warn(self) -> None:
        pass

    def take_warnings(self) -> tuple[list[str], list[str], list[str]]:
        """Return what is new: laws out of range; the energy balance; tooth jumps."""
        return self._core.take_warnings()

    def _slice(self) -> bool:
        if self.given_up is not None and self.given_up.is_set():
            raise KeyboardInterrupt
        return super()._slice()


@dataclass(frozen=True)
class CaseOf:
    """A case that is ready to run.

    Attributes
    ----------
    scene : Scene
        What is simulated.
    run : dict
        Arguments of its run.
    compiled : Case, optional
        The case as the compiled pool runs it: of drives with clearance in their hinges, whose runs
        nothing looks at.
    simulation : Simulation, optional
        The simulation of any other case.
    """

    scene: Scene
    run: Parameters
    compiled: _rustchain.Case | None
    simulation: Quiet | None

    @classmethod
    def made(cls, scene: Scene, run: Parameters, looked_at: bool) -> CaseOf:
        """Return a case whose scene and run are checked."""
        groups, energy = known_groups(scene, run["record"], run["energy"])
        if looked_at or scene.kind != "clearance":
            return cls(scene, run, None, Quiet(scene))
        times = {name: run[name] for name in ("duration", "report_step")}
        place, _ = start_of(scene)
        compiled = _rustchain.Case(
            **keywords_of(scene), **place, **times, groups=groups, energy=energy
        )
        numbers = numbers_of_drive_row(scene.drive, groups, energy)
        check_rows_fit(times["duration"], times["report_step"], numbers)
        return cls(scene, run, compiled, None)


def run_looked_at(
    cases: Mapping[int, CaseOf],
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
    from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

    given_up = threading.Event()

    def run(number: int) -> Ended:
        simulation = cases[number].simulation
        if given_up.is_set() or simulation is None:
            return Ended(number, None, None, [], [], [])
        simulation.given_up = given_up
        result, error = None, None
        try:
            arguments = cases[number].run
            result = simulation.run(**arguments, progress=False, stop=stop, callback=callback)
        except Exception as raised:  # a callback of the user's may raise anything
            error = raised
        return Ended(number, result, error, *simulation.take_warnings())

    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        waiting = {pool.submit(run, number) for number in cases}
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
