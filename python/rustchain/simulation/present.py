"""The present state of a simulation: read, evaluated, saved and set."""

from __future__ import annotations

import copyreg
import threading
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from rustchain import _rustchain
from rustchain.arguments import plain, rows_of
from rustchain.caller import warn_caller
from rustchain.description.mechanism.report import MechanismReport
from rustchain.description.report import DriveReport
from rustchain.description.scene import OfScene, Scene
from rustchain.errors import (
    EnergyWarning,
    InvalidInput,
    RangeWarning,
    SimulationError,
    ToothJumpWarning,
)
from rustchain.names import known_keywords
from rustchain.panics import IN_USE
from rustchain.results import state_file
from rustchain.results.values import read_only
from rustchain.simulation.core import core_of, start_of
from rustchain.simulation.evaluation import Evaluation
from rustchain.typing import Array, FilePath, Number

if TYPE_CHECKING:
    from typing_extensions import Self


class _State(dict[str, Any]):
    """A complete state; printed by its names, as its bytes and arrays fill screens."""

    def __repr__(self) -> str:
        return f"<state at t = {self.get('time')} s: {', '.join(self)}>"


class Present(OfScene):
    """A scene at some time of its motion."""

    rest: dict[str, float] | None = None

    _core: _rustchain.Core
    _runner: int | None = None  # the thread of a run that is under way

    def __repr__(self) -> str:
        """Return the scene's name and the time."""
        return f"<Simulation of {self.scene.name} at t = {self.time:.6g} s>"

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies, in the order of every (bodies, 3) array."""
        return self._core.body_names

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints and drivers of a mechanism; none in drives."""
        return self._core.joint_names

    @property
    def contact_names(self) -> list[str]:
        """Names of the contacts of a mechanism; none in drives."""
        return self._core.contact_names

    @property
    def time(self) -> float:
        """Present time [s]."""
        return self._core.time

    @property
    def positions(self) -> Array:
        """Present positions [m, m, rad], (bodies, 3): a read-only copy."""
        positions: Array = read_only(self._core.positions)
        return positions

    @property
    def velocities(self) -> Array:
        """Present velocities [m/s, m/s, rad/s], (bodies, 3): a read-only copy."""
        velocities: Array = read_only(self._core.velocities)
        return velocities

    @property
    def stats(self) -> dict[str, float]:
        """Counts since the simulation began, and wall times [s]; `Result.stats` has those of a run.

        Among them are "steps", "rejected", "evaluations" and "onsets" of contacts.
        """
        return self._core.stats()

    def check(self) -> DriveReport | MechanismReport:
        """Return the report of the drive's layout, or of the mechanism's assembly."""
        return self.scene.check()

    def state(self) -> dict[str, Any]:
        """Return the complete state, for `set_state`.

        Not in it are wall times. The copy is the caller's own: `copy` and `pickle` take it.

        Returns
        -------
        dict
            To look at:

            - ``time`` [s]; ``positions`` and ``velocities``, (bodies, 3) [m, m, rad], [m/s, m/s,
              rad/s];
            - of drives, ``hinge_onset_speed``, (hinges,), and ``tooth_onset_speed``, (bushings,
              sprockets and guides): initial impact velocity of each present contact [m/s], 0
              without contact and in ideal hinges;
            - ``tooth_onset_surface``, (bushings, sprockets and guides): surface of the contact
              onset, numbered from the seat, 0, outward; of ANSI teeth 1 is the working curve, 2 the
              flat, 3 the topping curve;
            - ``ended_hinges`` and ``ended_tooth_pairs`` (sprocket · bushings + bushing): contacts
              that ended in the last step;
            - where rollers are bodies, ``roller_onset_speed``, (rollers,), and ``ended_rollers``,
              of bushings in rollers likewise.

            And ``snapshot``: bytes that hold all of it and all else, to the last bit.
        """
        return _State(self._core.state())

    @known_keywords
    def set_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`, to the same bits as the simulation that gave it.

        Counts (steps, evaluations, onsets) go on from those of the state, wall times from those of
        this simulation. The bits are the same where `rustchain.instruction_set` is. They are the
        same, too, with "avx2", "avx512" and "neon" and the same C library.

        Parameters
        ----------
        state : dict
            What `state` gave, of this simulation or of one with the same scene. Python callables
            of a mechanism are taken to be the same.

        Raises
        ------
        InvalidInput
            The state is of another scene, or was changed or damaged. The simulation is then what
            it was.
        """
        self._check_idle("set_state")
        self._core = state_file.restored(self._core, state)
        self._warn()

    @known_keywords
    def save_state(self, path: FilePath) -> None:
        """Write the state and its scene to a file.

        The file is a NumPy archive (.npz); one that is there already is replaced when the new one
        is complete. Its name ends in ``.npz`` or has no ending. Errors are those of `Result.save`.
        A mechanism with a Python function (`add_callable`) is refused; `state` keeps its state in
        memory.
        """
        state_file.write(path, self.scene, self._core.start(), self.state())

    @classmethod
    @known_keywords
    def load_state(cls, path: FilePath) -> Self:
        """Return a simulation that continues from the state in a file, to the same bits.

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
        scene, place, state = state_file.read(path)
        simulation = cls._continued(scene, place, state)
        simulation._warn()
        return simulation

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy scene, state and a user's attributes; the copy continues to the same bits."""
        place = dict(zip(("positions", "velocities"), self._core.start(), strict=True))
        made = (type(self), self.scene, place, self.state(), self.rest)
        own = ("scene", "_core", "rest", "_runner")
        others = {name: each for name, each in vars(self).items() if name not in own}
        names = copyreg._slotnames(type(self))  # type: ignore[attr-defined]  # as pickle has them
        slots = {name: getattr(self, name) for name in names if hasattr(self, name)}
        return _copied, made, (others, slots) if slots else others

    @known_keywords
    def evaluate(
        self,
        positions: npt.ArrayLike | None = None,
        velocities: npt.ArrayLike | None = None,
        time: Number | None = None,
    ) -> Evaluation:
        """Return accelerations and contacts of a state, without touching the simulation.

        Parameters
        ----------
        positions, velocities : array_like, (bodies, 3), optional
            By default the present ones; those of a mechanism are taken as they are, on the
            constraints or not. With positions given, no contact has a memory.
        time : float, optional
            By default the present one [s].
        """
        bodies = len(self.body_names)
        rows = rows_of("positions", positions, bodies), rows_of("velocities", velocities, bodies)
        return Evaluation(self._core.evaluate(*rows, plain(time)))

    @classmethod
    def _continued(cls, scene: Scene, place: Mapping[str, Any], state: Mapping[str, Any]) -> Self:
        """Return the simulation of a scene that began at `place`, in another state."""
        if scene.kind == "mechanism":  # assembled again; drivers change the described velocities
            place, _ = start_of(scene)
        core = core_of(scene, place)
        return cls._around(state_file.restored(core, state), scene)

    @classmethod
    def _around(cls, core: _rustchain.Core, scene: Scene) -> Self:
        """Return the simulation of `scene` that `core` is in the middle of."""
        simulation = cls.__new__(cls)
        simulation.scene, simulation._core = scene, core
        return simulation

    def _warn(self) -> None:
        """Pass the core's warnings on, as if from the innermost line outside the package."""
        categories = (RangeWarning, EnergyWarning, ToothJumpWarning)
        for category, messages in zip(categories, self._core.take_warnings(), strict=True):
            for message in messages:
                warn_caller(message, category)

    def _check_idle(self, wanted: str) -> None:
        """Raise where a callback or another thread moves a simulation that runs."""
        if self._runner is None:
            return
        if self._runner != threading.get_ident():
            raise SimulationError(IN_USE)
        msg = (
            f"{wanted}: a run is under way; a callback may look at the simulation, but not move it"
        )
        raise InvalidInput(msg)


def _copied(
    kind: type[Present],
    scene: Scene,
    place: Mapping[str, Any],
    state: Mapping[str, Any],
    rest: dict[str, float] | None,
) -> Present:
    """Return the copy of a simulation, without the warnings that the original has given."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        copied = kind._continued(scene, place, state)
        copied._warn()
    copied.rest = rest
    return copied
