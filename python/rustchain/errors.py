"""What can go wrong, as types."""

from rustchain import _rustchain
from rustchain._rustchain import InvalidInput, SimulationError
from rustchain.panics import guard

__all__ = [
    "EnergyWarning",
    "InvalidInput",
    "NotRecorded",
    "RangeWarning",
    "SimulationError",
    "ToothJumpWarning",
]

guard(_rustchain)


class NotRecorded(LookupError):
    """A result was asked for something that its run did not record."""


class RangeWarning(UserWarning):
    """A contact has left the range in which its force law holds."""


class EnergyWarning(RuntimeWarning):
    """More energy is missing in a run than its accuracy should leave."""


class ToothJumpWarning(RuntimeWarning):
    """The chain has jumped teeth of a sprocket."""
