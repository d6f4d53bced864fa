"""Tensions of a chain's strands, from where its hinges are and what they pull."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.description.drive import ChainDrive
from rustchain.typing import Array

_ROWS = 1000  # looked at in one go, so that what lies between takes little memory

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class HingeRows:
    """The hinges of a drive at some times.

    Attributes
    ----------
    bushing : ndarray, (times, hinges, 2)
        Centre of each bushing [m].
    pull : ndarray, (times, hinges)
        Pull of the hinge on the link before it, along the chain [N].
    centers : ndarray, (times, sprockets, 2)
        Centres of the sprockets [m].
    near : ndarray of bool, (times, hinges, sprockets)
        Whether the bushing is in reach of the teeth.
    """

    bushing: Array
    pull: Array
    centers: Array
    near: Flags

    def part(self, rows: slice) -> HingeRows:
        """Return some of the times."""
        return HingeRows(self.bushing[rows], self.pull[rows], self.centers[rows], self.near[rows])


def strand_tensions(drive: ChainDrive, rows: HingeRows) -> Array:
    """Return the mean pull of the hinges of each strand [N], (times, strands)."""
    way = _between_two if len(drive.sprockets) == 2 else _between_many
    times = range(0, max(len(rows.pull), 1), _ROWS)
    return np.concatenate([way(drive, rows.part(slice(t, t + _ROWS))) for t in times])


def _pitch_radii(drive: ChainDrive) -> list[float]:
    return [0.5 * drive.chain.pitch / math.sin(math.pi / s.teeth) for s in drive.sprockets]


def _between_two(drive: ChainDrive, rows: HingeRows) -> Array:
    """Return the tensions of the upper and the lower strand, above and below the centres."""
    centers = rows.centers
    line = centers[:, 1] - centers[:, 0]
    distance = np.hypot(line[:, 0], line[:, 1])[:, None]
    axis = (line / distance)[:, None]
    r1, r2 = _pitch_radii(drive)
    # A common tangent leaves each pitch circle where its normal does.
    cosine = (r1 - r2) / distance
    offset = rows.bushing - centers[:, :1]
    along = (offset * axis).sum(-1)
    free = (along >= r1 * cosine) & (along <= distance + r2 * cosine)
    left = axis[..., 0] * offset[..., 1] - axis[..., 1] * offset[..., 0] >= 0.0
    return _means([free & left, free & ~left], rows.pull)


def _between_many(drive: ChainDrive, rows: HingeRows) -> Array:
    """Return the tensions of the strands in the order of their names, such as "1-2".

    A hinge is in a strand when it lies between that strand's tangent points and the strand leaves
    or meets the sprocket that the chain touched last; of two such, the nearer one.
    """
    names = _rustchain.strand_names(drive)
    order = [int(name.split("-")[0]) - 1 for name in names]
    signs = [1.0 if drive.sprockets[s].side == "inside" else -1.0 for s in order]
    radii = np.array([r * _pitch_radii(drive)[s] for r, s in zip(signs, order, strict=True)])
    centers = rows.centers[:, order]
    starts, directions, lengths = _tangents(centers, radii)
    offset = rows.bushing[:, :, None] - starts[:, None]
    along = (offset * directions[:, None]).sum(-1)
    beside = np.abs(
        directions[:, None, :, 0] * offset[..., 1] - directions[:, None, :, 1] * offset[..., 0]
    )
    with np.errstate(invalid="ignore"):  # no tangent where two sprockets are too near
        beside = np.where((along >= 0.0) & (along <= lengths[:, None]), beside, np.inf)
    last = _touched_last(rows.near[..., order])
    strands = np.arange(len(order))
    leaving = last[..., None] == strands
    meeting = (last[..., None] - 1) % len(order) == strands
    known = (last >= 0)[..., None]
    apart = np.where((leaving | meeting) & known, beside, np.inf)
    found = np.where(np.isfinite(apart.min(-1)), apart.argmin(-1), -1)
    return _means([found == strand for strand in strands], rows.pull)


def _tangents(centers: Array, radii: Array) -> tuple[Array, Array, Array]:
    """Return from where, where to and how far each strand leads; radii outside are negative."""
    line = np.roll(centers, -1, axis=1) - centers
    distance = np.hypot(line[..., 0], line[..., 1])
    along = line / distance[..., None]
    with np.errstate(invalid="ignore"):
        sine = (radii - np.roll(radii, -1)) / distance
        cosine = np.sqrt(1.0 - sine**2)
    direction = cosine[..., None] * along + sine[..., None] * _left(along)
    return centers - radii[:, None] * _left(direction), direction, distance * cosine


def _left(vectors: Array) -> Array:
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def _touched_last(near: Flags) -> npt.NDArray[np.int_]:
    """Return the place of the sprocket that the chain touched last, up to each hinge; -1: none."""
    touched = np.where(near.any(-1), near.argmax(-1), -1)
    # Round the chain twice: the first hinges follow the last ones.
    last = np.full(len(touched), -1)
    found = np.empty_like(touched)
    for _ in range(2):
        for k in range(touched.shape[1]):
            last = np.where(touched[:, k] >= 0, touched[:, k], last)
            found[:, k] = last
    return found


def _means(where: list[Flags], pull: Array) -> Array:
    """Return the mean pull of the hinges in each strand; zero for one without hinges."""
    means = [np.where(on, pull, 0.0).sum(1) / np.maximum(on.sum(1), 1) for on in where]
    tension: Array = np.stack(means, axis=-1)
    return tension
