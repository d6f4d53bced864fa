"""Friction in hinges and on teeth: against the NumPy reference, and as users meet it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import DriveEquations

LN = rc.LankaraniNikravesh()
FRICTIONS = {
    "tanh": (rc.Coulomb(0.1), rc.Coulomb(0.2, speed=1e-2)),
    "threlfall": (rc.Coulomb(0.3, "threlfall", 5e-3), rc.Coulomb(0.1, "threlfall")),
    "ambrosio": (rc.Coulomb(0.15, "ambrosio", 2e-2, 1e-3), rc.Coulomb(0.15, "ambrosio", 1e-2)),
    "hinges alone": (rc.Coulomb(0.1), None),
    "teeth alone": (None, rc.Coulomb(0.1)),
}


@pytest.mark.parametrize("which", FRICTIONS)
def test_forces_and_accelerations_agree_to_round_off(which, paper, states_with_seat):
    hinges, teeth = FRICTIONS[which]
    simulation = rc.Simulation(
        paper,
        hinge_law=rc.LankaraniNikravesh(friction=hinges),
        tooth_law=rc.LankaraniNikravesh(friction=teeth),
    )
    laws = [replace(LN, friction=law) for law in (hinges, teeth)]
    equations = DriveEquations(paper, *laws)
    rubbing = np.zeros(2)
    for positions, velocities in states_with_seat("pitch-circle"):
        expected = equations.evaluate(positions, velocities, 0.04)
        e = simulation.evaluate(positions=positions, velocities=velocities, time=0.04)
        for kind in ("hinge", "tooth"):
            bound = getattr(expected, f"{kind}_vector_bound")
            vectors = [getattr(found, f"{kind}_force_vector") for found in (e, expected)]
            assert_within(*vectors, bound[..., None], f"{kind}: forces as vectors")
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        rubbing += np.array(expected.friction_powers[:2]) > 0.0
    assert np.all((rubbing > 20) == [hinges is not None, teeth is not None])


def test_friction_is_a_part_of_the_laws():
    drive = rc.paper_drive(pretension=25.0)
    both, teeth = rc.Coulomb(0.1), rc.Coulomb(0.2)
    simulation = rc.Simulation(
        drive,
        force_law=rc.LankaraniNikravesh(friction=both),
        tooth_law=rc.LankaraniNikravesh(friction=teeth),
    )
    assert simulation.hinge_law == rc.LankaraniNikravesh(friction=both)
    assert simulation.tooth_law == rc.LankaraniNikravesh(friction=teeth)
    as_laws = rc.Simulation(drive, hinge_law=simulation.hinge_law, tooth_law=simulation.tooth_law)
    for run in (simulation, as_laws):
        run.step_to(4e-3)
    assert np.array_equal(simulation.positions, as_laws.positions)
    law = simulation.tooth_law
    assert rc.ForceLaw.from_json(law.to_json()) == law


def test_a_state_with_friction_is_saved_and_goes_on(tmp_path):
    simulation = rc.Simulation(
        rc.paper_drive(pretension=25.0), force_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
    )
    simulation.step_to(3e-3)
    simulation.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    for run in (simulation, again):
        run.step_to(5e-3)
    assert np.array_equal(simulation.positions, again.positions)


def loaded_drive(pretension: float, torque: float) -> rc.ChainDrive:
    drive = rc.paper_drive(pretension)
    driven = replace(drive.sprockets[1], motion=rc.AppliedTorque(-torque))
    tensioner = replace(drive.tensioner, ramp_time=2e-3)
    return replace(drive, sprockets=(drive.sprockets[0], driven), tensioner=tensioner)


def test_efficiency_falls_with_friction_by_the_work_of_articulation():
    pitches = 2.0 * 0.5 / 17.0  # [s] for two
    found = []
    for law in (None, rc.Coulomb(0.1)):
        simulation = rc.Simulation(
            loaded_drive(200.0, 4.0), hinge_law=rc.LankaraniNikravesh(friction=law)
        )
        result = simulation.run(0.04 + 2.0 * pitches, 1e-4, progress=False)
        energy = result.energy
        assert energy.hinge_friction is not None
        assert energy.hinge_contact is not None
        assert energy.tooth_contact is not None
        assert energy.tooth_friction is not None
        parts = (
            energy.hinge_contact
            + energy.tooth_contact
            + energy.hinge_friction
            + energy.tooth_friction
        )
        assert np.all(parts <= energy.dissipated * (1.0 + 1e-12) + 1e-15)
        assert np.all(energy.tooth_friction == 0.0)
        assert (energy.hinge_friction[-1] > 0.0) == (law is not None)
        found.append(result.efficiency(after=0.04))
    without, with_friction = found
    # mu r omega (1 + 1) (T1 + T2), of the 4 N m at the driver's speed that the load takes out.
    share = 0.1 * 2.22e-3 * 2.0 * 400.0 / 4.0
    assert 0.85 < without < 1.0
    # Measured 0.92 of it; the rest of the losses changes a little too.
    assert with_friction == pytest.approx(without - share, abs=0.5 * share)


def test_efficiency_needs_rows_and_a_driver():
    result = rc.Simulation(rc.paper_drive(25.0)).run(2e-3, 1e-3, progress=False)
    with pytest.raises(rc.InvalidInput, match="rows there"):
        result.efficiency(after=1.0)


def test_a_sweep_has_friction_as_a_parameter():
    found = rc.sweep(
        rc.paper_drive(25.0),
        {"hinge_law.friction": [None, rc.Coulomb(0.1)]},
        lambda result: result.energy.hinge_friction[-1],
        duration=8e-3,
        report_step=1e-3,
        progress=False,
    )
    assert found.values[0] == 0.0
    assert found.values[1] > 0.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rc.Coulomb(0.0), "Coulomb.coefficient = 0.*leave the law out"),
        (lambda: rc.Coulomb(-0.1), "Coulomb.coefficient"),
        (lambda: rc.Coulomb(0.1, speed=0.0), "Coulomb.speed"),
        (lambda: rc.Coulomb(0.1, "stribeck"), "Coulomb.regularization"),
        (lambda: rc.Coulomb(0.1, dead_speed=1e-4), "ambrosio"),
        (lambda: rc.Coulomb(0.1, "ambrosio", 1e-3, 1e-3), "less than speed"),
        (lambda: rc.Hertz(friction=0.1), "Hertz.friction"),
        (
            lambda: rc.Simulation(
                replace(rc.paper_drive(25.0), hinges="ideal"),
                force_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.1)),
            ),
            "friction.*whose hinges have no contact",
        ),
    ],
)
def test_a_friction_law_that_means_nothing_is_refused(make, message):
    with pytest.raises(rc.InvalidInput, match=message):
        make()
