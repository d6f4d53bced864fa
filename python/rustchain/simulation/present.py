"""What a simulation is at its present time: looked at, evaluated, taken and set as a state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import rows_of
from rustchain.caller import warn_caller
from rustchain.description.drive import ChainDrive
from rustchain.description.laws.force import ForceLaw
from rustchain.description.solver import Solver
from rustchain.errors import EnergyWarning, RangeWarning, ToothJumpWarning
from rustchain.names import known_keywords
from rustchain.results import state_file
from rustchain.simulation.evaluation import Evaluation
from rustchain.typing import Array

if TYPE_CHECKING:
    from typing import TypeAlias

    from typing_extensions import Self

    Core: TypeAlias = _rustchain.Core | _rustchain.IdealCore

SCENE = ("drive", "force_law", "hinge_law", "tooth_law", "min_impact_velocity", "solver")


class Present:
    """A drive with its laws and solver, somewhere on its way."""

    _core: Core

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
              came apart in the last step;
            - where rollers are bodies, ``roller_onset_speed``, (rollers,), and ``parted_rollers``,
              of bushings in rollers likewise.

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
        self._core = state_file.restored(self._core, state)
        self._warn()

    @known_keywords
    def save_state(self, path: str | Path) -> None:
        """Write the state and what it is of (drive, laws, solver, start) to a file.

        The file is a NumPy archive (.npz); one that is there already is replaced when the new one
        is complete. Parameters and errors are those of `Result.save`.
        """
        positions, velocities = self._core.start()
        state_file.write(
            path,
            {
                "drive": self.drive,
                "hinge_law": self.hinge_law,
                "tooth_law": self.tooth_law,
                "solver": self.solver,
                "min_impact_velocity": self.min_impact_velocity,
                "positions": positions,
                "velocities": velocities,
            },
            self.state(),
        )

    @classmethod
    @known_keywords
    def load_state(cls, path: str | Path) -> Self:
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
        scene, state = state_file.read(path)
        scene |= {"force_law": scene["hinge_law"]}
        simulation = cls._around(core_for(scene["drive"])(**scene), scene)
        simulation._core = state_file.restored(simulation._core, state)
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
                rows_of("positions", positions, len(self.body_names)),
                rows_of("velocities", velocities, len(self.body_names)),
                time,
            )
        )

    @classmethod
    def _around(cls, core: Core, scene: Mapping[str, Any]) -> Self:
        """Return the simulation of `scene` that `core` is in the middle of."""
        simulation = cls.__new__(cls)
        simulation._core = core
        simulation._describe(**{name: scene[name] for name in SCENE})
        return simulation

    def _describe(
        self,
        drive: ChainDrive,
        force_law: ForceLaw,
        hinge_law: ForceLaw | None,
        tooth_law: ForceLaw | None,
        min_impact_velocity: float,
        solver: Solver,
    ) -> None:
        """Remember what is simulated, and how."""
        self.drive = drive
        self.hinge_law = force_law if hinge_law is None else hinge_law
        self.tooth_law = force_law if tooth_law is None else tooth_law
        self.min_impact_velocity = float(min_impact_velocity)  # whatever kind of number
        self.solver = solver

    def _warn(self) -> None:
        """Pass the core's warnings on, as if from the innermost line outside the package."""
        categories = (RangeWarning, EnergyWarning, ToothJumpWarning)
        for category, notes in zip(categories, self._core.take_warnings(), strict=True):
            for message in notes:
                warn_caller(message, category)


def core_for(drive: object) -> Callable[..., Core]:
    """Return what makes the core that runs this drive."""
    if isinstance(drive, ChainDrive) and drive.hinges == "ideal":
        return _ideal_core
    return _rustchain.Core


def _ideal_core(**scene: Any) -> _rustchain.IdealCore:  # noqa: ANN401
    """Return the core of a drive with ideal hinges; warn of links that had to be moved far."""
    core = _rustchain.IdealCore(**scene)
    if (note := core.take_start_note()) is not None:
        warn_caller(note)
    return core
