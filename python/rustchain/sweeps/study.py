"""A study: replicate runs of a scene from slightly different starts, and their statistics."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from rustchain.arguments import count_within, finite_number, plain, shown
from rustchain.errors import InvalidInput, NotRecorded
from rustchain.html import HtmlView
from rustchain.names import known_keywords, named_attributes
from rustchain.results.result import Result
from rustchain.results.values import ArrayValue
from rustchain.simulation.run import Group
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import StopCondition
from rustchain.sweeps.axes import System
from rustchain.sweeps.cases import (
    MOST_CASES,
    axes_of,
    cases_of,
    check_burn_in,
    check_columns,
    names_of,
)
from rustchain.sweeps.measure import check_measure, numbers_of
from rustchain.sweeps.result import SweepResult
from rustchain.sweeps.running import DaskClient
from rustchain.sweeps.sweep import sweep
from rustchain.typing import Count, FilePath, Number

if TYPE_CHECKING:
    from concurrent.futures import Executor

    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

_OF_TABLES = ("run", "statistic", "measure")  # columns and dimensions of the tables
_STATISTICS = ("mean", "std", "low", "high", "count")


@named_attributes
@dataclass(frozen=True, eq=False, repr=False)
class StudyResult(ArrayValue, HtmlView):
    """Results of several runs of each case; equal (``==``) if the runs are.

    Attributes
    ----------
    sweep : SweepResult
        The runs, with their errors and notes.
    confidence : float
        That the interval of a mean holds the true one.
    burn_in : float
        Simulated time that was not measured [s].

    Examples
    --------
    >>> found = rc.study(
    ...     rc.paper_drive(),
    ...     lambda result: result.peaks.hinge_force.max(),
    ...     runs=2,
    ...     duration=2e-3,
    ...     burn_in=1e-3,
    ...     progress=False,
    ... )
    >>> found.confidence, found.burn_in
    (0.95, 0.001)
    """

    sweep: SweepResult
    confidence: float
    burn_in: float

    def __repr__(self) -> str:
        """Return how the runs ended."""
        return f"<StudyResult: {self.sweep.message}>"

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the cases in `statistics`; `samples` has "run", too."""
        return tuple(dim for dim in self.sweep.dims if dim != "replicate")

    @property
    def samples(self) -> xr.Dataset:
        """Measured values of every run: the axes, then "run", then the dimensions of an array."""
        if self.sweep.errors and all(value is None for value in self.sweep.values):
            number, error = next(iter(self.sweep.errors.items()))
            msg = f"no run has a value; the first error, of run {number}: {shown(error)}"
            raise NotRecorded(msg)
        return self.sweep.to_xarray().rename(replicate="run")

    @property
    def statistics(self) -> xr.Dataset:
        """Statistics over the runs, along "statistic".

        "mean", "std" of a run, "low" and "high" ends of the mean's confidence interval, "count" of
        the runs that have a value. The interval is Student's: of runs that are independent, which
        chaos makes of different starts within some milliseconds.
        """
        from rustchain.extras import pandas as pd
        from rustchain.extras import stats
        from rustchain.extras import xarray as xr

        samples = self.samples
        count = samples.count("run")
        mean, spread = samples.mean("run"), samples.std("run", ddof=1)
        level = 0.5 + 0.5 * self.confidence
        factors = count.map(lambda n: n.copy(data=stats.t.ppf(level, np.maximum(n - 1, 1))))
        half = factors * spread / np.sqrt(count)
        statistic = pd.Index(_STATISTICS, name="statistic")
        found = xr.concat([mean, spread, mean - half, mean + half, count], statistic)
        return found.transpose(..., "statistic").assign_attrs(
            confidence=self.confidence, burn_in=self.burn_in
        )

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each case and measure, and a column for each statistic.

        The numbers of an array have their place in the name: ``value_0``, ``value_1``.
        """
        from rustchain.extras import pandas as pd

        statistics = self.statistics
        labels, rows = [], [np.empty((0, len(_STATISTICS)))]
        for name, found in statistics.items():
            own = [dim for dim in found.dims if dim not in (*self.dims, "statistic")]
            values = found.transpose(*own, *self.dims, "statistic")
            labels += ["_".join(map(str, (name, *k))) for k in np.ndindex(values.shape[: len(own)])]
            rows.append(values.to_numpy().reshape(-1, len(_STATISTICS)))
        index = pd.Index(labels, name="measure")
        if self.dims:
            # Parameters that vary together are no index of rows.
            cases = [statistics[dim].to_numpy() for dim in self.dims]
            index = pd.MultiIndex.from_product([labels, *cases], names=["measure", *self.dims])
        columns = pd.Index(_STATISTICS, name="statistic")
        return pd.DataFrame(np.concatenate(rows), index, columns)

    @known_keywords
    def plot(self, *measures: str) -> Figure:
        """Draw measures with their confidence intervals and all runs, over the first axis.

        A row of numbers is drawn over its places, a panel for each case. By default all numbers are
        drawn; where there is none, all rows.
        """
        from rustchain.plot.studies import draw_study

        return draw_study(self, measures)


@known_keywords
def study(
    scene: System,
    measure: Callable[[Result], Any] | None = None,
    *,
    runs: Count = 8,
    duration: Number = 0.5,
    burn_in: Number = 0.1,
    confidence: Number = 0.95,
    axes: Mapping[Any, Iterable[Any]] | None = None,
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
) -> StudyResult:
    """Run replicates of a scene from slightly different starts, and return their statistics.

    A slack chain is chaotic: two runs whose starts differ by rounding take different paths after
    some milliseconds, and one run is one sample. The first run is the scene without changes. In the
    others the initial speeds differ by up to 1e-4 of themselves: of every sprocket without a
    prescribed speed, and of every moving body of a mechanism. Those of sprockets at rest, or slower
    than 0.1 rad/s, differ by up to 1e-5 rad/s, also with ``start="static"``. The change depends on
    the number of the run only, so that a study is reproducible.

    Parameters
    ----------
    scene : Scene, ChainDrive or Mechanism, or function that returns one
        What to simulate.
    measure : function of a Result, optional
        Returns the measured quantity of a run: a number, an array, or a dict of them, NaN or None
        where a run has none. The result that is passed begins after `burn_in` (its ``stats`` are
        those of the whole run). By default `Result.summary`.
    runs : int
        How many runs, 2 to 100,000.
    duration : float
        Simulated time of each [s].
    burn_in : float
        Simulated time at the beginning that is not measured [s]: a tensioner's ramp, and the decay
        of what the start stirred up.
    confidence : float
        Of the interval of each mean, between 0 and 1.
    axes : mapping of str or tuple of str to sequence, optional
        Parameters as in `sweep`, all of which are combined; each combination is run `runs` times.
    report_step, record, energy
        As in `Simulation.run`.
    threads, executor, store, retry, progress, stop, callback
        As in `sweep`. A run that is stopped is measured as far as it came.

    Returns
    -------
    StudyResult
        Its ``statistics`` hold mean, confidence interval and spread of every measure.

    Raises
    ------
    InvalidInput
        A number is out of its range, or a parameter is not known.

    Examples
    --------
    >>> found = rc.study(
    ...     rc.paper_drive(25.0),
    ...     lambda result: {"peak": result.peaks.tooth_force.max()},
    ...     runs=2,
    ...     duration=2e-3,
    ...     burn_in=1e-3,
    ...     progress=False,
    ... )
    >>> type(found).__name__
    'StudyResult'
    """
    axes = {} if axes is None else axes
    runs = count_within("runs", runs, 2, MOST_CASES)  # one has no spread
    check_measure(measure)
    duration, burn_in, confidence = map(plain, (duration, burn_in, confidence))
    for name, value in (("duration", duration), ("burn_in", burn_in), ("confidence", confidence)):
        if isinstance(value, bool) or not isinstance(value, float | int):
            msg = f"{name} = {shown(value)}: must be a number"
            raise InvalidInput(msg)
    if finite_number(duration) is None or duration <= 0.0:
        msg = f"duration = {shown(duration)}: must be a positive number of seconds"
        raise InvalidInput(msg)
    if not 0.0 < confidence < 1.0:
        msg = f"confidence = {shown(confidence)}: must lie between 0 and 1"
        raise InvalidInput(msg)
    if not isinstance(axes, Mapping):
        msg = f"axes = {shown(axes)}: must map names to sequences of values"
        raise InvalidInput(msg)
    grid = axes_of(axes)
    names = [name for axis in grid for name in names_of(axis)]
    if "replicate" in names:
        msg = "axes: 'replicate' is what makes the runs of a study; say how many by runs=..."
        raise InvalidInput(msg)
    if callable(scene):  # drives and mechanisms have no parameters of these names
        check_columns(names, _OF_TABLES)
    check_burn_in(burn_in, duration, cases_of(grid)[1])
    found = sweep(
        scene,
        {**grid, "replicate": range(runs)},
        partial(_numbers, of=measure, burn_in=burn_in),
        duration=duration,
        report_step=report_step,
        record=record,
        energy=energy,
        threads=threads,
        executor=executor,
        store=store,
        retry=retry,
        progress=progress,
        stop=stop,
        callback=callback,
    )
    return StudyResult(found, float(confidence), float(burn_in))


def _numbers(
    result: Result, *, of: Callable[[Result], Any] | None, burn_in: Number
) -> dict[str, Any]:
    """Return the measured values of a run after the burn-in [s].

    The sweep refuses names of parameters. As arguments of this function they would be part of a
    stored case's identity: with a further axis, all cases would run again.
    """
    if of is None:
        return numbers_of(result.summary(start=burn_in), _OF_TABLES)
    return numbers_of(of(result.between(start=burn_in)), _OF_TABLES)
