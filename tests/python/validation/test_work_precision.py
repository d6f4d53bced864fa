"""What the comparison of run times makes of its figures."""

import numpy as np
import pytest

from work_precision.analysis import (
    batch_means,
    frontier,
    order_of_convergence,
    time_at_error,
)

ERRORS, TIMES = [1e-2, 1e-4, 1e-6], [1.0, 10.0, 100.0]


def test_the_time_at_an_error_lies_on_the_line_between_logarithms():
    assert time_at_error(ERRORS, TIMES, 1e-3) == pytest.approx(np.sqrt(10.0))
    assert time_at_error(ERRORS, TIMES, 1e-4) == pytest.approx(10.0)


def test_a_looser_error_than_any_costs_the_cheapest_run_and_a_tighter_one_has_no_time():
    assert time_at_error(ERRORS, TIMES, 1.0) == 1.0
    assert np.isnan(time_at_error(ERRORS, TIMES, 1e-7))
    assert np.isnan(time_at_error([np.nan], [1.0], 1.0))


def test_a_point_that_another_beats_in_both_does_not_count():
    errors, times = ERRORS + [1e-3], TIMES + [50.0]
    assert frontier(errors, times)[0].tolist() == ERRORS
    assert time_at_error(errors, times, 1e-3) == time_at_error(ERRORS, TIMES, 1e-3)


def test_the_order_of_convergence_is_that_of_the_power():
    costs = np.array([10.0, 30.0, 100.0])
    assert order_of_convergence(costs, 5.0 * costs**-4) == pytest.approx(4.0)


def test_intervals_of_batch_means_hold_the_mean_in_95_percent_of_all_series():
    generator = np.random.default_rng(1)
    held = 0
    for _ in range(400):
        mean, half = batch_means(generator.normal(3.0, 1.0, (400, 2)), np.mean)
        held += abs(mean - 3.0) <= half
    # Binomial with p = 0.95: 380 of 400 expected, standard deviation 4.4.
    assert abs(held - 380) < 4 * 4.4


def test_a_steady_series_has_no_width():
    assert batch_means(np.full((100, 3), 7.0), np.mean) == (7.0, 0.0)
