"""A mechanism and a solver: the present state, single evaluations and runs."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain, _state_file
from rustchain._names import known_keywords
from rustchain._run import WALL_BUDGET, seconds_bar
from rustchain._start import rows_of
from rustchain.errors import EnergyWarning, InvalidInput, SimulationError
from rustchain.mechanism import Mechanism
from rustchain.mechanism_report import MechanismReport
from rustchain.mechanism_result import MechanismResult
from rustchain.result import Array, Status
from rustchain.solver import Solver

_SOLVER = Solver(method="pece", rtol=1e-9, atol=1e-9, max_step=0.01)


@dataclass(frozen=True, eq=False)
class MechanismEvaluation:
    """Accelerations, reactions and contacts of one state.

    Attributes
    ----------
    accelerations : ndarray, (bodies, 3)
        [m/s^2, m/s^2, rad/s^2].
    joint_reaction : ndarray, (joints, 3)
        Force and torque on body b about the joint's point [N, N, N m].
    contact_force, contact_penetration : ndarray, (contacts,)
        [N] and [m].
    contact_force_vector : ndarray, (contacts, 2)
        Force on the circle [N].
    contact_gap, contact_region : ndarray of int, (contacts,)
        Of circles near teeth the gap, from 0 (-1: none), and its region, counted from 1 along its
        outline (0: none; an ANSI gap has seven).
    """

    accelerations: Array
    joint_reaction: Array
    contact_force: Array
    contact_penetration: Array
    contact_force_vector: Array
    contact_gap: npt.NDArray[np.int32]
    contact_region: npt.NDArray[np.int32]


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
            msg = f"mechanism = {mechanism!r}: must be a Mechanism"
            raise InvalidInput(msg)
        self.name = mechanism.name
        self.solver = solver
        self._core = _rustchain.MechanismCore(mechanism, solver, baumgarte)
        for text in self.check().warnings:
            warnings.warn(text, stacklevel=3)

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
        self._core = _state_file.restored(self._core, state)

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
        while not self._core.step_to(t, WALL_BUDGET):
            pass

    @known_keywords
    def run(
        self, duration: float, report_step: float = 1e-3, progress: bool = True
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
            More energy is missing at a row than the tolerances should leave: once a simulation.
        """
        before = self._core.stats()
        start = self.time
        self._core.start_recording(duration, report_step)
        try:
            with seconds_bar(duration, progress) as bar:
                finished = False
                while not finished:
                    finished = self._core.advance(WALL_BUDGET)
                    bar.update(self.time - start - bar.n)
            return self._result("finished", before)
        except KeyboardInterrupt:
            return self._result("interrupted", before)
        except Exception as error:  # what a callable raised, too
            message = str(error) if isinstance(error, SimulationError) else repr(error)
            error.result = self._result("failed", before, message)  # type: ignore[attr-defined]
            raise
        finally:
            self._core.take_recording()  # whatever else ended the run
            if (text := self._core.take_warnings()) is not None:
                warnings.warn(text, EnergyWarning, stacklevel=3)

    def _result(
        self, status: Status, before: Mapping[str, float], failure: str = ""
    ) -> MechanismResult:
        """Take the recording."""
        messages = {
            "finished": f"reached t = {self.time:.6g} s",
            "interrupted": f"interrupted at t = {self.time:.6g} s",
            "failed": failure,
        }
        return MechanismResult(
            arrays=self._core.take_recording(),
            name=self.name,
            body_names=tuple(self.body_names),
            joint_names=tuple(self.joint_names),
            contact_names=tuple(self._core.contact_names),
            status=status,
            message=messages[status],
            stats={name: n - before.get(name, 0) for name, n in self._core.stats().items()},
        )
