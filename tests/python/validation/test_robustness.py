"""The scenes of benches/robustness.py, briefly: they end, and their energy balances close."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import robustness
import rustchain as rc

DURATION = 0.02
SCENES = robustness.scenes(DURATION)


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_the_scene_ends_and_its_balance_closes(scene):
    solver = rc.Solver(method="newton", accuracy=1e-9)
    outcome = robustness.run(scene, solver, DURATION)
    assert outcome.steps > 10
    assert outcome.end == "ends", robustness.row(outcome)


def test_every_demand_has_its_scenes():
    names = [scene.name for scene in SCENES]
    assert len(set(names)) == len(names)
    for demand in (
        "1000 N",
        "restitution 0.05",
        "restitution 1.0",
        "minimum impact velocity 1e-05",
        "minimum impact velocity 0.1",
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
    outcome = robustness.run(scene, rc.Solver(method="newton", accuracy=1e-6), DURATION)
    assert outcome.failed
    assert outcome.end.startswith("its balance is off: ")


def test_a_known_excess_of_the_balance_is_no_failure_until_it_grows():
    known = [scene for scene in SCENES if scene.known_excess > 1.0]
    assert [scene.name for scene in known] == ["restitution 1.0, 0 N", "Johnson, 0 N"]
    for scene in known:
        limit = robustness.OF_EXCHANGED  # [J] of an energy exchanged of 1 J
        counts = {"wall": 1.0, "steps": 1, "rejected": 0, "onsets": 1, "dissipated": 0.0}

        def outcome(residual, scene=scene, counts=counts, message=""):
            return robustness.Outcome(
                scene, residual=residual, exchanged=1.0, message=message, **counts
            )

        assert outcome(0.99 * limit).end == "ends"
        found = outcome(0.99 * scene.known_excess * limit)
        assert not found.failed
        assert found.end == "its balance is off, as known: 2.0e-02 J are allowed"
        assert outcome(1.01 * scene.known_excess * limit).failed
        assert outcome(np.nan).failed
        assert outcome(0.0, message="step size fell").failed


@pytest.mark.parametrize(
    ("residual", "options", "status", "told"),
    [
        (2.0, [], 0, "0 failures, 1 off balance as known"),
        (2.0, ["--accuracy", "1e-9"], 1, "1 failures, 0 off balance as known"),
        (20.0, [], 1, "1 failures, 0 off balance as known"),
    ],
)
def test_an_excess_is_known_with_the_default_solver_only(
    residual, options, status, told, monkeypatch, capsys
):
    counts = {"wall": 1.0, "steps": 1, "rejected": 0, "onsets": 1, "dissipated": 0.0}

    def run(scene, *_):
        off = residual * robustness.OF_EXCHANGED
        return robustness.Outcome(scene, residual=off, exchanged=1.0, message="", **counts)

    monkeypatch.setattr(robustness, "run", run)
    monkeypatch.setattr("sys.argv", ["robustness.py", "--only", "restitution 1.0, 0 N", *options])
    monkeypatch.setattr(
        robustness, "scenes", lambda _: [s for s in SCENES if "1e-11" not in s.name]
    )
    assert robustness.main() == status
    assert told in capsys.readouterr().out


def test_a_run_whose_balance_does_not_close_says_so_once():
    solver = rc.Solver(method="newton", accuracy=1e-6)
    with pytest.warns(rc.RustchainWarning, match="solver.accuracy"):
        simulation = rc.Simulation(rc.paper_drive(), solver=solver)
    with pytest.warns(rc.EnergyWarning, match="take accuracy = 1e-[0-9]+ or less") as caught:
        result = simulation.run(DURATION, record=("energy",), progress=False)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert result.stats["largest_residual"] == np.abs(result.energy.residual).max()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulation.run(1e-3, record=("energy",), progress=False)


def test_a_run_whose_balance_closes_does_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = rc.Simulation(rc.paper_drive()).run(DURATION, record=("energy",), progress=False)
    assert 0.0 < result.stats["largest_residual"] < 0.01 * result.energy.dissipated[-1]


def test_a_run_that_starts_from_rest_is_judged_by_all_that_passed():
    """Its first rows have errors and next to no loss: at 3 ms the residual is a third of it."""
    ramp = rc.PrescribedSpeed(((0.0, 0.0), (0.1, 5.0)))
    sprockets = [rc.Sprocket(24, (0.0, 0.0), ramp), rc.Sprocket(24, (88 * 0.01905, 0.0))]
    drive = rc.chain_drive("ANSI 60", sprockets, links=200, adjust=2, gravity=(0.0, 0.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = rc.Simulation(drive).run(DURATION, 5e-4, record=("energy",), progress=False)
    energy = result.energy
    assert abs(energy.residual[6]) > 0.1 * energy.dissipated[6]
    assert np.abs(energy.residual).max() < 0.01 * energy.dissipated[-1]


def test_sharp_regions_are_named_where_they_leave_the_balance_open():
    drive = rc.two_sprocket_drive(links=60, speed=12.0, pretension=50.0)
    law = rc.LankaraniNikravesh(regions="sharp")
    simulation = rc.Simulation(drive, force_law=law, start="static")
    with pytest.warns(rc.EnergyWarning, match='take regions = "kept": .* at any accuracy'):
        simulation.run(DURATION, record=("energy",), progress=False)


def test_energy_that_stays_stored_hides_no_residual():
    """A chain under 1000 N that hardly turns: a thousand times what it loses stays pressed."""
    drive = rc.two_sprocket_drive(teeth=(17, 17), links=38, speed=0.2, pretension=1000.0)

    def energy_of(accuracy):
        solver = rc.Solver("newton", accuracy=accuracy)
        simulation = rc.Simulation(drive, solver=solver, start="static")
        return simulation.run(0.01, record=("energy",), progress=False).energy

    with pytest.warns(rc.EnergyWarning, match="take accuracy = 1e-1[0-9] or less"):
        energy = energy_of(1e-9)
    # Four fifths of what is counted as dissipated are an error of the integration.
    error = energy.dissipated[-1] - energy_of(1e-12).dissipated[-1]
    assert error > 0.75 * energy.dissipated[-1]
    assert np.abs(energy.residual).max() == pytest.approx(error, rel=0.1)
    assert energy.elastic.min() > 1000.0 * energy.dissipated[-1]
