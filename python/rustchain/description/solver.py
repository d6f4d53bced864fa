"""Method and tolerances of the integration."""

from __future__ import annotations

from typing import Literal

from rustchain.description.base import Description, description
from rustchain.errors import InvalidInput

Method = Literal["auto", "pece", "newton"]

_COARSEST = 1e-4  # [m]: a hundred typical penetrations, four typical clearances
_FINEST = 1e-15  # of relative errors: rounding


@description(frozen=True)
class Solver(Description):
    """Method and tolerances of the integration: Adams' formulas of variable step and order.

    Attributes
    ----------
    method : {"auto", "pece", "newton"}
        Solution of the corrector's equation. "pece": predict, evaluate, correct, evaluate
        (Adams-Bashforth-Moulton, Shampine and Gordon 1975); stiff contacts limit its step size.
        "newton": Newton's method with analytical derivatives of all contacts. In drives they are
        without small terms that would make the matrix unsymmetric. Order 2, the trapezoidal rule,
        during stiff vibration of contacts, higher orders where the motion is smooth. "auto": the
        cheaper of the two, switched during the run. It begins with "newton" where a contact is
        closed or has a film. With ideal hinges it is always "newton".
    rtol, atol : float, optional
        Relative and absolute tolerance of every component, in its own unit, as in SciPy. If one of
        them is given, they replace `accuracy`; the other is then 1e-5. `rtol` is 0, or 1e-15 or
        more.
    max_step : float
        Largest step [s].
    max_order : int
        Highest order, 1 to 12.
    accuracy : float
        Error tolerance of a step in lengths [m], at most 1e-4; more than 1e-7 does not resolve the
        contacts of drives. In speeds it is `accuracy` times
        1e5/s, in angles the rotation that moves a point at half the pitch by `accuracy` (a
        sprocket's, at its pitch radius). Links on ideal hinges have half of it, not of `rtol` and
        `atol`. For comparison: clearances of 25e-6 m, penetrations of about 1e-6 m, impacts at
        1e-3 to 1 m/s. A ten times smaller accuracy divides the energy residual by about three with
        "newton".

    Examples
    --------
    >>> rc.Solver(method="newton", accuracy=1e-9)
    Solver(method='newton', accuracy=1e-09)
    >>> rc.Solver(rtol=1e-7, atol=1e-9)
    Solver(rtol=1e-07, atol=1e-09)
    """

    method: Method = "auto"
    rtol: float | None = None
    atol: float | None = None
    max_step: float = 1e-4
    max_order: int = 12
    accuracy: float = 1e-10

    def __post_init__(self) -> None:
        """Check the fields, and refuse tolerances that no run can mean or keep."""
        super().__post_init__()
        if self.accuracy > _COARSEST:
            msg = (
                f"Solver.accuracy = {self.accuracy:g}: must be at most {_COARSEST:g} m, far above "
                "clearances and penetrations; the default is 1e-10"
            )
            raise InvalidInput(msg)
        if self.rtol is not None and 0.0 < self.rtol < _FINEST:
            msg = (
                f"Solver.rtol = {self.rtol:g}: is below rounding; must be zero, or {_FINEST:g} or "
                "more"
            )
            raise InvalidInput(msg)
