"""The player in a headless browser: loads, plays, scrubs, zooms, tells the values of a link."""

import base64
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from browser import opened, ready, shown_time
from rustchain.plot import player
from rustchain.plot.colors import theme_css

RECORD = ("hinges", "teeth", "sprockets", "bodies")
RESULT = rc.Simulation(rc.paper_drive(25.0)).run(duration=0.05, record=RECORD, progress=False)


def unpacked(block):
    """The numbers of a block, as the page makes them."""
    shape = 4, block["channels"], block["rows"]
    planes = np.frombuffer(zlib.decompress(base64.b64decode(block["data"])), np.uint8).reshape(
        shape
    )
    folded = sum(planes[k].astype(np.uint32) << np.uint32(8 * k) for k in range(4))
    whole = ((folded >> 1) ^ -(folded & 1).astype(np.int32).astype(np.uint32)).astype(np.int32)
    for _ in range(block["order"]):
        whole = np.cumsum(whole, axis=1, dtype=np.int32)
    return block["offset"] + block["scale"] * whole


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("largest", [1e-3, 1.0, 1e7])
def test_numbers_come_out_of_a_block_rounded_to_their_step(order, largest):
    values = largest * np.random.default_rng(5).uniform(-1.0, 1.0, (3, 500))
    block = player.block_of(values, 1e-6, order)
    assert np.abs(unpacked(block) - values).max() <= 0.51 * max(1e-6, 2.0 * largest / 2**30)


def test_positions_in_a_page_are_those_of_the_result_to_a_tenth_of_a_micrometre():
    data = player.player_data(RESULT.animate())
    positions = RESULT.array("positions")
    places = unpacked(data["places"]).T.reshape(*positions.shape[:2], 2)
    assert np.abs(places - positions[:, :, :2]).max() < 0.6e-7
    assert np.abs(unpacked(data["angles"]).T - positions[:, :, 2]).max() < 0.6e-6
    assert np.abs(unpacked(data["time"])[0] - RESULT.time).max() < 1e-9


def test_a_page_with_nan_in_a_series_is_valid_json():
    tension = RESULT.array("strand_tension").copy()
    tension[3] = np.nan
    result = replace(RESULT, arrays=RESULT.arrays | {"strand_tension": tension})
    data = player.player_data(result.animate())
    json.dumps(data, allow_nan=False)
    block = unpacked(data["series"]["block"])
    assert block[:2, 3] == pytest.approx(0.0, abs=1e-6)
    assert block[0, 4] == pytest.approx(tension[4, 0], abs=1e-6)


def test_of_too_many_rows_every_second_one_is_left_out(monkeypatch):
    whole = player.player_data(RESULT.animate())
    monkeypatch.setattr(player, "LARGEST", player.length_of(whole) // 2)
    fewer = player.player_data(RESULT.animate())
    assert whole["time"]["rows"] == 501
    assert fewer["time"]["rows"] in (126, 251)
    assert unpacked(fewer["time"])[0, -1] == pytest.approx(0.05)
    # The largest forces between the rows that are left are all there.
    step = 500 // (fewer["time"]["rows"] - 1)
    series = dict(zip(fewer["series"]["names"], unpacked(fewer["series"]["block"]), strict=True))
    for part in ("hinge", "tooth"):
        peaks = RESULT.array(f"peak_{part}_force").max(axis=1)
        expected = [peaks[0], *peaks[1:].reshape(-1, step).max(axis=1)]
        np.testing.assert_allclose(series[f"largest {part} force"], expected, atol=1e-5)


def test_the_largest_forces_of_a_part_begin_with_those_of_its_first_row():
    row = 1 + int(RESULT.array("peak_tooth_force")[1:].max(axis=1).argmax())  # after an impact
    data = player.player_data(RESULT.animate(start=RESULT.time[row]))
    series = dict(zip(data["series"]["names"], unpacked(data["series"]["block"]), strict=True))
    part = RESULT.between(RESULT.time[row])
    for name in ("hinge", "tooth"):
        peaks = part.array(f"peak_{name}_force").max(axis=1)
        np.testing.assert_allclose(series[f"largest {name} force"], peaks, atol=1e-5)
    assert series["largest tooth force"][0] < 0.9 * RESULT.array("peak_tooth_force")[row].max()


@pytest.mark.filterwarnings("ignore::rustchain.RustchainWarning")  # nothing holds the body
def test_a_page_without_forces_has_the_largest_speed_over_time():
    m = rc.Mechanism(gravity=(0.0, -2.0))
    m.add_body("ball", mass=1.0, inertia=1e-3)
    result = rc.Simulation(m).run(0.1, 0.01, record=("bodies",), progress=False)
    series = player.player_data(result.animate())["series"]
    assert (series["names"], series["units"]) == (["largest speed of a body"], ["m/s"])
    np.testing.assert_allclose(unpacked(series["block"])[0], 2.0 * result.time, atol=1e-5)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("player") / "run.html"
    RESULT.animate(path, slow_motion=20.0)
    return path


def view(page):
    return page.evaluate("document.querySelector('.player').player.view")


def picture(page):
    """A checksum of what the stage shows."""
    return page.evaluate("document.querySelector('.stage').toDataURL()")


def test_it_loads_plays_and_stops(path):
    with opened(path) as page:
        ready(page)
        assert shown_time(page) == 0.0
        page.wait_for_timeout(200)
        before = picture(page)
        page.focus(".stage")
        page.keyboard.press("Space")
        page.wait_for_function("document.querySelector('.player').player.time > 0.005")
        assert picture(page) != before
        page.click("button[aria-label=pause]")
        stopped = shown_time(page)
        page.wait_for_timeout(200)
        assert shown_time(page) == stopped
        assert "ms" in page.inner_text("output")


def test_it_scrubs_by_slider_keys_and_plot(path):
    with opened(path) as page:
        ready(page)
        page.fill("input[type=range]", "250")
        assert shown_time(page) == pytest.approx(0.025)
        page.focus(".stage")
        page.keyboard.press("ArrowRight")
        assert shown_time(page) == pytest.approx(0.0251)
        page.keyboard.press("Home")
        assert shown_time(page) == 0.0
        chart = page.locator(".chart")
        width = chart.bounding_box()["width"]
        chart.click(position={"x": 0.75 * width, "y": 50})
        assert shown_time(page) == pytest.approx(0.0365, abs=2e-3)


def test_it_zooms_pans_and_fits(path):
    with opened(path) as page:
        ready(page)
        start = view(page)
        box = page.locator(".stage").bounding_box()
        page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 0.5 * box["height"])
        page.mouse.wheel(0, -600)
        page.wait_for_timeout(300)
        near = view(page)
        assert near["width"] < 0.6 * start["width"]
        assert near["x"] < start["x"]  # towards the pointer
        page.mouse.down()
        page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        page.mouse.up()
        assert view(page)["x"] < near["x"]
        page.focus(".stage")
        page.keyboard.press("0")
        assert view(page)["width"] == pytest.approx(start["width"])
        page.keyboard.press("+")
        assert view(page)["width"] == pytest.approx(0.8 * start["width"])
        page.select_option("select[aria-label=camera]", label="link 6")
        assert view(page)["x"] == 0.0


def test_a_link_tells_its_values_and_its_forces_are_plotted(path):
    with opened(path) as page:
        ready(page)
        page.fill("input[type=range]", "400")
        box, at = page.locator(".stage").bounding_box(), view(page)
        head = 30  # pixels, of the scales
        scale = min(box["width"] / at["width"], (box["height"] - head) / at["height"])
        x, y, _ = RESULT.array("positions")[400, 5]
        page.mouse.click(
            box["x"] + box["width"] / 2 + scale * (x - at["x"]),
            box["y"] + (box["height"] + head) / 2 - scale * (y - at["y"]),
        )
        page.wait_for_timeout(300)
        told = page.inner_text(".told").replace("−", "-")
        assert told.startswith("link 6:")
        numbers = re.findall(r"-?[\d.]+(?:e-?\d+)?", told.split(":", 1)[1])
        assert float(numbers[0]) == pytest.approx(1e3 * x, rel=1e-4)
        assert float(numbers[1]) == pytest.approx(1e3 * y, rel=1e-4)
        speed = np.hypot(*RESULT.array("velocities")[400, 5, :2])
        assert float(numbers[3]) == pytest.approx(speed, rel=0.02)
        force = RESULT.hinge(6).force[400]
        found = re.search(r"hinge 6, hinge force ([\d.e-]+) N", told)
        assert float(found[1]) == pytest.approx(force, rel=2e-3, abs=1e-3)
        assert "hinge 6, hinge force [N]" in page.inner_text(".legend")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_a_phone_nothing_sticks_out(path, scheme):
    with opened(path, viewport={"width": 390, "height": 844}, color_scheme=scheme) as page:
        ready(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (sum(map(int, re.findall(r"\d+", paper))) > 380) == (scheme == "light")


def test_a_notebook_shows_the_player_in_a_frame():
    shown = RESULT.animate(end=1e-3)._repr_html_()
    assert shown.startswith("<iframe srcdoc=")
    assert "&lt;div class=&quot;player&quot;" in shown


@pytest.mark.slow
def test_twenty_thousand_rows_are_fluent_and_small(tmp_path):
    """Two seconds of the paper's drive: a frame takes no longer than one of 0.02 s."""
    result = rc.Simulation(rc.paper_drive(25.0)).run(duration=2.0, record=RECORD, progress=False)
    assert len(result.time) == 20_001
    spans = {}
    for rows, end in ((200, 0.02), (20_000, 2.0)):
        path = tmp_path / f"{rows}.html"
        result.animate(path, end=end)
        assert path.stat().st_size < 15e6
        with opened(path) as page:
            ready(page)
            spans[rows] = page.evaluate(
                """async () => {
                  document.querySelector(".player button").click();
                  const start = performance.now();
                  for (let k = 0; k < 60; k++) await new Promise(requestAnimationFrame);
                  return performance.now() - start;
                }""",
            )
    assert spans[20_000] < 3.0 * spans[200]


def test_a_force_of_zero_is_zero_in_a_page():
    values = np.array([[0.0, 1.0, -0.37], [0.0, 0.0, 123.4]])
    for step in (0.0, 1e-3):
        block = unpacked(player.block_of(values, step, 1))
        assert (block[values == 0.0] == 0.0).all()
        assert block == pytest.approx(values, abs=1e-3)
    for constant in (0.0, 4.905):
        assert (unpacked(player.block_of(np.full((1, 3), constant), 0.0, 1)) == constant).all()


def test_a_page_that_a_browser_saved_builds_its_player_anew(tmp_path):
    first, saved = tmp_path / "first.html", tmp_path / "saved.html"
    RESULT.animate(first)
    with opened(first) as page:
        ready(page)
        saved.write_text(page.content().replace('data-ready="true"', ""), encoding="utf-8")
    with opened(saved) as page:
        ready(page)
        assert page.locator(".stage").count() == 1
        page.locator(".stage").focus()
        page.keyboard.press("End")
        assert shown_time(page) == pytest.approx(0.05)


def test_two_players_in_one_page_are_built_once_and_print_in_light_colours(tmp_path):
    page_of_two = tmp_path / "two.html"
    parts = [player.player_part(RESULT.animate(start=start)) for start in (None, 0.025)]
    style = f"<style>{theme_css()}</style>"
    page_of_two.write_text(f"<!DOCTYPE html>{style}{parts[0]}{parts[1]}", encoding="utf-8")
    with opened(page_of_two) as page:
        page.wait_for_function("document.querySelectorAll('.player[data-ready]').length === 2")
        page.wait_for_timeout(200)
        players = "[...document.querySelectorAll('.player')]"
        counts = f"{players}.map(p => p.querySelectorAll('.stage').length)"
        assert page.evaluate(counts) == [1, 1]
        times = f"{players}.map(p => p.player.time)"
        assert page.evaluate(times) == pytest.approx([0.0, 0.025])
        page.locator(".stage").nth(1).focus()
        page.keyboard.press("End")
        assert page.evaluate(times) == pytest.approx([0.0, 0.05])
        for theme in ("dark", None):
            found = page.evaluate(
                """theme => {
                    const data = document.documentElement.dataset, seen = [];
                    if (theme) data.theme = theme; else delete data.theme;
                    for (const event of ["beforeprint", "afterprint"]) {
                        dispatchEvent(new Event(event));
                        seen.push(data.theme ?? null);
                    }
                    return seen;
                }""",
                theme,
            )
            assert found == ["light", theme]
