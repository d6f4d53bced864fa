"""Accelerations of an open chain: as those of a closed one, with two more bodies and hinges less.

Behind the links come the body at end 2 and the body at end 1. Hinge k joins body k and body k + 1
in this row, the last one the last body and the first link.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from reference.dynamics import Array, DriveEquations, Kinematics, table_value

if TYPE_CHECKING:
    from rustchain import ChainDrive


class OpenChainEquations(DriveEquations):
    """Right-hand side of an open chain, with any number of sprockets."""

    def __init__(
        self, drive: ChainDrive, hinge_law: Any, tooth_law: Any, min_impact_velocity: float = 1e-3
    ) -> None:
        super().__init__(drive, hinge_law, tooth_law, min_impact_velocity)
        real = int(drive.chain.links)
        first, last = drive.ends
        self.links = real + 2
        self.wheels = self.links
        arm = [getattr(end, "arm", 0.0) for end in (last, first)]
        self.arms = np.concatenate([self.arms, arm])
        # Inner links carry their bushings at both ends. The body at end 2 has one where the last
        # link is an outer one; nothing is at the hinge between the two ends.
        self.on_front = np.arange(self.links) % 2 == 0
        self.on_front[real + 1] = False
        self.no_hinge = [real]
        self.no_bushing = [real]
        if type(last).__name__ == "FreeEnd":
            self.no_hinge.append(real - 1)
            if real % 2 == 0:
                self.no_bushing.append(real - 1)
        if type(first).__name__ == "FreeEnd":
            self.no_hinge.append(real + 1)
        if self.plates is not None:
            # The ends do not stretch; nothing touches between them.
            whole = self.plates[0]
            self.plates = np.append(self.plates, [whole, 0.5 * whole])
            self.plates[real - 1] = 0.5 * whole
        ends = [(real, last), (real + 1, first)]
        self.held = [(body, end) for body, end in ends if type(end).__name__ != "LoadedEnd"]
        mass, inertia = self.mass, self.inertia
        own = [(getattr(e, "mass", 1.0), getattr(e, "inertia", 1.0)) for e in (last, first)]
        masses, inertias = np.array(own).T
        self.mass = np.concatenate([mass[:real], masses, mass[real:]])
        self.inertia = np.concatenate([inertia[:real], inertias, inertia[real:]])

    def _tensioner(self) -> tuple[Array, float]:
        return np.zeros(2), 0.0

    def kinematics(self, positions: Array, velocities: Array) -> Kinematics:
        found = super().kinematics(positions, velocities)
        for k in self.no_hinge:
            found.hinge_penetration[k] = -self.clearance
            found.hinge_rate[k] = 0.0
            found.hinge_normal[k] = 0.0
        for k in self.no_bushing:
            found.tooth_penetration[k] = -np.inf
            found.tooth_region[k], found.tooth_gap[k] = 0, -1
        return replace(found)

    def _support_sprockets(self, time: float, accelerations: Array, bounds: Array) -> None:
        super()._support_sprockets(time, accelerations, bounds)
        for body, end in self.held:
            velocity = getattr(end, "velocity", (0.0, 0.0))
            rows = np.array(velocity, dtype=float)
            for axis in (0, 1):
                table = rows[:, [0, axis + 1]] if rows.ndim == 2 else 0.0
                accelerations[body, axis] = table_value(table, time)[1]
            accelerations[body, 2] = 0.0
            bounds[body] = 1e-12 * np.abs(accelerations[body])
