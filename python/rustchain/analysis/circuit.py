"""Position of each hinge along the chain path, and the sections of the path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from rustchain import _rustchain
from rustchain.analysis.jumps import teeth_jumped
from rustchain.arguments import shown
from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    from rustchain.description.chain import Chain
    from rustchain.description.drive import ChainDrive
    from rustchain.description.report import DriveReport
    from rustchain.description.scene import Scene
    from rustchain.results.result import Result
    from rustchain.typing import Array

_Listed = TypeVar("_Listed")


@dataclass(frozen=True)
class Section:
    """A part of the chain path: the arc round a sprocket, or a strand.

    Attributes
    ----------
    name : str
        "sprocket 1", or "strand " and its name.
    sprocket : int, optional
        Number of the sprocket; None for a strand.
    begin, end : float
        Where it lies [pitches]; `begin` of the first sprocket may be negative.
    """

    name: str
    sprocket: int | None
    begin: float
    end: float


@dataclass(frozen=True)
class Circuit:
    """The closed chain path, measured in pitches, counterclockwise.

    Position 0 is that of hinge 1 in the generated configuration, the first seat of the first
    sprocket. A hinge moves by a pitch as a sprocket turns by a tooth.

    Attributes
    ----------
    links : int
        Length of the chain path [pitches].
    sections : tuple of Section
        In the order in which a hinge passes them when sprocket 1 turns counterclockwise.
    """

    links: int
    sections: tuple[Section, ...]
    _first: int  # number of the sprocket whose angle gives the displacement of the chain
    _ahead: float = 0.0  # whole pitches by which bushings stand ahead of the gaps of that sprocket

    @classmethod
    def of(cls, drive: ChainDrive) -> Circuit:
        """Return the chain path of a drive in its initial configuration."""
        described = np.array([[sprocket.center for sprocket in _closed(drive).sprockets]])
        begin, wrap = _wraps(drive, described, np.zeros(described.shape[:2]))
        return cls._through(drive, begin[0], wrap[0])

    @classmethod
    def during(cls, result: Result, rows: slice) -> Circuit:
        """Return the chain path in these rows, in their mean where sprockets move.

        Where a sprocket moves, slack goes from strand to strand: the chain moves on by more at one
        sprocket than at another. Angles of sprockets show it, as bushings remain in their gaps. A
        static start may move them over whole gaps: recorded contacts show in which they are.
        """
        drive = result.drive
        report = _closed(drive).check()
        numbers = range(1, len(drive.sprockets) + 1)
        moved = np.stack([_moved(result, number)[rows] for number in numbers], axis=1)
        centers = result.array("sprocket_center")[rows, : len(drive.sprockets)]
        begin, wrap = _wraps(drive, centers, moved)
        shift = np.zeros(len(report.order))
        if "teeth" in result.groups:
            angle = result.array("sprocket_angle")[rows]
            wheel, gap = (result.array(f"tooth_{name}")[rows] for name in ("sprocket", "index"))
            meeting = Belt.around(drive, centers).meeting
            for place, number in enumerate(report.order):
                row, bushing = np.nonzero(wheel == number)
                if not row.size:
                    continue
                teeth = report.teeth[number - 1]
                around = (angle[row, number - 1] - meeting[row, place]) * teeth / (2 * math.pi)
                seen = _turn(report, number - 1) * (around + gap[row, bushing])
                middle = 0.5 * wrap[row, place]
                way = moved[row, report.order[0] - 1] + bushing - begin[row, place]
                apart = remainder(way - middle, drive.chain.links) + middle - seen
                shift[place] = np.round(np.median(remainder(apart, teeth)))
        # Position 0 remains the first seat of the first sprocket, whichever hinge starts there.
        begin = begin.mean(axis=0) + shift - shift[0]
        return cls._through(drive, begin, wrap.mean(axis=0), shift[0])

    @classmethod
    def _through(cls, drive: ChainDrive, begin: Array, wrap: Array, ahead: float = 0.0) -> Circuit:
        """Return the path with these wraps, in the order along the chain [pitches]."""
        report = drive.check()
        names = _in_order_of_the_way(report.strands)
        sections: list[Section] = []
        following = [*begin[1:], begin[0] + drive.chain.links]
        for place, number in enumerate(report.order):
            end = float(begin[place] + wrap[place])
            sections += [
                Section(f"sprocket {number}", number, float(begin[place]), end),
                Section(f"strand {names[place]}", None, end, float(following[place])),
            ]
        return cls(drive.chain.links, tuple(sections), report.order[0], ahead)

    def moved(self, result: Result) -> Array:
        """Return the displacement of the chain since the start [pitches], (times,)."""
        return _moved(result, self._first) - self._ahead

    def moved_at(self, scene: Scene, positions: Array) -> float:
        """Return the displacement with the bodies at these positions [pitches]."""
        angle = _wheels(scene.drive, positions)[self._first - 1, 2]
        return float(_displacement(scene, self._first, angle)) - self._ahead

    def steps(self, result: Result, rows: slice) -> Array:
        """Return the path of the chain between these rows, forward and back [pitches], (rows - 1,).

        It is that at the sprocket on which the chain jumped the fewest teeth in these rows. A
        sprocket slips gradually, and its jump is counted at one time: both would count as path.
        """
        numbers = [each.sprocket for each in self.sections if each.sprocket is not None]
        seated = min(numbers, key=lambda each: path_length(teeth_jumped(result, each)[rows]))
        path: Array = np.abs(np.diff(_moved(result, seated)[rows]))
        return path

    def revolutions(self, result: Result, rows: slice) -> float:
        """Return how often the chain has gone round in these rows, forward and back."""
        return float(self.steps(result, rows).sum()) / self.links

    def positions(self, result: Result) -> Array:
        """Return where each hinge is [pitches], from 0 to `links`, (times, hinges)."""
        start = np.arange(self.links, dtype=float)
        return np.mod(self.moved(result)[:, None] + start, self.links)

    def section(self, name: str | int) -> Section:
        """Return a section by its name, or that of a sprocket by its number."""
        wanted = f"sprocket {name}" if isinstance(name, int) else name
        for section in self.sections:
            if wanted in (section.name, section.name.removeprefix("strand ")):
                return section
        known = ", ".join(repr(section.name) for section in self.sections)
        msg = f"section: {shown(name)} is no section of the chain path; known: {known}"
        raise InvalidInput(msg)

    def names(self, positions: Array) -> list[str]:
        """Return the name of the section at each position."""
        found = []
        for position in positions:
            inside = (
                section.name
                for section in self.sections
                if (position - section.begin) % self.links < section.end - section.begin
            )
            found.append(next(inside, ""))
        return found


@dataclass(frozen=True)
class Belt:
    """The belt line on the pitch circles, at each of several times.

    Attributes
    ----------
    meeting, leaving : ndarray, (times, sprockets)
        Angle about a sprocket where the line meets and leaves its pitch circle [rad]; sprockets in
        the order in which the chain meets them.
    """

    meeting: Array
    leaving: Array
    _ends: tuple[Array, Array]

    @classmethod
    def around(cls, drive: ChainDrive, centers: Array) -> Belt:
        """Return the line round sprockets at `centers` [m], (times, sprockets, 2)."""
        report = drive.check()
        order = [number - 1 for number in report.order]
        outside = [report.sides[k] == "outside" for k in order]
        # Counterclockwise, an inside wheel lies left of the line: points are right of its centre.
        radius = np.where(outside, -1.0, 1.0) * [report.pitch_radius[k] for k in order]
        here, there = centers[:, order], np.roll(centers[:, order], -1, axis=1)
        way = there - here
        distance = np.hypot(way[..., 0], way[..., 1])
        least = np.abs(radius - np.roll(radius, -1))
        crossed = (distance < least) | (distance == 0.0)
        if crossed.any():
            _, k = np.argwhere(crossed)[0]
            pair = f"{order[k] + 1} and {order[(k + 1) % len(order)] + 1}"
            msg = (
                f"sprockets {pair}: their centres are {distance[:, k].min():.4g} m apart in these "
                f"rows, too near for the chain's line; take a part of the time before that, or "
                "limit the tensioner by its travel"
            )
            raise InvalidInput(msg)
        normal = np.arctan2(way[..., 1], way[..., 0]) - np.arccos(
            (radius - np.roll(radius, -1)) / distance
        )
        outward = np.stack([np.cos(normal), np.sin(normal)], -1)
        begin = here + radius[:, None] * outward
        end = there + np.roll(radius, -1)[:, None] * outward
        flipped = np.where(outside, math.pi, 0.0)
        return cls(
            meeting=np.roll(normal, 1, axis=1) + flipped,
            leaving=normal + flipped,
            _ends=(begin, end),
        )

    def strand(self, place: int) -> tuple[Array, Array]:
        """Return both ends of the strand behind the sprocket at this place [m], (times, 2) each."""
        begin, end = self._ends
        return begin[:, place], end[:, place]


def path_length(values: Array) -> float:
    """Return the sum of the changes, forward and back."""
    return float(np.abs(np.diff(values)).sum())


def _closed(drive: ChainDrive) -> ChainDrive:
    """Return the drive, or raise where its chain is open."""
    if drive.ends is not None:
        msg = (
            "ChainDrive.ends: an open chain has no closed chain path; use hinge(), bushing() and "
            "end(), which take one at a time"
        )
        raise InvalidInput(msg)
    return drive


def _wraps(drive: ChainDrive, centers: Array, moved: Array) -> tuple[Array, Array]:
    """Return begin and length of each wrap [pitches], (times, sprockets) in the order of the chain.

    `centers` are those of the sprockets [m], (times, sprockets, 2). `moved` is how far the chain
    has moved at each of them [pitches], (times, sprockets).
    """
    report = drive.check()
    belt = Belt.around(drive, centers)
    pitches = _in_order_of_the_way(report.strand_pitches)
    line = 0.0
    if len(report.order) == 2:  # first seats count from the line of centres as described
        (x1, y1), (x2, y2) = (sprocket.center for sprocket in drive.sprockets)
        line = math.atan2(y2 - y1, x2 - x1)
    begin, wrap = np.empty(belt.meeting.shape), np.empty(belt.meeting.shape)
    seat = 0.0
    for place, number in enumerate(report.order):
        k = number - 1
        per_radian = _per_radian(report, k)
        # The belt line meets the pitch circle before the first seat, or a little behind it.
        apart = remainder(belt.meeting[:, place] - report.first_seat_angle[k] - line, 2 * math.pi)
        behind = moved[:, report.order[0] - 1] - moved[:, k]
        begin[:, place] = seat + per_radian * apart + behind
        length = per_radian * (belt.leaving[:, place] - belt.meeting[:, place])
        described = report.belt_wrap_angle[k] * abs(per_radian)
        wrap[:, place] = described + remainder(length - described, report.teeth[k])
        seat += report.wrap_pitches[k] + pitches[place]
    return begin, wrap


def _moved(result: Result, number: int) -> Array:
    """Return the displacement of the chain at a sprocket since the start [pitches], (times,)."""
    tooth = 2 * math.pi / result.drive.sprockets[number - 1].teeth
    angle = result.array("sprocket_angle")[:, number - 1] - tooth * teeth_jumped(result, number)
    return _displacement(result.scene, number, angle)


def _displacement(scene: Scene, number: int, angle: Array) -> Array:
    """Return the displacement of a chain at a sprocket with these angles, without jumps."""
    report, k = scene.drive.check(), number - 1
    moved: Array = (angle - report.phase[k]) * _per_radian(report, k) - _ahead_of_gaps(scene)[k]
    return moved


def _ahead_of_gaps(scene: Scene) -> Array:
    """Return by how many whole pitches each sprocket is turned ahead of given positions.

    A sprocket turned by whole teeth, or a chain whose links are numbered from another one, is the
    same drive. The hinge in the middle of each wrap shows by how much the angle misleads.
    """
    drive = scene.drive
    report = drive.check()
    turned, ahead = np.zeros((2, len(drive.sprockets)))
    if scene.positions is None:
        return ahead
    positions = np.array(scene.positions)
    wheels = _wheels(drive, positions)
    fronts = fronts_of(drive.chain, positions[: drive.chain.links])
    centers = wheels[None, :, :2]
    begin, wrap = _wraps(drive, centers, np.zeros(centers.shape[:2]))
    meeting = Belt.around(drive, centers).meeting
    for place, number in enumerate(report.order):
        k, per_radian = number - 1, _per_radian(report, number - 1)
        turned[k] = (wheels[k, 2] - report.phase[k]) * per_radian
        middle = meeting[0, place] + 0.5 * wrap[0, place] / per_radian
        from_center = fronts - wheels[k, :2]
        angle = np.arctan2(from_center[:, 1], from_center[:, 0])
        seat = report.pitch_radius[k] * np.array([math.cos(middle), math.sin(middle)])
        apart = np.hypot(*(from_center - seat).T)
        hinge = int(np.argmin(apart))
        if apart[hinge] > drive.chain.pitch:
            continue  # the chain has left this sprocket
        past = math.remainder(angle[hinge] - middle, 2 * math.pi)
        there = begin[0, place] + 0.5 * wrap[0, place] + past * per_radian
        ahead[k] = np.round(hinge + turned[k] - there)
    # Hinges count modulo the links: all sprockets are then within half a circuit of the first one.
    moved = turned - ahead
    circuits = np.round((moved - moved[report.order[0] - 1]) / drive.chain.links)
    counted: Array = ahead + drive.chain.links * circuits
    return counted


def _wheels(drive: ChainDrive, positions: Array) -> Array:
    """Return the rows of the sprockets in positions of the bodies, (sprockets, 3)."""
    end = len(positions) - len(drive.guides)
    return positions[end - len(drive.sprockets) : end]


def _per_radian(report: DriveReport, k: int) -> float:
    """Return how far a chain moves as a sprocket turns counterclockwise [pitches/rad]."""
    return _turn(report, k) * report.teeth[k] / (2 * math.pi)


def _turn(report: DriveReport, k: int) -> float:
    """Return 1 where a wheel turns as the chain goes round, -1 where it turns against it."""
    return 1.0 if report.sides[k] == "inside" else -1.0


def _in_order_of_the_way(values: tuple[_Listed, ...]) -> tuple[_Listed, ...]:
    """Return values by strand in the order of the chain path: two are listed upper, lower."""
    return values[::-1] if len(values) == 2 else values


def fronts_of(chain: Chain, poses: Array) -> Array:
    """Return where the front hinges of links at `poses` are [m], (..., links, 2)."""
    half = 0.5 * _rustchain.chain_links(chain)[:, :1]
    turn = np.stack([np.cos(poses[..., 2]), np.sin(poses[..., 2])], -1)
    places: Array = poses[..., :2] + half * turn
    return places


def remainder(values: Array, period: float) -> Array:
    """Return the values less whole periods, from minus to plus half a period: `math.remainder`."""
    left: Array = values - period * np.round(values / period)
    return left
