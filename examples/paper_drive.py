"""Published drive: tooth forces of two bushings over half a second.

Each stay of a bushing on a tooth is a row of impacts; the first one is the hardest.
"""

import rustchain as rc

drive = rc.paper_drive()
result = rc.Simulation(drive).run(duration=0.5)

lost, missed = 1e3 * result.energy.dissipated[-1], 1e3 * result.energy.residual[-1]
print(result.message, f"in {result.stats['steps']} steps")
print(f"dissipated {lost:.3f} mJ, residual of the energy balance {missed:.1e} mJ")
result.plot.tooth_force(6, 11).savefig("paper_drive.png")
