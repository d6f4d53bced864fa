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
