"""Chains by name and drives from a handful of numbers.

Sources. Pitch, roller diameter, inside width, pin diameter, plate thickness and strength of the
ANSI chains: ANSI/ASME B29.1, as makers' tables give them (rounded decimals that stand for fractions
are given as fractions here). Weight: makers' tables, which differ by about 5 %. Limits of pin and
bore: ANSI/ASME B29.1, largest pin 0.0005 in and smallest bore 0.0015 in over the nominal pin
diameter. Heights of the plates: the standard's largest. Thickness of the sprocket: 0.93 times the
inside width less 0.006 in, the usual largest for a single strand. Everything else is derived in
`catalogue_chain`.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain._names import known_keywords, suggest
from rustchain.drive import (
    AnsiTooth,
    AppliedTorque,
    Chain,
    ChainDrive,
    ClearanceHinge,
    Free,
    Hinges,
    Link,
    Material,
    Point,
    PrescribedSpeed,
    Seat,
    Sprocket,
    Tensioner,
    TimeTable,
)
from rustchain.errors import InvalidInput

_INCH = 0.0254  # [m]
_POUND_PER_FOOT = 0.45359237 / 0.3048  # [kg/m]
_STEEL_DENSITY = 7850.0  # [kg/m^3]


class AnsiSize(NamedTuple):
    """One row of the standard: lengths [in], smallest ultimate strength [lbf], weight [lb/ft]."""

    pitch: float
    roller_diameter: float
    width: float
    pin_diameter: float
    plate_thickness: float
    strength: float
    weight: float


ANSI_SIZES = {
    "ANSI 25": AnsiSize(
        1 / 4, 0.130, 1 / 8, 0.0905, 0.030, 780, 0.084
    ),  # no rollers: bushing diameter
    "ANSI 35": AnsiSize(
        3 / 8, 0.200, 3 / 16, 0.141, 0.050, 1760, 0.21
    ),  # no rollers: bushing diameter
    "ANSI 41": AnsiSize(1 / 2, 0.306, 1 / 4, 0.141, 0.050, 1500, 0.28),
    "ANSI 40": AnsiSize(1 / 2, 5 / 16, 5 / 16, 0.156, 0.060, 3125, 0.41),
    "ANSI 50": AnsiSize(5 / 8, 0.400, 3 / 8, 0.200, 0.080, 4880, 0.68),
    "ANSI 60": AnsiSize(3 / 4, 15 / 32, 1 / 2, 0.234, 0.094, 7030, 1.00),
    "ANSI 80": AnsiSize(1, 5 / 8, 5 / 8, 0.312, 0.125, 12500, 1.69),
    "ANSI 100": AnsiSize(1 + 1 / 4, 3 / 4, 3 / 4, 0.375, 0.156, 19530, 2.49),
    "ANSI 120": AnsiSize(1 + 1 / 2, 7 / 8, 1, 0.437, 0.187, 28125, 3.67),
    "ANSI 140": AnsiSize(1 + 3 / 4, 1, 1, 0.500, 0.219, 38280, 4.93),
    "ANSI 160": AnsiSize(2, 1 + 1 / 8, 1 + 1 / 4, 0.562, 0.250, 50000, 6.43),
    "ANSI 180": AnsiSize(2 + 1 / 4, 1 + 13 / 32, 1 + 13 / 32, 0.687, 0.281, 63280, 8.70),
    "ANSI 200": AnsiSize(2 + 1 / 2, 1 + 9 / 16, 1 + 1 / 2, 0.781, 0.312, 78125, 10.51),
    "ANSI 240": AnsiSize(3, 1 + 7 / 8, 1 + 7 / 8, 0.937, 0.375, 112500, 16.90),
}

PAPER_CHAIN = Chain(
    name="ASA 40 of Pereira, Ambrosio and Ramalho (2010)",
    pitch=0.0127,
    links=38,
    inner=Link(mass=6.474e-3, inertia=0.1795e-6),
    outer=Link(mass=8.265e-3, inertia=0.1174e-6),
    hinge=ClearanceHinge(pin_radius=0.00222, bore_radius=0.002245, length=0.011),
    bushing_radius=0.00396875,
    tooth_contact_length=0.007,
    material=Material(elastic_modulus=2.07e11, poisson_ratio=0.3, restitution=0.71),
)


@known_keywords
def paper_drive(pretension: float = 0.0, hinges: Hinges = "clearance") -> ChainDrive:
    """Return the published drive: 38 links round two sprockets of 17 teeth, the driver at 120 rpm.

    Parameters
    ----------
    pretension : float
        Tension that a tensioner on sprocket 2 gives each strand [N]; at 0 the centres are fixed.
    hinges : {"clearance", "ideal"}
        Pins with play in their bushings, or ideal joints.
    """
    teeth = 17

    def sprocket(center: Point, motion: PrescribedSpeed | Free) -> Sprocket:
        profile = AnsiTooth(seat="pitch-circle")
        return Sprocket(teeth, center, motion, profile, mass=0.817, inertia=588.29e-6)

    distance = _rustchain.closing_center_distance(
        PAPER_CHAIN.pitch, (teeth, teeth), PAPER_CHAIN.links
    )
    return ChainDrive(
        chain=PAPER_CHAIN,
        sprockets=[
            sprocket((0.0, 0.0), PrescribedSpeed(4.0 * pi)),
            sprocket((distance, 0.0), Free()),
        ],
        tensioner=_tensioner(pretension),
        name="paper",
        hinges=hinges,
    )


@known_keywords
def two_sprocket_drive(
    chain: str | Chain = "ANSI 40",
    teeth: tuple[int, int] = (17, 25),
    links: int | None = None,
    center_distance: float | None = None,
    speed: TimeTable = 12.566,
    pretension: float | None = None,
    torque: TimeTable | None = None,
    seat: Seat = "bottom-diameter",
    gravity: Point = (0.0, -9.81),
    hinges: Hinges = "clearance",
) -> ChainDrive:
    """Return a drive of two sprockets, the driver at the origin and the other at +x.

    Parameters
    ----------
    chain : str or Chain
        A name of the catalogue, such as "ANSI 40", or a chain, whose `links` then count by default.
    teeth : (int, int)
        Teeth of the driver and of the driven sprocket.
    links : int, optional
        Number of links, even; by default the smallest that closes round `center_distance`.
    center_distance : float, optional
        Distance of the centres [m]; by default the one at which the strands are taut and straight.
    speed : float or table of (time, speed)
        Speed of the driver [rad/s], counterclockwise positive.
    pretension : float, optional
        Tension that a tensioner on sprocket 2 gives each strand [N]; by default the centres are
        fixed.
    torque : float or table of (time, torque), optional
        Torque on the driven sprocket [N m], counterclockwise positive; by default none.
    seat : {"bottom-diameter", "pitch-circle"}
        Where the teeth's seats lie; see `AnsiTooth`.
    gravity : (float, float)
        Acceleration of gravity [m/s^2].
    hinges : {"clearance", "ideal"}
        Pins with play in their bushings, or ideal joints.
    """
    if links is None and isinstance(chain, Chain):
        links = chain.links
    pitch = chain.pitch if isinstance(chain, Chain) else _INCH * ANSI_SIZES[_listed(chain)].pitch
    if links is None:
        if center_distance is None:
            msg = (
                "two_sprocket_drive: links=None and center_distance=None; give at least one of them"
            )
            raise InvalidInput(msg)
        links = _rustchain.links_for(pitch, teeth, center_distance)
    if center_distance is None:
        center_distance = _rustchain.closing_center_distance(pitch, teeth, links)
    chain = catalogue_chain(chain, links) if isinstance(chain, str) else replace(chain, links=links)
    profile = AnsiTooth(seat=seat)
    return ChainDrive(
        chain=chain,
        sprockets=[
            Sprocket(teeth[0], (0.0, 0.0), PrescribedSpeed(speed), profile),
            Sprocket(
                teeth[1],
                (center_distance, 0.0),
                Free() if torque is None else AppliedTorque(torque),
                profile,
            ),
        ],
        tensioner=_tensioner(pretension),
        gravity=gravity,
        name=f"{chain.name}, {teeth[0]}:{teeth[1]}",
        hinges=hinges,
    )


@known_keywords
def catalogue_chain(name: str, links: int) -> Chain:
    """Return a chain of the catalogue, such as "ANSI 40".

    A roller chain is represented as a bushing chain of the roller's outside diameter. The clearance
    of its hinges is the standard's least. Mass follows the maker's weight per length; how inner and
    outer links share it, and the moments of inertia, follow from the parts: plates with rounded
    ends (a pressed-in pin or bushing fills the hole), tubes between the inner plates, pins with
    heads of half a plate's thickness; all scaled alike to the weight, which allows for the waist of
    real plates.

    Parameters
    ----------
    name : str
        Name in `ANSI_SIZES`.
    links : int
        Number of links, even.
    """
    name = _listed(name)
    size = ANSI_SIZES[name]
    pitch, roller_diameter, width, pin_diameter, thickness = (_INCH * length for length in size[:5])
    pin_radius = (pin_diameter + 0.0005 * _INCH) / 2
    bore_radius = (pin_diameter + 0.0015 * _INCH) / 2
    bushing_radius = roller_diameter / 2

    plates = _plate(pitch, 0.95 * pitch, 2 * thickness)
    tubes = _cylinders(pitch, bushing_radius, width)
    bores = _cylinders(pitch, bore_radius, width + 2 * thickness)
    inner = plates + tubes - bores
    pins = _cylinders(pitch, pin_radius, width + 3 * thickness)
    outer = _plate(pitch, 0.82 * pitch, 2 * thickness) + pins
    mass = 2 * pitch * size.weight * _POUND_PER_FOOT  # of an inner and an outer link
    scale = mass / (inner + outer)[0]

    return Chain(
        name=name,
        pitch=pitch,
        links=links,
        inner=Link(*(scale * inner)),
        outer=Link(*(scale * outer)),
        hinge=ClearanceHinge(pin_radius, bore_radius, length=width + 2 * thickness),
        bushing_radius=bushing_radius,
        tooth_contact_length=0.93 * width - 0.006 * _INCH,
    )


def _plate(pitch: float, height: float, thickness: float) -> npt.NDArray[np.float64]:
    """Return mass [kg] and inertia [kg m^2] of a bar with round ends centred on the hinges."""
    bar = pitch * height
    ends = pi * height**2 / 4
    bar_inertia = bar * (pitch**2 + height**2) / 12
    ends_inertia = ends * (height**2 / 8 + pitch**2 / 4 + pitch * 2 * height / (3 * pi))
    return _STEEL_DENSITY * thickness * np.array([bar + ends, bar_inertia + ends_inertia])


def _cylinders(pitch: float, radius: float, length: float) -> npt.NDArray[np.float64]:
    """Return mass [kg] and inertia [kg m^2] of a cylinder at each hinge, about the middle."""
    mass = _STEEL_DENSITY * 2 * pi * radius**2 * length
    return np.array([mass, mass * (radius**2 / 2 + pitch**2 / 4)])


def _tensioner(pretension: float | None) -> Tensioner | None:
    """Return a tensioner on sprocket 2, or none where there is nothing to pull."""
    return Tensioner(sprocket=2, pretension=pretension) if pretension else None


def _listed(name: str) -> str:
    """Return the name as it stands in the catalogue, whatever its case here."""
    for listed in ANSI_SIZES:
        if listed.casefold() == str(name).casefold():
            return listed
    msg = f"chain: {name!r} is not in the catalogue; {suggest(name, ANSI_SIZES)}"
    raise InvalidInput(msg)
