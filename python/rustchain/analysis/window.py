"""A part of the time of a result: its rows, and a result of them alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.errors import InvalidInput
from rustchain.results.stored import part_of
from rustchain.typing import Array, Number, Time

if TYPE_CHECKING:
    from rustchain.results.result import Result


_ROUNDING = 1e-12
_DIFFERENCE = 16.0 * float(np.finfo(float).eps)  # of its operands: a smaller one is rounding
_LEVELS = ("energy_kinetic", "energy_gravity", "energy_elastic")  # all other energies are sums


def rows_between(result: Result, start: Time, end: Time) -> slice:
    """Return the rows from `start` to `end` [s]."""
    time = result.time
    first = 0 if start is None else first_row(time, start)
    last = len(time)
    if end is not None:
        last = int(np.searchsorted(time, end + _ROUNDING * abs(float(end)), "right"))
    if start is not None and end is not None and start > end:
        msg = f"start={start}, end={end}: start is after end; expected an end at or after the start"
        raise InvalidInput(msg)
    if first >= last:
        span = f"{time[0]:g} to {time[-1]:g} s"
        msg = f"start={start}, end={end}: no rows there; the result has {span}"
        raise InvalidInput(msg)
    return slice(first, last)


def first_row(time: Array, start: Number) -> int:
    """Return the first row from `start` [s] on; times of rows are multiples to rounding."""
    return int(np.searchsorted(time, start - _ROUNDING * abs(float(start))))


def mean_over_time(time: Array, values: Array) -> Array:
    """Return the mean of `values`, (times, ...), over time, by the trapezoidal rule.

    Of one row, its values.
    """
    if len(time) < 2:
        only: Array = values[0]
        return only
    steps = np.diff(time).reshape(-1, *(1,) * (values.ndim - 1))
    mean: Array = (steps * (values[1:] + values[:-1]) / 2.0).sum(axis=0) / (time[-1] - time[0])
    return mean


def check_finite(where: str, values: Array) -> None:
    """Refuse NaN and infinities, which have no spectrum."""
    wrong = values[~np.isfinite(values)]
    if wrong.size:
        msg = (
            f"{where}: {wrong.size} of {values.size} values are no finite numbers, such as "
            f"{wrong[0]:g}; take rows without them, and of contacts a force"
        )
        raise InvalidInput(msg)


def difference_or_zero(difference: Array, *operands: Array) -> Array:
    """Return a difference over time, or zeros where all of it is within the operands' rounding."""
    size = sum(float(np.abs(each).max(initial=0.0)) for each in operands)
    below = float(np.abs(difference).max(initial=0.0)) <= _DIFFERENCE * size
    return np.zeros_like(difference) if below else difference


def between(result: Result, /, start: Time = None, end: Time = None) -> Result:
    """Return the part of the result from `start` to `end` [s], as a result.

    Energy dissipated, external work, losses and residual count from the first row of the part, and
    so do peaks and impulses. States at ends that were not recorded are NaN. ``stats`` are those of
    the whole run. Of a result in a streamed file, these rows alone are read; the part is in memory.
    """
    rows = rows_between(result, start, end)
    arrays = {name: part_of(result.arrays, name, rows) for name in result.arrays}
    arrays = from_first_row(arrays, rows)
    ends = {}
    for name, row, whole in (
        ("initial", rows.start, 0),
        ("final", rows.stop - 1, len(result.time) - 1),
    ):
        for quantity in ("positions", "velocities"):
            at_end = getattr(result, f"{name}_{quantity}")
            if row != whole:
                recorded = arrays.get(quantity)
                place = row - rows.start
                at_end = np.full_like(at_end, np.nan) if recorded is None else recorded[place]
            ends[f"{name}_{quantity}"] = at_end
    return replace(result, arrays=arrays, **ends)


def from_first_row(
    arrays: Mapping[str, npt.NDArray[Any]], rows: slice
) -> dict[str, npt.NDArray[Any]]:
    """Return these rows of arrays with sums and peaks from the first of them on, as of a run."""
    found = dict(arrays)
    if rows.start == 0:
        return found
    for name, values in arrays.items():
        if name.startswith("energy_") and name not in _LEVELS:
            found[name] = values - values[0]
        elif name.startswith("peak_") or name == "contact_impact_velocity":
            found[name] = values.copy()
            found[name][0] = 0.0
    for name in ("hinge_force", "tooth_force", "roller_force", "contact_force"):
        if {name, f"peak_{name}"} <= arrays.keys():
            found[f"peak_{name}"][0] = arrays[name][0]
    if {"joint_reaction", "peak_joint_force"} <= arrays.keys():
        found["peak_joint_force"][0] = np.hypot(*arrays["joint_reaction"][0, :, :2].T)
    return found


def start_positions(result: Result) -> Array:
    """Return the positions of the bodies at the start of the simulation, (bodies, 3)."""
    scene = result.scene
    if result.time[0] == 0.0:
        return result.initial_positions
    if scene.start == "static":
        found: Array = _rustchain.static_start(scene)["positions"]
        return found
    if scene.positions is not None:
        return np.array(scene.positions)
    return _rustchain.Core(scene, None, None).positions
