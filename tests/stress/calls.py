"""A fuzzer of calls: every public callable with wild arguments; run it as a script.

Each call replaces one argument, sometimes two, of a call that is accepted by a wild value. It ends
in one of three ways:

- accepted: something was returned, and no argument was nonsense for its type;
- refused: an exception of this package, which names an argument, in at most `LONGEST` characters;
- a hole: anything else, such as an exception from inside, an abort, or a call that does not end.

As a script it makes the calls in child processes, so that an abort or a hang is one hole, and the
calls go on after it::

    python tests/stress/calls.py --calls 20000 --seed 1
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import io
import linecache
import multiprocessing
import os
import re
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
if __name__ == "__main__":
    sys.path[:0] = [str(ROOT / "tests/python"), str(ROOT / "tests/stress")]

import call_table  # noqa: E402
import rustchain as rc  # noqa: E402
import wild_values  # noqa: E402

LONGEST = 300  # [characters] of a refusal: four lines of a terminal
_PATIENCE = 60.0  # [s] for one call of a child process, which shares the machine
_MEMORY = 6 * 2**30  # [bytes] of a child process
_BATCH = 500  # calls of a child process

# Kinds of value that are nonsense for an argument of a type: to accept one is a hole.
_REFUSED = {
    "float": {*wild_values.NO_NUMBERS, "None", "True", "False", "NumPy True", "rows"},
    "int": {*wild_values.NO_NUMBERS, "None", "True", "False", "NumPy True", "a broken number"},
    "bool": {*wild_values.NO_NUMBERS, *wild_values.NUMBERS, "None", "two numbers", "rows"},
    "str": {"None", "True", "zero", "NaN", "complex", "bytes", "object", "empty list", "dict"},
    "Point": {"None", "True", "zero", "NaN", "complex", "text", "empty list", "dict", "rows"},
}
_REFUSED |= {"Number": _REFUSED["float"], "Count": _REFUSED["int"], "Pair": _REFUSED["Point"]}


@dataclass(frozen=True)
class Outcome:
    """How a call ended."""

    call: str
    kind: str
    said: str = ""

    def __str__(self) -> str:
        return f"{self.kind}: {self.call}: {self.said}"


def call(seed: int, number: int) -> tuple[call_table.Target, dict[str, str]]:
    """Return the target of call `number`, and the kinds of value of the replaced arguments."""
    random = np.random.default_rng((seed, number))
    table = call_table.targets_once()
    target = table[int(random.integers(len(table)))]
    names = list(target.arguments)
    count = min(len(names), 1 if random.random() < 0.8 else 2)
    replaced = random.choice(names, count, replace=False) if names else []
    kinds = list(wild_values.ALL)
    chosen = {str(name): str(random.choice(kinds)) for name in replaced}
    return target, {n: "decimal" if (n, kind) in _LONG else kind for n, kind in chosen.items()}


def outcome(target: call_table.Target, replaced: dict[str, str]) -> Outcome:
    """Make a call and classify how it ends."""
    values = {name: wild_values.ALL[kind]() for name, kind in replaced.items()}
    words = ", ".join(f"{name}: {kind}" for name, kind in replaced.items())
    said = f"{target.name}({words})"
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            target.call(**target.arguments | values)
    except BaseException as error:
        hole = _hole(error, target, replaced)
        text = _text(error)
        return Outcome(said, "refused", text) if hole is None else Outcome(said, hole, text)
    finally:
        if "matplotlib.pyplot" in sys.modules:
            sys.modules["matplotlib.pyplot"].close("all")
    nonsense = [
        name
        for name, kind in replaced.items()
        if kind in _REFUSED.get(target.annotations.get(name, ""), ())
    ]
    return Outcome(said, "hole, nonsense accepted" if nonsense else "accepted")


def _hole(error: BaseException, target: call_table.Target, replaced: dict[str, str]) -> str | None:
    """Return what is wrong with a refusal, or None."""
    text = _text(error)
    if not isinstance(error, Exception):
        return "hole, no Exception"
    if any("class" in replaced.get(name, "") for name in ("callback", "measure", "function")):
        return None  # a class is a function, and what it raises is passed on
    if not _is_ours(error):
        frames = traceback.extract_tb(error.__traceback__)
        return f"hole, {type(error).__name__} from {frames[-1].filename}:{frames[-1].lineno}"
    if len(text) > LONGEST:
        return "hole, long message"
    # A method of one argument is named in its place: "hinge 99: hinges are numbered 1 to 38".
    names = [*target.arguments, target.name.split(".")[-1], *_SYNONYMS.get(target.name, ())]
    names += ["body"] if target.name.startswith("Mechanism.add_") else []
    forms = {form for name in names for form in (name, name.removesuffix("s"), f"{name}s")}
    forms |= {name.removesuffix("ies") + "y" for name in names}
    if isinstance(error, rc.SimulationError):  # of a run that began
        return None
    if replaced and not any(re.search(rf"\b{form}\b", text) for form in forms):
        return "hole, names no argument"
    return None


# What a refusal may name in place of an argument: the part of the scene that the argument makes.
_SYNONYMS = {
    "Mechanism.add_driver": ("motion",),
    "Mechanism.add_position_driver": ("motion",),
    "Mechanism.add_disc_contact": ("radius",),
    "Mechanism.add_torque": ("table",),
    "Mechanism.add_torsion_spring": ("rest angle",),
    "Plots.force_penetration": ("hinge", "bushing"),
    "two_sprocket_drive": ("center",),
    "Result.efficiency": ("start",),
    "catalogue_chain": ("chain",),
}

# Times that are legal, and would take minutes to simulate.
_LONG = {
    *((time, kind) for time in ("t", "duration") for kind in ("two", "99", "NumPy integer")),
    *(("t", kind) for kind in ("2**63", "huge")),
}


def _is_ours(error: Exception) -> bool:
    """Whether an exception is raised by this package on purpose, not by something inside it."""
    kind = type(error)
    if kind.__module__.startswith("rustchain"):
        return True
    frame = traceback.extract_tb(error.__traceback__)[-1]
    if "/rustchain/" in frame.filename.replace("\\", "/"):
        return linecache.getline(frame.filename, frame.lineno or 0).strip().startswith("raise ")
    return False


def _text(error: BaseException) -> str:
    try:
        return str(error)
    except Exception:
        return "an error that cannot be printed"


def trials(seed: int, numbers: range) -> Iterator[Outcome]:
    """Make some calls of a seed in this process."""
    for number in numbers:
        yield outcome(*call(seed, number))


def _child(seed: int, numbers: range, pipe: Any) -> None:
    """Make calls, and send each before and after it is made."""
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        call_table.targets_once()
        for number in numbers:
            pipe.send((number, None))
            pipe.send((number, outcome(*call(seed, number))))
    pipe.close()


def _isolated(seed: int, calls: range) -> Iterator[Outcome]:
    """Make calls in child processes; one that dies or hangs is a hole, and the next one goes on."""
    context = multiprocessing.get_context("spawn")
    number = calls.start
    while number < calls.stop:
        batch = range(number, min(number + _BATCH, calls.stop))
        receive, send = context.Pipe(duplex=False)
        child = context.Process(target=_child, args=(seed, batch, send))
        child.start()
        send.close()
        fate = "died"
        begun = None
        try:
            while receive.poll(_PATIENCE + (60.0 if begun is None else 0.0)):
                begun, found = receive.recv()
                if found is not None:
                    number = begun + 1
                    yield found
            fate = "did not end"
        except EOFError:
            pass
        if number < batch.stop:
            child.kill()
            child.join()
            target, replaced = call(seed, number)
            words = ", ".join(f"{name}: {kind}" for name, kind in replaced.items())
            said = f"exit code {child.exitcode}"
            yield Outcome(f"{target.name}({words})", f"hole, {fate}", said)
            number += 1
        child.join()


def main() -> None:
    """Make the calls that the command line asks for, and print what came of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--calls", type=int, default=1000, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first call")
    parser.add_argument("--seed", type=int, default=1, help="of the random choice")
    parser.add_argument("--holes", type=Path, help="file to write the holes to")
    given = parser.parse_args()
    counts: collections.Counter[str] = collections.Counter()
    began = time.monotonic()
    holes = []
    for found in _isolated(given.seed, range(given.first, given.first + given.calls)):
        counts[found.kind] += 1
        if found.kind.startswith("hole"):
            holes.append(str(found)[:1000])
    for kind, count in counts.most_common():
        print(f"{count:7d} {kind}")
    print(f"{sum(counts.values()):7d} calls in {time.monotonic() - began:.0f} s")
    if given.holes:
        given.holes.write_text("\n".join(holes), errors="replace")
    sys.exit(1 if holes else 0)


if __name__ == "__main__":
    main()
