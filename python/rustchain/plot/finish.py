"""Parts of all figures: notes in empty axes, markers of single rows, and numbers of axes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import ScalarFormatter

from rustchain.plot.colors import GREY

_ROUNDING = 1e-11  # of a value: smaller ranges of an axis are rounding, which matplotlib widens


def note(axes: Axes, text: str) -> None:
    """Write in the middle of axes why they are empty."""
    axes.text(
        0.5, 0.5, text, ha="center", va="center", wrap=True, fontsize=8.0, color=GREY,
        transform=axes.transAxes,
    )  # fmt: skip


def as_written(name: str) -> str:
    """Return a name of the user for a figure: `$` begins no formula, `_` hides no legend entry."""
    shown = name.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def finish(all_axes: Iterable[Axes]) -> None:
    """Show curves of one row as markers, and axes without offsets."""
    for axes in all_axes:
        for line in axes.lines:
            if line.get_transform() == axes.transData and len(line.get_xdata()) == 1:  # type: ignore[arg-type]
                line.set(marker="o", markersize=4.0)
        for axis in (axes.xaxis, axes.yaxis):
            formatter = axis.get_major_formatter()
            if isinstance(formatter, ScalarFormatter):
                formatter.set_useOffset(False)
        low, high = axes.get_ylim()
        size = max(abs(low), abs(high))
        if axes.get_yscale() == "linear" and abs(high - low) < _ROUNDING * size:
            middle = 0.5 * (low + high)
            axes.set_ylim(middle - 0.05 * size, middle + 0.05 * size)


def is_empty(values: object) -> bool:
    """Return whether no value is a number above zero."""
    array = np.asarray(values, dtype=float)
    return not bool((array[np.isfinite(array)] > 0.0).any())
