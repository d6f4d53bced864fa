"""The player: a page in which a recorded motion is played, with plots linked to its time."""

from __future__ import annotations

import base64
import json
import math
import zlib
from collections.abc import Sequence
from html import escape
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from rustchain.analysis.window import from_first_row
from rustchain.plot.between_rows import large_force
from rustchain.plot.canvas import THICKNESS, arrow_scale, view_of
from rustchain.plot.colors import theme_css
from rustchain.plot.looks import FORCE_COLORS, LOOKS
from rustchain.plot.shapes import Bar, Forces, Shape
from rustchain.typing import Array

if TYPE_CHECKING:
    from rustchain.plot.animation import Animation
    from rustchain.results.result import Result

LARGEST = 14_000_000  # characters of data in a page; of more rows every second one is left out
_LENGTH, _ANGLE = 1e-7, 1e-6  # [m], [rad] to which bodies are rounded: less than a pixel shows
_FORCE = 1e-5  # of a large force
_WHOLE = 2.0**30  # rounded numbers stay below
_SOLID = ("inner", "outer", "body", "sprocket", "rail", "load")  # what can be pointed at
_PAGE = "body { max-width: 1100px; margin: 0 auto; padding: 12px; }"
_HEIGHT = 860  # [pixels] of the player in a notebook


def player_page(animation: Animation) -> str:
    """Return a page with the player, which needs no other file."""
    title = escape(animation.result.scene.name)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>{theme_css()}\n{_PAGE}</style>"
        f"</head><body>\n{player_part(animation)}</body></html>\n"
    )


def player_frame(animation: Animation) -> str:
    """Return the player in a frame of its own, for a notebook."""
    page = escape(player_page(animation), quote=True)
    style = f"width: 100%; height: {_HEIGHT}px; border: 0"
    return f'<iframe srcdoc="{page}" style="{style}"></iframe>'


def player_part(animation: Animation) -> str:
    """Return the player as a part of a page, whose style is `theme_css`."""
    data = json.dumps(player_data(animation), separators=(",", ":")).replace("<", "\\u003c")
    script = resources.files("rustchain.plot").joinpath("player.js").read_text(encoding="utf-8")
    return (
        f'<div class="player"><script type="application/json">{data}</script></div>\n'
        f"<script>{script}</script>\n"
    )


def player_data(animation: Animation) -> dict[str, Any]:
    """Return all that the player needs: outlines, positions, forces and series, rounded."""
    step = 1
    while True:
        rows = slice(animation.rows.start, animation.rows.stop, step)
        data = _data(animation, rows)
        if length_of(data) <= LARGEST or data["time"]["rows"] < 3:
            return data
        step *= 2


def length_of(data: dict[str, Any]) -> int:
    """Return how many characters the blocks take."""
    blocks = [data["time"], data["places"], data["angles"], data["series"]["block"]]
    return sum(len(block["data"]) for block in (*blocks, *(f["block"] for f in data["forces"])))


def _data(animation: Animation, rows: slice) -> dict[str, Any]:
    result, shapes = animation.result, animation.shapes
    positions = result.array("positions")[rows]
    center, size = view_of(animation)
    whole_center, whole_size = view_of(animation.of_scene())
    names = ("scene", *result.body_names)
    large = large_force(result, shapes.forces, animation.rows)
    series_names, units, series = _series(result, rows)
    return {
        "name": result.scene.name,
        "names": list(result.body_names),
        "time": block_of(result.time[rows][None], 0.0, 2),
        "places": block_of(positions[:, :, :2].reshape(len(positions), -1).T, _LENGTH, 2),
        "angles": block_of(positions[:, :, 2].T, _ANGLE, 2),
        "shapes": [
            _shape(one) for kind in LOOKS["light"] for one in shapes.outlines if one.kind == kind
        ],
        "forces": [_forces(result, group, rows, large) for group in shapes.forces],
        "series": {"names": series_names, "units": units, "block": block_of(series, 0.0, 1)},
        "looks": LOOKS,
        "colors": FORCE_COLORS,
        "slow": float(f"{animation.slowdown:.2g}"),
        "follow": names.index(animation.camera) - 1,
        "view": _view(center, size),
        "whole": _view(whole_center, whole_size),
        "close": 8.0 * shapes.size,
        "arrow": arrow_scale(animation, large),
        "width": THICKNESS * shapes.size,
    }


def _view(center: Array, size: Array) -> dict[str, float]:
    x, y, width, height = map(float, (*center, *size))
    return {"x": x, "y": y, "width": width, "height": height}


def _shape(shape: Shape | Bar) -> dict[str, Any]:
    """Return a shape as the player has it; coordinates to a hundredth of a micrometre."""
    common = {"kind": shape.kind, "bodies": shape.bodies}
    if isinstance(shape, Bar):
        return common | {"points": shape.points.tolist(), "width": shape.width}
    outline = np.round(shape.outline, 8).ravel().tolist()
    solid = shape.kind in _SOLID and shape.closed
    return common | {"outline": outline, "closed": shape.closed, "solid": solid}


def _forces(result: Result, group: Forces, rows: slice, large: float) -> dict[str, Any]:
    vectors = result.array(group.array)[rows][..., :2]
    given = {"contact": result.contact_names, "joint": result.joint_names}
    names: Sequence[str] = given.get(group.kind) or [
        f"{'bushing' if group.kind == 'tooth' else 'hinge'} {k}, {group.label}"
        for k in range(1, len(group.bodies) + 1)
    ]
    return {
        "kind": group.kind,
        "label": group.label,
        "names": list(names),
        "bodies": group.bodies,
        "points": np.round(group.points, 8).tolist(),
        "block": block_of(vectors.reshape(len(vectors), -1).T, _FORCE * large, 1),
    }


def _series(result: Result, rows: slice) -> tuple[list[str], list[str], Array]:
    """Return what is plotted over time: names, units, values (series, times)."""
    found: dict[str, tuple[str, Array]] = {}
    if "strand_tension" in result.arrays:
        tensions = result.array("strand_tension")[rows].T
        for name, tension in zip(result.strand_names, tensions, strict=True):
            found[f"tension of strand {name}"] = "N", tension
    # The peaks of rows that are left out belong to the next one, those before the part to none.
    kept = np.arange(0, rows.stop - rows.start, rows.step)
    first = np.append(0, kept[:-1] + 1)
    whole = slice(rows.start, rows.start + kept[-1] + 1)
    for part in ("hinge", "tooth", "joint", "contact"):
        names = {f"peak_{part}_force", f"{part}_force", f"{part}_reaction"} & set(result.arrays)
        forces = from_first_row({name: result.arrays[name][whole] for name in names}, whole)
        largest = forces.get(f"peak_{part}_force")
        if largest is not None and largest.size:
            peaks = np.maximum.reduceat(largest.max(axis=1), first)
            found[f"largest {part} force"] = "N", peaks
    if not found:
        speed = np.linalg.norm(result.array("velocities")[rows][..., :2], axis=2)
        found["largest speed of a body"] = "m/s", speed.max(axis=1)
    units, values = zip(*found.values(), strict=True)
    return list(found), list(units), np.array(values)


def block_of(values: Array, step: float, order: int) -> dict[str, Any]:
    """Return numbers as the player's `decode` takes them.

    NaN, which JSON lacks, becomes 0. Values are rounded to whole multiples of `step`, or to a
    billionth of their range where that is larger, so that 0 remains 0. Their differences of
    `order` along time, small for smooth motion, are packed by bytes.

    Parameters
    ----------
    values : ndarray, (channels, times)
        Numbers.
    step : float
        Unit of rounding.
    order : int
        How often differences are taken.
    """
    values = np.nan_to_num(values)
    low, high = float(values.min()), float(values.max())
    scale = max(step, (high - low) / _WHOLE)
    if scale > 0.0:
        low = scale * math.floor(low / scale)
    else:  # one number
        scale = 1.0
    whole = np.rint((values - low) / scale).astype(np.int64)
    for _ in range(order):
        whole = np.diff(whole, axis=1, prepend=0)
    wrapped = whole.astype(np.int32)  # sums of 32 bits undo what overflows
    folded = np.ascontiguousarray(
        (wrapped << 1) ^ (wrapped >> 31), "<i4"
    )  # the sign last: small stay small
    planes = np.ascontiguousarray(folded.view(np.uint8).reshape(-1, 4).T)
    packed = zlib.compress(planes.tobytes(), 6)
    channels, rows = values.shape
    return {
        "rows": rows,
        "channels": channels,
        "scale": scale,
        "offset": low,
        "order": order,
        "data": base64.b64encode(packed).decode(),
    }
