"""Waterfalls, maps, orbits and polar loads show the numbers that they are given."""

import re

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import rustchain as rc
from rustchain.arguments import shown
from rustchain.plot import Plots, draw_loss_map, draw_map, draw_waterfall
from rustchain.plot.colors import CYCLE
from rustchain.plot.studies import draw_study, draw_sweep
from rustchain.sweeps.result import SweepResult
from rustchain.sweeps.study import StudyResult

RESULT = rc.Simulation(rc.paper_drive(25.0)).run(
    duration=0.05, record=("hinges", "teeth", "sprockets"), progress=False
)


class FakeResult:
    """A result whose transmission error has one order, over another number of revolutions."""

    def __init__(self, order, revolutions):
        orders = np.arange(0.0, 200.0, 1.0 / revolutions)
        amplitude = np.where(np.abs(orders - order) < 0.6 / revolutions, 2e-4, 1e-9)
        self.found = xr.Dataset(
            {"amplitude": ("order", amplitude)},
            {"order": orders},
            {"peak_to_peak": 4e-4, "peak_to_peak_length": 4e-4 * 0.03, "tooth_order": 17},
        )

    def transmission_error(self, sprocket, *, start):
        return self.found


def waterfall(cases, values):
    axes = {"speed": tuple(case["speed"] for case in cases)}
    return SweepResult(cases, axes, values, _measured=False)


def test_a_waterfall_has_each_order_at_its_place_whatever_the_number_of_revolutions():
    cases = [{"speed": speed} for speed in (30.0, 10.0, 20.0)]
    sweep = waterfall(cases, [FakeResult(51.0, 3.0), FakeResult(17.0, 1.7), FakeResult(34.0, 9.3)])
    figure = draw_waterfall(sweep)
    (mesh,) = figure.axes[0].collections
    values = mesh.get_array().reshape(3, -1)
    orders = 0.25 + 0.5 * np.arange(values.shape[1])
    found = orders[values.argmax(axis=1)]
    np.testing.assert_allclose(found, [17.0, 34.0, 51.0], atol=0.75)  # by speed
    np.testing.assert_allclose(values.max(axis=1), 1e6 * 2e-4 * 0.03)  # µm
    assert figure.axes[0].get_ylabel() == "speed [rad/s]"
    assert figure.axes[1].get_ylabel() == "amplitude [µm]"


def test_a_waterfall_over_numbers_of_teeth_has_the_orders_of_all_and_no_line():
    cases = [{"speed": float(teeth)} for teeth in (17, 19)]
    found = [FakeResult(17.0, 2.0), FakeResult(19.0, 2.0)]
    assert len(draw_waterfall(waterfall(cases, found)).axes[0].lines) == 4
    found[1].found.attrs["tooth_order"] = 19
    axes = draw_waterfall(waterfall(cases, found)).axes[0]
    values = axes.collections[0].get_array().reshape(2, -1)
    assert values.shape[1] == round(2 * 4.5 * 19)
    orders = 0.25 + 0.5 * np.arange(values.shape[1])
    np.testing.assert_allclose(orders[values.argmax(axis=1)], [17.0, 19.0], atol=0.75)
    assert len(axes.lines) == 0


def test_a_waterfall_of_a_real_sweep_is_drawn():
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=38, speed=20.0, torque=-3.0)
    sweep = rc.sweep(
        drive, {"speed": [20.0, 40.0]}, duration=0.05, record=("sprockets",), progress=False
    )
    assert draw_waterfall(sweep, "speed_ripple", 2).axes[1].get_ylabel() == "amplitude [%]"


def test_what_makes_no_waterfall_is_refused():
    cases = [{"speed": 1.0}, {"speed": 2.0}]
    with pytest.raises(rc.InvalidInput, match="expected two or more"):
        draw_waterfall(waterfall(cases, [None, FakeResult(17.0, 2.0)]))
    with pytest.raises(rc.InvalidInput, match="did you mean 'speed_ripple'"):
        draw_waterfall(waterfall(cases, [None, None]), "speed_riple")
    two = SweepResult(cases, {"speed": (1.0,), "pretension": (0, 1)}, [None, None], _measured=False)
    with pytest.raises(rc.InvalidInput, match="expected one axis of numbers"):
        draw_waterfall(two)
    laws = waterfall([{"speed": rc.Hertz()}, {"speed": rc.Johnson()}], [None, None])
    with pytest.raises(rc.InvalidInput, match=r"speed = Hertz\(\); expected a number"):
        draw_waterfall(laws)


@pytest.mark.parametrize(
    "given", [None, 3, "runs.nc", [RESULT], RESULT, RESULT.drive, SweepResult], ids=str
)
def test_what_is_no_sweep_and_no_result_is_refused_by_name(given):
    said = re.escape(f"got {shown(given)}; expected ")
    with pytest.raises(rc.InvalidInput, match=rf"draw_map\(sweep\): {said}what sweep returned$"):
        draw_map(given, "force")
    with pytest.raises(rc.InvalidInput, match=rf"draw_waterfall\(sweep\): {said}what sweep"):
        draw_waterfall(given)
    with pytest.raises(rc.InvalidInput, match=rf"draw_loss_map\(losses\): {said}what loss_map"):
        draw_loss_map(given)
    if given is not RESULT:
        with pytest.raises(rc.InvalidInput, match=rf"Plots\(result\): {said}a Result$"):
            Plots(given)


def test_of_a_study_the_sweep_is_drawn():
    study = StudyResult(campaign(), 0.95, 0.0)
    with pytest.raises(rc.InvalidInput, match=r"got <StudyResult.*; of a study, take \.sweep$"):
        draw_map(study, "force")
    assert draw_map(study.sweep, "force").axes


def campaign():
    axes = {"pretension": (0.0, 25.0, 50.0), "speed": (5.0, 10.0)}
    cases = [{"pretension": p, "speed": s} for p in axes["pretension"] for s in axes["speed"]]
    values = [{"force": 10.0 * c["pretension"] + c["speed"]} for c in cases]
    values[3] = None
    return SweepResult(cases, axes, values, errors={3: rc.SimulationError("no")})


def test_a_map_has_the_measured_numbers_and_a_cross_where_a_case_failed():
    figure = draw_map(campaign(), "force")
    axes = figure.axes[0]
    values = axes.collections[0].get_array().reshape(2, 3)  # speed, pretension
    np.testing.assert_array_equal(values[0], [5.0, 255.0, 505.0])
    assert np.ma.getmaskarray(np.ma.masked_invalid(values)).tolist() == [
        [False, False, False],
        [False, True, False],
    ]
    (crosses,) = axes.lines
    np.testing.assert_array_equal(crosses.get_xydata(), [[1.5, 1.5]])
    assert axes.get_xlabel() == "pretension [N]"
    assert [label.get_text() for label in axes.get_yticklabels()] == ["5", "10"]


def legend_of(figure):
    (legend,) = figure.legends
    return legend.get_title().get_text(), [text.get_text() for text in legend.get_texts()]


def test_the_lines_of_a_sweep_over_two_axes_have_a_legend():
    figure = draw_sweep(campaign())
    assert legend_of(figure) == ("speed [rad/s]", ["5", "10"])
    assert [line.get_color() for line in figure.axes[0].lines] == list(CYCLE[:2])
    np.testing.assert_array_equal(figure.axes[0].lines[1].get_ydata(), [10.0, np.nan, 510.0])
    drawn = Figure().subplots()
    draw_sweep(campaign(), ax=drawn)
    assert drawn.get_legend().get_title().get_text() == "speed [rad/s]"


def test_of_many_lines_of_a_sweep_some_are_named():
    axes = {"pretension": (0.0, 25.0), "speed": tuple(np.arange(30.0))}
    cases = [{"pretension": p, "speed": s} for p in axes["pretension"] for s in axes["speed"]]
    figure = draw_sweep(SweepResult(cases, axes, [c["speed"] for c in cases]))
    assert len(figure.axes[0].lines) == len({line.get_color() for line in figure.axes[0].lines})
    title, labels = legend_of(figure)
    assert (title, len(labels), labels[0], labels[-1]) == ("speed [rad/s]", len(CYCLE), "0", "29")


def test_of_a_sweep_what_is_no_number_is_not_drawn():
    axes = {"speed": (5.0, 10.0)}
    cases = [{"speed": 5.0}, {"speed": 10.0}]
    values = [
        {"drive": rc.paper_drive(), "name": "a", "z": 1j, "peak": k, "on": True} for k in (1, 2)
    ]
    figure = draw_sweep(SweepResult(cases, axes, values))
    assert [cell.get_title("left") or cell.get_title() for cell in figure.axes] == ["peak", "on"]
    sweep = SweepResult(cases, axes, [{"drive": rc.paper_drive()}] * 2)
    with pytest.raises(rc.InvalidInput, match="nothing that was measured is a number"):
        draw_sweep(sweep)
    html = sweep._repr_html_()
    assert "<table" in html
    assert "image/png" not in html


def test_a_sweep_over_one_axis_has_no_legend():
    axes = {"speed": (5.0, 10.0)}
    cases = [{"speed": 5.0}, {"speed": 10.0}]
    figure = draw_sweep(SweepResult(cases, axes, [1.0, 2.0]))
    assert not figure.legends
    assert figure.axes[0].get_legend() is None
    assert figure.axes[0].get_xlabel() == "speed [rad/s]"


@pytest.fixture(scope="module")
def study():
    return rc.study(
        rc.paper_drive(),
        lambda result: {"start": result.initial_velocities[-1, 2], "end": result.time[-1]},
        axes={"pretension": [0.0, 25.0], "speed": [10.0, 12.566370614359172]},
        runs=2,
        duration=1e-3,
        burn_in=0.0,
        progress=False,
    )


def test_a_study_names_its_axes_with_units_and_its_lines_above_the_panels(study):
    figure = draw_study(study, ())
    assert legend_of(figure) == ("speed [rad/s]", ["10", "12.57"])
    for axes in figure.axes:
        assert axes.get_xlabel() == "pretension [N]"
        assert [bars.lines[0].get_color() for bars in axes.containers] == list(CYCLE[:2])
        found = study.statistics[axes.get_title("left")]
        runs = study.samples[axes.get_title("left")]
        dots = [line.get_xydata() for line in axes.lines if len(line.get_xydata()) == 4]
        for k, one in enumerate(dots):
            of_speed = runs.isel(speed=k).transpose("pretension", "run").to_numpy()
            expected = [(p, v) for p, row in zip((0.0, 25.0), of_speed, strict=True) for v in row]
            np.testing.assert_allclose(one, expected)
        for k, bars in enumerate(axes.containers):
            ends = [piece[:, 1] for piece in bars.lines[2][0].get_segments()]
            expected = found.isel(speed=k).sel(statistic=["low", "high"])
            np.testing.assert_allclose(ends, expected, atol=1e-12)
    figure.draw_without_rendering()
    (legend,) = figure.legends
    assert not any(legend.get_window_extent().overlaps(axes.bbox) for axes in figure.axes)


def test_figures_of_the_summary_and_of_fields_have_their_units_from_a_store_too(tmp_path):
    axes = {"chain.hinge.bore_radius": [2.30e-3, 2.31e-3], "chain.material.restitution": [0.3, 0.6]}
    rc.sweep(
        rc.paper_drive(), axes, rc.Result.summary, duration=2e-3, store=tmp_path, progress=False
    )
    sweep = rc.load_sweep(tmp_path)
    figure = draw_sweep(sweep)
    assert {cell.get_xlabel() for cell in figure.axes} == {"chain.hinge.bore_radius [m]"}
    assert legend_of(figure)[0] == "chain.material.restitution"
    titles = [cell.get_title("left") for cell in figure.axes]
    assert titles[0] == "tension_upper [N]"
    assert titles[4] == "hinge_contact_share"
    drawn, bar = draw_map(sweep, "tension_upper").axes
    assert drawn.get_title("left") == bar.get_ylabel() == "tension_upper [N]"
    study = rc.study(
        rc.paper_drive(), runs=2, duration=2e-3, burn_in=1e-3, store=tmp_path / "study",
        progress=False,
    )  # fmt: skip
    assert study.plot("loss").axes[0].get_title("left") == "loss [W]"


def test_runs_of_a_study_have_whole_numbers():
    study = rc.study(
        rc.paper_drive(), lambda result: result.time[-1],
        runs=3, duration=1e-3, burn_in=0.0, progress=False,
    )  # fmt: skip
    (axes,) = draw_study(study, ()).axes
    ticks = axes.get_xticks()
    np.testing.assert_array_equal(ticks, ticks.round())


@pytest.mark.parametrize(("speeds", "loads"), [([20.0], [-1.0, -3.0]), ([20.0, 60.0], [-2.0])])
def test_losses_at_one_speed_or_one_load_are_curves(speeds, loads):
    shape = (len(speeds), len(loads))
    losses = xr.Dataset(
        {
            "efficiency": (("speed", "torque"), np.full(shape, 0.97)),
            "lost": (("speed", "torque"), np.arange(2.0).reshape(shape)),
        },
        {"speed": speeds, "torque": loads},
    )
    figure = draw_loss_map(losses)
    (line,) = figure.axes[1].lines
    np.testing.assert_array_equal(line.get_ydata(), [0.0, 1.0])
    (told,) = figure.axes[1].get_legend().get_texts()
    assert told.get_text() == ("speed 20 rad/s" if len(speeds) == 1 else "load 2 N m")


def test_a_map_of_losses_has_per_cent_and_watts_at_their_speeds_and_loads():
    """Efficiency falls with the speed alone, from 98 to 96 %; losses grow with the load alone."""
    speeds, torques = [10.0, 20.0, 30.0], [-4.0, -1.0]
    losses = xr.Dataset(
        {
            "efficiency": (("speed", "torque"), [[0.98, 0.98], [0.97, 0.97], [0.96, 0.96]]),
            "lost": (("speed", "torque"), [[40.0, 10.0]] * 3),
        },
        {"speed": speeds, "torque": torques},
    )
    left, right = draw_loss_map(losses).axes[:2]
    titles = [axes.get_title("left") for axes in (left, right)]
    assert titles == ["efficiency [%]", "power lost [W]"]
    for axes, low, high, along in ((left, 96.0, 98.0, 0), (right, 10.0, 40.0, 1)):
        filled = axes.collections[0]
        assert (filled.zmin, filled.zmax) == pytest.approx((low, high))
        best = filled.get_paths()[int(np.argmax(filled.layers))].vertices
        assert best.mean(axis=0)[along] == pytest.approx((10.0, 4.0)[along], rel=0.15)
        cases = sorted(tuple(dot) for line in axes.lines for dot in line.get_xydata())
        assert cases == [(speed, load) for speed in speeds for load in (1.0, 4.0)]
    assert (left.get_xlabel(), left.get_ylabel()) == ("speed of the driver [rad/s]", "load [N m]")


def test_losses_are_drawn_over_speeds_in_order_and_negative_ones_to_the_right():
    for speeds in ([10.0, 30.0, 20.0], [-10.0, -30.0, -20.0]):
        lost = np.abs(speeds)[:, None]
        losses = xr.Dataset(
            {"efficiency": (("speed", "torque"), lost), "lost": (("speed", "torque"), lost)},
            {"speed": speeds, "torque": [np.copysign(2.0, -speeds[0])]},
        )
        (line,) = draw_loss_map(losses).axes[1].lines
        np.testing.assert_array_equal(line.get_data(), [[10.0, 20.0, 30.0]] * 2)


def test_a_map_of_what_was_not_measured_is_refused():
    with pytest.raises(rc.InvalidInput, match="did you mean 'force'"):
        draw_map(campaign(), "forse")


def test_what_makes_no_map_is_refused():
    one = SweepResult([{"speed": 1.0}, {"speed": 2.0}], {"speed": (1.0, 2.0)}, [1.0, 2.0])
    with pytest.raises(rc.InvalidInput, match="a sweep over speed; expected two axes or more"):
        draw_map(one, "value")


def test_laws_on_an_axis_stand_in_a_row_with_their_names():
    laws, speeds = (rc.Hertz(), rc.Johnson()), (5.0, 10.0)
    cases = [{"force_law": law, "speed": speed} for law in laws for speed in speeds]
    found = SweepResult(cases, {"force_law": laws, "speed": speeds}, [1.0, 2.0, 3.0, 4.0])
    axes = draw_sweep(found).axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["Hertz", "Johnson"]
    assert [line.get_xydata().tolist() for line in axes.lines] == [
        [[0.0, 1.0], [1.0, 3.0]],
        [[0.0, 2.0], [1.0, 4.0]],
    ]


def test_a_polar_load_stands_as_far_out_as_it_is_large():
    lines = RESULT.plot.polar_tooth_loads(1).axes[0].lines
    (largest,) = (line for line in lines if line.get_label() == "largest")
    found = RESULT.tooth_loads(1)
    force, angle = found["largest"].to_numpy(), found["angle"].to_numpy()
    x, y = largest.get_data()
    place = force.argmax()
    np.testing.assert_allclose(np.hypot(x, y)[:-1] - 1.05, force / force.max(), atol=1e-12)
    assert np.arctan2(y[place], x[place]) % (2 * np.pi) == pytest.approx(angle[place])


def test_each_sprocket_has_the_range_of_its_own_wrap_and_one_scale_of_forces():
    drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, 25), links=60, speed=12.5)
    result = rc.Simulation(drive).run(5e-3, progress=False)
    figure = result.plot.wrap_loads(1, 2)
    wraps = [result.wrap_loads(number).attrs["wrap"] for number in (1, 2)]
    assert wraps[0] + 1.0 < wraps[1]
    for axes, wrap in zip(figure.axes, wraps, strict=True):
        assert axes.get_xlim() == pytest.approx((-1.0, wrap + 1.0))
    assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()
