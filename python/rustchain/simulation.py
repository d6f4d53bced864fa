"""A drive, its force laws and a solver: the present state, single evaluations and runs."""

from __future__ import annotations

import reprlib
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NoReturn, get_args

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain, _state_file
from rustchain._description import Description
from rustchain._names import known_keywords, suggest
from rustchain.drive import ChainDrive
from rustchain.errors import EnergyWarning, InvalidInput, RangeWarning, SimulationError
from rustchain.force_law import ForceLaw, LankaraniNikravesh, with_friction
from rustchain.friction import Coulomb
from rustchain.mechanism import Mechanism
from rustchain.result import Array, Result, Status

if TYPE_CHECKING:
    from typing import TypeAlias

    from tqdm import tqdm

    from rustchain._ideal_hinges import IdealHingeCore

    Core: TypeAlias = _rustchain.Core | IdealHingeCore

Method = Literal["auto", "pece", "newton"]
Group = Literal["hinges", "teeth", "sprockets", "bodies", "energy"]

_WALL_BUDGET = 0.05  # [s] between looks at the keyboard and the progress bar


@known_keywords
@dataclass(frozen=True)
class Solver(Description):
    """How the equations of motion are integrated: Adams' formulas of variable step and order.

    Attributes
    ----------
    method : {"auto", "pece", "newton"}
        How the corrector's equation is solved. "pece": predict, evaluate, correct, evaluate
        (Adams-Bashforth-Moulton, Shampine and Gordon 1975); held to small steps by stiff contacts.
        "newton": Newton's method with the exact derivatives of all contacts; at order 2, the
        trapezoid, while contacts vibrate stiffly, higher where the motion is smooth. "auto": the
        cheaper of the two, changed over while running.
    rtol, atol : float, optional
        Relative and absolute tolerance of every component, in its own unit, as in SciPy; they rule
        in place of `accuracy` when one of them is given (the other is then 1e-5). One may be 0.
    max_step : float
        Largest step [s].
    max_order : int
        Highest order, 1 to 12.
    accuracy : float
        Error that a step is allowed: in lengths `accuracy` [m], in speeds `accuracy` times 1e5/s,
        in angles what moves as much at half the pitch (of a sprocket, at its pitch radius). To
        compare it with: clearances of 25e-6 m, penetrations of about 1e-6 m, impacts at 1e-3 to
        1 m/s. Every tenth of it divides the energy residual by about three with "newton".
    """

    method: Method = "auto"
    rtol: float | None = None
    atol: float | None = None
    max_step: float = 1e-4
    max_order: int = 12
    accuracy: float = 1e-10


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Accelerations and contacts of one state.

    Attributes
    ----------
    accelerations : ndarray, (bodies, 3)
        Accelerations [m/s^2, m/s^2, rad/s^2].
    hinge_force, hinge_penetration : ndarray, (hinges,)
        Normal force [N] and penetration [m] of each hinge; penetration is negative when apart.
    hinge_force_vector : ndarray, (hinges, 2)
        Force on the pin, friction and all [N].
    tooth_force, tooth_penetration : ndarray, (bushings, sprockets)
        Normal force [N] and penetration [m] of each bushing; penetration is -inf when not near.
    tooth_force_vector : ndarray, (bushings, sprockets, 2)
        Force on the bushing, friction and all [N].
    tooth_region, tooth_index : ndarray of int, (bushings, sprockets)
        Region of the tooth, 1 to 7 (0: none), and its gap, from 0 (-1: none).
    """

    accelerations: Array
    hinge_force: Array
    hinge_penetration: Array
    hinge_force_vector: Array
    tooth_force: Array
    tooth_penetration: Array
    tooth_force_vector: Array
    tooth_region: npt.NDArray[np.int32]
    tooth_index: npt.NDArray[np.int32]


_LAW = LankaraniNikravesh()
_SOLVER = Solver()
_SCENE = ("drive", "force_law", "hinge_law", "tooth_law", "min_approach_speed", "solver")


@known_keywords
class Simulation:
    """A chain drive in motion; a mechanism makes a `MechanismSimulation`, with its keywords.

    Parameters
    ----------
    drive : ChainDrive or Mechanism
        What moves.
    force_law : ForceLaw
        Law of every contact.
    hinge_law, tooth_law : ForceLaw, optional
        Law of pins in bushings, of bushings on teeth; by default `force_law`.
    friction : Coulomb, optional
        Friction of every contact: put into the laws, as ``ForceLaw.friction``.
    hinge_friction, tooth_friction : Coulomb, optional
        Friction of pins in bushings, of bushings on teeth; by default `friction`.
    min_approach_speed : float
        Least approach speed that the damping reckons with [m/s]; without it, a contact that begins
        slowly would be damped without limit.
    positions, velocities : array_like, (bodies, 3), optional
        A start of one's own [m, m, rad] and [m/s, m/s, rad/s]; by default the generated one.
    solver : Solver
        Method and tolerances.
    start : {"laid", "static"}
        As the generator lays the chain, with nothing in contact; or at rest under gravity, the
        loads of the first instant and the tensioner's full pull, which then has no ramp. The
        sprockets' speeds are those of the laid start. `rest` says how well the chain rests.

    Attributes
    ----------
    rest : dict, optional
        Of a static start: ``residual``, the largest unbalanced force [N], ``largest_force`` of a
        contact [N], and ``iterations``.

    Raises
    ------
    InvalidInput
        A value is out of its range, or nothing holds a load at rest.

    Warns
    -----
    RangeWarning
        A contact has left the range of its law.
    """

    rest: dict[str, float] | None = None

    def __new__(cls, drive: object = None, *_: object, **keywords: Any) -> Simulation:  # noqa: ANN401
        """Return the simulation that suits what is given."""
        if isinstance(drive, Mechanism):
            from rustchain.mechanism_simulation import MechanismSimulation

            return MechanismSimulation(drive, **keywords)  # type: ignore[return-value]
        return super().__new__(cls)

    def __init__(
        self,
        drive: ChainDrive,
        force_law: ForceLaw = _LAW,
        hinge_law: ForceLaw | None = None,
        tooth_law: ForceLaw | None = None,
        min_approach_speed: float = 1e-3,
        positions: npt.ArrayLike | None = None,
        velocities: npt.ArrayLike | None = None,
        solver: Solver = _SOLVER,
        start: Literal["laid", "static"] = "laid",
        friction: Coulomb | None = None,
        hinge_friction: Coulomb | None = None,
        tooth_friction: Coulomb | None = None,
    ) -> None:
        force_law, hinge_law, tooth_law = with_friction(
            (force_law, hinge_law, tooth_law), friction, hinge_friction, tooth_friction
        )
        if start == "static":
            if positions is not None or velocities is not None:
                msg = "start = 'static': there is no room for positions and velocities of one's own"
                raise InvalidInput(msg)
            drive, found = _at_rest(drive, force_law, hinge_law, tooth_law, min_approach_speed)
            positions, velocities = found.pop("positions"), found.pop("velocities")
            self.rest = found
        elif start != "laid":
            msg = f"start = {start!r}: must be 'laid' or 'static'"
            raise InvalidInput(msg)
        self._describe(drive, force_law, hinge_law, tooth_law, min_approach_speed, solver)
        known = isinstance(drive, ChainDrive)  # the core refuses anything else
        bodies = drive.chain.links + len(drive.sprockets) if known else "bodies"
        self._core: Core = _core_for(drive)(
            drive,
            force_law,
            hinge_law,
            tooth_law,
            min_approach_speed,
            solver,
            _rows("positions", positions, bodies),
            _rows("velocities", velocities, bodies),
        )
        self._warn()

    def __repr__(self) -> str:
        """Return what moves, and the time."""
        return f"<Simulation of {self.drive.name or 'a chain drive'} at t = {self.time:.6g} s>"

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies, in the order of every (bodies, 3) array."""
        return self._core.body_names

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self._core.time

    @property
    def positions(self) -> Array:
        """Present positions [m, m, rad], (bodies, 3)."""
        return self._core.positions

    @property
    def velocities(self) -> Array:
        """Present velocities [m/s, m/s, rad/s], (bodies, 3)."""
        return self._core.velocities

    def state(self) -> dict[str, Any]:
        """Return all that decides how the run goes on, for `set_state`.

        Not in it are wall times. The copy is the caller's own: `copy` and `pickle` take it.

        Returns
        -------
        dict
            To look at:

            - ``time`` [s]; ``positions`` and ``velocities``, (bodies, 3) [m, m, rad], [m/s, m/s,
              rad/s];
            - ``hinge_onset_speed``, (hinges,), and ``tooth_onset_speed``, (bushings, sprockets):
              approach speed at which each live contact began [m/s], 0 without contact;
            - ``tooth_onset_surface``, (bushings, sprockets): where it began, 0 seating curve, 1
              working curve, 2 flat, 3 topping curve;
            - ``parted_hinges`` and ``parted_tooth_pairs`` (sprocket · bushings + bushing): what
              came apart in the last step.

            And ``snapshot``: bytes that hold all of it and all else, to the last bit.
        """
        return self._core.state()

    @known_keywords
    def set_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, to the same bits as the simulation that gave it.

        Counts (steps, evaluations, onsets) go on from those of the state, wall times from those of
        this simulation. The bits are the same where `rustchain.instruction_set` is, or is one of
        "avx2" and "avx512".

        Parameters
        ----------
        state : dict
            What `state` gave, of this simulation or of one with the same drive, laws, solver and
            start.

        Raises
        ------
        InvalidInput
            The state is of another drive, other laws or another solver, or was changed or damaged.
            The simulation is then what it was.
        """
        self._core = _state_file.restored(self._core, state)
        self._warn()

    @known_keywords
    def save_state(self, path: str | Path) -> None:
        """Write the state and what it is of (drive, laws, solver, start) to a file.

        The file is a NumPy archive (.npz); one that is there already is replaced when the new one
        is complete.
        """
        positions, velocities = self._core.start()
        _state_file.write(
            path,
            {
                "drive": self.drive,
                "hinge_law": self.hinge_law,
                "tooth_law": self.tooth_law,
                "solver": self.solver,
                "min_approach_speed": self.min_approach_speed,
                "positions": positions,
                "velocities": velocities,
            },
            self.state(),
        )

    @classmethod
    @known_keywords
    def load_state(cls, path: str | Path) -> Simulation:
        """Return a simulation that goes on from the state in a file, to the same bits.

        Parameters
        ----------
        path : str or Path
            A file that `save_state` wrote.

        Raises
        ------
        InvalidInput
            The file holds no state, or is damaged.

        Warns
        -----
        RangeWarning
            A contact had left the range of its law.
        """
        scene, state = _state_file.read(path)
        scene |= {"force_law": scene["hinge_law"]}
        simulation = cls._around(_core_for(scene["drive"])(**scene), scene)
        simulation._core = _state_file.restored(simulation._core, state)
        simulation._warn()
        return simulation

    @known_keywords
    def evaluate(
        self,
        positions: npt.ArrayLike | None = None,
        velocities: npt.ArrayLike | None = None,
        time: float | None = None,
    ) -> Evaluation:
        """Return accelerations and contacts of a state, without touching the simulation.

        Parameters
        ----------
        positions, velocities : array_like, (bodies, 3), optional
            By default the present ones. With positions given, no contact has a memory.
        time : float, optional
            By default the present one [s].
        """
        return Evaluation(
            **self._core.evaluate(
                _rows("positions", positions, len(self.body_names)),
                _rows("velocities", velocities, len(self.body_names)),
                time,
            )
        )

    @known_keywords
    def step_to(self, t: float) -> None:
        """Go on to exactly `t` [s]."""
        try:
            while not self._core.step_to(t, _WALL_BUDGET):
                pass
        finally:
            self._warn()

    @known_keywords
    def run(
        self,
        duration: float,
        report_step: float = 1e-4,
        record: Sequence[Group] = ("hinges", "teeth", "sprockets"),
        energy: bool = True,
        progress: bool = True,
    ) -> Result:
        """Go on for a while and record.

        Parameters
        ----------
        duration : float
            Simulated time from now on [s].
        report_step : float
            Time between two rows of the result [s].
        record : sequence of {"hinges", "teeth", "sprockets", "bodies", "energy"}
            What to record.
        energy : bool
            Whether to keep the energy balance, whatever `record` says.
        progress : bool
            Whether to show a progress bar, where a terminal is there to show it.

        Returns
        -------
        Result
            After Ctrl-C with status "interrupted" and the rows until then.

        Raises
        ------
        SimulationError
            The run cannot go on; ``error.result`` holds the rows until then.

        Warns
        -----
        EnergyWarning
            With the energy balance kept: at some report more energy was missing than a twentieth of
            that dissipated and a hundredth of that exchanged (dissipated, worked in, moved in and
            out of kinetic and elastic energy). ``result.stats["largest_residual"]`` has the largest
            of all reports [J].
        """
        start = (self.positions, self.velocities)
        before = self._core.stats()
        self._core.start_recording(duration, report_step, *known_groups(record, energy))
        try:
            self._advance(duration, progress)
            return self._result("finished", start, before)
        except KeyboardInterrupt:
            return self._result("interrupted", start, before)
        except SimulationError as error:
            error.result = self._result("failed", start, before, str(error))
            raise
        finally:
            self._core.take_recording()  # whatever else ended the run
            self._warn()

    @classmethod
    def _around(cls, core: Core, scene: Mapping[str, Any]) -> Simulation:
        """Return the simulation of `scene` that `core` is in the middle of."""
        simulation = cls.__new__(cls)
        simulation._core = core
        simulation._describe(**{name: scene[name] for name in _SCENE})
        return simulation

    def _describe(
        self,
        drive: ChainDrive,
        force_law: ForceLaw,
        hinge_law: ForceLaw | None,
        tooth_law: ForceLaw | None,
        min_approach_speed: float,
        solver: Solver,
    ) -> None:
        """Remember what is simulated, and how."""
        self.drive = drive
        self.hinge_law = force_law if hinge_law is None else hinge_law
        self.tooth_law = force_law if tooth_law is None else tooth_law
        self.min_approach_speed = min_approach_speed
        self.solver = solver

    def _result(
        self,
        status: Status,
        start: tuple[Array, Array],
        before: Mapping[str, float],
        failure: str = "",
    ) -> Result:
        """Take the recording, which began at `start` when the statistics stood at `before`."""
        messages = {
            "finished": f"reached t = {self.time:.6g} s",
            "interrupted": f"interrupted at t = {self.time:.6g} s",
            "failed": failure,
        }
        arrays = self._core.take_recording()
        stats = {name: n - before.get(name, 0) for name, n in self._core.stats().items()}
        if (residual := arrays.get("energy_residual")) is not None and residual.size:
            # The rows of a run that failed may end in what is no number.
            stats["largest_residual"] = float(np.nanmax(np.abs(residual), initial=0.0))
        return Result(
            arrays=arrays,
            drive=self.drive,
            hinge_law=self.hinge_law,
            tooth_law=self.tooth_law,
            solver=self.solver,
            min_approach_speed=self.min_approach_speed,
            body_names=tuple(self.body_names),
            initial_positions=start[0],
            initial_velocities=start[1],
            final_positions=self.positions,
            final_velocities=self.velocities,
            status=status,
            message=messages[status],
            stats=stats,
        )

    def _advance(self, duration: float, progress: bool) -> None:
        """Advance to the end of the recording, with a bar of simulated seconds."""
        start = self.time
        with seconds_bar(duration, progress) as bar:
            finished = False
            while not finished:
                finished = self._core.advance(_WALL_BUDGET)
                bar.update(self.time - start - bar.n)

    def _warn(self) -> None:
        """Pass the core's warnings on, as if from the line that called the public method."""
        range_notes, balance_notes = self._core.take_warnings()
        for message in range_notes:
            warnings.warn(message, RangeWarning, stacklevel=4)
        for message in balance_notes:
            warnings.warn(message, EnergyWarning, stacklevel=4)


def _core_for(drive: object) -> type[Core]:
    """Return what runs this drive."""
    if isinstance(drive, ChainDrive) and drive.hinges == "ideal":
        from rustchain._ideal_hinges import IdealHingeCore

        return IdealHingeCore
    return _rustchain.Core


def _at_rest(
    drive: ChainDrive,
    force_law: ForceLaw,
    hinge_law: ForceLaw | None,
    tooth_law: ForceLaw | None,
    min_approach_speed: float,
) -> tuple[ChainDrive, dict[str, Any]]:
    """Return the drive with its tensioner at full pull from the beginning, and its static start."""
    if drive.hinges == "ideal":
        msg = "start = 'static': only for drives with clearance in their hinges"
        raise InvalidInput(msg)
    if drive.tensioner is not None:
        drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.0))
    found = _rustchain.static_start(drive, force_law, hinge_law, tooth_law, min_approach_speed)
    return drive, found


def _rows(name: str, values: npt.ArrayLike | None, bodies: int | str) -> Array | None:
    """Return `values` as the compiled module wants them: (bodies, 3) real numbers."""
    if values is None:
        return None
    try:
        given = np.asarray(values)
        array = np.ascontiguousarray(given, dtype=float) if given.dtype.kind in "iuf" else None
    except ValueError:  # ragged
        given, array = np.empty(0, dtype=object), None
    if array is None or array.ndim != 2:
        shown = reprlib.repr(values) if array is None else f"an array of shape {given.shape}"
        msg = f"{name} = {shown}, {given.dtype}: must be numbers of shape ({bodies}, 3)"
        raise InvalidInput(msg)
    return array


def known_groups(record: Sequence[str], energy: bool) -> tuple[list[str], bool]:
    """Return the groups to record, each of which must exist, and whether to keep the energy."""
    if not isinstance(record, Iterable):
        msg = f"record = {record!r}: must be a sequence of groups: {', '.join(get_args(Group))}"
        raise InvalidInput(msg)
    groups = [record] if isinstance(record, str) else list(record)
    for group in groups:
        if group not in get_args(Group):
            msg = f"record: {group!r} is no group; {suggest(group, get_args(Group))}"
            raise InvalidInput(msg)
    return groups, True if "energy" in groups else energy


def seconds_bar(total: float, progress: bool, description: str | None = None) -> tqdm[NoReturn]:
    """Return a bar of simulated seconds [s]."""
    from tqdm import tqdm

    form = "{l_bar}{bar}| {n:.4f}/{total:.4f} s [{elapsed}<{remaining}, {rate_noinv_fmt}]"
    return tqdm(
        desc=description,
        total=total,
        unit=" s",
        bar_format=form,
        disable=None if progress else True,
    )
