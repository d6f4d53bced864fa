"""A result as a dataset with units and as a table."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rustchain._rustchain import instruction_set
from rustchain.results.channels import PARTS, VARIABLES, Variable

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from rustchain.results.result import Result

FORMAT = 1
"""Number of the format of files; a change of what is in a file and of its names raises it."""

JUMPS = ("jump_time", "jump_sprocket", "jump_direction")
ENDS = ("initial_positions", "initial_velocities", "final_positions", "final_velocities")


def dataset_of(result: Result) -> xr.Dataset:
    """Return everything in a result, the scene in the attributes."""
    from rustchain.extras import xarray as xr

    coordinates: dict[str, Any] = {
        "time": xr.Variable("time", result.time, {"units": "s", "long_name": "time"}),
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
    there = {name: array for name, array in result.arrays.items() if array.size}
    variables = variables_of(there, VARIABLES)
    for name in ENDS:
        end, quantity = name.split("_")
        if (values := getattr(result, name)).size:
            for part, v, place in VARIABLES[quantity].parts(quantity):
                attributes = {"units": v.units, "long_name": f"{end} {v.long_name}"}
                variables[f"{end}_{part}"] = (v.dims, values[:, place], attributes)
    attributes_of_jumps = {}
    if result.jumps is not None:
        attributes_of_jumps["tooth_jumps"] = len(result.jumps[0])
        if len(result.jumps[0]):  # files have no empty variables
            for name, values, units in zip(JUMPS, result.jumps, ("s", "1", "1"), strict=True):
                variables[name] = ("jump", values, {"units": units})
    return dataset(
        variables,
        coordinates,
        {
            "scene": result.scene.to_json(placeholders=True),
            "joint_names": json.dumps(result.joint_names),
            "contact_names": json.dumps(result.contact_names),
            "status": result.status,
            "message": result.message,
            "stats": json.dumps(result.stats),
        }
        | attributes_of_jumps,
    )


def variables_of(
    arrays: Mapping[str, npt.NDArray[Any]], known: Mapping[str, Variable]
) -> dict[str, Any]:
    """Return the arrays with their dimensions and attributes, those that are there."""
    found = {}
    for name in filter(arrays.__contains__, known):
        for part, v, place in known[name].parts(name):
            attributes = {"units": v.units, "long_name": v.long_name}
            if " or " in v.units:  # of joints of several kinds: a variable has one unit, or none
                attributes = {"long_name": f"{v.long_name} [{v.units}]"}
            values = arrays[name] if part == name else arrays[name][..., place]
            found[part] = (("time", *v.dims), values, attributes)
    return found


def array_of(data: xr.Dataset, name: str, end: str = "") -> npt.NDArray[Any] | None:
    """Return an array from its parts in a dataset, or None; `end` is "initial" or "final"."""
    names = [f"{end}_{part}" if end else part for part in PARTS.get(name, (name,))]
    if names[0] not in data:
        return None
    parts = [data[part].values for part in names]
    return parts[0] if len(parts) == 1 else np.concatenate([parts[0], parts[1][..., None]], -1)


def dataset(
    variables: dict[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]
) -> xr.Dataset:
    """Return a dataset with the coordinates that its variables have, format and version."""
    from rustchain import __version__
    from rustchain.extras import xarray as xr

    used = {"time"}.union(*(dims for dims, *_ in variables.values()))
    return xr.Dataset(
        variables,
        {name: values for name, values in coordinates.items() if name in used},
        {
            **attributes,
            "format": FORMAT,
            "rustchain_version": __version__,
            "platform": f"{platform.system()} {platform.machine()}, {instruction_set()}",
        },
    )


def table_of(dataset: xr.Dataset, known: Mapping[str, Variable]) -> pd.DataFrame:
    """Return a row for each time and a column for each number of the known variables."""
    from rustchain.extras import pandas as pd

    time = dataset["time"].values
    columns: dict[str, npt.NDArray[Any]] = {}
    parts = [(part, v.dims) for name in known for part, v, _ in known[name].parts(name)]
    for name, dims in parts:
        if name not in dataset:
            continue
        labels = product([name], *(dataset[d].values for d in dims))
        series = dataset[name].values.reshape(len(time), -1).T
        columns |= {
            "_".join(map(str, label)): one for label, one in zip(labels, series, strict=True)
        }
    return pd.DataFrame(columns, index=pd.Index(time, name="time"))
