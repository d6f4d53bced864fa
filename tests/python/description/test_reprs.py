"""What a prompt and a notebook show of descriptions and results."""

import dataclasses
import sys

import pytest

import rustchain as rc

DRIVE = rc.paper_drive(25.0)
RESULT = rc.Simulation(DRIVE).run(duration=4e-3, progress=False)


SWEEP = rc.sweep(
    DRIVE,
    {"pretension": [25.0, 50.0]},
    lambda result: {"force": result.peaks.hinge_force.max()},
    duration=1e-3,
    progress=False,
)
STUDY = rc.study(DRIVE, runs=2, duration=4e-3, burn_in=2e-3, progress=False)
SHOWN = {
    "drive": DRIVE,
    "report": DRIVE.check(),
    "result": RESULT,
    "summary": RESULT.summary(),
    "sweep": SWEEP,
    "study": STUDY,
}


def test_a_repr_has_what_differs_from_the_default():
    assert repr(rc.Material()) == "Material()"
    assert repr(rc.Material(restitution=0.5)) == "Material(restitution=0.5)"
    assert repr(rc.Johnson(damping="flores")) == "Johnson(damping='flores')"
    assert repr(rc.Sprocket(17, (0.2, 0.0), rc.PrescribedSpeed(20.0))) == (
        "Sprocket(teeth=17, center=(0.2, 0.0), motion=PrescribedSpeed(speed=20.0))"
    )


def test_a_repr_of_defaults_can_be_evaluated_again():
    law = rc.EnhancedCylinder(friction=rc.Coulomb(0.1))
    assert eval(repr(law), vars(rc)) == law


@pytest.mark.parametrize(
    "described",
    [
        DRIVE,
        DRIVE.chain,
        DRIVE.sprockets[0],
        rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=4),
        rc.PrescribedSpeed([(0.01 * k, 1.0 * k) for k in range(100)]),
        dataclasses.replace(DRIVE, name="x" * 300),
    ],
    ids=lambda described: type(described).__name__,
)
def test_a_repr_is_one_short_line(described):
    assert "\n" not in repr(described)
    assert len(repr(described)) <= 100
    assert repr(described).startswith(type(described).__name__)


@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_gets_a_table(name):
    html = SHOWN[name]._repr_html_()
    assert html.count("<table") == html.count("</table>") == 1
    assert html.count("<tr") > 1


@pytest.mark.parametrize("name", ["drive", "result", "sweep", "study"])
def test_a_notebook_gets_one_picture(name):
    assert SHOWN[name]._repr_html_().count("data:image/png;base64,") == 1


@pytest.mark.parametrize("name", ["drive", "result", "sweep", "study"])
def test_without_matplotlib_the_table_stays(name, monkeypatch):
    for module in [name for name in sys.modules if name.startswith("rustchain.plot")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    html = SHOWN[name]._repr_html_()
    assert "<table" in html
    assert "image/png" not in html


def test_a_summary_prints_as_a_table_with_units_and_is_a_dict():
    summary = RESULT.summary()
    assert summary["hinge_force_largest"] == RESULT.peaks.hinge_force.max()
    assert set(summary.units) == set(summary)
    line = next(row for row in str(summary).splitlines() if row.startswith("tension_upper "))
    assert line.split() == ["tension_upper", f"{summary['tension_upper']:.6g}", "N"]
    assert summary.units["hinge_contact_share"] == "1"
    assert summary.units["loss"] == "W"


def test_html_of_names_is_escaped():
    named = dataclasses.replace(DRIVE, name="<script>")
    assert "<script>" not in named._repr_html_()
