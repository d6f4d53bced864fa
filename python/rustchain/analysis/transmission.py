"""Transmission error and speed ripple, over time and by order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.jumps import check_seated
from rustchain.analysis.loads import checked_sprocket
from rustchain.analysis.window import (
    check_finite,
    difference_or_zero,
    mean_over_time,
    rows_between,
)
from rustchain.errors import InvalidInput
from rustchain.names import counted
from rustchain.typing import Array, Count, Time

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.description.drive import ChainDrive
    from rustchain.results.result import Result


_FEWEST = 8  # rows of a spectrum of orders
_ROUNDING = 1e-6  # of a revolution: the angles of a whole number of them add up to it with rounding


def mean_ratio(drive: ChainDrive, driven: Count, driver: Count) -> float:
    """Return the mean speed of one sprocket over that of another, by their teeth."""
    of, to = drive.sprockets[driven - 1], drive.sprockets[driver - 1]
    turn = 1.0 if of.side == to.side else -1.0
    return turn * to.teeth / of.teeth


def transmission_error(
    result: Result, /, driven: Count = 2, driver: Count = 1, *, start: Time = None, end: Time = None
) -> xr.Dataset:
    """Return the transmission error of a pair of sprockets.

    Parameters
    ----------
    driven, driver : int
        Numbers of the sprockets, from 1.

    Returns
    -------
    Dataset
        Over ``time``: ``error`` [rad] of the driven sprocket, its mean taken off;
        ``error_length`` [m], the same at the pitch radius; ``driver_angle`` [rad] turned. Over
        ``order``, cycles per revolution of the driver: ``amplitude`` [rad] over its last whole
        revolutions (Hann's window; of less than one revolution over all of it).
        ``attrs``: ``peak_to_peak`` [rad], ``peak_to_peak_length`` [m], ``ratio``,
        ``tooth_order``.

    Raises
    ------
    InvalidInput
        The two are one sprocket, or the chain jumped teeth of one of them: the error then grows by
        a gap for each tooth.
    """
    from rustchain.extras import xarray as xr

    rows = rows_between(result, start, end)
    driven = checked_sprocket(result, driven, "driven")
    driver = checked_sprocket(result, driver, "driver")
    if driven == driver:
        msg = (
            f"transmission_error(driven): got {driven}, which is the driver too; expected another "
            "sprocket"
        )
        raise InvalidInput(msg)
    check_seated(result, "transmission_error", start, end, (driven, driver))
    turned, error, radius = angle_error(result, driven, driver, rows)
    order, amplitude = order_spectrum(turned, error)
    return xr.Dataset(
        {
            "error": ("time", error, {"units": "rad"}),
            "error_length": ("time", radius * error, {"units": "m"}),
            "driver_angle": ("time", turned, {"units": "rad"}),
            "amplitude": ("order", amplitude, {"units": "rad"}),
        },
        {"time": ("time", result.time[rows], {"units": "s"}), "order": order},
        {
            "driver": driver,
            "driven": driven,
            "ratio": mean_ratio(result.drive, driven, driver),
            "peak_to_peak": float(np.ptp(error)),
            "peak_to_peak_length": float(radius * np.ptp(error)),
            "tooth_order": result.drive.sprockets[driver - 1].teeth,
        },
    )


def angle_error(
    result: Result, driven: Count, driver: Count, rows: slice
) -> tuple[Array, Array, float]:
    """Return angle of the driver and error of the driven [rad], and the pitch radius of it [m]."""
    angle = result.array("sprocket_angle")[rows]
    turned = angle[:, driver - 1] - angle[0, driver - 1]
    ratio = mean_ratio(result.drive, driven, driver)
    error = angle[:, driven - 1] - ratio * turned
    error = error - _mean(result.time[rows], error)
    error = difference_or_zero(error, angle[:, driven - 1], ratio * angle[:, driver - 1])
    return turned, error, result.drive.check().pitch_radius[driven - 1]


def speed_ripple(
    result: Result, /, sprocket: Count = 2, *, start: Time = None, end: Time = None
) -> xr.Dataset:
    """Return the speed ripple of a sprocket.

    Parameters
    ----------
    sprocket : int
        Number of the sprocket, from 1.

    Returns
    -------
    Dataset
        Over ``time``: ``speed`` [rad/s], ``ripple`` = speed / mean - 1. Over ``order``, cycles
        per revolution of the sprocket: ``amplitude`` of the ripple, as in `transmission_error`.
        ``attrs``: ``mean`` [rad/s], ``rms``, ``peak_to_peak``, ``tooth_order``.

    Raises
    ------
    InvalidInput
        The mean speed is below half of the RMS of the speed: the sprocket rests, turns back and
        forth, or starts late in this part.
    """
    from rustchain.extras import xarray as xr

    rows = rows_between(result, start, end)
    checked_sprocket(result, sprocket)
    speed = result.array("sprocket_speed")[rows, sprocket - 1]
    angle = result.array("sprocket_angle")[rows, sprocket - 1]
    mean, ripple, rms = ripple_of(result, sprocket, rows)
    order, amplitude = order_spectrum(angle - angle[0], ripple)
    return xr.Dataset(
        {
            "speed": ("time", speed, {"units": "rad/s"}),
            "ripple": ("time", ripple, {"units": "1"}),
            "amplitude": ("order", amplitude, {"units": "1"}),
        },
        {"time": ("time", result.time[rows], {"units": "s"}), "order": order},
        {
            "sprocket": sprocket,
            "mean": mean,
            "peak_to_peak": float(np.ptp(ripple)),
            "rms": rms,
            "tooth_order": result.drive.sprockets[sprocket - 1].teeth,
        },
    )


def ripple_of(result: Result, sprocket: Count, rows: slice) -> tuple[float, Array, float]:
    """Return the mean speed of a sprocket [rad/s], its ripple over time and the RMS of that."""
    time, speed = result.time[rows], result.array("sprocket_speed")[rows, sprocket - 1]
    mean, turns = _mean_speed(result, sprocket, rows)
    if not turns:
        rms = float(np.sqrt(_mean(time, speed**2)))
        msg = (
            f"speed_ripple: the mean speed of sprocket {sprocket} is {mean:.3g} rad/s, the RMS of "
            f"its speed {rms:.3g} rad/s; expected a sprocket that turns one way; take another one, "
            "or a part of the run in which it does"
        )
        raise InvalidInput(msg)
    ripple = difference_or_zero(speed / mean - 1.0, np.ones(1))
    return mean, ripple, float(np.sqrt(_mean(time, ripple**2)))


def has_ripple(result: Result, sprocket: Count, rows: slice) -> bool:
    """Return whether the speed of a sprocket has a mean that a ripple can be related to."""
    return _mean_speed(result, sprocket, rows)[1]


def _mean_speed(result: Result, sprocket: Count, rows: slice) -> tuple[float, bool]:
    """Return the mean speed of a sprocket, and whether it is above half of the RMS of the speed.

    Otherwise the ripple has an RMS above sqrt(3): the sprocket turns back and forth, or rests.
    """
    time, speed = result.time[rows], result.array("sprocket_speed")[rows, sprocket - 1]
    mean = _mean(time, speed)
    return mean, mean**2 > 0.25 * _mean(time, speed**2)


def order_spectrum(angle: Array, values: Array) -> tuple[Array, Array]:
    """Return orders, per revolution, and the amplitude of `values` at each, over an angle [rad].

    The last whole revolutions count, in which the orders of teeth are lines of the spectrum: beside
    a line, amplitudes are up to 15 % low. Of less than one revolution, all of it counts. A linear
    drift is removed, then Hann's window is applied: a line covers three orders of the spectrum.
    """
    from rustchain.extras import interpolate, signal

    for name, given in (("angle", angle), ("values", values)):
        check_finite(f"spectrum of orders: {name}", given)
    turned = angle * np.sign(angle[-1])
    path = np.abs(np.diff(angle)).sum()
    if turned[-1] < 0.5 * path:
        msg = (
            f"start, end: the shaft rotated back and forth by {path:.3g} rad, and on by "
            f"{turned[-1]:.3g} rad; expected a shaft that turns one way; take a part of the run in "
            "which it does"
        )
        raise InvalidInput(msg)
    if len(turned) < _FEWEST or not turned[-1] > 0.0:
        msg = (
            f"start, end: {counted(len(turned), 'rows')} over {turned[-1]:.3g} rad: too "
            "few for a spectrum of orders; take a longer part, or a smaller report_step"
        )
        raise InvalidInput(msg)
    # A shaft that turns back for a moment is read in the order of its farthest angles.
    onward = np.maximum.accumulate(turned)
    revolutions = np.floor(onward[-1] / (2 * np.pi) + _ROUNDING) or onward[-1] / (2 * np.pi)
    span = 2 * np.pi * revolutions
    count = max(round((len(onward) - 1) * span / onward[-1]), _FEWEST)
    # Without its first angle, which is the last one of the revolution before.
    even = onward[-1] - span * np.arange(count)[::-1] / count
    # Straight lines between rows would lower an amplitude with few rows per cycle.
    number = np.arange(len(values))
    between = interpolate.CubicSpline(number, values)(np.interp(even, onward, number))
    _, power = signal.periodogram(between, window="hann", detrend="linear", scaling="spectrum")
    order = np.arange(len(power)) / revolutions
    return order, np.sqrt(2.0 * power)


def _mean(time: Array, values: Array) -> float:
    """Return the mean over time."""
    return float(mean_over_time(time, values))
