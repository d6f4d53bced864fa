"""Orders of convergence of both correctors on a drive with clearance whose contacts stay closed."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc

# A pretension keeps all contacts closed while the load swings: the equations are smooth.
DRIVE = rc.two_sprocket_drive(teeth=(17, 17), links=40, speed=0.0, torque=-1.0, pretension=800.0)
LOAD = rc.AppliedTorque(rc.Sines([(0.2, 2 * np.pi * 500.0, 0.0)], offset=-1.0))
SWINGING = replace(DRIVE, sprockets=(DRIVE.sprockets[0], replace(DRIVE.sprockets[1], motion=LOAD)))
DURATION = 1e-3  # [s] half a period of the load


def centres(law, method, max_order, step):
    """Return the links' centres at the end of constant steps from static equilibrium [m]."""
    # No error is too large for a tolerance of 0.1 m: each step is as long as it may be.
    solver = rc.Solver(method=method, max_order=max_order, rtol=0.1, atol=0.1, max_step=step)
    simulation = rc.Simulation(SWINGING, law, start="static", solver=solver)
    before = simulation.positions[:, :2].copy()
    result = simulation.run(DURATION, DURATION, progress=False, energy=False)
    assert result.stats["onsets"] == 0
    assert result.stats["rejected"] == 0
    assert result.stats["steps"] == pytest.approx(DURATION / step, rel=0.05)
    found = simulation.positions[:, :2]
    assert abs(found - before).max() > 1e-8  # the load moves the chain, far more than the errors
    return found


@pytest.mark.parametrize(
    ("law", "method", "max_order", "steps", "expected"),
    [
        # Damping at the least impact velocity is too stiff for long steps of the explicit one.
        (rc.LankaraniNikravesh(), "newton", 2, (4e-6, 2e-6, 1e-6, 5e-7), 2),
        (rc.Hertz(), "newton", 2, (4e-6, 2e-6, 1e-6, 5e-7), 2),
        # A corrector of one order more than the predictor: the error is of its order.
        (rc.Hertz(), "pece", 1, (1e-6, 5e-7, 2.5e-7), 2),
        (rc.Hertz(), "pece", 2, (1e-6, 5e-7, 2.5e-7), 3),
        (rc.Hertz(), "pece", 3, (2e-6, 1e-6, 5e-7), 4),
        (rc.Hertz(), "pece", 4, (2e-6, 1e-6, 5e-7), 5),
    ],
    ids=["damped Newton", "Newton", "PECE 1", "PECE 2", "PECE 3", "PECE 4"],
)
def test_the_error_falls_with_the_order_of_the_corrector(law, method, max_order, steps, expected):
    """Differences of runs with halved steps: each is a 2^order-th of the one before.

    The longest steps are not short beside the shortest vibrations: measured orders, 1.7 to 2.1,
    2.0, 2.7, 3.5 and 4.8, are up to 0.54 from the theory.
    """
    ends = [centres(law, method, max_order, step) for step in steps]
    differences = [abs(a - b).max() for a, b in itertools.pairwise(ends)]
    orders = np.log2(np.divide(differences[:-1], differences[1:]))
    assert abs(orders - expected).max() < 0.6, orders


def test_both_correctors_converge_to_the_same_motion():
    """The error of the implicit one is a third of its last change by a halved step, by order 2.

    Measured: 4.5e-13 m, and 3.5e-14 m with that taken off; 5e-8 m moved.
    """
    fine = centres(rc.Hertz(), "pece", 4, 2.5e-7)
    coarse, halved = (centres(rc.Hertz(), "newton", 2, step) for step in (5e-7, 2.5e-7))
    extrapolated = halved + (halved - coarse) / 3.0
    assert abs(halved - fine).max() < 1e-12
    assert abs(extrapolated - fine).max() < 0.15 * abs(halved - fine).max()
