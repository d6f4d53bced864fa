"""Bristles in hinges, on teeth, in rollers: against the NumPy reference, and as users see them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import DriveEquations

LAW = rc.LuGre(0.2, 0.1, viscous_coefficient=0.05, stribeck_speed=5e-3, stribeck_exponent=0.7)
WHERE = {
    "hinges": (LAW, None),
    "teeth": (None, rc.LuGre(0.15, 0.15, stiffness=3e5, damping=0.1)),
    "both": (LAW, rc.LuGre(0.1, 0.05)),
}


@pytest.mark.parametrize("rollers", [False, True])
@pytest.mark.parametrize("which", WHERE)
def test_forces_of_bent_bristles_agree_to_round_off(which, rollers):
    hinges, teeth = WHERE[which]
    laws = [rc.Hertz(regions="sharp", friction=law) for law in (hinges, teeth)]
    drive = rc.paper_drive(100.0, rollers="bodies" if rollers else "fixed")
    drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=1e-3))
    simulation = rc.Simulation(drive, hinge_law=laws[0], tooth_law=laws[1])
    equations = DriveEquations(drive, *laws)
    rng = np.random.default_rng(5)
    bent = 0
    for report in range(1, 7):
        simulation.step_to(1e-3 * report)
        # Bristles stay bent as they are while everything moves otherwise.
        positions = simulation.positions
        velocities = simulation.velocities
        velocities = velocities + 1e-2 * rng.standard_normal(velocities.shape) * [1, 1, 100]
        velocities[-2:] = simulation.velocities[-2:]
        e = simulation.evaluate(velocities=velocities)
        equations.bristles = (e.hinge_bristle, e.tooth_bristle, e.roller_bristle)
        expected = equations.evaluate(positions, velocities, simulation.time)
        for kind in ("hinge", "tooth") + (("roller",) if rollers else ()):
            bound = getattr(expected, f"{kind}_vector_bound")
            vectors = [getattr(found, f"{kind}_force_vector") for found in (e, expected)]
            assert_within(*vectors, bound[..., None], f"{kind}: forces as vectors")
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        for deflection in (e.hinge_bristle, e.tooth_bristle, e.roller_bristle):
            bent += 0 if deflection is None else np.count_nonzero(deflection)
        assert (e.hinge_bristle is None) == (hinges is None)
        assert (e.tooth_bristle is None) == (teeth is None)
        assert (e.roller_bristle is None) == (hinges is None or not rollers)
    assert bent > 4
    at_places = simulation.evaluate(positions=positions)
    assert all(
        deflection is None or np.all(deflection == 0.0)
        for deflection in (at_places.hinge_bristle, at_places.tooth_bristle)
    )


def test_a_state_with_bent_bristles_is_saved_and_goes_on(tmp_path):
    drive = rc.paper_drive(pretension=100.0)
    drive = replace(drive, tensioner=replace(drive.tensioner, ramp_time=1e-3))
    simulation = rc.Simulation(drive, force_law=rc.LankaraniNikravesh(friction=LAW))
    simulation.step_to(4e-3)
    simulation.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    for run in (simulation, again):
        run.step_to(5e-3)
    assert np.array_equal(simulation.positions, again.positions)
    bent = [run.evaluate().hinge_bristle for run in (simulation, again)]
    assert np.array_equal(*bent)
    assert np.any(bent[0] != 0.0)


def test_losses_are_channels_and_efficiency_counts_them():
    drive = rc.paper_drive(100.0)
    driven = replace(drive.sprockets[1], motion=rc.AppliedTorque(-2.0))
    tensioner = replace(drive.tensioner, ramp_time=2e-3)
    drive = replace(drive, sprockets=(drive.sprockets[0], driven), tensioner=tensioner)
    result = rc.Simulation(drive, hinge_law=rc.LankaraniNikravesh(friction=rc.LuGre(0.1, 0.1))).run(
        0.03, 1e-4, progress=False
    )
    energy = result.energy
    assert energy.hinge_friction is not None
    assert energy.hinge_friction[-1] > 1e-3
    assert energy.tooth_friction is not None
    assert np.all(energy.tooth_friction == 0.0)
    # Measured: 1e-4 of what is dissipated.
    assert np.max(np.abs(energy.residual)) < 3e-3 * energy.dissipated[-1]
    assert 0.5 < result.efficiency(after=0.01) < 1.0


def test_bristles_are_a_friction_in_laws_files_and_sweeps(tmp_path):
    law = rc.LankaraniNikravesh(friction=LAW)
    assert rc.ForceLaw.from_json(law.to_json()) == law
    file = tmp_path / "drive.toml"
    file.write_text(
        """
[drive]
type = "paper_drive"
pretension = 25.0

[simulation.force_law]
type = "LankaraniNikravesh"

[simulation.force_law.friction]
static_coefficient = 0.12
kinetic_coefficient = 0.1
"""
    )
    assert rc.load_scene(file).force_law.friction == rc.LuGre(0.12, 0.1)
    found = rc.sweep(
        rc.paper_drive(25.0),
        {"hinge_law.friction": [None, rc.LuGre(0.1, 0.1)]},
        lambda result: result.energy.hinge_friction[-1],
        duration=6e-3,
        report_step=1e-3,
        progress=False,
    )
    assert found.values[0] == 0.0
    assert found.values[1] > 0.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rc.LuGre(0.0, 0.0), "LuGre.static_coefficient = 0.*leave the law out"),
        (lambda: rc.LuGre(0.1, 0.2), "LuGre.kinetic_coefficient = 0.2.*viscous_coefficient"),
        (lambda: rc.LuGre(0.1, 0.1, stiffness=0.0), "LuGre.stiffness.*1/m"),
        (lambda: rc.LuGre(0.1, 0.1, damping=-1.0), "LuGre.damping.*s/m"),
        (lambda: rc.LuGre(0.1, 0.1, viscous_coefficient=-1.0), "LuGre.viscous_coefficient"),
        (lambda: rc.LuGre(0.1, 0.1, stribeck_speed=0.0), "LuGre.stribeck_speed.*m/s"),
        (lambda: rc.LuGre(0.1, 0.1, stribeck_exponent=20.0), "LuGre.stribeck_exponent.*0.1 to 10"),
        (
            lambda: rc.Simulation(
                replace(rc.paper_drive(25.0), hinges="ideal"),
                force_law=rc.LankaraniNikravesh(friction=rc.LuGre(0.1, 0.1)),
            ),
            "friction.*whose hinges have no contact",
        ),
    ],
)
def test_a_lugre_law_that_means_nothing_is_refused(make, message):
    with pytest.raises(rc.InvalidInput, match=message):
        make()


@pytest.mark.parametrize(("stiffness", "remedy"), [(1e2, "or more"), (1e9, "or less")])
def test_absurd_bristles_are_warned_of(stiffness, remedy):
    with pytest.warns(rc.RangeWarning, match=f"LuGre friction, hinges.*{remedy}"):
        rc.Simulation(
            rc.paper_drive(25.0),
            hinge_law=rc.LankaraniNikravesh(friction=rc.LuGre(0.1, 0.1, stiffness=stiffness)),
        ).run(1e-5, 1e-5, progress=False)
