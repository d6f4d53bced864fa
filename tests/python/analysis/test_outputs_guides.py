"""What engineers read of a drive whose chain bears on a rail of its own material."""

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc


@pytest.fixture(scope="module")
def on_a_rail():
    """A blade of a polymer pressed on the slack strand, from rest."""
    drive = rc.two_sprocket_drive(
        chain="ANSI 40", teeth=(17, 17), links=60, center_distance=0.2715, speed=10.0, torque=-1.0
    )
    blade = rc.GuideRail(
        center=(0.136, -0.07),
        direction=(0.0, 1.0),
        length=0.12,
        radius=0.25,
        arm=rc.GuideArm(pivot=(0.055, -0.075), force=40.0, ramp_time=2e-3),
        material=rc.Material(3e9, 0.4, 0.71),
    )
    drive = replace(drive, gravity=(0.0, -9.81), guides=[blade])
    return rc.Simulation(drive).run(0.02, 1e-3, progress=False)


def test_pressure_on_a_rail_is_that_of_both_materials(on_a_rail):
    chain = on_a_rail.drive.chain
    wheel, force = on_a_rail.array("tooth_sprocket"), on_a_rail.array("tooth_force")
    there = (wheel == 3) & (force > 0.0)
    assert there.any()
    compliance = (1.0 - 0.3**2) / 2.07e11 + (1.0 - 0.4**2) / 3e9
    length = chain.tooth_contact_length
    curvature = 1.0 / chain.bushing_radius + 1.0 / 0.25
    wanted = np.sqrt(force * curvature / (np.pi * length * compliance))
    found = on_a_rail.contact_pressure("tooth")["pressure"].to_numpy()
    np.testing.assert_allclose(found[there], wanted[there], rtol=1e-12)


def test_a_load_that_drives_is_refused():
    drive = rc.two_sprocket_drive("ANSI 40", links=78, torque=-1.0)
    with pytest.raises(rc.InvalidInput, match=r"torques = 1 N m at speeds = 10 rad/s.*-1 N m"):
        rc.loss_map(drive, [10.0], [1.0])


def test_a_drive_without_a_load_has_no_efficiency():
    drive = rc.two_sprocket_drive("ANSI 40", links=78, torque=0.0)
    still = rc.Simulation(drive).run(0.05, 1e-3, progress=False)
    assert np.isnan(still.efficiency())


def test_a_mechanism_takes_its_solver_by_keyword_alone():
    mechanism = rc.Mechanism()
    mechanism.add_body("bob", mass=1.0, inertia=0.1)
    mechanism.add_revolute("pivot", "ground", "bob", at=(0.0, 0.1))
    solver = rc.Solver(method="newton", accuracy=1e-4)
    assert rc.Simulation(mechanism, solver=solver).solver == solver
    for wrong in (solver, "rubbish"):
        with pytest.raises(rc.InvalidInput, match="force_law"):
            rc.Simulation(mechanism, wrong)
