"""Numerical behaviour of the published drive: growth of errors, energy residual, steps."""

from __future__ import annotations

import numpy as np
import pandas as pd

import rustchain as rc

TIMES = np.array([4e-3, 4.5e-3, 5e-3, 5.5e-3, 6e-3, 6.5e-3, 7e-3])  # [s]
FINEST = 2e-14


def positions(tolerance):
    """Positions of the links (times, 38, 2) of the drive without pretension."""
    simulation = rc.Simulation(
        rc.paper_drive(), solver=rc.Solver(rtol=tolerance, atol=tolerance, max_step=1e-4)
    )
    found = []
    for time in TIMES:
        simulation.step_to(float(time))
        found.append(simulation.positions[:38, :2].copy())
    return np.array(found)


def growth(tolerances=(1e-7, 1e-9, 1e-11)):
    """Largest error [m] of a link's position at each time, for each tolerance."""
    finest = positions(FINEST)
    return {
        tolerance: np.abs(positions(tolerance) - finest).max(axis=(1, 2))
        for tolerance in tolerances
    }


def growth_table(found):
    """Return the errors at whole milliseconds as a table."""
    whole = [k for k, time in enumerate(TIMES) if abs(1e3 * time - round(1e3 * time)) < 1e-9]
    columns = [f"{1e3 * TIMES[k]:g} ms" for k in whole]
    rows = [[f"{errors[k]:.0e} m" for k in whole] for errors in found.values()]
    index = pd.Index([f"{tolerance:g}" for tolerance in found], name="rtol = atol")
    return pd.DataFrame(rows, index=index, columns=columns)


def residuals(durations, tolerances=(1e-5, 1e-6, 1e-7)):
    """Residual at the end over the energy dissipated, steps a second, by pretension."""
    rows = {}
    for pretension, duration in durations.items():
        for tolerance in tolerances:
            simulation = rc.Simulation(
                rc.paper_drive(pretension), solver=rc.Solver(rtol=tolerance, atol=tolerance)
            )
            result = simulation.run(duration, record=("energy",), progress=False)
            share = result.energy.residual[-1] / result.energy.dissipated[-1]
            steps = result.stats["steps"] / duration
            rows[f"{pretension:g} N", f"{tolerance:g}"] = f"{share:.1e}", f"{steps:.2g}"
    index = pd.MultiIndex.from_tuples(rows, names=["pretension", "rtol = atol"])
    heads = ["residual over dissipated energy", "steps a second"]
    return pd.DataFrame(list(rows.values()), index=index, columns=heads)


def correctors(pretension=100.0, duration=2e-3):
    """Steps of each corrector over a time after the ramp of the tensioner, by tolerance."""
    before = rc.Simulation(rc.paper_drive(pretension))
    before.step_to(0.1)
    start = {"positions": before.positions, "velocities": before.velocities}
    rows = {}
    for method in ("pece", "newton"):
        for tolerance in (1e-5, 1e-7):
            solver = rc.Solver(method=method, rtol=tolerance, atol=tolerance)
            simulation = rc.Simulation(rc.paper_drive(pretension), solver=solver, **start)
            stats = simulation.run(duration, record=("energy",), progress=False).stats
            rows[method, f"{tolerance:g}"] = f"{stats['steps'] / duration:.2g}"
    return pd.Series(rows, name="steps a second").to_frame()
