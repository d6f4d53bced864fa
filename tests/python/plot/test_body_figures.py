"""Figures of bodies and residuals: what is drawn by default, legends, ticks and scales."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure

import rustchain as rc

RESULT = rc.Simulation(rc.paper_drive(25.0)).run(
    0.02, record=("hinges", "teeth", "bodies"), progress=False
)


def slider_crank():
    """Return a mechanism with joints only."""
    m = rc.Mechanism(gravity=(0.0, -9.81))
    m.add_body("crank", mass=0.3, inertia=6e-5, position=(0.025, 0.0, 0.0))
    m.add_body("rod", mass=0.21, inertia=2.5e-4, position=(0.11, 0.0, 0.0))
    m.add_body("slider", mass=0.14, inertia=1e-4, position=(0.17, 0.0, 0.0))
    m.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    m.add_revolute("crank pin", "crank", "rod", at=(0.05, 0.0))
    m.add_revolute("wrist pin", "rod", "slider", at=(0.17, 0.0))
    m.add_prismatic("guide", "ground", "slider", direction=(1.0, 0.0))
    m.add_driver("motor", "ground", "crank", speed=52.36)
    return m


def names_in(figure):
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    return [text.get_text() for each in legends if each for text in each.get_texts()]


def test_bodies_and_joints_have_their_own_numbers_and_units():
    result = rc.Simulation(slider_crank()).run(0.02, progress=False)
    for quantity, way, turn in (
        ("position", "x [m]", "angle [rad]"),
        ("velocity", "velocity, x [m/s]", "velocity, angle [rad/s]"),
        ("acceleration", "acceleration, x [m/s²]", "acceleration, angle [rad/s²]"),
    ):
        axes = result.plot.motion("rod", quantity=quantity).axes
        assert (axes[0].get_ylabel(), axes[2].get_ylabel()) == (way, turn)
        drawn = [each.lines[0].get_ydata() for each in axes]
        np.testing.assert_array_equal(drawn, getattr(result.body("rod"), quantity).T)
    path, end = result.plot.paths("crank").axes[0].lines
    np.testing.assert_array_equal(path.get_xydata(), result.body("crank").position[:, :2])
    # The crank of 52.36 rad/s has turned by a sixth of a revolution: 60 degrees.
    np.testing.assert_allclose(end.get_xydata()[0], [0.0125, 0.025 * np.sqrt(0.75)], atol=1e-6)
    upper, lower = result.plot.joint_loads("wrist pin", "motor").axes
    force = result.array("joint_reaction")[:, 2, :2]  # of the third joint
    size = np.sqrt(force[:, 0] ** 2 + force[:, 1] ** 2)
    np.testing.assert_allclose(upper.lines[0].get_ydata(), size, rtol=1e-12)
    np.testing.assert_array_equal(lower.lines[1].get_ydata(), result.joint("motor").torque)
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("force [N]", "torque [N m]")
    lines = result.plot.residuals().axes[0].lines
    for line, rate in zip(lines, ("position", "velocity"), strict=True):
        worst = np.max(result.array(f"joint_{rate}_residual"), axis=1)
        np.testing.assert_array_equal(line.get_ydata(), np.maximum(worst, 1e-20))


@pytest.mark.parametrize("draw", ["motion", "paths"])
def test_of_a_drive_sprockets_and_one_link_are_drawn_by_default(draw):
    figure = getattr(RESULT.plot, draw)()
    assert names_in(figure) == ["link_1", "sprocket_1", "sprocket_2"]
    figure = getattr(RESULT.plot, draw)(RESULT.body_names)  # all where they are named
    curves = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 1]
    assert len(curves) == len(RESULT.body_names)


@pytest.mark.parametrize("draw", ["motion", "paths"])
@pytest.mark.parametrize("count", [3, 12, 13, 38])
def test_legends_lie_within_the_figure_and_cover_no_axes(draw, count):
    """Warnings of matplotlib are errors here."""
    names = [f"link_{k + 1}" for k in range(count)]
    figure = getattr(RESULT.plot, draw)(names)
    figure.draw_without_rendering()
    assert names_in(figure) == (names if count <= 12 else [])
    for legend in figure.legends:
        box = legend.get_window_extent()
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
        assert not any(box.overlaps(axes.get_window_extent()) for axes in figure.axes)
    assert all(axes.bbox.height > 0.2 * figure.bbox.height for axes in figure.axes)


def test_names_beside_given_axes_are_theirs():
    figure = Figure()
    axes = figure.subplots()
    RESULT.plot.paths("link_1", "link_2", ax=axes)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["link_1", "link_2"]
    assert not figure.legends


@pytest.mark.parametrize("draw", ["motion", "paths", "joint_loads"])
def test_long_names_are_shortened_in_legends(draw):
    m = rc.Mechanism(gravity=(0.0, -9.81))
    for k in range(12):
        name, place = f"part {k} " + 150 * "x", (0.1 * k, 0.0, 0.0)
        m.add_body(name, mass=1.0, inertia=1e-3, position=place)
        m.add_revolute(name, "ground", name, at=(0.1 * k, 0.1))
    figure = getattr(rc.Simulation(m).run(0.01, progress=False).plot, draw)()
    figure.draw_without_rendering()
    assert len(names_in(figure)) == 12
    assert all(len(name) == 30 for name in names_in(figure))


@pytest.mark.parametrize(
    "draw",
    [
        lambda plot: plot.tooth_force(6, 11, 20, end=0.005),
        lambda plot: plot.hinge_force(6, 11, 20, end=0.02),
        lambda plot: plot.paths("link_1", end=0.002),
    ],
    ids=["tooth_force", "hinge_force", "paths"],
)
def test_labels_of_ticks_do_not_overlap(draw):
    figure = draw(RESULT.plot)
    figure.draw_without_rendering()
    for axes in figure.axes:
        low, high = axes.get_xlim()
        ticks = [each for each in axes.xaxis.get_major_ticks() if low <= each.get_loc() <= high]
        assert 3 <= len(ticks) <= 5
        boxes = [each.label1.get_window_extent() for each in ticks]
        assert all(one.x1 < other.x0 for one, other in pairwise(boxes))


def test_ticks_of_given_axes_stay():
    axes = Figure().subplots()
    axes.set_xticks(np.linspace(0.0, 0.02, 9))
    RESULT.plot.hinge_force(6, ax=axes)
    assert len(axes.get_xticks()) == 9


@pytest.mark.parametrize("zeros", ["some", "all"])
def test_residuals_of_zero_do_not_stretch_the_axis(zeros):
    result = rc.Simulation(slider_crank()).run(0.02, progress=False)
    names = ("joint_position_residual", "joint_velocity_residual")
    arrays = {name: result.array(name).copy() for name in names}
    for values in arrays.values():
        values[: 5 if zeros == "some" else None] = 0.0
    axes = replace(result, arrays=result.arrays | arrays).plot.residuals().axes[0]
    low, high = axes.get_ylim()
    largest = max(values.max() for values in arrays.values())
    assert 1e-22 < low <= 1e-20
    assert high <= 1e3 * max(largest, 1e-20)


def test_names_are_shown_as_they_are():
    mechanism = rc.Mechanism()
    mechanism.add_body("_arm $x$", 1.0, 0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("$a_b^{$", "ground", "_arm $x$", at=(0.0, 0.0))
    result = rc.Simulation(mechanism).run(2e-3, progress=False)
    for figure, name in (
        (result.plot.motion(), "_arm $x$"),
        (result.plot.paths(), "_arm $x$"),
        (result.plot.joint_loads(), "$a_b^{$"),
    ):
        figure.canvas.draw()
        (legend,) = figure.legends
        (text,) = legend.get_texts()
        assert text.get_text().replace("\\", "").strip() == name


def test_a_contact_force_of_a_part_has_no_peak_from_before_it():
    m = rc.Mechanism(gravity=(0.0, 0.0))
    m.add_body("ball", 0.01, 1e-6, (0.02 + 1e-6, 0.0, 0.0), (-0.5, 0.0, 0.0))
    surfaces = rc.SurfaceContact(rc.LankaraniNikravesh(), material=rc.Material(restitution=0.7))
    m.add_disc_contact("stop", "ground", "ball", 0.01, 0.01, surfaces)
    result = rc.Simulation(m).run(5e-4, report_step=5e-5, progress=False)
    view = result.contact("stop")
    row = int(np.argmax(view.peak_force))
    assert view.peak_force[row] > 2.0 * view.force[row]
    (dots,) = result.plot.force_penetration("stop").axes[0].lines
    touching = view.force > 0.0
    np.testing.assert_allclose(dots.get_xdata(), 1e6 * view.penetration[touching])
    np.testing.assert_array_equal(dots.get_ydata(), view.force[touching])
    figure = result.plot.contact_force("stop", start=result.time[row])
    largest = figure.axes[0].lines[0].get_ydata()
    assert largest[0] == view.force[row]
    np.testing.assert_array_equal(largest[1:], view.peak_force[row + 1 :])
