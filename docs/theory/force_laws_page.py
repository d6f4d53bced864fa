"""The tables and figures of force_laws.md, from the laws themselves; running it writes them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

import rustchain as rc

DOCS = Path(__file__).parents[1]
PAGE = Path(__file__).with_name("force_laws.md")
LOAD = 50.0  # [N]

LAWS: dict[str, rc.ForceLaw] = {
    "Hertz (points)": rc.Hertz(),
    "Johnson": rc.Johnson(),
    "enhanced, 2010": rc.EnhancedCylinder(damping=None),
    "enhanced, 2015": rc.EnhancedCylinder(damping=None, coefficients="2015"),
    "Hertz, cylinders": rc.HertzCylinder(),
    "Radzimovsky": rc.Radzimovsky(),
    "ESDU 78035": rc.Esdu78035(),
    "Liu, conformal": rc.LiuConformal(),
}

DAMPINGS: tuple[rc.description.laws.force.Damping, ...] = (
    "hunt-crossley",
    "lankarani-nikravesh",
    "herbert-mcwhannell",
    "lee-wang",
    "flores",
    "gonthier",
    "hu-guo",
    "zhiying-qishao",
)
ASKED = (0.1, 0.3, 0.5, 0.71, 0.8, 0.9, 0.95, 0.99)

# What the laws are told of the published drive's pairs: radii [m], length [m], kind.
Pair = tuple[tuple[float, float], float, rc.description.laws.force.Surfaces]
_R, _DR = 3.96875e-3, 7.9375e-3  # bushing; roller diameter of the profile [m]
_INCH = 0.0254


def pairs() -> dict[str, Pair]:
    """Return the pairs of surfaces of the published drive: 17 teeth after ANSI B29.1."""
    hinge = rc.paper_drive().chain.hinge
    seat = 0.5025 * _DR + 0.0015 * _INCH
    working = 1.3025 * _DR + 0.0015 * _INCH
    b, c = np.deg2rad(18 - 56 / 17), np.deg2rad(17 - 64 / 17)
    topping = _DR * (0.8 * np.cos(b) + 1.4 * np.cos(c) - 1.3025) - 0.0015 * _INCH
    length = rc.paper_drive().chain.tooth_contact_length
    return {
        "pin in bushing": ((hinge.pin_radius, hinge.bore_radius), hinge.length, "internal"),
        "seating curve": ((_R, seat), length, "internal"),
        "working curve": ((_R, working), length, "internal"),
        "flat": ((_R, topping), length, "flat"),
        "topping curve": ((_R, topping), length, "external"),
    }


def penetration(law: rc.ForceLaw, pair: Pair, force: float) -> float:
    """Return the penetration [m] at which a law gives `force` [N]."""
    low, high = 1e-12, 1e-2
    while high / low > 1.0 + 1e-12:
        middle = np.sqrt(low * high)
        if law.elastic_force(middle, *pair) < force:
            low = middle
        else:
            high = middle
    return float(low)


def penetration_table() -> str:
    """Return the penetrations under the load, in micrometres, a row for each law."""
    surfaces = pairs()
    rows = [
        f"| penetration at {LOAD:.0f} N [µm] | {' | '.join(surfaces)} |",
        "|---" * (len(surfaces) + 1) + "|",
    ]
    for name, law in LAWS.items():
        depths = (1e6 * penetration(law, pair, LOAD) for pair in surfaces.values())
        rows.append(f"| {name} | {' | '.join(f'{depth:.4f}' for depth in depths)} |")
    return "\n".join(rows)


def restitution_table() -> str:
    """Return the effective restitution for each requested one, a row for each damping law."""
    rows = [
        f"| requested | {' | '.join(f'{asked:g}' for asked in ASKED)} |",
        "|---" * (len(ASKED) + 1) + "|",
    ]
    for damping in DAMPINGS:
        obtained = (rc.effective_restitution(damping, asked) for asked in ASKED)
        rows.append(f"| {damping} | {' | '.join(f'{each:.4f}' for each in obtained)} |")
    return "\n".join(rows)


TABLES = {"penetration": penetration_table, "restitution": restitution_table}


def with_table(text: str, name: str, table: str) -> str:
    """Return a page with what stands between the marks of `name` replaced."""
    between = rf"(<!-- {name} -->\n).*?(<!-- end -->)"
    found, count = re.subn(between, lambda m: f"{m[1]}{table}\n{m[2]}", text, flags=re.DOTALL)
    if count != 1:
        msg = f"{PAGE.name} has {count} places for the table {name!r}, not one"
        raise ValueError(msg)
    return found


def draw_forces(path: Path) -> None:
    """Draw the force over the penetration: each pair up to 100 N, and the pin's to the ends."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 3, figsize=(10.5, 6.4), layout="constrained")
    styles = ["-", "-", "--", ":", "-", "-.", "--", "-"]
    surfaces = pairs()
    for panel, (name, pair) in zip(axes.flat, surfaces.items(), strict=False):
        far = 1.15 * penetration(rc.Esdu78035(), pair, 100.0)
        depth = np.linspace(0.0, far, 300)
        for (label, law), style in zip(LAWS.items(), styles, strict=True):
            panel.plot(1e6 * depth, law.elastic_force(depth, *pair), style, label=label)
        panel.set(title=name, xlim=(0, 1e6 * far), ylim=(0, 100))
    panel = axes[1, 2]
    depth = np.geomspace(1e-9, 2e-4, 400)
    for law, style in zip(LAWS.values(), styles, strict=True):
        force = law.elastic_force(depth, *surfaces["pin in bushing"])
        panel.loglog(1e6 * depth, force, style)
    panel.set(title="pin in bushing, past the ends", ylim=(0.05, 1e6))
    figure.supxlabel("penetration [µm]")
    figure.supylabel("elastic force [N]")
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False
    )
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_restitution(path: Path) -> None:
    """Draw the effective restitution over the requested one."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 4.6), layout="constrained")
    asked = np.linspace(0.01, 1.0, 200)
    axes.plot([0, 1], [0, 1], color="0.8", linewidth=4, label="as requested")
    styles = ["-", "--", "-.", ":", "-", "--", "-.", ":"]
    for damping, style in zip(DAMPINGS, styles, strict=True):
        obtained = [rc.effective_restitution(damping, each) for each in asked]
        axes.plot(asked, obtained, style, label=damping)
    axes.set(
        xlabel="requested restitution", ylabel="effective restitution", xlim=(0, 1), ylim=(0, 1)
    )
    axes.legend(frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    """Write the tables into the page, and the figures."""
    text = PAGE.read_text()
    for name, table in TABLES.items():
        text = with_table(text, name, table())
    PAGE.write_text(text)
    draw_forces(DOCS / "images" / "laws.png")
    draw_restitution(DOCS / "images" / "restitution.png")


if __name__ == "__main__":
    main()
