"""A scene: a drive or a mechanism with its laws, its solver and its start, as one value."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from inspect import isfunction
from typing import TYPE_CHECKING, Literal, cast, get_args

from rustchain.arguments import finite_number, plain, rows_of, shown
from rustchain.description.base import Description
from rustchain.description.drive import ChainDrive
from rustchain.description.laws.force import ForceLaw, LankaraniNikravesh
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords
from rustchain.typing import Rows

if TYPE_CHECKING:
    from rustchain.description.mechanism.report import MechanismReport
    from rustchain.description.report import DriveReport

Start = Literal["generated", "static"]
Kind = Literal["drive", "mechanism"]

_LAW = LankaraniNikravesh()
_MIN_IMPACT_VELOCITY = 1e-3  # [m/s]
_SOLVER_OF_MECHANISMS = Solver(method="pece", rtol=1e-9, atol=1e-9, max_step=0.01)


@known_keywords(min_approach_speed="min_impact_velocity")
@dataclass(frozen=True)
class Scene(Description):
    """Drive or mechanism to simulate, with laws, solver and start.

    Attributes
    ----------
    system : ChainDrive or Mechanism
        Drive or mechanism to simulate. Of a mechanism the scene keeps a
        frozen copy; ``scene.system.copy()`` can be changed.
    force_law : ForceLaw
        Law of every contact of a drive. The contacts of a mechanism have laws of their own.
    hinge_law, tooth_law : ForceLaw, optional
        Law of pins in bushings, and law of bushings on teeth; by default `force_law`.
    min_impact_velocity : float
        Lower bound on the initial impact velocity used by the damping factor [m/s]. Prevents
        unbounded damping of slow contacts. ``min_approach_speed`` is another name of it.
    solver : Solver, optional
        Method and tolerances; by default ``Solver()`` for drives, and for mechanisms
        ``Solver(method="pece", rtol=1e-9, atol=1e-9, max_step=0.01)``.
    start : {"generated", "static"}
        "generated": the generated configuration of a drive, with nothing in contact, or the
        described positions of a mechanism. "static": the static equilibrium under gravity, the
        loads of the first instant and the full force of tensioner and plungers, which then have
        no ramp. The search begins at the generated or described positions, with motors and
        drivers held there, and without friction. Prescribed speeds are kept. Other
        velocities of a drive are those of the generated start, changed so that loaded contacts stay
        closed; velocities of a mechanism are those described.
    positions, velocities : array_like, (bodies, 3), optional
        Initial positions [m, m, rad] and velocities [m/s, m/s, rad/s]; by default those of `start`.
        Positions need velocities with them; velocities alone go with the generated positions.
        Sprockets on fixed bearings, guides and anchors must be at their described positions.

    Raises
    ------
    InvalidInput
        A value is out of its range, or is not for this kind of system.

    Examples
    --------
    >>> scene = rc.Scene(rc.paper_drive(25.0), force_law=rc.Johnson(), start="static")
    >>> scene.kind
    'drive'
    """

    system: ChainDrive | Mechanism
    force_law: ForceLaw = _LAW
    hinge_law: ForceLaw | None = field(default=None, kw_only=True)
    tooth_law: ForceLaw | None = field(default=None, kw_only=True)
    min_impact_velocity: float = field(default=_MIN_IMPACT_VELOCITY, kw_only=True)
    solver: Solver = field(default=cast("Solver", None), kw_only=True)  # one, once it is made
    start: Start = field(default="generated", kw_only=True)
    positions: Rows | None = field(default=None, kw_only=True)
    velocities: Rows | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Convert the fields to plain values and check them."""
        self._check_system()
        for name in ("force_law", "hinge_law", "tooth_law"):
            law = getattr(self, name)
            if not isinstance(law, ForceLaw) and not (law is None and name != "force_law"):
                msg = (
                    f"{name} = {shown(law)}: expected a force law such as LankaraniNikravesh() or "
                    "Hertz()"
                )
                raise InvalidInput(msg)
        if not isinstance(self.solver, Solver | None):
            raise InvalidInput(f"solver = {shown(self.solver)}: must be a Solver")
        if self.solver is None:
            mechanism = isinstance(self.system, Mechanism)
            self._set("solver", _SOLVER_OF_MECHANISMS if mechanism else Solver())
        self._check_velocity()
        for name in ("positions", "velocities"):
            rows = rows_of(name, getattr(self, name), self.body_count)
            self._set(name, None if rows is None else plain(rows))
            self._check_finite(name)
        self._check_start()
        if self.kind == "mechanism":
            self._check_laws_of_mechanism()

    @property
    def kind(self) -> Kind:
        """The kind of system."""
        return "drive" if isinstance(self.system, ChainDrive) else "mechanism"

    @property
    def drive(self) -> ChainDrive:
        """The drive; raises `InvalidInput` where the scene has a mechanism."""
        if isinstance(self.system, ChainDrive):
            return self.system
        msg = (
            f"drive: {self.system!r} is no chain drive: hinges, bushings, strands and sprockets "
            "are of a ChainDrive only; a mechanism has body(name), joint(name) and contact(name)"
        )
        raise InvalidInput(msg)

    def check(self) -> DriveReport | MechanismReport:
        """Return the report of the drive's layout, or of the mechanism's assembly.

        With ``start="static"`` the tensioner has its full force from the start, and the report has
        no warning about its ramp.
        """
        system = self.system
        if isinstance(system, ChainDrive) and self.start == "static" and system.tensioner:
            full = replace(system, tensioner=replace(system.tensioner, ramp_time=0.0))
            return replace(full.check(), drive=system)
        return system.check()

    @property
    def name(self) -> str:
        """Name of the drive or mechanism, or its kind."""
        return self.system.name or ("mechanism" if self.kind == "mechanism" else "chain drive")

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of every (bodies, 3) array."""
        drive = self.system
        if isinstance(drive, Mechanism):
            return tuple(body.name for body in drive.bodies)
        rollers = 0 if drive.chain.roller is None else drive.hinge_count
        counts = (
            ("link", drive.chain.links),
            ("roller", rollers),
            ("sprocket", len(drive.sprockets)),
            ("guide", len(drive.guides)),
        )
        numbered = [[f"{part}_{k}" for k in range(1, count + 1)] for part, count in counts]
        ends = [] if drive.ends is None else ["end_2", "end_1"]
        return tuple(sum(numbered[1:], numbered[0] + ends))

    @property
    def body_count(self) -> int:
        """Number of bodies."""
        return len(self.body_names)

    @property
    def law_of_hinges(self) -> ForceLaw:
        """Law of pins in bushings."""
        return self.force_law if self.hinge_law is None else self.hinge_law

    @property
    def law_of_teeth(self) -> ForceLaw:
        """Law of bushings or rollers on teeth."""
        return self.force_law if self.tooth_law is None else self.tooth_law

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check_system(self) -> None:
        """Refuse what is neither a drive nor a mechanism; keep a frozen copy of a mechanism."""
        system = self.system
        if isinstance(system, Mechanism):
            self._set("system", system.frozen())
        elif not isinstance(system, ChainDrive):
            got, remedy = instead_of_a_scene(system)
            msg = f"system of the scene = {got}: must be a ChainDrive or a Mechanism{remedy}"
            raise InvalidInput(msg)

    def _check_velocity(self) -> None:
        given = plain(self.min_impact_velocity)
        speed = finite_number(given)
        if speed is None or speed <= 0.0:
            number = isinstance(given, float | int) and not isinstance(given, bool)
            kind = "a positive number" if number else "a number"
            got = shown(self.min_impact_velocity)
            raise InvalidInput(f"min_impact_velocity = {got}: must be {kind} in m/s")
        self._set("min_impact_velocity", float(speed))

    def _check_finite(self, name: str) -> None:
        """Refuse numbers of a start that are not finite, by the name of the body."""
        for row, numbers in zip(self.body_names, getattr(self, name) or (), strict=False):
            for number in numbers:
                if not math.isfinite(number):
                    msg = f"{name} of {row} = {number!r}: must be finite numbers"
                    raise InvalidInput(msg)

    def _check_start(self) -> None:
        """Refuse a start that is not defined, or not for this kind of system."""
        if not isinstance(self.start, str) or self.start not in get_args(Start):
            msg = f"start = {shown(self.start)}: must be 'generated' or 'static'"
            raise InvalidInput(msg)
        given = self.positions is not None or self.velocities is not None
        if self.start == "static" and given:
            msg = (
                "start = 'static': the positions are those of the equilibrium; leave out "
                "positions and velocities"
            )
            raise InvalidInput(msg)
        if self.positions is not None and self.velocities is None:
            msg = (
                "velocities = None: must be given when positions are; those of the generated start "
                "belong to its own positions"
            )
            raise InvalidInput(msg)

    def _check_laws_of_mechanism(self) -> None:
        """Refuse laws beside a mechanism, whose contacts have their own."""
        defaults = {
            "force_law": _LAW,
            "hinge_law": None,
            "tooth_law": None,
            "min_impact_velocity": _MIN_IMPACT_VELOCITY,
        }
        for name, default in defaults.items():
            if getattr(self, name) != default:
                msg = (
                    f"{name} = {shown(getattr(self, name))}: is not for a mechanism, whose "
                    "contacts have laws of their own; give it to the contacts, as in "
                    "SurfaceContact(law, ...)"
                )
                raise InvalidInput(msg)


class OfScene:
    """Properties of simulations and results that are those of their scene."""

    scene: Scene

    @property
    def drive(self) -> ChainDrive:
        """The drive; raises `InvalidInput` where a mechanism is simulated."""
        return self.scene.drive

    @property
    def hinge_law(self) -> ForceLaw:
        """Law of pins in bushings."""
        return self.scene.law_of_hinges

    @property
    def tooth_law(self) -> ForceLaw:
        """Law of bushings or rollers on teeth."""
        return self.scene.law_of_teeth

    @property
    def min_impact_velocity(self) -> float:
        """Lower bound on the initial impact velocity used by the damping factor [m/s]."""
        return self.scene.min_impact_velocity

    @property
    def solver(self) -> Solver:
        """Method and tolerances."""
        return self.scene.solver


def instead_of_a_scene(given: object) -> tuple[str, str]:
    """Return how a message shows what is no scene, and how it names the scene in it."""
    kind = type(given).__name__
    for name in ("scene", "system", "drive"):
        with suppress(Exception):  # of any object
            if isinstance(getattr(given, name), Scene | ChainDrive | Mechanism):
                return kind, f"; use {kind.lower()}.{name}"
    if isfunction(given):
        return shown(given), "; call it, or for sweep and study let it return the Scene"
    return shown(given), ""


def scene_of(given: object) -> Scene:
    """Return a scene as it is, and that of a drive or a mechanism with default laws."""
    return given if isinstance(given, Scene) else Scene(given)  # type: ignore[arg-type]
