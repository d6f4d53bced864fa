"""Rainflow counting of the ranges in a history, after ASTM E1049-85, 5.4.4."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rustchain.typing import Array


def reversals(history: Array, gate: float = 0.0) -> Array:
    """Return the first value of a history, its turning points and its last value.

    Of three points and more, swings no larger than `gate` are passed over, the one to the last
    value too.
    """
    slopes = np.diff(history)
    values = history[np.concatenate([[True], slopes != 0.0])]
    turns = np.flatnonzero(np.diff(values)[1:] * np.diff(values)[:-1] < 0.0) + 1
    points: Array = values
    if len(values) > 1:
        points = values[np.concatenate([[0], turns, [len(values) - 1]])]
    if gate <= 0.0 or len(points) < 3:
        return points
    kept = [float(points[0])]
    for value in points[1:].tolist():
        if len(kept) > 1 and (value - kept[-1]) * (kept[-1] - kept[-2]) > 0.0:
            kept[-1] = value  # goes on in the same direction
        elif abs(value - kept[-1]) > gate:
            kept.append(value)
    return np.array(kept)


def count(history: Array, gate: float = 0.0) -> tuple[Array, Array]:
    """Return the ranges of a history and how many cycles each is, 1 or 0.5, (ranges,) each."""
    ranges: list[float] = []
    cycles: list[float] = []
    stack: list[float] = []
    for point in reversals(history, gate).tolist():
        stack.append(point)
        while len(stack) >= 3:
            latest = abs(stack[-1] - stack[-2])
            before = abs(stack[-2] - stack[-3])
            if latest < before:
                break
            ranges.append(before)
            if len(stack) == 3:  # it contains the starting point: half a cycle
                cycles.append(0.5)
                del stack[0]
            else:
                cycles.append(1.0)
                del stack[-3:-1]
    ranges.extend(abs(after - here) for here, after in pairwise(stack))
    cycles.extend([0.5] * max(len(stack) - 1, 0))
    return np.array(ranges), np.array(cycles)
