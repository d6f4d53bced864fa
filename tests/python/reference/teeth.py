"""Contact of circles with teeth of any form, by the distance from every piece of the whole outline.

Points are complex numbers: of a gap, u + i v with the sprocket's centre as origin and the gap along
+i; of a sprocket, x + i y. A flank is a list of pieces from the middle of the gap to the middle of
the tooth on the right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Points = NDArray[np.complex128]


@dataclass(frozen=True)
class Piece:
    """A piece from ``start`` to ``end``: an arc of less than half a turn, or a line."""

    start: complex
    end: complex
    center: complex | None = None

    def distance(self, points: Points) -> Array:
        """Distance of points from the piece, its ends included."""
        ends = np.minimum(np.abs(points - self.start), np.abs(points - self.end))
        if self.center is None:
            along = (self.end - self.start) / abs(self.end - self.start)
            foot = (points - self.start) / along
            inside = (foot.real >= 0.0) & (foot.real <= abs(self.end - self.start))
            return np.where(inside, np.abs(foot.imag), ends)
        arm = points - self.center
        first, last = self.start - self.center, self.end - self.center
        sense = np.sign((np.conj(first) * last).imag)
        inside = (sense * (np.conj(first) * arm).imag >= 0.0) & (
            sense * (np.conj(arm) * last).imag >= 0.0
        )
        return np.where(inside, np.abs(np.abs(arm) - abs(first)), ends)

    def placed(self, turn: complex, mirrored: bool) -> Piece:
        """The piece in another gap, or on the left flank."""

        def move(point: complex) -> complex:
            return turn * (-point.conjugate() if mirrored else point)

        center = None if self.center is None else move(self.center)
        return Piece(move(self.start), move(self.end), center)


def iso_flank(
    pitch: float, teeth: int, roller: float, share: float, seated: bool = True
) -> list[Piece]:
    """Seat and flank of ISO 606, as far as it goes; ``share`` 0: minimum gap, 1: maximum."""
    mm = 1e-3
    ri = 0.505 * roller + share * 0.069 * mm * np.cbrt(roller / mm)
    limits = 0.12 * roller * (teeth + 2), 0.008 * roller * (teeth**2 + 180)
    re = limits[0] + share * (limits[1] - limits[0])
    half = np.radians(140 - 90 / teeth - 20 * share) / 2
    seat = 1j * (pitch / (2 * np.sin(np.pi / teeth)) + (ri - roller / 2 if seated else 0.0))
    down = -1j * np.exp(1j * half)  # from the seat's centre to its end
    center = seat + (ri + re) * down
    return [
        Piece(seat - 1j * ri, seat + ri * down, seat),
        Piece(seat + ri * down, center + 1j * re, center),
    ]


def straight_flank(pitch: float, teeth: int, roller: float, angle: float) -> list[Piece]:
    """A seat of 0.505 roller diameters and a line that leans ``angle`` from the gap's middle."""
    ri = 0.505 * roller
    seat = 1j * (pitch / (2 * np.sin(np.pi / teeth)) + ri - roller / 2)
    end = seat + ri * np.exp(-1j * angle)
    return [Piece(seat - 1j * ri, end, seat), Piece(end, end + 1j * pitch * np.exp(-1j * angle))]


def ansi_flank(pitch: float, teeth: int, roller: float) -> list[Piece]:
    """Seat, working curve, flat and topping curve of ANSI/ASME B29.1, as far as it goes."""
    allowance, degree = 0.0015 * 0.0254, np.pi / 180
    seat_radius = 0.5025 * roller + allowance
    a, b = (35 + 60 / teeth) * degree, (18 - 56 / teeth) * degree
    seat = 1j * (pitch / (2 * np.sin(np.pi / teeth)) + seat_radius - roller / 2)
    c = seat - 0.8 * roller * np.exp(-1j * a)
    x = seat + seat_radius * np.exp(-1j * a)
    y = c + (1.3025 * roller + allowance) * np.exp(-1j * (a - b))
    top = seat + 1.4 * roller * np.exp(-1j * np.pi / teeth)
    flat = roller * (1.4 * np.sin((17 - 64 / teeth) * degree) - 0.8 * np.sin(b))
    z = y + flat * 1j * np.exp(-1j * (a - b))
    return [
        Piece(seat - 1j * seat_radius, x, seat),
        Piece(x, y, c),
        Piece(y, z),
        Piece(z, top + 1j * abs(z - top), top),
    ]


def cut(flank: list[Piece], teeth: int, outside: float, edge: float) -> list[Piece]:
    """The flank up to an edge of radius ``edge`` that touches it and the circle of ``outside``."""
    middle = 1j * np.exp(-1j * np.pi / teeth)
    level = [Piece(1j * outside, outside * middle, 0j)]
    if outside <= abs(flank[0].start):
        return level  # the tooth is gone
    for i, piece in enumerate(flank):
        for center in _edges(piece, outside, edge):
            if center.real < 0.0 or (np.conj(middle) * center).imag < 0.0 or center.imag < 0.0:
                continue
            foot = _foot(piece, center)
            if piece.distance(np.array([foot]))[0] > 1e-12:
                continue
            corner = outside * center / abs(center)
            return [
                *flank[:i],
                Piece(piece.start, foot, piece.center),
                Piece(foot, corner, center),
                Piece(corner, outside * middle, 0j),
            ]
    return level


def _edges(piece: Piece, outside: float, edge: float) -> list[complex]:
    """Centres of circles of radius ``edge`` that touch piece and circle from within."""
    within = outside - edge
    if piece.center is None:
        along = (piece.end - piece.start) / abs(piece.end - piece.start)
        moved = (piece.start - 1j * edge * along) / along
        if within < abs(moved.imag):
            return []
        half = np.sqrt(within**2 - moved.imag**2)
        return [along * complex(part, moved.imag) for part in (half, -half)]
    turn = (np.conj(piece.start - piece.center) * (piece.end - piece.center)).imag
    radius = abs(piece.start - piece.center) + (edge if turn > 0.0 else -edge)
    distance = abs(piece.center)
    if distance == 0.0:
        return []
    along = (distance**2 + within**2 - radius**2) / (2 * distance)
    if within < abs(along):
        return []
    half = np.sqrt(within**2 - along**2)
    return [piece.center / distance * complex(along, part) for part in (half, -half)]


def _foot(piece: Piece, point: complex) -> complex:
    """The point of the curve, however long, that is nearest."""
    if piece.center is None:
        along = (piece.end - piece.start) / abs(piece.end - piece.start)
        return complex(piece.start + along * ((point - piece.start) / along).real)
    arm = point - piece.center
    return complex(piece.center + arm * abs(piece.start - piece.center) / abs(arm))


def penetration(flanks: dict[int, list[Piece]], teeth: int, points: Points, radius: float) -> Array:
    """Depth of circles about points outside the material of a whole sprocket, gap 0 along +x.

    ``flanks`` holds the flank of damaged teeth by their number (tooth k between gaps k and k + 1)
    and that of all others at -1.
    """
    least = np.full(points.shape, np.inf)
    step = 2 * np.pi / teeth
    for gap in range(teeth):
        turn = -1j * np.exp(1j * step * gap)
        for tooth, mirrored in ((gap, True), ((gap - 1) % teeth, False)):
            for piece in flanks.get(tooth, flanks[-1]):
                least = np.minimum(least, piece.placed(turn, mirrored).distance(points))
    return radius - least
