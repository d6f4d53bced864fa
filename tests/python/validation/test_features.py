"""What benches/features.py measures and writes."""

import json
import warnings

import numpy as np
import pytest

import features
import least_times
import practical
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

FOUND = json.loads(features.NUMBERS.read_text(encoding="utf-8"))


def test_the_page_has_the_numbers_beside_it():
    page = features.PAGE.read_text(encoding="utf-8")
    assert features.with_tables(page, FOUND) == page


def test_every_feature_is_on_the_page_at_both_pretensions():
    names = [feature.name for feature in features.features()]
    assert len(set(names)) == len(names)
    rows = [(row["pretension"], row["feature"]) for row in FOUND["features"]]
    assert rows == [(force, name) for force in features.PRETENSIONS for name in names]


def test_the_start_of_a_case_takes_less_than_two_milliseconds():
    sweep = FOUND["sweep"]
    for way in sweep["ways"].values():
        assert way["start-up"] / sweep["cases"] < 2e-3


def test_every_feature_runs_and_recording_leaves_the_steps_alone():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rows = features.all_features(rounds=1, lead=1e-3, duration=1e-3, most=3)
    assert all(row["steps"] > 0 and row["time"] > 0.0 for row in rows)
    first = {row["pretension"]: row["steps"] for row in rows if row["feature"] == "default"}
    recorded = [row for row in rows if "row" in row["feature"]]
    assert len(recorded) == 2 * 11
    assert [row["steps"] for row in recorded] == [first[row["pretension"]] for row in recorded]
    # One of the equal runs counts, from the state after the lead.
    for pretension, steps in first.items():
        alone = rc.Simulation(features.scene_of(features.Feature("default"), pretension, 1.0))
        alone.step_to(1e-3)
        before = alone.stats["steps"]
        alone.step_to(2e-3)
        assert steps == alone.stats["steps"] - before


def test_a_ratio_is_that_of_the_same_round():
    counts = dict.fromkeys(("difference", *features.COUNTS), 10)
    default = [counts | {"time": time} for time in (1.0, 2.0, 3.0)]
    twice = [one | {"time": 2.0 * one["time"]} for one in default]
    row = features.row({(25.0, "default"): default, (25.0, "twice"): twice}, 25.0, "twice")
    assert row["time"] == 4.0
    assert row["quartiles"] == pytest.approx([2.0, 2.0])


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


def test_the_page_of_practical_scenes_has_the_numbers_beside_it():
    page = practical.PAGE.read_text(encoding="utf-8")
    assert practical.with_table(page, json.loads(practical.NUMBERS.read_text("utf-8"))) == page


def test_a_scene_that_fails_keeps_its_message_and_the_others_their_times(monkeypatch):
    broken = practical.Practical("broken", practical.five_bar, 2e9)  # longer than a run may be
    good = practical.Practical("good", practical.five_bar, 1e-4)
    monkeypatch.setattr(practical, "scenes", lambda: [broken, good])
    rows = practical.all_scenes()
    assert [bool(row["message"]) for row in rows] == [True, True, False, False]
    assert all(row["time"] > 0.0 for row in rows if not row["message"])
    assert len(practical.cells_of(rows[0])) == len(practical.COLUMNS)
