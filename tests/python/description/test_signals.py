"""Functions of time: what they prescribe in drives and mechanisms, and what is refused."""

import copy
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import rustchain as rc

SPEED = 4.0 * math.pi
END = 2e-3
WAVES = rc.Sines([(2.0, 3000.0, 0.4)], offset=SPEED)
RISE = rc.SmoothStep(5e-4, 1.5e-3, SPEED, SPEED + 2.0)
ARCH = rc.Spline([(0.0, SPEED), (1e-3, SPEED + 1.5), (2e-3, SPEED)])
RAMP = rc.Table([(0.0, SPEED), (1e-3, SPEED + 1.5), (2e-3, SPEED)])
SIGNALS = {
    "sines": (WAVES, SPEED * END + 2.0 / 3000.0 * (math.cos(0.4) - math.cos(3000.0 * END + 0.4))),
    "smooth step": (RISE, SPEED * END + 2.0 * END / 2.0),
    "spline": (ARCH, SPEED * END + 2.0 * 0.625 * 1.5e-3),
    "table": (RAMP, SPEED * END + 1.5e-3),
}


def drive_with(speed=SPEED, torque=None, **keywords):
    drive = rc.paper_drive(**keywords)
    motions = (rc.PrescribedSpeed(speed), rc.Free() if torque is None else rc.AppliedTorque(torque))
    wheels = [replace(s, motion=m) for s, m in zip(drive.sprockets, motions, strict=True)]
    return replace(drive, sprockets=wheels)


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
@pytest.mark.parametrize("name", SIGNALS)
def test_a_sprocket_turns_by_the_integral_of_its_speed(name, hinges):
    signal, turned = SIGNALS[name]
    simulation = rc.Simulation(drive_with(signal, hinges=hinges))
    start = simulation.positions[-2, 2]
    simulation.step_to(END)
    assert simulation.positions[-2, 2] - start == pytest.approx(turned, abs=1e-12)


def test_a_mechanism_follows_the_same_signals():
    for signal, turned in SIGNALS.values():
        mechanism = rc.Mechanism()
        mechanism.add_body("wheel", 1.0, 0.1)
        mechanism.add_revolute("axle", "ground", "wheel")
        mechanism.add_driver("motor", "ground", "wheel", speed=signal)
        simulation = rc.Simulation(mechanism)
        simulation.step_to(END)
        assert simulation.positions[0, 2] == pytest.approx(turned, abs=1e-12)
        torque = rc.Mechanism()
        torque.add_body("wheel", 1.0, 2.0)
        torque.add_revolute("axle", "ground", "wheel")
        torque.add_torque("load", "wheel", signal)
        simulation = rc.Simulation(torque)
        simulation.step_to(END)
        assert simulation.velocities[0, 2] == pytest.approx(turned / 2.0, rel=1e-6)


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
def test_a_load_is_reported_as_its_signal_has_it(hinges):
    load = rc.Sines([(0.5, 2000.0, 0.0)], offset=-0.8)
    result = rc.Simulation(drive_with(torque=load, pretension=25.0, hinges=hinges)).run(
        3e-3, 1e-4, progress=False
    )
    expected = -0.8 + 0.5 * np.sin(2000.0 * result.time)
    assert_allclose(result.sprocket(2).torque, expected, atol=1e-12)


def test_rows_are_those_of_a_table():
    paths = []
    for speed in (RAMP.rows, RAMP):
        simulation = rc.Simulation(drive_with(speed))
        simulation.step_to(END)
        paths.append(simulation.positions)
    assert_array_equal(*paths)


def test_a_curve_may_be_a_table():
    rows = [(0.0, 2.0), (20.0, -1.0)]
    motions = [rc.AppliedTorque(curve=curve) for curve in (rows, rc.Table(rows))]
    paths = []
    for motion in motions:
        drive = rc.paper_drive()
        driver, driven = drive.sprockets
        simulation = rc.Simulation(
            replace(drive, sprockets=(driver, replace(driven, motion=motion)))
        )
        simulation.step_to(END)
        paths.append(simulation.positions)
    assert_array_equal(*paths)


def test_the_mechanism_of_a_drive_has_its_signals():
    for signal, _ in SIGNALS.values():
        mechanism = drive_with(signal, torque=signal, hinges="ideal").to_mechanism()
        motor = next(joint for joint in mechanism.joints if joint.name == "motor_1")
        load = next(force for force in mechanism.forces if force.name == "motor_2")
        assert (motor.motion, load.x) == (signal, signal)


@pytest.mark.parametrize("signal", [each for each, _ in SIGNALS.values()])
def test_a_speed_is_set_to_any_signal_and_the_state_has_it(signal, tmp_path):
    simulation = rc.Simulation(drive_with())
    simulation.step_to(5e-4)
    simulation.set_speed("sprocket_1", signal)
    simulation.save_state(tmp_path / "set.npz")
    other = rc.Simulation.load_state(tmp_path / "set.npz")
    for each in (simulation, other):
        each.step_to(END)
    assert_array_equal(simulation.positions, other.positions)
    assert simulation.state()["snapshot"] == other.state()["snapshot"]


@pytest.mark.parametrize("suffix", [".toml", ".json"])
def test_files_hold_every_signal(suffix, tmp_path):
    path = tmp_path / f"scene{suffix}"
    for signal in (SPEED, RAMP.rows, RAMP, ARCH, WAVES, RISE):
        scene = rc.Scene(drive_with(signal, torque=signal))
        rc.save_scene(scene, path)
        assert rc.load_scene(path) == scene
    strand = rc.open_chain(
        "ANSI 40", ends=(rc.AnchoredEnd((0.0, 0.0), (RISE, 0.1)), rc.LoadedEnd(1.0)), links=12
    )
    rc.save_scene(strand, path)
    assert rc.load_scene(path).drive == strand
    mechanism = rc.Mechanism()
    mechanism.add_body("wheel", 1.0, 0.1)
    mechanism.add_revolute("axle", "ground", "wheel")
    mechanism.add_force("push", "wheel", (WAVES, RAMP))
    mechanism.add_torque("load", "wheel", by_speed=RAMP)
    rc.save_scene(mechanism, path)
    assert rc.load_scene(path).system == mechanism


def test_a_file_must_say_which_signal_rows_are_of(tmp_path):
    path = tmp_path / "drive.toml"
    text = (
        '[drive]\ntype = "two_sprocket_drive"\nlinks = 60\n'
        "speed = {{ {}rows = [[0.0, 1.0], [1.0, 2.0]] }}\n"
    )
    path.write_text(text.format('type = "Spline", '))
    speed = rc.load_scene(path).drive.sprockets[0].motion.speed
    assert speed == rc.Spline([(0.0, 1.0), (1.0, 2.0)])
    path.write_text(text.format(""))
    with pytest.raises(rc.InvalidInput, match=r"expected one; add .*'Table'.*'Spline'"):
        rc.load_scene(path)


def test_signals_are_values():
    for signal, _ in SIGNALS.values():
        for again in (pickle.loads(pickle.dumps(signal)), copy.deepcopy(signal), eval_of(signal)):
            assert again == signal
    assert rc.Table([[0, 1], [2, 3]]) == rc.Table(np.array([(0.0, 1.0), (2.0, 3.0)]))


def eval_of(signal):
    return eval(repr(signal), vars(rc).copy())


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: rc.Table([]), r"Table\.rows = \(\): needs at least one row"),
        (lambda: rc.Table([(1.0, 0.0), (1.0, 2.0)]), r"Table\.rows = 1 after 1: .*must increase"),
        (lambda: rc.Table([1.0, 2.0]), r"Table\.rows\.1: got 1.0"),
        (lambda: rc.Table([(0.0, math.nan)]), r"Table\.rows\.1\.2: got nan"),
        (lambda: rc.Table([(0.0, 1.0, 2.0)]), r"Table\.rows = \(0.0, 1.0, 2.0\): each row must be"),
        (lambda: rc.Spline([(0.0, 1.0)]), r"Spline\.rows = 1 row: needs at least two rows"),
        (lambda: rc.Sines([(1.0, 2.0)]), r"Sines\.terms = .*must be rows of three numbers"),
        (lambda: rc.SmoothStep(1.0, 1.0, 0.0, 1.0), r"SmoothStep\.end = 1: must be after"),
        (lambda: rc.PrescribedSpeed("fast"), r"PrescribedSpeed\.speed = 'fast': must be a number"),
        (
            lambda: rc.AppliedTorque(curve=WAVES),
            r"AppliedTorque\.curve = Sines.*: must be a number",
        ),
        (lambda: rc.AnchoredEnd((0.0, 0.0), (WAVES, "x")), r"AnchoredEnd\.velocity = 'x'"),
        (
            lambda: drive_with(rc.Sines([(1e6, 1.0, 0.0)])),
            r"motion\.speed = 1000000: expected at most",
        ),
        (
            lambda: drive_with(rc.Spline([(0.0, 0.0), (1.0, 2.8e4), (1.5, 2.8e4), (2.5, 0.0)])),
            r"motion\.speed = 29500: expected at most",
        ),
    ],
)
def test_what_is_no_signal_is_refused_when_it_is_made(make, says):
    with pytest.raises(rc.InvalidInput, match=says):
        make()


def test_a_speed_in_rpm_goes_wherever_a_speed_goes():
    speed = rc.rpm(120.0)
    assert speed == pytest.approx(SPEED)
    assert_allclose(rc.rpm([60.0, 120.0]), [0.5 * SPEED, SPEED])
    ramp = np.column_stack([[0.0, 0.1], rc.rpm([0.0, 1500.0])])
    assert rc.PrescribedSpeed(ramp).speed[1][1] == pytest.approx(50.0 * math.pi)
    assert rc.two_sprocket_drive(links=60, speed=speed).sprockets[0].motion.speed == speed
    simulation = rc.Simulation(drive_with(speed))
    simulation.set_speed("sprocket_1", rc.rpm(100))
    assert simulation.velocities[-2, 2] == rc.rpm(100)
    free = replace(rc.paper_drive().sprockets[1], initial_speed=speed)
    assert free.initial_speed == speed
    wheel = rc.Mechanism()
    wheel.add_body("wheel", 1.0, 0.1, velocity=(0.0, 0.0, speed))
    wheel.add_revolute("axle", "ground", "wheel")
    wheel.add_driver("motor", "ground", "wheel", speed=speed)
    assert rc.Simulation(wheel).velocities[0, 2] == pytest.approx(speed)
    with pytest.raises(rc.InvalidInput, match=r"rpm\(speed\): got 'x'; expected finite numbers"):
        rc.rpm("x")


def function(t):
    return t


ANCHOR = (0.0, 0.0)
MECHANISM = rc.Mechanism()
NOT_SAMPLED = {
    "speed": (lambda: rc.PrescribedSpeed(function), "Table, or call set_speed with a number in a"),
    "torque": (lambda: rc.AppliedTorque(function), "Table, or call set_torque with a number in a"),
    "curve": (lambda: rc.AppliedTorque(0.0, curve=function), "rows or a Table; sample it into a T"),
    "velocity": (lambda: rc.AnchoredEnd(ANCHOR, velocity=function), "sample it into a Table"),
    "component": (lambda: rc.AnchoredEnd(ANCHOR, (function, 0.0)), "sample it into a Table"),
    "set_speed": (lambda: rc.Simulation(rc.paper_drive()).set_speed(1, function), "set_speed with"),
    "angle": (
        lambda: MECHANISM.add_driver("d", "ground", "b", angle=function),
        "Spline, Sines or SmoothStep; sample it into a Spline",
    ),
    "force": (lambda: MECHANISM.add_force("f", "b", (function, 0.0)), "sample it into a Table"),
    "by speed": (lambda: MECHANISM.add_torque("t", "b", by_speed=function), "rows or a Table"),
}


@pytest.mark.parametrize("what", NOT_SAMPLED)
def test_a_python_function_is_no_signal(what):
    call, remedy = NOT_SAMPLED[what]
    with pytest.raises(rc.InvalidInput, match=f"is a Python function; expected .*{remedy}"):
        call()


@pytest.mark.parametrize("start", [0.01, 400.0, -3.0])
def test_rows_that_are_one_time_to_rounding_are_refused(start):
    for kind in (rc.Table, rc.Spline):
        with pytest.raises(rc.InvalidInput, match="are one time to rounding: a jump needs rows"):
            drive_with(kind([(start, 0.0), (math.nextafter(start, math.inf), 0.5)])).check()
    anchor = ((start, 0.0), (start + 1e-15 * abs(start), 0.5))
    with pytest.raises(rc.InvalidInput, match="one time to rounding"):
        rc.AnchoredEnd((0, 0), (rc.Table(anchor), 0.0))
    # The proposed distance is enough, for motion and work.
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("wheel", 1.0, 0.5)
    mechanism.add_revolute("axle", "ground", "wheel")
    jump = 5e-3 + 3e-14 * 5e-3
    mechanism.add_driver("motor", "ground", "wheel", speed=[(5e-3, 0.0), (jump, 2.0)])
    energy = rc.Simulation(mechanism).run(0.01, 1e-3, progress=False).energy
    assert energy.kinetic[-1] == pytest.approx(1.0)
    assert energy.external_work[-1] == pytest.approx(1.0, rel=1e-6)


def test_curves_over_speed_have_rows_at_any_distance():
    rc.AppliedTorque(curve=[(1.0, 0.0), (math.nextafter(1.0, 2.0), -3.0)])
