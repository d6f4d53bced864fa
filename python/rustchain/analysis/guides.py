"""Loads of guides: rails, blades, shoes and smooth idlers, along the chain path and over time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.circuit import Circuit, fronts_of, remainder
from rustchain.analysis.loads import forces_of, nearest_contact
from rustchain.analysis.phases import (
    NEWTONS,
    QUANTILES,
    Forces,
    bins_of,
    checked_bins,
    intervals,
    load_variables,
    mean_of,
    midway,
)
from rustchain.analysis.window import rows_between, start_positions
from rustchain.arguments import shown
from rustchain.description.guides import SmoothIdler
from rustchain.errors import InvalidInput
from rustchain.typing import Count, Numbers, Time

if TYPE_CHECKING:
    import xarray as xr

    from rustchain.results.result import Result


def guide_loads(
    result: Result,
    /,
    guide: Count | str = 1,
    *,
    quantiles: Numbers = QUANTILES,
    bins_per_pitch: Count = 4,
    start: Time = None,
    end: Time = None,
) -> xr.Dataset:
    """Return the load of a rail, a blade, a shoe or a smooth idler.

    Parameters
    ----------
    guide : int or str
        Number of the guide, from 1, or its name: "guide_1".
    quantiles, bins_per_pitch
        As in `hinge_loads`.

    Returns
    -------
    Dataset
        ``position`` is the position of a bushing [pitches] from the middle of the guide at the
        start of the simulation, counterclockwise. Over ``position``: ``mean``, ``quantiles``,
        ``largest`` [N] of the force of each bushing that passes, as in `hinge_loads`. Over
        ``bushing``: ``bushing_mean``, ``bushing_largest`` [N]. Over ``time``: ``force`` [N], the
        sum of the forces' sizes at the reports, and ``bushings``, the number in contact.
        ``attrs["mean_force"]`` is the mean of that sum [N], from the impulses. The angle of a
        blade's arm is that of `Result.guide`.
    """
    from rustchain.extras import xarray as xr

    bins_per_pitch = checked_bins("guide_loads.bins_per_pitch", bins_per_pitch)
    rows = rows_between(result, start, end)
    number = guide_number(result, guide)
    wheel = result.array("tooth_sprocket")
    here = wheel[rows] == len(result.drive.sprockets) + number
    # Most impacts are over before a row: they count where the bushing was last.
    nearest = np.take_along_axis(wheel, nearest_contact(result), 0)[rows]
    met = nearest == len(result.drive.sprockets) + number
    of = forces_of(result, "tooth", rows)
    forces = Forces(
        np.where(here, of.force, 0.0),
        np.where(met, of.peak, 0.0),
        np.where(met, of.impulse, 0.0),
    )
    span = intervals(result.time[rows])[:, None]

    circuit = Circuit.of(result.drive)
    reach = math.ceil(_length(result, number) / (2 * result.drive.chain.pitch)) + 1.5
    along = midway(circuit.moved(result)[rows])[:, None] + np.arange(circuit.links)
    along = remainder(along - _middle(result, number), circuit.links)
    bins = round(2 * reach * bins_per_pitch)
    place = bins_of(along, -reach, 1.0 / bins_per_pitch, bins)
    mean = mean_of(forces.impulse, span)
    position = -reach + (np.arange(bins) + 0.5) / bins_per_pitch
    return xr.Dataset(
        load_variables("position", place, bins, forces, span, quantiles)
        | {
            "bushing_mean": ("bushing", mean, NEWTONS),
            "bushing_largest": ("bushing", forces.peak.max(0), NEWTONS),
            "force": ("time", forces.force.sum(1), NEWTONS),
            "bushings": ("time", (here & (forces.force > 0.0)).sum(1)),
        },
        {
            "position": ("position", position, {"units": "pitches"}),
            "quantile": list(quantiles),
            "bushing": np.arange(1, circuit.links + 1),
            "time": ("time", result.time[rows], {"units": "s"}),
        },
        {"guide": number, "mean_force": float(mean.sum())},
    )


def guide_number(result: Result, guide: Count | str) -> int:
    """Return the number of a guide, from 1; `guide` is that, or a name such as "guide_1"."""
    count = len(result.drive.guides)
    if isinstance(guide, str):
        digits = guide.removeprefix("guide_")
        number = int(digits) if digits.isdecimal() else 0
    else:
        number = int(guide)
    if not 1 <= number <= count:
        known = f"1 to {count}, or 'guide_1' and so on" if count else "but the drive has none"
        msg = f"guide = {shown(guide)}: must be the number of a guide, {known}"
        raise InvalidInput(msg)
    return number


def _length(result: Result, number: int) -> float:
    """Return an upper bound on the contact length of a guide [m]."""
    guide = result.drive.guides[number - 1]
    return math.pi * guide.radius if isinstance(guide, SmoothIdler) else guide.length


def _middle(result: Result, number: int) -> float:
    """Return the position of the middle of a guide along the chain path at the start [pitches]."""
    drive = result.drive
    guide = drive.guides[number - 1]
    positions = start_positions(result)
    hinges = fronts_of(drive.chain, positions[: drive.chain.links])
    step = np.roll(hinges, -1, axis=0) - hinges
    along = ((np.array(guide.center) - hinges) * step).sum(axis=1) / (step**2).sum(axis=1)
    inside = np.clip(along, 0.0, 1.0)
    foot = hinges + inside[:, None] * step
    nearest = int(np.argmin(np.hypot(*(foot - np.array(guide.center)).T)))
    moved = Circuit.of(drive).moved_at(result.scene, positions)
    return float(nearest + inside[nearest] + moved)
