"""Numbers that the catalogue derives, worked out by hand in the units of the standards."""

import copy
import dataclasses
import math

import pytest

import rustchain as rc
from rustchain.catalogue.sizes import _iso, _other_names, _sizes

INCH = 25.4  # [mm]
POUND_FORCE = 4.4482216152605  # [N]


def made(name):
    """Return a size from the file, made again as at the import, and its lengths in mm."""
    (size,) = (size for size in _sizes() if size.name == name)
    lengths = {
        field.name: 1e3 * getattr(size, field.name)
        for field in dataclasses.fields(size)
        if field.name not in ("name", "standard", "sources", "mass_per_length", "strength")
    }
    return size, lengths


def test_an_ansi_chain_with_rollers_has_the_numbers_of_b29_1():
    """No. 40: half-inch pitch, 5/16 in rollers, 0.156 in pins, 0.060 in plates, 3125 lbf."""
    size, found = made("ANSI 40")
    assert found == pytest.approx(
        {
            "pitch": 12.7,
            "roller_diameter": 0.3125 * INCH,
            "inner_width": 0.3125 * INCH,
            "pin_diameter": 0.1565 * INCH,
            "bore_diameter": 0.1575 * INCH,
            "bushing_diameter": 5.5959375,  # 0.705 of 7.9375 mm
            "inner_plate_height": 12.065,  # 95 % of the pitch
            "outer_plate_height": 10.414,  # 82 % of the pitch
            "inner_plate_thickness": 1.524,
            "outer_plate_thickness": 1.524,
            "tooth_width": (0.93 * 0.3125 - 0.006) * INCH,
        },
        rel=1e-12,
    )
    assert size.mass_per_length == pytest.approx(0.41 * 0.45359237 / 0.3048)
    assert size.strength == pytest.approx(3125 * POUND_FORCE)
    assert size.sources["bushing_diameter"] == "derived"
    assert size.sources["roller_diameter"] == "standard"


def test_an_ansi_chain_without_rollers_seats_on_its_bushings():
    size, found = made("ANSI 25")
    assert found["bushing_diameter"] == found["roller_diameter"] == pytest.approx(0.130 * INCH)
    assert size.sources["roller_diameter"] == "standard, bushing"
    assert size.sources["bushing_diameter"] == "standard"
    assert size.sources["pitch"] == "standard"


@pytest.mark.parametrize(
    ("name", "row", "tooth_width", "strength", "mass"),
    [
        ("08B", (12.7, 8.51, 7.75, 4.45, 11.8, 11.8, 1.6, 1.6), 0.93 * 7.75, 17.8, 0.70),
        ("10B", (15.875, 10.16, 9.65, 5.08, 14.7, 14.7, 1.7, 1.7), 0.95 * 9.65, 22.2, 0.92),
        ("16B", (25.4, 15.88, 17.02, 8.28, 21.1, 21.1, 4.15, 3.1), 0.95 * 17.02, 60.0, 2.70),
    ],
)
def test_an_iso_chain_has_the_numbers_of_iso_606(name, row, tooth_width, strength, mass):
    """Teeth are 0.93 of the inner width up to 12.7 mm pitch, then 0.95 of it."""
    size, found = made(f"ISO {name}")
    names = (
        "pitch",
        "roller_diameter",
        "inner_width",
        "pin_diameter",
        "inner_plate_height",
        "outer_plate_height",
        "inner_plate_thickness",
        "outer_plate_thickness",
    )
    assert tuple(found[name] for name in names) == pytest.approx(row)
    assert found["bore_diameter"] == pytest.approx(row[3] + 0.05)
    assert found["bushing_diameter"] == pytest.approx(0.705 * row[1])
    assert found["tooth_width"] == pytest.approx(tooth_width)
    assert size.strength == pytest.approx(1e3 * strength)
    assert size.mass_per_length == mass
    assert size.sources["pitch"] == "standard"


def test_an_iso_row_has_the_inner_plate_before_the_outer_one():
    """The heights of both plates agree in the file, not in this row."""
    table = {"standard": "ISO 606", "sources": {}, "confirmed": {}}
    made = _iso("08B", [12.7, 8.51, 7.75, 4.45, 11.81, 10.92, 1.6, 1.5, 17.8, 0.7], table)
    assert made.inner_plate_height == pytest.approx(11.81e-3)
    assert made.outer_plate_height == pytest.approx(10.92e-3)
    assert made.inner_plate_thickness == pytest.approx(1.6e-3)
    assert made.outer_plate_thickness == pytest.approx(1.5e-3)


def test_the_file_gives_the_catalogue():
    assert {size.name: size for size in _sizes()} == rc.chain_sizes()


def test_a_roller_is_a_hollow_cylinder_of_the_scaled_mass():
    """ISO 16B: 15.88 mm outside, its bore 0.1 mm over the bushing, 17.02 mm wide."""
    size = rc.chain_sizes()["ISO 16B"]
    outside, bore, width = 15.88e-3, 0.705 * 15.88e-3 + 0.1e-3, 17.02e-3
    assert size.roller_bore_diameter == pytest.approx(bore)
    mass = size.mass_scale * 7850.0 * math.pi / 4 * (outside**2 - bore**2) * width
    assert size.roller().mass == pytest.approx(mass)
    # About its own axis: m (R^2 + r^2) / 2.
    expected = mass * ((outside / 2) ** 2 + (bore / 2) ** 2) / 2
    assert size.roller().inertia == pytest.approx(expected)


def test_sections_are_those_of_two_plates():
    inner, outer = rc.chain_sizes()["ISO 16B"].plate_sections
    assert inner == pytest.approx(2 * 21.1e-3 * 4.15e-3)
    assert outer == pytest.approx(2 * 21.1e-3 * 3.1e-3)


def test_the_table_of_a_size_has_each_number_in_its_unit():
    lines = str(rc.chain_sizes()["ANSI 40"]).splitlines()
    assert lines[0] == "ANSI 40 (ANSI/ASME B29.1), simplex"
    table = {line[2:24].strip(): line[24:].split() for line in lines[1:]}
    assert table["pitch"] == ["12.700", "mm", "standard"]
    assert table["mass per length"] == ["0.610", "kg/m", "makers"]
    assert table["strength"] == ["13.901", "kN", "standard"]
    assert table["strength, 2 strands"] == ["27.801", "kN", "derived"]
    assert table["inner link"][:2] == ["8.894", "g,"]
    assert table["inner plates, both"] == ["36.774", "mm^2", "derived"]
    assert table["outer plates, both"] == ["31.742", "mm^2", "derived"]
    assert table["roller bore diameter"] == ["5.696", "mm", "derived"]
    assert "standard" not in table  # no number, but the name of the table's source
    assert "strength, 2 strands       31.100 kN    typical" in str(rc.chain_sizes()["ISO 08B"])
    assert "2 strands" not in str(rc.chain_sizes()["ISO 32B"])  # not known


@pytest.mark.parametrize("strands", [-1, 0, 2.5, "2", True, None])
def test_a_breaking_load_of_no_number_of_strands_is_refused(strands):
    for name in ("ANSI 40", "ISO 08B"):
        with pytest.raises(rc.InvalidInput, match="strands"):
            rc.chain_sizes()[name].breaking_load(strands)


def test_names_of_both_standards_and_of_makers_are_those_of_a_size():
    assert set(_other_names("ANSI 80")) == {
        "ansi80", "80", "#80", "rs80", "iso16a", "16a",
    }  # fmt: skip
    assert set(_other_names("ANSI 41")) == {
        "ansi41", "41", "#41", "rs41", "iso085", "085",
    }  # fmt: skip
    assert set(_other_names("ISO 08B")) == {"iso08b", "08b"}


def test_sizes_are_keys_of_dicts_and_equal_by_value():
    size = rc.chain_sizes()["ANSI 40"]
    assert {size: 1}[copy.deepcopy(size)] == 1
    assert size != rc.chain_sizes()["ANSI 50"]


def test_a_size_is_one_line_in_a_list():
    text = repr(rc.chain_sizes()["ISO 08B"])
    assert text == "<ChainSize ISO 08B: pitch 12.7 mm, 0.7 kg/m, strength 17.8 kN>"
