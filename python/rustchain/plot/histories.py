"""Figures of the whole drive over time: tension of the strands, energy balance."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from rustchain._names import known_keywords
from rustchain.plot.style import (
    BLUE,
    CYCLE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    Figures,
    legend_above,
    panels,
    styled,
)


class HistoryFigures(Figures):
    """The figures of strands and energy over time."""

    @known_keywords
    @styled
    def tension(self, *, start: float | None = None, end: float | None = None) -> Figure:
        """Draw the tension of all strands over time, and the pretension if there is one."""
        rows = self.rows(start, end)
        figure, (axes,) = panels(1, "time [s]", "strand tension [N]", size=(7.0, 2.8))
        for k, name in enumerate(self.result.strand_names):
            strand, color = self.result.strand(name), CYCLE[k % len(CYCLE)]
            axes.plot(strand.time[rows], strand.tension[rows], color=color, label=f"{name} strand")
        tensioner = self.result.drive.tensioner
        if tensioner is not None:
            axes.axhline(tensioner.pretension, color=GREY, linestyle="--", label="pretension")
        legend_above(axes)
        return figure

    @known_keywords
    @styled
    def energy(self, *, start: float | None = None, end: float | None = None) -> Figure:
        """Draw the energy balance over time, and what it misses."""
        rows = self.rows(start, end)
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
        legend_above(upper)
        lower.plot(time, 1e3 * energy.residual[rows], color=BLUE)
        lower.set_ylabel("residual [mJ]")
        lower.set_xlabel("time [s]")
        figure.align_ylabels()
        return figure
