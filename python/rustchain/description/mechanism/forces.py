"""Forces of a mechanism: the methods of `Mechanism` that add them."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Sequence

from rustchain.arguments import finite_number, plain, shown
from rustchain.description.mechanism.checks import one_of
from rustchain.description.mechanism.checks import point as point_of
from rustchain.description.mechanism.parts import GROUND, Force, LoadFunction
from rustchain.description.signals import Curve, Signal, refuse_functions
from rustchain.errors import InvalidInput
from rustchain.typing import Numbers, Point


def _check_stiffness(name: str, stiffness: object, cubic: object, unit: str) -> None:
    """Refuse a spring that pushes its ends apart without end; a cubic part holds a snap spring."""
    given, held = finite_number(stiffness), finite_number(cubic)
    if given is not None and given < 0.0 and not (held is not None and held > 0.0):
        msg = (
            f"stiffness of force {shown(name)} = {shown(stiffness)}: must be zero or a positive "
            f"number in {unit}, unless cubic is positive"
        )
        raise InvalidInput(msg)
    if held is not None and held < 0.0 and not (given is not None and given > 0.0):
        msg = (
            f"cubic of force {shown(name)} = {shown(cubic)}: must be zero or a positive number, "
            "unless stiffness is positive"
        )
        raise InvalidInput(msg)


class WithForces:
    """Base of `Mechanism`: force elements."""

    forces: Sequence[Force]

    def add_force(
        self,
        name: str,
        body: str,
        force: Sequence[Signal] | Numbers,
        point: Point = (0.0, 0.0),
        follows: bool = False,
    ) -> None:
        """Add a force on a point of a body.

        Parameters
        ----------
        name : str
            Name of the force.
        body : str
            Name of the body.
        force : (x, y)
            Components of the force [N], each a number, rows of (time, force), or a `Table`,
            `Spline`, `Sines` or `SmoothStep`.
        point : (float, float)
            Point in the frame of the body [m]; by default the centre of mass.
        follows : bool
            Whether the force turns with the body: `force` is then in its frame, otherwise in that
            of the ground.
        """
        components = plain(force)
        if not isinstance(components, tuple) or len(components) != 2:
            msg = f"force of {shown(name)} = {shown(force)}: must be two components (x, y) [N]"
            raise InvalidInput(msg)
        refuse_functions(f"force of {shown(name)}", *components)
        x, y = components
        at = point_of("point", "force", name, point)
        made = Force("force", name, GROUND, body, point_b=at, x=x, y=y, follows=follows)
        self.forces = (*self.forces, made)

    def add_torque(
        self,
        name: str,
        body: str,
        torque: Signal | None = None,
        by_speed: Curve | None = None,
        reaction: str = GROUND,
    ) -> None:
        """Add a torque on a body, over time or over its speed.

        Exactly one of `torque` and `by_speed` must be given.

        Parameters
        ----------
        name : str
            Name of the torque.
        body : str
            Name of the body.
        torque : float, rows of (time, torque), Table, Spline, Sines or SmoothStep, optional
            Torque [N m] over time [s], counterclockwise positive.
        by_speed : rows of (speed, torque) or Table, optional
            Torque [N m] over the angular velocity relative to `reaction` [rad/s].
        reaction : str
            Name of the body that takes the reaction; by default the ground.
        """
        one_of(name, "torque", torque, "by_speed", by_speed)
        if torque is None:
            made = Force("torque_by_speed", name, reaction, body, table=by_speed)
        else:
            made = Force("torque", name, reaction, body, x=torque)
        self.forces = (*self.forces, made)

    def add_spring(
        self,
        name: str,
        body_a: str,
        body_b: str,
        stiffness: float = 0.0,
        damping: float = 0.0,
        *,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
        rest_length: float | None = None,
        cubic: float = 0.0,
        table: Curve | None = None,
    ) -> None:
        """Add a spring and damper between two points.

        Parameters
        ----------
        name : str
            Name of the spring.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        point_a, point_b : (float, float)
            Points in the frames of the bodies [m].
        stiffness, damping, cubic : float
            Stiffness [N/m], damping [N s/m] and cubic coefficient [N/m^3]. With the elongation x
            the tension is stiffness * x + cubic * x^3 + damping * x'.
        rest_length : float, optional
            Length without force [m], by default as placed.
        table : sequence of (elongation [m], tension [N]), optional
            Tension over elongation, in place of `stiffness` and `cubic`.
        """
        if rest_length is not None and rest_length < 0:
            msg = (
                f"rest_length of force {shown(name)} = {shown(rest_length)}: must be zero or a "
                "positive number in m"
            )
            raise InvalidInput(msg)
        _check_stiffness(name, stiffness, cubic, "N/m")
        made = Force(
            "spring",
            name,
            body_a,
            body_b,
            point_of("point_a", "force", name, point_a),
            point_of("point_b", "force", name, point_b),
            stiffness=stiffness,
            damping=damping,
            cubic=cubic,
            rest=rest_length,
            table=table,
        )
        self.forces = (*self.forces, made)

    def add_torsion_spring(
        self,
        name: str,
        body_a: str,
        body_b: str,
        stiffness: float = 0.0,
        damping: float = 0.0,
        rest_angle: float | None = None,
        cubic: float = 0.0,
        table: Curve | None = None,
    ) -> None:
        """Add a torsion spring and damper between the angles of two bodies.

        Parameters
        ----------
        name : str
            Name of the spring.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        stiffness, damping, cubic : float
            Stiffness [N m/rad], damping [N m s/rad] and cubic coefficient [N m/rad^3]. The torque
            against the rotation x of b relative to a is stiffness * x + cubic * x^3 + damping * x'.
        rest_angle : float, optional
            Angle of b minus that of a without torque [rad]; by default as placed.
        table : sequence of (rotation [rad], torque [N m]), optional
            Torque over rotation, in place of `stiffness` and `cubic`.
        """
        _check_stiffness(name, stiffness, cubic, "N m/rad")
        made = Force(
            "torsion_spring",
            name,
            body_a,
            body_b,
            stiffness=stiffness,
            damping=damping,
            cubic=cubic,
            rest=rest_angle,
            table=table,
        )
        self.forces = (*self.forces, made)

    def add_callable(self, name: str, body: str, function: LoadFunction) -> None:
        """Add a load on a body by a Python function: for prototypes, slower than other forces.

        Parameters
        ----------
        name : str
            Name of the force.
        body : str
            Name of the body.
        function : callable
            Called with time [s], position and velocity of the body (three numbers each); returns
            force x, force y [N] and torque about the centre of mass [N m]. An exception ends the
            run.
        """
        if not callable(function):
            msg = (
                f"function of force {shown(name)} = {shown(function)}: must be callable: "
                "f(time, position, velocity) that returns (force x, force y, torque)"
            )
            raise InvalidInput(msg)
        arguments = None
        with contextlib.suppress(ValueError):  # some built-in functions have no signature
            arguments = inspect.signature(function)
        try:
            _ = arguments and arguments.bind(0.0, (), ())
        except TypeError as error:
            msg = (
                f"function of force {shown(name)} = {shown(function)}: takes the arguments "
                f"{arguments}; expected three: time, position, velocity"
            )
            raise InvalidInput(msg) from error
        self.forces = (*self.forces, Force("custom", name, GROUND, body, function=function))
