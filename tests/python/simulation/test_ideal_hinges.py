"""Drives with ideal hinges: channels, plots, states and files of a drive; forces move the links."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc

GROUPS = ("hinges", "teeth", "sprockets", "bodies", "energy")
DRIVE = rc.paper_drive(pretension=100.0, hinges="ideal")
SOLVER = rc.Solver(accuracy=1e-9)


def run(drive, duration=5e-3, **keywords):
    simulation = rc.Simulation(drive, solver=SOLVER)
    return simulation.run(
        duration=duration, report_step=1e-4, record=GROUPS, progress=False, **keywords
    )


@pytest.fixture(scope="module")
def result():
    return run(DRIVE)


def test_the_channels_are_those_of_a_drive_with_clearance(result):
    other = run(rc.paper_drive(pretension=100.0), duration=1e-3)
    # Ideal hinges have no contact.
    places = {"energy_hinge_contact", "energy_hinge_friction", "hinge_onset_speed"}
    assert set(result.arrays) == set(other.arrays) - places
    with pytest.raises(rc.NotRecorded, match="this scene has no such channel"):
        result.array("hinge_onset_speed")
    for name, values in result.arrays.items():
        assert values.dtype == other.arrays[name].dtype, name
        assert values.shape[1:] == other.arrays[name].shape[1:], name
    evaluations = [rc.Simulation(d).evaluate() for d in (DRIVE, rc.paper_drive(pretension=100.0))]
    ideal, clearance = map(vars, evaluations)
    assert ideal.keys() == clearance.keys()
    for name, values in clearance.items():
        assert (ideal[name].shape, ideal[name].dtype) == (values.shape, values.dtype), name


def test_hinge_and_tooth_forces_move_the_links():
    """Newton's second law, link by link, from the forces as they are handed out."""
    simulation = rc.Simulation(DRIVE, solver=SOLVER)
    chain, t = DRIVE.chain, 4e-3
    while (found := simulation.evaluate()).tooth_force.max() < 1.0:
        assert t < 0.02
        t += 2e-5
        simulation.step_to(t)
    on_bushing = found.tooth_force_vector.sum(axis=1) - found.hinge_force_vector
    assert found.hinge_force.max() > 1.0
    for link in range(chain.links):
        inner = link % 2 == 0
        of = on_bushing if inner else found.hinge_force_vector
        mass = (chain.inner if inner else chain.outer).mass
        force = of[link] + of[link - 1] + mass * np.array(DRIVE.gravity)
        # Forces of about 100 N, from a linear system of condition 1e3.
        np.testing.assert_allclose(mass * found.accelerations[link, :2], force, atol=1e-9)


def test_pins_stay_in_the_middle_of_their_bushings(result):
    """Within the accuracy: they are projected after every fourth step."""
    for number in (1, 6, 38):
        hinge = result.hinge(number)
        assert np.all(hinge.penetration >= 0.0)
        assert hinge.penetration.max() < SOLVER.accuracy
        sizes = np.hypot(*hinge.eccentricity.T)
        np.testing.assert_allclose(hinge.penetration, sizes, rtol=1e-9, atol=0.0)
        x, y = hinge.force_vector.T
        np.testing.assert_array_equal(hinge.force, np.sqrt(x * x + y * y))


@pytest.mark.parametrize("solver", [rc.Solver(), dataclasses.replace(SOLVER, method="pece")])
def test_the_balance_closes(solver):
    energy = rc.Simulation(DRIVE, solver=solver).run(5e-3, progress=False).energy
    assert np.abs(energy.residual).max() < 0.02 * energy.dissipated[-1]


def test_the_driver_turns_as_told(result):
    np.testing.assert_allclose(result.sprocket(1).speed, 4 * np.pi, rtol=1e-13)
    assert np.abs(result.sprocket(1).torque).max() > 1e-3
    assert np.all(result.sprocket(2).torque == 0.0)


def test_tension_is_the_pull_of_the_hinges_between_the_sprockets(result):
    """Of the upper strand: hinges above the line of centres, farther in than the tangents' ends."""
    row, links = -1, DRIVE.chain.links
    positions = result.arrays["positions"][row]
    left, right = positions[links:, :2]
    pulls = {"upper": [], "lower": []}
    for k in range(links):
        here, after = positions[k], positions[(k + 1) % links]
        place = here[:2] + 0.5 * DRIVE.chain.pitch * np.array([np.cos(here[2]), np.sin(here[2])])
        if left[0] <= place[0] <= right[0]:  # equal sprockets
            way = (after - here)[:2] / np.hypot(*(after - here)[:2])
            on_front = result.hinge(k + 1).force_vector[row] * (-1.0 if k % 2 == 0 else 1.0)
            pulls["upper" if place[1] > 0.0 else "lower"].append(on_front @ way)
    for name, pull in pulls.items():
        assert len(pull) >= 9
        assert abs(result.strand(name).tension[row] - np.mean(pull)) < 1e-10


def test_peaks_bound_the_forces_at_the_reports(result):
    forces = result.arrays["hinge_force"]
    assert np.all(result.peaks.hinge_force[1:] >= forces[1:])
    assert np.any(result.peaks.hinge_force[1:] > 1.5 * np.maximum(forces[1:], forces[:-1]))
    assert np.all(result.peaks.tooth_impulse >= 0.0)
    assert result.peaks.tooth_impulse.max() > 0.0


def test_every_figure_can_be_drawn(result):
    plot = result.plot
    figures = [
        plot.hinge_force(6),
        plot.tooth_force(6),
        plot.force_penetration(6),
        plot.tension(),
        plot.energy(),
        plot.drive(time=2e-3),
    ]
    assert all(figure.axes for figure in figures)


def test_joint_loads_are_those_of_the_joints_by_their_names(result):
    plot = result.plot
    upper, lower = plot.joint_loads("hinge_6", ["hinge_11", "motor_1"]).axes
    np.testing.assert_array_equal(upper.lines[1].get_ydata(), result.hinge(11).force)
    np.testing.assert_array_equal(lower.lines[0].get_ydata(), result.sprocket(1).torque)
    largest, mean = plot.joint_loads(start=1e-3).axes[0].lines
    assert np.all(largest.get_ydata() >= mean.get_ydata())
    assert largest.get_ydata().max() == result.array("hinge_force")[10:].max()
    assert len(plot.joint_loads("motor_1").axes) == 1
    with pytest.raises(rc.InvalidInput, match=r"joint: 'hinge_39' is no joint .* did you mean"):
        plot.joint_loads("hinge_39")
    clearance = rc.Simulation(rc.paper_drive()).run(2e-4, progress=False)
    with pytest.raises(rc.InvalidInput, match=r"hinges = 'clearance': .* hinge_force .* draw them"):
        clearance.plot.joint_loads()


def test_a_state_of_another_scene_is_refused():
    state = rc.Simulation(DRIVE, solver=SOLVER).state()
    other = rc.Simulation(rc.paper_drive(pretension=50.0, hinges="ideal"), solver=SOLVER)
    with pytest.raises(rc.InvalidInput, match="some number of drive, start or laws differs"):
        other.set_state(state)
    with pytest.raises(rc.InvalidInput, match=r"state, Solver\.accuracy = "):
        rc.Simulation(DRIVE, solver=rc.Solver(accuracy=1e-8)).set_state(state)
    damaged = state | {"snapshot": state["snapshot"][:-9] + b"x" + state["snapshot"][-8:]}
    with pytest.raises(rc.InvalidInput, match="damaged"):
        rc.Simulation(DRIVE, solver=SOLVER).set_state(damaged)


def test_a_state_evaluated_elsewhere_leaves_the_run_alone():
    simulation = rc.Simulation(DRIVE, solver=SOLVER)
    simulation.step_to(2e-3)
    before = simulation.evaluate()
    again = simulation.evaluate(velocities=simulation.velocities, time=2e-3)
    np.testing.assert_array_equal(again.hinge_force, before.hinge_force)
    still = simulation.evaluate(velocities=np.zeros_like(simulation.velocities))
    assert np.abs(still.hinge_force - before.hinge_force).max() > 1e-3
    np.testing.assert_array_equal(simulation.evaluate().hinge_force, before.hinge_force)
    with pytest.raises(rc.InvalidInput, match="needs one row"):
        simulation.evaluate(positions=np.zeros((3, 3)))


def test_a_drive_says_itself_which_hinges_it_has():
    assert len(DRIVE.to_mechanism().joints) > 38
    assert len(rc.paper_drive().to_mechanism().joints) < 10
    drive = rc.two_sprocket_drive(links=60, hinges="ideal")
    assert rc.Simulation(drive).evaluate().hinge_force.shape == (60,)
    with pytest.raises(rc.InvalidInput, match=r"hinges.*'rigid'.*clearance.*ideal"):
        dataclasses.replace(DRIVE, hinges="rigid")


def test_ideal_hinges_that_the_polygon_effect_leaves_too_short_are_told():
    """17:17, 38 links, seats without room: the largest hinge force grows to kilonewtons."""

    def warnings_of(**keywords):
        given = {"links": 38, "hinges": "ideal"} | keywords
        drive = rc.two_sprocket_drive("ANSI 40", (17, 17), **given)
        return [text for text in drive.check().warnings if "too short for these centres" in text]

    (text,) = warnings_of()
    shortage, tension = (float(text.split(unit)[0].split()[-1]) for unit in (" um", " N,"))
    # By the polygons of both sprockets, over a pitch of turning.
    assert shortage == pytest.approx(51.8, abs=0.5)
    assert 5e3 < tension < 5e4
    for remedy in ({"hinges": "clearance"}, {"pretension": 50.0}, {"seat": "pitch-circle"}):
        assert warnings_of(**remedy) == []
    distance = rc.two_sprocket_drive("ANSI 40", (17, 17), links=38).sprockets[1].center[0]
    # Both strands share what a centre is moved in by.
    assert len(warnings_of(center_distance=distance - 20e-6)) == 1
    assert warnings_of(center_distance=distance - 27e-6) == []
    assert rc.paper_drive(hinges="ideal").check().warnings == ()


def test_a_sweep_of_ideal_hinges_has_the_numbers_of_single_runs():
    def ends(result):
        return result.final_positions

    swept = rc.sweep(DRIVE, {"accuracy": [1e-8]}, ends, duration=1e-3, progress=False)
    alone = rc.Simulation(DRIVE, solver=dataclasses.replace(rc.Scene(DRIVE).solver, accuracy=1e-8))
    np.testing.assert_array_equal(swept.values[0], ends(alone.run(1e-3, progress=False)))


@pytest.mark.parametrize("pivot", [None, (0.05, 0.05)])
def test_a_tensioner_force_that_is_set_is_that_of_a_tensioner_described_with_it(pivot, tmp_path):
    tensioner = rc.Tensioner(25.0, ramp_time=0.1, pivot=pivot)
    drive = dataclasses.replace(DRIVE, tensioner=tensioner)
    at_once = dataclasses.replace(tensioner, ramp_time=0.0)
    described = rc.Simulation(dataclasses.replace(drive, tensioner=at_once), solver=SOLVER)
    told = rc.Simulation(drive, solver=SOLVER)
    force = drive.check().tension_force
    told.set_tensioner_force(force)
    for simulation in (described, told):
        simulation.step_to(2e-3)
    np.testing.assert_allclose(told.positions, described.positions, rtol=0, atol=1e-12)
    told.set_tensioner_force(3.0 * force)
    # The force acts on the sprocket alone at once.
    shift = told.evaluate().accelerations - described.evaluate().accelerations
    assert np.abs(shift[-1, :2]).max() > 10.0
    told.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    for simulation in (told, again):
        simulation.step_to(3e-3)
    np.testing.assert_array_equal(again.positions, told.positions)
    for wrong, message in (
        (-1.0, "must be zero or a positive"),
        ([(0.0, 1.0), (1.0, 2.0)], "must be a number in N"),
    ):
        with pytest.raises(rc.InvalidInput, match=message):
            told.set_tensioner_force(wrong)


@pytest.mark.parametrize("friction", [None, rc.Coulomb(0.1)])
def test_accelerations_and_hinge_forces_are_those_of_the_mechanism(friction):
    """Two ways to the same solution: the chain's ring of blocks, and sparse blocks of joints."""
    law = rc.LankaraniNikravesh(friction=friction)
    simulation = rc.Simulation(DRIVE, tooth_law=law, solver=SOLVER, start="static")
    simulation.step_to(1e-3)
    tensioner = replace(DRIVE.tensioner, ramp_time=0.0)  # a static start has its whole force
    system = replace(DRIVE, tensioner=tensioner).to_mechanism(force_law=law)
    mechanism = rc.Simulation(system, solver=SOLVER)
    place = simulation.positions, simulation.velocities
    found, other = simulation.evaluate(*place), mechanism.evaluate(*place)
    assert found.tooth_force.max() > 1.0
    hinges = slice(first := mechanism.joint_names.index("hinge_1"), first + DRIVE.chain.links)
    force = other.joint_reaction[hinges, :2]
    # Penetrations of 1e-7 m are rounded to 1e-16 m.
    largest = np.abs(other.accelerations).max()
    np.testing.assert_allclose(found.accelerations, other.accelerations, atol=1e-7 * largest)
    np.testing.assert_allclose(found.hinge_force_vector, force, atol=1e-8 * np.abs(force).max())


@pytest.mark.parametrize("method", ["auto", "pece"])
def test_a_drive_moves_as_its_mechanism(method):
    solver = rc.Solver(accuracy=1e-11, method=method)
    simulation = rc.Simulation(DRIVE, solver=solver, start="static")
    place = {"positions": simulation.positions, "velocities": simulation.velocities}
    tensioner = replace(DRIVE.tensioner, ramp_time=0.0)  # a static start has its whole force
    system = replace(DRIVE, tensioner=tensioner).to_mechanism()
    mechanism = rc.Simulation(system, solver=rc.Solver(accuracy=1e-12), **place)
    for each in (simulation, mechanism):
        each.step_to(1e-3)
    assert np.abs(simulation.positions - place["positions"]).max() > 1e-4
    np.testing.assert_allclose(simulation.positions, mechanism.positions, atol=1e-7)


def test_guides_and_eccentric_teeth_run_with_ideal_hinges():
    """They have about the tensions that they have with clearance, and the balance closes."""
    made = rc.two_sprocket_drive("ANSI 40", (17, 17), links=60, speed=20.0, pretension=60.0)
    half = 0.5 * made.sprockets[1].center[0]
    radius = 0.5 * 12.7e-3 / np.sin(np.pi / 17)
    rail = rc.GuideRail((half, radius + 10e-3), (0.0, -1.0), 0.5 * half)
    sprockets = [replace(made.sprockets[0], eccentricity=2e-5), made.sprockets[1]]
    for change in ({"guides": [rail]}, {"sprockets": sprockets}):
        tension = []
        for hinges in ("clearance", "ideal"):
            drive = replace(made, hinges=hinges, **change)
            result = rc.Simulation(drive, start="static").run(0.02, progress=False)
            energy = result.energy
            assert np.abs(energy.residual).max() < 0.02 * energy.dissipated[-1]
            tension.append(result.array("strand_tension").mean())
        assert tension[0] > 20.0
        assert tension[1] == pytest.approx(tension[0], rel=0.3)


def test_what_ideal_hinges_cannot_have_is_refused_by_name():
    stiff = replace(DRIVE.chain, link_stiffness=1e8)
    with pytest.raises(rc.InvalidInput, match=r"Chain\.link_stiffness.*ideal hinges"):
        rc.Simulation(replace(DRIVE, chain=stiff))


@pytest.mark.parametrize("method", ["auto", "pece"])
@pytest.mark.parametrize(
    "set_one",
    [
        lambda simulation: simulation.set_speed("sprocket_1", 13.0),
        lambda simulation: simulation.set_torque("sprocket_2", -0.5),
        lambda simulation: simulation.set_tensioner_force(150.0),
    ],
)
def test_an_input_has_the_same_bits_after_a_state(set_one, method, tmp_path):
    """A restored simulation has no slopes of an earlier step."""
    made = rc.Simulation(DRIVE, start="static", solver=rc.Solver(method=method))
    made.step_to(1.0003e-3)
    made.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    for simulation in (made, again):
        set_one(simulation)
        simulation.step_to(1.3e-3)
    np.testing.assert_array_equal(again.positions, made.positions)
    np.testing.assert_array_equal(again.velocities, made.velocities)


def test_velocities_that_would_open_hinges_are_told():
    simulation = rc.Simulation(DRIVE)
    positions, velocities = simulation.positions, simulation.velocities.copy()
    rc.Simulation(DRIVE, positions=positions, velocities=velocities)
    velocities[6, 0] += 1.0
    with pytest.warns(UserWarning, match=r"velocities: those of links had to be changed by up to"):
        rc.Simulation(DRIVE, positions=positions, velocities=velocities)
