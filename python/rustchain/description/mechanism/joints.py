"""Joints and drivers of a mechanism: the methods of `Mechanism` that add them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rustchain.arguments import shown
from rustchain.description.laws.friction import Coulomb
from rustchain.description.mechanism.checks import numbers, one_of, point
from rustchain.description.mechanism.parts import GROUND, Body, Joint
from rustchain.description.signals import Signal
from rustchain.errors import InvalidInput
from rustchain.names import suggest
from rustchain.typing import Point


class WithJoints:
    """Base of `Mechanism`: joints and drivers."""

    bodies: Sequence[Body]
    joints: Sequence[Joint]

    def add_revolute(
        self,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point | None = None,
        point_b: Point | None = None,
        at: Point | None = None,
        friction: Coulomb | None = None,
        radius: float | None = None,
    ) -> None:
        """Add a revolute joint: a point of each body coincides.

        Parameters
        ----------
        name : str
            Name of the joint.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        point_a, point_b : (float, float), optional
            Points in the frames of the bodies [m]; by default the centres of mass.
        at : (float, float), optional
            In place of both points: a point of the ground's frame [m], for the bodies as placed.
        friction : Coulomb, optional
            Friction of the pin: a torque of `radius` times coefficient times reaction force
            against the relative rotation. Its `speed` is that of the pin's surface.
        radius : float, optional
            Radius of the pin [m]; only with `friction`, which needs it.
        """
        pin: dict[str, Any] = {"friction": friction, "radius": radius}
        self._join("revolute", name, body_a, body_b, point_a, point_b, at, **pin)

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
        """Add a fixed joint: a point of each body coincides, and their relative angle is constant.

        Parameters
        ----------
        name : str
            Name of the joint.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        point_a, point_b : (float, float), optional
            Points in the frames of the bodies [m]; by default the centres of mass.
        at : (float, float), optional
            In place of both points: a point of the ground's frame [m], for the bodies as placed.
        angle : float, optional
            Angle of body b minus that of body a [rad]; by default as placed.
        """
        self._join("fixed", name, body_a, body_b, point_a, point_b, at, value=angle)

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
        """Add a prismatic joint: body b slides along a line of body a without rotation.

        Point b stays on the line of body a through point a along `direction`.

        Parameters
        ----------
        name : str
            Name of the joint.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        direction : (float, float)
            Direction of the line in the frame of body a; its length does not matter.
        point_a, point_b : (float, float), optional
            Points in the frames of the bodies [m]; by default the centres of mass.
        at : (float, float), optional
            In place of both points: a point of the ground's frame [m], for the bodies as placed.
        angle : float, optional
            Angle of body b minus that of body a [rad]; by default as placed.
        """
        line: dict[str, Any] = {"direction": direction, "value": angle}
        self._join("prismatic", name, body_a, body_b, point_a, point_b, at, **line)

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
        """Keep point b on the line of body a through point a; body b can rotate.

        Parameters
        ----------
        name : str
            Name of the joint.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        direction : (float, float)
            Direction of the line in the frame of body a; its length does not matter.
        point_a, point_b : (float, float), optional
            Points in the frames of the bodies [m]; by default the centres of mass.
        at : (float, float), optional
            In place of both points: a point of the ground's frame [m], for the bodies as placed.
        """
        self._join("point_on_line", name, body_a, body_b, point_a, point_b, at, direction=direction)

    def add_distance(
        self,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
        length: float | None = None,
    ) -> None:
        """Keep two points at a constant distance.

        Parameters
        ----------
        name : str
            Name of the joint.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        point_a, point_b : (float, float)
            Points in the frames of the bodies [m]; by default the centres of mass.
        length : float, optional
            Distance of the points [m]; by default as placed.
        """
        self._join_at("distance", name, body_a, body_b, point_a, point_b, value=length)

    def add_gear(
        self, name: str, body_a: str, body_b: str, ratio: float, carrier: str | None = None
    ) -> None:
        """Add a gear pair: two wheels roll on each other.

        Parameters
        ----------
        name : str
            Name of the joint.
        body_a, body_b : str
            Names of the bodies that are the wheels.
        ratio : float
            Turns of b for one turn of a, both relative to the carrier: -r_a / r_b for wheels
            outside each other, +r_a / r_b for one inside the other. Not zero.
        carrier : str, optional
            Name of the body on which both turn; by default the ground.
        """
        self._join("gear", name, body_a, body_b, value=ratio, carrier=carrier)

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
        """Add a rack: a wheel, body b, rolls on a line of body a.

        The displacement of point b from point a along `direction` changes by `radius` times the
        angle of b relative to a [rad]. The positions as placed are the reference.

        Parameters
        ----------
        name : str
            Name of the joint.
        body_a, body_b : str
            Names of the bodies of the rack and of the wheel; "ground" is the frame that does not
            move.
        direction : (float, float)
            Direction of the line in the frame of body a; its length does not matter.
        radius : float
            Radius of the wheel [m]; negative for rotation in the other direction.
        point_a, point_b : (float, float)
            Points in the frames of the bodies [m]; by default the centres of mass.
        """
        line: dict[str, Any] = {"direction": direction, "value": radius}
        self._join_at("rack", name, body_a, body_b, point_a, point_b, **line)

    def add_driver(
        self,
        name: str,
        body_a: str,
        body_b: str,
        angle: Signal | None = None,
        speed: Signal | None = None,
    ) -> None:
        """Prescribe the angle or the angular velocity of body b relative to body a.

        Exactly one of `angle` and `speed` must be given.

        Parameters
        ----------
        name : str
            Name of the driver.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        angle : float, Spline, Sines or SmoothStep, optional
            Angle of b minus that of a [rad] over time [s].
        speed : float, rows of (time, speed), Table, Spline, Sines or SmoothStep, optional
            Angular velocity [rad/s] over time [s], from the angle as placed.
        """
        motion = one_of(name, "angle", angle, "speed", speed)
        self._join("driven_angle", name, body_a, body_b, motion=motion, by_speed=angle is None)

    def add_position_driver(
        self,
        name: str,
        body_a: str,
        body_b: str,
        direction: Point,
        position: Signal | None = None,
        speed: Signal | None = None,
        point_a: Point = (0.0, 0.0),
        point_b: Point = (0.0, 0.0),
    ) -> None:
        """Prescribe displacement or speed of point b along a direction from point a.

        Exactly one of `position` and `speed` must be given.

        Parameters
        ----------
        name : str
            Name of the driver.
        body_a, body_b : str
            Names of the bodies; "ground" is the frame that does not move.
        direction : (float, float)
            Direction of the line in the frame of body a; its length does not matter.
        position : float, Spline, Sines or SmoothStep, optional
            Displacement of point b from point a along `direction` [m] over time [s].
        speed : float, rows of (time, speed), Table, Spline, Sines or SmoothStep, optional
            Its rate [m/s] over time [s], from the position as placed.
        point_a, point_b : (float, float)
            Points in the frames of the bodies [m]; by default the centres of mass.
        """
        motion = one_of(name, "position", position, "speed", speed)
        by_speed = position is None
        law: dict[str, Any] = {"direction": direction, "motion": motion, "by_speed": by_speed}
        self._join_at("driven_position", name, body_a, body_b, point_a, point_b, **law)

    def _join_at(
        self,
        kind: str,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point,
        point_b: Point,
        **others: Any,  # noqa: ANN401
    ) -> None:
        """Add a joint with points that must be given."""
        point_a = point("point_a", "joint", name, point_a)
        point_b = point("point_b", "joint", name, point_b)
        self._join(kind, name, body_a, body_b, point_a, point_b, **others)

    def _join(
        self,
        kind: str,
        name: str,
        body_a: str,
        body_b: str,
        point_a: Point | None = None,
        point_b: Point | None = None,
        at: Point | None = None,
        *,
        direction: Point = (1.0, 0.0),
        **others: Any,  # noqa: ANN401
    ) -> None:
        """Add a joint; `at` stands for both points, `others` are further fields of the joint."""
        if at is not None:
            if point_a is not None or point_b is not None:
                msg = (
                    f"at of joint {shown(name)} = {shown(at)}: give it, or point_a and "
                    "point_b, not both"
                )
                raise InvalidInput(msg)
            at = numbers(f"at of joint {shown(name)}", at, 2, "(x, y) [m]")
            point_a, point_b = (self._local(name, body, at) for body in (body_a, body_b))
        direction = numbers(f"direction of joint {shown(name)}", direction, 2, "(x, y)")
        points = (("a", point_a), ("b", point_b))
        place_a, place_b = (
            (0.0, 0.0) if place is None else point(f"point_{end}", "joint", name, place)
            for end, place in points
        )
        made = Joint(kind, name, body_a, body_b, place_a, place_b, direction, **others)
        self.joints = (*self.joints, made)

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
        msg = (
            f"body of joint {shown(joint)} = {shown(body)}: there is no such body; "
            f"{suggest(body, names)}"
        )
        raise InvalidInput(msg)
