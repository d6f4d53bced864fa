"""What the generator chose for a drive."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING, TypeAlias

from rustchain import _rustchain
from rustchain._description import plain

if TYPE_CHECKING:
    from rustchain.drive import ChainDrive

Pair: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class DriveReport:
    """How a chain lies round its sprockets at the start; ``print(report)`` shows it as a table.

    Pairs belong to sprockets 1 and 2, or to the upper strand (left of the line from sprocket 1 to
    sprocket 2) and the lower one.

    Attributes
    ----------
    links : int
        Number of links.
    pitch : float
        Pitch of the chain [m].
    teeth : (int, int)
        Numbers of teeth.
    center_distance, closing_center_distance : float
        Distance of the centres, and the one at which the strands are taut and straight [m].
    pitch_radius : (float, float)
        Pitch radii [m].
    wrap_pitches : (int, int)
        Pitches seated on each sprocket.
    wrap_angle, first_seat_angle, phase : (float, float)
        Angle of wrap, of the first seated hinge, and of the sprocket at the start [rad].
    strand_pitches : (int, int)
        Pitches in each strand.
    strand_slack : (float, float)
        Length of each strand over the straight line [m]; negative: stretched into the clearance.
    sag : (float, float)
        Rise of each strand's arc over its chord [m].
    hinge_stretch : float
        Eccentricity of the strand hinges at the start [m].
    start_gap : float
        Smallest gap of all contacts at the start [m].
    speed_ratio : float
        Speed of sprocket 2 over that of sprocket 1.
    tension_force : float
        Full pull of the tensioner on its sprocket [N].
    warnings : tuple of str
        What deserves a second look.
    """

    links: int
    pitch: float
    teeth: tuple[int, int]
    center_distance: float
    closing_center_distance: float
    pitch_radius: Pair
    wrap_pitches: tuple[int, int]
    wrap_angle: Pair
    first_seat_angle: Pair
    phase: Pair
    strand_pitches: tuple[int, int]
    strand_slack: Pair
    sag: Pair
    hinge_stretch: float
    start_gap: float
    speed_ratio: float
    tension_force: float
    warnings: tuple[str, ...]

    @classmethod
    def of(cls, drive: ChainDrive) -> DriveReport:
        """Return the report on `drive`."""
        return cls(**{name: plain(value) for name, value in _rustchain.layout(drive).items()})

    def __str__(self) -> str:
        """Return the report as a table, lengths in mm and angles in degrees."""
        rows = (
            ("chain", f"{self.links} links of {1e3 * self.pitch:.4f} mm"),
            ("centre distance", f"{1e3 * self.center_distance:.6f} mm"),
            ("  taut and straight at", f"{1e3 * self.closing_center_distance:.6f} mm"),
            ("speed ratio", f"{self.speed_ratio:.6f}"),
            ("hinge stretch", f"{1e6 * self.hinge_stretch:.3f} um"),
            ("smallest gap at the start", f"{1e6 * self.start_gap:.3f} um"),
            ("tensioner's pull", f"{self.tension_force:.3f} N"),
            ("", ""),
            _row("", "sprocket 1", "sprocket 2"),
            _row("teeth", *self.teeth),
            _row("pitch radius [mm]", *_scaled(self.pitch_radius, 1e3, ".4f")),
            _row("pitches seated", *self.wrap_pitches),
            _row("angle of wrap [deg]", *_scaled(self.wrap_angle, degrees(1), ".3f")),
            _row("first seat at [deg]", *_scaled(self.first_seat_angle, degrees(1), ".6f")),
            _row("phase [deg]", *_scaled(self.phase, degrees(1), ".6f")),
            ("", ""),
            _row("", "upper strand", "lower strand"),
            _row("pitches", *self.strand_pitches),
            _row("slack [um]", *_scaled(self.strand_slack, 1e6, ".3f")),
            _row("sag [mm]", *_scaled(self.sag, 1e3, ".4f")),
        )
        table = (f"{label:<26}{value}".rstrip() for label, value in rows)
        return "\n".join([*table, *(f"warning: {warning}" for warning in self.warnings)])


def _row(label: str, first: object, second: object) -> tuple[str, str]:
    """Return a row of two columns."""
    return label, f"{first!s:>14}{second!s:>14}"


def _scaled(pair: Pair, factor: float, form: str) -> list[str]:
    """Return both numbers in another unit, as text."""
    return [format(factor * value, form) for value in pair]
