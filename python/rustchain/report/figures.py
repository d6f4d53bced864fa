"""The figures of a report, as SVG with the colours of the page."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from io import StringIO
from typing import TYPE_CHECKING, Any, NamedTuple

import matplotlib as mpl
import numpy as np

from rustchain.analysis.window import start_positions
from rustchain.errors import InvalidInput, NotRecorded
from rustchain.plot.colors import IN_DARK
from rustchain.plot.picture import draw_drive
from rustchain.plot.style import light_theme

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rustchain.results.result import Result

_SPROCKETS = 3  # whose tooth loads are drawn
_PIXELS = 150  # of the widest figure, for an inch
_CURVES = 6  # of a mechanism's bodies, joints or contacts: those with the largest values

# Text stays text, which is smaller and can be found; what is less than half a point off a straight
# line is left out; names of parts depend on their content alone, so that pages can be compared.
_SVG: Any = {"svg.fonttype": "none", "path.simplify_threshold": 0.5, "svg.hashsalt": "rustchain"}


class Drawn(NamedTuple):
    """A figure of a report: its title, and its SVG or why it was left out."""

    title: str
    svg: str = ""
    left_out: str = ""


def figures_of(result: Result) -> Iterator[Drawn]:
    """Yield the figures that a result has the data for, and why others are left out."""
    for title, draw in _wanted(result):
        try:
            with light_theme(), warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of runs too short for a spectrum
                figure = draw()
            yield Drawn(title, svg_of(figure))
        except (NotRecorded, InvalidInput) as error:
            yield Drawn(title, left_out=str(error))


def svg_of(figure: Figure) -> str:
    """Return a figure as SVG for a page, in whose colours it is drawn."""
    file = StringIO()
    with mpl.rc_context(_SVG):
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    text = file.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", text, flags=re.DOTALL)
    text = re.sub(r'font-family: [^;"]*(; )?', "", text)
    for color in IN_DARK:
        text = text.replace(color, f"var(--x{color[1:]})")
    # As wide as the page, unless its letters would become much larger than the page's.
    width = float(figure.get_size_inches()[0])
    style = f'style="max-width: {_PIXELS * width:.0f}px"'
    return re.sub(r'(<svg[^>]*?) width="[^"]*" height="[^"]*"', rf"\1 {style}", text, count=1)


def picture_of(result: Result) -> str:
    """Return the drive at the start of the simulation as SVG."""
    with light_theme():
        return svg_of(draw_drive(result.drive, start_positions(result)))


def _wanted(result: Result) -> list[tuple[str, Callable[[], Figure]]]:
    """Return the titles of the figures, and what draws them."""
    plot = result.plot
    if result.scene.kind == "mechanism":
        names = partial(_largest, result)
        return [
            ("Motion of the bodies", lambda: plot.motion(names("body", "velocities"))),
            ("Loads of joints", lambda: plot.joint_loads(names("joint", "peak_joint_force"))),
            ("Contact forces", lambda: plot.contact_force(names("contact", "peak_contact_force"))),
            ("Energy balance", plot.energy),
        ]
    sprockets = range(1, len(result.drive.sprockets) + 1)
    found: list[tuple[str, Callable[[], Figure]]] = [
        ("Tension of the strands", plot.tension),
        ("Hinge loads along the chain path", plot.hinge_loads),
        *(
            (f"Tooth loads of sprocket {k}", partial(plot.tooth_loads, k))
            for k in sprockets[:_SPROCKETS]
        ),
    ]
    if len(sprockets):
        found += [("Loads along the wrap", lambda: plot.wrap_loads(*sprockets[:_SPROCKETS]))]
        found += [("Engagement impacts", plot.engagements)]
    found += [
        (f"Transmission error and orders, sprocket {k}", partial(plot.transmission_error, k))
        for k in sprockets[1:_SPROCKETS]
    ]
    return [
        *found,
        ("Spectrum of the strand tensions", lambda: plot.spectrum("strand_tension")),
        ("Power balance", plot.power_balance),
        ("Contact pressure in the hinges", plot.contact_pressure),
        ("Contact pressure on the teeth", lambda: plot.contact_pressure("tooth")),
        ("Energy balance", plot.energy),
    ]


def _largest(result: Result, part: str, array: str) -> list[str]:
    """Return the names of the parts of which an array is largest, in their order."""
    names: tuple[str, ...] = getattr(result, f"{part}_names")
    if not names:
        raise InvalidInput(f"{part}: the scene has none")
    values = np.abs(result.array(array)).reshape(len(result.time), len(names), -1).max(axis=(0, 2))
    chosen = np.sort(np.argsort(-values, kind="stable")[:_CURVES])
    return [names[k] for k in chosen]
