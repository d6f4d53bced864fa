"""Lubricant in the hinges: losses and largest hinge force against viscosity.

The published drive with a pretension of 100 N, between 0.1 and 0.15 s.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

viscosities = np.array([0.01, 0.03, 0.1, 0.3, 0.5])  # [Pa s]
BEGIN, END = 0.1, 0.15

drive = rc.paper_drive(pretension=100.0)
drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=2e-3))
places = {
    "film in hinges": "hinge_film",
    "damping in hinges": "hinge_contact",
    "damping on teeth": "tooth_contact",
}
lost, force = {name: [] for name in places}, []
for film in [None, *map(rc.LubricantFilm, viscosities)]:
    law = rc.LankaraniNikravesh(film=film)
    simulation = rc.Simulation(drive, hinge_law=law)
    result = simulation.run(END, 1e-4, record=("hinges", "energy"))
    late = result.time >= BEGIN
    for name, place in places.items():
        energy = getattr(result.energy, place)
        power = 0.0 if energy is None else (energy[late][-1] - energy[late][0]) / (END - BEGIN)
        lost[name].append(power)
    force.append(result.peaks.hinge_force[late].max())
    powers = ", ".join(f"{name} {values[-1]:.3f} W" for name, values in lost.items())
    name = "dry" if film is None else f"{film.viscosity:g} Pa s"
    print(f"{name}: {powers}, largest hinge force {force[-1]:.0f} N, {result.stats['steps']} steps")

names = ["dry", *(f"{viscosity:g}" for viscosity in viscosities)]
figure, (powers, forces) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
base = np.zeros(len(names))
for name, values in lost.items():
    powers.bar(names, values, bottom=base, label=name, alpha=0.8)
    base += values
powers.set(xlabel="viscosity [Pa s]", ylabel="power lost [W]")
powers.legend()
forces.plot(names, force, "o-")
forces.set(
    xlabel="viscosity [Pa s]",
    ylabel="largest force of a hinge [N]",
    ylim=(0.0, 1.1 * max(force)),
)
forces.grid(alpha=0.3)
figure.savefig("film.png")
