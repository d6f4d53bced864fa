"""A circle on an outline in plain NumPy: least distances bear, greatest ones are taken off.

Candidates are the feet of the circle's centre on lines and arcs, and the corners; which of them are
least and which greatest is told by the distances a little before and after along the outline.
"""

import numpy as np

STEP = 1e-6  # of the way along a piece, to both sides of a candidate


def rotated(point):
    """A quarter turn to the right: from the way out of the material on its left."""
    return np.array([point[1], -point[0]])


def length(vector):
    return np.sqrt(vector @ vector)


class Line:
    def __init__(self, start, end):
        self.start, self.end = start, end
        self.outward = rotated(end - start) / length(end - start)

    def at(self, part):
        return self.start + part * (self.end - self.start)

    def normal(self, part):
        return self.outward

    def feet(self, point):
        part = (point - self.start) @ (self.end - self.start) / length(self.end - self.start) ** 2
        return [(part, self.distance)]

    def distance(self, point):
        return self.outward @ (point - self.start)


class Arc:
    def __init__(self, start, end, center, convex):
        self.center, self.side = center, 1.0 if convex else -1.0
        self.radius = length(start - center)
        first, last = (np.arctan2(*(p - center)[::-1]) for p in (start, end))
        self.first, self.turn = first, self.side * (self.side * (last - first) % (2.0 * np.pi))

    def normal(self, part):
        angle = self.first + part * self.turn
        return self.side * np.array([np.cos(angle), np.sin(angle)])

    def at(self, part):
        return self.center + self.side * self.radius * self.normal(part)

    def feet(self, point):
        toward = np.arctan2(*(point - self.center)[::-1])
        parts = []
        for angle, distance in ((toward, self.near), (toward + np.pi, self.far)):
            way = self.side * (angle - self.first) % (2.0 * np.pi)
            parts.append((way / abs(self.turn), distance))
        return parts

    def near(self, point):
        return self.side * (length(point - self.center) - self.radius)

    def far(self, point):
        return -self.side * (length(point - self.center) + self.radius)


class Outline:
    """The outline of a contact of kind "polyline" or "arcs"."""

    def __init__(self, contact):
        self.closed, rows = contact.closed, np.array(contact.points, dtype=float)
        if contact.kind == "polyline":
            ends = np.roll(rows, -1, axis=0)
            pairs = list(zip(rows, ends, strict=True))[: None if self.closed else -1]
            self.pieces = [Line(start, end) for start, end in pairs]
            return
        self.pieces = [
            Line(row[:2], row[2:4])
            if row[6] == 0.0
            else Arc(row[:2], row[2:4], row[4:6], row[6] > 0.0)
            for row in rows
        ]

    def corners(self):
        """Pieces before and after, and the place of each; ends of open outlines have one piece."""
        count = len(self.pieces)
        for k in range(count + 1 - self.closed):
            before = self.pieces[k - 1] if k > 0 or self.closed else None
            after = self.pieces[k] if k < count else None
            yield before, after, before.at(1.0) if after is None else after.at(0.0)

    def candidates(self, point):
        """Place, outward direction, places beside it, distance function, whether it is an end."""
        for piece in self.pieces:
            for part, distance in piece.feet(point):
                if 0.0 < part < 1.0:
                    beside = [piece.at(part - STEP), piece.at(part + STEP)]
                    yield piece.at(part), piece.normal(part), beside, distance, False
        for before, after, place in self.corners():
            beside = [] if before is None else [before.at(1.0 - STEP)]
            beside += [] if after is None else [after.at(STEP)]
            normals = [] if before is None else [before.normal(1.0)]
            normals += [] if after is None else [after.normal(0.0)]
            outward = np.sum(normals, axis=0)
            side = 1.0 if outward @ (point - place) >= 0.0 else -1.0

            def distance(p, place=place, side=side):
                return side * length(p - place)

            yield place, outward, beside, distance, before is None or after is None

    def places(self, point):
        """Signs and distances of all that the point is in front of; None behind the outline."""
        found, nearest, behind_end = [], (np.inf, 1.0), np.inf
        for place, outward, beside, distance, is_end in self.candidates(point):
            here = length(point - place)
            others = [length(point - other) for other in beside]
            least, greatest = all(d > here for d in others), all(d < here for d in others)
            front = outward @ (point - place)
            if least:
                nearest = min(nearest, (here, front))
                if is_end and front < 0.0:
                    behind_end = min(behind_end, here)
            if front > 0.0 and (least or (greatest and not is_end)):
                found.append((1.0 if least else -1.0, distance))
        return None if nearest[1] <= 0.0 else found, behind_end
