"""Figures of many runs: a study's measures with their intervals, a map of losses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from rustchain.arguments import shown
from rustchain.errors import InvalidInput
from rustchain.names import suggest
from rustchain.plot.style import BLUE, GREY, RED, Ax, panels, styled, subplots

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.sweeps.result import SweepResult
    from rustchain.sweeps.study import StudyResult


@styled
def draw_study(study: StudyResult, measures: Sequence[str], ax: Ax = None) -> Figure:
    """Draw what `StudyResult.plot` promises."""
    samples, statistics = study.samples, study.statistics
    numbers = [str(name) for name, values in samples.items() if len(_own(values, study)) < 2]
    for name in measures:
        if not isinstance(name, str) or name not in numbers:
            msg = (
                f"measures: {shown(name)} is no measured number or row of numbers; "
                f"{suggest(name, numbers)}"
            )
            raise InvalidInput(msg)
    if not numbers:
        msg = "measures: arrays of two dimensions and more are not drawn; take .statistics"
        raise InvalidInput(msg)
    single = [name for name in numbers if not _own(samples[name], study)]
    chosen = list(measures or single or numbers)
    axes_of_study = study.dims
    over = axes_of_study[0] if axes_of_study else "run"
    panes: list[tuple[str, dict[str, int]]] = []
    for name in chosen:
        rows = _own(samples[name], study)
        counts = [samples.sizes[axis] for axis in axes_of_study] if rows else []
        cases = (dict(zip(axes_of_study, place, strict=True)) for place in np.ndindex(*counts))
        panes += [(name, case) for case in cases] if rows else [(name, {})]
    figure, cells = panels(len(panes), over, "", size=(3.4, 2.6), share=False, ax=ax)
    for axes, (name, case) in zip(cells, panes, strict=True):
        values, found = samples[name].isel(case), statistics[name].isel(case)
        title = ", ".join(f"{axis} {values[axis].item()}" for axis in case)
        if _own(values, study):
            _row(axes, values, found)
        elif over == "run":
            axes.plot(values["run"], values, "o", color=GREY, markersize=3.0)
            for end, style in (("mean", "-"), ("low", "--"), ("high", "--")):
                axes.axhline(float(found.sel(statistic=end)), color=BLUE, linestyle=style)
        else:
            _over_axis(axes, values, found, over)
        axes.set_title(f"{name}: {title}" if title else name)
    return figure


@styled
def draw_sweep(sweep: SweepResult, *, ax: Ax = None) -> Figure:
    """Draw the measured numbers of a sweep over its first axis, a panel each, six at most."""
    measured = sweep.to_xarray()
    over = sweep.dims[0]
    names = [str(name) for name, values in measured.items() if over in values.dims][:6]
    if not names:
        msg = "sweep: nothing that was measured is a number of each case"
        raise InvalidInput(msg)
    figure, cells = panels(len(names), over, "", size=(3.4, 2.6), share=False, ax=ax)
    for axes, name in zip(cells, names, strict=True):
        values = measured[name].transpose(over, ...)
        axes.plot(values[over], values.to_numpy().reshape(len(values), -1), "o-", markersize=3.0)
        axes.set_title(name)
    return figure


def _own(values: xr.DataArray, study: StudyResult) -> list[str]:
    """Return the dimensions that a measure has itself: none where it is a number."""
    axes = {*study.dims, "run"}
    return [str(dim) for dim in values.dims if dim not in axes]


def _row(axes: Any, values: xr.DataArray, found: xr.DataArray) -> None:  # noqa: ANN401
    """Draw a row of numbers of all runs over its places, its mean and the mean's interval."""
    (dim,) = (dim for dim in found.dims if dim != "statistic")
    place = np.arange(found.sizes[dim])
    axes.plot(place, values.transpose(dim, "run"), color=GREY, linewidth=0.4)
    mean, low, high = (found.sel(statistic=end).to_numpy() for end in ("mean", "low", "high"))
    axes.fill_between(place, low, high, color=BLUE, alpha=0.25, linewidth=0.0)
    axes.plot(place, mean, color=BLUE)
    axes.set_xlabel("place in the row")


def _over_axis(axes: Any, values: xr.DataArray, found: xr.DataArray, over: str) -> None:  # noqa: ANN401
    """Draw runs and intervals over the values of an axis, one line for each of the others."""
    label = found[over].to_numpy()
    numeric = np.issubdtype(label.dtype, np.number)
    x = label.astype(float) if numeric else np.arange(len(label), dtype=float)
    others = [dim for dim in found.dims if dim not in (over, "statistic")]
    rows = found.stack(other=others) if others else found.expand_dims(other=[""])
    every = values.stack(other=others) if others else values.expand_dims(other=[""])
    for k in range(rows.sizes["other"]):
        line = rows.isel(other=k).transpose(over, "statistic")
        mean, low, high = (line.sel(statistic=end).to_numpy() for end in ("mean", "low", "high"))
        dots = every.isel(other=k).transpose(over, "run").to_numpy()
        axes.plot(np.repeat(x, dots.shape[1]), dots.ravel(), "o", color=GREY, markersize=2.0)
        name = ", ".join(map(str, np.atleast_1d(rows["other"].to_numpy()[k]))) if others else None
        axes.errorbar(x, mean, (mean - low, high - mean), capsize=3.0, marker="o", label=name)
    if not numeric:
        axes.set_xticks(x, label)
    if others:
        axes.legend()


@styled
def draw_loss_map(losses: xr.Dataset, *, ax: Ax = None) -> Figure:
    """Draw efficiency and power lost over speed and load, from what `rustchain.loss_map` found."""
    names = set(map(str, losses.variables)) if type(losses).__name__ == "Dataset" else set()
    if not {"speed", "torque", "efficiency", "lost"} <= names:
        msg = f"draw_loss_map(losses): got {shown(losses)}; expected what loss_map returned"
        raise InvalidInput(msg)
    figure, cells = subplots(1, 2, ax=ax, figsize=(8.0, 3.2), sharey=True)
    speed, torque = losses["speed"].to_numpy(), losses["torque"].to_numpy()
    for axes, name, scale, label in (
        (cells[0], "efficiency", 100.0, "efficiency [%]"),
        (cells[1], "lost", 1.0, "power lost [W]"),
    ):
        values = scale * losses[name].transpose("torque", "speed").to_numpy()
        if min(values.shape) > 1:
            filled = axes.contourf(speed, np.abs(torque), values, levels=12, cmap="viridis")
            figure.colorbar(filled, ax=axes)
        axes.plot(*np.meshgrid(speed, np.abs(torque)), ".", color=RED, markersize=2.5)
        axes.set(xlabel="speed of the driver [rad/s]", title=label)
        axes.grid(visible=False)
    cells[0].set_ylabel("load [N m]")
    return figure
