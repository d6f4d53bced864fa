"""Bodies and forces between the rows of a result, as animations and the player show them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rustchain.errors import InvalidInput
from rustchain.plot.shapes import Forces
from rustchain.typing import Array

if TYPE_CHECKING:
    from rustchain.results.result import Result


def poses_at(result: Result, times: Array) -> Array:
    """Return positions between the rows by cubic Hermite interpolation, (times, bodies, 3).

    Velocities are recorded with the positions, so that the error is of fourth order of the step.
    """
    row, share, step = _places(result, times)
    position, velocity = result.array("positions"), result.array("velocities")
    s = share[:, None, None]
    h = step[:, None, None]
    found: Array = (
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * position[row]
        + s * (1.0 - s) ** 2 * h * velocity[row]
        + s**2 * (3.0 - 2.0 * s) * position[row + 1]
        - s**2 * (1.0 - s) * h * velocity[row + 1]
    )
    return found


def forces_at(result: Result, array: str, times: Array) -> Array:
    """Return recorded forces between the rows, linear in time, (times, forces, 2) [N]."""
    row, share, _ = _places(result, times)
    vectors = result.array(array)[..., :2]
    s = share[:, None, None]
    found: Array = (1.0 - s) * vectors[row] + s * vectors[row + 1]
    return found


def _places(result: Result, times: Array) -> tuple[Any, Array, Array]:
    """Return the row before each time, the share of the step after it, and the step [s]."""
    if len(result.time) < 2:
        msg = "animate(): the result has one row; expected two or more; run for longer"
        raise InvalidInput(msg)
    row = np.clip(np.searchsorted(result.time, times, "right") - 1, 0, len(result.time) - 2)
    step = result.time[row + 1] - result.time[row]
    return row, np.clip((times - result.time[row]) / step, 0.0, 1.0), step


def large_force(result: Result, forces: tuple[Forces, ...], rows: slice) -> float:
    """Return a large force of the recorded ones [N], which single impacts may exceed."""
    large = 0.0
    for group in forces:
        vectors = result.array(group.array)[rows][..., :2]
        size = np.hypot(vectors[..., 0], vectors[..., 1])
        size = size[np.isfinite(size)]
        if size.size:
            large = max(large, float(np.quantile(size, 0.998)))
    return large


def round_number(value: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above `value`."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= value * (1 + 1e-12))
