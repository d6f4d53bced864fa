"""Static equilibrium of mechanisms and of drives with ideal hinges against statics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize, minimize_scalar

import rustchain as rc

GRAVITY = 9.81


def at_rest(system, **keywords):
    """Return the static start of a system, which a run begins without accelerations."""
    simulation = rc.Simulation(system, start="static", **keywords)
    assert simulation.rest["iterations"] < 2000
    if isinstance(system, rc.Mechanism) and not simulation.velocities.any():
        mass = np.array([[body.mass, body.mass, 0.0] for body in system.bodies])
        forces = np.abs(mass * simulation.evaluate().accelerations).max()
        assert forces <= 1.5 * simulation.rest["residual"] + 1e-9
    return simulation


def bar(mechanism, name, a, b, mass):
    """Add a uniform bar between two points."""
    a, b = np.array(a), np.array(b)
    along = b - a
    place = (*(a + b) / 2, np.arctan2(along[1], along[0]))
    mechanism.add_body(name, mass, mass * (along @ along) / 12, position=place)


def bars(points, masses):
    """Return a chain of bars, its first end fixed to the ground."""
    mechanism = rc.Mechanism(name="chain of bars")
    before = "ground"
    for i, mass in enumerate(masses):
        bar(mechanism, f"bar {i}", points[i], points[i + 1], mass)
        mechanism.add_revolute(f"hinge {i}", before, f"bar {i}", at=tuple(points[i]))
        before = f"bar {i}"
    return mechanism


@pytest.mark.parametrize("angle", [0.0, 1.0, -1.4, 1.55])
def test_a_pendulum_hangs_straight(angle):
    mechanism = bars([(0.0, 0.0), (np.cos(angle), np.sin(angle))], [1.0])
    rest = at_rest(mechanism).positions[0]
    np.testing.assert_allclose(rest[:2], [0.0, -0.5], atol=1e-7)
    assert rest[2] % (2 * np.pi) == pytest.approx(1.5 * np.pi)


@pytest.mark.parametrize("rest_length", [0.3, None])
def test_a_mass_hangs_on_a_spring_by_its_weight(rest_length):
    # A length that is not given is that of the described position, not that of the equilibrium.
    mechanism = rc.Mechanism(name="mass on a spring")
    mechanism.add_body("mass", 2.0, 0.01, position=(0.0, -0.3, 0.0))
    mechanism.add_prismatic("guide", "ground", "mass", direction=(0.0, 1.0))
    mechanism.add_spring("spring", "ground", "mass", stiffness=1000.0, rest_length=rest_length)
    simulation = at_rest(mechanism)
    place = -0.3 - 2.0 * GRAVITY / 1000.0
    assert simulation.positions[0, 1] == pytest.approx(place, rel=1e-9)
    result = simulation.run(0.05, progress=False)
    np.testing.assert_allclose(result.body("mass").position[:, 1], place, rtol=1e-7)


def test_two_bars_lean_with_a_side_force():
    masses, force = (0.7, 0.4), 3.0
    mechanism = bars([(0.0, 0.0), (0.5, 0.0), (0.8, 0.1)], masses)
    length = np.hypot(0.3, 0.1)
    mechanism.add_force("wind", "bar 1", force=(force, 0.0), point=(length / 2, 0.0))
    angles = at_rest(mechanism).positions[:, 2]
    # Moments about each hinge: the weight beyond it acts at half of its own bar.
    below = np.array([masses[0] / 2 + masses[1], masses[1] / 2])
    np.testing.assert_allclose(np.tan(angles), -below * GRAVITY / force, rtol=1e-6)


def four_bar():
    """Return a four-bar linkage with unequal bars, and its corners."""
    corners = [(0.0, 0.0), (0.15, 0.25), (0.55, 0.3), (0.6, 0.0)]
    mechanism = bars(corners, [0.8, 1.5, 0.5])
    mechanism.add_revolute("end", "bar 2", "ground", at=corners[3])
    return mechanism, np.array(corners)


def test_a_four_bar_linkage_rests_where_its_potential_energy_is_least():
    mechanism, corners = four_bar()
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    masses = np.array([0.8, 1.5, 0.5])

    def shape(angle):
        """Return the corners at an angle of the first bar, on the branch of the equilibrium."""
        b = lengths[0] * np.array([np.cos(angle), np.sin(angle)])
        to = corners[3] - b
        distance = np.linalg.norm(to)
        along = (distance**2 + lengths[1] ** 2 - lengths[2] ** 2) / (2 * distance)
        height = np.sqrt(lengths[1] ** 2 - along**2)
        across = np.array([-to[1], to[0]]) / distance
        return np.array(
            [[0.0, 0.0], b, b + along * to / distance + side * height * across, corners[3]]
        )

    def energy(angle):
        places = shape(angle)
        return GRAVITY * masses @ (places[:-1, 1] + places[1:, 1]) / 2

    begin = np.arctan2(0.25, 0.15)
    rest = at_rest(mechanism).positions
    found = np.arctan2(rest[0, 1], rest[0, 0])
    second, third = 2 * rest[0, :2], 2 * rest[1, :2] - 2 * rest[0, :2]
    to, along = corners[3] - second, third - second
    side = np.sign(to[0] * along[1] - to[1] * along[0])
    least = minimize_scalar(
        energy, bounds=(found - 0.1, found + 0.1), method="bounded", options={"xatol": 1e-12}
    )
    assert abs(found - begin) > 0.3
    assert energy(found) <= least.fun + 1e-9
    assert found == pytest.approx(least.x, abs=1e-5)


def test_a_body_hangs_on_two_springs():
    mechanism = rc.Mechanism(name="body on two springs")
    mechanism.add_body("body", 3.0, 0.02, position=(0.0, -0.4, 0.0))
    anchors, points = np.array([[-0.3, 0.0], [0.3, 0.0]]), np.array([[-0.1, 0.05], [0.2, 0.05]])
    stiffness, free = np.array([400.0, 900.0]), 0.25
    for i in range(2):
        mechanism.add_spring(
            f"spring {i}",
            "ground",
            "body",
            point_a=tuple(anchors[i]),
            point_b=tuple(points[i]),
            stiffness=stiffness[i],
            rest_length=free,
        )

    def energy(q):
        cos, sin = np.cos(q[2]), np.sin(q[2])
        ends = q[:2] + points @ np.array([[cos, sin], [-sin, cos]])
        stretch = np.linalg.norm(ends - anchors, axis=1) - free
        return 3.0 * GRAVITY * q[1] + 0.5 * stiffness @ stretch**2

    rest = at_rest(mechanism).positions[0]
    least = minimize(energy, rest + 0.01, method="BFGS", options={"gtol": 1e-8})
    np.testing.assert_allclose(rest, least.x, atol=1e-6)


@pytest.mark.parametrize("links", [12, 60])
def test_a_hanging_chain_of_links_is_a_discrete_catenary(links):
    length, span, rise = 0.1, 0.08 * links, 0.01 * links
    # Laid as a zigzag between two points.
    step = np.array([span, rise]) / links
    deep = np.sqrt(length**2 - step @ step)
    across = np.array([-step[1], step[0]]) / np.linalg.norm(step)
    points = [i * step + (i % 2) * deep * across for i in range(links + 1)]
    mechanism = bars(points, [0.05] * links)
    mechanism.add_revolute("end", f"bar {links - 1}", "ground", at=tuple(points[-1]))
    angles = at_rest(mechanism).positions[:, 2]
    # The horizontal force H is the same in all links; the vertical force in the middle of link i
    # grows by a link's weight from one to the next: tan θ_i = (V + i w) / H.
    weight = 0.05 * GRAVITY
    number = np.arange(links)

    def ends(pull, vertical):
        slopes = (vertical + number * weight) / pull
        cosines = 1.0 / np.hypot(1.0, slopes)
        return length * cosines.sum() - span, length * (slopes * cosines).sum() - rise

    def vertical(pull):
        most = 10 * links * weight
        return brentq(lambda v: ends(pull, v)[1], -most, most, xtol=1e-13)

    pull = brentq(lambda h: ends(h, vertical(h))[0], 1e-3 * weight, 100 * links * weight)
    expected = np.arctan((vertical(pull) + number * weight) / pull)
    np.testing.assert_allclose(np.sin(angles), np.sin(expected), atol=1e-5)


@pytest.mark.parametrize(
    ("law", "penetration"),
    [
        (rc.LinearContact(1e6, 50.0), lambda force: force / 1e6),
        (rc.HuntCrossley(2e9, 1.5, 10.0), lambda force: (force / 2e9) ** (2 / 3)),
    ],
)
def test_a_pin_with_clearance_penetrates_by_the_inverse_of_its_law(law, penetration):
    mechanism = rc.Mechanism(name="pin")
    mechanism.add_body("mass", 5.0, 0.01, position=(0.0, 0.0, 0.0))
    mechanism.add_clearance_joint("pin", "ground", "mass", 0.0102, 0.01, law)
    simulation = at_rest(mechanism)
    expected = penetration(5.0 * GRAVITY)
    assert simulation.evaluate().contact_penetration[0] == pytest.approx(expected, rel=1e-5)
    assert simulation.positions[0, 1] == pytest.approx(-2e-4 - expected, rel=1e-6)
    assert simulation.rest["largest_force"] == pytest.approx(5.0 * GRAVITY)


def add_floor(mechanism, radius, law, x=0.0):
    """Add a floor at y = 0 below a circle at `x` in the frame of the body."""
    points, place = [(3.0, 0.0), (-3.0, 0.0)], {"circle_point": (x, 0.0), "closed": False}
    mechanism.add_outline_contact(f"floor {x}", "ground", "body", points, radius, law, **place)


@pytest.mark.parametrize("angle", [0.1, 1.0, 1.4])
@pytest.mark.parametrize(
    "law",
    [rc.SurfaceContact(law) for law in (rc.Hertz(), rc.LankaraniNikravesh(), rc.Johnson())],
)
def test_a_leaning_rod_lies_down(law, angle):
    # Standing on one end is an equilibrium too, an unstable one.
    mechanism = rc.Mechanism(name="rod")
    mechanism.add_body("body", 1.0, 0.02, position=(0.0, 0.25 * np.sin(angle) + 0.02, angle))
    for x in (-0.25, 0.25):
        add_floor(mechanism, 0.02, law, x)
    simulation = rc.Simulation(mechanism, start="static")
    assert abs(np.sin(simulation.positions[0, 2])) < 1e-6
    np.testing.assert_allclose(simulation.evaluate().contact_force, GRAVITY / 2, rtol=1e-6)


@pytest.mark.parametrize("beside", [1e-4, 0.06])
def test_a_disc_beside_the_top_of_another_rolls_off(beside):
    law = rc.SurfaceContact(rc.Hertz())
    mechanism = rc.Mechanism(name="disc")
    mechanism.add_body("body", 1.0, 1e-3, position=(beside, 0.4, 0.0))
    add_floor(mechanism, 0.05, law)
    mechanism.add_disc_contact("top", "ground", "body", 0.1, 0.05, law, point_a=(0.0, 0.25))
    wall = [(0.3, 1.0), (0.3, -1.0)]
    mechanism.add_outline_contact("wall", "ground", "body", wall, 0.05, law, closed=False)
    x, y, _ = rc.Simulation(mechanism, start="static").positions[0]
    assert y == pytest.approx(0.05, abs=1e-6)
    assert x > 0.1


@pytest.mark.parametrize("heavy", [1e6, 1e9])
def test_a_light_body_beside_a_heavy_one_comes_to_rest(heavy):
    # A pendulum and a mass on a spring: the weight of the frame is no measure of their balance.
    mechanism = bars([(0.0, 0.0), (1.0, 0.0)], [1.0])
    mechanism.add_body("mass", 2.0, 0.01, position=(0.0, -0.3, 0.0))
    mechanism.add_prismatic("guide", "ground", "mass", direction=(0.0, 1.0))
    mechanism.add_spring("spring", "ground", "mass", stiffness=1000.0)
    mechanism.add_body("frame", heavy, heavy, position=(3.0, 0.0, 0.0))
    mechanism.add_fixed("foot", "ground", "frame", at=(3.0, 0.0))
    rest = rc.Simulation(mechanism, start="static").positions
    np.testing.assert_allclose(rest[0, :2], [0.0, -0.5], atol=1e-6)
    assert rest[1, 1] == pytest.approx(-0.3 - 2.0 * GRAVITY / 1000.0, rel=1e-6)


@pytest.mark.parametrize("stiffness", [10.0, 3e3, 7e5])
@pytest.mark.parametrize("length", [0.45, 0.47])
def test_a_spring_relaxes_where_nothing_else_acts(stiffness, length):
    # The force falls to rounding, and with it the force that it is compared with.
    mechanism = bars([(0.0, 0.0), (1.0, 0.0)], [1.0])
    mechanism.gravity = (0.0, 0.0)
    spring = {"point_a": (0.3, 0.6), "point_b": (0.2, 0.0), "rest_length": length}
    mechanism.add_spring("spring", "ground", "bar 0", stiffness=stiffness, **spring)
    simulation = rc.Simulation(mechanism, start="static")
    angle = simulation.positions[0, 2]
    end = 0.7 * np.array([np.cos(angle), np.sin(angle)])
    assert np.hypot(*(end - spring["point_a"])) == pytest.approx(length, rel=1e-14)
    assert simulation.rest["residual"] < 1e-14 * stiffness


def test_drivers_are_held_and_their_speeds_kept():
    mechanism = bars([(0.0, 0.0), (0.1, 0.0), (0.4, 0.0)], [0.3, 0.6])
    mechanism.add_driver("motor", "ground", "bar 0", speed=20.0)
    simulation = at_rest(mechanism)
    np.testing.assert_allclose(simulation.positions[0], [0.05, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(simulation.positions[1, :2], [0.1, -0.15], atol=1e-7)
    assert simulation.velocities[0, 2] == pytest.approx(20.0)


def test_a_load_of_the_first_instant_is_held_by_a_torsion_spring():
    mechanism = rc.Mechanism(name="disc")
    mechanism.add_body("disc", 2.0, 0.01)
    mechanism.add_revolute("axle", "ground", "disc", at=(0.0, 0.0))
    mechanism.add_torque("load", "disc", [(0.0, 5.0), (1.0, 0.0)])
    mechanism.add_torsion_spring("spring", "ground", "disc", stiffness=0.5)
    assert at_rest(mechanism).positions[0, 2] == pytest.approx(10.0)


def test_what_nothing_holds_is_refused_by_name():
    mechanism = rc.Mechanism(name="wheel")
    mechanism.add_body("wheel", 2.0, 0.01)
    mechanism.add_revolute("axle", "ground", "wheel", at=(0.0, 0.0))
    mechanism.add_torque("load", "wheel", 3.0)
    with pytest.raises(rc.InvalidInput, match='nothing holds body "wheel", which has turned'):
        rc.Simulation(mechanism, start="static")
    falling = rc.Mechanism(name="ball")
    falling.add_body("ball", 2.0, 0.01, position=(0.0, 1.0, 0.0))
    with pytest.raises(rc.InvalidInput, match='nothing holds body "ball", which has moved'):
        rc.Simulation(falling, start="static")


@pytest.mark.parametrize("count", [2, 3, 20])
def test_a_taut_straight_chain_is_not_at_rest(count):
    # No finite tension carries a weight across a straight chain.
    points = [(0.1 * i, 0.0) for i in range(count + 1)]
    mechanism = bars(points, [0.05] * count)
    mechanism.add_revolute("end", f"bar {count - 1}", "ground", at=points[-1])
    with pytest.raises(rc.InvalidInput, match="no finite force is in balance: give it slack"):
        rc.Simulation(mechanism, start="static")


def test_a_toggle_near_its_dead_centre_rests():
    """Two bars at 0.01 degrees: the reaction is the weight of one over twice the tangent."""
    angle = np.deg2rad(0.01)
    points = [(0.0, 0.0), (1.0, -np.tan(angle)), (2.0, 0.0)]
    mechanism = bars(points, [1.0, 1.0])
    mechanism.add_revolute("end", "bar 1", "ground", at=points[-1])
    simulation = at_rest(mechanism)
    assert simulation.rest["largest_force"] == pytest.approx(GRAVITY)
    reaction = np.hypot(*simulation.evaluate().joint_reaction[0, :2])
    assert reaction == pytest.approx(GRAVITY / (2 * np.tan(angle)), rel=1e-4)


@pytest.mark.parametrize("stiffness", [1e8, 1e12])
def test_a_stiff_spring_holds_to_the_rounding_of_the_positions(stiffness):
    mechanism = rc.Mechanism(name="mass on a stiff spring")
    mechanism.add_body("mass", 1.0, 1.0, position=(0.0, -1.0, 0.0))
    mechanism.add_prismatic("guide", "ground", "mass", direction=(0.0, 1.0))
    mechanism.add_spring("spring", "ground", "mass", stiffness=stiffness, rest_length=1.0)
    simulation = at_rest(mechanism)
    assert simulation.rest["largest_force"] == pytest.approx(GRAVITY, rel=1e-4)
    assert simulation.rest["residual"] <= 1e-6 * GRAVITY + np.finfo(float).eps * stiffness
    bound = 3e-16 + simulation.rest["residual"] / stiffness
    assert simulation.positions[0, 1] == pytest.approx(-1.0 - GRAVITY / stiffness, abs=bound)


def test_a_pull_that_grows_from_zero_is_named():
    # With ideal hinges there is a rest: both sprockets in one place, and the chain hanging on them.
    mechanism = rc.paper_drive(pretension=25.0).to_mechanism(hinges="clearance")
    with pytest.raises(rc.InvalidInput, match=r'"tensioner_2" is zero at t = 0 .* ramp_time = 0'):
        rc.Simulation(mechanism, start="static")


def test_friction_that_is_left_out_is_named():
    mechanism = rc.Mechanism(name="ball on a slope")
    mechanism.add_body("ball", 1.0, 1e-3, position=(0.5, 0.1, 0.0))
    slope = [(0.9, 0.1), (0.1, 0.0)]
    for friction, told in ((rc.Coulomb(0.5), True), (None, False)):
        other = replace(mechanism)
        law = rc.LinearContact(1e5, 20.0, friction=friction)
        other.add_outline_contact("floor", "ground", "ball", slope, 0.05, law, closed=False)
        with pytest.raises(rc.InvalidInput, match='nothing holds body "ball"') as refused:
            rc.Simulation(other, start="static")
        assert ("friction is left out" in str(refused.value)) == told


def test_a_drive_of_ideal_hinges_at_rest_exchanges_no_energy_to_warn_of():
    drive = rc.paper_drive(pretension=25.0)
    sprockets = [replace(sprocket, motion=rc.Free()) for sprocket in drive.sprockets]
    # Warnings are errors here.
    result = at_rest(replace(drive, hinges="ideal", sprockets=sprockets)).run(0.01, progress=False)
    assert np.abs(result.energy.residual).max() < 1e-8


def test_an_exception_of_a_callable_ends_the_search():
    mechanism = rc.Mechanism(name="spring of Python")
    mechanism.add_body("body", 1.0, 0.1)
    mechanism.add_callable("spring", "body", lambda _t, q, _v: (0.0, 1.0 / q[1], 0.0))
    with pytest.raises(ZeroDivisionError):
        rc.Simulation(mechanism, start="static")


def test_a_state_of_a_static_start_is_saved_and_loaded(tmp_path):
    mechanism = rc.Mechanism(name="mass on a spring")
    mechanism.add_body("mass", 2.0, 0.01, position=(0.0, -0.3, 0.0))
    mechanism.add_prismatic("guide", "ground", "mass", direction=(0.0, 1.0))
    mechanism.add_spring("spring", "ground", "mass", stiffness=1000.0)
    simulation = at_rest(mechanism)
    simulation.step_to(0.01)
    simulation.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    for each in (simulation, again):
        each.step_to(0.02)
    np.testing.assert_array_equal(again.positions, simulation.positions)


def tensioned(hinges):
    """Return a drive of two sprockets at rest, pulled apart by 200 N without gravity."""
    drive = rc.paper_drive(pretension=100.0)
    sprockets = [replace(s, motion=rc.PrescribedSpeed(0.0)) for s in drive.sprockets[:1]]
    sprockets.append(replace(drive.sprockets[1], motion=rc.Free()))
    return replace(drive, sprockets=sprockets, gravity=(0.0, 0.0), hinges=hinges)


def test_strands_of_ideal_hinges_have_half_the_force_of_the_tensioner():
    drive = tensioned("ideal")
    simulation = at_rest(drive)
    forces = simulation.evaluate().hinge_force_vector
    places = simulation.positions[: drive.chain.links, :2]
    middle = np.mean([sprocket.center[0] for sprocket in drive.sprockets])
    cut = [
        side[np.argmin(np.abs(places[side, 0] - middle))]
        for side in (np.flatnonzero(places[:, 1] > 0.0), np.flatnonzero(places[:, 1] < 0.0))
    ]
    # A cut through both strands: without weight they are parallel to the force of the tensioner.
    force = drive.check().tension_force
    assert np.abs(forces[cut, 0]).sum() == pytest.approx(force, rel=1e-4)
    tension = {}
    for hinges in ("ideal", "clearance"):
        result = at_rest(tensioned(hinges)).run(1e-5, 1e-5, progress=False)
        tension[hinges] = [result.strand(name).tension[0] for name in ("upper", "lower")]
    np.testing.assert_allclose(tension["ideal"], force / 2, rtol=0.01)
    np.testing.assert_allclose(tension["ideal"], tension["clearance"], rtol=5e-3)


def test_a_drive_rests_as_the_mechanism_of_it():
    # The drive and its mechanism have equations of their own.
    drive = tensioned("clearance")
    drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=0.0))
    of_drive, of_mechanism = at_rest(drive), at_rest(drive.to_mechanism())
    forces = [simulation.rest["largest_force"] for simulation in (of_drive, of_mechanism)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-7)
    np.testing.assert_allclose(of_mechanism.positions, of_drive.positions, atol=1e-7)


@pytest.mark.parametrize("pivot", [None, (0.05, 0.05)])
def test_links_of_a_running_drive_with_ideal_hinges_move_along_its_teeth(pivot):
    drive = rc.paper_drive(pretension=100.0)
    tensioner = replace(drive.tensioner, pivot=pivot)
    simulation = at_rest(replace(drive, hinges="ideal", tensioner=tensioner))
    speed = drive.sprockets[0].motion.speed
    first = simulation.body_names.index("sprocket_1")
    assert simulation.velocities[first, 2] == pytest.approx(speed)
    # The damping of a contact that is approached would change its force.
    still = simulation.evaluate(velocities=np.zeros_like(simulation.velocities)).tooth_force
    forces = simulation.evaluate().tooth_force
    loaded = still > 0.01 * still.max()
    np.testing.assert_allclose(forces[loaded], still[loaded], rtol=0.05)


@pytest.mark.parametrize(("height", "closed"), [(-1e-6, True), (1e-6, False)])
def test_a_mechanism_with_a_closed_contact_begins_with_the_implicit_corrector(height, closed):
    mechanism = rc.Mechanism(name="pin")
    mechanism.add_body("mass", 5.0, 0.01, position=(0.0, -2e-4 + height, 0.0))
    law = rc.LinearContact(1e6, 50.0)
    mechanism.add_clearance_joint("pin", "ground", "mass", 0.0102, 0.01, law)
    simulation = rc.Simulation(mechanism, solver=rc.Solver(method="auto"))
    simulation.run(1e-7, report_step=1e-7)
    assert (simulation.stats["jacobians"] > 0) == closed
