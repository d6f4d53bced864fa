"""Simpler scenes that fail as a given one does, down to a small TOML file."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import rustchain as rc
import tree
from outcomes import Job, Outcome
from scenes import Trial
from workers import outcomes_of

SECONDS = 120.0  # after which no simpler scene is looked for


@dataclass(frozen=True)
class Simplified:
    """A scene as JSON text and how it is run; a job as random scenes are."""

    name: str
    kind: str
    text: str
    duration: float
    restart: bool = False

    def trial(self) -> Trial:
        """Return the scene, which may be refused."""
        return Trial(tree.scene_of(json.loads(self.text)), self.duration, self.restart)


def simplified(job: Job, outcome: Outcome, limit: float, seconds: float = SECONDS) -> Simplified:
    """Return the simplest scene found whose outcome is of the same class as that of `job`.

    Parts are left out, fields get their defaults, numbers get round, one after the other.
    """
    trial = job.trial()
    text = json.dumps(tree.tree_of(trial.scene))
    best = Simplified(job.name, job.kind, text, trial.duration, trial.restart)
    end = time.monotonic() + seconds
    tried: set[Simplified] = set()
    again = True
    while again:
        again = False
        for simpler in _simpler(best):
            if time.monotonic() > end:
                return best
            if simpler in tried:
                continue
            tried.add(simpler)
            (found,) = outcomes_of([simpler], limit)
            if found.outcome == outcome.outcome:
                best, again = simpler, True
                break
    return best


def _simpler(job: Simplified) -> Iterator[Simplified]:
    """Yield scenes that are simpler in one place, great simplifications first."""
    if job.restart:
        yield replace(job, restart=False)
    whole: dict[str, Any] = json.loads(job.text)

    def made(changed: dict[str, Any]) -> Simplified:
        return replace(job, text=json.dumps(changed))

    places = [(path, node) for path, node in tree.nodes(whole) if path]
    # Outer fields first: a default there leaves out all that is in it.
    for path, node in [((), whole), *places]:
        for name, default in tree.defaults(node).items():
            if node.get(name, default) != default:
                yield made(tree.with_value(whole, (*path, name), default))
    for path, node in reversed(places):
        if isinstance(path[-1], int) and isinstance(node, dict | list):
            yield made(tree.without(whole, path))
    yield replace(job, duration=0.5 * job.duration)
    for path, number in tree.numbers(whole):
        short = float(f"{number:.1e}") if isinstance(number, float) else number
        if short != number:
            yield made(tree.with_value(whole, path, short))


def to_file(job: Job, outcome: Outcome, folder: Path, limit: float) -> str:
    """Write a simplified failing scene to a TOML file, and return what to print about it."""
    try:
        simpler = simplified(job, outcome, limit)
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{job.name.replace(' ', '_').replace('/', '_')}.toml"
        rc.save_scene(simpler.trial().scene, path)
    except rc.RustchainError as error:
        return f"{job.name}: not written, the description itself is refused: {error}"
    with path.open("a") as lines:
        lines.write(f"\n[run]\nduration = {simpler.duration!r}\n")
        lines.write(f"# {outcome.outcome}: {outcome.message}\n")
    return f"{job.name}: written to {path}"
