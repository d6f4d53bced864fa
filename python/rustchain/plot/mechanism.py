"""Figures of bodies, joints and contacts of mechanisms: motion, paths, loads, residuals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rustchain.analysis.window import from_first_row, rows_between
from rustchain.arguments import shown
from rustchain.errors import InvalidInput
from rustchain.names import suggest
from rustchain.plot.colors import BLUE, ORANGE, RED, color_of
from rustchain.plot.finish import as_written
from rustchain.plot.style import (
    Ax,
    Figures,
    legend_above,
    legend_outside,
    limit_ticks,
    panels,
    styled,
    subplots,
)
from rustchain.results.result import Result
from rustchain.typing import Time

_RATES = {
    "position": ("m", "rad"),
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s²", "rad/s²"),
}
_NAMED = 12  # curves; the legend of more would be higher than some figures
_LONGEST = 30  # characters of a name in a legend, which would leave no width for the axes
_RESIDUAL_FLOOR = 1e-20  # drawn for zeros, which a logarithmic axis cannot show; below all rounding


class MechanismFigures(Figures):
    """The figures of bodies, and of joints and contacts of mechanisms.

    They are named, one by one or in a list. Without a name, all are drawn; of a drive, the
    sprockets and link 1. Above 12 names there is no legend.
    """

    @styled
    def motion(
        self,
        *bodies: str | Sequence[str],
        quantity: Literal["position", "velocity", "acceleration"] = "position",
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw positions of bodies, or their rates, over time: x, y and the angle.

        Without a name, all bodies of a mechanism are drawn; of a drive, the sprockets and "link_1".
        """
        names = _bodies(self.result, bodies)
        rows = rows_between(self.result, start, end)
        figure, cells = subplots(3, 1, sharex=True, ax=ax, figsize=(7.0, 5.2))
        way, turn = _RATES[quantity]
        labels = (f"x [{way}]", f"y [{way}]", f"angle [{turn}]")
        for k, name in enumerate(names):
            view = self.result.body(name)
            values = getattr(view, quantity)[rows]
            for axes, column in zip(cells, values.T, strict=True):
                axes.plot(view.time[rows], column, color=color_of(k), label=as_written(name))
        for axes, label in zip(cells, labels, strict=True):
            axes.set_ylabel(label if quantity == "position" else f"{quantity}, {label}")
        cells[-1].set_xlabel("time [s]")
        _legend(cells[0], ax)
        figure.align_ylabels()
        return figure

    @styled
    def paths(
        self, *bodies: str | Sequence[str], start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the paths of the bodies' centres of mass in the plane, with where they end.

        Without a name, all bodies of a mechanism are drawn; of a drive, the sprockets and "link_1".
        """
        names = _bodies(self.result, bodies)
        rows = rows_between(self.result, start, end)
        figure, axes = subplots(ax=ax, figsize=(5.4, 4.6))
        for k, name in enumerate(names):
            way = self.result.body(name).position[rows, :2]
            axes.plot(*way.T, color=color_of(k), label=as_written(name))
            axes.plot(*way[-1], "o", markersize=3.5, color=color_of(k))
        limit_ticks(axes)
        axes.set(xlabel="x [m]", ylabel="y [m]")
        axes.set_aspect("equal", adjustable="datalim")
        _legend(axes, ax)
        return figure

    @styled
    def contact_force(
        self, *contacts: str | Sequence[str], start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the force of contacts over time, side by side, with the largest between two rows."""
        names = names_of(self.result, "contact", contacts)
        rows = rows_between(self.result, start, end)
        figure, cells = panels(len(names), "time [s]", "contact force [N]", ax=ax)
        for axes, name in zip(cells, names, strict=True):
            view = self.result.contact(name)
            time = view.time[rows]
            forces = {"contact_force": view.force, "peak_contact_force": view.peak_force}
            forces = from_first_row({array: of[rows] for array, of in forces.items()}, rows)
            now, largest = forces.values()
            axes.plot(time, largest, color=RED, linewidth=0.5, label="largest")
            axes.plot(time, now, color=BLUE, label="at the row")
            axes.set_title(as_written(name))
        legend_outside(cells, "outside upper right", ax)
        return figure

    @styled
    def residuals(self, *, start: Time = None, end: Time = None, ax: Ax = None) -> Figure:
        """Draw the largest constraint residual of all joints over time, and its rate."""
        names_of(self.result, "joint", ())
        rows = rows_between(self.result, start, end)
        figure, axes = subplots(ax=ax, figsize=(7.0, 2.8))
        for name, label, color in (
            ("joint_position_residual", "positions [m or rad]", BLUE),
            ("joint_velocity_residual", "velocities [m/s or rad/s]", ORANGE),
        ):
            worst = self.result.array(name)[rows].max(axis=1)
            shown = np.maximum(worst, _RESIDUAL_FLOOR)
            axes.semilogy(self.result.time[rows], shown, color=color, label=label)
        axes.set(xlabel="time [s]", ylabel="largest residual")
        legend_above(axes)
        return figure


def joint_loads_figure(
    result: Result, joints: tuple[str | Sequence[str], ...], rows: slice, ax: Ax
) -> Figure:
    """Return the figure of force and torque of joints and drivers over time."""
    names = names_of(result, "joint", joints)
    figure, (upper, lower) = subplots(2, 1, sharex=True, ax=ax, figsize=(7.0, 4.2))
    for k, name in enumerate(names):
        view = result.joint(name)
        force = np.hypot(*view.force[rows].T)
        upper.plot(view.time[rows], force, color=color_of(k), label=as_written(name))
        lower.plot(view.time[rows], view.torque[rows], color=color_of(k))
    upper.set_ylabel("force [N]")
    lower.set_ylabel("torque [N m]")
    lower.set_xlabel("time [s]")
    _legend(upper, ax)
    figure.align_ylabels()
    return figure


def force_penetration_figure(
    result: Result, contacts: tuple[object, ...], rows: slice, ax: Ax
) -> Figure:
    """Return the figure of force against penetration of contacts, side by side."""
    names = names_of(result, "contact", contacts)
    figure, cells = panels(len(names), "penetration [µm]", "contact force [N]", share=False, ax=ax)
    for axes, name in zip(cells, names, strict=True):
        view = result.contact(name)
        depth, force = view.penetration[rows], view.force[rows]
        touching = force > 0.0
        axes.plot(1e6 * depth[touching], force[touching], "o", markersize=1.8, color=BLUE)
        axes.set(xlim=(0.0, None), ylim=(0.0, None))
        axes.set_title(as_written(name))
    return figure


def names_of(
    result: Result, part: str, given: tuple[object, ...], default: tuple[str, ...] = ()
) -> tuple[str, ...]:
    """Return the names that are given, one by one or in lists, which must exist.

    Without any, the default ones are returned, or all where there are none.
    """
    names: tuple[str, ...] = getattr(result, f"{part}_names")
    if not names:
        msg = f"{part}: the scene has none to draw"
        raise InvalidInput(msg)
    wanted: list[Any] = []
    for one in given:
        wanted += [one] if isinstance(one, str) or not isinstance(one, Sequence) else one
    for name in wanted:
        if name not in names:
            msg = f"{part}: {shown(name)} is no {part}; {suggest(name, names)}"
            raise InvalidInput(msg)
    return tuple(wanted) or default or names


def _bodies(result: Result, given: tuple[object, ...]) -> tuple[str, ...]:
    """Return the names of bodies that are given; of a drive by default sprockets and a link."""
    default: tuple[str, ...] = ()
    if result.scene.kind != "mechanism":
        default = ("link_1", *(f"sprocket_{k + 1}" for k in range(len(result.drive.sprockets))))
    return names_of(result, "body", given, default)


def _legend(axes: Axes, ax: Ax) -> None:
    """Name the curves beside the figure or the given axes, unless there are too many of them."""
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > _NAMED:
        return
    labels = [f"{name[: _LONGEST - 1]}…" if len(name) > _LONGEST else name for name in labels]
    if ax is None:
        axes.figure.legend(handles, labels, loc="outside right upper")
        return
    axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
