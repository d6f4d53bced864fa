"""Colours of drawn bodies, in light and in dark."""

from __future__ import annotations

from typing import Literal, NamedTuple

from rustchain.plot.shapes import Kind
from rustchain.plot.style import BLUE, CYCLE, GREY, GRID

Theme = Literal["light", "dark"]


class Look(NamedTuple):
    """Colours of one kind of outline: face (None: not filled), its opacity, edge."""

    face: str | None
    opacity: float
    edge: str


_BLUE, _AMBER = "#5b8fb9", "#f0b35a"


def _looks(steel: str, grey: str, ink: str, paper: str, rail: str, arm: str) -> dict[Kind, Look]:
    return {
        "sprocket": Look(steel, 1.0, grey),
        "hub": Look(paper, 1.0, grey),
        "mark": Look(None, 1.0, grey),
        "arm": Look(arm, 1.0, grey),
        "spring": Look(None, 1.0, grey),
        "ground": Look(steel, 1.0, grey),
        "rail": Look(rail, 1.0, grey),
        "anchor": Look(None, 1.0, ink),
        "load": Look(steel, 1.0, ink),
        "body": Look(_BLUE, 0.55, _BLUE),
        "profile": Look(None, 1.0, ink),
        "inner": Look(_BLUE, 0.55, _BLUE),
        "outer": Look(_AMBER, 0.55, _AMBER),
        "roller": Look(None, 1.0, ink),
        "bushing": Look(None, 1.0, ink),
        "pin": Look(paper, 1.0, ink),
    }


LOOKS: dict[Theme, dict[Kind, Look]] = {
    "light": _looks("#d5dae0", "#7a7f87", "#3b4048", "#ffffff", "#cfe3d0", "#e6dccb"),
    "dark": _looks("#39424d", "#8b949f", "#c4ccd6", "#14181d", "#33463a", "#4a4335"),
}
"""Of each theme, the look of each kind, from the back to the front."""


def _arrow_colors(of_contacts: str, of_joints: str) -> dict[str, str]:
    return {
        "tooth": of_contacts,
        "contact": of_contacts,
        "hinge": of_joints,
        "joint": of_joints,
    }


FORCE_COLORS: dict[Theme, dict[str, str]] = {
    "light": _arrow_colors("#c2410c", "#0b3d91"),
    "dark": _arrow_colors("#ff9a62", "#8fc1ff"),
}
"""Colours of the arrows of each kind of force."""
PAPER: dict[Theme, str] = {"light": "#ffffff", "dark": "#14181d"}
INK: dict[Theme, str] = {"light": "#22262b", "dark": "#dfe5ec"}

# Colours of pages by their names: in light, in dark.
_PAGE = {
    "ink": (INK["light"], INK["dark"]),
    "dim": (GREY, "#9aa5b1"),
    "paper": (PAPER["light"], PAPER["dark"]),
    "soft": ("#f1f4f7", "#222830"),
    "line": (GRID, "#38414c"),
    "accent": (BLUE, "#6db7ee"),
}
_CURVES = ("#6db7ee", "#f2a154", "#63c593", "#f0858c", "#b79be0", "#cdb05c", "#5cc9c9", "#e59ac0")


def theme_css() -> str:
    """Return the colours of pages: light or dark as the reader has it, or as `data-theme` says.

    Curves have the names c1, c2, ...; ``--x0b64a0`` is what stands for #0b64a0 of a figure.
    """
    pairs = _PAGE | {f"c{k}": pair for k, pair in enumerate(zip(CYCLE, _CURVES, strict=True), 1)}
    pairs |= {f"x{light[1:]}": (light, dark) for light, dark in in_dark().items()}
    light, dark = (
        "; ".join(f"--{name}: {pair[k]}" for name, pair in pairs.items()) for k in (0, 1)
    )
    return (
        f":root {{ color-scheme: light dark; {light} }}\n"
        f"@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
        f':root[data-theme="light"] {{ color-scheme: light; {light} }}\n'
        f':root[data-theme="dark"] {{ color-scheme: dark; {dark} }}\n'
        "body { background: var(--paper); color: var(--ink); }"
    )


def in_dark() -> dict[str, str]:
    """Return what stands for each colour of a light figure on a dark page."""
    found = dict(zip(CYCLE, _CURVES, strict=True)) | dict(_PAGE.values())
    found |= {"#000000": INK["dark"], "#808080": _PAGE["dim"][1]}
    for kind, look in LOOKS["light"].items():
        dark = LOOKS["dark"][kind]
        found[look.edge] = dark.edge
        if look.face is not None and dark.face is not None:
            found[look.face] = dark.face
    return found | {CYCLE[0]: _CURVES[0]}
