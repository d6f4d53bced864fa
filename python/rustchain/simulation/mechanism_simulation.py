"""A mechanism and a solver: the present state, single evaluations and runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import plain, rows_of, shown
from rustchain.caller import warn_caller
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.mechanism.report import MechanismReport
from rustchain.description.solver import Solver
from rustchain.errors import EnergyWarning, InvalidInput, SimulationError
from rustchain.names import known_keywords
from rustchain.results import state_file
from rustchain.results.mechanism_result import MechanismResult
from rustchain.results.result import Status
from rustchain.simulation.mechanism_evaluation import MechanismEvaluation
from rustchain.simulation.mechanism_stop import Look, MechanismStop, looks_of
from rustchain.simulation.run import WALL_BUDGET, check_progress, check_rows_fit, seconds_bar
from rustchain.typing import Array

_SOLVER = Solver(method="pece", rtol=1e-9, atol=1e-9, max_step=0.01)


@known_keywords
class MechanismSimulation:
    """A mechanism in motion, from where it is placed; assembled first.

    Parameters
    ----------
    mechanism : Mechanism
        What moves. Later changes of it have no effect.
    solver : Solver
        Method and tolerances; "newton" is for contacts that are stiff beside the steps.
    baumgarte : float, optional
        Angular frequency [rad/s] of Baumgarte's stabilisation, for comparison; by default positions
        and velocities are projected onto the constraints after each step.

    Raises
    ------
    InvalidInput
        A value is out of its range, or the joints do not go together.

    Warns
    -----
    UserWarning
        Something of the mechanism is worth a second look; see `check`.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        solver: Solver = _SOLVER,
        baumgarte: float | None = None,
    ) -> None:
        if not isinstance(mechanism, Mechanism):
            msg = f"mechanism = {shown(mechanism)}: must be a Mechanism"
            raise InvalidInput(msg)
        self.name = mechanism.name
        self.solver = solver
        self._running = False
        self._core = _rustchain.MechanismCore(mechanism, solver, baumgarte)
        for text in self.check().warnings:
            warn_caller(text)

    def __repr__(self) -> str:
        """Return what moves, and the time."""
        return f"<MechanismSimulation of {self.name or 'a mechanism'} at t = {self.time:.6g} s>"

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies, in the order of every (bodies, 3) array."""
        return self._core.body_names

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints, in the order of every (joints, 3) array."""
        return self._core.joint_names

    @property
    def contact_names(self) -> list[str]:
        """Names of the contacts, in the order of every (contacts,) array."""
        return self._core.contact_names

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

    def check(self) -> MechanismReport:
        """Return what assembling found."""
        return MechanismReport(**self._core.check())

    def state(self) -> dict[str, Any]:
        """Return all that decides how the run goes on, for `set_state`.

        Returns
        -------
        dict
            To look at: ``time`` [s]; ``positions`` and ``velocities``, (bodies, 3) [m, m, rad],
            [m/s, m/s, rad/s]. And ``snapshot``: bytes that hold all of it and all else.
        """
        return self._core.state()

    @known_keywords
    def set_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, to the same bits as the simulation that gave it.

        Parameters
        ----------
        state : dict
            What `state` gave, of this simulation or of one with the same mechanism and solver.
            Python callables are taken to be the same.

        Raises
        ------
        InvalidInput
            The state is of another mechanism or solver, or was changed or damaged. The simulation
            is then what it was.
        """
        self._check_idle("set_state")
        self._core = state_file.restored(self._core, state, "Mechanism whose bodies are placed so")

    @known_keywords
    def evaluate(
        self,
        positions: npt.ArrayLike | None = None,
        velocities: npt.ArrayLike | None = None,
        time: float | None = None,
    ) -> MechanismEvaluation:
        """Return accelerations, reactions and contacts of a state, without touching the simulation.

        Parameters
        ----------
        positions, velocities : array_like, (bodies, 3), optional
            By default the present ones; taken as they are, on the constraints or not. Bodies that
            are held stay where they are. With positions given, no contact has a memory.
        time : float, optional
            By default the present one [s].
        """
        bodies = len(self.body_names)
        rows = rows_of("positions", positions, bodies), rows_of("velocities", velocities, bodies)
        return MechanismEvaluation(**self._core.evaluate(*rows, time))

    @known_keywords
    def step_to(self, t: float) -> None:
        """Go on to exactly `t` [s]; after an error, to where the last step ended that was made."""
        self._check_idle("step_to")
        t = plain(t)
        while not self._core.step_to(t, WALL_BUDGET):
            pass

    @known_keywords
    def run(
        self,
        duration: float,
        report_step: float = 1e-3,
        progress: bool = True,
        stop: MechanismStop | Sequence[MechanismStop] = (),
        callback: Callable[[MechanismSimulation], object] | None = None,
    ) -> MechanismResult:
        """Go on for a while and record everything.

        Parameters
        ----------
        duration : float
            Simulated time from now on [s].
        report_step : float
            Time between two rows of the result [s].
        progress : bool
            Whether to show a progress bar, where a terminal is there to show it.
        stop : JointForceAbove, ContactForceAbove, TimeReached, or a sequence of them
            Ends the run, with status "stopped", at the first row at which one holds.
        callback : function of the simulation, optional
            Called when a row has been recorded, with the simulation at that time. When it returns
            True, the run stops there. It may look at everything; it must not move the simulation.
            It does not change the steps.

        Returns
        -------
        MechanismResult
            After Ctrl-C with status "interrupted" and the rows until then.

        Raises
        ------
        SimulationError
            The run cannot go on; ``error.result`` holds the rows until then, and the simulation is
            where the last step ended that was made. The same holds for what a callable raises.

        Warns
        -----
        EnergyWarning
            The energy balance does not close, once a simulation, when a run ends; by the same rule
            as in `Simulation.run`.
        """
        self._check_idle("run")
        looks = looks_of(self, stop, callback)
        bodies, joints, contacts = self.body_names, self.joint_names, self.contact_names
        numbers = 7 + 9 * len(bodies) + 7 * len(joints) + 9 * len(contacts)
        check_progress(progress)
        duration, report_step = plain(duration), plain(report_step)
        check_rows_fit(duration, report_step, numbers)
        before = self._core.stats()
        self._core.start_recording(duration, report_step)
        self._running = True
        try:
            if (reason := self._advance(duration, progress, looks)) is not None:
                return self._result("stopped", before, reason)
            return self._result("finished", before)
        except KeyboardInterrupt:
            return self._result("interrupted", before)
        except Exception as error:  # what a callable raised, too
            message = str(error) if isinstance(error, SimulationError) else repr(error)
            error.result = self._result("failed", before, message)  # type: ignore[attr-defined]
            raise
        finally:
            self._running = False
            self._core.take_recording()  # whatever else ended the run
            if (text := self._core.take_warnings()) is not None:
                warn_caller(text, EnergyWarning)

    def _advance(self, duration: float, progress: bool, looks: Sequence[Look]) -> str | None:
        """Advance to the end of the recording, or to a row at which to stop: then return why."""
        start, rows = self.time, 0
        if looks:
            self._core.pause_at_reports()
        with seconds_bar(duration, progress) as bar:
            finished = False
            while not finished:
                finished = self._core.advance(WALL_BUDGET)
                bar.update(self.time - start - bar.n)
                if not looks or self._core.rows == rows:
                    continue
                rows = self._core.rows
                reasons = [reason for look in looks if (reason := look()) is not None]
                if reasons:
                    return "; ".join(reasons)
        return None

    def _check_idle(self, wanted: str) -> None:
        """Raise where a callback wants to move the simulation that has called it."""
        if self._running:
            msg = (
                f"{wanted}: a run is under way; a callback may look at the simulation, but not "
                "move it"
            )
            raise InvalidInput(msg)

    def _result(
        self, status: Status, before: Mapping[str, float], reason: str = ""
    ) -> MechanismResult:
        """Take the recording."""
        messages = {
            "finished": f"reached t = {self.time:.6g} s",
            "interrupted": f"interrupted at t = {self.time:.6g} s",
            "stopped": f"stopped at t = {self.time:.6g} s: {reason}",
            "failed": reason,
        }
        return MechanismResult(
            arrays=self._core.take_recording(),
            name=self.name,
            body_names=tuple(self.body_names),
            joint_names=tuple(self.joint_names),
            contact_names=tuple(self.contact_names),
            status=status,
            message=messages[status],
            stats={name: n - before.get(name, 0) for name, n in self._core.stats().items()},
        )
