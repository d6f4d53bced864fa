"""Exceptions and warnings of the package, each with one base class."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from rustchain import _rustchain
from rustchain.panics import guard

if TYPE_CHECKING:
    from rustchain.results.result import Result

__all__ = [
    "CaseWarning",
    "EnergyWarning",
    "InvalidInput",
    "MissingExtra",
    "NoSuchPart",
    "NotRecorded",
    "RangeWarning",
    "RustchainError",
    "RustchainWarning",
    "SimulationError",
    "ToothJumpWarning",
]

guard(_rustchain)


class RustchainError(Exception):
    """Base class of all exceptions of this package."""


class InvalidInput(RustchainError, ValueError):
    """A description or an argument is out of its allowed range.

    Examples
    --------
    >>> try:
    ...     rc.Link(mass=-1.0, inertia=1e-7)
    ... except rc.InvalidInput as error:
    ...     print(error)
    Link.mass = -1: must be a positive number in kg
    """


class NotRecorded(RustchainError, LookupError):
    """The run did not record the requested quantity.

    Examples
    --------
    >>> result = rc.Simulation(rc.paper_drive()).run(1e-4, record=["sprockets"], progress=False)
    >>> try:
    ...     result.hinge(1)
    ... except rc.NotRecorded as error:
    ...     print(error)
    hinges were not recorded; pass record=(..., 'hinges') to run
    """


class MissingExtra(RustchainError, ImportError):
    """A package of an extra, or the library of FMUs, is not installed.

    The message has the command that installs it.
    """


class SimulationError(RustchainError, RuntimeError):
    """A run cannot continue.

    Attributes
    ----------
    time : float, optional
        Time of the failure [s].
    step_size : float, optional
        Step size at that time [s].
    contact : str, optional
        The contact, body or joint with the largest error.
    result : Result, optional
        Rows recorded before the failure; set by `Simulation.run` and `sweep`.
    """

    time: float | None = None
    step_size: float | None = None
    contact: str | None = None
    result: Result | None = None


class RustchainWarning(UserWarning):
    """Base class of all warnings of this package."""


class NoSuchPart(InvalidInput, IndexError):
    """The scene has no hinge, strand, body or other part of this number or name.

    Examples
    --------
    >>> try:
    ...     rc.Simulation(rc.paper_drive()).run(1e-4, progress=False).strand("uper")
    ... except rc.NoSuchPart as error:
    ...     print(error)
    strand: 'uper' is no strand; did you mean 'upper'?
    """


class RangeWarning(RustchainWarning):
    """A contact has left the range of validity of its force law."""


class EnergyWarning(RustchainWarning, RuntimeWarning):
    """The energy balance residual of a run is large beside the energy dissipated."""


class CaseWarning(RustchainWarning, RuntimeWarning):
    """Cases of a sweep have failed."""


class ToothJumpWarning(RustchainWarning, RuntimeWarning):
    """The chain has jumped teeth of a sprocket."""


def attach(error: BaseException, name: str, value: object) -> None:
    """Set an attribute of an exception, unless its class refuses it, as a frozen dataclass does."""
    with suppress(AttributeError, TypeError):
        BaseException.__setattr__(error, name, value)
