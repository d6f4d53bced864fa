"""Vertical drive: the chain hangs on the upper sprocket.

Without a tensioner it leaves the teeth of the lower one.
A tensioner pulls the lower shaft down, so that the chain stays on it.
"""

import rustchain as rc

drive = rc.chain_drive(
    "ANSI 40",
    [
        rc.Sprocket(19, (0.0, 0.5), rc.PrescribedSpeed(20.0)),
        rc.Sprocket(19, (0.0, 0.0), rc.AppliedTorque(-1.0)),
    ],
    adjust=2,
    direction=(0.0, -1.0),
    tensioner=rc.Tensioner(30.0, sprocket=2, direction=(0.0, -1.0), damping=500.0),
    name="vertical",
)
print(drive.check())

simulation = rc.Simulation(drive, start="static")
print(f"at rest to {simulation.rest['residual']:.1e} N")
result = simulation.run(duration=0.05, record=["hinges", "sprockets", "bodies"])
for name in result.strand_names:
    print(f"{name} strand: {result.strand(name).tension[250:].mean():.0f} N in the mean")
result.plot.drive(time=0.05).savefig("vertical.png")
