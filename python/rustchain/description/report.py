"""Report of the initial configuration of a drive."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import degrees, isfinite
from typing import TYPE_CHECKING, TypeAlias

from rustchain import _rustchain
from rustchain.arguments import plain
from rustchain.description.plausibility import implausible_inputs
from rustchain.description.sprocket import Free
from rustchain.errors import InvalidInput
from rustchain.html import HtmlView
from rustchain.names import counted, named_attributes

if TYPE_CHECKING:
    from rustchain.description.drive import ChainDrive

Numbers: TypeAlias = tuple[float, ...]
Row: TypeAlias = tuple[str, str | tuple[str, ...]]


@named_attributes
@dataclass(frozen=True, repr=False)
class DriveReport(HtmlView):
    """Initial configuration of a chain on its sprockets; ``print(report)`` shows it as a table.

    Tuples have an entry for each sprocket as listed, or for each strand. Two sprockets have the
    strands "upper" (left of the line from sprocket 1 to sprocket 2) and "lower". With more
    sprockets, strand "1-3" leads from sprocket 1 to sprocket 3. Strand "end_1-1" of an open chain
    leads from end 1 to sprocket 1.

    Attributes
    ----------
    links : int
        Number of links.
    pitch : float
        Pitch of the chain [m].
    belt_pitches : float
        Length of a taut chain along the belt line on the pitch circles, in pitches.
    order : tuple of int
        Sprockets in the order along the chain, counterclockwise; of an open chain from end 1 to end
        2.
    teeth : tuple of int
        Numbers of teeth.
    sides : tuple of str
        On which side of the chain each sprocket stands.
    center_distance, closing_center_distance : float, optional
        Distance of the centres of two sprockets, and the one at which the strands are taut and
        straight [m].
    pitch_radius : tuple of float
        Pitch radii [m].
    wrap_pitches : tuple of int
        Pitches seated on each sprocket.
    wrap_angle, belt_wrap_angle : tuple of float
        Angle that the seated pitches and that the belt line wraps [rad].
    first_seat_angle, phase : tuple of float
        Angle of the first seated hinge (from the line of centres of two sprockets) and of the
        sprocket at the start [rad].
    initial_speed : tuple of float
        Angular speed at the start [rad/s].
    speed_ratios : tuple of float
        Mean speed of each sprocket over that of sprocket 1.
    strands : tuple of str
        Names of the strands.
    strand_pitches : tuple of int
        Pitches in each strand.
    strand_span, strand_slack : tuple of float
        Straight distance between the ends of each strand, and its length over that [m]; negative:
        stretched into the clearance.
    sag : tuple of float
        Rise of each strand's arc over its chord [m].
    hinge_stretch : float
        Eccentricity of the strand hinges at the start [m].
    start_gap : float
        Smallest gap of all contacts at the start [m]; infinite where no bushing is near one.
    tension_force : float
        Force of the tensioner on its sprocket after the ramp [N], with the sprocket where it is
        described. Over a displacement s the force of a spring is less by ``stiffness`` times s.
    guide_gap : tuple of float
        Smallest distance of a bushing from each guide at the start [m], or of a plate where plates
        are in contact with it.
    guide_turn : tuple of float
        How far each guide's arm is swung at the start from where it is described, for the chain to
        be clear [rad].
    guide_travel : tuple of (float, float)
        How far each guide's plunger can go back and out from there until its stops [m]: infinite
        without stops, zero without an arm.
    guide_bushings : tuple of int
        Bushings within half a pitch of each guide: its possible contacts.
    guide_place : tuple of str
        The strand or sprocket at which each guide's nearest bushing is.
    warnings : tuple of str
        Warnings, as text.
    roller_play : float, optional
        Radial play of rollers on bushings [m], where rollers are bodies of their own.
    drive : ChainDrive, optional
        The drive.

    Examples
    --------
    >>> report = rc.paper_drive(pretension=25.0).check()
    >>> report.strands, report.wrap_pitches, report.tension_force
    (('upper', 'lower'), (8, 9), 50.0)
    """

    links: int
    pitch: float
    belt_pitches: float
    order: tuple[int, ...]
    teeth: tuple[int, ...]
    sides: tuple[str, ...]
    center_distance: float | None
    closing_center_distance: float | None
    pitch_radius: Numbers
    wrap_pitches: tuple[int, ...]
    wrap_angle: Numbers
    belt_wrap_angle: Numbers
    first_seat_angle: Numbers
    phase: Numbers
    initial_speed: Numbers
    speed_ratios: Numbers
    strands: tuple[str, ...]
    strand_pitches: tuple[int, ...]
    strand_span: Numbers
    strand_slack: Numbers
    sag: Numbers
    hinge_stretch: float
    start_gap: float
    tension_force: float
    guide_gap: Numbers
    guide_turn: Numbers
    guide_travel: tuple[tuple[float, float], ...]
    guide_bushings: tuple[int, ...]
    guide_place: tuple[str, ...]
    warnings: tuple[str, ...]
    roller_play: float | None = None
    drive: ChainDrive | None = None

    @classmethod
    def of(cls, drive: ChainDrive) -> DriveReport:
        """Return the report on `drive`."""
        found = _rustchain.layout(drive)  # which refuses what is no drive
        chain = drive.chain
        play = None if chain.roller is None else chain.roller.bore_radius - chain.bushing_radius
        values = {name: plain(value) for name, value in found.items()}
        values["warnings"] += (*_at_rest(drive), *implausible_inputs(drive))
        return cls(**values, roller_play=play, drive=drive)

    def __repr__(self) -> str:
        """Return links, teeth and the number of warnings on one line."""
        teeth = f"teeth {', '.join(map(str, self.teeth[:6]))}{', ...' if self.teeth[6:] else ''}"
        chain = f"{self.links} links of {1e3 * self.pitch:g} mm"
        return f"<DriveReport: {chain}, {teeth}, {counted(len(self.warnings), 'warnings')}>"

    @property
    def speed_ratio(self) -> float:
        """Mean speed of sprocket 2 over that of sprocket 1.

        Raises
        ------
        InvalidInput
            The drive has fewer than two sprockets.
        """
        if len(self.teeth) < 2:
            msg = f"speed_ratio: got {counted(len(self.teeth), 'sprockets')}; expected two or more"
            raise InvalidInput(msg)
        return self.speed_ratios[1]

    def __str__(self) -> str:
        """Return the report as a table, lengths in mm and angles in degrees."""
        table = (
            f"{label:<26}{value if isinstance(value, str) else ''.join(f'{v:>14}' for v in value)}"
            for label, value in self.rows()
        )
        warnings = (f"warning: {warning}" for warning in self.warnings)
        return "\n".join([*map(str.rstrip, table), *warnings])

    def rows(self) -> list[Row]:
        """Return the rows of the table: a label, and a text or one for each column."""
        pitch = self.pitch if self.drive is None else self.drive.chain.mean_pitch  # with wear
        spare = _text(1e3 * (self.links - self.belt_pitches) * pitch, ".3f")
        rows: list[Row] = [
            ("chain", f"{self.links} links of {1e3 * self.pitch:.4f} mm"),
            (
                "  taut",
                f"{self.belt_pitches:.4f} pitches; {spare} mm to spare",
            ),
        ]
        if self.roller_play is not None:
            rows.append(("play of the rollers", f"{1e6 * self.roller_play:.3f} um"))
        if self.center_distance is not None:
            rows.append(("centre distance", f"{1e3 * self.center_distance:.6f} mm"))
        if self.closing_center_distance is not None:
            rows.append(("  taut and straight at", f"{1e3 * self.closing_center_distance:.6f} mm"))
        if len(self.teeth) > 2:
            rows.append(("order along the chain", ", ".join(map(str, self.order))))
        percent = [
            _text(100.0 * sag / span, ".2f") if span else ""  # none between ends at one point
            for sag, span in zip(self.sag, self.strand_span, strict=True)
        ]
        of_sprockets: list[Row] = [
            ("", ""),
            _row("sprocket", range(1, len(self.teeth) + 1)),
            _row("teeth", self.teeth),
            _row("side of the chain", self.sides),
            _row("pitch radius [mm]", _scaled(self.pitch_radius, 1e3, ".4f")),
            _row("speed ratio", _scaled(self.speed_ratios, 1.0, ".6f")),
            _row("speed [rad/s]", _scaled(self.initial_speed, 1.0, ".4f")),
            _row("pitches seated", self.wrap_pitches),
            _row("wrap of these [deg]", _scaled(self.wrap_angle, degrees(1), ".3f")),
            _row("wrap of the belt [deg]", _scaled(self.belt_wrap_angle, degrees(1), ".3f")),
            _row("first seat at [deg]", _scaled(self.first_seat_angle, degrees(1), ".6f")),
            _row("phase [deg]", _scaled(self.phase, degrees(1), ".6f")),
        ]
        gap: list[Row] = [("smallest gap at the start", f"{_text(1e6 * self.start_gap, '.3f')} um")]
        tensioner: list[Row] = [("tensioner force", f"{_text(self.tension_force, '.3f')} N")]
        rows += [
            ("hinge stretch", f"{_text(1e6 * self.hinge_stretch, '.3f')} um"),
            *(gap if isfinite(self.start_gap) else ()),  # infinite: none is near
            *(tensioner if self.drive is None or self.drive.tensioner is not None else ()),
            *(of_sprockets if self.teeth else ()),
            ("", ""),
            _row("strand", self.strands),
            _row("pitches", self.strand_pitches),
            _row("span [mm]", _scaled(self.strand_span, 1e3, ".4f")),
            _row("slack [um]", _scaled(self.strand_slack, 1e6, ".3f")),
            _row("sag [mm]", _scaled(self.sag, 1e3, ".4f")),
            _row("sag [% of span]", percent),
            *self._guide_rows(),
        ]
        return rows

    def _guide_rows(self) -> list[Row]:
        """Return the rows on guides; none without them."""
        if not self.guide_gap:
            return []
        back, out = zip(*self.guide_travel, strict=True)

        def of_arms(values: Numbers, factor: float) -> list[str]:
            texts = zip(_scaled(values, factor, ".3f"), self.guide_travel, strict=True)
            return [text if any(travel) else "" for text, travel in texts]

        with_arm: list[Row] = [
            _row("arm swung by [deg]", of_arms(self.guide_turn, degrees(1))),
            _row("plunger to inner stop [mm]", of_arms(back, 1e3)),
            _row("plunger to outer stop [mm]", of_arms(out, 1e3)),
        ]
        return [
            ("", ""),
            _row("guide", range(1, len(self.guide_gap) + 1)),
            _row("at", (place.removeprefix("strand ") for place in self.guide_place)),
            _row("gap to the chain [mm]", _scaled(self.guide_gap, 1e3, ".4f")),
            _row("bushings along it", self.guide_bushings),
            *(with_arm if any(map(any, self.guide_travel)) else ()),
        ]


def _at_rest(drive: ChainDrive) -> Iterator[str]:
    """Tell of a closed chain that nothing moves; weight moves open and laden ones."""
    moved = any(s.initial_speed or not isinstance(s.motion, Free) for s in drive.sprockets)
    pressed = drive.tensioner is not None or any(
        getattr(guide, "arm", None) for guide in drive.guides
    )
    if drive.ends is None and not drive.chain.carried and not moved and not pressed:
        yield (
            "no sprocket has a speed or a torque: give one motion=PrescribedSpeed(...) or "
            "AppliedTorque(...), or set a torque during the run"
        )


def _row(label: str, values: Iterable[object]) -> Row:
    """Return a row of columns."""
    return label, tuple(map(str, values))


def _scaled(values: Numbers, factor: float, form: str) -> list[str]:
    """Return numbers in another unit, as text."""
    return [_text(factor * value, form) for value in values]


def _text(value: float, form: str) -> str:
    """Return a number as text; what rounds to zero has no sign."""
    text = format(value, form)
    return text.lstrip("-") if float(text) == 0.0 else text
