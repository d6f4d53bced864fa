"""The page of a report: one file that needs no network."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rustchain import extras
from rustchain.description.base import fields_of
from rustchain.description.drive import ChainDrive
from rustchain.description.solver import Solver
from rustchain.errors import InvalidInput, NotRecorded
from rustchain.files.writer import text_of_scene
from rustchain.names import counted
from rustchain.notebook import html_table
from rustchain.paths import check_writable, path_of, write_whole
from rustchain.plot.colors import theme_css
from rustchain.plot.player import player_part
from rustchain.report.confidence import PARTS, KeyFigure, key_figures
from rustchain.report.figures import Drawn, figures_of, picture_of
from rustchain.report.safety import USUAL_SAFETY, USUAL_SAFETY_OFFSET, Safety, safety_of
from rustchain.simulation.simulation import Simulation
from rustchain.typing import FilePath, Time

if TYPE_CHECKING:
    from rustchain.results.result import Result

_THEME = """
document.querySelector("nav button").addEventListener("click", () => {
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)").matches;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : system;
  root.dataset.theme = dark ? "light" : "dark";
});
"""


def write_report(
    result: Result,
    path: FilePath,
    *,
    start: Time = None,
    end: Time = None,
    breaking_load: float | None = None,
) -> None:
    """Write what `Result.report` promises."""
    where = path_of(path)
    check_options(where, breaking_load, result.scene.kind)
    _ = extras.matplotlib, extras.xarray  # first, as they name their extras
    check_writable(where)
    write_whole(where, report_page(result, start, end, breaking_load).encode())


def check_options(path: Path, breaking_load: float | None, kind: str) -> None:
    """Refuse options of a report on a scene of a kind that are out of their ranges."""
    if path.suffix.lower() not in (".html", ".htm"):
        msg = f"path = {str(path)!r}: ends in {path.suffix!r}; expected .html"
        if path.suffix.lower() == ".pdf":
            msg += ": a browser prints the page to PDF"
        raise InvalidInput(msg)
    if breaking_load is None:
        return
    if kind == "mechanism":
        msg = "report(breaking_load): a mechanism has no chain; leave it out"
        raise InvalidInput(msg)
    if not 0.0 < breaking_load < np.inf:
        msg = f"report(breaking_load): got {breaking_load:g}; expected a positive number in N"
        raise InvalidInput(msg)


def report_page(
    result: Result, start: Time = None, end: Time = None, breaking_load: float | None = None
) -> str:
    """Return the report on a result as a page; see `Result.report`."""
    from rustchain import __version__

    inputs = _inputs(result)  # with the drive as it stands at the start of the run
    result = result if start is None and end is None else result.between(start, end)
    sections = {
        "Warnings": _warnings(result),
        "Drive" if isinstance(result.scene.system, ChainDrive) else "Mechanism": inputs,
        "Key figures": _key_figures(result),
        "Safety": _safety(result, breaking_load),
        "Motion": _motion(result),
        "Plots": _plots(figures_of(result)),
    }
    there = {title: content for title, content in sections.items() if content}
    links = "".join(f'<a href="#{_anchor(title)}">{title}</a>' for title in there)
    body = "".join(
        f'<section id="{_anchor(title)}"><h2>{title}</h2>{content}</section>\n'
        for title, content in there.items()
    )
    style = resources.files("rustchain.report").joinpath("page.css").read_text(encoding="utf-8")
    time, name = result.time, escape(result.scene.name)
    head = (
        f"rustchain {escape(__version__)}: {time[0]:g} to {time[-1]:g} s "
        f"in {counted(len(time), 'rows')}; {escape(result.message)}"
    )
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{name}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>{theme_css()}\n{style}</style></head><body>\n<h1>{name}</h1>"
        f'<div class="dim">{head}</div>\n'
        f'<nav>{links}<button type="button">light / dark</button></nav>\n{body}'
        f"<script>{_THEME}</script></body></html>\n"
    )


def _anchor(title: str) -> str:
    return title.lower().replace(" ", "-")


def _warnings(result: Result) -> str:
    """Return the warnings of the scene and of the run."""
    try:
        found = list(result.scene.check().warnings)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            Simulation(result.scene)
    except InvalidInput as error:  # a Python function, which the file of the result does not have
        found, caught = [str(error)], []
    # Those of the drive are there; the others are of force laws and of the solver.
    found += [text for each in caught if (text := str(each.message)) not in found]
    if not result.success:
        how = "failed" if result.status == "failed" else f"was {result.status}"
        found.append(f"the run {how}: {result.message}")
    jumps = 0 if result.jumps is None else len(result.tooth_jumps)
    if jumps:
        teeth = "tooth" if jumps == 1 else "teeth"
        found.append(
            f"the chain jumped {jumps} {teeth}; there is no transmission error or efficiency"
        )
    return "".join(f'<p class="warning">{escape(text)}</p>' for text in found)


def _inputs(result: Result) -> str:
    """Return layout and inputs, with a picture of a drive."""
    scene = result.scene
    laws: list[tuple[str, object]] = []
    if isinstance(scene.system, ChainDrive):
        layout = f'<figure class="drive">{picture_of(result)}</figure>'
        layout += f'<div class="scroll">{html_table(scene.system.check().rows())}</div>'
        ideal = scene.system.hinges == "ideal"
        laws = [
            ("law of hinges", "ideal hinges" if ideal else scene.law_of_hinges),
            ("law of teeth", scene.law_of_teeth),
        ]
    else:
        try:
            layout = f"<pre>{escape(str(scene.system.check()))}</pre>"
        except InvalidInput:  # which is among the warnings
            layout = ""
    rows = [(label, line_of(value)) for label, value in (*laws, ("solver", scene.solver))]
    rows.append(("start", scene.start if scene.positions is None else "given positions"))
    try:
        text = escape(text_of_scene(scene, ".toml"))
    except InvalidInput as error:  # a Python function
        text = escape(str(error))
    every = f"<details><summary>All inputs, as a drive file</summary><pre>{text}</pre></details>"
    return f"{layout}<h3>Simulation</h3>{_table((), rows)}{every}"


def line_of(value: object) -> str:
    """Return a description in one line: its name, and what it sets."""
    if isinstance(value, str):
        return value
    fields = fields_of(value) or {}
    if isinstance(value, Solver) and (value.rtol, value.atol) != (None, None):
        del fields["accuracy"]  # which they replace
    given = ", ".join(f"{k} {v}" for k, v in fields.items() if v is not None)
    return f"{type(value).__name__}: {given}"


def _key_figures(result: Result) -> str:
    """Return the key figures with their units and confidence."""
    figures = key_figures(result)
    if not figures:
        return ""
    rows = [(f.label, *_in_its_unit(f)) for f in figures]
    table = _table(("", "value", "", f"95 % interval, or range of {PARTS} parts"), rows)
    energy = _energy(result)
    note = (
        f"± is the 95 % interval of a mean over time, from the means of {PARTS} parts of equal "
        f"duration ({number_text(np.ptp(result.time) / PARTS)} s{_turns(result)}), taken as "
        "independent. What repeats within a revolution makes it wider than chance does, a change "
        "that outlasts a part narrower. Of other figures the range of the parts is given. Other "
        "starts of a chaotic drive are the subject of study()."
    )
    return f'{table}{energy}<p class="note">{note}</p>'


def _in_its_unit(figure: KeyFigure) -> tuple[str, str, str]:
    """Return value, unit and confidence of a figure; lengths in micrometres."""
    scale, unit = (1e6, "µm") if figure.unit == "m" else (1.0, figure.unit)
    told = ""
    if figure.interval is not None:
        told = f"± {number_text(scale * (figure.interval[1] - figure.value))}"
    elif figure.spread is not None:
        told = " … ".join(number_text(scale * end) for end in figure.spread)
    return number_text(scale * figure.value), unit, told


def _turns(result: Result) -> str:
    """Return how often the first sprocket turns in a part."""
    angle = result.arrays.get("sprocket_angle")
    if angle is None or not angle.shape[1]:
        return ""
    turns = abs(angle[-1, 0] - angle[0, 0]) / (2.0 * np.pi * PARTS)
    return f", {number_text(turns)} turns of sprocket 1"


def _energy(result: Result) -> str:
    """Return how well the energy balance is fulfilled."""
    if "energy" not in result.groups:
        return ""
    lost = float(result.energy.dissipated[-1] - result.energy.dissipated[0])
    residual = float(result.energy.residual[-1] - result.energy.residual[0])
    share = f", {number_text(100.0 * abs(residual) / lost)} % of it" if lost > 0.0 else ""
    told = f"{number_text(lost)} J dissipated, residual {number_text(residual)} J{share}"
    return f"<p>Energy balance: {told}.</p>"


def _safety(result: Result, breaking_load: float | None) -> str:
    """Return the safety of a chain beside what is usual."""
    if result.scene.kind == "mechanism":
        return ""
    try:
        found = safety_of(result, breaking_load)
    except NotRecorded as error:
        return f'<p class="note">{escape(str(error))}</p>'
    head = ("", "load", "", "safety", "usually at least")
    rows: list[Sequence[str]] = []
    for label, load, usual in (
        ("mean tension of the tight strand", found.pull, f"{found.usual_safety:g}"),
        ("largest tension of a strand", found.largest_pull, ""),
        ("largest force in a hinge", found.largest_force, ""),
    ):
        safety = "–"
        if found.breaking_load is not None and load > 0.0:
            safety = number_text(found.breaking_load / load)
        rows.append((label, number_text(load), "N", safety, usual))
    known_load = (
        f"Breaking load of the chain: {number_text(1e-3 * found.breaking_load)} kN."
        if found.breaking_load is not None
        else "Breaking load of the chain: not known; pass breaking_load to report."
    )
    return f"<p>{known_load}</p>{_table(head, rows)}{_pressures(found)}{_SOURCES}"


def _pressures(found: Safety) -> str:
    """Return the table of pressures in hinges."""
    allowed = (
        "outside the table"
        if found.allowed_pressure is None
        else f"{number_text(1e-6 * found.allowed_pressure)} MPa"
    )
    rows = [
        ("projected, of the mean tension", number_text(1e-6 * found.pressure), "MPa", allowed),
        ("projected, of the largest force", number_text(1e-6 * found.largest_pressure), "MPa", ""),
        ("Hertz, of the largest force", number_text(1e-6 * found.hertz_pressure), "MPa", ""),
    ]
    return "<h3>Pressure in the hinges</h3>" + _table(("", "pressure", "", "guide value"), rows)


_SOURCES = (
    f'<p class="note">Safety of {USUAL_SAFETY:g} of the breaking load for chains with press-fit '
    f"connecting links, {USUAL_SAFETY_OFFSET:g} with slip-fit ones or offset links: rule of "
    "Diamond Chain for slow drives. Pressure over the projected area, pin diameter times length of "
    "the bushing. Its guide value is a textbook's for the mean pressure, at this pitch and speed "
    "of the small sprocket, with 1 % more for each tooth above 17: Chernavskii and others, Course "
    "Design of Machine Elements (edition and page not checked). It is no limit of a standard or of "
    "the chain's manufacturer, and other tables differ from it by up to 30 %. The manufacturer's "
    "selection by power decides.</p>"
)


def _motion(result: Result) -> str:
    """Return the player, where bodies were recorded."""
    try:
        return player_part(result.animate())
    except (NotRecorded, InvalidInput) as error:
        return f'<p class="note">{escape(str(error))}</p>'


def _plots(figures: Iterable[Drawn]) -> str:
    """Return the figures, and at the end what was left out and why."""
    drawn, left_out = [], []
    for one in figures:
        if one.svg:
            drawn.append(f"<h3>{escape(one.title)}</h3><figure>{one.svg}</figure>")
        else:
            left_out.append(f"<li>{escape(one.title)}: {escape(one.left_out)}</li>")
    more = f'<h3>Left out</h3><ul class="note">{"".join(left_out)}</ul>' if left_out else ""
    return "".join(drawn) + more


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; the first column has labels."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(
        f"<tr><th>{escape(label)}</th>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>"
        for label, *cells in rows
    )
    opening = f"<thead><tr>{top}</tr></thead>" if head else ""
    return (
        f'<div class="scroll"><table class="figures">{opening}<tbody>{body}</tbody></table></div>'
    )


def number_text(value: float) -> str:
    """Return a number with four figures; from ten thousand to ten million without an exponent."""
    text = f"{value:.4g}"
    if 1e4 <= abs(float(text)) < 1e7:
        text = f"{float(text):.0f}"
    return text.replace("-", "−")
