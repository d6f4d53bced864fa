"""Figures from a result, in the form of the published ones; of studies and loss maps."""

from __future__ import annotations

from rustchain.arguments import checked_methods
from rustchain.extras import matplotlib as _matplotlib  # noqa: F401, names the extra
from rustchain.plot.contacts import ContactFigures
from rustchain.plot.histories import HistoryFigures
from rustchain.plot.joints import JointFigures
from rustchain.plot.loads import LoadFigures
from rustchain.plot.mechanism import MechanismFigures
from rustchain.plot.motion import MotionFigures
from rustchain.plot.picture import DrivePicture
from rustchain.plot.studies import draw_loss_map, draw_map, draw_waterfall
from rustchain.plot.style import use_theme

__all__ = ["Plots", "draw_loss_map", "draw_map", "draw_waterfall", "use_theme"]


@checked_methods
class Plots(
    ContactFigures,
    JointFigures,
    LoadFigures,
    MotionFigures,
    HistoryFigures,
    DrivePicture,
    MechanismFigures,
):
    """The figures of a result; every method returns a matplotlib figure.

    `start` and `end` [s] choose a part of the time, by default all of it. Several hinges or
    bushings stand side by side. Bodies, joints and contacts of mechanisms go by their names.
    """
