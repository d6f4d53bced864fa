"""The commands of many runs: sweep, study."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

import rustchain as rc
from rustchain.cli.common import (
    FAILED_CASES,
    INTERRUPTED,
    AsJson,
    Drive,
    Output,
    Quiet,
    Settings,
    check_file,
    clear_errors,
    fail,
    make_room,
    misuse,
    named_value,
    scene_file,
    with_settings,
)
from rustchain.cli.executors import Where, executor_of
from rustchain.extras import typer
from rustchain.files.sweep import SweepFile, check_figures, measure_of
from rustchain.paths import write_whole
from rustchain.results import netcdf
from rustchain.sweeps.case_run import told
from rustchain.sweeps.cases import cases_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_TABLES = (".csv", ".nc")
_SHOWN = 5  # failures that are told one by one

Store = Annotated[
    Path | None,
    typer.Option(help="Folder that keeps each case: what is there is not run again."),
]
Retry = Annotated[bool, typer.Option("--retry", help="Run stored cases that failed again.")]


def sweep(
    file: Annotated[
        Path, typer.Argument(help="A sweep file, such as sweep.toml; docs/reference/files.md.")
    ],
    settings: Settings = None,
    store: Store = None,
    retry: Retry = False,
    executor: Where = "threads",
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", help="Table to write, .csv or .nc; by default sweep.csv of sweep.toml."
        ),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Run a drive with other parameters many times, and write a table of the results.

    Ctrl-C keeps what is done; where there is a table of before, in sweep.partial.csv beside it.
    With --store, the same command continues an interrupted sweep.
    """
    output = Output(as_json, quiet)
    with clear_errors():
        _check_retry(retry, store)
        described = SweepFile.read(file, lambda name: scene_file(name, None))
        cases = cases_of(described.axes)[1]
        varied = {name for case in cases for name in case}
        _check_no_axis(settings, varied, "the sweep file; change it there")
        scene = with_settings(described.scene, settings)
        path = _table(out or Path(f"{file.stem}.csv"))
        run = {"duration": 2.0, **scene.run}
        with executor_of(executor) as where:
            try:
                described.check(scene.scene, run["duration"])
                found = rc.sweep(
                    scene.scene,
                    described.axes,
                    described.measure,
                    **run,
                    **where,
                    store=store,
                    retry=retry,
                    progress=output.progress,
                )
            except rc.InvalidInput as error:
                raise scene.refused_option(error) or described.refusal(error) from error
        path = _written(path, found, found.to_pandas, lambda: _dataset(found), output)
        _tell(found, path, store, output)
    _leave(found)


def study(
    drive: Drive,
    *,
    runs: Annotated[int, typer.Option(help="Runs of each case, from slightly other starts.")] = 8,
    duration: Annotated[
        float | None, typer.Option(help="Simulated time of each [s]; 0.5, where the file has none.")
    ] = None,
    burn_in: Annotated[
        float, typer.Option(help="Simulated time at the beginning that is not measured [s].")
    ] = 0.1,
    confidence: Annotated[float, typer.Option(help="Of the intervals of the means.")] = 0.95,
    axes: Annotated[
        list[str] | None,
        typer.Option(
            "--axis",
            metavar="KEY=[VALUES]",
            help="Parameter and its values, as often as given: pretension=[0,25].",
        ),
    ] = None,
    measure: Annotated[
        list[str] | None,
        typer.Option(
            help="Figure of the summary, as often as given; or a function, file.py:function. By "
            "default all figures."
        ),
    ] = None,
    settings: Settings = None,
    store: Store = None,
    retry: Retry = False,
    executor: Where = "threads",
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Table to write, .csv or .nc; by default none."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Run a drive several times from slightly different starts, and give means with intervals."""
    output = Output(as_json, quiet)
    with clear_errors():
        _check_retry(retry, store)
        scene = scene_file(drive, settings)
        if quiet and not as_json and out is None and store is None:
            misuse(
                "--quiet: leaves nothing of a study; give --out, --store or --json, or remove it"
            )
        path = None if out is None else _table(out)
        given = measure[0] if measure is not None and len(measure) == 1 else measure
        run = {"duration": 0.5, **scene.run}
        run |= {} if duration is None else {"duration": duration}
        grid: dict[str, Any] = {}
        for axis in axes or ():
            name, values = named_value("--axis", axis)
            if name in grid:
                misuse(f"--axis: {name!r} is there twice; give it once, with all values")
            if not isinstance(values, list | tuple):
                text = axis.partition("=")[2].strip()
                misuse(f"--axis {axis}: is no list; expected brackets, {name}=[{text}]")
            grid[name] = values
        _check_no_axis(settings, grid, "--axis; remove one of them")
        figures = None if given is None else measure_of(given, 0.0, Path())
        check_figures(figures, scene.scene, grid)
        with executor_of(executor) as where:
            found = rc.study(
                scene.scene,
                figures,
                **run,
                **where,
                runs=runs,
                burn_in=burn_in,
                confidence=confidence,
                axes=grid,
                store=store,
                retry=retry,
                progress=output.progress,
            )
        if found.sweep.finished == 0:
            _tell(found.sweep, None, store, output)
            _leave(found.sweep)
        table = found.to_pandas()
        if path is not None:
            path = _written(path, found.sweep, found.to_pandas, lambda: found.statistics, output)
        output.say(table.to_string(float_format=lambda number: f"{number:.5g}"))
        rows = table.reset_index().to_dict("records")
        _tell(found.sweep, path, store, output, {"statistics": rows})
    _leave(found.sweep)


def _check_no_axis(settings: list[str] | None, varied: Collection[str], where: str) -> None:
    """Refuse to set what an axis varies; `where` it does, and a remedy."""
    for name in (each.partition("=")[0].strip() for each in settings or ()):
        if name in varied:
            misuse(f"--set: {name!r} is varied by {where}")


def _check_retry(retry: bool, store: Path | None) -> None:
    """Refuse to run again what no store has."""
    if retry and store is None:
        misuse(
            "--retry: runs stored cases again, and there is no store; give --store, or remove it"
        )


def _table(path: Path) -> Path:
    """Return the file of a table, which can be written."""
    check_file(path, "sweep.csv")
    if path.suffix not in _TABLES:
        fail(f"out = {path}: tables are written as .csv or .nc; take {path.with_suffix('.csv')}")
    make_room(path)
    return path


def _written(
    path: Path,
    found: rc.SweepResult,
    frame: Callable[[], pd.DataFrame],
    data: Callable[[], xr.Dataset],
    output: Output,
) -> Path:
    """Write a table or a dataset whole; return its file, which is another than a table of before.

    A table of an interrupted sweep lacks cases that the one of before may have.
    """
    is_kept = found.status == "interrupted" and path.exists()
    new = path.with_suffix(f".partial{path.suffix}") if is_kept else path
    if path.suffix == ".csv":
        write_whole(new, frame().to_csv().encode(), "out")
    else:
        netcdf.write(data(), new)
    if is_kept:
        output.say(f"{path}: is kept as it was, for the sweep was interrupted")
    return new


def _dataset(found: rc.SweepResult) -> xr.Dataset:
    """Return the dataset of a sweep, with the reasons of failed cases in a text variable."""
    data = found.to_xarray()
    if found.errors:
        reasons = [told(e) if (e := found.errors.get(k)) else "" for k in range(len(found.cases))]
        shape = [data.sizes.get(dim, -1) for dim in found.dims]
        data["error"] = (found.dims, np.array(reasons).reshape(shape))
    return data


def _tell(
    found: rc.SweepResult,
    path: Path | None,
    store: Path | None,
    output: Output,
    more: dict[str, Any] | None = None,
) -> None:
    """Print the end of a sweep and its failed cases."""
    failed = list(found.errors.items())
    for number, error in failed[:_SHOWN]:
        typer.echo(f"case {number} {found.cases[number]}: {told(error)}", err=True)
    if len(failed) > _SHOWN:
        # A table of statistics has no cases.
        where = "" if path is None or more else f"; all of them in {path}"
        typer.echo(f"and {len(failed) - _SHOWN} more{where}", err=True)
    output.say(found.message if path is None else f"{found.message}: {path}")
    if found.status == "interrupted" and store is not None:
        output.say(f"the same command goes on with what is in {store}")
    output.document(
        {
            "status": found.status,
            "message": found.message,
            "cases": len(found.cases),
            "finished": found.finished,
            "failed": len(failed),
            "file": path,
            "errors": {number: told(error) for number, error in failed},
        }
        | (more or {})
    )


def _leave(found: rc.SweepResult) -> None:
    """Leave with the code of how a sweep ended."""
    if found.status == "interrupted":
        raise typer.Exit(INTERRUPTED)
    if found.errors:
        raise typer.Exit(FAILED_CASES)
