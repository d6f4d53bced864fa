"""What a user of mechanisms is told of idle parts, of assembly, of callables and of drivers."""

import math

import numpy as np
import pytest

import rustchain as rc


def pendulum(**keywords):
    mechanism = rc.Mechanism(**keywords)
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", at=(0.0, 0.0))
    return mechanism


def blank(kind):
    mechanism = pendulum()
    if kind == "body":
        mechanism.add_body("", 1.0, 0.1)
    elif kind == "joint":
        mechanism.add_revolute(" ", "ground", "bar")
    else:
        mechanism.add_force("", "bar", (1.0, 0.0))
    return mechanism


def with_spring(**keywords):
    mechanism = pendulum()
    mechanism.add_spring("strut", "ground", "bar", point_a=(0.0, 1.0), **keywords)
    return mechanism


def with_pin(law, pin_radius=0.02):
    mechanism = pendulum()
    mechanism.add_clearance_joint("pivot", "ground", "bar", 0.02, pin_radius, law, (0.5, 0.0))
    return mechanism


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: rc.Mechanism(gravity=(math.nan, 0.0)), r"gravity = \(nan, 0.0\): .*finite"),
        (lambda: pendulum(gravity=(0.0, math.inf)), r"gravity = \(0.0, inf\): .*finite"),
        (rc.Mechanism, "at least one body"),
        (lambda: blank("body"), 'name of a body = "": must not be blank'),
        (lambda: blank("joint"), 'name of a joint = " "'),
        (lambda: blank("force"), 'name of a force = ""'),
        *[
            (make, rf"{where}'{shown}'.*; expected text without")
            for name, shown, joint, force in (
                ("a\0b", r"a\\x00b", "name of a joint = ", "name of a force = "),
                ("\ud800", r"\\ud800", r"add_revolute\(name\): got ", r"add_force\(name\): got "),
            )
            for make, where in (
                (lambda name=name: rc.Mechanism(name=name), "name of the mechanism = "),
                (lambda name=name: pendulum().add_body(name, 1.0, 0.1), "name of a body = "),
                (lambda name=name: pendulum().add_revolute(name, "ground", "bar"), joint),
                (lambda name=name: pendulum().add_force(name, "bar", (1.0, 0.0)), force),
            )
        ],
        (with_spring, 'stiffness of force "strut" = 0: .*does nothing'),
        (
            lambda: with_pin(rc.LinearContact(1e6)),
            'pin_radius of contact "pivot" = 0.02 m: must be below bore_radius, 0.02 m',
        ),
        (
            lambda: with_pin(rc.SurfaceContact(), 0.021),
            'pin_radius of contact "pivot" = 0.021 m: must be below bore_radius, 0.02 m',
        ),
    ],
)
def test_what_cannot_be_or_does_nothing_is_refused(make, says):
    with pytest.raises(rc.InvalidInput, match=says):
        make().check()


def test_a_radius_is_refused_by_its_argument():
    law, bodies = rc.LinearContact(1e6), ("ground", "bar")
    for add, bad, field in (
        ("add_clearance_joint", (0.0, 0.01), "bore_radius"),
        ("add_clearance_joint", (0.02, -0.01), "pin_radius"),
        ("add_disc_contact", (-0.02, 0.01), "radius_a"),
        ("add_disc_contact", (0.02, 0.0), "radius_b"),
    ):
        mechanism = pendulum()
        getattr(mechanism, add)("x", *bodies, *bad, law)
        with pytest.raises(rc.InvalidInput, match=f'^{field} of contact "x" = .*: must be a posit'):
            mechanism.check()


def test_a_number_of_hundreds_of_digits_is_told_with_its_exponent():
    with pytest.raises(rc.InvalidInput, match=r"= 1e300 m: must be below bore_radius, 0.02 m"):
        with_pin(rc.LinearContact(1e6), 1e300).check()
    with pytest.raises(rc.InvalidInput, match=r"Table.rows = 1e299 after 1e300: "):
        rc.Table([(1e300, 1.0), (1e299, 1.0)])


@pytest.mark.parametrize(
    ("stiffness", "cubic", "told"),
    [
        (0.0, -1.0, "cubic of force 'strut' = -1.0: must be zero or a positive number, unless st"),
        (-1.0, 0.0, "stiffness of force 'strut' = -1.0: .* unless cubic is positive"),
        (-1.0, -1.0, "stiffness of force 'strut' = -1.0: .* unless cubic is positive"),
    ],
)
def test_a_spring_that_pushes_its_ends_apart_without_end_is_refused(stiffness, cubic, told):
    with pytest.raises(rc.InvalidInput, match=told):
        with_spring(stiffness=stiffness, cubic=cubic)
    # One that snaps through pulls again when it is long enough.
    assert with_spring(stiffness=-1.0, cubic=1.0).forces[0].cubic == 1.0


def test_the_place_of_a_joint_is_given_once():
    with pytest.raises(rc.InvalidInput, match=r"at of joint 'pin' = .*: give it, or .* not both"):
        pendulum().add_revolute("pin", "ground", "bar", (0.0, 0.0), at=(0.0, 0.0))


def test_laws_of_a_scene_are_not_for_a_mechanism():
    for given in (
        {"force_law": rc.Hertz()},
        {"hinge_law": rc.Hertz()},
        {"tooth_law": rc.Hertz()},
        {"min_impact_velocity": 1e-2},
    ):
        (name,) = given
        with pytest.raises(rc.InvalidInput, match=f"{name} = .*is not for a mechanism, whose con"):
            rc.Scene(pendulum(), **given)


def test_a_force_law_of_a_contact_is_sent_to_a_surface_contact():
    mechanism = pendulum()
    says = (
        r"is a force law; expected .* as SurfaceContact\(law=EnhancedCylinder\(...\), length=...\)"
    )
    mechanism.add_disc_contact("x", "ground", "bar", 0.1, 0.1, rc.EnhancedCylinder())
    with pytest.raises(rc.InvalidInput, match=says):
        mechanism.check()


def test_a_direction_that_is_none_is_told_as_it_was_given():
    mechanism = pendulum()
    with pytest.raises(rc.InvalidInput, match=r"direction of joint 'guide' = 7: must be two"):
        mechanism.add_prismatic("guide", "ground", "bar", direction=7)
    with pytest.raises(rc.InvalidInput, match=r"point_b of joint 'end' = \(1, 2, 3\): must be two"):
        mechanism.add_revolute("end", "ground", "bar", point_b=(1, 2, 3))


LAW = rc.LinearContact(1e6)
ADDED = {
    "a body": lambda name: pendulum().add_body(name, 1.0, 0.1),
    "a joint": lambda name: pendulum().add_revolute(name, "ground", "bar"),
    "a force": lambda name: pendulum().add_force(name, "bar", (1.0, 0.0)),
    "a contact": lambda name: pendulum().add_disc_contact(name, "ground", "bar", 0.1, 0.1, LAW),
}


@pytest.mark.parametrize("part", ADDED)
@pytest.mark.parametrize("name", ["", " ", "n" * 201, list(range(5000)), None, 7, b"bar"])
def test_a_name_that_tells_no_part_is_refused_when_it_is_given(part, name):
    with pytest.raises(rc.InvalidInput, match=rf"(name of {part} = |\(name\): got )") as caught:
        ADDED[part](name)
    assert len(str(caught.value)) <= 300
    ADDED[part]("n" * 200)


POINTS = {
    "bore_point": lambda m, p: m.add_clearance_joint(
        "x", "ground", "bar", 0.02, 0.01, LAW, bore_point=p
    ),
    "pin_point": lambda m, p: m.add_clearance_joint(
        "x", "ground", "bar", 0.02, 0.01, LAW, pin_point=p
    ),
    "point_a": lambda m, p: m.add_disc_contact("x", "ground", "bar", 0.1, 0.1, LAW, point_a=p),
    "circle_point": lambda m, p: m.add_outline_contact(
        "x", "ground", "bar", [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], 0.1, LAW, circle_point=p
    ),
    "point": lambda m, p: m.add_force("x", "bar", (1.0, 0.0), point=p),
    "point_b": lambda m, p: m.add_distance("x", "ground", "bar", point_b=p),
    "point_a ": lambda m, p: m.add_distance("x", "ground", "bar", point_a=p),
    "point_a  ": lambda m, p: m.add_rack("x", "ground", "bar", (1.0, 0.0), 0.1, point_a=p),
    "point_b ": lambda m, p: m.add_position_driver(
        "x", "ground", "bar", (1.0, 0.0), speed=1.0, point_b=p
    ),
    "point_b  ": lambda m, p: m.add_spring("x", "ground", "bar", 1.0, point_b=p),
}


@pytest.mark.parametrize("field", POINTS)
@pytest.mark.parametrize("point", [(), None, (1.0,), "xy", (0.0, math.inf), 1.0])
def test_a_point_of_a_part_is_refused_by_its_argument(field, point):
    says = rf"^{field.strip()} of (joint|force|contact) 'x' = .*: must be two finite numbers"
    with pytest.raises(rc.InvalidInput, match=says):
        POINTS[field](pendulum(), point)


@pytest.mark.parametrize("rest", [-math.inf, math.inf, math.nan, -1.0, "1", 10**400])
def test_a_rest_length_is_refused_by_its_argument(rest):
    with pytest.raises(rc.InvalidInput, match=r"\brest_length\b"):
        with_spring(stiffness=1.0, rest_length=rest)


def test_what_was_not_moved_is_not_said_to_be():
    mechanism = pendulum()
    mechanism.add_driver("motor", "ground", "bar", angle=0.3)
    report = mechanism.check()
    assert "positions            changed by up to" in str(report)
    (text,) = report.warnings
    assert 'body "bar" had to be moved by' in text
    with pytest.warns(UserWarning, match="had to be moved by") as caught:
        rc.Simulation(mechanism)
    assert [warning.filename for warning in caught] == [__file__]
    assert "turned by 3.000e-1 rad" in text
    assert "0.000e0" not in text
    assert "positions            as given" in str(pendulum().check())
    turned = rc.Mechanism()
    turned.add_body("wheel", 1.0, 0.1)
    turned.add_revolute("axle", "ground", "wheel")
    turned.add_driver("motor", "ground", "wheel", angle=0.3)
    (text,) = turned.check().warnings
    assert text.startswith('body "wheel" had to be turned by 3.000e-1 rad to assemble')


def test_velocities_that_assembly_changed_are_told_by_body():
    mechanism = rc.Mechanism()
    mechanism.add_body("bar", 1.0, 0.1, (0.5, 0.0, 0.0), velocity=(3.0, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", at=(0.0, 0.0))
    report = mechanism.check()
    assert report.velocity_change == pytest.approx(3.0, rel=1e-6)
    (text,) = report.warnings
    assert 'velocity of body "bar" had to be changed by 3.000e0 m/s' in text
    # What is left out is found, and is nothing to warn of.
    driven = pendulum()
    driven.add_driver("motor", "ground", "bar", speed=4.0)
    report = driven.check()
    assert report.warnings == ()
    assert (report.velocity_change, report.spin_change) == pytest.approx((2.0, 4.0))
    assert "velocities           changed by up to 2 m/s, 4 rad/s" in str(report)


def test_a_load_that_is_no_number_is_told_with_force_and_time():
    def load(t, position, velocity):
        return (math.nan if t > 0.1 else 0.0, 0.0, 0.0)

    mechanism = pendulum()
    mechanism.add_callable("own", "bar", load)
    simulation = rc.Simulation(mechanism)
    says = r'load of force "own" at t = 0\.1\d* s = \(nan, 0.0, 0.0\): must be three finite'
    with pytest.raises(rc.InvalidInput, match=says) as caught:
        simulation.run(duration=0.5, progress=False)
    assert caught.value.result.time[-1] <= 0.11


def test_a_callable_that_uses_its_simulation_is_told_what_is_not_allowed():
    seen = []

    def load(t, position, velocity):
        if seen:
            return (0.1 * float(np.sum(seen[0].positions)), 0.0, 0.0)
        return (0.0, 0.0, 0.0)

    mechanism = pendulum()
    mechanism.add_callable("own", "bar", load)
    simulation = rc.Simulation(mechanism)
    seen.append(simulation)
    says = 'function of force "own": uses the simulation that calls it'
    with pytest.raises(rc.InvalidInput, match=says):
        simulation.run(duration=0.1, progress=False)
    seen.clear()
    simulation.run(duration=0.1, progress=False)


def test_a_driver_past_its_reach_is_named_with_what_it_asks():
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("rod", 1.0, 0.1, (0.3, 0.4, math.atan2(0.8, 0.6)))
    mechanism.add_revolute("pin", "ground", "rod", at=(0.0, 0.0))
    mechanism.add_position_driver(
        "lift",
        "ground",
        "rod",
        (0.0, 1.0),
        position=rc.SmoothStep(0.0, 1.0, 0.8, 1.2),
        point_b=(0.5, 0.0),
    )
    simulation = rc.Simulation(mechanism)
    with pytest.raises(
        rc.SimulationError, match=r'driver "lift" prescribes 1\.\d+e0 m, changing at'
    ):
        simulation.run(duration=1.0, progress=False)
    assert 0.4 < simulation.time < 0.6


def test_a_shaft_in_its_bearing_is_as_large_as_the_bearing():
    mechanism = rc.Mechanism()
    mechanism.add_body("shaft", 1.0, 1.2e-4, position=(0.0, -5e-5, 0.0))
    law = rc.LinearContact(stiffness=1e7, damping=10.0)
    mechanism.add_clearance_joint("bearing", "ground", "shaft", 0.0151, 0.015, law)
    assert not [text for text in mechanism.check().warnings if "radius" in text]
