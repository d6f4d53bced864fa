"""Drives as mechanisms: with clearance they move as the drive, with ideal hinges chains close."""

import dataclasses

import numpy as np
import pytest

import rustchain as rc

SOLVER = rc.Solver(rtol=1e-9, atol=1e-9)


def test_a_drive_with_clearance_moves_as_its_mechanism():
    """At 5 ms, past the first contacts; chaos has not begun to tell the two apart."""
    drive = rc.paper_drive(pretension=25.0)
    direct = rc.Simulation(drive, solver=SOLVER)
    mechanism = rc.Simulation(drive.to_mechanism(), solver=SOLVER)
    assert mechanism.body_names == direct.body_names
    np.testing.assert_allclose(mechanism.positions, direct.positions, atol=1e-14)
    for simulation in (direct, mechanism):
        simulation.step_to(5e-3)
    np.testing.assert_allclose(mechanism.positions[:, :2], direct.positions[:, :2], atol=2e-8)
    evaluation = mechanism.evaluate()
    assert np.max(evaluation.contact_force) > 1.0


def test_ideal_hinges_close_the_chain_and_carry_the_pretension():
    drive = rc.paper_drive(pretension=100.0)
    simulation = rc.Simulation(
        drive.to_mechanism(hinges="ideal"), solver=rc.Solver(rtol=1e-6, atol=1e-6)
    )
    report = simulation.check()
    assert report.moved < 1e-9
    assert report.redundant == ()
    # 38 links in a ring keep 38 of their 114 motions, the driven sprocket its turn and its slide.
    assert report.degrees_of_freedom == 38 + 2
    result = simulation.run(duration=0.02, report_step=1e-4, progress=False)
    for k in range(1, 39):
        joint = result.joint(f"hinge_{k}")
        assert np.max(joint.position_residual) < 1e-15
        assert np.max(joint.velocity_residual) < 1e-13
    energy = result.energy
    assert np.max(np.abs(energy.residual)) < 1e-3 * np.max(energy.kinetic)
    # The pull has grown to a fifth, 40 N in two strands.
    tension = [np.hypot(*result.joint(f"hinge_{k}").force[-50:].T).mean() for k in (14, 33)]
    assert 5.0 < np.mean(tension) < 60.0


def test_a_drive_can_be_extended():
    mechanism = rc.paper_drive().to_mechanism(hinges="ideal")
    mechanism.add_torque("load", "sprocket_2", -0.1)
    mechanism.add_torsion_spring("rubber", "ground", "sprocket_2", damping=1e-3)
    simulation = rc.Simulation(mechanism, solver=rc.Solver(rtol=1e-6, atol=1e-6))
    simulation.step_to(5e-3)
    assert abs(simulation.velocities[-2, 2] - 12.566370614359172) < 1e-6


def test_other_hinges_are_refused():
    with pytest.raises(rc.InvalidInput, match="'clearance' or 'ideal'"):
        rc.paper_drive().to_mechanism(hinges="rigid")


def test_a_film_of_several_strands_is_as_long_in_the_mechanism():
    paper = rc.paper_drive(pretension=25.0)
    drive = dataclasses.replace(paper, chain=dataclasses.replace(paper.chain, strands=3))
    law = rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1, length=9e-3))
    direct = rc.Simulation(drive, law, solver=SOLVER)
    mechanism = rc.Simulation(drive.to_mechanism(force_law=law), solver=SOLVER)
    for simulation in (direct, mechanism):
        simulation.step_to(2e-3)
    np.testing.assert_allclose(mechanism.positions[:, :2], direct.positions[:, :2], atol=2e-8)


def test_sharp_regions_do_not_go_into_a_mechanism():
    says = r'LankaraniNikravesh\.regions = .sharp.: must be "kept" in a mechanism'
    law = rc.LankaraniNikravesh(regions="sharp")
    with pytest.raises(rc.InvalidInput, match=says):
        rc.paper_drive().to_mechanism(force_law=law)
    mechanism = rc.Mechanism()
    mechanism.add_body("pin", 0.1, 1e-5)
    contact = rc.SurfaceContact(law)
    mechanism.add_clearance_joint("joint", "ground", "pin", 0.0101, 0.01, contact)
    with pytest.raises(rc.InvalidInput, match=says):
        mechanism.check()


@pytest.mark.parametrize("back", [0.0, 100.0])
def test_a_leak_does_not_go_into_a_mechanism_even_a_leak_of_none(back):
    tensioner = rc.Tensioner(25.0, damping_back=back)
    drive = dataclasses.replace(rc.paper_drive(), tensioner=tensioner)
    with pytest.raises(rc.InvalidInput, match="a leak do not go into a mechanism"):
        drive.to_mechanism()
    rc.Simulation(dataclasses.replace(drive, hinges="ideal")).step_to(1e-4)  # runs as a drive
    alike = dataclasses.replace(tensioner, damping_back=tensioner.damping)
    dataclasses.replace(drive, tensioner=alike).to_mechanism()


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
def test_a_pull_without_a_ramp_is_there_from_the_start(hinges):
    tensioner = rc.Tensioner(100.0, ramp_time=0.0)
    drive = dataclasses.replace(rc.paper_drive(), tensioner=tensioner, hinges=hinges)
    simulation = rc.Simulation(drive)
    acceleration = simulation.evaluate().accelerations[-1, 0]
    if hinges == "clearance":  # nothing holds the sprocket back yet
        pull = drive.check().tension_force
        assert acceleration == pytest.approx(pull / drive.sprockets[1].mass)
    assert acceleration > 0.0


WAYS = ("clearance", "ideal", "mechanism with clearance", "mechanism with ideal hinges")


def in_this_way(drive, way):
    """Return the drive with its hinges, or as a mechanism."""
    hinges = "ideal" if "ideal" in way else "clearance"
    if way.startswith("mechanism"):
        return drive.to_mechanism(hinges=hinges)
    return dataclasses.replace(drive, hinges=hinges)


@pytest.mark.parametrize("way", WAYS)
def test_the_rotation_of_a_driver_counts_in_the_energies_however_a_drive_is_simulated(way):
    """Kinetic energy by masses and velocities of the bodies; external work by the balance."""
    drive = rc.paper_drive()
    ramp = rc.PrescribedSpeed([(0.0, 5.0), (0.01, 20.0)])
    driver = dataclasses.replace(drive.sprockets[0], motion=ramp, inertia=0.01)
    drive = dataclasses.replace(drive, sprockets=[driver, drive.sprockets[1]])
    mechanism = drive.to_mechanism()
    result = rc.Simulation(in_this_way(drive, way), solver=SOLVER).run(
        0.01, 1e-3, record=("bodies", "energy"), progress=False
    )
    velocities = result.array("velocities")[:, : len(mechanism.bodies)]
    masses = np.array([(body.mass, body.mass, body.inertia) for body in mechanism.bodies])
    energy = result.energy
    np.testing.assert_allclose(
        energy.kinetic, 0.5 * (masses * velocities**2).sum(axis=(1, 2)), rtol=1e-9
    )
    spun_up = 0.5 * 0.01 * (20.0**2 - 5.0**2)
    grown = np.diff(energy.kinetic[[0, -1]]) + np.diff(energy.elastic[[0, -1]])
    grown += np.diff(energy.gravity[[0, -1]]) + energy.dissipated[-1]
    assert energy.external_work[-1] > spun_up
    assert energy.external_work[-1] == pytest.approx(grown[0], abs=1e-4 * spun_up)
