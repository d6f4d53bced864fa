"""The simulation of a scene: start, steps and runs."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy.typing as npt

from rustchain.arguments import plain
from rustchain.description.drive import ChainDrive
from rustchain.description.laws.force import ForceLaw
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene, Start
from rustchain.description.signals import Signal, refuse_functions
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords, named_attributes
from rustchain.results.result import Result
from rustchain.simulation.core import core_of, start_of
from rustchain.simulation.inputs import Quantity, part_of
from rustchain.simulation.pieces import rows_of_a_piece
from rustchain.simulation.present import Present
from rustchain.simulation.recording import Recording
from rustchain.simulation.run import (
    WALL_BUDGET,
    Group,
    check_rows_fit,
    check_truth,
    known_groups,
    numbers_of_a_row,
)
from rustchain.simulation.stop import StopCondition, looks_of
from rustchain.typing import Count, FilePath, Number


@named_attributes
@known_keywords(min_approach_speed="min_impact_velocity")
class Simulation(Present):
    """The simulation of a scene: of a chain drive or a mechanism.

    Parameters
    ----------
    scene : Scene, ChainDrive or Mechanism
        What to simulate, and how; of a drive or a mechanism, the scene is made with the keywords
        below. With a scene, they take the place of its own.
    force_law, hinge_law, tooth_law : ForceLaw, optional
    min_impact_velocity : float, optional
        [m/s]; ``min_approach_speed`` is another name of it.
    solver : Solver, optional
    start : {"generated", "static"}, optional
    positions, velocities : array_like, (bodies, 3), optional
        As in `Scene`.

    Attributes
    ----------
    scene : Scene
        The simulated scene.
    rest : dict, optional
        Of a static start: ``residual``, the largest unbalanced force [N], ``largest_force`` of a
        contact, or of a load or weight of mechanisms where nothing touches [N], and ``iterations``.

    Raises
    ------
    InvalidInput
        A value is out of its range, nothing holds a load at rest, or the joints of a mechanism do
        not go together.

    Warns
    -----
    RangeWarning
        A contact has left the range of its law.
    RustchainWarning
        An input has an implausible size; see `ChainDrive.check` and `Mechanism.check`.

    Examples
    --------
    >>> simulation = rc.Simulation(rc.paper_drive(25.0), force_law=rc.Hertz())
    >>> result = simulation.run(duration=1e-3, progress=False)
    >>> len(result.time), result.status
    (11, 'finished')
    """

    def __init__(
        self,
        scene: Scene | ChainDrive | Mechanism,
        force_law: ForceLaw | None = None,
        *,
        hinge_law: ForceLaw | None = None,
        tooth_law: ForceLaw | None = None,
        min_impact_velocity: float | None = None,
        solver: Solver | None = None,
        start: Start | None = None,
        positions: npt.ArrayLike | None = None,
        velocities: npt.ArrayLike | None = None,
    ) -> None:
        keywords: dict[str, Any] = {
            "force_law": force_law,
            "hinge_law": hinge_law,
            "tooth_law": tooth_law,
            "min_impact_velocity": min_impact_velocity,
            "solver": solver,
            "start": start,
            "positions": positions,
            "velocities": velocities,
        }
        given = {name: value for name, value in keywords.items() if value is not None}
        self.scene = replace(scene, **given) if isinstance(scene, Scene) else Scene(scene, **given)
        place, self.rest = start_of(self.scene)
        self._core = core_of(self.scene, place)
        self._warn()

    @known_keywords
    def step_to(self, t: Number) -> None:
        """Continue to exactly `t` [s].

        The energy balance is not integrated, which makes it the fastest way to advance. There is
        no progress bar; Ctrl-C raises `KeyboardInterrupt`, and the simulation stands at the time
        that it has reached. At most 1e9 s at a time.
        """
        self._check_idle("step_to")
        end = plain(t)
        try:
            while not self._core.step_to(end, WALL_BUDGET):
                pass
        finally:
            self._warn()

    @known_keywords
    def set_speed(self, part: str | Count, speed: Signal) -> None:
        """Set the speed of a sprocket or a driver from now on; its position does not jump.

        For co-simulation, between calls of `step_to`, or in a run's `callback`. The integrator goes
        back to the present time and restarts there. Contacts keep their impact velocity memory, the
        energy balance continues, and `state` includes the change; `scene` is not changed.

        Parameters
        ----------
        part : str or int
            Of drives a sprocket, such as "sprocket_1", or its number from 1; its motion must be a
            `PrescribedSpeed`. Of mechanisms the name of a driver described by its speed.
        speed : float, rows of (time, speed), Table, Spline, Sines or SmoothStep
            [rad/s], or [m/s] of a driver along a line, against the simulation's time. A number is a
            jump of the speed, at which contacts with the teeth have an impact. The bodies that
            joints connect to the driver jump with it, as by an impulse; its work is external work.
            Rows that begin at the present time and speed make a ramp.

        Raises
        ------
        NoSuchPart
            There is no such sprocket or driver.
        InvalidInput
            The part is not driven by a speed, or the table is not valid. Or the chain would be
            faster than 1000 m/s, the limit of descriptions, or other joints do not permit the
            speed.
        """
        self._set("speed", part, speed)

    @known_keywords
    def set_torque(self, part: str | Count, torque: Signal) -> None:
        """Set the torque on a sprocket or a body from now on; see `set_speed`.

        Parameters
        ----------
        part : str or int
            Of drives a sprocket, such as "sprocket_2", or its number from 1; its motion must be an
            `AppliedTorque`, whose curve over speed is still added, or `Free`. Of mechanisms the
            name of a torque, as `Mechanism.add_torque` has it.
        torque : float, rows of (time, torque), Table, Spline, Sines or SmoothStep
            [N m], against the simulation's time.

        Raises
        ------
        NoSuchPart
            There is no such sprocket or torque.
        InvalidInput
            The speed of the sprocket is prescribed, the torque is a curve over speed, the table is
            not valid, or its values exceed the limits of descriptions.
        """
        self._set("torque", part, torque)

    def _set(self, quantity: Quantity, part: str | Count, value: Signal) -> None:
        """Set a speed or a torque from now on."""
        refuse_functions(quantity, value, setter=f"set_{quantity}")
        self._core.set_input(part_of(self.scene.system, part, quantity), quantity, plain(value))

    @known_keywords
    def set_tensioner_force(self, force: Number) -> None:
        """Set the force of the tensioner from now on; see `set_speed`.

        Parameters
        ----------
        force : float
            Force on the sprocket's centre along the direction of the tensioner [N], in place of the
            one that follows from its pretension, whose ramp ends. Spring, damper, stops and ratchet
            act as before.

        Raises
        ------
        InvalidInput
            The drive has no tensioner, or the force is negative or exceeds the limits of
            descriptions.
        """
        tensioner = self.scene.drive.tensioner
        if tensioner is None:
            msg = (
                "set_tensioner_force: the drive has no tensioner; describe one with "
                "ChainDrive.tensioner"
            )
            raise InvalidInput(msg)
        self._core.set_input(tensioner.sprocket, "tensioner_force", plain(force))

    @known_keywords
    def run(
        self,
        duration: Number,
        report_step: Number = 1e-4,
        *,
        record: Sequence[Group] | None = None,
        energy: bool | None = None,
        progress: bool = True,
        stop: StopCondition | Sequence[StopCondition] = (),
        callback: Callable[[Simulation], object] | None = None,
        out: FilePath | None = None,
        memory: str | Count | None = None,
    ) -> Result:
        """Advance the simulation by `duration` and record.

        Parameters
        ----------
        duration : float
            Simulated time from now on [s].
        report_step : float
            Time between two rows of the result [s].
        record : sequence of groups, optional
            What to record: of drives "hinges", "teeth", "sprockets", "bodies" and "energy", by
            default all but the bodies; of mechanisms "bodies", "joints", "contacts" and "energy",
            by default all.
        energy : bool, optional
            False takes the energy balance out of `record`, True puts it in. The energies of a chain
            are integrated along every step, with further evaluations: the published drive then
            takes 1.1 to 1.3 times the time of its steps. Without it there is no `EnergyWarning`;
            the path is the same to the last bit.
        progress : bool
            Whether to show a progress bar. Without a terminal, lines on the standard error tell the
            progress: one in 30 s at most, and one for each hundredth at most.
        stop : StopCondition or sequence of them
            Ends the run, with status "stopped", at the first row at which one holds:
            `HingeForceAbove`, `ToothForceAbove`, `StrandSlack`, `ToothJump`, `TimeReached`; of
            mechanisms `JointForceAbove`, `ContactForceAbove`, `TimeReached`.
        callback : function of the simulation, optional
            Called when a row has been recorded, with the simulation at that time. When it returns
            True, the run stops there. It may read everything and set speeds and torques; it must
            not move the simulation. It does not change the steps.
        out : str or Path, optional
            A netCDF file to which the rows are written during the run, for runs of any length; one
            that is there is replaced when the run begins. Endings are those of `Result.save`.
            Complete blocks of 256 rows are written every two seconds, or when `memory` is full.
            `load_result` reads the file at any time, also when the process was killed. More rows
            than the disc has room for are refused, unless `stop` or `callback` may end the run.
        memory : str or int, optional
            Of a run with `out`, the most memory that rows take [bytes], such as "256 MB", the
            default, or "1 GiB". Numbers and steps do not depend on it.

        Returns
        -------
        Result
            After Ctrl-C with status "interrupted" and the rows until then. With `out`, its arrays
            are read from the file when they are accessed. Ctrl-C while the end of the file is
            written does not change its status, such as "finished".

        Raises
        ------
        SimulationError
            The run cannot continue, or it is too slow. At the mean step size of the last 1e5 steps,
            the rest of the run, at most one second of it, would take more than 1e9 steps.
            ``error.result`` has the rows until then. The same holds for an exception of a callback.
        OSError
            `out` cannot be written: before the first step, or because the disc is full, or another
            run has replaced the file. ``error.result`` has the rows that are in the file.

        Warns
        -----
        EnergyWarning
            With the energy balance kept, once a simulation, when a run ends: its largest residual
            at a report is more than 5 % of the energy dissipated. Where less than a hundredth of
            the energy exchanged, or 2e-4 of the kinetic and elastic energy, was dissipated, that
            value is the reference. Energy exchanged is the largest of the energy dissipated, the
            external work, and the changes of kinetic, gravitational and elastic energy. With
            regions="sharp" no accuracy helps. A drive at rest, whose links move by no more than
            three times the permitted error of speeds, is not checked.
            ``result.stats["largest_residual"]`` has the largest residual [J].
        ToothJumpWarning
            The chain has jumped teeth: how many, and the first; see `Result.tooth_jumps`.
        """
        self._check_idle("run")
        groups, energy = known_groups(self.scene, record, energy)
        looks = looks_of(self, stop, callback, groups)
        check_truth("progress", progress)
        seconds, step = plain(duration), plain(report_step)
        numbers = numbers_of_a_row(self, groups, energy)
        # A run with conditions may end long before its duration, which is then only a bound. Its
        # rows are kept if it fills the disc.
        if out is None or not looks:
            check_rows_fit(seconds, step, numbers, out)
        piece = rows_of_a_piece(out, memory, numbers)
        recording = Recording(self, (self.positions, self.velocities), self._core.stats())
        self._core.start_recording(seconds, step, groups, energy)
        self._runner = threading.get_ident()
        try:
            if out is not None:
                rows = int(seconds / step) + 2  # a chunk takes its whole size in the file
                recording.stream_to(out, piece._replace(chunk=min(piece.chunk, rows)))
            return recording.run(seconds, progress, looks)
        finally:
            self._runner = None
            self._core.take_recording()  # whatever else ended the run
            self._warn()

    def _slice(self) -> bool:
        """Go on with the recording for a moment of wall time; return whether its end is reached."""
        return self._core.advance(WALL_BUDGET)
