"""Power balance: shafts, losses by channel, stored energy, efficiency."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rustchain.analysis.jumps import check_seated, jumps_within
from rustchain.analysis.window import mean_over_time, rows_between
from rustchain.description.drive import Free, PrescribedSpeed
from rustchain.errors import InvalidInput
from rustchain.typing import Array, Time

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.results.result import Result

_STORED = ("kinetic", "gravity", "elastic")
_SUMS = ("dissipated", "external_work", "residual")


def power_balance(result: Result, /, *, start: Time = None, end: Time = None) -> xr.Dataset:
    """Return the mean powers of shafts, losses and stores, and the efficiency.

    Needs sprockets and the energy balance recorded.

    Returns
    -------
    Dataset
        ``shaft_power`` [W], (sprocket): into the drive positive. ``loss`` [W], (channel):
        dissipated power by channel, contacts and whatever other channels the run kept.
        ``stored`` [W], (store): growth of kinetic, gravity and elastic energy. ``residual``
        [W]: rate of the energy balance residual. ``efficiency``: power delivered by the shafts over
        power delivered and lost, NaN where nothing is delivered; growth of stored energy does
        not enter. The power of the only motor of prescribed speed holds the tensioner's work.
        ``attrs``: ``span`` [s]; ``tooth_jumps``, how many teeth the chain jumped meanwhile.
    """
    from rustchain.extras import xarray as xr

    found = mean_powers(result, start, end)
    jumps = jumps_within(result, start, end)
    watts = {"units": "W"}
    return xr.Dataset(
        {
            "shaft_power": ("sprocket", found.shafts, watts),
            "loss": ("channel", list(found.losses.values()), watts),
            "stored": ("store", list(found.stored.values()), watts),
            "residual": ((), found.residual, watts),
            "efficiency": ((), found.efficiency, {"units": "1"}),
        },
        {
            "sprocket": np.arange(1, len(found.shafts) + 1),
            "channel": list(found.losses),
            "store": list(found.stored),
        },
        {"span": found.span} | ({} if jumps is None else {"tooth_jumps": len(jumps[0])}),
    )


class MeanPowers(NamedTuple):
    """Mean powers over a part of a run [W], its length [s] and the efficiency."""

    shafts: Array
    losses: dict[str, float]
    stored: dict[str, float]
    residual: float
    efficiency: float
    span: float


def mean_powers(result: Result, start: Time, end: Time) -> MeanPowers:
    """Return the numbers of `power_balance`."""
    rows = rows_between(result, start, end)
    time = result.time[rows]
    if len(time) < 2:
        msg = f"start={start}, end={end}: a power needs at least two rows; take a longer part"
        raise InvalidInput(msg)
    span = float(time[-1] - time[0])

    def rate(name: str) -> float:
        values = result.array(f"energy_{name}")[rows]
        return float(values[-1] - values[0]) / span

    shafts = _shafts(result, rows, rate("external_work"))
    delivered = float(-shafts[shafts < 0.0].sum())
    lost = rate("dissipated")
    # Without work put in by a shaft, stored energy is spent: the efficiency is not defined.
    works = delivered > 0.0 and bool(np.any(shafts > 0.0))
    return MeanPowers(
        shafts=shafts,
        losses=_losses(result, rate),
        stored={name: rate(name) for name in _STORED},
        residual=rate("residual"),
        efficiency=delivered / (delivered + lost) if works else np.nan,
        span=span,
    )


def efficiency(result: Result, /, after: float = 0.0) -> float:
    """Return the power delivered over the power delivered and lost, as `power_balance` has it.

    Parameters
    ----------
    after : float
        Start of the evaluated part [s], when the drive should have settled.

    Returns
    -------
    float
        NaN where nothing is delivered, or no shaft puts work in.

    Raises
    ------
    InvalidInput
        The part has fewer than two rows, or the chain jumped teeth in it.
    """
    time = result.time
    if (left := np.count_nonzero(time >= after)) < 2:
        msg = (
            f"after = {after:g}: {left} rows there, a power needs two; the result has "
            f"{time[0]:g} to {time[-1]:g} s"
        )
        raise InvalidInput(msg)
    check_seated(result, "efficiency", after, None)
    return mean_powers(result, after, None).efficiency


def _losses(result: Result, rate: Callable[[str], float]) -> dict[str, float]:
    """Return the power of each channel of losses; the remainder has a channel of its own."""
    known = {f"energy_{name}" for name in (*_STORED, *_SUMS)}
    named = [name for name in result.arrays if name.startswith("energy_") and name not in known]
    parts = {name.removeprefix("energy_"): rate(name.removeprefix("energy_")) for name in named}
    rest = "contacts" if result.drive.tensioner is None else "contacts and dashpot"
    if any(name.endswith("_contact") for name in parts):
        rest = "dashpots"  # the contacts have channels of their own
    return {rest: rate("dissipated") - sum(parts.values()), **parts}


def _shafts(result: Result, rows: slice, external_work: float) -> Array:
    """Return the mean power of each shaft [W], positive into the drive, (sprockets,).

    Applied torques are smooth enough to integrate from row to row. A motor of prescribed speed
    receives every impact, most of which fall between rows: the power of a single motor is the
    external work less that of the other shafts.
    """
    time = result.time[rows]
    count = len(result.drive.sprockets)
    torque, speed = (result.array(f"sprocket_{name}")[rows, :count] for name in ("torque", "speed"))
    power = mean_over_time(time, torque * speed)
    motions = [sprocket.motion for sprocket in result.drive.sprockets]
    power[[isinstance(motion, Free) for motion in motions]] = 0.0
    motors = [k for k, motion in enumerate(motions) if isinstance(motion, PrescribedSpeed)]
    if len(motors) == 1:
        power[motors[0]] = 0.0
        power[motors[0]] = external_work - power.sum()
    return power
