"""One case of a sweep: its scene, its run and its outcome."""

from __future__ import annotations

import functools
import os
import pickle
import sysconfig
import threading
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from rustchain.description.scene import Scene
from rustchain.errors import RustchainError, attach
from rustchain.results.result import Result
from rustchain.simulation.run import known_groups
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.stop import StopCondition
from rustchain.sweeps.cases import Parameters

_RAISED = "raised at "

Measure: TypeAlias = Callable[[Result], Any]
Notes: TypeAlias = tuple[list[str], list[str], list[str]]
"""What there was to warn of: laws out of range, the energy balance, tooth jumps."""


@dataclass(frozen=True)
class Case:
    """A case of a sweep: its number, from 0, what is simulated, and the arguments of its run."""

    number: int
    scene: Scene
    run: Parameters

    def groups(self) -> tuple[list[str], bool]:
        """Return what is recorded, and whether the energy balance is kept."""
        return known_groups(self.scene, self.run["record"], self.run["energy"])


@dataclass(frozen=True)
class Looks:
    """Stop conditions and callback of each row of a run."""

    stop: StopCondition | Sequence[StopCondition]
    callback: Callable[[Simulation], object] | None
    any: bool


class Outcome(NamedTuple):
    """The outcome of a case.

    Attributes
    ----------
    value : object
        The measured value, or the Result.
    error : Exception, optional
        The error.
    notes : tuple of lists of str
        What there was to warn of.
    made : bool
        Whether the run began: a scene that is refused, or an executor that is broken, has no run.
    """

    value: Any = None
    error: Exception | None = None
    notes: Notes = ([], [], [])
    made: bool = True


class Quiet(Simulation):
    """A simulation that leaves its warnings to the sweep, and ends with it."""

    given_up: threading.Event | None = None

    def _warn(self) -> None:
        pass

    def take_warnings(self) -> Notes:
        """Return what is new: laws out of range; the energy balance; tooth jumps."""
        return self._core.take_warnings()

    def _slice(self) -> bool:
        if self.given_up is not None and self.given_up.is_set():
            raise KeyboardInterrupt
        return super()._slice()


_OTHERS = tuple(
    f"{folder}{os.sep}" for folder in (Path(__file__).parents[1], sysconfig.get_path("stdlib"))
)


@functools.cache
def is_of_user(file: str) -> bool:
    """Return whether a file is neither of rustchain nor of Python or an installed package."""
    installed = not {"site-packages", "dist-packages"}.isdisjoint(Path(file).parts)
    return not installed and not file.startswith(("<frozen", *_OTHERS))


def lean(error: Exception) -> Exception:
    """Return an error without its frames, which hold all that the run has, such as the result.

    A note has the line of the user's code that it is of.
    """
    lines = [
        f"{_RAISED}{Path(frame.f_code.co_filename).name}, line {line}"
        for frame, line in traceback.walk_tb(error.__traceback__)
        if is_of_user(frame.f_code.co_filename)
        and not str(frame.f_globals.get("__name__")).startswith("rustchain.")  # made by dataclasses
    ]
    attach(error, "__notes__", [*getattr(error, "__notes__", ()), *lines[-1:]])
    chain: list[BaseException] = [error]
    for each in chain:
        attach(each, "__traceback__", None)
        others = (each.__cause__, each.__context__)
        chain += [other for other in others if other is not None and other not in chain]
    return error


def told(error: Exception) -> str:
    """Return an error in words, with the line of the user's code that it is of."""
    notes = getattr(error, "__notes__", ())
    places = [f" ({note.removeprefix(_RAISED)})" for note in notes if note.startswith(_RAISED)]
    return f"{type(error).__name__}: {error}{''.join(places[:1])}"


def run_and_measure(case: Case, *, looks: Looks, measure: Measure | None) -> Outcome:
    """Run and measure a case, in whatever process; return what can be sent back."""
    try:
        simulation = Quiet(case.scene)
    except Exception as error:  # what is refused
        return Outcome(error=_sendable(lean(error)), made=False)
    outcome = measured(run_case(case, simulation, looks), measure)
    failure = outcome.error
    return outcome if failure is None else outcome._replace(error=_sendable(failure))


def _sendable(error: Exception) -> Exception:
    """Return an error, or what stands for it where it does not survive pickling."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception as reason:  # whatever a class of the user's does
        found = RustchainError(f"{type(error).__name__}: {error}")
        notes = getattr(error, "__notes__", ())
        found.__notes__ = [*notes, f"the error itself cannot be sent to another process: {reason}"]
        return found
    return error


def run_case(
    case: Case, simulation: Quiet, looks: Looks, given_up: threading.Event | None = None
) -> Outcome:
    """Run the simulation of a case."""
    simulation.given_up = given_up
    result: Result | None = None
    failure: Exception | None = None
    try:
        stop, callback = looks.stop, looks.callback
        result = simulation.run(**case.run, progress=False, stop=stop, callback=callback)
    except Exception as error:  # a callback of the user's may raise anything
        failure = lean(error)
    if result is not None and result.status == "interrupted":
        raise KeyboardInterrupt
    # With the first row, an error has the rows until then.
    made = failure is None or hasattr(failure, "result")
    return Outcome(result, failure, simulation.take_warnings(), made)


def measured(outcome: Outcome, measure: Measure | None) -> Outcome:
    """Return the outcome of a case whose run has ended, measured."""
    if measure is None or outcome.error is not None:
        return outcome
    try:
        return outcome._replace(value=measure(outcome.value))
    except Exception as raised:  # a function of the user's may raise anything
        return outcome._replace(value=None, error=lean(raised))
