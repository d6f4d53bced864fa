"""The scenes of benches/robustness.py, briefly: they end, and their energy balances close."""

from __future__ import annotations

import importlib.util
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import rustchain as rc

PATH = Path(__file__).parents[2] / "benches" / "robustness.py"
_SPEC = importlib.util.spec_from_file_location("robustness", PATH)
robustness = importlib.util.module_from_spec(_SPEC)
sys.modules["robustness"] = robustness  # where its dataclasses look themselves up
_SPEC.loader.exec_module(robustness)

DURATION = 0.02
SCENES = robustness.scenes(DURATION)


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_the_scene_ends_and_its_balance_closes(scene):
    solver = rc.Solver(method="newton", accuracy=1e-9)
    outcome = robustness.run(scene, solver, DURATION)
    assert outcome.steps > 10
    assert not outcome.failure, robustness.row(outcome)


def test_every_demand_has_its_scenes():
    names = [scene.name for scene in SCENES]
    assert len(set(names)) == len(names)
    for demand in (
        "1000 N",
        "restitution 0.05",
        "restitution 1.0",
        "floor 1e-05",
        "floor 0.1",
        "rpm",
    ):
        assert any(demand in name for name in names), demand
    for demand in (
        "clearance 5 um",
        "clearance 500 um",
        "Johnson",
        "enhanced",
        "from rest",
        "load",
    ):
        assert any(demand in name for name in names), demand


def test_a_scene_that_loses_energy_is_a_failure():
    scene = SCENES[0]
    outcome = robustness.run(scene, rc.Solver(method="newton", accuracy=1e-4), DURATION)
    assert outcome.failure


def test_a_run_whose_balance_does_not_close_says_so_once():
    solver = rc.Solver(method="newton", accuracy=1e-4)
    simulation = rc.Simulation(rc.paper_drive(), solver=solver)
    with pytest.warns(rc.EnergyWarning, match="take accuracy = 1e-[0-9]+ or less") as caught:
        result = simulation.run(DURATION, record=(), progress=False)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert result.stats["largest_residual"] == np.abs(result.energy.residual).max()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulation.run(1e-3, record=(), progress=False)


def test_a_run_whose_balance_closes_does_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = rc.Simulation(rc.paper_drive()).run(DURATION, record=(), progress=False)
    assert 0.0 < result.stats["largest_residual"] < 0.01 * result.energy.dissipated[-1]
