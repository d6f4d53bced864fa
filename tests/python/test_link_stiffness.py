"""Elastic links: plates in series with the contacts of their hinges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import DriveEquations

LAWS = {
    "lankarani-nikravesh": rc.LankaraniNikravesh(),
    "johnson": rc.Johnson(),
    "enhanced": rc.EnhancedCylinder(damping="lankarani-nikravesh"),
}


def elastic(drive: rc.ChainDrive, stiffness: float | None) -> rc.ChainDrive:
    return replace(drive, chain=replace(drive.chain, link_stiffness=stiffness))


@pytest.mark.parametrize("stiffness", [1e7, 3e8])
@pytest.mark.parametrize("which", LAWS)
def test_forces_and_accelerations_agree_to_round_off(which, stiffness, paper, states_with_seat):
    law, drive = LAWS[which], elastic(paper, stiffness)
    simulation = rc.Simulation(drive, law)
    equations = DriveEquations(drive, law, law)
    pressed = 0
    for positions, velocities in states_with_seat("pitch-circle")[::5]:
        expected = equations.evaluate(positions, velocities, 0.04)
        e = simulation.evaluate(positions=positions, velocities=velocities, time=0.04)
        assert_within(e.hinge_force, expected.hinge_force, expected.hinge_force_bound, "hinges")
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        pressed += np.count_nonzero(expected.hinge_force > 0.0)
    assert pressed > 50


@pytest.mark.parametrize("which", LAWS)
def test_a_tight_chain_is_longer_by_its_plates_and_its_contacts(which):
    stiffness, law = 5e7, LAWS[which]
    drive = rc.paper_drive(pretension=100.0)
    chain = drive.chain
    simulation = rc.Simulation(elastic(drive, stiffness), law, start="static")
    still = simulation.evaluate(
        positions=simulation.positions, velocities=np.zeros_like(simulation.velocities)
    )
    force, depth = still.hinge_force, still.hinge_penetration
    radii = (chain.hinge.pin_radius, chain.hinge.bore_radius)
    assert force.max() > 50.0
    expected = []
    for pull in force:

        def missing(d: float, pull: float = pull) -> float:
            return float(law.elastic_force(d, radii, chain.hinge.length)) - pull

        expected.append(brentq(missing, 0.0, 1e-4, xtol=1e-16, rtol=1e-14) + pull / stiffness)
    assert np.allclose(depth, expected, rtol=1e-9, atol=1e-15)
    assert depth.sum() == pytest.approx(np.sum(expected), rel=1e-12)


def test_the_energy_balance_closes_with_elastic_links():
    found = rc.Simulation(elastic(rc.paper_drive(25.0), 5e7)).run(0.02, 1e-3, progress=False)
    assert abs(found.energy.residual[-1]) < 1e-2 * found.energy.dissipated[-1]


def test_a_linear_contact_and_its_plates_are_two_springs_in_series():
    contact, plates = 3e8, 1e8
    both = contact * plates / (contact + plates)
    runs = [
        rc.Simulation(
            elastic(rc.paper_drive(25.0), plates), hinge_law=rc.Linear(stiffness=contact)
        ),
        rc.Simulation(rc.paper_drive(25.0), hinge_law=rc.Linear(stiffness=both)),
    ]
    for run in runs:
        run.step_to(2e-3)
    series, single = (run.positions for run in runs)
    assert np.abs(series - single).max() < 1e-9


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: elastic(rc.paper_drive(), 0.0), "Chain.link_stiffness"),
        (
            lambda: rc.Simulation(
                replace(elastic(rc.paper_drive(25.0), 1e8), hinges="ideal"),
            ),
            "Chain.link_stiffness.*ideal hinges",
        ),
    ],
)
def test_what_means_nothing_is_refused(make, message):
    with pytest.raises(rc.InvalidInput, match=message):
        make()
