"""Random legal scenes over the whole interface: what comes of each, counted.

A scene is made from its seed alone and runs in a process of its own, 20 s of processor time at
most. Prints the failures as they come and a table at the end; the exit status is 1 when a scene
breaks one of the bounds of bounds.py, hangs, panics, aborts, or raises what is no error of the
package. With --extremes, rich scenes run with each of their numbers times 1e-9 to 1e9 instead.
With --shrink, a failing scene is simplified while it fails, and written to a TOML file.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import extremes
import shrink
from outcomes import read, table, write
from scenes import Seeded
from workers import LIMIT, outcomes_of


def seeds_of(text: str) -> range:
    """Return the seeds of `A:B`, or one."""
    begin, _, end = text.partition(":")
    return range(int(begin), int(end) if end else int(begin) + 1)


def main() -> int:
    """Run the scenes asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=seeds_of, default=range(200), help="A:B, or one seed")
    parser.add_argument("--extremes", action="store_true", help="numbers times 1e-9 to 1e9")
    parser.add_argument("--only", default="", help="extremes whose name has this in it")
    parser.add_argument("--longest", type=float, default=0.04, help="longest duration [s]")
    parser.add_argument("--limit", type=float, default=LIMIT, help="processor time of a scene [s]")
    parser.add_argument(
        "--out", type=Path, help="file of outcomes, a line each; failures in it run again"
    )
    parser.add_argument("--shrink", type=Path, help="folder for simplified failing scenes")
    parser.add_argument("--verbose", action="store_true", help="print all outcomes")
    given = parser.parse_args()
    jobs = [Seeded(seed, given.longest) for seed in given.seeds]
    if given.extremes:
        jobs = [job for job in extremes.jobs() if given.only in job.name]
    outcomes = read(given.out) if given.out and given.out.exists() else []
    outcomes = [outcome for outcome in outcomes if not outcome.failed]
    known = {outcome.name for outcome in outcomes}
    jobs = [job for job in jobs if job.name not in known]
    for job, outcome in zip(jobs, outcomes_of(jobs, given.limit), strict=True):
        outcomes.append(outcome)
        if given.out:
            write(outcome, given.out)
        if outcome.failed or given.verbose:
            print(outcome, flush=True)
        if outcome.failed and given.shrink:
            print(shrink.to_file(job, outcome, given.shrink, given.limit), flush=True)
    print(table(outcomes))
    return int(any(outcome.failed for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
