"""Stop conditions of runs: forces of joints and contacts, by their names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from rustchain.arguments import admitted, shown
from rustchain.description.base import description
from rustchain.errors import InvalidInput, NoSuchPart
from rustchain.names import suggest
from rustchain.simulation.stop import Look, StopCondition, force_above

if TYPE_CHECKING:
    from rustchain.simulation.simulation import Simulation


@dataclass(frozen=True)
class _PartForceAbove(StopCondition):
    """Base of the conditions on forces of joints and contacts."""

    part: ClassVar[str]

    force: float

    def _check(self) -> None:
        self._check_number("force", "N")
        admitted(f"{type(self).__name__}.{self.part}", getattr(self, self.part), str | None)

    def look_at(self, simulation: Simulation) -> Look:
        """Return the function that is called at each report of `simulation`."""
        names: Sequence[str] = getattr(simulation, f"{self.part}_names")
        wanted = getattr(self, self.part)
        if not names:
            other = {"joint": "HingeForceAbove", "contact": "ToothForceAbove"}[self.part]
            remedy = f"; take {other}" if simulation.scene.kind == "drive" else ""
            kind, name = type(self).__name__, simulation.scene.name
            msg = f"stop: {kind}: {name} has no {self.part}s{remedy}"
            raise InvalidInput(msg)
        if wanted is not None and wanted not in names:
            expected = f"is no {self.part}; {suggest(wanted, names)}"
            raise self._refusal(self.part, wanted, expected, NoSuchPart)
        first = 0 if wanted is None else names.index(wanted)
        which = slice(first, len(names) if wanted is None else first + 1)
        called = [f"{self.part} {shown(name)}" for name in names]
        return force_above(simulation, f"peak_{self.part}_force", self.force, called, which)


@description(frozen=True)
class JointForceAbove(_PartForceAbove):
    """The reaction force of an ideal joint exceeded a limit since the row before.

    For mechanisms. Those of `ChainDrive.to_mechanism` with ideal hinges have joints such as
    ``"hinge_1"``, ``"bearing_1"`` and ``"motor_1"``.

    Attributes
    ----------
    force : float
        The limit [N].
    joint : str, optional
        Name of the joint or driver; by default any.

    Examples
    --------
    >>> mechanism = rc.paper_drive(pretension=25.0).to_mechanism(hinges="ideal")
    >>> above = rc.JointForceAbove(5.0, "hinge_6")
    >>> result = rc.Simulation(mechanism).run(0.1, stop=[above], progress=False)
    >>> result.status
    'stopped'
    """

    part: ClassVar[str] = "joint"
    group: ClassVar[str | None] = "joints"

    joint: str | None = None


@description(frozen=True)
class ContactForceAbove(_PartForceAbove):
    """The force of a contact or clearance joint exceeded a limit since the row before.

    For mechanisms. Those of `ChainDrive.to_mechanism` have contacts such as
    ``"bushing_6_on_sprocket_1"``.

    Attributes
    ----------
    force : float
        The limit [N].
    contact : str, optional
        Name of the contact; by default any.

    Examples
    --------
    >>> mechanism = rc.paper_drive(pretension=25.0).to_mechanism(hinges="ideal")
    >>> above = rc.ContactForceAbove(5.0)
    >>> result = rc.Simulation(mechanism).run(0.1, stop=[above], progress=False)
    >>> result.status
    'stopped'
    """

    part: ClassVar[str] = "contact"
    group: ClassVar[str | None] = "contacts"

    contact: str | None = None
