"""The command `rustchain`: run a drive into a file, draw a file's figures, list the chains."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn, TextIO, cast

import typer

import rustchain as rc
from rustchain._names import suggest
from rustchain.simulation import Group, Method

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


@app.command()
def run(
    drive: Annotated[str, typer.Argument(help="The drive: paper.")],
    duration: Annotated[float, typer.Option(help="Simulated time [s].")] = 2.0,
    pretension: Annotated[float, typer.Option(help="Tension given to each strand [N].")] = 0.0,
    law: Annotated[Law, typer.Option(help="Force law of every contact.")] = Law.LANKARANI_NIKRAVESH,
    method: Annotated[str, typer.Option(help="Of integration: auto, pece or newton.")] = "auto",
    accuracy: Annotated[float, typer.Option(help="Error a step is allowed [m].")] = 1e-10,
    rtol: Annotated[
        float | None, typer.Option(help="Relative tolerance, in place of accuracy.")
    ] = None,
    atol: Annotated[
        float | None, typer.Option(help="Absolute tolerance, in place of accuracy.")
    ] = None,
    max_step: Annotated[float, typer.Option(help="Largest step [s].")] = 1e-4,
    report_step: Annotated[float, typer.Option(help="Time between two rows [s].")] = 1e-4,
    record: Annotated[
        str, typer.Option(help="What to record, of hinges,teeth,sprockets,bodies.")
    ] = "hinges,teeth,sprockets",
    out: Annotated[Path, typer.Option(help="File to write (netCDF).")] = Path("run.nc"),
) -> None:
    """Run a drive and save what it did. Ctrl-C saves what is there."""
    with _clear_errors():
        if drive != "paper":
            _fail(f"drive: {drive!r} is not known; {suggest(drive, ['paper'])}")
        out.parent.mkdir(parents=True, exist_ok=True)
        solver = rc.Solver(
            method=cast("Method", method),
            rtol=rtol,
            atol=atol,
            max_step=max_step,
            accuracy=accuracy,
        )
        simulation = rc.Simulation(rc.paper_drive(pretension), law.value_of(), solver=solver)
        groups = cast("list[Group]", [group.strip() for group in record.split(",")])
        try:
            result = simulation.run(duration, report_step, groups)
        except rc.SimulationError as error:
            if error.result is not None:
                _save(error.result, out)
            raise
        _save(result, out)
    if not result.success:
        raise typer.Exit(_INTERRUPTED)


@app.command()
def plot(
    file: Annotated[
        Path, typer.Argument(help="File that `rustchain run` wrote.", exists=True, dir_okay=False)
    ],
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("figures"),
    hinges: Annotated[
        str, typer.Option(help="Numbers of the hinges and bushings to draw.")
    ] = "6,11",
    form: Annotated[str, typer.Option("--format", help="png, pdf or svg.")] = "png",
) -> None:
    """Draw the figures that a file has the data for."""
    with _clear_errors():
        import matplotlib as mpl
        import matplotlib.pyplot as plt

        mpl.use("Agg")
        draw = rc.load_result(file).plot
        first, *more = _numbers(hinges)
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
        out.mkdir(parents=True, exist_ok=True)
        for name, figure_of in figures.items():
            path = out / f"{name}.{form}"
            try:
                figure = figure_of()
            except (rc.NotRecorded, rc.InvalidInput) as error:
                typer.echo(f"{path}: left out, {error}")
                continue
            figure.savefig(path)
            plt.close(figure)
            typer.echo(path)


@app.command()
def catalogue(
    name: Annotated[
        str | None, typer.Argument(help="A chain, such as 'ANSI 40': all of its numbers.")
    ] = None,
) -> None:
    """List the standard chains, or all numbers of one with their sources."""
    with _clear_errors():
        sizes = rc.catalogue()
        if name is not None:
            typer.echo(sizes[rc.catalogue_chain(name, links=8).name])
            return
        typer.echo(
            f"{'chain':<10}{'pitch':>9}{'roller':>9}{'width':>9}{'pin':>9}{'kg/m':>9}{'kN':>9}"
        )
        for size in sizes.values():
            lengths = (size.pitch, size.roller_diameter, size.inner_width, size.pin_diameter)
            row = "".join(f"{1e3 * length:9.3f}" for length in lengths)
            typer.echo(
                f"{size.name:<10}{row}{size.mass_per_length:9.3f}{1e-3 * size.strength:9.2f}"
            )


def _numbers(text: str) -> list[int]:
    """Return the numbers in a text such as "6,11"."""
    try:
        return [int(number) for number in text.split(",")]
    except ValueError:
        _fail(f"hinges: {text!r} is no list of numbers, such as 6,11")


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
            f"energy: {energy.dissipated[-1]:.3e} J dissipated, "
            f"{energy.residual[-1]:.1e} J missing from the balance"
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


def main() -> None:
    """Run the command."""
    app()
