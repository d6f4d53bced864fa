"""The examples of layouts: each lays its chain, checks, runs for a moment and makes its picture."""

import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rustchain as rc

LAYOUTS = Path(__file__).parents[3] / "examples" / "layouts"


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
