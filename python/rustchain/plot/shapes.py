"""Shapes of the bodies of a scene, for pictures, animations and the player."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rustchain.plot import outlines
from rustchain.typing import Array

Kind = Literal[
    "sprocket",
    "hub",
    "mark",
    "arm",
    "spring",
    "ground",
    "rail",
    "anchor",
    "load",
    "inner",
    "outer",
    "roller",
    "bushing",
    "pin",
    "body",
    "profile",
]
"""What an outline stands for; it sets the colours."""

GROUND_ROW = -1
"""In place of the row of a body: the frame that does not move."""


@dataclass(frozen=True)
class Shape:
    """One outline that one or several bodies carry.

    Attributes
    ----------
    kind : str
        What it stands for.
    bodies : tuple of int
        Rows of the bodies in positions; `GROUND_ROW` is the ground.
    outline : ndarray, (points, 2)
        In the frame of the body [m].
    closed : bool
        True if the last point is joined to the first.
    """

    kind: Kind
    bodies: tuple[int, ...]
    outline: Array
    closed: bool = True


@dataclass(frozen=True)
class Bar:
    """A bar, or a spring, from a point of one body to a point of another.

    Attributes
    ----------
    kind : {"arm", "spring"}
        What it stands for.
    bodies : (int, int)
        Rows of the bodies.
    points : ndarray, (2, 2)
        Its ends in the frames of the bodies [m].
    width : float
        [m].
    """

    kind: Kind
    bodies: tuple[int, int]
    points: Array
    width: float

    @property
    def closed(self) -> bool:
        """True if the last point is joined to the first."""
        return self.kind != "spring"


@dataclass(frozen=True)
class Forces:
    """Recorded forces and the points of bodies on which they act.

    Attributes
    ----------
    kind : str
        "hinge", "tooth", "contact" or "joint".
    array : str
        Name of the recorded array, (times, forces, 2 or 3).
    bodies : tuple of int
        Rows of the bodies on which the forces act.
    points : ndarray, (forces, 2)
        Where, in the frames of the bodies [m].
    """

    kind: str
    array: str
    bodies: tuple[int, ...]
    points: Array

    @property
    def label(self) -> str:
        """Name of the forces in legends."""
        return "reaction" if self.kind == "joint" else f"{self.kind} force"


@dataclass(frozen=True)
class Shapes:
    """All outlines of a scene, from the back to the front, and the forces that can be drawn.

    Attributes
    ----------
    outlines : tuple of Shape and Bar
        In the order in which they are drawn.
    forces : tuple of Forces
        Groups of forces.
    size : float
        A typical length of a part [m]: the pitch of a chain.
    """

    outlines: tuple[Shape | Bar, ...]
    forces: tuple[Forces, ...]
    size: float

    def extent(self, poses: Array) -> tuple[Array, Array]:
        """Return the lower left and the upper right corner of all outlines at `poses`.

        Parameters
        ----------
        poses : ndarray, (..., bodies, 3)
            Positions [m, m, rad], at one time or several.
        """
        low, high = np.full(2, np.inf), np.full(2, -np.inf)
        for one in poses.reshape(-1, *poses.shape[-2:]):
            for shape in self.outlines:
                points = outlines_at(shape, one).reshape(-1, 2)
                low = np.minimum(low, points.min(axis=0))
                high = np.maximum(high, points.max(axis=0))
        return low, high


def outlines_at(shape: Shape | Bar, poses: Array) -> Array:
    """Return the outlines of a shape, or of a bar, with bodies at `poses`, (n, points, 2) [m]."""
    if isinstance(shape, Shape):
        return placed(_rows(poses, shape.bodies), shape.outline)
    start, end = (
        placed(_rows(poses, (body,)), point[None])[0, 0]
        for body, point in zip(shape.bodies, shape.points, strict=True)
    )
    draw = outlines.coil if shape.kind == "spring" else outlines.bar
    return draw(np.array([start, end]), shape.width)[None]


def force_points(forces: Forces, poses: Array) -> Array:
    """Return where forces act with bodies at `poses`, (forces, 2) [m]."""
    return placed(_rows(poses, forces.bodies), forces.points[:, None])[:, 0]


def _rows(poses: Array, bodies: Sequence[int]) -> Array:
    """Return the poses of bodies, of which the ground's is zero."""
    with_ground = np.concatenate([poses, np.zeros((1, 3))])  # row -1
    rows: Array = with_ground[list(bodies)]
    return rows


def placed(poses: Array, points: Array) -> Array:
    """Return points of a body at each of its poses, (poses, points, 2).

    They are the same at all poses, (points, 2), or those of each, (poses, points, 2).
    """
    cosine, sine = np.cos(poses[:, None, 2]), np.sin(poses[:, None, 2])
    x, y = points[..., 0], points[..., 1]
    turned = np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
    found: Array = turned + poses[:, None, :2]
    return found
