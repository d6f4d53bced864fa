"""What is wrong in a description of a mechanism is told with part, field, value and remedy."""

import math
import re
import warnings

import numpy as np
import pytest

import rustchain as rc

LAW = rc.LinearContact(1e5, 10.0)
SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def bar():
    mechanism = rc.Mechanism()
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5, 3.0, 0.0))
    return mechanism


def outline(mechanism, points=SQUARE, name="floor", **keywords):
    mechanism.add_outline_contact(name, "ground", "bar", points, radius=0.1, law=LAW, **keywords)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda m: m.add_force("push", "bar", 3.0), "force of 'push' = 3.0: .*two components"),
        (lambda m: m.add_force("push", "bar", ("a", 0.0)), "force 'push': x = 'a': .*a number"),
        (lambda m: m.add_force("push", "ground", (1.0, 0.0)), 'body of force "push" = "ground"'),
        (lambda m: m.add_torque("turn", "bar", "much"), "force 'turn': torque = 'much'"),
        (
            lambda m: m.add_torque("turn", "bar", by_speed=[1.0]),
            "force 'turn': .*rows of two numbers",
        ),
        (lambda m: outline(m, bulges=0.5), "bulges of contact 'floor' = 0.5: .*list of finite"),
        (
            lambda m: outline(m, bulges=[0.1]),
            "bulges of contact 'floor' = .*4 numbers, one for each",
        ),
        (lambda m: outline(m, bulges=[math.nan, 0, 0, 0]), "bulges of contact 'floor' .*finite"),
        (lambda m: outline(m, points=7.0), "points of contact 'floor' = 7.0: .*rows of two finite"),
        (
            lambda m: outline(m, points=[(0, 0, 1)]),
            "points of contact 'floor' .*rows of two finite",
        ),
        (
            lambda m: outline(m, points=SQUARE[::2] + SQUARE[1::2]),
            "cross each other: give the points",
        ),
        (lambda m: m.add_callable("own", "bar", 3.0), "function of force 'own' = 3.0: .*callable"),
        (
            lambda m: m.add_callable("own", "bar", lambda t: (t, 0.0, 0.0)),
            r"function of force 'own' = .*: takes the arguments \(t\); expected three: time, posit",
        ),
        (lambda m: m.add_body("x", 1.0, 1.0, (0.0, 0.0)), "position of body 'x' = .*three finite"),
        (
            lambda m: m.add_body("x", 1.0, 1.0, velocity=(0, 0, math.inf)),
            "velocity of body 'x' = .*three finite",
        ),
        (
            lambda m: m.add_body("x", 1.0, 1.0, velocity=(1.0, 0.0, 0.0), fixed=True),
            'velocity of body "x" .*fixed body',
        ),
        (
            lambda m: m.add_body("x", "heavy", 1.0),
            "body 'x': .*mass = 'heavy': must be a number in kg",
        ),
        (
            lambda m: m.add_revolute("pin", "ground", "bar", at=5.0),
            "at of joint 'pin' = 5.0: .*two",
        ),
        (
            lambda m: m.add_revolute("pin", "ground", "bar", point_b=3.0),
            "point_b of joint 'pin' = 3.0: must be two finite numbers",
        ),
        (lambda m: m.add_gear("pair", "ground", "bar", "x"), "joint 'pair': ratio = 'x'"),
        (
            lambda m: m.add_gear("pair", "ground", "bar", 2.0, carrier=7),
            "joint 'pair': carrier = 7",
        ),
        (
            lambda m: m.add_driver("motor", "ground", "bar", angle=rc.Sines([1.0, 2.0, 3.0])),
            r"Sines.terms.1: got 1.0; expected a sequence",
        ),
        (
            lambda m: m.add_driver("motor", "ground", "bar", angle="fast"),
            "joint 'motor': motion = 'fast': .*SmoothStep, Table, Spline or Sines",
        ),
        (
            lambda m: m.add_spring("s", "ground", "bar", -1.0, cubic=-1.0),
            "stiffness of force 's' = -1.0: must be zero or a positive number in N/m, unless cubic",
        ),
        (
            lambda m: m.add_torsion_spring("s", "ground", "bar", stiffness=-1),
            "stiffness of force 's' = -1: must be zero or a positive number in N m/rad",
        ),
        (
            lambda m: m.add_spring("s", "ground", "bar", 1.0, damping=-1.0),
            'damping of force "s" = -1: must be zero or a positive number',
        ),
        (lambda m: m.add_spring("s", "bar", "bar", 1.0), 'bodies of force "s" = "bar" twice'),
        (
            lambda m: m.add_spring("s", "ground", "bar", 1.0, table=[(0, 0), (1, 1)]),
            'stiffness of force "s" = 1: .*table',
        ),
        (
            lambda m: m.add_disc_contact("d", "bar", "bar", 1.0, 1.0, LAW),
            'contact "d" = "bar" twice',
        ),
        (
            lambda m: m.add_disc_contact("d", "ground", "bar", 1.0, 1.0, "soft"),
            "contact 'd': law = 'soft'",
        ),
        (
            lambda m: m.add_sprocket_contact("d", "ground", "bar", 1, 2, LAW),
            "sprocket of contact 'd' = 1: must be a Sprocket",
        ),
        (
            lambda m: outline(m, points=[(x, y + 2.5) for x, y in SQUARE]),
            "into the material: place",
        ),
        (lambda m: outline(m, points=SQUARE[::-1]), "run clockwise.*reverse their order"),
    ],
)
def test_what_is_wrong_is_told_with_part_field_value_and_remedy(change, says):
    mechanism = bar()

    def made():
        change(mechanism)
        mechanism.check()

    with pytest.raises(rc.InvalidInput, match=says):
        made()


def test_a_gravity_that_is_no_vector_is_refused():
    with pytest.raises(rc.InvalidInput, match=r"gravity = 9.81: must be two finite numbers"):
        rc.Mechanism(gravity=9.81).check()


def held_bar(**changed):
    """A bar of 0.2 m on a bearing, with other inputs."""
    given = {"mass": 1.0, "inertia": 1e-2, "position": (0.1, 0.0, 0.0), "velocity": (0.0,) * 3}
    given |= {name: value for name, value in changed.items() if name in given}
    mechanism = rc.Mechanism(gravity=changed.get("gravity", (0.0, -9.81)))
    mechanism.add_body("bar", **given)
    points = {"point_a": (0.0, 0.0), "point_b": (-0.1, 0.0)}
    points |= {name: value for name, value in changed.items() if name in points}
    mechanism.add_revolute("bearing", "ground", "bar", **points)
    return mechanism


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"gravity": (0.0, -9810.0)}, r"gravity = 9810 m/s\^2: .* give it in m/s\^2"),
        (
            {"position": (100.1, 0.0, 0.0), "point_b": (-100.1, 0.0)},
            "position of body .* divide millimetres by 1000",
        ),
        ({"point_a": (100.0, 0.0), "position": (100.1, 0.0, 0.0)}, "point_a of joint 'bearing'"),
        ({"position": (0.1, 0.0, 45.0)}, "its angle = 45 rad: .* convert degrees"),
        ({"velocity": (0.0, 5e3, 5e4)}, "its rate of turning = 5e.04 rad/s: give it in rad/s"),
        ({"inertia": 1e3}, r"radius of gyration of 31.62 m; give it in kg m\^2"),
    ],
)
def test_inputs_in_another_unit_are_told_with_field_value_and_remedy(changed, says):
    assert held_bar().check().warnings == ()
    (told,) = [text for text in held_bar(**changed).check().warnings if re.search(says, text)]
    with pytest.warns(rc.RustchainWarning) as caught:
        rc.Simulation(held_bar(**changed))
    assert told in [str(warning.message) for warning in caught]


def test_a_body_without_mass_is_told_the_least_that_is_of_use():
    with pytest.raises(rc.InvalidInput, match=r"mass of body \"bar\" = 0: must be above zero"):
        held_bar(mass=0.0).check()
    mechanism = held_bar(inertia=0.0)
    mechanism.add_body("wheel", 2.0, 0.5)
    with pytest.raises(rc.InvalidInput, match=r"inertia of body \"bar\" = 0: .* 5.0e-7 kg m\^2"):
        mechanism.check()


def drop(tolerance):
    mechanism = rc.Mechanism()
    mechanism.add_body("ball", 1.0, 0.01, position=(0.0, 1.0, 0.0))
    line = [(1.0, 0.0), (-1.0, 0.0)]
    mechanism.add_outline_contact("floor", "ground", "ball", line, 0.1, LAW, closed=False)
    solver = rc.Solver(method="pece", rtol=tolerance, atol=tolerance, max_step=0.1)
    return rc.Simulation(mechanism, solver=solver)


def test_an_energy_balance_that_does_not_close_is_told_once():
    simulation = drop(0.5)
    with pytest.warns(rc.EnergyWarning, match="take rtol and atol of 1e-[1-3] or less") as caught:
        result = simulation.run(duration=1.5, report_step=0.01, progress=False)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    energy = result.energy
    assert np.abs(energy.residual).max() > 0.05 * energy.dissipated[-1]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulation.run(duration=0.1, progress=False)
        drop(1e-8).run(duration=1.5, progress=False)


def test_an_ideal_drive_tells_of_its_balance_where_it_is_recorded():
    drive = rc.paper_drive(hinges="ideal", pretension=100.0)
    solver = rc.Solver(method="pece", rtol=0.3, atol=0.03)
    with pytest.warns(rc.EnergyWarning, match="the energy balance is off"):
        rc.Simulation(drive, solver=solver).run(duration=5e-3, report_step=1e-3, progress=False)


def test_links_that_have_to_be_moved_far_to_close_ideal_hinges_are_told():
    drive = rc.paper_drive(hinges="ideal")
    start = rc.Simulation(drive)
    positions = start.positions.copy()
    positions[3, 0] += 1e-3
    with pytest.warns(UserWarning, match="links had to be moved by up to") as caught:
        rc.Simulation(drive, positions=positions, velocities=start.velocities)
    assert [warning.filename for warning in caught] == [__file__]


def test_a_scene_keeps_a_frozen_copy_of_a_mechanism():
    m = rc.Mechanism(name="m")
    m.add_body("a", 1.0, 1.0)
    scene = rc.Scene(m)
    m.add_body("b", 1.0, 1.0)
    assert (scene.body_count, len(m.bodies)) == (1, 2)
    for change in (
        lambda system: system.add_body("z", 1.0, 1.0),
        lambda system: system.add_revolute("pin", "ground", "a"),
        lambda system: system.add_torque("load", "a", 1.0),
        lambda system: system.add_disc_contact("c", "ground", "a", 1, 1, rc.LinearContact(1.0)),
        lambda system: setattr(system, "gravity", (0.0, 0.0)),
    ):
        with pytest.raises(rc.InvalidInput, match=r"scene\.system\.copy\(\)"):
            change(scene.system)
    copied = scene.system.copy()
    assert copied == scene.system
    copied.add_body("z", 1.0, 1.0)
    assert [body.name for body in copied.bodies] == ["a", "z"]
    assert [body.name for body in scene.system.bodies] == ["a"]


def test_a_mechanism_has_a_hash_where_it_cannot_be_changed():
    m = rc.Mechanism()
    with pytest.raises(TypeError, match="unhashable"):
        hash(m)
    first, second = rc.Scene(m), rc.Scene(rc.Mechanism())
    assert hash(first.system) == hash(second.system)
    assert len({first, second}) == 1


def test_a_part_that_no_file_can_hold_is_told_with_its_number_and_name(tmp_path):
    m = rc.Mechanism()
    m.add_body("a", 1.0, 1.0)
    m.add_callable("pull", "a", lambda *_: (0.0, 0.0, 0.0))
    says = r"scene\.system\.forces\.1 \('pull'\)\.function: is a Python function"
    with pytest.raises(rc.InvalidInput, match=says):
        rc.save_scene(rc.Scene(m), tmp_path / "scene.toml")


def test_a_body_in_a_file_has_the_defaults_of_add_body(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(
        """
[mechanism]
gravity = [0.0, -9.81]
[[mechanism.bodies]]
name = "ball"
mass = 1.0
inertia = 0.1
[[mechanism.contacts]]
kind = "disc"
name = "touch"
body_a = "ground"
body_b = "ball"
radius = 0.1
profile_radius = 0.1
law = {type = "LinearContact", stiffness = 1e5}
"""
    )
    m = rc.Mechanism()
    m.add_body("ball", 1.0, 0.1)
    m.add_disc_contact("touch", "ground", "ball", 0.1, 0.1, rc.LinearContact(1e5))
    assert rc.load_scene(path) == rc.Scene(m)


def test_a_snap_spring_has_a_negative_stiffness_and_a_cubic_part():
    mechanism = held_bar()
    mechanism.add_spring("snap", "ground", "bar", -1.0, cubic=100.0, point_a=(0.0, 1.0))
    assert mechanism.check().warnings == ()
