"""Ideal hinges round any number of sprockets, with tensioners, beside hinges with clearance."""

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from rustchain import _rustchain

SOLVER = rc.Solver(accuracy=3e-10)
GROUPS = ("hinges", "teeth", "sprockets", "bodies", "energy")


def three_sprockets(**keywords):
    """A driver, a loaded sprocket and a reverse idler between them."""
    return rc.chain_drive(
        "ANSI 40",
        [
            rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(12.566)),
            rc.Sprocket(25, (0.35, -0.05), rc.AppliedTorque(-2.0)),
            rc.Sprocket(13, (0.18, -0.005), side="outside"),
        ],
        **keywords,
    )


TENSIONERS = {
    "slide": rc.Tensioner(30.0, sprocket=3, ramp_time=0.02, damping=300.0),
    "direction": rc.Tensioner(30.0, sprocket=2, direction=(1.0, -0.4), ramp_time=0.0),
    "spring": rc.Tensioner(30.0, sprocket=3, stiffness=2e4, damping=0.0, ramp_time=0.01),
    "stops": rc.Tensioner(30.0, sprocket=3, stiffness=2e4, travel=(1e-3, 2e-3)),
    "arm": rc.Tensioner(30.0, sprocket=3, pivot=(0.25, 0.03), arm_inertia=2e-4, ramp_time=0.0),
    "bare arm": rc.Tensioner(
        30.0, sprocket=3, pivot=(0.1, 0.03), stiffness=3e3, travel=(1e-3, 1.0)
    ),
}


@pytest.fixture(scope="module")
def pair():
    runs = []
    for hinges in ("clearance", "ideal"):
        drive = three_sprockets(hinges=hinges)
        simulation = rc.Simulation(drive, solver=SOLVER)
        runs.append(simulation.run(0.03, report_step=1e-4, record=GROUPS, progress=False))
    return runs


def test_strands_bear_what_they_bear_with_clearance(pair):
    """Means of 30 ms; 8.3, 41.5, 44.5 N with clearance, 8.7, 42.0, 44.9 N with ideal hinges."""
    clearance, ideal = (run.arrays["strand_tension"].mean(axis=0) for run in pair)
    assert pair[1].strand_names == ("1-2", "2-3", "3-1")
    assert clearance[1] > 30.0
    np.testing.assert_allclose(ideal, clearance, atol=5.0)


def test_the_balance_closes_and_pins_stay_in_the_middle(pair):
    result = pair[1]
    energy = result.energy
    exchanged = np.ptp(energy.kinetic) + energy.elastic.max() + np.abs(energy.external_work).max()
    assert np.abs(energy.residual).max() < 0.02 * exchanged
    assert result.arrays["hinge_penetration"].max() < SOLVER.accuracy
    np.testing.assert_allclose(result.sprocket(1).speed, 12.566, rtol=1e-12)
    np.testing.assert_allclose(result.sprocket(2).torque, -2.0)


def test_the_channels_are_those_of_a_drive_with_clearance(pair):
    clearance, ideal = pair
    places = {"energy_hinge_contact", "energy_hinge_friction", "hinge_onset_speed"}
    assert set(ideal.arrays) == set(clearance.arrays) - places
    for name, values in ideal.arrays.items():
        assert values.shape == clearance.arrays[name].shape, name


def test_a_tooth_pushes_bushings_outwards_with_its_force(pair):
    for run in pair:
        force, vector = run.array("tooth_force"), run.array("tooth_force_vector")
        np.testing.assert_allclose(np.hypot(*np.moveaxis(vector, -1, 0)), force, rtol=1e-9)
        sprocket, positions = run.array("tooth_sprocket"), run.array("positions")
        assert (sprocket > 0).any()
        links = run.drive.chain.links
        seat = positions[np.arange(len(sprocket))[:, None], links + np.maximum(sprocket, 1) - 1, :2]
        rear = positions[:, :links, :2]  # half a pitch off, which leaves the sign
        out = ((rear - seat) * vector).sum(-1)[sprocket > 0]
        assert np.mean(out) > 0.0


def far_from_the_chain(drive, way):
    """Positions and velocities with the links out of reach and the tensioner's sprocket moved."""
    simulation = rc.Simulation(replace(drive, hinges="clearance"))
    positions, velocities = simulation.positions.copy(), simulation.velocities.copy()
    links, tensioner = drive.chain.links, drive.tensioner
    positions[:links, 1] += 10.0
    row = links + tensioner.sprocket - 1
    center = np.array(drive.sprockets[tensioner.sprocket - 1].center)
    if tensioner.pivot is None:
        direction = tensioner.direction or _rustchain.bisector(drive, tensioner.sprocket)
        along = np.array(direction) / np.hypot(*direction)
        positions[row, :2] = center + way * along
        velocities[row, :2] = 0.2 * along
    else:
        pivot = np.array(tensioner.pivot)
        arm = center - pivot
        radius, angle = np.hypot(*arm), np.arctan2(arm[1], arm[0]) + way / np.hypot(*arm)
        left = np.array([-np.sin(angle), np.cos(angle)])
        positions[row, :2] = pivot + radius * np.array([np.cos(angle), np.sin(angle)])
        velocities[row, :2] = 0.2 * left
    return positions, velocities, row


def pulling_alike(drive, hinges):
    """The drive with other hinges and the same pull, which a spring reckons from its taut place."""
    wanted, other = drive.check().tension_force, replace(drive, hinges=hinges)
    pretension = drive.tensioner.pretension

    def pull(value):
        tensioner = replace(drive.tensioner, pretension=value)
        return replace(other, tensioner=tensioner).check().tension_force

    slope = pull(pretension + 1.0) - pull(pretension)
    value = pretension + (wanted - pull(pretension)) / slope
    return replace(other, tensioner=replace(drive.tensioner, pretension=value))


@pytest.mark.parametrize("kind", TENSIONERS)
@pytest.mark.parametrize("way", [-1.5e-3, 0.0, 1e-3, 4e-3])
def test_a_tensioner_moves_its_sprocket_as_with_clearance(kind, way):
    """Away from the chain, where nothing else moves it."""
    drive = three_sprockets(tensioner=TENSIONERS[kind])
    positions, velocities, row = far_from_the_chain(drive, way)
    found = []
    for hinges in ("clearance", "ideal"):
        simulation = rc.Simulation(pulling_alike(drive, hinges))
        for time in (0.0, 0.005, 1.0):
            found.append(simulation.evaluate(positions, velocities, time).accelerations[row])
    clearance, ideal = np.array(found[:3]), np.array(found[3:])
    assert np.abs(clearance).max() > 1.0
    np.testing.assert_allclose(ideal, clearance, rtol=1e-9, atol=1e-8)


@pytest.mark.parametrize("kind", ["spring", "arm"])
def test_a_tensioned_chain_is_as_tight_as_with_clearance(kind):
    drive = three_sprockets(tensioner=TENSIONERS[kind])
    means = []
    for hinges in ("clearance", "ideal"):
        simulation = rc.Simulation(replace(drive, hinges=hinges), solver=SOLVER)
        result = simulation.run(0.03, report_step=2e-4, record=GROUPS, progress=False)
        means.append(result.arrays["strand_tension"].mean(axis=0))
        assert result.arrays["positions"].shape[1] == drive.chain.links + 3
    print(means)
    assert means[0].max() > 30.0
    np.testing.assert_allclose(means[1], means[0], atol=8.0)


def test_a_motor_with_a_curve_has_its_torque():
    drive = three_sprockets(hinges="ideal")
    motor = rc.AppliedTorque(0.5, curve=((0.0, 3.0), (20.0, -1.0)))
    sprockets = [replace(drive.sprockets[0], motion=motor, initial_speed=10.0)]
    simulation = rc.Simulation(replace(drive, sprockets=[*sprockets, *drive.sprockets[1:]]))
    result = simulation.run(1e-3, report_step=1e-4, record=GROUPS, progress=False)
    speed = result.sprocket(1).speed
    np.testing.assert_allclose(result.sprocket(1).torque, 3.5 - 0.2 * speed, rtol=1e-12)


@pytest.mark.parametrize("more", [{"ratchet": 1e-5}, {"damping_back": 1e6}])
def test_a_ratchet_and_a_leak_hold_a_tensioner_back(more):
    """Under a pull that falls after 10 ms; without them the sprocket goes back with the chain."""
    backward = []
    for change in ({}, more):
        tensioner = rc.Tensioner(60.0, sprocket=3, ramp_time=0.0, damping=10.0, **change)
        simulation = rc.Simulation(three_sprockets(tensioner=tensioner, hinges="ideal"))
        simulation.step_to(0.01)
        simulation.set_tensioner_force(0.0)
        result = simulation.run(5e-3, 1e-4, record=("sprockets",), energy=False, progress=False)
        way = np.hypot(*(result.sprocket(3).center - result.sprocket(3).center[0]).T)
        backward.append(way.max())
    assert backward[0] > 3.0 * backward[1]


def test_a_state_and_a_stop_work_with_an_arm(tmp_path):
    drive = three_sprockets(tensioner=TENSIONERS["arm"], hinges="ideal")
    # The explicit corrector: these 2 ms dissipate 6e-6 J, and the implicit one errs by over 5 %.
    solver = replace(SOLVER, method="pece")
    straight, broken = (rc.Simulation(drive, solver=solver) for _ in range(2))
    assert len(straight.body_names) == drive.chain.links + 3
    straight.step_to(2e-3)
    broken.step_to(1e-3)
    broken.save_state(tmp_path / "state.npz")
    resumed = rc.Simulation.load_state(tmp_path / "state.npz")
    resumed.step_to(2e-3)
    np.testing.assert_array_equal(resumed.positions, straight.positions)
    stop = rc.HingeForceAbove(1e-6)
    result = resumed.run(1e-3, report_step=1e-4, stop=stop, progress=False)
    assert result.status == "stopped"


def test_positions_of_an_arm_are_not_asked_for():
    drive = three_sprockets(tensioner=TENSIONERS["bare arm"], hinges="ideal")
    simulation = rc.Simulation(drive)
    simulation.evaluate(simulation.positions, simulation.velocities)
    with pytest.raises(rc.InvalidInput, match=r"positions = 5 rows: .* each of the 81 bodies"):
        simulation.evaluate(simulation.positions[:5])
