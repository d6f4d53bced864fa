"""Polygon action: a study over the number of teeth of the driver.

A sprocket is a polygon, and the fewer its teeth, the more the chain's speed pulses as it turns.
With more teeth on the driver, the driven sprocket turns more smoothly and the teeth are hit less
hard. Every mean is that of several runs, with its confidence interval: a single run is one sample.
"""

import matplotlib.pyplot as plt

import rustchain as rc


def drive(teeth):
    """Return a drive of the same chain and chain speed, whatever the teeth of its driver."""
    return rc.two_sprocket_drive(
        teeth=(teeth, 34), links=76, speed=12.566 * 17 / teeth, torque=-1.0, pretension=50.0
    )


def measure(result):
    """Return how unevenly the driven sprocket turns, and the force of its hard impacts."""
    return {
        "ripple": 100 * result.speed_ripple(2).attrs["rms"],
        "force": float(result.engagements()["force"].quantile(0.95)),
    }


teeth = [9, 11, 13, 17, 21, 25]
study = rc.study(drive, measure, runs=4, duration=0.4, burn_in=0.2, axes={"teeth": teeth})
print(study.to_pandas())

found = study.statistics
figure, panels = plt.subplots(1, 2, figsize=(8.0, 3.8), layout="constrained")
figure.suptitle("Polygon effect: ANSI 40 at 0.43 m/s, driven sprocket of 34 teeth")
labels = {
    "ripple": "rms ripple of the driven speed [%]",
    "force": "engagement force, 95th percentile [N]",
}
for axes, (name, label) in zip(panels, labels.items(), strict=True):
    mean, low, high = (found[name].sel(statistic=part) for part in ("mean", "low", "high"))
    axes.errorbar(teeth, mean, (mean - low, high - mean), marker="o", capsize=3)
    axes.set(xlabel="teeth of the driver", xticks=teeth, ylabel=label, ylim=(0, None))
figure.savefig("polygon_effect.png")
