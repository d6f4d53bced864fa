"""Chains by name and drives from a handful of numbers."""

from __future__ import annotations

import re
from dataclasses import replace
from math import pi
from typing import Literal, TypeAlias

from rustchain import _rustchain
from rustchain.arguments import admitted, finite_number, plain, shown
from rustchain.catalogue.sizes import SIZES, ChainSize, named_size, nearest_size
from rustchain.description.chain import Chain, ClearanceHinge, Link, Plates, Roller
from rustchain.description.drive import ChainDrive, Hinges
from rustchain.description.material import Material
from rustchain.description.signals import Signal
from rustchain.description.sprocket import AppliedTorque, Free, PrescribedSpeed, Sprocket
from rustchain.description.teeth import AnsiTooth, IsoTooth, Seat, ToothForm
from rustchain.description.tensioner import Tensioner
from rustchain.errors import InvalidInput
from rustchain.names import known_keywords, suggest
from rustchain.typing import Counts, Point

Rollers: TypeAlias = Literal["fixed", "bodies"]
Stretch: TypeAlias = Literal["rigid", "elastic"]

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
def paper_drive(
    pretension: float | None = 0.0,
    *,
    hinges: Hinges = "clearance",
    rollers: Rollers = "fixed",
) -> ChainDrive:
    """Return the published drive: 38 links round two sprockets of 17 teeth, the driver at 120 rpm.

    Parameters
    ----------
    pretension : float, optional
        Tension that a tensioner on sprocket 2 gives each strand [N]; at 0 or None the centres are
        fixed.
    hinges : {"clearance", "ideal"}
        Pins with clearance in their bushings, or ideal joints.
    rollers : {"fixed", "bodies"}
        "fixed": the published bushing chain. "bodies": rollers of a no. 40 chain on smaller
        bushings; outside radius, mass of the chain and all other data are the same.

    Examples
    --------
    >>> drive = rc.paper_drive(pretension=25.0)
    >>> drive.chain.links, [sprocket.teeth for sprocket in drive.sprockets]
    (38, [17, 17])
    """
    teeth = 17

    def sprocket(center: Point, motion: PrescribedSpeed | Free) -> Sprocket:
        profile = AnsiTooth(seat="pitch-circle")
        return Sprocket(teeth, center, motion, profile, mass=0.817, inertia=588.29e-6)

    distance = _rustchain.closing_center_distance(
        PAPER_CHAIN.pitch, (teeth, teeth), PAPER_CHAIN.links
    )
    return ChainDrive(
        chain=_rolling(PAPER_CHAIN, SIZES["ANSI 40"], rollers),
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
    teeth: Counts = (17, 25),
    *,
    links: int | None = None,
    center_distance: float | None = None,
    speed: Signal = 12.566,
    pretension: float | None = None,
    torque: Signal | None = None,
    seat: Seat = "bottom-diameter",
    gravity: Point = (0.0, -9.81),
    hinges: Hinges = "clearance",
    profile: ToothForm | None = None,
    rollers: Rollers = "fixed",
    plates: Stretch = "rigid",
) -> ChainDrive:
    """Return a drive of two sprockets, the driver at the origin and the other at +x.

    Parameters
    ----------
    chain : str or Chain
        Name in the catalogue, such as "ANSI 40", or a chain, whose `links` are then the default.
    teeth : (int, int)
        Numbers of teeth of the driver and of the driven sprocket.
    links : int, optional
        Number of links; by default the smallest even number that closes round `center_distance`.
        One of both is needed.
    center_distance : float, optional
        Distance of the centres [m]; by default that at which the strands are taut and straight.
    speed : float, rows of (time, speed), Table, Spline, Sines or SmoothStep
        Speed of the driver [rad/s], counterclockwise positive.
    pretension : float, optional
        Tension that a tensioner on sprocket 2 gives each strand [N]; by default the centres are
        fixed.
    torque : float, rows of (time, torque), Table, Spline, Sines or SmoothStep, optional
        Torque on the driven sprocket [N m], counterclockwise positive; by default none.
    seat : {"bottom-diameter", "pitch-circle"}
        Position of the seats of the default teeth; see `AnsiTooth`. A `profile` has its own.
    gravity : (float, float)
        Acceleration of gravity [m/s^2].
    hinges : {"clearance", "ideal"}
        Pins with clearance in their bushings, or ideal joints.
    profile : AnsiTooth, IsoTooth, StraightTooth or CustomTooth, optional
        Tooth form of both sprockets. By default it is `IsoTooth` for a chain with the name of an
        ISO size of the catalogue, else `AnsiTooth`, with this `seat`.
    rollers : {"fixed", "bodies"}
        For a chain given by its name; see `catalogue_chain`.
    plates : {"rigid", "elastic"}
        For a chain given by its name; see `catalogue_chain`.

    Examples
    --------
    >>> drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=rc.rpm(120), torque=-2.0)
    >>> drive.chain.links
    60
    >>> round(drive.sprockets[1].center[0], 4)  # [m]; the strands are straight
    0.2471
    """
    if finite_number(teeth) is not None:
        msg = f"teeth = {shown(teeth)}: must be two whole numbers, such as (17, 25)"
        raise InvalidInput(msg)
    pair: tuple[int, int] = admitted("two_sprocket_drive(teeth)", teeth, tuple[int, int])
    links = None if links is None else admitted("two_sprocket_drive(links)", links, int)
    seat = admitted("two_sprocket_drive(seat)", seat, Seat)
    if profile is not None and seat != "bottom-diameter":
        msg = (
            f"seat = {shown(seat)}: must be left out beside a profile, which has its own; give it "
            f"there, such as AnsiTooth(seat={shown(seat)})"
        )
        raise InvalidInput(msg)
    if isinstance(chain, Chain):
        links = chain.links if links is None else links
        pitch = replace(chain, links=links).mean_pitch
    else:
        pitch = _size(chain)[0].pitch
    if links is None:
        if center_distance is None:
            msg = (
                "two_sprocket_drive: links=None and center_distance=None; give at least one of them"
            )
            raise InvalidInput(msg)
        links = _rustchain.links_for(pitch, pair, center_distance)
    if center_distance is None:
        center_distance = _rustchain.closing_center_distance(pitch, pair, links)
    chain = replace(chain_of(chain, links, rollers, plates), links=links)
    if profile is None:
        # A changed chain of the catalogue has the teeth of its size: the name is kept.
        size = SIZES.get(chain.name)
        iso = size is not None and size.standard == "ISO 606"
        profile = IsoTooth(seat=seat) if iso else AnsiTooth(seat=seat)
    strands = f"-{chain.strands}" if chain.strands > 1 else ""
    return ChainDrive(
        chain=chain,
        sprockets=[
            Sprocket(pair[0], (0.0, 0.0), PrescribedSpeed(speed), profile),
            Sprocket(
                pair[1],
                (center_distance, 0.0),
                Free() if torque is None else AppliedTorque(torque),
                profile,
            ),
        ],
        tensioner=_tensioner(pretension),
        gravity=gravity,
        name=f"{chain.name}{strands}, {pair[0]}:{pair[1]}",
        hinges=hinges,
    )


def chain_sizes() -> dict[str, ChainSize]:
    """Return the standard chains by name: ANSI/ASME B29.1 and ISO 606; print one to read it.

    Examples
    --------
    >>> round(rc.chain_sizes()["ANSI 40"].strength)  # [N]
    13901
    """
    return dict(SIZES)


@known_keywords
def catalogue_chain(
    name: str,
    links: int,
    *,
    strands: int | None = None,
    rollers: Rollers = "fixed",
    plates: Stretch = "rigid",
) -> Chain:
    """Return a chain of the catalogue, such as "ANSI 40" or "ISO 08B".

    Sources of its numbers: `chain_sizes` and docs/reference/chains.md.

    Parameters
    ----------
    name : str
        Name in `chain_sizes()`, or another name of the size: the number alone ("40", "08B"), "#40",
        "RS40", and of ANSI sizes that of ISO 606 ("ISO 08A" is "ANSI 40"). A suffix "-1", "-2" or
        "-3" gives the number of strands, as in "08B-2".
    links : int
        Number of links.
    strands : int, optional
        Parallel strands on common pins; by default those of the name, or 1.
    rollers : {"fixed", "bodies"}
        "fixed": a roller chain is a bushing chain of the roller's outside diameter, and the inner
        links have the mass of the rollers. "bodies": every roller is a body that turns on its
        bushing with clearance; mass, inertia and bore are derived. Sizes without rollers permit
        "fixed" alone.
    plates : {"rigid", "elastic"}
        "elastic": links have the axial stiffness of their plates, whose cross-sections are derived.

    Examples
    --------
    >>> chain = rc.catalogue_chain("ISO 08B", 80)
    >>> chain.pitch, chain.links
    (0.0127, 80)
    >>> rc.catalogue_chain("08B-2", 80).strands
    2
    """
    size, named = _size(name)
    if strands is not None and named not in (None, strands):
        msg = f"strands = {strands}: the name {name!r} says {named}; give one of them"
        raise InvalidInput(msg)
    admitted("plates", plates, Stretch)
    inner, outer = size.links()
    fixed = Chain(
        name=size.name,
        pitch=size.pitch,
        links=links,
        inner=Link(*inner),
        outer=Link(*outer),
        hinge=ClearanceHinge(
            size.pin_diameter / 2,
            size.bore_diameter / 2,
            length=size.inner_width + 2 * size.inner_plate_thickness,
        ),
        bushing_radius=size.roller_diameter / 2,
        tooth_contact_length=size.tooth_width,
        strands=(named or 1) if strands is None else strands,
        link_stiffness=Plates(*size.plate_sections) if plates == "elastic" else None,
    )
    return _rolling(fixed, size, rollers)


def chain_of(chain: str | Chain, links: int, rollers: Rollers, plates: Stretch) -> Chain:
    """Return the catalogue's chain of this name, with `links` links, or a given chain unchanged.

    Raise `InvalidInput` where a given chain has no rollers or elastic plates, and they are wanted.
    """
    if isinstance(chain, str):
        return catalogue_chain(chain, links, rollers=rollers, plates=plates)
    if not isinstance(chain, Chain):
        msg = f"chain = {shown(chain)}: must be a Chain, or the name of one in the catalogue"
        raise InvalidInput(msg)
    admitted("rollers", rollers, Rollers)
    if rollers == "bodies" and chain.roller is None:
        msg = (
            "rollers = 'bodies': the chain given has none; give it Chain(..., roller=Roller(...)), "
            "or name a chain of the catalogue"
        )
        raise InvalidInput(msg)
    admitted("plates", plates, Stretch)
    if plates == "elastic" and chain.link_stiffness is None:
        msg = (
            "plates = 'elastic': the chain given is rigid; give it Chain(..., "
            "link_stiffness=Plates(...)), or name a chain of the catalogue"
        )
        raise InvalidInput(msg)
    return chain


def _rolling(chain: Chain, size: ChainSize, rollers: Rollers) -> Chain:
    """Return a chain whose rollers, fixed to its bushings, are made bodies where that is asked."""
    admitted("rollers", rollers, Rollers)
    if rollers == "fixed":
        return chain
    if not size.has_rollers:
        msg = f"rollers = 'bodies': {size.name} is a chain without rollers; leave rollers='fixed'"
        raise InvalidInput(msg)
    mass, inertia = size.roller()
    # An inertia that counts bushings counts the rollers on them too; the published one does not.
    counted = chain is not PAPER_CHAIN
    turning = 2 * mass * size.pitch**2 / 4 + 2 * inertia if counted else 0.0
    roller = Roller(
        radius=size.roller_diameter / 2,
        bore_radius=size.roller_bore_diameter / 2,
        length=size.inner_width,
        mass=mass,
        inertia=inertia,
    )
    inner = Link(chain.inner.mass - 2 * mass, chain.inner.inertia - turning)
    return replace(chain, inner=inner, bushing_radius=size.bushing_diameter / 2, roller=roller)


def _tensioner(pretension: float | None) -> Tensioner | None:
    """Return a tensioner on sprocket 2, or None without pretension."""
    if pretension is None or finite_number(pretension) == 0:
        return None
    return Tensioner(sprocket=2, pretension=pretension)


def _size(name: str) -> tuple[ChainSize, int | None]:
    """Return the size of this name, whatever its case, and its number of strands."""
    if not isinstance(name, str):
        text = shown(plain(name))
        meant = f": '{text}'" if named_size(text) else ", such as 'ANSI 40'"
        raise InvalidInput(f"chain = {shown(name)}: must be text, a name in the catalogue{meant}")
    size, dash, strands = name.partition("-")
    listed = named_size(size)
    if listed is not None and (not dash or strands in ("1", "2", "3")):
        return SIZES[listed], int(strands) if dash else None
    near = nearest_size(name)
    hint = suggest(name, SIZES) if near is None else f"did you mean {near!r}?"
    if listed is not None and re.fullmatch("[4-9]|1[0-9]|2[0-4]", strands):
        hint += f" Strands above 3: catalogue_chain({listed!r}, links, strands={strands})"
    raise InvalidInput(f"chain: {shown(name)} is not in the catalogue; {hint}")
