"""A drive, how it is simulated and for how long: what a drive file describes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rustchain.description.drive import ChainDrive
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords
from rustchain.paths import path_of
from rustchain.results.result import Result
from rustchain.simulation.simulation import Simulation

if TYPE_CHECKING:
    from rustchain.files.source import Source


@dataclass(frozen=True)
class Scene:
    """What a drive file describes; see `load_scene`.

    Attributes
    ----------
    drive : ChainDrive
        What moves.
    simulation : dict
        Keywords of `Simulation`.
    run : dict
        Keywords of `Simulation.run`.
    out : Path, optional
        Where `rustchain run` writes the result.
    """

    drive: ChainDrive
    simulation: Mapping[str, Any] = field(default_factory=dict)
    run: Mapping[str, Any] = field(default_factory=dict)
    out: Path | None = None
    _source: Source | None = field(default=None, repr=False, compare=False)

    def simulate(self) -> Simulation:
        """Return the simulation, at its start."""
        with self._errors_located("simulation"):
            return Simulation(self.drive, **self.simulation)

    def run_simulation(self, simulation: Simulation) -> Result:
        """Run a simulation for as long as the scene says, and record.

        Raises
        ------
        InvalidInput
            The scene has no duration, or an argument of the run is refused.
        """
        with self._errors_located("run"):
            self._check_duration()
            return simulation.run(**self.run)

    def check_run(self, simulation: Simulation) -> None:
        """Refuse what `run_simulation` would refuse: the run is made as far as its first row."""
        once = {"progress": False, "callback": lambda _: True}
        with self._errors_located("run"):
            self._check_duration()
            simulation.run(**{**self.run, **once})

    def changed(
        self, simulation: Mapping[str, Any], solver: Mapping[str, Any], run: Mapping[str, Any]
    ) -> Scene:
        """Return the scene with other keywords, and other fields of the solver."""
        keywords = {**self.simulation, **simulation}
        if solver:
            keywords["solver"] = replace(keywords.get("solver", Solver()), **solver)
        return replace(self, simulation=keywords, run={**self.run, **run})

    def _check_duration(self) -> None:
        """Refuse a run without an end."""
        if "duration" not in self.run:
            msg = (
                "duration: is missing; expected a time in s; write it in [run], or add it with "
                'scene.changed({}, {}, {"duration": ...})'
            )
            raise InvalidInput(msg)

    @contextmanager
    def _errors_located(self, section: str) -> Iterator[None]:
        """Say of what is refused where in the file it stands."""
        try:
            yield
        except InvalidInput as error:
            if self._source is None or hasattr(error, "result"):
                raise
            raise self._source.refusal((section,), str(error)) from error


@known_keywords
def load_scene(path: str | Path) -> Scene:
    """Read a drive file: a drive, how it is simulated, and for how long.

    The file is TOML with tables ``drive``, ``simulation`` and ``run``; docs/files.md has every key.
    Units are SI, and paths in it are relative to the file.

    Parameters
    ----------
    path : str or Path
        The file.

    Raises
    ------
    InvalidInput
        The file is no TOML, has a key that means nothing or lacks one, or a value is refused: with
        the file, the line, the key, the value and what is allowed.
    """
    from rustchain.files.reader import read  # with pydantic, which nothing else needs

    source, found = read(path_of(path))
    run = dict(found["run"])
    return Scene(found["drive"], found["simulation"], run, run.pop("out", None), source)
