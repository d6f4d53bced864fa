"""Many runs at once: the cases of a grid or a list, measured one by one as they finish."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from itertools import product
from typing import Any

import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import count_within, plain, shown
from rustchain.caller import warn_caller
from rustchain.description.drive import ChainDrive
from rustchain.description.laws.film import LubricantFilm
from rustchain.description.laws.force import ForceLaw, with_friction
from rustchain.description.laws.friction import Coulomb, LuGre
from rustchain.description.solver import Solver
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
from rustchain.simulation.present import SCENE
from rustchain.simulation.run import (
    WALL_BUDGET,
    Group,
    check_progress,
    check_rows_fit,
    known_groups,
    numbers_of_a_row,
    seconds_bar,
)
from rustchain.simulation.simulation import _LAW, _SOLVER, Simulation
from rustchain.simulation.start import Start, started
from rustchain.simulation.stop import StopCondition, check_looks
from rustchain.sweeps.axes import (
    MOST_CASES,
    Drive,
    Parameters,
    axes_of,
    cases_of,
    check_names,
    scene_of,
)
from rustchain.sweeps.result import SweepResult
from rustchain.sweeps.stoppable import run_looked_at
from rustchain.typing import Array


@known_keywords
def sweep(
    drive: Drive,
    axes: Mapping[str, Iterable[Any]] | Sequence[Mapping[str, Any]],
    measure: Callable[[Result], Any] | None = None,
    duration: float = 2.0,
    report_step: float = 1e-4,
    record: Sequence[Group] = ("hinges", "teeth", "sprockets"),
    energy: bool = True,
    force_law: ForceLaw = _LAW,
    hinge_law: ForceLaw | None = None,
    tooth_law: ForceLaw | None = None,
    min_impact_velocity: float = 1e-3,
    solver: Solver = _SOLVER,
    start: Start = "generated",
    positions: npt.ArrayLike | None = None,
    velocities: npt.ArrayLike | None = None,
    threads: int | None = None,
    progress: bool = True,
    friction: Coulomb | LuGre | None = None,
    hinge_friction: Coulomb | LuGre | None = None,
    tooth_friction: Coulomb | LuGre | None = None,
    stop: StopCondition | Sequence[StopCondition] = (),
    callback: Callable[[Simulation], object] | None = None,
    hinge_film: LubricantFilm | None = None,
) -> SweepResult:
    """Run a drive with other parameters again and again, several runs at once.

    Each case runs on one thread; its numbers are those of ``Simulation(...).run(...)`` to the last
    bit, whatever the number of threads. A case that fails leaves the others alone.

    What a parameter may be called:

    - an argument of `drive`, where that is a function: it goes there, before all else;
    - "pretension" [N]: makes, changes or (0 N) removes the tensioner; "speed" [rad/s]: that of the
      driver;
    - "disturbance": a seed; every sprocket without a prescribed speed starts at random up to 1e-4
      of its speed faster or slower; 0: none does;
    - a keyword below, from `duration` to `velocities`, a friction or the film, which it takes the
      place of, or a field of the solver, such as "rtol";
    - a field of the drive, dotted: "chain.material.restitution", "sprockets.1.teeth" (as
      ``drive.sprockets[1].teeth``: the first sprocket is 0). No other field follows: with other
      teeth, centre distance or links may have to change as well, which a function does best.

    Parameters
    ----------
    drive : ChainDrive, or function that returns one
        What moves.
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
    force_law, hinge_law, tooth_law, min_impact_velocity, solver, start, positions, velocities
        As in `Simulation`.
    threads : int, optional
        How many cases run at once; by default as many as there are cores.
    progress : bool
        Whether to show a progress bar, where a terminal is there to show it.
    friction, hinge_friction, tooth_friction, hinge_film
        As in `Simulation`.
    stop, callback
        As in `Simulation.run`, for each case: one that a condition stops counts as finished, and
        its result says so. A callback is called in the thread of its case, several at once.

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
    RuntimeWarning
        Cases have failed: how many, and the first.
    RangeWarning
        Contacts have left the range of their law: in how many cases, and the first.
    EnergyWarning
        The energy balance does not close: in how many cases, and the first.
    ToothJumpWarning
        The chain has jumped teeth: in how many cases, and the first.
    """
    scene: Parameters = {
        "duration": plain(duration),
        "report_step": plain(report_step),
        "record": record,
        "energy": energy,
        "force_law": force_law,
        "hinge_law": hinge_law,
        "tooth_law": tooth_law,
        "min_impact_velocity": plain(min_impact_velocity),
        "solver": solver,
        "start": start,
        "positions": positions,
        "velocities": velocities,
        "friction": friction,
        "hinge_friction": hinge_friction,
        "tooth_friction": tooth_friction,
        "hinge_film": hinge_film,
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
    check_names(drive, scene, cases)
    looked_at = len(check_looks(stop, callback)) > 0 or callback is not None

    found = SweepResult(cases, grid, [None] * len(cases), _measured=measure is not None)
    scenes: dict[int, Parameters] = {}
    ready: dict[int, _rustchain.Case] = {}
    for number, case in enumerate(cases):
        try:
            scenes[number] = _with_laws(scene_of(drive, scene, case))
            ready[number] = _ready(scenes[number])
        except Exception as error:  # a function of the user's may raise anything
            _fail(found, number, error)
    if not ready:
        raise found.errors[0]
    if looked_at:
        ready_scenes = {number: scenes[number] for number in ready}
        _run_looked_at(found, ready_scenes, stop, callback, measure, threads, progress)
    else:
        _run_all(found, scenes, ready, measure, threads, progress)
    found.errors = dict(sorted(found.errors.items()))
    found.law_warnings = dict(sorted(found.law_warnings.items()))
    found.energy_warnings = dict(sorted(found.energy_warnings.items()))
    found.jump_warnings = dict(sorted(found.jump_warnings.items()))
    _warn(found)
    return found


def _with_laws(scene: Parameters) -> Parameters:
    """Return a scene whose laws have its friction and its film."""
    names = ("force_law", "hinge_law", "tooth_law")
    given = (scene[name] for name in ("friction", "hinge_friction", "tooth_friction", "hinge_film"))
    laws = with_friction((scene[names[0]], scene[names[1]], scene[names[2]]), *given)
    return scene | dict(zip(names, laws, strict=True))


def _ready(scene: Parameters) -> _rustchain.Case:
    """Return a scene as the compiled module runs it."""
    groups, energy = known_groups(scene["record"], scene["energy"])
    drive = scene["drive"]
    if isinstance(drive, ChainDrive) and drive.hinges != "clearance":
        msg = (
            f"ChainDrive.hinges = {shown(drive.hinges)}: a sweep runs clearance hinges only; "
            "run a Simulation of each drive"
        )
        raise InvalidInput(msg)
    scene |= started(scene)
    names = (*SCENE, "duration", "report_step", "positions", "velocities")
    given = {name: scene[name] for name in names}
    case = _rustchain.Case(**given, groups=groups, energy=energy)
    numbers = numbers_of_a_row(scene["drive"], groups, energy)
    check_rows_fit(scene["duration"], scene["report_step"], numbers)
    return case


def _run_all(
    found: SweepResult,
    scenes: Mapping[int, Parameters],
    ready: Mapping[int, _rustchain.Case],
    measure: Callable[[Result], Any] | None,
    threads: int | None,
    progress: bool,
) -> None:
    """Run the cases that are ready, and measure each as soon as it has ended."""
    numbers = list(ready)
    total = sum(scenes[number]["duration"] for number in numbers)
    ensemble = _rustchain.Ensemble(list(ready.values()), threads)
    try:
        with seconds_bar(total, progress, f"0 of {len(numbers)} cases") as bar:
            left = len(numbers)
            while left:
                fetched = ensemble.fetch(WALL_BUDGET)
                bar.update(ensemble.simulated - bar.n)
                if fetched is None:
                    continue
                place, run, error = fetched
                _take(found, numbers[place], scenes[numbers[place]], run, error, measure)
                left -= 1
                bar.set_description(f"{len(numbers) - left} of {len(numbers)} cases")
    except KeyboardInterrupt:
        found.status = "interrupted"
    finally:
        ensemble.close()


def _run_looked_at(
    found: SweepResult,
    scenes: Mapping[int, Parameters],
    stop: StopCondition | Sequence[StopCondition],
    callback: Callable[[Simulation], object] | None,
    measure: Callable[[Result], Any] | None,
    threads: int | None,
    progress: bool,
) -> None:
    """Run cases that are looked at while they run, and measure each as soon as it has ended."""
    total = sum(scene["duration"] for scene in scenes.values())
    try:
        with (
            seconds_bar(total, progress, f"0 of {len(scenes)} cases") as bar,
            closing(run_looked_at(scenes, stop, callback, threads)) as running,
        ):
            for ended in filter(None, running):
                number, error = ended.number, ended.error
                _note(found, number, ended.law_warnings, ended.energy_warnings, ended.jump_warnings)
                if ended.result is not None:
                    error = _measured(found, number, ended.result, measure)
                if error is not None:
                    _fail(found, number, error)
                bar.update(scenes[number]["duration"])
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
    scene: Parameters,
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
