"""Losses and efficiency of a loaded drive against the friction coefficient.

The driver turns at 120 min⁻¹ and the load takes 4 N m: 50 W. Beside the powers lost stands the
work of articulation, μ r ω (1 + z₁/z₂) (T₁ + T₂): each hinge turns by a gap's angle on every
sprocket that it joins or leaves.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

PRETENSION, TORQUE, SETTLED = 200.0, 4.0, 0.05
coefficients = np.array([0.0, 0.03, 0.06, 0.1, 0.15, 0.2])

drive = rc.paper_drive(pretension=PRETENSION)
load = replace(drive.sprockets[1], motion=rc.AppliedTorque(-TORQUE))
tensioner = replace(drive.tensioner, ramp_time=2e-3)
drive = replace(drive, sprockets=(drive.sprockets[0], load), tensioner=tensioner)
speed = drive.sprockets[0].motion.speed
duration = 4.0 * 2.0 * np.pi / speed / 17  # of four pitches

places = {
    "damping in hinges": "hinge_contact",
    "damping on teeth": "tooth_contact",
    "friction in hinges": "hinge_friction",
    "friction on teeth": "tooth_friction",
}
lost, efficiencies, articulation = {name: [] for name in places}, [], []
for coefficient in coefficients:
    friction = rc.Coulomb(coefficient) if coefficient > 0.0 else None
    result = rc.Simulation(drive, force_law=rc.LankaraniNikravesh(friction=friction)).run(
        SETTLED + duration, 1e-4, record=("hinges", "sprockets", "energy")
    )
    late = result.time >= SETTLED
    for name, place in places.items():
        energy = getattr(result.energy, place)[late]
        lost[name].append((energy[-1] - energy[0]) / duration)
    efficiencies.append(result.efficiency(after=SETTLED))
    pulls = sum(result.strand(name).tension[late].mean() for name in result.strand_names)
    share = coefficient / np.hypot(1.0, coefficient)
    articulation.append(2.0 * share * drive.chain.hinge.pin_radius * speed * pulls)
    powers = ", ".join(f"{name} {values[-1]:.3f} W" for name, values in lost.items())
    print(f"μ = {coefficient:.2f}: efficiency {efficiencies[-1]:.4f}; {powers}")

# Damping takes a thousandth of what friction takes: a logarithmic axis shows both.
figure, (powers, whole) = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
for name, values in lost.items():
    slid = np.array(values) > 0.0
    powers.semilogy(coefficients[slid], np.array(values)[slid], "o-", label=name)
powers.semilogy(coefficients[1:], articulation[1:], "k--", label="work of articulation")
powers.set(xlabel="friction coefficient", ylabel="power lost [W]")
powers.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
whole.plot(coefficients, 100.0 * (1.0 - np.array(efficiencies)), "o-")
whole.set(xlabel="friction coefficient", ylabel="1 - efficiency [%]")
whole.set_ylim(0.0, None)
for axes in (powers, whole):
    axes.set_xticks(coefficients)
    axes.grid(alpha=0.3)
figure.savefig("friction.png")
