"""Planar mechanisms described by hand: bodies, ideal joints, drivers, forces and contacts."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rustchain._description import plain
from rustchain._mechanism_input import arcs, numbers, one_of, rows
from rustchain._names import known_keywords, suggest
from rustchain.drive import Chain, Sprocket
from rustchain.errors import InvalidInput
from rustchain.mechanism_parts import (
    GROUND,
    Body,
    Contact,
    ContactLaw,
    Force,
    Joint,
    LoadFunction,
    Point,
    Rows,
    TimeFunction,
)
from rustchain.mechanism_report import MechanismReport


@known_keywords
class Mechanism:
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
        self.gravity: tuple[float, ...] = plain(gravity)
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
        for field, given in (("position", position), ("velocity", velocity)):
            numbers(f"{field} of body {name!r}", given, 3, "(x, y, angle)")
        self.bodies.append(Body(name, mass, inertia, position, velocity, fixed))
        return name

    @known_keywords
    def add_revolute(
        self,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point | None = None,
        point_b: Point | None = None,
        at: Point | None = None,
    ) -> None:
        """Let a point of each body coincide."""
        self._join("revolute", name, body_a, body_b, point_a, point_b, at)

    @known_keywords
    def add_fixed(
        self,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point | None = None,
        point_b: Point | None = None,
        at: Point | None = None,
        angle: float | None = None,
    ) -> None:
        """Weld two bodies; `angle` of b less that of a [rad], by default as placed."""
        self._join("fixed", name, body_a, body_b, point_a, point_b, at, value=angle)

    @known_keywords
    def add_prismatic(
        self,
        name: str,
        body_a: str,
        body_b: str,
        direction: Point,
        point_a: Point | None = None,
        point_b: Point | None = None,
        at: Point | None = None,
        angle: float | None = None,
    ) -> None:
        """Let b slide on a line of a without turning: through point a, along `direction` of a."""
        self._join(
            "prismatic",
            name,
            body_a,
            body_b,
            point_a,
            point_b,
            at,
            direction=direction,
            value=angle,
        )

    @known_keywords
    def add_point_on_line(
        self,
        name: str,
        body_a: str,
        body_b: str,
        direction: Point,
        point_a: Point | None = None,
        point_b: Point | None = None,
        at: Point | None = None,
    ) -> None:
        """Keep point b on the line of a through point a, along `direction` of a."""
        self._join("point_on_line", name, body_a, body_b, point_a, point_b, at, direction=direction)

    @known_keywords
    def add_distance(
        self,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
        length: float | None = None,
    ) -> None:
        """Keep two points at a distance [m], by default as placed."""
        self._join("distance", name, body_a, body_b, point_a, point_b, None, value=length)

    @known_keywords
    def add_gear(
        self, name: str, body_a: str, body_b: str, ratio: float, carrier: str | None = None
    ) -> None:
        """Let two wheels roll on each other.

        Parameters
        ----------
        ratio : float
            Turns of b for one turn of a, both seen from the carrier: -r_a / r_b for wheels outside
            each other, +r_a / r_b for one inside the other.
        carrier : str, optional
            The body on which both turn; by default the ground.
        """
        self._join("gear", name, body_a, body_b, None, None, None, value=ratio, carrier=carrier)

    @known_keywords
    def add_rack(
        self,
        name: str,
        body_a: str,
        body_b: str,
        direction: Point,
        radius: float,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
    ) -> None:
        """Let a wheel b roll on a line of a: way along `direction` = `radius` * turns of b."""
        self._join(
            "rack",
            name,
            body_a,
            body_b,
            point_a,
            point_b,
            None,
            direction=direction,
            value=radius,
        )

    @known_keywords
    def add_driver(
        self,
        name: str,
        body_a: str,
        body_b: str,
        angle: TimeFunction | None = None,
        speed: TimeFunction | None = None,
    ) -> None:
        """Prescribe the angle [rad] or the speed [rad/s] of b seen from a."""
        motion = one_of(name, "angle", angle, "speed", speed)
        by_speed = angle is None
        self._join(
            "driven_angle",
            name,
            body_a,
            body_b,
            None,
            None,
            None,
            motion=motion,
            by_speed=by_speed,
        )

    @known_keywords
    def add_position_driver(
        self,
        name: str,
        body_a: str,
        body_b: str,
        direction: Point,
        position: TimeFunction | None = None,
        speed: TimeFunction | None = None,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
    ) -> None:
        """Prescribe the way [m] or speed [m/s] of point b along `direction` from point a."""
        motion = one_of(name, "position", position, "speed", speed)
        self._join(
            "driven_position",
            name,
            body_a,
            body_b,
            point_a,
            point_b,
            None,
            direction=direction,
            motion=motion,
            by_speed=position is None,
        )

    @known_keywords
    def add_force(
        self,
        name: str,
        body: str,
        force: Sequence[TimeFunction],
        point: Point = (0.0, 0.0),
        follows: bool = False,
    ) -> None:
        """Push a point of a body with a force (x, y) [N], which may turn with the body."""
        if not isinstance(force, Sequence | np.ndarray) or len(force) != 2:
            msg = f"force of {name!r} = {force!r}: must be two components (x, y) [N]"
            raise InvalidInput(msg)
        self.forces.append(
            Force(
                "force",
                name,
                GROUND,
                body,
                point_b=point,
                x=force[0],
                y=force[1],
                follows=follows,
            )
        )

    @known_keywords
    def add_torque(
        self,
        name: str,
        body: str,
        torque: TimeFunction | None = None,
        by_speed: Rows | None = None,
        reaction: str = GROUND,
    ) -> None:
        """Turn a body with a torque [N m] of time, or by a table of (speed [rad/s], torque).

        `reaction` names the body that takes the reaction and from which the speed is seen.
        """
        one_of(name, "torque", torque, "by_speed", by_speed)
        if torque is None:
            self.forces.append(Force("torque_by_speed", name, reaction, body, table=by_speed))
        else:
            self.forces.append(Force("torque", name, reaction, body, x=torque))

    @known_keywords
    def add_spring(
        self,
        name: str,
        body_a: str,
        body_b: str,
        stiffness: float = 0.0,
        damping: float = 0.0,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
        rest_length: float | None = None,
        cubic: float = 0.0,
        table: Rows | None = None,
    ) -> None:
        """Put a spring and damper between two points.

        Parameters
        ----------
        stiffness, damping, cubic : float
            [N/m], [N s/m] and [N/m^3]: tension = stiffness * x + cubic * x^3 + damping * x'.
        rest_length : float, optional
            Length without force [m], by default as placed.
        table : sequence of (elongation [m], tension [N]), optional
            In place of stiffness and cubic.
        """
        self.forces.append(
            Force(
                "spring",
                name,
                body_a,
                body_b,
                point_a,
                point_b,
                stiffness=stiffness,
                damping=damping,
                cubic=cubic,
                rest=rest_length,
                table=table,
            )
        )

    @known_keywords
    def add_torsion_spring(
        self,
        name: str,
        body_a: str,
        body_b: str,
        stiffness: float = 0.0,
        damping: float = 0.0,
        rest_angle: float | None = None,
        cubic: float = 0.0,
        table: Rows | None = None,
    ) -> None:
        """Put a spring and damper between two angles; as `add_spring`, with radians."""
        self.forces.append(
            Force(
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
        )

    @known_keywords
    def add_callable(self, name: str, body: str, function: LoadFunction) -> None:
        """Load a body by a function of Python: for prototypes, clearly slower than the rest.

        Parameters
        ----------
        function : callable
            Called with time [s], position and velocity of the body (three numbers each); returns
            force x, force y [N] and torque about the centre of mass [N m]. An exception ends the
            run.
        """
        if not callable(function):
            msg = (
                f"function of force {name!r} = {function!r}: must be callable: f(time, position, "
                "velocity) that returns (force x, force y, torque)"
            )
            raise InvalidInput(msg)
        self.forces.append(Force("custom", name, GROUND, body, function=function))

    @known_keywords
    def add_clearance_joint(
        self,
        name: str,
        bore: str,
        pin: str,
        bore_radius: float,
        pin_radius: float,
        law: ContactLaw,
        bore_point: Point = (0.0, 0.0),
        pin_point: Point = (0.0, 0.0),
    ) -> None:
        """Let a pin of one body play in a bore of another [m]."""
        self.contacts.append(
            Contact(
                "bore",
                name,
                bore,
                pin,
                bore_point,
                pin_point,
                pin_radius,
                law,
                profile_radius=bore_radius,
            )
        )

    @known_keywords
    def add_disc_contact(
        self,
        name: str,
        body_a: str,
        body_b: str,
        radius_a: float,
        radius_b: float,
        law: ContactLaw,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
    ) -> None:
        """Let two discs touch from outside [m]."""
        self.contacts.append(
            Contact(
                "disc",
                name,
                body_a,
                body_b,
                point_a,
                point_b,
                radius_b,
                law,
                profile_radius=radius_a,
            )
        )

    @known_keywords
    def add_outline_contact(
        self,
        name: str,
        outline: str,
        circle: str,
        points: Rows,
        radius: float,
        law: ContactLaw,
        circle_point: Point = (0.0, 0.0),
        bulges: Sequence[float] | None = None,
        closed: bool = True,
    ) -> None:
        """Let a circle of one body touch an outline on another.

        Parameters
        ----------
        points : sequence of (float, float)
            Corners in the frame of the body [m]; the material lies on the left of the way through
            them. Two points and ``closed=False`` make a segment.
        radius : float
            Of the circle [m].
        bulges : sequence of float, optional
            For each piece the tangent of a quarter of the angle of its arc: positive where the
            outline is convex, negative where it is concave, 0 for a straight line.
        closed : bool
            Whether the last point is joined to the first.
        """
        kind, pieces = "polyline", points
        rows(f"points of contact {name!r}", points, 2)
        if bulges is not None:
            kind, pieces = "arcs", arcs(name, points, bulges, closed)
        self.contacts.append(
            Contact(
                kind,
                name,
                outline,
                circle,
                (0.0, 0.0),
                circle_point,
                radius,
                law,
                points=pieces,
                closed=closed,
            )
        )

    @known_keywords
    def add_sprocket_contact(
        self,
        name: str,
        wheel: str,
        circle: str,
        sprocket: Sprocket,
        chain: Chain,
        law: ContactLaw,
        circle_point: Point = (0.0, 0.0),
    ) -> None:
        """Let a bushing of `chain` around a point of one body touch the teeth of another."""
        for field, given, kind in (("sprocket", sprocket, Sprocket), ("chain", chain, Chain)):
            if not isinstance(given, kind):
                msg = f"{field} of contact {name!r} = {given!r}: must be a {kind.__name__}"
                raise InvalidInput(msg)
        self.contacts.append(
            Contact(
                "sprocket",
                name,
                wheel,
                circle,
                (0.0, 0.0),
                circle_point,
                chain.bushing_radius,
                law,
                sprocket=sprocket,
                chain=chain,
            )
        )

    def check(self) -> MechanismReport:
        """Assemble the mechanism and tell what was found, or raise with the joints at fault."""
        from rustchain import _rustchain
        from rustchain.simulation import Solver

        return MechanismReport(**_rustchain.MechanismCore(self, Solver(), None).check())

    def _join(
        self,
        kind: str,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point | None,
        point_b: Point | None,
        at: Point | None,
        direction: Point = (1.0, 0.0),
        value: float | None = None,
        carrier: str | None = None,
        motion: TimeFunction = 0.0,
        by_speed: bool = False,
    ) -> None:
        """Add a joint; `at` stands for both points."""
        if at is not None:
            if point_a is not None or point_b is not None:
                msg = f"at of joint {name!r} = {at!r}: give it, or point_a and point_b, not both"
                raise InvalidInput(msg)
            at = numbers(f"at of joint {name!r}", at, 2, "(x, y) [m]")
            point_a, point_b = (self._local(name, body, at) for body in (body_a, body_b))
        self.joints.append(
            Joint(
                kind,
                name,
                body_a,
                body_b,
                (0.0, 0.0) if point_a is None else point_a,
                (0.0, 0.0) if point_b is None else point_b,
                direction,
                value,
                carrier,
                motion,
                by_speed,
            )
        )

    def _local(self, joint: str, body: str, at: Point) -> tuple[float, float]:
        """Return a point of the ground's frame in the frame of a body as placed."""
        if body == GROUND:
            return (float(at[0]), float(at[1]))
        for known in self.bodies:
            if known.name == body:
                x, y, angle = known.position
                dx, dy = at[0] - x, at[1] - y
                cos, sin = math.cos(angle), math.sin(angle)
                return (cos * dx + sin * dy, cos * dy - sin * dx)
        names = [GROUND, *(known.name for known in self.bodies)]
        msg = f"body of joint {joint!r} = {body!r}: there is no such body; {suggest(body, names)}"
        raise InvalidInput(msg)
