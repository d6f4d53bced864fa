"""Powers of shafts where other sources put work in."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

import rustchain as rc


def two(speed=25.0):
    return rc.two_sprocket_drive("ANSI 40", teeth=(17, 25), links=60, speed=speed, pretension=60.0)


def assert_balanced(power):
    """Assert that work put in is what is lost and stored, but for the residual."""
    put_in = float(power["shaft_power"].sum()) + float(power["other_work"])
    taken = float(power["loss"].sum()) + float(power["stored"].sum())
    scale = float(np.abs(power["shaft_power"]).max()) + taken
    assert put_in + float(power["residual"]) == pytest.approx(taken, abs=1e-9 * scale)


def test_a_torque_set_on_a_free_sprocket_is_a_load():
    simulation = rc.Simulation(two(), start="static")
    simulation.set_torque("sprocket_2", -3.0)
    result = simulation.run(0.03, progress=False).between(0.01)
    power = result.power_balance()
    load = 3.0 * np.ptp(result.sprocket(2).angle) / np.ptp(result.time)
    assert float(power["shaft_power"][1]) == pytest.approx(-load, rel=1e-4)
    # The motor turns at 25 rad/s against 3 N m over the ratio of the teeth.
    assert float(power["shaft_power"][0]) == pytest.approx(25.0 * 3.0 * 17 / 25, rel=0.03)
    lost = float(power["loss"].sum())
    assert result.summary()["efficiency"] == pytest.approx(load / (load + lost), rel=1e-4)
    assert float(power["other_work"]) == 0.0
    assert_balanced(power)


def sampled(result, number):
    """Return the mean of torque times speed over the rows [W]."""
    motion = result.sprocket(number)
    return trapezoid(motion.torque * motion.speed, result.time) / np.ptp(result.time)


@pytest.mark.parametrize("speed", [0.0, 2.0])
def test_the_work_of_a_moved_end_is_not_that_of_a_shaft(speed):
    """The end draws the chain round a wheel that is held, or turned with it."""
    wheel = rc.Sprocket(17, motion=rc.PrescribedSpeed(speed))
    end = rc.AnchoredEnd((-0.2, -0.05), velocity=(-0.3, 0.0))
    drive = rc.open_chain("ANSI 40", (end, rc.LoadedEnd(10.0)), 70, [wheel])
    result = rc.Simulation(drive, start="static").run(5e-3, 2e-5, progress=False)
    power = result.power_balance()
    shaft = float(power["shaft_power"][0])
    assert shaft == pytest.approx(sampled(result, 1))
    assert (shaft == 0.0) == (speed == 0.0)
    first = result.end(1)
    by_end = -trapezoid((first.force * first.velocity).sum(axis=1), result.time) / 5e-3
    assert by_end > 0.5
    assert float(power["other_work"]) == pytest.approx(by_end, rel=0.01)
    assert_balanced(power)


def test_an_end_at_rest_leaves_all_work_to_the_only_motor():
    wheel = rc.Sprocket(17, motion=rc.PrescribedSpeed(2.0))
    ends = rc.AnchoredEnd((-0.2, -0.05)), rc.LoadedEnd(10.0)
    drive = rc.open_chain("ANSI 40", ends, 70, [wheel])
    result = rc.Simulation(drive, start="static").run(5e-3, progress=False)
    power = result.power_balance()
    work = np.ptp(result.energy.external_work) / 5e-3
    assert float(power["shaft_power"][0]) == pytest.approx(work, rel=1e-12)
    assert float(power["other_work"]) == 0.0


def test_two_motors_have_the_powers_of_the_rows_and_the_rest_is_named():
    drive = two()
    second = replace(drive.sprockets[1], motion=rc.PrescribedSpeed(17.0))
    drive = replace(drive, sprockets=[drive.sprockets[0], second])
    result = rc.Simulation(drive, start="static").run(0.02, progress=False)
    power = result.power_balance()
    expected = [sampled(result, number) for number in (1, 2)]
    np.testing.assert_allclose(power["shaft_power"], expected, rtol=1e-12)
    assert float(power["other_work"]) != 0.0
    assert_balanced(power)


def test_a_motor_at_rest_does_no_work_while_the_tensioner_pulls():
    result = rc.Simulation(two(speed=0.0)).run(0.02, progress=False)
    power = result.power_balance()
    np.testing.assert_array_equal(power["shaft_power"], 0.0)
    assert float(power["other_work"]) > 0.0
    assert_balanced(power)
    labels = [each.get_text() for each in result.plot.power_balance().axes[1].get_yticklabels()]
    assert "other work" in labels


def test_the_work_of_a_plunger_is_that_of_its_torque_on_the_arm():
    drive = rc.two_sprocket_drive(
        chain="ANSI 40", teeth=(17, 17), links=60, center_distance=0.2715, speed=10.0, torque=-1.0
    )
    arm = rc.GuideArm((0.055, -0.075), force=40.0, ramp_time=0.0)
    blade = rc.GuideRail((0.136, -0.07), (0.0, 1.0), length=0.12, radius=0.25, arm=arm)
    result = rc.Simulation(replace(drive, guides=[blade])).run(0.01, progress=False)
    swung = result.guide(1)
    torque = 40.0 * (0.136 - 0.055)  # the plunger presses on the rail's middle
    np.testing.assert_allclose(swung.torque, torque)
    power = result.power_balance()
    work = torque * (swung.angle[-1] - swung.angle[0])
    assert work > 0.0
    assert float(power["other_work"]) * 0.01 == pytest.approx(work, rel=0.02)
    assert_balanced(power)
