"""Chain tension of a motorcycle: against the torque, and along the sprockets.

The drive is that of `motorcycle_chain.toml`: a 520 chain, 15 to 42 teeth, 60 km/h. Three formulae
of handbooks stand beside the run. The strands differ by the torque over the pitch radius. The
lower strand has its centrifugal tension q v² and the tension of a sagging chain, q g L²/(8 f).
Along a sprocket the tension less q v² falls from tooth to tooth by sin φ/sin(φ + 2π/N) (Binder,
Mechanics of the Roller Chain Drive, 1956). The pressure angle φ of a new chain on ANSI teeth is
35° - 120°/N.

The torque at the wheel is that of the road less what accelerates the wheel during the run. With
this correction the strands differ by what the formula has, to some tenths of a per cent. The
lower strand has more tension than the formula: it swings. The tension falls in the published
series, except where a tooth takes or releases its bushing. The formula assumes seated bushings at
rest, which explains the 1.5 % of the small sprocket. What one learns: three teeth of the small
sprocket have 80 % of the load, the same share as eight teeth of the large one.
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

TORQUES = (50.0, 155.0, 400.0)  # at the wheel [N m]
DURATION, SETTLED = 0.2, 0.08  # [s]
scene = rc.load_scene(Path(sys.argv[0]).with_name("motorcycle_chain.toml"))
drive = scene.system
chain = drive.chain
motor, wheel = drive.sprockets
report = drive.check()
small, large = report.pitch_radius
mass = 0.5 * (chain.inner.mass + chain.outer.mass) / chain.pitch  # [kg/m]
speed = motor.teeth * chain.pitch * motor.motion.speed / (2.0 * math.pi)  # [m/s]
centrifugal = mass * speed**2
sag = mass * 9.81 * report.strand_span[1] ** 2 / (8.0 * report.sag[1])


def loaded(torque):
    """Return the result of a run against a torque at the wheel [N m], without its beginning."""
    braked = replace(wheel, motion=rc.AppliedTorque(-torque))
    changed = replace(drive, sprockets=[motor, braked])
    result = rc.Simulation(replace(scene, system=changed)).run(
        DURATION, record=("hinges", "teeth", "sprockets", "energy")
    )
    return result.between(start=SETTLED)


def by_formula(torque, result):
    """Return the difference of the strands' tensions [N] that turns and accelerates the wheel."""
    late = result.sprocket(2)
    gained = (late.speed[-1] - late.speed[0]) / (late.time[-1] - late.time[0])
    return (torque + wheel.load_inertia * gained) / large


print(f"chain speed {speed:.2f} m/s, {mass:.3f} kg/m: q v² = {centrifugal:.1f} N")
results = {torque: loaded(torque) for torque in TORQUES}
deviations = {}
for torque, result in results.items():
    upper, lower = (float(result.strand(name).tension.mean()) for name in ("upper", "lower"))
    found, expected = upper - lower, by_formula(torque, result)
    deviations[f"tension at {torque:.0f} N m"] = found / expected - 1.0
    print(
        f"{torque:.0f} N m: strands differ by {found:.1f} N, formula {expected:.1f} N "
        f"({found / expected - 1.0:+.2%}); lower strand {lower:.1f} N, "
        f"formula {centrifugal + sag:.1f} N"
    )

figure, (tensions, wraps) = plt.subplots(1, 2, figsize=(9.0, 3.9), layout="constrained")
axis = np.linspace(0.0, 1.05 * TORQUES[-1])
tensions.plot(
    axis, axis / large + centrifugal + sag, color="0.6", label="M/r + q v² + q g L²/(8 f)"
)
for name, colour in (("upper", "tab:blue"), ("lower", "tab:orange")):
    means = [results[torque].strand(name).tension.mean() for torque in TORQUES]
    tensions.plot(TORQUES, means, "o", color=colour, label=f"{name} strand, mean of the run")
tensions.axhline(centrifugal + sag, color="0.6", linestyle=":", label="q v² + q g L²/(8 f)")
tensions.set(xlabel="torque at the wheel [N m]", ylabel="tension [N]", ylim=(0.0, None))
tensions.legend()

loads = results[TORQUES[1]]
for number, (sprocket, colour) in enumerate(
    zip((motor, wheel), ("tab:blue", "tab:red"), strict=True), 1
):
    angle = 2.0 * math.pi / sprocket.teeth
    pressure = math.radians(35.0 - 120.0 / sprocket.teeth)
    factor = math.sin(pressure) / math.sin(pressure + angle)
    wrap = loads.wrap_loads(number)
    # Four values a pitch; from the side of the tight strand.
    tension = wrap["hinge_mean"].to_numpy().reshape(-1, 4).mean(1)[1:-1] - centrifugal
    tension = tension[:: 1 if number == 1 else -1]
    tooth = np.arange(len(tension))
    middle = slice(1, 5 if number == 1 else 12)
    ratio = (tension[middle][-1] / tension[middle][0]) ** (1.0 / (len(tension[middle]) - 1))
    deviations[f"series on {sprocket.teeth} teeth"] = ratio / factor - 1.0
    print(
        f"{sprocket.teeth} teeth: tension falls by {ratio:.4f} a tooth, "
        f"formula {factor:.4f} ({ratio / factor - 1.0:+.2%})"
    )
    wraps.semilogy(tooth, tension, "o", color=colour, label=f"{sprocket.teeth} teeth")
    wraps.semilogy(tooth, tension[1] * factor ** (tooth - 1.0), color=colour, linewidth=0.8)
wraps.set(
    xlabel="teeth from the tight strand",
    ylabel="chain tension less q v² [N]",
    ylim=(3.0, 3e3),
)
wraps.legend(title="mean of the run; lines: Binder's series")
figure.savefig("motorcycle_chain.png")
