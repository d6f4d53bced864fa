"""The compiled mechanism with the interface of the other cores."""

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
from rustchain.description.mechanism.plausibility import implausible_inputs
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.results.channels import VARIABLES
from rustchain.typing import Array


class MechanismCore:
    """Core of a mechanism."""

    def __init__(
        self, mechanism: Mechanism, solver: Solver, place: Mapping[str, Array | None]
    ) -> None:
        self._core = _rustchain.MechanismCore(_placed(mechanism, place), solver, None)
        self._groups: list[str] = []
        self._energy = False
        self._start = [self._core.positions, self._core.velocities]
        # As described: the angles of a later state may be many turns.
        for text in (*self._core.check()["warnings"], *implausible_inputs(mechanism)):
            warn_caller(text)

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401
        """Return what the compiled mechanism has alike."""
        if name == "_core":  # of a copy that is being made
            raise AttributeError(name)
        return getattr(self._core, name)

    def start(self) -> list[Array]:
        """Return positions and velocities after assembly."""
        return self._start

    def restored(self, snapshot: bytes) -> MechanismCore:
        """Return the same simulation in another state."""
        found = copy.copy(self)
        found._core = self._core.restored(snapshot)
        return found

    def start_recording(
        self, duration: float, report_step: float, groups: list[str], energy: bool
    ) -> None:
        """Begin a recording that ends `duration` [s] from now."""
        self._core.start_recording(duration, report_step)
        self._groups = [*groups, *(["energy"] if energy else [])]
        self._energy = energy

    def last_row(self, name: str) -> Array:
        """Refuse: stop conditions of drives, which look at rows, are not for mechanisms."""
        msg = f"{name}: is no channel of a mechanism"
        raise InvalidInput(msg)

    def set_input(self, sprocket: int, quantity: str, value: object) -> None:
        """Refuse: a mechanism has no sprockets by number, and its drivers are those described."""
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
