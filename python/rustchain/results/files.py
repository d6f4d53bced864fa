"""Results of drives from their files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rustchain.description.base import Description
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords
from rustchain.results import netcdf
from rustchain.results.channels import VARIABLES
from rustchain.results.result import Result
from rustchain.results.tables import ENDS, JUMPS, SCENE
from rustchain.results.views import Jumps

if TYPE_CHECKING:
    import xarray as xr

_OF_DRIVES = ("Result.save", "a drive")  # what writes such files, and what they are of


@known_keywords
def load_result(path: str | Path) -> Result:
    """Return the result that `Result.save` wrote to `path`.

    Raises
    ------
    OSError
        There is no such file (`FileNotFoundError`), it is a directory (`IsADirectoryError`), a
        device or a FIFO, or cannot be read.
    InvalidInput
        The file holds no result of a drive, or its content does not match its checksum.
    """
    data = netcdf.read(path, *_OF_DRIVES)
    if "mechanism" in data.attrs:
        msg = f"path = {path}: holds the result of a mechanism; MechanismResult.load reads it"
        raise InvalidInput(msg)
    try:
        scene: dict[str, Any] = {name: Description.from_json(data.attrs[name]) for name in SCENE}
        scene |= {name: data[name].values for name in ENDS}
        return Result(
            arrays={"time": data["time"].values}
            | {name: data[name].values for name in VARIABLES if name in data},
            **scene,
            min_impact_velocity=float(data.attrs["min_impact_velocity"]),
            body_names=tuple(map(str, data["body"].values)),
            status=data.attrs["status"],
            message=data.attrs["message"],
            stats=json.loads(data.attrs["stats"]),
            jumps=_jumps_of(data),
        )
    except Exception as error:  # so does what is damaged within
        raise netcdf.damaged(path, *_OF_DRIVES, error) from error


def _jumps_of(data: xr.Dataset) -> Jumps | None:
    """Return times, sprockets and directions of the tooth jumps; None where none were counted."""
    if "tooth_jumps" not in data.attrs:
        return None
    if not data.attrs["tooth_jumps"]:
        return np.empty(0), np.empty(0, np.int64), np.empty(0, np.int64)
    time, sprocket, direction = (data[name].values for name in JUMPS)
    return time, sprocket, direction
