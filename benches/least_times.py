"""Processor times of simulations on a machine with other load.

Other load shares caches, clock rate and execution units with a run. It adds time, for milliseconds
to seconds. Equal runs take the same steps. They are divided into parts, best of a millisecond or
less. For each part the least time of all runs counts. Between two of these runs all others have a
turn, so that a busy second does not slow all of them. The least of fewer runs and of longer parts
is larger: this bias remains between fast and slow runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import count

import numpy as np

import rustchain as rc

PARTS = 100  # of a run
LEAST_RUNS, MOST_RUNS = 4, 10  # equal ones
SECONDS = 4.0  # after which there are no further runs than the least number [s]


class Clock:
    """Times of this process at the ends of parts [s]."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Begin the first part now."""
        self.marks = [time.process_time()]

    def mark(self) -> None:
        """End a part."""
        self.marks.append(time.process_time())

    def parts(self) -> np.ndarray:
        """Return the times of all parts [s]."""
        return np.diff(self.marks)


def step(simulation: rc.Simulation, duration: float, clock: Clock, parts: int = PARTS) -> None:
    """Advance by steps alone; calls of `step_to` in between change no step."""
    begin = simulation.time
    for part in range(1, parts + 1):
        simulation.step_to(begin + part / parts * duration)
        clock.mark()


def each_row(clock: Clock, rows: int) -> Callable[[rc.Simulation], None]:
    """Return a callback of runs that ends a part after so many rows."""
    numbers = count(1)

    def marked(_: rc.Simulation) -> None:
        if next(numbers) % rows == 0:
            clock.mark()

    return marked


@dataclass(frozen=True)
class LeastTime:
    """Sum of the least times of all parts [s], and how far two halves of the runs differ in it."""

    seconds: float
    difference: float


def least_of(runs: list[np.ndarray]) -> LeastTime:
    """Return the least time of runs with the same parts."""
    halves = [np.min(runs[half::2], axis=0).sum() for half in (0, 1)]
    seconds = float(np.min(runs, axis=0).sum())
    return LeastTime(seconds, float(abs(halves[0] - halves[1])) / seconds)


@dataclass
class EqualRuns:
    """Equal runs, each of which marks the ends of its parts."""

    run: Callable[[Clock], None]
    parts: list[np.ndarray] = field(default_factory=list)
    spent: float = 0.0  # [s]

    def go_on(self) -> None:
        """Make one more run, if there are not enough."""
        if len(self.parts) >= LEAST_RUNS and self.spent > SECONDS:
            return
        clock = Clock()
        self.run(clock)
        clock.mark()
        self.parts.append(clock.parts())
        self.spent += self.parts[-1].sum()

    def least(self) -> LeastTime:
        """Return the least time."""
        return least_of(self.parts)


def take_turns(several: Iterable[EqualRuns], most: int = MOST_RUNS) -> None:
    """Make the runs of all, one of each at a time, at most so many of each, and two or more."""
    several = list(several)
    for _ in range(max(most, 2)):
        for runs in several:
            runs.go_on()
