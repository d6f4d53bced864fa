"""The scenes of the comparison, and a line of the table for every method and tolerance."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from least_times import least_of

from . import own, peers
from .peers import Run, Start

HERE = Path(__file__).parent
OWN = {
    "newton": "rustchain Newton",
    "pece": "rustchain PECE",
    "pece, rtol": "rustchain PECE, rtol",
    "auto": "rustchain auto",
}
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
    residual: float  # energy missing over dissipated by the reference, root mean square
    runs: int
    note: str
    times: list[float] = field(default_factory=list)  # `wall` of each timed run
    difference: float = np.nan  # of the times that two halves of equal runs have; median


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


# A point is timed again while its timed runs took less than this: first for one, then for more [s].
LITTLE = (1.0, 0.2)
# A timed run is made of equal ones: each of its parts counts with its least time. There are so
# many, and fewer where they take more time together, but never less than the lower number [s].
EQUAL_RUNS = (6, 12)
EQUAL_TIME = 1.5


@dataclass
class Point:
    """One method at one tolerance: its timed runs, and those whose energy is metered."""

    method: str
    tolerance: float
    run: Callable[[float, bool], Run]  # of a tolerance, and whether energy is metered
    runs: int  # metered ones
    budget: float  # [s] of all runs; there is always one of each kind
    timed: list[Run] = field(default_factory=list)
    metered: list[Run] = field(default_factory=list)
    spent: float = 0.0  # by timed runs [s]
    differences: list[float] = field(default_factory=list)  # of two halves of equal runs

    def begin(self, turn, repeats, spread):
        """Begin a turn; the tolerances of turns differ by the share `spread`."""
        self.turn, self.equal, self.equal_time = turn, [], 0.0
        self.of_turn = self.tolerance * (1.0 + spread * turn)
        self.is_timed = turn < repeats and self.spent < LITTLE[turn > 1] and self._may(self.timed)

    def time(self):
        """Make one of the equal runs of this turn, if there are not enough."""
        fewest, most = EQUAL_RUNS
        enough = len(self.equal) >= (fewest if self.equal_time > EQUAL_TIME else most)
        failed = self.equal and not self.equal[-1].finished
        if self.is_timed and not enough and not failed:
            self.equal.append(self.run(self.of_turn, False))
            self.equal_time += self.equal[-1].wall

    def end(self):
        """End a turn: make its metered run, and one timed run of the equal ones."""
        if self.equal:
            self.timed.append(self._of_equal())
        if self.turn < self.runs and self._may(self.metered):
            self.metered.append(self.run(self.of_turn, True))

    def _of_equal(self):
        """Return the last of the equal runs, with the least time of each of its parts."""
        run = self.equal[-1]
        if run.finished:
            least = least_of([run.parts for run in self.equal])
            run.wall = least.seconds - min(run.deducted for run in self.equal)
            self.differences.append(least.difference)
        self.spent += run.wall
        return run

    def _may(self, done):
        made = self.timed + self.metered
        if not all(run.finished for run in made):
            return False
        return not done or sum(run.wall for run in made) < self.budget


def points_of(start, end, plan):
    """Points of this project's methods and of the other solvers in compiled code."""

    def own_run(method):
        return lambda tol, energy: own.run(start, method, tol, end, energy)

    def other_run(method):
        return lambda tol, energy: peers.compiled(
            start, method, tol, end, wall=plan.budget, metered=energy
        )[0]

    points = [
        Point(OWN[m], tol, own_run(m), plan.runs, plan.budget_of_own_point)
        for m, tolerances in plan.own.items()
        for tol in tolerances
    ]
    return points + [
        Point(m, tol, other_run(m), plan.other_runs, plan.budget_of_point)
        for m, tolerances in plan.compiled.items()
        for tol in tolerances
    ]


def take_turns(points, plan, spread=0.0):
    """Make all runs, a turn of every point after the other: a busy while slows all alike.

    Every turn begins with another point: what runs after another solver finds cold caches.
    """
    for turn in range(max(plan.repeats, plan.runs, plan.other_runs)):
        first = turn % len(points)
        in_turn = points[first:] + points[:first]
        for point in in_turn:
            point.begin(turn, plan.repeats, spread)
        for _ in range(EQUAL_RUNS[1]):
            for point in in_turn:
                point.time()
        for point in in_turn:
            point.end()


def line_of(scene, point, duration, dissipated=np.nan, position_error=np.nan):
    """One line: means of the counts; time as their steps at the least time of one.

    Runs that differ a little take different numbers of steps, and other work on the machine only
    ever adds time. `dissipated` is the scene's, the same for all methods [J].
    """
    made = point.timed + point.metered
    failed = [run for run in made if not run.finished]
    timed = [run for run in point.timed if run.finished]
    if not timed:
        run = failed[0]
        wall, times = run.wall / max(min(run.reached, duration), 1e-12), []
        counts = (run.steps, run.evaluations, run.jacobians, run.onsets)
        note = f"did not finish: {run.why}"
        residual, runs = np.nan, 0
    else:
        metered = [run for run in point.metered if run.finished]
        done = metered or timed
        counts = [
            float(np.mean([getattr(run, name) for run in done]))
            for name in ("steps", "evaluations", "jacobians", "onsets")
        ]
        times = [run.wall / run.steps * counts[0] / duration for run in timed]
        wall = min(times)
        shares = np.array([run.residual / dissipated for run in metered])
        residual = float(np.sqrt(np.mean(np.square(shares)))) if len(shares) else np.nan
        runs = len(done)
        note = f"{len(failed)} runs did not finish" if failed else ""
        if len(shares) and not np.isfinite(shares).all():
            note = "energy without bounds"
    return say(
        Line(
            scene,
            point.method,
            point.tolerance,
            wall,
            *counts,
            position_error,
            residual,
            runs,
            note,
            times,
            float(np.median(point.differences)) if point.differences else np.nan,
        )
    )


def reference(start, end):
    """Positions at `end` by PECE at two tight tolerances, and how far a fixed step is from it.

    Returns positions, both distances [m] and the energy dissipated [J].
    """
    tight, tighter = (own.run(start, "pece, rtol", tol, end, energy=True) for tol in (1e-12, 1e-13))
    fixed, _ = peers.compiled(start, "RK4", 5e-8 if end < 0.01 else 1e-7, end)
    doubt = link_error(tight.positions, tighter.positions)
    apart = link_error(fixed.positions, tighter.positions)
    print(f"  reference: 1e-12 and 1e-13 differ by {doubt:.1e} m; RK4 is {apart:.1e} m away")
    return tighter.positions, doubt, apart, tighter.dissipated


def dissipated_by(start, end, runs=4):
    """Energy that fine runs dissipate, and the largest distance of one from their mean [J]."""
    fine = [
        own.run(start, "auto", 1e-11 * (1.0 + 0.01 * i), end, energy=True).dissipated
        for i in range(runs)
    ]
    mean = float(np.mean(fine))
    return mean, float(np.abs(np.array(fine) - mean).max())


def path_scene(scene, start, end, plan):
    """Error in position at `end`, where the path does not yet depend on rounding.

    Root mean square of the timed runs, whose tolerances differ by a percent: one run may be near by
    chance. Returns lines, and of the reference its two doubts [m] and the energy that it dissipates
    [J].
    """
    print(scene)
    expected, doubt, apart, dissipated = reference(start, end)
    points = points_of(start, end, plan)
    take_turns(points, plan, spread=0.01)
    for method, tolerances in plan.scipy.items():
        for tolerance in tolerances:
            run, _ = peers.scipy_solver(start, method, tolerance, end, plan.budget)
            metered = [run] if run.finished else []
            points.append(Point(method, tolerance, peers.scipy_solver, 1, 0.0, [run], metered))
    lines = []
    for point in points:
        errors = [link_error(run.positions, expected) for run in point.timed if run.finished]
        error = float(np.sqrt(np.mean(np.square(errors)))) if errors else np.nan
        lines.append(line_of(scene, point, end, dissipated, error))
        lines[-1].runs = max(len(errors), lines[-1].runs)
    return lines, [doubt, apart, dissipated]


def energy_scene(scene, start, end, plan):
    """Energy residual over the energy dissipated, of runs whose tolerances differ by a percent.

    Returns lines, and the energy that fine runs dissipate with its scatter [J].
    """
    print(scene)
    dissipated, scatter = dissipated_by(start, end)
    print(f"  fine runs dissipate {dissipated:.4g} J, {scatter:.1e} J apart at most")
    points = points_of(start, end, plan)
    take_turns(points, plan, spread=0.01)
    return [line_of(scene, point, end, dissipated) for point in points], [dissipated, scatter]


def known_scene(scene, problem, end, error_of, plan, rust):
    """Error against a known solution; `rust` has this project's runs."""
    print(scene)
    lines = [
        say(
            Line(
                scene, OWN[line["method"]], line["tolerance"], min(line["walls"]), line["steps"],
                line["evaluations"], 0, 0, line["error"], np.nan, len(line["walls"]), "",
                line["walls"],
            )
        )
        for line in rust
    ]  # fmt: skip
    errors = {}

    def run(method):
        def of(tolerance, _):
            done, y = peers.compiled(problem, method, tolerance, end)
            errors[method, tolerance] = error_of(done, y)
            return done

        return of

    points = [
        Point(method, tolerance, run(method), 0, 1.0)
        for method, tolerances in plan.known.items()
        for tolerance in tolerances
    ]
    take_turns(points, plan)
    return lines + [
        line_of(scene, p, 1.0, position_error=errors[p.method, p.tolerance]) for p in points
    ]


def planet_error(_, y):
    """Distance of the planet from where every period ends."""
    return float(np.hypot(y[0] - 0.4, y[1]))


def check_right_hand_side():
    """Stop unless the other solvers see the accelerations that this project's `evaluate` gives."""
    import rustchain as rc

    for start in (Start(0.0), stored(25.0), stored(100.0)):
        sim = own.simulation(start, rc.Solver())
        with peers.System(start) as system:
            slope = system.slope(0.0, system.y)
            accelerations = sim.evaluate().accelerations[:-2]
            links = len(accelerations)
            coordinates = system.dimension // 2
            found = slope[coordinates : coordinates + 3 * links].reshape(3, links).T
        largest = np.maximum(np.abs(accelerations).max(axis=0), 9.81)
        apart = np.abs(found - accelerations).max(axis=0) / largest
        if not apart.max() < 1e-6:
            sys.exit(f"error: right-hand sides differ by {apart.max():.1e} at {start.pretension} N")


def check_impact_memory():
    """Stop unless RK4 ends where PECE does, after 15 contact onsets: 8e-12 m apart in 4.6 ms."""
    start, end = Start(0.0), 4.6e-3
    expected = own.run(start, "pece, rtol", 1e-12, end, energy=False)
    found, _ = peers.compiled(start, "RK4", 2.5e-7, end)
    apart = link_error(found.positions, expected.positions)
    if not apart < 1e-9:
        sys.exit(f"error: the other solvers have other contacts: positions differ by {apart:.1e} m")
