"""A state and the scene it is of, in one file that NumPy alone can read."""

from __future__ import annotations

import io
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np

from rustchain.arguments import rows_of, shown
from rustchain.description.base import Description
from rustchain.errors import InvalidInput
from rustchain.paths import check_there, shown_path, write_whole

if TYPE_CHECKING:
    from typing_extensions import Self


class _HasState(Protocol):
    """A core whose state can be taken and set."""

    def state(self) -> dict[str, Any]: ...

    def restored(self, snapshot: bytes) -> Self: ...


_Core = TypeVar("_Core", bound=_HasState)

_FORMAT = 1  # of the file; what its snapshot holds has a version of its own
_DESCRIBED = ("drive", "hinge_law", "tooth_law", "solver")
_ROWS = ("positions", "velocities")


def restored(
    core: _Core,
    state: Mapping[str, Any],
    start: str = "Simulation with positions= and velocities=",
) -> _Core:
    """Return the simulation of `core` in another state, whose arrays must be as it was taken.

    `start` says what makes a start of one's own.
    """
    snapshot = state.get("snapshot") if isinstance(state, Mapping) else None
    if not isinstance(snapshot, bytes):
        msg = f"state: {type(state).__name__} without a snapshot: pass what Simulation.state() gave"
        raise InvalidInput(msg)
    found = core.restored(snapshot)
    for name, value in found.state().items():
        if name not in state or not np.array_equal(state[name], value):
            change = "was changed" if name in state else "is missing"
            msg = (
                f"state[{shown(name)}] {change}: a state is set as it was taken; for a start "
                "of your "
                f"own, make a {start}"
            )
            raise InvalidInput(msg)
    return found


def write(path: str | Path, scene: Mapping[str, Any], state: Mapping[str, Any]) -> None:
    """Write a scene, its start included, and a state; the file is there whole or not at all."""
    members: dict[str, Any] = {"format": _FORMAT, "rustchain_version": version("rustchain")}
    members |= {name: scene[name].to_json() for name in _DESCRIBED}
    members |= {f"scene.{name}": scene[name] for name in ("min_impact_velocity", *_ROWS)}
    members |= {f"state.{name}": value for name, value in state.items()}
    members["state.snapshot"] = np.frombuffer(state["snapshot"], dtype=np.uint8)
    archive = io.BytesIO()
    np.savez(archive, **members)
    write_whole(path, archive.getbuffer())


def read(path: str | Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the scene and the state that `write` wrote."""
    packed = check_there(path, "Simulation.save_state").read_bytes()
    try:
        with np.load(io.BytesIO(packed), allow_pickle=False) as file:
            members = {name: file[name] for name in file.files}
        found = int(members["format"])
        if found == _FORMAT:
            return _scene_of(members), _state_of(members)
    except Exception as error:  # a damaged archive raises what it likes
        msg = (
            f"path = {shown_path(path)}: holds no state of rustchain, or is damaged: give a file "
            "that Simulation.save_state wrote, or copy or save it again"
        )
        raise InvalidInput(msg) from error
    msg = (
        f"path = {shown_path(path)}: has format {found}, this rustchain reads {_FORMAT}: load it "
        f"with the one that wrote it, {members.get('rustchain_version', 'of another version')}"
    )
    raise InvalidInput(msg)


def _scene_of(members: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keywords of the simulation."""
    scene = {name: Description.from_json(str(members[name])) for name in _DESCRIBED}
    scene["min_impact_velocity"] = members["scene.min_impact_velocity"].item()
    return scene | {name: rows_of(name, members[f"scene.{name}"], "bodies") for name in _ROWS}


def _state_of(members: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state as `Simulation.state` gives it."""
    state = {
        name.removeprefix("state."): value[()]
        for name, value in members.items()
        if name.startswith("state.")
    }
    return state | {"snapshot": state["snapshot"].tobytes()}
