"""The description of a chain drive: frozen dataclasses in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain._description import Description
from rustchain._names import known_keywords
from rustchain.guides import GuideRail, SmoothIdler
from rustchain.material import Material
from rustchain.report import DriveReport

if TYPE_CHECKING:
    from rustchain.force_law import ForceLaw
    from rustchain.mechanism import Mechanism

Point: TypeAlias = tuple[float, float]
Seat = Literal["bottom-diameter", "pitch-circle"]
Hinges = Literal["clearance", "ideal"]
Side = Literal["inside", "outside"]
TimeTable: TypeAlias = float | Sequence[Sequence[float]]
"""A constant, or rows (time [s], value): linear between the rows, constant outside them."""


@known_keywords
@dataclass(frozen=True)
class Link(Description):
    """A link with all that is fixed to it: plates and bushings (inner), plates and pins (outer).

    Attributes
    ----------
    mass : float
        Mass [kg].
    inertia : float
        Moment of inertia about the middle of its two hinges [kg m^2].
    """

    mass: float
    inertia: float


@known_keywords
@dataclass(frozen=True)
class ClearanceHinge(Description):
    """A pin that is loose in the bore of a bushing.

    Attributes
    ----------
    pin_radius, bore_radius : float
        Radii of pin and bore [m]; their difference is the radial clearance.
    length : float
        Length of contact along the pin [m].
    """

    pin_radius: float
    bore_radius: float
    length: float

    @property
    def clearance(self) -> float:
        """Radial clearance [m]."""
        return self.bore_radius - self.pin_radius


@known_keywords
@dataclass(frozen=True)
class Chain(Description):
    """A closed bushing chain of alternating inner and outer links; link 1 is an inner one.

    In a chain of an odd number of links the last one is an offset link: a bushing at its rear, a
    pin at its front.

    Attributes
    ----------
    pitch : float
        Nominal distance between the hinges of a link [m].
    links : int
        Number of links.
    inner, outer : Link
        The inner link (two bushings) and the outer link (two pins).
    hinge : ClearanceHinge
        Pin and bore of every hinge.
    bushing_radius : float
        Outside radius of a bushing, where it meets the teeth [m].
    tooth_contact_length : float
        Length of contact of bushing and tooth, along the bushing [m].
    material : Material
        Material of chain and sprockets.
    name : str
        For people to read.
    offset : Link, optional
        The offset link of an odd number; by default the mean of an inner and an outer one.
    strands : int
        Parallel strands on common pins. Masses, inertias and lengths of contact are those of one
        strand; all are multiplied.
    elongation : float or sequence of float
        Share of the pitch by which all links, or each, are longer: wear, seen as length.
    pitch_spread : float
        Standard deviation of the lengths of links by manufacture, as a share of the pitch.
    seed : int
        Which links the spread makes longer and which shorter.
    """

    pitch: float
    links: int
    inner: Link
    outer: Link
    hinge: ClearanceHinge
    bushing_radius: float
    tooth_contact_length: float
    material: Material = Material()
    name: str = ""
    offset: Link | None = None
    strands: int = 1
    elongation: float | Sequence[float] = 0.0
    pitch_spread: float = 0.0
    seed: int = 0

    @property
    def link_pitches(self) -> npt.NDArray[np.float64]:
        """Distance between the hinges of each link [m], wear and spread included, (links,)."""
        return _rustchain.chain_links(self)[:, 0]

    @property
    def mean_pitch(self) -> float:
        """Mean of `link_pitches` [m]."""
        pitches = self.link_pitches
        return float(pitches[0] if (pitches == pitches[0]).all() else pitches.mean())


@known_keywords
@dataclass(frozen=True)
class AnsiTooth(Description):
    """The tooth form of ANSI/ASME B29.1.

    Attributes
    ----------
    seat : {"bottom-diameter", "pitch-circle"}
        Where the seat's centre lies: outside the pitch circle, so that a seated bushing's centre is
        on it (the standard), or on the pitch circle itself (a seated bushing then has play all
        round).
    roller_diameter : float, optional
        The diameter that the tooth is cut for [m]; by default that of the chain's bushings.
    tip : {"full", "cut"}
        Whether the topping curves go on to the middle of the tooth, as in the published model, or
        end at the outside diameter in an edge.
    edge_radius : float, optional
        Radius of that edge [m]; by default 0.025 of the roller diameter.
    """

    seat: Seat = "bottom-diameter"
    roller_diameter: float | None = None
    tip: Literal["full", "cut"] = "full"
    edge_radius: float | None = None


@known_keywords
@dataclass(frozen=True)
class IsoTooth(Description):
    """The tooth form of ISO 606: a round seat and convex flanks, cut off at the tip diameter.

    Attributes
    ----------
    gap : float or "minimum" or "maximum"
        From the standard's minimum gap form, 0, to its maximum, 1; each dimension in proportion.
    seat : {"bottom-diameter", "pitch-circle"}
        Where the seat's centre lies; see `AnsiTooth`. The bottom diameter is the pitch diameter
        less the roller's, or less twice the seat's radius.
    roller_diameter : float, optional
        The diameter that the tooth is cut for [m]; by default that of the chain's bushings.
    tip_diameter : float, optional
        [m]; by default the middle of the standard's range, or its least where that is pointed.
    edge_radius : float, optional
        Radius of the edge at the tip [m]; by default 0.025 of the roller diameter.
    """

    gap: float | Literal["minimum", "maximum"] = "minimum"
    seat: Seat = "bottom-diameter"
    roller_diameter: float | None = None
    tip_diameter: float | None = None
    edge_radius: float | None = None


@known_keywords
@dataclass(frozen=True)
class StraightTooth(Description):
    """A tooth of straight flanks, tangent to a round seat and cut off at the tip diameter.

    Attributes
    ----------
    flank_angle : float
        Angle between a flank and the middle of the gap [rad].
    seat_radius : float, optional
        [m]; by default 0.505 roller diameters.
    seat : {"bottom-diameter", "pitch-circle"}
        Where the seat's centre lies; see `AnsiTooth`.
    roller_diameter : float, optional
        The diameter that the tooth is cut for [m]; by default that of the chain's bushings.
    tip_diameter : float, optional
        [m]; by default as of an `IsoTooth`.
    edge_radius : float, optional
        Radius of the edge at the tip [m]; by default 0.025 of the roller diameter.
    """

    flank_angle: float
    seat_radius: float | None = None
    seat: Seat = "bottom-diameter"
    roller_diameter: float | None = None
    tip_diameter: float | None = None
    edge_radius: float | None = None


@known_keywords
@dataclass(frozen=True)
class ToothLine(Description):
    """A straight piece of a `CustomTooth`.

    Attributes
    ----------
    start, end : (float, float)
        Across the gap and outward through its middle, from the sprocket's centre [m].
    """

    start: Point
    end: Point


@known_keywords
@dataclass(frozen=True)
class ToothArc(Description):
    """A circular piece of a `CustomTooth`, less than half a turn.

    Attributes
    ----------
    start, end, center : (float, float)
        Across the gap and outward through its middle, from the sprocket's centre [m]. About a
        centre on the left of the way from start to end the arc is hollow, else convex.
    """

    start: Point
    end: Point
    center: Point


@known_keywords
@dataclass(frozen=True)
class CustomTooth(Description):
    """A tooth of arcs and lines of one's own, tangent to one another.

    Attributes
    ----------
    pieces : sequence of ToothLine and ToothArc
        The right half of a gap, from its middle (u = 0, level) up the flank; the left half mirrors
        it. The material lies on the right of the way. Joints may be off by 1e-7 m and 1e-4 rad.
    tip_diameter : float, optional
        Where the tooth is cut off [m]; without it, the pieces end level in the middle of the tooth.
    edge_radius : float, optional
        Radius of the edge of a cut tip [m]; by default 0.025 of the bushings' diameter.
    """

    pieces: Sequence[ToothLine | ToothArc]
    tip_diameter: float | None = None
    edge_radius: float | None = None


ToothForm: TypeAlias = AnsiTooth | IsoTooth | StraightTooth | CustomTooth


@known_keywords
@dataclass(frozen=True)
class PrescribedSpeed(Description):
    """A sprocket that turns at a given speed, whatever it takes.

    Attributes
    ----------
    speed : float or table of (time, speed)
        Speed [rad/s], counterclockwise positive.
    """

    speed: TimeTable


@known_keywords
@dataclass(frozen=True)
class AppliedTorque(Description):
    """A sprocket under a given torque.

    Attributes
    ----------
    torque : float or table of (time, torque)
        Torque [N m], counterclockwise positive.
    curve : table of (speed, torque), optional
        Torque that the sprocket's own speed [rad/s] adds: a motor's or a load's curve, linear
        between the rows and constant outside them.
    """

    torque: TimeTable = 0.0
    curve: TimeTable | None = None


@known_keywords
@dataclass(frozen=True)
class Free(Description):
    """A sprocket that only the chain turns."""


@known_keywords
@dataclass(frozen=True)
class Sprocket(Description):
    """A toothed wheel.

    Attributes
    ----------
    teeth : int
        Number of teeth.
    center : (float, float)
        Centre at the start [m].
    motion : PrescribedSpeed, AppliedTorque or Free
        What turns it.
    profile : AnsiTooth, IsoTooth, StraightTooth or CustomTooth
        Tooth form.
    mass, inertia : float, optional
        Mass [kg] and moment of inertia [kg m^2]; by default those of a steel disc of the pitch
        radius, as thick as the chain's `tooth_contact_length`.
    initial_speed : float, optional
        Speed at the start [rad/s]; by default what the motion prescribes or the chain carries over.
    bearing : {"fixed", "floating"}
        Whether the centre is held.
    side : {"inside", "outside"}
        On which side of the chain's loop it stands: a sprocket outside is a reverse idler, which
        presses the chain inward and turns against the driver.
    load_inertia : float
        Moment of inertia of all that turns with it [kg m^2]: shaft, load, motor.
    eccentricity : float
        Distance of the teeth's centre from the bore's [m], half the full radial runout. The centre
        of gravity stays in the bore.
    eccentricity_angle : float
        Direction of the teeth's centre, from that of gap 0 [rad].
    damaged_teeth : sequence of (int, float)
        Teeth that are not whole, and the share of their height above the bottom of the gap that is
        left; 0: gone. Tooth k, from 0, lies between gaps k and k + 1.
    """

    teeth: int
    center: Point = (0.0, 0.0)
    motion: PrescribedSpeed | AppliedTorque | Free = Free()
    profile: ToothForm = AnsiTooth()
    mass: float | None = None
    inertia: float | None = None
    initial_speed: float | None = None
    bearing: Literal["fixed", "floating"] = "fixed"
    side: Side = "inside"
    load_inertia: float = 0.0
    eccentricity: float = 0.0
    eccentricity_angle: float = 0.0
    damaged_teeth: Sequence[tuple[int, float]] = ()

    def outline(self, chain: Chain, points: int = 24) -> npt.NDArray[np.float64]:
        """Return the closed outline of the teeth for `chain`, about their centre.

        Parameters
        ----------
        chain : Chain
            The chain they are cut for.
        points : int
            Points on each curve.

        Returns
        -------
        ndarray, shape (points in all, 2)
            Counterclockwise [m]; gap 0 lies along x.
        """
        return _rustchain.tooth_outline(self, chain, points)


@known_keywords
@dataclass(frozen=True)
class Tensioner(Description):
    """A pull on a sprocket's centre, which slides along one direction or swings about a pivot.

    Attributes
    ----------
    pretension : float
        Tension that the pull gives the strands at rest [N], where the sprocket has taken up the
        chain's slack.
    sprocket : int
        Number of the sprocket, from 1.
    ramp_time : float
        Time over which the pull grows from zero [s].
    damping : float
        Damping of the slide [N s/m].
    damping_back : float, optional
        Damping while the centre gives way to the chain [N s/m], by default the same: a hydraulic
        tensioner follows the chain through its check valve and gives way by its leak.
    direction : (float, float), optional
        Direction of the pull; by default away from the other one of two sprockets, and along the
        bisector that tightens both strands alike of more.
    stiffness : float
        How much of the pull is lost as the centre moves along it [N/m]: a spring's stiffness.
    travel : (float, float), optional
        How far the centre can move against the pull and along it [m], where stops of 1e7 N/m are
        (0 for the first: the sprocket cannot give way); by default there are none.
    pivot : (float, float), optional
        Where the arm turns that carries the sprocket [m]; by default the sprocket slides. Lengths,
        stiffness and damping then count along the circle of the centre.
    arm_inertia : float
        Moment of inertia of the arm about its pivot, without the sprocket [kg m^2].
    """

    pretension: float
    sprocket: int = 2
    ramp_time: float = 0.1
    damping: float = 2000.0
    direction: Point | None = None
    stiffness: float = 0.0
    travel: tuple[float, float] | None = None
    pivot: Point | None = None
    arm_inertia: float = 0.0
    damping_back: float | None = None


@known_keywords
@dataclass(frozen=True)
class ChainDrive(Description):
    """A chain round two sprockets or more.

    Attributes
    ----------
    chain : Chain
        The chain.
    sprockets : sequence of Sprocket
        In the order in which the chain meets them, one way round or the other; the driver first by
        custom.
    tensioner : Tensioner, optional
        Without one, the centres stay where they are.
    gravity : (float, float)
        Acceleration of gravity [m/s^2].
    name : str
        For people to read.
    hinges : {"clearance", "ideal"}
        Pins with play in their bushings, or ideal joints: then the drive runs as the mechanism of
        `to_mechanism`, with the same channels; hinge forces are the joints' reactions.
    guides : sequence of GuideRail and SmoothIdler
        What the chain slides along besides. They take no part in how it is laid: they begin beside
        it, blades swung back on their arms.
    """

    chain: Chain
    sprockets: Sequence[Sprocket]
    tensioner: Tensioner | None = None
    gravity: Point = (0.0, -9.81)
    name: str = ""
    hinges: Hinges = "clearance"
    guides: Sequence[GuideRail | SmoothIdler] = ()

    def check(self) -> DriveReport:
        """Lay the chain out and return what was chosen; print the report to read it as a table."""
        return DriveReport.of(self)

    def to_mechanism(
        self,
        hinges: Hinges | None = None,
        force_law: ForceLaw | None = None,
        min_approach_speed: float = 1e-3,
    ) -> Mechanism:
        """Return the drive as a mechanism, laid out and ready to be extended.

        Parameters
        ----------
        hinges : {"clearance", "ideal"}, optional
            Pins with play in their bushings, or ideal joints, whose reactions are the hinge forces;
            by default as the drive says.
        force_law : ForceLaw, optional
            Law of the contacts, by default that of Lankarani and Nikravesh.
        min_approach_speed : float
            Least approach speed that the damping reckons with [m/s].
        """
        from rustchain._drive_mechanism import drive_mechanism

        wanted = self.hinges if hinges is None else hinges
        return drive_mechanism(self, wanted, force_law, min_approach_speed)
