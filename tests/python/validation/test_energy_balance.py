"""The energy balance against accurate runs, and where contacts are overdamped."""

import numpy as np
import pytest

import rustchain as rc


@pytest.mark.parametrize("pretension", [0.0, 25.0, 100.0])
def test_the_energy_lost_is_that_of_an_accurate_run(pretension):
    """Root mean square of six starts: 5e-8, 5e-8 and 5e-8 J.

    With the external power integrated along the path of each step it is 6e-7, 3e-7 and 8e-7 J.
    """
    drive = rc.paper_drive(pretension=pretension)
    before = rc.Simulation(drive)
    errors, losses = [], []
    for i in range(6):
        before.step_to(0.13 + 0.003 * i)
        place = {"positions": before.positions, "velocities": before.velocities}
        lost = []
        for solver in (rc.Solver(), rc.Solver(method="pece", accuracy=1e-13)):
            energy = rc.Simulation(drive, **place, solver=solver).run(2e-3, progress=False).energy
            stored = energy.kinetic + energy.gravity + energy.elastic
            lost.append(energy.external_work[-1] - (stored[-1] - stored[0]))
        errors.append(lost[0] - lost[1])
        losses.append(lost[1])
    assert max(losses) > 5e-5
    assert np.sqrt(np.mean(np.square(errors))) < 1.5e-7


# At 1e-6 m/s.
@pytest.mark.filterwarnings("ignore:min_impact_velocity", "ignore::rustchain.EnergyWarning")
@pytest.mark.parametrize(("minimum", "most"), [(1e-4, 3e-4), (1e-6, 1e-2)])
def test_the_balance_of_overdamped_contacts_closes(minimum, most):
    """Of 24 mJ dissipated; 0.06 and 1.7 mJ, and 1.8 mJ and 1.6 J along the path of each step."""
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=157.0, torque=5.0)
    simulation = rc.Simulation(drive, start="static", min_impact_velocity=minimum)
    energy = simulation.run(5e-3, progress=False).energy
    assert energy.dissipated[-1] > 0.015
    assert np.abs(energy.residual).max() < most
