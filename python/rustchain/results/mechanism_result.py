"""What a run of a mechanism recorded."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rustchain.arguments import checked_methods, shown
from rustchain.errors import InvalidInput
from rustchain.names import named_attributes, suggest
from rustchain.results import netcdf, tables
from rustchain.results.channels import Variable
from rustchain.results.mechanism_views import BodyMotion, ContactHistory, JointHistory
from rustchain.results.result import Status
from rustchain.results.views import Energy
from rustchain.typing import Array

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from rustchain.plot.mechanism import MechanismPlots

_VARIABLES = {
    "positions": Variable("bodies", ("body", "coordinate"), "m, m, rad", "positions"),
    "velocities": Variable("bodies", ("body", "coordinate"), "m/s, m/s, rad/s", "velocities"),
    "accelerations": Variable(
        "bodies", ("body", "coordinate"), "m/s^2, m/s^2, rad/s^2", "accelerations"
    ),
    "joint_reaction": Variable(
        "joints",
        ("joint", "component"),
        "N, N, N m",
        "force and torque on body b, about its point",
    ),
    "joint_position_residual": Variable("joints", ("joint",), "m or rad", "constraint residual"),
    "joint_velocity_residual": Variable(
        "joints", ("joint",), "m/s or rad/s", "rate of the constraint residual"
    ),
    "contact_force": Variable("contacts", ("contact",), "N", "normal force"),
    "contact_force_vector": Variable("contacts", ("contact", "axis"), "N", "force on the circle"),
    "contact_impact_velocity": Variable(
        "contacts",
        ("contact",),
        "m/s",
        "largest initial impact velocity since the last row, 0: no onset",
    ),
    "contact_penetration": Variable("contacts", ("contact",), "m", "penetration"),
    "contact_gap": Variable("contacts", ("contact",), "1", "gap of teeth near, -1: none"),
    "contact_region": Variable("contacts", ("contact",), "1", "region of tooth near, 0: none"),
    "peak_joint_force": Variable("joints", ("joint",), "N", "largest force since the last row"),
    "peak_joint_impulse": Variable("joints", ("joint",), "N s", "impulse since the last row"),
    "peak_contact_force": Variable(
        "contacts", ("contact",), "N", "largest normal force since the last row"
    ),
    "peak_contact_impulse": Variable("contacts", ("contact",), "N s", "impulse since the last row"),
    "energy_kinetic": Variable("energy", (), "J", "kinetic energy"),
    "energy_gravity": Variable("energy", (), "J", "potential energy of gravity"),
    "energy_elastic": Variable("energy", (), "J", "energy of springs and contacts"),
    "energy_dissipated": Variable("energy", (), "J", "energy dissipated since the first row"),
    "energy_external_work": Variable("energy", (), "J", "external work since the first row"),
    "energy_residual": Variable("energy", (), "J", "residual of the energy balance"),
}

_OF_MECHANISMS = ("MechanismResult.save", "a mechanism")  # what writes files, what they are of


@named_attributes
@checked_methods
@dataclass(frozen=True, eq=False, repr=False)
class MechanismResult:
    """What a run of a mechanism recorded.

    Attributes
    ----------
    arrays : dict of ndarray
        Everything recorded, by name; time is the first axis. `to_xarray` adds dims and units.
    name : str
        Of the mechanism.
    body_names, joint_names, contact_names : tuple of str
        In the order of the arrays.
    status : {"finished", "stopped", "interrupted", "failed"}
        How the run ended.
    message : str
        The same in words.
    stats : dict
        Steps, evaluations, onsets of contacts of this run.
    """

    arrays: dict[str, npt.NDArray[Any]]
    name: str
    body_names: tuple[str, ...]
    joint_names: tuple[str, ...]
    contact_names: tuple[str, ...]
    status: Status
    message: str
    stats: dict[str, Any]

    def __repr__(self) -> str:
        """Return how the run ended."""
        name = self.name or "a mechanism"
        return f"<MechanismResult of {name}: {self.status}, {len(self.time)} rows>"

    @property
    def success(self) -> bool:
        """Whether the run reached its end."""
        return self.status == "finished"

    @property
    def time(self) -> Array:
        """Report times [s], (times,)."""
        return self.arrays["time"]

    def body(self, name: str) -> BodyMotion:
        """Return a body by its name."""
        k = _place("body", name, self.body_names)
        names = ("positions", "velocities", "accelerations")
        return BodyMotion(self.time, *(self.arrays[part][:, k] for part in names))

    def joint(self, name: str) -> JointHistory:
        """Return a joint or driver by its name."""
        k = _place("joint", name, self.joint_names)
        reaction = self.arrays["joint_reaction"][:, k]
        others = (
            "joint_position_residual",
            "joint_velocity_residual",
            "peak_joint_force",
            "peak_joint_impulse",
        )
        return JointHistory(
            self.time,
            reaction[:, :2],
            reaction[:, 2],
            *(self.arrays[part][:, k] for part in others),
        )

    def contact(self, name: str) -> ContactHistory:
        """Return a contact by its name."""
        k = _place("contact", name, self.contact_names)
        names = (
            "contact_force",
            "contact_penetration",
            "contact_gap",
            "contact_region",
            "peak_contact_force",
            "peak_contact_impulse",
            "contact_force_vector",
            "contact_impact_velocity",
        )
        return ContactHistory(self.time, *(self.arrays[part][:, k] for part in names))

    @property
    def energy(self) -> Energy:
        """The energy balance."""
        names = ("kinetic", "gravity", "elastic", "dissipated", "external_work", "residual")
        return Energy(*(self.arrays[f"energy_{name}"] for name in names))

    @property
    def plot(self) -> MechanismPlots:
        """Figures; see `rustchain.plot.mechanism.MechanismPlots`."""
        from rustchain.plot.mechanism import MechanismPlots

        return MechanismPlots(self)

    def to_xarray(self) -> xr.Dataset:
        """Return everything as a dataset with units."""
        from rustchain.extras import xarray as xr

        coordinates = {
            "time": xr.Variable("time", self.time, {"units": "s", "long_name": "time"}),
            "body": list(self.body_names),
            "joint": np.array(self.joint_names, dtype=str),
            "contact": np.array(self.contact_names, dtype=str),
            "coordinate": ["x", "y", "theta"],
            "component": ["x", "y", "torque"],
            "axis": ["x", "y"],
        }
        there = {name: array for name, array in self.arrays.items() if array.size}
        return tables.dataset(
            tables.variables_of(there, _VARIABLES),
            coordinates,
            {
                "mechanism": self.name,
                "status": self.status,
                "message": self.message,
                "stats": json.dumps(self.stats),
            },
        )

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each time and a column for each number: ``positions_crank_x``."""
        return tables.table_of(self.to_xarray(), _VARIABLES)

    def save(self, path: str | Path) -> None:
        """Write everything to a netCDF file, for `load` and for xarray; see `Result.save`."""
        netcdf.write(self.to_xarray(), path)

    @classmethod
    def load(cls, path: str | Path) -> MechanismResult:
        """Return the result that `save` wrote to `path`; errors are those of `load_result`."""
        data = netcdf.read(path, *_OF_MECHANISMS)
        if "mechanism" not in data.attrs:
            msg = (
                f"path = {path}: holds no result of a mechanism; load_result reads those of drives"
            )
            raise InvalidInput(msg)
        try:
            names = {
                part: tuple(map(str, data[part].values)) if part in data else ()
                for part in ("body", "joint", "contact")
            }
            sizes = {part: len(listed) for part, listed in names.items()}
            sizes |= {"coordinate": 3, "component": 3, "axis": 2}
            arrays = {"time": data["time"].values}
            for name, v in _VARIABLES.items():
                shape = (len(arrays["time"]), *(sizes[d] for d in v.dims))
                arrays[name] = data[name].values if name in data else np.zeros(shape)
            return cls(
                arrays=arrays,
                name=data.attrs["mechanism"],
                body_names=names["body"],
                joint_names=names["joint"],
                contact_names=names["contact"],
                status=data.attrs["status"],
                message=data.attrs["message"],
                stats=json.loads(data.attrs["stats"]),
            )
        except Exception as error:  # so does what is damaged within
            raise netcdf.damaged(path, *_OF_MECHANISMS, error) from error


def _place(part: str, name: str, names: tuple[str, ...]) -> int:
    """Return the place in arrays of the part with this name."""
    if name not in names:
        msg = f"{part}: {shown(name)} is no {part} of this mechanism; {suggest(name, names)}"
        raise InvalidInput(msg)
    return names.index(name)
