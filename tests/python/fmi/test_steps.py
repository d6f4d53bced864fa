"""Steps of an FMU: the same bits as `step_to`, states, phases, and the coupling with an engine."""

from dataclasses import replace
from itertools import pairwise

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import rustchain as rc
from fmi.master import opened


def moved(size=2e-4, count=20):
    """Return times of steps of changing size, and inputs set at some of them."""
    sizes = size * (1.0 + 0.5 * np.sin(np.arange(count)))
    times = [0.0]
    for each in sizes.tolist():
        times.append(times[-1] + each)
    inputs = {
        3: [("sprocket_1.set_speed", 13.0)],
        7: [("sprocket_2.set_torque", -5.0), ("tensioner.set_force", 120.0)],
        8: [("sprocket_1.set_speed", 12.0), ("sprocket_2.set_torque", -5.0)],
        15: [("tensioner.set_force", 20.0)],
    }
    return times, inputs


def set_in(simulation, name, value):
    part, _, quantity = name.partition(".")
    arguments = (value,) if part == "tensioner" else (part, value)
    method = "set_tensioner_force" if part == "tensioner" else quantity
    getattr(simulation, method)(*arguments)


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
def test_steps_have_the_bits_of_step_to(drive, version, hinges, tmp_path):
    times, inputs = moved()
    drive, fmu = replace(drive, hinges=hinges), tmp_path / "drive.fmu"
    rc.export_fmu(drive, fmu, version=version)
    simulation = rc.Simulation(drive)
    with opened(fmu) as master:
        master.initialize()
        for i, (begin, end) in enumerate(pairwise(times)):
            for name, value in inputs.get(i, []):
                master.set(name, value)
                set_in(simulation, name, value)
            size = end - begin
            master.step(begin, size)
            simulation.step_to(begin + size)
            places, speeds = simulation.positions[-2:, 2], simulation.velocities[-2:, 2]
            assert (master.get("sprocket_1.angle", "sprocket_2.angle") == places).all()
            assert (master.get("sprocket_1.speed", "sprocket_2.speed") == speeds).all()
    # Inputs act: without them the driver is elsewhere, and the driven sprocket has another speed.
    alone = rc.Simulation(drive)
    alone.step_to(times[-1])
    assert abs(alone.positions[-2, 2] - simulation.positions[-2, 2]) > 9e-4
    assert abs(alone.velocities[-1, 2] - simulation.velocities[-1, 2]) > 0.1


def test_outputs_are_the_recorded_channels(fmu, drive):
    """Largest forces are those since the last communication point, as between rows of a run."""
    simulation = rc.Simulation(drive)
    with opened(fmu) as master:
        master.initialize()
        for i in range(15):
            master.step(i * 1e-3, 1e-3)
            run = simulation.run(1e-3, 1e-3, energy=False, progress=False)
            row = {name: run.array(name)[-1] for name in ("sprocket_torque", "strand_tension")}
            expected = [*row["sprocket_torque"], *row["strand_tension"]]
            expected += [run.array(f"peak_{kind}_force")[-1].max() for kind in ("hinge", "tooth")]
            found = master.get(
                "sprocket_1.torque",
                "sprocket_2.torque",
                "strand_upper.tension",
                "strand_lower.tension",
                "hinges.largest_force",
                "teeth.largest_force",
            )
            # The run ends at its begin plus 1e-3, the step at i times 1e-3 plus 1e-3.
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
        assert min(expected[-2:]) > 1.0


def test_a_tensioner_force_is_in_balance_with_the_strands():
    """Parallel strands of a drive at rest share the force of the tensioner: F = T1 + T2."""
    drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, 17), links=38, speed=0.0, pretension=20.0)
    drive = replace(drive, tensioner=replace(drive.tensioner, damping=100.0))
    simulation = rc.Simulation(rc.Scene(drive, start="static"))
    simulation.set_tensioner_force(90.0)
    simulation.step_to(0.05)
    run = simulation.run(0.02, 1e-4, energy=False, progress=False)
    tension = run.array("strand_tension").mean(axis=0)
    assert tension.sum() == pytest.approx(90.0, rel=0.02)


def test_a_run_with_the_same_inputs_from_the_start_is_that_of_the_description(drive):
    """A description with other constants, and its inputs set at time zero, are one drive."""
    sprockets = (drive.sprockets[0], replace(drive.sprockets[1], motion=rc.AppliedTorque(-3.0)))
    at_once = replace(drive.tensioner, ramp_time=0.0)
    described = rc.Simulation(replace(drive, sprockets=sprockets, tensioner=at_once))
    told = rc.Simulation(drive)
    told.set_torque(2, -3.0)
    told.set_tensioner_force(drive.check().tension_force)
    for simulation in (described, told):
        simulation.step_to(2e-3)
    np.testing.assert_allclose(told.positions, described.positions, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("force", "message"),
    [
        (-1.0, "must be zero or a positive"),
        (np.nan, "(?i)nan"),
        (1e9, "at most"),
        ("x", "number in N"),
    ],
)
def test_wrong_tensioner_forces_are_refused(drive, force, message):
    with pytest.raises(rc.InvalidInput, match=message):
        rc.Simulation(drive).set_tensioner_force(force)
    with pytest.raises(rc.InvalidInput, match="has no tensioner"):
        rc.Simulation(rc.paper_drive()).set_tensioner_force(1.0)


def test_simulate_fmu_runs_it(fmu, drive):
    rows = fmpy.simulate_fmu(
        str(fmu),
        stop_time=0.01,
        output_interval=1e-3,
        start_values={"sprocket_2.set_torque": -4.0},
        output=["sprocket_1.angle", "sprocket_2.angle"],
    )
    simulation = rc.Simulation(drive)
    simulation.set_torque(2, -4.0)
    simulation.step_to(0.01)
    assert rows["time"][-1] == pytest.approx(0.01)
    assert rows["sprocket_1.angle"][-1] == pytest.approx(simulation.positions[-2, 2], abs=1e-12)
    assert rows["sprocket_2.angle"][-1] == pytest.approx(simulation.positions[-1, 2], abs=1e-9)


def test_a_state_is_returned_to_bit_for_bit(fmu):
    times, _ = moved()
    with opened(fmu, count=2) as (master, other):
        master.initialize()
        other.initialize()
        slave = master.slave
        first = master.steps(times[:10])
        master.set("sprocket_1.set_speed", 15.0)  # set, not yet applied: a part of the state
        state = slave.getFMUState()
        packed = slave.serializeFMUState(state)
        onward = master.steps(times[9:])
        assert (onward[-1] != first[-1]).any()

        slave.setFMUState(state)
        assert (master.outputs() == first[-1]).all()
        assert (master.steps(times[9:]) == onward).all()
        slave.freeFMUState(state)

        unpacked = other.slave.deserializeFMUState(packed)
        other.slave.setFMUState(unpacked)
        assert (other.outputs() == first[-1]).all()
        assert (other.steps(times[9:]) == onward).all()
        other.slave.freeFMUState(unpacked)

        flipped = bytearray(packed)
        flipped[-20] ^= 0x40
        for damaged in (packed[: len(packed) // 2], b"\xff" * 64, bytes(flipped), packed + b"xyz"):
            refused(master, "damaged", lambda damaged=damaged: restored(slave, damaged))


def test_the_state_of_another_fmu_is_refused(fmu, drive, version, tmp_path):
    path = tmp_path / "another.fmu"
    inputs = ["sprocket_2.set_torque", "sprocket_1.set_speed", "tensioner.set_force"]
    rc.export_fmu(drive, path, version=version, inputs=inputs)
    with opened(fmu) as own, opened(path) as other:
        own.initialize()
        other.initialize()
        packed = other.slave.serializeFMUState(other.slave.getFMUState())
        before = own.outputs()
        refused(own, "belongs to another FMU", lambda: restored(own.slave, packed))
        assert (own.outputs() == before).all()


def test_steps_go_on_where_the_rounding_of_the_time_exceeds_a_thousandth_of_them(fmu):
    start, size = 1.7e9, 1e-4
    with opened(fmu) as master, opened(fmu) as early:
        early.initialize()
        master.initialize(start_time=start)
        for step in range(20):
            master.slave.doStep(start + step * size, size)
            early.slave.doStep(step * size, size)
        assert master.outputs()[1:] == pytest.approx(early.outputs()[1:], rel=0.1)


def test_instances_of_one_process_are_independent(fmu):
    times, _ = moved()
    with opened(fmu, count=2) as (one, two):
        one.initialize()
        two.initialize()
        two.set("sprocket_1.set_speed", 20.0)
        alone = one.steps(times[:6])
        assert (two.steps(times[:6]) != alone).any()
        one.slave.reset()
        one.initialize()
        assert (one.steps(times[:6]) == alone).all()


def test_another_start_time_shifts_the_time_alone(fmu):
    with opened(fmu, count=2) as (one, late):
        one.initialize()
        late.initialize(5.0)
        for i in range(4):
            one.step(i * 1e-3, 1e-3)
            late.step(5.0 + i * 1e-3, 1e-3)
        np.testing.assert_allclose(late.outputs()[0], one.outputs()[0], rtol=1e-12)


def test_no_step_ends_past_the_stop_time(fmu):
    start, size, count = 0.3, 1e-4, 20
    with opened(fmu) as master:
        refused(master, "start time, 1 s", lambda: master.initialize(1.0, stop_time=0.5))
        master.initialize(start, stop_time=start + count * size)
        time = start
        for _ in range(count):  # the sum of the steps differs from the stop time by roundings
            master.step(time, size)
            time += size
        before = master.outputs()
        message = f"past the stop time, {start + count * size} s"
        refused(master, message, lambda: master.step(time, size))
        assert (master.outputs() == before).all()
        master.slave.reset()
        master.initialize().step(0.0, 1.0e-3)  # the stop time does not outlive a reset


def test_calls_in_the_wrong_order_are_refused_with_a_message(fmu):
    with opened(fmu) as master:
        refused(master, "before its initialization", lambda: master.step(0.0, 1e-3))
        master.initialize()
        refused(master, "in step mode", master.initialize)
        refused(master, "must be a positive number", lambda: master.step(0.0, -1e-3))
        refused(master, "must be a positive number", lambda: master.step(0.0, np.nan))
        refused(master, "the instance is at 0 s", lambda: master.step(0.5, 1e-3))
        refused(master, "NaN", lambda: master.set("sprocket_1.set_speed", np.nan))
        refused(master, "chain speed", lambda: master.set("sprocket_1.set_speed", 1e9))
        refused(master, "is no input", lambda: master.set("sprocket_1.speed", 1.0))
        master.step(0.0, 1e-3)
        master.slave.terminate()
        refused(master, "terminated", lambda: master.step(1e-3, 1e-3))
        refused(master, "terminated", lambda: master.set("sprocket_1.set_speed", 1.0))
        master.outputs()
        master.slave.reset()
        refused(master, "before its initialization", lambda: master.step(0.0, 1e-3))
        master.initialize().step(0.0, 1e-3)


def test_unknown_variables_and_other_types_are_refused(fmu, version):
    with opened(fmu) as master:
        slave = master.slave
        if version == "2.0":
            refused(master, "value reference = 99", lambda: slave.getReal([99]))
            refused(master, "fmi2GetInteger", lambda: slave.getInteger([1]))
            assert slave.getInteger([]) == []
        else:
            refused(master, "value reference = 99", lambda: slave.getFloat64([99]))
            refused(master, "fmi3GetInt32", lambda: slave.getInt32([1]))
            refused(master, "nValues = 2", lambda: slave.getFloat64([1], nValues=2))
            assert slave.getFloat64([0]) == [0.0]
            assert slave.getInt32([]) == []


def restored(slave, packed):
    slave.setFMUState(slave.deserializeFMUState(packed))


def refused(master, message, call):
    """Check that a call fails with a message to the logger of the master."""
    master.messages.clear()
    with pytest.raises(FMICallException):
        call()
    assert message in master.messages[-1], master.messages


ENGINE = 0.02  # [kg m^2], inertia of the shaft and of sprocket 1
LOAD = -2.0  # [N m], on sprocket 2


def engine_torque(angle):
    """Return the torque of an engine with two power strokes a revolution [N m]."""
    return 2.0 + 6.0 * np.sin(2.0 * angle)


def coupled_by_speed(path, size, end):
    """Return the engine's speed [rad/s] over time: the master integrates the shaft.

    The shaft has J dw/dt = T_engine - T_drive. Its speed goes to the FMU as a prescribed one, which
    gives back the torque that this needs: a Gauss-Seidel coupling with constant inputs.
    """
    speeds = [12.566]
    with opened(path) as master:
        master.initialize()
        for i in range(round(end / size)):
            angle, torque = master.get("sprocket_1.angle", "sprocket_1.torque")
            change = (engine_torque(angle) - torque) / ENGINE
            speeds.append(speeds[-1] + size * change)
            master.set("sprocket_1.set_speed", speeds[-1])
            master.step(i * size, size)
    return np.array(speeds)


def coupled_by_torque(size, end):
    """Return the same speed with the shaft as a part of the drive, which integrates it."""
    drive = engine_drive(rc.AppliedTorque(0.0), inertia=ENGINE, initial_speed=12.566)
    simulation = rc.Simulation(drive)
    speeds = [12.566]
    for i in range(round(end / size)):
        simulation.set_torque(1, engine_torque(simulation.positions[-2, 2]))
        simulation.step_to(i * size + size)
        speeds.append(simulation.velocities[-2, 2])
    return np.array(speeds)


def engine_drive(motion, **shaft):
    driver = rc.Sprocket(17, (0.0, 0.0), motion, **shaft)
    driven = rc.Sprocket(25, (0.23, 0.0), rc.AppliedTorque(LOAD))
    return rc.chain_drive("ANSI 40", [driver, driven], adjust=2)


def test_an_engine_on_the_fmu_is_the_engine_in_the_drive(tmp_path, version):
    path = tmp_path / "drive.fmu"
    rc.export_fmu(engine_drive(rc.PrescribedSpeed(12.566)), path, version=version)
    end = 0.02
    whole = coupled_by_torque(1e-5, end)
    errors = []
    for ratio in (4, 2, 1):
        coupled = coupled_by_speed(path, 1e-4 * ratio, end)
        errors.append(np.abs(coupled - whole[:: 10 * ratio]).max())
    # Measured: 0.130, 0.073 and 0.041 rad/s of 3.1 rad/s, of first order in the step.
    assert np.ptp(whole) > 3.0
    assert errors[-1] < 0.02 * np.ptp(whole)
    assert errors[0] > 1.5 * errors[1] > 1.5**2 * errors[2]
