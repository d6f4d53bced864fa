"""Figures of single contacts: forces over time, force against penetration, orbits of pins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from rustchain import _rustchain
from rustchain.analysis.window import rows_between
from rustchain.arguments import admitted, shown
from rustchain.errors import InvalidInput
from rustchain.names import suggest
from rustchain.plot.colors import BLUE, CYCLE, GREEN, GREY, ORANGE, RED
from rustchain.plot.mechanism import force_penetration_figure
from rustchain.plot.style import Ax, Figures, legend_of_distinct, panels, styled
from rustchain.results.views import Bushing
from rustchain.typing import Time

_SHOWN = 2  # hinges or bushings, where none are named
_SURFACES = (BLUE, ORANGE, GREEN, RED)  # of the tooth, from the seat outward


class ContactFigures(Figures):
    """The figures of single hinges and bushings."""

    @styled
    def hinge_force(
        self, *hinges: int, start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the contact force of hinges over time, by default of the two most loaded."""
        rows = rows_between(self.result, start, end)
        numbers = hinges or self._most_loaded("hinge_force", rows)
        figure, cells = panels(len(numbers), "time [s]", "pin / bushing force [N]", ax=ax)
        for axes, number in zip(cells, numbers, strict=True):
            view = self.result.hinge(number)
            axes.plot(view.time[rows], view.force[rows], color=BLUE)
            axes.set_title(f"hinge {number}")
        return figure

    @styled
    def tooth_force(
        self, *bushings: int, start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the tooth force of bushings over time, each stay with its sprocket and gap.

        By default those of the two most loaded bushings.
        """
        window = rows_between(self.result, start, end)
        numbers = bushings or self._most_loaded("tooth_force", window)
        figure, cells = panels(len(numbers), "time [s]", "bushing / tooth force [N]", ax=ax)
        for axes, number in zip(cells, numbers, strict=True):
            view = self.result.bushing(number)
            axes.plot(
                view.time[window], np.zeros_like(view.time[window]), color=GREY, linewidth=0.5
            )
            for rows, sprocket, tooth in _visits(view, window):
                time, force = view.time[rows], view.tooth_force[rows]
                color = CYCLE[(sprocket - 1) % len(CYCLE)]
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
            legend_of_distinct(axes)
        return figure

    @styled
    def force_penetration(
        self,
        *numbers: int | str | Sequence[str],
        contact: Literal["tooth", "hinge"] = "tooth",
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw force against penetration of bushings on teeth, or of pins in bushings.

        Tooth contacts are coloured by the region of the tooth. With regions "kept" the stiffness is
        that of the region of the contact onset, so that points of one colour may lie on two lines.
        Hinges are shown with the elastic part of their law. By default the two most loaded ones are
        drawn. The contacts of a mechanism go by their names; without a name, all are drawn.
        """
        rows = rows_between(self.result, start, end)
        if self.result.scene.kind == "mechanism":
            return force_penetration_figure(self.result, numbers, rows, ax)
        if contact not in ("tooth", "hinge"):
            msg = f"contact: {shown(contact)} is no contact; {suggest(contact, ('tooth', 'hinge'))}"
            raise InvalidInput(msg)
        numbers = numbers or self._most_loaded(f"{contact}_force", rows)
        draw = self._tooth_loops if contact == "tooth" else self._hinge_loops
        label = "bushing / tooth" if contact == "tooth" else "pin / bushing"
        figure, cells = panels(len(numbers), "penetration [µm]", f"{label} force [N]", ax=ax)
        for axes, one in zip(cells, numbers, strict=True):
            draw(axes, admitted("force_penetration(number)", one, int), rows)
            legend_of_distinct(axes)
        cells[0].set(xlim=(0.0, None), ylim=(0.0, None))  # of all panels
        return figure

    @styled
    def orbit(self, *hinges: int, start: Time = None, end: Time = None, ax: Ax = None) -> Figure:
        """Draw the path of a pin's centre in its bushing, coloured by the force between the two.

        The dotted circle shows the contact onset. One scale of colours holds for all hinges. By
        default the two most loaded ones are drawn.
        """
        rows = rows_between(self.result, start, end)
        numbers = hinges or self._most_loaded("hinge_force", rows)
        clearance = 1e6 * self.result.drive.chain.hinge.clearance
        figure, cells = panels(len(numbers), "x [µm]", "y [µm]", size=(3.5, 3.4), ax=ax)
        views = [self.result.hinge(number) for number in numbers]
        largest = max(float(view.force[rows].max()) for view in views)
        farthest = max(float(np.abs(view.eccentricity[rows]).max()) for view in views)
        reach = max(1.2 * clearance, 1.05e6 * farthest)
        for axes, number, view in zip(cells, numbers, views, strict=True):
            path = 1e6 * view.eccentricity[rows]
            pieces = np.stack([path[:-1], path[1:]], axis=1)
            force = 0.5 * (view.force[rows][:-1] + view.force[rows][1:])
            drawn = LineCollection(list(pieces), cmap="viridis", linewidth=1.0, array=force)
            drawn.set_clim(0.0, largest or 1.0)
            axes.add_collection(drawn)
            axes.add_patch(Circle((0.0, 0.0), clearance, fill=False, color=GREY, linestyle=":"))
            axes.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
            axes.set_title(f"pin {number} in its bushing")
        if ax is None:
            figure.colorbar(drawn, ax=cells, label="pin / bushing force [N]", shrink=0.8)
        return figure

    def _most_loaded(self, force: str, rows: slice) -> tuple[int, ...]:
        """Return the numbers of the two contacts with the largest force in some rows, in order."""
        largest = self.result.array(force)[rows].max(axis=0, initial=0.0)
        return tuple(int(k) + 1 for k in np.sort(np.argsort(-largest, kind="stable")[:_SHOWN]))

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
            length = chain.strands * hinge.length
            elastic = _rustchain.law_force(law, "internal", *radii, length, chain.material, depth)
            axes.plot(
                1e6 * depth, elastic, color=RED, linewidth=1.0, label=f"{law.elastic}, elastic part"
            )
        axes.set_title(f"hinge {number}")


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
