"""What came of a scene: one of the classes below, with its warnings and its worst figures."""

from __future__ import annotations

import json
import signal
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np

import rustchain as rc
from bounds import Figure, balance, energies, figures
from scenes import ROWS, Trial

# Classes that a stress run must not have.
FAILURES = (
    "silent imbalance",
    "not finite",
    "through a part",
    "drift",
    "other bits",
    "no cause",
    "other error",
    "panic",
    "hang",
    "abort",
)
# A slow scene has obeyed an interrupt at the limit of processor time; its rows hold the bounds.
CLASSES = ("finished", "slow", "refused", "SimulationError", *FAILURES)

# What the core says of its panics, and the shortest text that can name a cause.
PANIC, SHORTEST = "defect of rustchain", 20


class Job(Protocol):
    """What gives a scene to run: `trial` may be refused."""

    name: str
    kind: str

    def trial(self) -> Trial:
        """Return the scene and how it is run."""


@dataclass
class Outcome:
    """What came of a scene, by its name: of random ones the seed."""

    name: str
    kind: str
    outcome: str
    message: str = ""
    features: list[str] = field(default_factory=list)
    warned: list[str] = field(default_factory=list)
    energy: dict[str, float] = field(default_factory=dict)
    """Of a run [J]: largest residual; dissipated, exchanged, kinetic and stored energy; at rest."""
    worst: dict[str, float] = field(default_factory=dict)
    """Largest share of each bound."""
    steps: int = 0
    seconds: float = field(default=0.0, compare=False)
    """Processor time."""

    @property
    def failed(self) -> bool:
        """Whether a stress run must not have it."""
        return self.outcome in FAILURES

    def __str__(self) -> str:
        told = ", ".join(self.features)
        energy = ", ".join(f"{name} {value:.2e}" for name, value in self.energy.items())
        return f"{self.name}: {self.outcome}; {self.kind}: {told}; {energy} {self.message}"


def outcome_of(job: Job, limit: float = np.inf) -> Outcome:
    """Run the scene of a job, `limit` of processor time at most [s], and classify the outcome."""
    found = Outcome(job.name, job.kind, "finished")
    begin = time.process_time()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            with _limited(limit):
                trial = job.trial()
                found.features = trial.features
                result, same = run(trial)
            classify(found, result, same, {w.category.__name__ for w in caught})
        except rc.SimulationError as error:
            panicked = PANIC in str(error)
            found.outcome, found.message = ("panic" if panicked else "SimulationError"), str(error)
        except rc.RustchainError as error:
            found.outcome, found.message = "refused", str(error)
        except KeyboardInterrupt:
            found.outcome, found.message = "slow", "before its first step"
        except Exception as error:
            found.outcome, found.message = "other error", repr(error)
        except BaseException as error:  # the core's panics are no Exception
            found.outcome, found.message = "panic", str(error)
    if found.outcome in ("refused", "SimulationError") and len(found.message) < SHORTEST:
        found.outcome = "no cause"
    found.warned = sorted({w.category.__name__ for w in caught})
    found.seconds = time.process_time() - begin
    return found


@contextmanager
def _limited(limit: float) -> Iterator[None]:
    """Interrupt what is done within, as Ctrl-C does, after so much processor time [s]."""
    if limit == np.inf:
        yield
        return

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def run(trial: Trial) -> tuple[rc.Result, bool]:
    """Return the result of a trial, and whether it goes on from its state to the same bits."""
    simulation = rc.Simulation(trial.scene)
    mechanism = isinstance(trial.scene.system, rc.Mechanism)
    record = ("bodies", "joints", "contacts") if mechanism else ("hinges", "teeth", "sprockets")
    keywords = {"record": (*dict.fromkeys((*record, "bodies", "energy")),), "progress": False}
    step = trial.duration / ROWS
    if not trial.restart:
        return simulation.run(trial.duration, step, **keywords), True
    half = 0.5 * trial.duration
    first = simulation.run(half, step, **keywords)
    if first.status != "finished":
        return first, True
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "state.npz")
        simulation.save_state(path)
        successor = rc.Simulation.load_state(path)
    one = simulation.run(half, step, **keywords)
    if one.status != "finished":
        return one, True
    other = successor.run(half, step, **keywords)
    same = other.status == "interrupted" or all(
        np.array_equal(values, other.arrays[name], equal_nan=True)
        for name, values in one.arrays.items()
    )
    return one, same


def classify(found: Outcome, result: rc.Result, same: bool, warned: set[str]) -> None:
    """Set the class of a run that ended with a result."""
    found.steps = int(result.stats["steps"])
    if result.status == "interrupted":
        found.outcome, found.message = "slow", "before its first row"
        if not len(result.time):
            return
        reached = result.time[-1] - result.time[0]
        found.message = f"at {reached:.2e} s after {result.stats['steps']:.0f} steps"
    found.energy = energies(result)
    imbalance = balance(found.energy)
    told = "EnergyWarning" in warned
    named = "residual, with a warning" if told else "residual, without a warning"
    held = [Figure(named, imbalance, "" if told else "silent imbalance"), *figures(result)]
    for figure in held:
        found.worst[figure.name] = max(figure.value, found.worst.get(figure.name, 0.0))
        if figure.failure and not figure.value <= 1.0 and not found.failed:
            found.outcome, found.message = figure.failure, f"{figure.name}: {figure.value:.3g}"
    if not same:
        found.outcome, found.message = "other bits", "after a restart from a file"


def read(*paths: Path) -> list[Outcome]:
    """Return the outcomes in files, each by its last line."""
    lines = [line for path in paths for line in path.read_text().splitlines()]
    outcomes = [Outcome(**json.loads(line)) for line in lines]
    return list({(outcome.kind, outcome.name): outcome for outcome in outcomes}.values())


def write(outcome: Outcome, path: Path) -> None:
    """Add an outcome to a file, as a line."""
    with path.open("a") as lines:
        lines.write(json.dumps(asdict(outcome)) + "\n")


def table(outcomes: Sequence[Outcome]) -> str:
    """Return counts of classes and warnings by kind, the worst figures, and the failures."""
    warned = sorted({name for o in outcomes for name in o.warned})
    columns = [c for c in CLASSES if c in {o.outcome for o in outcomes}] + warned
    kinds = sorted({o.kind for o in outcomes})
    lines = ["| kind | scenes | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    for kind in [*kinds, "all"]:
        chosen = [o for o in outcomes if kind in (o.kind, "all")]
        counts = Counter(name for o in chosen for name in (o.outcome, *o.warned))
        cells = " | ".join(str(counts[column]) for column in columns)
        lines.append(f"| {kind} | {len(chosen)} | {cells} |")
    lines += ["", "| figure, as a share of its bound | largest | in |", "|---|---|---|"]
    for name in sorted({name for o in outcomes for name in o.worst}):
        most = max(outcomes, key=lambda o: o.worst.get(name, -1.0))
        lines.append(f"| {name} | {most.worst[name]:.2e} | {most.name} |")
    slowest = sorted(outcomes, key=lambda o: o.seconds)[:-6:-1]
    told = ", ".join(f"{o.name} ({o.seconds:.1f} s)" for o in slowest)
    lines += ["", f"slowest: {told}", "", *(str(o) for o in outcomes if o.failed)]
    return "\n".join(lines)
