"""What benches/features.py measures and writes."""

import json
import warnings

import pytest

import features
import rustchain as rc

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
