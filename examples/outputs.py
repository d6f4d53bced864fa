"""Post-processing of a loaded drive: loads, power, pressure, transmission error.

A motor at 25 rad/s, a load of 3 N m, 60 N of pretension; one revolution of the chain after the
start has settled.
"""

import rustchain as rc

drive = rc.two_sprocket_drive(
    "ANSI 40", teeth=(17, 25), links=72, speed=25.0, torque=-3.0, pretension=60.0
)
result = rc.Simulation(drive).run(
    duration=1.5, record=("hinges", "teeth", "sprockets", "bodies", "energy")
)
steady = result.between(start=0.4)
for name, value in steady.summary().items():
    print(f"{name:24} {value:.4g}")

plot = steady.plot
figures = {
    "hinge_loads": plot.hinge_loads(),
    "tooth_loads": plot.tooth_loads(1),
    "wrap_loads": plot.wrap_loads(1, 2),
    "transmission_error": plot.transmission_error(),
    "speed_ripple": plot.speed_ripple(2),
    "power_balance": plot.power_balance(),
    "contact_pressure": plot.contact_pressure("tooth"),
    "strand_spectrum": plot.strand_spectrum("upper", segment=0.5),
    "engagements": plot.engagements(),
}
for name, figure in figures.items():
    figure.savefig(f"outputs_{name}.png", dpi=110)
