"""Figures of single contacts: which are drawn, by which names, and with which curves."""

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest

import rustchain as rc

ALL = ("hinges", "teeth", "sprockets")
RESULT = rc.Simulation(rc.paper_drive(25.0)).run(0.05, record=ALL, progress=False)
ALONE = {name: RESULT.arrays[name] for name in RESULT.arrays if not name.startswith("peak_")}


@pytest.fixture(scope="module")
def guided():
    """Return a result with a bushing on guide 1 of a drive with two sprockets."""
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=60, speed=25.0)
    rail = rc.GuideRail(center=(0.136, 0.0251), direction=(0.0, 1.0), length=0.1)
    drive = replace(drive, guides=[rail])  # it carries the upper strand, which sags
    return rc.Simulation(drive, start="static").run(2e-3, record=ALL, progress=False)


def titles(figure):
    return [axes.get_title("left") for axes in figure.axes if axes.get_title("left")]


@pytest.mark.parametrize(
    ("draw", "part", "options"),
    [
        ("tooth_force", "tooth", {}),
        ("hinge_force", "hinge", {}),
        ("orbit", "hinge", {}),
        ("force_penetration", "tooth", {}),
        ("force_penetration", "hinge", {"contact": "hinge"}),
    ],
)
def test_the_most_loaded_contacts_are_those_with_the_largest_force_between_rows(
    draw, part, options
):
    at_rows = RESULT.array(f"{part}_force").max(axis=0)
    peaks = RESULT.array(f"peak_{part}_force").max(axis=0)
    numbers, at_row = (set(np.argsort(largest)[-2:] + 1) for largest in (peaks, at_rows))
    assert numbers != at_row
    figure = getattr(RESULT.plot, draw)(**options)
    assert {int(each.split()[1]) for each in titles(figure)} == numbers
    without = replace(RESULT, arrays=ALONE)  # such as a file of an old version
    figure = getattr(without.plot, draw)(**options)
    assert {int(each.split()[1]) for each in titles(figure)} == at_row


@pytest.mark.parametrize("part", ["hinge", "tooth"])
@pytest.mark.parametrize("whole", [True, False])
def test_the_largest_force_between_rows_is_drawn(part, whole):
    above = RESULT.array(f"peak_{part}_force")[:, 19] - RESULT.array(f"{part}_force")[:, 19]
    assert above.max() > 1.0  # [N]
    start = None if whole else RESULT.time[above.argmax()]
    rows = RESULT.time >= (start or 0.0)
    figure = getattr(RESULT.plot, f"{part}_force")(20, start=start)
    (line,) = (each for each in figure.axes[0].get_lines() if each.get_label() == "largest")
    expected = RESULT.array(f"peak_{part}_force")[rows, 19].copy()
    expected[0] = RESULT.array(f"{part}_force")[rows, 19][0]  # the peak there is of before
    np.testing.assert_array_equal(line.get_ydata(), expected)
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    assert "largest" in [text.get_text() for each in legends if each for text in each.get_texts()]


def test_the_name_of_a_tooth_is_at_the_largest_force():
    largest = RESULT.array("peak_tooth_force")
    bushing = int(np.argmax(largest.max(axis=0)))
    axes = RESULT.plot.tooth_force(bushing + 1).axes[0]
    row = np.argmax(largest[:, bushing])
    places = [text.xy for text in axes.texts]
    assert (RESULT.time[row], largest[row, bushing]) in places


def test_a_guide_has_its_own_name_and_no_tooth(guided):
    wheel = guided.array("tooth_sprocket")  # guides follow the two sprockets
    number = int(np.argmax((wheel == 3).any(axis=0) & ~np.isin(wheel, (1, 2)).any(axis=0))) + 1
    assert (wheel[:, number - 1] == 3).any()
    axes = guided.plot.tooth_force(number).axes[0]
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "guide 1" in names
    assert "sprocket 3" not in names
    assert not axes.texts


@pytest.mark.parametrize("ends", [False, True])
def test_the_curve_of_a_hinge_includes_the_extension_of_elastic_plates(ends):
    """Undamped, points lie on the law in series with the plates; at an end with half of them."""
    law = rc.Johnson()
    if ends:
        both = rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(20.0)
        drive = rc.open_chain("ANSI 40", both, links=12, plates="elastic")
    else:
        drive = rc.two_sprocket_drive(
            "ANSI 40", (17, 17), links=38, speed=25.0, pretension=200.0, plates="elastic"
        )
    simulation = rc.Simulation(drive, law, start="static")
    result = simulation.run(1e-3, report_step=2e-5, record=("hinges",), progress=False)
    numbers = (6, drive.chain.links, drive.hinge_count) if ends else (6, 11)
    for axes in result.plot.force_penetration(*numbers, contact="hinge").axes:
        dots, line = axes.get_lines()
        assert dots.get_xdata().size > 5
        expected = np.interp(dots.get_xdata(), *line.get_data())
        np.testing.assert_allclose(dots.get_ydata(), expected, rtol=1e-3)
        assert line.get_label() == "johnson, elastic part + F/k of links"


@pytest.mark.parametrize(
    ("draw", "options"), [("orbit", {}), ("force_penetration", {"contact": "hinge"})]
)
def test_ideal_hinges_have_neither_orbit_nor_penetration(draw, options):
    drive = rc.paper_drive(25.0, hinges="ideal")
    result = rc.Simulation(drive).run(1e-3, record=ALL, progress=False)
    with pytest.raises(rc.InvalidInput, match=r"hinges = 'ideal'.*joint_loads.*'clearance'"):
        getattr(result.plot, draw)(6, **options)


@pytest.mark.parametrize(("hinges", "start"), [((6, 11, 12), None), ((6, 11), 0.03)])
def test_titles_and_labels_of_orbits_are_inside_the_figure(hinges, start):
    figure = RESULT.plot.orbit(*hinges, start=start, end=0.05 if start is None else start)
    figure.savefig(BytesIO(), format="png")
    drawn, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    assert 0.0 < drawn.x0 < drawn.x1 < width
    assert 0.0 < drawn.y0 < drawn.y1 < height


def test_a_pin_at_rest_in_its_bushing_is_a_marker_in_the_colour_of_its_force():
    ends = rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(2.0)
    scene = rc.Scene(rc.open_chain("ANSI 40", ends, links=10), start="static")
    result = rc.Simulation(scene).run(1e-3, record=("hinges",), progress=False)
    upper, lower, _ = result.plot.orbit(1, 9).axes
    for axes, number in ((upper, 1), (lower, 9)):
        (dot,) = axes.get_lines()
        np.testing.assert_array_equal(
            np.ravel(dot.get_data()), 1e6 * result.hinge(number).eccentricity[-1]
        )
    assert upper.get_lines()[0].get_color() != lower.get_lines()[0].get_color()
