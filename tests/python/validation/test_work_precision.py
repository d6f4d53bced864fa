"""What the comparison of run times makes of its figures, and the pages that it writes."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from work_precision import render
from work_precision.analysis import (
    LOAD_LIMIT,
    SPREAD_LIMIT,
    batch_means,
    disturbance,
    frontier,
    order_of_convergence,
    ratios_of_rounds,
    time_at_error,
)

DOCS = Path(__file__).parents[3] / "docs"
RECORD = json.loads((DOCS / "performance" / "work-precision.json").read_text(encoding="utf-8"))
ERRORS, TIMES = [1e-2, 1e-4, 1e-6], [1.0, 10.0, 100.0]


def test_the_time_at_an_error_lies_on_the_line_between_logarithms():
    assert time_at_error(ERRORS, TIMES, 1e-3) == pytest.approx(np.sqrt(10.0))
    assert time_at_error(ERRORS, TIMES, 1e-4) == pytest.approx(10.0)


def test_a_looser_error_than_any_costs_the_cheapest_run_and_a_tighter_one_has_no_time():
    assert time_at_error(ERRORS, TIMES, 1.0) == 1.0
    assert np.isnan(time_at_error(ERRORS, TIMES, 1e-7))
    assert np.isnan(time_at_error([np.nan], [1.0], 1.0))


def test_a_point_that_another_beats_in_both_does_not_count():
    errors, times = ERRORS + [1e-3], TIMES + [50.0]
    assert frontier(errors, times)[0].tolist() == ERRORS
    assert time_at_error(errors, times, 1e-3) == time_at_error(ERRORS, TIMES, 1e-3)


def test_the_order_of_convergence_is_that_of_the_power():
    costs = np.array([10.0, 30.0, 100.0])
    assert order_of_convergence(costs, 5.0 * costs**-4) == pytest.approx(4.0)


def test_intervals_of_batch_means_hold_the_mean_in_95_percent_of_all_series():
    generator = np.random.default_rng(1)
    held = 0
    for _ in range(400):
        mean, half = batch_means(generator.normal(3.0, 1.0, (400, 2)), np.mean)
        held += abs(mean - 3.0) <= half
    # Binomial with p = 0.95: 380 of 400 expected, standard deviation 4.4.
    assert abs(held - 380) < 4 * 4.4


def test_a_steady_series_has_no_width():
    assert batch_means(np.full((100, 3), 7.0), np.mean) == (7.0, 0.0)


def test_the_ratio_is_taken_in_each_round_and_a_point_with_one_run_counts_in_all():
    own = [(1e-2, [1.0, 2.0, 4.0]), (1e-4, [10.0, 20.0, 40.0])]
    other = [(1e-2, [8.0]), (1e-4, [80.0])]
    assert ratios_of_rounds(own, other, 1e-3) == pytest.approx([8.0, 4.0, 2.0])


def test_a_busy_machine_and_halves_that_differ_are_told():
    near, far = 0.5 * SPREAD_LIMIT, 2.0 * SPREAD_LIMIT
    assert disturbance([0.9, 1.1], [near, near, far]) == ""
    assert "load average" in disturbance([0.9, LOAD_LIMIT + 0.1], [near])
    assert "differ by" in disturbance([1.0], [near, far, far])
    assert disturbance([1.0], [np.nan]) == ""  # a point without equal runs


def test_the_record_is_of_one_revision_on_a_quiet_machine():
    differences = [line["difference"] for line in RECORD["lines"]]
    assert np.isfinite(differences).any()
    assert disturbance(np.ravel(list(RECORD["load"].values())), differences) == ""
    assert len(set(RECORD["machines"].values())) == 1


def test_the_pages_are_what_the_record_makes_of_them():
    for page, text in render.pages(RECORD, DOCS).items():
        assert page.read_text(encoding="utf-8") == text
    assert RECORD["verdicts"] == render.verdicts(RECORD)


def test_the_performance_page_has_the_times_of_the_record():
    page = (DOCS / "performance" / "index.md").read_text(encoding="utf-8")
    row = r"^\| (\d+ N) \| (.*) \| (\S+) \| (\S+) (thousand|million) \| (\S+) \|$"
    rows = re.findall(row, page, re.MULTILINE)
    assert len(rows) == 12
    processor, _, instructions, _ = RECORD["machines"]["long"].split(", ")
    assert {"instructions avx512": "AVX-512", "instructions avx2": "AVX2"}[instructions] in page
    assert f"one core of an {processor} server" in page
    methods = {
        "default, `accuracy=1e-10`": ("rustchain auto", 1e-10),
        "`accuracy=1e-9`": ("rustchain auto", 1e-9),
        '`method="pece"`, `rtol=atol=1e-5`': ("rustchain PECE, rtol", 1e-5),
    }
    for pretension, solver, wall, number, unit, residual in rows:
        lines = [line for line in RECORD["lines"] if line["scene"] == f"{pretension}, 0.2 s"]
        if solver == "CVODE":
            cvode = [x for x in lines if x["method"].startswith("CVODE") and x["residual"] < 1e-2]
            line = min(cvode, key=lambda x: x["wall"])
        else:
            line = next(x for x in lines if (x["method"], x["tolerance"]) == methods[solver])
        assert float(wall) == pytest.approx(line["wall"], rel=0.03)
        assert float(residual) == pytest.approx(line["residual"], rel=0.1)
        found = float(number) * {"thousand": 1e3, "million": 1e6}[unit]
        assert found == pytest.approx(line["steps"] / 0.2, rel=0.05)


def test_the_page_opens_with_a_table_of_few_lines_whose_ratios_are_those_of_its_times():
    page = (DOCS / "performance" / "work-precision.md").read_text(encoding="utf-8")
    opening = page[: page.index("## ")]
    titles, _, *rows = (
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in opening.splitlines()
        if line.startswith("|")
    )
    wanted = ["scene", "error", "rustchain", "time", "best other solver", "time", "ratio"]
    assert titles[:7] == wanted
    assert opening.index("| scene") < opening.index("![")
    assert 8 <= len(rows) <= 12
    for scene, _, _, own, _, other, ratio, *_ in rows:
        if not other:
            assert ratio == "does not reach it"
            continue
        own_time, other_time = (re.fullmatch(r"(\S+) (s/s|ms)", time) for time in (own, other))
        assert own_time[2] == other_time[2]
        # Three digits of the times, two of the ratio.
        quotient = float(other_time[1]) / float(own_time[1])
        assert float(ratio) == pytest.approx(quotient, rel=0.06), scene
    # Where the right-hand side costs next to nothing, other solvers are as fast: these stay in.
    assert {"planet", "pin, undamped", "pin, damped"} <= {row[0].split(", 10")[0] for row in rows}
