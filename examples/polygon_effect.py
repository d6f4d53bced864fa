"""How many teeth a driver should have: a sweep at one chain speed, on all cores.

A sprocket is a polygon, and the fewer its teeth, the more the chain's speed pulses as it turns.
With more teeth on the driver, the driven sprocket turns more smoothly and, by and large, the teeth
are hit less hard.
"""

import matplotlib.pyplot as plt

import rustchain as rc


def drive(teeth):
    """Return a drive of the same chain and chain speed, whatever the teeth of its driver."""
    return rc.two_sprocket_drive(
        teeth=(teeth, 34), links=76, speed=12.566 * 17 / teeth, torque=-1.0
    )


def measure(result):
    """Return how unevenly the driven sprocket turns, and the hardest hit."""
    late = result.time > 0.1
    speed = result.sprocket(2).speed[late]
    force = result.peaks.tooth_force[late]
    return {"ripple": 100 * speed.std() / speed.mean(), "force": force.max()}


sweep = rc.sweep(drive, {"teeth": [9, 11, 13, 17, 21, 25]}, measure, duration=0.3)
print(sweep.to_pandas())

data = sweep.to_xarray()
figure, panels = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
labels = {"ripple": "ripple of the driven speed [%]", "force": "largest tooth force [N]"}
for axes, (name, label) in zip(panels, labels.items(), strict=True):
    axes.plot(data["teeth"], data[name], marker="o")
    axes.set(xlabel="teeth of the driver", xticks=data["teeth"], ylabel=label, ylim=(0, None))
figure.savefig("polygon_effect.png")
