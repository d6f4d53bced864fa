"""Results of drives from their files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rustchain import _netcdf
from rustchain._channels import VARIABLES
from rustchain._description import Description
from rustchain._names import known_keywords
from rustchain._result_tables import ENDS, SCENE
from rustchain.errors import InvalidInput
from rustchain.result import Result

_DAMAGED = (
    "is no result of a drive, or is damaged ({}): give a file that "
    "Result.save wrote, which is netCDF whatever its name, or copy or save it again"
)


@known_keywords
def load_result(path: str | Path) -> Result:
    """Return the result that `Result.save` wrote to `path`.

    Raises
    ------
    InvalidInput
        The file holds no result of a drive, or is damaged.
    """
    data = _netcdf.read(path, _DAMAGED)
    if "rustchain_version" not in data.attrs:
        msg = f"path: {path} holds no result of rustchain"
        raise InvalidInput(msg)
    if "mechanism" in data.attrs:
        msg = f"path: {path} holds the result of a mechanism; MechanismResult.load reads it"
        raise InvalidInput(msg)
    try:
        scene: dict[str, Any] = {name: Description.from_json(data.attrs[name]) for name in SCENE}
        scene |= {name: data[name].values for name in ENDS}
        return Result(
            arrays={"time": data["time"].values}
            | {name: data[name].values for name in VARIABLES if name in data},
            **scene,
            min_approach_speed=float(data.attrs["min_approach_speed"]),
            body_names=tuple(map(str, data["body"].values)),
            status=data.attrs["status"],
            message=data.attrs["message"],
            stats=json.loads(data.attrs["stats"]),
        )
    except KeyError as error:
        raise InvalidInput(f"path = {path}: " + _DAMAGED.format(error)) from error
