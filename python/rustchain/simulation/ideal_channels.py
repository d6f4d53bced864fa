"""The channels of a drive with ideal hinges, from what its mechanism has recorded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.description.drive import AppliedTorque, ChainDrive, PrescribedSpeed, TimeTable
from rustchain.simulation.strand_tensions import HingeRows, strand_tensions
from rustchain.typing import Array

Arrays = Mapping[str, npt.NDArray[Any]]


class IdealHingeChannels:
    """Turns rows of a drive's mechanism into those of the drive."""

    def __init__(self, drive: ChainDrive, joints: Sequence[str]) -> None:
        """`joints`: their names, in the order of the rows."""
        self._drive = drive
        links, sprockets = drive.chain.links, len(drive.sprockets)
        # An arm comes after what the drive has.
        self._wheels = slice(links, links + sprockets)
        self._own = slice(0, links + sprockets)
        self._hinges = slice(joints.index("hinge_1"), joints.index("hinge_1") + links)
        motors = [f"motor_{k + 1}" for k in range(sprockets)]
        self._motors = [joints.index(name) if name in joints else None for name in motors]

    def _ends(self, positions: Array) -> tuple[Array, Array]:
        """Return front of each link and rear of the next one, (times, links, 2)."""
        links = positions[:, : self._drive.chain.links]
        half = 0.5 * _rustchain.chain_links(self._drive.chain)[:, :1]
        arm = half * np.stack([np.cos(links[..., 2]), np.sin(links[..., 2])], -1)
        return links[..., :2] + arm, np.roll(links[..., :2] - arm, -1, axis=1)

    def _eccentricity(self, positions: Array) -> Array:
        """Return the pin's centre of each hinge seen from its bushing's [m], (times, hinges, 2)."""
        front, rear = self._ends(positions)
        inner = _rustchain.chain_links(self._drive.chain)[:, 3] > 0.0
        apart: Array = np.where(inner[:, None], rear - front, front - rear)
        return apart

    def _hinge_channels(self, found: Arrays) -> dict[str, npt.NDArray[Any]]:
        """Return force, place of the pin, peaks, and tension of the strands."""
        force = found["joint_reaction"][:, self._hinges, :2]
        eccentricity = self._eccentricity(found["positions"])
        return {
            "hinge_force": np.hypot(force[..., 0], force[..., 1]),
            "hinge_force_vector": force,
            "hinge_penetration": np.hypot(eccentricity[..., 0], eccentricity[..., 1]),
            "hinge_eccentricity": eccentricity,
            "strand_tension": self._strand_tension(
                found["positions"], force, found["contact_region"]
            ),
            "peak_hinge_force": found["peak_joint_force"][:, self._hinges],
            "peak_hinge_impulse": found["peak_joint_impulse"][:, self._hinges],
        }

    def _strand_tension(self, positions: Array, on_pin: Array, region: Array) -> Array:
        """Return the mean pull along the chain of the hinges of each strand, (times, strands)."""
        drive, links = self._drive, self._drive.chain.links
        front, rear = self._ends(positions)
        inner = _rustchain.chain_links(drive.chain)[:, 3:] > 0.0
        on_front = np.where(inner, -on_pin, on_pin)
        step = np.roll(positions[:, :links, :2], -1, axis=1) - positions[:, :links, :2]
        rows = HingeRows(
            bushing=np.where(inner, front, rear),
            pull=(on_front * step).sum(-1) / np.hypot(step[..., 0], step[..., 1]),
            centers=positions[:, self._wheels, :2],
            near=region.reshape(len(positions), links, len(drive.sprockets)) > 0,
        )
        return strand_tensions(drive, rows)

    def _tooth_channels(self, found: Arrays) -> dict[str, npt.NDArray[Any]]:
        """Return the deepest contact of each bushing, and peaks over all sprockets."""
        shape = (-1, self._drive.chain.links, len(self._drive.sprockets))
        by_pair = {
            name: found[name].reshape(shape)
            for name in ("contact_force", "contact_gap", "contact_region")
        }
        near = by_pair["contact_region"] > 0
        depth = np.where(near, found["contact_penetration"].reshape(shape), -np.inf)
        deepest = depth.argmax(-1)[..., None]
        depth = np.take_along_axis(depth, deepest, -1)[..., 0]
        pushes = found["contact_force_vector"].reshape(*near.shape, 2)
        push = np.take_along_axis(pushes, deepest[..., None], -2)[..., 0, :]
        touching = depth > 0.0
        of = {
            name: np.take_along_axis(values, deepest, -1)[..., 0]
            for name, values in by_pair.items()
        }
        return {
            "tooth_force": np.where(touching, of["contact_force"], 0.0),
            "tooth_force_vector": np.where(touching[..., None], push, 0.0),
            "tooth_penetration": depth,
            "tooth_sprocket": np.where(touching, deepest[..., 0] + 1, 0).astype(np.int32),
            "tooth_index": np.where(touching, of["contact_gap"], -1).astype(np.int32),
            "tooth_region": np.where(touching, of["contact_region"], 0).astype(np.int32),
            "peak_tooth_force": found["peak_contact_force"].reshape(shape).max(-1),
            "peak_tooth_impulse": found["peak_contact_impulse"].reshape(shape).sum(-1),
        }

    def _sprocket_channels(self, found: Arrays) -> dict[str, npt.NDArray[Any]]:
        """Return angle, speed, torque on the shaft and centre of each sprocket."""
        wheels = self._wheels
        torque = [self._torque(k, found) for k in range(len(self._drive.sprockets))]
        return {
            "sprocket_angle": found["positions"][:, wheels, 2],
            "sprocket_speed": found["velocities"][:, wheels, 2],
            "sprocket_torque": np.stack(torque, axis=-1),
            "sprocket_center": found["positions"][:, wheels, :2],
        }

    def _torque(self, k: int, found: Arrays) -> Array:
        """Return the torque of a sprocket's motor or load [N m]."""
        motion, motor = self._drive.sprockets[k].motion, self._motors[k]
        torque: Array
        if isinstance(motion, PrescribedSpeed) and motor is not None:
            torque = found["joint_reaction"][:, motor, 2]
        elif isinstance(motion, AppliedTorque):
            rows = np.atleast_2d(
                motion.torque if isinstance(motion.torque, tuple) else (0.0, motion.torque)
            )
            torque = np.interp(found["time"], rows[:, 0], rows[:, 1])
            if motion.curve is not None:
                spin = found["velocities"][:, self._wheels.start + k, 2]
                torque = torque + _of_curve(motion.curve, spin)
        else:
            torque = np.zeros(len(found["time"]))
        return torque


def _of_curve(curve: TimeTable, spin: Array) -> Array:
    """Return the torque [N m] that a motor's or a load's curve has at speeds [rad/s]."""
    rows = np.atleast_2d(curve if isinstance(curve, tuple) else (0.0, curve))
    torque: Array = np.interp(spin, rows[:, 0], rows[:, 1])
    return torque
