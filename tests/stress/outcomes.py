"""What came of a scene: one of the classes below, with its warnings and its energy balance."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

import rustchain as rc
from scenes import Scene

# Classes that a stress run must not have.
FAILURES = ("silent imbalance", "other error", "panic", "hang", "abort")
CLASSES = ("finished", "refused", "SimulationError", *FAILURES)

# A residual above this share of the energy dissipated must not be silent. Where less is dissipated
# than these shares of the energy exchanged and stored, it is held against them.
SHARE, OF_EXCHANGED, OF_STORED = 0.05, 1e-2, 2e-4

# Kinetic energy [J] of half a kilogram that moves at three times the default error of speeds, 1e-5
# m/s: what has no more is at rest, and all that passes in it is error.
AT_REST = 2e-10


@dataclass
class Outcome:
    """What came of the scene of a seed."""

    seed: int
    kind: str
    outcome: str
    message: str = ""
    features: list[str] = field(default_factory=list)
    warned: list[str] = field(default_factory=list)
    energy: dict[str, float] = field(default_factory=dict)
    """Of a finished run [J]: largest residual; dissipated, exchanged, kinetic and stored energy."""

    @property
    def failed(self) -> bool:
        """Whether a stress run must not have it."""
        return self.outcome in FAILURES

    def __str__(self) -> str:
        told = ", ".join(self.features)
        energy = ", ".join(f"{name} {value:.2e}" for name, value in self.energy.items())
        return f"{self.seed}: {self.outcome}; {self.kind}: {told}; {energy} {self.message}"


def energies(result: rc.Result) -> dict[str, float]:
    """Return the largest residual of a run, and what its energy balance can be held against [J]."""
    energy = result.energy

    def spread(values: np.ndarray) -> float:
        return float(values.max() - values.min())

    dissipated = float(energy.dissipated[-1])
    moved = (energy.external_work, energy.kinetic, energy.gravity, energy.elastic)
    return {
        "residual": float(np.abs(energy.residual).max()),
        "dissipated": dissipated,
        "exchanged": max(dissipated, *map(spread, moved)),
        "kinetic": float(energy.kinetic.max()),
        "stored": float((energy.kinetic + energy.elastic).max()),
    }


def outcome_of(seed: int, longest: float) -> Outcome:
    """Run the scene of a seed and classify what came of it."""
    scene = Scene(seed)
    found = Outcome(seed, scene.kind, "finished")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found.energy = energies(scene.run(longest))
        except rc.InvalidInput as error:
            found.outcome, found.message = "refused", str(error)
        except rc.SimulationError as error:
            found.outcome, found.message = "SimulationError", str(error)
        except Exception as error:
            found.outcome, found.message = "other error", repr(error)
        except BaseException as error:  # the core's panics are no Exception
            if isinstance(error, KeyboardInterrupt):
                raise
            found.outcome, found.message = "panic", str(error)
    found.features = scene.draw.features
    found.warned = sorted({w.category.__name__ for w in caught})
    if found.outcome == "finished" and is_silent(found):
        found.outcome = "silent imbalance"
    return found


def is_silent(found: Outcome) -> bool:
    """Return whether more energy is missing than may be, and no warning says so."""
    energy = found.energy
    if energy["kinetic"] <= AT_REST:
        return False
    scale = max(
        energy["dissipated"], OF_EXCHANGED * energy["exchanged"], OF_STORED * energy["stored"]
    )
    # A NaN is an imbalance.
    return not energy["residual"] <= SHARE * scale and "EnergyWarning" not in found.warned


def table(outcomes: Sequence[Outcome]) -> str:
    """Return counts of classes and warnings by kind of scene, with the failures below."""
    warned = sorted({name for o in outcomes for name in o.warned})
    columns = [c for c in CLASSES if c in {o.outcome for o in outcomes}] + warned
    kinds = sorted({o.kind for o in outcomes})
    lines = ["| kind | scenes | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    for kind in [*kinds, "all"]:
        chosen = [o for o in outcomes if kind in (o.kind, "all")]
        counts = Counter(name for o in chosen for name in (o.outcome, *o.warned))
        cells = " | ".join(str(counts[column]) for column in columns)
        lines.append(f"| {kind} | {len(chosen)} | {cells} |")
    lines += ["", *(str(o) for o in outcomes if o.failed)]
    return "\n".join(lines)
