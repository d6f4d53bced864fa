"""Tight chain: the centres are farther apart than a closed chain allows.

Every hinge lends a part of its clearance. It runs; where the hinges' clearances together do not
give enough, the same chain is refused.
"""

from dataclasses import replace

import rustchain as rc

drive = rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 17), links=60, speed=12.0, torque=-2.0)
first, second = drive.sprockets
x, y = second.center


def apart(distance):
    """Return the drive with its centres moved apart by `distance` [m]."""
    return replace(drive, sprockets=(first, replace(second, center=(x + distance, y))))


play = drive.chain.hinge.bore_radius - drive.chain.hinge.pin_radius
tight = apart(0.3 * play * drive.chain.links)
print(tight.check())
try:
    apart(2.0 * play * drive.chain.links).check()
except rc.InvalidInput as error:
    print("refused:", error)

result = rc.Simulation(tight).run(duration=0.05, record=["hinges", "bodies"])
for name in result.strand_names:
    print(f"{name} strand: {result.strand(name).tension[250:].mean():.0f} N in the mean")
result.plot.drive(time=0.05).savefig("over_tight.png")
