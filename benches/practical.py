"""Cost of practical scenes at two accuracies: time, steps, rejected steps, evaluations, residual.

Prints a line for each run. With --write, the table goes into docs/performance/practical.md and the
numbers into practical.json beside it. Exit status 1: a scene does not end.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import rustchain as rc
from least_times import MOST_RUNS, Clock, EqualRuns, step, take_turns
from pages import put, table
from provenance import ROOT, provenance

sys.path.insert(0, str(ROOT / "tests" / "python"))
from checks.andrews import andrews

PAGE = ROOT / "docs" / "performance" / "practical.md"
NUMBERS = PAGE.with_suffix(".json")
ACCURACIES = (1e-10, 1e-9)  # [m]
MANY_REJECTED = 0.1  # share of the steps that were tried
LN = rc.LankaraniNikravesh


@dataclass(frozen=True)
class Practical:
    """A scene, made when it runs, and its duration [s]."""

    name: str
    scene: Callable[[], rc.Scene]
    duration: float


def example(name: str) -> rc.Scene:
    """Return the scene of a drive file among the examples."""
    return rc.load_scene(ROOT / "examples" / f"{name}.toml")


def drive(
    law: rc.ForceLaw | None = None, links: int = 60, **options: object
) -> Callable[[], rc.Scene]:
    """Return a maker of the drive of 17:25 teeth, ANSI 40, 1500 rpm, 5 N m."""
    return lambda: rc.Scene(
        rc.two_sprocket_drive(
            "ANSI 40", teeth=(17, 25), links=links, speed=rc.rpm(1500), torque=-5.0, **options
        ),
        **({} if law is None else {"force_law": law}),
    )


def timing_drive() -> rc.Scene:
    """Return the timing drive of the examples with a rail beside its tight strand."""
    scene = example("timing_drive")
    rail = rc.GuideRail(
        center=(0.0573, 0.2),
        direction=(-0.9967, 0.0813),
        length=0.2,
        material=scene.system.guides[0].material,
    )
    return replace(scene, system=replace(scene.system, guides=[*scene.system.guides, rail]))


def bar(m: rc.Mechanism, name: str, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Add a uniform bar of 2 kg/m from `start` to `end` [m]."""
    x, y = end[0] - start[0], end[1] - start[1]
    mass = 2.0 * math.hypot(x, y)
    middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]), math.atan2(y, x))
    m.add_body(name, mass, mass * (x * x + y * y) / 12.0, middle)


def pin(m: rc.Mechanism, name: str, bodies: tuple[str, str], ends: tuple[float, float]) -> None:
    """Add a pin of 10 mm with 50 um of radial clearance, at distances along two bars [m]."""
    m.add_clearance_joint(
        name,
        *bodies,
        bore_radius=5.05e-3,
        pin_radius=5e-3,
        law=rc.SurfaceContact(LN(), length=0.015),
        bore_point=(ends[0], 0.0),
        pin_point=(ends[1], 0.0),
    )


def five_bar() -> rc.Scene:
    """Return two driven cranks and two couplers, whose three pins have clearance."""
    m = rc.Mechanism()
    left, right, top = (-0.1, 0.12), (0.3, 0.12), (0.1, 0.27)
    coupler = math.dist(left, top)
    bar(m, "left crank", (-0.1, 0.0), left)
    bar(m, "right crank", (0.3, 0.0), right)
    bar(m, "left coupler", left, top)
    bar(m, "right coupler", right, top)
    m.add_revolute("left bearing", "ground", "left crank", at=(-0.1, 0.0))
    m.add_revolute("right bearing", "ground", "right crank", at=(0.3, 0.0))
    pin(m, "left pin", ("left crank", "left coupler"), (0.06, -0.5 * coupler))
    pin(m, "right pin", ("right crank", "right coupler"), (0.06, -0.5 * coupler))
    pin(m, "top pin", ("left coupler", "right coupler"), (0.5 * coupler, 0.5 * coupler))
    for side, share in (("left", 3.0), ("right", 2.0)):
        swing = rc.Sines([(share, 30.0, 0.0)])
        m.add_driver(f"{side} motor", "ground", f"{side} crank", speed=swing)
    return rc.Scene(m)


def slider_crank() -> rc.Scene:
    """Return a slider-crank at 5000 rpm whose wrist pin has 50 um of radial clearance."""
    m = rc.Mechanism(gravity=(0.0, 0.0))
    bar(m, "crank", (0.0, 0.0), (0.05, 0.0))
    bar(m, "rod", (0.05, 0.0), (0.17, 0.0))
    m.add_body("slider", 0.14, 1e-4, (0.17, 0.0, 0.0))
    m.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    m.add_revolute("crank pin", "crank", "rod", at=(0.05, 0.0))
    m.add_prismatic("guide", "ground", "slider", direction=(1.0, 0.0))
    pin(m, "wrist pin", ("slider", "rod"), (0.0, 0.06))
    m.add_driver("motor", "ground", "crank", speed=rc.rpm(5000))
    return rc.Scene(m)


def scenes() -> list[Practical]:
    """Return all scenes."""
    friction = rc.Coulomb(0.1)
    return [
        Practical("17:25, Lankarani-Nikravesh", drive(), 0.1),
        Practical("17:25, Coulomb 0.1", drive(LN(friction=friction)), 0.05),
        Practical("17:25, LuGre", drive(LN(friction=rc.LuGre(0.12, 0.1))), 0.02),
        Practical("17:25, film 0.1 Pa s", drive(LN(film=rc.LubricantFilm(0.1))), 0.02),
        Practical("17:25, Johnson, Hu-Guo", drive(rc.Johnson(damping="hu-guo")), 0.05),
        Practical("17:25, rollers as bodies", drive(rollers="bodies"), 0.05),
        Practical("17:25, ideal hinges", drive(hinges="ideal"), 0.1),
        Practical("timing drive, blade and rail", timing_drive, 0.1),
        Practical("conveyor, 402 links", lambda: example("conveyor_start"), 0.05),
        Practical("motorcycle at 60 km/h", lambda: example("motorcycle_chain"), 0.1),
        Practical("hoist", lambda: example("hoist_load"), 0.3),
        Practical("five-bar, clearance", five_bar, 0.5),
        Practical("slider-crank, clearance", slider_crank, 0.1),
        Practical("Andrews' mechanism", lambda: rc.Scene(andrews()[0]), 0.03),
    ]


class Measured:
    """A scene at an accuracy: equal runs by steps alone, and one with energies."""

    def __init__(self, case: Practical, accuracy: float, duration: float) -> None:
        scene = case.scene()
        # The default of mechanisms is a relative and an absolute tolerance in place of an accuracy.
        solver = replace(scene.solver, accuracy=accuracy, rtol=None, atol=None)
        self.scene = replace(scene, solver=solver)
        self.row = {"scene": case.name, "accuracy": accuracy, "duration": duration}
        self.runs = EqualRuns(self.step)

    def step(self, clock: Clock) -> None:
        """Advance from the start by steps alone."""
        simulation = rc.Simulation(self.scene)
        clock.begin()
        step(simulation, self.row["duration"], clock)

    def meter(self) -> str:
        """Run with energies; return why that failed."""
        try:
            result = rc.Simulation(self.scene).run(
                self.row["duration"], 1e-3, record=("energy",), progress=False
            )
        except rc.RustchainError as error:
            self.row["message"] = str(error)
            return self.row["message"]
        energy = result.energy
        exchanged = max(
            energy.dissipated[-1], *(np.ptp(e) for e in (energy.external_work, energy.kinetic))
        )
        residual = float(np.abs(energy.residual).max())
        self.row |= {
            **{name: int(result.stats[name]) for name in ("steps", "rejected", "evaluations")},
            "residual": residual,
            "dissipated": float(energy.dissipated[-1]),
            "relative": residual / float(exchanged),
            "message": "",
        }
        return ""

    def numbers(self) -> dict[str, object]:
        """Return time, counts and residual."""
        if not self.row["message"]:
            least = self.runs.least()
            self.row |= {"time": least.seconds, "difference": least.difference}
        return self.row


def all_scenes(only: str = "", short: bool = False) -> list[dict[str, object]]:
    """Return the numbers of the scenes with `only` in their name; short ones for tests."""
    made = [
        Measured(case, accuracy, 1e-3 if short else case.duration)
        for case in scenes()
        if only in case.name
        for accuracy in ACCURACIES
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ended = [one for one in made if not one.meter()]
        take_turns((one.runs for one in ended), 2 if short else MOST_RUNS)
    return [one.numbers() for one in made]


COLUMNS = (
    "scene",
    "s simulated",
    "accuracy [m]",
    "processor time [s]",
    "steps",
    "rejected",
    "evaluations",
    "residual [J]",
    "over exchanged",
)


def share_rejected(row: dict[str, object]) -> float:
    """Return the share of rejected steps among those that were tried."""
    return row["rejected"] / (row["steps"] + row["rejected"])


def cells_of(row: dict[str, object]) -> tuple[str, ...]:
    """Return the cells of a line of the table."""
    first = (row["scene"], f"{row['duration']:g}", f"{row['accuracy']:g}")
    if row["message"]:
        return (*first, row["message"], *[""] * (len(COLUMNS) - 4))
    return (
        *first,
        f"{row['time']:.3g}",
        f"{row['steps']}",
        f"{row['rejected']} ({share_rejected(row):.1%})",
        f"{row['evaluations']}",
        f"{row['residual']:.1e}",
        f"{row['relative']:.1e}",
    )


def findings(rows: list[dict[str, object]]) -> list[str]:
    """Return which scenes reject many steps, and which are slower at the looser accuracy."""
    ended = [row for row in rows if not row["message"]]
    found = [
        f"- {row['scene']} at {row['accuracy']:g} m: {share_rejected(row):.0%} rejected"
        for row in ended
        if share_rejected(row) > MANY_REJECTED
    ]
    by_scene: dict[str, dict[float, int]] = {}
    for row in ended:
        by_scene.setdefault(row["scene"], {})[row["accuracy"]] = row["evaluations"]
    tight, loose = ACCURACIES
    for name, counts in by_scene.items():
        if counts.get(loose, 0) > counts.get(tight, math.inf):
            ratio = counts[loose] / counts[tight]
            found.append(f"- {name}: {ratio:.2f} times the evaluations at {loose:g} m")
    return found


def with_table(page: str, found: dict[str, object]) -> str:
    """Return the text of the page with the table of these numbers."""
    rows = found["scenes"]
    differences = [row["difference"] for row in rows if not row["message"]]
    lines = [
        *table(COLUMNS, [cells_of(row) for row in rows]),
        "",
        f"Machine: {found['machine']}. Two halves of the equal runs differ by "
        f"{np.median(differences):.0%} in time (median of all lines; {max(differences):.0%} in "
        "one).",
        "",
        "Scenes with many rejected steps, or with more evaluations at the looser accuracy:",
        "",
        *(findings(rows) or ["- none"]),
    ]
    return put(page, "table", lines)


def write(found: dict[str, object]) -> None:
    """Write the numbers, and the table into its page."""
    NUMBERS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), found), encoding="utf-8")


def main() -> int:
    """Run what the command line requests."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="scenes whose name has this in it")
    parser.add_argument("--test", action="store_true", help="all scenes, 1 ms each")
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    options = parser.parse_args()
    if options.write and (options.only or options.test):
        parser.error("--write needs all scenes in full: leave out --only and --test")
    if not any(options.only in case.name for case in scenes()):
        names = "; ".join(case.name for case in scenes())
        parser.error(f"--only {options.only!r}: no such scene; one of {names}")
    rows = all_scenes(options.only, options.test)
    print("\n".join(" | ".join(cells) for cells in (COLUMNS, *map(cells_of, rows))))
    print("\n".join(findings(rows)))
    if options.write:
        write({"machine": provenance(), "scenes": rows})
    return int(any(row["message"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
