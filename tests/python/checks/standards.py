"""Numbers of standards: tooth profiles, tooth forms, rainflow counting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import rustchain as rc
from checks.check import Check
from reference import teeth as outline
from reference.tooth_cases import CHAIN, EDGE, RADIUS, cases, near_the_surface
from rustchain import _rustchain
from rustchain.analysis import rainflow

INCH = 0.0254
HERE = "python/validation/test_checks.py"


def makers_sheet():
    """Return the checks of a tooth of one inch pitch and 28 teeth beside a maker's sheet.

    The sheet is printed to four places: half a unit of the fourth and a little.
    """
    chain = replace(rc.catalogue_chain("ANSI 80", 40), bushing_radius=0.3125 * INCH)
    radii = _rustchain.tooth_radii(rc.Sprocket(28), chain)
    test = "geometry/tooth_profile.rs::a_maker_s_sheet_has_the_same_numbers"
    return [
        Check(
            f"ANSI/ASME B29.1, 1 in, 28 teeth: {name}", abs(found) / INCH, given, 0.6e-4, test, "in"
        )
        for name, found, given in (
            ("seating radius R", radii[0], 0.3156),
            ("working radius E", radii[1], 0.8156),
            ("topping radius F", radii[3], 0.5114),
        )
    ]


def tooth_dimensions():
    """Return the checks of radii and diameters of 17 teeth of 12.7 mm pitch, both standards, in mm.

    The numbers are printed to 1e-4 or 1e-6 mm.
    """
    test = f"{HERE}::test_teeth_have_the_dimensions_of_the_standards"
    paper = rc.paper_drive().chain
    ansi = rc.Sprocket(17)
    iso_chain = replace(paper, bushing_radius=3.96e-3)
    radii = _rustchain.tooth_radii(ansi, paper)
    shape = _rustchain.tooth_outline(ansi, paper, 1000)
    rows = [
        ("ANSI, seating radius R", radii[0], 4.026694, 1e-6),
        ("ANSI, working radius E", radii[1], 10.376694, 1e-6),
        ("ANSI, topping radius F", radii[3], 6.582621, 1e-6),
        ("ANSI, bottom diameter", 2 * np.hypot(*shape.T).min(), 61.178328, 1e-5),
        ("ANSI, outside diameter", 2 * np.hypot(*shape.T).max(), 75.558999, 1e-5),
    ]
    for name, gap, seat, flank in (
        ("smallest gap", "minimum", 3.9996, 18.0576),
        ("largest gap", "maximum", 4.13714, 29.71584),
    ):
        found = _rustchain.tooth_radii(rc.Sprocket(17, profile=rc.IsoTooth(gap)), iso_chain)
        rows.append((f"ISO 606, {name}, seat radius", found[0], seat, 1e-5))
        rows.append((f"ISO 606, {name}, flank radius", found[1], flank, 1e-5))
    return [
        Check(name, 1e3 * abs(found), given, bound, test, "mm")
        for name, found, given, bound in rows
    ]


def tooth_forms():
    """Return the checks of penetrations into teeth beside distances from their outlines, in nm."""
    test = "python/catalogue/test_tooth_forms.py::test_each_form_is_as_deep_as_the_outline_is_near"
    checks = []
    for teeth, profile, flank, outside in cases():
        if teeth != 17:
            continue
        whole = outline.cut(flank, teeth, outside, EDGE)
        rng = np.random.default_rng(teeth)
        places, expected = near_the_surface({-1: whole}, teeth, (-1e-3, 1e-4), rng)
        points = np.stack([places.real, places.imag], axis=1)
        sprocket = rc.Sprocket(teeth, profile=profile)
        _, depth, _ = _rustchain.tooth_contacts(sprocket, CHAIN, points, RADIUS)
        # Coordinates of the sprocket's size go through some ten roundings on either side.
        bound = 40 * np.finfo(float).eps * float(np.max(np.abs(places)))
        checks.append(
            Check(
                f"{profile!r}: penetration of one of {len(places)} circles; largest error",
                *(1e9 * depth[0], 1e9 * expected[0], 1e9 * bound, test, "nm"),
                error=1e9 * float(np.max(np.abs(depth - expected))),
            )
        )
    return checks


def counting():
    """Return the checks of the cycles of ASTM E1049-85, Figure 6, the history A to I."""
    test = "python/analysis/test_outputs.py::test_rainflow_counts_the_example_of_the_standard"
    history = np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])
    ranges, cycles = rainflow.count(history)
    return [
        Check(
            f"ASTM E1049-85, range of {given:g}: cycles",
            *(float(cycles[ranges == given].sum()), expected, 0.0, test),
        )
        for given, expected in ((3.0, 0.5), (4.0, 1.5), (6.0, 0.5), (8.0, 1.0), (9.0, 0.5))
    ]
