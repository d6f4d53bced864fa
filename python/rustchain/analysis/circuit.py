"""Position of each hinge along the chain path, and the sections of the path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from rustchain.analysis.jumps import teeth_jumped
from rustchain.arguments import shown
from rustchain.errors import InvalidInput

if TYPE_CHECKING:
    from rustchain.description.drive import ChainDrive
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
    _teeth: int  # its teeth
    _pitches_per_radian: float
    _phase: float

    @classmethod
    def of(cls, drive: ChainDrive) -> Circuit:
        """Return the chain path of a drive in its initial configuration."""
        if drive.ends is not None:
            msg = "ChainDrive.ends: an open chain has no closed way that its links run round"
            raise InvalidInput(msg)
        report = drive.check()
        belt = Belt.around(drive, np.array([[s.center for s in drive.sprockets]]))
        count = len(report.order)
        pitches = _in_order_of_the_way(report.strand_pitches)
        names = _in_order_of_the_way(report.strands)
        sections: list[tuple[str, int | None, float, float]] = []
        seat = 0.0
        for place, number in enumerate(report.order):
            k = number - 1
            per_radian = drive.sprockets[k].teeth / (2 * math.pi)
            turn = 1.0 if report.sides[k] == "inside" else -1.0
            first_seat = report.first_seat_angle[k] + (belt.line_angle if count == 2 else 0.0)
            # The belt line meets the pitch circle before the first seat, or a little behind it.
            apart = _wrapped(float(belt.meeting[0, place]) - first_seat)
            enter = turn * per_radian * apart
            leave = enter + per_radian * report.belt_wrap_angle[k]
            sections.append((f"sprocket {number}", number, seat + enter, seat + leave))
            seat += report.wrap_pitches[k]
            sections.append((f"strand {names[place]}", None, seat, seat))
            seat += float(pitches[place])
        ends = [*(begin for _, _, begin, _ in sections[2::2]), sections[0][2] + drive.chain.links]
        for place, end in enumerate(ends):
            begin = sections[2 * place][3]
            sections[2 * place + 1] = (sections[2 * place + 1][0], None, begin, end)
        first = report.order[0]
        return cls(
            drive.chain.links,
            tuple(Section(*each) for each in sections),
            first,
            drive.sprockets[first - 1].teeth,
            (1.0 if report.sides[first - 1] == "inside" else -1.0)
            * drive.sprockets[first - 1].teeth
            / (2 * math.pi),
            report.phase[first - 1],
        )

    def moved(self, result: Result) -> Array:
        """Return the displacement of the chain since the start [pitches], (times,)."""
        angle: Array = result.array("sprocket_angle")[:, self._first - 1]
        jumped = 2 * math.pi / self._teeth * teeth_jumped(result, self._first)
        moved: Array = (angle - jumped - self._phase) * self._pitches_per_radian
        return moved

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
    line_angle : float
        Direction from the first sprocket to the second at the first time [rad].
    """

    meeting: Array
    leaving: Array
    line_angle: float
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
            line_angle=float(np.arctan2(way[0, 0, 1], way[0, 0, 0])),
            _ends=(begin, end),
        )

    def strand(self, place: int) -> tuple[Array, Array]:
        """Return both ends of the strand behind the sprocket at this place [m], (times, 2) each."""
        begin, end = self._ends
        return begin[:, place], end[:, place]


def _in_order_of_the_way(values: tuple[_Listed, ...]) -> tuple[_Listed, ...]:
    """Return values by strand in the order of the chain path: two are listed upper, lower."""
    return values[::-1] if len(values) == 2 else values


def _wrapped(angle: float) -> float:
    """Return the angle between -π and π."""
    return math.remainder(angle, 2 * math.pi)
