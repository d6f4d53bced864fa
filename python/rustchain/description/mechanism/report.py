"""Report of the assembly of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

from rustchain.html import HtmlView

# Changes of positions and velocities that are not told [m, rad, m/s, rad/s].
_ROUNDING = 1e-12


@dataclass(frozen=True)
class MechanismReport(HtmlView):
    """What assembling a mechanism found.

    Attributes
    ----------
    degrees_of_freedom : int
        Motions that joints and drivers leave.
    redundant : list of str
        Joints with redundant constraints; one entry for each redundant equation.
    moved, turned : float
        Farthest that a body had to be moved [m] and turned [rad] to fulfil the joints.
    velocity_change, spin_change : float
        Largest change of a body's velocity [m/s] and rate of turning [rad/s] to fulfil joints and
        drivers; a body that is described without a velocity counts from rest.
    warnings : list of str
        Warnings, as text.
    """

    degrees_of_freedom: int
    redundant: list[str]
    moved: float
    turned: float
    velocity_change: float
    spin_change: float
    warnings: list[str]

    def __str__(self) -> str:
        """Return the report, a line each."""
        speeds = _changed(self.velocity_change, "m/s", self.spin_change, "rad/s")
        lines = [
            f"degrees of freedom   {self.degrees_of_freedom}",
            f"redundant            {', '.join(self.redundant) or 'none'}",
            f"positions            {_changed(self.moved, 'm', self.turned, 'rad')}",
            f"velocities           {speeds}",
        ]
        return "\n".join(lines + [f"warning              {text}" for text in self.warnings])


def _changed(way: float, unit: str, turn: float, unit_of_turn: str) -> str:
    """Return the changes larger than rounding, as text."""
    changes = [f"{c:.3g} {u}" for c, u in ((way, unit), (turn, unit_of_turn)) if c > _ROUNDING]
    return f"changed by up to {', '.join(changes)}" if changes else "as given"
