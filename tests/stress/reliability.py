"""What the package promises, the test that holds each promise, and the figures that it reached.

Runs random and extreme scenes, the stability studies, wild calls, and the tests of files, restarts,
interrupts and stores; prints one table. With --page it also goes into docs/reliability.md, with
the table and the figure of the studies. The exit status is 1 when anything failed.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import extremes
import studies
from outcomes import Outcome, read
from run import seeds_of
from scenes import Seeded
from workers import outcomes_of

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "reliability.md"
FIGURE = ROOT / "docs" / "images" / "stability.png"

EXTREMES_LIMIT = 5.0  # of processor time [s]


@dataclass(frozen=True)
class Row:
    """A promise, what holds it, and how it came out."""

    promise: str
    test: str
    cases: int
    failures: int
    worst: str = ""

    def __str__(self) -> str:
        return f"| {self.promise} | {self.test} | {self.cases} | {self.failures} | {self.worst} |"


HEAD = "| promise | test | cases tried | failures | worst figure |\n|---|---|---|---|---|"


# Promise, classes of outcomes that break it, figures of it as shares of their bounds.
OF_SCENES: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...] = (
    (
        "an energy residual above its bound comes with a warning",
        ("silent imbalance",),
        ("residual, without a warning",),
    ),
    ("every recorded number is finite", ("not finite",), ()),
    (
        "no part goes through another",
        ("through a part",),
        (
            "bushing's centre in a tooth",
            "bushing's centre in an idler",
            "penetration of a hinge over the radius",
            "penetration of a tooth over the radius",
            "penetration of a contact over the radius",
        ),
    ),
    (
        "joints and ideal hinges hold",
        ("drift",),
        ("drift of joints", "drift of speeds of joints", "drift of hinges"),
    ),
    ("a restart from a file continues to the same bits", ("other bits",), ()),
    ("a run ends, or obeys an interrupt: no hang, no abort", ("hang", "abort"), ()),
    ("an error is one of the package and names a cause", ("no cause", "other error", "panic"), ()),
)

# Promise, and the tests of pytest that hold it: paths, and the expression that chooses among them.
OF_PYTEST: tuple[tuple[str, tuple[str, ...], str], ...] = (
    (
        "a saved state continues to the same bits: new process, other threads, any time",
        ("simulation/test_restart.py", "simulation/test_state.py"),
        "not damaged and not refused",
    ),
    (
        "damaged, truncated and hostile files are refused, or read as written",
        (
            "files/test_damaged_files.py",
            "simulation/test_state.py",
            "results/test_files.py",
            "sweeps/test_store.py",
            "sweeps/test_load_sweep.py",
        ),
        "damaged or refused or flipped or truncated or junk or hostile",
    ),
    (
        "a killed run, a full disc or Ctrl-C loses no row that was written",
        ("files/test_streams.py", "results/test_files.py"),
        "killed or kill or full_disc or ctrl_c or limit_of_the_size",
    ),
    (
        "several writers of one store or file leave whole files, each case once",
        ("sweeps/test_store.py", "sweeps/test_load_sweep.py", "results/test_files.py"),
        "several_processes or processes_at_once or writers_at_once or share_a_store",
    ),
    (
        "a sweep that is interrupted, or loses a worker, continues where it was",
        ("sweeps/test_store.py", "sweeps/test_executors.py", "sweeps/test_sweep.py"),
        "ended or killed or interrupted or breaks or damaged",
    ),
    ("interrupts are heard within a fifth of a second", ("simulation/test_interrupt.py",), ""),
    ("panics of the compiled module are errors", ("simulation/test_panics.py",), ""),
    (
        "a size that would take the memory or the time is refused",
        ("description/test_bounds.py",),
        "",
    ),
    (
        "a value out of its range is refused by the name of its field",
        ("description/test_bad_fields.py", "simulation/test_bad_calls.py"),
        "",
    ),
)


def rows_of_scenes(what: str, test: str, outcomes: Sequence[Outcome]) -> list[Row]:
    """Return the rows of random or extreme scenes."""
    made = []
    for promise, classes, figures in OF_SCENES:
        ran = [o for o in outcomes if o.worst or o.outcome in classes]
        tried = ran if figures or promise.startswith("every") else list(outcomes)
        if classes == ("other bits",):
            tried = [o for o in ran if "restart" in o.features]
        if not tried:
            continue
        worst = max((o.worst.get(name, 0.0) for o in ran for name in figures), default=0.0)
        told = f"{worst:.2g} of the bound" if figures else ""
        if "hang" in classes:
            told = f"{max(o.seconds for o in outcomes):.0f} s of processor time"
        failures = sum(o.outcome in classes for o in outcomes)
        made.append(Row(f"{what}: {promise}", test, len(tried), failures, told))
    return made


def row_of_studies(outcomes: Sequence[Outcome]) -> Row:
    """Return the row of the stability studies."""
    failures = sum(o.outcome != "finished" for o in outcomes)
    worst = max(map(studies.share, outcomes))
    told = f"residual {worst:.1e} of the energy exchanged"
    promise = "each quantity from one end of its range to the other"
    return Row(promise, "`studies.py`", len(outcomes), failures, told)


def row_of_calls(count: int) -> Row:
    """Return the row of calls of every public function with wild arguments."""
    script = ROOT / "tests" / "stress" / "calls.py"
    ended = subprocess.run(
        [sys.executable, str(script), "--calls", str(count)], capture_output=True, text=True
    )
    holes = sum(int(n) for n in re.findall(r"(\d+) hole", ended.stdout))
    made = re.search(r"(\d+) calls in", ended.stdout)
    promise = "every public call with wild arguments returns, or refuses one by name"
    tried = int(made[1]) if made else 0
    return Row(promise, "`calls.py`", tried, holes if tried else 1)


def row_of_mechanisms(count: int) -> Row:
    """Return the row of random mechanisms beside Exudyn."""
    script = ROOT / "tests" / "stress" / "exudyn_mechanisms.py"
    command = [sys.executable, str(script), "--seeds", "0", str(count)]
    ended = subprocess.run(command, capture_output=True, text=True)
    last = ended.stdout.splitlines()[-1] if ended.stdout else ""
    made = re.match(r"(\d+) mechanisms.* (\d+) disagree.*extrapolated (\S+)", last)
    promise = "random mechanisms move as in Exudyn, to its tolerance"
    if made is None:
        print(ended.stderr, flush=True)
        return Row(promise, f"`{script.name}`", 0, 1)
    tried, disagree, worst = int(made[1]), int(made[2]), made[3].rstrip(",")
    return Row(promise, f"`{script.name}`", tried, disagree, f"{worst} m or rad, extrapolated")


def row_of_pytest(promise: str, paths: Iterable[str], chosen: str) -> Row:
    """Return the row of tests of pytest."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.xml")
        tests = [str(ROOT / "tests" / "python" / path) for path in paths]
        command = [sys.executable, "-m", "pytest", "-q", f"--junitxml={report}", *tests]
        ended = subprocess.run([*command, "-k", chosen], cwd=ROOT, capture_output=True, text=True)
        suites = list(ElementTree.parse(report).getroot().iter("testsuite"))
        names = ("tests", "skipped", "failures", "errors")
        suite = {name: sum(int(each.get(name, 0)) for each in suites) for name in names}
    failed = suite["failures"] + suite["errors"]
    if failed:
        print(ended.stdout, flush=True)
    files = ", ".join(f"`{Path(path).name}`" for path in paths)
    return Row(promise, files, suite["tests"] - suite["skipped"], failed)


def present_commit() -> str:
    """Return the commit that is checked out."""
    command = ["git", "rev-parse", "--short", "HEAD"]
    return f"commit `{subprocess.check_output(command, cwd=ROOT, text=True).strip()}`"


def write(rows: Sequence[Row], of_studies: Sequence[Outcome], when: str) -> None:
    """Put the tables into the page, between the comments that mark their places."""
    text = PAGE.read_text()
    parts = {
        "promises": "\n".join([HEAD, *map(str, rows)]),
        "studies": studies.table(of_studies),
        "run": f"Date of the run: {when}.",
    }
    for name, part in parts.items():
        begin, end = f"<!-- {name} -->\n", f"\n<!-- end of {name} -->"
        before, _, rest = text.partition(begin)
        _, _, after = rest.partition(end)
        text = before + begin + "\n" + part + "\n" + end + after
    PAGE.write_text(text)


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=seeds_of, default=range(200), help="A:B of random scenes")
    parser.add_argument("--every", type=int, default=20, help="of the extreme scenes, each so many")
    parser.add_argument("--calls", type=int, default=1000, help="number of wild calls")
    parser.add_argument("--mechanisms", type=int, default=20, help="number beside Exudyn")
    parser.add_argument(
        "--random", type=Path, help="outcomes that run.py --out wrote, not run here"
    )
    parser.add_argument("--extreme", type=Path, help="the same, of run.py --extremes")
    parser.add_argument("--page", metavar="DATE", help=f"write {PAGE.name}, with this date")
    given = parser.parse_args()
    jobs = [Seeded(seed) for seed in given.seeds]
    random = read(given.random) if given.random else list(outcomes_of(jobs))
    few = extremes.jobs()[:: given.every]
    extreme = read(given.extreme) if given.extreme else list(outcomes_of(few, EXTREMES_LIMIT))
    rows = rows_of_scenes("random scenes", "`run.py`", random)
    rows += rows_of_scenes("extreme values", "`run.py --extremes`", extreme)
    chosen = studies.runs()
    of_studies = list(studies.all_outcomes(chosen))
    rows += [row_of_studies(of_studies), row_of_calls(given.calls)]
    rows.append(row_of_mechanisms(given.mechanisms))
    rows += [row_of_pytest(*test) for test in OF_PYTEST]
    print("\n".join([HEAD, *map(str, rows)]))
    failed = [o for o in (*random, *extreme, *of_studies) if o.failed]
    print("\n".join(map(str, failed)))
    if given.page:
        studies.draw(chosen, of_studies, FIGURE)
        write(rows, of_studies, f"{given.page}, {present_commit()}")
    return int(any(row.failures for row in rows))


if __name__ == "__main__":
    sys.exit(main())
