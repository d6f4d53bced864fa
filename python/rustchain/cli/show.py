"""The commands that show a motion: animate, report."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import rustchain as rc
from rustchain.cli.common import (
    INTERRUPTED,
    AsJson,
    Output,
    Quiet,
    Settings,
    clear_errors,
    fail,
    file_to_write,
    scene_file,
    with_options,
)
from rustchain.extras import typer
from rustchain.results.netcdf import ENDINGS
from rustchain.results.superblock import is_hdf5
from rustchain.simulation.run import GROUPS

Source = Annotated[
    str,
    typer.Argument(
        metavar="DRIVE_OR_RESULT",
        help="A result file, such as run.nc; or a drive file, or paper, which is run first.",
    ),
]
Duration = Annotated[
    float | None,
    typer.Option(help="Of a drive, simulated time [s]; 2, where the file has none."),
]


def animate(
    source: Source,
    *,
    duration: Duration = None,
    settings: Settings = None,
    start: Annotated[
        float | None, typer.Option(help="Beginning of the part that is shown [s].")
    ] = None,
    end: Annotated[float | None, typer.Option(help="End of the part that is shown [s].")] = None,
    slow_motion: Annotated[
        float | None,
        typer.Option(help="Seconds shown for one simulated; by default ten seconds in all."),
    ] = None,
    fps: Annotated[float, typer.Option(help="Frames a second.")] = 25.0,
    camera: Annotated[
        str, typer.Option(help="scene, or a body in the middle: sprocket_1, link_6.")
    ] = "scene",
    view: Annotated[float | None, typer.Option(help="Width of the view [m].")] = None,
    forces: Annotated[bool, typer.Option(help="Draw forces as arrows.")] = True,
    width: Annotated[int, typer.Option(help="Width of a frame [pixels].")] = 900,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="File to write: .gif, .mp4 or .html; run.gif of run.nc."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Animate a result, or a drive that is run first: real shapes, forces as arrows."""
    output = Output(as_json, quiet)
    with clear_errors():
        path = file_to_write(out, source, ".gif")

        def check(simulation: rc.Simulation, seconds: float) -> None:
            from rustchain.plot import animation

            options = camera, slow_motion, fps, view, width
            animation.check_options(simulation.body_names, *options)
            animation.check_file(path, fps)
            _check_part(start, end, seconds)

        result = result_of(source, duration, settings, output, check)
        if "bodies" not in result.groups:
            record = ",".join(GROUPS[result.scene.kind])
            fail(
                f"{source}: bodies were not recorded; give the drive file, which is then run, or "
                f"a result of rustchain run --record {record}"
            )
        result.animate(
            path,
            start=start,
            end=end,
            slow_motion=slow_motion,
            fps=fps,
            camera=camera,
            view=view,
            forces=forces,
            width=width,
        )
        output.say(path)
        output.document({"file": path, "status": result.status})
    _leave(source, result)


def report(
    source: Source,
    *,
    duration: Duration = None,
    settings: Settings = None,
    start: Annotated[
        float | None, typer.Option(help="Beginning of the part that is reported [s].")
    ] = None,
    end: Annotated[float | None, typer.Option(help="End of the part that is reported [s].")] = None,
    breaking_load: Annotated[
        float | None,
        typer.Option(help="Of the chain, all strands together [N]; by default the catalogue's."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="File to write, .html; my_drive.html of my_drive.toml."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Report on a result, or a drive that is run first: one page with figures and a player."""
    output = Output(as_json, quiet)
    with clear_errors():
        path = file_to_write(out, source, ".html")

        def check(simulation: rc.Simulation, seconds: float) -> None:
            from rustchain.report.page import check_options

            check_options(path, breaking_load, simulation.scene.kind)
            _check_part(start, end, seconds)

        result = result_of(source, duration, settings, output, check)
        result.report(path, start=start, end=end, breaking_load=breaking_load)
        output.say(path)
        output.document({"file": path, "status": result.status})
    _leave(source, result)


def _check_part(start: float | None, end: float | None, seconds: float) -> None:
    """Refuse a part that has no rows of a run."""
    if start is not None and start > seconds:
        fail(f"--start = {start:g}: the run ends at {seconds:g} s; expected a time before that")
    if end is not None and end < (start or 0.0):
        fail(f"--end = {end:g}: is before the part; expected a time after {start or 0.0:g} s")


def _is_result(source: str) -> bool:
    """Return whether a source is a file of results, by its name, or by its content without one."""
    path = Path(source)
    if path.suffix.lower() in (*ENDINGS, ".toml", ".json") or not path.is_file():
        return path.suffix.lower() in ENDINGS
    return is_hdf5(path)


def _leave(source: str, result: rc.Result) -> None:
    """Leave with the code of Ctrl-C where the command ran the drive and was interrupted."""
    if result.status == "interrupted" and not _is_result(source):
        raise typer.Exit(INTERRUPTED)


def result_of(
    source: str,
    duration: float | None,
    settings: list[str] | None,
    output: Output,
    check: Callable[[rc.Simulation, float], None],
) -> rc.Result:
    """Return the result in a file, or that of a drive's run with all that can be recorded.

    What follows the run is checked before it, with the duration [s].
    """
    if _is_result(source):
        if settings or duration is not None:
            fail(f"{source}: has been run; --set and --duration are for a drive")
        return rc.load_result(source)
    file = scene_file(source, settings)
    run = {"record": GROUPS[file.scene.kind], "energy": True, "progress": output.progress}
    if duration is None:
        run["duration"] = file.run.get("duration", 2.0)
    else:
        file, run["duration"] = with_options(file, ["duration"]), duration
    file = file.changed({}, {}, run)
    simulation = file.simulate()
    check(simulation, float(file.run["duration"]))
    return file.run_simulation(simulation)
