"""Figures of the whole drive over time: tension of the strands, energy balance."""

from __future__ import annotations

from matplotlib.figure import Figure

from rustchain.analysis.window import rows_between
from rustchain.plot.colors import BLUE, GREEN, GREY, ORANGE, RED, color_of
from rustchain.plot.style import Ax, Figures, legend_above, panels, styled, subplots
from rustchain.typing import Array, Time


class HistoryFigures(Figures):
    """The figures of strands and energy over time."""

    @styled
    def tension(self, *, start: Time = None, end: Time = None, ax: Ax = None) -> Figure:
        """Draw the tension of all strands over time, and the pretension if there is one."""
        rows = rows_between(self.result, start, end)
        figure, (axes,) = panels(1, "time [s]", "strand tension [N]", size=(7.0, 2.8), ax=ax)
        for k, name in enumerate(self.result.strand_names):
            tension = self.result.strand(name).tension[rows]
            axes.plot(self.result.time[rows], tension, color=color_of(k), label=f"strand {name}")
        tensioner = self.result.drive.tensioner
        if tensioner is not None:
            axes.axhline(tensioner.pretension, color=GREY, linestyle="--", label="pretension")
        legend_above(axes)
        return figure

    @styled
    def energy(self, *, start: Time = None, end: Time = None, ax: Ax = None) -> Figure:
        """Draw the energy balance over time, and its residual.

        Sums count from the first of the rows, as those of `Result.between` do.
        """
        scale, unit = (1.0, "J") if self.result.scene.kind == "mechanism" else (1e3, "mJ")
        rows = rows_between(self.result, start, end)
        time, energy = self.result.time[rows], self.result.energy

        def since(values: Array) -> Array:
            counted: Array = values[rows] - values[rows.start] if rows.start else values[rows]
            return counted

        figure, (upper, lower) = subplots(
            2, 1, sharex=True, ax=ax, figsize=(7.0, 4.2), height_ratios=(2.2, 1.0)
        )
        curves = {
            "dissipated": (since(energy.dissipated), RED),
            "external work": (since(energy.external_work), GREEN),
            "kinetic, change": (energy.kinetic[rows] - energy.kinetic[rows.start], BLUE),
            "gravity, change": (energy.gravity[rows] - energy.gravity[rows.start], GREY),
            "elastic": (energy.elastic[rows], ORANGE),
        }
        for name, (values, color) in curves.items():
            upper.plot(time, scale * values, color=color, label=name)
        upper.set_ylabel(f"energy [{unit}]")
        legend_above(upper)
        lower.plot(time, scale * since(energy.residual), color=BLUE)
        lower.set_ylabel(f"residual [{unit}]")
        lower.set_xlabel("time [s]")
        figure.align_ylabels()
        return figure
