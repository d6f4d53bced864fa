"""The standard chains: sizes, from the table sizes.toml, and masses of the parts.

Sources, by the words of `ChainSize.sources`:

- "standard": the standard's own number as two published tables give it alike (ANSI/ASME B29.1:
  decimals that tables round are not rounded here; ISO 606: pitch, width, roller).
- "makers": makers' tables, which differ by about 5 % among themselves.
- "limit": the standard's limit, not a nominal size: largest heights of ANSI plates (0.95 and 0.82
  pitches), largest pin and smallest bore (0.0005 and 0.0015 in over the pin's nominal diameter).
- "typical": one maker's value or one that makers' values scatter round; not checked against a
  second source.
- "derived": computed here from the others; `ChainSize` describes the method.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

from rustchain import _rustchain
from rustchain.arguments import admitted
from rustchain.errors import InvalidInput

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
        Outside diameter in contact with the teeth [m]: the roller, or the bushing of a chain
        without.
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

    Examples
    --------
    >>> sizes = rc.chain_sizes()
    >>> sizes["ANSI 40"].pitch
    0.0127
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
    sources: Mapping[str, str] = field(hash=False)

    def breaking_load(self, strands: int = 1) -> float | None:
        """Return the smallest ultimate tensile strength of all strands [N]; None: not known.

        ANSI chains have that of one strand times their number. Two and three strands of the B
        series have typical values of their own, from 05B to 24B.

        Raises
        ------
        InvalidInput
            `strands` is not a whole number of 1 or more.

        Examples
        --------
        >>> rc.chain_sizes()["ISO 08B"].breaking_load(2)
        31100.0
        """
        strands = admitted("breaking_load(strands)", strands, int)
        if strands < 1:
            raise InvalidInput(f"strands = {strands}: must be 1 or more")
        if strands == 1 or self.name.startswith("ANSI"):
            return strands * self.strength
        return _STRENGTHS.get(self.name, {}).get(strands)

    @property
    def has_rollers(self) -> bool:
        """True if rollers turn on the bushings."""
        return self.bushing_diameter < self.roller_diameter

    @property
    def parts(self) -> dict[str, Part]:
        """Parts of an inner and an outer link, in the shapes of docs/reference/chains.md, unscaled.

        Keys are "inner plates", "bushings", "rollers" (of an inner link), "outer plates" and "pins"
        (of an outer link); each counts both of its kind.
        """
        # A bore is counted where it is, also in the plates. All of it with the bushings would leave
        # those of ISO 32B a negative mass: their wall is thin and their plates are thick.
        parts, length = self._whole_bores, 2 * self.inner_plate_thickness
        plates = _sum(parts["inner plates"], self._cylinders(self.bore_diameter, -length))
        bushings = _sum(parts["bushings"], self._cylinders(self.bore_diameter, length))
        return parts | {"inner plates": plates, "bushings": bushings}

    @property
    def _whole_bores(self) -> dict[str, Part]:
        """Parts with the whole bores counted with the bushings: what links and their scale add up.

        Sums of `parts` would be the same to rounding, but runs would not have the same bits.
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
        """Return the factor of the parts' masses at which the chain weighs `mass_per_length`."""
        whole = sum(p.mass for p in self._whole_bores.values())
        return 2 * self.pitch * self.mass_per_length / whole

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
        parts, scale = self._whole_bores, self.mass_scale
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

    def __repr__(self) -> str:
        """Return name, pitch, mass per length and strength on one line."""
        return (
            f"<ChainSize {self.name}: pitch {1e3 * self.pitch:g} mm, "
            f"{self.mass_per_length:.3g} kg/m, strength {1e-3 * self.strength:.3g} kN>"
        )

    def __str__(self) -> str:
        """Return a table of the size, with the source of each number."""
        units = {"mass_per_length": (1.0, "kg/m"), "strength": (1e-3, "kN")}
        rows = []  # label, number, unit, source
        for each in fields(self)[2:-1]:
            factor, unit = units.get(each.name, (1e3, "mm"))
            value = factor * getattr(self, each.name)
            rows.append((each.name.replace("_", " "), value, unit, self.sources[each.name]))
        source = "derived" if self.name.startswith("ANSI") else "typical"
        for strands in (2, 3):
            if (load := self.breaking_load(strands)) is not None:
                rows.append((f"strength, {strands} strands", 1e-3 * load, "kN", source))
        inner, outer = self.links()
        links = {"inner link": inner, "outer link": outer}
        rows += [(label, *_mass_in_words(part), "derived") for label, part in links.items()]
        for label, section in zip(("inner", "outer"), self.plate_sections, strict=True):
            rows.append((f"{label} plates, both", 1e6 * section, "mm^2", "derived"))
        if self.has_rollers:
            bore = 1e3 * self.roller_bore_diameter
            rows.append(("roller bore diameter", bore, "mm", "derived"))
            rows.append(("roller, one", *_mass_in_words(self.roller()), "derived"))
        lines = [f"{self.name} ({self.standard}), simplex"]
        for label, number, unit, source in rows:
            lines.append(f"  {label:<22}{number:10.3f} {unit:<6}{source}")
        return "\n".join(lines)


def _mass_in_words(part: Part) -> tuple[float, str]:
    """Return the mass of a part [g], and as its unit what follows the number in a table."""
    return 1e3 * part.mass, f"g, {1e6 * part.inertia:.4g}e-6 kg m^2  "


def _sum(*parts: Part) -> Part:
    return Part(sum(p.mass for p in parts), sum(p.inertia for p in parts))


def _ansi(name: str, row: Sequence[float], table: Mapping[str, Any]) -> ChainSize:
    """Return an ANSI size; the file has what its numbers are."""
    pitch, roller, width, pin, thickness = (INCH * length for length in row[:5])
    bare = name in table["without_rollers"]
    bushings = {"roller_diameter": "standard, bushing", "bushing_diameter": "standard"}
    return ChainSize(
        name=f"ANSI {name}",
        standard=table["standard"],
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
        mass_per_length=_POUND_PER_FOOT * row[6],
        strength=_POUND_FORCE * row[5],
        sources=table["sources"] | (bushings if bare else {}),
    )


def _iso(name: str, row: Sequence[float], table: Mapping[str, Any]) -> ChainSize:
    """Return an ISO size; the file has what its numbers are."""
    pitch, roller, width, pin, *plates = (1e-3 * length for length in row[:8])
    confirmed = {each: "makers" for each, names in table["confirmed"].items() if name in names}
    return ChainSize(
        name=f"ISO {name}",
        standard=table["standard"],
        pitch=pitch,
        roller_diameter=roller,
        inner_width=width,
        pin_diameter=pin,
        bore_diameter=pin + 0.05e-3,
        bushing_diameter=_BUSHING_OVER_ROLLER * roller,
        inner_plate_height=plates[0],
        outer_plate_height=plates[1],
        inner_plate_thickness=plates[2],
        outer_plate_thickness=plates[3],
        tooth_width=(0.93 if pitch <= 0.0127 else 0.95) * width,
        mass_per_length=row[9],
        strength=1e3 * row[8],
        sources=table["sources"] | confirmed,
    )


_TABLES, _ = _rustchain.read_toml(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))

# Strength [N] of two and of three strands, by size.
_STRENGTHS = {
    f"ISO {name}": {2: 1e3 * two, 3: 1e3 * three}
    for name, (two, three) in _TABLES["ISO"]["strands"].items()
}


def _sizes() -> Iterator[ChainSize]:
    """Yield the sizes in the file beside this one."""
    for standard, make in (("ANSI", _ansi), ("ISO", _iso)):
        table = _TABLES[standard]
        for name, row in table["sizes"].items():
            yield make(name, row, table)


SIZES: dict[str, ChainSize] = {size.name: size for size in _sizes()}

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
