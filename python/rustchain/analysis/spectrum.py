"""The spectrum of any recorded array."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.window import check_finite, rows_between
from rustchain.arguments import shown
from rustchain.errors import InvalidInput
from rustchain.names import counted
from rustchain.results.channels import PARTS
from rustchain.typing import Array, Number, Time

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.results.result import Result

_FEWEST = 16  # rows of a spectrum or a segment of it
_ROUNDING = 1e-13  # of the largest value of an array: variation below it is of rounding


def spectrum(
    result: Result,
    /,
    name: str,
    *,
    segment: Number | None = None,
    start: Time = None,
    end: Time = None,
) -> xr.DataArray:
    """Return the power spectral density of a recorded array, (..., frequency [Hz]).

    `scipy.signal.welch`: Hann's window, straight lines taken off. Of two rows 1e-4 s apart,
    what vibrates faster than 5 kHz, as contacts do, is folded down. A part that varies by rounding
    only, less than 1e-13 of the largest value of the array, has zeros.

    Parameters
    ----------
    name : str
        Name in `arrays`, such as "strand_tension" or "sprocket_speed".
    segment : float, optional
        Length of the segments [s] that are averaged, at least 16 rows; by default one segment, the
        finest resolution.
    """
    from rustchain.extras import xarray as xr

    rows = rows_between(result, start, end)
    if name in PARTS:
        msg = f"name = {shown(name)}: has two units; expected {' or '.join(map(repr, PARTS[name]))}"
        raise InvalidInput(msg)
    dataset = result.to_xarray()
    if name not in dataset:
        result.array(name)  # raises, with the remedy
    recorded = dataset[name]
    if "time" not in recorded.dims:
        msg = f"name = {shown(name)}: has no rows over time; take a recorded array"
        raise InvalidInput(msg)
    values = recorded.to_numpy()[rows]
    check_finite(f"name = {shown(name)}", values)
    frequency, density = welch(result.time[rows], np.moveaxis(values, 0, -1), segment)
    varies = np.sqrt(density.sum(axis=-1) * frequency[1]) > _ROUNDING * np.abs(values).max()
    density = np.where(varies[..., np.newaxis], density, 0.0)
    unit = str(recorded.attrs["units"])
    others = [dim for dim in recorded.dims if dim != "time"]
    return xr.DataArray(
        density,
        {
            **{dim: recorded.coords[dim] for dim in others},
            "frequency": ("frequency", frequency, {"units": "Hz"}),
        },
        [*others, "frequency"],
        f"{name}_spectrum",
        {"units": f"{unit if unit.isalpha() else f'({unit})'}^2/Hz"},
    )


def welch(time: Array, values: Array, segment: Number | None) -> tuple[Array, Array]:
    """Return frequencies [Hz] and densities of values over time, their last axis.

    Segments of `segment` [s] (by default all in one), half of each in the next, their straight
    lines taken off, under Hann's window: `scipy.signal.welch`. Rows that are not evenly spaced, as
    the last of a run may be, are interpolated.
    """
    from rustchain.extras import signal

    if len(time) < _FEWEST:
        msg = (
            f"start, end: {counted(len(time), 'rows')}: too few for a spectrum; take a longer part"
        )
        raise InvalidInput(msg)
    if segment is not None and segment <= 0.0:
        msg = f"segment = {segment:g}: must be a positive number in s"
        raise InvalidInput(msg)
    step = float(np.median(np.diff(time)))
    even = time[0] + step * np.arange(int((time[-1] - time[0]) / step + 0.5) + 1)
    flat = values.reshape(-1, values.shape[-1])
    resampled = np.stack([np.interp(even, time, one) for one in flat])
    points = len(even) if segment is None else round(min(segment / step, len(even)))
    if points < min(_FEWEST, len(even)):
        msg = (
            f"segment = {segment:g}: has {counted(points, 'rows')} of {step:.4g} s; expected at "
            f"least {_FEWEST * step:.4g} s, which are {_FEWEST} rows"
        )
        raise InvalidInput(msg)
    frequency, density = signal.welch(resampled, 1.0 / step, nperseg=points, detrend="linear")
    return frequency, density.reshape(*values.shape[:-1], -1)
