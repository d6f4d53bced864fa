"""Hoist: a load wheel lifts 10 kg and stops.

The chain begins at an anchor, hangs in a loop to the wheel, and ends in the hook. The weight of the
loop keeps the bushings seated where the chain runs off the wheel.
"""

import rustchain as rc

LIFTED = 10.0  # kg
motor = rc.PrescribedSpeed([(0.0, 0.0), (0.05, 8.0), (0.2, 8.0), (0.23, 0.0)])
drive = rc.open_chain(
    "ANSI 40",
    ends=(rc.AnchoredEnd((-0.16, -0.02), links=50), rc.LoadedEnd(LIFTED, arm=0.08)),
    links=90,
    sprockets=[rc.Sprocket(17, motion=motor)],
    name="hoist",
)
print(drive.check())

simulation = rc.Simulation(drive, start="static")
print(f"at rest to {simulation.rest['residual']:.1e} N")
result = simulation.run(duration=0.4, record=["hinges", "teeth", "sprockets", "bodies"])
hook, motor_side = result.end(2), result.sprocket(1)
rise = hook.position[-1, 1] - hook.position[0, 1]
print(f"lifted by {1e3 * rise:.1f} mm; the hook bears {hook.force[0, 1]:.1f} N at rest,")
print(f"{hook.force[:, 1].max():.1f} N at most while it starts and stops")
print(f"torque of the motor: {motor_side.torque[1000:2000].mean():.3f} N m while it lifts")
result.plot.drive(time=0.4).savefig("hoist.png")
