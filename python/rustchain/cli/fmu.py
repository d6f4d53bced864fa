"""The command that exports a drive for co-simulation: fmu."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import rustchain as rc
from rustchain.cli.common import (
    AsJson,
    Output,
    Quiet,
    Settings,
    clear_errors,
    fail,
    file_to_write,
    misuse,
    scene_file,
)
from rustchain.extras import typer

_STATES = ".npz"


def fmu(
    drive: Annotated[
        str,
        typer.Argument(
            metavar="DRIVE_OR_STATE",
            help="A drive file, such as my_drive.toml; paper, the published drive; or a file of "
            "Simulation.save_state, such as state.npz, to begin with its state.",
        ),
    ],
    fmi: Annotated[str, typer.Option("--fmi", help="Version of the FMI: 2.0 or 3.0.")] = "2.0",
    inputs: Annotated[
        str | None,
        typer.Option(help="Names of the inputs, as sprocket_1.set_speed,...; by default all."),
    ] = None,
    outputs: Annotated[
        str | None,
        typer.Option(help="Names of the outputs, as sprocket_2.speed,...; by default all."),
    ] = None,
    settings: Settings = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="File to write, .fmu; my_drive.fmu of my_drive.toml."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Export a drive as an FMU for co-simulation, which runs without Python."""
    output = Output(as_json, quiet)
    with clear_errors():
        if fmi not in ("2.0", "3.0"):
            misuse(f"--fmi = {fmi}: expected 2.0 or 3.0")
        path = file_to_write(out, drive, ".fmu")
        rc.export_fmu(
            _system(drive, settings),
            path,
            inputs=_names(inputs),
            outputs=_names(outputs),
            version=fmi,  # type: ignore[arg-type]  # it is one of the two
        )
        output.say(path)
        output.document({"file": path, "fmi": fmi})


def _system(drive: str, settings: list[str] | None) -> rc.Scene | rc.Simulation:
    """Return the scene of a drive file, or the simulation in a file of a state."""
    if Path(drive).suffix.lower() != _STATES:
        return scene_file(drive, settings).scene
    if settings:
        fail(f"{drive}: has a state; --set is for a drive")
    return rc.Simulation.load_state(drive)


def _names(text: str | None) -> list[str] | None:
    """Return the names in a list with commas."""
    return None if text is None else [name.strip() for name in text.split(",") if name.strip()]
