"""The pictures of gallery.md and the page itself; running it writes them.

The tests draw the pictures again and compare them with those in docs/images/gallery.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import rustchain as rc
from rustchain.plot import draw_map, draw_waterfall, use_theme

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = Path(__file__).with_name("gallery.md")
IMAGES = Path(__file__).parents[1] / "images" / "gallery"
DPI = 90

HEAD = """# Figures

Every figure of `result.plot`: those of chain drives are drawn for the published drive with 25 N
over 0.05 s, those of mechanisms for a slider-crank. [The script](gallery_page.py) has the calls.
[Post-processing](outputs.md) explains the quantities. `rustchain.plot.use_theme("dark")` draws the
figures that follow on a dark ground. The colours are distinct for people with red-green colour
blindness, too (`tests/python/plot/test_colors.py`).
"""


def drive_figures() -> dict[str, Callable[[], Figure]]:
    """Return what draws the figures of a chain drive, by the call."""
    result = rc.Simulation(rc.paper_drive(25.0)).run(
        duration=0.05, record=("hinges", "teeth", "sprockets", "bodies", "energy"), progress=False
    )
    plot = result.plot
    return {
        "result.plot.drive()": plot.drive,
        "result.plot.tension()": plot.tension,
        "result.plot.hinge_force(6, 11)": lambda: plot.hinge_force(6, 11),
        "result.plot.tooth_force(6, 11)": lambda: plot.tooth_force(6, 11),
        "result.plot.orbit(6, 11)": lambda: plot.orbit(6, 11, start=0.01),
        "result.plot.force_penetration(6)": lambda: plot.force_penetration(6),
        "result.plot.hinge_loads()": plot.hinge_loads,
        "result.plot.tooth_loads(1)": plot.tooth_loads,
        "result.plot.polar_tooth_loads(1, 2)": lambda: plot.polar_tooth_loads(1, 2),
        "result.plot.wrap_loads(1, 2)": lambda: plot.wrap_loads(1, 2),
        "result.plot.contact_pressure()": plot.contact_pressure,
        "result.plot.engagements()": plot.engagements,
        "result.plot.transmission_error()": plot.transmission_error,
        "result.plot.speed_ripple(2)": plot.speed_ripple,
        "result.plot.strand_motion('upper')": lambda: plot.strand_motion("upper"),
        "result.plot.spectrum('strand_tension')": lambda: plot.spectrum("strand_tension"),
        "result.plot.power_balance()": plot.power_balance,
        "result.plot.energy()": plot.energy,
        "use_theme('dark'); result.plot.hinge_loads()": lambda: _in_the_dark(plot.hinge_loads),
    }


def mechanism_figures() -> dict[str, Callable[[], Figure]]:
    """Return what draws the figures of a mechanism, by the call."""
    m = rc.Mechanism(name="slider-crank")
    m.add_body("crank", mass=0.3, inertia=6e-5, position=(0.025, 0.0, 0.0))
    m.add_body("rod", mass=0.21, inertia=2.5e-4, position=(0.11, 0.0, 0.0))
    m.add_body("slider", mass=0.14, inertia=1e-4, position=(0.17, 0.0, 0.0))
    m.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    m.add_revolute("crank pin", "crank", "rod", at=(0.05, 0.0))
    law = rc.SurfaceContact(rc.LankaraniNikravesh(), length=0.015)
    bore = {"bore_radius": 0.01, "pin_radius": 0.0099, "pin_point": (0.06, 0.0)}
    m.add_clearance_joint("wrist pin", "slider", "rod", law=law, **bore)
    m.add_prismatic("guide", "ground", "slider", direction=(1.0, 0.0))
    m.add_driver("motor", "ground", "crank", speed=rc.rpm(1500))
    plot = rc.Simulation(m).run(duration=0.04, progress=False).plot
    return {
        "result.plot.motion()": plot.motion,
        "result.plot.paths()": plot.paths,
        "result.plot.joint_loads('bearing', 'motor')": lambda: plot.joint_loads("bearing", "motor"),
        "result.plot.contact_force()": plot.contact_force,
    }


def sweep_figures() -> dict[str, Callable[[], Figure]]:
    """Return what draws the figures of sweeps, by the call."""
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=20.0, torque=-3.0)
    speeds = [float(speed) for speed in np.linspace(20.0, 60.0, 9)]
    kept = rc.sweep(drive, {"speed": speeds}, duration=0.2, record=("sprockets",), progress=False)
    axes = {"pretension": [0.0, 25.0, 50.0, 100.0], "speed": [5.0, 10.0, 15.0, 20.0, 25.0]}
    measured = rc.sweep(rc.paper_drive(), axes, _largest, duration=0.02, progress=False)
    return {
        "draw_waterfall(sweep)": lambda: draw_waterfall(kept),
        "draw_map(sweep, 'tooth_force')": lambda: draw_map(measured, "tooth_force"),
    }


def _largest(result: rc.Result) -> dict[str, float]:
    return {"tooth_force": float(result.peaks.tooth_force.max())}


def _in_the_dark(draw: Callable[[], Figure]) -> Figure:
    use_theme("dark")
    try:
        return draw()
    finally:
        use_theme("light")


def name_of(call: str) -> str:
    """Return the name of a picture."""
    words = "".join(sign if sign.isalnum() else " " for sign in call.removeprefix("result.plot."))
    return "_".join(words.split()) + ".png"


GROUPS = {
    "Chain drives": drive_figures,
    "Mechanisms": mechanism_figures,
    "Sweeps": sweep_figures,
}


def main() -> None:
    """Write page and pictures."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    lines = [HEAD]
    for title, figures in GROUPS.items():
        lines.append(f"## {title}\n")
        for call, draw in figures().items():
            draw().savefig(IMAGES / name_of(call), dpi=DPI, metadata={"Software": None})
            lines.append(f"`{call}`\n\n![{call}](../images/gallery/{name_of(call)})\n")
    PAGE.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
