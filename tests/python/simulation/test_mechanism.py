"""Mechanisms from Python: closed forms, the NumPy reference, results, and what is refused."""

import copy
import math
import re

import numpy as np
import pytest

import rustchain as rc
from reference.constrained import Chain, turned

GRAVITY = 9.81


def pendulum(length=1.0):
    mechanism = rc.Mechanism(name="pendulum")
    mechanism.add_body("bar", 1.0, length**2 / 12, position=(length / 2, 0.0, 0.0))
    mechanism.add_revolute("bearing", "ground", "bar", at=(0.0, 0.0))
    return mechanism


def slider_crank(speed=10.0, crank=0.05, rod=0.12):
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("crank", 0.3, 1e-4, (crank / 2, 0.0, 0.0), (0.0, speed * crank / 2, speed))
    spin = -speed * crank / rod
    middle = crank + rod / 2
    mechanism.add_body("rod", 0.2, 3e-4, (middle, 0.0, 0.0), (0.0, speed * crank / 2, spin))
    mechanism.add_body("slider", 0.1, 1e-4, (crank + rod, 0.0, 0.0))
    mechanism.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    mechanism.add_revolute("crank pin", "crank", "rod", at=(crank, 0.0))
    mechanism.add_revolute("wrist pin", "rod", "slider", at=(crank + rod, 0.0))
    mechanism.add_prismatic("guide", "ground", "slider", direction=(1.0, 0.0))
    mechanism.add_driver("motor", "ground", "crank", speed=speed)
    return mechanism


def test_a_pendulum_turns_by_its_energy():
    result = rc.Simulation(pendulum()).run(duration=1.0, progress=False)
    body = result.body("bar")
    spin, angle = body.velocity[:, 2], body.position[:, 2]
    np.testing.assert_allclose(spin**2, -3 * GRAVITY * np.sin(angle), atol=1e-6)
    joint = result.joint("bearing")
    assert np.max(joint.position_residual) < 1e-14
    assert np.max(joint.velocity_residual) < 1e-13
    assert abs(joint.force[0, 1] - GRAVITY / 4) < 1e-9
    assert np.max(np.abs(result.energy.residual)) < 1e-6
    assert result.success
    assert result.stats["evaluations"] > result.stats["steps"] > 0


def test_a_simulation_of_a_mechanism_is_made_by_the_same_name():
    simulation = rc.Simulation(slider_crank(), solver=rc.Solver(rtol=1e-8, atol=1e-8))
    assert type(simulation) is rc.Simulation
    report = simulation.check()
    assert report.degrees_of_freedom == 0
    assert report.redundant == ()
    assert hash(report) == hash(copy.deepcopy(report))
    assert "degrees of freedom   0" in str(report)
    simulation.step_to(math.pi / 10)
    assert simulation.time == math.pi / 10
    assert abs(simulation.positions[2, 0] - (0.12 - 0.05)) < 1e-12
    evaluation = simulation.evaluate()
    crank, rod, speed = 0.05, 0.12, 10.0
    expected = speed**2 * crank * (1.0 - crank / rod)
    assert abs(evaluation.accelerations[2, 0] - expected) < 1e-8
    assert evaluation.joint_reaction.shape == (5, 3)


def test_results_go_to_xarray_pandas_and_files(tmp_path):
    import xarray as xr

    result = rc.Simulation(slider_crank()).run(duration=0.1, report_step=0.01, progress=False)
    dataset = result.to_xarray()
    assert dataset["position"].sel(body="slider", axis="x").shape == (11,)
    assert dataset["joint_force"].attrs["units"] == "N"
    assert dataset["joint_torque"].attrs["units"] == "N m"
    assert dataset["joint_torque"].sel(joint="motor").shape == (11,)
    assert "position_slider_x" in result.to_pandas()
    result.save(tmp_path / "run.nc")
    loaded = xr.load_dataset(tmp_path / "run.nc", engine="h5netcdf")
    np.testing.assert_array_equal(loaded["energy_kinetic"], result.energy.kinetic)


@pytest.mark.filterwarnings("ignore:velocity of body .* had to be changed")
def test_accelerations_and_reactions_are_those_of_the_dense_reference():
    rng = np.random.default_rng(7)
    for bars in (2, 3, 6):
        for _ in range(10):
            masses, lengths = rng.uniform(0.1, 3.0, bars), rng.uniform(0.2, 1.5, bars)
            inertias = masses * lengths**2 / rng.uniform(6.0, 20.0, bars)
            angles, end = rng.uniform(-3.0, 3.0, bars), np.zeros(2)
            mechanism = rc.Mechanism()
            for k in range(bars):
                half = turned(angles[k], (lengths[k] / 2, 0.0))
                position = (*(end + half), angles[k])
                velocity = rng.normal(size=3)
                mechanism.add_body(f"bar {k}", masses[k], inertias[k], position, velocity)
                before = "ground" if k == 0 else f"bar {k - 1}"
                mechanism.add_revolute(f"hinge {k}", before, f"bar {k}", at=end)
                end = end + 2 * half
            direction = turned(rng.uniform(-3, 3), (1.0, 0.0))
            mechanism.add_point_on_line(
                "line", "ground", f"bar {bars - 1}", direction, end, (lengths[-1] / 2, 0.0)
            )
            simulation = rc.Simulation(mechanism)
            reference = Chain(masses, inertias, lengths, (end, direction))
            q, v = simulation.positions.ravel(), simulation.velocities.ravel()
            assert np.max(np.abs(reference.constraints(q))) < 1e-14
            assert np.max(np.abs(reference.jacobian(q) @ v)) < 1e-13
            acceleration, multipliers, condition = reference.solve(q, v, GRAVITY)
            found = simulation.evaluate()
            # gamma's differences are good to 1e-11 of the rates' size; the rest is the condition.
            scale = np.max(np.abs(acceleration)) + np.max(np.abs(v)) ** 2
            bound = (1e-10 + 1e-15 * condition) * scale
            assert np.max(np.abs(found.accelerations.ravel() - acceleration)) < bound
            force = found.joint_reaction[:bars, :2].ravel()
            assert np.max(np.abs(force + multipliers[:-1])) < bound * np.max(masses) * 10


def test_a_clearance_joint_carries_the_weight():
    mechanism = rc.Mechanism()
    mechanism.add_body("pin", 0.5, 1e-4)
    law = rc.SurfaceContact(rc.LankaraniNikravesh())
    mechanism.add_clearance_joint("bush", "ground", "pin", 0.01, 0.0099, law)
    mechanism.add_spring("drag", "ground", "pin", damping=20.0, rest_length=0.0)
    result = rc.Simulation(mechanism).run(duration=0.5, report_step=0.01, progress=False)
    contact = result.contact("bush")
    assert abs(contact.force[-1] - 0.5 * GRAVITY) < 1e-3
    assert abs(contact.penetration[0] + 1e-4) < 1e-15
    assert result.stats["onsets"] >= 1


def test_a_ball_rests_on_an_outline_with_arcs():
    mechanism = rc.Mechanism()
    mechanism.add_body("ball", 1.0, 0.01, position=(0.2, 0.5, 0.0))
    # A bowl: a half circle of 1 m, its concave side up.
    mechanism.add_outline_contact(
        "bowl",
        "ground",
        "ball",
        points=[(1.0, 0.0), (-1.0, 0.0)],
        bulges=[-1.0],
        radius=0.1,
        closed=False,
        law=rc.LinearContact(stiffness=1e5, damping=200.0),
    )
    mechanism.add_spring("drag", "ground", "ball", damping=1.0, rest_length=0.0)
    report = mechanism.check()
    assert report.degrees_of_freedom == 3
    result = rc.Simulation(mechanism).run(duration=1.0, report_step=0.01, progress=False)
    distance = np.hypot(*result.body("ball").position[:, :2].T)
    assert np.max(distance) < 0.9 + 0.05
    assert np.max(np.abs(result.energy.residual)) < 1e-4


def test_a_callable_loads_a_body_and_its_exception_ends_the_run():
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("block", 2.0, 0.1, position=(0.3, 0.0, 0.0))
    mechanism.add_callable("spring", "block", lambda t, q, v: (-8.0 * q[0], 0.0, 0.0))
    simulation = rc.Simulation(mechanism)
    simulation.step_to(1.0)
    assert abs(simulation.positions[0, 0] - 0.3 * math.cos(2.0)) < 1e-8

    def broken(t, q, v):
        if t > 0.5:
            raise KeyError("mine")
        return (0.0, 0.0, 0.0)

    mechanism = rc.Mechanism()
    mechanism.add_body("block", 2.0, 0.1)
    mechanism.add_callable("broken", "block", broken)
    with pytest.raises(KeyError, match="mine"):
        rc.Simulation(mechanism).run(duration=1.0, progress=False)


def test_drivers_follow_their_functions():
    functions = {
        "step": (rc.SmoothStep(0.1, 0.6, 0.0, 2.0), lambda t: 2.0),
        "sines": (rc.Sines([(0.3, 4.0, 0.2)]), lambda t: 0.3 * math.sin(4.0 * t + 0.2)),
        "spline": (rc.Spline([(0.0, 0.0), (0.4, 1.0), (0.8, 0.3)]), lambda t: 0.3),
    }
    for name, (function, expected) in functions.items():
        mechanism = pendulum()
        mechanism.add_driver("motor", "ground", "bar", angle=function)
        simulation = rc.Simulation(mechanism)
        simulation.step_to(0.8)
        assert abs(simulation.positions[0, 2] - expected(0.8)) < 1e-12, name
    mechanism = pendulum()
    mechanism.add_driver("motor", "ground", "bar", speed=rc.Table([(0.0, 0.0), (1.0, 2.0)]))
    simulation = rc.Simulation(mechanism)
    simulation.step_to(0.5)
    assert abs(simulation.positions[0, 2] - 0.25) < 1e-12


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda m: m.add_revolute("x", "ground", "bra"), "bra.*there is no such body"),
        (lambda m: m.add_body("bar", 1.0, 1.0), "is taken already"),
        (lambda m: m.add_body("light", -1.0, 1.0), "mass of body.*light"),
        (lambda m: m.add_body("heavy", "1", 1.0), "mass.*must be a number"),
        (
            lambda m: m.add_revolute("far", "ground", "bar", (9.0, 0.0), (0.5, 0.0)),
            "cannot be assembled.*far",
        ),
        (
            lambda m: m.add_fixed("far", "ground", "bar", angle=2**63),
            '"far" by 9.223e18 rad.*check lengths, angles, points and units',
        ),
        (lambda m: m.add_driver("w", "ground", "bar", angle=rc.Table([(0, 0), (1, 1)])), "corners"),
        (lambda m: m.add_driver("w", "ground", "bar"), "exactly one"),
        (lambda m: m.add_torque("t", "bar"), "exactly one"),
        (lambda m: m.add_revolute("y", "ground", "bra", at=(0.0, 0.0)), "did you mean 'bar'"),
    ],
)
def test_a_wrong_part_of_a_mechanism_is_refused_by_its_name(change, says):
    mechanism = pendulum()

    def made():
        change(mechanism)
        mechanism.check()

    with pytest.raises(rc.InvalidInput, match=says):
        made()


def test_loose_parts_are_warned_of():
    mechanism = pendulum()
    mechanism.add_body("loose", 1.0, 0.1)
    says = 'nothing connects "loose" to the ground: it moves by gravity and its own velocity only'
    with pytest.warns(UserWarning, match=says):
        rc.Simulation(mechanism)


def test_newtons_method_keeps_the_joints_too():
    ends = []
    for accuracy in (1e-8, 1e-10):
        solver = rc.Solver(method="newton", accuracy=accuracy, max_step=0.01)
        simulation = rc.Simulation(pendulum(), solver=solver)
        result = simulation.run(duration=0.5, report_step=0.05, progress=False)
        assert np.max(result.joint("bearing").position_residual) < 1e-14
        ends.append(np.max(np.abs(result.energy.residual)))
    assert ends[1] < 0.2 * ends[0] < 1e-3


@pytest.mark.filterwarnings("ignore:velocity of body .* had to be changed")
def test_results_come_back_from_their_file(tmp_path):
    mechanism = rc.Mechanism(name="falling")
    mechanism.add_body("bar", 1.0, 0.1, velocity=(1.0, 0.0, 2.0))
    mechanism.add_torsion_spring("rubber", "ground", "bar", stiffness=1.0)
    free = rc.Simulation(mechanism).run(duration=0.01, progress=False)
    mechanism.add_revolute("pin", "ground", "bar", at=(0.5, 0.0))
    held = rc.Simulation(mechanism).run(duration=0.01, progress=False)
    for number, result in enumerate((free, held)):
        path = tmp_path / f"{number}.nc"
        result.save(path)
        loaded = rc.load_result(path)
        assert (loaded.scene.name, loaded.stats) == ("falling", result.stats)
        assert loaded.joint_names == result.joint_names
        assert set(loaded.arrays) == set(result.arrays)
        for name, values in result.arrays.items():
            np.testing.assert_array_equal(loaded.arrays[name], values)
        assert loaded == result
    np.testing.assert_array_equal(
        rc.load_result(tmp_path / "1.nc").joint("pin").force, held.joint("pin").force
    )


def test_a_state_goes_on_to_the_same_bits():
    mechanism = rc.Mechanism()
    for k in range(3):
        mechanism.add_body(f"bar {k}", 1.0, 0.1, (k + 0.5, 0.0, 0.0))
        before, point = ("ground", (0.0, 0.0)) if k == 0 else (f"bar {k - 1}", (0.5, 0.0))
        mechanism.add_revolute(f"hinge {k}", before, f"bar {k}", point, (-0.5, 0.0))
    straight, broken, resumed = (rc.Simulation(mechanism) for _ in range(3))
    straight.step_to(1.0)
    broken.step_to(0.4)
    resumed.set_state(broken.state())
    resumed.step_to(1.0)
    np.testing.assert_array_equal(resumed.positions, straight.positions)
    np.testing.assert_array_equal(
        resumed.evaluate().joint_reaction, straight.evaluate().joint_reaction
    )
    mechanism.add_torque("motor", "bar 0", 1.0)
    with pytest.raises(rc.InvalidInput, match="of another scene"):
        rc.Simulation(mechanism).set_state(broken.state())


# Coarse on purpose, so that steps are long.
@pytest.mark.filterwarnings("ignore:the energy balance is off:rustchain.EnergyWarning")
@pytest.mark.parametrize("height", [0.2, 0.5, 1.0, 5.0])
@pytest.mark.parametrize("method", ["pece", "newton"])
def test_a_small_ball_does_not_fall_through_a_floor(height, method):
    mechanism = rc.Mechanism()
    mechanism.add_body("ball", 0.1, 1e-5, (0.0, height, 0.0))
    line, law = [(1.0, 0.0), (-1.0, 0.0)], rc.LinearContact(1e6, 0.0)
    mechanism.add_outline_contact("floor", "ground", "ball", line, 0.005, law, closed=False)
    solver = rc.Solver(method=method, accuracy=1e-8, max_step=0.1)
    if method == "pece":
        solver = rc.Solver(method=method, rtol=1e-8, atol=1e-8, max_step=0.1)
    duration = 1.5 * math.sqrt(2 * height / GRAVITY)
    result = rc.Simulation(mechanism, solver=solver).run(duration=duration, progress=False)
    assert result.stats["onsets"] == 1
    # Measured: up to 1.3 % of the energy of the fall.
    assert np.abs(result.energy.residual).max() < 0.02 * 0.1 * GRAVITY * height
    # It rises as fast as it fell: after half the time of the fall, a quarter of the way is left.
    assert abs(result.body("ball").position[-1, 1] - 0.75 * height) < 0.01 * height + 0.01


def test_a_far_contact_does_not_shorten_steps():
    def steps(apart):
        mechanism = pendulum()
        if apart is not None:
            law = rc.LinearContact(1e6, 0.0)
            mechanism.add_disc_contact("far", "ground", "bar", 0.01, 0.01, law, (0.0, apart))
        return rc.Simulation(mechanism).run(duration=1.0, progress=False).stats["steps"]

    assert steps(50.0) == steps(None)


def test_a_soft_contact_of_an_open_outline_holds_what_sinks_in_deeply():
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("ball", 1.0, 1.0, (0.0, 0.02, 0.0), (0.0, -1.0, 0.0))
    line, law = [(1.0, 0.0), (-1.0, 0.0)], rc.LinearContact(100.0, 0.0)
    mechanism.add_outline_contact("floor", "ground", "ball", line, 0.01, law, closed=False)
    result = rc.Simulation(mechanism).run(duration=0.5, progress=False)
    # It sinks in by v sqrt(m/k) = 0.1 m, ten radii, for half a period of 2 pi sqrt(m/k).
    assert abs(result.contact("floor").penetration.max() - 0.1) < 1e-4
    assert abs(result.body("ball").velocity[-1, 1] - 1.0) < 1e-5


def test_a_callable_that_raises_leaves_the_last_state_and_the_rows():
    raising = [True]

    def load(t, q, v):
        if raising[0] and t > 0.5:
            raise RuntimeError("boom")
        return 0.0, 0.0, 0.0

    def swing():
        mechanism = pendulum()
        mechanism.add_callable("load", "bar", load)
        return rc.Simulation(mechanism)

    stepped, recorded = swing(), swing()
    with pytest.raises(RuntimeError, match="boom"):
        stepped.step_to(1.0)
    assert 0.45 < stepped.time <= 0.5
    raising[0] = False
    free = rc.Simulation(pendulum())
    free.step_to(stepped.time)
    np.testing.assert_allclose(stepped.positions, free.positions, atol=1e-5)
    # It goes on from there as if nothing had happened.
    for simulation in (stepped, free):
        simulation.step_to(0.8)
    np.testing.assert_allclose(stepped.positions, free.positions, atol=1e-5)

    raising[0] = True
    with pytest.raises(RuntimeError, match="boom") as caught:
        recorded.run(duration=1.0, report_step=0.01, progress=False)
    result = caught.value.result
    assert result.status == "failed"
    assert 0.45 < result.time[-1] <= recorded.time <= 0.5
    assert len(result.time) == len(result.body("bar").position) > 40


def test_a_jammed_mechanism_stays_where_its_joints_last_held():
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    crank, foot = np.array([math.sqrt(0.75), 0.5]), np.array([2.0, 0.0])
    across = foot - crank
    rise = math.sqrt(1.0 - 0.25 * across @ across) / np.linalg.norm(across)
    knee = (crank + foot) / 2 + rise * np.array([-across[1], across[0]])
    ends = {"crank": (0 * foot, crank), "coupler": (crank, knee), "rocker": (knee, foot)}
    for name, (start, end) in ends.items():
        x, y = (start + end) / 2
        angle = math.atan2(end[1] - start[1], end[0] - start[0])
        mechanism.add_body(name, 1.0, 1 / 12, (x, y, angle))
    mechanism.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    mechanism.add_revolute("pin", "crank", "coupler", at=crank)
    mechanism.add_revolute("knee", "coupler", "rocker", at=knee)
    mechanism.add_revolute("foot", "ground", "rocker", at=foot)
    mechanism.add_driver("motor", "ground", "crank", speed=1.0)
    simulation = rc.Simulation(mechanism)
    with pytest.raises(rc.SimulationError):
        simulation.step_to(5.0)
    assert 0.0 < simulation.time < 5.0
    x, y, angle = simulation.positions[0]
    np.testing.assert_allclose([x, y], [math.cos(angle) / 2, math.sin(angle) / 2], atol=1e-9)
    assert abs(angle - (math.pi / 6 + simulation.time)) < 1e-9
    x, y, angle = simulation.positions[2]
    end = [x + math.cos(angle) / 2, y + math.sin(angle) / 2]
    np.testing.assert_allclose(end, foot, atol=1e-9)


@pytest.mark.parametrize("speed", [2.9, 3.0, 3.1, 3.2])
def test_a_ball_from_behind_passes_an_open_outline_and_then_lands_on_it(speed):
    mechanism = rc.Mechanism()
    mechanism.add_body("ball", 1.0, 1.0, (0.0, -0.1, 0.0), (0.0, speed, 0.0))
    line, law = [(1.0, 0.0), (-1.0, 0.0)], rc.LinearContact(1e6, 0.0)
    mechanism.add_outline_contact("floor", "ground", "ball", line, 0.01, law, closed=False)
    result = rc.Simulation(mechanism).run(duration=0.7, report_step=1e-4, progress=False)
    rising = result.time < speed / GRAVITY
    assert result.contact("floor").force[rising].max() == 0.0
    assert result.body("ball").position[:, 1].max() > speed**2 / (2 * GRAVITY) - 0.1 - 1e-4
    assert result.stats["onsets"] == 1
    assert np.max(np.abs(result.energy.residual)) < 1e-5


@pytest.mark.filterwarnings("ignore:body .* had to be moved")
@pytest.mark.parametrize("turned", [0.0, 1e-9, 1e-6, 1e-3, 0.1, 0.5])
def test_assembly_finds_the_nearest_position_from_a_stretched_one(turned):
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("crank", 1.0, 0.1, (0.5, 0.0, 0.0))
    rod = (1.0 + 0.5 * math.cos(turned), 0.5 * math.sin(turned), turned)
    mechanism.add_body("rod", 1.0, 0.1, rod)
    mechanism.add_revolute("bearing", "ground", "crank", (0.0, 0.0), (-0.5, 0.0))
    mechanism.add_revolute("pin", "crank", "rod", (0.5, 0.0), (-0.5, 0.0))
    mechanism.add_distance("tie", "ground", "rod", (3.0, 0.0), (0.5, 0.0), length=1.5)
    mechanism.add_driver("motor", "ground", "crank", angle=0.0)
    simulation = rc.Simulation(mechanism)
    # The rod's end is 1 m from (1, 0) and 1.5 m from (3, 0): 5 - 4 cos(angle) = 1.5^2.
    angle = math.acos((5.0 - 1.5**2) / 4.0)
    found = simulation.positions[1, 2]
    assert abs((abs(found) if turned == 0.0 else found) - angle) < 1e-9
    assert simulation.check().turned <= angle + 1e-9


@pytest.mark.parametrize(("length", "gap"), [(3.0, 1.5), (4.4, 0.1), (5.6, 0.1), (6.0, 0.5)])
def test_what_cannot_assemble_is_told_by_what_the_nearest_positions_miss(length, gap):
    mechanism = pendulum()
    mechanism.add_distance("tie", "ground", "bar", point_a=(0.0, 5.0), length=length)
    with pytest.raises(ValueError, match="cannot be assembled") as refused:
        rc.Simulation(mechanism)
    missed = dict(re.findall(r'"(\w+)" by (\S+) m', str(refused.value)))
    # The least sum of squares shares the gap between the two, a distance by its square.
    assert set(missed) == {"bearing", "tie"}
    for value in missed.values():
        assert 0.35 * gap < float(value) < 0.75 * gap


def test_redundant_joints_that_do_not_agree_are_told_where_they_jam():
    mechanism = rc.Mechanism()
    length, angle = 0.2, 1.0
    along, up = length * np.cos(angle), length * np.sin(angle)
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5 + along, up, 0.0))
    for k in range(3):
        post, foot = f"post_{k}", 0.5 * k + (1e-12 if k == 1 else 0.0)
        place = (0.5 * k + 0.5 * along, 0.5 * up, angle)
        mechanism.add_body(post, 0.1, 1e-3, position=place)
        mechanism.add_revolute(f"foot_{k}", "ground", post, at=(foot, 0.0))
        mechanism.add_revolute(f"head_{k}", post, "bar", at=(0.5 * k + along, up))
    mechanism.add_driver("motor", "ground", "post_0", speed=5.0)
    with pytest.warns(rc.RustchainWarning, match="redundant"):
        simulation = rc.Simulation(mechanism)
    with pytest.raises(rc.SimulationError, match="joints are redundant: their points"):
        simulation.step_to(5.0)
