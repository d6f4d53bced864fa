"""Shared parts of the commands: the drive and its settings, output, errors and exit codes."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, NoReturn, TextIO

import numpy as np

import rustchain as rc
from rustchain.extras import typer
from rustchain.files.reader import value_of_text
from rustchain.files.scene import SceneFile
from rustchain.names import suggest
from rustchain.paths import check_writable, path_of, reason
from rustchain.sweeps.axes import parameter_names

FAILED_CASES = 3
INTERRUPTED = 130  # what a shell reports after Ctrl-C


def _complete_setting(incomplete: str) -> list[str]:
    """Return the settings that begin so, for the shell."""
    found = [f"{name}=" for name in parameter_names() if name.startswith(incomplete)]
    dots = incomplete.count(".")
    near = [name for name in found if name.count(".") <= dots]
    heads = {".".join(name.split(".")[: dots + 1]) for name in found if name not in near}
    return near + sorted(f"{head}." for head in heads)


def _complete_drive(incomplete: str) -> list[str]:
    """Return the drives and files that begin so, for the shell."""
    folder = Path(incomplete) if incomplete.endswith("/") else Path(incomplete).parent
    try:
        found = [str(each) for each in folder.iterdir() if each.is_dir() or each.suffix in _FORMS]
    except OSError:
        found = []
    return [name for name in ("paper", *sorted(found)) if name.startswith(incomplete)]


_FORMS = (".toml", ".json")

Drive = Annotated[
    str,
    typer.Argument(
        help="A drive file, such as my_drive.toml; or paper, the published drive.",
        autocompletion=_complete_drive,
    ),
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a field, as often as given: pretension=25, chain.material.restitution=0.5, "
        "sprockets.2.motion={torque=-3}, start=static, chain='ISO 08B', force_law=Hertz, "
        "force_law={type='Linear', stiffness=1e7}; values as in TOML; text needs no quotes.",
        autocompletion=_complete_setting,
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document in place of text.")]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors; no bar.")
]


@dataclass(frozen=True)
class Output:
    """Output of a command: text during the command, or one JSON document at its end."""

    json: bool
    quiet: bool

    def say(self, text: object) -> None:
        """Print a line of text."""
        if not (self.json or self.quiet):
            printed(text)

    def document(self, content: Mapping[str, Any]) -> None:
        """Print the document if JSON is requested."""
        if self.json:
            printed(json.dumps(_plain(content), indent=2, ensure_ascii=False))

    @property
    def progress(self) -> bool:
        """Return whether progress is shown: a bar, or lines where there is no terminal."""
        return not self.quiet


def printed(text: object) -> None:
    """Print a line on the standard output; nothing where its reader has ended, as head does."""
    try:
        typer.echo(text)
    except OSError as error:
        msg = unwritten(error)
        if not isinstance(error, BrokenPipeError):
            raise type(error)(msg) from error


def unwritten(error: OSError) -> str:
    """Return the message on a standard output that cannot be written, and end the output."""
    # What is in its buffer would fail at the exit, too.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return f"the standard output cannot be written ({reason(error)}); write it elsewhere"


def _plain(value: Any) -> Any:  # noqa: ANN401
    """Return a value as JSON has it; what is no finite number is null."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return value if isinstance(value, bool | int | str | None) else str(value)


def scene_file(drive: str, settings: Sequence[str] | None) -> SceneFile:
    """Return what a drive file, or the name of a drive, stands for, with other settings."""
    return with_settings(_scene_file(drive), settings)


def _scene_file(drive: str) -> SceneFile:
    if drive == "paper":
        return SceneFile(rc.Scene(rc.paper_drive()))
    path = Path(drive)
    if not path.exists():
        hint = suggest(drive, ["paper"])
        if hint.startswith("known"):
            hint = "give the path of a drive file, or paper"
        fail(f"drive = {drive!r}: is no file, and no drive; {hint}")
    return SceneFile.read(path)


def with_settings(file: SceneFile, settings: Sequence[str] | None) -> SceneFile:
    """Return the content of a file with the fields that ``--set`` changes."""
    parameters: dict[str, Any] = {}
    for setting in settings or ():
        name, value = named_value("--set", setting)
        if name in parameters:
            misuse(f"--set: {name!r} is there twice; give it once")
        parameters[name] = value
    return file.with_parameters(parameters, "--set") if parameters else file


def with_options(file: SceneFile, names: Iterable[str]) -> SceneFile:
    """Return the content of a file whose arguments of these names are values of options."""
    options = {name: f"--{name.replace('_', '-')}" for name in names}
    return replace(file, options={**file.options, **options})


def named_value(option: str, text: str) -> tuple[str, Any]:
    """Return name and value of ``name=value``."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        misuse(f"{option} {text}: is no setting; expected name=value, such as pretension=25")
    name = name.strip()
    return name, value_of_text(option, name, value.strip())


LAWS: dict[str, rc.ForceLaw] = {
    "lankarani-nikravesh": rc.LankaraniNikravesh(),
    "enhanced-cylinder": rc.EnhancedCylinder(),
    "enhanced-cylinder-2015": rc.EnhancedCylinder(coefficients="2015"),
    "johnson": rc.Johnson(),
    "hertz": rc.Hertz(),
    "hertz-cylinder": rc.HertzCylinder(),
    "radzimovsky": rc.Radzimovsky(),
    "esdu-78035": rc.Esdu78035(),
    "liu-conformal": rc.LiuConformal(),
}
"""The force laws by their names on the command line, each with its own default damping."""


def law_named(name: str) -> rc.ForceLaw:
    """Return the law of a name on the command line, or end as for a wrong command line."""
    if name not in LAWS:
        misuse(f"--law: {name!r} is no law; {suggest(name, LAWS)}")
    return LAWS[name]


def file_to_write(out: Path | None, source: str, ending: str) -> Path:
    """Return the file to write, by default named after the source; make its folder."""
    default = Path(f"{Path(source).stem}{ending}")
    path = out or default
    check_file(path, default.name)
    make_room(path)
    return path


def make_room(path: Path) -> None:
    """Make the folder of a file and see that it can be written, before anything runs."""
    make_folder(path.parent)
    check_writable(path, "out")


def make_folder(path: Path) -> None:
    """Make a folder for what is written."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = "there is a file of that name" if path.exists() else error.strerror
        raise OSError(f"out: the folder {path} cannot be made ({why}): name another") from error


def check_file(path: Path, example: str) -> None:
    """Refuse a folder as a file to write."""
    path_of(path, "out")
    if os.path.isdir(path):  # noqa: PTH112, Path.is_dir raises for a name that is too long
        msg = f"out = {path}: is a folder; name a file in it, such as {path / example}"
        raise rc.InvalidInput(msg)


def fail(message: object) -> NoReturn:
    """End with a message, not a traceback."""
    typer.echo(f"error: {message}", err=True)
    raise typer.Exit(1)


def misuse(message: object) -> NoReturn:
    """End as for a wrong command line, whatever the files hold."""
    typer.echo(f"error: {message}", err=True)
    raise typer.Exit(2)


@contextmanager
def clear_errors() -> Iterator[None]:
    """Print errors and warnings in one line each."""

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        typer.echo(f"warning: {message}", err=True)

    with warnings.catch_warnings():
        warnings.showwarning = show
        warnings.simplefilter("ignore", rc.CaseWarning)  # failed cases are told one by one
        try:
            yield
        except (ValueError, LookupError, OSError, rc.RustchainError) as error:
            fail(error)
