"""Comparison of arrays within element-wise bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def assert_within(actual: ArrayLike, expected: ArrayLike, bound: ArrayLike, what: str) -> None:
    """Assert |actual - expected| <= bound in every element; equal infinities agree, NaN never."""
    actual, expected = np.asarray(actual), np.asarray(expected)
    assert actual.shape == expected.shape, f"{what}: shape {actual.shape}, not {expected.shape}"
    bound = np.broadcast_to(bound, expected.shape)
    same_infinity = np.isinf(expected) & (actual == expected)
    with np.errstate(invalid="ignore"):
        error = np.where(same_infinity, 0.0, np.abs(actual - expected))
    wrong = ~(error <= bound)
    if np.any(wrong):
        ratio = np.where(wrong, error / np.maximum(bound, np.finfo(float).tiny), 0.0)
        worst = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
        place = tuple(int(i) for i in worst)
        raise AssertionError(
            f"{what}: {int(wrong.sum())} of {wrong.size} out of bounds; worst at {place}: "
            f"{actual[worst]:.17g} against {expected[worst]:.17g}, "
            f"off by {error[worst]:.3g}, bound {bound[worst]:.3g}"
        )
