"""Prescribed speeds, torques and tensioners: motion, reactions and the energy balance."""

import math
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc

END = 8.3e-3  # [s], after the first contacts of hinges and teeth
ALL = ("hinges", "teeth", "sprockets", "bodies", "energy")
SPEED = 4 * math.pi  # of the paper's driver [rad/s]


def with_motions(first, second=None, drive=None, **changes):
    """A drive whose sprockets move as told."""
    drive = drive or rc.paper_drive()
    motions = first, second or rc.Free()
    sprockets = [
        replace(sprocket, motion=motion)
        for sprocket, motion in zip(drive.sprockets, motions, strict=True)
    ]
    return replace(drive, sprockets=sprockets, **changes)


def test_a_prescribed_speed_follows_its_table():
    times, speeds = np.array([0.0, 2e-3, 4e-3]), np.array([0.0, 10.0, 4.0])
    drive = with_motions(rc.PrescribedSpeed(np.stack([times, speeds], axis=1)))
    simulation = rc.Simulation(drive)
    assert not simulation.velocities.any()  # from rest
    assert simulation.evaluate(time=1e-3).accelerations[38, 2] == pytest.approx(5000.0)
    assert simulation.evaluate(time=3e-3).accelerations[38, 2] == pytest.approx(-3000.0)
    assert simulation.evaluate(time=9e-3).accelerations[38, 2] == 0.0
    result = simulation.run(6e-3, 1e-5, record=("sprockets",), progress=False)
    driver = result.sprocket(1)
    np.testing.assert_allclose(
        driver.speed, np.interp(result.time, times, speeds), rtol=1e-12, atol=1e-12
    )
    fine = np.linspace(0.0, 6e-3, 6001)
    values = np.interp(fine, times, speeds)
    turned = np.concatenate([[0.0], np.cumsum(0.5e-6 * (values[1:] + values[:-1]))])
    angle = driver.angle - driver.angle[0]
    np.testing.assert_allclose(angle, np.interp(result.time, fine, turned), rtol=0.0, atol=1e-10)


def test_a_table_begins_at_its_value_at_time_zero():
    simulation = rc.Simulation(with_motions(rc.PrescribedSpeed([(-1.0, 4.0), (1.0, 8.0)])))
    assert simulation.velocities[38, 2] == pytest.approx(6.0)
    assert simulation.velocities[39, 2] == pytest.approx(6.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_torque_accelerates_a_sprocket_before_anything_touches(sign):
    drive = with_motions(rc.AppliedTorque(0.02 * sign), gravity=(0.0, 0.0))
    simulation = rc.Simulation(drive)
    assert not simulation.velocities.any()
    inertia = drive.sprockets[0].inertia
    assert simulation.evaluate().accelerations[38, 2] == pytest.approx(0.02 * sign / inertia)
    result = simulation.run(2e-3, 1e-4, record=("sprockets", "teeth", "energy"), progress=False)
    driver = result.sprocket(1)
    assert not result.array("tooth_force").any()
    np.testing.assert_allclose(driver.torque, 0.02 * sign)
    np.testing.assert_allclose(
        driver.speed, 0.02 * sign / inertia * result.time, rtol=1e-9, atol=1e-12
    )
    assert result.energy.external_work[-1] == pytest.approx(result.energy.kinetic[-1], rel=1e-6)


def test_a_torque_follows_its_table():
    drive = with_motions(rc.PrescribedSpeed(SPEED), rc.AppliedTorque([(1e-3, 0.0), (3e-3, -0.4)]))
    result = rc.Simulation(drive).run(5e-3, 1e-4, record=("sprockets",), progress=False)
    expected = np.interp(result.time, [1e-3, 3e-3], [0.0, -0.4])
    np.testing.assert_allclose(result.sprocket(2).torque, expected, atol=1e-15)
    assert result.sprocket(2).speed[-1] < SPEED


def test_a_braked_drive_carries_its_load_in_the_pulling_strand():
    """The driver turns counterclockwise, so that it pulls at the upper strand."""
    load = 0.5
    drive = with_motions(rc.PrescribedSpeed(SPEED), rc.AppliedTorque([(0.0, 0.0), (0.02, -load)]))
    result = rc.Simulation(drive).run(0.06, 1e-4, progress=False)
    late = result.time > 0.04
    pull = load / 0.03456
    tensions = {name: result.strand(name).tension[late].mean() for name in ("upper", "lower")}
    tight, slack = sorted(tensions.values(), reverse=True)
    assert tight == pytest.approx(pull, rel=0.25)
    assert slack < 0.3 * pull
    assert max(tensions, key=tensions.get) == "upper"
    assert result.sprocket(1).torque[late].mean() == pytest.approx(load, rel=0.25)


def test_without_motion_and_gravity_nothing_moves():
    simulation = rc.Simulation(with_motions(rc.Free(), gravity=(0.0, 0.0)))
    start = simulation.positions
    result = simulation.run(0.01, record=ALL, progress=False)
    np.testing.assert_array_equal(simulation.positions, start)
    assert not result.array("hinge_force").any()
    assert not result.array("sprocket_torque").any()


def test_a_free_drive_falls_from_rest_and_is_caught():
    result = rc.Simulation(with_motions(rc.Free())).run(0.02, record=ALL, progress=False)
    assert not result.array("velocities")[0].any()
    assert result.array("hinge_force").any()
    assert result.energy.kinetic[0] == 0.0
    assert not result.energy.external_work.any()
    # 32 runs whose accuracies differ by a percent each: 1.4e-6 J (RMS), 2.1e-6 J at most.
    assert abs(result.energy.residual).max() < 3e-6


def test_an_initial_speed_sets_the_chain_going():
    drive = rc.paper_drive()
    sprockets = [
        replace(drive.sprockets[0], motion=rc.Free(), initial_speed=SPEED),
        drive.sprockets[1],
    ]
    simulation = rc.Simulation(replace(drive, sprockets=sprockets))
    np.testing.assert_allclose(
        simulation.velocities, rc.Simulation(drive).velocities, rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("teeth", [(17, 17), (17, 25)])
def test_the_other_way_round_works_too(teeth):
    links = {(17, 17): 38, (17, 25): 60}[teeth]
    drive = rc.two_sprocket_drive(chain="ANSI 40", teeth=teeth, links=links, speed=-12.566)
    simulation = rc.Simulation(drive)
    ratio = teeth[0] / teeth[1]
    assert simulation.velocities[links, 2] == -12.566
    assert simulation.velocities[links + 1, 2] == pytest.approx(-12.566 * ratio, rel=0.02)
    result = simulation.run(0.02, progress=False)
    np.testing.assert_allclose(result.sprocket(1).speed, -12.566)
    assert result.sprocket(2).speed.mean() == pytest.approx(-12.566 * ratio, rel=0.05)
    assert (np.diff(result.sprocket(1).angle) < 0.0).all()
    assert result.array("tooth_force").any()
    through = result.energy.dissipated[-1] + abs(result.energy.external_work[-1])
    assert abs(result.energy.residual).max() < 0.02 * through


def test_the_work_put_in_is_torque_times_angle():
    drive = with_motions(rc.PrescribedSpeed(SPEED), rc.AppliedTorque(-0.2), rc.paper_drive(25.0))
    simulation = rc.Simulation(drive)
    result = simulation.run(0.012, 5e-7, record=("sprockets", "energy"), progress=False)
    t, energy = result.time, result.energy
    center = result.sprocket(2).center[:, 0]
    pull = 50.0 * np.minimum(t / 0.1, 1.0)
    work = np.zeros_like(t)
    for number in (1, 2):
        sprocket = result.sprocket(number)
        work[1:] += np.cumsum(
            0.5 * np.diff(sprocket.angle) * (sprocket.torque[1:] + sprocket.torque[:-1])
        )
    work[1:] += np.cumsum(0.5 * np.diff(center) * (pull[1:] + pull[:-1]))
    largest = abs(energy.external_work).max()
    assert largest > 1e-3
    np.testing.assert_allclose(work, energy.external_work, rtol=0.0, atol=0.01 * largest)
    assert abs(energy.residual).max() < 0.01 * largest


def _loaded(links: int = 60, teeth: tuple[int, int] = (17, 25), **changes: object) -> rc.ChainDrive:
    """Return a drive under 5 N m with another first sprocket."""
    drive = rc.two_sprocket_drive("ANSI 40", teeth=teeth, links=links, speed=20.0, torque=-5.0)
    first, second = drive.sprockets
    return replace(drive, sprockets=(replace(first, **changes), second))


WORKS = {
    "60 links": _loaded,
    "61 links": lambda: _loaded(61),
    "9 links": lambda: _loaded(9, (5, 5)),
    "eccentric": lambda: _loaded(eccentricity=2e-4),
    "two motors": lambda: with_motions(
        rc.PrescribedSpeed(20.0), rc.PrescribedSpeed(20.0 * 17 / 25), _loaded()
    ),
    "friction": _loaded,
    "bristles": _loaded,
    "ideal hinges": lambda: replace(_loaded(), hinges="ideal"),
}
WORKING_LAWS = {
    "friction": rc.LankaraniNikravesh(friction=rc.Coulomb(0.1)),
    "bristles": rc.LankaraniNikravesh(friction=rc.LuGre(0.12, 0.1)),
}


@pytest.mark.parametrize("scene", WORKS)
def test_work_of_prescribed_speeds_is_torque_times_angle(scene):
    # Torques of rows are those along the path of a step, and the work is that of its impulses. They
    # converge: 1e-8 to 6e-6 of the work that flows through, and 8e-8 to 4e-4 at 1e-10 m.
    simulation = rc.Simulation(
        WORKS[scene](),
        rc.LankaraniNikravesh(),
        tooth_law=WORKING_LAWS.get(scene),
        solver=rc.Solver(accuracy=1e-11),
    )
    simulation.step_to(5e-3)
    result = simulation.run(1.5e-3, 2e-7, record=("sprockets", "energy"), progress=False)
    work, through = 0.0, 0.0
    for number in (1, 2):
        sprocket = result.sprocket(number)
        gains = 0.5 * np.diff(sprocket.angle) * (sprocket.torque[1:] + sprocket.torque[:-1])
        work, through = work + np.cumsum(gains), through + np.abs(gains).sum()
    gained = result.energy.external_work[1:] - result.energy.external_work[0]
    np.testing.assert_allclose(gained, work, rtol=0.0, atol=3e-5 * through)


def test_the_balance_does_not_depend_on_when_it_begins():
    """A balance begun in the middle of a run gains what one kept from the start gains."""
    whole = rc.Simulation(rc.paper_drive(25.0)).run(END, 1e-4, record="energy", progress=False)
    simulation = rc.Simulation(rc.paper_drive(25.0))
    simulation.step_to(5e-3)
    part = simulation.run(END - 5e-3, 1e-4, record="energy", progress=False)
    for name in ("kinetic", "gravity", "elastic"):
        values, all_values = getattr(part.energy, name), getattr(whole.energy, name)
        np.testing.assert_allclose(values, all_values[50:], rtol=1e-6, atol=1e-9)
    for name in ("dissipated", "external_work"):
        values, all_values = getattr(part.energy, name), getattr(whole.energy, name)
        gain, whole_gain = values[-1] - values[0], all_values[-1] - all_values[50]
        assert gain == pytest.approx(whole_gain, rel=1e-3)


def test_a_balance_that_begins_inside_a_step_closes_from_there():
    # 1.5e-6 of the work. With the power at the end of that step in all of its rest: 6.5e-5.
    drive = rc.two_sprocket_drive(
        "ANSI 40", teeth=(17, 25), links=60, speed=20.0, torque=-2.0, pretension=50.0
    )
    simulation = rc.Simulation(drive)
    simulation.step_to(3.3e-4)
    energy = simulation.run(5e-4, 5e-5, record="energy", progress=False).energy
    assert abs(energy.residual).max() < 1e-5 * np.ptp(energy.external_work)


def test_no_pretension_is_no_tensioner():
    assert rc.paper_drive(pretension=0.0).tensioner is None
    tensioner = rc.paper_drive(pretension=100.0).tensioner
    assert (tensioner.sprocket, tensioner.ramp_time, tensioner.damping) == (2, 0.1, 2000.0)


def test_the_pull_gives_both_strands_the_pretension():
    assert rc.paper_drive(pretension=25.0).check().tension_force == pytest.approx(50.0)
    drive = rc.two_sprocket_drive(teeth=(17, 25), links=60, pretension=25.0)
    report = drive.check()
    slope = (report.pitch_radius[1] - report.pitch_radius[0]) / report.center_distance
    assert report.tension_force == pytest.approx(50.0 * math.sqrt(1.0 - slope**2), rel=1e-12)


@pytest.mark.parametrize(
    ("sprocket", "direction", "along"),
    [(2, None, (1.0, 0.0)), (1, None, (-1.0, 0.0)), (2, (3.0, 4.0), (0.6, 0.8))],
)
def test_the_pull_grows_along_its_direction(sprocket, direction, along):
    tensioner = rc.Tensioner(25.0, sprocket=sprocket, ramp_time=0.02, direction=direction)
    simulation = rc.Simulation(replace(rc.paper_drive(), tensioner=tensioner, gravity=(0.0, 0.0)))
    body = 37 + sprocket
    # 19 hinges between the sprockets, open by their clearance; the centre has left the line of
    # centres by then.
    taut = 10.5 * 0.0127 + 19 * 25e-6
    across = along[1] * simulation.positions[39, 0] / taut
    for time, share in ((0.0, 0.0), (0.005, 0.25), (0.02, 1.0), (1.0, 1.0)):
        acceleration = simulation.evaluate(time=time).accelerations[body, :2]
        # The part along the direction of the force that 25 N in both strands exert.
        expected = share * 50.0 * math.sqrt(1.0 - across**2) / 0.817 * np.array(along)
        np.testing.assert_allclose(acceleration, expected, rtol=1e-9, atol=1e-12)
    # The dashpot takes 2000 N at 1 m/s; nothing but the slide's direction counts.
    velocities = simulation.velocities.copy()
    velocities[body, :2] = 0.01 * np.array(along)
    acceleration = simulation.evaluate(velocities=velocities, time=0.0).accelerations[body, :2]
    np.testing.assert_allclose(acceleration, -20.0 / 0.817 * np.array(along), rtol=1e-9, atol=1e-9)


def test_a_tensioned_centre_stays_on_its_line():
    tensioner = rc.Tensioner(25.0, ramp_time=0.0, direction=(1.0, 0.01))
    drive = replace(rc.paper_drive(), tensioner=tensioner)
    result = rc.Simulation(drive).run(5e-3, record=("sprockets", "energy"), progress=False)
    moved = result.sprocket(2).center - result.sprocket(2).center[0]
    assert moved[-1, 0] > 1e-6
    np.testing.assert_allclose(moved[:, 1], 0.01 * moved[:, 0], atol=1e-15)
    assert not np.ptp(result.sprocket(1).center, axis=0).any()


def test_a_floating_sprocket_falls():
    drive = rc.paper_drive()
    sprockets = [drive.sprockets[0], replace(drive.sprockets[1], bearing="floating")]
    simulation = rc.Simulation(replace(drive, sprockets=sprockets))
    assert simulation.evaluate().accelerations[39].tolist() == [0.0, -9.81, 0.0]
    simulation.step_to(1e-3)
    assert simulation.velocities[39, 1] == pytest.approx(-9.81e-3, rel=1e-6)
