"""The compiled core of a scene, and its start."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rustchain import _rustchain
from rustchain.caller import warn_caller
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.plausibility import implausible_inputs
from rustchain.description.scene import Scene
from rustchain.typing import Array

_FAR = 0.01  # displacement over the pitch that closes ideal hinges without a warning
_FAST = 0.05  # change over the largest speed that does not open them without a warning


def start_of(scene: Scene) -> tuple[dict[str, Any], dict[str, float] | None]:
    """Return positions and velocities that a scene begins with, and how well it then rests.

    They are None where the core takes the generated ones. A static start has the surfaces of its
    contacts, too.
    """
    if scene.start == "generated":
        given = {"positions": scene.positions, "velocities": scene.velocities}
        return {name: _array(rows) for name, rows in given.items()}, None
    if isinstance(scene.system, Mechanism):
        found = _rustchain.mechanism_static_start(scene.system)
    else:
        found = _rustchain.static_start(scene)
    return {name: found.pop(name) for name in ("positions", "velocities", "surfaces")}, found


def core_of(scene: Scene, place: Mapping[str, Any]) -> _rustchain.Core:
    """Return the compiled core of a scene that begins at `place`."""
    if isinstance(scene.system, Mechanism):
        if place["positions"] is None and place["velocities"] is not None:
            described = tuple(body.position for body in scene.system.bodies)
            place = {**place, "positions": _array(described)}
        # Lengths and angles that are not described remain those of the described positions.
        core = _rustchain.MechanismCore(scene.system, scene.solver, **place)
        # As described: the angles of a later state may be many turns.
        for text in (*core.check()["warnings"], *implausible_inputs(scene)):
            warn_caller(text)
        return core
    core = _rustchain.Core(scene, **place)
    for text in implausible_inputs(scene):
        warn_caller(text)
    for text in changes_of_start(scene, place, (core.positions, core.velocities)):
        warn_caller(text)
    return core


def changes_of_start(
    scene: Scene, place: Mapping[str, Any], begun: tuple[Array, Array]
) -> list[str]:
    """Return what was changed much at the start of a drive to close its ideal hinges.

    `place` is what the start was given as; `begun` are positions and velocities at its beginning.
    """
    if scene.drive.hinges != "ideal" or place["positions"] is None:
        return []
    found = []
    moved, changed = begun[0] - place["positions"], begun[1] - place["velocities"]
    farthest = np.hypot(moved[:, 0], moved[:, 1]).max()
    if farthest > _FAR * scene.drive.chain.pitch:
        found.append(
            f"positions: links had to be moved by up to {farthest:.3e} m to close the ideal "
            "hinges: is each link placed where its hinges meet?"
        )
    given = np.hypot(place["velocities"][:, 0], place["velocities"][:, 1]).max()
    fastest = np.hypot(changed[:, 0], changed[:, 1]).max()
    if fastest > _FAST * given:
        found.append(
            f"velocities: those of links had to be changed by up to {fastest:.3e} m/s to keep the "
            "ideal hinges closed: does each hinge have one velocity?"
        )
    return found


def _array(rows: object) -> Array | None:
    if not isinstance(rows, tuple):
        return None
    return np.array(rows, dtype=float) if rows else np.empty((0, 3))
