"""Results of runs: arrays, views of their parts, figures, tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy.typing as npt

from rustchain import _rustchain
from rustchain.analysis import Outputs
from rustchain.arguments import checked_methods, shown
from rustchain.description.scene import OfScene, Scene
from rustchain.errors import NotRecorded
from rustchain.html import HtmlView
from rustchain.names import counted, named_attributes, suggest
from rustchain.parts import place_of, position_of
from rustchain.results.channels import OF_DRIVES, OF_MECHANISMS, VARIABLES
from rustchain.results.exports import Exports
from rustchain.results.mechanism_views import BodyMotion, ContactHistory, JointHistory
from rustchain.results.stored import part_of
from rustchain.results.values import ArrayValue, equal
from rustchain.results.views import (
    Bushing,
    ChainEnd,
    Energy,
    Hinge,
    Jumps,
    Peaks,
    RollerOnBushing,
    SprocketMotion,
    Strand,
)
from rustchain.typing import Array, Count

Status = Literal["finished", "stopped", "interrupted", "failed"]


@named_attributes
@checked_methods
@dataclass(frozen=True, eq=False, repr=False)
class Result(OfScene, ArrayValue, Outputs, Exports, HtmlView):
    """The record of a run, and its scene.

    Hinges, bushings and sprockets are numbered from 1 in calls, from 0 in arrays; bodies, joints
    and contacts go by their names. The arrays are read-only. Post-processing of chain drives are
    the methods from `link_tension` to `engagements`.

    Attributes
    ----------
    arrays : mapping of ndarray
        Everything recorded, by name; time is the first axis. `to_xarray` adds dims and units. Those
        of a run with ``out`` are read from the file when they are accessed.
    scene : Scene
        The simulated scene. `drive`, `hinge_law`, `tooth_law`, `solver` and
        `min_impact_velocity` are its own.
    body_names : tuple of str
        Names of the bodies.
    initial_positions, initial_velocities, final_positions, final_velocities : ndarray, (bodies, 3)
        State at both ends [m, m, rad] and [m/s, m/s, rad/s].
    status : {"finished", "stopped", "interrupted", "failed"}
        Status at the end of the run.
    message : str
        Reason of the end, as text.
    stats : dict
        Steps, evaluations, onsets of contacts and wall time by phase [s] of this run.
    jumps : tuple of ndarray, optional
        Times [s], sprockets (from 1) and directions of the tooth jumps since the simulation began;
        see `tooth_jumps`. None in mechanisms, where they are not counted.
    joint_names, contact_names : tuple of str
        Of mechanisms, in the order of the arrays.

    Examples
    --------
    >>> result = rc.Simulation(rc.paper_drive()).run(2e-3, progress=False)
    >>> result.status, result.time.size, result.hinge(6).force.shape
    ('finished', 21, (21,))
    """

    arrays: Mapping[str, npt.NDArray[Any]]
    scene: Scene
    body_names: tuple[str, ...]
    initial_positions: Array
    initial_velocities: Array
    final_positions: Array
    final_velocities: Array
    status: Status
    message: str
    stats: dict[str, Any]
    jumps: Jumps | None = None
    joint_names: tuple[str, ...] = ()
    contact_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        self.__setstate__(vars(self))

    def __eq__(self, other: object) -> bool:
        """Return whether all is equal to the last bit, except the wall times of the runs."""
        if type(other) is not type(self):
            return NotImplemented
        values = []
        for result in (self, other):
            stats = {name: n for name, n in result.stats.items() if not name.startswith("wall_")}
            values.append({**vars(result), "stats": stats})
        return equal(*values)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Return status, time span and recorded groups."""
        span = f"{self.time[0]:.6g} to {self.time[-1]:.6g} s in {counted(len(self.time), 'rows')}"
        groups = ", ".join(self.groups)
        return f"<Result of {self.scene.name}: {self.status}, {span}: {groups}>"

    @property
    def success(self) -> bool:
        """True if the run reached its end or a stop condition."""
        return self.status in ("finished", "stopped")

    @property
    def groups(self) -> tuple[str, ...]:
        """Recorded groups."""
        return tuple(dict.fromkeys(v.group for name, v in VARIABLES.items() if name in self.arrays))

    @property
    def time(self) -> Array:
        """Report times [s], (times,)."""
        return self.arrays["time"]

    def array(self, name: str) -> npt.NDArray[Any]:
        """Return a recorded array by its name in `arrays`, or raise with the remedy."""
        self._check_recorded(name)
        return self.arrays[name]

    def _column(self, name: str, place: int) -> npt.NDArray[Any]:
        """Return a column of a recorded array; of a file, nothing else is read."""
        self._check_recorded(name)
        return part_of(self.arrays, name, slice(None), place)

    def _if_recorded(self, name: str, place: int) -> npt.NDArray[Any] | None:
        return self._column(name, place) if name in self.arrays else None

    def _check_recorded(self, name: str) -> None:
        """Raise with the remedy where there is no such array."""
        if name in self.arrays:
            return
        if name not in VARIABLES:
            msg = f"name = {shown(name)}: there is no such array; {suggest(name, self.arrays)}"
            raise NotRecorded(msg)
        group = VARIABLES[name].group
        if group in self.groups:
            msg = (
                f"{name}: this scene has no such channel; expected hinges='clearance', and for "
                "channels of rollers, film or ends a drive that has them"
            )
        elif group == "energy":
            msg = "the energy balance was not recorded; pass energy=True to run"
        elif group in {"drive": OF_MECHANISMS, "mechanism": OF_DRIVES}[self.scene.kind]:
            msg = f"{name}: {self.scene.name} has no {group}; it has recorded {self.groups}"
        else:
            msg = f"{group} were not recorded; pass record=(..., {shown(group)}) to run"
        raise NotRecorded(msg)

    def hinge(self, number: Count) -> Hinge:
        """Return hinge `number`, which joins the front of that link and the rear of the next.

        Hinge `links` of an open chain joins the last link and end 2, hinge `links` + 2 joins end 1
        and the first link; the one between is none.
        """
        k = position_of("hinge", number, self.drive.hinge_count)
        names = ("force", "force_vector", "penetration", "eccentricity")
        more = (self._if_recorded(f"hinge_{name}", k) for name in ("film_force", "onset_speed"))
        return Hinge(self.time, *(self._column(f"hinge_{name}", k) for name in names), *more)

    def bushing(self, number: Count) -> Bushing:
        """Return bushing `number`, that of the hinge with the same number."""
        k = position_of("bushing", number, self.drive.hinge_count)
        names = ("force", "penetration", "sprocket", "index", "region")
        more = (self._if_recorded(f"tooth_{name}", k) for name in ("force_vector", "onset_speed"))
        return Bushing(self.time, *(self._column(f"tooth_{name}", k) for name in names), *more)

    def roller(self, number: Count) -> RollerOnBushing:
        """Return roller `number`, on the bushing with the same number, where rollers are bodies."""
        if self.drive.chain.roller is None:
            msg = "roller: the chain's rollers are no bodies of their own; see Chain.roller"
            raise NotRecorded(msg)
        k = position_of("roller", number, self.drive.hinge_count)
        force, vector, penetration, eccentricity, onset_speed = (
            self._column(f"roller_{name}", k)
            for name in ("force", "force_vector", "penetration", "eccentricity", "onset_speed")
        )
        body = self.drive.hinge_count + k
        position, velocity = (
            self._if_recorded(quantity, body) for quantity in ("positions", "velocities")
        )
        return RollerOnBushing(
            self.time, force, vector, penetration, eccentricity, position, velocity, onset_speed
        )

    @property
    def strand_names(self) -> tuple[str, ...]:
        """Names of the strands, in the order of arrays.

        Two sprockets have "upper" (left of the line from sprocket 1 to 2) and "lower"; of more,
        "1-3" leads from sprocket 1 to sprocket 3. Open chains have "end_1-1", "1-2", ... and so on
        to "end_2".
        """
        return tuple(_rustchain.strand_names(self.drive))

    def strand(self, name: str | Count) -> Strand:
        """Return a strand by its name in `strand_names` or by its number there, from 1."""
        names = self.strand_names
        if not isinstance(name, str):
            k = position_of("strand", name, len(names))
        else:
            k = place_of("strand", name, names)
        return Strand(self.time, self._column("strand_tension", k))

    def sprocket(self, number: Count) -> SprocketMotion:
        """Return sprocket `number`, from 1."""
        k = position_of("sprocket", number, len(self.drive.sprockets))
        names = ("angle", "speed", "torque", "center")
        return SprocketMotion(self.time, *(self._column(f"sprocket_{name}", k) for name in names))

    def end(self, number: Count) -> ChainEnd:
        """Return end `number` of an open chain: 1 before its first link, 2 behind its last one."""
        k = position_of("end", number, 0 if self.drive.ends is None else 2)
        names = ("force", "position", "velocity")
        return ChainEnd(self.time, *(self._column(f"end_{name}", k) for name in names))

    def guide(self, number: Count) -> SprocketMotion:
        """Return guide `number`: angle, speed, torque and place of its bearing.

        The torque is that of the bearing. On a `GuideArm` it is the force of the plunger with its
        ramp, times the lever, without spring, dashpot, stops and ratchet.

        In arrays the guides follow the sprockets; a bushing's `sprocket` counts them on.
        """
        k = position_of("guide", number, len(self.drive.guides)) + len(self.drive.sprockets)
        names = ("angle", "speed", "torque", "center")
        return SprocketMotion(self.time, *(self._column(f"sprocket_{name}", k) for name in names))

    def body(self, name: str) -> BodyMotion:
        """Return a body by its name in `body_names`."""
        k = place_of("body", name, self.body_names)
        return BodyMotion(
            self.time,
            self._column("positions", k),
            self._column("velocities", k),
            self._if_recorded("accelerations", k),
        )

    def joint(self, name: str) -> JointHistory:
        """Return a joint or driver by its name in `joint_names`."""
        self._check_recorded("joint_reaction")
        k = place_of("joint", name, self.joint_names)
        reaction = self._column("joint_reaction", k)
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
            *(self._column(part, k) for part in others),
        )

    def contact(self, name: str) -> ContactHistory:
        """Return a contact by its name in `contact_names`."""
        self._check_recorded("contact_force")
        k = place_of("contact", name, self.contact_names)
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
        return ContactHistory(self.time, *(self._column(part, k) for part in names))

    @property
    def energy(self) -> Energy:
        """The energy balance."""
        names = ("kinetic", "gravity", "elastic", "dissipated", "external_work", "residual")
        kinds = ("contact", "friction")
        places = [*(f"{part}_{kind}" for kind in kinds for part in ("hinge", "tooth"))]
        places += [*(f"roller_{kind}" for kind in kinds), "hinge_film"]
        return Energy(
            *(self.array(f"energy_{name}") for name in names),
            *(self.arrays.get(f"energy_{name}") for name in places),
        )

    @property
    def peaks(self) -> Peaks:
        """The largest forces and impulses between the report times."""
        return Peaks(self)
