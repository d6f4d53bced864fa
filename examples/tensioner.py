"""Best damping of a tensioner, found with scipy.optimize.

The measure is the standard deviation of the tight strand's tension at the worse of two speeds. Too
little damping lets the tensioner swing with the polygon action, too much holds it where the chain
needs it to give way. Cases are kept in a store: run again, the script only draws.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import minimize_scalar

import rustchain as rc

DURATION, SETTLED = 0.25, 0.12  # [s]
SPEEDS = (20.0, 60.0)  # [rad/s]
drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, 25), links=60, torque=-5.0, pretension=60.0)
tried: dict[float, list[float]] = {}


def ripple(result: rc.Result) -> float:
    """Return the standard deviation of the tight strand's tension [N]."""
    return float(result.between(start=SETTLED).strand("upper").tension.std())


def worst(exponent: float) -> float:
    """Return the ripple at the worse speed, for a damping of ten to the power of `exponent`."""
    found = rc.sweep(
        drive,
        {"tensioner.damping": [10.0**exponent], "speed": SPEEDS},
        ripple,
        duration=DURATION,
        record=["hinges"],
        store="tensioner-runs",
    )
    tried[exponent] = found.values
    return max(found.values)


best = minimize_scalar(worst, bounds=(2.0, 4.5), method="bounded", options={"xatol": 0.1})
print(f"{10.0**best.x:.0f} N s/m: {best.fun:.1f} N, after {best.nfev} dampings")

exponents = sorted(tried)
figure, axes = plt.subplots(figsize=(6.0, 3.6), layout="constrained")
for speed, values in zip(SPEEDS, np.transpose([tried[each] for each in exponents]), strict=True):
    axes.plot(10.0 ** np.array(exponents), values, "o-", label=f"{speed:g} rad/s")
axes.axvline(10.0**best.x, color="0.6", linestyle="--", label="best")
axes.set(xscale="log", xlabel="damping of the tensioner [N s/m]")
axes.set_xticks([200.0, 500.0, 1000.0, 2000.0, 5000.0], ["200", "500", "1000", "2000", "5000"])
axes.minorticks_off()
axes.set(ylabel="tension of the tight strand,\nstandard deviation [N]")
axes.legend()
figure.savefig("tensioner.png")
