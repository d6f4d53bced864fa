"""Friction and lubricant of mechanisms: as properties of contact laws and of revolute joints."""

from __future__ import annotations

import json
import math
import pickle

import numpy as np
import pytest

import rustchain as rc

GRAVITY = 9.81


def incline(angle, friction):
    """Return a block of 1 kg on two feet; gravity is turned by the angle of the slope."""
    radius, height, stiffness = 0.02, 0.05, 1e6
    depth = 0.5 * GRAVITY * math.cos(angle) / stiffness
    m = rc.Mechanism(gravity=(GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle)))
    m.add_body("block", mass=1.0, inertia=0.01, position=(0.0, height + radius - depth, 0.0))
    law = rc.LinearContact(stiffness, 500.0, friction=friction)
    for name, x in (("rear", -0.2), ("front", 0.2)):
        m.add_outline_contact(
            name,
            "ground",
            "block",
            [(20.0, 0.0), (-20.0, 0.0)],
            radius,
            law,
            circle_point=(x, -height),
            closed=False,
        )
    return m


def pendulum(**pin):
    """Return a bar of 1 m that hangs 10 mrad beside the vertical."""
    angle = 0.01
    place = (0.5 * math.sin(angle), -0.5 * math.cos(angle), angle - 0.5 * math.pi)
    m = rc.Mechanism()
    m.add_body("bar", mass=2.0, inertia=2.0 / 12.0, position=place)
    m.add_revolute("pin", "ground", "bar", at=(0.0, 0.0), **pin)
    return m


@pytest.mark.parametrize("friction", [rc.Coulomb(0.3), rc.LuGre(0.3, 0.3, damping=10.0)])
def test_a_block_slides_down_an_incline_with_the_acceleration_that_friction_leaves(friction):
    angle = math.atan(0.45)
    result = rc.Simulation(incline(angle, friction)).run(0.4, 0.2, progress=False)
    speeds = result.body("block").velocity[:, 0]
    expected = GRAVITY * (math.sin(angle) - 0.3 * math.cos(angle))
    assert (speeds[2] - speeds[1]) / 0.2 == pytest.approx(expected, rel=1e-5)
    energy = result.energy
    assert abs(energy.residual[-1]) < 1e-5 * energy.dissipated[-1]


def test_a_block_with_bristles_sticks_where_one_with_coulomb_friction_creeps():
    angle = math.atan(0.15)
    moved = {}
    for friction in (rc.Coulomb(0.3), rc.LuGre(0.3, 0.3, damping=10.0)):
        result = rc.Simulation(incline(angle, friction)).run(0.4, 0.2, progress=False)
        places = result.body("block").position[:, 0]
        moved[type(friction)] = places[2] - places[1]
    assert moved[rc.Coulomb] == pytest.approx(0.2 * 1e-3 * math.atanh(0.5), rel=1e-3)
    assert abs(moved[rc.LuGre]) < 1e-7


@pytest.mark.parametrize("corners", [300, 1000, 3000])
def test_friction_on_a_polyline_is_that_on_the_arc_which_it_approximates(corners):
    law = rc.LinearContact(1e5, friction=rc.Coulomb(0.2))
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("disc", 1.0, 0.02)
    angles = -2.0 * np.pi * np.arange(corners) / corners
    points = np.column_stack([0.1 * np.cos(angles), 0.1 * np.sin(angles)])
    mechanism.add_outline_contact("bore", "ground", "disc", points, 0.05, law)
    simulation = rc.Simulation(mechanism)
    # 0.5 mm and 1.6 mm deep, where up to fifty sides are in contact.
    for place, depth in ((0.0505, 0.5e-3), (0.0516, 1.6e-3)):
        found = simulation.evaluate([(place, 1e-4, 0.0)], [(0.0, 0.0, 10.0)])
        torque = 0.02 * found.accelerations[0, 2]
        assert torque == pytest.approx(-0.2 * 0.05 * 1e5 * depth, rel=0.02)


def test_friction_in_a_flat_corner_is_that_of_its_load():
    law = rc.LinearContact(1e5, friction=rc.Coulomb(0.2))
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("disc", 1.0, 0.02, position=(0.0, 0.06, 0.0))
    rise = np.tan(np.radians(1.0))
    points = [(1.0, rise), (0.0, 0.0), (-1.0, rise)]
    mechanism.add_outline_contact("corner", "ground", "disc", points, 0.05, law, closed=False)
    found = rc.Simulation(mechanism).evaluate([(0.0, 0.049, 0.0)], [(0.0, 0.0, 10.0)])
    load = found.accelerations[0, 1]
    torque = 0.02 * found.accelerations[0, 2]
    assert load == pytest.approx(1e5 * 1e-3, rel=0.02)
    assert torque == pytest.approx(-0.2 * 0.05 * load, rel=0.01)


@pytest.mark.parametrize("behind", [0.0, 0.01, 0.02, 0.03])
def test_friction_at_the_end_of_an_open_outline_is_that_of_the_whole_load(behind):
    law = rc.LinearContact(1e5, friction=rc.Coulomb(0.2))
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("disc", 1.0, 0.02, position=(0.5, 0.06, 0.0))
    points = [(1.0, 0.0), (0.0, 0.0)]
    mechanism.add_outline_contact("edge", "ground", "disc", points, 0.05, law, closed=False)
    found = rc.Simulation(mechanism).evaluate([(-0.03, -behind, 0.0)], [(0.0, 0.0, 10.0)])
    # Normal force N and friction 0.2 N are at right angles, and both move the disc.
    normal = np.hypot(*found.accelerations[0, :2]) / np.hypot(1.0, 0.2)
    assert -0.02 * found.accelerations[0, 2] == pytest.approx(0.2 * 0.05 * normal, rel=1e-3)


def test_pin_friction_takes_the_same_angle_off_each_swing():
    mu, radius = 0.02, 0.01
    m = pendulum(friction=rc.Coulomb(mu, speed=1e-6), radius=radius)
    period = 2.0 * math.pi * math.sqrt(2.0 / 3.0 / GRAVITY)
    result = rc.Simulation(m).run(2.0 * period, period / 1000.0, progress=False)
    angle = result.body("bar").position[:, 2] + 0.5 * math.pi
    turns = [abs(angle[start : start + 200]).max() for start in (900, 1800)]
    loss = 2.0 * mu * radius / 0.5
    assert turns == pytest.approx([0.01 - 2 * loss, 0.01 - 4 * loss], abs=0.02 * loss)
    reaction = result.joint("pin")
    assert abs(reaction.torque).max() == pytest.approx(mu * radius * 2.0 * GRAVITY, rel=1e-3)


def test_a_film_carries_a_journal():
    speed, viscosity, length, radius, clearance = 100.0, 0.05, 0.03, 0.01, 2e-5
    m = rc.Mechanism(gravity=(0.0, 0.0))
    m.add_body("journal", 1.0, 1e-4, position=(0.5 * clearance, 0.0, 0.0), velocity=(0, 0, speed))
    film = rc.LubricantFilm(viscosity, handover=0.99, tension=0.0)
    law = rc.SurfaceContact(rc.LankaraniNikravesh(film=film), length=length)
    m.add_clearance_joint("bearing", "ground", "journal", radius + clearance, radius, law)
    m.add_driver("motor", "ground", "journal", speed=speed)
    found = rc.Simulation(m).evaluate().accelerations[0]
    scale = viscosity * speed * radius * length * (radius / clearance) ** 2
    assert found[0] == pytest.approx(-scale * 3.0 / (2.25 * 0.75), rel=1e-9)
    assert found[1] == pytest.approx(scale * 3.0 * math.pi / (2.25 * math.sqrt(0.75)), rel=1e-9)


def test_a_film_of_a_linear_law_has_the_length_of_its_contact():
    film = rc.LubricantFilm(0.05)
    forces = []
    for law in (
        rc.LinearContact(1e10, length=0.03, film=film),
        rc.HuntCrossley(1e9, film=rc.LubricantFilm(0.05, length=0.03)),
    ):
        m = rc.Mechanism(gravity=(0.0, 0.0))
        m.add_body("journal", 1.0, 1e-4, position=(1e-5, 0.0, 0.0), velocity=(1e-3, 0, 0))
        m.add_clearance_joint("bearing", "ground", "journal", 0.01002, 0.01, law)
        forces.append(rc.Simulation(m).evaluate().accelerations[0])
    assert forces[0] == pytest.approx(forces[1])
    assert forces[0][0] < 0.0


def test_a_state_with_bent_bristles_goes_on_to_the_same_bits():
    m = incline(math.atan(0.2), rc.LuGre(0.3, 0.2))
    simulation = rc.Simulation(m)
    simulation.step_to(0.01)
    state = simulation.state()
    simulation.step_to(0.02)
    other = rc.Simulation(m)
    other.set_state(state)
    other.step_to(0.02)
    np.testing.assert_array_equal(simulation.positions, other.positions)
    np.testing.assert_array_equal(simulation.velocities, other.velocities)


def test_friction_and_film_are_carried_by_json_and_pickles():
    law = rc.LinearContact(1e6, friction=rc.LuGre(0.3, 0.2), film=rc.LubricantFilm(0.1))
    assert type(law).from_json(law.to_json()) == law
    assert json.loads(law.to_json())
    m = pendulum(friction=rc.Coulomb(0.1), radius=0.01)
    assert pickle.loads(pickle.dumps(m)) == m
    assert m != pendulum(friction=rc.Coulomb(0.2), radius=0.01)


def test_teeth_of_a_drive_with_ideal_hinges_may_rub():
    drive = rc.paper_drive(pretension=25.0, hinges="ideal")
    # At the default accuracy some of such short runs warn of their residual.
    solver = rc.Solver(accuracy=3e-11)
    lost = []
    for law in (rc.LankaraniNikravesh(), rc.LankaraniNikravesh(friction=rc.Coulomb(0.3))):
        result = rc.Simulation(drive, tooth_law=law, solver=solver).run(5e-3, 1e-3, progress=False)
        lost.append(result.energy.dissipated[-1])
    assert lost[0] != lost[1]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pendulum(friction=rc.Coulomb(0.1)).check(), "pin.*radius = None.*give radius"),
        (lambda: pendulum(radius=0.01).check(), "pin.*radius = 0.01 m.*give friction"),
        (
            lambda: pendulum(friction=rc.Coulomb(0.1), radius=-1.0).check(),
            'radius of joint "pin".*-1',
        ),
        (
            lambda: pendulum(friction=rc.LuGre(0.1, 0.1), radius=0.1).check(),
            "pin.*friction.*Coulomb",
        ),
        (lambda: rc.LinearContact(1e6, friction=0.1), "LinearContact.friction"),
        (
            lambda: incline(0.1, None).add_outline_contact(
                "wet",
                "ground",
                "block",
                [(20.0, 0.0), (-20.0, 0.0)],
                0.01,
                rc.LinearContact(1e6, film=0.1),
            ),
            "LinearContact.film",
        ),
    ],
)
def test_friction_that_means_nothing_is_refused_with_its_field_and_the_remedy(make, message):
    with pytest.raises(rc.InvalidInput, match=message):
        make()


def test_only_clearance_joints_have_a_film_and_it_needs_a_length():
    m = rc.Mechanism()
    m.add_body("disc", 1.0, 0.1, position=(0.0, 1.5, 0.0))
    law = rc.LinearContact(1e6, length=0.01, film=rc.LubricantFilm(0.1))
    m.add_disc_contact("wet", "ground", "disc", 1.0, 0.4, law)
    with pytest.raises(rc.InvalidInput, match=r"film of contact .wet.*only clearance joints"):
        m.check()
    m = rc.Mechanism()
    m.add_body("pin", 1.0, 0.1)
    law = rc.HuntCrossley(1e6, film=rc.LubricantFilm(0.1))
    m.add_clearance_joint("wet", "ground", "pin", 1.1, 1.0, law)
    with pytest.raises(rc.InvalidInput, match=r"length of the film of contact .wet"):
        m.check()
