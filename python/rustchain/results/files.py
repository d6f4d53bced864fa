"""Results from their files."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from rustchain.description.base import Description
from rustchain.description.scene import Scene
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords
from rustchain.paths import shown_path
from rustchain.results import netcdf
from rustchain.results.channels import OF_MECHANISMS, VARIABLES
from rustchain.results.result import Result
from rustchain.results.stored import StoredArrays, header_of, is_streamed
from rustchain.results.tables import ENDS, FORMAT, JUMPS, array_of
from rustchain.results.views import Jumps
from rustchain.typing import FilePath

if TYPE_CHECKING:
    import xarray as xr


@known_keywords
def load_result(path: FilePath) -> Result:
    """Return the result that `Result.save` or a run with ``out`` wrote to `path`.

    The arrays of a run with ``out`` are read when they are accessed. Such a file can be loaded
    during the run, and after its process was killed: it then has the rows that were written,
    and status "interrupted". Where bodies were not recorded, the last state of such a run is NaN.

    Python functions of a mechanism are not in the file: those of the scene then raise when called.

    Raises
    ------
    OSError
        There is no such file (`FileNotFoundError`), it is a directory (`IsADirectoryError`), a
        device or a FIFO, or cannot be read.
    InvalidInput
        The file holds no result, has the format of another version, or its content does not
        match its checksum.

    Examples
    --------
    >>> result = rc.Simulation(rc.paper_drive()).run(duration=1e-3, progress=False)
    >>> result.save("run.nc")
    >>> rc.load_result("run.nc") == result
    True
    """
    if is_streamed(path):
        return _streamed(Path(path))
    data = netcdf.read(path)
    _check_format(path, data.attrs)
    try:
        scene: Scene = Description.from_json(data.attrs["scene"])
        names = {
            "body": tuple(map(str, data["body"].values)) if "body" in data else (),
            "joint": tuple(json.loads(data.attrs["joint_names"])),
            "contact": tuple(json.loads(data.attrs["contact_names"])),
        }
        ends = {}
        for name in ENDS:
            end, quantity = name.split("_")
            rows = array_of(data, quantity, end)
            ends[name] = np.empty((0, 3)) if rows is None else rows
        return Result(
            arrays=_arrays_of(data, scene, {part: len(listed) for part, listed in names.items()}),
            scene=scene,
            body_names=names["body"],
            joint_names=names["joint"],
            contact_names=names["contact"],
            **ends,
            status=data.attrs["status"],
            message=data.attrs["message"],
            stats=json.loads(data.attrs["stats"]),
            jumps=_jumps_of(data),
        )
    except Exception as error:  # so does what is damaged within
        raise netcdf.damaged(path, error) from error


def _check_format(path: object, attributes: Mapping[Any, Any]) -> None:
    """Refuse the format of another version, and the other files of sweeps."""
    if "format" not in attributes and "case" in attributes:
        msg = (
            f"path = {shown_path(path)}: is a stored case of a sweep, without a result: load_sweep "
            "reads its folder"
        )
        raise InvalidInput(msg)
    if "format" not in attributes and "scene" not in attributes:
        msg = (
            f"path = {shown_path(path)}: is a table of a sweep or study, not a result: "
            "xarray.open_dataset reads it; rustchain run writes results"
        )
        raise InvalidInput(msg)
    if (found := attributes.get("format", "none")) != FORMAT:
        msg = (
            f"path = {shown_path(path)}: has format {found}, this rustchain reads {FORMAT}: load "
            f"it with the one that wrote it, {attributes.get('rustchain_version', 'unknown')}"
        )
        raise InvalidInput(msg)


def _streamed(path: Path) -> Result:
    """Return the result in a streamed file, of a run that has ended, continues, or was killed."""
    header = header_of(path)
    about, arrays = header.attributes, header.arrays
    _check_format(path, about)
    try:
        scene: Scene = Description.from_json(about["scene"])
        body, joint, contact = (
            tuple(map(str, json.loads(about[f"{part}_names"])))
            for part in ("body", "joint", "contact")
        )
        sizes = {"body": len(body), "joint": len(joint), "contact": len(contact)}
        arrays.empty = _empty_arrays(about, scene, sizes, len(arrays["time"]))
        ends = {}
        for quantity in ("positions", "velocities"):
            start = array_of(header.constants, quantity, "initial")
            start = np.empty((0, 3)) if start is None else start
            ends[f"initial_{quantity}"] = start
            last = _last_row(arrays, quantity, start)
            ends[f"final_{quantity}"] = np.array(header.end[quantity]) if header.end else last
        jumps = None
        if JUMPS[0] in header.constants:
            jumps = (*(header.constants[name] for name in JUMPS),)
        not_ended = f"the run has not ended; it has rows until t = {arrays['time'][-1]:.6g} s"
        end = header.end or {"status": "interrupted", "message": not_ended, "stats": {}}
        return Result(
            arrays=arrays,
            scene=scene,
            body_names=body,
            joint_names=joint,
            contact_names=contact,
            **ends,
            status=end["status"],
            message=end["message"],
            stats=end["stats"],
            jumps=cast("Jumps | None", jumps),
        )
    except Exception as error:  # so does what is damaged within
        raise netcdf.damaged(path, error) from error


def _arrays_of(
    data: xr.Dataset, scene: Scene, sizes: dict[str, int]
) -> dict[str, npt.NDArray[Any]]:
    """Return the recorded arrays, with the empty ones, which are not in the file."""
    arrays = {"time": data["time"].values}
    found = {name: array_of(data, name) for name in VARIABLES}
    arrays |= {name: array for name, array in found.items() if array is not None}
    return arrays | _empty_arrays(data.attrs, scene, sizes, len(arrays["time"]))


def _empty_arrays(
    attributes: Mapping[Any, Any], scene: Scene, sizes: dict[str, int], rows: int
) -> dict[str, npt.NDArray[Any]]:
    """Return the recorded arrays that are empty: of parts that the scene does not have."""
    groups: Collection[str] = json.loads(attributes.get("groups", "[]"))
    if scene.kind == "mechanism":
        groups = ("bodies", *OF_MECHANISMS)
    elif not scene.drive.sprockets and not scene.drive.guides:
        sizes = sizes | {"sprocket": 0}
    sizes = sizes | {"coordinate": 3, "component": 3, "axis": 2}
    arrays = {}
    for name, v in VARIABLES.items():
        shape = (rows, *(sizes.get(d, 1) for d in v.dims))
        if v.group in groups and 0 in shape[1:]:
            kind = np.int32 if name in ("contact_gap", "contact_region") else np.float64
            arrays[name] = np.zeros(shape, kind)
    return arrays


def _last_row(arrays: StoredArrays, quantity: str, like: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the last state of the bodies that was recorded; NaN where they were not."""
    if quantity not in arrays or not like.size:
        return np.full_like(like, np.nan)
    row: npt.NDArray[Any] = arrays.part(quantity, slice(-1, None))[0]
    return row


def _jumps_of(data: xr.Dataset) -> Jumps | None:
    """Return times, sprockets and directions of the tooth jumps; None where none were counted."""
    if "tooth_jumps" not in data.attrs:
        return None
    if not data.attrs["tooth_jumps"]:
        return np.empty(0), np.empty(0, np.int64), np.empty(0, np.int64)
    time, sprocket, direction = (data[name].values for name in JUMPS)
    return time, sprocket, direction
