"""Forces, accelerations and the first milliseconds of a path, against the NumPy reference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import DriveEquations
from reference.path import follow

SEATS = ("pitch-circle", "bottom-diameter")
LN = rc.LankaraniNikravesh()
LAWS = {
    "lankarani-nikravesh": (LN, LN),
    "hertz": (rc.Hertz(), rc.Hertz()),
    "johnson": (rc.Johnson(), rc.Johnson()),
    "johnson damped": (rc.Johnson(damping="lankarani-nikravesh"),) * 2,
    "enhanced": (rc.EnhancedCylinder(), rc.EnhancedCylinder()),
    "enhanced undamped": (rc.EnhancedCylinder(damping=None),) * 2,
    "sharp": (rc.LankaraniNikravesh(regions="sharp"),) * 2,
    "johnson hinges, enhanced teeth": (rc.Johnson(), rc.EnhancedCylinder()),
    "enhanced hinges, hertz teeth": (rc.EnhancedCylinder(), LN),
    "liu in hinges, hertz cylinders on teeth": (
        rc.LiuConformal(damping="flores"),
        rc.HertzCylinder(damping="gonthier"),
    ),
    "radzimovsky in hinges, liu on teeth": (
        rc.Radzimovsky(damping="zhiying-qishao"),
        rc.LiuConformal(damping="hu-guo", regions="sharp"),
    ),
    "esdu": (rc.Esdu78035(damping="herbert-mcwhannell"),) * 2,
}
TIME = 0.04  # [s], while the tensioner's pull still grows


@pytest.mark.filterwarnings("ignore::rustchain.RangeWarning")
@pytest.mark.parametrize("laws", LAWS)
@pytest.mark.parametrize("seat", SEATS)
def test_forces_and_accelerations_agree_to_round_off(laws, seat, paper_with_seat, states_with_seat):
    hinge_law, tooth_law = LAWS[laws]
    drive = paper_with_seat(seat)
    simulation = rc.Simulation(drive, hinge_law=hinge_law, tooth_law=tooth_law)
    equations = DriveEquations(drive, hinge_law, tooth_law)
    pushed_on_teeth = pushed_in_hinges = 0
    for positions, velocities in states_with_seat(seat):
        expected = equations.evaluate(positions, velocities, TIME)
        e = simulation.evaluate(positions=positions, velocities=velocities, time=TIME)
        assert_within(e.hinge_force, expected.hinge_force, expected.hinge_force_bound, "hinges")
        assert_within(e.tooth_force, expected.tooth_force, expected.tooth_force_bound, "teeth")
        assert_within(
            e.hinge_force_vector,
            expected.hinge_force_vector,
            expected.hinge_force_bound[:, None],
            "force on the pins",
        )
        assert_within(
            e.tooth_force_vector,
            expected.tooth_force_vector,
            expected.tooth_force_bound[:, :, None],
            "force on the bushings",
        )
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        pushed_on_teeth += int(np.sum(expected.tooth_force > 0.0))
        pushed_in_hinges += int(np.sum(expected.hinge_force > 0.0))
    assert pushed_on_teeth > 300
    assert pushed_in_hinges > 300


def test_a_higher_floor_of_the_approach_speed_softens_the_damping(paper, states_with_seat):
    for floor in (1e-4, 1e-1):
        simulation = rc.Simulation(paper, min_impact_velocity=floor)
        equations = DriveEquations(paper, LN, LN, min_impact_velocity=floor)
        for positions, velocities in states_with_seat("pitch-circle")[::10]:
            expected = equations.evaluate(positions, velocities)
            e = simulation.evaluate(positions=positions, velocities=velocities, time=0.0)
            assert_within(e.hinge_force, expected.hinge_force, expected.hinge_force_bound, "hinges")
            assert_within(e.tooth_force, expected.tooth_force, expected.tooth_force_bound, "teeth")


def test_without_contact_only_gravity_and_what_is_applied_act(paper):
    simulation = rc.Simulation(paper)
    start, rates = simulation.positions, simulation.velocities
    for time, pull in ((0.0, 0.0), (0.025, 12.5), (0.1, 50.0), (3.0, 50.0)):  # 2 T over 0.1 s
        rates = rates.copy()
        rates[39, 0] = 1e-3  # the slide's damping takes 2000 N s/m off the pull
        a = simulation.evaluate(positions=start, velocities=rates, time=time).accelerations
        assert np.all(a[:38] == [0.0, -9.81, 0.0])
        assert np.all(a[38] == 0.0)
        assert_allclose(a[39], [(pull - 2.0) / 0.817, 0.0, 0.0], rtol=1e-12)


def test_tables_of_speed_and_torque_are_followed(paper):
    speed = ((0.0, 0.0), (0.1, 20.0), (0.3, -10.0))
    torque = ((0.1, 0.0), (0.2, 4.0))
    driver = replace(paper.sprockets[0], motion=rc.PrescribedSpeed(speed))
    driven = replace(
        paper.sprockets[1],
        motion=rc.AppliedTorque(torque),
        mass=None,
        inertia=None,
        bearing="floating",
    )
    drive = replace(paper, sprockets=[driver, driven], tensioner=None)
    start = rc.Simulation(paper)
    simulation = rc.Simulation(drive)
    equations = DriveEquations(drive, LN, LN)
    # A steel disc: 7850 pi 0.034557914^2 0.007 = 0.20616 kg; m r^2 / 2 = 1.2310e-4 kg m^2.
    assert_allclose(equations.mass[39], 0.20616, rtol=1e-4)
    assert_allclose(equations.inertia[39], 1.2310e-4, rtol=1e-4)
    for time, driver_rate, applied in (
        (0.05, 200.0, 0.0),
        (0.15, -150.0, 2.0),
        (0.25, -150.0, 4.0),
        (0.5, 0.0, 4.0),
    ):
        e = simulation.evaluate(positions=start.positions, velocities=start.velocities, time=time)
        expected = equations.evaluate(start.positions, start.velocities, time).accelerations
        assert_allclose(e.accelerations[38], [0.0, 0.0, driver_rate], rtol=1e-12)
        assert_allclose(e.accelerations[39], expected[39], rtol=1e-12)
        assert_allclose(expected[39], [0.0, -9.81, applied / equations.inertia[39]], rtol=1e-12)


def test_evaluate_leaves_the_simulation_as_it_was(paper, states_with_seat):
    simulation, untouched = rc.Simulation(paper), rc.Simulation(paper)
    for drive in (simulation, untouched):
        drive.step_to(4.5e-3)
    positions, velocities = states_with_seat("pitch-circle")[0]
    simulation.evaluate(positions=positions, velocities=velocities, time=1.0)
    for drive in (simulation, untouched):
        drive.step_to(4.8e-3)
    assert simulation.time == untouched.time
    assert np.array_equal(simulation.positions, untouched.positions)
    assert np.array_equal(simulation.velocities, untouched.velocities)


@pytest.fixture(scope="module")
def paper_without_tension():
    return rc.paper_drive(pretension=0.0)


def link_positions_at(drive, time, tolerance, max_step):
    solver = rc.Solver(rtol=tolerance, atol=tolerance, max_step=max_step)
    simulation = rc.Simulation(drive, solver=solver)
    simulation.step_to(time)
    assert simulation.time == time
    return simulation.positions[:, :2]


def test_the_path_to_6_ms_converges_with_the_tolerance(paper_without_tension):
    finest = link_positions_at(paper_without_tension, 6e-3, 1e-12, 2e-5)
    for tolerance, agreed in ((1e-9, 1e-8), (1e-10, 1e-8), (1e-11, 1e-9), (1e-12, 1e-9)):
        for max_step in (1e-4, 2e-5):
            positions = link_positions_at(paper_without_tension, 6e-3, tolerance, max_step)
            off = np.max(np.abs(positions - finest))
            assert off <= agreed, f"{off:.2g} m at {tolerance:g}, largest step {max_step:g} s"


@pytest.mark.parametrize(
    "laws",
    [
        "lankarani-nikravesh",
        pytest.param("johnson hinges, enhanced teeth", marks=pytest.mark.slow),
    ],
)
def test_the_path_past_the_first_contacts_is_the_references(laws, paper_without_tension):
    # DOP853 stopped at every onset, each contact with its own memory.
    end = 4.6e-3
    hinge_law, tooth_law = LAWS[laws]
    solver = rc.Solver(rtol=1e-12, atol=1e-12, max_step=1e-4)
    simulation = rc.Simulation(
        paper_without_tension, hinge_law=hinge_law, tooth_law=tooth_law, solver=solver
    )
    equations = DriveEquations(paper_without_tension, hinge_law, tooth_law)
    path = follow(equations, simulation.positions, simulation.velocities, end)
    assert path.tooth_onsets[0][0] == pytest.approx(4.09e-3, abs=5e-6)
    if tooth_law.elastic == "hertz":  # the first hinge answers to the first tooth
        assert path.hinge_onsets[0][0] == pytest.approx(4.32e-3, abs=5e-6)
    assert len(path.tooth_onsets) >= 5
    assert len(path.hinge_onsets) >= 5
    simulation.step_to(end)
    assert_same_path(simulation, path)


@pytest.mark.slow
def test_a_contact_that_slides_into_another_region_keeps_its_stiffness_or_not(
    paper_without_tension,
):
    # Seven links thrown about, so that a bushing slides into the next region under load.
    start = rc.Simulation(paper_without_tension)
    positions, velocities = start.positions, start.velocities.copy()
    velocities[19:26, :2] += np.random.default_rng(99).uniform(-0.8, 0.8, (38, 2))[19:26]
    ends = {}
    for regions in ("kept", "sharp"):
        law = rc.LankaraniNikravesh(regions=regions)
        simulation = rc.Simulation(
            paper_without_tension,
            force_law=law,
            positions=positions,
            velocities=velocities,
            solver=rc.Solver(rtol=1e-12, atol=1e-12),
        )
        equations = DriveEquations(paper_without_tension, law, law)
        path = follow(equations, positions, velocities, 1.4e-4)
        simulation.step_to(1.4e-4)
        assert_same_path(simulation, path)
        ends[regions] = path.positions
    assert np.max(np.abs(ends["kept"] - ends["sharp"])[:, :2]) > 1e-7


def assert_same_path(simulation, path):
    off = np.abs(simulation.positions - path.positions)
    rates_off = np.abs(simulation.velocities - path.velocities)
    assert np.max(off[:, :2]) <= 1e-12  # [m]
    assert np.max(off[:, 2]) <= 1e-9  # [rad]
    assert np.max(rates_off[:, :2]) <= 1e-7  # [m/s]; 2.4e-8 where a surface is left under load
    assert np.max(rates_off[:, 2]) <= 1e-5  # [rad/s]


def test_first_contacts_come_at_4_09_and_4_32_ms(paper_without_tension):
    solver = rc.Solver(rtol=1e-10, atol=1e-10)
    result = rc.Simulation(paper_without_tension, solver=solver).run(
        duration=4.5e-3, report_step=5e-6, progress=False
    )
    touched = np.any(result.arrays["tooth_force"] > 0.0, axis=1)
    pinned = np.any(result.arrays["hinge_force"] > 0.0, axis=1)
    assert result.time[np.argmax(touched)] == pytest.approx(4.09e-3, abs=1e-5)
    assert result.time[np.argmax(pinned)] == pytest.approx(4.32e-3, abs=1e-5)
