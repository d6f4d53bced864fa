"""Manufacturing tolerances: a Monte-Carlo study with confidence intervals.

Each of 60 chains has its own bores, and its own long and short links. The mean has Student's
interval; the 90th percentile has the distribution-free interval between two of the sorted chains,
whose numbers follow from the binomial distribution. Bands in the figure are the intervals of means.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy import stats

import rustchain as rc

CHAINS = 60
DURATION, SETTLED = 0.2, 0.1  # [s]
drive = rc.two_sprocket_drive("ANSI 40", links=60, torque=-3.0, pretension=60.0)
hinge = drive.chain.hinge
axes_of_study = {
    **rc.samples(
        {
            "chain.hinge.bore_radius": stats.norm(hinge.bore_radius, 0.1 * hinge.clearance),
            "chain.seed": stats.randint(0, 2**31),
        },
        CHAINS,
        seed=1,
    ),
    "chain.pitch_spread": [0.0, 2e-4],  # the same chains, with and without
}


def measure(result: rc.Result) -> dict[str, float]:
    """Return the transmission error [m], peak to peak, and the largest tooth force [N]."""
    late = result.between(start=SETTLED)
    error = late.transmission_error(2, 1).attrs["peak_to_peak_length"]
    return {"swing": float(error), "force": float(late.peaks.tooth_force.max())}


found = rc.sweep(
    drive, axes_of_study, measure, duration=DURATION, record=["teeth", "sprockets"]
).to_xarray()

figure, panels = plt.subplots(1, 2, figsize=(8.0, 3.4), layout="constrained")
for axes, (name, unit, factor) in zip(
    panels, (("swing", "transmission error [µm]", 1e6), ("force", "largest tooth force [N]", 1.0)),
    strict=True,
):  # fmt: skip
    values = factor * found[name].transpose("chain.pitch_spread", "sample").to_numpy()
    for spread, each in zip((0.0, 2e-4), values, strict=True):
        known = np.sort(each[np.isfinite(each)])
        low, high = stats.t.interval(0.95, len(known) - 1, known.mean(), stats.sem(known))
        # P(k-th <= percentile <= l-th of n) = P(k <= B < l), B of the binomial distribution
        first, last = stats.binom.ppf([0.025, 0.975], len(known), 0.9).astype(int)
        ends = known[max(first - 1, 0)], known[min(last, len(known) - 1)]
        print(
            f"{unit}, links spread by {100.0 * spread:g} %: mean {known.mean():.4g} ({low:.4g} to "
            f"{high:.4g}), 90 % below {np.quantile(known, 0.9):.4g} ({ends[0]:.4g} to "
            f"{ends[1]:.4g})"
        )
        (bars,) = axes.plot(
            known, np.arange(1, len(known) + 1) / len(known), drawstyle="steps-post"
        )
        bars.set_label(f"links spread by {100.0 * spread:g} %")
        axes.axvspan(low, high, color=bars.get_color(), alpha=0.2, linewidth=0.0)
    axes.set(xlabel=unit, ylabel="share of chains below")
panels[0].legend()
figure.savefig("tolerances.png")
