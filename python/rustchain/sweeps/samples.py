"""Samples of parameters from distributions, as an axis of a sweep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from rustchain.arguments import checked, count_within, shown
from rustchain.errors import InvalidInput
from rustchain.sweeps.cases import MOST_CASES
from rustchain.typing import Count

Sampling = Literal["random", "latin-hypercube", "sobol", "halton"]

_LEAST = 2.0**-53  # of a probability: at 0 and 1 many distributions are infinite


@checked
def samples(
    distributions: Mapping[str, Any], count: Count, *, seed: Count = 0, method: Sampling = "random"
) -> dict[tuple[str, ...], list[tuple[float, ...]]]:
    """Return samples of parameters, as an axis for `sweep` or `study`.

    >>> from scipy import stats
    >>> import rustchain as rc
    >>> bore = stats.norm(3.02e-3, 3e-6)
    >>> axes = rc.samples({"chain.hinge.bore_radius": bore, "chain.seed": stats.randint(0, 99)}, 2)
    >>> {name: len(rows) for name, rows in axes.items()}
    {('chain.hinge.bore_radius', 'chain.seed'): 2}

    Parameters
    ----------
    distributions : mapping of str to distribution
        Of each parameter a distribution of `scipy.stats`, such as ``stats.norm(3.02e-3, 3e-6)``;
        parameters are drawn independently of each other. Whole numbers of discrete distributions,
        such as ``stats.randint(0, 2**31)`` for "chain.seed", are integers.
    count : int
        How many samples, 1 to 100,000.
    seed : int
        The same seed gives the same samples.
    method : {"random", "latin-hypercube", "sobol", "halton"}
        Independent samples, for which confidence intervals of means hold; or those of
        `scipy.stats.qmc`, scrambled, which fill the space more evenly.

    Returns
    -------
    dict
        The names together, and the rows of their values: ``{("a", "b"): [(a1, b1), ...]}``. Merge
        it with other axes: ``{**samples(...), "speed": [10.0, 20.0]}``.

    Raises
    ------
    InvalidInput
        A value is no distribution, or a number is out of its range.
    """
    from rustchain.extras import stats

    count = count_within("samples(count)", count, 1, MOST_CASES)
    seed = count_within("samples(seed)", seed, 0, 2**63 - 1)
    if not distributions:
        msg = "samples(distributions): is empty; expected a distribution for each parameter"
        raise InvalidInput(msg)
    places = np.clip(_unit_cube(method, len(distributions), count, seed), _LEAST, 1.0 - _LEAST)
    columns = []
    for (name, distribution), place in zip(distributions.items(), places.T, strict=True):
        quantile = getattr(distribution, "ppf", None) or getattr(distribution, "icdf", None)
        if quantile is None:
            msg = (
                f"samples: {shown(name)} has {shown(distribution)}; expected a distribution of "
                "scipy.stats, such as stats.norm(mean, deviation)"
            )
            raise InvalidInput(msg)
        try:
            values = np.asarray(quantile(place), dtype=float)
            single = np.shape(quantile(place[:1])) == (1,)
            # Classes such as stats.Binomial have no base of their own; pmf is 0 of continuous ones.
            discrete = isinstance(getattr(distribution, "dist", distribution), stats.rv_discrete)
            if not discrete and hasattr(distribution, "pmf"):
                discrete = bool(np.all(distribution.pmf(values) > 0.0))
        except Exception as error:  # a distribution of the user's may raise anything
            msg = (
                f"samples: {shown(name)} has {shown(distribution)}, which has no values "
                f"({type(error).__name__}: {error}); expected a distribution of scipy.stats"
            )
            raise InvalidInput(msg) from error
        if not single:
            msg = (
                f"samples: {shown(name)} has {shown(distribution)} of several values; expected "
                "parameters of the distribution that are numbers, no arrays"
            )
            raise InvalidInput(msg)
        if not np.isfinite(values).all():
            msg = f"samples: {shown(name)} has values that are not finite; expected a distribution"
            raise InvalidInput(f"{msg} whose parameters are in their range")
        whole = discrete and bool(np.all(values == np.round(values)))
        columns.append([int(v) if whole else float(v) for v in values])
    return {tuple(distributions): list(zip(*columns, strict=True))}


def _unit_cube(method: Sampling, dims: int, count: int, seed: int) -> npt.NDArray[np.float64]:
    """Return points of the unit cube, (count, dims)."""
    from rustchain.extras import stats

    if method == "random":
        return np.random.default_rng(seed).random((count, dims))
    engines = {
        "latin-hypercube": stats.qmc.LatinHypercube,
        "sobol": stats.qmc.Sobol,
        "halton": stats.qmc.Halton,
    }
    points: npt.NDArray[np.float64] = engines[method](dims, seed=seed).random(count)
    return points
