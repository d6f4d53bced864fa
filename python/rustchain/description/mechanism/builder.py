"""Planar mechanisms described by hand: bodies, ideal joints, drivers, forces and contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from rustchain.arguments import admitted, checked, shown
from rustchain.description.base import described
from rustchain.description.mechanism.checks import Point, check_name, check_part_name, numbers
from rustchain.description.mechanism.contacts import WithContacts
from rustchain.description.mechanism.forces import WithForces
from rustchain.description.mechanism.joints import WithJoints
from rustchain.description.mechanism.parts import Body, Contact, Force, Joint
from rustchain.description.mechanism.plausibility import implausible_inputs
from rustchain.description.mechanism.report import MechanismReport
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords

_Kind = TypeVar("_Kind")


@known_keywords
@described
@dataclass(repr=False)
class Mechanism(WithJoints, WithForces, WithContacts):
    """Rigid bodies in the plane with joints, drivers, forces and contacts.

    Points are given in the frames of the bodies, which sit at the centres of mass; ``"ground"`` is
    the frame that does not move. Where bodies are placed already, ``at=(x, y)`` gives one point of
    the ground's frame in place of a point of each body.

    Parameters
    ----------
    gravity : (float, float)
        [m/s^2].
    name : str
        For people to read.
    bodies, joints, forces, contacts : sequences of parts
        Parts, as the methods ``add_...`` make them; by default none.
    """

    gravity: Point = (0.0, -9.81)
    name: str = ""
    bodies: list[Body] = field(default_factory=list, kw_only=True)
    joints: list[Joint] = field(default_factory=list, kw_only=True)
    forces: list[Force] = field(default_factory=list, kw_only=True)
    contacts: list[Contact] = field(default_factory=list, kw_only=True)

    def __post_init__(self) -> None:
        """Check name and gravity; keep the lists of parts apart from those given."""
        if not isinstance(self.name, str):
            msg = f"name of the mechanism = {shown(self.name)}: must be text"
            raise InvalidInput(msg)
        check_name("name of the mechanism", self.name)
        self.gravity = numbers("gravity", self.gravity, 2, "(x, y) [m/s^2]")
        self.bodies = _parts("bodies", self.bodies, Body)
        self.joints = _parts("joints", self.joints, Joint)
        self.forces = _parts("forces", self.forces, Force)
        self.contacts = _parts("contacts", self.contacts, Contact)

    def __repr__(self) -> str:
        """Return what there is."""
        parts = ("bodies", "joints", "forces", "contacts")
        counts = ", ".join(f"{len(getattr(self, part))} {part}" for part in parts)
        return f"<Mechanism {self.name!r}: {counts}>"

    @known_keywords
    def add_body(
        self,
        name: str,
        mass: float,
        inertia: float,
        position: Point = (0.0, 0.0, 0.0),
        velocity: Point = (0.0, 0.0, 0.0),
        fixed: bool = False,
    ) -> str:
        """Add a rigid body, and return its name.

        Parameters
        ----------
        mass, inertia : float
            [kg] and, about the centre of mass, [kg m^2]; above zero for a body that moves.
        position, velocity : (float, float, float)
            Centre of mass and angle [m, m, rad], and their rates.
        fixed : bool
            Whether the body is held where it is.
        """
        check_part_name("name of a body", name)
        for part, given in (("position", position), ("velocity", velocity)):
            numbers(f"{part} of body {shown(name)}", given, 3, "(x, y, angle)")
        self.bodies.append(Body(name, mass, inertia, position, velocity, fixed))
        return name

    def check(self) -> MechanismReport:
        """Assemble the mechanism and return the report, or raise with the joints at fault."""
        from rustchain import _rustchain
        from rustchain.description.solver import Solver

        found = _rustchain.MechanismCore(self, Solver()).check()
        return MechanismReport(**found | {"warnings": found["warnings"] + implausible_inputs(self)})


def _parts(where: str, given: object, kind: type[_Kind]) -> list[_Kind]:
    """Return the parts of one kind as a list of the mechanism's own."""
    found: tuple[_Kind, ...] = admitted(f"Mechanism.{where}", given, Sequence[kind])  # type: ignore[valid-type]
    return list(found)


# Errors of a call, such as of a missing argument, name the method by this class. What else is wrong
# is told of the part, when the mechanism is put together.
for _part, _only in (
    (WithJoints, (str,)),
    (WithForces, (str, float | None)),
    (WithContacts, (str, float, bool)),
):
    for _name, _method in vars(_part).items():
        if _name.startswith("add_"):
            _method.__qualname__ = f"Mechanism.{_name}"
            setattr(Mechanism, _name, checked(_method, _only))
