"""Rollers as bodies of their own: against the NumPy reference, and as users meet them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import DriveEquations
from reference.states import with_rollers

LN = rc.LankaraniNikravesh()
SCENES = {
    "damped": (LN, None, None),
    "johnson": (rc.Johnson(), None, None),
    "enhanced": (rc.EnhancedCylinder(), None, None),
    "friction": (LN, rc.Coulomb(0.1), rc.Coulomb(0.2, speed=1e-2)),
    "friction in hinges alone": (LN, rc.Coulomb(0.3, "threlfall", 5e-3), None),
    "friction on teeth alone": (LN, None, rc.Coulomb(0.15, "ambrosio", 2e-2, 1e-3)),
}
PLAYS = (6e-6, None)  # [m] radial; None: as it is


def roller_drive(play: float | None = None, pretension: float = 25.0) -> rc.ChainDrive:
    drive = rc.paper_drive(pretension, rollers="bodies")
    if play is None:
        return drive
    chain = drive.chain
    roller = replace(chain.roller, bore_radius=chain.bushing_radius + play)
    return replace(drive, chain=replace(chain, roller=roller))


@pytest.mark.filterwarnings("ignore::rustchain.RangeWarning")
@pytest.mark.parametrize("play", PLAYS)
@pytest.mark.parametrize("scene", SCENES)
def test_forces_and_accelerations_agree_to_round_off(scene, play, states_with_seat):
    law, hinges, teeth = SCENES[scene]
    drive = roller_drive(play)
    simulation = rc.Simulation(
        drive,
        law,
        hinge_law=replace(law, friction=hinges),
        tooth_law=replace(law, friction=teeth),
    )
    laws = [replace(law, friction=friction) for friction in (hinges, teeth)]
    equations = DriveEquations(drive, *laws)
    rng = np.random.default_rng(7)
    pressed, rubbing = np.zeros(3), np.zeros(3)
    for base in states_with_seat("pitch-circle")[::2]:
        positions, velocities = with_rollers(equations, base, rng)
        expected = equations.evaluate(positions, velocities, 0.04)
        e = simulation.evaluate(positions=positions, velocities=velocities, time=0.04)
        for kind in ("hinge", "roller", "tooth"):
            forces = (getattr(e, f"{kind}_force"), getattr(expected, kind).force)
            assert_within(*forces, getattr(expected, f"{kind}_force_bound"), f"{kind}: forces")
            bound = getattr(expected, f"{kind}_vector_bound")
            vectors = [getattr(found, f"{kind}_force_vector") for found in (e, expected)]
            assert_within(*vectors, bound[..., None], f"{kind}: forces as vectors")
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        parts = (expected.hinge, expected.roller, expected.tooth)
        pressed += [np.sum(part.force > 0.0) for part in parts]
        rubbing += np.array(expected.friction_powers) > 0.0
    assert np.all(pressed > 100)
    wanted = [hinges is not None, teeth is not None, hinges is not None]
    assert np.all((rubbing > 20) == wanted)


def test_bodies_and_channels_of_a_roller_drive():
    drive = roller_drive()
    simulation = rc.Simulation(drive)
    names = simulation.body_names
    assert (names[0], names[38], names[75], names[76]) == (
        "link_1",
        "roller_1",
        "roller_38",
        "sprocket_1",
    )
    result = simulation.run(
        0.01, 1e-3, record=("hinges", "teeth", "sprockets", "bodies", "energy"), progress=False
    )
    roller = result.roller(6)
    assert roller.force.shape == (11,)
    assert roller.position is not None
    assert np.array_equal(roller.position, result.array("positions")[:, 43])
    # The bushing is never out of the bore, and pressed where it is deeper than the play.
    distance = np.hypot(*roller.eccentricity.T)
    play = drive.chain.roller.bore_radius - drive.chain.bushing_radius
    np.testing.assert_allclose(roller.penetration, distance - play, atol=1e-12)
    assert np.all((roller.force > 0.0) == (roller.penetration > 0.0))
    np.testing.assert_allclose(np.hypot(*roller.force_vector.T), roller.force, rtol=1e-9)
    assert result.peaks.roller_force.max() > 0.0
    assert result.energy.roller_contact[-1] > 0.0
    assert np.all(result.energy.roller_friction == 0.0)
    channels = result.power_balance().channel.values
    assert "roller_contact" in channels


def test_the_report_and_the_picture_have_rollers():
    drive = roller_drive()
    report = drive.check()
    assert report.roller_play == pytest.approx(50e-6)
    assert "play of the rollers       50.000 um" in str(report)
    assert "rollers" not in str(rc.paper_drive(25.0).check())
    result = rc.Simulation(drive).run(1e-3, 1e-3, record=["bodies", "energy"], progress=False)
    outlines = [len(artist.get_paths()) for artist in result.plot.drive().axes[0].collections]
    assert outlines.count(38) == 5  # rollers, bores, marks of their rotation, bushings, pins
    plain = rc.Simulation(rc.paper_drive(25.0)).run(1e-3, 1e-3, progress=False)
    outlines = [len(artist.get_paths()) for artist in plain.plot.drive().axes[0].collections]
    assert outlines.count(38) == 2


def test_a_drive_file_may_ask_for_rollers(tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text(
        "[drive]\ntype = 'paper_drive'\npretension = 25.0\nrollers = 'bodies'\n", encoding="utf-8"
    )
    assert rc.load_scene(path).drive == roller_drive()


def test_without_rollers_nothing_of_them_is_there():
    result = rc.Simulation(rc.paper_drive(25.0)).run(1e-3, 1e-3, energy=True, progress=False)
    assert not [name for name in result.arrays if "roller" in name]
    with pytest.raises(rc.NotRecorded, match="no bodies of their own"):
        result.roller(1)


@pytest.mark.parametrize("method", ["pece", "newton"])
def test_a_run_goes_on_bit_for_bit_from_a_saved_state(method, tmp_path):
    simulation = rc.Simulation(roller_drive(), solver=rc.Solver(method=method))
    simulation.step_to(6e-3)
    simulation.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    for run in (simulation, again):
        run.step_to(8e-3)
    assert np.array_equal(simulation.positions, again.positions)
    assert np.array_equal(simulation.velocities, again.velocities)


def test_a_result_is_saved_and_loaded(tmp_path):
    result = rc.Simulation(roller_drive()).run(2e-3, 1e-3, progress=False)
    result.save(tmp_path / "run.nc")
    again = rc.load_result(tmp_path / "run.nc")
    assert again.drive == result.drive
    assert np.array_equal(again.roller(3).force, result.roller(3).force)
    assert len(result.to_pandas().filter(like="roller_force_vector_6").columns) == 2


def test_a_static_start_presses_rollers_between_bushings_and_teeth():
    drive = roller_drive(pretension=100.0)
    simulation = rc.Simulation(drive, start="static")
    e = simulation.evaluate(velocities=np.zeros_like(simulation.velocities))
    assert np.all(np.abs(e.accelerations[38:76, :2]) < 0.1)
    on_teeth = e.tooth_force.sum(axis=1)
    seated = on_teeth > 1.0
    assert seated.sum() >= 4
    # A roller at rest passes on what its bushing presses it with, but for its weight.
    weight = 9.81 * drive.chain.roller.mass
    np.testing.assert_allclose(e.roller_force[seated], on_teeth[seated], atol=1.1 * weight)


def test_a_catalogue_chain_weighs_the_same_with_rollers_as_bodies():
    for name, size in rc.chain_sizes().items():
        fixed = rc.catalogue_chain(name, 40)
        if not size.has_rollers:
            with pytest.raises(rc.InvalidInput, match="without rollers"):
                rc.catalogue_chain(name, 40, rollers="bodies")
            continue
        chain = rc.catalogue_chain(name, 40, rollers="bodies")
        roller = chain.roller
        assert chain.inner.mass + 2.0 * roller.mass == pytest.approx(fixed.inner.mass, rel=1e-12)
        assert chain.outer == fixed.outer
        assert chain.contact_radius == fixed.bushing_radius
        # Rollers at the hinges, and their own inertia, make up what the inner link has lost.
        moved = 2.0 * (roller.mass * (0.5 * chain.pitch) ** 2 + roller.inertia)
        assert chain.inner.inertia + moved == pytest.approx(fixed.inner.inertia, rel=1e-12)
        across = roller.radius**2 + roller.bore_radius**2
        assert roller.inertia == pytest.approx(0.5 * roller.mass * across, rel=1e-12)
        assert "roller bore diameter" in str(size)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda c, r: replace(r, radius=0.0), "Roller.radius"),
        (lambda c, r: replace(r, mass=-1.0), "Roller.mass"),
        (lambda c, r: replace(r, bore_radius=r.radius), "larger than its bore's"),
        (lambda c, r: replace(c, bushing_radius=r.bore_radius), "larger than the bushing's"),
        (lambda c, r: replace(c, roller=replace(r, radius=0.5 * c.pitch)), "would overlap"),
        (lambda c, r: replace(c, roller=3.0), "Chain.roller"),
        (lambda c, r: rc.two_sprocket_drive(replace(c, roller=None), rollers="bodies"), "roller"),
        (lambda c, r: rc.paper_drive(rollers="loose"), "'fixed' or 'bodies'"),
        (lambda c, r: roller_drive().to_mechanism(), "no rollers as bodies"),
    ],
)
def test_rollers_and_pitches_that_cannot_be_are_refused(make, message):
    chain = roller_drive().chain
    with pytest.raises(rc.InvalidInput, match=message):
        make(chain, chain.roller)


def test_a_roller_off_its_bushing_is_refused():
    drive = roller_drive()
    start = rc.Simulation(drive)
    positions = start.positions.copy()
    positions[40, 0] += 1e-3
    with pytest.raises(rc.InvalidInput, match=r"roller_3.*off its bushing"):
        rc.Simulation(drive, positions=positions, velocities=start.velocities)
