"""Colours of drawn bodies, in light and in dark."""

from __future__ import annotations

from typing import Literal, NamedTuple

from rustchain.plot.shapes import Kind

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

_CSS: dict[Theme, dict[str, str]] = {
    "light": {
        "ink": INK["light"], "dim": "#5c636c", "paper": PAPER["light"], "soft": "#f1f4f7",
        "line": "#d8dde3", "accent": "#0b64a0",
        "c1": "#0b64a0", "c2": "#d9730d", "c3": "#2a8f5b", "c4": "#b8323a", "c5": "#7d5ba6",
        "c6": "#8c6d1f",
    },
    "dark": {
        "ink": INK["dark"], "dim": "#9aa5b1", "paper": PAPER["dark"], "soft": "#222830",
        "line": "#38414c", "accent": "#6db7ee",
        "c1": "#6db7ee", "c2": "#f2a154", "c3": "#63c593", "c4": "#f0858c", "c5": "#b79be0",
        "c6": "#cdb05c",
    },
}  # fmt: skip


def theme_css() -> str:
    """Return the colours of pages: light or dark as the reader has it, or as `data-theme` says."""
    light, dark = (
        "; ".join(f"--{name}: {color}" for name, color in _CSS[theme].items())
        for theme in ("light", "dark")
    )
    return (
        f":root {{ color-scheme: light dark; {light} }}\n"
        f"@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
        f':root[data-theme="light"] {{ color-scheme: light; {light} }}\n'
        f':root[data-theme="dark"] {{ color-scheme: dark; {dark} }}\n'
        "body { background: var(--paper); color: var(--ink); }"
    )
