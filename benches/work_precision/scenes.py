"""The scenes of the comparison, and a line of the table for every method and tolerance."""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import own, peers
from .peers import Start

HERE = Path(__file__).parent
OWN = {"newton": "rustchain Newton", "pece": "rustchain PECE", "auto": "rustchain auto"}
DAMPING = 0.75 * (1.0 - 0.71**2)


@dataclass
class Line:
    """One line of the table. Times in s, errors as the scene says, counts of one run (a mean)."""

    scene: str
    method: str
    tolerance: float
    wall: float  # per simulated second, or of the run where the problem has no unit of time
    steps: float
    evaluations: float
    jacobians: float
    onsets: float
    position_error: float  # [m], largest of all links; of the known solution where there is one
    residual: float  # energy missing over dissipated, root mean square of the runs
    runs: int
    note: str


def stored(pretension):
    """State at 0.15 s: positions and velocities, from which contacts begin without memory."""
    rows = list(csv.reader((HERE / f"state_{pretension:.0f}N.csv").open()))[1:]
    numbers = np.array([row[1:] for row in rows], dtype=np.float64)
    return Start(pretension, numbers[:, :3].copy(), numbers[:, 3:].copy())


def link_error(positions, expected):
    """Largest distance of a link's centre from where it should be [m]."""
    return float(np.hypot(*(positions - expected)[:-2, :2].T).max())


def say(line):
    """Print a line as it is made."""
    error = line.residual if np.isnan(line.position_error) else line.position_error
    print(
        f"  {line.method:<26}{line.tolerance:>9.1e}{line.wall:>11.3g}{line.steps:>10.0f}"
        f"{line.evaluations:>11.0f}{error:>11.1e}{line.residual:>11.1e}  {line.note}",
        flush=True,
    )
    return line


def line_of(scene, method, tolerance, runs, duration, position_error=np.nan):
    """One line of several runs: means of the counts; time as their steps at the least time of one.

    Runs that differ a little take different numbers of steps, and other work on the machine only
    ever adds time.
    """
    done = [run for run in runs if run.finished]
    if not done:
        run = runs[0]
        wall = run.wall / max(min(run.reached, duration), 1e-12)
        counts = (run.steps, run.evaluations, run.jacobians, run.onsets)
        note = f"did not finish: {run.why}"
        return say(Line(scene, method, tolerance, wall, *counts, np.nan, np.nan, 0, note))
    steps = np.mean([run.steps for run in done])
    wall = min(run.wall / run.steps for run in done) * steps / duration
    means = [
        float(np.mean([getattr(run, name) for run in done]))
        for name in ("evaluations", "jacobians", "onsets")
    ]
    shares = [run.residual / run.dissipated for run in done if run.dissipated > 0.0]
    residual = float(np.sqrt(np.mean(np.square(shares)))) if shares else np.nan
    note = "" if len(done) == len(runs) else f"{len(runs) - len(done)} runs did not finish"
    return say(
        Line(
            scene, method, tolerance, wall, steps, *means, position_error, residual, len(done), note
        )
    )


def reference(start, end):
    """Positions at `end` by PECE at two tight tolerances, and how far a fixed step is from it."""
    tight, tighter = (own.run(start, "pece", tol, end, energy=False) for tol in (1e-12, 1e-13))
    fixed, _ = peers.compiled(start, "RK4", 5e-8 if end < 0.01 else 1e-7, end)
    doubt = link_error(tight.positions, tighter.positions)
    apart = link_error(fixed.positions, tighter.positions)
    print(f"  reference: 1e-12 and 1e-13 differ by {doubt:.1e} m; RK4 is {apart:.1e} m away")
    return tighter.positions, doubt, apart


def repeated(plan, run):
    """Return runs for the least time; long ones are long enough to be timed once."""
    runs = [run()]
    while len(runs) < plan.repeats and runs[-1].finished and runs[-1].wall < 0.3:
        runs.append(run())
    return runs


def path_scene(scene, start, end, plan, expected):
    """Error in position at `end`, where the path does not yet depend on rounding."""
    print(scene)
    lines = []
    for method, tolerances in plan.own.items():
        for tolerance in tolerances:
            runs = repeated(
                plan, lambda m=method, tol=tolerance: own.run(start, m, tol, end, energy=False)
            )
            error = link_error(runs[0].positions, expected) if runs[0].finished else np.nan
            energy = own.run(start, method, tolerance, end, energy=True)
            runs[0].residual, runs[0].dissipated = energy.residual, energy.dissipated
            lines.append(line_of(scene, OWN[method], tolerance, runs, end, error))
    for method, tolerances in plan.compiled.items():
        for tolerance in tolerances:
            runs = repeated(
                plan,
                lambda m=method, tol=tolerance: peers.compiled(
                    start, m, tol, end, wall=plan.budget
                )[0],
            )
            error = link_error(runs[0].positions, expected) if runs[0].finished else np.nan
            lines.append(line_of(scene, method, tolerance, runs, end, error))
    for method, tolerances in plan.scipy.items():
        for tolerance in tolerances:
            run, _ = peers.scipy_solver(start, method, tolerance, end, plan.budget)
            error = link_error(run.positions, expected) if run.finished else np.nan
            lines.append(line_of(scene, method, tolerance, [run], end, error))
    return lines


def energy_scene(scene, start, end, plan):
    """Energy residual over the energy dissipated, of runs whose tolerances differ by a percent."""
    print(scene)
    lines = []

    def several(name, tolerance, run, budget):
        runs, spent = [], 0.0
        for i in range(plan.runs):
            runs.append(run(tolerance * (1.0 + 0.01 * i)))
            spent += runs[-1].wall
            if not runs[-1].finished or spent > budget:
                break
        lines.append(line_of(scene, name, tolerance, runs, end))

    for method, tolerances in plan.own.items():
        for tolerance in tolerances:
            several(
                OWN[method],
                tolerance,
                lambda tol, m=method: own.run(start, m, tol, end, energy=True),
                plan.budget_of_own_runs,
            )
    for method, tolerances in plan.compiled.items():
        for tolerance in tolerances:
            several(
                method,
                tolerance,
                lambda tol, m=method: peers.compiled(start, m, tol, end, wall=plan.budget)[0],
                plan.budget_of_runs,
            )
    return lines


def known_scene(scene, problem, end, error_of, plan, twins):
    """Error against a known solution; `twins` are this project's runs, made in Rust."""
    print(scene)
    lines = [
        say(
            Line(
                scene, OWN["pece"], twin["tolerance"], twin["wall"], twin["steps"],
                twin["evaluations"], 0, 0, twin["error"], np.nan, twin["repeats"], "",
            )
        )
        for twin in twins
    ]  # fmt: skip
    for method, tolerances in plan.known.items():
        for tolerance in tolerances:
            results = [peers.compiled(problem, method, tolerance, end) for _ in range(20)]
            runs = [run for run, _ in results]
            error = error_of(*results[0])
            lines.append(line_of(scene, method, tolerance, runs, 1.0, error))
    return lines


def planet_error(_, y):
    """Distance of the planet from where every period ends."""
    return float(np.hypot(y[0] - 0.4, y[1]))


def check_right_hand_side():
    """Stop unless rivals see the accelerations that this project's `evaluate` gives."""
    import rustchain as rc

    for start in (Start(0.0), stored(25.0), stored(100.0)):
        sim = own.simulation(start, rc.Solver())
        with peers.System(start) as system:
            slope = system.slope(0.0, system.y)
            accelerations = sim.evaluate().accelerations[:-2]
            links = len(accelerations)
            coordinates = (system.dimension - 2) // 2
            found = slope[coordinates : coordinates + 3 * links].reshape(3, links).T
        largest = np.maximum(np.abs(accelerations).max(axis=0), 9.81)
        apart = np.abs(found - accelerations).max(axis=0) / largest
        if not apart.max() < 1e-6:
            sys.exit(f"error: right-hand sides differ by {apart.max():.1e} at {start.pretension} N")
