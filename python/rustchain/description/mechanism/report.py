"""Report of the assembly of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rustchain.html import HtmlView
from rustchain.names import counted

if TYPE_CHECKING:
    from rustchain.description.mechanism.builder import Mechanism

# Changes of positions and velocities that are not told [m, rad, m/s, rad/s].
_ROUNDING = 1e-12


@dataclass(frozen=True, repr=False)
class MechanismReport(HtmlView):
    """Report of the assembly of a mechanism.

    Attributes
    ----------
    degrees_of_freedom : int
        Motions that joints and drivers leave.
    redundant : tuple of str
        Joints with redundant constraints; one entry for each redundant equation.
    moved, turned : float
        Farthest that a body had to be moved [m] and turned [rad] to fulfil the joints.
    velocity_change, spin_change : float
        Largest change of a body's velocity [m/s] and rate of turning [rad/s] to fulfil joints and
        drivers; a body that is described without a velocity counts from rest.
    warnings : tuple of str
        Warnings, as text.
    mechanism : Mechanism, optional
        The mechanism.

    Examples
    --------
    >>> pendulum = rc.Mechanism()
    >>> pendulum.add_body("bar", mass=1.0, inertia=0.1, position=(0.5, 0.0, 0.0))
    'bar'
    >>> pendulum.add_revolute("pin", "ground", "bar", at=(0.0, 0.0))
    >>> pendulum.check().degrees_of_freedom
    1
    """

    degrees_of_freedom: int
    redundant: tuple[str, ...]
    moved: float
    turned: float
    velocity_change: float
    spin_change: float
    warnings: tuple[str, ...]
    mechanism: Mechanism | None = None

    def __repr__(self) -> str:
        """Return degrees of freedom and numbers of what is redundant and of warnings."""
        return (
            f"<MechanismReport: {counted(self.degrees_of_freedom, 'degrees')} of freedom, "
            f"{counted(len(self.redundant), 'redundant constraints')}, "
            f"{counted(len(self.warnings), 'warnings')}>"
        )

    def __str__(self) -> str:
        """Return the report, a line each."""
        return "\n".join(f"{label:<21}{text}" for label, text in self.rows())

    def rows(self) -> list[tuple[str, str]]:
        """Return the rows of the table: label and text."""
        return [
            ("degrees of freedom", str(self.degrees_of_freedom)),
            ("redundant", ", ".join(self.redundant) or "none"),
            ("positions", _changed(self.moved, "m", self.turned, "rad")),
            ("velocities", _changed(self.velocity_change, "m/s", self.spin_change, "rad/s")),
            *(("warning", text) for text in self.warnings),
        ]


def _changed(way: float, unit: str, turn: float, unit_of_turn: str) -> str:
    """Return the changes larger than rounding, as text."""
    changes = [f"{c:.3g} {u}" for c, u in ((way, unit), (turn, unit_of_turn)) if c > _ROUNDING]
    return f"changed by up to {', '.join(changes)}" if changes else "as given"
