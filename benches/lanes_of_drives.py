"""Efficiency that eight drives of one structure would have in the lanes of one SIMD vector.

Runs eight drives, takes every step of each (size, evaluations, rejected attempts, matrices), and
prints inputs and results of docs/development/lanes-of-drives.md.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

import rustchain as rc

RAMP, LEAD, DURATION = 0.02, 0.04, 0.02  # of the tensioner's force, before steps count [s]
ROW = 2.5e-7  # resolution of the ends of steps [s]
# Shares of the time of a step with one evaluation and a new matrix, 1.58 us at 25 N: a further
# evaluation with its solution, and the matrix with its factors (decision 23).
EVALUATION, MATRIX = (0.402 + 0.254) / 1.58, 0.6 / 1.58

SETS = {
    "25 N, 12.5 to 13.0 rad/s": [(25.0, 12.5 + 0.07 * k) for k in range(8)],
    "25 to 100 N, 12.6 rad/s": [(n, 12.6) for n in np.linspace(25.0, 100.0, 8)],
    "25 N, 5 to 25 rad/s": [(25.0, speed) for speed in np.linspace(5.0, 25.0, 8)],
    "0 N, 5 to 25 rad/s": [(0.0, speed) for speed in np.linspace(5.0, 25.0, 8)],
    "25 and 100 N, 5 to 25 rad/s": [
        (n, speed) for n in (25.0, 100.0) for speed in np.linspace(5.0, 25.0, 4)
    ],
}
COUNTS = ("steps", "rejected", "evaluations", "jacobians", "onsets")


def simulation_of(pretension: float, speed: float) -> rc.Simulation:
    """Return the published drive after the ramp."""
    drive = rc.paper_drive(pretension)
    driver, driven = drive.sprockets
    driver = replace(driver, motion=rc.PrescribedSpeed(speed))
    tensioner = drive.tensioner and replace(drive.tensioner, ramp_time=RAMP)
    simulation = rc.Simulation(replace(drive, sprockets=[driver, driven], tensioner=tensioner))
    simulation.step_to(LEAD)
    return simulation


def history(pretension: float, speed: float, duration: float) -> np.ndarray:
    """Return a row for each step: its end [s], and counts of `COUNTS` in it, but for the steps."""
    simulation, rows = simulation_of(pretension, speed), []

    def look(now: rc.Simulation) -> None:
        stats = now.stats
        if not rows or stats["steps"] != rows[-1][1]:
            rows.append((now.time, *(stats[name] for name in COUNTS)))

    simulation.run(duration, ROW, record=(), callback=look, progress=False)
    table, found = np.array(rows), []
    for (end, steps, *counts), before in zip(table[1:], table[:-1], strict=True):
        made = int(steps - before[1])
        share = (np.array(counts) - before[2:]) / made
        # Those that end between two rows are taken as equal.
        found += [(end - ROW * (made - 1 - k) / made, *share) for k in range(made)]
    return np.array(found)


def cost(evaluations: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """Return the time of attempts over that of one with one evaluation and a new matrix."""
    return 1.0 - MATRIX + EVALUATION * (evaluations - 1.0) + MATRIX * matrices


def attempts(steps: np.ndarray) -> np.ndarray:
    """Return evaluations and new matrices of each attempt, rejected ones before their step."""
    found = []
    for _, rejected, evaluations, matrices, _ in steps:
        tries = round(rejected) + 1
        each = max(evaluations / tries, 1.0), min(matrices / tries, 1.0)
        found += [each] * tries
    return np.array(found)


def own_times(drives: list[np.ndarray]) -> float:
    """Return the efficiency where each lane has its own time: an attempt takes as the slowest."""
    lanes = [attempts(steps) for steps in drives]
    length = min(map(len, lanes))  # another case takes the place of one that has ended
    costs = np.array([cost(*lane[:length].T) for lane in lanes])
    together = cost(*np.array([lane[:length].T for lane in lanes]).max(axis=0))
    return float(costs.mean(axis=0).sum() / together.sum())


def common_step(drives: list[np.ndarray]) -> float:
    """Return the efficiency where all lanes take the shortest step of them."""
    begin, end = max(one[0, 0] for one in drives), min(one[-1, 0] for one in drives)
    grid = np.arange(begin + 0.5 * ROW, end, ROW)
    rates = []
    for steps in drives:
        sizes = np.diff(steps[:, 0])
        rates.append(1.0 / sizes[np.searchsorted(steps[1:, 0], grid)])
    return float(np.mean(rates, axis=0).sum() / np.max(rates, axis=0).sum())


def main() -> None:
    """Print a line for each set of drives."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="one set, 1 ms")
    duration = 1e-3 if parser.parse_args().test else DURATION
    for name, cases in list(SETS.items())[: 1 if duration < DURATION else None]:
        drives = [history(*case, duration) for case in cases]
        tries = np.concatenate([attempts(steps) for steps in drives])
        steps = np.concatenate(drives)
        size = np.concatenate([np.diff(one[:, 0]) for one in drives])
        print(
            f"{name}: steps {[len(one) for one in drives]}; "
            f"sizes, 10, 50, 90 %: {1e6 * np.quantile(size, (0.1, 0.5, 0.9))} us; "
            f"attempts {len(tries) / len(steps):.3f} a step, more than one evaluation "
            f"{np.mean(tries[:, 0] > 1):.1%}, new matrix {np.mean(tries[:, 1]):.1%}; "
            f"steps with onset {np.mean(steps[:, 4] > 0):.1%}; "
            f"efficiency own times {own_times(drives):.2f}, common step {common_step(drives):.2f}"
        )


if __name__ == "__main__":
    main()
