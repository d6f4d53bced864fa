"""Run time against error: this project's integrator and other solvers on the same right-hand side.

`make work-precision` builds what it needs, runs all scenes (45 minutes on an idle
machine) and writes docs/performance/work-precision.json, and from it the chart and the pages
work-precision.md and work-precision-tables.md. `--only SCENE`, as often as wanted, runs these alone
and puts them into the last full run's place; `--redraw` writes chart and pages of the last run;
`--test` runs a few short scenes (or those of `--only`, shortened) and writes nothing. Nothing is
written where the load of the machine or the spread of times is too large: such a scene runs again,
at most three times in all, and then the exit status is 1.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass, field

import numpy as np

from least_times import take_turns
from provenance import ROOT, provenance
from work_precision import own, peers, render, scenes
from work_precision.analysis import LOAD_LIMIT, disturbance, force_statistics
from work_precision.peers import Start

RECORD = ROOT / "docs/performance/work-precision.json"
ACCURACIES = [3e-9, 1e-9, 3e-10, 1e-10, 1e-11]
# Of all three where runs are short: from what is too loose to what rounding leaves.
ALL_ACCURACIES = [3e-8, *ACCURACIES, 1e-12, 1e-13, 1e-14, 3e-15]


@dataclass
class Plan:
    """Tolerances of each method, and how long and how often it may run."""

    own: dict = field(default_factory=dict)
    compiled: dict = field(default_factory=dict)
    scipy: dict = field(default_factory=dict)
    known: dict = field(default_factory=dict)
    repeats: int = 5  # timed, without metering; fewer of long ones
    runs: int = 8  # metered, of this project's methods
    other_runs: int = 3  # metered, of the other solvers
    budget: float = 8.0  # [s] of one run of another solver
    # After so much time a point gets no further run [s].
    budget_of_own_point: float = 9.0
    budget_of_point: float = 3.0


def decades(first, last, per_decade=1):
    """Tolerances from 10^first down to 10^last."""
    count = round((first - last) * per_decade) + 1
    return [float(f"{tol:.2g}") for tol in np.logspace(first, last, count)]


def path_plan():
    """Many tolerances: the runs are short. Those of "pece" span what rounding leaves of them."""
    methods = {
        "auto": list(ALL_ACCURACIES),
        "newton": list(ALL_ACCURACIES),
        "pece": list(ALL_ACCURACIES),
        "pece, rtol": [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11],
    }
    compiled = {
        "RK4": [6e-6, 2e-6, 6e-7, 2e-7],
        "Dormand-Prince 5(4)": decades(-8, -16),
        "DOP853": decades(-8, -16),
        "CVODE Adams, functional": decades(-8, -13),
        "CVODE Adams": decades(-8, -13),
        "CVODE BDF": decades(-8, -13),
    }
    return Plan(methods, compiled, repeats=8, runs=1, other_runs=1, budget=3.0, budget_of_point=1.0)


def loaded_path_plan():
    """Fewer: under load, explicit methods crawl."""
    plan = path_plan()
    plan.own["pece, rtol"] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10]
    plan.compiled |= {
        "RK4": [2e-6, 2e-7],
        "Dormand-Prince 5(4)": [1e-9, 1e-10, 1e-11, 1e-13],
        "DOP853": [1e-9, 1e-10, 1e-11, 1e-13],
        "CVODE Adams, functional": [1e-10],
    }
    return plan


def energy_plan(pretension):
    """Few: each point is several runs. Under 100 N an explicit one takes seconds."""
    methods = {
        "auto": [6e-9, *ACCURACIES[:2], 5e-10, *ACCURACIES[2:], 1e-12],
        "newton": [6e-9, *ACCURACIES[:2], 5e-10, *ACCURACIES[2:], 1e-12],
        "pece": list(ACCURACIES),
        "pece, rtol": [1e-5, 1e-6],
    }
    compiled = {
        "RK4": [2e-6, 5e-7],
        "Dormand-Prince 5(4)": [1e-9, 1e-10, 1e-11],
        "DOP853": [1e-9, 1e-10, 1e-11],
        "CVODE Adams, functional": [1e-9, 1e-10],
        "CVODE Adams": [1e-9, 1e-10, 1e-11],
        "CVODE BDF": [1e-9, 1e-10, 1e-11],
    }
    plan = Plan(methods, compiled)
    if pretension > 50.0:
        plan.own["pece"] = [1e-9, 1e-10, 1e-11]
        plan.compiled |= {
            "Dormand-Prince 5(4)": [1e-10, 1e-11],
            "DOP853": [1e-10],
            "CVODE Adams, functional": [1e-10],
        }
    return plan


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
ATTEMPTS = 3  # of a scene, until one is quiet
LONG = {"auto": [1e-9, 1e-10], "newton": [1e-10], "pece": [1e-10]}


def short(plan):
    """One tolerance of each, once."""
    for table in (plan.own, plan.compiled, plan.scipy, plan.known):
        for method in table:
            table[method] = table[method][1:2] or table[method][:1]
    plan.repeats, plan.runs, plan.other_runs, plan.budget = 1, 1, 1, 1.0
    return plan


@functools.cache
def rust_lines(tried):
    """Return the lines of benches/work_precision.rs."""
    command = ["cargo", "bench", "--quiet", "--bench", "work_precision"]
    command += ["--", "--test"] if tried else []
    print(" ".join(command), flush=True)
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"error: cargo bench --bench work_precision failed:\n{done.stderr}")
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def long_runs(duration):
    """Energy residual and statistics of forces; rows of a table. Under 100 N none of "pece"."""
    runs = [
        own.LongRun(Start(pretension), method, tolerance, duration)
        for pretension in (0.0, 25.0, 100.0)
        for method, tolerances in LONG.items()
        for tolerance in (tolerances if pretension < 50.0 or method != "pece" else [])
    ]
    take_turns(run.equal for run in runs)
    return [row_of(run) for run in runs]


def row_of(run):
    """Return the row of a long run."""
    result, energy = run.result, run.result.energy
    forces = force_statistics(result, 0.1 * run.duration)
    row = {
        "pretension": run.start.pretension,
        "method": scenes.OWN[run.method],
        "tolerance": run.tolerance,
        "wall": run.equal.least().seconds / run.duration,
        "steps": int(result.stats["steps"]),
        "residual": energy.residual[-1] / energy.dissipated[-1],
        "forces": {f"{what} {which}": values for (what, which), values in forces.items()},
    }
    print(
        f"  {row['pretension']:>5.0f} N  {row['method']:<20}{run.tolerance:>9.0e}"
        f"{row['wall']:>9.3g} s/s  residual {row['residual']:.1e}",
        flush=True,
    )
    return row


def last_run():
    """Return what was kept of the last full run."""
    return json.loads(RECORD.read_text(encoding="utf-8"))


class Record:
    """Results of the runs so far."""

    def __init__(self, tried, merged):
        self.tried = tried
        self.prepare = short if tried else (lambda plan: plan)
        blank = {name: {} for name in ("references", "load", "seconds", "machines")}
        blank |= {name: [] for name in ("lines", "rust", "long")}
        self.found = last_run() if merged else blank

    def paths(self, scene, start, end):
        """Keep a scene judged by positions."""
        plan = path_plan() if start.pretension == 0.0 else loaded_path_plan()
        if scene == "0 N, 6 ms":
            plan.scipy = dict(SCIPY)
        self.put(scene, *scenes.path_scene(scene, start, end, self.prepare(plan)))

    def energies(self, scene, pretension):
        """Keep a scene judged by its energy balance."""
        plan, end = self.prepare(energy_plan(pretension)), 0.02 if self.tried else 0.2
        self.put(scene, *scenes.energy_scene(scene, Start(pretension), end, plan))

    def known(self, scene, problem, kind, end):
        """Keep a scene with a known answer."""
        error = scenes.planet_error if kind == "kepler" else (lambda run, _: run.error)
        rust = [line for line in rust_lines(self.tried) if line["kind"] == kind]
        plan = self.prepare(Plan(known=dict(KNOWN), repeats=20, runs=0, other_runs=0))
        self.put(scene, scenes.known_scene(scene, problem, end, error, plan, rust))

    def put(self, scene, lines, reference=None):
        """Put a scene's lines in the place of those that it had."""
        others = [line for line in self.found["lines"] if line["scene"] != scene]
        self.found["lines"] = others + [vars(line) for line in lines]
        if reference is not None:
            self.found["references"][scene] = reference

    def rust(self):
        """Keep the times of instruction sets and of long chains."""
        self.found["rust"] = [
            line for line in rust_lines(self.tried) if line["kind"] in ("instructions", "links")
        ]

    def long(self):
        """Keep the long runs."""
        self.found["long"] = long_runs(0.05 if self.tried else 2.0)

    def why_disturbed(self, name, loads):
        """Say why the machine was not quiet before a scene, or during it; nothing where it was."""
        lines = [line for line in self.found["lines"] if line["scene"] == name]
        differences = [line["difference"] for line in lines]
        return "" if self.tried else disturbance(loads, differences)

    def make(self, name, scene):
        """Run one scene until the machine is quiet during it, at most `ATTEMPTS` times."""
        for _ in range(ATTEMPTS):
            why = self.attempt(name, scene)
            if not why:
                return
            print(f"{name}: {why}", flush=True)
        sys.exit(f"error: {name}: {why}. Nothing is written; run again on a quiet machine.")

    def attempt(self, name, scene):
        """Run one scene once; note how busy the machine was. Return why that was too much."""
        before = os.getloadavg()[0] if self.tried else faded_load()
        if why := self.why_disturbed(f"before {name}", [before]):
            return why
        begin = (time.perf_counter(), time.process_time())
        scene()
        seconds, own_seconds = time.perf_counter() - begin[0], time.process_time() - begin[1]
        self.found["load"][name] = [before, os.getloadavg()[0]]
        self.found["seconds"][name] = seconds
        self.found["machines"][name] = provenance()
        print(
            f"  {seconds:.0f} s, {own_seconds:.0f} s of them at work; "
            f"load {before:.1f} before, {os.getloadavg()[0]:.1f} after",
            flush=True,
        )
        return self.why_disturbed(name, self.found["load"][name])


def faded_load():
    """Return the load average, after at most five minutes: builds count in it after their end."""
    end = time.monotonic() + 300.0
    while os.getloadavg()[0] > LOAD_LIMIT and time.monotonic() < end:
        time.sleep(5.0)
    return os.getloadavg()[0]


def write(found):
    """Write the record with its verdicts, the chart and the pages."""
    found["verdicts"] = render.verdicts(found)
    RECORD.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    render.write(found, ROOT / "docs")


def all_scenes(record):
    """Return {name: what runs it}, in the order of the tables."""
    bind = functools.partial
    loaded = {pretension: scenes.stored(pretension) for pretension in (25.0, 100.0)}
    return {
        "rust": record.rust,
        "0 N, 5 ms": bind(record.paths, "0 N, 5 ms", Start(0.0), 5e-3),
        "0 N, 6 ms": bind(record.paths, "0 N, 6 ms", Start(0.0), 6e-3),
        "25 N, 20 ms": bind(record.paths, "25 N, 20 ms", loaded[25.0], 20e-3),
        "100 N, 20 ms": bind(record.paths, "100 N, 20 ms", loaded[100.0], 20e-3),
        "planet, 10 periods": bind(
            record.known, "planet, 10 periods", "kepler", "kepler", 20.0 * np.pi
        ),
        "pin, undamped": bind(record.known, "pin, undamped", 0.0, "pin", 3.5),
        "pin, damped": bind(record.known, "pin, damped", scenes.DAMPING, "damped_pin", 3.5),
        "0 N, 0.2 s": bind(record.energies, "0 N, 0.2 s", 0.0),
        "25 N, 0.2 s": bind(record.energies, "25 N, 0.2 s", 25.0),
        "100 N, 0.2 s": bind(record.energies, "100 N, 0.2 s", 100.0),
        "long": record.long,
    }


TRIED = ("rust", "0 N, 6 ms", "25 N, 20 ms", "pin, undamped", "0 N, 0.2 s", "long")


def main():
    """Run, judge, and write chart and tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="a few short scenes; write nothing")
    parser.add_argument("--redraw", action="store_true", help="write chart and pages again")
    parser.add_argument("--only", action="append", metavar="SCENE", help="one scene of the tables")
    options = parser.parse_args()
    if options.redraw and (options.only or options.test):
        parser.error("--redraw runs nothing: leave out --only and --test")
    if options.redraw:
        write(last_run())
        return
    begin = time.perf_counter()
    record = Record(options.test, merged=bool(options.only) and not options.test)
    scene_of = all_scenes(record)
    names = options.only or (TRIED if options.test else list(scene_of))
    for name in names:
        if name not in scene_of:
            parser.error(f"--only {name!r}: no such scene; one of {'; '.join(scene_of)}")
    peers.load()
    scenes.check_right_hand_side()
    scenes.check_impact_memory()
    print(
        f"{'method':<28}{'tolerance':>9}{'s/s':>11}{'steps':>10}{'evaluations':>11}"
        f"{'error':>11}{'residual':>11}"
    )
    for name in names:
        record.make(name, scene_of[name])
    found = record.found
    order = list(scene_of)
    found["lines"].sort(key=lambda line: order.index(line["scene"]))
    print("\n".join(render.verdicts(found)))
    print(f"{time.perf_counter() - begin:.0f} s")
    if not options.test:
        write(found)


if __name__ == "__main__":
    main()
