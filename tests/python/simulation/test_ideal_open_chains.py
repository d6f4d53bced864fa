"""Open chains with ideal hinges: pendulums of links by Lagrange's equations, hoists, moved ends."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rustchain as rc

GRAVITY = 9.81
ROWS = ((0.0, 0.0), (0.02, 0.4), (0.06, -0.3), (0.08, 0.0))  # speed of an end [s, m/s]
GROUPS = ("hinges", "teeth", "sprockets", "bodies", "energy")


class Pendulum:
    """Rigid links on a pivot, in their angles; a point-like load may hang on the last one."""

    def __init__(self, chain, load=None):
        links, arm = chain.links, 0.5 * chain.pitch
        bodies = [chain.inner if k % 2 == 0 else chain.outer for k in range(links)]
        self.mass = np.array([body.mass for body in bodies])
        self.inertia = np.array([body.inertia for body in bodies])
        # Place of a centre: the sum of these lengths times the directions of the links.
        self.arms = np.tril(np.full((links, links), 2.0 * arm), -1) + arm * np.eye(links)
        if load is not None:
            self.mass = np.append(self.mass, load)
            self.arms = np.vstack([self.arms, np.full(links, 2.0 * arm)])

    def rates(self, _, state, acceleration=0.0):
        """Speeds and angular accelerations; the pivot has this acceleration along x."""
        angle, spin = np.split(state, 2)
        along, across = -self.arms * np.sin(angle), self.arms * np.cos(angle)
        weighted = self.mass[:, None]
        mass = np.diag(self.inertia) + along.T @ (weighted * along) + across.T @ (weighted * across)
        x = -self.arms @ (np.cos(angle) * spin**2) + acceleration
        y = -self.arms @ (np.sin(angle) * spin**2) + GRAVITY
        force = -along.T @ (self.mass * x) - across.T @ (self.mass * y)
        return np.concatenate([spin, np.linalg.solve(mass, force)])

    def centers(self, angle):
        """Centres of all bodies, from the pivot."""
        return np.column_stack([self.arms @ np.cos(angle), self.arms @ np.sin(angle)])


def test_a_chain_that_falls_is_a_pendulum_of_rigid_links():
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd())
    drive = rc.open_chain("ANSI 40", ends, 7, hinges="ideal")
    pendulum = Pendulum(drive.chain)
    angle = -0.5 * np.pi + np.random.default_rng(1).uniform(-1.0, 1.0, 7)
    place = rc.Simulation(drive).positions.copy()
    place[:7] = np.column_stack([pendulum.centers(angle), angle])
    still = {"positions": place, "velocities": np.zeros_like(place)}
    exact = solve_ivp(
        pendulum.rates, (0.0, 0.05), np.append(angle, np.zeros(7)), "DOP853", rtol=1e-12, atol=1e-12
    )
    for method, error in (("auto", 1e-11), ("newton", 1e-10), ("pece", 1e-11)):
        solver = rc.Solver(method=method, accuracy=1e-11)
        simulation = rc.Simulation(drive, solver=solver, **still)
        result = simulation.run(0.05, 1e-3, record=GROUPS, progress=False)
        found = simulation.positions
        np.testing.assert_allclose(found[:7, :2], pendulum.centers(exact.y[:7, -1]), atol=error)
        assert np.abs(found[:7] - place[:7]).max() > 0.01
        assert np.abs(result.energy.residual).max() < 1e-6 * result.energy.kinetic.max()
        # The pin of an end without a body has no force, and no ends are joined to each other.
        forces = result.array("hinge_force")
        assert not forces[:, 6].any()
        assert not forces[:, 7].any()
        assert forces[:, 8].min() > 0.0


def test_a_moved_end_swings_a_load_and_does_its_work():
    velocity = [(t, speed, 0.0) for t, speed in ROWS]
    ends = (rc.AnchoredEnd((0.0, 0.0), velocity), rc.LoadedEnd(1.0))
    drive = rc.open_chain("ANSI 40", ends, 12, hinges="ideal")
    pendulum = Pendulum(drive.chain, load=1.0)
    state = np.append(np.full(12, -0.5 * np.pi), np.zeros(12))
    for (start, slow), (end, fast) in pairwise(ROWS):
        given = {"args": ((fast - slow) / (end - start),), "rtol": 1e-12, "atol": 1e-13}
        swing = solve_ivp(pendulum.rates, (start, end), state, "DOP853", **given)
        state = swing.y[:, -1]
    simulation = rc.Simulation(drive)
    result = simulation.run(0.08, 1e-3, record=GROUPS, progress=False)
    pivot = np.array([3e-3, 0.0])  # the integral of the speed
    found = simulation.positions
    np.testing.assert_allclose(found[:13, :2], pendulum.centers(state[:12]) + pivot, atol=1e-11)
    np.testing.assert_allclose(found[13, :2], pivot, atol=1e-15)
    # Work of the end: that of its force, row by row, and the gain of energy.
    energy = result.energy
    assert np.abs(energy.residual).max() < 1e-7 * np.abs(energy.external_work).max()
    speeds = np.interp(result.time, *zip(*ROWS, strict=True))
    power = -result.end(1).force[:, 0] * speeds
    steps = np.diff(result.time)
    work = np.append(0.0, np.cumsum(0.5 * steps * (power[1:] + power[:-1])))
    # The force jumps at the rows of the speed.
    np.testing.assert_allclose(energy.external_work, work, atol=0.02 * np.abs(work).max())


def test_a_chain_lifted_straight_up_moves_as_one_body():
    """The force on a moved end jumps at each row of its speed."""
    rows = [(0.0, 0.0, 0.0), (0.01, 0.0, 0.3), (0.02, 0.0, -0.3), (0.03, 0.0, -0.3)]
    ends = (rc.AnchoredEnd((0.0, 0.0), rows), rc.LoadedEnd(10.0))
    for links in (4, 12):  # fewer links than a vector has numbers, and more
        drive = rc.open_chain("ANSI 40", ends, links, hinges="ideal")
        result = rc.Simulation(drive).run(0.03, 2.5e-4, record=GROUPS, progress=False)
        speed = np.interp(result.time, *np.array(rows)[:, ::2].T)
        found = result.array("velocities")[:, :, 1]
        np.testing.assert_allclose(found, np.tile(speed, (links + 2, 1)).T, atol=1e-10)
        energy = result.energy
        assert np.abs(energy.residual).max() < 1e-8 * energy.external_work.max()


def test_light_loads_on_both_sides_have_the_motion_of_explicit_steps():
    """No prescribed end: the factors of the implicit corrector have single precision."""
    ends = (rc.LoadedEnd(0.05), rc.LoadedEnd(0.08))
    wheel = rc.Sprocket(17, motion=rc.PrescribedSpeed(3.0))
    drive = rc.open_chain("ANSI 40", ends, 40, [wheel], hinges="ideal")
    start = rc.Simulation(drive)
    place = {"positions": start.positions, "velocities": start.velocities}
    found = []
    for solver in (rc.Solver("newton", accuracy=1e-11), rc.Solver("pece", accuracy=1e-12)):
        simulation = rc.Simulation(drive, solver=solver, **place)
        energy = simulation.run(3e-3, 1e-3, record=GROUPS, progress=False).energy
        assert np.abs(energy.residual).max() < 1e-4 * energy.kinetic.max()
        found.append(simulation.positions.copy())
    assert np.abs(found[0] - place["positions"]).max() > 1e-5
    np.testing.assert_allclose(found[0], found[1], atol=1e-8)


def hoist(hinges="ideal", load=10.0, **keywords):
    """A load on a wheel, against the weight of a loop."""
    motor = rc.PrescribedSpeed([(0.0, 0.0), (0.05, 8.0)])
    ends = (rc.AnchoredEnd((-0.16, -0.02), links=50), rc.LoadedEnd(load, arm=0.08))
    wheel = rc.Sprocket(17, motion=motor)
    return rc.open_chain("ANSI 40", ends, 90, [wheel], hinges=hinges, **keywords)


@pytest.fixture(scope="module")
def lifted():
    runs = []
    for hinges in ("clearance", "ideal"):
        simulation = rc.Simulation(hoist(hinges), start="static")
        runs.append(simulation.run(0.06, 1e-4, record=GROUPS, progress=False))
    return runs


def test_a_hoist_lifts_its_load_as_with_clearance(lifted):
    clearance, ideal = lifted
    assert ideal.end(2).force[0, 1] == pytest.approx(10.0 * GRAVITY, rel=1e-6)
    rises = [np.ptp(run.end(2).position[:, 1]) for run in lifted]
    radius = 0.5 * 0.0127 / np.sin(np.pi / 17)
    assert rises[1] == pytest.approx(radius * 8.0 * (0.025 + 0.01), rel=0.02)
    assert rises[1] == pytest.approx(rises[0], abs=1e-4)
    tensions = [run.end(2).force[:, 1].mean() for run in lifted]
    assert tensions[1] == pytest.approx(tensions[0], rel=0.02)
    torques = [run.sprocket(1).torque.mean() for run in lifted]
    assert torques[1] == pytest.approx(torques[0], rel=0.05)
    assert ideal.array("hinge_eccentricity").max() < 1e-9
    work = np.abs(ideal.energy.external_work).max()
    assert np.abs(ideal.energy.residual).max() < 1e-4 * work
    # A third of the steps, with two corrections each.
    assert 3 * ideal.stats["steps"] < clearance.stats["steps"]


def test_the_forces_of_a_hoist_move_its_links_and_its_load():
    """Newton's second law, link by link; the bodies of both ends follow the links."""
    simulation = rc.Simulation(hoist(), start="static")
    simulation.step_to(0.02)
    found, chain = simulation.evaluate(), simulation.drive.chain
    on_bushing = found.tooth_force_vector.sum(axis=1) - found.hinge_force_vector
    for link in range(chain.links):
        inner = link % 2 == 0
        of = on_bushing if inner else found.hinge_force_vector
        mass = (chain.inner if inner else chain.outer).mass
        force = of[link] + of[link - 1] + mass * np.array([0.0, -GRAVITY])
        np.testing.assert_allclose(mass * found.accelerations[link, :2], force, atol=1e-8)
    pull = 10.0 * (found.accelerations[90, :2] + np.array([0.0, GRAVITY]))
    size = np.linalg.norm(found.hinge_force_vector[89])
    assert size == pytest.approx(np.linalg.norm(pull), rel=1e-9)
    assert not found.accelerations[91].any()


@pytest.mark.parametrize("rollers", ["fixed", "bodies"])
@pytest.mark.parametrize("method", ["auto", "pece"])
def test_a_state_of_a_hoist_goes_on_to_the_same_bits(method, rollers, tmp_path):
    solver = rc.Solver(method=method)
    straight = rc.Simulation(hoist(rollers=rollers), start="static", solver=solver)
    straight.step_to(1e-3)
    straight.save_state(tmp_path / "state.npz")
    resumed = rc.Simulation.load_state(tmp_path / "state.npz")
    for simulation in (straight, resumed):
        simulation.step_to(2e-3)
    np.testing.assert_array_equal(resumed.positions, straight.positions)
    np.testing.assert_array_equal(resumed.velocities, straight.velocities)


@pytest.mark.filterwarnings("ignore:min_impact_velocity")
def test_the_balance_of_a_fast_heavy_load_closes():
    """By a second correction in each step: without it 17 mJ are off, and 0.4 mJ with it."""
    ends = (rc.LoadedEnd(3.0), rc.FreeEnd(links=17))
    wheel = rc.Sprocket(14, motion=rc.PrescribedSpeed(98.0))
    drive = rc.open_chain("ANSI 60", ends, 52, [wheel], hinges="ideal")
    simulation = rc.Simulation(drive, min_impact_velocity=1e-5)
    energy = simulation.run(6.4e-3, 1e-4, record=GROUPS, progress=False).energy
    assert energy.kinetic[0] > 30.0
    assert np.abs(energy.residual).max() < 2e-3
    assert np.abs(energy.external_work).max() > 0.1


@pytest.mark.parametrize("stiffness", [0.0, 2e4])
def test_a_tensioner_between_anchors_gives_the_tension_asked_for(stiffness):
    tensioner = rc.Tensioner(80.0, sprocket=2, stiffness=stiffness, ramp_time=0.0)
    drive = rc.open_chain(
        "ANSI 40",
        (rc.AnchoredEnd((-0.2, -0.15)), rc.AnchoredEnd((0.6, -0.15))),
        86,
        [rc.Sprocket(17), rc.Sprocket(17, (0.3, 0.0))],
        gravity=(0.0, 0.0),
        tensioner=tensioner,
        hinges="ideal",
    )
    result = rc.Simulation(drive, start="static").run(2e-3, 1e-4, record=GROUPS, progress=False)
    np.testing.assert_allclose(result.array("strand_tension"), 80.0, atol=1.0)


@pytest.mark.parametrize("start", ["generated", "static"])
def test_a_chain_between_two_anchors_rests_on_its_polygon(start):
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((0.3, 0.05)))
    drive = rc.open_chain("ANSI 40", ends, 40, hinges="ideal")
    simulation = rc.Simulation(drive, start=start)
    before = simulation.positions.copy()
    result = simulation.run(0.02, 1e-3, record=GROUPS, progress=False)
    np.testing.assert_allclose(simulation.positions, before, atol=1e-12)
    masses = [drive.chain.inner.mass, drive.chain.outer.mass]
    on_ends = result.end(1).force + result.end(2).force
    np.testing.assert_allclose(on_ends[:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(on_ends[:, 1], -20.0 * sum(masses) * GRAVITY, rtol=1e-9)


def test_an_open_chain_is_no_mechanism():
    with pytest.raises(rc.InvalidInput, match=r"open chain cannot be a mechanism; run the drive"):
        hoist().to_mechanism()
    stiff = replace(hoist().chain, link_stiffness=1e8)
    with pytest.raises(rc.InvalidInput, match=r"Chain\.link_stiffness.*ideal hinges"):
        replace(hoist(), chain=stiff)
