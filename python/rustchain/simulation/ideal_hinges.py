"""A drive with ideal hinges behind the face of the compiled drive: its channels, by a mechanism."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.caller import warn_caller
from rustchain.description.drive import ChainDrive
from rustchain.description.laws.force import ForceLaw
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.simulation.drive_mechanism import drive_mechanism
from rustchain.simulation.ideal_channels import IdealHingeChannels
from rustchain.simulation.tensioner_mechanism import arm_rows
from rustchain.typing import Array

_FAR = 0.01  # of a pitch: way that hinges may move a link without a word
_ENERGY = ("kinetic", "gravity", "elastic", "dissipated", "external_work", "residual")


class IdealHingeCore(IdealHingeChannels):
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
        min_impact_velocity: float,
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
        law = force_law if tooth_law is None else tooth_law
        mechanism = drive_mechanism(
            drive, "ideal", law, min_impact_velocity, (positions, velocities)
        )
        if solver.method == "auto":  # the one that ideal hinges were measured with
            solver = replace(solver, method="pece")
        self._core = _rustchain.MechanismCore(mechanism, solver, None)
        super().__init__(drive, self._core.joint_names)
        report = self._core.check()
        if positions is not None and report["moved"] > _FAR * drive.chain.pitch:
            msg = (
                f"positions: links had to be moved by up to {report['moved']:.3g} m to close the "
                "ideal hinges: is each link placed where its hinges meet?"
            )
            warn_caller(msg)
        self._groups: Sequence[str] = ()
        self._energy = False
        # As placed: assembling moves them by rounding.
        self._start = [
            np.array([getattr(body, quantity) for body in mechanism.bodies[self._own]], dtype=float)
            for quantity in ("position", "velocity")
        ]

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies."""
        return self._core.body_names[self._own]

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints and drivers of the drive's mechanism."""
        return self._core.joint_names

    @property
    def contact_names(self) -> list[str]:
        """Names of its contacts."""
        return self._core.contact_names

    def last_peaks(self) -> list[Array]:
        """Return the last row of the largest forces of joints and contacts."""
        return self._core.last_peaks()

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self._core.time

    @property
    def positions(self) -> Array:
        """Present positions [m, m, rad], (bodies, 3)."""
        return self._core.positions[self._own]

    @property
    def velocities(self) -> Array:
        """Present velocities [m/s, m/s, rad/s], (bodies, 3)."""
        return self._core.velocities[self._own]

    def start(self) -> list[Array]:
        """Return positions and velocities that the simulation began with."""
        return self._start

    def state(self) -> dict[str, Any]:
        """Return the complete state."""
        state: dict[str, Any] = self._core.state()
        return state | {name: state[name][self._own] for name in ("positions", "velocities")}

    def restored(self, snapshot: bytes) -> IdealHingeCore:
        """Return the same simulation in another state."""
        found = copy.copy(self)
        found._core = self._core.restored(snapshot)
        return found

    def evaluate(
        self, positions: Array | None, velocities: Array | None, time: float | None
    ) -> dict[str, Any]:
        """Return the fields of an Evaluation."""
        found = self._core.evaluate(*self._with_arm(positions, velocities), time)
        places = self.positions if positions is None else positions
        force = found["joint_reaction"][self._hinges, :2]
        shape = (self._drive.chain.links, len(self._drive.sprockets))
        depth = found["contact_penetration"].reshape(shape)
        tooth_force = found["contact_force"].reshape(shape)
        near = found["contact_region"].reshape(shape) > 0
        touching = depth > 0.0
        return {
            "accelerations": found["accelerations"][self._own],
            "hinge_force": np.hypot(*force.T),
            "hinge_penetration": np.hypot(*self._eccentricity(places[None])[0].T),
            "hinge_force_vector": force,
            "tooth_force": tooth_force,
            "tooth_penetration": np.where(near, depth, -np.inf),
            "tooth_force_vector": found["contact_force_vector"].reshape(*shape, 2),
            "tooth_region": np.where(touching, found["contact_region"].reshape(shape), 0),
            "tooth_index": np.where(touching, found["contact_gap"].reshape(shape), -1),
        }

    def _with_arm(
        self, positions: Array | None, velocities: Array | None
    ) -> tuple[Array | None, Array | None]:
        """Return positions and velocities of the drive's bodies with those of a tensioner's arm."""
        if positions is None and velocities is None:
            return None, None
        places = self.positions if positions is None else positions
        rates = self.velocities if velocities is None else velocities
        for name, rows in (("positions", places), ("velocities", rates)):
            if len(rows) != self._own.stop:
                msg = (
                    f"{name} = {len(rows)} rows: needs one row (3 numbers) for each of the "
                    f"{self._own.stop} bodies"
                )
                raise InvalidInput(msg)
        arm = arm_rows(self._drive, places, rates)
        return np.concatenate([places, arm[:1]]), np.concatenate([rates, arm[1:]])

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
        present = self._core.evaluate(None, None, None)
        forces = present["joint_reaction"][None, self._hinges, :2]
        region = present["contact_region"][None]
        tension: Array = self._strand_tension(self.positions[None], forces, region)[0]
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

    def tooth_jumps(self) -> None:
        """Return nothing: a mechanism does not count the jumps of its chain."""

    def take_warnings(self) -> tuple[list[str], list[str], list[str]]:
        """Return what was not told yet: no law, but the energy balance where it is recorded."""
        text = self._core.take_warnings() if self._energy else None
        return [], [] if text is None else [text], []

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
            arrays |= {name: found[name][:, self._own] for name in ("positions", "velocities")}
        if self._energy:
            arrays |= {f"energy_{name}": found[f"energy_{name}"] for name in _ENERGY}
        return arrays
