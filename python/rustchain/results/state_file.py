"""A state and the scene it is of, in one file that NumPy alone can read."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np

from rustchain.arguments import rows_of, shown
from rustchain.description.base import Description
from rustchain.description.scene import Scene
from rustchain.errors import InvalidInput
from rustchain.paths import check_there, path_with_ending, shown_path, write_whole
from rustchain.typing import Array, FilePath

if TYPE_CHECKING:
    from typing_extensions import Self


class _HasState(Protocol):
    """A core whose state can be taken and set."""

    def state(self) -> dict[str, Any]: ...

    def restored(self, snapshot: bytes) -> Self: ...


_Core = TypeVar("_Core", bound=_HasState)

_FORMAT = 2  # of the file; what its snapshot holds has a version of its own
_ROWS = ("positions", "velocities")


def restored(
    core: _Core,
    state: Mapping[str, Any],
) -> _Core:
    """Return the simulation of `core` in another state, whose arrays must be as it was taken."""
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
                "of your own, make a Simulation with positions= and velocities="
            )
            raise InvalidInput(msg)
    return found


def write(path: FilePath, scene: Scene, start: Sequence[Array], state: Mapping[str, Any]) -> None:
    """Write a scene, its start and a state; the file is there whole or not at all."""
    from rustchain import __version__

    path_with_ending(path, "path", (".npz",), "states are NumPy archives")
    members: dict[str, Any] = {"format": _FORMAT, "rustchain_version": __version__}
    members["scene"] = scene.to_json()
    members |= {f"start.{name}": rows for name, rows in zip(_ROWS, start, strict=True)}
    members |= {f"state.{name}": value for name, value in state.items()}
    members["state.snapshot"] = np.frombuffer(state["snapshot"], dtype=np.uint8)
    archive = io.BytesIO()
    np.savez(archive, **members)
    write_whole(path, archive.getbuffer())


def read(path: FilePath) -> tuple[Scene, dict[str, Array | None], dict[str, Any]]:
    """Return the scene, its start and the state that `write` wrote."""
    packed = check_there(path, "Simulation.save_state").read_bytes()
    try:
        with zipfile.ZipFile(io.BytesIO(packed)) as archive:
            if any(member.compress_type != zipfile.ZIP_STORED for member in archive.infolist()):
                msg = "it is compressed, and may grow without a limit"
                raise ValueError(msg)
        with np.load(io.BytesIO(packed), allow_pickle=False) as file:
            members = {name: file[name] for name in file.files}
        found = int(members["format"])
        if found == _FORMAT:
            scene = Description.from_json(str(members["scene"]))
            if not isinstance(scene, Scene):
                msg = "its scene is none"
                raise TypeError(msg)
            start = {name: rows_of(name, members[f"start.{name}"], "bodies") for name in _ROWS}
            return scene, start, _state_of(members)
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


def _state_of(members: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state as `Simulation.state` gives it."""
    state = {
        name.removeprefix("state."): value[()]
        for name, value in members.items()
        if name.startswith("state.")
    }
    return state | {"snapshot": state["snapshot"].tobytes()}
