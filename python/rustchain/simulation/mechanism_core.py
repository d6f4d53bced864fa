"""The compiled mechanism behind the face that a simulation needs of every core."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import plain
from rustchain.caller import warn_caller
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.results.channels import VARIABLES
from rustchain.typing import Array


class MechanismCore:
    """What a simulation needs of the core of a mechanism."""

    def __init__(
        self, mechanism: Mechanism, solver: Solver, place: Mapping[str, Array | None]
    ) -> None:
        self._core = _rustchain.MechanismCore(_placed(mechanism, place), solver, None)
        self._groups: list[str] = []
        self._energy = False
        self._start = [self._core.positions, self._core.velocities]
        for text in self._core.check()["warnings"]:
            warn_caller(text)

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies."""
        return self._core.body_names

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints and drivers."""
        return self._core.joint_names

    @property
    def contact_names(self) -> list[str]:
        """Names of the contacts."""
        return self._core.contact_names

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

    @property
    def rows(self) -> int:
        """Number of rows recorded so far."""
        return self._core.rows

    def check(self) -> dict[str, Any]:
        """Return the fields of a MechanismReport."""
        return self._core.check()

    def start(self) -> list[Array]:
        """Return positions and velocities after assembly."""
        return self._start

    def state(self) -> dict[str, Any]:
        """Return the complete state."""
        return self._core.state()

    def restored(self, snapshot: bytes) -> MechanismCore:
        """Return the same simulation in another state."""
        found = copy.copy(self)
        found._core = self._core.restored(snapshot)
        return found

    def evaluate(
        self, positions: Array | None, velocities: Array | None, time: float | None
    ) -> dict[str, npt.NDArray[Any]]:
        """Return the fields of an Evaluation."""
        return self._core.evaluate(positions, velocities, time)

    def start_recording(
        self, duration: float, report_step: float, groups: list[str], energy: bool
    ) -> None:
        """Begin a recording that ends `duration` [s] from now."""
        self._core.start_recording(duration, report_step)
        self._groups = [*groups, *(["energy"] if energy else [])]
        self._energy = energy

    def advance(self, wall_budget: float) -> bool:
        """Go on for about `wall_budget` seconds of wall time; return whether the end is reached."""
        return self._core.advance(wall_budget)

    def step_to(self, t: float, wall_budget: float) -> bool:
        """Go on towards exactly `t` [s]; return whether it is reached."""
        return self._core.step_to(t, wall_budget)

    def pause_at_reports(self) -> None:
        """Make `advance` return after each report."""
        self._core.pause_at_reports()

    def last_row(self, name: str) -> Array:
        """Refuse: stop conditions of drives, which look at rows, are not for mechanisms."""
        msg = f"{name}: is no channel of a mechanism"
        raise InvalidInput(msg)

    def last_peaks(self) -> list[Array]:
        """Return the last row of the largest forces, of joints and of contacts [N]."""
        return self._core.last_peaks()

    def set_input(self, sprocket: int, quantity: str, value: object) -> None:
        """Refuse: a mechanism has no sprockets by number, and its drivers stay as described."""
        del value
        msg = (
            f"sprocket = {sprocket}: its {quantity} cannot be set in a mechanism; describe the "
            "driver or the torque with a function of time"
        )
        raise InvalidInput(msg)

    def take_recording(self) -> dict[str, npt.NDArray[Any]]:
        """Return the rows of the recorded groups up to now."""
        found = self._core.take_recording()
        return {
            name: array
            for name, array in found.items()
            if name == "time" or VARIABLES[name].group in self._groups
        }

    def stats(self) -> dict[str, float]:
        """Return the counts of the run."""
        return self._core.stats()

    def tooth_jumps(self) -> None:
        """Return nothing: a mechanism does not count tooth jumps."""

    def take_warnings(self) -> tuple[list[str], list[str], list[str]]:
        """Return what is new of the energy balance, where it is recorded."""
        text = self._core.take_warnings() if self._energy else None
        return [], [] if text is None else [text], []


def _placed(mechanism: Mechanism, place: Mapping[str, Array | None]) -> Mechanism:
    """Return the mechanism with its bodies at other positions and velocities."""
    names = {"positions": "position", "velocities": "velocity"}
    bodies = mechanism.bodies
    for quantity, name in names.items():
        rows = place[quantity]
        if rows is None:
            continue
        if len(rows) != len(bodies):
            msg = (
                f"{quantity} = {len(rows)} rows: needs one row (3 numbers) for each of the "
                f"{len(bodies)} bodies"
            )
            raise InvalidInput(msg)
        pairs = zip(bodies, plain(rows), strict=True)
        bodies = [replace(body, **{name: row}) for body, row in pairs]
    return replace(mechanism, bodies=bodies)
