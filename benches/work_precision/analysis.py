"""Analysis of runs: times at equal error, and means with their confidence."""

from __future__ import annotations

import numpy as np

# Above these a machine is not quiet: its load average, of which the run itself is 1, and `spread`.
LOAD_LIMIT = 1.5
SPREAD_LIMIT = 0.1


def frontier(errors, times):
    """Points that no other beats in both, errors falling and times rising; (errors, times)."""
    errors, times = np.asarray(errors, float), np.asarray(times, float)
    use = np.isfinite(errors) & np.isfinite(times) & (errors > 0.0)
    order = np.lexsort((errors[use], times[use]))
    errors, times = errors[use][order], times[use][order]
    best = np.minimum.accumulate(errors)
    kept = np.concatenate(([True], errors[1:] < best[:-1])) if len(errors) else np.zeros(0, bool)
    return errors[kept], times[kept]


def time_at_error(errors, times, wanted):
    """Least time for an error of `wanted`: straight lines between logarithms on the frontier.

    The cheapest point's time where even that is more exact; NaN where no point is exact enough.
    """
    errors, times = frontier(errors, times)
    if not len(errors) or wanted < errors[-1]:
        return np.nan
    if wanted >= errors[0]:
        return times[0]
    logarithms = np.log(errors[::-1]), np.log(times[::-1])
    return float(np.exp(np.interp(np.log(wanted), *logarithms)))


def ratios_of_rounds(own, other, wanted):
    """Time of `other` over that of `own` at an error of `wanted`, in each round of timed runs.

    Both are lists of (error, times), a point each; one with fewer runs counts with its last.
    """

    def time(points, k):
        times = [times[min(k, len(times) - 1)] for _, times in points]
        return time_at_error([error for error, _ in points], times, wanted)

    rounds = max(len(times) for _, times in own + other)
    return np.array([time(other, k) / time(own, k) for k in range(rounds)])


def spread(differences):
    """Median difference of the times that two halves of equal runs have; NaN without any."""
    known = [difference for difference in differences if np.isfinite(difference)]
    return float(np.median(known)) if known else np.nan


def disturbance(loads, differences):
    """Say why a machine was not quiet; nothing where it was."""
    if max(loads) > LOAD_LIMIT:
        return f"the load average was {max(loads):.1f}, more than {LOAD_LIMIT}"
    wide = spread(differences)
    if wide > SPREAD_LIMIT:
        return f"two halves of equal runs differ by {wide:.0%}, more than {SPREAD_LIMIT:.0%}"
    return ""


def order_of_convergence(costs, errors):
    """Slope of error over cost, both as logarithms: least squares."""
    return float(-np.polyfit(np.log(costs), np.log(errors), 1)[0])


def batch_means(samples, statistic, batches=20):
    """Mean of a statistic over batches in time, and the half width of its 95 % interval.

    `samples` has time along its first axis. Batches must be long beside the process's memory for
    their statistics to be independent.
    """
    from scipy.stats import t

    values = np.array([statistic(batch) for batch in np.array_split(samples, batches)])
    half = t.ppf(0.975, batches - 1) * values.std(ddof=1) / np.sqrt(batches)
    return float(values.mean()), float(half)


STATISTICS = {
    "mean": np.mean,
    "RMS": lambda forces: np.sqrt(np.mean(forces**2)),
    "99 %": lambda forces: np.quantile(forces, 0.99),
}


def force_statistics(result, skip):
    """Statistics of hinge and tooth forces after `skip` s [N]: {(what, which): (mean, half)}."""
    rows = result.time >= result.time[0] + skip
    links = result.drive.chain.links
    forces = {
        "hinge": [result.hinge(k).force[rows] for k in range(1, links + 1)],
        "tooth": [result.bushing(k).tooth_force[rows] for k in range(1, links + 1)],
    }
    return {
        (what, which): batch_means(np.transpose(series), statistic)
        for what, series in forces.items()
        for which, statistic in STATISTICS.items()
    }
