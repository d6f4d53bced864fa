"""Figures from a result, in the form of the published ones."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from rustchain import _rustchain
from rustchain._names import known_keywords, suggest
from rustchain.errors import InvalidInput
from rustchain.guides import GuideRail, SmoothIdler
from rustchain.result import Array, Bushing, Result

if TYPE_CHECKING:
    from matplotlib.typing import ColorType

BLUE, ORANGE, GREEN, RED, GREY = "#0b64a0", "#d9730d", "#2a8f5b", "#b8323a", "#7a7f87"
_CYCLE = (BLUE, ORANGE, GREEN, RED, "#7d5ba6", "#8c6d1f", "#1d9a9a", "#c2608f")
_INNER, _OUTER, _STEEL, _INK = "#5b8fb9", "#f0b35a", "#d5dae0", "#3b4048"
_RAIL = "#cfe3d0"
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
    "grid.color": "#e4e7eb",
    "grid.linewidth": 0.6,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "figure.constrained_layout.use": True,
    "figure.dpi": 150,
}
_SURFACES = (BLUE, ORANGE, GREEN, RED)  # of the tooth, from the seat outward

_styled = style.context(_STYLE)


@dataclass(frozen=True)
class Plots:
    """The figures of a result; every method returns a matplotlib figure.

    `start` and `end` [s] choose a part of the time, by default all of it. Several hinges or
    bushings stand side by side.
    """

    result: Result

    @known_keywords
    @_styled
    def hinge_force(
        self, hinge: int, *more: int, start: float | None = None, end: float | None = None
    ) -> Figure:
        """Draw the contact force of hinges over time."""
        numbers = (hinge, *more)
        rows = self._rows(start, end)
        figure, panels = _panels(len(numbers), "time [s]", "pin / bushing force [N]")
        for axes, number in zip(panels, numbers, strict=True):
            view = self.result.hinge(number)
            axes.plot(view.time[rows], view.force[rows], color=BLUE)
            axes.set_title(f"hinge {number}")
        return figure

    @known_keywords
    @_styled
    def tooth_force(
        self, bushing: int, *more: int, start: float | None = None, end: float | None = None
    ) -> Figure:
        """Draw the tooth force of bushings over time, each stay with its sprocket and gap."""
        numbers = (bushing, *more)
        window = self._rows(start, end)
        figure, panels = _panels(len(numbers), "time [s]", "bushing / tooth force [N]")
        for axes, number in zip(panels, numbers, strict=True):
            view = self.result.bushing(number)
            axes.plot(
                view.time[window], np.zeros_like(view.time[window]), color=GREY, linewidth=0.5
            )
            for rows, sprocket, tooth in _visits(view, window):
                time, force = view.time[rows], view.tooth_force[rows]
                color = _CYCLE[(sprocket - 1) % len(_CYCLE)]
                axes.plot(time, force, color=color, label=f"sprocket {sprocket}")
                axes.annotate(
                    f"tooth {tooth}",
                    (time.mean(), force.max()),
                    xytext=(0, 2),
                    textcoords="offset points",
                    horizontalalignment="center",
                    fontsize=7.5,
                    color=color,
                )
            axes.set_title(f"bushing {number}")
            axes.margins(y=0.12)
            _legend_of_distinct(axes)
        return figure

    @known_keywords
    @_styled
    def force_penetration(
        self,
        number: int,
        *more: int,
        contact: Literal["tooth", "hinge"] = "tooth",
        start: float | None = None,
        end: float | None = None,
    ) -> Figure:
        """Draw force against penetration of bushings on teeth, or of pins in bushings.

        Tooth contacts are coloured by the region of the tooth that the bushing is on; with regions
        "kept" its stiffness is that of the region where the contact began, so that points of one
        colour may lie on two lines. Hinges are shown with the elastic part of their law.
        """
        if contact not in ("tooth", "hinge"):
            msg = f"contact: {contact!r} is no contact; {suggest(contact, ('tooth', 'hinge'))}"
            raise InvalidInput(msg)
        numbers = (number, *more)
        rows = self._rows(start, end)
        draw = self._tooth_loops if contact == "tooth" else self._hinge_loops
        label = "bushing / tooth" if contact == "tooth" else "pin / bushing"
        figure, panels = _panels(len(numbers), "penetration [µm]", f"{label} force [N]")
        for axes, one in zip(panels, numbers, strict=True):
            draw(axes, one, rows)
            _legend_of_distinct(axes)
        panels[0].set(xlim=(0.0, None), ylim=(0.0, None))  # of all panels
        return figure

    @known_keywords
    @_styled
    def orbit(
        self, hinge: int, *more: int, start: float | None = None, end: float | None = None
    ) -> Figure:
        """Draw the path of a pin's centre in its bushing, with the circle where contact begins."""
        numbers = (hinge, *more)
        rows = self._rows(start, end)
        clearance = 1e6 * self.result.drive.chain.hinge.clearance
        figure, panels = _panels(len(numbers), "x [µm]", "y [µm]", size=(3.5, 3.4))
        for axes, number in zip(panels, numbers, strict=True):
            path = 1e6 * self.result.hinge(number).eccentricity[rows]
            axes.plot(*path.T, color=BLUE, linewidth=0.4, alpha=0.8)
            axes.add_patch(Circle((0.0, 0.0), clearance, fill=False, color=RED, zorder=3))
            axes.set_aspect("equal")
            axes.set_xlim(-1.2 * clearance, 1.2 * clearance)
            axes.set_ylim(-1.2 * clearance, 1.2 * clearance)
            axes.set_title(f"pin {number} in its bushing")
        return figure

    @known_keywords
    @_styled
    def tension(self, *, start: float | None = None, end: float | None = None) -> Figure:
        """Draw the tension of all strands over time, and the pretension if there is one."""
        rows = self._rows(start, end)
        figure, (axes,) = _panels(1, "time [s]", "strand tension [N]", size=(7.0, 2.8))
        for k, name in enumerate(self.result.strand_names):
            strand, color = self.result.strand(name), _CYCLE[k % len(_CYCLE)]
            axes.plot(strand.time[rows], strand.tension[rows], color=color, label=f"{name} strand")
        tensioner = self.result.drive.tensioner
        if tensioner is not None:
            axes.axhline(tensioner.pretension, color=GREY, linestyle="--", label="pretension")
        _legend_above(axes)
        return figure

    @known_keywords
    @_styled
    def energy(self, *, start: float | None = None, end: float | None = None) -> Figure:
        """Draw the energy balance over time, and what it misses."""
        rows = self._rows(start, end)
        energy, time = self.result.energy, self.result.time[rows]
        figure, (upper, lower) = plt.subplots(
            2, 1, sharex=True, figsize=(7.0, 4.2), height_ratios=(2.2, 1.0)
        )
        curves = {
            "dissipated": (energy.dissipated, RED),
            "worked in": (energy.worked_in, GREEN),
            "kinetic, change": (energy.kinetic - energy.kinetic[0], BLUE),
            "gravity, change": (energy.gravity - energy.gravity[0], GREY),
            "elastic": (energy.elastic, ORANGE),
        }
        for name, (values, color) in curves.items():
            upper.plot(time, 1e3 * values[rows], color=color, label=name)
        upper.set_ylabel("energy [mJ]")
        _legend_above(upper)
        lower.plot(time, 1e3 * energy.residual[rows], color=BLUE)
        lower.set_ylabel("residual [mJ]")
        lower.set_xlabel("time [s]")
        figure.align_ylabels()
        return figure

    @known_keywords
    @_styled
    def drive(self, time: float | None = None) -> Figure:
        """Draw the drive at the row nearest to `time` [s], by default at the start.

        Without bodies recorded, the start or the end is drawn, whichever is nearer, with a warning
        where that is not what was asked for.
        """
        time, positions = self._snapshot(time)
        drive, chain = self.result.drive, self.result.drive.chain
        links, wheels = positions[: chain.links], positions[chain.links :]
        guides = wheels[len(drive.sprockets) :]
        wheels = wheels[: len(drive.sprockets)]
        hinges = _placed(links, np.array([[0.5 * chain.pitch, 0.0]]))[:, 0]
        low = hinges.min(axis=0) - 1.6 * chain.pitch
        high = hinges.max(axis=0) + 1.6 * chain.pitch
        width, height = (high - low) * min(8.0 / (high - low)[0], 10.0 / (high - low)[1])
        figure, axes = plt.subplots(figsize=(max(width, 3.0), max(height, 0.5) + 0.6))

        for sprocket, pose in zip(drive.sprockets, wheels[:, None], strict=True):
            outline = _rustchain.tooth_outline(sprocket, chain, 12)
            _add_polygons(axes, _placed(pose, outline), _STEEL, GREY)
            _add_polygons(axes, _placed(pose, _circle(0.5 * chain.pitch)), "white", GREY)
            mark = chain.pitch * np.array([[0.5, 0.0], [1.1, 0.0]])  # points to gap 0
            axes.plot(*_placed(pose, mark)[0].T, color=GREY, linewidth=1.2)
        for guide, pose in zip(drive.guides, guides[:, None], strict=True):
            outline = guide.outline() + _from_bearing(guide)
            _add_polygons(axes, _placed(pose, outline), _RAIL, GREY)
        # First link, height of the drawn plate over the pitch, colour.
        for first, share, color in ((0, 0.8, _INNER), (1, 0.7, _OUTER)):
            plate = _plate_outline(chain.pitch, share * chain.pitch)
            _add_polygons(axes, _placed(links[first::2], plate), to_rgba(color, 0.55), color)
        for radius, face in ((chain.bushing_radius, "none"), (chain.hinge.pin_radius, "white")):
            _add_polygons(axes, hinges[:, None] + _circle(radius), face, _INK)
        for number in (1, *range(6, chain.links + 1, 5 * max(1, chain.links // 200))):
            here = hinges[number - 1]
            if len(wheels) == 2:
                x, y = _outside(here, wheels[:, :2], chain.pitch)
            else:  # to the right of the chain, which runs counterclockwise
                along = hinges[number % chain.links] - hinges[number - 2]
                x, y = here + chain.pitch * np.array([along[1], -along[0]]) / np.hypot(*along)
            axes.text(x, y, str(number), fontsize=7.5, ha="center", va="center")

        axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axes.set(xlabel="x [mm]", ylabel="y [mm]", title=f"t = {time:.4g} s")
        axes.grid(visible=False)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(lambda value, _: f"{1e3 * value:g}".replace("-", "−"))
        return figure

    def _rows(self, start: float | None, end: float | None) -> slice:
        """Return the rows from `start` to `end`."""
        time = self.result.time
        first = 0 if start is None else int(np.searchsorted(time, start, "left"))
        last = len(time) if end is None else int(np.searchsorted(time, end, "right"))
        if first >= last:
            span = f"{time[0]:g} to {time[-1]:g} s"
            msg = f"start={start}, end={end}: no rows there; the result has {span}"
            raise InvalidInput(msg)
        return slice(first, last)

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
            warnings.warn(msg, UserWarning, stacklevel=3)
        return found, result.final_positions if row == last else result.initial_positions

    def _tooth_loops(self, axes: Axes, number: int, rows: slice) -> None:
        """Draw force against penetration of a bushing, coloured by region."""
        view = self.result.bushing(number)
        force, region = view.tooth_force[rows], view.region[rows]
        touching = force > 0.0
        penetration = 1e6 * view.tooth_penetration[rows]
        drive = self.result.drive
        for wheel, sprocket in enumerate(drive.sprockets, 1):
            names = _rustchain.tooth_surfaces(sprocket, drive.chain)
            for step, name in enumerate(names):
                there = touching & (view.sprocket[rows] == wheel)
                there &= np.abs(region - len(names)) == step
                if there.any():
                    (dots,) = axes.plot(penetration[there], force[there], "o", markersize=2.2)
                    dots.set_color(_SURFACES[step % len(_SURFACES)])
                    dots.set_label(name.removesuffix(" curve"))
        axes.set_title(f"bushing {number}")

    def _hinge_loops(self, axes: Axes, number: int, rows: slice) -> None:
        """Draw force against penetration of a hinge, over the elastic part of its law."""
        view, chain = self.result.hinge(number), self.result.drive.chain
        hinge = chain.hinge
        touching = view.force[rows] > 0.0
        penetration, force = view.penetration[rows][touching], view.force[rows][touching]
        axes.plot(1e6 * penetration, force, "o", markersize=1.8, color=BLUE)
        if touching.any():
            depth = np.linspace(0.0, penetration.max(), 200)
            radii = hinge.pin_radius, hinge.bore_radius
            law = self.result.hinge_law
            elastic = _rustchain.law_force(
                law, "internal", *radii, hinge.length, chain.material, depth
            )
            axes.plot(
                1e6 * depth, elastic, color=RED, linewidth=1.0, label=f"{law.elastic}, elastic part"
            )
        axes.set_title(f"hinge {number}")


def _from_bearing(guide: GuideRail | SmoothIdler) -> Array:
    """Return a guide's middle in a frame at its bearing that turns with it [m]."""
    if isinstance(guide, SmoothIdler) or guide.arm is None:
        return np.zeros(2)
    out = np.array(guide.direction) / np.hypot(*guide.direction)
    arm = np.array(guide.center) - np.array(guide.arm.pivot)
    return np.array([arm @ out, out[0] * arm[1] - out[1] * arm[0]])


def _panels(
    count: int, x: str, y: str, size: tuple[float, float] = (4.2, 2.9)
) -> tuple[Figure, list[Axes]]:
    """Return a figure of panels side by side, at most three in a row, with shared axes."""
    columns = min(count, 3)
    rows = -(-count // columns)
    figure, grid = plt.subplots(
        rows,
        columns,
        sharex=True,
        sharey=True,
        squeeze=False,
        figsize=(size[0] * columns, size[1] * rows),
    )
    panels: list[Axes] = list(grid.flat)
    for axes in panels[count:]:
        axes.remove()
    for axes in panels[:count]:
        axes.set_xlabel(x)
        axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel(y)
    return figure, panels[:count]


def _visits(bushing: Bushing, window: slice) -> Iterator[tuple[slice, int, int]]:
    """Yield each stay in one tooth gap, flights between impacts included: rows, sprocket, gap."""
    rows = np.flatnonzero(bushing.sprocket[window]) + window.start
    if rows.size == 0:
        return
    where = np.stack([bushing.sprocket[rows], bushing.tooth[rows]])
    changes = np.flatnonzero((np.diff(where) != 0).any(axis=0)) + 1
    for stay in np.split(rows, changes):
        rows_of_stay = slice(max(stay[0] - 1, window.start), min(stay[-1] + 2, window.stop))
        yield rows_of_stay, int(bushing.sprocket[stay[0]]), int(bushing.tooth[stay[0]])


def _legend_above(axes: Axes) -> None:
    """Put the legend in one row above the axes, where no curve runs."""
    columns = len(axes.get_legend_handles_labels()[1])
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2)


def _legend_of_distinct(axes: Axes) -> None:
    """Name every label once, beside the title."""
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    axes.legend(
        once.values(),
        once,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=len(once),
        borderaxespad=0.2,
    )


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


def _outside(point: Array, centers: Array, distance: float) -> Array:
    """Return the point moved by `distance` away from the line that joins `centers`."""
    along = centers[-1] - centers[0]
    share = np.clip((point - centers[0]) @ along / (along @ along), 0.0, 1.0)
    away = point - centers[0] - share * along
    moved: Array = point + distance * away / np.linalg.norm(away)
    return moved
