"""Views of drives, mechanisms, reports and results in notebooks: a table and a picture."""

from __future__ import annotations

import base64
import warnings
from collections.abc import Callable, Iterable
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING, Any

from rustchain.errors import InvalidInput, MissingExtra, NotRecorded, SimulationError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rustchain.analysis.summary import Summary
    from rustchain.description.drive import ChainDrive
    from rustchain.description.mechanism.builder import Mechanism
    from rustchain.description.mechanism.report import MechanismReport
    from rustchain.description.report import DriveReport, Row
    from rustchain.results.result import Result
    from rustchain.sweeps.result import SweepResult
    from rustchain.sweeps.study import StudyResult
    from rustchain.typing import Array

_PICTURE = 640  # width of a picture [pixels], at most that of the page
# What a scene may lack for a part of its view, which is then left out.
_LACKING = (MissingExtra, NotRecorded, InvalidInput, SimulationError)


def html_of(value: Any) -> str:  # noqa: ANN401
    """Return what a notebook shows of a value."""
    return _VIEWS[type(value).__name__](value)


def _html_of_system(system: ChainDrive | Mechanism) -> str:
    """Return the report on a drive or a mechanism as a table, and its picture at the start."""
    return _view(repr(system), _part(lambda: _table_of(system.check())), lambda: _picture(system))


def _html_of_report(report: DriveReport | MechanismReport) -> str:
    """Return a report as a table, and the picture of what it reports on."""
    system = getattr(report, "drive", None) or getattr(report, "mechanism", None)
    picture = "" if system is None else _part(lambda: _image(_picture(system)))
    return _table_of(report) + picture


def _table_of(report: DriveReport | MechanismReport) -> str:
    rows = [row for row in report.rows() if row[0] != "warning"]
    warnings = "".join(f"<p><b>warning:</b> {escape(text)}</p>" for text in report.warnings)
    return html_table(rows) + warnings


def _picture(system: ChainDrive | Mechanism, positions: Array | None = None) -> Figure:
    """Return the picture of a drive or a mechanism, by default at its start."""
    from rustchain.description.drive import ChainDrive
    from rustchain.plot.picture import draw_drive, draw_mechanism
    from rustchain.simulation.simulation import Simulation

    if positions is None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the simulation to be run gives them
            positions = Simulation(system).positions
    if isinstance(system, ChainDrive):
        return draw_drive(system, positions)
    return draw_mechanism(system, positions)


def _html_of_result(result: Result) -> str:
    """Return the key figures of a result, and a figure.

    The figure has the tension of the strands of a drive, or a mechanism at the end.
    """
    summary = _part(lambda: result.summary()._repr_html_())
    mechanism = result.scene.kind == "mechanism"

    def picture() -> Figure:
        if mechanism:
            return _picture(result.scene.system, result.final_positions)
        return result.plot.tension()

    return _view(f"{result!r}: {result.message}", summary, picture)


def _html_of_sweep(sweep: SweepResult) -> str:
    """Return the measured values of each case as a table, and over the first axis as a figure."""

    def picture() -> Figure:
        from rustchain.plot.studies import draw_sweep

        return draw_sweep(sweep)

    return _view(repr(sweep), _part(lambda: sweep.to_pandas().to_html(max_rows=20)), picture)


def _html_of_study(study: StudyResult) -> str:
    """Return the statistics of a study as a table, and its figure."""
    return _view(repr(study), _part(lambda: study.to_pandas().to_html(max_rows=20)), study.plot)


def _html_of_summary(summary: Summary) -> str:
    """Return the key figures as a table."""
    return html_table((name, (value, unit)) for name, value, unit in summary.rows())


def _view(head: str, table: str, picture: Callable[[], Figure]) -> str:
    return f"<p>{escape(head)}</p>{table}{_part(lambda: _image(picture()))}"


def _part(make: Callable[[], str]) -> str:
    """Return a part of a view; nothing where what it needs is not there."""
    try:
        return make()
    except _LACKING:
        return ""


def html_table(rows: Iterable[Row]) -> str:
    """Return rows as a table; a text without columns goes over all of them."""
    lines = []
    for label, value in rows:
        if isinstance(value, str):
            cells = f'<td colspan="99" style="text-align: left">{escape(value)}</td>'
        else:
            cells = "".join(f"<td>{escape(cell)}</td>" for cell in value)
        lines.append(f'<tr><th style="text-align: left">{escape(label)}</th>{cells}</tr>')
    return f"<table>{''.join(lines)}</table>"


def _image(figure: Figure) -> str:
    """Return a figure as an image inside the page."""
    image = BytesIO()
    figure.savefig(image, format="png")
    data = base64.b64encode(image.getvalue()).decode()
    return f'<img width="{_PICTURE}" style="max-width: 100%" src="data:image/png;base64,{data}">'


_VIEWS: dict[str, Callable[[Any], str]] = {
    "ChainDrive": _html_of_system,
    "DriveReport": _html_of_report,
    "Mechanism": _html_of_system,
    "MechanismReport": _html_of_report,
    "Result": _html_of_result,
    "StudyResult": _html_of_study,
    "Summary": _html_of_summary,
    "SweepResult": _html_of_sweep,
}
"""The view of each class that has one, by its name."""
