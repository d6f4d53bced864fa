"""Peaks at the ends of steps against rows that are closer together than the steps."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc


def drive(**keywords: object) -> rc.ChainDrive:
    """Return the published drive at 100 N with another chain."""
    return replace(rc.paper_drive(pretension=100.0), chain=rc.paper_drive(**keywords).chain)


def newton(accuracy: float) -> rc.Solver:
    """Return Newton's method."""
    return rc.Solver(method="newton", accuracy=accuracy)


SCENES: dict[str, Callable[[], rc.Simulation]] = {
    "bushings": lambda: rc.Simulation(drive(), solver=newton(1e-9)),
    "rollers": lambda: rc.Simulation(drive(rollers="bodies"), solver=newton(1e-10)),
    "friction": lambda: rc.Simulation(
        drive(), rc.LankaraniNikravesh(friction=rc.Coulomb(0.1)), solver=newton(1e-9)
    ),
    "film": lambda: rc.Simulation(
        drive(), hinge_law=rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1)), solver=newton(1e-10)
    ),
    "ideal hinges": lambda: rc.Simulation(replace(drive(), hinges="ideal"), solver=newton(1e-9)),
}


@pytest.mark.parametrize("energy", [False, True])
@pytest.mark.parametrize("scene", SCENES)
def test_a_peak_is_the_force_of_a_step_end_after_its_last_correction(scene: str, energy: bool):
    """A step of Newton's method has its last evaluation before its last correction."""
    simulation = SCENES[scene]()
    simulation.step_to(0.02)
    record = ("hinges", "teeth", "energy") if energy else ("hinges", "teeth")
    rows = simulation.run(1e-3, 1e-7, record=record, progress=False)
    for kind in ("hinge_force", "tooth_force"):
        force, peak = rows.array(kind), rows.array(f"peak_{kind}")
        # The end of a step lies between two rows.
        above = peak[1:] - np.maximum(force[1:], force[:-1])
        # By chance 0.2 to 1.8 % in six runs whose accuracies differ by a few percent.
        assert above.max() < 0.03 * force.max()
        assert (above > 1e-9 * force.max()).sum() > 20
