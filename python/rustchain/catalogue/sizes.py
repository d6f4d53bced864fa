"""The standard chains: the numbers of each size, where they come from, and masses of the parts.

Sources, by the words that `ChainSize.sources` uses:

- "standard": the standard's own number as two published tables give it alike (ANSI/ASME B29.1:
  rounded decimals that stand for fractions are fractions here; ISO 606: pitch, width, roller).
- "makers": makers' tables, which differ by about 5 % among themselves.
- "limit": the standard's limit, not a nominal size: largest heights of ANSI plates (0.95 and 0.82
  pitches), largest pin and smallest bore (0.0005 and 0.0015 in over the pin's nominal diameter).
- "typical": one maker's value or one that makers' values scatter round; not checked against a
  second source.
- "derived": computed here from the others; `ChainSize` says how.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from difflib import get_close_matches
from math import pi
from typing import NamedTuple

INCH = 0.0254  # [m]
_POUND_PER_FOOT = 0.45359237 / 0.3048  # [kg/m]
_POUND_FORCE = 4.4482216152605  # [N]
_STEEL_DENSITY = 7850.0  # [kg/m^3]
_BUSHING_OVER_ROLLER = 0.705  # of no. 40, whose bushings measure about 5.6 mm
_ROLLER_PLAY = 0.1e-3  # [m] roller's bore less bushing's diameter


class Part(NamedTuple):
    """Mass properties of one kind of part of one link, both pieces together.

    Attributes
    ----------
    mass : float
        [kg].
    inertia : float
        About the middle of the link's two hinges [kg m^2].
    """

    mass: float
    inertia: float


@dataclass(frozen=True)
class ChainSize:
    """One size of a standard, simplex.

    Attributes
    ----------
    name : str
        As `catalogue_chain` takes it, such as "ANSI 40" or "ISO 08B".
    standard : str
        Standard that the size belongs to.
    pitch : float
        [m].
    roller_diameter : float
        Outside diameter of what meets the teeth [m]: the roller, or the bushing of a chain without.
    inner_width : float
        Between the inner plates [m].
    pin_diameter, bore_diameter : float
        Pin and bore of the bushing [m].
    bushing_diameter : float
        Outside diameter of the bushing [m]; "derived" is 0.705 of the roller's, as of no. 40.
    inner_plate_height, outer_plate_height : float
        [m].
    inner_plate_thickness, outer_plate_thickness : float
        [m].
    tooth_width : float
        Thickness of the sprocket that fits [m].
    mass_per_length : float
        [kg/m].
    strength : float
        Smallest ultimate tensile strength [N].
    sources : mapping of str to str
        Where each number comes from: "standard", "makers", "limit", "typical" or "derived".
    """

    name: str
    standard: str
    pitch: float
    roller_diameter: float
    inner_width: float
    pin_diameter: float
    bore_diameter: float
    bushing_diameter: float
    inner_plate_height: float
    outer_plate_height: float
    inner_plate_thickness: float
    outer_plate_thickness: float
    tooth_width: float
    mass_per_length: float
    strength: float
    sources: Mapping[str, str]

    @property
    def has_rollers(self) -> bool:
        """Whether rollers turn on the bushings."""
        return self.bushing_diameter < self.roller_diameter

    @property
    def parts(self) -> dict[str, Part]:
        """Parts of an inner and an outer link, in the shapes of docs/reference/chains.md, unscaled.

        Keys are "inner plates", "bushings", "rollers" (of an inner link), "outer plates" and "pins"
        (of an outer link); each counts both of its kind.
        """
        bearing = self.inner_width + 2 * self.inner_plate_thickness
        pins = bearing + self.outer_plate_thickness
        bushings = _sum(
            self._cylinders(self.bushing_diameter, self.inner_width),
            self._cylinders(self.bore_diameter, -bearing),
        )
        rollers = Part(0.0, 0.0)
        if self.has_rollers:
            bore = self.roller_bore_diameter
            rollers = _sum(
                self._cylinders(self.roller_diameter, self.inner_width),
                self._cylinders(bore, -self.inner_width),
            )
        return {
            "inner plates": self._plates(self.inner_plate_height, self.inner_plate_thickness),
            "bushings": bushings,
            "rollers": rollers,
            "outer plates": self._plates(self.outer_plate_height, self.outer_plate_thickness),
            "pins": self._cylinders(self.pin_diameter, pins),
        }

    @property
    def roller_bore_diameter(self) -> float:
        """Bore of a roller [m], derived: 0.1 mm over the bushing."""
        return self.bushing_diameter + _ROLLER_PLAY

    def roller(self) -> Part:
        """Return one roller, scaled as the links are; its inertia is about its own axis."""
        mass = 0.5 * self.mass_scale * self.parts["rollers"].mass
        across = self.roller_diameter**2 + self.roller_bore_diameter**2
        return Part(mass, mass * across / 8)

    @property
    def mass_scale(self) -> float:
        """What the parts' masses are multiplied by to weigh `mass_per_length`."""
        return 2 * self.pitch * self.mass_per_length / sum(p.mass for p in self.parts.values())

    @property
    def plate_sections(self) -> tuple[float, float]:
        """Cross-section of both plates of an inner and of an outer link [m^2], derived.

        Twice height times thickness, without waists and holes.
        """
        return (
            2 * self.inner_plate_height * self.inner_plate_thickness,
            2 * self.outer_plate_height * self.outer_plate_thickness,
        )

    def links(self, rollers: bool = True) -> tuple[Part, Part]:
        """Return the inner link, with or without its rollers, and the outer one, to scale."""
        parts, scale = self.parts, self.mass_scale
        inner = _sum(parts["inner plates"], parts["bushings"])
        if rollers:
            inner = _sum(inner, parts["rollers"])
        outer = _sum(parts["outer plates"], parts["pins"])
        return (
            Part(scale * inner.mass, scale * inner.inertia),
            Part(scale * outer.mass, scale * outer.inertia),
        )

    def _plates(self, height: float, thickness: float) -> Part:
        """Two bars with round ends centred on the hinges; what is pressed in fills the holes."""
        bar, ends = self.pitch * height, pi * height**2 / 4
        area = bar * (self.pitch**2 + height**2) / 12
        area += ends * (height**2 / 8 + self.pitch**2 / 4 + self.pitch * 2 * height / (3 * pi))
        weight = _STEEL_DENSITY * 2 * thickness
        return Part(weight * (bar + ends), weight * area)

    def _cylinders(self, diameter: float, length: float) -> Part:
        """One at each hinge; a negative length takes away."""
        mass = _STEEL_DENSITY * 2 * pi / 4 * diameter**2 * length
        return Part(mass, mass * (diameter**2 / 8 + self.pitch**2 / 4))

    def __str__(self) -> str:
        """Return a table of the size, with the source of each number."""
        lines = [f"{self.name} ({self.standard}), simplex"]
        for field in fields(self)[2:-1]:
            value = getattr(self, field.name)
            if field.name == "mass_per_length":
                shown = f"{value:10.3f} kg/m"
            elif field.name == "strength":
                shown = f"{1e-3 * value:10.3f} kN"
            else:
                shown = f"{1e3 * value:10.3f} mm"
            label = field.name.replace("_", " ")
            lines.append(f"  {label:<22}{shown:<17}{self.sources[field.name]}")
        for label, part in zip(("inner link", "outer link"), self.links(), strict=True):
            shown = f"{1e3 * part.mass:10.3f} g, {1e6 * part.inertia:.4g}e-6 kg m^2"
            lines.append(f"  {label:<22}{shown}  derived")
        sections = zip(
            ("inner plates, both", "outer plates, both"), self.plate_sections, strict=True
        )
        for label, section in sections:
            shown = f"{1e6 * section:10.3f} mm^2"
            lines.append(f"  {label:<22}{shown:<17}derived")
        if self.has_rollers:
            bore, one = f"{1e3 * self.roller_bore_diameter:10.3f} mm", self.roller()
            lines.append(f"  {'roller bore diameter':<22}{bore:<17}derived")
            shown = f"{1e3 * one.mass:10.3f} g, {1e6 * one.inertia:.4g}e-6 kg m^2"
            lines.append(f"  {'roller, one':<22}{shown}  derived")
        return "\n".join(lines)


def _sum(*parts: Part) -> Part:
    return Part(sum(p.mass for p in parts), sum(p.inertia for p in parts))


# No.: pitch, roller, width, pin, plate thickness [in], strength [lbf], weight [lb/ft]
_ANSI: dict[str, tuple[float, ...]] = {
    "25": (1 / 4, 0.130, 1 / 8, 0.0905, 0.030, 780, 0.084),
    "35": (3 / 8, 0.200, 3 / 16, 0.141, 0.050, 1760, 0.21),
    "41": (1 / 2, 0.306, 1 / 4, 0.141, 0.050, 1500, 0.28),
    "40": (1 / 2, 5 / 16, 5 / 16, 0.156, 0.060, 3125, 0.41),
    "50": (5 / 8, 0.400, 3 / 8, 0.200, 0.080, 4880, 0.68),
    "60": (3 / 4, 15 / 32, 1 / 2, 0.234, 0.094, 7030, 1.00),
    "80": (1, 5 / 8, 5 / 8, 0.312, 0.125, 12500, 1.69),
    "100": (1 + 1 / 4, 3 / 4, 3 / 4, 0.375, 0.156, 19530, 2.49),
    "120": (1 + 1 / 2, 7 / 8, 1, 0.437, 0.187, 28125, 3.67),
    "140": (1 + 3 / 4, 1, 1, 0.500, 0.219, 38280, 4.93),
    "160": (2, 1 + 1 / 8, 1 + 1 / 4, 0.562, 0.250, 50000, 6.43),
    "180": (2 + 1 / 4, 1 + 13 / 32, 1 + 13 / 32, 0.687, 0.281, 63280, 8.70),
    "200": (2 + 1 / 2, 1 + 9 / 16, 1 + 1 / 2, 0.781, 0.312, 78125, 10.51),
    "240": (3, 1 + 7 / 8, 1 + 7 / 8, 0.937, 0.375, 112500, 16.90),
}
_WITHOUT_ROLLERS = ("25", "35")

# No.: pitch, roller, width, pin; heights and thicknesses of plates, inner and outer [mm];
# strength [kN], mass [kg/m]
_ISO: dict[str, tuple[float, ...]] = {
    "05B": (8.0, 5.0, 3.0, 2.31, 7.11, 7.11, 0.75, 0.75, 4.4, 0.18),
    "06B": (9.525, 6.35, 5.72, 3.28, 8.26, 8.26, 1.3, 1.0, 8.9, 0.41),
    "08B": (12.7, 8.51, 7.75, 4.45, 11.8, 11.8, 1.6, 1.6, 17.8, 0.70),
    "10B": (15.875, 10.16, 9.65, 5.08, 14.7, 14.7, 1.7, 1.7, 22.2, 0.92),
    "12B": (19.05, 12.07, 11.68, 5.72, 16.1, 16.1, 1.85, 1.85, 28.9, 1.16),
    "16B": (25.4, 15.88, 17.02, 8.28, 21.1, 21.1, 4.15, 3.1, 60.0, 2.70),
    "20B": (31.75, 19.05, 19.56, 10.19, 26.4, 26.4, 4.5, 3.5, 95.0, 3.50),
    "24B": (38.1, 25.4, 25.4, 14.63, 33.4, 33.4, 6.0, 4.8, 160.0, 6.80),
    "28B": (44.45, 27.94, 30.99, 15.9, 37.08, 37.08, 7.5, 6.3, 200.0, 9.1),
    "32B": (50.8, 29.21, 30.99, 17.81, 42.3, 42.3, 7.0, 6.0, 250.0, 10.5),
}
# Sizes whose pin, plate heights or strength a second source confirms.
_CONFIRMED = {
    "pin_diameter": ("08B", "10B", "12B", "16B"),
    "inner_plate_height": ("08B", "10B"),
    "outer_plate_height": ("08B", "10B"),
    "strength": ("16B",),
}


def _ansi(number: str) -> ChainSize:
    pitch, roller, width, pin, thickness = (INCH * length for length in _ANSI[number][:5])
    bare = number in _WITHOUT_ROLLERS
    sources = {
        "pitch": "standard",
        "roller_diameter": "standard, bushing" if bare else "standard",
        "inner_width": "standard",
        "pin_diameter": "limit",
        "bore_diameter": "limit",
        "bushing_diameter": "standard" if bare else "derived",
        "inner_plate_height": "limit",
        "outer_plate_height": "limit",
        "inner_plate_thickness": "standard",
        "outer_plate_thickness": "standard",
        "tooth_width": "standard, largest",
        "mass_per_length": "makers",
        "strength": "standard",
    }
    return ChainSize(
        name=f"ANSI {number}",
        standard="ANSI/ASME B29.1",
        pitch=pitch,
        roller_diameter=roller,
        inner_width=width,
        pin_diameter=pin + 0.0005 * INCH,  # the largest
        bore_diameter=pin + 0.0015 * INCH,  # the smallest
        bushing_diameter=roller if bare else _BUSHING_OVER_ROLLER * roller,
        inner_plate_height=0.95 * pitch,
        outer_plate_height=0.82 * pitch,
        inner_plate_thickness=thickness,
        outer_plate_thickness=thickness,
        tooth_width=0.93 * width - 0.006 * INCH,
        mass_per_length=_POUND_PER_FOOT * _ANSI[number][6],
        strength=_POUND_FORCE * _ANSI[number][5],
        sources=sources,
    )


def _iso(number: str) -> ChainSize:
    lengths = [1e-3 * length for length in _ISO[number][:8]]
    pitch, roller, width, pin = lengths[:4]
    sources = dict.fromkeys(
        (
            "pin_diameter",
            "bore_diameter",
            "inner_plate_height",
            "outer_plate_height",
            "inner_plate_thickness",
            "outer_plate_thickness",
            "tooth_width",
            "strength",
        ),
        "typical",
    )
    sources |= {name: "makers" for name, sizes in _CONFIRMED.items() if number in sizes}
    sources |= dict.fromkeys(("pitch", "roller_diameter", "inner_width"), "standard")
    return ChainSize(
        name=f"ISO {number}",
        standard="ISO 606",
        pitch=pitch,
        roller_diameter=roller,
        inner_width=width,
        pin_diameter=pin,
        bore_diameter=pin + 0.05e-3,
        bushing_diameter=_BUSHING_OVER_ROLLER * roller,
        inner_plate_height=lengths[4],
        outer_plate_height=lengths[5],
        inner_plate_thickness=lengths[6],
        outer_plate_thickness=lengths[7],
        tooth_width=(0.93 if pitch <= 0.0127 else 0.95) * width,
        mass_per_length=_ISO[number][9],
        strength=1e3 * _ISO[number][8],
        sources=sources | {"bushing_diameter": "derived", "mass_per_length": "makers"},
    )


SIZES: dict[str, ChainSize] = {size.name: size for size in (*map(_ansi, _ANSI), *map(_iso, _ISO))}

# ISO 606 lists the ANSI sizes too: their pitch in sixteenths of an inch and "A", but for these.
_ISO_OF_ANSI = {"25": "04C", "35": "06C", "41": "085"}


def _other_names(name: str) -> list[str]:
    """Return the names that a size goes by, in small letters and without a space."""
    standard, number = name.casefold().split()
    names = [f"{standard}{number}", number]
    if standard == "ansi":
        iso = _ISO_OF_ANSI.get(number) or f"{int(number) // 5:02d}A"
        names += [f"#{number}", f"rs{number}", f"iso{iso}", iso]
    return [other.casefold() for other in names]


# What makers and standards call the sizes -> the name in the catalogue.
_OTHER_NAMES: dict[str, str] = {other: name for name in SIZES for other in _other_names(name)}


def named_size(name: str) -> str | None:
    """Return the name in the catalogue of what makers and standards call a size, or None."""
    return _OTHER_NAMES.get(_folded(name))


def nearest_size(name: str) -> str | None:
    """Return the name in the catalogue that is nearest to an unknown one, or None."""
    for part in (name, name.partition("-")[0]):  # the rest may be the strands
        padded = re.sub(r"(?<!\d)(\d[abc])", r"0\1", _folded(part))  # "8b" is 08B
        if near := get_close_matches(padded, _OTHER_NAMES, n=1):
            return _OTHER_NAMES[near[0]]
    return None


def _folded(name: str) -> str:
    """Return a name in small letters, without spaces around it and behind the standard's name."""
    return re.sub(r"^(ansi|iso|rs|#)\s+", r"\1", name.strip().casefold())
