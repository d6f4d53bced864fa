"""The picture of a drive at one instant: sprockets, links, pins and numbers."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.transforms import Bbox

from rustchain.caller import warn_caller
from rustchain.description.drive import ChainDrive
from rustchain.description.mechanism.builder import Mechanism
from rustchain.errors import NotRecorded
from rustchain.plot.drive_shapes import shapes_of_drive
from rustchain.plot.looks import LOOKS
from rustchain.plot.mechanism_shapes import shapes_of_mechanism
from rustchain.plot.shapes import Shapes, force_points, outlines_at
from rustchain.plot.style import Ax, Figures, styled, subplots
from rustchain.typing import Array, Time

_NUMBERS_APART = 0.15  # [inches] from their hinges
_NUMBER = np.array([0.12, 0.07])  # [inches] half of a number of three figures
_BETWEEN = 0.3  # [inches] from number to number along a chain, at least
_ROOM = np.array([8.0, 10.0])  # [inches] that a drawing takes at most
_LABELS = (0.75, 0.65)  # [in] that ticks, labels and title take; less leaves empty margins
_MARGIN = 1.2  # [pitches] round all that is drawn; numbers may need more


class DrivePicture(Figures):
    """The drive as it stands at one instant."""

    @styled
    def drive(self, time: Time = None, *, ax: Ax = None) -> Figure:
        """Draw the drive at the row nearest to `time` [s], by default at the start.

        Without bodies recorded, the start or the end is drawn, whichever is nearer, with a warning
        if it is not the requested time.
        """
        return _figure_of_drive(self.result.drive, *self._snapshot(time), ax)

    def _snapshot(self, time: Time) -> tuple[float, Array]:
        """Return the recorded time nearest to `time` and the positions then."""
        result = self.result
        row = 0 if time is None else int(np.abs(result.time - time).argmin())
        found = float(result.time[row])
        if "positions" in result.arrays:
            return found, result.arrays["positions"][row]
        last = len(result.time) - 1
        between = row not in (0, last)
        if between:
            row = last if 2 * row > last else 0
            found = float(result.time[row])
        positions = result.final_positions if row == last else result.initial_positions
        if not np.isfinite(positions).all():
            msg = (
                f"positions at t = {found:g} s: bodies were not recorded, and t is no end of the "
                "run; pass record=(..., 'bodies') to run, or draw the whole result"
            )
            raise NotRecorded(msg)
        if between:
            msg = (
                f"drawn at t = {found:g} s: bodies were not recorded between start and end; "
                "pass record=(..., 'bodies') to run"
            )
            warn_caller(msg)
        return found, positions


@styled
def draw_drive(drive: ChainDrive, positions: Array, *, ax: Ax = None) -> Figure:
    """Draw a drive at its start, with its bodies at `positions`, (bodies, 3) [m, m, rad]."""
    return _figure_of_drive(drive, 0.0, positions, ax)


def _figure_of_drive(drive: ChainDrive, time: float, positions: Array, ax: Ax) -> Figure:
    """Return the picture of a drive at a time [s], with its bodies at `positions`."""
    chain = drive.chain
    shapes = shapes_of_drive(drive)
    figure, axes = subplots(ax=ax)
    covered = _draw_outlines(axes, shapes, positions)
    room = _ROOM if ax is None else np.array(axes.bbox.size) / axes.figure.dpi
    low, high, scale = _limits(shapes, positions, room)
    apart = max(_NUMBERS_APART / scale, chain.pitch)
    fives = max(1, chain.links // 200, math.ceil(_BETWEEN / (5.0 * chain.pitch * scale)))
    hinges = force_points(shapes.forces[0], positions)
    if drive.ends is not None:  # the last one joins both ends: it does not exist
        hinges = np.delete(hinges, chain.links, axis=0)
    first = len(positions) - len(drive.sprockets) - len(drive.guides)
    wheels = positions[first : len(positions) - len(drive.guides)]
    # The last numbers of a closed chain would overlap with the first one.
    last = chain.links + (1 if drive.ends is not None else -1)
    for number in (1, *range(6, last, 5 * fives)):
        here = hinges[number - 1]
        if len(wheels) == 2 and drive.ends is None:
            aside = _outward(here, wheels[:, :2])
        else:  # to the right of the chain, which runs counterclockwise
            along = hinges[number % len(hinges)] - hinges[number - 2]
            aside = np.array([along[1], -along[0]]) / np.hypot(*along)
        x, y = _clear_place(here, apart * aside, covered, hinges)
        axes.text(x, y, str(number), fontsize=7.5, ha="center", va="center")

    if ax is None:
        _fit(figure, (high - low) * scale)
    axes.set(title=f"t = {time:.4g} s")
    _label(axes, low, high)
    return figure


@styled
def draw_mechanism(mechanism: Mechanism, positions: Array) -> Figure:
    """Draw a mechanism with its bodies at `positions`, (bodies, 3) [m, m, rad]."""
    shapes = shapes_of_mechanism(mechanism)
    figure, axes = subplots()
    _draw_outlines(axes, shapes, positions)
    low, high, scale = _limits(shapes, positions, _ROOM)
    _fit(figure, (high - low) * scale)
    _label(axes, low, high)
    return figure


def _draw_outlines(axes: Axes, shapes: Shapes, positions: Array) -> list[Path]:
    """Draw all outlines; return those on which a number would be hard to read."""
    covered: list[Path] = []
    for kind, look in LOOKS["light"].items():
        for shape in (each for each in shapes.outlines if each.kind == kind):
            outlines = list(outlines_at(shape, positions))
            if not shape.closed:
                axes.add_collection(LineCollection(outlines, colors=look.edge, linewidths=1.0))
                continue
            face = "none" if look.face is None else to_rgba(look.face, look.opacity)
            filled = PolyCollection(outlines, facecolor=face, edgecolor=look.edge, linewidth=0.7)
            axes.add_collection(filled)
            if kind in ("sprocket", "rail", "load"):
                covered += [Path(outline) for outline in outlines]
    return covered


def _limits(shapes: Shapes, positions: Array, room: Array) -> tuple[Array, Array, float]:
    """Return the corners of what is drawn [m], and its scale [inches a metre] in a room [inches].

    The margin has the numbers, whose size in metres depends on the scale.
    """
    low, high = shapes.extent(positions)
    numbers = _NUMBERS_APART + _NUMBER
    coarse = float(np.max((high - low) / np.maximum(room - 2.0 * numbers, 0.5 * room)))
    margin = np.maximum(_MARGIN * shapes.size, numbers * coarse)
    low, high = low - margin, high + margin
    return low, high, float(np.min(room / (high - low)))


def _fit(figure: Figure, size: Array) -> None:
    """Give a figure the size of its drawing [inches]."""
    width, height = size
    figure.set_size_inches(max(width, 3.0) + _LABELS[0], max(height, 0.5) + _LABELS[1])


def _label(axes: Axes, low: Array, high: Array) -> None:
    """Set limits and labels of both axes, in mm."""
    axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set(xlabel="x [mm]", ylabel="y [mm]")
    axes.grid(visible=False)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda value, _: f"{1e3 * value:g}".replace("-", "−"))


def _outward(point: Array, centers: Array) -> Array:
    """Return the direction at a point away from the line that joins `centers`."""
    along = centers[-1] - centers[0]
    share = np.clip((point - centers[0]) @ along / (along @ along), 0.0, 1.0)
    away = point - centers[0] - share * along
    outward: Array = away / np.linalg.norm(away)
    return outward


def _clear_place(point: Array, aside: Array, covered: list[Path], hinges: Array) -> Array:
    """Return the place beside a point, or on its other side, where nothing is drawn, if any."""
    apart = np.hypot(*aside)
    room = apart * np.array([[-0.5, -0.35], [0.5, 0.35]])  # that two figures take
    for place in (point + aside, point - aside):
        if np.hypot(*(hinges - place).T).min() > 0.8 * apart and not any(
            outline.intersects_bbox(Bbox(place + room)) for outline in covered
        ):
            clear: Array = place
            return clear
    beside: Array = point + aside
    return beside
