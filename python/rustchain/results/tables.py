"""A result as a dataset with units and as a table."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rustchain._rustchain import instruction_set
from rustchain.results.channels import PARTS, VARIABLES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from rustchain.results.result import Result
    from rustchain.results.views import Jumps

FORMAT = 1
"""Number of the format of files; a change of what is in a file and of its names raises it."""

JUMPS = ("jump_time", "jump_sprocket", "jump_direction")
TIME_ATTRIBUTES = {"units": "s", "long_name": "time"}
ENDS = ("initial_positions", "initial_velocities", "final_positions", "final_velocities")


def dataset_of(result: Result) -> xr.Dataset:
    """Return everything in a result, the scene in the attributes."""
    from rustchain.extras import xarray as xr

    there = {name: array for name, array in result.arrays.items() if array.size}
    variables = variables_of(there) | ends_of(result, ("initial", "final"))
    attributes: dict[str, Any] = {
        "status": result.status,
        "message": result.message,
        "stats": json.dumps(result.stats),
    }
    if result.jumps is not None:
        attributes["tooth_jumps"] = len(result.jumps[0])
        if len(result.jumps[0]):  # files have no empty variables
            variables |= jumps_of(result.jumps)
    used = {dim for dims, *_ in variables.values() for dim in dims}
    coordinates = {"time": ("time", result.time, TIME_ATTRIBUTES)}
    coordinates |= {n: values for n, values in coordinates_of(result).items() if n in used}
    return xr.Dataset(variables, coordinates, attributes_of(result) | attributes)


def coordinates_of(result: Result) -> dict[str, Any]:
    """Return the names and numbers of the parts along each dimension."""
    coordinates: dict[str, Any] = {
        "axis": ["x", "y"],
        "body": list(result.body_names),
        "joint": np.array(result.joint_names, dtype=str),
        "contact": np.array(result.contact_names, dtype=str),
    }
    if result.scene.kind != "mechanism":
        drive = result.drive
        coordinates |= {
            "hinge": np.arange(1, drive.hinge_count + 1),
            "bushing": np.arange(1, drive.hinge_count + 1),
            "end": [1, 2],
            "sprocket": np.arange(1, len(drive.sprockets) + len(drive.guides) + 1),
            "strand": list(result.strand_names),
        }
    return coordinates


def attributes_of(result: Result) -> dict[str, Any]:
    """Return what is known of a result before its run: scene, names, format and version."""
    from rustchain import __version__

    return {
        "scene": result.scene.to_json(placeholders=True),
        "groups": json.dumps(result.groups),
        "joint_names": json.dumps(result.joint_names),
        "contact_names": json.dumps(result.contact_names),
        "format": FORMAT,
        "rustchain_version": __version__,
        "platform": f"{platform.system()} {platform.machine()}, {instruction_set()}",
    }


def ends_of(result: Result, ends: Sequence[str]) -> dict[str, Any]:
    """Return the states at the ends of a run, those that have bodies."""
    found = {}
    for name in ENDS:
        end, quantity = name.split("_")
        if end in ends and (values := getattr(result, name)).size:
            for part, v, place in VARIABLES[quantity].parts(quantity):
                attributes = {"units": v.units, "long_name": f"{end} {v.long_name}"}
                found[f"{end}_{part}"] = (v.dims, values[:, place], attributes)
    return found


def jumps_of(jumps: Jumps) -> dict[str, Any]:
    """Return times, sprockets and directions of tooth jumps."""
    columns = zip(JUMPS, jumps, ("s", "1", "1"), strict=True)
    return {name: (("jump",), values, {"units": units}) for name, values, units in columns}


def variables_of(arrays: Mapping[str, npt.NDArray[Any]]) -> dict[str, Any]:
    """Return recorded arrays with their dimensions and attributes."""
    found = {}
    for name in filter(arrays.__contains__, VARIABLES):
        for part, v, place in VARIABLES[name].parts(name):
            attributes = {"units": v.units, "long_name": v.long_name}
            values = arrays[name] if part == name else arrays[name][..., place]
            found[part] = (("time", *v.dims), values, attributes)
    return found


def array_of(
    data: Mapping[Any, Any],
    name: str,
    end: str = "",
    place: Any = ...,  # noqa: ANN401
) -> npt.NDArray[Any] | None:
    """Return an array, or a `place` of it, from its parts in a dataset or file; None without it.

    `end` is "initial" or "final".
    """
    names = [f"{end}_{part}" if end else part for part in PARTS.get(name, (name,))]
    if names[0] not in data:
        return None
    parts = [np.asarray(data[part][place]) for part in names]
    return parts[0] if len(parts) == 1 else np.concatenate([parts[0], parts[1][..., None]], -1)


def table_of(dataset: xr.Dataset) -> pd.DataFrame:
    """Return a row for each time and a column for each number that was recorded."""
    from rustchain.extras import pandas as pd

    time = dataset["time"].values
    columns: dict[str, npt.NDArray[Any]] = {}
    parts = (part for name, each in VARIABLES.items() for part in each.parts(name))
    for name, variable, _ in parts:
        if name not in dataset:
            continue
        labels = product([name], *(dataset[d].values for d in variable.dims))
        series = dataset[name].values.reshape(len(time), -1).T
        columns |= {
            "_".join(map(str, label)): one for label, one in zip(labels, series, strict=True)
        }
    return pd.DataFrame(columns, index=pd.Index(time, name="time"))
