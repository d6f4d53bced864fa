"""Shared parts of all figures: colours, style, panels, legends, and rows of a part of the time."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import to_hex, to_rgba, to_rgba_array
from matplotlib.figure import Figure
from matplotlib.ticker import AutoLocator

from rustchain.arguments import admitted, checked, shown
from rustchain.errors import InvalidInput
from rustchain.names import named_attributes
from rustchain.plot.colors import GREY, GRID, Theme, in_theme
from rustchain.plot.finish import finish
from rustchain.results.result import Result

_Draw = TypeVar("_Draw", bound=Callable[..., Any])
_STYLE: dict[str, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "figure.constrained_layout.use": True,
    "figure.dpi": 150,
}

_NARROW = 5.2  # width of axes [in] in which nine labels such as 0.0025 overlap

_theme: Theme = "light"


@checked
def use_theme(theme: Theme) -> None:
    """Draw the figures that follow on a light or on a dark ground, and the frames of animations.

    Reports and HTML pages with the player are light or dark as the browser has it.

    Parameters
    ----------
    theme : {"light", "dark"}
        Figures drawn into given axes keep the ground and the colours of these.
    """
    global _theme
    _theme = theme


def current_theme() -> Theme:
    """Return the theme of the figures that follow."""
    return _theme


@contextmanager
def light_theme() -> Iterator[None]:
    """Draw in light colours, whatever the theme: for a page, which replaces them by its own."""
    global _theme
    before, _theme = _theme, "light"
    try:
        yield
    finally:
        _theme = before


def styled(draw: _Draw) -> _Draw:
    """Give the figures that a function draws the style and the theme that all share."""

    @functools.wraps(draw)
    def drawn(*args: Any, **keywords: Any) -> Any:  # noqa: ANN401
        with style.context(_STYLE):
            figure = draw(*args, **keywords)
        if isinstance(figure, Picture):
            own = keywords.get("ax")
            finish(figure.axes if own is None else np.ravel(own))
        if _theme == "dark" and isinstance(figure, Picture):
            _darken(figure)
        return figure

    return drawn  # type: ignore[return-value]


def _darken(figure: Figure) -> None:
    """Give every part of a figure the colour that stands for its own on a dark ground."""
    for artist in figure.findobj():
        for part in ("color", "facecolor", "edgecolor", "markerfacecolor", "markeredgecolor"):
            get, put = getattr(artist, f"get_{part}", None), getattr(artist, f"set_{part}", None)
            if get is None or put is None:
                continue
            if isinstance(artist, Collection):
                if artist.get_array() is None:  # otherwise colours stand for values
                    put([_dark(color) for color in to_rgba_array(get())])
            elif not isinstance(get(), list | tuple) or len(get()):
                put(_dark(to_rgba(get())))


def _dark(color: Any) -> tuple[float, ...]:  # noqa: ANN401
    """Return what stands for a colour on a dark ground, as opaque as it is."""
    name = to_hex(color)  # without its opacity
    return (*to_rgba(in_theme(name, "dark"))[:3], color[3])


Ax: TypeAlias = Axes | Sequence[Axes] | None
"""Axes to draw into, as many as the figure has panels; None makes a figure."""


class Picture(Figure):
    """A figure that a notebook shows once, whether pyplot was imported or not."""

    def _repr_png_(self) -> bytes:
        image = BytesIO()
        self.savefig(image, format="png")
        return image.getvalue()


@named_attributes
@dataclass(frozen=True)
class Figures:
    """A result to be drawn."""

    result: Result

    def __post_init__(self) -> None:
        """Refuse what is no result."""
        admitted("Plots(result)", self.result, Result)

    def _wheel_name(self, number: int) -> str:
        """Return the name of a sprocket or guide by its number, in which guides follow."""
        toothed = len(self.result.drive.sprockets)
        return f"sprocket {number}" if number <= toothed else f"guide {number - toothed}"


def subplots(
    rows: int = 1,
    columns: int = 1,
    *,
    ax: Ax = None,
    figsize: tuple[float, float] | None = None,
    squeeze: bool = True,
    **sharing: Any,  # noqa: ANN401
) -> tuple[Figure, Any]:
    """Return a figure and its axes, as `pyplot.subplots` does but without pyplot's state.

    With `ax` given, return its figure and these axes, whose number must be rows x columns.
    """
    if ax is None:
        figure = Picture(figsize=figsize)
        return figure, figure.subplots(rows, columns, squeeze=squeeze, **sharing)
    given = np.array(ax, dtype=object).ravel()
    if len(given) != rows * columns or not all(isinstance(each, Axes) for each in given):
        msg = f"ax: got {shown(ax)}; expected {rows * columns} matplotlib Axes"
        raise InvalidInput(msg)
    grid = given.reshape(rows, columns)
    if squeeze:
        return given[0].figure, given[0] if len(given) == 1 else grid.squeeze()
    return given[0].figure, grid


def panels(
    count: int,
    x: str,
    y: str,
    size: tuple[float, float] = (4.2, 2.9),
    share: bool | Literal["y"] = True,
    ax: Ax = None,
) -> tuple[Figure, list[Axes]]:
    """Return a figure of panels side by side, at most three in a row, by default of one scale.

    With "y" they share the vertical scale alone.
    """
    columns = min(count, 3) if ax is None else count
    rows = -(-count // columns)
    figure, grid = subplots(
        rows,
        columns,
        ax=ax,
        sharex=share is True,
        sharey=bool(share),
        squeeze=False,
        figsize=(size[0] * columns, size[1] * rows),
    )
    cells: list[Axes] = list(grid.flat)
    for axes in cells[count:]:
        axes.remove()
    for axes in cells[:count]:
        limit_ticks(axes)
        axes.set_xlabel(x)
        axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel(y)
    return figure, cells[:count]


def limit_ticks(axes: Axes) -> None:
    """Set three to five ticks on the horizontal axis where labels of more would overlap.

    Ticks that a user set in given axes stay.
    """
    narrow = axes.bbox.width / axes.figure.dpi < _NARROW
    if narrow and type(axes.xaxis.get_major_locator()) is AutoLocator:
        axes.locator_params(axis="x", nbins=4, min_n_ticks=3)  # 4 intervals


def legend_outside(
    cells: Sequence[Axes], loc: Literal["outside upper left", "outside upper right"], ax: Ax
) -> None:
    """Put one legend for all panels above the figure, or above the first of given axes."""
    if ax is not None:
        legend_above(cells[0])
        return
    handles, labels = cells[0].get_legend_handles_labels()
    fitting = int(
        cells[0].figure.bbox.width / cells[0].figure.dpi // 1.5
    )  # an entry takes about 1.5 inches
    cells[0].figure.legend(handles, labels, loc=loc, ncols=max(1, min(len(labels), fitting)))


def legend_above(axes: Axes) -> None:
    """Put the legend in one row above the axes, where no curve runs."""
    columns = len(axes.get_legend_handles_labels()[1])
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2)


def legend_of_distinct(axes: Axes) -> None:
    """Name every label once, beside the title."""
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    axes.legend(
        once.values(),
        once,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=min(len(once), 3),  # more would cover the title
        borderaxespad=0.2,
        **({} if len(once) < 3 else {"handlelength": 1.0, "columnspacing": 0.8}),
    )
