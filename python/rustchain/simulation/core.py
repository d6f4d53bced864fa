"""The compiled core of a scene, and its start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from rustchain import _rustchain
from rustchain.caller import warn_caller
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.simulation.mechanism_core import MechanismCore
from rustchain.typing import Array

Core: TypeAlias = "_rustchain.Core | _rustchain.IdealCore | MechanismCore"


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
