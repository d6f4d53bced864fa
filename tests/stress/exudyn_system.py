"""A mechanism of rustchain as a system of Exudyn, from its description alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

import rustchain as rc
from exudyn_run import solve

Array = npt.NDArray[np.float64]


class Translated:
    """A mechanism as a system of Exudyn, from its description alone."""

    def __init__(self, mechanism: rc.Mechanism) -> None:
        """Add all bodies, joints and loads."""
        import exudyn as exu
        import exudyn.itemInterface as items

        self.items, self.mechanism = items, mechanism
        self.system: Any = exu.SystemContainer().AddSystem()
        still = self.system.AddNode(items.NodePointGround())
        self.bodies = {"ground": self.system.AddObject(items.ObjectGround())}
        self.nodes = {"ground": still}
        self.angles = {"ground": 0.0}
        for body in mechanism.bodies:
            self._body(body)
        for joint in mechanism.joints:
            self._joint(joint)
        for force in mechanism.forces:
            self._force(force)

    def _body(self, body: Any) -> None:
        items, system = self.items, self.system
        node = system.AddNode(
            items.NodeRigidBody2D(
                referenceCoordinates=list(body.position), initialVelocities=list(body.velocity)
            )
        )
        rigid = items.ObjectRigidBody2D(
            physicsMass=body.mass, physicsInertia=body.inertia, nodeNumber=node
        )
        self.nodes[body.name], self.bodies[body.name] = node, system.AddObject(rigid)
        self.angles[body.name] = body.position[2]
        weight = system.AddMarker(items.MarkerBodyMass(bodyNumber=self.bodies[body.name]))
        gravity = [*self.mechanism.gravity, 0.0]
        system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=gravity))

    def _point(self, name: str, at: Sequence[float]) -> int:
        """Return the marker of a point of a body, with its rotation."""
        local = [*at, 0.0]
        marker = self.items.MarkerBodyRigid(bodyNumber=self.bodies[name], localPosition=local)
        return int(self.system.AddMarker(marker))

    def _turn(self, name: str) -> int:
        """Return the marker of the rotation of a body since the start."""
        which = 0 if name == "ground" else 2
        marker = self.items.MarkerNodeCoordinate(nodeNumber=self.nodes[name], coordinate=which)
        return int(self.system.AddMarker(marker))

    def _place(self, name: str, at: Sequence[float]) -> Array:
        """Return where a point of a body is at the start."""
        angle = self.angles[name]
        body = next((b for b in self.mechanism.bodies if b.name == name), None)
        centre = np.zeros(2) if body is None else np.array(body.position[:2])
        return centre + _turned(at, angle)

    def _joint(self, joint: Any) -> None:
        items, add = self.items, self.system.AddObject
        a, b = joint.body_a, joint.body_b
        turned = self.angles[a] - self.angles[b]
        if joint.kind in ("gear", "driven_angle"):
            self._rotations(joint)
            return
        ends = [self._point(a, joint.point_a), self._point(b, joint.point_b)]
        match joint.kind:
            case "revolute":
                add(items.ObjectJointRevolute2D(markerNumbers=ends))
            case "distance":
                apart = self._place(b, joint.point_b) - self._place(a, joint.point_a)
                length = float(np.hypot(*apart))
                add(items.ObjectConnectorDistance(markerNumbers=ends, distance=length))
            case "fixed":
                frames = [_rotation(-self.angles[name]) for name in (a, b)]
                add(
                    items.ObjectJointGeneric(
                        markerNumbers=ends,
                        constrainedAxes=[1, 1, 0, 0, 0, 1],
                        rotationMarker0=frames[0],
                        rotationMarker1=frames[1],
                    )
                )
            case "prismatic" | "point_on_line":
                # The normal is of marker 1 there: the body with the line comes second.
                unit = np.array(joint.direction) / np.hypot(*joint.direction)
                axis = [*_turned(unit, turned), 0.0]
                add(
                    items.ObjectJointPrismatic2D(
                        markerNumbers=ends[::-1],
                        axisMarker0=axis,
                        normalMarker1=[-unit[1], unit[0], 0.0],
                        constrainRotation=joint.kind == "prismatic",
                    )
                )
            case other:
                raise ValueError(other)  # no such part is made here

    def _rotations(self, joint: Any) -> None:
        """Add a gear, or a driver whose speed is one sine without phase."""
        markers = [self._turn(joint.body_b), self._turn(joint.body_a)]
        if joint.kind == "gear":
            item = self.items.ObjectConnectorCoordinate(
                markerNumbers=markers, factorValue1=joint.value
            )
            self.system.AddObject(item)
            return
        ((amplitude, frequency, _),) = joint.motion.terms

        def angle(mbs: Any, t: float, number: int, offset: float) -> float:
            return amplitude / frequency * (1.0 - math.cos(frequency * t))

        def speed(mbs: Any, t: float, number: int, offset: float) -> float:
            return amplitude * math.sin(frequency * t)

        self.system.AddObject(
            self.items.ObjectConnectorCoordinate(
                markerNumbers=markers[::-1],
                factorValue1=1.0,
                offsetUserFunction=angle,
                offsetUserFunction_t=speed,
            )
        )

    def _force(self, force: Any) -> None:
        items, system, b = self.items, self.system, force.body_b
        match force.kind:
            case "spring" | "torsion_spring":
                self._spring(force)
            case "force":
                marker = self._point(b, force.point_b)
                pushed = [force.x, force.y, 0.0]
                load = items.LoadForceVector(
                    markerNumber=marker, loadVector=pushed, bodyFixed=bool(force.follows)
                )
                system.AddLoad(load)
            case "torque":
                for name, sign in ((b, 1.0), (force.body_a, -1.0)):
                    if name != "ground":
                        marker, torque = self._point(name, (0.0, 0.0)), [0.0, 0.0, sign * force.x]
                        system.AddLoad(
                            items.LoadTorqueVector(markerNumber=marker, loadVector=torque)
                        )
            case other:
                raise ValueError(other)  # no such part is made here

    def _spring(self, force: Any) -> None:
        a, b, cubic = force.body_a, force.body_b, force.cubic

        def spring(mbs: Any, t: float, n: int, x: float, v: float, k: float, d: float, *_: Any):
            return k * x + d * v + cubic * x**3

        if force.kind == "spring":
            apart = self._place(b, force.point_b) - self._place(a, force.point_a)
            rest = float(np.hypot(*apart)) if force.rest is None else force.rest
            keywords = {"springForceUserFunction": spring} if cubic else {}
            item = self.items.ObjectConnectorSpringDamper(
                markerNumbers=[self._point(a, force.point_a), self._point(b, force.point_b)],
                referenceLength=rest,
                stiffness=force.stiffness,
                damping=force.damping,
                **keywords,
            )
            self.system.AddObject(item)
            return
        start = self.angles[b] - self.angles[a]
        offset = 0.0 if force.rest is None else force.rest - start

        def torsion(mbs: Any, t: float, n: int, x: float, v: float, k: float, d: float, o: float):
            return k * (x - o) + d * v + cubic * (x - o) ** 3

        item = self.items.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=[self._turn(a), self._turn(b)],
            stiffness=force.stiffness,
            damping=force.damping,
            offset=offset,
            **({"springForceUserFunction": torsion} if cubic else {}),
        )
        self.system.AddObject(item)

    def solve(self, span: float, steps: int) -> Array:
        """Return the places and angles of all bodies after `span`, (bodies, 3)."""
        import exudyn as exu

        nodes = [self.nodes[body.name] for body in self.mechanism.bodies]
        solve(self.system, nodes, steps, span)
        moved = [self.system.GetNodeOutput(n, exu.OutputVariableType.Coordinates) for n in nodes]
        return np.array(moved) + [body.position for body in self.mechanism.bodies]


def _turned(point: Sequence[float], angle: float) -> Array:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]])


def _rotation(angle: float) -> list[list[float]]:
    cos, sin = math.cos(angle), math.sin(angle)
    return [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]
