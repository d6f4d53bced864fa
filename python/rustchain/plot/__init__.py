"""Figures from a result, in the form of the published ones."""

from __future__ import annotations

from rustchain.plot.contacts import ContactFigures
from rustchain.plot.histories import HistoryFigures
from rustchain.plot.picture import DrivePicture

__all__ = ["Plots"]


class Plots(ContactFigures, HistoryFigures, DrivePicture):
    """The figures of a result; every method returns a matplotlib figure.

    `start` and `end` [s] choose a part of the time, by default all of it. Several hinges or
    bushings stand side by side.
    """
