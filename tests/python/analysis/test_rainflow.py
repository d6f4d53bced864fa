"""Turning points and cycles of short histories, worked out by hand."""

import numpy as np
import pytest

from rustchain.analysis import rainflow


@pytest.mark.parametrize(
    ("history", "points"),
    [
        ([2.0, 2.0, 2.0], [2.0]),  # nothing turns
        ([0.0, 0.1, 0.2, 0.3], [0.0, 0.3]),  # slopes below 1
        ([0.0, 1.0, 1.0, 2.0, 2.0, 1.0], [0.0, 2.0, 1.0]),  # slopes of 1, and plateaus
        ([0.0, 0.2, 0.2, 0.1, 0.3], [0.0, 0.2, 0.1, 0.3]),
    ],
)
def test_turning_points_are_those_of_the_history_without_repeated_values(history, points):
    assert rainflow.reversals(np.array(history)).tolist() == points


@pytest.mark.parametrize(
    ("history", "gate", "points"),
    [
        ([0.0, 0.25], 0.5, [0.0, 0.25]),  # two points are the ends
        ([0.0, 1.0, 0.75], 0.5, [0.0, 1.0]),
        ([0.0, 1.0, 0.25], 0.5, [0.0, 1.0, 0.25]),
        ([0.0, 1.0, 0.5, 2.0], 0.5, [0.0, 2.0]),  # a swing of the gate itself is passed over
        ([0.0, 0.7, 0.4, 0.9, 0.0], 0.5, [0.0, 0.9, 0.0]),
        ([0.0, 0.7, 0.0, 0.2, -0.4, 0.6], 0.5, [0.0, 0.7, -0.4, 0.6]),
    ],
)
def test_a_gate_passes_over_swings_up_to_its_size(history, gate, points):
    assert rainflow.reversals(np.array(history), gate).tolist() == points


def test_a_steady_history_has_no_cycle():
    ranges, cycles = rainflow.count(np.full(3, 5.0))
    assert (len(ranges), len(cycles)) == (0, 0)


def test_a_range_equal_to_the_one_before_completes_it():
    """ASTM E1049-85, 5.4.4, step 3: a range is counted if the next one is no smaller."""
    ranges, cycles = rainflow.count(np.array([0.0, 4.0, 1.0, 3.0, 1.0, 4.0]))
    found = dict(zip(ranges.tolist(), cycles.tolist(), strict=True))
    assert found == {2.0: 1.0, 3.0: 1.0, 4.0: 0.5}
