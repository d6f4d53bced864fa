"""Cost of each feature of a drive, and throughput of sweeps.

Every feature is added alone to the published drive; all of them run in turn, round after round.
With --write, the tables go into docs/performance/features.md and the numbers into features.json
beside it.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import rustchain as rc
from least_times import MOST_RUNS, PARTS, Clock, EqualRuns, each_row, step, take_turns
from pages import put, table
from provenance import ROOT, provenance

PAGE = ROOT / "docs" / "performance" / "features.md"
NUMBERS = PAGE.with_suffix(".json")
PRETENSIONS = (25.0, 100.0)  # [N]
RAMP, LEAD, DURATION = 0.02, 0.04, 0.1  # of the tensioner's force, before the time counts [s]
ROUNDS = 5
FEW = 50  # rows
COUNTS = ("steps", "rejected", "evaluations", "energy_evaluations")
DAMPING = "lankarani-nikravesh"
ALL_ROWS, FEW_ROWS = "rows: default groups, to a file", "default groups, to a file, 50 rows"

LEAST, CASE = 1e-6, 0.05  # durations of the cases of a sweep [s]
STARTS = 8  # of all cases, in a round
AXES = {"pretension": np.linspace(10.0, 100.0, 10), "speed": np.linspace(5.0, 25.0, 20)}


def run(*record: str, **options: object) -> Callable[[rc.Simulation, float, Clock], None]:
    """Return a maker of runs that record these groups."""

    def made(simulation: rc.Simulation, duration: float, clock: Clock) -> None:
        rows = round(duration / options.get("report_step", 1e-4))
        if "out" not in options:  # a file is written by another thread, whose work has no part
            options["callback"] = each_row(clock, max(1, rows // PARTS))
        simulation.run(duration, record=record, progress=False, **options)

    return made


def peaks(simulation: rc.Simulation, duration: float, clock: Clock) -> None:
    """Run with the contacts in the record and few rows."""
    run("hinges", "teeth", report_step=duration / FEW)(simulation, duration, clock)


def to_file(simulation: rc.Simulation, duration: float, clock: Clock, few: bool = False) -> None:
    """Run with the rows of all default groups written to a file; or with few of them."""
    with tempfile.TemporaryDirectory() as folder:
        step = {"report_step": duration / FEW} if few else {}
        run("hinges", "teeth", "sprockets", "energy", out=f"{folder}/run.nc", **step)(
            simulation, duration, clock
        )


@dataclass(frozen=True)
class Feature:
    """A feature: what it changes in the drive, in the scene's keywords, and in the run."""

    name: str
    drive: Callable[[rc.ChainDrive], rc.ChainDrive] = lambda drive: drive
    keywords: dict[str, object] | None = None
    run: Callable[[rc.Simulation, float, Clock], None] = step


def with_chain(drive: rc.ChainDrive, **fields: object) -> rc.ChainDrive:
    """Return the drive with other fields of its chain."""
    return replace(drive, chain=replace(drive.chain, **fields))


def with_rollers(drive: rc.ChainDrive) -> rc.ChainDrive:
    """Return the drive with rollers that are bodies."""
    return replace(drive, chain=rc.paper_drive(rollers="bodies").chain)


def guided(drive: rc.ChainDrive, **fields: object) -> rc.ChainDrive:
    """Return the drive with a guide on its upper strand, which touches the bushings."""
    middle = 0.5 * drive.sprockets[1].center[0]
    if "radius" in fields:
        guide = rc.SmoothIdler(center=(middle, 0.0385 + fields["radius"]), **fields)
    else:
        guide = rc.GuideRail((middle, 0.0435), (0.0, -1.0), length=0.08, **fields)
    return replace(drive, guides=[guide])


def features() -> list[Feature]:
    """Return the default drive, then every feature."""
    kinds = {
        "Coulomb friction": {"friction": rc.Coulomb(0.1)},
        "LuGre friction": {"friction": rc.LuGre(0.12, 0.1)},
    }
    laws = (
        rc.EnhancedCylinder,
        rc.Johnson,
        rc.HertzCylinder,
        rc.Radzimovsky,
        rc.Esdu78035,
        rc.LiuConformal,
    )
    plates = rc.catalogue_chain("ANSI 40", 38, plates="elastic").link_stiffness
    arm = rc.GuideArm(pivot=(0.0267, 0.05), force=10.0, ramp_time=RAMP)
    return [
        Feature("default"),
        Feature("without gravity", lambda drive: replace(drive, gravity=(0.0, 0.0))),
        Feature("without damping", keywords={"force_law": rc.Hertz()}),
        *(
            Feature(f"{law.__name__}, same damping", keywords={"force_law": law(damping=DAMPING)})
            for law in laws
        ),
        *(
            Feature(f"{kind} {where}", keywords={law: rc.LankaraniNikravesh(**given)})
            for kind, given in kinds.items()
            for law, where in (
                ("hinge_law", "in hinges"),
                ("tooth_law", "on teeth"),
                ("force_law", "in both"),
            )
        ),
        Feature(
            "lubricant film in hinges",
            keywords={"hinge_law": rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))},
        ),
        Feature("rollers as bodies", with_rollers),
        Feature("elastic plates", partial(with_chain, link_stiffness=plates)),
        Feature("fixed rail", guided),
        Feature("blade: rail on an arm", partial(guided, arm=arm)),
        Feature("smooth idler", partial(guided, radius=0.015)),
        Feature("smooth idler that turns", partial(guided, radius=0.015, inertia=1e-6)),
        Feature("ideal hinges", lambda drive: replace(drive, hinges="ideal")),
        Feature('`method="newton"`', keywords={"solver": rc.Solver("newton")}),
        Feature('`method="pece"`', keywords={"solver": rc.Solver("pece")}),
        Feature("`accuracy=1e-9`", keywords={"solver": rc.Solver(accuracy=1e-9)}),
        Feature("rows: time alone", run=run()),
        Feature("peaks of hinges and teeth, 50 rows", run=peaks),
        *(
            Feature(f"rows: {group}", run=run(group))
            for group in ("hinges", "teeth", "sprockets", "bodies", "energy")
        ),
        Feature(
            "rows: default groups",
            run=run("hinges", "teeth", "sprockets", "energy"),
        ),
        Feature(
            "rows: all groups",
            run=run("hinges", "teeth", "sprockets", "bodies", "energy"),
        ),
        Feature(ALL_ROWS, run=to_file),
        Feature(FEW_ROWS, run=partial(to_file, few=True)),
    ]


def scene_of(feature: Feature, pretension: float, factor: float) -> rc.Scene:
    """Return the scene of a feature; its accuracy is multiplied."""
    drive = rc.paper_drive(pretension)
    drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=RAMP))
    scene = rc.Scene(feature.drive(drive), **(feature.keywords or {}))
    solver = replace(scene.solver, accuracy=factor * scene.solver.accuracy)
    return replace(scene, solver=solver)


class Measured:
    """Equal runs of a feature, all from the same state after the ramp, and counts of one."""

    def __init__(self, scene: rc.Scene, feature: Feature, lead: float, duration: float) -> None:
        self.simulation = rc.Simulation(scene)
        self.simulation.step_to(lead)
        self.before, state = self.simulation.stats, self.simulation.state()

        def run(clock: Clock) -> None:
            self.simulation.set_state(state)
            clock.begin()
            feature.run(self.simulation, duration, clock)

        self.runs = EqualRuns(run)

    def numbers(self) -> dict[str, float]:
        """Return processor time [s] and counts."""
        least, after = self.runs.least(), self.simulation.stats
        counts = {name: after[name] - self.before[name] for name in COUNTS}
        return {"time": least.seconds, "difference": least.difference, **counts}


def all_features(
    rounds: int, lead: float, duration: float, most: int = MOST_RUNS
) -> list[dict[str, object]]:
    """Return a row for every feature and pretension: medians, and quartiles of ratios."""
    keys = [(pretension, feature) for pretension in PRETENSIONS for feature in features()]
    runs: dict[tuple[float, str], list[dict[str, float]]] = {}
    for number in range(rounds):
        factor = 1.0 + 0.01 * (number - rounds // 2)
        made = [
            Measured(scene_of(feature, n, factor), feature, lead, duration) for n, feature in keys
        ]
        take_turns((one.runs for one in made), most)
        for (pretension, feature), one in zip(keys, made, strict=True):
            runs.setdefault((pretension, feature.name), []).append(one.numbers())
        print(f"round {number + 1} of {rounds}", flush=True)
    return [row(runs, pretension, feature.name) for pretension, feature in keys]


def row(
    runs: dict[tuple[float, str], list[dict[str, float]]], pretension: float, name: str
) -> dict[str, object]:
    """Return medians of a feature, and quartiles of its time over that of the default."""
    own, base = runs[pretension, name], runs[pretension, "default"]
    median = {
        key: statistics.median(one[key] for one in own) for key in ("time", "difference", *COUNTS)
    }
    ratios = [one["time"] / default["time"] for one, default in zip(own, base, strict=True)]
    low, ratio, high = np.quantile(ratios, (0.25, 0.5, 0.75))
    of_ratios = {"ratio": ratio, "quartiles": [low, high]}
    return {"pretension": pretension, "feature": name, **median, **of_ratios}


def measure(result: rc.Result) -> float:
    """Return what is kept of a case."""
    return float(result.peaks.tooth_force.max())


def sweep(duration: float, axes: dict[str, np.ndarray], **options: object) -> rc.SweepResult:
    """Run all cases."""
    return rc.sweep(rc.paper_drive(), axes, duration=duration, progress=False, **options)


def alone(duration: float, axes: dict[str, np.ndarray]) -> None:
    """Run the same cases one after the other, without a sweep."""
    for pretension in axes["pretension"]:
        for speed in axes["speed"]:
            drive = rc.paper_drive(pretension)
            driver, driven = drive.sprockets
            driver = replace(driver, motion=rc.PrescribedSpeed(speed))
            simulation = rc.Simulation(replace(drive, sprockets=[driver, driven]))
            measure(simulation.run(duration, progress=False))


WAYS: dict[str, Callable[[float, dict[str, np.ndarray]], object]] = {
    "single runs": alone,
    "`rc.sweep`, `threads=1`": partial(sweep, measure=measure, threads=1),
    "`rc.sweep`, `threads=2`": partial(sweep, measure=measure, threads=2),
}


def peak_memory() -> float:
    """Return the largest memory of this process so far [MB]."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / (1e6 if sys.platform == "darwin" else 1e6 / 1024.0)


def memory(duration: float, axes: dict[str, np.ndarray]) -> dict[str, float]:
    """Return the growth of the peak memory per case [MB]; the process must not have run others."""
    cases = np.prod([len(values) for values in axes.values()])
    few = {name: values[:4] for name, values in axes.items()}
    sweep(duration, few, measure=measure, threads=2)
    begin = peak_memory()
    sweep(duration, axes, measure=measure, threads=2)
    end = peak_memory()
    kept = sweep(duration, axes, threads=2)
    return {
        "measured": (end - begin) / cases,
        "kept": (peak_memory() - end) / cases,
        "rows": len(kept.results[0].time),
    }


def sweeps(rounds: int, duration: float, axes: dict[str, np.ndarray]) -> dict[str, object]:
    """Return throughput, start-up and memory of a sweep: medians, and the least start-up."""
    cases = int(np.prod([len(values) for values in axes.values()]))
    grown = memory(duration, axes)
    found: dict[str, dict[str, list[float]]] = {way: {} for way in WAYS}
    for number in range(rounds):
        for way, run_all in WAYS.items():
            for name, length in (*[("start-up", LEAST)] * STARTS, ("run", duration)):
                wall, begin = time.perf_counter(), time.process_time()
                run_all(length, axes)
                found[way].setdefault(name, []).append(time.process_time() - begin)
                found[way].setdefault(f"{name} wall", []).append(time.perf_counter() - wall)
        print(f"round {number + 1} of {rounds} of the sweep", flush=True)
    ways = {
        way: {name: statistics.median(times) for name, times in of_way.items()}
        | {"start-up": min(of_way["start-up"])}  # other load only adds time
        for way, of_way in found.items()
    }
    first, *_ = WAYS
    for way, of_way in found.items():
        pairs = zip(of_way["run"], found[first]["run"], strict=True)
        low, high = np.quantile([base / one for one, base in pairs], (0.25, 0.75))
        ways[way]["quartiles"] = [low, high]
    return {"cases": cases, "duration": duration, "memory": grown, "ways": ways}


COLUMNS = (
    "feature",
    "time",
    "quartiles",
    "steps",
    "time a step",
    "million steps a s",
    "evaluations a step",
    "of energies",
    "rejected",
    "µs a step",
)


def feature_lines(found: dict[str, object]) -> list[str]:
    """Return the tables of the features."""
    differences = [row["difference"] for row in found["features"]]
    lines = [
        f"Machine: {found['machine']}; load average {found['load'][0]:.1f} before and "
        f"{found['load'][1]:.1f} after the run, of which the run itself is 1. Medians of "
        f"{found['rounds']} rounds of {found['duration']:g} s. Two halves of the equal runs "
        f"differ by {statistics.median(differences):.1%} in time (median of all lines; "
        f"{max(differences):.0%} in one).",
    ]
    for pretension in PRETENSIONS:
        rows = [each for each in found["features"] if each["pretension"] == pretension]
        cells = [feature_cells(each, rows[0], found["duration"]) for each in rows]
        lines += ["", f"### {pretension:g} N", "", *table(COLUMNS, cells)]
        time_of = {each["feature"]: each["time"] for each in rows}
        begun = time_of[FEW_ROWS] - time_of["rows: energy"]
        row = (time_of[ALL_ROWS] - time_of[FEW_ROWS]) / max(found["duration"] / 1e-4 - FEW, 1.0)
        lines += ["", f"A file takes {1e3 * begun:.0f} ms, and {1e6 * row:.0f} µs for each row."]
    return lines


def feature_cells(one: dict[str, object], base: dict[str, object], duration: float):
    """Return the cells of a line."""
    spent, count = one["ratio"], one["steps"] / base["steps"]
    low, high = one["quartiles"]
    return (
        one["feature"],
        f"{spent:.2f}",
        f"{low:.2f} to {high:.2f}",
        f"{count:.2f}",
        f"{spent / count:.2f}",
        f"{1e-6 * one['steps'] / duration:.3g}",
        f"{one['evaluations'] / one['steps']:.2f}",
        f"{one['energy_evaluations'] / one['steps']:.2f}",
        f"{one['rejected'] / (one['steps'] + one['rejected']):.1%}",
        f"{1e6 * one['time'] / one['steps']:.3g}",
    )


def sweep_lines(found: dict[str, object]) -> list[str]:
    """Return the table of the sweep."""
    of = found["sweep"]
    simulated = of["cases"] * of["duration"]
    rows = [
        (
            way,
            f"{simulated / times['run']:.3g}",
            f"{times['quartiles'][0]:.2f} to {times['quartiles'][1]:.2f}",
            f"{simulated / times['run wall']:.3g}",
            f"{1e3 * times['start-up'] / of['cases']:.2f}",
        )
        for way, times in of["ways"].items()
    ]
    columns = (
        "cases",
        "simulated s per core second",
        "over single runs",
        "simulated s per s of wall time",
        "start-up of a case [ms]",
    )
    memory = of["memory"]
    return [
        f"{of['cases']} cases of {of['duration']:g} s:",
        "",
        *table(columns, rows),
        "",
        f"Peak memory grows by {memory['measured']:.2g} MB a case with `measure`, and by "
        f"{memory['kept']:.2g} MB where results of {memory['rows']} rows are kept.",
    ]


def with_tables(page: str, found: dict[str, object]) -> str:
    """Return the page with the tables of these numbers."""
    return put(put(page, "features", feature_lines(found)), "sweep", sweep_lines(found))


def main() -> None:
    """Run what the command line requests."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--test", action="store_true", help="one round of 1 ms, few cases")
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    options = parser.parse_args()
    if options.write and options.test:
        parser.error("--write needs all rounds: leave out --test")
    warnings.simplefilter("ignore")
    rounds, duration, case, axes = ROUNDS, DURATION, CASE, AXES
    lead = LEAD
    if options.test:
        rounds, lead, duration, case = 1, 1e-3, 1e-3, 1e-3
        axes = {name: values[:2] for name, values in AXES.items()}
    load = os.getloadavg()[0]
    of_sweep = sweeps((rounds + 1) // 2, case, axes)
    all_features(1, 1e-3, 1e-3, most=2)  # loads the modules that files need
    found = {
        "machine": provenance(),
        "rounds": rounds,
        "duration": duration,
        "features": all_features(rounds, lead, duration, 2 if options.test else MOST_RUNS),
        "sweep": of_sweep,
        "load": [load, os.getloadavg()[0]],
    }
    print("\n".join([*feature_lines(found), "", *sweep_lines(found)]))
    if options.write:
        NUMBERS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        page = with_tables(PAGE.read_text(encoding="utf-8"), found)
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
