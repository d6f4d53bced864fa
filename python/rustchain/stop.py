"""When a run ends before its time: at a force, at a slack strand, at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from rustchain import _rustchain
from rustchain._description import Description
from rustchain._names import known_keywords, suggest
from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    from typing import TypeAlias

    from rustchain.simulation import Simulation

    Look: TypeAlias = Callable[[], str | None]
    """Says why the run is to stop at the report just made, if it is."""


@dataclass(frozen=True)
class StopCondition(Description):
    """What every stop condition has; choose one of its subclasses.

    A condition is looked at when a row has been recorded, and the run stops there: forces are the
    largest since the row before, so that no impact is missed.
    """

    group: ClassVar[str | None] = None  # that a run has to record

    def __post_init__(self) -> None:
        """Refuse numbers that mean nothing."""
        for name, value in vars(self).items():
            if isinstance(value, float | int) and (isinstance(value, bool) or math.isnan(value)):
                raise self._refusal(name, value, "must be a number")

    def look_at(self, simulation: Simulation) -> Look:
        """Return what looks at each report of `simulation`."""
        raise NotImplementedError

    def _refusal(self, field: str, value: object, expected: str) -> InvalidInput:
        return InvalidInput(f"{type(self).__name__}.{field} = {value!r}: {expected}")

    def _positive(self, field: str, unit: str) -> None:
        value = getattr(self, field)
        if not isinstance(value, float | int) or not 0.0 < value < math.inf:
            raise self._refusal(field, value, f"must be a positive number in {unit}")

    def _one_of(self, field: str, count: int) -> slice:
        """Return where a row has the contact that the field names from 1, or all of them."""
        number = getattr(self, field)
        if number is None:
            return slice(0, count)
        if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= count:
            raise self._refusal(field, number, f"must be a number from 1 to {count}, or None")
        return slice(number - 1, number)

    def _force(self, simulation: Simulation, channel: str, field: str, name: str) -> Look:
        """Return what looks for a force above the limit in a channel of largest forces."""
        which = self._one_of(field, simulation.drive.chain.links)
        limit = getattr(self, "force")  # noqa: B009  # of the two subclasses that call this

        def look() -> str | None:
            row = simulation._core.last_row(channel)[which]
            worst = int(row.argmax())
            if row[worst] <= limit:
                return None
            number = which.start + worst + 1
            return f"{name} {number} was pressed by {row[worst]:.4g} N, above {limit:g} N"

        return look


@known_keywords
@dataclass(frozen=True)
class HingeForceAbove(StopCondition):
    """A hinge was pressed by more than a limit since the row before.

    Attributes
    ----------
    force : float
        The limit [N].
    hinge : int, optional
        Number of the hinge, from 1; by default any.
    """

    group: ClassVar[str | None] = "hinges"

    force: float
    hinge: int | None = None

    def __post_init__(self) -> None:
        """Refuse numbers that mean nothing."""
        super().__post_init__()
        self._positive("force", "N")

    def look_at(self, simulation: Simulation) -> Look:
        """Return what looks at each report of `simulation`."""
        return self._force(simulation, "peak_hinge_force", "hinge", "hinge")


@known_keywords
@dataclass(frozen=True)
class ToothForceAbove(StopCondition):
    """A bushing was pressed by its teeth by more than a limit since the row before.

    Attributes
    ----------
    force : float
        The limit [N].
    bushing : int, optional
        Number of the bushing, from 1; by default any.
    """

    group: ClassVar[str | None] = "teeth"

    force: float
    bushing: int | None = None

    def __post_init__(self) -> None:
        """Refuse numbers that mean nothing."""
        super().__post_init__()
        self._positive("force", "N")

    def look_at(self, simulation: Simulation) -> Look:
        """Return what looks at each report of `simulation`."""
        return self._force(simulation, "peak_tooth_force", "bushing", "bushing")


@known_keywords
@dataclass(frozen=True)
class StrandSlack(StopCondition):
    """A strand has lost its tension.

    Attributes
    ----------
    tension : float
        The strand is slack where the mean pull of its hinges is not above this [N].
    strand : str, optional
        Name of the strand, as of `Result.strand`; by default any.
    lasting : float
        For how long it has to be slack without a break [s]: a strand that swings is slack for a
        moment again and again.
    """

    group: ClassVar[str | None] = "hinges"

    tension: float = 0.0
    strand: str | None = None
    lasting: float = 0.0

    def __post_init__(self) -> None:
        """Refuse numbers that mean nothing."""
        super().__post_init__()
        for field, unit in (("tension", "N"), ("lasting", "s")):
            value = getattr(self, field)
            if not isinstance(value, float | int) or not 0.0 <= value < math.inf:
                raise self._refusal(field, value, f"must be a number in {unit}, not negative")

    def look_at(self, simulation: Simulation) -> Look:
        """Return what looks at each report of `simulation`."""
        names = _rustchain.strand_names(simulation.drive)
        if self.strand is not None and self.strand not in names:
            raise self._refusal(
                "strand", self.strand, f"is no strand; {suggest(self.strand, names)}"
            )
        since: dict[str, float] = {}

        def look() -> str | None:
            row = simulation._core.last_row("strand_tension")
            for name, pull in zip(names, row, strict=True):
                if self.strand not in (None, name) or pull > self.tension or np.isnan(pull):
                    since.pop(name, None)
                    continue
                begin = since.setdefault(name, simulation.time)
                if simulation.time - begin >= self.lasting * (1.0 - 1e-12):
                    lasting = f" for {self.lasting:g} s" if self.lasting else ""
                    return f"strand {name!r} is slack{lasting}: its tension is {pull:.4g} N"
            return None

        return look


@known_keywords
@dataclass(frozen=True)
class TimeReached(StopCondition):
    """The simulation's time, which goes on from run to run, has reached a value.

    Attributes
    ----------
    time : float
        [s].
    """

    time: float

    def __post_init__(self) -> None:
        """Refuse numbers that mean nothing."""
        super().__post_init__()
        self._positive("time", "s")

    def look_at(self, simulation: Simulation) -> Look:
        """Return what looks at each report of `simulation`."""

        def look() -> str | None:
            rounding = 1e-12 * self.time
            return f"reached {self.time:g} s" if simulation.time >= self.time - rounding else None

        return look


def looks_of(
    simulation: Simulation,
    stop: StopCondition | Sequence[StopCondition],
    callback: Callable[[Simulation], object] | None,
    groups: Sequence[str],
) -> list[Look]:
    """Return what looks at each report of a run that records `groups`."""
    conditions = [stop] if isinstance(stop, StopCondition) else stop
    looks: list[Look] = []
    if isinstance(conditions, str) or not isinstance(conditions, Sequence):
        msg = (
            f"stop = {stop!r}: must be a stop condition, such as HingeForceAbove, or a list of them"
        )
        raise InvalidInput(msg)
    for condition in conditions:
        if not isinstance(condition, StopCondition):
            msg = (
                f"stop: {condition!r} is no stop condition, such as HingeForceAbove; a function of "
                "your own goes into callback="
            )
            raise InvalidInput(msg)
        if condition.group is not None and condition.group not in groups:
            msg = (
                f"stop: {type(condition).__name__} looks at what is recorded of the "
                f"{condition.group}: add {condition.group!r} to record"
            )
            raise InvalidInput(msg)
        looks.append(condition.look_at(simulation))
    if callback is not None:
        if not callable(callback):
            msg = f"callback = {callback!r}: must be a function of the simulation"
            raise InvalidInput(msg)

        def called() -> str | None:
            answer = callback(simulation)
            # Not just anything that counts as true: a function may return what it likes.
            asked = isinstance(answer, bool | np.bool_) and bool(answer)
            return "the callback asked for it" if asked else None

        looks.append(called)
    return looks
