"""The catalogue: every size, its sources, its masses, and names that are not there."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

import rustchain as rc
from command import rustchain

INCH = 0.0254
SIZES = rc.chain_sizes()
ANSI = ["25", "35", "41", "40", "50", "60", "80", "100", "120", "140", "160", "180", "200", "240"]
ISO = ["05B", "06B", "08B", "10B", "12B", "16B", "20B", "24B", "28B", "32B"]
WORDS = {"standard", "standard, bushing", "standard, largest", "makers", "limit", "typical"}


def test_all_sizes_of_both_standards_are_there():
    assert list(SIZES) == [f"ANSI {n}" for n in ANSI] + [f"ISO {n}" for n in ISO]


@pytest.mark.parametrize("name", SIZES)
def test_each_number_has_a_source_and_the_parts_fit_into_each_other(name):
    size = SIZES[name]
    numbers = {f.name for f in fields(size)} - {"name", "standard", "sources"}
    assert set(size.sources) == numbers
    assert set(size.sources.values()) <= WORDS | {"derived"}
    assert size.pin_diameter < size.bore_diameter < size.bushing_diameter <= size.roller_diameter
    assert size.roller_diameter < size.pitch
    assert size.tooth_width < size.inner_width
    assert max(size.inner_plate_height, size.outer_plate_height) < size.pitch
    assert size.has_rollers == (name not in ("ANSI 25", "ANSI 35"))


@pytest.mark.parametrize("name", SIZES)
def test_a_chain_weighs_what_its_maker_says_and_its_parts_nearly_do(name):
    size, chain = SIZES[name], rc.catalogue_chain(name, links=20)
    per_length = (chain.inner.mass + chain.outer.mass) / (2 * chain.pitch)
    assert per_length == pytest.approx(size.mass_per_length, rel=1e-14)
    # Bars without a waist, largest plates: the parts of steel are up to a third too heavy.
    assert 0.7 < size.mass_scale < 1.05
    parts = size.parts
    assert all(part.mass > 0.0 < part.inertia for part in parts.values() if part != (0.0, 0.0))
    assert (parts["rollers"] == (0.0, 0.0)) == (not size.has_rollers)
    assert sum(part.mass for part in parts.values()) * size.mass_scale == pytest.approx(
        2 * size.pitch * size.mass_per_length
    )
    for link, kinds in zip(
        size.links(),
        (("inner plates", "bushings", "rollers"), ("outer plates", "pins")),
        strict=True,
    ):
        whole = np.sum([parts[kind] for kind in kinds], axis=0)
        assert link == pytest.approx(size.mass_scale * whole, rel=1e-13)


def test_moments_of_inertia_are_those_of_the_shapes():
    """Integrated over a grid of the plate's area and by parallel axes for the cylinders."""
    size = SIZES["ISO 08B"]
    p, h, t = size.pitch, size.inner_plate_height, size.inner_plate_thickness
    x, y = np.meshgrid(np.linspace(-p, p, 2001), np.linspace(-h / 2, h / 2, 1001))
    cell = (x[0, 1] - x[0, 0]) * (y[1, 0] - y[0, 0])
    beyond = np.maximum(np.abs(x) - p / 2, 0.0)
    inside = beyond**2 + y**2 <= (h / 2) ** 2
    mass = 7850 * 2 * t * cell * inside.sum()
    inertia = 7850 * 2 * t * cell * (inside * (x**2 + y**2)).sum()
    # Bushings fill the holes, but for their bores.
    bore = size.bore_diameter / 2
    bores = 7850 * 2 * np.pi * bore**2 * 2 * t
    mass, inertia = mass - bores, inertia - bores * (bore**2 / 2 + (p / 2) ** 2)
    plates = size.parts["inner plates"]
    assert plates.mass == pytest.approx(mass, rel=3e-3)
    assert plates.inertia == pytest.approx(inertia, rel=3e-3)
    pins = size.parts["pins"]
    length = size.inner_width + 2 * t + size.outer_plate_thickness
    radius = size.pin_diameter / 2
    assert pins.mass == pytest.approx(7850 * 2 * np.pi * radius**2 * length)
    assert pins.inertia == pytest.approx(pins.mass * (radius**2 / 2 + (p / 2) ** 2))


def test_numbers_of_the_standards_are_as_printed():
    forty, eight = SIZES["ANSI 40"], SIZES["ISO 08B"]
    assert (forty.pitch, forty.roller_diameter) == pytest.approx((INCH / 2, 5 / 16 * INCH))
    assert forty.strength == pytest.approx(13_900, rel=1e-3)
    assert (forty.bore_diameter - forty.pin_diameter) / 2 == pytest.approx(12.7e-6)
    assert (eight.pitch, eight.roller_diameter, eight.inner_width) == (0.0127, 0.00851, 0.00775)
    assert SIZES["ANSI 240"].mass_per_length == pytest.approx(25.15, abs=0.01)


def test_a_chain_is_found_by_its_number_and_refused_with_the_nearest_name():
    assert rc.catalogue_chain("08b", 60).name == "ISO 08B"
    assert rc.catalogue_chain("41", 60).name == "ANSI 41"
    for name, nearest in (
        ("ISO 8B", "ISO 08B"),
        ("80H", "ANSI 80"),
        ("ANSI 80H", "ANSI 80"),
        ("80H-2", "ANSI 80"),
        ("RS-40", "ANSI 40"),
        ("ANSI 4O", "ANSI 4"),
    ):
        with pytest.raises(rc.InvalidInput, match=f"did you mean '{nearest}"):
            rc.catalogue_chain(name, 60)
    for name in ("", " ", "-", "chain", "4 0", "40-4", "x" * 5000):
        with pytest.raises(rc.InvalidInput, match="is not in the catalogue; ") as caught:
            rc.catalogue_chain(name, 60)
        assert len(str(caught.value)) <= 400


@pytest.mark.parametrize(
    ("name", "listed", "strands"),
    [
        ("#40", "ANSI 40", 1),
        ("RS40", "ANSI 40", 1),
        ("RS 40", "ANSI 40", 1),
        ("# 40", "ANSI 40", 1),
        ("ANSI40", "ANSI 40", 1),
        ("ansi 40-2", "ANSI 40", 2),
        ("ISO08B", "ISO 08B", 1),
        ("ISO08A-2", "ANSI 40", 2),
        ("rs60-2", "ANSI 60", 2),
        ("40-3", "ANSI 40", 3),
        ("ISO 08A", "ANSI 40", 1),
        ("48a-2", "ANSI 240", 2),
        ("04C", "ANSI 25", 1),
        ("06C", "ANSI 35", 1),
        ("ISO 085", "ANSI 41", 1),
        ("08B-1", "ISO 08B", 1),
        ("iso 32B-3", "ISO 32B", 3),
    ],
)
def test_a_chain_is_found_by_the_names_of_makers_and_of_both_standards(name, listed, strands):
    assert rc.catalogue_chain(name, 60) == rc.catalogue_chain(listed, 60, strands=strands)


def test_the_sizes_of_the_a_series_have_the_pitch_that_their_name_says():
    for number in (8, 10, 12, 16, 20, 24, 28, 32, 36, 40, 48):
        found = rc.catalogue_chain(f"ISO {number:02d}A", 60)
        assert found.pitch == pytest.approx(number * INCH / 16, rel=1e-12)
        assert found.name.startswith("ANSI")


def test_the_name_of_a_drive_of_two_sprockets_has_the_strands():
    drives = [rc.two_sprocket_drive(chain, (19, 38), links=100) for chain in ("08B-1", "08B-2")]
    assert [drive.name for drive in drives] == ["ISO 08B, 19:38", "ISO 08B-2, 19:38"]


def test_strands_that_the_name_does_not_say_are_refused():
    assert rc.catalogue_chain("08B-2", 60, strands=2).strands == 2
    with pytest.raises(rc.InvalidInput, match="strands = 3: the name '08B-2' says 2"):
        rc.catalogue_chain("08B-2", 60, strands=3)
    remedy = r"Strands above 3: catalogue_chain\('ISO 08B', links, strands=4\)"
    with pytest.raises(rc.InvalidInput, match=f"'08B-4' is not in the catalogue; .*{remedy}"):
        rc.catalogue_chain("08B-4", 60)
    for name in ("08B-0", "08B-04", "08B-25", "08B-٤"):  # no number of strands
        with pytest.raises(rc.InvalidInput, match=r"did you mean '[^']*'\?$"):
            rc.catalogue_chain(name, 60)


def test_an_iso_chain_gets_iso_teeth():
    drive = rc.two_sprocket_drive(chain="ISO 08B", teeth=(17, 25), links=60)
    assert all(sprocket.profile == rc.IsoTooth() for sprocket in drive.sprockets)
    assert drive.check().links == 60


def test_a_changed_iso_chain_keeps_iso_teeth():
    chain = rc.catalogue_chain("ISO 08B", 60)
    for given in (chain, replace(chain, elongation=0.002)):
        drive = rc.two_sprocket_drive(given, (17, 25), seat="pitch-circle")
        assert [s.profile for s in drive.sprockets] == [rc.IsoTooth(seat="pitch-circle")] * 2
    for other in (rc.catalogue_chain("ANSI 40", 60), replace(chain, name="own")):
        drive = rc.two_sprocket_drive(other, (17, 25))
        assert [s.profile for s in drive.sprockets] == [rc.AnsiTooth()] * 2


def test_a_seat_beside_a_tooth_form_is_refused():
    with pytest.raises(rc.InvalidInput, match=r"^seat = 'pitch-circle': must be left out beside"):
        rc.two_sprocket_drive(links=60, seat="pitch-circle", profile=rc.AnsiTooth())


def test_the_command_lists_all_and_shows_one():
    listed = rustchain("catalogue")
    assert listed.exit_code == 0
    assert all(name in listed.output for name in SIZES)
    one = rustchain("catalogue", "16B")
    assert "ISO 16B (ISO 606)" in one.output
    assert "strength" in one.output
    assert "makers" in one.output
    wrong = rustchain("catalogue", "17C")
    assert wrong.exit_code == 1
    assert "not in the catalogue" in wrong.output
