"""Reducer: 15 to 38 teeth at the shortest usual centre distance, 30 pitches.

The generator counts the links; the centre then moves until the chain is taut.
"""

import rustchain as rc

drive = rc.chain_drive(
    "ANSI 40",
    [
        rc.Sprocket(15, (0.0, 0.0), rc.PrescribedSpeed(50.0)),
        rc.Sprocket(38, (30 * 0.0127, 0.0), rc.AppliedTorque(-5.0), load_inertia=0.02),
    ],
    adjust=2,
    name="15 to 38",
)
print(drive.check())

result = rc.Simulation(drive).run(duration=0.05, record=["hinges", "sprockets", "bodies"])
for name in result.strand_names:
    print(f"{name} strand: {result.strand(name).tension[250:].mean():.0f} N in the mean")
slow = result.sprocket(2).speed[250:]
print(f"large sprocket: {slow.mean():.3f} rad/s, {50.0 * 15 / 38:.3f} by the teeth")
result.plot.drive(time=0.05).savefig("unequal_15_38.png")
