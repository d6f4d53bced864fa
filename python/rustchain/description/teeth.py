"""Tooth forms: of the standards, straight-sided, and of arcs and lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

from rustchain.description.base import Description, description
from rustchain.typing import Point

Seat = Literal["bottom-diameter", "pitch-circle"]


@description(frozen=True)
class AnsiTooth(Description):
    """The tooth form of ANSI/ASME B29.1.

    Attributes
    ----------
    seat : {"bottom-diameter", "pitch-circle"}
        Position of the centre of the seat. In the standard it is outside the pitch circle, so that
        the centre of a seated bushing is on the pitch circle. With the centre on the pitch circle,
        a seated bushing has clearance all round.
    roller_diameter : float, optional
        Roller diameter for which the tooth is cut [m]; by default that of the chain's bushings, or
        of its rollers where those are bodies.
    tip : {"full", "cut"}
        "full": the topping curves continue to the middle of the tooth, as in the published model.
        "cut": they end at the outside diameter in an edge.
    edge_radius : float, optional
        Radius of the edge of a cut tip [m]; by default 0.025 of the roller diameter.

    Examples
    --------
    >>> rc.Sprocket(17, profile=rc.AnsiTooth(seat="pitch-circle")).profile
    AnsiTooth(seat='pitch-circle')
    """

    seat: Seat = "bottom-diameter"
    roller_diameter: float | None = None
    tip: Literal["full", "cut"] = "full"
    edge_radius: float | None = None


@description(frozen=True)
class IsoTooth(Description):
    """The tooth form of ISO 606: a round seat and convex flanks, cut off at the tip diameter.

    Attributes
    ----------
    gap : float or "minimum" or "maximum"
        Gap form between the standard's minimum, 0, and its maximum, 1. Each dimension is
        interpolated.
    seat : {"bottom-diameter", "pitch-circle"}
        Position of the centre of the seat, as in `AnsiTooth`. The bottom diameter is the pitch
        diameter less the roller diameter, or less twice the seat radius.
    roller_diameter : float, optional
        Roller diameter for which the tooth is cut [m]; by default that of the chain's bushings, or
        of its rollers where those are bodies.
    tip_diameter : float, optional
        Tip diameter [m]; by default the middle of the standard's range, or its smallest value where
        the tooth would be pointed.
    edge_radius : float, optional
        Radius of the edge at the tip [m]; by default 0.025 of the roller diameter.

    Examples
    --------
    >>> rc.IsoTooth(gap="maximum")
    IsoTooth(gap='maximum')
    """

    gap: float | Literal["minimum", "maximum"] = "minimum"
    seat: Seat = "bottom-diameter"
    roller_diameter: float | None = None
    tip_diameter: float | None = None
    edge_radius: float | None = None


@description(frozen=True)
class StraightTooth(Description):
    """A tooth of straight flanks, tangent to a round seat and cut off at the tip diameter.

    Attributes
    ----------
    flank_angle : float
        Angle between a flank and the middle of the gap [rad].
    seat_radius : float, optional
        Radius of the seat [m]; by default 0.505 roller diameters.
    seat : {"bottom-diameter", "pitch-circle"}
        Position of the centre of the seat, as in `AnsiTooth`.
    roller_diameter : float, optional
        Roller diameter for which the tooth is cut [m]; by default that of the chain's bushings, or
        of its rollers where those are bodies.
    tip_diameter : float, optional
        Tip diameter [m]; by default that of an `IsoTooth`.
    edge_radius : float, optional
        Radius of the edge at the tip [m]; by default 0.025 of the roller diameter.

    Examples
    --------
    >>> rc.StraightTooth(flank_angle=0.3)
    StraightTooth(flank_angle=0.3)
    """

    flank_angle: float
    seat_radius: float | None = None
    seat: Seat = "bottom-diameter"
    roller_diameter: float | None = None
    tip_diameter: float | None = None
    edge_radius: float | None = None


@description(frozen=True)
class ToothLine(Description):
    """A straight piece of a `CustomTooth`.

    Attributes
    ----------
    start, end : (float, float)
        Ends (u, v) [m] from the centre of the sprocket: u across the gap, v outward through its
        middle.

    Examples
    --------
    >>> rc.ToothLine(start=(3.8e-3, 33e-3), end=(5.8e-3, 38.5e-3))
    ToothLine(start=(0.0038, 0.033), end=(0.0058, 0.0385))
    """

    start: Point
    end: Point


@description(frozen=True)
class ToothArc(Description):
    """A circular piece of a `CustomTooth`, less than half a turn.

    Attributes
    ----------
    start, end, center : (float, float)
        Ends and centre (u, v) [m] from the centre of the sprocket: u across the gap, v outward
        through its middle. If the centre is on the left in the direction from start to end, the arc
        is hollow, else convex.

    Examples
    --------
    >>> rc.ToothArc(start=(0.0, 30.5e-3), end=(3.8e-3, 33e-3), center=(0.0, 34.5e-3))
    ToothArc(start=(0.0, 0.0305), end=(0.0038, 0.033), center=(0.0, 0.0345))
    """

    start: Point
    end: Point
    center: Point


@description(frozen=True)
class CustomTooth(Description):
    """A tooth of given arcs and lines, tangent to one another.

    Attributes
    ----------
    pieces : sequence of ToothLine and ToothArc
        Right half of a gap, from its middle (u = 0, level) up the flank; the left half mirrors it.
        The material lies on the right in the direction of the pieces. Gaps of 1e-7 m and angles of
        1e-4 rad between pieces are permitted.
    tip_diameter : float, optional
        Tip diameter [m]. Without it, the last piece ends level in the middle of the tooth.
    edge_radius : float, optional
        Radius of the edge of a cut tip [m]; by default 0.025 of the bushings' diameter.

    Examples
    --------
    >>> pitch, seat, slope = 12.7e-3, 4.03e-3, np.radians(20.0)
    >>> center = np.array([0.0, pitch / (2.0 * np.sin(np.pi / 17))])
    >>> bottom = center - np.array([0.0, seat])
    >>> tangent = center + seat * np.array([np.cos(slope), -np.sin(slope)])
    >>> top = tangent + 6e-3 * np.array([np.sin(slope), np.cos(slope)])
    >>> pieces = [rc.ToothArc(bottom, tangent, center), rc.ToothLine(tangent, top)]
    >>> tooth = rc.CustomTooth(pieces, tip_diameter=75e-3)
    >>> drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, 17), links=60, profile=tooth)
    >>> drive.check().teeth
    (17, 17)
    """

    pieces: Sequence[ToothLine | ToothArc]
    tip_diameter: float | None = None
    edge_radius: float | None = None


ToothForm: TypeAlias = AnsiTooth | IsoTooth | StraightTooth | CustomTooth
