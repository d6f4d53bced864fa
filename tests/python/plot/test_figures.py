"""Figures: no state of pyplot, and every one can be drawn into given axes."""

import inspect
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure

import rustchain as rc
from rustchain.plot import Plots, studies
from rustchain.plot.picture import draw_drive

RESULT = rc.Simulation(rc.paper_drive(25.0)).run(
    duration=0.02, record=("hinges", "teeth", "sprockets", "bodies", "energy"), progress=False
)
# Arguments, and the number of panels.
CALLS = {
    "contact_pressure": ((), 2),
    "drive": ((), 1),
    "energy": ((), 2),
    "engagements": ((), 2),
    "force_penetration": ((6, 11), 2),
    "hinge_force": ((6,), 1),
    "hinge_loads": ((), 1),
    "orbit": ((6, 11), 2),
    "polar_tooth_loads": ((1, 2), 2),
    "power_balance": ((), 2),
    "pressure_cycles": ((), 2),
    "spectrum": (("strand_tension",), 1),
    "speed_ripple": ((), 2),
    "strand_motion": (("upper", "lower"), 2),
    "tension": ((), 1),
    "tooth_force": ((6, 11), 2),
    "tooth_loads": ((), 2),
    "transmission_error": ((), 2),
    "wrap_loads": ((1, 2), 2),
}
OF_OTHER_DRIVES = {"guide_loads", "joint_loads", "strand_spectrum"}
OF_MECHANISMS = {"contact_force", "motion", "paths", "residuals"}


def methods(kind):
    return {
        name: each
        for name, each in inspect.getmembers(kind, inspect.isfunction)
        if not name.startswith("_") and name != "rows"
    }


def test_every_plot_of_a_result_is_drawn_here():
    assert set(methods(Plots)) == {*CALLS, *OF_OTHER_DRIVES, *OF_MECHANISMS}


@pytest.mark.parametrize(
    "function",
    [
        *methods(Plots).values(),
        studies.draw_study,
        studies.draw_sweep,
        studies.draw_loss_map,
        studies.draw_map,
        studies.draw_waterfall,
        draw_drive,
    ],
    ids=lambda function: function.__name__,
)
def test_every_plot_takes_axes(function):
    assert inspect.signature(function).parameters["ax"].default is None


@pytest.mark.parametrize("name", CALLS)
def test_a_figure_leaves_no_state_in_pyplot(name):
    arguments, _ = CALLS[name]
    before = plt.get_fignums()
    figure = getattr(RESULT.plot, name)(*arguments)
    assert isinstance(figure, Figure)
    assert plt.get_fignums() == before
    assert figure._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", CALLS)
def test_a_figure_can_be_drawn_into_given_axes(name):
    arguments, panels = CALLS[name]
    figure = Figure(figsize=(9.0, 3.0))
    left, *others = figure.subplots(1, panels + 1)
    ax = others[0] if panels == 1 else others
    assert getattr(RESULT.plot, name)(*arguments, ax=ax) is figure
    assert len(figure.axes) == panels + 1
    assert all(axes.has_data() or axes.collections or axes.get_title("left") for axes in others)
    assert not (left.has_data())
    assert not (left.get_title("left"))
    np.testing.assert_array_equal(figure.get_size_inches(), (9.0, 3.0))


@pytest.mark.parametrize(
    ("draw", "force", "options"),
    [
        ("hinge_force", "hinge_force", {}),
        ("orbit", "hinge_force", {}),
        ("tooth_force", "tooth_force", {}),
        ("tooth_force", "tooth_force", {"start": 0.01, "end": 0.012}),
        ("force_penetration", "tooth_force", {}),
        ("force_penetration", "hinge_force", {"contact": "hinge"}),
    ],
)
def test_without_numbers_the_two_most_loaded_are_drawn(draw, force, options):
    inside = (RESULT.time >= options.get("start", 0.0)) & (RESULT.time <= options.get("end", 1.0))
    largest = RESULT.array(f"peak_{force}")[inside].max(axis=0)
    first, second = sorted(np.argsort(largest)[-2:] + 1)
    figure = getattr(RESULT.plot, draw)(**options)
    titles = [axes.get_title("left") for axes in figure.axes[:2]]
    for title, number in zip(titles, (first, second), strict=True):
        assert str(number) in title.split()
    if not options:
        assert (first, second) != (6, 11)


@pytest.mark.parametrize("ax", [3, [], "axes"])
def test_other_axes_than_the_figure_has_panels_are_refused(ax):
    with pytest.raises(rc.InvalidInput, match=r"ax.*expected .*Axes"):
        RESULT.plot.orbit(6, 11, ax=ax)
    with pytest.raises(rc.InvalidInput, match=r"expected 2 matplotlib Axes"):
        RESULT.plot.orbit(6, 11, ax=Figure().subplots())


@pytest.mark.parametrize("width", [7.0, 4.5])
@pytest.mark.parametrize("links", [38, 114, 400])
def test_names_along_a_chain_of_any_length_touch_neither_each_other_nor_the_curve(links, width):
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=links, speed=25.0)
    result = rc.Simulation(drive).run(2e-3, record=("hinges", "sprockets"), progress=False)
    figure = Figure(figsize=(width, 3.2))
    axes = figure.add_subplot()
    result.plot.hinge_loads(ax=axes)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 4
    for k, box in enumerate(boxes):
        assert axes.bbox.x0 <= box.x0 < box.x1 <= axes.bbox.x1
        assert not any(box.overlaps(other) for other in boxes[:k])
    largest = max(np.nanmax(line.get_ydata()) for line in axes.lines)
    top = axes.transData.transform((0.0, largest))[1]
    assert top <= min(box.y0 for box in boxes)


def test_an_orbit_shows_the_whole_path_of_every_pin():
    """A pin may go far beyond the clearance; both panels have one scale."""
    clearance = RESULT.drive.chain.hinge.clearance
    path = RESULT.array("hinge_eccentricity").copy()
    path[50, 5] = 3.0 * clearance, -4.0 * clearance
    far = replace(RESULT, arrays=RESULT.arrays | {"hinge_eccentricity": path})
    for figure in (far.plot.orbit(6, 11), far.plot.orbit(11, 6), far.plot.orbit(6)):
        for axes in figure.axes[:-1]:
            low, high = axes.get_ylim()
            assert low == -high == axes.get_xlim()[0]
            assert low < -4e6 * clearance
    axes = RESULT.plot.orbit(6).axes[0]
    assert axes.get_xlim()[1] == pytest.approx(1.2e6 * clearance, rel=0.3)


def test_the_power_balance_of_a_drive_without_dashpots_draws_none_of_them():
    drive = replace(rc.paper_drive(25.0), tensioner=None)
    result = rc.Simulation(drive).run(0.01, progress=False)
    for part in (result, result.between(5e-3)):
        loss = part.power_balance()["loss"]
        assert float(loss.sel(channel="dashpots")) == 0.0
        axes = part.plot.power_balance().axes[1]
        assert "lost: dashpots" not in [label.get_text() for label in axes.get_yticklabels()]


# --- what is drawn has the numbers of the outputs, in the units of the labels


def curves(axes):
    """Return the points of the curves by label; of those without one, by their number."""
    return {
        k if line.get_label().startswith("_") else line.get_label(): line.get_xydata().T
        for k, line in enumerate(axes.lines)
    }


def heights(axes):
    return [each.get_height() for each in axes.patches]


def verticals(axes):
    """Return the places of vertical lines, in their order."""
    return [
        x[0] for x, y in (line.get_data() for line in axes.lines) if len(x) == 2 and x[0] == x[1]
    ]


def test_a_transmission_error_is_drawn_in_micrometres_at_the_pitch_radius():
    found = RESULT.transmission_error()
    left, right = RESULT.plot.transmission_error().axes
    radius = 12700.0 / (2.0 * np.sin(np.pi / 17))  # [um]
    turned, error = curves(left)[0]
    np.testing.assert_allclose(turned, 120.0 / 60.0 * RESULT.time, atol=1e-12)
    np.testing.assert_allclose(error, radius * found["error"], rtol=1e-9)
    order, amplitude = curves(right)[0]
    np.testing.assert_array_equal(order, found["order"][1 : len(order) + 1])
    assert order[-1] <= 4.5 * 17 < found["order"][len(order) + 1]
    np.testing.assert_allclose(amplitude, radius * found["amplitude"][1 : len(order) + 1])
    assert verticals(right) == [17.0, 34.0, 51.0, 68.0]


def test_a_ripple_is_drawn_in_per_cent_beside_the_speed_and_its_mean():
    found = RESULT.speed_ripple(2)
    left, right = RESULT.plot.speed_ripple(2).axes
    np.testing.assert_array_equal(curves(left)[0][1], RESULT.sprocket(2).speed)
    np.testing.assert_array_equal(curves(left)[1][1], found.attrs["mean"])
    order, amplitude = curves(right)[0]
    np.testing.assert_allclose(amplitude, 100.0 * found["amplitude"][1 : len(order) + 1])


def test_strands_are_drawn_in_millimetres_with_the_frequencies_of_teeth_and_string():
    motion = RESULT.strand_motion("upper")
    found = RESULT.strand_spectrum("upper", modes=5)
    left, right = RESULT.plot.strand_spectrum("upper").axes
    for axes in (left, RESULT.plot.strand_motion("lower", "upper").axes[1]):
        for k, (_, outward) in enumerate(curves(axes).values()):
            np.testing.assert_allclose(outward, 1e3 * motion[:, k], rtol=1e-12)
    for k in range(3):
        np.testing.assert_array_equal(curves(right)[k][1], found["density"][k])
    teeth = np.arange(34.0, right.get_xlim()[1], 34.0)  # [Hz], of 17 teeth at 120 rpm
    expected = [*found["natural_frequency"].to_numpy(), *teeth]
    np.testing.assert_allclose(verticals(right), expected, rtol=1e-6)
    assert [text.get_text() for text in right.texts] == [f" {k}" for k in range(1, 6)]


def test_a_spectrum_of_more_than_eight_parts_is_their_mean():
    (axes,) = RESULT.plot.spectrum("hinge_force").axes
    expected = RESULT.spectrum("hinge_force").to_numpy().mean(axis=0)
    np.testing.assert_allclose(curves(axes)["mean of all"][1], expected, rtol=1e-12)
    (axes,) = RESULT.plot.spectrum("hinge_force", hinge=list(range(1, 9))).axes
    assert list(curves(axes)) == [str(number) for number in range(1, 9)]


def test_bars_of_a_power_balance_add_up_to_nothing():
    """What shafts and other work put in is positive, what is lost and stored negative."""
    found = RESULT.power_balance()
    above, below = RESULT.plot.power_balance().axes
    names = [label.get_text() for axes in (above, below) for label in axes.get_yticklabels()]
    powers = [each.get_width() for axes in (above, below) for each in axes.patches]
    drawn = dict(zip(names, powers, strict=True))
    np.testing.assert_array_equal([drawn["sprocket 1"], drawn["sprocket 2"]], found["shaft_power"])
    lost = {
        f"lost: {name.replace('_', ' ')}": -each
        for name, each in dict(
            zip(found["channel"].values, found["loss"].values, strict=True)
        ).items()
    }
    assert {name: drawn[name] for name in lost} == pytest.approx(lost)
    assert drawn["stored"] == pytest.approx(-float(found["stored"].sum()))
    assert sum(powers) == pytest.approx(0.0, abs=1e-9 * max(map(abs, powers)))


def test_loads_are_drawn_as_mean_largest_and_band():
    found = RESULT.tooth_loads(1, quantiles=(0.05, 0.95))
    left, right = RESULT.plot.tooth_loads(1).axes
    seen = np.isfinite(found["largest"].to_numpy())
    for name in ("mean", "largest"):
        direction, force = curves(left)[name]
        np.testing.assert_allclose(direction, 360.0 / 68 * (np.arange(68) + 0.5)[seen])
        np.testing.assert_array_equal(force, found[name][seen])
    band = left.collections[0].get_paths()[0].vertices
    for angle, ends in zip(direction, found["quantiles"][seen].to_numpy(), strict=True):
        there = band[np.isclose(band[:, 0], angle), 1]
        assert (there.min(), there.max()) == pytest.approx(tuple(ends))
    np.testing.assert_array_equal(heights(right)[:17], found["tooth_largest"])
    np.testing.assert_array_equal(heights(right)[17:], found["tooth_mean"])


def test_the_ends_of_the_wrap_and_the_sections_of_the_path_are_marked():
    """Half of 17 pitches of each sprocket, but for what the strands' ends take."""
    for axes, number in zip(RESULT.plot.wrap_loads(1, 2).axes, (1, 2), strict=True):
        wrap = RESULT.wrap_loads(number).attrs["wrap"]
        assert wrap == pytest.approx(8.5, abs=0.01)
        assert verticals(axes) == [0.0, wrap]
    (axes,) = RESULT.plot.hinge_loads().axes
    grey = [each.get_x() + np.array([0.0, each.get_width()]) for each in axes.patches]
    sections = RESULT.hinge_loads()["section"].to_numpy()
    for position, section in zip(
        RESULT.hinge_loads()["position"].to_numpy(), sections, strict=True
    ):
        inside = any(low <= position < high for low, high in grey)
        assert inside == section.startswith("sprocket")
    for text in axes.texts:
        x, _ = text.get_position()
        assert sections[int(4 * x)] == text.get_text()


@pytest.mark.parametrize("contact", ["hinge", "tooth"])
def test_pressures_are_drawn_in_megapascals_and_cycles_of_a_range_or_more(contact):
    found, cycles = RESULT.contact_pressure(contact), RESULT.pressure_cycles(contact)
    left, right = RESULT.plot.contact_pressure(contact).axes
    peak = found["peak_pressure"].to_numpy() / 1e6
    np.testing.assert_allclose(curves(left)["largest of all"][1], peak.max(axis=1))
    np.testing.assert_allclose(curves(left)["mean of all"][1], peak.mean(axis=1))
    counted, largest = RESULT.plot.pressure_cycles(contact).axes
    mean = cycles["cycles"].to_numpy().mean(axis=0)
    for axes in (right, counted):
        size, number = curves(axes)[0]
        np.testing.assert_allclose(size, cycles["range"] / 1e6)
        np.testing.assert_allclose(number, [mean[k:].sum() for k in range(20)], rtol=1e-9)
    np.testing.assert_allclose(heights(largest), cycles["largest"] / 1e6)
    part = RESULT.plot.contact_pressure(contact, start=0.01, end=0.012).axes[1]
    expected = RESULT.pressure_cycles(contact, start=0.01, end=0.012)["range"] / 1e6
    np.testing.assert_allclose(curves(part)[0][0], expected)


def test_impulses_of_engagements_are_drawn_in_newton_milliseconds():
    found = RESULT.engagements()
    upper, lower = RESULT.plot.engagements().axes
    for axes, column, scale in ((upper, "force", 1.0), (lower, "impulse", 1e3)):
        drawn = [line.get_ydata() for line in axes.lines if len(line.get_ydata())]
        for number, values in zip((1, 2), drawn, strict=True):
            own = found[found["sprocket"] == number]
            np.testing.assert_allclose(values, scale * own[column])


def test_energies_are_drawn_in_millijoules_and_the_pretension_beside_the_tensions():
    energy = RESULT.energy
    upper, lower = RESULT.plot.energy().axes
    expected = {
        "dissipated": energy.dissipated,
        "external work": energy.external_work,
        "kinetic, change": energy.kinetic - energy.kinetic[0],
        "gravity, change": energy.gravity - energy.gravity[0],
        "elastic": energy.elastic,
    }
    for name, values in expected.items():
        np.testing.assert_allclose(curves(upper)[name][1], 1e3 * values, atol=1e-12)
    np.testing.assert_allclose(curves(lower)[0][1], 1e3 * energy.residual, atol=1e-15)
    assert set(curves(RESULT.plot.tension().axes[0])["pretension"][1]) == {25.0}


def test_contacts_are_drawn_in_micrometres():
    for axes, number in zip(
        RESULT.plot.force_penetration(6, 7, contact="hinge").axes, (6, 7), strict=True
    ):
        hinge = RESULT.hinge(number)
        touching = hinge.force > 0.0
        depth, force = curves(axes)[0]
        np.testing.assert_allclose(depth, 1e6 * hinge.penetration[touching])
        np.testing.assert_array_equal(force, hinge.force[touching])
    (axes,) = RESULT.plot.force_penetration(6).axes
    bushing, drawn = RESULT.bushing(6), curves(axes)
    for name, regions in (("seating", (4,)), ("working", (3, 5))):
        there = np.isin(bushing.region, regions) & (bushing.tooth_force > 0.0)
        depth, force = drawn[name]
        np.testing.assert_allclose(depth, 1e6 * bushing.tooth_penetration[there])
        np.testing.assert_array_equal(force, bushing.tooth_force[there])
    axes = RESULT.plot.orbit(6).axes[0]
    path = axes.collections[0]
    eccentricity = 1e6 * RESULT.hinge(6).eccentricity
    np.testing.assert_allclose([each[0] for each in path.get_segments()], eccentricity[:-1])
    force = RESULT.hinge(6).force
    np.testing.assert_allclose(path.get_array(), (force[1:] + force[:-1]) / 2)
    assert path.get_clim() == (0.0, force.max())
    assert axes.patches[0].get_radius() == pytest.approx(25.0)  # bore 2.245 mm, pin 2.22 mm


# --- what is not there is said


def texts_of(axes):
    return [text.get_text() for text in axes.texts]


@pytest.fixture(scope="module")
def brief():
    """A drive that hardly turned, with a rail that the chain does not touch."""
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 17), links=60, center_distance=0.2715, speed=10.0, torque=-1.0
    )
    drive = replace(drive, guides=[rc.GuideRail((0.136, 0.09), (0.0, -1.0), length=0.1)])
    groups = ("hinges", "teeth", "sprockets", "bodies", "energy")
    return rc.Simulation(drive).run(2e-3, record=groups, progress=False)


@pytest.fixture(scope="module")
def one_row():
    return rc.Simulation(rc.paper_drive(25.0)).run(
        0.01, progress=False, record=("hinges", "teeth", "sprockets", "bodies", "energy"),
        callback=lambda simulation: True,
    )  # fmt: skip


def test_a_part_without_impacts_says_so_over_its_own_time(brief):
    axes = brief.plot.engagements(end=1e-4).axes
    assert [texts_of(each) for each in axes] == [["no impacts in this part"]] * 2
    assert axes[1].get_xlim() == pytest.approx((0.0, 1e-4))


def test_a_guide_without_contact_and_parts_without_force_say_so(brief, one_row):
    left, right = brief.plot.guide_loads(1).axes
    assert texts_of(left) == ["no force in this part"]
    assert texts_of(right) == ["no contact with the guide in this part"]
    for figure in (one_row.plot.hinge_loads(), one_row.plot.tooth_loads()):
        assert "no force in this part" in texts_of(figure.axes[0])


def test_orders_of_a_part_of_a_revolution_are_points_with_their_distance(brief):
    _, right = RESULT.plot.transmission_error().axes
    assert right.get_title("left").endswith("orders")
    assert "revolutions: an amplitude each" in right.get_title("left")
    assert right.lines[0].get_marker() == "o"
    for draw in ("transmission_error", "speed_ripple"):
        _, right = getattr(brief.plot, draw)().axes
        assert texts_of(right)[0].endswith("revolutions: too few for these orders")


def test_a_transmission_error_runs_to_the_right_whatever_the_sign_of_the_speed():
    for speed in (12.5, -12.5):
        drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, 25), links=60, speed=speed)
        result = rc.Simulation(drive).run(5e-3, record=("sprockets",), progress=False)
        turned = result.plot.transmission_error().axes[0].lines[0].get_xdata()
        assert turned[-1] == pytest.approx(12.5 * 5e-3 / (2 * np.pi), rel=1e-6)


def test_cycles_of_a_part_of_a_revolution_are_called_extrapolated():
    turns = RESULT.pressure_cycles().attrs["revolutions"]
    for figure in (RESULT.plot.pressure_cycles(), RESULT.plot.contact_pressure()):
        labels = [axes.get_ylabel() for axes in figure.axes]
        assert any(f"extrapolated from {turns:.2g} revolutions" in label for label in labels)


def test_a_strand_has_one_name_in_legends_labels_and_sections():
    (axes,) = RESULT.plot.tension().axes
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    assert legend[:2] == ["strand upper", "strand lower"]
    assert RESULT.plot.strand_motion("upper").axes[0].get_ylabel().startswith("strand upper,")
    assert {"strand upper", "strand lower"} <= set(RESULT.hinge_loads()["section"].values)


def test_a_single_row_is_a_marker(one_row):
    for figure in (one_row.plot.tension(), one_row.plot.energy(), one_row.plot.orbit(6)):
        curves = [line for line in figure.axes[0].lines if len(line.get_xdata()) == 1]
        assert curves
        assert {line.get_marker() for line in curves} == {"o"}
    assert {line.get_marker() for line in RESULT.plot.tension().axes[0].lines} == {"None"}


def test_numbers_of_a_power_balance_are_inside_the_axes():
    figure = RESULT.plot.power_balance()
    figure.draw_without_rendering()
    for axes in figure.axes:
        for text in axes.texts:
            box = text.get_window_extent()
            assert axes.bbox.x0 <= box.x0 < box.x1 <= axes.bbox.x1


def test_axes_have_no_offsets():
    speed = RESULT.array("sprocket_speed").copy()
    speed[:, 1] = 2.717e-2 + 1e-7 * np.sin(np.arange(len(speed)))
    even = replace(RESULT, arrays=RESULT.arrays | {"sprocket_speed": speed})
    axes = even.plot.speed_ripple(2).axes[0]
    axes.figure.draw_without_rendering()
    assert axes.yaxis.get_major_formatter().get_offset() == ""
    speed[:, 1] = 2.717e-2 * (1.0 + 1e-16 * np.arange(len(speed)))
    axes = replace(RESULT, arrays=RESULT.arrays | {"sprocket_speed": speed}).plot.speed_ripple(2)
    assert np.ptp(axes.axes[0].get_ylim()) > 1e-3


@pytest.mark.parametrize("given", [False, True])
@pytest.mark.parametrize("links", [60, 150, 402, 1000])
def test_numbers_of_hinges_of_chains_of_any_length_are_inside_the_axes(links, given):
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=links, speed=10.0)
    result = rc.Simulation(drive).run(1e-4, progress=False)
    ax = Figure(figsize=(7.0, 3.0)).subplots() if given else None
    figure = result.plot.drive(ax=ax)
    (axes,) = figure.axes
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) > 8
    for k, box in enumerate(boxes):
        assert axes.bbox.x0 <= box.x0 < box.x1 <= axes.bbox.x1
        assert axes.bbox.y0 <= box.y0 < box.y1 <= axes.bbox.y1
        assert not any(box.overlaps(other) for other in boxes[:k])


@pytest.mark.parametrize(
    ("array", "of", "error"),
    [
        (
            "strand_tension",
            {"strand": "uper"},
            r"strand: 'uper' is no strand; did you mean 'upper'",
        ),
        ("strand_tension", {"strand": 3}, "strand 3: strands are numbered 1 to 2"),
        ("hinge_force", {"hinge": 0}, "hinge 0: hinges are numbered 1 to 38; the nearest is 1"),
        ("hinge_force", {"hinge": [6, 99]}, "hinge 99: hinges are numbered 1 to 38"),
        ("hinge_force", {"hinge": 6.5}, "hinge: got 6.5; expected a number from 1 to 38"),
        ("hinge_force", {"hinge": [[1, 2]]}, r"hinge: got \[1, 2\]; expected a number"),
        ("hinge_force", {"hinge": np.array(99)}, "hinge 99: hinges are numbered 1 to 38"),
        ("hinge_force", {"hinge": []}, r"hinge: got \[\]; expected a number from 1 to 38"),
        ("hinge_force", {"frequency": 3}, "frequency: 'hinge_force' has no such parts"),
    ],
)
def test_a_spectrum_of_a_part_that_is_not_there_is_refused_by_name(array, of, error):
    with pytest.raises(rc.InvalidInput, match=error):
        RESULT.plot.spectrum(array, **of)


def test_a_spectrum_is_that_of_the_part_by_number_or_name():
    of_one = RESULT.spectrum("strand_tension").sel(strand="upper")
    for strand in ("upper", 1):
        (line,) = RESULT.plot.spectrum("strand_tension", strand=strand).axes[0].lines
        np.testing.assert_array_equal(line.get_ydata(), of_one)


def test_energies_of_a_part_count_from_its_first_row():
    part = RESULT.between(0.01, 0.015).plot.energy()
    drawn = RESULT.plot.energy(start=0.01, end=0.015)
    for axes, expected in zip(drawn.axes, part.axes, strict=True):
        for line, other in zip(axes.lines, expected.lines, strict=True):
            np.testing.assert_array_equal(line.get_xydata(), other.get_xydata())


def test_loads_of_a_drive_at_rest_are_drawn_although_most_places_have_none():
    drive = rc.two_sprocket_drive(
        "ANSI 40", teeth=(17, 25), links=60, speed=0.0, torque=-4.0, pretension=60.0
    )
    result = rc.Simulation(drive, start="static").run(
        duration=1e-3, record=("hinges", "teeth", "sprockets"), progress=False
    )
    plot = result.plot
    for figure, drawn in (
        (plot.hinge_loads(), 2),
        (plot.tooth_loads(1), 2),
        (plot.wrap_loads(1), 3),
        (plot.polar_tooth_loads(1), 2),
    ):
        curves = [line.get_ydata() for line in figure.axes[0].lines[:drawn]]
        assert all(len(curve) > 8 and np.isfinite(curve).all() for curve in curves)


def test_loads_of_one_row_are_drawn():
    one = RESULT.time[-1]
    for draw in (RESULT.plot.hinge_loads, RESULT.plot.polar_tooth_loads):
        largest = [line for line in draw(start=one).axes[0].lines if "largest" in line.get_label()]
        assert len(largest) == 1
        assert np.isfinite(largest[0].get_ydata()).sum() > 8
    at_rest = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=50.0, torque=-5.0)
    result = rc.Simulation(at_rest).run(1e-3, report_step=1e-4, progress=False)
    assert not result.plot.polar_tooth_loads(1, start=1e-3).axes[0].texts


def test_forces_of_the_circles_of_a_polar_figure_are_written_beside_the_curve():
    hoist = rc.open_chain(
        "ANSI 40",
        ends=(rc.AnchoredEnd((-0.16, -0.02), links=50), rc.LoadedEnd(10.0, arm=0.08)),
        links=90,
        sprockets=[rc.Sprocket(17, motion=rc.PrescribedSpeed(8.0))],
    )
    result = rc.Simulation(hoist).run(duration=0.02, progress=False)
    found = result.tooth_loads(1).dropna("angle")
    (axes,) = result.plot.polar_tooth_loads(1).axes
    assert axes.texts
    for text in axes.texts:
        x, y = text.get_position()
        apart = np.angle(np.exp(1j * (found["angle"] - np.arctan2(y, x))))
        beside = found["largest"].to_numpy()[np.abs(apart) < 0.3]
        assert beside.max() < 0.2 * float(found["largest"].max())
