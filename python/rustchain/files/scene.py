"""Scenes in files: a drive or mechanism, how it is simulated, and for how long."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rustchain.arguments import admitted, shown
from rustchain.description.scene import Scene, scene_of
from rustchain.errors import InvalidInput
from rustchain.files.reader import read
from rustchain.files.source import Source
from rustchain.files.writer import text_of_scene
from rustchain.names import known_keywords
from rustchain.paths import path_of, shown_path, write_whole
from rustchain.results.result import Result
from rustchain.simulation.pieces import DEFAULT, bytes_of
from rustchain.simulation.simulation import Simulation
from rustchain.sweeps.axes import RUN_FIELDS, case_of, check_names
from rustchain.typing import FilePath

if TYPE_CHECKING:
    from rustchain.description.mechanism.report import MechanismReport
    from rustchain.description.report import DriveReport

# Of descriptions that a whole drive is needed to refuse, by the beginning of the message.
_TABLES = {"Tensioner": ("drive", "tensioner"), "Chain": ("drive", "chain")}
_FORMS = (".toml", ".json")


@dataclass(frozen=True)
class SceneFile:
    """The content of a file: a scene, and how it is run.

    Attributes
    ----------
    scene : Scene
        What is simulated.
    run : dict
        Keywords of `Simulation.run`.
    out : Path, optional
        Where `rustchain run` writes the result.
    memory : str or int, optional
        How much memory its rows then take.
    options : dict
        What gave the values that do not stand in the file: options of a command by the argument.
    """

    scene: Scene
    run: Mapping[str, Any] = field(default_factory=dict)
    out: Path | None = None
    memory: str | int | None = None
    options: Mapping[str, str] = field(default_factory=dict)
    _source: Source | None = field(default=None, repr=False, compare=False)

    @classmethod
    def read(cls, path: FilePath) -> SceneFile:
        """Read a file; parameters and errors are those of `load_scene`."""
        source, found = read(path_of(path))
        run = dict(found["run"])
        out = run.pop("out", None)
        return cls(found["scene"], run, out, run.pop("memory", None), _source=source)

    def check(self) -> DriveReport | MechanismReport:
        """Return the report of the drive or mechanism; errors have their place in the file."""
        with self._errors_located("drive" if self.scene.kind != "mechanism" else "mechanism"):
            return self.scene.check()

    def simulate(self) -> Simulation:
        """Return the simulation, at its start."""
        with self._errors_located("simulation"):
            return Simulation(self.scene)

    def run_simulation(self, simulation: Simulation, out: Path | None = None) -> Result:
        """Run a simulation for the duration of the file, and record, in memory or in a file `out`.

        Raises
        ------
        InvalidInput
            The file has no duration, or an argument of the run is refused.
        """
        with self._errors_located("run"):
            self._check_duration()
            return simulation.run(**self.run, out=out, memory=None if out is None else self.memory)

    def check_run(self, simulation: Simulation) -> None:
        """Refuse what `run_simulation` would refuse: the run is made as far as its first row."""
        once = {"progress": False, "callback": lambda _: True}
        with self._errors_located("run"):
            self._check_duration()
            bytes_of(DEFAULT if self.memory is None else self.memory)
            simulation.run(**{**self.run, **once})

    def changed(
        self, scene: Mapping[str, Any], solver: Mapping[str, Any], run: Mapping[str, Any]
    ) -> SceneFile:
        """Return the content with other fields of the scene and of its solver, and of the run."""
        made = replace(self.scene, **scene)
        made = replace(made, solver=replace(made.solver, **solver))
        return replace(self, scene=made, run={**self.run, **run})

    def with_parameters(self, parameters: Mapping[str, Any], where: str) -> SceneFile:
        """Return the content with other values of parameters, by the names that `sweep` has.

        `where` begins the message of a name that means nothing.
        """
        run = {name: self.run.get(name) for name in RUN_FIELDS}
        check_names(self.scene, run, [dict(parameters)], where)
        scene, run = case_of(self.scene, run, dict(parameters))
        given = {name: value for name, value in run.items() if value is not None}
        options = {**self.options, **{name: f"{where} {name}" for name in parameters}}
        return replace(self, scene=scene, run={**self.run, **given}, options=options)

    def refused_option(self, error: InvalidInput) -> InvalidInput | None:
        """Return an error with the option that gave the value; None where no option did."""
        text = str(error)
        where = text.partition(" ")[0].rstrip(":")
        name = where.rpartition(".")[2]
        if name not in self.options:
            return None
        return InvalidInput(f"{self.options[name]}{text.removeprefix(where)}")

    def _check_duration(self) -> None:
        """Refuse a run without an end."""
        if "duration" not in self.run:
            msg = "duration: is missing; expected a time in s; write it in [run]"
            raise InvalidInput(msg)

    @contextmanager
    def _errors_located(self, section: str) -> Iterator[None]:
        """Add the option or the place in the file to errors."""
        try:
            yield
        except InvalidInput as error:
            if hasattr(error, "result"):
                raise
            if (refused := self.refused_option(error)) is not None:
                raise refused from error
            if self._source is None:
                raise
            key = _TABLES.get(str(error).partition(".")[0], (section,))
            raise self._source.refusal(key, str(error)) from error


@known_keywords
def load_scene(path: FilePath) -> Scene:
    """Read the scene in a file: a drive or a mechanism, its laws, its solver and its start.

    The file is TOML, or JSON where its name ends in ``.json``, with tables ``drive`` or
    ``mechanism``, ``simulation`` and ``run``; docs/reference/files.md has every key. Units
    are SI, and paths in it are relative to the file. ``run`` is what the command
    ``rustchain run`` does with it.

    Parameters
    ----------
    path : str or Path
        The file.

    Raises
    ------
    InvalidInput
        The file is not TOML or JSON, has an unknown key or lacks one, or a value is refused. The
        message has the file, the line, the key, the value and the permitted values.
    OSError
        The file cannot be read; `FileNotFoundError` where there is none.

    Examples
    --------
    >>> rc.save_scene(rc.Scene(rc.paper_drive()), "drive.toml")
    >>> rc.load_scene("drive.toml").kind
    'drive'
    """
    return SceneFile.read(path).scene


@known_keywords
def save_scene(scene: Scene, path: FilePath) -> None:
    """Write a scene to a file, for `load_scene`, which gives an equal one.

    Parameters
    ----------
    scene : Scene, ChainDrive or Mechanism
        The scene; of a drive or a mechanism, that with default laws.
    path : str or Path
        The file: TOML or JSON by its ending, ``.toml`` or ``.json``.

    Raises
    ------
    InvalidInput
        The ending is another one, or a field has what a file cannot hold, such as a Python
        function: the message names it.
    OSError
        The file cannot be written.

    Examples
    --------
    >>> rc.save_scene(rc.Scene(rc.paper_drive(25.0)), "drive.toml")
    >>> rc.load_scene("drive.toml").drive == rc.paper_drive(25.0)
    True
    """
    where = path_of(path)
    form = where.suffix.lower()
    if form not in _FORMS:
        msg = f"path = {shown_path(where)}: expected a name that ends in .toml or .json"
        raise InvalidInput(msg)
    made = admitted("scene", scene_of(scene), Scene)
    try:
        content = text_of_scene(made, form).encode()
    except UnicodeEncodeError as error:
        broken = shown(error.object[error.start : error.end])
        msg = f"scene: has a text with {broken}; expected text without lone surrogates; remove it"
        raise InvalidInput(msg) from error
    write_whole(path, memoryview(content))
