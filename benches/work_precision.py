"""Run time against error: this project's integrator and rivals on the same right-hand side.

`make work-precision` builds what it needs, runs all scenes (a quarter of an hour on an idle
machine) and writes the chart and the tables of docs/work-precision.md. `--test` runs a few short
scenes and writes nothing; `--redraw` makes chart and tables anew from the last full run.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from work_precision import own, peers, render, scenes
from work_precision.analysis import force_statistics
from work_precision.peers import Start

ROOT = Path(__file__).parent.parent
RECORD = ROOT / "docs/work-precision.json"


@dataclass
class Plan:
    """Tolerances of each method, and how long and how often it may run."""

    own: dict
    compiled: dict = field(default_factory=dict)
    scipy: dict = field(default_factory=dict)
    known: dict = field(default_factory=dict)
    repeats: int = 3
    runs: int = 8
    budget: float = 6.0  # [s] of one run
    # After so much time a point gets no further run [s].
    budget_of_own_runs: float = 10.0
    budget_of_runs: float = 3.0


def decades(first, last, per_decade=1):
    """Tolerances from 10^first down to 10^last."""
    count = round((first - last) * per_decade) + 1
    return [float(f"{tol:.2g}") for tol in np.logspace(first, last, count)]


def path_plan(methods):
    """Many tolerances: the runs are short."""
    own_tolerances = {
        "newton": decades(-8, -14),
        "pece": decades(-3, -11),
        "auto": decades(-8, -14),
    }
    compiled = {
        "RK4": [6e-6, 2e-6, 6e-7, 2e-7],
        "Dormand-Prince 5(4)": decades(-8, -16),
        "DOP853": decades(-8, -16),
        "CVODE Adams, functional": decades(-8, -13),
        "CVODE Adams": decades(-8, -13),
        "CVODE BDF": decades(-8, -13),
    }
    return Plan({m: own_tolerances[m] for m in methods}, compiled, budget=3.0)


def loaded_path_plan(methods):
    """Fewer: under load, explicit methods crawl."""
    plan = path_plan(methods)
    plan.own["pece"] = [1e-3, 1e-4, 1e-6, 1e-8]
    plan.compiled |= {
        "RK4": [2e-6, 2e-7],
        "Dormand-Prince 5(4)": [1e-9, 1e-10, 1e-11, 1e-13],
        "DOP853": [1e-9, 1e-10, 1e-11, 1e-13],
        "CVODE Adams, functional": [1e-10],
    }
    return plan


def energy_plan(methods):
    """Few: each point is several runs."""
    newton = [1e-8, 3e-9, 1e-9, 3e-10, 1e-10, 1e-11]
    own_tolerances = {"newton": newton, "pece": [1e-3, 1e-4, 1e-5], "auto": newton}
    compiled = {
        "RK4": [2e-6, 5e-7],
        "Dormand-Prince 5(4)": [1e-9, 1e-10, 1e-11],
        "DOP853": [1e-9, 1e-10, 1e-11],
        "CVODE Adams, functional": [1e-9, 1e-10],
        "CVODE Adams": [1e-9, 1e-10, 1e-11],
        "CVODE BDF": [1e-9, 1e-10, 1e-11],
    }
    return Plan({m: own_tolerances[m] for m in methods}, compiled)


SCIPY = {
    "SciPy RK45": [1e-6, 1e-9],
    "SciPy DOP853": [1e-6, 1e-9],
    "SciPy LSODA": [1e-6, 1e-9],
    "SciPy BDF": [1e-6],
    "SciPy Radau": [1e-6],
}
KNOWN = {
    "RK4": [0.05, 0.02, 0.01, 0.003, 0.001],
    "Dormand-Prince 5(4)": decades(-3, -13, 0.5),
    "DOP853": decades(-3, -13, 0.5),
    "CVODE Adams, functional": decades(-3, -11, 0.5),
    "CVODE BDF": decades(-3, -9, 0.5),
}


def short(plan):
    """One tolerance of each, once."""
    for table in (plan.own, plan.compiled, plan.scipy, plan.known):
        for method in table:
            table[method] = table[method][1:2]
    plan.repeats, plan.runs, plan.budget = 1, 1, 1.0
    return plan


def twin(tried):
    """Lines of the Rust twin."""
    command = ["cargo", "bench", "--quiet", "--bench", "work_precision", "--"]
    command.append("--test" if tried else "--json")
    print(" ".join(command), flush=True)
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"error: the Rust twin failed:\n{done.stderr}")
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def long_runs(methods, duration):
    """Energy residual and statistics of forces; rows of a table."""
    rows = []
    tolerances = {"newton": [1e-9, 1e-10], "pece": [1e-5], "auto": [1e-9]}
    for pretension in (0.0, 25.0, 100.0):
        for method in methods:
            for tolerance in tolerances[method]:
                result, wall = own.long_run(Start(pretension), method, tolerance, duration)
                energy = result.energy
                row = {
                    "pretension": pretension,
                    "method": scenes.OWN[method],
                    "tolerance": tolerance,
                    "wall": wall / duration,
                    "steps": result.stats["steps"],
                    "residual": energy.residual[-1] / energy.dissipated[-1],
                    "forces": {
                        f"{what} {which}": values
                        for (what, which), values in force_statistics(
                            result, 0.1 * duration
                        ).items()
                    },
                }
                print(
                    f"  {pretension:>5.0f} N  {row['method']:<20}{tolerance:>9.0e}"
                    f"{row['wall']:>9.3g} s/s  residual {row['residual']:.1e}",
                    flush=True,
                )
                rows.append(row)
    return rows


def main():
    """Run, judge, and write chart and tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="a few short scenes; write nothing")
    parser.add_argument("--redraw", action="store_true", help="from the last full run")
    options = parser.parse_known_args()[0]
    if options.redraw:
        render.write(json.loads(RECORD.read_text()), ROOT / "docs")
        return
    begin = time.perf_counter()
    peers.load()
    scenes.check_right_hand_side()
    methods = own.methods()
    tried = options.test
    prepare = short if tried else (lambda plan: plan)
    twins = twin(tried)
    print(
        f"{'method':<28}{'tolerance':>9}{'s/s':>11}{'steps':>10}{'evaluations':>11}"
        f"{'error':>11}{'residual':>11}"
    )
    lines, references = [], {}
    record = {
        "machine": render.machine(),
        "references": references,
        "lines": [],
        "twins": twins,
        "long": [],
    }

    def keep():
        record["lines"] = [vars(line) for line in lines]
        record["seconds"] = time.perf_counter() - begin
        if not tried:
            RECORD.write_text(json.dumps(record, indent=1) + "\n")

    loaded = {pretension: scenes.stored(pretension) for pretension in (25.0, 100.0)}
    paths = [
        ("0 N, 5 ms", Start(0.0), 5e-3),
        ("0 N, 6 ms", Start(0.0), 6e-3),
        ("25 N, 20 ms", loaded[25.0], 20e-3),
        ("100 N, 20 ms", loaded[100.0], 20e-3),
    ]
    for scene, start, end in paths[1:3] if tried else paths:
        plan = path_plan(methods) if start.pretension == 0.0 else loaded_path_plan(methods)
        if scene == "0 N, 6 ms":
            plan.scipy = dict(SCIPY)
        plan = prepare(plan)
        expected, *references[scene] = scenes.reference(start, end)
        lines += scenes.path_scene(scene, start, end, plan, expected)
        keep()
    known = [
        ("planet, 10 periods", "kepler", "kepler", 20.0 * np.pi),
        ("pin, undamped", 0.0, "pin", 3.5),
        ("pin, damped", scenes.DAMPING, "damped_pin", 3.5),
    ]
    for scene, problem, kind, end in known:
        lines += scenes.known_scene(
            scene,
            problem,
            end,
            scenes.planet_error if problem == "kepler" else (lambda run, _: run.error),
            prepare(Plan({}, known=dict(KNOWN))),
            [line for line in twins if line["kind"] == kind],
        )
    for pretension in (0.0,) if tried else (0.0, 25.0, 100.0):
        scene, end = f"{pretension:.0f} N, 0.2 s", 0.02 if tried else 0.2
        lines += scenes.energy_scene(scene, Start(pretension), end, prepare(energy_plan(methods)))
        keep()
    print("long runs")
    record["long"] = long_runs(methods[:1] if tried else methods, 0.05 if tried else 2.0)
    keep()
    print("\n".join(render.verdicts(record)))
    print(f"{time.perf_counter() - begin:.0f} s")
    if not tried:
        render.write(record, ROOT / "docs")


if __name__ == "__main__":
    main()
