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
