"""When a run of a mechanism ends before its time: at a force of a joint or contact, at a time."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from rustchain.arguments import admitted, finite_number, shown
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords, suggest
from rustchain.simulation.stop import TimeReached, look_of_callback

if TYPE_CHECKING:
    from rustchain.simulation.mechanism_simulation import MechanismSimulation
    from rustchain.typing import Array

Look: TypeAlias = Callable[[], "str | None"]
"""Says why the run is to stop at the report just made, if it is."""


@dataclass(frozen=True)
class MechanismStopCondition(ABC):
    """What the stop conditions of mechanisms have; choose one of its subclasses.

    A condition is looked at when a row has been recorded, and the run stops there: forces are the
    largest since the row before, so that no impact is missed.
    """

    force: float

    def __post_init__(self) -> None:
        """Check the limit."""
        force = finite_number(self.force)
        if force is None or force <= 0.0:
            msg = (
                f"{type(self).__name__}.force = {shown(self.force)}: must be a positive number in N"
            )
            raise InvalidInput(msg)
        object.__setattr__(self, "force", force)
        for field in dataclasses.fields(self)[1:]:  # the name of a part
            where = f"{type(self).__name__}.{field.name}"
            admitted(where, getattr(self, field.name), str | None)

    @abstractmethod
    def look_at(self, simulation: MechanismSimulation) -> Look:
        """Return what looks at each report of `simulation`."""

    def _force(
        self, part: str, name: str | None, names: Sequence[str], row: Callable[[], Array]
    ) -> Look:
        """Return what looks for a force above the limit, of one part or of all."""
        if name is not None and name not in names:
            msg = (
                f"{type(self).__name__}.{part} = {shown(name)}: is no {part} of this mechanism; "
                f"{suggest(name, names)}"
            )
            raise InvalidInput(msg)
        if not names:
            msg = f"{type(self).__name__}: this mechanism has no {part}s"
            raise InvalidInput(msg)
        first = 0 if name is None else names.index(name)
        which = slice(first, len(names) if name is None else first + 1)

        def look() -> str | None:
            forces = row()[which]
            worst = int(forces.argmax())
            if forces[worst] <= self.force:
                return None
            found = names[first + worst]
            return f"{part} {found!r} bore {forces[worst]:.4g} N, above {self.force:g} N"

        return look


@known_keywords
@dataclass(frozen=True)
class JointForceAbove(MechanismStopCondition):
    """An ideal joint bore more than a limit since the row before.

    For mechanisms, and for drives with ideal hinges, whose joints are ``"hinge_1"`` and so on,
    ``"bearing_1"`` and ``"motor_1"``, as in `ChainDrive.to_mechanism`.

    Attributes
    ----------
    force : float
        The limit [N].
    joint : str, optional
        Name of the joint or driver; by default any.
    """

    joint: str | None = None

    def look_at(self, simulation: MechanismSimulation) -> Look:
        """Return what looks at each report of `simulation`."""
        core = simulation._core
        return self._force("joint", self.joint, core.joint_names, lambda: core.last_peaks()[0])


@known_keywords
@dataclass(frozen=True)
class ContactForceAbove(MechanismStopCondition):
    """A contact or clearance joint was pressed by more than a limit since the row before.

    For mechanisms, and for drives with ideal hinges, whose contacts are such as
    ``"bushing_6_on_sprocket_1"``.

    Attributes
    ----------
    force : float
        The limit [N].
    contact : str, optional
        Name of the contact; by default any.
    """

    contact: str | None = None

    def look_at(self, simulation: MechanismSimulation) -> Look:
        """Return what looks at each report of `simulation`."""
        core = simulation._core
        names = core.contact_names
        return self._force("contact", self.contact, names, lambda: core.last_peaks()[1])


MechanismStop: TypeAlias = MechanismStopCondition | TimeReached


def looks_of(
    simulation: MechanismSimulation,
    stop: MechanismStop | Sequence[MechanismStop],
    callback: Callable[[MechanismSimulation], object] | None,
) -> list[Look]:
    """Return what looks at each report of a run."""
    kinds = (MechanismStopCondition, TimeReached)
    wanted = "JointForceAbove, ContactForceAbove or TimeReached"
    conditions = [stop] if isinstance(stop, kinds) else stop
    if isinstance(conditions, str) or not isinstance(conditions, Sequence):
        msg = f"stop = {shown(stop)}: must be {wanted}, or a list of them"
        raise InvalidInput(msg)
    looks: list[Look] = []
    for condition in conditions:
        if not isinstance(condition, kinds):
            msg = (
                f"stop: {shown(condition)} is no stop condition of mechanisms, which are "
                f"{wanted}; a "
                "function of your own goes into callback="
            )
            raise InvalidInput(msg)
        looks.append(condition.look_at(simulation))  # type: ignore[arg-type]
    if callback is not None:
        if not callable(callback):
            msg = f"callback = {shown(callback)}: must be a function of the simulation"
            raise InvalidInput(msg)
        looks.append(look_of_callback(simulation, callback))
    return looks
