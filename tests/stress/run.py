"""Random legal scenes over the whole interface: what comes of each, counted.

A scene is made from its seed alone and runs in a process of its own, 20 s of processor time at
most. Prints the failures as they come and a table at the end; the exit status is 1 when a scene
hangs, panics, aborts, raises what is no error of the package, or is out of balance in silence.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from outcomes import table
from workers import LIMIT, outcomes_of


def _seeds(text: str) -> range:
    begin, _, end = text.partition(":")
    return range(int(begin), int(end) if end else int(begin) + 1)


def main() -> int:
    """Run the scenes of the seeds asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=_seeds, default=range(200), help="A:B, or one seed")
    parser.add_argument("--longest", type=float, default=0.04, help="longest duration [s]")
    parser.add_argument("--limit", type=float, default=LIMIT, help="processor time of a scene [s]")
    parser.add_argument("--out", type=Path, help="file of all outcomes, a JSON object a line")
    parser.add_argument("--verbose", action="store_true", help="print all outcomes")
    given = parser.parse_args()
    outcomes = []
    for outcome in outcomes_of(given.seeds, given.longest, given.limit):
        outcomes.append(outcome)
        if outcome.failed or given.verbose:
            print(outcome, flush=True)
    if given.out:
        given.out.write_text("".join(json.dumps(asdict(o)) + "\n" for o in outcomes))
    print(table(outcomes))
    return int(any(outcome.failed for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
