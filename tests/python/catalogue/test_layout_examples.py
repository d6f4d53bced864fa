"""The examples of layouts: each lays its chain, checks, runs for a moment and makes its picture."""

import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rustchain as rc

ROOT = Path(__file__).parents[3]
LAYOUTS = ROOT / "examples" / "layouts"


@pytest.mark.parametrize("path", sorted(LAYOUTS.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_lays_checks_runs_and_makes_its_picture(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    whole = rc.Simulation.run
    results = []

    def briefly(simulation, duration, report_step=1e-4, **options):
        # As many rows as in the example, in two thousandths of a second.
        rows = round(duration / report_step)
        results.append(whole(simulation, 2e-3, 2e-3 / rows, progress=False, **options))
        return results[-1]

    monkeypatch.setattr(rc.Simulation, "run", briefly)
    try:
        runpy.run_path(str(path), run_name="__main__")
    finally:
        plt.close("all")
    assert (tmp_path / f"{path.stem}.png").stat().st_size > 10_000
    assert capsys.readouterr().out
    for result in results:
        assert result.success
        assert np.all(np.isfinite(result.final_positions))


def test_both_guides_of_the_page_have_contact():
    page = (ROOT / "docs" / "howto" / "layouts.md").read_text(encoding="utf-8")
    block = next(b for b in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "GuideArm" in b)
    names = {"rc": rc}
    exec(block, names)
    assert not [text for text in names["drive"].check().warnings if "guide" in text]
    result = rc.Simulation(names["drive"], start="static").run(0.01, progress=False)
    assert all(result.guide_loads(guide).attrs["mean_force"] > 0.0 for guide in (1, 2))
