"""Force on the hook of a starting hoist: run and formulae.

The hoist is that of `hoist_load.toml`: 250 kg on 80 links of ANSI 80. The wheel's speed grows in
0.2 s, as a straight ramp of acceleration a or as a smooth step. Four formulae stand beside the
runs. At rest the hook has m g. A rigid chain adds m a. An elastic chain without damping
overshoots to m (g + 2a), because the ramp begins suddenly. The load vibrates at sqrt(k/m)/2π; k
is that of all links and hinges in series, and a third of the chain's mass counts (Rayleigh).

A link has the stiffness E A/p of its plates, a hinge that of Johnson's line contact at this
force. The wheel's part is missing in k: the links on its first teeth and the teeth, as compliant
as some two links. The frequency of the run is lower for that reason. The mean is lower because
the load is slower than a rigid chain at the end of the ramp. The polygon of the wheel accounts
for up to 1.7 % of its speed, the vibration for up to a/ω, 2.5 %. Damping in the contacts, here
that of Lankarani and Nikravesh, takes a part of the overshoot. A smooth step does not overshoot,
but its largest acceleration is 15/8 a: the hook has nearly the same peak. At 250 ms a link
engages, and without damping the hinges vibrate after the impact. What one learns: a smooth start
spares the hoist the vibration, a longer one the force.
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

DURATION = 0.3  # [s]
GRAVITY = 9.81  # [m/s^2]
scene = rc.load_scene(Path(sys.argv[0]).with_name("hoist_load.toml"))
drive = scene.system
chain = drive.chain
(wheel,) = drive.sprockets
_, hook = drive.ends
(start, _), (end, full) = wheel.motion.speed
acceleration = -full / (end - start) * drive.check().pitch_radius[0]
smooth = replace(wheel, motion=rc.PrescribedSpeed(rc.SmoothStep(start, end, 0.0, full)))
scenes = {
    "straight ramp, no damping": scene,
    "straight ramp, damping of the contacts": replace(
        scene, force_law=rc.Johnson(damping="lankarani-nikravesh")
    ),
    "smooth step, no damping": replace(scene, system=replace(drive, sprockets=[smooth])),
}


def stiffness(force):
    """Return the stiffness of the links and hinges of the loaded strand [N/m] at a force [N]."""
    material, hinge = chain.material, chain.hinge
    modulus = material.elastic_modulus / (2.0 * (1.0 - material.poisson_ratio**2))
    line = math.pi * modulus * hinge.length
    contact = (math.log(4.0 * line * hinge.clearance / force) - 2.0) / line  # [m/N]
    return 1.0 / (hook.links * (1.0 / chain.axial_stiffness + contact))


def period(time, force, level):
    """Return the mean period of a vibration [s] about a level, from its rises through it."""
    calm = np.convolve(force, np.full(21, 1.0 / 21.0), "same")
    rises = time[1:][(calm[:-1] < level) & (calm[1:] >= level)]
    return (rises[-1] - rises[0]) / (len(rises) - 1)


results = {
    name: rc.Simulation(each).run(DURATION, record=("hinges", "sprockets", "energy"))
    for name, each in scenes.items()
}
time = next(iter(results.values())).time
forces = {name: result.end(2).force[:, 1] for name, result in results.items()}
straight, damped, gentle = forces.values()
ramp = (time >= start) & (time <= end)
mass = hook.mass
working = mass * (GRAVITY + acceleration)
strand = 0.5 * hook.links * (chain.inner.mass + chain.outer.mass)
natural = math.sqrt(stiffness(working) / (mass + strand / 3.0)) / (2.0 * math.pi)
beside = {
    "at rest [N]": (straight[0], mass * GRAVITY),
    "mean of the ramp [N]": (straight[ramp].mean(), working),
    "largest of the ramp [N]": (straight[ramp].max(), working + mass * acceleration),
    "frequency [Hz]": (1.0 / period(time[ramp], straight[ramp], straight[ramp].mean()), natural),
    "largest of the smooth step [N]": (
        gentle.max(),
        mass * (GRAVITY + 15.0 / 8.0 * acceleration),
    ),
}
deviations = {name: found / expected - 1.0 for name, (found, expected) in beside.items()}
for name, (found, expected) in beside.items():
    print(f"{name:32}{found:9.1f}, formula {expected:9.1f} ({deviations[name]:+.2%})")
print(f"with the damping of the contacts {damped[ramp].max():.0f} N at most")

figure, axes = plt.subplots(figsize=(8.0, 4.0), layout="constrained")
for (name, force), colour in zip(forces.items(), ("tab:blue", "tab:green", "tab:red"), strict=True):
    axes.plot(1e3 * time, force, color=colour, linewidth=1.0, label=name)
for factor, label in ((0.0, "m g"), (1.0, "m (g + a)"), (2.0, "m (g + 2a)")):
    level = mass * (GRAVITY + factor * acceleration)
    axes.axhline(level, color="0.6", linestyle="--", linewidth=0.8)
    axes.text(1.01e3 * DURATION, level, label, va="center", backgroundcolor="white")
axes.set(xlabel="time [ms]", ylabel="force on the hook [N]", xlim=(0.0, 1.15e3 * DURATION))
axes.legend(loc="lower left")
figure.savefig("hoist_load.png")
