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
from rustchain.analysis.window import from_first_row, rows_between
from rustchain.arguments import admitted, shown
from rustchain.errors import InvalidInput
from rustchain.plot.colors import BLUE, CYCLE, GREEN, GREY, ORANGE, RED
from rustchain.plot.mechanism import force_penetration_figure
from rustchain.plot.style import Ax, Figures, legend_of_distinct, legend_outside, panels, styled
from rustchain.results.views import Bushing
from rustchain.typing import Array, Count, Time

_SHOWN = 2  # hinges or bushings, where none are named
_WHEELS = tuple(color for color in CYCLE if color != RED)  # red are the largest forces
_SURFACES = (BLUE, ORANGE, GREEN, RED)  # of the tooth, from the seat outward


class ContactFigures(Figures):
    """The figures of single hinges and bushings."""

    @styled
    def hinge_force(
        self, *hinges: Count, start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the contact force of hinges over time, with the largest between two rows.

        By default the two most loaded hinges are drawn, by the largest force between rows.
        """
        rows = rows_between(self.result, start, end)
        numbers = hinges or self._most_loaded("hinge", rows)
        peaks = self._peaks("hinge", rows)
        figure, cells = panels(len(numbers), "time [s]", "pin / bushing force [N]", ax=ax)
        for axes, number in zip(cells, numbers, strict=True):
            view = self.result.hinge(number)
            _draw_largest(axes, view.time[rows], peaks, number)
            axes.plot(view.time[rows], view.force[rows], color=BLUE, label="at the row")
            axes.set_title(f"hinge {number}")
        if peaks is not None:
            legend_outside(cells, "outside upper right", ax)
        return figure

    @styled
    def tooth_force(
        self, *bushings: Count, start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the tooth force of bushings over time, each contact episode with sprocket and gap.

        The thin line is the largest force between two rows. Contacts with guides have the number of
        the guide. By default the two most loaded bushings are drawn, by the largest force between
        rows.
        """
        window = rows_between(self.result, start, end)
        numbers = bushings or self._most_loaded("tooth", window)
        peaks = self._peaks("tooth", window)
        figure, cells = panels(len(numbers), "time [s]", "bushing / tooth force [N]", ax=ax)
        for axes, number in zip(cells, numbers, strict=True):
            view = self.result.bushing(number)
            axes.plot(
                view.time[window], np.zeros_like(view.time[window]), color=GREY, linewidth=0.5
            )
            _draw_largest(axes, view.time[window], peaks, number)
            largest = view.tooth_force.copy()
            if peaks is not None:
                largest[window] = peaks[:, number - 1]
            for rows, nearest, sprocket, tooth in _visits(view, window):
                force = view.tooth_force[rows]
                color = _WHEELS[(sprocket - 1) % len(_WHEELS)]
                name = self._wheel_name(sprocket)
                axes.plot(view.time[rows], force, color=color, label=name)
                if sprocket > len(self.result.drive.sprockets):
                    continue  # a guide has no teeth
                top = nearest.start + int(np.argmax(largest[nearest]))
                axes.annotate(
                    f"tooth {tooth}",
                    (view.time[top], largest[top]),
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
        *numbers: Count | str | Sequence[str],
        contact: Literal["tooth", "hinge"] = "tooth",
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw force against penetration of bushings on teeth, or of pins in bushings.

        Tooth contacts are coloured by the region of the tooth. With regions "kept" the stiffness is
        that of the region of the contact onset, so that points of one colour may lie on two lines.
        Hinges are shown with the elastic part of their law. With elastic plates the penetration of
        hinges includes the extension F/k of the links, and so does the curve. By default the two
        most loaded ones are drawn, by the largest force between rows. The contacts of a mechanism
        go by their names; without a name, all are drawn.

        Raises
        ------
        InvalidInput
            With ``contact="hinge"``, if the hinges are ideal: they have no penetration.
        """
        rows = rows_between(self.result, start, end)
        if self.result.scene.kind == "mechanism":
            return force_penetration_figure(self.result, numbers, rows, ax)
        if contact == "hinge":
            self._check_clearance()
        numbers = numbers or self._most_loaded(contact, rows)
        draw = self._tooth_loops if contact == "tooth" else self._hinge_loops
        label = "bushing / tooth" if contact == "tooth" else "pin / bushing"
        figure, cells = panels(len(numbers), "penetration [µm]", f"{label} force [N]", ax=ax)
        for axes, one in zip(cells, numbers, strict=True):
            draw(axes, admitted("force_penetration(number)", one, int), rows)
            legend_of_distinct(axes)
        cells[0].set(xlim=(0.0, None), ylim=(0.0, None))  # of all panels
        return figure

    @styled
    def orbit(self, *hinges: Count, start: Time = None, end: Time = None, ax: Ax = None) -> Figure:
        """Draw the path of a pin's centre in its bushing, coloured by the force between the two.

        The dotted circle shows the contact onset; a pin at rest is a point. One scale of colours
        holds for all hinges. By default the two most loaded ones are drawn, by the largest force
        between rows.

        Raises
        ------
        InvalidInput
            If the hinges are ideal: their pins do not move in their bushings.
        """
        rows = rows_between(self.result, start, end)
        self._check_clearance()
        numbers = hinges or self._most_loaded("hinge", rows)
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
            if np.ptp(path, axis=0).max() < 0.01 * reach:  # a line too short to be seen
                axes.plot(*path[-1:].T, color=drawn.to_rgba(view.force[rows][-1]))
            axes.add_patch(Circle((0.0, 0.0), clearance, fill=False, color=GREY, linestyle=":"))
            axes.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
            axes.set_title(f"pin {number} in its bushing")
        if ax is None:
            figure.set_layout_engine("compressed")  # for axes of one scale for x and y
            figure.colorbar(drawn, ax=cells, label="pin / bushing force [N]", shrink=0.8)
        return figure

    def _most_loaded(self, part: Literal["hinge", "tooth"], rows: slice) -> tuple[int, ...]:
        """Return the numbers of the two contacts with the largest force in some rows, in order."""
        forces = self._peaks(part, rows)
        if forces is None:
            forces = self.result.array(f"{part}_force")[rows]
        largest = forces.max(axis=0, initial=0.0)
        return tuple(int(k) + 1 for k in np.sort(np.argsort(-largest, kind="stable")[:_SHOWN]))

    def _peaks(self, part: Literal["hinge", "tooth"], rows: slice) -> Array | None:
        """Return the largest forces between some rows [N], (rows, contacts), where recorded."""
        names = (f"{part}_force", f"peak_{part}_force")
        if names[1] not in self.result.arrays:
            return None
        arrays = {name: self.result.array(name)[rows] for name in names}
        return from_first_row(arrays, rows)[names[1]]

    def _check_clearance(self) -> None:
        """Refuse a drive whose hinges are ideal."""
        hinges = self.result.drive.hinges
        if hinges == "ideal":
            msg = (
                f"ChainDrive.hinges = {shown(hinges)}: the hinges of this drive have neither "
                "clearance nor penetration: hinge_force and joint_loads draw their forces; "
                "hinges='clearance' makes contacts of them"
            )
            raise InvalidInput(msg)

    def _compliance(self, number: int) -> float:
        """Return the compliance of the plates in series with a hinge [m/N]; 0 of rigid links.

        It is half of that of each link at the hinge. The body at an end of an open chain is rigid.
        """
        drive = self.result.drive
        stiffness = drive.chain.axial_stiffness
        if stiffness is None:
            return 0.0
        at_end = drive.ends is not None and number in (drive.chain.links, drive.hinge_count)
        return (0.5 if at_end else 1.0) / stiffness

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
            law, deepest = self.result.hinge_law, penetration.max()
            radii = hinge.pin_radius, hinge.bore_radius
            length, material = chain.strands * hinge.length, chain.material
            compliance, label = self._compliance(number), f"{law.elastic}, elastic part"

            def elastic_force(depth: Array) -> Array:
                return _rustchain.law_force(law, "internal", *radii, length, material, depth)

            depth = np.linspace(0.0, deepest, 200)
            if compliance:
                # The penetration of the contact alone is that part of the total which F/k leaves.
                total = depth + compliance * elastic_force(depth)
                depth = np.linspace(0.0, np.interp(deepest, total, depth), 200)
                label += " + F/k of links"
            elastic = elastic_force(depth)
            total = depth + compliance * elastic
            axes.plot(1e6 * total, elastic, color=RED, linewidth=1.0, label=label)
        axes.set_title(f"hinge {number}")


def _draw_largest(axes: Axes, time: Array, peaks: Array | None, number: Count) -> None:
    """Draw the largest force of a contact between two rows as a thin line, where recorded."""
    if peaks is not None:
        axes.plot(time, peaks[:, number - 1], color=RED, linewidth=0.5, label="largest")


def _visits(bushing: Bushing, window: slice) -> Iterator[tuple[slice, slice, int, int]]:
    """Yield each contact episode in one tooth gap, flights between impacts included.

    They are its rows, the rows nearer to it than to other episodes, sprocket and gap. Impacts
    between two rows have no gap of their own: they belong to the nearest episode.
    """
    rows = np.flatnonzero(bushing.sprocket[window]) + window.start
    if rows.size == 0:
        return
    where = np.stack([bushing.sprocket[rows], bushing.tooth[rows]])
    changes = np.flatnonzero((np.diff(where) != 0).any(axis=0)) + 1
    middles = (rows[changes - 1] + rows[changes]) // 2 + 1
    edges = [window.start, *middles.tolist(), window.stop]
    for k, episode in enumerate(np.split(rows, changes)):
        rows_of_episode = slice(
            max(episode[0] - 1, window.start), min(episode[-1] + 2, window.stop)
        )
        nearest = slice(edges[k], edges[k + 1])
        sprocket, tooth = bushing.sprocket[episode[0]], bushing.tooth[episode[0]]
        yield rows_of_episode, nearest, int(sprocket), int(tooth)
