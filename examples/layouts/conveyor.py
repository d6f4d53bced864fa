"""Conveyor: 2,000 links of 19 mm pitch, seen from above.

Both strands are long springs, which the head shaft starts from rest; the tail shaft follows when
the tension wave has arrived there.
"""

import rustchain as rc

pitch = 0.01905
ramp = rc.PrescribedSpeed(((0.0, 0.0), (0.1, 5.0)))
drive = rc.chain_drive(
    "ANSI 60",
    [
        rc.Sprocket(24, (0.0, 0.0), ramp),
        rc.Sprocket(24, (988 * pitch, 0.0), rc.Free()),
    ],
    links=2000,
    adjust=2,
    gravity=(0.0, 0.0),
    name="conveyor",
)
report = drive.check()
print(report)

simulation = rc.Simulation(drive)
result = simulation.run(duration=0.02, report_step=5e-4, record=["hinges", "sprockets", "bodies"])
print(f"{result.stats['steps']} steps")
figure = result.plot.drive(time=0.02)
axes = figure.axes[0]
figure.set_layout_engine("none")
figure.set_size_inches(8.0, 3.4)
axes.set(xlim=(-0.12, 0.45), ylim=(-0.11, 0.11))
axes.set_title("head of the conveyor, t = 0.02 s", loc="left", fontsize=9.5, weight="bold")
figure.savefig("conveyor.png")
