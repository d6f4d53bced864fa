"""Conclusions of the published study, with confidence intervals.

Pereira, Ambrosio and Ramalho (2010) run their drive once for each case; without pretension it is
chaotic, so that a run is one sample. Here each case is run five times from slightly different
starts, and measured after the tensioner's ramp of 0.1 s. A minute or two on two cores.
"""

import matplotlib.pyplot as plt

import rustchain as rc

LAWS = [rc.LankaraniNikravesh(), rc.EnhancedCylinder()]
NAMES = ["Lankarani-Nikravesh", "enhanced cylindrical"]


def measure(result):
    """Return what the conclusions are about; onsets and steps are those of the whole run."""
    return {
        "apart": 100 * (result.array("hinge_penetration") <= 0).mean(),
        "onsets": result.stats["onsets"] / 0.3,
        "hinge": result.peaks.hinge_force.max(axis=0).mean(),
        "impact": result.engagements()["force"].mean(),
        "depth": 1e6 * result.array("tooth_penetration").max(),
        "tension": result.strand("upper").tension.mean(),
        "swing": result.strand("upper").tension.std(),
        "steps": result.stats["steps"] / 0.3,
    }


study = rc.study(
    rc.paper_drive(),
    measure,
    runs=5,
    duration=0.3,
    burn_in=0.15,
    axes={"pretension": [0.0, 25.0, 100.0], "force_law": LAWS},
)
print(study.to_pandas()[["mean", "low", "high"]].to_string(float_format="%.4g"))

labels = {
    "apart": "hinges without contact [%]",
    "onsets": "contact onsets [1/s]",
    "depth": "largest penetration of a tooth at the rows [µm]",
    "hinge": "largest hinge force, mean of hinges [N]",
    "impact": "mean engagement impact [N]",
    "swing": "upper strand's tension: standard deviation [N]",
}
figure, panels = plt.subplots(2, 3, figsize=(10.5, 6.0), layout="constrained")
for axes, (name, label) in zip(panels.flat, labels.items(), strict=True):
    for k, (law, color) in enumerate(zip(NAMES, ("tab:blue", "tab:red"), strict=True)):
        runs = study.samples[name].isel(force_law=k)
        found = study.statistics[name].isel(force_law=k)
        mean, low, high = (found.sel(statistic=s).to_numpy() for s in ("mean", "low", "high"))
        place = found["pretension"].to_numpy() + 2.0 * (k - 0.5)
        for run in range(runs.sizes["run"]):
            axes.plot(place, runs.isel(run=run), ".", color=color, alpha=0.35, markersize=4)
        errors = (mean - low, high - mean)
        axes.errorbar(place, mean, errors, color=color, capsize=3, marker="o", ms=4, label=law)
    axes.set(title=label, xlabel="pretension [N]", xticks=[0, 25, 100])
    axes.set_ylim(0.0, None)
    axes.title.set_fontsize(9.5)
panels[0, 0].legend()
figure.savefig("paper_study.png")
