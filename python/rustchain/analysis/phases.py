"""Statistics of forces by position: mean, quantiles and largest value of each bin."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rustchain.arguments import count_within, shown
from rustchain.errors import InvalidInput
from rustchain.typing import Numbers

if TYPE_CHECKING:
    import numpy.typing as npt

    from rustchain.typing import Array

QUANTILES = (0.05, 0.5, 0.95)
NEWTONS = {"units": "N"}
# Far finer than rows lie in a pitch: with more bins most are empty.
_MOST_BINS = 1000


def checked_bins(where: str, bins: object) -> int:
    """Return a number of bins, or raise `InvalidInput`."""
    return count_within(where, bins, 1, _MOST_BINS)


class Forces(NamedTuple):
    """Forces of parts at the reports, and their peaks [N] and impulses [N s] since the rows before.

    All have the same shape, (times, parts).
    """

    force: Array
    peak: Array
    impulse: Array


def load_variables(
    axis: str,
    place: npt.NDArray[np.intp],
    bins: int,
    forces: Forces,
    span: Array,
    quantiles: Numbers,
) -> dict[str, Any]:
    """Return mean, quantiles and largest force of each bin [N], NaN in empty ones, over `axis`.

    `place` is the bin of each force, negative for one that counts nowhere; `span` the length of its
    interval [s].
    """
    for k, quantile in enumerate(quantiles, 1):
        if not 0.0 <= quantile <= 1.0:
            msg = f"quantiles.{k} = {shown(quantile)}: must be between 0 and 1"
            raise InvalidInput(msg)
    where, force, peak = place.ravel(), forces.force.ravel(), forces.peak.ravel()
    order = np.argsort(where, kind="stable")
    order = order[where[order] >= 0]
    edges = np.searchsorted(where[order], np.arange(1, bins))
    shares, largest = np.full((bins, len(quantiles)), np.nan), np.full(bins, np.nan)
    for k, members in enumerate(np.split(order, edges)):
        if members.size:
            shares[k] = np.quantile(force[members], quantiles)
            largest[k] = peak[members].max()
    return {
        "mean": (axis, share(place, bins, forces.impulse, span), NEWTONS),
        "quantiles": ((axis, "quantile"), shares, NEWTONS),
        "largest": (axis, largest, NEWTONS),
    }


def share(place: npt.NDArray[np.intp], bins: int, amount: Array, span: Array) -> Array:
    """Return the sum of `amount` in each bin over that of `span`, NaN in empty ones."""
    counted = place >= 0
    sums = [
        np.bincount(place[counted], np.broadcast_to(each, place.shape)[counted], bins)
        for each in (amount, span)
    ]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean: Array = sums[0] / sums[1]
    return mean


def mean_of(impulse: Array, span: Array) -> Array:
    """Return the mean force of each part [N]; NaN of a single row, which has no interval."""
    with np.errstate(invalid="ignore"):
        mean: Array = impulse.sum(axis=0) / span.sum()
    return mean


def bins_of(position: Array, begin: float, width: float, bins: int) -> npt.NDArray[np.intp]:
    """Return the bin of each position, -1 outside all of them."""
    place = np.floor((position - begin) / width).astype(np.intp)
    return np.where((place >= 0) & (place < bins), place, -1)


def midway(values: Array) -> Array:
    """Return values in the middle of each row's interval: halfway to the row before."""
    return np.append(values[:1], 0.5 * (values[1:] + values[:-1]))


def intervals(time: Array) -> Array:
    """Return the length of the interval that ends with each row [s]; 0 for the first."""
    return np.diff(time, prepend=time[:1])
