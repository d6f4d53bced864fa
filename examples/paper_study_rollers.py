"""Bushing chain and roller chain, with confidence intervals.

The rollers are those of a no. 40 chain: outside radius, mass of the chain and all else are the
same. What differs is a radial play of 0.05 mm more between link and tooth, with a body of 1.6 g in
it. As in paper_study.py, each case is run five times and measured after the tensioner's ramp. Two
to three minutes on two cores.
"""

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

CHAINS = ["fixed", "bodies"]
NAMES = ["bushing chain", "roller chain"]
COLORS = ["tab:blue", "tab:orange"]


def measure(result):
    """Return what tells the two chains apart."""
    span = result.time[-1] - result.time[0]
    lost = result.energy.dissipated
    rolling = result.drive.chain.roller is not None
    return {
        "hinge": result.peaks.hinge_force.max(axis=0).mean(),
        "tooth": result.peaks.tooth_force.max(axis=0).mean(),
        "roller": result.peaks.roller_force.max(axis=0).mean() if rolling else np.nan,
        "impact": result.engagements()["force"].mean(),
        "swing": result.strand("upper").tension.std(),
        "lost": 1e3 * (lost[-1] - lost[0]) / span,
    }


study = rc.study(
    rc.paper_drive,
    measure,
    runs=5,
    duration=0.3,
    burn_in=0.15,
    axes={"pretension": [0.0, 25.0, 100.0], "rollers": CHAINS},
)
print(study.to_pandas()[["mean", "low", "high"]].to_string(float_format="%.4g"))

labels = {
    "impact": "mean engagement impact on a tooth [N]",
    "tooth": "largest tooth force, mean of bushings or rollers [N]",
    "hinge": "largest hinge force, mean of hinges [N]",
    "swing": "upper strand's tension: standard deviation [N]",
    "lost": "power dissipated by impacts [mW]",
}
figure, panels = plt.subplots(2, 3, figsize=(10.5, 6.0), layout="constrained")
for axes, (name, label) in zip(panels.flat, labels.items(), strict=False):
    for k, (chain, color) in enumerate(zip(NAMES, COLORS, strict=True)):
        runs = study.samples[name].isel(rollers=k)
        found = study.statistics[name].isel(rollers=k)
        mean, low, high = (found.sel(statistic=s).to_numpy() for s in ("mean", "low", "high"))
        place = found["pretension"].to_numpy() + 2.0 * (k - 0.5)
        for run in range(runs.sizes["run"]):
            axes.plot(place, runs.isel(run=run), ".", color=color, alpha=0.35, markersize=4)
        errors = (mean - low, high - mean)
        axes.errorbar(place, mean, errors, color=color, capsize=3, marker="o", ms=4, label=chain)
    axes.set(title=label, xlabel="pretension [N]", xticks=[0, 25, 100])
    axes.set_ylim(0.0, None)
    axes.title.set_fontsize(9.5)
panels[0, 0].legend()

# One roller on its way: where its bushing is in the bore, on a strand and on the sprockets.
result = rc.Simulation(rc.paper_drive(25.0, rollers="bodies")).run(duration=0.3)
late = result.time > 0.15
x, y = 1e6 * result.roller(6).eccentricity[late].T
axes = panels[1, 2]
axes.plot(x, y, linewidth=0.6, color=COLORS[1])
chain = result.drive.chain
play = 1e6 * (chain.roller.bore_radius - chain.bushing_radius)
axes.add_patch(plt.Circle((0.0, 0.0), play, fill=False, color="red"))
axes.set(aspect="equal", xlabel="x [µm]", ylabel="y [µm]", title="bushing 6 in its roller, 25 N")
axes.title.set_fontsize(9.5)
figure.savefig("paper_study_rollers.png")
