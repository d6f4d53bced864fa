"""Many runs at once: the cases of a grid or a list, measured one by one as they finish."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rustchain.arguments import plain, shown
from rustchain.caller import warn_caller
from rustchain.errors import (
    CaseWarning,
    EnergyWarning,
    InvalidInput,
    RangeWarning,
    ToothJumpWarning,
    attach,
)
from rustchain.names import known_keywords
from rustchain.results.result import Result
from rustchain.simulation.run import Bar, Group, check_truth, read_once, seconds_bar
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import StopCondition, check_looks
from rustchain.sweeps.axes import System, case_of, check_names
from rustchain.sweeps.case_run import Case, Looks, Outcome, lean, told
from rustchain.sweeps.cases import Parameters, cases_of, check_columns, dims_of, seconds_of
from rustchain.sweeps.measure import NameTaken, check_measure, check_names_of
from rustchain.sweeps.result import OF_TABLES, SweepResult
from rustchain.sweeps.running import (
    DaskClient,
    check_executor,
    number_of_threads,
    run_here,
    run_on,
)
from rustchain.sweeps.store import Measured, Store, StoredResults
from rustchain.typing import Count, FilePath, Number

if TYPE_CHECKING:
    from concurrent.futures import Executor


@known_keywords
def sweep(
    scene: System,
    axes: Mapping[Any, Iterable[Any]] | Sequence[Mapping[str, Any]],
    measure: Callable[[Result], Any] | None = None,
    *,
    duration: Number = 2.0,
    report_step: Number = 1e-4,
    record: Sequence[Group] | None = None,
    energy: bool | None = None,
    stop: StopCondition | Sequence[StopCondition] = (),
    callback: Callable[[Simulation], object] | None = None,
    threads: Count | None = None,
    executor: Executor | DaskClient | None = None,
    store: FilePath | None = None,
    retry: bool = False,
    progress: bool = True,
) -> SweepResult:
    """Run a scene with other parameters again and again, several runs at once.

    Each case runs on one thread; its numbers are those of ``Simulation(...).run(...)`` to the last
    bit, whatever the number of threads and the executor. A case that fails leaves the others alone.

    What a parameter may be called:

    - an argument of `scene`, where that is a function: it goes there, before all else;
    - "pretension" [N]: makes, changes or (0 N or None) removes the tensioner; "speed" [rad/s]: that
      of the driver;
    - "replicate": a seed; every sprocket without a prescribed speed, and every body of a mechanism
      that moves, starts at random up to 1e-4 of its speed faster or slower, a sprocket below 0.1
      rad/s up to 1e-5 rad/s; 0: none does;
    - a field of the scene, such as "solver", or of what is in it, dotted: "force_law.friction",
      "solver.rtol"; a field of the solver alone, such as "rtol", too;
    - an argument of the run: "duration", "report_step", "record", "energy";
    - a field of the drive, dotted: "chain.material.restitution", "sprockets.1.teeth". Sprockets,
      guides, ends and coordinates are numbered from 1, as everywhere in names: "sprockets.1" is
      what ``result.sprocket(1)`` shows. "chain" takes a name of the catalogue, too, such as
      "ISO 08B", with the present number of links. No other field follows: with other teeth, centre
      distance or links may have to change as well, which a function does best;
    - a field of the mechanism, dotted: "bodies.1.mass", "joints.2.motion", "forces.1.stiffness",
      "contacts.1.law.friction". Parts are numbered in the order in which they were added.

    Parameters
    ----------
    scene : Scene, ChainDrive or Mechanism, or function that returns one
        What to simulate.
    axes : mapping of str or tuple of str to sequence, or sequence of mappings
        Values of each parameter, all of which are combined; or the parameters of each case. With a
        tuple of names the values are rows, whose parameters vary together: paired lists, samples
        (see `samples`), or an array of `scipy.stats.qmc`.
    measure : function of a Result, optional
        Returns what to keep of a case: a number, an array, or a dict of them. It is called in the
        thread that called `sweep`, for one case at a time, while others go on running; with an
        executor, where the case has run. By default the results themselves are kept, which takes
        memory for all of them, unless there is a store.
    duration : float
        Simulated time [s].
    report_step, record, energy
        As in `Simulation.run`.
    stop, callback
        As in `Simulation.run`, for each case: one that a condition stops counts as finished, with
        that status. A callback is called in the thread of its case, several at once.
    threads : int, optional
        How many cases run at once; by default as many as there are cores that this process may use.
    executor : Executor or Client of Dask, optional
        Where the cases run: an executor of `concurrent.futures`, loky or `mpi4py.futures`, or
        ``dask.distributed.Client(...)``. It stays open. By default threads of this process.
    store : str or Path, optional
        A folder with the result of each case, failed ones too, in a netCDF file each. Stored cases
        of the same scene, run, stop conditions and functions, by the same version of rustchain, are
        not run again: an interrupted sweep continues. Several sweeps may use a folder at once. Of
        functions, code and the numbers, functions and classes that it refers to count, but not the
        code of installed packages. What is measured must then be numbers, arrays, or a dict of
        them; without `measure`, results are read from the folder when they are accessed.
        `load_sweep` reads all cases of a folder.
    retry : bool
        Whether cases that are stored as failed are run again.
    progress : bool
        Whether to show a progress bar. Without a terminal, lines on the standard error tell the
        progress: one in 30 s at most, and one for each hundredth at most.

    Returns
    -------
    SweepResult
        After Ctrl-C with status "interrupted" and the cases that had finished. An exception that
        ends the sweep, and a warning that is raised as an error, have it as ``result``.

    Raises
    ------
    InvalidInput
        A parameter is not known, no case has values that are allowed, or a store cannot tell
        whether a function is the same. A measured name is that of a parameter, "error", "case",
        another measured name as text, or a number of a measured array. A parameter has the name of
        another column or dimension of the tables.
    OSError
        The store cannot be written.

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

    Examples
    --------
    >>> found = rc.sweep(
    ...     rc.paper_drive(),
    ...     {"pretension": [25, 50]},
    ...     lambda result: {"rows": len(result.time)},
    ...     duration=1e-3,
    ...     progress=False,
    ... )
    >>> [value["rows"] for value in found.values]
    [11, 11]
    """
    run: Parameters = {
        "duration": plain(duration),
        "report_step": plain(report_step),
        "record": read_once(record),
        "energy": energy,
    }
    grid, cases = cases_of(axes)
    check_measure(measure)
    check_truth("progress", progress)
    check_truth("retry", retry)
    check_names(scene, run, cases)
    rows = () if grid is None else (d for axis, d in dims_of(grid).items() if d != axis)
    check_columns(dict.fromkeys(name for case in cases for name in case), {*OF_TABLES, *rows})
    looks = Looks(stop, callback, len(check_looks(stop, callback)) > 0 or callback is not None)
    if threads is not None:
        threads = number_of_threads(threads)
    if executor is not None:
        check_executor(executor)
        if threads is not None:
            msg = f"threads = {threads}: is for executor=None; an executor has its own workers"
            raise InvalidInput(msg)

    kept = None
    found = SweepResult(cases, grid, [None] * len(cases), _measured=measure is not None)
    if store is not None:
        kept = Store(store, measure, looks, retry)
        measure = None if measure is None else Measured(measure)
        if measure is None:
            found.values = StoredResults([None] * len(cases))
    sweep = _Sweep(found, kept)
    total = sum(seconds_of(run | case) for case in cases)
    try:
        with seconds_bar(total, progress, f"0 of {len(cases)} cases") as bar:
            todo = sweep.todo(scene, run, bar)
            running = (
                run_here(todo, looks, measure, threads, bar)
                if executor is None
                else run_on(executor, todo, looks, measure, bar)
            )
            with closing(running):
                for case, outcome in running:
                    sweep.take(case, outcome)
                    sweep.tell(bar)
    except KeyboardInterrupt:
        found.status = "interrupted"
    except BaseException as error:
        found.status = "interrupted"
        attach(error, "result", found)
        raise
    finally:
        for name in ("errors", "law_warnings", "energy_warnings", "jump_warnings"):
            setattr(found, name, dict(sorted(getattr(found, name).items())))
    if len(sweep.unmade) == len(cases):
        raise found.errors[0]
    try:
        _warn(found)
    except Warning as warning:
        attach(warning, "result", found)
        raise
    return found


class _Sweep:
    """A sweep under way: what has come of its cases, and where that is stored."""

    def __init__(self, found: SweepResult, store: Store | None) -> None:
        self.found = found
        self.unmade: set[int] = set()
        self._taken = found._taken()
        self._store = store
        self._paths: dict[int, Path] = {}

    def todo(self, scene: System, run: Parameters, bar: Bar) -> Iterator[Case]:
        """Yield, one at a time, the cases that are neither refused nor stored."""
        for number, parameters in enumerate(self.found.cases):
            try:
                case = Case(number, *case_of(scene, run, parameters))
                if self._store is not None:
                    self._paths[number] = self._store.path(case)
                stored = None if self._store is None else self._store.get(self._paths[number])
            except Exception as error:  # a function of the user's may raise anything
                stored = Outcome(error=lean(error), made=False)
            if stored is None:
                yield case
            else:
                self._check_names(stored)
                self._keep(number, stored)
                bar.total -= seconds_of(run | parameters)
                self.tell(bar)

    def take(self, case: Case, outcome: Outcome) -> None:
        """Take the outcome of a case; store it, unless it is the executor that failed."""
        self._check_names(outcome)
        if self._store is not None and outcome.made:
            parameters = self.found.cases[case.number]
            self._store.put(self._paths[case.number], case, outcome, parameters)
        self._keep(case.number, outcome)

    def _check_names(self, outcome: Outcome) -> None:
        """End the sweep where a measured name is taken: it would be so in every case."""
        if isinstance(outcome.error, NameTaken):
            raise outcome.error
        if outcome.error is None and self.found._measured:
            check_names_of(outcome.value, self._taken)

    def _keep(self, number: int, outcome: Outcome) -> None:
        found = self.found
        if not outcome.made:
            self.unmade.add(number)
        if outcome.error is not None:
            if self._store is not None:  # which has what memory need not hold
                attach(outcome.error, "__traceback__", None)
                if hasattr(outcome.error, "result"):
                    attach(outcome.error, "result", None)
            # What add_note does, which Python 3.10 lacks.
            notes = getattr(outcome.error, "__notes__", ())
            note = f"in {_name(found, number)} of the sweep"
            attach(outcome.error, "__notes__", [*notes, note])
        elif isinstance(found.values, StoredResults):
            found.values.paths[number] = self._paths[number]
        else:
            found.values[number] = outcome.value
        found._end(number, outcome.notes, outcome.error)

    def tell(self, bar: Bar) -> None:
        """Show how many cases have ended and how many have failed."""
        done, failed = len(self.found._ended), len(self.found.errors)
        text = f"{done + failed} of {len(self.found.cases)} cases"
        bar.set_description(f"{text}, {failed} failed" if failed else text)


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
        warn_caller(f"{which}: {told(error)}", CaseWarning)
    for notes, category in (
        (found.law_warnings, RangeWarning),
        (found.energy_warnings, EnergyWarning),
        (found.jump_warnings, ToothJumpWarning),
    ):
        for number, lines in list(notes.items())[:1]:
            which = f"{len(notes)} of {len(found.cases)} cases, first {_name(found, number)}"
            warn_caller(f"{which}: {'; '.join(lines)}", category)
