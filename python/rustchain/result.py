"""What a run recorded, its views by part, and the file it lives in."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib.metadata import version
from itertools import product
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain._description import Description
from rustchain._names import known_keywords, suggest
from rustchain.drive import ChainDrive
from rustchain.errors import InvalidInput, NotRecorded
from rustchain.force_law import ForceLaw
from rustchain.outputs import Outputs

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from rustchain.plot import Plots
    from rustchain.simulation import Solver

Array: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
Status = Literal["finished", "stopped", "interrupted", "failed"]


class _Variable(NamedTuple):
    """What an array of a result is."""

    group: str
    dims: tuple[str, ...]  # after "time"
    units: str
    long_name: str


_VARIABLES = {
    "hinge_force": _Variable("hinges", ("hinge",), "N", "force of pin on bushing"),
    "hinge_force_vector": _Variable("hinges", ("hinge", "axis"), "N", "force on the pin"),
    "hinge_penetration": _Variable("hinges", ("hinge",), "m", "penetration of pin into bushing"),
    "hinge_eccentricity": _Variable(
        "hinges", ("hinge", "axis"), "m", "pin centre seen from the bushing"
    ),
    "roller_force": _Variable("hinges", ("bushing",), "N", "force of bushing on roller"),
    "roller_force_vector": _Variable(
        "hinges", ("bushing", "axis"), "N", "force of the bushing on the roller"
    ),
    "roller_penetration": _Variable(
        "hinges", ("bushing",), "m", "penetration of bushing into roller"
    ),
    "roller_eccentricity": _Variable(
        "hinges", ("bushing", "axis"), "m", "bushing's centre seen from the roller"
    ),
    "peak_roller_force": _Variable(
        "hinges", ("bushing",), "N", "largest force of bushing on roller since the last row"
    ),
    "peak_roller_impulse": _Variable(
        "hinges", ("bushing",), "N s", "impulse of the bushing on the roller since the last row"
    ),
    "strand_tension": _Variable("hinges", ("strand",), "N", "mean tension of the strand's hinges"),
    "peak_hinge_force": _Variable(
        "hinges", ("hinge",), "N", "largest hinge force since the last row"
    ),
    "peak_hinge_impulse": _Variable(
        "hinges", ("hinge",), "N s", "impulse of the hinge since the last row"
    ),
    "end_force": _Variable("hinges", ("end", "axis"), "N", "force of the chain on its end"),
    "end_position": _Variable("hinges", ("end", "axis"), "m", "pin at the chain's end"),
    "end_velocity": _Variable("hinges", ("end", "axis"), "m/s", "its velocity"),
    "hinge_film_force": _Variable("hinges", ("hinge",), "N", "size of the film's force on the pin"),
    "tooth_force": _Variable("teeth", ("bushing",), "N", "force of tooth on bushing"),
    "tooth_penetration": _Variable("teeth", ("bushing",), "m", "penetration of bushing into tooth"),
    "tooth_sprocket": _Variable("teeth", ("bushing",), "1", "sprocket in contact, 0: none"),
    "tooth_index": _Variable("teeth", ("bushing",), "1", "tooth gap in contact, -1: none"),
    "tooth_region": _Variable(
        "teeth", ("bushing",), "1", "region of the tooth in contact, 0: none"
    ),
    "peak_tooth_force": _Variable(
        "teeth", ("bushing",), "N", "largest tooth force since the last row"
    ),
    "peak_tooth_impulse": _Variable(
        "teeth", ("bushing",), "N s", "impulse of the tooth since the last row"
    ),
    "sprocket_angle": _Variable("sprockets", ("sprocket",), "rad", "angle of the sprocket"),
    "sprocket_speed": _Variable("sprockets", ("sprocket",), "rad/s", "speed of the sprocket"),
    "sprocket_torque": _Variable(
        "sprockets", ("sprocket",), "N m", "torque on the sprocket's shaft"
    ),
    "sprocket_center": _Variable("sprockets", ("sprocket", "axis"), "m", "centre of the sprocket"),
    "positions": _Variable(
        "bodies", ("body", "coordinate"), "m, m, rad", "positions of the bodies"
    ),
    "velocities": _Variable(
        "bodies", ("body", "coordinate"), "m/s, m/s, rad/s", "velocities of the bodies"
    ),
    "energy_kinetic": _Variable("energy", (), "J", "kinetic energy"),
    "energy_gravity": _Variable("energy", (), "J", "potential energy of gravity"),
    "energy_elastic": _Variable("energy", (), "J", "elastic energy of the contacts"),
    "energy_dissipated": _Variable("energy", (), "J", "energy dissipated since the first row"),
    "energy_worked_in": _Variable("energy", (), "J", "work put in since the first row"),
    "energy_residual": _Variable("energy", (), "J", "residual of the energy balance"),
    "energy_hinge_contact": _Variable("energy", (), "J", "dissipated by damping in hinges"),
    "energy_tooth_contact": _Variable("energy", (), "J", "dissipated by damping on teeth"),
    "energy_hinge_friction": _Variable("energy", (), "J", "dissipated by friction in hinges"),
    "energy_tooth_friction": _Variable("energy", (), "J", "dissipated by friction on teeth"),
    "energy_roller_contact": _Variable("energy", (), "J", "dissipated by damping in rollers"),
    "energy_roller_friction": _Variable("energy", (), "J", "dissipated by friction in rollers"),
    "energy_hinge_film": _Variable("energy", (), "J", "dissipated by lubricant in hinges"),
}


@dataclass(frozen=True, eq=False)
class Hinge:
    """One hinge over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    force, penetration : ndarray, (times,)
        Normal force [N] and penetration [m]; penetration is negative when apart.
    force_vector : ndarray, (times, 2)
        Force on the pin, friction, film and all [N].
    eccentricity : ndarray, (times, 2)
        Pin centre seen from the bushing [m].
    film_force : ndarray, (times,), optional
        Size of what lubricant does [N], where there is any.
    """

    time: Array
    force: Array
    force_vector: Array
    penetration: Array
    eccentricity: Array
    film_force: Array | None = None


@dataclass(frozen=True, eq=False)
class Bushing:
    """One bushing's deepest contact with a tooth, over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    tooth_force, tooth_penetration : ndarray, (times,)
        Contact force [N] and penetration [m]; penetration is -inf when not even near.
    sprocket, tooth, region : ndarray of int, (times,)
        Sprocket from 1 (0: none), tooth gap from 0 (-1: none), region of the gap from 1
        (0: none); an ANSI gap has seven, the fourth is the seat.
    """

    time: Array
    tooth_force: Array
    tooth_penetration: Array
    sprocket: IntArray
    tooth: IntArray
    region: IntArray


@dataclass(frozen=True, eq=False)
class RollerOnBushing:
    """One roller on its bushing over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    force, penetration : ndarray, (times,)
        Normal force of the bushing in the bore [N] and penetration [m], negative when apart.
    force_vector : ndarray, (times, 2)
        Force of the bushing on the roller, friction and all [N].
    eccentricity : ndarray, (times, 2)
        Bushing's centre seen from the roller's [m].
    position, velocity : ndarray, (times, 3), optional
        The roller itself [m, m, rad] and [m/s, m/s, rad/s], where bodies were recorded.
    """

    time: Array
    force: Array
    force_vector: Array
    penetration: Array
    eccentricity: Array
    position: Array | None = None
    velocity: Array | None = None


@dataclass(frozen=True, eq=False)
class Strand:
    """One strand over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    tension : ndarray, (times,)
        Mean tension of the strand's hinges [N].
    """

    time: Array
    tension: Array


@dataclass(frozen=True, eq=False)
class SprocketMotion:
    """One sprocket over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    angle, speed, torque : ndarray, (times,)
        Angle [rad], speed [rad/s] and torque on the shaft [N m], counterclockwise positive.
    center : ndarray, (times, 2)
        Centre [m].
    """

    time: Array
    angle: Array
    speed: Array
    torque: Array
    center: Array


@dataclass(frozen=True, eq=False)
class ChainEnd:
    """One end of an open chain over time.

    Attributes
    ----------
    time : ndarray, (times,)
        Report times [s].
    force : ndarray, (times, 2)
        Force of the chain on its end [N]: the reaction of an anchor, with the other sign.
    position, velocity : ndarray, (times, 2)
        Pin of that end [m], [m/s]. A loose end has none: it stays where the chain began.
    """

    time: Array
    force: Array
    position: Array
    velocity: Array


@dataclass(frozen=True, eq=False)
class Energy:
    """The energy balance over time.

    Attributes
    ----------
    kinetic, gravity, elastic : ndarray, (times,)
        Energy stored [J].
    dissipated, worked_in : ndarray, (times,)
        Energy lost in contacts and in the tensioner's dashpot, and work of motors and tensioner,
        since the first row [J].
    residual : ndarray, (times,)
        What the balance misses [J]: the honest error figure of a long run.
    hinge_contact, tooth_contact, hinge_friction, tooth_friction : ndarray, (times,), optional
        Where `dissipated` was lost [J]: to the damping of contacts and to friction, of pins in
        bushings and of bushings on teeth; the rest went into dashpots. Only of chain drives with
        clearance in their hinges.
    roller_contact, roller_friction : ndarray, (times,), optional
        The same of bushings in rollers, where those are bodies.
    hinge_film : ndarray, (times,), optional
        The same of lubricant between pins and bushings [J], where there is any.
    """

    kinetic: Array
    gravity: Array
    elastic: Array
    dissipated: Array
    worked_in: Array
    residual: Array
    hinge_contact: Array | None = None
    tooth_contact: Array | None = None
    hinge_friction: Array | None = None
    tooth_friction: Array | None = None
    roller_contact: Array | None = None
    roller_friction: Array | None = None
    hinge_film: Array | None = None


@dataclass(frozen=True, eq=False)
class Peaks:
    """Largest forces [N] and impulses [N s] within each report interval; row i ends at time i.

    An impact lasts 15 to 80 us, so that most of them fall between two rows of the other arrays.
    """

    _result: Result

    @property
    def hinge_force(self) -> Array:
        """Largest force of each hinge [N], (times, hinges)."""
        return self._result.array("peak_hinge_force")

    @property
    def hinge_impulse(self) -> Array:
        """Impulse of each hinge [N s], (times, hinges)."""
        return self._result.array("peak_hinge_impulse")

    @property
    def roller_force(self) -> Array:
        """Largest force of each bushing in its roller [N], (times, rollers)."""
        return self._result.array("peak_roller_force")

    @property
    def roller_impulse(self) -> Array:
        """Impulse of each bushing in its roller [N s], (times, rollers)."""
        return self._result.array("peak_roller_impulse")

    @property
    def tooth_force(self) -> Array:
        """Largest tooth force of each bushing [N], (times, bushings)."""
        return self._result.array("peak_tooth_force")

    @property
    def tooth_impulse(self) -> Array:
        """Impulse of the teeth on each bushing [N s], (times, bushings)."""
        return self._result.array("peak_tooth_impulse")


@dataclass(frozen=True, eq=False, repr=False)
class Result(Outputs):
    """What a run recorded, and of what.

    Hinges, bushings and sprockets are numbered from 1 in calls, from 0 in arrays. What engineers
    read are the methods from `link_tension` to `engagements`.

    Attributes
    ----------
    arrays : dict of ndarray
        Everything recorded, by name; time is the first axis. `to_xarray` adds dims and units.
    drive, hinge_law, tooth_law, solver, min_approach_speed
        What was simulated, and how.
    body_names : tuple of str
        Names of the bodies.
    initial_positions, initial_velocities, final_positions, final_velocities : ndarray, (bodies, 3)
        State at both ends [m, m, rad] and [m/s, m/s, rad/s].
    status : {"finished", "stopped", "interrupted", "failed"}
        How the run ended.
    message : str
        The same in words.
    stats : dict
        Steps, evaluations, onsets of contacts and wall time by phase [s] of this run.
    """

    arrays: dict[str, npt.NDArray[Any]]
    drive: ChainDrive
    hinge_law: ForceLaw
    tooth_law: ForceLaw
    solver: Solver
    min_approach_speed: float
    body_names: tuple[str, ...]
    initial_positions: Array
    initial_velocities: Array
    final_positions: Array
    final_velocities: Array
    status: Status
    message: str
    stats: dict[str, Any]

    def __repr__(self) -> str:
        """Return how the run ended and what is there."""
        name = self.drive.name or "chain drive"
        span = f"{self.time[0]:.6g} to {self.time[-1]:.6g} s in {len(self.time)} rows"
        return f"<Result of {name}: {self.status}, {span}: {', '.join(self.groups)}>"

    @property
    def success(self) -> bool:
        """Whether the run reached its end, or a stop condition."""
        return self.status in ("finished", "stopped")

    @property
    def groups(self) -> tuple[str, ...]:
        """What was recorded."""
        return tuple(
            dict.fromkeys(v.group for name, v in _VARIABLES.items() if name in self.arrays)
        )

    @property
    def time(self) -> Array:
        """Report times [s], (times,)."""
        return self.arrays["time"]

    def array(self, name: str) -> npt.NDArray[Any]:
        """Return a recorded array by its name in `arrays`, or raise with the remedy."""
        if name in self.arrays:
            return self.arrays[name]
        if name not in _VARIABLES:
            msg = f"no array {name!r}; {suggest(name, _VARIABLES)}"
            raise NotRecorded(msg)
        group = _VARIABLES[name].group
        if group == "energy":
            msg = "the energy balance was not recorded; pass energy=True to run"
        else:
            msg = f"{group} were not recorded; pass record=(..., {group!r}) to run"
        raise NotRecorded(msg)

    def hinge(self, number: int) -> Hinge:
        """Return hinge `number`, which joins the front of that link and the rear of the next.

        Hinge `links` of an open chain joins the last link and end 2, hinge `links` + 2 joins end 1
        and the first link; the one between is none.
        """
        k = _position("hinge", number, self.drive.hinge_count)
        force, vector, penetration, eccentricity = (
            self.array(f"hinge_{name}")[:, k]
            for name in ("force", "force_vector", "penetration", "eccentricity")
        )
        film = self.arrays.get("hinge_film_force")
        film = None if film is None else film[:, k]
        return Hinge(self.time, force, vector, penetration, eccentricity, film)

    def bushing(self, number: int) -> Bushing:
        """Return bushing `number`, that of the hinge with the same number."""
        k = _position("bushing", number, self.drive.hinge_count)
        names = ("force", "penetration", "sprocket", "index", "region")
        return Bushing(self.time, *(self.array(f"tooth_{name}")[:, k] for name in names))

    def roller(self, number: int) -> RollerOnBushing:
        """Return roller `number`, on the bushing with the same number, where rollers are bodies."""
        if self.drive.chain.roller is None:
            msg = "roller: the chain's rollers are no bodies of their own; see Chain.roller"
            raise NotRecorded(msg)
        k = _position("roller", number, self.drive.hinge_count)
        names = ("force", "force_vector", "penetration", "eccentricity")
        body = self.drive.hinge_count + k
        moved = (self.arrays.get(name) for name in ("positions", "velocities"))
        return RollerOnBushing(
            self.time,
            *(self.array(f"roller_{name}")[:, k] for name in names),
            *(None if array is None else array[:, body] for array in moved),
        )

    @property
    def strand_names(self) -> tuple[str, ...]:
        """Names of the strands, in the order of arrays.

        Two sprockets have "upper" (left of the line from sprocket 1 to 2) and "lower"; of more,
        "1-3" leads from sprocket 1 to sprocket 3. Open chains have "end_1-1", "1-2", ... and so on
        to "end_2".
        """
        return tuple(_rustchain.strand_names(self.drive))

    def strand(self, name: str | int) -> Strand:
        """Return a strand by its name in `strand_names` or by its number there, from 1."""
        names = self.strand_names
        if not isinstance(name, str):
            k = _position("strand", name, len(names))
        elif name in names:
            k = names.index(name)
        else:
            msg = f"strand: {name!r} is no strand; {suggest(name, names)}"
            raise InvalidInput(msg)
        return Strand(self.time, self.array("strand_tension")[:, k])

    def sprocket(self, number: int) -> SprocketMotion:
        """Return sprocket `number`; 1 is the driver."""
        k = _position("sprocket", number, len(self.drive.sprockets))
        names = ("angle", "speed", "torque", "center")
        return SprocketMotion(self.time, *(self.array(f"sprocket_{name}")[:, k] for name in names))

    def end(self, number: int) -> ChainEnd:
        """Return end `number` of an open chain: 1 before its first link, 2 behind its last one."""
        k = _position("end", number, 0 if self.drive.ends is None else 2)
        names = ("force", "position", "velocity")
        return ChainEnd(self.time, *(self.array(f"end_{name}")[:, k] for name in names))

    def guide(self, number: int) -> SprocketMotion:
        """Return guide `number`: angle and place of its bearing, torque on it.

        In arrays the guides follow the sprockets; a bushing's `sprocket` counts them on.
        """
        k = _position("guide", number, len(self.drive.guides)) + len(self.drive.sprockets)
        names = ("angle", "speed", "torque", "center")
        return SprocketMotion(self.time, *(self.array(f"sprocket_{name}")[:, k] for name in names))

    @property
    def energy(self) -> Energy:
        """The energy balance."""
        names = ("kinetic", "gravity", "elastic", "dissipated", "worked_in", "residual")
        kinds = ("contact", "friction")
        places = [*(f"{part}_{kind}" for kind in kinds for part in ("hinge", "tooth"))]
        places += [*(f"roller_{kind}" for kind in kinds), "hinge_film"]
        return Energy(
            *(self.array(f"energy_{name}") for name in names),
            *(self.arrays.get(f"energy_{name}") for name in places),
        )

    def efficiency(self, after: float = 0.0) -> float:
        """Return the power delivered over the power delivered and lost, as `power_balance` has it.

        Parameters
        ----------
        after : float
            Time from which on to count [s]: the drive should have settled by then.

        Returns
        -------
        float
            NaN where nothing is delivered, or no shaft puts work in.

        Raises
        ------
        InvalidInput
            No two rows lie after that time.
        """
        return float(self.power_balance(start=after)["efficiency"])

    @property
    def peaks(self) -> Peaks:
        """The largest forces and impulses between the report times."""
        return Peaks(self)

    @property
    def plot(self) -> Plots:
        """Figures; see `rustchain.plot.Plots`."""
        from rustchain.plot import Plots

        return Plots(self)

    def to_xarray(self) -> xr.Dataset:
        """Return everything as a dataset with units; the scene is in its attributes."""
        import xarray as xr

        coordinates = {
            "time": xr.Variable("time", self.time, {"units": "s", "long_name": "time"}),
            "hinge": np.arange(1, self.drive.hinge_count + 1),
            "bushing": np.arange(1, self.drive.hinge_count + 1),
            "end": [1, 2],
            "sprocket": np.arange(1, len(self.drive.sprockets) + len(self.drive.guides) + 1),
            "strand": list(self.strand_names),
            "axis": ["x", "y"],
            "body": list(self.body_names),
            "coordinate": ["x", "y", "theta"],
        }
        variables = {
            name: (
                ("time", *v.dims),
                self.arrays[name],
                {"units": v.units, "long_name": v.long_name},
            )
            for name, v in _VARIABLES.items()
            if name in self.arrays
        }
        for name in _ENDS:
            end, quantity = name.split("_")
            units = _VARIABLES[quantity].units
            attributes = {"units": units, "long_name": f"{end} {quantity} of the bodies"}
            variables[name] = (("body", "coordinate"), getattr(self, name), attributes)
        used = {"time"}.union(*(dims for dims, *_ in variables.values()))
        return xr.Dataset(
            variables,
            {name: values for name, values in coordinates.items() if name in used},
            {name: getattr(self, name).to_json() for name in _SCENE}
            | {
                "min_approach_speed": self.min_approach_speed,
                "status": self.status,
                "message": self.message,
                "stats": json.dumps(self.stats),
                "rustchain_version": version("rustchain"),
            },
        )

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each time and a column for each number: ``hinge_force_vector_6_x``."""
        import pandas as pd

        dataset = self.to_xarray()
        columns: dict[str, npt.NDArray[Any]] = {}
        for name in filter(self.arrays.__contains__, _VARIABLES):
            labels = product([name], *(dataset[d].values for d in _VARIABLES[name].dims))
            series = self.arrays[name].reshape(len(self.time), -1).T
            columns |= {
                "_".join(map(str, label)): one for label, one in zip(labels, series, strict=True)
            }
        return pd.DataFrame(columns, index=pd.Index(self.time, name="time"))

    def save(self, path: str | Path) -> None:
        """Write everything to a netCDF file, for `load_result`."""
        dataset = self.to_xarray()
        packed = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
        dataset.to_netcdf(path, engine="h5netcdf", encoding=packed)


_SCENE = ("drive", "hinge_law", "tooth_law", "solver")
_ENDS = ("initial_positions", "initial_velocities", "final_positions", "final_velocities")


@known_keywords
def load_result(path: str | Path) -> Result:
    """Return the result that `Result.save` wrote to `path`.

    Raises
    ------
    InvalidInput
        The file holds no result of a drive, or is damaged.
    """
    import xarray as xr

    try:
        data = xr.load_dataset(path, engine="h5netcdf", decode_times=False)
    except OSError as error:
        if not Path(path).is_file():
            raise  # which names the path
        raise InvalidInput(_damaged(path, error)) from error
    except Exception as error:  # a damaged file raises what it likes
        raise InvalidInput(_damaged(path, error)) from error
    if "rustchain_version" not in data.attrs:
        msg = f"path: {path} holds no result of rustchain"
        raise InvalidInput(msg)
    if "mechanism" in data.attrs:
        msg = f"path: {path} holds the result of a mechanism; MechanismResult.load reads it"
        raise InvalidInput(msg)
    try:
        scene: dict[str, Any] = {name: Description.from_json(data.attrs[name]) for name in _SCENE}
        scene |= {name: data[name].values for name in _ENDS}
        return Result(
            arrays={"time": data["time"].values}
            | {name: data[name].values for name in _VARIABLES if name in data},
            **scene,
            min_approach_speed=float(data.attrs["min_approach_speed"]),
            body_names=tuple(map(str, data["body"].values)),
            status=data.attrs["status"],
            message=data.attrs["message"],
            stats=json.loads(data.attrs["stats"]),
        )
    except KeyError as error:
        raise InvalidInput(_damaged(path, error)) from error


def _damaged(path: str | Path, error: Exception) -> str:
    """Return what is said of a file that holds no whole result."""
    return (
        f"path = {path}: is no result of a drive, or is damaged ({error}): give a file that "
        "Result.save wrote, which is netCDF whatever its name, or copy or save it again"
    )


def _position(part: str, number: int, count: int) -> int:
    """Return the place in arrays of the part with this number."""
    if not 1 <= index(number) <= count:
        msg = f"{part} {number}: {part}s are numbered 1 to {count}"
        if count == 0:
            msg = f"{part} {number}: there is none"
        raise IndexError(msg)
    return index(number) - 1
