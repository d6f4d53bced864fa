"""Figures of many runs: a study's measures with their intervals, maps, waterfalls, losses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, to_hex
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rustchain.arguments import finite_number, shown
from rustchain.description.docstrings import unit_of
from rustchain.errors import InvalidInput
from rustchain.names import suggest
from rustchain.plot.colors import BLUE, CYCLE, GREY, PAPER, RED
from rustchain.plot.finish import as_written
from rustchain.plot.motion import radius_of
from rustchain.plot.style import Ax, panels, styled, subplots
from rustchain.typing import Array, Count, Time

_PANELS = 9  # of a map
_ENTRY = 1.2  # [in] that an entry of a legend takes
_BIN = 0.5  # [orders] that are one column of a waterfall
_ORDERS = {  # scale and label of the amplitudes
    "transmission_error": (1e6, "amplitude [µm]"),
    "speed_ripple": (1e2, "amplitude [%]"),
}

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
    if not any(values.size for values in samples.values()):
        msg = "measures: nothing was measured; expected numbers, or arrays that are not empty"
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
    figure, cells = panels(len(panes), _named(over), "", size=(3.4, 2.6), share=False, ax=ax)
    titles: list[str] = []
    for axes, (name, case) in zip(cells, panes, strict=True):
        values, found = samples[name].isel(case), statistics[name].isel(case)
        title = ", ".join(f"{axis} {_told(values[axis].item())}" for axis in case)
        titles.append("")
        if _own(values, study):
            _row(axes, values, found)
        elif over == "run":
            axes.plot(values["run"], values, "o", color=GREY, markersize=3.0)
            for end, style in (("mean", "-"), ("low", "--"), ("high", "--")):
                axes.axhline(float(found.sel(statistic=end)), color=BLUE, linestyle=style)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        else:
            titles[-1] = _over_axis(axes, values, found, over)
        axes.set_title(f"{_title(values)}: {title}" if title else _title(values))
    _legends(figure, cells, titles, ax)
    return figure


@styled
def draw_sweep(sweep: SweepResult, *, ax: Ax = None) -> Figure:
    """Draw the measured numbers of a sweep over its first axis, a panel each, six at most."""
    measured = sweep.to_xarray()
    over = sweep.dims[0]
    real = "biuf"  # kinds of numbers, of which complex ones and other values are not drawn
    names = [str(n) for n, v in measured.items() if over in v.dims and v.dtype.kind in real][:6]
    if not names:
        msg = "sweep: nothing that was measured is a number of each case"
        raise InvalidInput(msg)
    figure, cells = panels(len(names), _named(over), "", size=(3.4, 2.6), share=False, ax=ax)
    titles = []
    for axes, name in zip(cells, names, strict=True):
        values = measured[name]
        others = [str(dim) for dim in values.dims if dim != over]
        lines = _lines(values, others)
        x = _places(axes, values[over].to_numpy())
        looks = _line_styles(lines["_other"].to_numpy() if others else None)
        for k, (color, label) in enumerate(looks):
            line = lines.isel(_other=k).to_numpy()
            axes.plot(x, line, "o-", markersize=3.0, color=color, label=label)
        axes.set_title(_title(values))
        titles.append(", ".join(map(_named, others)))
    _legends(figure, cells, titles, ax)
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


def _over_axis(axes: Axes, values: xr.DataArray, found: xr.DataArray, over: str) -> str:
    """Draw runs and intervals over the values of an axis, one line for each of the others.

    Returns the names of the other axes, the title of the legend.
    """
    x = _places(axes, found[over].to_numpy())
    others = [str(dim) for dim in found.dims if dim not in (over, "statistic")]
    rows, every = _lines(found, others), _lines(values, others)
    for k, (color, label) in enumerate(_line_styles(rows["_other"].to_numpy() if others else None)):
        line = rows.isel(_other=k).transpose(over, "statistic")
        mean, low, high = (line.sel(statistic=end).to_numpy() for end in ("mean", "low", "high"))
        dots = every.isel(_other=k).transpose(over, "run").to_numpy()
        axes.plot(np.repeat(x, dots.shape[1]), dots.ravel(), "o", color=GREY, markersize=2.0)
        errors = (mean - low, high - mean)
        axes.errorbar(
            x, mean, errors, capsize=3.0, marker="o", markersize=4.0, color=color, label=label
        )
    return ", ".join(map(_named, others))


def _lines(values: xr.DataArray, others: Sequence[str]) -> xr.DataArray:
    """Return values with the other dimensions stacked to one, an entry for each line."""
    return values.stack(_other=others) if others else values.expand_dims(_other=[""])


def _places(axes: Axes, values: Any) -> Array:  # noqa: ANN401
    """Return where the values of an axis stand: numbers as they are, others in a row, named."""
    if np.issubdtype(values.dtype, np.number):
        numbers: Array = values.astype(float)
        return numbers
    row = np.arange(len(values), dtype=float)
    axes.set_xticks(row, [_told(value) for value in values])
    return row


def _line_styles(cases: Any) -> list[tuple[str, str | None]]:  # noqa: ANN401
    """Return colour and label of each line; `cases` are values of other axes, None: one line.

    Of more lines than there are colours, the colours go from dark to light and some have a label.
    """
    if cases is None:
        return [(BLUE, None)]
    labels: list[str | None] = [
        ", ".join(map(_told, case)) if isinstance(case, tuple) else _told(case) for case in cases
    ]
    if len(labels) <= len(CYCLE):
        return list(zip(CYCLE, labels, strict=False))
    named = set(np.linspace(0, len(labels) - 1, len(CYCLE)).round().astype(int).tolist())
    colors = colormaps["viridis"](np.linspace(0.0, 0.9, len(labels)))
    return [(to_hex(colors[k]), label if k in named else None) for k, label in enumerate(labels)]


def _legends(figure: Figure, cells: Sequence[Axes], titles: Sequence[str], ax: Ax) -> None:
    """Name the lines of panels: once above the figure where all have the same ones, with a title.

    Panels without a title have one line.
    """
    keys = [axes.get_legend_handles_labels() for axes in cells]
    alike = all(titles) and all(labels == keys[0][1] for _, labels in keys)
    if ax is None and alike and len(set(titles)) == 1:
        handles, labels = keys[0]
        columns = max(1, int(figure.get_figwidth() / _ENTRY))
        figure.legend(
            handles, labels, title=titles[0], loc="outside upper left", alignment="left",
            ncols=min(columns, len(labels)), title_fontsize=8.0,
        )  # fmt: skip
        return
    for axes, title in zip(cells, titles, strict=True):
        if title:
            axes.legend(title=title, title_fontsize=8.0)


@styled
def draw_loss_map(losses: xr.Dataset, *, ax: Ax = None) -> Figure:
    """Draw efficiency and power lost over speed and load, from what `rustchain.loss_map` found.

    Loads have no sign, nor have speeds that are all negative. At one speed or one load, they are
    drawn as curves over the other.
    """
    names = set(map(str, losses.variables)) if type(losses).__name__ == "Dataset" else set()
    if not {"speed", "torque", "efficiency", "lost"} <= names:
        msg = f"draw_loss_map(losses): got {shown(losses)}; expected what loss_map returned"
        raise InvalidInput(msg)
    backward = bool((losses["speed"] < 0.0).all())
    losses = losses.assign_coords(
        speed=-losses["speed"] if backward else losses["speed"], torque=np.abs(losses["torque"])
    ).sortby(["speed", "torque"])
    speed, load = losses["speed"].to_numpy(), losses["torque"].to_numpy()
    area = min(len(speed), len(load)) > 1
    figure, cells = subplots(1, 2, ax=ax, figsize=(8.0, 3.2), sharey=area)
    for axes, name, scale, label in (
        (cells[0], "efficiency", 100.0, "efficiency [%]"),
        (cells[1], "lost", 1.0, "power lost [W]"),
    ):
        values = scale * losses[name].transpose("torque", "speed").to_numpy()
        axes.set_title(label)
        if not area:
            _losses_along(axes, speed, load, values.ravel())
            continue
        filled = axes.contourf(speed, load, values, levels=12, cmap="viridis")
        figure.colorbar(filled, ax=axes)
        axes.plot(*np.meshgrid(speed, load), ".", color=RED, markersize=2.5, clip_on=False)
        axes.set_xlabel("speed of the driver [rad/s]")
        axes.grid(visible=False)
    if area:
        cells[0].set_ylabel("load [N m]")
    return figure


def _losses_along(axes: Axes, speed: Array, load: Array, values: Array) -> None:
    """Draw a loss over the load at one speed, or over the speed at one load."""
    if len(speed) > 1:
        x, label, at = speed, "speed of the driver [rad/s]", f"load {load[0]:.4g} N m"
    else:
        x, label, at = load, "load [N m]", f"speed {speed[0]:.4g} rad/s"
    axes.plot(x, values, "o-", color=BLUE, markersize=3.0, label=at)
    axes.set_xlabel(label)
    axes.legend()


@styled
def draw_map(sweep: SweepResult, measure: str, *, ax: Ax = None) -> Figure:
    """Draw a measured number of a sweep over its first two axes, as a map.

    Of further axes there is a panel for each of their values, nine at most. A case that failed
    stays empty, with a cross.

    Parameters
    ----------
    sweep : SweepResult
        A sweep of two axes or more, with a measure.
    measure : str
        What to draw: a key of the measured dict, or "value".

    Raises
    ------
    InvalidInput
        It is no sweep, there is no such measure, it is no number of each case, there are fewer
        axes, or the cases are listed.
    """
    _check_sweep("draw_map", sweep)
    if sweep.axes is None:
        msg = (
            "draw_map(sweep): got listed cases; expected those of axes; of a store, call sweep "
            "with the same axes, measure and store: what is stored is not run again"
        )
        raise InvalidInput(msg)
    measured = sweep.to_xarray()
    names = [str(name) for name, values in measured.items() if values.dims == sweep.dims]
    if measure not in names:
        msg = f"draw_map(measure): got {shown(measure)}; expected a measured number; "
        raise InvalidInput(msg + suggest(measure, names))
    if len(sweep.dims) < 2:
        msg = f"draw_map(sweep): got a sweep over {sweep.dims[0]}; expected two axes or more"
        raise InvalidInput(msg)
    x, y, *others = sweep.dims
    values = measured[measure]
    cases = list(np.ndindex(*(values.sizes[other] for other in others)))[:_PANELS]
    figure, cells = panels(len(cases), _named(x), _named(y), size=(4.4, 3.3), share=False, ax=ax)
    low, high = float(values.min()), float(values.max())
    for axes, case in zip(cells, cases, strict=True):
        here = values.isel(dict(zip(others, case, strict=True))).transpose(y, x)
        drawn = axes.pcolormesh(
            here.to_numpy(), cmap="viridis", vmin=low, vmax=high, edgecolors="face", linewidth=0.2
        )
        failed = np.argwhere(~np.isfinite(here.to_numpy()))
        axes.plot(failed[:, 1] + 0.5, failed[:, 0] + 0.5, "x", color=RED, markersize=6.0)
        for axis, dim in ((axes.xaxis, x), (axes.yaxis, y)):
            labels = [_told(value) for value in here[dim].to_numpy()]
            every = -(-len(labels) // 10)
            axis.set_ticks(np.arange(len(labels))[::every] + 0.5, labels[::every])
        axes.grid(visible=False)
        told = ", ".join(f"{other} = {_told(here[other].item())}" for other in others)
        axes.set_title(f"{_title(values)}: {told}" if told else _title(values))
    if ax is None:
        figure.colorbar(drawn, ax=cells, label=_title(values))
    return figure


@styled
def draw_waterfall(
    sweep: SweepResult,
    quantity: Literal["transmission_error", "speed_ripple"] = "transmission_error",
    sprocket: Count = 2,
    *,
    start: Time = None,
    ax: Ax = None,
) -> Figure:
    """Draw the amplitude by order over the axis of a sweep, such as the speed.

    The orders of the teeth are marked where all cases have the same.

    Parameters
    ----------
    sweep : SweepResult
        A sweep of one axis of numbers, without a measure, so that it has kept its results.
    quantity : {"transmission_error", "speed_ripple"}
        Of which the orders are drawn.
    sprocket : int
        The driven sprocket, or the one whose speed ripples.
    start : float, optional
        Time from which on to look [s], when the drive has settled.

    Raises
    ------
    InvalidInput
        It is no sweep, has another number of axes, or its axis has no numbers.
    NotRecorded
        The results were measured and let go, or have no sprockets.
    """
    _check_sweep("draw_waterfall", sweep)
    if quantity not in _ORDERS:
        msg = f"draw_waterfall(quantity): got {shown(quantity)}; {suggest(quantity, _ORDERS)}"
        raise InvalidInput(msg)
    if sweep.axes is None or len(sweep.axes) != 1:
        msg = f"draw_waterfall(sweep): got axes {sweep.dims}; expected one axis of numbers"
        raise InvalidInput(msg)
    (over,) = sweep.dims
    scale, label = _ORDERS[quantity]
    lines = []
    for case, result in zip(sweep.cases, sweep.results, strict=True):
        value = finite_number(case.get(over))
        if value is None:
            msg = f"draw_waterfall(sweep): {over} = {shown(case.get(over))}; expected a number"
            raise InvalidInput(msg)
        if result is not None:
            found = getattr(result, quantity)(sprocket, start=start)
            radius = radius_of(found) if quantity == "transmission_error" else 1.0
            lines.append((value, found, scale * radius))
    if len(lines) < 2:
        msg = f"draw_waterfall(sweep): {len(lines)} cases have a result; expected two or more"
        raise InvalidInput(msg)
    lines.sort(key=lambda line: line[0])
    values = np.array([value for value, _, _ in lines])
    teeth = {found.attrs["tooth_order"] for _, found, _ in lines}
    orders = np.arange(0.5 * _BIN, 4.5 * max(teeth) + 0.5 * _BIN, _BIN)
    amplitudes = np.array([_in_bins(found, factor, orders) for _, found, factor in lines])
    figure, axes = subplots(ax=ax, figsize=(7.0, 3.6))
    top = float(amplitudes.max()) or 1.0
    drawn = axes.pcolormesh(
        orders, values, np.maximum(amplitudes, 1e-4 * top), cmap="viridis",
        norm=LogNorm(1e-3 * top, top), shading="nearest", rasterized=True,
    )  # fmt: skip
    for multiple in range(1, 5) if len(teeth) == 1 else ():
        axes.axvline(multiple * max(teeth), color=PAPER, linestyle="--", linewidth=0.7, alpha=0.8)
    shaft = 1 if quantity == "transmission_error" else sprocket
    axes.set(xlabel=f"order, per revolution of sprocket {shaft}", ylabel=_named(over))
    axes.grid(visible=False)
    axes.set_title(f"{quantity.replace('_', ' ')} of sprocket {sprocket}")
    if ax is None:
        figure.colorbar(drawn, ax=axes, label=label)
    return figure


def _check_sweep(where: str, given: object) -> None:
    """Refuse what no sweep returned; plots cannot import the class, which is above them."""
    kind = type(given).__name__
    if kind != "SweepResult":
        remedy = "; of a study, take .sweep" if kind == "StudyResult" else ""
        msg = f"{where}(sweep): got {shown(given)}; expected what sweep returned{remedy}"
        raise InvalidInput(msg)


def _in_bins(found: xr.Dataset, scale: float, orders: Array) -> Array:
    """Return the largest amplitude about each of `orders`, the middles of bins.

    Runs of unlike numbers of revolutions have their amplitudes at unlike orders.
    """
    order, amplitude = found["order"].to_numpy(), scale * found["amplitude"].to_numpy()
    binned: Array = np.interp(orders, order, amplitude)  # of a bin without an order of its own
    place = (order / _BIN).astype(int)
    there = place < len(binned)
    np.maximum.at(binned, place[there], amplitude[there])
    return binned


def _named(axis: str) -> str:
    """Return the label of an axis of a sweep, with the unit where it follows from the name."""
    unit = unit_of(axis)
    return as_written(axis) if unit is None else f"{as_written(axis)} [{unit}]"


def _title(values: xr.DataArray) -> str:
    """Return the name of a measured quantity, with its unit where it has one."""
    name, unit = as_written(str(values.name)), values.attrs.get("units", "1")
    return name if unit == "1" else f"{name} [{unit}]"


def _told(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else as_written(str(value))
