"""Variables of an FMU: the inputs and outputs that a drive has, with units and descriptions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from rustchain import _rustchain
from rustchain.arguments import shown
from rustchain.description.drive import ChainDrive
from rustchain.description.sprocket import PrescribedSpeed
from rustchain.errors import InvalidInput
from rustchain.names import suggest


@dataclass(frozen=True)
class Variable:
    """Name, unit and description of a variable."""

    name: str
    unit: str
    description: str


@dataclass(frozen=True)
class Input(Variable):
    """An input: number of the sprocket, from 1, and its quantity in the compiled core."""

    sprocket: int
    quantity: str


@dataclass(frozen=True)
class Output(Variable):
    """An output: a channel, and the number of its element, or None for the largest one."""

    channel: str
    element: int | None


def inputs_of(drive: ChainDrive) -> Iterator[Input]:
    """Return all inputs of a drive."""
    for number, sprocket in enumerate(drive.sprockets, 1):
        name = f"sprocket_{number}"
        if isinstance(sprocket.motion, PrescribedSpeed):
            text = "prescribed angular speed"
            yield Input(f"{name}.set_speed", "rad/s", text, number, "speed")
        else:
            text = "applied torque, without that of a curve over the speed"
            yield Input(f"{name}.set_torque", "N.m", text, number, "torque")
    if drive.tensioner is not None:
        text = "force of the tensioner on its sprocket"
        number = drive.tensioner.sprocket
        yield Input("tensioner.set_force", "N", text, number, "tensioner_force")


def outputs_of(drive: ChainDrive) -> Iterator[Output]:
    """Return all outputs of a drive."""
    for element in range(len(drive.sprockets)):
        name = f"sprocket_{element + 1}"
        yield Output(f"{name}.angle", "rad", "angle", "sprocket_angle", element)
        yield Output(f"{name}.speed", "rad/s", "angular speed", "sprocket_speed", element)
        text = "shaft torque: of the motor, or applied"
        yield Output(f"{name}.torque", "N.m", text, "sprocket_torque", element)
    for element, strand in enumerate(_rustchain.strand_names(drive)):
        name = f"strand_{strand.replace('-', '_')}.tension"
        text = f"mean tension of the hinges of the strand {strand}"
        yield Output(name, "N", text, "strand_tension", element)
    contacts = [("hinges", "pins in bushings", "peak_hinge_force")]
    if drive.chain.roller is not None:
        contacts.append(("rollers", "bushings in rollers", "peak_roller_force"))
    contacts.append(("teeth", "bushings or rollers on teeth", "peak_tooth_force"))
    for group, what, channel in contacts:
        text = f"largest normal force of {what} since the last communication point"
        yield Output(f"{group}.largest_force", "N", text, channel, None)


def chosen(
    field: str, names: Sequence[str] | None, there: Iterable[Input | Output]
) -> list[Input | Output]:
    """Return those of the variables that have these names, by default all."""
    known = {each.name: each for each in there}
    if names is None:
        return list(known.values())
    for name in names:
        if name not in known:
            msg = f"{field}: {shown(name)} is not one of this drive; {suggest(name, known)}"
            raise InvalidInput(msg)
        if names.count(name) > 1:
            raise InvalidInput(f"{field}: {shown(name)} is there twice; give it once")
    return [known[name] for name in names]
