"""Parts whose speed or torque a run sets: sprockets, and drivers and torques of mechanisms."""

from __future__ import annotations

from typing import Literal

from rustchain.arguments import plain, shown
from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.errors import InvalidInput, NoSuchPart
from rustchain.names import suggest

Quantity = Literal["speed", "torque"]


def part_of(system: ChainDrive | Mechanism, part: object, quantity: Quantity) -> str | int:
    """Return the part as the compiled module takes it: the number of a sprocket, or a name.

    Raises
    ------
    NoSuchPart
        The mechanism has no joint, or no force, of this name.
    InvalidInput
        The part is no number or name of a sprocket.
    """
    if isinstance(system, ChainDrive):
        return _sprocket_number(part)
    if quantity == "speed":
        kind, names = "driver described by its speed", [joint.name for joint in system.joints]
        known = [j.name for j in system.joints if j.kind.startswith("driven") and j.by_speed]
    else:
        kind, names = "applied torque", [force.name for force in system.forces]
        known = [force.name for force in system.forces if force.kind == "torque"]
    if isinstance(part, str) and part in names:
        return part  # the compiled module checks its kind
    found = suggest(part, known) if known else "there is none"
    msg = f"part = {shown(part)}: no {kind} of the mechanism has this name; {found}"
    raise NoSuchPart(msg)


def _sprocket_number(sprocket: object) -> int:
    """Return the number, from 1, in a name such as "sprocket_2"; a number is one already."""
    number = plain(sprocket)
    if isinstance(sprocket, str) and sprocket.startswith("sprocket_"):
        digits = sprocket.removeprefix("sprocket_")
        number = int(digits) if digits.isdecimal() and len(digits) < 10 else None
    if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number < 2**31:
        msg = f"part = {shown(sprocket)}: must be such as 'sprocket_2', or 2"
        raise InvalidInput(msg)
    return number
