"""Drive from minimal input: 60 links of ANSI 40 round 17 and 25 teeth.

The generator finds phases, wrap and slack, and lays the slack into the lower strand. The load on
the driven sprocket keeps the upper strand tight; the lower one hangs.
"""

import rustchain as rc

drive = rc.two_sprocket_drive(
    chain="ANSI 40",
    teeth=(17, 25),
    links=60,
    center_distance=0.2465,
    speed=12.566,
    torque=-0.5,
)
print(drive.check())

result = rc.Simulation(drive).run(duration=0.1, record=["hinges", "bodies"])
for name in ("upper", "lower"):
    print(f"{name} strand: {result.strand(name).tension[500:].mean():.1f} N in the mean")
result.plot.drive(time=0.1).savefig("unequal_sprockets.png")
