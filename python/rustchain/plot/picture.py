"""The picture of a drive at one instant: sprockets, links, pins and numbers."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.transforms import Bbox

from rustchain import _rustchain
from rustchain.caller import warn_caller
from rustchain.description.drive import ChainDrive
from rustchain.description.ends import AnchoredEnd, LoadedEnd
from rustchain.description.guides import GuideRail, SmoothIdler
from rustchain.plot.style import GREY, Ax, Figures, styled, subplots
from rustchain.typing import Array

if TYPE_CHECKING:
    from matplotlib.typing import ColorType

    from rustchain.results.result import Result

_INNER, _OUTER, _STEEL, _INK = "#5b8fb9", "#f0b35a", "#d5dae0", "#3b4048"
_RAIL, _ARM = "#cfe3d0", "#e6dccb"
_NUMBERS_APART = 0.15  # [inches] from their hinges
_LABELS = (0.75, 0.65)  # [in] that ticks, labels and title take; less leaves empty margins


class DrivePicture(Figures):
    """The drive as it stands at one instant."""

    @styled
    def drive(self, time: float | None = None, *, ax: Ax = None) -> Figure:
        """Draw the drive at the row nearest to `time` [s], by default at the start.

        Without bodies recorded, the start or the end is drawn, whichever is nearer, with a warning
        where that is not what was asked for.
        """
        time, positions = self._snapshot(time)
        drive, chain = self.result.drive, self.result.drive.chain
        links, others = positions[: chain.links], positions[drive.hinge_count :]
        rollers, wheels = np.split(others, [0 if chain.roller is None else chain.links])
        ends = positions[chain.links : drive.hinge_count]
        guides = wheels[len(drive.sprockets) :]
        wheels = wheels[: len(drive.sprockets)]
        hinges = _placed(links, np.array([[0.5 * chain.pitch, 0.0]]))[:, 0]
        if drive.ends is not None:  # the pin or bushing before the first link
            first = _placed(links[:1], np.array([[-0.5 * chain.pitch, 0.0]]))[:, 0]
            hinges = np.concatenate([hinges, first])
        shown = _extent(drive, hinges, wheels, ends)
        low, high = shown.min(axis=0) - 1.6 * chain.pitch, shown.max(axis=0) + 1.6 * chain.pitch
        figure, axes = subplots(ax=ax)
        covered: list[Array] = []  # outlines on which a number would be hard to read
        for sprocket, pose in zip(drive.sprockets, wheels[:, None], strict=True):
            outline = _placed(pose, _rustchain.tooth_outline(sprocket, chain, 12))
            covered += list(outline)
            _add_polygons(axes, outline, _STEEL, GREY)
            _add_polygons(axes, _placed(pose, _circle(0.5 * chain.pitch)), "white", GREY)
            mark = chain.pitch * np.array([[0.5, 0.0], [1.1, 0.0]])  # points to gap 0
            axes.plot(*_placed(pose, mark)[0].T, color=GREY, linewidth=1.2)
        for start, finish in self._arms(wheels, guides):
            # As wide as the links are; round ends, and its pivot.
            way = np.array([start, finish])
            width = 0.35 * chain.pitch
            _add_polygons(axes, _bar(way, width)[None], _ARM, GREY)
            _add_polygons(axes, (_circle(0.5 * width) + start)[None], "white", _INK)
            low, high = np.minimum(low, start - width), np.maximum(high, start + width)
        for guide, pose in zip(drive.guides, guides[:, None], strict=True):
            outline = _placed(pose, guide.outline() + _from_bearing(guide))
            covered += list(outline)
            _add_polygons(axes, outline, _RAIL, GREY)
            low = np.minimum(low, outline[0].min(axis=0) - 0.3 * chain.pitch)
            high = np.maximum(high, outline[0].max(axis=0) + 0.3 * chain.pitch)
        covered += _add_ends(axes, drive, ends)
        # First link, height of the drawn plate over the pitch, colour.
        for kind, share, color in ((0, 0.8, _INNER), (1, 0.7, _OUTER)):
            plate = _plate_outline(chain.pitch, share * chain.pitch)
            _add_polygons(axes, _placed(links[kind::2], plate), to_rgba(color, 0.55), color)
        if chain.roller is not None:
            ring = _circle(chain.roller.radius), _circle(chain.roller.bore_radius)
            for circle in ring:
                _add_polygons(axes, _placed(rollers, circle), "none", _INK)
            # A line on each shows how it has turned.
            mark = np.array([[chain.roller.bore_radius, 0.0], [chain.roller.radius, 0.0]])
            for line in _placed(rollers, mark):
                axes.plot(*line.T, color=_INK, linewidth=0.7)
        for radius, face in ((chain.bushing_radius, "none"), (chain.hinge.pin_radius, "white")):
            _add_polygons(axes, hinges[:, None] + _circle(radius), face, _INK)
        scale = min(8.0 / (high - low)[0], 10.0 / (high - low)[1])  # inches a metre
        apart = np.clip(_NUMBERS_APART / scale, chain.pitch, 1.5 * chain.pitch)
        free = [Path(outline) for outline in covered]
        # The last ones of a closed chain would stand in the way of the first.
        last = chain.links + (1 if drive.ends is not None else -1)
        for number in (1, *range(6, last, 5 * max(1, chain.links // 200))):
            here = hinges[number - 1]
            if len(wheels) == 2 and drive.ends is None:
                aside = _outward(here, wheels[:, :2])
            else:  # to the right of the chain, which runs counterclockwise
                along = hinges[number % len(hinges)] - hinges[number - 2]
                aside = np.array([along[1], -along[0]]) / np.hypot(*along)
            x, y = _clear_place(here, apart * aside, free, hinges)
            axes.text(x, y, str(number), fontsize=7.5, ha="center", va="center")

        width, height = (high - low) * scale
        if ax is None:
            figure.set_size_inches(max(width, 3.0) + _LABELS[0], max(height, 0.5) + _LABELS[1])
        axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axes.set(xlabel="x [mm]", ylabel="y [mm]", title=f"t = {time:.4g} s")
        axes.grid(visible=False)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(lambda value, _: f"{1e3 * value:g}".replace("-", "−"))
        return figure

    def _arms(self, wheels: Array, guides: Array) -> Iterator[tuple[Array, Array]]:
        """Yield from which pivot to where each arm reaches: to a sprocket, or to a blade's end."""
        drive = self.result.drive
        tensioner = drive.tensioner
        if tensioner is not None and tensioner.pivot is not None:
            yield np.array(tensioner.pivot), wheels[tensioner.sprocket - 1, :2]
        for guide, pose in zip(drive.guides, guides, strict=True):
            if isinstance(guide, SmoothIdler) or guide.arm is None:
                continue
            # To the nearer end of the blade, or to its middle where that is nearer.
            ends = guide.end_radius - 0.5 * guide.length
            marks = np.array([[0.0, ends], [0.0, 0.0], [0.0, -ends]])
            places = _placed(pose[None], marks + _from_bearing(guide))[0]
            yield pose[:2], places[np.argmin(np.hypot(*(places - pose[:2]).T))]

    def _snapshot(self, time: float | None) -> tuple[float, Array]:
        """Return the recorded time nearest to `time` and the positions then."""
        result = self.result
        row = 0 if time is None else int(np.abs(result.time - time).argmin())
        found = float(result.time[row])
        if "positions" in result.arrays:
            return found, result.arrays["positions"][row]
        last = len(result.time) - 1
        if row not in (0, last):
            row = last if 2 * row > last else 0
            found = float(result.time[row])
            msg = (
                f"drawn at t = {found:g} s: bodies were not recorded between start and end; "
                "pass record=(..., 'bodies') to run"
            )
            warn_caller(msg)
        return found, result.final_positions if row == last else result.initial_positions


def draw_drive(drive: ChainDrive, positions: Array, *, ax: Ax = None) -> Figure:
    """Draw a drive with its bodies at `positions`, (bodies, 3) [m, m, rad]."""
    start = SimpleNamespace(
        drive=drive,
        time=np.zeros(1),
        arrays={},
        initial_positions=positions,
        final_positions=positions,
    )
    return DrivePicture(cast("Result", start)).drive(ax=ax)


def _extent(drive: ChainDrive, hinges: Array, wheels: Array, ends: Array) -> Array:
    """Return points that the picture has to show, (points, 2)."""
    if drive.ends is None:
        return hinges
    # A sprocket of an open chain, or its load, may stand out of the chain's own frame.
    radius = [
        0.5 * drive.chain.pitch / np.sin(np.pi / sprocket.teeth) for sprocket in drive.sprockets
    ]
    corners = [
        pose[:2] + size * np.array(side)
        for pose, size in zip(wheels, radius, strict=False)
        for side in ((-1.0, -1.0), (1.0, 1.0))
    ]
    loads = [
        pose[:2] + _load_size(end) * np.array(side)
        for end, pose in zip(drive.ends[::-1], ends, strict=True)
        if isinstance(end, LoadedEnd)
        for side in ((-1.0, -1.0), (1.0, -1.0))
    ]
    return np.array([*hinges, *corners, *loads])


def _load_size(load: LoadedEnd) -> float:
    """Return the radius of a ball of steel with the mass of a load [m]."""
    return float(np.cbrt(load.mass / (7850.0 * 4.0 / 3.0 * np.pi)))


def _add_ends(axes: Axes, drive: ChainDrive, ends: Array) -> list[Array]:
    """Draw what an open chain ends in, and return the outlines of what is solid.

    Anchors are hatched, loads are balls of steel on their hooks.
    """
    balls: list[Array] = []
    if drive.ends is None:
        return balls
    pitch = drive.chain.pitch
    # The end behind the last link comes first in arrays.
    for end, pose, sign in zip(drive.ends[::-1], ends, (-1.0, 1.0), strict=True):
        if isinstance(end, AnchoredEnd):
            square = 0.55 * pitch * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
            _add_polygons(axes, (square + pose[:2])[None], "none", _INK)
            axes.plot(*(square[[0, 2]] + pose[:2]).T, color=_INK, linewidth=0.7)
            axes.plot(*(square[[1, 3]] + pose[:2]).T, color=_INK, linewidth=0.7)
        elif isinstance(end, LoadedEnd):
            balls.append(_circle(_load_size(end)) + pose[:2])
            _add_polygons(axes, balls[-1][None], _STEEL, _INK)
            pin = _placed(pose[None], np.array([[sign * end.arm, 0.0]]))[0, 0]
            axes.plot(*np.array([pin, pose[:2]]).T, color=_INK, linewidth=1.4)
    return balls


def _from_bearing(guide: GuideRail | SmoothIdler) -> Array:
    """Return a guide's middle in a frame at its bearing that turns with it [m]."""
    if isinstance(guide, SmoothIdler) or guide.arm is None:
        return np.zeros(2)
    out = np.array(guide.direction) / np.hypot(*guide.direction)
    arm = np.array(guide.center) - np.array(guide.arm.pivot)
    return np.array([arm @ out, out[0] * arm[1] - out[1] * arm[0]])


def _add_polygons(axes: Axes, outlines: Array, face: ColorType, edge: ColorType) -> None:
    """Add closed polygons, (polygons, points, 2)."""
    axes.add_collection(
        PolyCollection(list(outlines), facecolor=face, edgecolor=edge, linewidth=0.7)
    )


def _placed(poses: Array, points: Array) -> Array:
    """Return `points`, (points, 2), of a body at each of its `poses`: (poses, points, 2)."""
    cosine, sine = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turn = np.array([[cosine, -sine], [sine, cosine]])
    placed: Array = np.einsum("ijk,pj->kpi", turn, points) + poses[:, None, :2]
    return placed


def _bar(way: Array, width: float) -> Array:
    """Return the outline of a bar with round ends along `way`, (2, 2), as a polygon."""
    along = way[1] - way[0]
    angle = np.arctan2(along[1], along[0])
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 24) + angle
    half = 0.5 * width * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return np.concatenate([way[1] + half, way[0] - half])


def _circle(radius: float) -> Array:
    """Return a circle about the origin as a polygon, (points, 2)."""
    angle = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _plate_outline(pitch: float, height: float) -> Array:
    """Return the outline of a waisted link plate in its own frame, (points, 2)."""
    end, waist = 0.5 * height, 0.36 * height
    rise = ((0.5 * pitch) ** 2 - (end - waist) ** 2) / (2 * (end - waist))
    # The arc of the waist, about (0, rise), touches the round ends, about (+-pitch/2, 0).
    lean = np.arctan2(rise, 0.5 * pitch)
    round_end = np.linspace(lean - np.pi, np.pi - lean, 40)
    right = end * np.stack([np.cos(round_end), np.sin(round_end)], axis=-1) + [0.5 * pitch, 0.0]
    fall = np.linspace(-lean, lean - np.pi, 20)[1:-1]
    upper = (rise - waist) * np.stack([np.cos(fall), np.sin(fall)], axis=-1) + [0.0, rise]
    half = np.concatenate([right, upper])
    return np.concatenate([half, -half])


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
