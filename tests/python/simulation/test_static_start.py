"""Static starts: a run begins with the contact forces of its equilibrium."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rustchain as rc
from rustchain import _rustchain

HOIST = Path(__file__).parents[3] / "examples" / "hoist_load.toml"
LAWS = [rc.LankaraniNikravesh(), rc.Hertz(), rc.Johnson()]


def hoist(law):
    """Return the hoist of the examples with another law."""
    return replace(rc.load_scene(HOIST), force_law=law)


def unbalanced(simulation):
    """Return the largest unbalanced force on a link at the first evaluation, at rest [N]."""
    chain = simulation.drive.chain
    still = np.zeros_like(simulation.velocities)
    accelerations = simulation.evaluate(velocities=still).accelerations
    mass = _rustchain.chain_links(chain)[:, 1]
    return np.abs(mass[:, None] * accelerations[: len(mass), :2]).max()


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_a_run_begins_on_the_tooth_surfaces_of_its_equilibrium(law):
    # Bushings of this drive rest where two surfaces of a tooth meet, whose stiffness differs with
    # the laws of Hertz and of Lankarani and Nikravesh.
    simulation = rc.Simulation(hoist(law))
    # Two links that meet at less than 60 degrees press a bushing by at most the larger tension.
    forces = simulation.evaluate()
    assert forces.tooth_force.max() < forces.hinge_force.max()
    assert forces.hinge_force.max() == pytest.approx(simulation.rest["largest_force"], rel=1e-3)
    assert unbalanced(simulation) < 1.5 * simulation.rest["residual"]


def test_the_surfaces_are_in_states_and_in_cases_of_the_pool(tmp_path):
    scene = hoist(rc.Hertz())
    simulation = rc.Simulation(scene)
    simulation.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    first = simulation.evaluate().tooth_force
    np.testing.assert_array_equal(again.evaluate().tooth_force, first)
    # A sweep runs in the compiled pool.
    (result,) = rc.sweep(scene, {"duration": [1e-5]}, report_step=1e-5, progress=False).values
    np.testing.assert_array_equal(result.arrays["tooth_force"][0], first.max(axis=1))


def test_a_surface_that_does_not_exist_is_refused():
    scene = rc.Scene(rc.paper_drive())
    place = rc.Simulation(scene)
    for surface in [(38, 0, 0), (0, 2, 0), (0, 0, 200)]:
        with pytest.raises(rc.InvalidInput, match="surfaces"):
            _rustchain.Core(scene, place.positions, place.velocities, [surface])


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
@pytest.mark.parametrize("aside", [0.1, 0.3])
def test_a_load_aside_of_its_anchor_swings_down(aside, hinges):
    # With a limit by the clearance of hinges that do not exist, 0.3 m took more than 100,000
    # iterations, after which a static start is refused.
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(5.0, position=(aside, -0.6)))
    drive = rc.open_chain("ANSI 40", ends, links=60, hinges=hinges)
    simulation = rc.Simulation(drive, start="static")
    assert simulation.rest["iterations"] < 30_000
    assert simulation.positions[:60, 0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("links", [96, 98])
def test_rollers_settle_where_a_run_of_a_movable_sprocket_passes_the_last_bushing(links):
    """98 links are no multiple of eight: terms behind the last bushing must not count twice."""
    drive = rc.two_sprocket_drive(
        "ANSI 40", (25, 17), links=links, speed=60.0, torque=5.0, rollers="bodies", pretension=300.0
    )
    motor, driven = drive.sprockets
    sprockets = (
        replace(motor, motion=rc.AppliedTorque(5.0)),
        replace(driven, motion=rc.PrescribedSpeed(60.0)),
    )
    drive = replace(drive, sprockets=sprockets, tensioner=rc.Tensioner(300.0, sprocket=1))
    assert rc.Simulation(drive, start="static").rest["iterations"] < 2000


@pytest.mark.parametrize("method", ["auto", "newton", "pece"])
def test_a_drive_that_rests_under_load_keeps_the_forces_of_its_equilibrium(method):
    # The first explicit step was 1e-4 s long, a hundred times the limit of stability: hinges bore
    # up to four times their force within it.
    hanging = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(20.0)), links=60)
    tight = rc.two_sprocket_drive(
        "ANSI 40", teeth=(17, 25), links=60, speed=0.0, torque=-5.0, pretension=500.0
    )
    for drive in (hanging, tight):
        simulation = rc.Simulation(drive, start="static", solver=rc.Solver(method=method))
        result = simulation.run(2e-4, report_step=1e-5, progress=False)
        force = result.array("hinge_force").max(axis=1)
        # The tolerance of velocities is worth 5 N in a hinge, more near the limit of stability.
        np.testing.assert_allclose(force, force[0], rtol=0.05)
        assert result.peaks.hinge_force.max() < 1.15 * force[0]
        np.testing.assert_array_equal(result.peaks.hinge_force[0], result.array("hinge_force")[0])
        assert abs(result.energy.dissipated[-1]) < 1e-6


@pytest.mark.parametrize("accuracy", [1e-8, 1e-9, 1e-10])
def test_a_chain_at_rest_stays_there_at_any_accuracy(accuracy):
    # Slow contacts are overdamped. The explicit corrector was unstable there up to its tolerance:
    # the largest force was 1.97, 1.10 and 1.00004 times that at rest.
    hanging = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(10.0)), links=40)
    simulation = rc.Simulation(hanging, start="static", solver=rc.Solver(accuracy=accuracy))
    result = simulation.run(4e-3, report_step=1e-4, record=("hinges",), energy=False)
    force = result.array("hinge_force")[0]
    np.testing.assert_allclose(result.peaks.hinge_force, np.tile(force, (41, 1)), rtol=1e-4)
    assert simulation.stats["evaluations"] < 100


@pytest.mark.parametrize("accuracy", [3e-10, 1e-10, 3e-11])
def test_the_largest_forces_of_overdamped_contacts_do_not_depend_on_the_accuracy(accuracy):
    # Velocities that alternate from step to step made them 3 to 11 % larger.
    def largest(accuracy):
        simulation = rc.Simulation(
            rc.paper_drive(25.0),
            start="static",
            min_impact_velocity=1e-4,
            solver=rc.Solver(accuracy=accuracy),
        )
        result = simulation.run(5e-3, report_step=2e-5, energy=False)
        return result.peaks.hinge_force.max()

    assert largest(accuracy) == pytest.approx(largest(1e-12), rel=1e-3)


def test_a_start_with_closed_contacts_or_a_film_has_the_implicit_corrector():
    def matrices(**start):
        simulation = rc.Simulation(rc.paper_drive(25.0), **start)
        simulation.run(1e-6, report_step=1e-6, energy=False)
        return simulation.stats["jacobians"]

    rest = rc.Simulation(rc.paper_drive(25.0), start="static")
    assert matrices() == 0
    assert matrices(start="static") > 0
    assert matrices(positions=rest.positions, velocities=rest.velocities) > 0
    assert matrices(start="static", solver=rc.Solver(method="pece")) == 0
    film = rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))
    assert matrices(hinge_law=film) > 0
