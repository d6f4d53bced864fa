"""Stop conditions of runs: forces, slack strands, tooth jumps, time."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import numpy as np

from rustchain import _rustchain
from rustchain.arguments import finite_number, plain, shown
from rustchain.description.base import Description, description
from rustchain.description.ends import bushings_of, hinges_of
from rustchain.errors import InvalidInput, NoSuchPart
from rustchain.names import suggest
from rustchain.simulation.run import GROUPS

if TYPE_CHECKING:
    from rustchain.simulation.simulation import Simulation

Look: TypeAlias = Callable[[], "str | None"]
"""Returns the reason to stop at the latest report, or None."""


@dataclass(frozen=True)
class StopCondition(Description, ABC):
    """Base of the stop conditions.

    A condition is evaluated when a row has been recorded, and the run stops there. Forces are the
    largest since the row before, so that no impact is missed.
    """

    group: ClassVar[str | None] = None  # that a run has to record
    of_drives: ClassVar[bool] = False  # not for mechanisms

    def __post_init__(self) -> None:
        """Turn what NumPy has into Python's, then check every field."""
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, plain(getattr(self, field.name)))
        self._check()

    @abstractmethod
    def _check(self) -> None:
        """Raise `InvalidInput` where a field is out of its range."""

    @abstractmethod
    def look_at(self, simulation: Simulation) -> Look:
        """Return the function that is called at each report of `simulation`."""

    def _refusal(
        self, field: str, value: object, expected: str, kind: type[InvalidInput] = InvalidInput
    ) -> InvalidInput:
        return kind(f"{type(self).__name__}.{field} = {shown(value)}: {expected}")

    def _check_number(self, field: str, unit: str, *, zero: bool = False) -> None:
        """Refuse what is no finite number above zero; with `zero`, that is allowed too."""
        value = getattr(self, field)
        if isinstance(value, bool) or not isinstance(value, float | int):
            raise self._refusal(field, value, f"must be a number in {unit}")
        if finite_number(value) is None or value < 0.0 or (value == 0 and not zero):
            least = "zero or a positive number" if zero else "a positive number"
            raise self._refusal(field, value, f"must be {least} in {unit}")

    def _check_count(self, field: str) -> None:
        number = getattr(self, field)
        whole = isinstance(number, int) and not isinstance(number, bool)
        if number is not None and not (whole and number >= 1):
            raise self._refusal(field, number, "must be a whole number from 1 on, or None")

    def _one_of(self, field: str, count: int) -> slice:
        """Return where a row has the contact that the field names from 1, or all of them."""
        number = getattr(self, field)
        if number is None:
            return slice(0, count)
        if number > count:
            expected = f"must be a number from 1 to {count}, or None"
            raise self._refusal(field, number, expected, NoSuchPart)
        return slice(number - 1, number)


def force_above(
    simulation: Simulation, channel: str, limit: float, names: Sequence[str], which: slice
) -> Look:
    """Return a check of a row: a message where a force of the channel exceeds a limit [N]."""

    def look() -> str | None:
        forces = simulation._core.last_row(channel)[which]
        worst = int(forces.argmax())
        if forces[worst] <= limit:
            return None
        found = names[which][worst]
        return f"{found} had a force of {forces[worst]:.4g} N, above {limit:g} N"

    return look


@dataclass(frozen=True)
class _ContactForceAbove(StopCondition):
    """Base of the conditions on forces of hinges and of teeth."""

    of_drives: ClassVar[bool] = True
    contact: ClassVar[str]  # field with its number
    channel: ClassVar[str]  # of the largest forces

    force: float

    def _check(self) -> None:
        self._check_number("force", "N")
        self._check_count(self.contact)

    def look_at(self, simulation: Simulation) -> Look:
        """Return the function that is called at each report of `simulation`."""
        drive = simulation.drive
        which = self._one_of(self.contact, drive.hinge_count)
        there = hinges_of(drive) if self.contact == "hinge" else bushings_of(drive)
        if which.stop - which.start == 1 and which.start not in there:
            expected = f"must be a {self.contact} that this open chain has"
            raise self._refusal(self.contact, which.start + 1, expected, NoSuchPart)

        names = [f"{self.contact} {k + 1}" for k in range(drive.hinge_count)]
        return force_above(simulation, self.channel, self.force, names, which)


@description(frozen=True)
class HingeForceAbove(_ContactForceAbove):
    """The force of a hinge has exceeded a limit since the row before.

    It is compared with the peaks of `Result.peaks`, the forces at the ends of all steps.

    Attributes
    ----------
    force : float
        The limit [N].
    hinge : int, optional
        Number of the hinge, from 1; by default any.
    """

    group: ClassVar[str | None] = "hinges"
    contact: ClassVar[str] = "hinge"
    channel: ClassVar[str] = "peak_hinge_force"

    hinge: int | None = None


@description(frozen=True)
class ToothForceAbove(_ContactForceAbove):
    """The tooth force of a bushing has exceeded a limit since the row before.

    It is compared with the peaks of `Result.peaks`, the forces at the ends of all steps.

    Attributes
    ----------
    force : float
        The limit [N].
    bushing : int, optional
        Number of the bushing, from 1; by default any.

    Examples
    --------
    >>> simulation = rc.Simulation(rc.paper_drive(25.0))
    >>> simulation.run(1e-2, stop=[rc.ToothForceAbove(1.0)], progress=False).status
    'stopped'
    """

    group: ClassVar[str | None] = "teeth"
    contact: ClassVar[str] = "bushing"
    channel: ClassVar[str] = "peak_tooth_force"

    bushing: int | None = None


@description(frozen=True)
class StrandSlack(StopCondition):
    """A strand that was tight has no tension any more.

    A generated start has no tension in any strand: a strand counts from the first row at which it
    is tight; with `from_start` all count from the beginning.

    Attributes
    ----------
    tension : float
        The strand is slack where the mean tension of its hinges is not above this [N].
    strand : str, optional
        Name of the strand, as of `Result.strand`; by default any.
    lasting : float
        Time for which it must be slack without interruption [s]: a vibrating strand is slack for
        short times.
    from_start : bool
        Whether a strand counts that has not been tight in this run.
    """

    group: ClassVar[str | None] = "hinges"
    of_drives: ClassVar[bool] = True

    tension: float = 0.0
    strand: str | None = None
    lasting: float = 0.0
    from_start: bool = False

    def _check(self) -> None:
        if not isinstance(self.from_start, bool):
            raise self._refusal("from_start", self.from_start, "must be True or False")
        self._check_number("tension", "N", zero=True)
        self._check_number("lasting", "s", zero=True)
        if not isinstance(self.strand, str | None):
            raise self._refusal("strand", self.strand, "must be text, or None")

    def look_at(self, simulation: Simulation) -> Look:
        """Return the function that is called at each report of `simulation`."""
        names = _rustchain.strand_names(simulation.drive)
        if self.strand is not None and self.strand not in names:
            expected = f"is no strand; {suggest(self.strand, names)}"
            raise self._refusal("strand", self.strand, expected, NoSuchPart)
        since: dict[str, float] = {}
        tight = set(names) if self.from_start else set()

        def look() -> str | None:
            row = simulation._core.last_row("strand_tension")
            for name, pull in zip(names, row, strict=True):
                if pull > self.tension:
                    tight.add(name)
                if self.strand not in (None, name) or name not in tight or not pull <= self.tension:
                    since.pop(name, None)
                    continue
                begin = since.setdefault(name, simulation.time)
                if simulation.time - begin >= self.lasting * (1.0 - 1e-12):
                    lasting = f" for {self.lasting:g} s" if self.lasting else ""
                    return f"strand {name!r} is slack{lasting}: its tension is {pull:.4g} N"
            return None

        return look


@description(frozen=True)
class ToothJump(StopCondition):
    """The chain has jumped a tooth in this run; see `Result.tooth_jumps`.

    Attributes
    ----------
    sprocket : int, optional
        Number of the sprocket, from 1; by default any.
    """

    of_drives: ClassVar[bool] = True

    sprocket: int | None = None

    def _check(self) -> None:
        self._check_count("sprocket")

    def look_at(self, simulation: Simulation) -> Look:
        """Return the function that is called at each report of `simulation`."""
        which = self._one_of("sprocket", len(simulation.drive.sprockets))
        jumps_of = simulation._core.tooth_jumps  # of a drive, which counts them
        before = len((jumps_of() or [()])[0])

        def look() -> str | None:
            time, sprocket, _ = (column[before:] for column in jumps_of() or ())
            own = (sprocket > which.start) & (sprocket <= which.stop)
            if not own.any():
                return None
            number, at = sprocket[own][0], time[own][0]
            return f"the chain jumped a tooth of sprocket {number} at {at:.6g} s"

        return look


@description(frozen=True)
class TimeReached(StopCondition):
    """The simulation's time, which continues from run to run, has reached a value.

    Attributes
    ----------
    time : float
        Time [s].
    """

    time: float

    def _check(self) -> None:
        self._check_number("time", "s")

    def look_at(self, simulation: Simulation) -> Look:
        """Return the function that is called at each report of `simulation`."""

        def look() -> str | None:
            rounding = 1e-12 * self.time
            return f"reached {self.time:g} s" if simulation.time >= self.time - rounding else None

        return look


def check_looks(
    stop: StopCondition | Sequence[StopCondition], callback: Callable[[Simulation], object] | None
) -> Sequence[StopCondition]:
    """Return the conditions as a list; raise where one of them, or the callback, is none."""
    conditions = [stop] if isinstance(stop, StopCondition) else stop
    if isinstance(conditions, str) or not isinstance(conditions, Sequence):
        own = "; a function of your own goes into callback=" if callable(stop) else ""
        msg = (
            f"stop = {shown(stop)}: must be a stop condition, such as HingeForceAbove, or a "
            f"list of them{own}"
        )
        raise InvalidInput(msg)
    for condition in conditions:
        if not isinstance(condition, StopCondition):
            msg = (
                f"stop: {shown(condition)} is no stop condition, such as HingeForceAbove; a "
                "function of your own goes into callback="
            )
            raise InvalidInput(msg)
    if callback is not None and not callable(callback):
        msg = f"callback = {shown(callback)}: must be a function of the simulation"
        raise InvalidInput(msg)
    return conditions


def look_of_callback(simulation: Simulation, callback: Callable[[Simulation], object]) -> Look:
    """Return the function that calls the callback at each report."""

    def called() -> str | None:
        answer = callback(simulation)
        # Not just anything that counts as true: a function may return what it likes.
        asked = isinstance(answer, bool | np.bool_) and bool(answer)
        return "the callback returned True" if asked else None

    return called


def looks_of(
    simulation: Simulation,
    stop: StopCondition | Sequence[StopCondition],
    callback: Callable[[Simulation], object] | None,
    groups: Sequence[str],
) -> list[Look]:
    """Return the conditions and callbacks of each report of a run that records `groups`."""
    looks: list[Look] = []
    for condition in check_looks(stop, callback):
        if condition.of_drives and simulation.scene.kind == "mechanism":
            msg = (
                f"stop: {type(condition).__name__} is for chain drives; in a mechanism take "
                "JointForceAbove, ContactForceAbove or TimeReached"
            )
            raise InvalidInput(msg)
        if condition.group in GROUPS[simulation.scene.kind] and condition.group not in groups:
            msg = (
                f"stop: {type(condition).__name__} looks at what is recorded of the "
                f"{condition.group}: add {shown(condition.group)} to record"
            )
            raise InvalidInput(msg)
        looks.append(condition.look_at(simulation))
    if callback is not None:
        looks.append(look_of_callback(simulation, callback))
    return looks
