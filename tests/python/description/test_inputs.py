"""Speeds and torques that are set while a drive runs: co-simulation and controllers."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

import rustchain as rc

SPEED = 4.0 * np.pi


@pytest.fixture(params=["clearance", "ideal"])
def simulation(request):
    return rc.Simulation(rc.paper_drive(pretension=25.0, hinges=request.param))


def sprocket(simulation, number):
    row = simulation.body_names.index(f"sprocket_{number}")
    return simulation.positions[row, 2], simulation.velocities[row, 2]


@pytest.mark.parametrize("name", ["sprocket_1", 1])
def test_a_sprocket_turns_on_from_its_angle_at_the_speed_that_is_set(simulation, name):
    simulation.step_to(1.2345e-3)
    angle, _ = sprocket(simulation, 1)
    simulation.set_speed(name, 10.0)
    assert sprocket(simulation, 1) == pytest.approx((angle, 10.0), abs=1e-14)
    simulation.step_to(2.2345e-3)
    assert sprocket(simulation, 1) == pytest.approx((angle + 0.01, 10.0), abs=1e-13)


def test_rows_from_the_present_speed_on_make_a_ramp(simulation):
    simulation.step_to(1e-3)
    simulation.set_speed("sprocket_1", [(1e-3, SPEED), (2e-3, SPEED + 1.0)])
    for t, speed in [(1e-3, SPEED), (1.5e-3, SPEED + 0.5), (3e-3, SPEED + 1.0)]:
        simulation.step_to(t)
        assert sprocket(simulation, 1)[1] == pytest.approx(speed, abs=1e-12)


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
def test_a_torque_set_at_once_is_that_of_the_drive_described_with_it(hinges):
    drive = rc.paper_drive(hinges=hinges)
    driver, driven = drive.sprockets
    loaded = rc.ChainDrive(
        drive.chain,
        (driver, rc.Sprocket(**vars(driven) | {"motion": rc.AppliedTorque(-0.5)})),
        hinges=hinges,
    )
    described, told = rc.Simulation(loaded), rc.Simulation(drive)
    told.set_torque("sprocket_2", -0.5)
    for simulation in (described, told):
        simulation.step_to(3e-3)
    np.testing.assert_array_equal(told.positions, described.positions)


def test_the_balance_counts_the_work_of_what_is_set_by_a_callback(simulation):
    def brake(simulation):
        simulation.set_torque(2, -40.0 * simulation.time)

    result = simulation.run(0.02, 1e-4, progress=False, callback=brake)
    torque = result.sprocket(2).torque
    # A row shows what held when it was reached.
    np.testing.assert_allclose(torque[1:], -40.0 * result.time[:-1], atol=1e-12)
    energy = result.energy
    work = np.abs(energy.external_work).max()
    assert work > 1e-3
    assert np.abs(energy.residual).max() < 0.01 * work


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (
            lambda s: s.set_speed("sprocket_3", 1.0),
            "no sprocket; did you mean 'sprocket_",
        ),
        (
            lambda s: s.set_speed("wheel", 1.0),
            "no sprocket; known: 'sprocket_1', 'sprocket_2'",
        ),
        (lambda s: s.set_speed(True, 1.0), "True is no sprocket; known"),
        (lambda s: s.set_speed("sprocket_2", 1.0), "describe it with PrescribedSpeed"),
        (lambda s: s.set_torque("sprocket_1", 1.0), "describe it with AppliedTorque or Free"),
        (lambda s: s.set_torque(2, "much"), "'much': must be a number in N m"),
        (lambda s: s.set_torque(2, np.inf), "torque = inf"),
        (lambda s: s.set_torque(2, [(1.0, 0.0), (0.0, 1.0)]), "times must increase"),
    ],
)
def test_what_cannot_be_set_is_refused_and_nothing_is_changed(simulation, call, text):
    simulation.step_to(1e-3)
    before = simulation.state()["snapshot"]
    with pytest.raises(rc.InvalidInput, match=text):
        call(simulation)
    assert simulation.state()["snapshot"] == before


def test_ideal_hinges_take_the_power_of_the_torque_that_is_set():
    """The power at the shafts of an ideal drive is what its energies and losses show."""
    simulation = rc.Simulation(rc.paper_drive(hinges="ideal"))
    simulation.run(4e-3, progress=False)
    simulation.set_torque("sprocket_2", -2.0)
    result = simulation.run(4e-3, 2e-6, progress=False)
    shafts = [result.sprocket(number) for number in (1, 2)]
    np.testing.assert_array_equal(shafts[1].torque, -2.0)
    power = sum(shaft.torque * shaft.speed for shaft in shafts)
    work = trapezoid(power, result.time)
    assert result.energy.external_work[-1] == pytest.approx(work, rel=1e-3)
    assert trapezoid(shafts[1].torque * shafts[1].speed, result.time) < -0.05


def test_a_torque_on_ideal_hinges_is_met_as_with_little_clearance():
    """Mean torque of the driver against a load that is set: hinges with a clearance of 1 um."""
    mean = {}
    for hinges in ("ideal", "clearance"):
        drive = rc.paper_drive(pretension=25.0, hinges=hinges)
        hinge = replace(drive.chain.hinge, bore_radius=drive.chain.hinge.pin_radius + 1e-6)
        drive = replace(drive, chain=replace(drive.chain, hinge=hinge))
        simulation = rc.Simulation(drive)
        simulation.step_to(5e-3)
        simulation.set_torque("sprocket_2", -2.0)
        simulation.step_to(0.03)
        result = simulation.run(0.04, progress=False)
        mean[hinges] = result.sprocket(1).torque.mean()
    assert mean["ideal"] == pytest.approx(2.0, rel=0.1)
    assert mean["ideal"] == pytest.approx(mean["clearance"], rel=0.05)


@pytest.mark.parametrize("force", [math.nan, [(0.0, 1.0), (1.0, 2.0)], rc.Sines([(2.0, 3.0, 0.0)])])
def test_a_force_of_the_tensioner_is_one_number(force):
    simulation = rc.Simulation(rc.paper_drive(25.0))
    with pytest.raises(rc.InvalidInput, match=r"must be a (finite )?number in N"):
        simulation.set_tensioner_force(force)
