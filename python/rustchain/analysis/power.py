"""Power balance: shafts, losses by channel, stored energy, efficiency."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rustchain.analysis.jumps import check_seated, jumps_within
from rustchain.analysis.window import first_row, mean_over_time, rows_between
from rustchain.description.ends import AnchoredEnd
from rustchain.description.sprocket import PrescribedSpeed
from rustchain.errors import InvalidInput
from rustchain.typing import Array, Number, Time

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.results.result import Result

_STORED = ("kinetic", "gravity", "elastic")
_SUMS = ("dissipated", "external_work", "residual")
_ROUNDING = 1e-9  # of the losses, which are differences of sums


def power_balance(result: Result, /, *, start: Time = None, end: Time = None) -> xr.Dataset:
    """Return the mean powers of shafts, losses and stores, and the efficiency.

    Needs sprockets and the energy balance recorded.

    Returns
    -------
    Dataset
        ``shaft_power`` [W], (sprocket): into the drive positive. ``other_work`` [W]: external work
        less that of the shafts. ``loss`` [W], (channel): dissipated power by channel, contacts and
        whatever other channels the run kept. ``stored`` [W], (store): growth of kinetic, gravity
        and elastic energy. ``residual`` [W]: rate of the energy balance residual. Shafts, other
        work and residual add up to losses and stored energy. ``efficiency``: power delivered by the
        shafts over power delivered and lost, NaN where none is delivered or no shaft puts work in;
        growth of stored energy does not enter. ``attrs``: ``span`` [s]; ``tooth_jumps``, how many
        teeth the chain jumped meanwhile.

    Notes
    -----
    The power of a shaft is the mean of recorded torque times speed. That of an applied torque,
    described or set during the run, is exact to 2e-5 of itself at rows 1e-4 s apart.

    The torque of a motor of prescribed speed consists of impacts, most of which fall between rows.
    The power of a single motor is therefore the external work less that of other shafts and guide
    arms. ``other_work`` is then that of the guide arms. The motor's power contains the tensioner's
    work, which is its force times the way of the centre. In a drive of 51 W this was 0.01 W over
    0.15 s. It was 0.1 W over 0.2 s with a ramp.

    With two motors that turn, or with a moved end, powers are those of the rows. In drives of 3 to
    300 W they were off by up to 2 %. This may be more than the losses. ``other_work`` is then the
    work of ends, tensioner and guide arms, with the error of the motors. Without a motor of
    prescribed speed it is that work alone.
    """
    from rustchain.extras import xarray as xr

    found = mean_powers(result, start, end)
    jumps = jumps_within(result, start, end)
    watts = {"units": "W"}
    return xr.Dataset(
        {
            "shaft_power": ("sprocket", found.shafts, watts),
            "other_work": ((), found.other, watts),
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
    other: float
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

    shafts, other = _shafts(result, rows, rate("external_work"))
    delivered = float(-shafts[shafts < 0.0].sum())
    lost = rate("dissipated")
    # Without work put in by a shaft, stored energy is spent: the efficiency is not defined.
    works = delivered > 0.0 and bool(np.any(shafts > 0.0))
    return MeanPowers(
        shafts=shafts,
        other=other,
        losses=_losses(result, rate),
        stored={name: rate(name) for name in _STORED},
        residual=rate("residual"),
        efficiency=delivered / (delivered + lost) if works else np.nan,
        span=span,
    )


def efficiency(result: Result, /, after: Number = 0.0) -> float:
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
    if (left := len(time) - first_row(time, after)) < 2:
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
    dissipated = rate("dissipated")
    left = dissipated - sum(parts.values())
    if abs(left) <= _ROUNDING * sum(map(abs, parts.values())):
        left = 0.0  # a drive without dashpots
    return {rest: left, **parts}


def _shafts(result: Result, rows: slice, external_work: float) -> tuple[Array, float]:
    """Return the mean power of each shaft, (sprockets,), and the external power of all else [W].

    Applied torques are smooth enough to integrate from row to row. A motor of prescribed speed
    receives every impact, most of which fall between rows. The power of a single motor that turns
    is what other sources leave of the external work. Moved ends receive impacts, too: then the rows
    are used.
    """
    drive = result.drive
    count = len(drive.sprockets)
    torque, speed = (result.array(f"sprocket_{name}")[rows] for name in ("torque", "speed"))
    power = mean_over_time(result.time[rows], torque * speed)
    shafts, plungers = power[:count], float(power[count:].sum())  # guides follow the sprockets
    motors = [
        k
        for k, sprocket in enumerate(drive.sprockets)
        if isinstance(sprocket.motion, PrescribedSpeed) and speed[:, k].any()
    ]
    if len(motors) != 1 or any(map(_is_moved, drive.ends or ())):
        return shafts, external_work - float(shafts.sum())
    shafts[motors] = 0.0
    shafts[motors] = external_work - plungers - shafts.sum()
    return shafts, plungers


def _is_moved(end: object) -> bool:
    """Return whether a velocity other than zero is prescribed to an end of a chain."""
    return isinstance(end, AnchoredEnd) and any(each != 0.0 for each in end.velocity)
