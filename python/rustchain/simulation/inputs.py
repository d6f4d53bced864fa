"""Parts whose speed or torque a run sets: sprockets, and drivers and torques of mechanisms."""

from __future__ import annotations

from typing import Literal

from rustchain.arguments import plain
from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.errors import NoSuchPart
from rustchain.parts import place_of, position_of

Quantity = Literal["speed", "torque"]

_DRIVER, _TORQUE = "driver described by its speed", "applied torque"


def part_of(system: ChainDrive | Mechanism, part: object, quantity: Quantity) -> str | int:
    """Return the part as the compiled module takes it: the number of a sprocket, or a name.

    Raises
    ------
    NoSuchPart
        There is no sprocket, driver or torque of this number or name.
    """
    try:
        return _known_part(system, part, quantity)
    except NoSuchPart as error:
        told = str(error)
        for kind in ("sprocket", _DRIVER, _TORQUE):  # the message has it once more
            told = told.removeprefix(f"{kind}: ")
        raise NoSuchPart(f"part: {told}") from None


def _known_part(system: ChainDrive | Mechanism, part: object, quantity: Quantity) -> str | int:
    if isinstance(system, ChainDrive):
        number = plain(part)
        if isinstance(number, int) and not isinstance(number, bool):
            return position_of("sprocket", number, len(system.sprockets)) + 1
        names = [f"sprocket_{number}" for number, _ in enumerate(system.sprockets, 1)]
        return place_of("sprocket", part, names) + 1
    if quantity == "speed":
        kind, names = _DRIVER, [joint.name for joint in system.joints]
        known = [j.name for j in system.joints if j.kind.startswith("driven") and j.by_speed]
    else:
        kind, names = _TORQUE, [force.name for force in system.forces]
        known = [force.name for force in system.forces if force.kind == "torque"]
    # Of a part of another kind, the compiled module says which one it is.
    known = names if isinstance(part, str) and part in names else known
    return known[place_of(kind, part, known)]
