"""A drive with ideal hinges behind the face of the compiled drive: its channels, by a mechanism."""

from __future__ import annotations

import copy
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain._drive_mechanism import drive_mechanism
from rustchain.drive import AppliedTorque, ChainDrive, PrescribedSpeed
from rustchain.errors import InvalidInput
from rustchain.force_law import ForceLaw
from rustchain.result import Array
from rustchain.solver import Solver

_FAR = 0.01  # of a pitch: way that hinges may move a link without a word
_ENERGY = ("kinetic", "gravity", "elastic", "dissipated", "worked_in", "residual")
Arrays = Mapping[str, npt.NDArray[Any]]


class IdealHingeCore:
    """What `Simulation` asks of its core, answered by the drive's mechanism.

    Hinge forces are the joints' reactions; the pins stay in the middle of their bushings to
    round-off, which is what penetration and eccentricity show.
    """

    def __init__(
        self,
        drive: ChainDrive,
        force_law: ForceLaw,
        hinge_law: ForceLaw | None,
        tooth_law: ForceLaw | None,
        min_approach_speed: float,
        solver: Solver,
        positions: Array | None,
        velocities: Array | None,
    ) -> None:
        # There is no contact in the hinges, whose law says nothing but this.
        friction = getattr(force_law if hinge_law is None else hinge_law, "friction", None)
        if friction is not None:
            msg = (
                f"friction = {friction}: must be None with ChainDrive.hinges = 'ideal'; only chain "
                "drives with clearance hinges have friction"
            )
            raise InvalidInput(msg)
        film = getattr(force_law if hinge_law is None else hinge_law, "film", None)
        if film is not None:
            msg = (
                f"film = {film}: must be None with ChainDrive.hinges = 'ideal'; only chain drives "
                "with clearance hinges have room for a film"
            )
            raise InvalidInput(msg)
        if hinge_law is not None and hinge_law != force_law:
            msg = (
                f"hinge_law = {hinge_law}: must be None with ChainDrive.hinges = 'ideal', whose "
                "hinges have no contact; it is for 'clearance'"
            )
            raise InvalidInput(msg)
        if len(drive.sprockets) > 2:
            msg = (
                f"ChainDrive.hinges = 'ideal': {len(drive.sprockets)} sprockets; ideal hinges go "
                "with two, take 'clearance' or ChainDrive.to_mechanism(hinges='ideal')"
            )
            raise InvalidInput(msg)
        law = force_law if tooth_law is None else tooth_law
        mechanism = drive_mechanism(
            drive, "ideal", law, min_approach_speed, (positions, velocities)
        )
        self._drive = drive
        if solver.method == "auto":  # the one that ideal hinges were measured with
            solver = replace(solver, method="pece")
        self._core = _rustchain.MechanismCore(mechanism, solver, None)
        report = self._core.check()
        if positions is not None and report["moved"] > _FAR * drive.chain.pitch:
            msg = (
                f"positions: links had to be moved by up to {report['moved']:.3g} m to close the "
                "ideal hinges: is each link placed where its hinges meet?"
            )
            warnings.warn(msg, stacklevel=4)
        self._groups: Sequence[str] = ()
        self._energy = False
        joints = self._core.joint_names
        self._hinges = slice(joints.index("hinge_1"), joints.index("hinge_1") + drive.chain.links)
        motors = [f"motor_{k + 1}" for k in range(len(drive.sprockets))]
        self._motors = [joints.index(name) if name in joints else None for name in motors]
        # As placed: assembling moves them by rounding.
        self._start = [
            np.array([getattr(body, quantity) for body in mechanism.bodies], dtype=float)
            for quantity in ("position", "velocity")
        ]

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies."""
        return self._core.body_names

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self._core.time

    @property
    def positions(self) -> Array:
        """Present positions [m, m, rad], (bodies, 3)."""
        return self._core.positions

    @property
    def velocities(self) -> Array:
        """Present velocities [m/s, m/s, rad/s], (bodies, 3)."""
        return self._core.velocities

    def start(self) -> list[Array]:
        """Return positions and velocities that the simulation began with."""
        return self._start

    def state(self) -> dict[str, Any]:
        """Return the complete state."""
        return self._core.state()

    def restored(self, snapshot: bytes) -> IdealHingeCore:
        """Return the same simulation in another state."""
        found = copy.copy(self)
        found._core = self._core.restored(snapshot)
        return found

    def evaluate(
        self, positions: Array | None, velocities: Array | None, time: float | None
    ) -> dict[str, Any]:
        """Return the fields of an Evaluation."""
        found = self._core.evaluate(positions, velocities, time)
        places = self.positions if positions is None else positions
        force = found["joint_reaction"][self._hinges, :2]
        shape = (self._drive.chain.links, len(self._drive.sprockets))
        depth = found["contact_penetration"].reshape(shape)
        tooth_force = found["contact_force"].reshape(shape)
        near = found["contact_region"].reshape(shape) > 0
        touching = depth > 0.0
        return {
            "accelerations": found["accelerations"],
            "hinge_force": np.hypot(*force.T),
            "hinge_penetration": np.hypot(*self._eccentricity(places[None])[0].T),
            "hinge_force_vector": force,
            "tooth_force": tooth_force,
            "tooth_penetration": np.where(near, depth, -np.inf),
            "tooth_force_vector": found["contact_force_vector"].reshape(*shape, 2),
            "tooth_region": np.where(touching, found["contact_region"].reshape(shape), 0),
            "tooth_index": np.where(touching, found["contact_gap"].reshape(shape), -1),
        }

    def start_recording(
        self, duration: float, report_step: float, groups: Sequence[str], energy: bool
    ) -> None:
        """Begin a recording that ends `duration` [s] from now."""
        self._groups, self._energy = groups, energy
        self._core.start_recording(duration, report_step)

    def advance(self, wall_budget: float) -> bool:
        """Go on for about `wall_budget` seconds of wall time; return whether the end is reached."""
        return self._core.advance(wall_budget)

    def step_to(self, t: float, wall_budget: float) -> bool:
        """Go on towards exactly `t` [s]; return whether it is reached."""
        return self._core.step_to(t, wall_budget)

    def pause_at_reports(self) -> None:
        """Make `advance` return after each report."""
        self._core.pause_at_reports()

    @property
    def rows(self) -> int:
        """Number of rows recorded so far."""
        return self._core.rows

    def last_row(self, name: str) -> Array:
        """Return the last row of a channel that a stop condition looks at."""
        joints, contacts = self._core.last_peaks()
        if name == "peak_hinge_force":
            return joints[self._hinges]
        if name == "peak_tooth_force":
            found: Array = contacts.reshape(self._drive.chain.links, -1).max(axis=-1)
            return found
        reaction = self._core.evaluate(None, None, None)["joint_reaction"]
        forces = reaction[None, self._hinges, :2]
        tension: Array = self._strand_tension(self.positions[None], forces)[0]
        return tension

    def set_input(self, sprocket: int, quantity: str, value: object) -> None:
        """Refuse: a mechanism's drivers stay as they were described."""
        del value
        msg = (
            f"sprocket = {sprocket}: its {quantity} cannot be set while a drive with ideal hinges "
            "runs; take hinges='clearance', or describe it with a table of time"
        )
        raise InvalidInput(msg)

    def stats(self) -> dict[str, float]:
        """Return the counts of the run."""
        return self._core.stats()

    def take_warnings(self) -> tuple[list[str], list[str]]:
        """Return what was not told yet: no law, but the energy balance where it is recorded."""
        text = self._core.take_warnings() if self._energy else None
        return [], [] if text is None else [text]

    def take_recording(self) -> dict[str, npt.NDArray[Any]]:
        """Return the rows recorded up to now, as the channels of a drive."""
        found = self._core.take_recording()
        arrays: dict[str, npt.NDArray[Any]] = {"time": found["time"]}
        if "hinges" in self._groups:
            arrays |= self._hinge_channels(found)
        if "teeth" in self._groups:
            arrays |= self._tooth_channels(found)
        if "sprockets" in self._groups:
            arrays |= self._sprocket_channels(found)
        if "bodies" in self._groups:
            arrays |= {name: found[name] for name in ("positions", "velocities")}
        if self._energy:
            arrays |= {f"energy_{name}": found[f"energy_{name}"] for name in _ENERGY}
        return arrays

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
            "strand_tension": self._strand_tension(found["positions"], force),
            "peak_hinge_force": found["peak_joint_force"][:, self._hinges],
            "peak_hinge_impulse": found["peak_joint_impulse"][:, self._hinges],
        }

    def _strand_tension(self, positions: Array, on_pin: Array) -> Array:
        """Return the mean pull along the chain of the hinges between the sprockets, (times, 2)."""
        links, drive = self._drive.chain.links, self._drive
        front, rear = self._ends(positions)
        inner = _rustchain.chain_links(drive.chain)[:, 3:] > 0.0
        bushing, on_front = np.where(inner, front, rear), np.where(inner, -on_pin, on_pin)
        centers = positions[:, links : links + 2, :2]
        line = centers[:, 1] - centers[:, 0]
        distance = np.hypot(line[:, 0], line[:, 1])[:, None]
        axis = (line / distance)[:, None]
        r1, r2 = (
            0.5 * drive.chain.pitch / math.sin(math.pi / sprocket.teeth)
            for sprocket in drive.sprockets[:2]
        )
        # A common tangent leaves each pitch circle where its normal does.
        cosine = (r1 - r2) / distance
        offset = bushing - centers[:, :1]
        along = (offset * axis).sum(-1)
        free = (along >= r1 * cosine) & (along <= distance + r2 * cosine)
        left = axis[..., 0] * offset[..., 1] - axis[..., 1] * offset[..., 0] >= 0.0
        step = np.roll(positions[:, :links, :2], -1, axis=1) - positions[:, :links, :2]
        pull = (on_front * step).sum(-1) / np.hypot(step[..., 0], step[..., 1])
        strands = [free & left, free & ~left]
        means = [np.where(on, pull, 0.0).sum(1) / np.maximum(on.sum(1), 1) for on in strands]
        tension: Array = np.stack(means, axis=-1)
        return tension

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
        touching = depth > 0.0
        of = {
            name: np.take_along_axis(values, deepest, -1)[..., 0]
            for name, values in by_pair.items()
        }
        return {
            "tooth_force": np.where(touching, of["contact_force"], 0.0),
            "tooth_penetration": depth,
            "tooth_sprocket": np.where(touching, deepest[..., 0] + 1, 0).astype(np.int32),
            "tooth_index": np.where(touching, of["contact_gap"], -1).astype(np.int32),
            "tooth_region": np.where(touching, of["contact_region"], 0).astype(np.int32),
            "peak_tooth_force": found["peak_contact_force"].reshape(shape).max(-1),
            "peak_tooth_impulse": found["peak_contact_impulse"].reshape(shape).sum(-1),
        }

    def _sprocket_channels(self, found: Arrays) -> dict[str, npt.NDArray[Any]]:
        """Return angle, speed, torque on the shaft and centre of each sprocket."""
        wheels = slice(self._drive.chain.links, None)
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
        else:
            torque = np.zeros(len(found["time"]))
        return torque
