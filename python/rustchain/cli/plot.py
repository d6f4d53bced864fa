"""The command that draws: plot."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import rustchain as rc
from rustchain.cli.common import (
    AsJson,
    Output,
    Quiet,
    clear_errors,
    fail,
    make_folder,
    misuse,
)
from rustchain.extras import typer
from rustchain.names import suggest
from rustchain.paths import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_FORMS = ("png", "pdf", "svg")
# The figures of which --hinges chooses the hinges or bushings.
_NUMBERED = {
    "hinge_force",
    "tooth_force",
    "hinge_force_penetration",
    "tooth_force_penetration",
    "orbit",
}


def plot(
    file: Annotated[
        Path, typer.Argument(help="File that `rustchain run` wrote.", exists=True, dir_okay=False)
    ],
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="FIGURES",
            help="Figures to draw, such as tension energy; by default all that the file has the "
            "data for.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the figures.")] = Path(
        "figures"
    ),
    hinges: Annotated[
        str | None,
        typer.Option(
            help="Numbers of hinges and bushings, such as 6,11; by default the most loaded ones."
        ),
    ] = None,
    form: Annotated[str, typer.Option("--format", help="png, pdf or svg.")] = "png",
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Plot figures from a result file: all that it has the data for, or those that are named.

    Figures without data in the file are reported and left out; a figure that was named must be
    drawn.
    """
    output = Output(as_json, quiet)
    with clear_errors():
        import rustchain.plot  # first, as it names the extra  # noqa: F401

        form = form.lower()
        if form not in _FORMS:
            misuse(f"--format = {form}: expected png, pdf or svg")
        result = rc.load_result(file)
        figures = _figures(result, hinges)
        for name in names or ():
            if name not in figures:
                fail(f"figure {name!r}: there is none of that name; {suggest(name, figures)}")
        if hinges is not None and names and _NUMBERED.isdisjoint(names):
            misuse(f"--hinges = {hinges}: {' '.join(names)} takes none; leave it out")
        wanted = names or [name for name in figures if name not in _absent(result)]
        make_folder(out)
        drawn, left_out = [], {}
        for name in wanted:
            path = out / f"{name}.{form}"
            try:
                figure = figures[name]()
            except (rc.NotRecorded, rc.InvalidInput) as error:
                if names:
                    fail(f"{path}: {error}")
                left_out[name] = str(error)
                output.say(f"{path}: left out, {error}")
                continue
            image = BytesIO()
            figure.savefig(image, format=form)
            write_whole(path, image.getbuffer(), "out")
            drawn.append(path)
            output.say(path)
        output.document({"figures": drawn, "left_out": left_out})
        if not drawn:
            groups = ", ".join(result.groups) or "nothing"
            fail(f"{file}: has the data for no figure; record more than {groups}")


def _absent(result: rc.Result) -> set[str]:
    """Return the figures of parts that the scene does not have."""
    if result.scene.kind == "mechanism":
        return set()
    drive = result.drive
    there = {"guide_loads": drive.guides, "joint_loads": drive.hinges == "ideal"}
    return {name for name, part in there.items() if not part}


def _figures(result: rc.Result, hinges: str | None) -> dict[str, Callable[[], Figure]]:
    """Return what draws each figure, by its name."""
    draw = result.plot
    if result.scene.kind == "mechanism":
        if hinges is not None:
            fail(f"--hinges = {hinges}: a mechanism has none; leave it out")
        return {
            "motion": draw.motion,
            "paths": draw.paths,
            "joint_loads": draw.joint_loads,
            "contact_force": draw.contact_force,
            "residuals": draw.residuals,
            "energy": draw.energy,
        }
    numbers = _numbers(hinges, result.drive.hinge_count)
    guides = range(1, max(2, 1 + len(result.drive.guides)))
    return {
        "drive": draw.drive,
        "tension": draw.tension,
        "energy": draw.energy,
        "hinge_force": lambda: draw.hinge_force(*numbers),
        "tooth_force": lambda: draw.tooth_force(*numbers),
        "hinge_force_penetration": lambda: draw.force_penetration(*numbers, contact="hinge"),
        "tooth_force_penetration": lambda: draw.force_penetration(*numbers, contact="tooth"),
        "orbit": lambda: draw.orbit(*numbers),
        "hinge_loads": draw.hinge_loads,
        "tooth_loads": draw.tooth_loads,
        "polar_tooth_loads": draw.polar_tooth_loads,
        "wrap_loads": draw.wrap_loads,
        "transmission_error": draw.transmission_error,
        "speed_ripple": draw.speed_ripple,
        "power_balance": draw.power_balance,
        "contact_pressure": draw.contact_pressure,
        "engagements": draw.engagements,
        "pressure_cycles": draw.pressure_cycles,
        "spectrum": lambda: draw.spectrum("strand_tension"),
        "strand_motion": lambda: draw.strand_motion(*result.strand_names),
        "guide_loads": lambda: draw.guide_loads(*guides),
        "joint_loads": draw.joint_loads,
        "motion": draw.motion,
        "paths": draw.paths,
    }


def _numbers(text: str | None, count: int) -> list[int]:
    """Return the numbers in a text such as "6,11"; none without one."""
    if text is None:
        return []
    try:
        numbers = [int(number) for number in text.split(",")]
    except ValueError:
        misuse(f"--hinges = {text!r}: is no list of numbers, such as 6,11")
    for number in numbers:
        if not 1 <= number <= count:
            fail(f"--hinges = {number}: there is none; hinges are numbered 1 to {count}")
    return numbers
