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
