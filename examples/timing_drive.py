"""Natural frequencies of the tight strand of a timing drive.

The drive is that of `timing_drive.toml`: 114 links of ISO 06B, 21 teeth on the crankshaft, 42 on
the camshaft, a blade on the slack strand. The camshaft takes 8 N m. After the start has settled,
the tight strand is plucked in its first three modes. The peaks of its spectrum stand beside the
frequencies of a string that moves along itself: f = n (c² - v²)/(2 L c), c = sqrt(T/μ) (Swope and
Ames, Vibration of a moving threadline, 1963). T is the mean tension of the run, centrifugal part
μ v² and all.

Peaks and formula agree to 1.3 %. The ends of the strand are not fixed as those of the string:
they roll off the sprockets. The tension varies while the blade moves, and peaks are broad,
because 0.3 s are ten periods of the first mode. At 400 rad/s the motion alone lowers the
frequencies by a sixth: a string at rest with the same tension, dashed, is far off. What one
learns: centrifugal tension hardly stiffens a strand. Measured frequencies of a fast drive give a
tension too low if its speed is left out.
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

SPEEDS = (100.0, 250.0, 400.0)  # of the crankshaft [rad/s]
SETTLED, DURATION = 0.08, 0.3  # [s]
PLUCKED = (0.3, 0.2, 0.15)  # velocity of each mode [m/s]
STRAND = "lower"  # right of the line from the crankshaft to the camshaft
scene = rc.load_scene(Path(sys.argv[0]).with_name("timing_drive.toml"))
drive = scene.system
crank, cam = drive.sprockets
report = drive.check()
first, second = report.pitch_radius
mass = 0.5 * (drive.chain.inner.mass + drive.chain.outer.mass) / drive.chain.pitch  # [kg/m]
tilt = math.asin((second - first) / report.center_distance)
begin = first * np.array([math.cos(tilt), -math.sin(tilt)])
along = np.array([math.sin(tilt), math.cos(tilt)])
outward = np.array([math.cos(tilt), -math.sin(tilt)])
span = math.sqrt(report.center_distance**2 - (second - first) ** 2)


def plucked(speed):
    """Return the result of the drive at a speed [rad/s] from when its tight strand is plucked."""
    fast = replace(crank, motion=rc.PrescribedSpeed(-speed))
    turning = replace(scene, system=replace(drive, sprockets=[fast, cam]))
    before = rc.Simulation(turning)
    before.step_to(SETTLED)
    positions, velocities = before.positions.copy(), before.velocities.copy()
    offset = positions[: drive.chain.links, :2] - begin
    x = offset @ along / span
    free = (np.abs(offset @ outward) < 0.2 * drive.chain.pitch) & (x > 0.0) & (x < 1.0)
    for mode, share in enumerate(PLUCKED, 1):
        phase = mode * math.pi * x[free]
        velocities[: len(x), :2][free] += share * np.sin(phase)[:, None] * outward
        velocities[: len(x), 2][free] -= share * mode * math.pi / span * np.cos(phase)
    arm = replace(drive.guides[0].arm, ramp_time=0.0)
    ready = replace(turning.system, guides=[replace(drive.guides[0], arm=arm)])
    again = replace(turning, system=ready, positions=positions, velocities=velocities)
    return rc.Simulation(again).run(DURATION, 4e-4, record=("hinges", "sprockets", "bodies"))


def peak(frequency, density, near):
    """Return the frequency of the highest peak within a quarter of a frequency [Hz]."""
    around = np.flatnonzero(np.abs(frequency / near - 1.0) < 0.25)
    top = around[density[around].argmax()]
    left, here, right = np.log(density[top - 1 : top + 2])
    return frequency[top] + 0.5 * (left - right) / (left - 2.0 * here + right) * frequency[1]


modes = np.arange(1, len(PLUCKED) + 1)
deviations = {}
figure, (spectra, frequencies) = plt.subplots(1, 2, figsize=(9.5, 4.0), layout="constrained")
found, moving, resting = [], [], []
for speed, colour in zip(SPEEDS, ("tab:blue", "tab:green", "tab:red"), strict=True):
    result = plucked(speed)
    tension = float(result.strand(STRAND).tension.mean())
    velocity = crank.teeth * drive.chain.pitch * speed / (2.0 * math.pi)
    wave = math.sqrt(tension / mass)
    resting.append(modes * wave / (2.0 * span))
    moving.append(resting[-1] * (1.0 - (velocity / wave) ** 2))
    spectrum = result.strand_spectrum(STRAND, stations=(1 / 6, 0.25, 0.5, 0.7))
    frequency = spectrum["frequency"].to_numpy()
    density = spectrum["density"].sum("station").to_numpy()
    found.append([peak(frequency, density, near) for near in moving[-1]])
    print(f"{speed:.0f} rad/s: chain {velocity:.1f} m/s, wave {wave:.1f} m/s, {tension:.0f} N")
    for mode, (ours, formula) in enumerate(zip(found[-1], moving[-1], strict=True), 1):
        deviations[f"mode {mode} at {speed:g} rad/s"] = ours / formula - 1.0
        print(
            f"    mode {mode}: {ours:6.1f} Hz, moving string {formula:6.1f} Hz "
            f"({ours / formula - 1.0:+.1%}), string at rest {resting[-1][mode - 1]:6.1f} Hz"
        )
    spectra.semilogy(frequency, density, color=colour, linewidth=1.0, label=f"{speed:g} rad/s")
    for near in moving[-1]:
        spectra.axvline(near, color=colour, linestyle=":", linewidth=0.8)
spectra.set(
    xlabel="frequency [Hz]",
    ylabel="motion across the strand [m²/Hz]",
    xlim=(0.0, 150.0),
    ylim=(1e-13, 1e-5),
)
spectra.legend(title="dotted: moving string", loc="lower right")
for mode in modes - 1:
    frequencies.plot(SPEEDS, [row[mode] for row in found], "o", color=f"C{mode}")
    frequencies.plot(
        SPEEDS, [row[mode] for row in moving], color=f"C{mode}", label=f"mode {mode + 1}"
    )
    frequencies.plot(SPEEDS, [row[mode] for row in resting], "--", color=f"C{mode}", linewidth=0.7)
frequencies.set(
    xlabel="speed of the crankshaft [rad/s]", ylabel="natural frequency [Hz]", ylim=(0.0, 190.0)
)
frequencies.legend(title="points: run, dashed: at rest", loc="upper left")
figure.savefig("timing_drive.png")
