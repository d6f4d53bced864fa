"""Views of drives, reports, results, sweeps and studies in notebooks: a table and a picture."""

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
    from rustchain.description.mechanism.report import MechanismReport
    from rustchain.description.report import DriveReport, Row
    from rustchain.results.result import Result
    from rustchain.sweeps.result import SweepResult
    from rustchain.sweeps.study import StudyResult

_PICTURE = 420  # width of a picture [pixels]
# What a scene may lack for a part of its view, which is then left out.
_LACKING = (MissingExtra, NotRecorded, InvalidInput, SimulationError)


def html_of(value: Any) -> str:  # noqa: ANN401
    """Return what a notebook shows of a value."""
    return _VIEWS[type(value).__name__](value)


def _html_of_drive(drive: ChainDrive) -> str:
    """Return the layout of a drive as a table, and the drive at its start."""

    def picture() -> Figure:
        from rustchain.plot.picture import draw_drive
        from rustchain.simulation.simulation import Simulation

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the simulation to be run gives them
            return draw_drive(drive, Simulation(drive).positions)

    report = _part(lambda: _html_of_report(drive.check()))
    return _view(repr(drive), report, picture)


def _html_of_report(report: DriveReport) -> str:
    """Return a report as a table."""
    warnings = "".join(f"<p><b>warning:</b> {escape(text)}</p>" for text in report.warnings)
    return html_table(report.rows()) + warnings


def _html_of_assembly(report: MechanismReport) -> str:
    """Return the lines of a report, set in characters of equal width."""
    return f"<pre>{escape(str(report))}</pre>"


def _html_of_result(result: Result) -> str:
    """Return the key figures of a result, and the tension of its strands."""
    summary = _part(lambda: result.summary()._repr_html_())
    return _view(f"{result!r}: {result.message}", summary, lambda: result.plot.tension())


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
    return f'<img width="{_PICTURE}" src="data:image/png;base64,{data}">'


_VIEWS: dict[str, Callable[[Any], str]] = {
    "ChainDrive": _html_of_drive,
    "DriveReport": _html_of_report,
    "MechanismReport": _html_of_assembly,
    "Result": _html_of_result,
    "StudyResult": _html_of_study,
    "Summary": _html_of_summary,
    "SweepResult": _html_of_sweep,
}
"""The view of each class that has one, by its name."""
