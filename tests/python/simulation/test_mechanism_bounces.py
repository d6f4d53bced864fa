"""Contacts that begin and end between two steps: none is passed over, at any tolerance and step."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from reference.bounces import Bore

PIN = 0.01  # radius [m]
MASS = 0.1  # [kg]


def pin_in_bore(clearance, velocity, **solver):
    mechanism = rc.Mechanism()
    mechanism.add_body("pin", MASS, 1e-5, velocity=(*velocity, 0.0))
    law = rc.SurfaceContact()
    mechanism.add_clearance_joint("joint", "ground", "pin", PIN + clearance, PIN, law)
    return simulation(mechanism, solver)


def simulation(mechanism, solver):
    return rc.Simulation(mechanism, **({"solver": rc.Solver(**solver)} if solver else {}))


def missing(result):
    """Largest energy residual over the kinetic energy of the start."""
    return np.abs(result.energy.residual).max() / result.energy.kinetic[0]


def test_hundreds_of_bounces_are_those_of_the_event_driven_reference():
    rng = np.random.default_rng(2)
    errors = []
    for _ in range(250):
        clearance = 10.0 ** rng.uniform(-6.0, np.log10(5e-4))
        velocity = rng.uniform(-0.2, 0.2, 2)
        bore = Bore(clearance, PIN, MASS, rc.Material())
        *bounces, after = bore.bounces((0.0, 0.0), velocity, 5)
        last = bounces[-1]
        end = 0.5 * (last.end + after.onset)
        result = pin_in_bore(clearance, velocity).run(end, end, progress=False)
        assert result.stats["onsets"] == len(bounces)
        expected = last.velocity - (end - last.end) * np.array([0.0, 9.81])
        error = np.linalg.norm(result.body("pin").velocity[-1, :2] - expected)
        errors.append(error / np.linalg.norm(velocity))
    # Measured: 2e-6 and 4.7e-5.
    assert np.median(errors) < 1e-5
    assert max(errors) < 2e-4


def test_three_hundred_pins_in_50_micrometres_keep_their_energy():
    rng = np.random.default_rng(1)
    for velocity in rng.uniform(-0.2, 0.2, (300, 2)):
        result = pin_in_bore(5e-5, velocity).run(0.05, 1e-3, progress=False)
        assert missing(result) < 1e-3, velocity


@pytest.mark.parametrize(
    ("solver", "share"),
    [
        ({}, 1e-4),
        *[({"rtol": 10.0**-k, "atol": 10.0**-k, "max_step": 0.01}, 1e-3) for k in range(7, 13)],
        ({"method": "newton", "max_step": 0.01}, 1e-2),
        ({"method": "pece", "max_step": 0.01}, 1e-2),
    ],
)
def test_a_pin_thrown_up_in_its_bore_keeps_its_energy_at_every_tolerance(solver, share):
    result = pin_in_bore(7.44e-5, (-0.0542, 0.0891), **solver).run(0.05, 1e-4, progress=False)
    assert missing(result) < share


def test_a_slider_crank_with_clearance_loses_no_bounce_at_sixty_tolerances():
    for exponent in np.linspace(7.0, 11.0, 60):
        m = rc.Mechanism()
        m.add_body("crank", mass=0.3, inertia=6e-5, position=(0.025, 0.0, 0.0))
        m.add_body("rod", mass=0.21, inertia=2.5e-4, position=(0.11, 0.0, 0.0))
        m.add_body("slider", mass=0.14, inertia=1e-4, position=(0.17, 0.0, 0.0))
        m.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
        m.add_revolute("crank pin", "crank", "rod", at=(0.05, 0.0))
        law = rc.SurfaceContact(length=0.015)
        m.add_clearance_joint(
            "wrist pin", "slider", "rod", 0.01, 0.0099, law, pin_point=(0.06, 0.0)
        )
        m.add_prismatic("guide", "ground", "slider", direction=(1.0, 0.0))
        m.add_driver("motor", "ground", "crank", speed=60.0)
        tolerance = 10.0**-exponent
        solver = {"method": "pece", "rtol": tolerance, "atol": tolerance, "max_step": 0.01}
        result = simulation(m, solver).run(0.0078, 7.8e-5, progress=False)
        assert result.stats["onsets"] == 14, tolerance
        assert np.abs(result.energy.residual).max() < 1e-4 * result.energy.kinetic.max()


def ceiling(mechanism, law):
    mechanism.add_outline_contact(
        "stop", "ground", "ball", [(-1.0, 0.05), (1.0, 0.05)], 0.05, law, closed=False
    )


def beam(mechanism, law):
    points = [(-1.0, 0.05), (1.0, 0.05), (1.0, 0.06), (-1.0, 0.06)]
    mechanism.add_outline_contact("stop", "ground", "ball", points, 0.05, law)


def edge(mechanism, law):
    points = [(0.0, 0.05), (0.3, 0.4), (-0.3, 0.4)]
    mechanism.add_outline_contact("stop", "ground", "ball", points, 0.05, law)


def vault(mechanism, law):
    points = [(-0.2, -0.15), (0.2, -0.15)]
    mechanism.add_outline_contact(
        "stop", "ground", "ball", points, 0.05, law, bulges=[-1.0], closed=False
    )


def disc(mechanism, law):
    mechanism.add_disc_contact("stop", "ground", "ball", 0.3, 0.05, law, point_a=(0.0, 0.35))


def teeth(mechanism, law):
    """The seat of a gap that opens downwards, above a roller of the chain."""
    chain = rc.catalogue_chain("ANSI 40", 40)
    wheel = rc.Sprocket(17, (0.0, 0.0))
    height = 0.5 * chain.pitch / np.sin(np.pi / 17)
    mechanism.add_body("wheel", 1.0, 1.0, position=(0.0, height, -np.pi / 2), fixed=True)
    mechanism.add_sprocket_contact("stop", "wheel", "ball", wheel, chain, law)


@pytest.mark.parametrize("stop", [ceiling, beam, edge, vault, disc, teeth])
@pytest.mark.parametrize("method", ["pece", "newton"])
def test_a_ball_thrown_up_to_a_stop_bounces_off_it(stop, method):
    """The path without the stop would be out of it again within a step, by 1e-8 m to 1 mm."""
    rng = np.random.default_rng(4)
    for excess in 10.0 ** rng.uniform(-8.0, -3.0, 12):
        m = rc.Mechanism()
        m.add_body("ball", 1.0, 1e-3, position=(0.0, -0.01, 0.0))
        stop(m, rc.LinearContact(1e6))
        placed = rc.Simulation(m)
        touching = placed.positions.copy()
        touching[0] = 0.0
        rise = 0.01 - placed.evaluate(touching).contact_penetration[0]
        speed = np.sqrt(2.0 * 9.81 * (rise + excess))
        m.bodies = (replace(m.bodies[0], velocity=(0.0, speed, 0.0)), *m.bodies[1:])
        solver = {"method": method, "accuracy": 1e-11, "max_step": 0.1}
        result = simulation(m, solver).run(2.2 * speed / 9.81, 1e-3, progress=False)
        assert result.stats["onsets"] == 1, excess
        assert missing(result) < 1e-4, excess


def test_onsets_and_forces_of_a_bounce_are_recorded_with_their_row():
    m = rc.Mechanism()
    m.add_body("ball", 1.0, 1e-3, position=(0.0, 0.15, 0.0))
    line = [(1.0, 0.0), (-1.0, 0.0)]
    law = rc.LinearContact(1e5)
    m.add_outline_contact("floor", "ground", "ball", line, 0.05, law, closed=False)
    result = rc.Simulation(m).run(0.4, 1e-3, progress=False)
    floor = result.contact("floor")
    begun = np.flatnonzero(floor.impact_velocity)
    fall = np.sqrt(2.0 * 0.1 / 9.81)
    assert [int(np.ceil(fall / 1e-3))] == begun.tolist()
    np.testing.assert_allclose(floor.impact_velocity[begun], 9.81 * fall, rtol=1e-7)
    np.testing.assert_allclose(floor.force_vector[:, 1], floor.force, rtol=1e-12)
    assert floor.force.max() > 0.0
    assert not floor.force_vector[:, 0].any()


def test_the_accuracy_that_a_warning_advises_closes_the_balance():
    rng = np.random.default_rng(5)
    told = 0
    for _ in range(12):
        height, stiffness = rng.uniform(0.06, 0.3), 10.0 ** rng.uniform(4.0, 7.0)

        def bounce(accuracy, height=height, stiffness=stiffness):
            m = rc.Mechanism()
            m.add_body("ball", 1.0, 1e-3, position=(0.0, height, 0.0))
            line = [(1.0, 0.0), (-1.0, 0.0)]
            law = rc.LinearContact(stiffness, 20.0)
            m.add_outline_contact("floor", "ground", "ball", line, 0.05, law, closed=False)
            solver = {"accuracy": accuracy, "max_step": 0.01}
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                simulation(m, solver).run(0.5, 1e-3, progress=False)
            return [str(warning.message) for warning in caught]

        for text in bounce(1e-6):
            told += 1
            advised = float(re.search(r"accuracy = (\S+) or less", text)[1])
            assert bounce(advised) == []
    assert told > 3
