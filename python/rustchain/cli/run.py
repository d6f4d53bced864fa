"""The commands that look at one drive: run, check."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import rustchain as rc
from rustchain.cli.common import (
    INTERRUPTED,
    LAWS,
    AsJson,
    Drive,
    Output,
    Quiet,
    Settings,
    check_file,
    clear_errors,
    law_named,
    make_room,
    scene_file,
    with_options,
)
from rustchain.extras import typer
from rustchain.names import counted
from rustchain.results.netcdf import result_path


def run(
    drive: Drive,
    *,
    duration: Annotated[
        float | None, typer.Option(help="Simulated time [s]; 2, where the file has none.")
    ] = None,
    pretension: Annotated[
        float | None, typer.Option(help="Tension given to each strand [N]; 0: no tensioner.")
    ] = None,
    law: Annotated[
        str | None,
        typer.Option(
            help=f"Force law of every contact: {', '.join(LAWS)}.",
            autocompletion=lambda incomplete: [law for law in LAWS if law.startswith(incomplete)],
        ),
    ] = None,
    method: Annotated[
        str | None, typer.Option(help="Integration method: auto, pece or newton.")
    ] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Error a step is allowed [m]; 1e-10 by default.")
    ] = None,
    rtol: Annotated[
        float | None, typer.Option(help="Relative tolerance, in place of accuracy.")
    ] = None,
    atol: Annotated[
        float | None, typer.Option(help="Absolute tolerance, in place of accuracy.")
    ] = None,
    max_step: Annotated[
        float | None, typer.Option(help="Largest step [s]; 1e-4 by default.")
    ] = None,
    report_step: Annotated[
        float | None, typer.Option(help="Time between two rows [s]; 1e-4 by default.")
    ] = None,
    record: Annotated[
        str | None, typer.Option(help="What to record, of hinges,teeth,sprockets,bodies,energy.")
    ] = None,
    energy: Annotated[
        bool | None,
        typer.Option(help="Keep the energy balance; a run is 1.1 to 1.3 times faster without."),
    ] = None,
    settings: Settings = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            help="File to write (netCDF); by default that of the file, or my_drive.nc of "
            "my_drive.toml.",
        ),
    ] = None,
    memory: Annotated[
        str | None, typer.Option(help="Most memory that rows take; 256 MB by default.")
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Run a drive and write its rows to a file while it runs. Ctrl-C keeps what is there.

    Options given here replace the values of a drive file.
    """
    output = Output(as_json, quiet)
    with clear_errors():
        if pretension is not None:
            settings = [f"pretension={pretension!r}", *(settings or ())]
        scene = scene_file(drive, settings)
        # Of every contact, whatever laws a file has for some.
        laws = ("force_law", "hinge_law", "tooth_law")
        simulation = (
            {} if law is None else dict(zip(laws, (law_named(law), None, None), strict=True))
        )
        solver = _given({"method": method, "max_step": max_step, "accuracy": accuracy})
        if any(tolerance is not None for tolerance in (accuracy, rtol, atol)):
            # One kind of tolerance takes the place of the other.
            solver |= {"rtol": rtol, "atol": atol}
        groups = None if record is None else [group.strip() for group in record.split(",")]
        reports = _given(
            {"duration": duration, "report_step": report_step, "record": groups, "energy": energy}
        )
        scene = with_options(scene, [*reports, *_given({"memory": memory})])
        defaults = {"duration": 2.0, **scene.run, "progress": output.progress}
        scene = scene.changed(simulation, solver, defaults | reports)
        scene = scene if memory is None else replace(scene, memory=memory)
        path = out or scene.out or Path(f"{Path(drive).stem}.nc")
        _check_netcdf(path)
        make_room(path)
        was_there = path.exists()
        try:
            result = scene.run_simulation(scene.simulate(), path)
        except (rc.SimulationError, OSError) as error:
            found: rc.Result | None = getattr(error, "result", None)
            if found is not None and len(found.time):
                _tell(found, path, output, was_there)
            raise
        _tell(result, path, output, was_there)
    if result.status == "interrupted":
        raise typer.Exit(INTERRUPTED)


def check(
    drive: Drive, settings: Settings = None, as_json: AsJson = False, quiet: Quiet = False
) -> None:
    """Print the initial configuration of a drive and its warnings; nothing is run."""
    output = Output(as_json, quiet)
    with clear_errors():
        scene = scene_file(drive, settings)
        scene = scene.changed({}, {}, {"duration": scene.run.get("duration", 2.0)})
        report = scene.check()
        output.say(report)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            simulation = scene.simulate()
        # Those of the drive are in the report; the others are of force laws.
        told = [str(each.message) for each in caught]
        told = [text for text in told if text not in report.warnings]
        for text in told:
            output.say(f"warning: {text}")
        for text in (*report.warnings, *told) if quiet and not as_json else ():
            typer.echo(f"warning: {text}", err=True)
        scene.check_run(simulation)
        if scene.out is not None:
            _check_netcdf(scene.out)
        bodies, seconds = simulation.body_names, scene.run["duration"]
        output.say(f"ready to run: {counted(len(bodies), 'bodies')}, {seconds:g} s")
        rows = {n: each for n, each in vars(report).items() if n not in ("drive", "mechanism")}
        rows["warnings"] = [*report.warnings, *told]
        output.document({"report": rows, "bodies": bodies, "duration": seconds})


def _given(options: dict[str, Any]) -> dict[str, Any]:
    """Return the options that were given."""
    return {name: value for name, value in options.items() if value is not None}


def _check_netcdf(path: Path) -> None:
    """Refuse what is no file of results by its name."""
    check_file(path, "run.nc")
    result_path(path, "out")


def _tell(result: rc.Result, out: Path, output: Output, replaced: bool) -> None:
    """Print what a run did and the path of its file."""
    stats, span = result.stats, result.time[-1] - result.time[0]
    wall = sum(seconds for name, seconds in stats.items() if name.startswith("wall_"))
    output.say(
        f"{stats['steps']} steps, {stats['rejected']} rejected, "
        f"{stats['evaluations']} evaluations, {stats['onsets']} contact onsets, {wall:.1f} s"
        + (f" ({wall / span:.2f} s for each simulated second)" if span > 0.0 else "")
    )
    balance = {}
    if "energy" in result.groups:
        energy = result.energy
        # Zero without a sign.
        balance = {"dissipated": energy.dissipated[-1] + 0.0, "residual": energy.residual[-1] + 0.0}
        share = ""
        if balance["dissipated"] > 0.0:
            share = f" ({100.0 * abs(balance['residual']) / balance['dissipated']:.2g} %)"
        output.say(
            f"energy: {balance['dissipated']:.3e} J dissipated, "
            f"{balance['residual']:.1e} J{share} energy balance residual"
        )
    output.say(f"{result.message}: {counted(len(result.time), 'rows')} in {out}")
    if replaced:
        output.say(f"{out}: was there and has been replaced")
    output.document(
        {
            "status": result.status,
            "message": result.message,
            "file": out,
            "rows": len(result.time),
            "time": result.time[-1],
            "stats": stats,
            "energy": balance,
        }
    )
