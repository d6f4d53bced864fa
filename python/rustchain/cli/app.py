"""The command `rustchain`: its commands, gathered."""

from __future__ import annotations

from typing import Annotated

import rustchain as rc
from rustchain.cli.fmu import fmu
from rustchain.cli.many import study, sweep
from rustchain.cli.plot import plot
from rustchain.cli.run import check, run
from rustchain.cli.show import animate, report
from rustchain.cli.tables import catalogue, schema
from rustchain.extras import typer

_EXIT_CODES = (
    "Exit codes: 0 done; 1 error; 2 wrong command line; 3 cases of a sweep or study have failed; "
    "130 ended by Ctrl-C or SIGTERM, what is there is kept."
)

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # it would take the units in brackets for markup
    context_settings={"max_content_width": 120},  # of a wide terminal; click has 80
    epilog=_EXIT_CODES,
)
for command in (run, check, plot, animate, report, sweep, study, fmu, catalogue, schema):
    app.command(epilog=_EXIT_CODES)(command)


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
