"""Long runs of the published drive: statistics, energy residual, memory, time per second.

Each pretension is one `run` with its rows in a file. Memory and processor time are read in the run,
every simulated second. Prints one table; `--figure` draws residual, memory and processor time.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy import stats

import rustchain as rc

Array = npt.NDArray[np.float64]

REPORT_STEP = 0.01  # of 0.029 s a tooth; peaks between rows are recorded too
SETTLED = 20.0  # rows before this time [s] are left out of the statistics
QUARTERS, BATCHES = (
    4,
    15,
)  # batches of a quarter are longer than the correlation of what they average
LEVEL = 0.01  # of the test that all quarters have one mean, for all quantities of a run together

# Rows of a run, and what is averaged over hinges or bushings.
QUANTITIES: dict[str, tuple[str, Callable[[Array], Array]]] = {
    "tension of the upper strand [N]": ("strand_tension", lambda rows: rows[:, 0]),
    "tension of the lower strand [N]": ("strand_tension", lambda rows: rows[:, 1]),
    "largest hinge force of a row [N]": ("peak_hinge_force", lambda rows: rows.max(axis=1)),
    "largest tooth force of a row [N]": ("peak_tooth_force", lambda rows: rows.max(axis=1)),
    "square of the ripple [rad²/s²]": (
        "sprocket_speed",
        lambda rows: (rows[:, 1] - rows[:, 1].mean()) ** 2,
    ),
}


@dataclass
class Ran:
    """A run: what was read each simulated second, and its file."""

    pretension: float
    path: Path
    time: list[float] = field(default_factory=list)
    spent: list[float] = field(default_factory=list)
    """Processor time since the beginning [s]."""
    memory: list[float] = field(default_factory=list)
    """Resident memory [MB]."""
    steps: int = 0


def resident() -> float:
    """Return the resident memory of this process [MB]; Linux."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def run(pretension: float, duration: float, accuracy: float, folder: Path) -> Ran:
    """Run the drive and write its rows and the figures of each second to `folder`."""
    ran = Ran(pretension, folder / f"{pretension:g}N.nc")
    scene = rc.Scene(rc.paper_drive(pretension=pretension), solver=rc.Solver(accuracy=accuracy))
    simulation = rc.Simulation(scene)
    begin = time.process_time()

    def read(simulation: rc.Simulation) -> None:
        if simulation.time >= len(ran.time):
            ran.time.append(simulation.time)
            ran.spent.append(time.process_time() - begin)
            ran.memory.append(resident())

    groups = ("hinges", "teeth", "sprockets", "energy")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rc.EnergyWarning)  # the table has the residual
        result = simulation.run(
            duration, REPORT_STEP, record=groups, progress=False, callback=read, out=ran.path
        )
    ran.steps = int(result.stats["steps"])
    if not result.success:  # Ctrl-C ends a run early: what there is counts
        print(f"{pretension:g} N: {result.status}: {result.message}", flush=True)
    kept = {name: value for name, value in vars(ran).items() if name != "path"}
    ran.path.with_suffix(".json").write_text(json.dumps(kept))
    return ran


def known(path: Path) -> Ran:
    """Return the run that wrote this file before."""
    return Ran(path=path, **json.loads(path.with_suffix(".json").read_text()))


def batch_means(rows: Array) -> Array:
    """Return the means of batches, (quarters, batches)."""
    length = len(rows) // (QUARTERS * BATCHES)
    return rows[: length * QUARTERS * BATCHES].reshape(QUARTERS, BATCHES, length).mean(axis=2)


def correlation(means: Array) -> float:
    """Return the correlation of one batch with the next one, within quarters."""
    off = means - means.mean(axis=1, keepdims=True)
    return float((off[:, 1:] * off[:, :-1]).sum() / (off**2).sum())


@dataclass(frozen=True)
class Quarters:
    """Means of the quarters of a run, half widths of 95 % intervals, and the test of one mean."""

    name: str
    mean: Array
    half: Array
    chance: float
    """Of means that differ as much as these or more, if the quarters have one mean."""
    next_batch: float
    """Correlation of a batch with the next one: near zero, as the intervals assume."""


def quarters(name: str, rows: Array) -> Quarters:
    """Compare the quarters of a recorded quantity by their batches (analysis of variance)."""
    means = batch_means(rows)
    half = stats.t.ppf(0.975, BATCHES - 1) * means.std(axis=1, ddof=1) / np.sqrt(BATCHES)
    chance = float(stats.f_oneway(*means).pvalue)
    return Quarters(name, means.mean(axis=1), half, chance, correlation(means))


def statistics(ran: Ran) -> list[Quarters]:
    """Return the quarters of all quantities, of dissipated power and of the residual's growth."""
    arrays = rc.load_result(ran.path).arrays
    settled = arrays["time"] >= SETTLED
    found = [quarters(name, of(arrays[key][settled])) for name, (key, of) in QUANTITIES.items()]
    for name, key in (
        ("power dissipated [W]", "dissipated"),
        ("growth of the residual [W]", "residual"),
    ):
        rate = np.diff(arrays[f"energy_{key}"][settled]) / REPORT_STEP
        found.append(quarters(name, rate))
    return found


def table(runs: Sequence[Ran]) -> str:
    """Return the quarters of each run, and its memory and processor time."""
    lines = ["| pretension | quantity | quarter 1 | 2 | 3 | 4 | chance |", "|---" * 7 + "|"]
    for ran in runs:
        for row in statistics(ran):
            pairs = zip(row.mean, row.half, strict=True)
            cells = " | ".join(f"{mean:.4g} ± {half:.2g}" for mean, half in pairs)
            lines.append(f"| {ran.pretension:g} N | {row.name} | {cells} | {row.chance:.2g} |")
    lines += ["", "| pretension | " + " | ".join(COSTS) + " |", "|---" * (len(COSTS) + 1) + "|"]
    for ran in runs:
        lines.append(f"| {ran.pretension:g} N | " + " | ".join(costs(ran)) + " |")
    return "\n".join(lines)


COSTS = (
    "simulated time",
    "steps",
    "residual over dissipated",
    "memory at 20 s, at the end, largest",
    "processor time of a simulated second, by quarters",
)


def costs(ran: Ran) -> list[str]:
    """Return the cells of `COSTS` of a run."""
    arrays = rc.load_result(ran.path).arrays
    ratio = np.abs(arrays["energy_residual"]).max() / arrays["energy_dissipated"][-1]
    memory, spent = np.array(ran.memory), np.array(ran.spent)
    after = memory[min(int(SETTLED), len(memory) - 1) :]
    each = [float(np.diff(part).mean()) for part in np.array_split(spent, QUARTERS)]
    return [
        f"{arrays['time'][-1]:g} s",
        f"{ran.steps:.3g}",
        f"{ratio:.1e}",
        f"{after[0]:.1f}, {after[-1]:.1f}, {memory.max():.1f} MB",
        ", ".join(f"{value:.2f}" for value in each) + " s",
    ]


def failures(ran: Ran) -> list[str]:
    """Return what of a run is not as promised: stationary, and memory and time that do not grow."""
    rows = statistics(ran)
    allowed = LEVEL / len(rows)
    found = [f"{row.name}: quarters differ" for row in rows if row.chance < allowed]
    memory, spent = np.array(ran.memory), np.array(ran.spent)
    half = max(len(memory) // 2, SETTLED_INDEX + 1)
    # What has settled after half of the run may grow by a block of rows, 1.4 MB, no more.
    if memory[half:].max() > memory[SETTLED_INDEX:half].max() + 4.0:
        found.append("memory grows")
    if np.diff(spent[half:]).mean() > 1.5 * np.diff(spent[:half]).mean():
        found.append("time of a second grows")
    return [f"{ran.pretension:g} N: {text}" for text in found]


SETTLED_INDEX = int(SETTLED)  # of the list of seconds


def draw(runs: Sequence[Ran], path: Path) -> None:
    """Draw residual, memory and processor time over the simulated time."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
    for ran in runs:
        arrays = rc.load_result(ran.path).arrays
        label = f"{ran.pretension:g} N"
        axes[0].plot(arrays["time"][::50], 1e3 * arrays["energy_residual"][::50], label=label)
        axes[1].plot(ran.time, ran.memory, label=label)
        axes[2].plot(ran.time[1:], np.diff(ran.spent), ",", label=label)
        smooth = np.convolve(np.diff(ran.spent), np.full(20, 0.05), "valid")
        axes[2].plot(ran.time[10 : 10 + len(smooth)], smooth, color=axes[0].lines[-1].get_color())
    names = ("energy residual [mJ]", "resident memory [MB]", "processor time per second")
    for axis, name in zip(axes, names, strict=True):
        axis.set_xlabel("simulated time [s]")
        axis.set_ylabel(name)
        axis.set_ylim(bottom=0.0 if axis is not axes[0] else None)
        axis.grid(alpha=0.3)
    axes[0].legend()
    figure.savefig(path, dpi=130)


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=600.0, help="simulated time [s]")
    parser.add_argument("--accuracy", type=float, default=1e-10, help="of the solver [m]")
    parser.add_argument("--pretensions", type=float, nargs="+", default=[0.0, 25.0, 100.0])
    parser.add_argument("--folder", type=Path, required=True, help="for rows; runs there are kept")
    parser.add_argument("--figure", type=Path, help="file of the figure")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    runs = []
    for pretension in given.pretensions:
        path = given.folder / f"{pretension:g}N.nc"
        done = path.with_suffix(".json").exists()
        runs.append(
            known(path) if done else run(pretension, given.duration, given.accuracy, given.folder)
        )
        print(f"{pretension:g} N: {costs(runs[-1])}", flush=True)
    print(table(runs))
    if given.figure:
        draw(runs, given.figure)
    failed = [text for ran in runs for text in failures(ran)]
    print("\n".join(failed))
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
