"""How benches/least_times.py measures processor times."""

import numpy as np
import pytest

import least_times
import rustchain as rc
from least_times import (
    LEAST_RUNS,
    MOST_RUNS,
    Clock,
    EqualRuns,
    each_row,
    least_of,
    step,
    take_turns,
)


def test_a_part_counts_with_its_least_time_of_all_runs():
    quiet = np.array([1.0, 2.0, 3.0])
    runs = [quiet + busy for busy in ([0.0, 1.0, 0.0], [1.0, 0.0, 0.25], [0.5, 0.5, 0.0])]
    least = least_of(runs)
    assert least.seconds == 6.0
    # The first and third run leave 0.5 in the second part; the second alone leaves 1.25.
    assert least.difference == pytest.approx((7.25 - 6.5) / 6.0)


def test_equal_runs_take_turns():
    order = []
    take_turns(EqualRuns(lambda _, name=name: order.append(name)) for name in "ab")
    assert order == ["a", "b"] * MOST_RUNS


def test_slow_runs_are_made_less_often(monkeypatch):
    monkeypatch.setattr(least_times, "SECONDS", 0.0)
    slow = EqualRuns(lambda clock: sum(range(1000)))
    take_turns([slow])
    assert len(slow.parts) == LEAST_RUNS


def test_parts_change_neither_steps_nor_motion():
    whole, divided, recorded = (rc.Simulation(rc.paper_drive(25.0)) for _ in range(3))
    whole.step_to(5e-3)
    clock = Clock()
    step(divided, 5e-3, clock, parts=10)
    assert len(clock.parts()) == 10
    clock.begin()
    recorded.run(5e-3, 1e-3, record=(), energy=False, progress=False, callback=each_row(clock, 2))
    assert len(clock.parts()) == 3  # six rows
    for other in (divided, recorded):
        assert other.stats["steps"] == whole.stats["steps"]
        assert np.array_equal(other.positions, whole.positions)
