"""Signals: functions of time that prescribe speeds and positions, or apply torques and forces."""

from __future__ import annotations

from typing import TypeAlias

from rustchain import _rustchain
from rustchain.arguments import shown
from rustchain.description.base import Typed, description
from rustchain.errors import InvalidInput
from rustchain.typing import Number, Rows

_OTHER_FORMS = {  # than a number, and what a function is sampled into
    "signal": ("rows of (time, value), Table, Spline, Sines or SmoothStep", "Table"),
    "position": ("Spline, Sines or SmoothStep", "Spline"),
    "curve": ("rows or a Table", "Table"),
}


def refuse_functions(where: str, *given: object, kind: str = "signal", setter: str = "") -> None:
    """Refuse Python functions in the place of signals and curves; `setter` changes them in runs."""
    forms, sampled = _OTHER_FORMS[kind]
    remedy = f", or call {setter} with a number in a callback of the run" if setter else ""
    for each in given:
        if callable(each) and not isinstance(each, type):
            msg = (
                f"{where} = {shown(each)}: is a Python function; expected a number, {forms}; "
                f"sample it into a {sampled}{remedy}"
            )
            raise InvalidInput(msg)


class _Signal(Typed):
    """Base of the classes of signals."""

    def __post_init__(self) -> None:
        """Check the types of all fields, then have the compiled module check their values."""
        super().__post_init__()
        _rustchain.validate(self)


@description(frozen=True)
class SmoothStep(_Signal):
    """From one value to another with two continuous derivatives.

    Attributes
    ----------
    start, end : float
        Beginning and end of the change [s].
    before, after : float
        Values before and after it.

    Examples
    --------
    >>> rc.AppliedTorque(rc.SmoothStep(0.1, 0.2, before=0.0, after=-5.0))
    AppliedTorque(torque=SmoothStep(start=0.1, end=0.2, before=0.0, after=-5.0))
    """

    start: float
    end: float
    before: float
    after: float


@description(frozen=True)
class Table(_Signal):
    """Straight lines between rows of (time [s], value), held at both ends; a ramp has two rows.

    Its slope jumps at each row: it prescribes speeds, torques and forces, and no positions. The
    curves of springs, motors and loads are tables too, over length, angle or speed.

    Attributes
    ----------
    rows : sequence of (time, value)
        One row or more; times increase. Times that are equal to rounding are refused.

    Examples
    --------
    >>> rc.PrescribedSpeed(rc.Table([(0.0, 0.0), (0.5, 12.0)]))  # constant from 0.5 s on
    PrescribedSpeed(speed=Table(rows=((0.0, 0.0), (0.5, 12.0))))
    """

    rows: Rows


@description(frozen=True)
class Spline(_Signal):
    """A cubic spline with free ends through rows of (time [s], value).

    Two derivatives are continuous. Before the first row and after the last one it continues along
    its tangent.

    Attributes
    ----------
    rows : sequence of (time, value)
        Two rows or more; times increase. Times that are equal to rounding are refused.

    Examples
    --------
    >>> rc.Spline([(0.0, 0.0), (0.2, 8.0), (0.5, 12.0)])
    Spline(rows=((0.0, 0.0), (0.2, 8.0), (0.5, 12.0)))
    """

    rows: Rows


@description(frozen=True)
class Sines(_Signal):
    """A sum of sines: offset + sum of amplitude * sin(frequency * t + phase).

    Attributes
    ----------
    terms : sequence of (amplitude, angular frequency, phase)
        Amplitude, angular frequency [rad/s] and phase [rad] of each sine.
    offset : float
        Mean value.

    Examples
    --------
    >>> rc.PrescribedSpeed(rc.Sines([(0.3, 25.0, 0.0)], offset=12.5))  # a motor with a ripple
    PrescribedSpeed(speed=Sines(terms=((0.3, 25.0, 0.0),), offset=12.5))
    """

    terms: Rows
    offset: float = 0.0


Signal: TypeAlias = Number | Rows | SmoothStep | Table | Spline | Sines
"""A function of time; a number is a constant, rows of (time [s], value) are those of a `Table`."""

Curve: TypeAlias = Number | Rows | Table
"""A function of length, angle or speed: a constant, or the rows of a `Table`."""
