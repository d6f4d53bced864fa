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


def bouncing_ball():
    m = rc.Mechanism(name="ball <on> floor")
    m.add_body("ball", 1.0, 1e-3, position=(0.5, 0.0505, 0.0), velocity=(0.0, -0.4, 0.0))
    floor = [(0.9, 0.0), (0.1, 0.0)]
    law = rc.LinearContact(1e5, 20.0)
    m.add_outline_contact("floor", "ground", "ball", floor, 0.05, law, closed=False)
    m.add_body("arm", 0.4, 1e-3, position=(0.05, 0.0, 0.0))
    m.add_revolute("bearing", "ground", "arm", at=(0.0, 0.0))
    return m


MECHANISM = bouncing_ball()
BOUNCE = rc.Simulation(MECHANISM).run(duration=4e-3, progress=False)
STUDY = rc.study(DRIVE, runs=2, duration=4e-3, burn_in=2e-3, progress=False)
SHOWN = {
    "drive": DRIVE,
    "report": DRIVE.check(),
    "result": RESULT,
    "summary": RESULT.summary(),
    "sweep": SWEEP,
    "study": STUDY,
    "mechanism": MECHANISM,
    "report of a mechanism": MECHANISM.check(),
    "result of a mechanism": BOUNCE,
}
PICTURED = [name for name in SHOWN if name != "summary"]


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


@pytest.mark.parametrize(
    "shown",
    [
        DRIVE.check(),
        MECHANISM,
        MECHANISM.check(),
        RESULT.hinge(1),
        RESULT.bushing(6),
        RESULT.strand("upper"),
        RESULT.sprocket(1),
        RESULT.energy,
        RESULT.peaks,
        BOUNCE.energy,
        BOUNCE.body("ball"),
        BOUNCE.joint("bearing"),
        BOUNCE.contact("floor"),
        rc.Simulation(DRIVE).evaluate(),
        RESULT,
        SWEEP,
        STUDY,
    ],
    ids=lambda shown: type(shown).__name__,
)
def test_a_repr_of_what_is_computed_is_one_line(shown):
    assert "\n" not in repr(shown)
    assert len(repr(shown)) <= 150
    assert type(shown).__name__ in repr(shown)


def test_a_repr_of_a_part_of_a_result_has_its_arrays_and_rows():
    assert repr(RESULT.strand("upper")) == "<Strand: 41 rows of time, tension>"
    assert repr(DRIVE.check()).startswith("<DriveReport: 38 links of 12.7 mm, teeth 17, 17, ")
    assert repr(MECHANISM.check()).startswith("<MechanismReport: 4 degrees of freedom, 0 redund")


@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_gets_a_table(name):
    html = SHOWN[name]._repr_html_()
    assert html.count("<table") == html.count("</table>") == 1
    assert html.count("<tr") > 1


@pytest.mark.parametrize("name", PICTURED)
def test_a_notebook_gets_one_picture(name):
    assert SHOWN[name]._repr_html_().count("data:image/png;base64,") == 1


@pytest.mark.parametrize("name", PICTURED)
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
    assert "<on>" not in MECHANISM._repr_html_()


def test_one_thing_has_no_plural_and_a_drive_without_tensioner_no_force_of_it():
    mechanism = rc.Mechanism(gravity=(0.0, -9.81))
    mechanism.add_body("bar", mass=1.0, inertia=0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", at=(0.0, 0.0))
    assert repr(mechanism) == "<Mechanism '': 1 body, 1 joint, 0 forces, 0 contacts>"
    assert repr(mechanism.check()).startswith("<MechanismReport: 1 degree of freedom, ")
    row = rc.Simulation(mechanism).run(0.01, progress=False).between(end=0.0)
    assert "in 1 row:" in repr(row)
    labels = [label for label, *_ in dataclasses.replace(DRIVE, tensioner=None).check().rows()]
    assert "tensioner force" not in labels
    labels = [label for label, *_ in rc.paper_drive(25.0).check().rows()]
    assert "tensioner force" in labels
