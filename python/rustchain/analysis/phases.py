"""Statistics of what repeats with a position: mean, percentiles and extremes of many bins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rustchain.arguments import count_within, shown
from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    import numpy.typing as npt

    from rustchain.typing import Array

QUANTILES = (0.05, 0.5, 0.95)
# Far finer than rows lie in a pitch: with more bins most are empty.
_MOST_BINS = 1000


def checked_bins(where: str, bins: object) -> int:
    """Return a number of bins that an output was asked for, if it makes sense."""
    return count_within(where, bins, 1, _MOST_BINS)


def statistics(
    place: npt.NDArray[np.intp],
    bins: int,
    values: Array,
    largest: Array,
    quantiles: Sequence[float],
) -> dict[str, Array]:
    """Return quantiles of `values` and the greatest of `largest` in each bin, NaN in empty ones.

    All arguments but `bins` and `quantiles` have the same shape; `place` is the bin of each value,
    negative for one that counts nowhere.
    """
    for k, quantile in enumerate(quantiles):
        if not 0.0 <= quantile <= 1.0:
            msg = f"quantiles[{k}] = {shown(quantile)}: must be between 0 and 1"
            raise InvalidInput(msg)
    place, values, largest = place.ravel(), values.ravel(), largest.ravel()
    order = np.argsort(place, kind="stable")
    order = order[place[order] >= 0]
    edges = np.searchsorted(place[order], np.arange(1, bins))
    found = {
        "quantiles": np.full((bins, len(quantiles)), np.nan),
        "largest": np.full(bins, np.nan),
    }
    for k, members in enumerate(np.split(order, edges)):
        if members.size:
            found["quantiles"][k] = np.quantile(values[members], quantiles)
            found["largest"][k] = largest[members].max()
    return found


def share(place: npt.NDArray[np.intp], bins: int, amount: Array, span: Array) -> Array:
    """Return the sum of `amount` in each bin over that of `span`, NaN where nothing was."""
    counted = place >= 0
    sums = [
        np.bincount(place[counted], np.broadcast_to(each, place.shape)[counted], bins)
        for each in (amount, span)
    ]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean: Array = sums[0] / sums[1]
    return mean


def bins_of(position: Array, begin: float, width: float, bins: int) -> npt.NDArray[np.intp]:
    """Return the bin of each position, -1 outside all of them."""
    place = np.floor((position - begin) / width).astype(np.intp)
    return np.where((place >= 0) & (place < bins), place, -1)


def midway(values: Array) -> Array:
    """Return values in the middle of each row's interval: halfway to the row before."""
    found: Any = values.copy()
    found[1:] = 0.5 * (values[1:] + values[:-1])
    return found  # type: ignore[no-any-return]


def intervals(time: Array) -> Array:
    """Return the length of the interval that ends with each row [s]; 0 for the first."""
    return np.diff(time, prepend=time[:1])
