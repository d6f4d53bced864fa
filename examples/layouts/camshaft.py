"""Camshaft drive: two camshafts, a blade with a hydraulic tensioner, a rail.

The blade presses on the slack strand; its plunger follows the chain through its check valve and
gives way only as lubricant leaks: the dashpot is fifty times harder back than forth. The cams'
torque changes sign twice a turn. Both guides are of polyamide.
"""

import math

import rustchain as rc

speed = -100.0  # of the crankshaft [rad/s]: 950 rpm, clockwise
# Valve springs hold the cams back and push them on.
times = [5e-4 * k for k in range(201)]
cams = rc.AppliedTorque(tuple((t, 1.5 + 4.0 * math.sin(speed * t)) for t in times))
polyamide = rc.Material(elastic_modulus=3e9, poisson_ratio=0.4)
blade = rc.GuideRail(
    center=(-0.0945, 0.134),
    direction=(0.943, 0.332),
    length=0.16,
    radius=0.35,
    arm=rc.GuideArm(
        pivot=(-0.071, 0.039),
        force=40.0,
        ramp_time=0.01,
        damping=40.0,
        damping_back=2000.0,
        travel=(0.03, 0.02),
        inertia=5e-4,
    ),
    material=polyamide,
)
rail = rc.GuideRail(
    center=(0.0895, 0.132), direction=(-0.943, 0.332), length=0.16, material=polyamide
)
drive = rc.chain_drive(
    "ANSI 35",
    [
        rc.Sprocket(21, (0.0, 0.0), rc.PrescribedSpeed(speed)),
        rc.Sprocket(42, (0.072, 0.3025), cams, load_inertia=4e-4),
        rc.Sprocket(42, (-0.072, 0.3025), cams, load_inertia=4e-4),
    ],
    links=114,
    guides=[blade, rail],
    name="camshaft",
)
print(drive.check())

simulation = rc.Simulation(drive, start="static")
print(f"at rest to {simulation.rest['residual']:.1e} N")
result = simulation.run(duration=0.06, record=["hinges", "teeth", "sprockets", "bodies"])
for name in result.strand_names:
    print(f"strand {name}: {result.strand(name).tension[300:].mean():.0f} N in the mean")
for number in (2, 3):
    ripple = result.sprocket(number).speed[300:]
    print(f"camshaft {number - 1}: {ripple.mean():.2f} rad/s, {ripple.std():.2f} rad/s ripple")
on_blade = (result.array("tooth_sprocket") == 4).sum(axis=1)
print(f"{on_blade[300:].mean():.1f} bushings on the blade")
result.plot.drive(time=0.06).savefig("camshaft.png")
