"""Reports: what they say, against numbers found otherwise, and how they look in a browser."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import trapezoid

import rustchain as rc
from browser import opened, ready
from rustchain.report import confidence, page, safety

RECORD = ("hinges", "teeth", "sprockets", "bodies", "energy")


def loaded_drive():
    return rc.two_sprocket_drive("ANSI 40", (17, 17), links=38, speed=20.0, torque=-3.0)


@pytest.fixture(scope="module")
def result():
    return rc.Simulation(loaded_drive()).run(duration=0.2, record=RECORD, progress=False)


@pytest.fixture(scope="module")
def path(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    result.report(path, start=0.05)
    return path


def text_of(path):
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", path.read_text(encoding="utf-8")))


# --- safety


def test_safety_is_the_breaking_load_over_the_pull(result):
    found = safety.safety_of(result)
    assert found.breaking_load == pytest.approx(3125 * 4.4482216152605)  # lbf, ANSI B29.1
    steps = np.diff(result.time)
    tension = result.array("strand_tension")
    means = ((tension[1:] + tension[:-1]) / 2.0 * steps[:, None]).sum(axis=0) / steps.sum()
    assert found.pull == pytest.approx(means.max())
    assert found.largest_force >= found.largest_pull > found.pull
    # The tight strand pulls the load's torque over the pitch radius, beside the slack one's.
    radius = 0.5 * 0.0127 / np.sin(np.pi / 17)
    assert found.pull - means.min() == pytest.approx(3.0 / radius, rel=0.1)


def test_pressure_is_the_pull_over_the_projected_area_of_a_pin(result):
    found, hinge = safety.safety_of(result), result.drive.chain.hinge
    assert found.pressure == pytest.approx(found.pull / (2.0 * hinge.pin_radius * hinge.length))
    most = result.contact_pressure()["peak_pressure"].max()
    assert found.hertz_pressure == pytest.approx(float(most))


def test_strands_share_the_load(result):
    twice = replace(result.scene.system, chain=replace(result.drive.chain, strands=2))
    shared = replace(result, scene=replace(result.scene, system=twice))
    one, two = safety.safety_of(result), safety.safety_of(shared)
    assert two.breaking_load == 2.0 * one.breaking_load
    assert two.pressure == pytest.approx(0.5 * one.pressure)


@pytest.mark.parametrize(
    ("pitch", "turns", "teeth", "expected"),
    [
        (12.7e-3, 200.0, 17, 29e6),
        (12.7e-3, -200.0, 17, 29e6),
        (25.4e-3, 250.0, 17, 21.5e6),
        (12.7e-3, 200.0, 27, 1.1 * 29e6),
        (12.7e-3, 10.0, 17, 46e6),  # as at 50 rpm
        (12.7e-3, 3000.0, 17, None),
        (38.1e-3, 1000.0, 17, None),
        (8e-3, 200.0, 17, None),
        (11.5e-3, 200.0, 17, None),
    ],
)
def test_the_allowable_pressure_is_that_of_the_table(pitch, turns, teeth, expected):
    found = safety.allowed_pressure(pitch, rc.rpm(turns), teeth)
    assert found == (None if expected is None else pytest.approx(expected))


def test_the_page_says_what_the_guide_value_of_the_pressure_is(path):
    section = path.read_text(encoding="utf-8").partition("Pressure in the hinges")[2]
    assert "<th>guide value</th>" in section
    assert "Chernavskii and others, Course Design of Machine Elements" in section
    assert "It is no limit of a standard or of the chain's manufacturer" in section
    assert "usually at most" not in section


@pytest.mark.parametrize(
    ("size", "strands", "expected"),
    [
        ("ANSI 40", 3, 3 * 3125 * 4.4482216152605),
        ("ISO 08B", 1, 17.8e3),
        ("ISO 05B", 2, 7.8e3),
        ("ISO 06B", 3, 24.9e3),
        ("ISO 08B", 2, 31.1e3),
        ("ISO 08B", 3, 44.5e3),
        ("ISO 10B", 3, 66.7e3),
        ("ISO 12B", 2, 57.8e3),
        ("ISO 16B", 2, 106e3),
        ("ISO 20B", 3, 250e3),
        ("ISO 24B", 2, 280e3),
        ("ISO 24B", 4, None),
    ],
)
def test_strands_of_the_b_series_break_at_less_than_so_many_single_ones(
    result, size, strands, expected
):
    chain = rc.catalogue_chain(size, links=38, strands=strands)
    shared = replace(result.scene.system, chain=chain)
    found = safety.safety_of(replace(result, scene=replace(result.scene, system=shared)))
    assert found.breaking_load == (None if expected is None else pytest.approx(expected))


def test_sizes_of_the_b_series_have_two_and_three_strands_or_none_is_known():
    for name, size in rc.chain_sizes().items():
        if name in ("ISO 28B", "ISO 32B"):
            assert [size.breaking_load(strands) for strands in (2, 3)] == [None, None]
            continue
        loads = [size.breaking_load(strands) for strands in (1, 2, 3)]
        shares = np.array(loads) / (size.strength * np.array([1, 2, 3]))
        assert shares[0] == 1.0
        if name.startswith("ISO"):
            assert (shares[1:] > 0.8).all()
            assert (shares[1:] <= 1.003).all()
        else:
            assert (shares == 1.0).all()


def test_the_guide_value_of_a_drive_that_turns_back_is_that_of_the_size_of_its_speed(result):
    time = np.array([0.0, 1.0, 2.0, 4.0])
    speed = np.tile([[20.0], [20.0], [-20.0], [-20.0]], 2)
    columns = result.between(end=3e-4).arrays
    arrays = columns | {"time": time, "sprocket_speed": speed}
    found = safety.safety_of(replace(result, arrays=arrays))
    assert found.allowed_pressure == safety.allowed_pressure(12.7e-3, 20.0, 17)
    uneven = np.tile([[10.0], [10.0], [-10.0], [-30.0]], 2)  # 15 rad/s in the mean over time
    found = safety.safety_of(replace(result, arrays=arrays | {"sprocket_speed": uneven}))
    assert found.allowed_pressure == safety.allowed_pressure(12.7e-3, 15.0, 17)


def test_offset_links_need_more_safety(result):
    odd = rc.two_sprocket_drive("ANSI 40", (17, 17), links=39, speed=20.0)
    fake = replace(result, scene=replace(result.scene, system=odd))
    assert safety.safety_of(result).usual_safety == 6.0
    assert safety.safety_of(fake).usual_safety == 9.0


# --- key figures


def test_the_mean_tension_is_one_number_among_key_figures_and_in_the_safety(result):
    late = result.between(start=0.0123)
    means = [f.value for f in confidence.key_figures(late) if f.label.startswith("mean tension")]
    assert max(means) == safety.safety_of(late).pull


def test_an_interval_is_students_of_the_means_of_the_parts(result):
    (figure,) = (f for f in confidence.key_figures(result) if f.name == "tension_upper")
    edges = np.linspace(0.0, 0.2, 9)
    tension = result.strand("upper").tension

    def mean_within(start, end):
        rows = (result.time >= start - 1e-9) & (result.time <= end + 1e-9)
        return trapezoid(tension[rows], result.time[rows]) / np.ptp(result.time[rows])

    parts = [mean_within(start, end) for start, end in pairwise(edges)]
    half = stats.t.ppf(0.975, 7) * stats.sem(parts)
    assert figure.value == pytest.approx(mean_within(0.0, 0.2))
    assert figure.interval == pytest.approx((figure.value - half, figure.value + half), rel=1e-4)
    assert figure.spread == pytest.approx((min(parts), max(parts)))


def test_the_mean_of_the_parts_is_the_value_of_each_figure_that_has_an_interval():
    """Of a run-up, in which the parts have unlike numbers of engagements and unlike powers."""
    speed = rc.Table([(0.0, 5.0), (0.2, 40.0)])
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=38, speed=speed, torque=-3.0)
    result = rc.Simulation(drive).run(duration=0.2, record=RECORD, progress=False)
    parts = [result.summary(start=a, end=b) for a, b in pairwise(np.linspace(0.0, 0.2, 9))]
    figures = confidence.key_figures(result)
    for figure in (one for one in figures if one.interval is not None):
        mean = np.mean([part[figure.name] for part in parts])
        assert mean == pytest.approx(figure.value, rel=1e-4), figure.name
    without = {one.name for one in figures if one.interval is None and one.spread is not None}
    assert {"engagement_force_mean", "efficiency"} <= without


def test_the_interval_has_the_mean_of_noise_in_about_95_of_100_cases(result):
    """Batches of white noise about 10 N."""
    rng, hits = np.random.default_rng(11), 0
    short = result.between(end=0.02)
    for _ in range(100):
        arrays = short.arrays | {"strand_tension": rng.normal(10.0, 3.0, (len(short.time), 2))}
        arrays = {
            name: arrays[name]
            for name in ("time", "strand_tension", "hinge_penetration", "peak_hinge_force")
        }
        figures = confidence.key_figures(replace(short, arrays=arrays))
        (figure,) = (f for f in figures if f.name == "tension_upper")
        hits += figure.interval[0] <= 10.0 <= figure.interval[1]
    assert 88 <= hits <= 100


def test_extremes_have_a_range_and_short_runs_neither(result):
    figures = {f.name: f for f in confidence.key_figures(result)}
    assert figures["ripple_2"].interval is None  # a root of a mean of squares
    assert figures["ripple_2"].spread is not None
    assert figures["hinge_force_largest"].interval is None
    assert figures["hinge_force_largest"].spread[1] == figures["hinge_force_largest"].value
    assert figures["hinge_force_largest"].label == "largest hinge force"
    short = confidence.key_figures(result.between(end=5e-3))
    assert all(f.interval is None and f.spread is None for f in short)


# --- the page


def test_a_page_says_what_was_run_and_found(path, result):
    text = text_of(path)
    part = result.between(start=0.05)
    found = safety.safety_of(part)
    for expected in (
        "0.05 to 0.2 s in 1501 rows",
        "LankaraniNikravesh",
        "mean tension, strand upper",
        "95 % interval",
        "Breaking load of the chain: 13.9 kN",
        f"{found.breaking_load / found.pull:.4g}",
        f"{1e-6 * found.pressure:.4g} MPa 29.72 MPa",
        "Energy balance",
        "Transmission error and orders, sprocket 2",
    ):
        assert expected in text


def test_a_page_on_a_failed_run_of_one_row_says_so_in_words(result, tmp_path):
    failed = replace(result.between(end=0.0), status="failed", message="step size fell")
    failed.report(tmp_path / "failed.html")
    text = text_of(tmp_path / "failed.html")
    assert "the run failed: step size fell" in text
    assert "s in 1 row; " in text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (19033.4, "19030"),
        (-19033.4, "−19030"),
        (9999.6, "10000"),
        (1.2346e9, "1.235e+09"),
        (0.01234567, "0.01235"),
    ],
)
def test_a_number_of_thousands_has_no_exponent(value, text):
    assert page.number_text(value) == text


def test_an_accuracy_that_tolerances_replace_is_not_told():
    assert page.line_of(rc.Solver(rtol=1e-7)).endswith("max_order 12")
    assert "accuracy 1e-09" in page.line_of(rc.Solver(accuracy=1e-9))


def test_a_page_needs_nothing_else(path):
    page = path.read_text(encoding="utf-8")
    assert not re.search(r"(src|href)=\"(?!#)", page)
    assert not re.search(r"url\((?!#)", page)
    assert "@import" not in page
    assert len(page) < 5e6


def test_what_people_write_is_escaped(tmp_path):
    drive = replace(loaded_drive(), name="<script>alert(1)</script>")
    result = rc.Simulation(drive).run(2e-3, record=("hinges",), progress=False)
    result.report(tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page


def test_what_was_not_recorded_is_left_out_with_the_reason(tmp_path):
    path = tmp_path / "run.html"
    rc.Simulation(loaded_drive()).run(2e-3, record=("hinges",), progress=False).report(path)
    text = text_of(path)
    assert "bodies were not recorded" in text
    assert re.search(r"Tooth loads of sprocket 1: \w+ were not recorded", text)
    assert 'class="player"' not in path.read_text(encoding="utf-8")


@pytest.mark.filterwarnings("ignore::rustchain.ToothJumpWarning")
def test_a_report_says_that_the_chain_jumped(tmp_path):
    drive = rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=20, torque=-10, pretension=50
    )
    law = rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
    result = rc.Simulation(drive, law).run(0.33, 1e-3, record=("hinges",), progress=False)
    result.report(tmp_path / "run.html")
    count = len(result.tooth_jumps)
    told = (
        f"the chain jumped {count} {'tooth' if count == 1 else 'teeth'}; there is no transmission"
    )
    assert told in text_of(tmp_path / "run.html")


@pytest.mark.parametrize("kind", ["mechanism", "ideal", "open"])
def test_every_kind_of_scene_has_a_report(kind, tmp_path):
    if kind == "mechanism":
        scene = rc.paper_drive(25.0).to_mechanism()
    elif kind == "open":
        scene = rc.open_chain("ISO 08B", [rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(5.0)], 10)
    else:
        # At the default accuracy some of such short runs warn of their residual.
        scene = rc.Scene(rc.paper_drive(25.0, hinges="ideal"), solver=rc.Solver(accuracy=3e-11))
    record = ("bodies", "joints", "contacts", "energy") if kind == "mechanism" else RECORD
    result = rc.Simulation(scene).run(5e-3, record=record, progress=False)
    path = tmp_path / "run.html"
    result.report(path)
    page = path.read_text(encoding="utf-8")
    assert page.count("<figure>") >= 3
    assert 'class="player"' in page


def test_a_breaking_load_can_be_given(tmp_path):
    result = rc.Simulation(rc.paper_drive(25.0)).run(5e-3, record=("hinges",), progress=False)
    result.report(tmp_path / "a.html")
    assert "not known; pass breaking_load" in text_of(tmp_path / "a.html")
    result.report(tmp_path / "b.html", breaking_load=14e3)
    assert "Breaking load of the chain: 14 kN" in text_of(tmp_path / "b.html")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"path": "run.pdf"}, "ends in '.pdf'; expected .html: a browser prints the page to PDF"),
        ({"path": "run.html", "breaking_load": -1.0}, "expected a positive number in N"),
        ({"path": "run.html", "start": 3.0}, "no rows there"),
    ],
)
def test_a_path_a_breaking_load_and_a_part_that_cannot_be_are_refused(
    result, arguments, told, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(rc.InvalidInput, match=told):
        result.report(**arguments)
    assert not list(tmp_path.iterdir())


def test_a_browser_shows_it_in_light_and_dark_and_plays(path):
    with opened(path, color_scheme="light") as page:
        ready(page)
        assert page.locator("figure svg").count() >= 11
        paper = "getComputedStyle(document.body).backgroundColor"
        light = page.evaluate(paper)
        page.click("nav button")
        assert page.evaluate(paper) != light
        # Curves and text of figures follow.
        text = page.evaluate("getComputedStyle(document.querySelector('figure svg text')).fill")
        assert sum(map(int, re.findall(r"\d+", text)[:3])) > 380
        page.click("button[aria-label=play]")
        page.wait_for_function("document.querySelector('.player').player.time > 0.052")


def test_on_a_phone_only_tables_and_figures_scroll_sideways(path):
    with opened(path, viewport={"width": 390, "height": 844}) as page:
        ready(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_it_prints_without_the_player_and_without_tables_cut_off(path):
    with opened(path, viewport={"width": 700, "height": 1000}) as page:
        ready(page)
        page.emulate_media(media="print")
        assert not page.is_visible("#motion")
        kept = "getComputedStyle(document.querySelector('#plots h3')).breakAfter"
        assert page.evaluate(kept) == "avoid"
        widest = "Math.max(...[...document.querySelectorAll('table')].map(t => t.scrollWidth))"
        assert page.evaluate(widest) <= 700
        page.wait_for_timeout(100)  # for a frame of the hidden player, which draws nothing


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_prints_on_white_paper(path, scheme):
    with opened(path, color_scheme=scheme) as page:
        ready(page)
        if scheme == "light":
            page.click("nav button")
        page.emulate_media(media="print")
        paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert paper == "rgb(255, 255, 255)"
        text = page.evaluate("getComputedStyle(document.querySelector('figure svg text')).fill")
        assert sum(map(int, re.findall(r"\d+", text)[:3])) < 200


def test_a_report_has_the_colours_of_its_page_whatever_the_theme(tmp_path):
    result = rc.Simulation(loaded_drive()).run(2e-3, record=("hinges",), progress=False)
    pages = []
    for theme in ("light", "dark"):
        rc.plot.use_theme(theme)
        try:
            result.report(tmp_path / f"{theme}.html")
        finally:
            rc.plot.use_theme("light")
        pages.append((tmp_path / f"{theme}.html").read_text(encoding="utf-8"))
    assert pages[0] == pages[1]
    assert "var(--x" in pages[0]


def test_a_report_has_the_warnings_of_laws_and_solver(tmp_path):
    solver = rc.Solver(accuracy=1e-5)
    with pytest.warns(rc.RustchainWarning, match=r"solver\.accuracy"):
        simulation = rc.Simulation(loaded_drive(), solver=solver)
    simulation.run(1e-5, energy=False, progress=False).report(tmp_path / "report.html")
    assert "solver.accuracy" in text_of(tmp_path / "report.html").split("All inputs")[0]


def test_a_report_of_ideal_hinges_names_no_law_for_them(tmp_path):
    drive = replace(loaded_drive(), hinges="ideal")
    result = rc.Simulation(drive).run(2e-3, record=("hinges",), progress=False)
    result.report(tmp_path / "report.html")
    assert "law of hinges ideal hinges" in text_of(tmp_path / "report.html")


def test_a_breaking_load_of_a_mechanism_is_refused(tmp_path):
    mechanism = rc.Mechanism()
    mechanism.add_body("rod", mass=1.0, inertia=0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "rod", at=(0.0, 0.0))
    result = rc.Simulation(mechanism).run(1e-3, progress=False)
    with pytest.raises(rc.InvalidInput, match=r"report\(breaking_load\): a mechanism has no chain"):
        result.report(tmp_path / "report.html", breaking_load=1e4)


def test_a_saved_result_with_a_python_function_has_a_report_without_it(tmp_path):
    mechanism = rc.Mechanism()
    mechanism.add_body("rod", mass=1.0, inertia=0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "rod", at=(0.0, 0.0))
    mechanism.add_callable("push", "rod", lambda *_: (0.0, 0.0, 0.1))
    rc.Simulation(mechanism).run(1e-3, progress=False).save(tmp_path / "run.nc")
    rc.load_result(tmp_path / "run.nc").report(tmp_path / "report.html")
    told = text_of(tmp_path / "report.html")
    assert "was a Python function, which files do not hold" in told
    assert "Energy balance" in told
