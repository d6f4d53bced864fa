"""A chain: its links, hinges and material."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rustchain import _rustchain
from rustchain.description.base import Description, description
from rustchain.description.material import Material
from rustchain.typing import Number, Numbers


@description(frozen=True)
class Link(Description):
    """A link with all that is fixed to it: plates and bushings (inner), plates and pins (outer).

    Attributes
    ----------
    mass : float
        Mass [kg].
    inertia : float
        Moment of inertia about the middle of its two hinges [kg m^2].

    Examples
    --------
    >>> rc.Link(mass=7e-3, inertia=1.5e-7)
    Link(mass=0.007, inertia=1.5e-07)
    """

    mass: float
    inertia: float


@description(frozen=True)
class ClearanceHinge(Description):
    """A pin that is loose in the bore of a bushing.

    Attributes
    ----------
    pin_radius, bore_radius : float
        Radii of pin and bore [m]; their difference is the radial clearance.
    length : float
        Length of contact along the pin [m].

    Examples
    --------
    >>> round(1e6 * rc.ClearanceHinge(2.22e-3, 2.245e-3, 0.011).clearance)  # [um]
    25
    """

    pin_radius: float
    bore_radius: float
    length: float

    @property
    def clearance(self) -> float:
        """Radial clearance [m]."""
        return self.bore_radius - self.pin_radius


@description(frozen=True)
class Roller(Description):
    """A roller that turns on its bushing with clearance: a body of its own.

    Attributes
    ----------
    radius : float
        Outside radius, in contact with the teeth [m].
    bore_radius : float
        Radius of its bore [m]; larger than the bushing's by the radial clearance.
    length : float
        Length of contact of bushing and bore, along the bushing [m].
    mass : float
        Mass [kg].
    inertia : float
        Moment of inertia about its axis [kg m^2].

    Examples
    --------
    >>> rolling = rc.catalogue_chain("ANSI 40", 60, rollers="bodies")
    >>> round(1e3 * rolling.roller.radius, 3)  # [mm]
    3.969
    """

    radius: float
    bore_radius: float
    length: float
    mass: float
    inertia: float


@description(frozen=True)
class Plates(Description):
    """Link plates, from which the axial stiffness of links follows.

    A link is a bar with the cross-section of its plates and the length of a pitch: E A / p. Inner
    and outer links are in series, which gives the harmonic mean. The waist of real plates reduces
    the stiffness, the eyes that grip pins and bushings increase it.

    Attributes
    ----------
    inner_section, outer_section : float
        Cross-section of both plates of an inner and of an outer link, of one strand [m^2].
    elastic_modulus : float, optional
        Young's modulus [Pa]; by default that of the chain's material.

    Examples
    --------
    >>> elastic = rc.catalogue_chain("ANSI 40", 60, plates="elastic")
    >>> round(1e-6 * elastic.axial_stiffness)  # [N/um]
    555
    """

    inner_section: float
    outer_section: float
    elastic_modulus: float | None = None


@description(frozen=True)
class Chain(Description):
    """A closed bushing or roller chain: inner and outer links in turn; link 1 is an inner one.

    In a chain of an odd number of links the last one is an offset link: a bushing at its rear, a
    pin at its front.

    Attributes
    ----------
    pitch : float
        Nominal distance between the hinges of a link [m].
    links : int
        Number of links, 4 to 100,000.
    inner, outer : Link
        Inner link (two bushings) and outer link (two pins).
    hinge : ClearanceHinge
        Pin and bore of every hinge.
    bushing_radius : float
        Outside radius of a bushing [m]; without `roller` it is in contact with the teeth.
    tooth_contact_length : float
        Length of contact with a tooth, along the bushing or roller [m].
    material : Material
        Material of chain and sprockets.
    name : str
        Name for reports and figures.
    offset : Link, optional
        Offset link of an odd number of links; by default the mean of an inner and an outer one.
    strands : int
        Number of parallel strands on common pins. Masses, inertias and lengths of contact are those
        of one strand; the run multiplies them by the number of strands.
    elongation : float or sequence of float
        Increase of the length of all links, or of each link, as a share of the pitch: wear.
    pitch_spread : float
        Standard deviation of the lengths of links due to manufacture, as a share of the pitch.
    seed : int
        Seed of the random deviations of `pitch_spread`.
    roller : Roller, optional
        Roller on every bushing: a body of its own, in contact with the teeth in place of the
        bushing. The masses of inner links are then without rollers. By default the chain is a
        bushing chain.
    link_stiffness : float or Plates, optional
        Axial stiffness of a link of one strand [N/m], or the plates from which it follows. It is in
        series with the contacts of the hinges, half of the link with each. By default links are
        rigid.
    carried : sequence of (link, mass)
        Masses in the middle of links [kg], with the numbers of the links from 1: slats, buckets,
        goods. A mass is that on all strands together.

    Examples
    --------
    >>> chain = rc.catalogue_chain("ANSI 40", 60)
    >>> round(1e3 * chain.contact_radius, 3)  # [mm]
    3.969
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
    elongation: Number | Numbers = 0.0
    pitch_spread: float = 0.0
    seed: int = 0
    roller: Roller | None = None
    link_stiffness: float | Plates | None = None
    carried: Sequence[tuple[int, float]] = ()

    @property
    def contact_radius(self) -> float:
        """Outside radius of rollers or bushings, in contact with the teeth [m]."""
        return self.bushing_radius if self.roller is None else self.roller.radius

    @property
    def axial_stiffness(self) -> float | None:
        """Axial stiffness of a link of all strands [N/m]; None: links are rigid."""
        return _rustchain.link_stiffness(self)

    @property
    def link_pitches(self) -> npt.NDArray[np.float64]:
        """Distance between the hinges of each link [m], wear and spread included; read-only."""
        pitches = _rustchain.chain_links(self)[:, 0]
        pitches.flags.writeable = False
        return pitches

    @property
    def mean_pitch(self) -> float:
        """Mean of `link_pitches` [m]."""
        pitches = self.link_pitches
        return float(pitches[0] if (pitches == pitches[0]).all() else pitches.mean())
