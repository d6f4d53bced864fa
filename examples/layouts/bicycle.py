"""Bicycle: chainring, cog, and the two pulleys of a derailleur.

The guide pulley stands outside the chain, the tension pulley inside it, on a cage that swings about
the guide pulley. The upper strand pulls, the lower ones have the tension of the cage's spring.
"""

import rustchain as rc

crank = rc.PrescribedSpeed(-8.4)  # 80 rpm, forward is clockwise
road = rc.AppliedTorque(9.0)
guide = (0.008, -0.078)
drive = rc.chain_drive(
    "ANSI 40",  # the pitch and the rollers of a bicycle chain
    [
        rc.Sprocket(38, (0.42, 0.015), crank),
        rc.Sprocket(15, (0.0, 0.0), road, load_inertia=10.0),  # 90 kg on a wheel of 0.34 m
        rc.Sprocket(11, guide, side="outside"),
        rc.Sprocket(11, (0.03, -0.145)),
    ],
    tensioner=rc.Tensioner(20.0, sprocket=4, pivot=guide, stiffness=300.0, damping=50.0),
    name="bicycle",
)
print(drive.check())

simulation = rc.Simulation(drive, start="static")
print(f"at rest to {simulation.rest['residual']:.1e} N")
result = simulation.run(duration=0.1, record=["hinges", "sprockets", "bodies"])
for name in result.strand_names:
    print(f"strand {name}: {result.strand(name).tension[500:].mean():.0f} N in the mean")
result.plot.drive(time=0.1).savefig("bicycle.png")
