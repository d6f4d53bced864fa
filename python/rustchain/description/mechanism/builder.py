"""Planar mechanisms described by hand: bodies, ideal joints, drivers, forces and contacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar

from rustchain.arguments import admitted, checked, shown
from rustchain.description.base import described
from rustchain.description.mechanism.checks import check_name, check_part_name, numbers
from rustchain.description.mechanism.contacts import WithContacts
from rustchain.description.mechanism.forces import WithForces
from rustchain.description.mechanism.joints import WithJoints
from rustchain.description.mechanism.parts import Body, Contact, Force, Joint
from rustchain.description.mechanism.report import MechanismReport
from rustchain.description.plausibility import implausible_inputs
from rustchain.errors import InvalidInput
from rustchain.html import HtmlView
from rustchain.names import counted, known_keywords
from rustchain.typing import Numbers, Point

_PARTS: dict[str, type[Any]] = {
    "bodies": Body,
    "joints": Joint,
    "forces": Force,
    "contacts": Contact,
}


@known_keywords
@described
@dataclass(repr=False)
class Mechanism(WithJoints, WithForces, WithContacts, HtmlView):
    """Rigid bodies in the plane with joints, drivers, forces and contacts.

    Points are given in the frames of the bodies, which sit at the centres of mass; ``"ground"`` is
    the frame that does not move. Where bodies are placed already, ``at=(x, y)`` gives one point of
    the ground's frame in place of a point of each body.

    The mechanism of a scene is a frozen copy: it has a hash, and changes of it are refused.

    Parameters
    ----------
    gravity : (float, float)
        Acceleration of gravity [m/s^2].
    name : str
        Name for reports and figures.
    bodies, joints, forces, contacts : sequences of parts
        Parts, as the methods ``add_...`` make them; by default none. The mechanism keeps them as
        tuples.

    Examples
    --------
    >>> pendulum = rc.Mechanism()
    >>> pendulum.add_body("bar", mass=1.0, inertia=0.1, position=(0.5, 0.0, 0.0))
    'bar'
    >>> pendulum.add_revolute("pin", "ground", "bar", at=(0.0, 0.0))
    >>> result = rc.Simulation(pendulum).run(0.1, progress=False)
    >>> result.body("bar").position.shape
    (1001, 3)
    """

    _frozen: ClassVar[bool] = False  # of the class; frozen mechanisms have their own

    gravity: Point = (0.0, -9.81)
    name: str = ""
    bodies: Sequence[Body] = field(default=(), kw_only=True)
    joints: Sequence[Joint] = field(default=(), kw_only=True)
    forces: Sequence[Force] = field(default=(), kw_only=True)
    contacts: Sequence[Contact] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        """Check name and gravity; a list of parts becomes a tuple."""
        if not isinstance(self.name, str):
            msg = f"name of the mechanism = {shown(self.name)}: must be text"
            raise InvalidInput(msg)
        check_name("name of the mechanism", self.name)
        self.gravity = numbers("gravity", self.gravity, 2, "(x, y) [m/s^2]")
        for name, kind in _PARTS.items():
            parts = admitted(f"Mechanism.{name}", getattr(self, name), Sequence[kind])  # type: ignore[valid-type]
            setattr(self, name, parts)

    def __setattr__(self, name: str, value: object) -> None:
        """Set a field, unless the mechanism is frozen."""
        self._check_change(name)
        super().__setattr__(name, value)

    def __hash__(self) -> int:
        """Return the hash of a frozen mechanism."""
        if not self._frozen:
            msg = "unhashable type: 'Mechanism'; the mechanism of a Scene has a hash"
            raise TypeError(msg)
        return hash((type(self), *(getattr(self, each.name) for each in fields(self))))

    def copy(self) -> Mechanism:
        """Return a copy that can be changed, of the mechanism of a scene too."""
        return replace(self)

    def frozen(self) -> Mechanism:
        """Return a copy that cannot be changed, as scenes have it; a frozen one is itself."""
        if self._frozen:
            return self
        made = replace(self)
        made.__dict__["_frozen"] = True
        return made

    def _check_change(self, what: str) -> None:
        if self._frozen:
            msg = (
                f"Mechanism.{what}: the mechanism of a scene cannot be changed; change a copy, "
                "scene.system.copy(), and make a scene of it"
            )
            raise InvalidInput(msg)

    def __repr__(self) -> str:
        """Return what there is."""
        counts = ", ".join(counted(len(getattr(self, part)), part) for part in _PARTS)
        return f"<Mechanism {self.name!r}: {counts}>"

    @known_keywords
    def add_body(
        self,
        name: str,
        mass: float,
        inertia: float,
        position: Numbers = (0.0, 0.0, 0.0),
        velocity: Numbers = (0.0, 0.0, 0.0),
        fixed: bool = False,
    ) -> str:
        """Add a rigid body, and return its name.

        Parameters
        ----------
        name : str
            Name of the body.
        mass, inertia : float
            Mass [kg], and moment of inertia about the centre of mass [kg m^2]; above zero for a
            body that moves.
        position, velocity : (float, float, float)
            Centre of mass and angle [m, m, rad], and their rates [m/s, m/s, rad/s].
        fixed : bool
            Whether the body is held where it is.

        Returns
        -------
        str
            The name.
        """
        check_part_name("name of a body", name)
        for part, given in (("position", position), ("velocity", velocity)):
            numbers(f"{part} of body {shown(name)}", given, 3, "(x, y, angle)")
        self.bodies = (*self.bodies, Body(name, mass, inertia, position, velocity, fixed))
        return name

    def check(self) -> MechanismReport:
        """Assemble the mechanism and return the report, or raise with the joints at fault."""
        from rustchain import _rustchain
        from rustchain.description.solver import Solver

        found = _rustchain.MechanismCore(self, Solver()).check()
        found["redundant"] = tuple(found["redundant"])
        found["warnings"] = (*found["warnings"], *implausible_inputs(self))
        return MechanismReport(**found, mechanism=self.frozen())


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
