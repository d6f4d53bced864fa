"""Key figures of a run with their confidence from its parts."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.summary import Summary
from rustchain.errors import RustchainError

if TYPE_CHECKING:
    from rustchain.results.result import Result

PARTS = 8  # of equal duration
_T = 2.3646  # quantile of Student's t distribution at 97.5 %, PARTS - 1 degrees of freedom
_ROWS = 16  # that each part has at least

# Figures that are means over time: the mean of the parts is that of the whole. The efficiency is a
# ratio of two means, and engagement impacts are events, of which parts may have unlike numbers.
_MEANS = re.compile(r"tension_.*(?<!_std)$|hinge_contact_share|loss")
_LABELS = (
    (r"tension_(.+)_std", r"standard deviation of the tension, strand \1"),
    (r"tension_(.+)", r"mean tension, strand \1"),
    ("hinge_contact_share", "share of time in contact, hinges"),
    (r"(\w+)_force_p99", r"\1 force: 99 % of the peaks are below"),
    (r"(\w+)_force_largest", r"largest \1 force"),
    ("engagement_force_mean", "mean force of engagement impacts"),
    ("engagement_force_p95", "engagement impacts: 95 % are below"),
    (r"transmission_error_(\d+)", r"transmission error of sprocket \1, peak to peak"),
    (r"ripple_(\d+)", r"ripple of the speed of sprocket \1, rms"),
    ("loss", "power lost"),
    ("tooth_jumps", "tooth jumps"),
)


@dataclass(frozen=True)
class KeyFigure:
    """A key figure of a run.

    Attributes
    ----------
    name, label : str
        Name in `Result.summary`, and in words.
    value : float
        Of the whole time.
    unit : str
        Empty of a ratio or a count.
    interval : (float, float), optional
        95 % confidence interval of the mean, from the means of the parts; None for other figures.
    spread : (float, float), optional
        Smallest and largest value of the parts; None where those are too short.
    """

    name: str
    label: str
    value: float
    unit: str
    interval: tuple[float, float] | None
    spread: tuple[float, float] | None


def key_figures(result: Result) -> list[KeyFigure]:
    """Return the key figures of a result, with intervals from eight parts of equal duration.

    The means of the parts are taken to be independent (docs/decisions/0037): what repeats within a
    revolution makes an interval wider than chance does, a change that outlasts a part narrower.
    """
    summary = result.summary()
    parts = _parts(result)
    units = summary.units
    found = []
    for name, value in summary.items():
        values = np.array([part[name] for part in parts if name in part])
        complete = len(values) == PARTS and bool(np.isfinite(values).all())
        interval = spread = None
        if complete:
            spread = float(values.min()), float(values.max())
        if complete and _MEANS.fullmatch(name):
            half = _T * float(values.std(ddof=1)) / np.sqrt(PARTS)
            interval = value - half, value + half
        unit = "" if units[name] == "1" else units[name]
        found.append(KeyFigure(name, label_of(name), value, unit, interval, spread))
    return found


def label_of(name: str) -> str:
    """Return a figure's name in words."""
    for pattern, label in _LABELS:
        if re.fullmatch(pattern, name):
            return re.sub(pattern, label, name)
    return name.replace("_", " ")


def _parts(result: Result) -> list[Summary]:
    """Return the key figures of each part; none where the parts have too few rows."""
    edges = np.linspace(result.time[0], result.time[-1], PARTS + 1)
    if len(result.time) < PARTS * _ROWS:
        return []
    found = []
    for start, end in pairwise(edges):
        try:
            found.append(result.summary(start=start, end=end))
        except RustchainError:  # nothing engaged in a part, or the chain jumped teeth there
            return []
    return found
