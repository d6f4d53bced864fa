"""Four tooth forms, each with a seated bushing and the pitch circle."""

import matplotlib.pyplot as plt
import numpy as np

import rustchain as rc

chain = rc.paper_drive().chain
forms = {
    "AnsiTooth(), and cut": (rc.AnsiTooth(), rc.AnsiTooth(tip="cut")),
    "IsoTooth, minimum and maximum gap": (rc.IsoTooth("minimum"), rc.IsoTooth("maximum")),
    "StraightTooth(0.45)": (rc.StraightTooth(0.45),),
    "damaged_teeth=((0, 0.4), (1, 0.0))": (rc.IsoTooth(0.5),),
}
figure, panels = plt.subplots(2, 2, figsize=(9, 8), layout="constrained")
turn = np.linspace(0.0, 2.0 * np.pi, 200)
for panel, (title, profiles) in zip(panels.flat, forms.items(), strict=True):
    for profile, style in zip(profiles, ("-", "--"), strict=False):
        damaged = ((0, 0.4), (1, 0.0)) if "damaged" in title else ()
        sprocket = rc.Sprocket(17, profile=profile, damaged_teeth=damaged)
        x, y = 1e3 * sprocket.outline(chain, points=40).T
        panel.plot(x, y, style, color="black", linewidth=1.0)
    radius = 1e3 * chain.pitch / (2.0 * np.sin(np.pi / 17))
    panel.plot(radius * np.cos(turn), radius * np.sin(turn), ":", color="grey", linewidth=0.8)
    bushing = 1e3 * chain.bushing_radius
    for gap in range(-1, 3):
        cx, cy = radius * np.array([np.cos(gap * 2 * np.pi / 17), np.sin(gap * 2 * np.pi / 17)])
        panel.plot(cx + bushing * np.cos(turn), cy + bushing * np.sin(turn), linewidth=0.8)
    panel.set(title=title, xlim=(22, 44), ylim=(-9, 21), aspect="equal", xlabel="mm", ylabel="mm")
figure.savefig("tooth_forms.png", dpi=130)
