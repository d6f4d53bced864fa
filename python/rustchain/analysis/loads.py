"""Loads over a revolution: of hinges along the chain path, of teeth, and along the wrap."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.circuit import Circuit, path_length
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
    share,
)
from rustchain.analysis.window import from_first_row, rows_between
from rustchain.arguments import plain, shown
from rustchain.errors import NoSuchPart
from rustchain.typing import Array, Count, Numbers, Time

if TYPE_CHECKING:
    from typing import TypeAlias

    import numpy.typing as npt
    import xarray as xr

    from rustchain.results.result import Result

    SprocketNumber: TypeAlias = Count
else:  # left to `checked_sprocket`, whose message names the output for guides
    SprocketNumber = object


def hinge_loads(
    result: Result,
    /,
    *,
    quantiles: Numbers = QUANTILES,
    bins_per_pitch: Count = 4,
    start: Time = None,
    end: Time = None,
) -> xr.Dataset:
    """Return the load of the hinges over a revolution of the chain, and that of each hinge.

    Parameters
    ----------
    quantiles : sequence of float
        Shares, 0 to 1, of the reports that lie below the values of ``quantiles``.
    bins_per_pitch : int
        Number of bins in a pitch of the chain path, 1 to 1000.

    Returns
    -------
    Dataset
        ``position`` is the position of a hinge along the chain path [pitches] from the first seat
        of sprocket 1 at the start, counterclockwise; ``section`` names sprocket or strand. Sections
        are those of the mean recorded centres and angles of the sprockets. After a static start
        that moved a tensioner they need teeth recorded, too. Over
        ``position``: ``mean`` [N], from the impulses; ``quantiles`` [N] of the force at the
        reports; ``largest`` [N], peaks between reports included. NaN where no hinge has been. Over
        ``hinge``: ``hinge_mean``, ``hinge_quantiles``, ``hinge_largest`` [N].
    """
    from rustchain.extras import xarray as xr

    bins_per_pitch = checked_bins("hinge_loads.bins_per_pitch", bins_per_pitch)
    rows = rows_between(result, start, end)
    circuit = Circuit.during(result, rows)
    where = midway(circuit.moved(result)[rows])[:, None] + np.arange(circuit.links)
    bins = bins_per_pitch * circuit.links
    place = np.floor(where * bins_per_pitch).astype(np.intp) % bins
    forces = forces_of(result, "hinge", rows)
    span = intervals(result.time[rows])[:, None]
    position = (np.arange(bins) + 0.5) / bins_per_pitch
    variables = load_variables("position", place, bins, forces, span, quantiles)
    shares = np.quantile(forces.force, quantiles, axis=0).T
    return xr.Dataset(
        variables
        | {
            "hinge_mean": ("hinge", mean_of(forces.impulse, span), NEWTONS),
            "hinge_quantiles": (("hinge", "quantile"), shares, NEWTONS),
            "hinge_largest": ("hinge", forces.peak.max(0), NEWTONS),
        },
        {
            "position": ("position", position, {"units": "pitches"}),
            "section": ("position", circuit.names(position)),
            "quantile": list(quantiles),
            "hinge": np.arange(1, circuit.links + 1),
        },
        {"revolutions": circuit.revolutions(result, rows)},
    )


def wrap_loads(
    result: Result,
    /,
    sprocket: SprocketNumber = 1,
    *,
    quantiles: Numbers = QUANTILES,
    bins_per_pitch: Count = 4,
    start: Time = None,
    end: Time = None,
) -> xr.Dataset:
    """Return the distribution of the load along the wrap of a sprocket.

    Parameters
    ----------
    sprocket : int
        Number of the sprocket, from 1.
    quantiles, bins_per_pitch
        As in `hinge_loads`.

    Returns
    -------
    Dataset
        ``position`` is the position of a bushing in the wrap [pitches] from the point where the
        belt line meets the pitch circle, counterclockwise. Where sprockets move, that point is the
        mean over this part of the run. Over ``position``: ``mean``,
        ``quantiles``, ``largest`` [N] of the tooth force, as in `hinge_loads`, and ``hinge_mean``
        [N], the mean hinge force there. ``attrs["wrap"]`` is the length of the wrap [pitches].
    """
    from rustchain.extras import xarray as xr

    bins_per_pitch = checked_bins("wrap_loads.bins_per_pitch", bins_per_pitch)
    rows = rows_between(result, start, end)
    sprocket = checked_sprocket(result, sprocket)
    circuit = Circuit.during(result, rows)
    section = circuit.section(sprocket)
    # Teeth are met and left outside the belt line; half pitches put seats in the middle of a bin.
    begin = -1.5
    bins = round(bins_per_pitch * (np.ceil(section.end - section.begin) - 2.0 * begin))
    here = midway(circuit.moved(result)[rows])[:, None] + np.arange(circuit.links)
    along = np.mod(here - section.begin - begin, circuit.links) + begin
    place = bins_of(along, begin, 1.0 / bins_per_pitch, bins)
    span = intervals(result.time[rows])[:, None]
    tooth, hinge = (forces_of(result, part, rows) for part in ("tooth", "hinge"))
    # A bushing beside a wrap may touch a guide. What no row shows in contact was on the teeth.
    wheel = np.take_along_axis(result.array("tooth_sprocket"), nearest_contact(result), 0)[rows]
    tooth = Forces(*(np.where(np.isin(wheel, (0, sprocket)), each, 0.0) for each in tooth))
    position = begin + (np.arange(bins) + 0.5) / bins_per_pitch
    return xr.Dataset(
        load_variables("position", place, bins, tooth, span, quantiles)
        | {"hinge_mean": ("position", share(place, bins, hinge.impulse, span), NEWTONS)},
        {
            "position": ("position", position, {"units": "pitches"}),
            "quantile": list(quantiles),
        },
        {"wrap": section.end - section.begin, "sprocket": sprocket},
    )


def tooth_loads(
    result: Result,
    /,
    sprocket: SprocketNumber = 1,
    *,
    quantiles: Numbers = QUANTILES,
    bins_per_pitch: Count = 4,
    start: Time = None,
    end: Time = None,
) -> xr.Dataset:
    """Return the load of a sprocket's teeth over its revolution, and that of each tooth.

    Tooth k is gap k, from 0: contacts on both of its flanks count.

    Parameters
    ----------
    sprocket : int
        Number of the sprocket, from 1.
    quantiles, bins_per_pitch
        As in `hinge_loads`.

    Returns
    -------
    Dataset
        ``angle`` [rad] is the direction of a gap from the centre, from x counterclockwise. Over
        ``angle``: ``mean``, ``quantiles``, ``largest`` [N] as in `hinge_loads`, of all gaps that
        pass there, loaded or not. Over ``tooth``: ``tooth_mean``, ``tooth_largest`` [N].
    """
    from rustchain.extras import xarray as xr

    bins_per_pitch = checked_bins("tooth_loads.bins_per_pitch", bins_per_pitch)
    rows = rows_between(result, start, end)
    sprocket = checked_sprocket(result, sprocket)
    teeth = result.drive.sprockets[sprocket - 1].teeth
    forces = by_gap(result, sprocket, rows)
    angles = result.array("sprocket_angle")[rows, sprocket - 1]
    turned = midway(angles)[:, None]
    around = (turned + 2 * np.pi * np.arange(teeth) / teeth) / (2 * np.pi)
    bins = bins_per_pitch * teeth
    place = np.floor(around * bins).astype(np.intp) % bins
    span = intervals(result.time[rows])[:, None]
    angle = 2 * np.pi * (np.arange(bins) + 0.5) / bins
    turns = path_length(angles) / (2 * np.pi)
    return xr.Dataset(
        load_variables("angle", place, bins, forces, span, quantiles)
        | {
            "tooth_mean": ("tooth", mean_of(forces.impulse, span), NEWTONS),
            "tooth_largest": ("tooth", forces.peak.max(0), NEWTONS),
        },
        {
            "angle": ("angle", angle, {"units": "rad"}),
            "quantile": list(quantiles),
            "tooth": np.arange(teeth),
        },
        {"sprocket": sprocket, "revolutions": turns},
    )


def by_gap(result: Result, sprocket: Count, rows: slice) -> Forces:
    """Return the forces in each gap of a sprocket, (times, gaps).

    A bushing that is in no contact at a row counts, with what it met since the row before, where
    it is in contact at the nearest row.
    """
    of = forces_of(result, "tooth", rows)
    how = (np.add, of.force), (np.maximum, of.peak), (np.add, of.impulse)
    return Forces(*in_gaps(result, sprocket, rows, *how))


def in_gaps(
    result: Result, sprocket: Count, rows: slice, *given: tuple[np.ufunc, Array]
) -> list[Array]:
    """Combine values of bushings in each gap of a sprocket, (times, gaps), 0 where none is.

    `given`: values, (times, bushings), and how those in one gap are combined.
    """
    nearest = nearest_contact(result)
    wheel, gap = (
        np.take_along_axis(result.array(name), nearest, 0)[rows]
        for name in ("tooth_sprocket", "tooth_index")
    )
    met = np.nonzero(wheel == sprocket)
    found = []
    for combine, values in given:
        found.append(np.zeros((len(values), result.drive.sprockets[sprocket - 1].teeth)))
        combine.at(found[-1], (met[0], gap[met]), values[met])
    return found


def nearest_contact(result: Result) -> npt.NDArray[np.intp]:
    """Return the row, nearest in time, at which each bushing is in contact, (times, bushings).

    Most impacts are over before the row that ends their interval: that of an engagement belongs to
    the next contact, that of a bushing that leaves to the last one. A bushing that no row found in
    contact has its own rows.
    """
    touching = result.array("tooth_sprocket") > 0
    row = np.arange(len(touching))[:, None]
    last = np.maximum.accumulate(np.where(touching, row, -1), axis=0)
    coming = np.where(touching, row, len(touching))
    coming = np.minimum.accumulate(coming[::-1], axis=0)[::-1]
    since = np.where(last >= 0, row - last, len(touching))
    until = coming - row  # at least 1 without contact; no next contact: past the end
    nearest = np.where((since <= until) | (coming == len(touching)), last, coming)
    return np.where(nearest >= 0, nearest, row)


def checked_sprocket(result: Result, number: object, argument: str = "sprocket") -> int:
    """Return the number of a sprocket, or raise where there is none of this number."""
    count = len(result.drive.sprockets)
    given = plain(number)
    if type(given) is not int or given not in range(1, count + 1):
        allowed = f"must be the number of a sprocket, 1 to {count}"
        msg = f"{argument} = {shown(number)}: {allowed if count else 'the drive has no sprocket'}"
        if result.drive.guides:
            msg += "; the loads of guides are those of guide_loads"
        raise NoSuchPart(msg)
    return given


def forces_of(result: Result, part: str, rows: slice) -> Forces:
    """Return the forces of hinges or of teeth; peaks and impulses are those after the first row."""
    names = (f"{part}_force", f"peak_{part}_force", f"peak_{part}_impulse")
    arrays = {name: result.array(name)[rows] for name in names}
    return Forces(*from_first_row(arrays, rows).values())
