"""Every script in examples/ runs; the long ones with fewer runs of shorter duration."""

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

ROOT = Path(__file__).parents[3] / "examples"
# What is shortened, with what stands in its place.
BRIEF = {
    "film": [("BEGIN, END = 0.1, 0.15", "BEGIN, END = 0.01, 0.015")],
    "friction": [
        ("SETTLED = 200.0, 4.0, 0.05", "SETTLED = 200.0, 4.0, 0.005"),
        ("4.0 * 2.0 * np.pi", "0.5 * 2.0 * np.pi"),
    ],
    "outputs": [
        ("duration=1.5", "duration=0.7"),
        ("start=0.4", "start=0.1"),
    ],
    "paper_drive": [("duration=0.5", "duration=0.1")],
    "paper_study": [("runs=5", "runs=2"), ("duration=0.3", "duration=0.04"), ("0.15", "0.02")],
    "paper_study_rollers": [
        ("runs=5", "runs=2"),
        ("duration=0.3", "duration=0.04"),
        ("0.15", "0.02"),
    ],
    "tensioner": [
        ("SETTLED = 0.25, 0.12", "SETTLED = 0.015, 0.005"),
        ('"xatol": 0.1', '"maxiter": 3'),
    ],
    "tolerances": [
        ("CHAINS = 60", "CHAINS = 4"),
        ("SETTLED = 0.2, 0.1", "SETTLED = 0.02, 0.01"),
    ],
    "polygon_effect": [
        ("runs=4", "runs=2"),
        ("duration=0.4, burn_in=0.2", "duration=0.1, burn_in=0.05"),
    ],
}
SCRIPTS = sorted(ROOT.glob("*.py"))
# Largest share by which runs may differ from the formulae beside them, by the first word of a name.
PUBLISHED = {
    "conveyor_start": {"ramp": 0.05, "period": 0.06, "wave": 0.01},
    "hoist_load": {"at": 1e-6, "mean": 0.005, "largest": 0.01, "frequency": 0.03},
    "motorcycle_chain": {"tension": 0.01, "series": 0.03},  # 0.0036 to 0.0074 at four accuracies
    "timing_drive": {"mode": 0.03},
}
SLOW = (
    "friction",
    "outputs",
    "paper_study",
    "paper_study_rollers",
    "polygon_effect",
    *PUBLISHED,
)


@pytest.fixture
def _without_a_window():
    backend = mpl.get_backend()
    mpl.use("Agg")
    yield
    plt.close("all")
    mpl.use(backend)


@pytest.mark.usefixtures("_without_a_window")
@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=[pytest.mark.slow] * (p.stem in SLOW), id=p.stem) for p in SCRIPTS],
)
def test_an_example_runs_and_makes_its_picture(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = path.read_text(encoding="utf-8")
    for long, brief in BRIEF.get(path.stem, ()):
        assert long in text
        text = text.replace(long, brief)
    monkeypatch.setattr("sys.argv", [str(path)])  # as the gallery does, which has no __file__
    names = {"__name__": "__main__"}
    exec(compile(text, path, "exec"), names)
    pictures = list(tmp_path.glob(f"{path.stem}*.png"))
    assert pictures
    assert all(picture.stat().st_size > 5_000 for picture in pictures)
    bounds = PUBLISHED.get(path.stem, {})
    deviations = names.get("deviations", {})
    assert {name.split()[0] for name in deviations} == set(bounds)
    assert {n: d for n, d in deviations.items() if not abs(d) <= bounds[n.split()[0]]} == {}


def test_only_examples_that_exist_are_shortened_or_slow():
    assert {*BRIEF, *SLOW} <= {path.stem for path in SCRIPTS}
