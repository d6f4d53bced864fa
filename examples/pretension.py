"""Effect of pretension: orbits of a pin in its bushing at 0 and 25 N.

The tensioner reaches its full force in 0.1 s. From then on the pins of the tightened chain stay on
the circle of contact onset; without pretension they leave it again and again.
"""

import matplotlib.pyplot as plt

import rustchain as rc

figure, panels = plt.subplots(
    1, 2, figsize=(8.0, 4.2), sharex=True, sharey=True, layout="constrained"
)
for axes, pretension in zip(panels, (0.0, 25.0), strict=True):
    drive = rc.paper_drive(pretension=pretension)
    result = rc.Simulation(drive).run(duration=0.2, record=["hinges"])
    x, y = 1e6 * result.hinge(34).eccentricity.T
    late = result.time > 0.1
    apart = (result.array("hinge_penetration")[late] <= 0.0).mean()
    print(f"{pretension:g} N: {apart:.2%} of all hinges and reports after 0.1 s without contact")
    axes.plot(x[~late], y[~late], linewidth=0.5, color="0.7", label="0 to 0.1 s")
    axes.plot(x[late], y[late], linewidth=0.7, color="tab:blue", label="0.1 to 0.2 s")
    clearance = 1e6 * drive.chain.hinge.clearance
    axes.add_patch(plt.Circle((0.0, 0.0), clearance, fill=False, color="red"))
    axes.set(aspect="equal", xlabel="x [µm]", title=f"pin 34, pretension {pretension:g} N")
panels[0].set_ylabel("y [µm]")
panels[1].legend(loc="lower right")
figure.savefig("pretension.png")
