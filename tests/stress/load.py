"""A large sweep that is interrupted twice, loses a worker, and is killed: nothing is lost.

One case of twenty fails. The sweep runs whole in one folder. In another folder it is disturbed at
shares of its cases, and starts again each time. Files of both folders must have the same bytes.
What a disturbed sweep has stored is not run again. The exit status is 1 when anything is not so.
Workers and memory are those of /proc: on Linux only.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import rustchain as rc

FAILS = 20
"""Of so many cases, one fails."""

GROWTH = 30.0
"""Largest growth of resident memory behind a quarter of the cases [MB].

Values, parameters and errors of 3,750 cases are less; their results would be 300 MB."""

LOOK = 5e-5
"""Time between two looks into the folder, for each case [s]: looks take 5 % of that."""

INTERRUPT, WORKER, KILL = "interrupt", "killed worker", "kill"
ENDS = {INTERRUPT: "interrupted", WORKER: "finished", KILL: ""}
"""What a disturbed sweep prints first."""

DISTURBANCES = ((0.25, INTERRUPT), (0.5, INTERRUPT), (0.55, WORKER), (0.8, KILL))


def end(result: rc.Result) -> dict[str, object]:
    """Return what is kept of a case."""
    return {"tooth force": result.peaks.tooth_force.max(), "positions": result.final_positions}


def sweep(store: str, cases: int, duration: float, processes: int) -> None:
    """Run the sweep; print its status, and how many cases have values and errors of their runs."""
    parameters: list[dict[str, float]] = [{"speed": 10.0 + 1e-3 * k} for k in range(cases)]
    for case in parameters[::FAILS]:
        case["chain.material.elastic_modulus"] = 1e300
    with ProcessPoolExecutor(processes) if processes else nullcontext() as executor:
        found = rc.sweep(
            rc.paper_drive(),
            parameters,
            end,
            duration=duration,
            store=store,
            executor=executor,
            progress=False,
        )
    of_runs = [error for error in found.errors.values() if isinstance(error, rc.SimulationError)]
    print(found.status, sum(value is not None for value in found.values), len(of_runs))


@dataclass(frozen=True)
class Ended:
    """A process with the sweep that has ended: what it printed, and its memory [MB]."""

    told: str
    memory: list[tuple[int, float]]
    """At numbers of stored cases."""

    def growth(self, cases: int) -> float:
        """Return the growth of memory from a quarter of the cases to its largest."""
        later = [memory for stored, memory in self.memory if stored >= 0.25 * cases]
        return max(later) - later[0] if later else 0.0


def run(store: Path, cases: int, duration: float, share: float = 2.0, what: str = "") -> Ended:
    """Run the sweep in a process of its own; disturb it at this share of its cases."""
    command = [sys.executable, "-W", "ignore", __file__, "--store", str(store)]
    command += ["--cases", str(cases), "--duration", str(duration)]
    command += ["--processes", "2" if what == WORKER else "0"]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    proc, memory = Path(f"/proc/{running.pid}"), []
    while running.poll() is None:
        stored = len(list(store.glob("*.nc")))
        used = (proc / "status").read_text().partition("VmRSS:")[2].split()
        if used:  # not of a process that has ended
            memory.append((stored, float(used[0]) / 1024.0))
        if stored >= share * cases:
            workers = (proc / "task" / str(running.pid) / "children").read_text().split()
            if what == INTERRUPT:
                running.send_signal(signal.SIGINT)
            elif what == KILL:
                running.kill()
            elif workers:
                os.kill(int(workers[0]), signal.SIGKILL)
            if what != WORKER or workers:  # a process that has just started has none yet
                share = 2.0  # once
        time.sleep(LOOK * cases)
    return Ended(running.communicate()[0].strip(), memory)


def files(store: Path) -> dict[str, int]:
    """Return the files of cases, and when each was written."""
    return {path.name: path.stat().st_mtime_ns for path in store.glob("*.nc")}


@dataclass(frozen=True)
class Load:
    """What is wrong with a disturbed sweep, and its figures."""

    cases: int
    wrong: list[str]
    stored: list[int]
    """Cases in the folder after each disturbance."""
    growth: float
    """Of memory, undisturbed [MB]."""

    def __str__(self) -> str:
        told = ", ".join(
            f"{what} at {n}" for n, (_, what) in zip(self.stored, DISTURBANCES, strict=True)
        )
        return f"{told}; memory grows by {self.growth:.1f} MB"


def load(folder: Path, cases: int, duration: float) -> Load:
    """Run the sweep whole and disturbed, and compare."""
    failing = len(range(0, cases, FAILS))
    finished = f"finished {cases - failing} {failing}"
    whole, disturbed = folder / "whole", folder / "disturbed"
    plain = run(whole, cases, duration)
    wrong = [] if plain.told == finished else [f"undisturbed: {plain.told}, not {finished}"]
    if plain.growth(cases) > GROWTH:
        wrong.append(f"memory grows by more than {GROWTH:g} MB")
    kept: dict[str, int] = {}
    stored = []
    for share, what in (*DISTURBANCES, (2.0, "")):
        ended = run(disturbed, cases, duration, share, what)
        found = files(disturbed)
        again = sum(found.get(name) != when for name, when in kept.items())
        if again:
            wrong.append(f"{what or 'end'}: {again} stored cases are lost or run again")
        if what and (not ended.told.startswith(ENDS[what]) or len(found) == cases):
            wrong.append(f"{what}: {ended.told}, with {len(found)} cases stored")
        if not what and ended.told != finished:
            wrong.append(f"after all disturbances: {ended.told}, not {finished}")
        kept = found
        stored.append(len(found))
    names = files(whole).keys()
    if kept.keys() != names:
        wrong.append(f"{len(kept.keys() ^ names)} cases are in one folder alone")
    both = kept.keys() & names
    other = sum((whole / n).read_bytes() != (disturbed / n).read_bytes() for n in both)
    if other:
        wrong.append(f"{other} cases have other bits")
    return Load(cases, wrong, stored[:-1], plain.growth(cases))


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=5000)
    parser.add_argument("--duration", type=float, default=5e-3, help="of a case [s]")
    parser.add_argument("--store", help="run the sweep alone, with this store")
    parser.add_argument("--processes", type=int, default=0, help="of that; 0: threads")
    given = parser.parse_args()
    if given.store:
        # A job in the background inherits that interrupts are ignored.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        sweep(given.store, given.cases, given.duration, given.processes)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        found = load(Path(folder), given.cases, given.duration)
    print("\n".join([f"{given.cases} cases: {found}", *found.wrong]))
    return int(bool(found.wrong))


if __name__ == "__main__":
    sys.exit(main())
