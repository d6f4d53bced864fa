"""What the package promises, the test that holds each promise, and the figures that it reached.

Runs random and extreme scenes, the stability studies, wild calls, and the tests of files, restarts,
interrupts and stores; prints one table. With --page it also goes into docs/reliability.md, with
the table and the figure of the studies. With --keep the outcomes of scenes and studies are kept
in a folder: a run that has ended continues, and the table has all outcomes that are there. Files
of `run.py --out` whose names begin with "random" or "extreme" join them. The exit status is 1 when
anything failed.
"""

from __future__ import annotations

import argparse
import importlib.util
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
from load import load
from outcomes import Job, Outcome, read
from outcomes import write as keep
from run import seeds_of
from scenes import Seeded
from workers import LIMIT, outcomes_of

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
        ("files/test_stream_failures.py", "results/test_files.py"),
        "killed or kill or full_disc or ctrl_c or limit_of_the_size",
    ),
    (
        "several writers of one store or file leave whole files, each case once",
        ("sweeps/test_load_sweep.py", "results/test_files.py"),
        "processes_at_once or writers_at_once or share_a_store",
    ),
    (
        "a sweep that is interrupted, or loses a worker, continues where it was",
        ("sweeps/test_store.py", "sweeps/test_executors.py", "sweeps/test_sweep.py"),
        "ended or killed or interrupted or breaks or damaged",
    ),
    (
        "interrupts are heard within a fifth of a second",
        (
            "simulation/test_interrupt.py",
            "simulation/test_interrupt_ends.py",
            "simulation/test_interrupt_moments.py",
        ),
        "",
    ),
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


def kept_or_run(jobs: Iterable[Job], limit: float, folder: Path | None, what: str) -> list[Outcome]:
    """Return the outcomes of jobs, and all kept ones of the same sort; failures run again."""
    paths = sorted(folder.glob(f"{what}*.jsonl")) if folder else []
    paths.sort(key=lambda path: path.stem == what)  # last, as the latest
    jobs = list(jobs)
    asked = {(job.kind, job.name) for job in jobs}
    # A failure that is not asked for again still counts.
    outcomes = [o for o in read(*paths) if not o.failed or (o.kind, o.name) not in asked]
    known = {(outcome.kind, outcome.name) for outcome in outcomes}
    for outcome in outcomes_of([job for job in jobs if (job.kind, job.name) not in known], limit):
        outcomes.append(outcome)
        if folder:
            keep(outcome, folder / f"{what}.jsonl")
    return outcomes


def rows_of_scenes(what: str, test: str, outcomes: Sequence[Outcome]) -> list[Row]:
    """Return the rows of random or extreme scenes."""
    made = []
    for promise, classes, figures in OF_SCENES:
        ran = [o for o in outcomes if o.worst or o.outcome in classes]
        tried = ran if promise.startswith("every") else list(outcomes)
        if figures:  # scenes that have such parts
            tried = [o for o in ran if o.outcome in classes or any(f in o.worst for f in figures)]
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


def row_of_load(cases: int) -> Row:
    """Return the row of a large sweep that is disturbed."""
    with tempfile.TemporaryDirectory() as folder:
        found = load(Path(folder), cases, 5e-3)
    print("\n".join(found.wrong), flush=True)
    promise = "a large sweep with 5 % failing cases: interrupts and killed workers lose no case"
    return Row(promise, "`load.py`", cases, len(found.wrong), str(found))


def row_of_fuzz(seconds: float) -> Row:
    """Return the row of mutated files; the cases are the files that were read or refused."""
    from fuzz import TARGETS

    failures = tried = 0
    for target in TARGETS:
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, str(ROOT / "tests" / "stress" / "fuzz.py"), target]
            command += ["--seconds", str(seconds), "--folder", folder]
            ended = subprocess.run(command, capture_output=True, text=True)
        counts = re.findall(r"'(?:read|refused|defect)': (\d+)", ended.stdout)
        tried += sum(map(int, counts))
        failures += ended.returncode != 0
        print(ended.stdout, flush=True)
    return Row("mutated files are read or refused", "`fuzz.py`", tried, failures)


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
    # An ending that no test explains is a failure, too: no test was chosen, or pytest failed.
    failed = max(failed, int(ended.returncode != 0))
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
    parser.add_argument("--limit", type=float, default=LIMIT, help="processor time of a scene [s]")
    parser.add_argument("--calls", type=int, default=1000, help="number of wild calls")
    parser.add_argument("--mechanisms", type=int, default=20, help="number beside Exudyn")
    parser.add_argument("--load", type=int, default=5000, help="cases of the disturbed sweep")
    parser.add_argument("--fuzz", type=float, default=20.0, help="processor time of a reader [s]")
    parser.add_argument("--keep", type=Path, help="folder of outcomes, which continues")
    parser.add_argument("--page", metavar="DATE", help=f"write {PAGE.name}, with this date")
    given = parser.parse_args()
    if given.keep:
        given.keep.mkdir(parents=True, exist_ok=True)
    random = kept_or_run(map(Seeded, given.seeds), given.limit, given.keep, "random")
    few = extremes.jobs()[:: given.every]
    extreme = kept_or_run(few, min(given.limit, EXTREMES_LIMIT), given.keep, "extreme")
    rows = rows_of_scenes("random scenes", "`run.py`", random)
    rows += rows_of_scenes("extreme values", "`run.py --extremes`", extreme)
    chosen = studies.runs()
    found = kept_or_run(chosen, studies.LIMIT, given.keep, "studies")
    by_name = {(outcome.kind, outcome.name): outcome for outcome in found}
    of_studies = [by_name[run.kind, run.name] for run in chosen]
    rows += [row_of_studies(of_studies), row_of_calls(given.calls)]
    rows.append(row_of_load(given.load))
    rows.append(row_of_mechanisms(given.mechanisms))
    # No group of tools has atheris, which few platforms have.
    if importlib.util.find_spec("atheris"):
        rows.append(row_of_fuzz(given.fuzz))
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
