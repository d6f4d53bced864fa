"""Numerical stability: one quantity after the other, from one end of its range to the other.

Prints a table with the energy residual over the energy exchanged, the steps and the outcome of each
run; `--figure` draws it. Each run is short, some milliseconds to some turns of the drive.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import rustchain as rc
from outcomes import Outcome
from scenes import Trial
from workers import outcomes_of

LIMIT = 60.0  # of processor time of a run [s]


@dataclass(frozen=True)
class Run:
    """One run of a study: a job as random scenes are."""

    kind: str
    value: float
    unit: str
    given: Trial

    @property
    def name(self) -> str:
        """Value and unit."""
        return f"{self.value:g} {self.unit}".strip()

    def trial(self) -> Trial:
        """Return the scene and how it is run."""
        return self.given


def _published(pretension: float = 25.0, **laws: object) -> rc.Scene:
    return rc.Scene(rc.paper_drive(pretension=pretension), **laws)


def _of_chain(scene: rc.Scene, **fields: object) -> rc.Scene:
    """Return the scene with other fields of its chain."""
    drive = scene.drive
    return replace(scene, system=replace(drive, chain=replace(drive.chain, **fields)))


def _of_material(**fields: float) -> rc.Scene:
    scene = _published()
    return _of_chain(scene, material=replace(scene.drive.chain.material, **fields))


def _turning(speed: float) -> rc.Scene:
    """Return the published drive at a speed [rpm], which is reached in a turn or in 50 ms."""
    scene = _published(100.0)
    driver, driven = scene.drive.sprockets
    final = rc.rpm(speed)
    ramp = rc.PrescribedSpeed(((0.0, 0.0), (min(4.0 * math.pi / final, 0.05), final)))
    drive = replace(scene.drive, sprockets=[replace(driver, motion=ramp), driven])
    return replace(scene, system=drive)


def _double_pendulum(ratio: float) -> rc.Scene:
    """Return a heavy rod at the end of a light one, `ratio` times as heavy."""
    m = rc.Mechanism()
    for name, mass, x in (("light", 1.0 / ratio, 0.1), ("heavy", 1.0, 0.3)):
        m.add_body(name, mass, mass * 0.2**2 / 12.0, (x, 0.0, 0.0))
    m.add_revolute("first", "ground", "light", at=(0.0, 0.0))
    m.add_revolute("second", "light", "heavy", at=(0.2, 0.0))
    return rc.Scene(m)


def _hung(ratio: float) -> rc.Scene:
    """Return a shaken chain of 20 links with a load of `ratio` times an inner link's mass."""
    chain = rc.catalogue_chain("ANSI 40", 20)
    load = rc.LoadedEnd(ratio * chain.inner.mass)
    shaken = rc.AnchoredEnd((0.0, 0.0), (rc.Sines([(0.3, 60.0, 0.0)]), 0.0))
    ends = (shaken, load)
    return rc.Scene(rc.open_chain(chain, ends, 20), start="static")


def _clearance(value: float) -> rc.Scene:
    """Return the published drive with a clearance of the hinges; 0: with ideal hinges."""
    scene = _published()
    if value == 0.0:
        return replace(scene, system=replace(scene.drive, hinges="ideal"))
    hinge = scene.drive.chain.hinge
    return _of_chain(scene, hinge=replace(hinge, bore_radius=hinge.pin_radius + value))


def _links(count: float) -> rc.Scene:
    return rc.Scene(rc.two_sprocket_drive(links=int(count), speed=20.0, pretension=100.0))


def _stretched(share: float) -> rc.Scene:
    """Return a drive whose strands bear this share of the least breaking load."""
    strength = rc.chain_sizes()["ANSI 40"].strength
    drive = rc.two_sprocket_drive("ANSI 40", links=60, speed=20.0, pretension=share * strength)
    return rc.Scene(drive, start="static")


def _undamped(pretension: float) -> rc.Scene:
    return _published(pretension, force_law=rc.Hertz())


Make = Callable[[float], rc.Scene]
Study = tuple[str, str, Make, float | Callable[[float], float], Sequence[float]]

# Name, unit, scene of a value, duration [s] or that of a value, values.
STUDIES: tuple[Study, ...] = (
    ("mass ratio of rods", "", _double_pendulum, 1.0, (1.0, 1e2, 1e4, 1e6)),
    ("load over a link's mass", "", _hung, 0.2, (1.0, 1e2, 1e4, 1e6)),
    (
        "stiffness of all contacts",
        "",
        lambda f: _of_material(elastic_modulus=f * 2.07e11),
        0.1,
        (1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3),
    ),
    ("radial clearance", "m", _clearance, 0.1, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 0.0)),
    (
        "restitution",
        "",
        lambda e: _of_material(restitution=e),
        0.1,
        (0.01, 0.1, 0.3, 0.7, 0.95, 1.0),
    ),
    (
        "minimum impact velocity",
        "m/s",
        lambda v: _published(min_impact_velocity=v),
        0.1,
        (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    ),
    (
        "speed",
        "rpm",
        _turning,
        lambda rpm: min(0.2, 180.0 / rpm),  # two turns, a fifth of a second at most
        (1.0, 10.0, 100.0, 1e3, 3e3, 1e4, 2e4),
    ),
    ("links", "", _links, 0.005, (60.0, 200.0, 1000.0, 3000.0, 10000.0)),
    ("pretension over strength", "", _stretched, 0.1, (0.01, 0.1, 0.3, 0.6, 0.9)),
    ("undamped, pretension", "N", _undamped, 0.1, (1.0, 10.0, 25.0, 100.0)),
)


def runs(only: str = "") -> list[Run]:
    """Return the runs of all studies whose names have `only` in them."""
    return [
        Run(name, value, unit, Trial(make(value), lasts(value) if callable(lasts) else lasts))
        for name, unit, make, lasts, values in STUDIES
        if only in name
        for value in values
    ]


def share(outcome: Outcome) -> float:
    """Return the largest residual over the largest energy exchanged; NaN without a result."""
    exchanged = outcome.energy.get("exchanged", math.nan)
    return outcome.energy["residual"] / exchanged if exchanged > 0.0 else math.nan


def table(outcomes: Sequence[Outcome]) -> str:
    """Return the table of all runs."""
    lines = [
        "| study | value | residual over exchanged | steps | outcome |",
        "|---|---|---|---|---|",
    ]
    for o in outcomes:
        told = ", ".join([o.outcome, *o.warned])
        what = told if not o.message else f"{told}: {o.message}"
        lines.append(f"| {o.kind} | {o.name} | {share(o):.1e} | {o.steps} | {what} |")
    return "\n".join(lines)


def draw(runs: Sequence[Run], outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw the residual over the energy exchanged against the value, a panel for each study."""
    import matplotlib as mpl

    mpl.use("agg")
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys(run.kind for run in runs))
    figure, axes = plt.subplots(2, 5, figsize=(12.0, 4.6), sharey=True, layout="constrained")
    for axis, name in zip(axes.flat, names, strict=False):
        of_all = zip(runs, outcomes, strict=True)
        # A logarithmic axis has no zero.
        chosen = [(r, share(o), o) for r, o in of_all if r.kind == name and r.value > 0.0]
        axis.loglog([r.value for r, *_ in chosen], [s for _, s, _ in chosen], color="0.7", lw=1)
        for label, color in (("", "C0"), ("EnergyWarning", "C1")):
            marked = [(r, s) for r, s, o in chosen if ("EnergyWarning" in o.warned) == bool(label)]
            values = ([r.value for r, _ in marked], [s for _, s in marked])
            axis.plot(*values, "o", color=color, ms=4, label=label or "no warning")
        unit = f" [{chosen[0][0].unit}]" if chosen[0][0].unit else ""
        axis.set_xlabel(f"{name}{unit}", fontsize=9)
        axis.grid(alpha=0.3)
    for axis in axes[:, 0]:
        axis.set_ylabel("residual / exchanged", fontsize=9)
    axes.flat[0].legend(fontsize=8)
    figure.savefig(path, dpi=130)


def all_outcomes(chosen: Sequence[Run]) -> Iterator[Outcome]:
    """Yield the outcome of each run."""
    return outcomes_of(chosen, LIMIT)


def main() -> int:
    """Run the studies asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="studies whose name has this in it")
    parser.add_argument("--figure", type=Path, help="file of the figure")
    given = parser.parse_args()
    chosen = runs(given.only)
    outcomes = []
    for outcome in all_outcomes(chosen):
        outcomes.append(outcome)
        print(f"{outcome} {outcome.steps} steps, {outcome.seconds:.1f} s", flush=True)
    print(table(outcomes))
    if given.figure:
        draw(chosen, outcomes, given.figure)
    return int(any(outcome.failed for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
