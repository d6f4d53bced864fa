"""Polygons and lines of which outlines consist, as points in the plane."""

from __future__ import annotations

import numpy as np

from rustchain.typing import Array


def of_arcs(pieces: Array) -> Array:
    """Return points along pieces (from, to, centre, 1 convex, -1 concave or 0 straight)."""
    points: list[Array] = []
    for start, end, center, sign in zip(
        pieces[:, :2], pieces[:, 2:4], pieces[:, 4:6], pieces[:, 6], strict=True
    ):
        points.append(start)
        if sign != 0.0 and np.isfinite(center).all():  # NaN: straight, in files of before
            first, last = (np.arctan2(*(p - center)[::-1]) for p in (start, end))
            turn = (last - first) % (2 * np.pi) if sign > 0 else -((first - last) % (2 * np.pi))
            angle = first + turn * np.linspace(0.0, 1.0, 17)[1:-1]
            radius = np.hypot(*(start - center))
            points += list(center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    points.append(pieces[-1, 2:4])
    return np.array(points)


def distinct(points: list[tuple[float, ...]], apart: float) -> Array:
    """Return points without those that lie on others."""
    kept: list[Array] = []
    for point in map(np.array, points):
        if all(np.hypot(*(point - other)) > apart for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)


def hull(points: Array) -> Array:
    """Return the convex hull of points, counterclockwise (Andrew's monotone chain)."""
    ordered = points[np.lexsort(points.T[::-1])]
    half: list[list[Array]] = []
    for way in (ordered, ordered[::-1]):
        side: list[Array] = []
        for point in way:
            while len(side) > 1:
                along, across = side[-1] - side[-2], point - side[-2]
                if along[0] * across[1] - along[1] * across[0] > 0.0:
                    break
                side.pop()
            side.append(point)
        half.append(side[:-1])
    return np.array(half[0] + half[1])


def bar(way: Array, width: float) -> Array:
    """Return the outline of a bar with round ends along `way`, (2, 2), as a polygon."""
    along = way[1] - way[0]
    angle = np.arctan2(along[1], along[0])
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 24) + angle
    half = 0.5 * width * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return np.concatenate([way[1] + half, way[0] - half])


def coil(way: Array, width: float) -> Array:
    """Return a zigzag along `way`, (2, 2), as an open line."""
    along = way[1] - way[0]
    length = max(float(np.hypot(*along)), 1e-12)
    across = np.array([-along[1], along[0]]) / length
    share = np.array([0.0, 0.15, *np.linspace(0.2, 0.8, 9), 0.85, 1.0])
    aside = np.zeros(len(share))
    aside[2:-2] = 0.5 * width * np.where(np.arange(9) % 2, -1.0, 1.0)
    zigzag: Array = way[0] + share[:, None] * along + aside[:, None] * across
    return zigzag


def circle(radius: float) -> Array:
    """Return a circle about the origin as a polygon, (points, 2)."""
    angle = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def plate(pitch: float, height: float) -> Array:
    """Return the outline of a waisted link plate in its own frame, (points, 2)."""
    end, waist = 0.5 * height, 0.36 * height
    rise = ((0.5 * pitch) ** 2 - (end - waist) ** 2) / (2 * (end - waist))
    # The arc of the waist, about (0, rise), touches the round ends, about (+-pitch/2, 0).
    lean = np.arctan2(rise, 0.5 * pitch)
    round_end = np.linspace(lean - np.pi, np.pi - lean, 40)
    right = end * np.stack([np.cos(round_end), np.sin(round_end)], axis=-1) + [0.5 * pitch, 0.0]
    fall = np.linspace(-lean, lean - np.pi, 20)[1:-1]
    upper = (rise - waist) * np.stack([np.cos(fall), np.sin(fall)], axis=-1) + [0.0, rise]
    half = np.concatenate([right, upper])
    return np.concatenate([half, -half])
