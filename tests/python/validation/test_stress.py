"""The generator of random scenes in tests/stress: its scenes and its classes of outcomes."""

from __future__ import annotations

import pytest

from outcomes import Outcome, is_silent, outcome_of, table
from scenes import KINDS, Scene
from workers import outcomes_of

BRIEF = 1e-3  # [s]


def test_a_seed_alone_decides_its_scene():
    first, again = (outcome_of(3, BRIEF) for _ in range(2))
    assert first == again
    assert {Scene(seed).kind for seed in range(200)} == set(KINDS)


def test_scenes_that_end_and_scenes_that_hang_are_told_apart():
    seeds = [seed for seed in range(100) if Scene(seed).kind in ("published drive", "bouncing")]
    for outcome in outcomes_of(seeds[:4], BRIEF):
        assert outcome.outcome == "finished", str(outcome)
    # A limit of processor time that no run can keep; the next one has a process again.
    (hung,) = outcomes_of(seeds[:1], BRIEF, limit=0.01)
    assert hung.outcome == "hang"
    assert "| all | 1 | 1 |" in table([hung])


@pytest.mark.parametrize(
    ("residual", "dissipated", "exchanged", "silent"),
    [(4e-3, 0.1, 1.0, False), (6e-3, 0.1, 1.0, True), (6e-4, 0.0, 1.0, True)],
)
def test_an_imbalance_without_a_warning_is_silent(residual, dissipated, exchanged, silent):
    energy = {
        "residual": residual,
        "dissipated": dissipated,
        "exchanged": exchanged,
        "stored": 1.0,
        "kinetic": 1.0,
    }
    assert is_silent(Outcome(0, "", "finished", energy=energy)) is silent
    assert not is_silent(Outcome(0, "", "finished", warned=["EnergyWarning"], energy=energy))
