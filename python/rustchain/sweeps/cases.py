"""The cases of a sweep: all combinations of axes, or a list."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, TypeAlias

from rustchain.arguments import count_within, finite_number, items_within, plain, shown
from rustchain.errors import InvalidInput

Parameters: TypeAlias = dict[str, Any]
AxisName: TypeAlias = str | tuple[str, ...]
Axes: TypeAlias = dict[AxisName, tuple[Any, ...]]

MOST_CASES = 100_000  # the parameters of all of them are in memory, some hundred bytes each


def axes_of(axes: Mapping[Any, Iterable[Any]]) -> Axes:
    """Return the values of each axis as a tuple; of names that vary together, rows of values."""
    found: Axes = {}
    for name, values in axes.items():
        where = f"axes[{shown(name)}]"
        listed = items_within(where, values, MOST_CASES)
        if listed is None:
            msg = f"{where} = {shown(values)}: must be a sequence of values, one for each case"
            raise InvalidInput(msg)
        found[name] = tuple(map(_read_once, listed))
        if not found[name]:
            msg = f"{where} = {shown(values)}: must hold at least one value"
            raise InvalidInput(msg)
        if isinstance(name, tuple):
            _check_rows(where, name, found[name])
            found[name] = tuple(tuple(map(_read_once, row)) for row in found[name])
    names = [each for name in found for each in names_of(name)]
    twice = first_twice(names)
    if twice is not None:
        msg = f"axes: {shown(twice)} is there twice, on two axes"
        raise InvalidInput(msg)
    return found


def _read_once(value: Any) -> Any:  # noqa: ANN401
    """Return a value as a case has it; the items of an iterator, which several cases share."""
    items = items_within("axes", value, MOST_CASES) if isinstance(value, Iterator) else None
    return plain(value if items is None else items)


def _check_rows(where: str, names: tuple[str, ...], rows: tuple[Any, ...]) -> None:
    """Refuse rows of names that vary together, where one has not a value for each name."""
    for row in rows:
        if not isinstance(row, tuple) or len(row) != len(names) or not names:
            msg = f"{where}: got the row {shown(row)}; expected {len(names)} values, one for each"
            raise InvalidInput(f"{msg} of the names")


def first_twice(names: Sequence[str]) -> str | None:
    """Return the first of the names that is there more than once, or None."""
    return next((name for name in names if names.count(name) > 1), None)


def seconds_of(parameters: Parameters) -> float:
    """Return the simulated time of a case [s]; 0 where it is no number, which the run refuses."""
    return finite_number(parameters["duration"]) or 0.0


def names_of(axis: AxisName) -> tuple[str, ...]:
    """Return the parameters that an axis varies."""
    return axis if isinstance(axis, tuple) else (axis,)


def dims_of(axes: Axes) -> dict[AxisName, str]:
    """Return the dimension of each axis: its name, or "sample" where names vary together.

    A second such axis is "sample_2".
    """
    found: dict[AxisName, str] = {}
    together = 0
    for axis in axes:
        together += isinstance(axis, tuple)
        of_rows = "sample" if together == 1 else f"sample_{together}"
        found[axis] = of_rows if isinstance(axis, tuple) else axis
    return found


def check_columns(names: Iterable[str], taken: Collection[str]) -> None:
    """Refuse parameters with a name that the tables of a sweep or a study use for something else.

    Only arguments of a function can have such a name.
    """
    for name in names:
        if name in taken:
            msg = (
                f"axes: {shown(name)} is the name of another column or dimension of the tables; "
                f"expected another than {', '.join(sorted(map(shown, taken)))}; rename the "
                "argument of the function"
            )
            raise InvalidInput(msg)


def cases_of(axes: object) -> tuple[Axes | None, list[Parameters]]:
    """Return the axes, None where cases are listed, and the parameters of each case."""
    if isinstance(axes, Mapping):
        grid = axes_of(axes)
        count_within("cases of the sweep", math.prod(map(len, grid.values())), 1, MOST_CASES)
        return grid, [_parameters(grid, values) for values in product(*grid.values())]
    listed = items_within("axes", axes, MOST_CASES) or []
    if not listed or not all(isinstance(case, Mapping) for case in listed):
        msg = (
            f"axes = {shown(axes)}: must map names to sequences of values, "
            "or be a list with a mapping of names to values for each case; of a DataFrame take "
            ".to_dict('records')"
        )
        raise InvalidInput(msg)
    return None, [{name: _read_once(value) for name, value in case.items()} for case in listed]


def check_burn_in(burn_in: object, duration: object, cases: Iterable[Parameters]) -> None:
    """Refuse a time that is not measured [s] of which a case leaves nothing.

    Durations that are no positive numbers are refused elsewhere.
    """
    durations = (finite_number(case.get("duration", duration)) for case in cases)
    shortest = min((each for each in durations if each is not None and each > 0), default=math.inf)
    value = finite_number(burn_in)
    if value is None or not 0.0 <= value < shortest:
        msg = (
            f"burn_in = {shown(burn_in)}: must be from 0 to less than the duration, {shortest:g} s"
        )
        raise InvalidInput(msg)


def _parameters(axes: Axes, values: tuple[Any, ...]) -> Parameters:
    """Return the parameters of the case at a place of the grid."""
    found: Parameters = {}
    for axis, value in zip(axes, values, strict=True):
        found |= zip(axis, value, strict=True) if isinstance(axis, tuple) else {axis: value}
    return found
