"""Results of the cases of a sweep: values, errors, and tables of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from rustchain.analysis.summary import Summary
from rustchain.arguments import shown
from rustchain.caller import warn_caller
from rustchain.description.base import Description
from rustchain.errors import NotRecorded
from rustchain.html import HtmlView
from rustchain.names import named_attributes
from rustchain.results.result import Result
from rustchain.results.values import ArrayValue
from rustchain.sweeps.case_run import Notes, told
from rustchain.sweeps.cases import Axes, Parameters, dims_of, names_of
from rustchain.sweeps.measure import array_of, check_distinct, check_names_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_Values: TypeAlias = npt.NDArray[Any]

OF_TABLES = ("error", "case")
"""Columns of `SweepResult.to_pandas` beside parameters and measured numbers."""


@named_attributes
@dataclass(eq=False, repr=False)
class SweepResult(ArrayValue, HtmlView):
    """Results of the cases of a sweep, in the order of the cases.

    Two of them are equal (``==``) where cases, values and warnings are, to the last bit, and errors
    by class and text. Wall times do not count.

    The cases of a grid are ordered as in nested loops, the last axis changing fastest.

    Attributes
    ----------
    cases : list of dict
        The parameters of each case.
    axes : dict of tuple, or None
        The axes of the grid; None where the cases were listed.
    values : sequence
        The measured quantity of each case, or its Result without `measure`; None for a case that
        failed or did not end before Ctrl-C. With a store, results are read when they are accessed.
    errors : dict of Exception
        Errors by the number of the case, from 0. The error of a run that could not continue has its
        rows until then in ``error.result``, unless there is a store.
    law_warnings : dict of list of str
        Which laws left their range, by the number of the case.
    energy_warnings : dict of list of str
        Where the energy balance does not close, by the number of the case.
    jump_warnings : dict of list of str
        How many teeth the chain jumped, by the number of the case.
    status : {"finished", "interrupted"}
        How the sweep ended.

    Examples
    --------
    >>> swept = rc.sweep(
    ...     rc.paper_drive(),
    ...     {"pretension": [0.0, 25.0]},
    ...     lambda result: result.time.size,
    ...     duration=1e-3,
    ...     progress=False,
    ... )
    >>> swept.cases, list(swept.values)
    ([{'pretension': 0.0}, {'pretension': 25.0}], [11, 11])
    """

    cases: list[Parameters]
    axes: Axes | None
    values: Any
    errors: dict[int, Exception] = field(default_factory=dict)
    law_warnings: dict[int, list[str]] = field(default_factory=dict)
    energy_warnings: dict[int, list[str]] = field(default_factory=dict)
    jump_warnings: dict[int, list[str]] = field(default_factory=dict)
    status: Literal["finished", "interrupted"] = "finished"
    _measured: bool = True
    _ended: set[int] = field(default_factory=set)

    def __repr__(self) -> str:
        """Return how the sweep ended."""
        return f"<SweepResult: {self.message}>"

    @property
    def success(self) -> bool:
        """True if every case reached its end and was measured."""
        return self.status == "finished" and not self.errors

    @property
    def message(self) -> str:
        """Message on the end of the sweep."""
        fate = f"{self.finished} of {len(self.cases)} cases finished, {len(self.errors)} failed"
        return fate if self.status == "finished" else f"interrupted: {fate}"

    @property
    def finished(self) -> int:
        """Number of cases that reached their end and were measured."""
        return len(self._ended)

    @property
    def results(self) -> Sequence[Result | None]:
        """The Result of each case, where nothing was to be measured."""
        if self._measured:
            msg = "the results were measured and let go; call sweep without measure to keep them"
            raise NotRecorded(msg)
        found: Sequence[Result | None] = self.values
        return found

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the cases in `to_xarray`: of each axis, or "case" for listed cases.

        Parameters that vary together have the dimension "sample".
        """
        return ("case",) if self.axes is None else tuple(dims_of(self.axes).values())

    def to_xarray(self) -> xr.Dataset:
        """Return the measured values, NaN where a case has none.

        The dimensions are those of the cases, `dims`, then those of an array that was measured:
        ``value_0``, ``value_1``. The variables are the keys of a measured dict, or "value"; those
        of `Result.summary` have units. Where cases have arrays of different shapes, NaN follows the
        shorter ones, with a warning.
        """
        from rustchain.extras import xarray as xr

        shape: tuple[int, ...] = (len(self.cases),)
        coordinates = {n: ("case", _labels(values)) for n, values in self._columns().items()}
        if self.axes is not None:
            shape = tuple(map(len, self.axes.values()))
            coordinates = {}
            for (axis, rows), dim in zip(self.axes.items(), self.dims, strict=True):
                columns = zip(*rows, strict=True) if isinstance(axis, tuple) else [rows]
                for n, column in zip(names_of(axis), columns, strict=True):
                    coordinates[n] = (dim, _labels(tuple(column)))
        arrays, variables = self._arrays(), {}
        summaries = [value.units for value in self.values if isinstance(value, Summary)]
        units = {name: unit for each in summaries for name, unit in each.items()}
        for name, values in arrays.items():
            own = tuple(f"{name}_{k}" for k in range(values.ndim - 1))
            attributes = {"units": units[name]} if name in units else {}
            shaped = values.reshape(shape + values.shape[1:])
            variables[name] = ((*self.dims, *own), shaped, attributes)
        return xr.Dataset(variables, coordinates, {"status": self.status, "message": self.message})

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each case and a column for each parameter and each measured number.

        The numbers of an array have their place in the name: ``value_0``, ``value_1``. Where cases
        have failed, the column "error" has the reason.
        """
        from rustchain.extras import pandas as pd

        columns: dict[str, _Values] = {n: _labels(values) for n, values in self._columns().items()}
        for name, values in self._arrays().items():
            for place in np.ndindex(values.shape[1:]):
                label = "_".join(map(str, (name, *place)))
                columns[label] = values[(slice(None), *place)]
        table = pd.DataFrame(columns, index=pd.RangeIndex(len(self.cases), name="case"))
        if self.errors:
            table["error"] = pd.Series({n: told(error) for n, error in self.errors.items()})
        return table

    def _end(self, number: int, notes: Notes, error: Exception | None) -> None:
        """Keep how a case ended: what there was to warn of, and its error, if there is one."""
        kinds = (self.law_warnings, self.energy_warnings, self.jump_warnings)
        for kind, lines in zip(kinds, notes, strict=True):
            if lines:
                kind[number] = lines
        if error is None:
            self._ended.add(number)
        else:
            self.errors[number] = error

    def _taken(self) -> set[str]:
        """Return the names that no measured quantity may have."""
        return {*OF_TABLES, *self.dims, *(name for case in self.cases for name in case)}

    def _columns(self) -> dict[str, list[Any]]:
        """Return each parameter over the cases."""
        names = dict.fromkeys(name for case in self.cases for name in case)
        return {name: [case.get(name) for case in self.cases] for name in names}

    def _arrays(self) -> dict[str, _Values]:
        """Return each measured quantity over the cases, (cases, ...)."""
        if not self._measured:
            msg = "nothing was measured; call sweep with measure=..., or use .results"
            raise NotRecorded(msg)
        rows = [value if isinstance(value, Mapping) else {"value": value} for value in self.values]
        names = dict.fromkeys(
            n
            for row, value in zip(rows, self.values, strict=True)
            if value is not None
            for n in row
        )
        check_distinct(names)
        arrays = {str(n): _stacked(str(n), [row.get(n) for row in rows]) for n in names}
        check_names_of({name: array[0] for name, array in arrays.items()}, self._taken())
        return arrays


def _stacked(name: str, values: Sequence[Any]) -> _Values:
    """Return the measured values of all cases as one array, NaN where there are none.

    Arrays of another shape stand at the beginning of one that holds each of them.
    """
    arrays = [None if value is None else array_of(name, value) for value in values]
    there = [array for array in arrays if array is not None]
    shapes = sorted({array.shape for array in there})
    if not there:
        return np.full(len(values), nan)
    if len(shapes) > 1:
        warn_caller(
            f"measure: {shown(name)} has shape {shapes[0]} in one case and {shapes[1]} in another: "
            "NaN fills the table; .values has them as they are"
        )
    depth = max(map(len, shapes))
    whole = tuple(np.max([(*shape, *(depth - len(shape)) * (1,)) for shape in shapes], axis=0))
    kind: npt.DTypeLike = np.result_type(*there)
    gaps = len(there) < len(values) or len(shapes) > 1
    numbers = np.issubdtype(kind, np.number) or np.issubdtype(kind, np.bool_)
    if gaps:
        kind = np.result_type(kind, np.float64) if numbers else object
    stacked = np.empty((len(values), *whole), kind)
    if gaps:
        stacked[...] = nan if numbers else None
    for place, array in enumerate(arrays):
        if array is not None:
            inside: tuple[Any, ...] = (*map(slice, array.shape), *(depth - array.ndim) * (0,))
            stacked[(place, *inside)] = array
    return stacked


def _labels(values: Sequence[Any]) -> _Values:
    """Return the values of a parameter as numbers where they are, else as words."""
    given = [value for value in values if value is not None]
    if all(isinstance(value, int | float) for value in given):
        return np.array([nan if value is None else value for value in values])
    types = {value: type(value).__name__ for value in given if isinstance(value, Description)}
    unique = len(set(types.values())) == len(types)

    def label(value: object) -> str:
        if unique and isinstance(value, Description):
            return types[value]
        return value if isinstance(value, str) else repr(value)

    return np.array(list(map(label, values)))
