"""Machine drive: a motor with its torque curve, two loads, an idler on an arm.

The chain is counted round the centres; the reverse idler on its arm takes up what is left over and
holds the slack strand, which leaves the motor, at 120 N. The others add what the loads take.
"""

import rustchain as rc

motor = rc.AppliedTorque(
    curve=((-75.0, 0.0), (-60.0, -9.0), (0.0, -12.0))
)  # [rad/s], [N m]: clockwise
drive = rc.chain_drive(
    "ANSI 40",
    [
        rc.Sprocket(19, (0.0, 0.0), motor, initial_speed=-65.0, load_inertia=4e-3),
        rc.Sprocket(30, (0.38, -0.06), rc.AppliedTorque(4.0), load_inertia=8e-3),
        rc.Sprocket(23, (0.27, 0.24), rc.AppliedTorque(3.0), load_inertia=5e-3),
        rc.Sprocket(15, (0.085, 0.11), side="outside"),
    ],
    tensioner=rc.Tensioner(
        120.0, sprocket=4, pivot=(0.0, 0.05), arm_inertia=2e-4, damping=300.0, ramp_time=0.02
    ),
    name="three shafts",
)
print(drive.check())

simulation = rc.Simulation(drive)
result = simulation.run(duration=0.3, record=["hinges", "sprockets", "bodies"])
for name in result.strand_names:
    print(f"strand {name}: {result.strand(name).tension[2000:].mean():.0f} N in the mean")
for number in range(1, 5):
    print(f"sprocket {number}: {result.sprocket(number).speed[2000:].mean():.2f} rad/s")
result.plot.drive(time=0.3).savefig("three_shafts.png")
