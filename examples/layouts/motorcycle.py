"""Final drive of a motorcycle: 15 to 42 teeth at 60 km/h.

The upper strand pulls; the lower one hangs with the slack that the swing arm's travel needs.
"""

import rustchain as rc

speed = 150.0  # of the countershaft [rad/s]: the machine goes to the left
drive = rc.chain_drive(
    "ANSI 50",
    [
        rc.Sprocket(15, (0.0, 0.0), rc.PrescribedSpeed(speed)),
        # 120 kg on a wheel of 0.31 m, pulled by 500 N.
        rc.Sprocket(42, (0.6245, -0.02), rc.AppliedTorque(-155.0), load_inertia=12.0),
    ],
    name="motorcycle",
)
print(drive.check())

simulation = rc.Simulation(drive, start="static")
result = simulation.run(duration=0.05, record=["hinges", "teeth", "sprockets", "bodies"])
for name in result.strand_names:
    print(f"{name} strand: {result.strand(name).tension[250:].mean():.0f} N in the mean")
print(f"hardest tooth force: {result.peaks.tooth_force.max():.0f} N")
result.plot.drive(time=0.05).savefig("motorcycle.png")
