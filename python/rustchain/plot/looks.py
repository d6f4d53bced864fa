"""Colours of drawn bodies and of the arrows of forces, in light and in dark."""

from __future__ import annotations

from typing import NamedTuple, get_args

from rustchain.plot import colors
from rustchain.plot.colors import Theme, in_theme
from rustchain.plot.shapes import Kind


class Look(NamedTuple):
    """Colours of one kind of outline: face (None: not filled), its opacity, edge."""

    face: str | None
    opacity: float
    edge: str


_LIGHT: dict[Kind, Look] = {
    "sprocket": Look(colors.STEEL, 1.0, colors.GREY),
    "hub": Look(colors.PAPER, 1.0, colors.GREY),
    "mark": Look(None, 1.0, colors.GREY),
    "arm": Look(colors.ARM, 1.0, colors.GREY),
    "spring": Look(None, 1.0, colors.GREY),
    "ground": Look(colors.STEEL, 1.0, colors.GREY),
    "rail": Look(colors.RAIL, 1.0, colors.GREY),
    "anchor": Look(None, 1.0, colors.EDGE),
    "load": Look(colors.STEEL, 1.0, colors.EDGE),
    "body": Look(colors.INNER, 0.55, colors.INNER),
    "profile": Look(None, 1.0, colors.EDGE),
    "inner": Look(colors.INNER, 0.55, colors.INNER),
    "outer": Look(colors.OUTER, 0.55, colors.OUTER),
    "roller": Look(None, 1.0, colors.EDGE),
    "bushing": Look(None, 1.0, colors.EDGE),
    "pin": Look(colors.PAPER, 1.0, colors.EDGE),
}
_ARROWS = {
    "tooth": colors.PUSH,
    "contact": colors.PUSH,
    "hinge": colors.PULL,
    "joint": colors.PULL,
}

LOOKS: dict[Theme, dict[Kind, Look]] = {
    theme: {
        kind: Look(
            None if look.face is None else in_theme(look.face, theme),
            look.opacity,
            in_theme(look.edge, theme),
        )
        for kind, look in _LIGHT.items()
    }
    for theme in get_args(Theme)
}
"""Of each theme, the look of each kind, from the back to the front."""

FORCE_COLORS: dict[Theme, dict[str, str]] = {
    theme: {kind: in_theme(color, theme) for kind, color in _ARROWS.items()}
    for theme in get_args(Theme)
}
"""Colours of the arrows of each kind of force."""
