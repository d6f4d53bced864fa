"""Warnings point at the line that called the package, whatever lies between."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

import rustchain as rc
from cores import CoreAround, cores_within

PAPER = rc.paper_drive(25.0)
# Bristles that a RangeWarning tells.
OUTSIDE = rc.LankaraniNikravesh(friction=rc.LuGre(0.1, 0.1, stiffness=1e9))
SCENE = rc.Scene(PAPER, OUTSIDE)
SHORT = {"duration": 1e-3, "report_step": 1e-4, "progress": False}
SETTLED = {**SHORT, "duration": 8e-3, "burn_in": 4e-3}


def one(result):
    return 1.0


def speed(value):
    return rc.two_sprocket_drive(teeth=(17, 17), links=38, speed=value, torque=-1.0)


CALLS = {
    "run": lambda: rc.Simulation(PAPER, OUTSIDE).run(**SHORT),
    "step_to": lambda: rc.Simulation(PAPER, OUTSIDE).step_to(1e-3),
    "sweep": lambda: rc.sweep(SCENE, {"pretension": [25.0]}, one, **SHORT),
    "sweep with a stop condition": lambda: rc.sweep(
        SCENE, {"pretension": [25.0]}, one, stop=rc.TimeReached(1.0), **SHORT
    ),
    "study": lambda: rc.study(SCENE, one, runs=2, **SETTLED),
    "study over an axis": lambda: rc.study(
        SCENE, one, runs=2, axes={"pretension": [25.0, 50.0]}, **SETTLED
    ),
    "loss_map": lambda: rc.loss_map(rc.Scene(speed(20.0), OUTSIDE), [20.0], [-1.0], **SETTLED),
}


@pytest.mark.parametrize("call", CALLS)
def test_the_file_of_a_warning_is_the_callers(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        CALLS[call]()
    assert rc.RangeWarning in {warning.category for warning in caught}
    assert {warning.filename for warning in caught} == {__file__}


def test_the_warning_of_a_case_that_failed_points_at_the_caller():
    def failing(result):
        raise ValueError("no value")

    with pytest.warns(RuntimeWarning, match="1 of 1 cases failed") as caught:
        rc.sweep(PAPER, {"pretension": [25.0]}, failing, **SHORT)
    assert {warning.filename for warning in caught} == {__file__}


def test_the_warning_of_a_drawing_points_at_the_caller():
    mpl.use("Agg")
    result = rc.Simulation(PAPER).run(**SHORT)
    with pytest.warns(UserWarning, match="bodies were not recorded") as caught:
        result.plot.drive(time=5e-4)
    plt.close("all")
    assert {warning.filename for warning in caught} == {__file__}


def test_no_warning_of_the_package_counts_frames_itself():
    package = Path(rc.__file__).parent
    found = [
        path.name
        for path in package.rglob("*.py")
        if re.search(r"warnings\.warn\(|stacklevel", path.read_text("utf-8"))
    ]
    assert found == ["caller.py"]


def test_an_implausible_input_is_told_once_in_a_sweep():
    heavy = rc.Scene(replace(PAPER, gravity=(0.0, -9810.0)))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        swept = rc.sweep(heavy, {"rtol": [1e-5, 1e-4]}, one, **SHORT)
    assert swept.success
    told = [each for each in caught if str(each.message).startswith("gravity = 9810 m/s^2")]
    assert len(told) == 1
    assert (told[0].category, told[0].filename) == (rc.errors.RustchainWarning, __file__)


def test_an_implausible_input_that_is_an_error_fails_every_case():
    heavy = rc.Scene(replace(PAPER, gravity=(0.0, -9810.0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(rc.errors.RustchainWarning, match="gravity = 9810"):
            rc.sweep(heavy, {"rtol": [1e-5, 1e-4]}, one, **SHORT)


class Jumped(CoreAround):
    """A core that has a warning after a run."""

    told = False

    def take_warnings(self):
        new = self.core.time > 0.0 and not self.told
        self.told |= new
        return [], [], ["two teeth"] if new else []


@pytest.mark.parametrize("out", [None, "run.nc"])
def test_a_warning_raised_as_an_error_has_the_result_of_its_run(out, tmp_path):
    with cores_within(Jumped), warnings.catch_warnings():
        warnings.simplefilter("error", rc.ToothJumpWarning)
        simulation = rc.Simulation(PAPER)
        with pytest.raises(rc.ToothJumpWarning, match="two teeth") as caught:
            simulation.run(1e-3, out=None if out is None else tmp_path / out, progress=False)
    assert caught.value.result.success
    assert len(caught.value.result.time) == 11


def thrown_ring(law, speed=1.0):
    """Return a ring that is thrown onto its pin; dR = 1 um, where Johnson's law ends at 0.54 um."""
    m = rc.Mechanism(gravity=(0.0, 0.0))
    m.add_body("ring", 50.0, 1e-2, (0.0, 0.0, 0.0), (0.0, -speed, 0.0))
    m.add_clearance_joint(
        "pin",
        "ring",
        "ground",
        bore_radius=5.001e-3,
        pin_radius=5e-3,
        law=rc.SurfaceContact(law, length=1e-3),
        bore_point=(0.0, 0.0),
        pin_point=(0.0, 0.0),
    )
    return m


def test_a_contact_of_a_mechanism_past_the_end_of_its_law_is_told_once(tmp_path):
    simulation = rc.Simulation(thrown_ring(rc.Johnson()))
    message = 'johnson law, contact "pin": penetration .* past the end of the law, 5.413e-7 m'
    with pytest.warns(rc.RangeWarning, match=message) as said:
        simulation.run(1e-4, 1e-5, progress=False)
    assert len(said) == 1
    simulation.run(1e-4, 1e-5, progress=False)  # says nothing: a warning is an error here
    simulation.save_state(tmp_path / "past.npz")
    simulation.set_state(simulation.state())
    with pytest.warns(rc.RangeWarning) as again:
        rc.Simulation.load_state(tmp_path / "past.npz")
    assert [str(each.message) for each in again] == [str(each.message) for each in said]


def test_penetrations_of_a_mechanism_within_the_range_are_silent():
    rc.Simulation(thrown_ring(rc.Hertz())).run(1e-4, 1e-5, progress=False)
    slow = rc.Simulation(thrown_ring(rc.Johnson(), speed=1e-3)).run(5e-3, 1e-4, progress=False)
    assert 0.0 < slow.contact("pin").penetration.max() < 5.4e-7


def test_laws_and_bristles_of_a_mechanism_outside_their_range_are_told_when_it_is_made():
    enhanced = 'enhanced-cylinder law, contact "pin": its exponent .* here dR = 0.0010 mm'
    with pytest.warns(rc.RangeWarning, match=enhanced):
        rc.Simulation(thrown_ring(rc.EnhancedCylinder()))
    soft = rc.Hertz(friction=rc.LuGre(0.1, 0.1, stiffness=10.0))
    with pytest.warns(rc.RangeWarning, match='LuGre friction, contact "pin": bristles break away'):
        rc.Simulation(thrown_ring(soft))


def test_the_contacts_of_a_drive_as_a_mechanism_have_one_warning():
    drive = rc.two_sprocket_drive("ANSI 80", (17, 17), links=60, speed=5.0, pretension=50.0)
    law = rc.EnhancedCylinder()
    with pytest.warns(rc.RangeWarning) as said:
        rc.Simulation(drive.to_mechanism(force_law=law))
    (warning,) = said
    message = 'contact "bushing_1_on_sprocket_1" and 119 more: .* dR = 12.7778 mm'
    assert re.search(message, str(warning.message))
