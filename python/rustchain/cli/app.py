"""The command `rustchain`: check and run drives, draw figures, list the chains."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TextIO

import rustchain as rc
from rustchain.extras import typer
from rustchain.files.scene import SceneFile
from rustchain.names import suggest
from rustchain.paths import check_writable, path_of, write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # it would take the units in brackets for markup
)

_INTERRUPTED = 130  # what a shell reports after Ctrl-C


class Law(str, Enum):
    """The force laws by their names on the command line."""

    LANKARANI_NIKRAVESH = "lankarani-nikravesh"
    ENHANCED_CYLINDER = "enhanced-cylinder"
    ENHANCED_CYLINDER_2015 = "enhanced-cylinder-2015"
    JOHNSON = "johnson"
    HERTZ = "hertz"
    HERTZ_CYLINDER = "hertz-cylinder"
    RADZIMOVSKY = "radzimovsky"
    ESDU_78035 = "esdu-78035"
    LIU_CONFORMAL = "liu-conformal"

    def value_of(self) -> rc.ForceLaw:
        """Return the law with its own default damping."""
        laws: dict[Law, rc.ForceLaw] = {
            Law.LANKARANI_NIKRAVESH: rc.LankaraniNikravesh(),
            Law.ENHANCED_CYLINDER: rc.EnhancedCylinder(),
            Law.ENHANCED_CYLINDER_2015: rc.EnhancedCylinder(coefficients="2015"),
            Law.JOHNSON: rc.Johnson(),
            Law.HERTZ: rc.Hertz(),
            Law.HERTZ_CYLINDER: rc.HertzCylinder(),
            Law.RADZIMOVSKY: rc.Radzimovsky(),
            Law.ESDU_78035: rc.Esdu78035(),
            Law.LIU_CONFORMAL: rc.LiuConformal(),
        }
        return laws[self]


def _print_version(wanted: bool) -> None:
    """Print the version and leave."""
    if wanted:
        typer.echo(f"rustchain {rc.__version__}")
        raise typer.Exit


@app.callback()
def rustchain(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Simulate chain drives with clearance and compliant contact."""


_NETCDF = ("", ".nc", ".nc4", ".cdf", ".h5", ".hdf5")


_SOME_HINGES = (6, 11)  # those that the published figures show


def _check_file(path: Path) -> None:
    """Refuse what is no file of results by its name."""
    path_of(path, "out")
    if os.path.isdir(path):  # noqa: PTH112, Path.is_dir raises for a name that is too long
        msg = f"out = {path}: is a folder; name a file in it, such as {path / 'run.nc'}"
        raise rc.InvalidInput(msg)
    if path.suffix.lower() not in _NETCDF:
        msg = (
            f"out = {path}: results are written as netCDF; take {path.with_suffix('.nc').name} "
            "(load_result(...).to_pandas() makes tables of it)"
        )
        raise rc.InvalidInput(msg)


def _make_room(path: Path) -> None:
    """Make the folder of a file and see that it can be written, before anything runs."""
    _make_folder(path.parent)
    check_writable(path, "out")


def _make_folder(path: Path) -> None:
    """Make a folder for what is written."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = "there is a file of that name" if path.exists() else error.strerror
        raise OSError(f"out: the folder {path} cannot be made ({reason}): name another") from error


Drive = Annotated[str, typer.Argument(help="A drive file, such as my_drive.toml; or paper.")]


@app.command()
def run(
    drive: Drive,
    duration: Annotated[
        float | None, typer.Option(help="Simulated time [s]; 2, where the file has none.")
    ] = None,
    pretension: Annotated[
        float | None, typer.Option(help="Tension given to each strand of the paper's drive [N].")
    ] = None,
    law: Annotated[Law | None, typer.Option(help="Force law of every contact.")] = None,
    method: Annotated[
        str | None, typer.Option(help="Of integration: auto, pece or newton.")
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
        typer.Option(help="Keep the energy balance; a run is 1.4 to 1.7 times faster without."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="File to write (netCDF); run.nc, where the file has none.")
    ] = None,
) -> None:
    """Run a drive and save what it did. Ctrl-C saves what is there.

    What is given here takes the place of what a drive file says.
    """
    with _clear_errors():
        scene = _scene(drive, pretension)
        # Of every contact, whatever laws a file has for some.
        laws = ("force_law", "hinge_law", "tooth_law")
        simulation = (
            {} if law is None else dict(zip(laws, (law.value_of(), None, None), strict=True))
        )
        solver = _given({"method": method, "max_step": max_step, "accuracy": accuracy})
        if any(tolerance is not None for tolerance in (accuracy, rtol, atol)):
            # One kind of tolerance takes the place of the other.
            solver |= {"rtol": rtol, "atol": atol}
        groups = None if record is None else [group.strip() for group in record.split(",")]
        reports = {
            "duration": scene.run.get("duration", 2.0) if duration is None else duration,
            "report_step": report_step,
            "record": groups,
            "energy": energy,
        }
        scene = scene.changed(simulation, solver, _given(reports))
        path = out or scene.out or Path("run.nc")
        _check_file(path)
        _make_room(path)
        try:
            result = scene.run_simulation(scene.simulate())
        except rc.SimulationError as error:
            if error.result is not None:
                _save(error.result, path)
            raise
        _save(result, path)
    if result.status == "interrupted":
        raise typer.Exit(_INTERRUPTED)


@app.command()
def check(drive: Drive) -> None:
    """Say how a drive would be laid out and what is doubtful about it; nothing is run."""
    with _clear_errors():
        scene = _scene(drive, None)
        scene = scene.changed({}, {}, {"duration": scene.run.get("duration", 2.0)})
        typer.echo(scene.scene.system.check())
        simulation = scene.simulate()
        scene.check_run(simulation)
        if scene.out is not None:
            _check_file(scene.out)
        bodies = len(simulation.body_names)
        typer.echo(f"ready to run: {bodies} bodies, {scene.run['duration']:g} s")


@app.command()
def plot(
    file: Annotated[
        Path, typer.Argument(help="File that `rustchain run` wrote.", exists=True, dir_okay=False)
    ],
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("figures"),
    hinges: Annotated[
        str | None,
        typer.Option(help="Numbers of the hinges and bushings to draw; 6,11 by default."),
    ] = None,
    form: Annotated[str, typer.Option("--format", help="png, pdf or svg.")] = "png",
) -> None:
    """Draw the figures that a file has the data for."""
    with _clear_errors():
        from matplotlib.backend_bases import FigureCanvasBase

        import rustchain.plot  # first, as it names the extra  # noqa: F401

        if form not in FigureCanvasBase.get_supported_filetypes():
            _fail(f"--format = {form}: cannot be drawn; take png, pdf or svg")
        result = rc.load_result(file)
        draw = result.plot
        first, *more = _numbers(hinges, result.drive.hinge_count)
        figures: dict[str, Callable[[], Figure]] = {
            "drive": draw.drive,
            "tension": draw.tension,
            "energy": draw.energy,
            "hinge_force": lambda: draw.hinge_force(first, *more),
            "tooth_force": lambda: draw.tooth_force(first, *more),
            "hinge_force_penetration": lambda: draw.force_penetration(
                first, *more, contact="hinge"
            ),
            "tooth_force_penetration": lambda: draw.force_penetration(
                first, *more, contact="tooth"
            ),
            "orbit": lambda: draw.orbit(first, *more),
            "hinge_loads": draw.hinge_loads,
            "tooth_loads": draw.tooth_loads,
            "wrap_loads": draw.wrap_loads,
            "transmission_error": draw.transmission_error,
            "speed_ripple": draw.speed_ripple,
            "power_balance": draw.power_balance,
            "contact_pressure": draw.contact_pressure,
            "engagements": draw.engagements,
        }
        _make_folder(out)
        for name, figure_of in figures.items():
            path = out / f"{name}.{form}"
            try:
                figure = figure_of()
            except (rc.NotRecorded, rc.InvalidInput) as error:
                typer.echo(f"{path}: left out, {error}")
                continue
            image = BytesIO()
            figure.savefig(image, format=form)
            write_whole(path, image.getbuffer(), "out")
            typer.echo(path)


@app.command()
def catalogue(
    name: Annotated[
        str | None, typer.Argument(help="A chain, such as 'ANSI 40': all of its numbers.")
    ] = None,
) -> None:
    """List the standard chains, or all numbers of one with their sources."""
    with _clear_errors():
        sizes = rc.chain_sizes()
        if name is not None:
            typer.echo(sizes[rc.catalogue_chain(name, links=8).name])
            return
        columns = ("pitch", "roller", "width", "pin", "mass", "strength")
        units = ("mm", "mm", "mm", "mm", "kg/m", "kN")
        for label, head in (("chain", columns), ("", units)):
            typer.echo(f"{label:<10}" + "".join(f"{one:>9}" for one in head))
        for size in sizes.values():
            lengths = (size.pitch, size.roller_diameter, size.inner_width, size.pin_diameter)
            row = "".join(f"{1e3 * length:9.3f}" for length in lengths)
            typer.echo(
                f"{size.name:<10}{row}{size.mass_per_length:9.3f}{1e-3 * size.strength:9.2f}"
            )


@app.command()
def schema(
    out: Annotated[
        Path | None, typer.Option(help="File to write; without it, the schema is printed.")
    ] = None,
) -> None:
    """Write the JSON Schema of drive files, for editors that check and complete them."""
    from rustchain.files.schema import schema as schema_of_files

    with _clear_errors():
        text = json.dumps(schema_of_files(), indent=2, ensure_ascii=False)
        if out is None:
            typer.echo(text)
            return
        _make_room(out)
        write_whole(out, f"{text}\n".encode(), "out")
        typer.echo(out)


def _scene(drive: str, pretension: float | None) -> SceneFile:
    """Return what a drive file, or the name of a drive, stands for."""
    if drive == "paper":
        return SceneFile(rc.Scene(rc.paper_drive(pretension or 0.0)))
    path = Path(drive)
    if not path.exists():
        hint = suggest(drive, ["paper"])
        if hint.startswith("known"):
            hint = "give the path of a drive file, or paper"
        _fail(f"drive = {drive!r}: is no file, and no drive; {hint}")
    if pretension is not None:
        _fail(f"--pretension = {pretension:g}: is for the paper's drive; write it into {drive}")
    return SceneFile.read(path)


def _given(options: dict[str, Any]) -> dict[str, Any]:
    """Return the options that were given."""
    return {name: value for name, value in options.items() if value is not None}


def _numbers(text: str | None, count: int) -> list[int]:
    """Return the numbers in a text such as "6,11", or those that are drawn without one."""
    if text is None:
        return [number for number in _SOME_HINGES if number <= count] or [1]
    try:
        numbers = [int(number) for number in text.split(",")]
    except ValueError:
        _fail(f"--hinges = {text!r}: is no list of numbers, such as 6,11")
    for number in numbers:
        if not 1 <= number <= count:
            _fail(f"--hinges = {number}: there is none; hinges are numbered 1 to {count}")
    return numbers


def _save(result: rc.Result, out: Path) -> None:
    """Save a result and say so."""
    result.save(out)
    stats, span = result.stats, result.time[-1] - result.time[0]
    wall = sum(seconds for name, seconds in stats.items() if name.startswith("wall_"))
    typer.echo(
        f"{stats['steps']} steps, {stats['rejected']} rejected, "
        f"{stats['evaluations']} evaluations, {stats['onsets']} onsets of contact, {wall:.1f} s"
        + (f" ({wall / span:.2f} s for each simulated second)" if span > 0.0 else "")
    )
    if "energy" in result.groups:
        energy = result.energy
        typer.echo(
            f"energy: {energy.dissipated[-1] + 0.0:.3e} J dissipated, "  # zero without a sign
            f"{energy.residual[-1] + 0.0:.1e} J missing from the balance"
        )
    typer.echo(f"{result.message}: {len(result.time)} rows in {out}")


def _fail(message: object) -> NoReturn:
    """End with a message, not a traceback."""
    typer.echo(f"error: {message}", err=True)
    raise typer.Exit(1)


@contextmanager
def _clear_errors() -> Iterator[None]:
    """Say errors and warnings in one line each."""

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
        try:
            yield
        except (ValueError, LookupError, OSError, rc.SimulationError) as error:
            _fail(error)
