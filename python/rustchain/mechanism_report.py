"""What assembling a mechanism found."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MechanismReport:
    """What assembling a mechanism found.

    Attributes
    ----------
    degrees_of_freedom : int
        Motions that joints and drivers leave.
    redundant : list of str
        Joints that hold something others hold already; one entry for each such equation.
    moved, turned : float
        Farthest that a body had to be moved [m] and turned [rad] to fulfil the joints.
    warnings : list of str
        What is worth a second look.
    """

    degrees_of_freedom: int
    redundant: list[str]
    moved: float
    turned: float
    warnings: list[str]

    def __str__(self) -> str:
        """Return the report, a line each."""
        lines = [
            f"degrees of freedom   {self.degrees_of_freedom}",
            f"redundant            {', '.join(self.redundant) or 'none'}",
            f"moved, turned        {self.moved:.3g} m, {self.turned:.3g} rad",
        ]
        return "\n".join(lines + [f"warning              {text}" for text in self.warnings])
