"""Slack chain: a strand that sags by an eighth of its span.

`check()` warns of the sag.
The strand starts on an arc; with start="static" it hangs on its catenary.
"""

import numpy as np

import rustchain as rc

drive = rc.two_sprocket_drive(
    chain="ANSI 40", teeth=(17, 25), links=80, center_distance=0.3665, speed=10.0, torque=-3.0
)
for warning in drive.check().warnings:
    print("warning:", warning)

simulation = rc.Simulation(drive, start="static")
hanging = simulation.positions[: drive.chain.links]
between = hanging[(hanging[:, 0] > 0.05) & (hanging[:, 0] < 0.32) & (hanging[:, 1] < 0.0)]
print(f"lowest point at rest: {1e3 * np.min(between[:, 1]):.1f} mm")
result = simulation.run(duration=0.05, record=["hinges", "bodies"])
for name in result.strand_names:
    print(f"{name} strand: {result.strand(name).tension[250:].mean():.1f} N in the mean")
result.plot.drive(time=0.05).savefig("slack.png")
