"""The compiled core of a scene: what a simulation needs of it, and which one a scene has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.caller import warn_caller
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.results.views import Jumps
from rustchain.typing import Array

if TYPE_CHECKING:
    from typing_extensions import Self


class Core(Protocol):
    """What a simulation needs of the compiled core of its scene."""

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies, in the order of every (bodies, 3) array."""

    @property
    def time(self) -> float:
        """Present time [s]."""

    @property
    def positions(self) -> Array:
        """Present positions [m, m, rad], (bodies, 3)."""

    @property
    def velocities(self) -> Array:
        """Present velocities [m/s, m/s, rad/s], (bodies, 3)."""

    @property
    def rows(self) -> int:
        """Number of rows recorded so far."""

    def state(self) -> dict[str, Any]:
        """Return the complete state; bytes of it under "snapshot"."""

    def restored(self, snapshot: bytes) -> Self:
        """Return the same simulation in the state of `snapshot`; this one stays as it is."""

    def start(self) -> Sequence[Array]:
        """Return positions and velocities that the simulation was made with."""

    def evaluate(
        self, positions: Array | None, velocities: Array | None, time: float | None
    ) -> Mapping[str, npt.NDArray[Any]]:
        """Return the fields of an Evaluation."""

    def start_recording(
        self, duration: float, report_step: float, groups: list[str], energy: bool
    ) -> None:
        """Begin a recording that ends `duration` [s] from now."""

    def advance(self, wall_budget: float) -> bool:
        """Go on for about `wall_budget` seconds of wall time; return whether the end is reached."""

    def step_to(self, t: float, wall_budget: float) -> bool:
        """Go on towards exactly `t` [s]; return whether it is reached."""

    def pause_at_reports(self) -> None:
        """Make `advance` return after each report."""

    def last_row(self, name: str) -> Array:
        """Return the last row of a channel, flat."""

    def set_input(self, sprocket: int, quantity: str, value: object) -> None:
        """Let a sprocket, from 1, have another "speed" or "torque" from now on."""

    def take_recording(self) -> dict[str, npt.NDArray[Any]]:
        """Return the rows recorded up to now."""

    def stats(self) -> Mapping[str, float]:
        """Return the counts and wall times of the run."""

    def tooth_jumps(self) -> Jumps | None:
        """Return times [s], sprockets (from 1) and directions of all tooth jumps so far."""

    def take_warnings(self) -> tuple[list[str], list[str], list[str]]:
        """Return what is new: laws out of range; the energy balance; tooth jumps."""


def keywords_of(scene: Scene) -> dict[str, Any]:
    """Return the keywords of the compiled core of a drive, without its start."""
    drive = scene.drive
    if scene.start == "static" and drive.tensioner is not None:  # at full pull from the beginning
        drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.0))
    names = ("force_law", "hinge_law", "tooth_law", "min_impact_velocity", "solver")
    return {"drive": drive} | {name: getattr(scene, name) for name in names}


def start_of(scene: Scene) -> tuple[dict[str, Any], dict[str, float] | None]:
    """Return positions and velocities that a drive begins with, and how well it then rests.

    They are None where the core takes the generated ones.
    """
    if scene.start == "generated":
        given = {"positions": scene.positions, "velocities": scene.velocities}
        return {name: _array(rows) for name, rows in given.items()}, None
    keywords = keywords_of(scene)
    del keywords["solver"]
    found = _rustchain.static_start(**keywords)
    return {name: found.pop(name) for name in ("positions", "velocities")}, found


def core_of(scene: Scene, place: Mapping[str, Any]) -> Core:
    """Return the compiled core of a scene that begins at `place`."""
    if isinstance(scene.system, Mechanism):
        from rustchain.simulation.mechanism_core import MechanismCore

        return MechanismCore(scene.system, scene.solver, place)
    if scene.kind == "ideal":
        core = _rustchain.IdealCore(**keywords_of(scene), **place)
        if (note := core.take_start_note()) is not None:
            warn_caller(note)
        return core
    return _rustchain.Core(**keywords_of(scene), **place)


def _array(rows: object) -> Array | None:
    if not isinstance(rows, tuple):
        return None
    return np.array(rows, dtype=float) if rows else np.empty((0, 3))
