"""Colours of figures, animations and pages, and what stands for each on a dark ground.

Neighbours of `CYCLE` and its first four with grey are apart by 15 (CIE 1976) also for people with
red-green or blue-yellow colour blindness (tests/python/plot/test_colors.py).
"""

from __future__ import annotations

from typing import Literal, get_args

Theme = Literal["light", "dark"]

BLUE, ORANGE, GREEN, RED, GREY = "#0b64a0", "#d9730d", "#2a8f5b", "#b8323a", "#7a7f87"
CYCLE = (BLUE, ORANGE, GREEN, RED, "#442082", "#3a1505", "#8f2bd6", "#e25fd2")
INK, PAPER, SOFT, GRID = "#22262b", "#ffffff", "#f1f4f7", "#e4e7eb"
STEEL, EDGE, RAIL, ARM = "#d5dae0", "#3b4048", "#cfe3d0", "#e6dccb"
INNER, OUTER = "#5b8fb9", "#f0b35a"  # links; alike on both grounds
PUSH, PULL = "#c2410c", "#0b3d91"  # arrows: of contacts with teeth and the like, of joints

IN_DARK = {
    **dict(
        zip(
            CYCLE,
            (
                "#6db7ee",
                "#f2b25c",
                "#3fb184",
                "#e8566a",
                "#3cfde6",
                "#88d687",
                "#a83fa5",
                "#9da817",
            ),
            strict=True,
        )
    ),
    GREY: "#8b949f",
    INK: "#dfe5ec",
    PAPER: "#14181d",
    SOFT: "#222830",
    GRID: "#38414c",
    STEEL: "#39424d",
    EDGE: "#c4ccd6",
    RAIL: "#33463a",
    ARM: "#4a4335",
    PUSH: "#ff9a62",
    PULL: "#8fc1ff",
    # What matplotlib draws by itself.
    "#000000": "#dfe5ec",
    "#808080": "#8b949f",
}
"""What stands for each colour on a dark ground; others stay as they are."""


def color_of(k: int) -> str:
    """Return the colour of a curve by its place, from 0; after the last one comes the first."""
    return CYCLE[k % len(CYCLE)]


def in_theme(color: str, theme: Theme) -> str:
    """Return a colour as a theme has it."""
    return IN_DARK.get(color, color) if theme == "dark" else color


def theme_css() -> str:
    """Return the colours of pages: light or dark as the reader has it, or as set by `data-theme`.

    Paper is white: pages are printed in light colours.

    Curves have the names c1, c2, ...; ``--x0b64a0`` is what stands for #0b64a0 of a figure.
    """
    named = {"ink": INK, "dim": GREY, "paper": PAPER, "soft": SOFT, "line": GRID, "accent": BLUE}
    named |= {f"c{k}": color for k, color in enumerate(CYCLE, 1)}
    named |= {f"x{color[1:]}": color for color in IN_DARK}
    light, dark = (
        "; ".join(f"--{name}: {in_theme(color, theme)}" for name, color in named.items())
        for theme in get_args(Theme)
    )
    return (
        f":root {{ color-scheme: light dark; {light} }}\n"
        f"@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
        f':root[data-theme="light"] {{ color-scheme: light; {light} }}\n'
        f':root[data-theme="dark"] {{ color-scheme: dark; {dark} }}\n'
        f"@media print {{ :root:root:root {{ color-scheme: light; {light} }} }}\n"
        "body { background: var(--paper); color: var(--ink); }"
    )
