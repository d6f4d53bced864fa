"""Start-up surge of a conveyor against the ramp time of the torque.

The conveyor is that of `conveyor_start.toml`: 402 links, a motor and a tail shaft with 1 kg m²
each. In a rigid conveyor the motor's torque M makes the tensions of the strands differ by M/(2
r), since one half accelerates the motor itself. In an elastic one, applied at once, it doubles
that. Applied over a ramp of duration t, the factor is ``1 + |sin(π t/τ)|/(π t/τ)`` (Harris' Shock
and Vibration Handbook). τ is the natural period of the two shafts on both strands. The tension
travels at sqrt(k/m) links a second, k and m being stiffness and mass of one link.

Plates give a link the stiffness E A/p, hinges have that of Johnson's line contact at the tension
at rest. A sixth of both strands' mass is added to either shaft for the period (Rayleigh).
Contacts are without damping, as in the formulae; with it the largest factor is 1.7. The links and
teeth of the wraps are not in the formula of the period: that of the run is 4 % longer. A ramp of
one computed period is therefore a little short, and leaves 4 % of surge. What one learns: a motor
that starts at once needs a chain for twice the tension. One that starts over a natural period
does not.
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

DURATION, SHARES = 0.08, (0.01, 0.35, 0.65, 1.0, 1.5, 2.0)  # [s]; ramps over the natural period
NEAR, FAR = 40, 140  # pitches from the motor at which the wave is timed
scene = rc.load_scene(Path(sys.argv[0]).with_name("conveyor_start.toml"))
drive = scene.system
chain = drive.chain
motor, tail = drive.sprockets
report = drive.check()
radius = report.pitch_radius[0]
torque = motor.motion.torque[-1][1]

link = 0.5 * (chain.inner.mass + chain.outer.mass)
material, hinge = chain.material, chain.hinge
modulus = material.elastic_modulus / (2.0 * (1.0 - material.poisson_ratio**2))
line = math.pi * modulus * hinge.length
contact = (math.log(4.0 * line * hinge.clearance / drive.tensioner.pretension) - 2.0) / line
stiffness = 1.0 / (1.0 / chain.axial_stiffness + contact)  # of a link and a hinge [N/m]
spring = 2.0 * stiffness / report.strand_pitches[0]
strands = 2.0 * report.strand_pitches[0] * link
shaft = (
    tail.load_inertia / radius**2 + math.pi * radius**2 * chain.tooth_contact_length * 7850.0 / 2
)
seated = 0.5 * (chain.links * link - strands)  # on either sprocket
period = 2.0 * math.pi * math.sqrt((shaft + seated + strands / 6.0) / (2.0 * spring))
rigid = 0.5 * torque / radius  # N


def started(ramp, duration, **options):
    """Return the result of a start with a torque that grows within a ramp [s]."""
    turned = replace(motor, motion=rc.AppliedTorque(((0.0, 0.0), (ramp, torque))))
    changed = replace(scene, system=replace(drive, sprockets=[turned, tail]))
    return rc.Simulation(changed).run(duration, record=("hinges", "sprockets", "energy"), **options)


def factor(share):
    """Return the largest tension over that of a rigid conveyor, for a ramp over the period."""
    return 1.0 + np.abs(np.sinc(share))


deviations = {}
histories, peaks = [], []
for share in SHARES:
    result = started(share * period, DURATION)
    difference = result.strand("upper").tension - result.strand("lower").tension
    histories.append(difference / rigid)
    peaks.append(histories[-1].max())
    deviations[f"ramp {share}"] = peaks[-1] / factor(share) - 1.0
    print(
        f"ramp {1e3 * share * period:5.1f} ms: {difference.max():.0f} N, {peaks[-1]:.3f} times the "
        f"rigid conveyor's {rigid:.0f} N; formula {factor(share):.3f} "
        f"({deviations[f'ramp {share}']:+.2%})"
    )

rises = result.time[1:][(histories[0][:-1] < 1.0) & (histories[0][1:] >= 1.0)]
found = (rises[-1] - rises[0]) / (len(rises) - 1)
deviations["period"] = found / period - 1.0
print(
    f"natural period {1e3 * found:.2f} ms, formula {1e3 * period:.2f} ms "
    f"({deviations['period']:+.2%})"
)

front = started(1e-5, 3e-3, report_step=1e-5)
arrivals = []
for pitches in (NEAR, FAR):
    force = front.hinge(chain.links + 1 - pitches).force
    arrivals.append(np.interp(10.0, force[:200] - force[0], front.time[:200]))
speed, expected = (FAR - NEAR) / (arrivals[1] - arrivals[0]), math.sqrt(stiffness / link)
deviations["wave"] = speed / expected - 1.0
print(
    f"the wave travels {chain.pitch * speed:.0f} m/s, formula {chain.pitch * expected:.0f} m/s "
    f"({deviations['wave']:+.2%})"
)

figure, (tensions, factors) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
time = 1e3 * result.time
for share, history in zip(SHARES[::2], histories[::2], strict=True):
    tensions.plot(time, history, linewidth=1.0, label=f"ramp of {share:g} natural periods")
tensions.axhline(1.0, color="0.6", linestyle="--", linewidth=0.8)
tensions.set(
    xlabel="time [ms]",
    ylabel="difference of the strands over that\nof a rigid conveyor",
    ylim=(-0.1, 2.6),
)
tensions.legend(loc="upper right")
axis = np.linspace(0.0, 1.1 * max(SHARES), 300)
factors.plot(axis, factor(axis), color="0.6", label="1 + |sin(π t/τ)|/(π t/τ)")
factors.plot(SHARES, peaks, "o", label="run")
factors.set(xlabel="duration of the ramp t/τ", ylabel="largest of the run", ylim=(0.9, 2.1))
factors.legend()
figure.savefig("conveyor_start.png")
