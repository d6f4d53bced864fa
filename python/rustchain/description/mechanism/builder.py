"""Planar mechanisms described by hand: bodies, ideal joints, drivers, forces and contacts."""

from __future__ import annotations

from rustchain.arguments import checked, shown
from rustchain.description.mechanism.checks import numbers
from rustchain.description.mechanism.contacts import WithContacts
from rustchain.description.mechanism.forces import WithForces
from rustchain.description.mechanism.joints import WithJoints
from rustchain.description.mechanism.parts import (
    Body,
    Contact,
    Force,
    Joint,
    Point,
    check_name,
    check_part_name,
)
from rustchain.description.mechanism.report import MechanismReport
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords


@known_keywords
class Mechanism(WithJoints, WithForces, WithContacts):
    """Rigid bodies in the plane, what joins them and what acts on them.

    Points are given in the frames of the bodies, which sit at the centres of mass; ``"ground"`` is
    the frame that does not move. Where bodies are placed already, ``at=(x, y)`` gives one point of
    the ground's frame in place of a point of each body.

    Parameters
    ----------
    gravity : (float, float)
        [m/s^2].
    name : str
        For people to read.
    """

    def __init__(self, gravity: Point = (0.0, -9.81), name: str = "") -> None:
        if not isinstance(name, str):
            msg = f"name of the mechanism = {shown(name)}: must be text"
            raise InvalidInput(msg)
        check_name("name of the mechanism", name)
        self.gravity = numbers("gravity", gravity, 2, "(x, y) [m/s^2]")
        self.name = name
        self.bodies: list[Body] = []
        self.joints: list[Joint] = []
        self.forces: list[Force] = []
        self.contacts: list[Contact] = []

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
            [kg] and, about the centre of mass, [kg m^2]; zero where joints carry the body along.
        position, velocity : (float, float, float)
            Centre of mass and angle [m, m, rad], and their rates.
        fixed : bool
            Whether the body is held where it is.
        """
        check_part_name("name of a body", name)
        for field, given in (("position", position), ("velocity", velocity)):
            numbers(f"{field} of body {shown(name)}", given, 3, "(x, y, angle)")
        self.bodies.append(Body(name, mass, inertia, position, velocity, fixed))
        return name

    def check(self) -> MechanismReport:
        """Assemble the mechanism and tell what was found, or raise with the joints at fault."""
        from rustchain import _rustchain
        from rustchain.description.solver import Solver

        return MechanismReport(**_rustchain.MechanismCore(self, Solver(), None).check())


# Errors of a call, such as of a missing argument, name the method by this class.
for _part in (WithJoints, WithForces, WithContacts):
    for _name, _method in vars(_part).items():
        if _name.startswith("add_"):
            for _function in (_method, _method.__wrapped__):
                _function.__qualname__ = f"Mechanism.{_name}"
            # What else is wrong is told of the part, when the mechanism is put together.
            _only = {
                WithJoints: (str,),
                WithForces: (str, float | None),
                WithContacts: (str, float, bool),
            }[_part]
            setattr(Mechanism, _name, checked(_method, _only))
