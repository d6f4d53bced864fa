"""Figures of motion and power: transmission error, ripple, strands across, power balance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rustchain.arguments import shown
from rustchain.description.ends import bushings_of, hinges_of
from rustchain.errors import InvalidInput, NoSuchPart
from rustchain.names import suggest
from rustchain.parts import place_of, position_of
from rustchain.plot.colors import BLUE, CYCLE, GREEN, GREY, RED, color_of
from rustchain.plot.finish import note
from rustchain.plot.style import Ax, Figures, legend_above, styled, subplots
from rustchain.typing import Count, Number, Time

if TYPE_CHECKING:
    import xarray as xr


class MotionFigures(Figures):
    """The figures of motion and power."""

    @styled
    def transmission_error(
        self,
        driven: Count = 2,
        driver: Count = 1,
        *,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw the transmission error over the driver's rotation, and its spectrum by order."""
        found = self.result.transmission_error(driven, driver, start=start, end=end)
        figure, (left, right) = subplots(1, 2, ax=ax, figsize=(8.0, 2.9))
        turned = found["driver_angle"].to_numpy() / (2 * np.pi)
        turned = turned * np.copysign(1.0, turned[-1] - turned[0])  # also of negative speeds
        left.plot(turned, 1e6 * found["error_length"], color=BLUE)
        left.set(xlabel=f"revolutions of sprocket {driver}")
        left.set(ylabel=f"error of sprocket {driven} [µm]")
        _orders(right, found, 1e6 * radius_of(found), "amplitude [µm]", driver)
        return figure

    @styled
    def speed_ripple(
        self, sprocket: Count = 2, *, start: Time = None, end: Time = None, ax: Ax = None
    ) -> Figure:
        """Draw the speed of a sprocket over time, and the spectrum of its ripple by order."""
        found = self.result.speed_ripple(sprocket, start=start, end=end)
        figure, (left, right) = subplots(1, 2, ax=ax, figsize=(8.0, 2.9))
        left.plot(found["time"], found["speed"], color=BLUE)
        left.axhline(found.attrs["mean"], color=GREY, linestyle="--")
        left.set(xlabel="time [s]", ylabel=f"speed of sprocket {sprocket} [rad/s]")
        _orders(right, found, 100.0, "amplitude of the ripple [%]", sprocket)
        return figure

    @styled
    def strand_motion(
        self,
        strand: str | Count,
        *more: str | Count,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw how far strands are off their straight lines over time, at several stations."""
        names = (strand, *more)
        figure, cells = subplots(
            len(names), 1, sharex=True, squeeze=False, ax=ax, figsize=(7.0, 0.6 + 2.1 * len(names))
        )
        for axes, name in zip(cells[:, 0], names, strict=True):
            motion = self.result.strand_motion(name, start=start, end=end)
            for k, station in enumerate(motion["station"].to_numpy()):
                label = f"at {station:g}"
                axes.plot(motion["time"], 1e3 * motion[:, k], color=color_of(k), label=label)
            axes.set(ylabel=f"strand {motion.attrs['strand']}, outward [mm]")
        legend_above(cells[0, 0])
        cells[-1, 0].set(xlabel="time [s]")
        return figure

    @styled
    def strand_spectrum(
        self,
        strand: str | Count,
        *,
        segment: Number | None = None,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
    ) -> Figure:
        """Draw a strand's transverse motion and its spectrum, with the frequencies to expect."""
        motion = self.result.strand_motion(strand, start=start, end=end)
        found = self.result.strand_spectrum(strand, segment=segment, modes=5, start=start, end=end)
        figure, (left, right) = subplots(1, 2, ax=ax, figsize=(8.0, 2.9))
        for k, station in enumerate(motion["station"].to_numpy()):
            at = f"at {station:g}"
            left.plot(motion["time"], 1e3 * motion[:, k], color=CYCLE[k], label=at)
            right.plot(found["frequency"], found["density"][k], color=CYCLE[k])
        left.set(xlabel="time [s]", ylabel=f"strand {motion.attrs['strand']}, outward [mm]")
        legend_above(left)
        natural = found["natural_frequency"].to_numpy()
        known = natural[np.isfinite(natural)]
        for number, frequency in enumerate(known, 1):
            label = "natural frequencies" if number == 1 else None
            right.axvline(frequency, color=GREY, linestyle="--", linewidth=0.7, label=label)
            right.text(
                frequency, 0.99, f" {number}", va="top", fontsize=7.5, color=GREY,
                transform=right.get_xaxis_transform(),
            )  # fmt: skip
        highest = 1.5 * known.max() if known.size else float(found["frequency"].max())
        teeth = found.attrs["tooth_frequency"]
        for multiple in range(1, 1 + int(highest / teeth) if teeth > 0.0 else 1):
            label = "tooth frequency, multiples" if multiple == 1 else None
            right.axvline(multiple * teeth, color=RED, linestyle=":", label=label)
        legend_above(right)
        shown = found["density"].where(found["frequency"] <= highest)
        right.set(yscale="log", xlim=(0.0, highest))
        right.set_ylim(max(1e-7 * float(shown.max()), 1e-30), 3.0 * float(shown.max()))
        right.set(xlabel="frequency [Hz]", ylabel="density [m²/Hz]")
        return figure

    @styled
    def spectrum(
        self,
        name: str,
        *,
        segment: Number | None = None,
        start: Time = None,
        end: Time = None,
        ax: Ax = None,
        **of: object,
    ) -> Figure:
        """Draw the spectrum of a recorded array; ``strand="upper"`` or ``hinge=6`` selects from it.

        Without a selection, a line for each part, or the mean of more than eight.
        """
        found = self.result.spectrum(name, segment=segment, start=start, end=end)
        known = [str(each) for each in found.dims if each != "frequency"]
        for dim in of:
            if dim not in known:
                msg = f"{dim}: {shown(name)} has no such parts; {suggest(dim, known)}"
                raise InvalidInput(msg)
        there = {"hinge": hinges_of, "bushing": bushings_of}  # those of drives alone
        for dim in (each for each in there if each in found.dims):
            found = found.isel({dim: there[dim](self.result.drive)})
        chosen = found.isel({dim: _places(found, dim, parts) for dim, parts in of.items()})
        others = [dim for dim in chosen.dims if dim != "frequency"]
        figure, axes = subplots(ax=ax, figsize=(7.0, 2.9))
        lines = chosen.stack(part=others) if others else chosen.expand_dims("part")
        if lines.sizes["part"] > len(CYCLE):
            axes.plot(lines["frequency"], lines.mean("part"), color=BLUE, label="mean of all")
        else:
            for k in range(lines.sizes["part"]):
                label = (
                    ", ".join(map(str, np.atleast_1d(lines["part"].values[k]))) if others else ""
                )
                axes.plot(lines["frequency"], lines.isel(part=k), color=CYCLE[k], label=label)
        axes.set(xlabel="frequency [Hz]", xlim=(0.0, None))
        if bool((lines > 0.0).any()):
            axes.set_yscale("log")
        else:
            axes.set_yticks([])
            note(axes, "nothing varies in this part")
        axes.set_ylabel(f"{name.replace('_', ' ')} [{found.attrs['units'].replace('^2', '²')}]")
        if others:
            legend_above(axes)
        return figure

    @styled
    def power_balance(self, *, start: Time = None, end: Time = None, ax: Ax = None) -> Figure:
        """Draw mean powers: shafts; below, on a scale of their own, what is lost and stored."""
        found = self.result.power_balance(start=start, end=end)
        powers = enumerate(found["shaft_power"].to_numpy().tolist(), 1)
        shafts = [(f"sprocket {number}", power, BLUE) for number, power in powers]
        losses = zip(found["channel"].to_numpy(), found["loss"].to_numpy().tolist(), strict=True)
        small = [
            (f"lost: {name}".replace("_", " "), -power, RED)
            for name, power in losses
            if name != "dashpots" or power
        ]
        if other := float(found["other_work"]):
            small.append(("other work", other, GREY))
        small.append(("stored", -float(found["stored"].sum()), GREEN))
        small.append(("residual", float(found["residual"]), GREY))
        parts = [bars for bars in (shafts, small) if bars]  # an open chain may have no sprocket
        counts = [len(bars) for bars in parts]
        figure, panels = subplots(
            len(parts),
            1,
            ax=ax,
            figsize=(7.0, 1.3 + 0.32 * sum(counts)),
            height_ratios=counts,
            squeeze=False,
        )
        for axes, bars in zip(panels[:, 0], parts, strict=True):
            _bars(axes, bars)
        above, below = panels[0, 0], panels[-1, 0]
        below.set(xlabel="power into the drive [W]")
        efficiency = float(found["efficiency"])
        if np.isfinite(efficiency):
            above.set_title(f"efficiency {efficiency:.4f}")
        return figure


def _places(found: xr.DataArray, dim: str, parts: object) -> int | list[int]:
    """Return the places along a dimension of a part, or of several, by number or name."""
    given = parts.tolist() if isinstance(parts, np.ndarray) else parts
    if isinstance(given, list | tuple) and given:
        return [_place(found, dim, part) for part in given]
    return _place(found, dim, given)


def _place(found: xr.DataArray, dim: str, part: object) -> int:
    """Return the place along a dimension of a part by number or name."""
    known = found[dim].to_numpy().tolist()
    if not isinstance(part, int | np.integer) or isinstance(part, bool):
        if isinstance(known[0], str):
            return place_of(dim, part, known)
        msg = f"{dim}: got {shown(part)}; expected a number from {known[0]} to {known[-1]}"
        raise InvalidInput(msg)
    if isinstance(known[0], str):
        return position_of(dim, int(part), len(known))
    if part not in known:
        position_of(dim, int(part), known[-1])
        raise NoSuchPart(f"{dim} {part}: an open chain has none there")
    place: int = known.index(part)
    return place


def radius_of(found: xr.Dataset) -> float:
    """Return the pitch radius by which a transmission error in rad was made a length [m]."""
    error = found.attrs["peak_to_peak"]  # none before anything touches
    return float(found.attrs["peak_to_peak_length"] / error) if error > 0.0 else 0.0


def _bars(axes: Axes, bars: Sequence[tuple[str, float, str]]) -> None:
    """Draw powers [W] as bars with their names, numbers and colours."""
    names, powers, colors = zip(*bars, strict=True)
    axes.barh(names, powers, color=colors, height=0.6)
    for place, power in enumerate(powers):
        left = power >= 0.0
        axes.annotate(
            f"{power + 0.0:.4g} W".replace("-", "−"),
            (power, place),
            xytext=(4 if left else -4, 0),
            textcoords="offset points",
            ha="left" if left else "right",
            va="center",
            fontsize=8.0,
        )
    axes.invert_yaxis()
    # Numbers on both sides need room on both, also where no bar goes beyond zero.
    axes.use_sticky_edges = min(powers) >= 0.0 or max(powers) < 0.0
    axes.margins(x=0.25)
    axes.axvline(0.0, color=GREY, linewidth=0.7)


def _orders(axes: Axes, found: xr.Dataset, scale: float, label: str, number: Count) -> None:
    """Draw amplitudes by order, the teeth's orders marked.

    Of less than one revolution, the few orders are points, and their distance is said.
    """
    tooth = found.attrs["tooth_order"]
    order, amplitude = found["order"].to_numpy(), scale * found["amplitude"].to_numpy()
    shown = (order > 0.0) & (order <= 4.5 * tooth)
    resolution = float(order[1])
    few = resolution > 1.0
    axes.plot(order[shown], amplitude[shown], "o-" if few else "-", color=BLUE, markersize=3.0)
    if few:
        turned = f"{1.0 / resolution:.2g} revolutions"
        if shown.any():
            axes.set_title(
                f"{turned}: an amplitude each {resolution:.3g} orders",
                fontsize=8.0, fontweight="normal", color=GREY,
            )  # fmt: skip
        else:
            axes.set_yticks([])
            note(axes, f"{turned}: too few for these orders")
    for multiple in range(1, 5) if shown.any() else ():
        axes.axvline(multiple * tooth, color=GREY, linestyle="--", linewidth=0.7)
    axes.set(xlabel=f"order, per revolution of sprocket {number}", ylabel=label)
    axes.set(xlim=(0.0, 4.5 * tooth), ylim=(0.0, None))
