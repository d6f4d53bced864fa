"""Many runs at once: the cases of a grid or a list, measured one by one as they finish."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from itertools import product
from typing import Any

from rustchain import _rustchain
from rustchain.arguments import count_within, plain, shown
from rustchain.caller import warn_caller
from rustchain.description.scene import Scene
from rustchain.errors import (
    CaseWarning,
    EnergyWarning,
    InvalidInput,
    RangeWarning,
    SimulationError,
    ToothJumpWarning,
)
from rustchain.names import known_keywords
from rustchain.results.result import Result
from rustchain.simulation.run import WALL_BUDGET, Group, check_progress, seconds_bar
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import StopCondition, check_looks
from rustchain.sweeps.axes import (
    MOST_CASES,
    Parameters,
    System,
    axes_of,
    case_of,
    cases_of,
    check_names,
)
from rustchain.sweeps.result import SweepResult
from rustchain.sweeps.stoppable import CaseOf, run_looked_at
from rustchain.typing import Array


@known_keywords
def sweep(
    scene: System,
    axes: Mapping[str, Iterable[Any]] | Sequence[Mapping[str, Any]],
    measure: Callable[[Result], Any] | None = None,
    *,
    duration: float = 2.0,
    report_step: float = 1e-4,
    record: Sequence[Group] | None = None,
    energy: bool | None = None,
    stop: StopCondition | Sequence[StopCondition] = (),
    callback: Callable[[Simulation], object] | None = None,
    threads: int | None = None,
    progress: bool = True,
) -> SweepResult:
    """Run a scene with other parameters again and again, several runs at once.

    Each case runs on one thread; its numbers are those of ``Simulation(...).run(...)`` to the last
    bit, whatever the number of threads. A case that fails leaves the others alone.

    What a parameter may be called:

    - an argument of `scene`, where that is a function: it goes there, before all else;
    - "pretension" [N]: makes, changes or (0 N) removes the tensioner; "speed" [rad/s]: that of the
      driver;
    - "replicate": a seed; every sprocket without a prescribed speed, and every body of a mechanism
      that moves, starts at random up to 1e-4 of its speed faster or slower; 0: none does;
    - a field of the scene, such as "solver", or of what is in it, dotted: "force_law.friction",
      "solver.rtol"; a field of the solver alone, such as "rtol", too;
    - an argument of the run: "duration", "report_step", "record", "energy";
    - a field of the drive, dotted: "chain.material.restitution", "sprockets.1.teeth". Sprockets,
      guides, ends and coordinates are numbered from 1, as everywhere in names: "sprockets.1" is
      what ``result.sprocket(1)`` shows. No other field follows: with other teeth, centre distance
      or links may have to change as well, which a function does best.

    Parameters
    ----------
    scene : Scene, ChainDrive or Mechanism, or function that returns one
        What to simulate.
    axes : mapping of str to sequence, or sequence of mappings
        Values of each parameter, all of which are combined; or the parameters of each case.
    measure : function of a Result, optional
        Returns what to keep of a case: a number, an array, or a dict of them. It is called in the
        thread that called `sweep`, for one case at a time, while others go on running. By default
        the results themselves are kept, which takes memory for all of them.
    duration : float
        Simulated time [s].
    report_step, record, energy
        As in `Simulation.run`.
    stop, callback
        As in `Simulation.run`, for each case: one that a condition stops counts as finished, and
        its result says so. A callback is called in the thread of its case, several at once.
    threads : int, optional
        How many cases run at once; by default as many as there are cores.
    progress : bool
        Whether to show a progress bar, where a terminal is there to show it.

    Returns
    -------
    SweepResult
        After Ctrl-C with status "interrupted" and the cases that had finished.

    Raises
    ------
    InvalidInput
        A parameter is not known, or no case has values that are allowed.

    Warns
    -----
    CaseWarning
        Cases have failed: how many, and the first.
    RangeWarning
        Contacts have left the range of their law: in how many cases, and the first.
    EnergyWarning
        The energy balance does not close: in how many cases, and the first.
    ToothJumpWarning
        The chain has jumped teeth: in how many cases, and the first.
    """
    run: Parameters = {
        "duration": plain(duration),
        "report_step": plain(report_step),
        "record": record,
        "energy": energy,
    }
    grid = axes_of(axes) if isinstance(axes, Mapping) else None
    if grid is None:
        cases = cases_of(axes)
    else:
        count_within("cases of the sweep", math.prod(map(len, grid.values())), 1, MOST_CASES)
        cases = [dict(zip(grid, values, strict=True)) for values in product(*grid.values())]
    if measure is not None and not callable(measure):
        msg = f"measure = {shown(measure)}: must be a function of a Result, or None"
        raise InvalidInput(msg)
    check_progress(progress)
    check_names(scene, run, cases)
    looked_at = len(check_looks(stop, callback)) > 0 or callback is not None

    found = SweepResult(cases, grid, [None] * len(cases), _measured=measure is not None)
    ready: dict[int, CaseOf] = {}
    for number, case in enumerate(cases):
        try:
            ready[number] = CaseOf.made(*case_of(scene, run, case), looked_at)
        except Exception as error:  # a function of the user's may raise anything
            _fail(found, number, error)
    if not ready:
        raise found.errors[0]
    in_pool = {number: case for number, case in ready.items() if case.compiled is not None}
    others = {number: case for number, case in ready.items() if case.compiled is None}
    if in_pool:
        _run_in_pool(found, in_pool, measure, threads, progress)
    if others and found.status == "finished":
        _run_looked_at(found, others, stop, callback, measure, threads, progress)
    found.errors = dict(sorted(found.errors.items()))
    found.law_warnings = dict(sorted(found.law_warnings.items()))
    found.energy_warnings = dict(sorted(found.energy_warnings.items()))
    found.jump_warnings = dict(sorted(found.jump_warnings.items()))
    _warn(found)
    return found


def _run_in_pool(
    found: SweepResult,
    cases: Mapping[int, CaseOf],
    measure: Callable[[Result], Any] | None,
    threads: int | None,
    progress: bool,
) -> None:
    """Run cases in the compiled pool, and measure each as soon as it has ended."""
    numbers = list(cases)
    total = sum(case.run["duration"] for case in cases.values())
    compiled = [case.compiled for case in cases.values() if case.compiled is not None]
    ensemble = _rustchain.Ensemble(compiled, threads)
    try:
        with seconds_bar(total, progress, f"0 of {len(numbers)} cases") as bar:
            left = len(numbers)
            while left:
                fetched = ensemble.fetch(WALL_BUDGET)
                bar.update(ensemble.simulated - bar.n)
                if fetched is None:
                    continue
                place, run, error = fetched
                _take(found, numbers[place], cases[numbers[place]].scene, run, error, measure)
                left -= 1
                bar.set_description(f"{len(numbers) - left} of {len(numbers)} cases")
    except KeyboardInterrupt:
        found.status = "interrupted"
    finally:
        ensemble.close()


def _run_looked_at(
    found: SweepResult,
    cases: Mapping[int, CaseOf],
    stop: StopCondition | Sequence[StopCondition],
    callback: Callable[[Simulation], object] | None,
    measure: Callable[[Result], Any] | None,
    threads: int | None,
    progress: bool,
) -> None:
    """Run cases as simulations on threads, and measure each as soon as it has ended."""
    total = sum(case.run["duration"] for case in cases.values())
    try:
        with (
            seconds_bar(total, progress, f"0 of {len(cases)} cases") as bar,
            closing(run_looked_at(cases, stop, callback, threads)) as running,
        ):
            for ended in filter(None, running):
                number, error = ended.number, ended.error
                _note(found, number, ended.law_warnings, ended.energy_warnings, ended.jump_warnings)
                if ended.result is not None:
                    error = _measured(found, number, ended.result, measure)
                if error is not None:
                    _fail(found, number, error)
                bar.update(cases[number].run["duration"])
    except KeyboardInterrupt:
        found.status = "interrupted"


def _measured(
    found: SweepResult, number: int, result: Result, measure: Callable[[Result], Any] | None
) -> Exception | None:
    """Keep the measured value of a case; return what its measure raised."""
    try:
        found.values[number] = result if measure is None else measure(result)
        found._ended.add(number)
    except Exception as raised:  # a function of the user's may raise anything
        return raised
    return None


def _take(
    found: SweepResult,
    number: int,
    scene: Scene,
    run: tuple[_rustchain.Core, tuple[Array, Array]] | None,
    error: Exception | None,
    measure: Callable[[Result], Any] | None,
) -> None:
    """Take what came of a case: its measured value, or its error."""
    if run is not None:
        core, start = run
        simulation = Simulation._around(core, scene)
        if error is None:
            result = simulation._result("finished", start, {})
            error = _measured(found, number, result, measure)
        elif isinstance(error, SimulationError):
            error.result = simulation._result("failed", start, {}, str(error))
        # The energy balance is judged when its recording has been taken.
        _note(found, number, *core.take_warnings())
    if error is not None:
        _fail(found, number, error)


def _note(
    found: SweepResult, number: int, ranges: list[str], balances: list[str], jumps: list[str]
) -> None:
    """Keep what there was to warn of in a case."""
    for notes, new in (
        (found.law_warnings, ranges),
        (found.energy_warnings, balances),
        (found.jump_warnings, jumps),
    ):
        if new:
            notes[number] = new


def _fail(found: SweepResult, number: int, error: Exception) -> None:
    """Keep the error of a case, with a note that tells which."""
    # What add_note does, which Python 3.10 lacks.
    note = f"in {_name(found, number)} of the sweep"
    error.__notes__ = [*getattr(error, "__notes__", ()), note]
    found.errors[number] = error


def _name(found: SweepResult, number: int) -> str:
    """Return a case by its number and parameters, in words."""
    parameters = ", ".join(f"{name}={shown(value)}" for name, value in found.cases[number].items())
    return f"case {number} ({parameters})"


def _warn(found: SweepResult) -> None:
    """Warn once of all cases that failed, of all laws that left their range, of all balances."""
    for number, error in list(found.errors.items())[:1]:
        which = (
            f"{len(found.errors)} of {len(found.cases)} cases failed, first {_name(found, number)}"
        )
        warn_caller(f"{which}: {type(error).__name__}: {error}", CaseWarning)
    for notes, category in (
        (found.law_warnings, RangeWarning),
        (found.energy_warnings, EnergyWarning),
        (found.jump_warnings, ToothJumpWarning),
    ):
        for number, lines in list(notes.items())[:1]:
            which = f"{len(notes)} of {len(found.cases)} cases, first {_name(found, number)}"
            warn_caller(f"{which}: {'; '.join(lines)}", category)
