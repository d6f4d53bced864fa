"""Strand of a conveyor: goods on a slide, against a counterweight.

A load at either end keeps the chain on its two wheels; between them its plates bear on a rail, with
friction. The motor on the right starts it from rest and then runs at a steady speed.
"""

import math
from dataclasses import replace

import rustchain as rc

LINKS, HANGING = 84, 16
PLATES = 0.0118  # m, height of what slides
THICK = 0.006  # m, the rail
chain = rc.catalogue_chain("ANSI 40", links=LINKS)
chain = replace(chain, carried=[(link, 0.5) for link in range(27, 39, 2)])
crest = 0.5 * chain.pitch / math.sin(math.pi / 17)  # of the seats; bushings lie a little lower
slide = rc.GuideRail(
    center=(0.3, crest - 0.5 * (PLATES + THICK) - 6e-4),
    direction=(0.0, 1.0),
    length=0.46,
    end_radius=0.5 * THICK,
    plate_height=PLATES,
)
motor = rc.PrescribedSpeed([(0.0, 0.0), (0.05, -6.0)])
drive = rc.open_chain(
    chain,
    ends=(rc.LoadedEnd(4.0, links=HANGING), rc.LoadedEnd(4.0)),
    links=LINKS,
    sprockets=[rc.Sprocket(17), rc.Sprocket(17, (0.6, 0.0), motor)],
    guides=[slide],
    name="strand of a conveyor",
)
print(drive.check())

simulation = rc.Simulation(
    drive, start="static", tooth_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.15))
)
print(f"at rest to {simulation.rest['residual']:.1e} N")
result = simulation.run(
    duration=0.25, report_step=2e-4, record=["hinges", "teeth", "sprockets", "bodies"]
)
moved = result.end(1).position[-1, 1] - result.end(1).position[0, 1]
steady = slice(len(result.time) // 2, None)
print(f"the counterweight has risen by {1e3 * moved:.1f} mm")
for strand in result.strand_names:
    tension = result.strand(strand).tension[steady]
    print(f"strand {strand}: {tension.mean():.1f} N, up to {tension.max():.1f} N")
result.plot.drive(time=0.25).savefig("conveyor_strand.png")
