"""Figures of loads over a revolution: chain path, teeth, wrap, pressure, impacts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rustchain import _rustchain
from rustchain.analysis.circuit import Circuit
from rustchain.analysis.window import rows_between
from rustchain.errors import InvalidInput
from rustchain.plot.between_rows import round_number
from rustchain.plot.colors import BLUE, GREY, ORANGE, PAPER, RED, STEEL, color_of
from rustchain.plot.finish import is_empty, note
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
from rustchain.typing import Array, Count, Time

if TYPE_CHECKING:
    import xarray as xr

_QUANTILES = (0.05, 0.95)


class LoadFigures(Figures):
    """The figures of loads over a revolution."""

    @styled
    def hinge_loads(self, *, start: Time = None, end: Time = None, ax: Ax = None) -> Figure:
        """Draw the hinge force along the chain path: mean, nine tenths of the reports, largest."""
        found = self.result.hinge_loads(quantiles=_QUANTILES, start=start, end=end)
        figure, axes = subplots(ax=ax, figsize=(7.0, 3.2))
        _band(axes, "position", found)
        circuit = Circuit.during(self.result, rows_between(self.result, start, end))
        for section in circuit.sections:
            if section.sprocket is None:
                continue
            for shift in (0, circuit.links):
                axes.axvspan(section.begin + shift, section.end + shift, color=GREY, alpha=0.12)
        middles = [0.5 * (each.begin + each.end) % circuit.links for each in circuit.sections]
        fitting = 18.0 * axes.bbox.width / figure.dpi  # characters in the width
        lines: list[float] = []  # where the last name of each line ends
        for middle, section in sorted(
            zip(middles, circuit.sections, strict=True), key=lambda each: each[0]
        ):
            half = 0.5 * len(section.name) / fitting * circuit.links
            x = min(max(middle, half), circuit.links - half)
            line = next((k for k, end in enumerate(lines) if end <= x - half), len(lines))
            lines[line : line + 1] = [x + half]
            axes.text(
                x, 0.99 - 0.06 * line, section.name, ha="center", va="top",
                fontsize=7.5, color=GREY, transform=axes.get_xaxis_transform(),
            )  # fmt: skip
        most = float(found["largest"].max())
        top = most / (0.98 - 0.06 * len(lines)) if most > 0.0 else None  # below the names
        axes.set(xlim=(0.0, circuit.links), ylim=(0.0, top))
        axes.set(xlabel="position along the chain path [pitches]", ylabel="hinge force [N]")
        legend_above(axes)
        return figure

    @styled
    def tooth_loads(
        self, sprocket: Count = 1, *, start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the tooth force over a sprocket's revolution, and the load of each tooth."""
        found = self.result.tooth_loads(sprocket, quantiles=_QUANTILES, start=start, end=end)
        figure, (left, right) = subplots(1, 2, ax=ax, figsize=(8.0, 3.2), width_ratios=(1.7, 1.0))
        _band(left, "angle", found.assign_coords(angle=np.degrees(found["angle"])))
        left.set(xlim=(0.0, 360.0), ylim=(0.0, None), xticks=range(0, 361, 60))
        left.set(xlabel="direction of the gap [°]", ylabel="tooth force [N]")
        legend_above(left)
        tooth = found["tooth"].to_numpy()
        right.bar(tooth, found["tooth_largest"], color=BLUE, alpha=0.25, label="largest")
        right.bar(tooth, found["tooth_mean"], color=BLUE, label="mean")
        right.set(xlabel=f"gap of sprocket {sprocket}", ylabel="force over a revolution [N]")
        legend_above(right)
        if is_empty(found["tooth_largest"]):
            right.set_yticks([])
            note(right, "no force in this part")
        return figure

    @styled
    def polar_tooth_loads(
        self,
        sprocket: Count = 1,
        *more: Count,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw the tooth force round a sprocket, by the direction in which the gap stands.

        The force is the distance from the circle over the tips of the teeth; circles are its scale.
        """
        numbers = (sprocket, *more)
        figure, cells = panels(len(numbers), "", "", size=(4.2, 4.4), share=False, ax=ax)
        drive = self.result.drive
        for axes, number in zip(cells, numbers, strict=True):
            found = self.result.tooth_loads(number, quantiles=_QUANTILES, start=start, end=end)
            outline = _rustchain.tooth_outline(drive.sprockets[number - 1], drive.chain, 12)
            outline = outline / np.hypot(*outline.T).max()
            axes.fill(*outline.T, facecolor=STEEL, edgecolor=GREY, linewidth=0.7)
            most = float(found["largest"].max())
            step = round_number(most / 2.0)
            found = found.dropna("angle", subset=["largest"])
            angle = found["angle"].to_numpy()
            around = np.append(angle, angle[:1])
            for name, color, width in (("largest", RED, 0.8), ("mean", BLUE, 1.4)):
                force = found[name].to_numpy()
                curve = _around(around, np.append(force, force[:1]), most)
                axes.plot(*curve, color=color, linewidth=width, label=name)
                if name == "mean":
                    axes.fill(*curve, color=color, alpha=0.15, linewidth=0.0, zorder=0.5)
            circle = np.linspace(0.0, 2.0 * np.pi, 181)
            base = _around(circle, np.zeros(181), most)
            axes.fill(*base, facecolor=PAPER, edgecolor=GREY, linewidth=0.4, zorder=0.6)
            for level in np.arange(step, 1.001 * most, step) if most > 0.0 else ():
                label = _clear_direction(angle, found["largest"].to_numpy())
                ring = _around(circle, np.full(181, level), most)
                axes.plot(*ring, color=GREY, linewidth=0.4, alpha=0.7)
                x, y = _around(label, np.full(1, level), most)[:, 0]
                axes.text(x, y, f"{level:g} N", fontsize=7.5, color=GREY)
            axes.set(aspect="equal", title=f"sprocket {number}")
            axes.set_axis_off()
        legend_outside(cells, "outside upper right", ax)
        return figure

    @styled
    def wrap_loads(
        self, sprocket: Count = 1, *more: Count, start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw how the load is distributed along the wrap of sprockets."""
        numbers = (sprocket, *more)
        x = "place in the wrap [pitches]"
        figure, cells = panels(len(numbers), x, "force [N]", share="y", ax=ax)
        for axes, number in zip(cells, numbers, strict=True):
            found = self.result.wrap_loads(number, quantiles=_QUANTILES, start=start, end=end)
            _band(axes, "position", found, "tooth, ")
            mean = found["hinge_mean"].dropna("position")
            axes.plot(mean["position"], mean, color=GREY, linestyle="--", label="hinge, mean")
            for place in (0.0, found.attrs["wrap"]):
                axes.axvline(place, color=GREY, linewidth=0.7)
            axes.set_title(f"sprocket {number}")
            axes.set_xlim(-1.0, found.attrs["wrap"] + 1.0)
        legend_outside(cells, "outside upper left", ax)
        cells[0].set_ylim(0.0, None)
        return figure

    @styled
    def contact_pressure(
        self,
        contact: Literal["hinge", "tooth"] = "hinge",
        *,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw the largest contact pressure over time, and its cycles per revolution."""
        found = self.result.contact_pressure(contact, start=start, end=end)
        part = "hinge" if contact == "hinge" else "bushing"
        figure, (left, right) = subplots(1, 2, ax=ax, figsize=(8.0, 3.0), width_ratios=(1.4, 1.0))
        pressure = 1e-6 * found["peak_pressure"]
        time = found["time"]
        left.plot(time, pressure.max(part), color=RED, linewidth=0.5, label="largest of all")
        left.plot(time, pressure.mean(part), color=BLUE, linewidth=0.6, label="mean of all")
        left.set(xlabel="time [s]", ylabel=f"pressure, all {part}s [MPa]", ylim=(0.0, None))
        legend_above(left)
        limit_ticks(left)
        try:
            _cycles(right, self.result.pressure_cycles(contact, start=start, end=end))
        except InvalidInput:  # the chain is open, or it hardly moves
            right.set(xticks=[], yticks=[])
            note(right, "no revolution of the chain in this part")
        return figure

    @styled
    def pressure_cycles(
        self,
        contact: Literal["hinge", "tooth"] = "hinge",
        sprocket: Count | None = None,
        *,
        bins: Count = 20,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw how many cycles of pressure a part sees per revolution, by range; who sees most."""
        cycles = self.result.pressure_cycles(contact, sprocket, bins=bins, start=start, end=end)
        part = str(cycles["cycles"].dims[0])
        figure, (left, right) = subplots(1, 2, ax=ax, figsize=(8.0, 3.0))
        _cycles(left, cycles)
        right.bar(cycles[part], 1e-6 * cycles["largest"], color=BLUE)
        of = f"{part}" if sprocket is None else f"gap of sprocket {sprocket}"
        right.set(xlabel=of, ylabel="largest pressure [MPa]")
        return figure

    @styled
    def guide_loads(
        self,
        guide: Count | str = 1,
        *more: Count | str,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw the load of guides along the chain path, and their whole force over time."""
        figure, cells = subplots(
            1 + len(more), 2, ax=ax, figsize=(8.0, 2.9 * (1 + len(more))), squeeze=False
        )
        for (left, right), number in zip(cells, (guide, *more), strict=True):
            found = self.result.guide_loads(number, quantiles=_QUANTILES, start=start, end=end)
            _band(left, "position", found)
            left.set(ylim=(0.0, None), xlabel="place from the guide's middle [pitches]")
            left.set(ylabel=f"guide {found.attrs['guide']}, force of a bushing [N]")
            legend_above(left)
            right.plot(found["time"], found["force"], color=BLUE, linewidth=0.6)
            right.axhline(found.attrs["mean_force"], color=GREY, linestyle="--")
            right.set(xlabel="time [s]", ylabel="force of all [N]", ylim=(0.0, None))
            if is_empty(found["largest"]):
                right.set_yticks([])
                note(right, "no contact with the guide in this part")
        return figure

    @styled
    def engagements(
        self,
        sprocket: Count | str | None = None,
        *,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw force and impulse of every engagement impact over time."""
        found = self.result.engagements(sprocket, start=start, end=end)
        figure, axes = subplots(2, 1, sharex=True, ax=ax, figsize=(7.0, 3.8))
        for number in sorted(found["sprocket"].unique().tolist()):
            rows = found[found["sprocket"] == number]
            color = color_of(number - 1)
            for cell, values in zip(axes, (rows["force"], 1e3 * rows["impulse"]), strict=True):
                cell.plot(rows["time"], values, "o", markersize=2.5, color=color)
            axes[0].plot([], [], "o", markersize=4.0, color=color, label=self._wheel_name(number))
        axes[0].set(ylabel="impact force [N]", ylim=(0.0, None))
        axes[1].set(ylabel="impulse [N ms]", xlabel="time [s]", ylim=(0.0, None))
        figure.align_ylabels()
        if len(found):
            legend_above(axes[0])
            return figure
        time = self.result.time[rows_between(self.result, start, end)]
        for cell in axes:
            cell.set_yticks([])
            note(cell, "no impacts in this part")
        if len(time) > 1:
            axes[1].set_xlim(time[0], time[-1])
        else:
            axes[1].set_xticks(time)
        return figure


def _band(axes: Axes, along: str, found: xr.Dataset, of: str = "") -> None:
    """Draw mean, the band between two quantiles, and the largest value; say where there is none.

    Lines go over places without values: of a drive at rest most places have none.
    """
    found = found.dropna(along, subset=["largest"])
    x = found[along]
    low, high = (found["quantiles"].isel(quantile=k) for k in (0, -1))
    axes.fill_between(x, low, high, color=BLUE, alpha=0.2, linewidth=0.0, label=f"{of}5 to 95 %")
    axes.plot(x, found["mean"], color=BLUE, label=f"{of}mean")
    axes.plot(x, found["largest"], color=RED, linewidth=0.6, label=f"{of}largest")
    if is_empty(found["largest"]):
        note(axes, "no force in this part")


def _around(angle: Array, force: Array, most: float) -> Array:
    """Return points at a distance of 1 and more from the centre by force, (2, points)."""
    radius = 1.05 + force / most if most > 0.0 else np.full(len(angle), 1.05)
    points: Array = radius * np.stack([np.cos(angle), np.sin(angle)])
    return points


def _clear_direction(angle: Array, force: Array) -> Array:
    """Return the direction nearest to 45 degrees with hardly a force within 30 degrees, (1,)."""
    apart = np.abs(np.angle(np.exp(1j * (angle[:, None] - angle))))
    near = np.where(apart < np.pi / 6.0, force, 0.0).max(axis=1)
    clear: Array = angle[near <= near.min() + 0.05 * force.max()]
    from_diagonal = np.abs(np.angle(np.exp(1j * (clear - np.pi / 4.0))))
    nearest = int(from_diagonal.argmin())
    return clear[nearest : nearest + 1]


def _cycles(axes: Axes, cycles: xr.Dataset) -> None:
    """Draw how many cycles there are of a range or of a larger one, in the mean of all parts."""
    part = str(cycles["cycles"].dims[0])
    mean = cycles["cycles"].mean(part).to_numpy()
    axes.step(
        1e-6 * cycles["range"].to_numpy(), np.cumsum(mean[::-1])[::-1], where="mid", color=ORANGE
    )
    axes.set(xlabel="range of the pressure [MPa] or more", xlim=(0.0, None))
    if mean.any():
        axes.set_yscale("log")
    else:
        axes.set_yticks([])
        note(axes, "no cycles in this part")
    label = f"cycles of a {part} per revolution"
    turns = cycles.attrs["revolutions"]
    if turns < 1.0:
        label += f",\nextrapolated from {turns:.2g} revolutions"
    axes.set_ylabel(label)
