"""The public face in use: scripts run, looking changes no path, runs that fail say where."""

import math
import re
import warnings
from dataclasses import replace

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import rustchain as rc

END = 8.3e-3  # [s], after the first contacts of hinges and teeth
ALL = ("hinges", "teeth", "sprockets", "bodies", "energy")


def path_of(simulation):
    """What must not depend on who looks: time, positions, velocities, memory, steps."""
    state = simulation.state()
    memory = [state[key] for key in sorted(state) if "onset" in key]
    return [state["time"], state["positions"], state["velocities"], *memory]


def assert_same_path(one, other):
    for a, b in zip(path_of(one), path_of(other), strict=True):
        np.testing.assert_array_equal(a, b)


def assert_same_state(one, other):
    assert one.keys() == other.keys()
    for key, value in one.items():
        np.testing.assert_array_equal(value, other[key], err_msg=key)


@pytest.fixture(scope="module")
def at_end():
    """The paper's drive with 25 N after END, reached in one go."""
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    simulation.step_to(END)
    return simulation


def test_a_script_with_every_name_of_the_public_face_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")

    drive = rc.paper_drive(pretension=0.0)
    drive = rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 25), center_distance=0.247)
    drive = rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 25), links=60, speed=12.566)
    chain = rc.Chain(
        pitch=0.0127,
        links=60,
        inner=rc.Link(mass=6.5e-3, inertia=1.8e-7),
        outer=rc.Link(mass=8.3e-3, inertia=1.2e-7),
        hinge=rc.ClearanceHinge(pin_radius=2.22e-3, bore_radius=2.245e-3, length=0.011),
        bushing_radius=0.00396875,
        tooth_contact_length=0.007,
        material=rc.Material(elastic_modulus=2.07e11, poisson_ratio=0.3, restitution=0.71),
    )
    profile = rc.AnsiTooth(seat="bottom-diameter")
    center = drive.sprockets[1].center
    driver = rc.Sprocket(
        teeth=17, center=(0, 0), motion=rc.PrescribedSpeed(12.566), profile=profile
    )
    for motion in (rc.Free(), rc.AppliedTorque(-0.1), rc.AppliedTorque([(0.0, 0.0), (0.1, -0.2)])):
        driven = rc.Sprocket(teeth=25, center=center, motion=motion, profile=profile)
        drive = rc.ChainDrive(
            chain=chain,
            sprockets=[driver, driven],
            tensioner=rc.Tensioner(sprocket=2, pretension=10.0),
            gravity=(0.0, -9.81),
        )
    report = drive.check()
    assert report.links == 60
    assert len(report.warnings) >= 0
    assert {"wrap_angle", "phase", "strand_slack"} <= set(vars(report))
    for law in (rc.LankaraniNikravesh(), rc.Johnson(), rc.EnhancedCylinder(), rc.Hertz()):
        rc.Simulation(drive, force_law=law)
    assert rc.Johnson().damping is None
    law = rc.Johnson(damping="lankarani-nikravesh")
    rc.LankaraniNikravesh(regions="kept")

    sim = rc.Simulation(
        drive,
        force_law=rc.LankaraniNikravesh(regions="sharp"),
        hinge_law=law,
        tooth_law=None,
        min_impact_velocity=1e-3,
        positions=None,
        velocities=None,
        solver=rc.Solver(method="auto", rtol=1e-5, atol=1e-5, max_step=1e-4),
    )
    assert rc.Solver(method="pece").method == "pece"
    bodies, hinges, times = 62, 60, 11
    assert [*sim.body_names[:2], *sim.body_names[-3:]] == [
        "link_1",
        "link_2",
        "link_60",
        "sprocket_1",
        "sprocket_2",
    ]
    assert sim.time == 0.0
    assert sim.positions.shape == sim.velocities.shape == (bodies, 3)
    assert {"positions", "velocities"} <= sim.state().keys()
    state = sim.state()
    sim.set_state(state)
    sim.save_state("state.npz")
    sim = rc.Simulation.load_state("state.npz")
    e = sim.evaluate(positions=None, velocities=None, time=None)
    assert e.accelerations.shape == (bodies, 3)
    assert e.hinge_force.shape == e.hinge_penetration.shape == (hinges,)
    assert e.tooth_force.shape == e.tooth_penetration.shape == (hinges, 2)
    assert not np.isnan(e.tooth_penetration).any()
    assert (e.tooth_penetration == -math.inf).any()
    sim.step_to(5e-4)
    assert sim.time == 5e-4
    result = sim.run(
        duration=1e-3,
        report_step=1e-4,
        record=("hinges", "teeth", "sprockets", "energy"),
        progress=True,
    )

    assert result.time.shape == (times,)
    hinge = result.hinge(6)
    assert hinge.force.shape == hinge.penetration.shape == (times,)
    assert hinge.force_vector.shape == hinge.eccentricity.shape == (times, 2)
    bushing = result.bushing(6)
    for values in (
        bushing.tooth_force,
        bushing.tooth_penetration,
        bushing.sprocket,
        bushing.tooth,
        bushing.region,
    ):
        assert values.shape == (times,)
    assert result.strand("upper").tension.shape == result.strand("lower").tension.shape == (times,)
    sprocket = result.sprocket(1)
    for values in (sprocket.angle, sprocket.speed, sprocket.torque):
        assert values.shape == (times,)
    for name in ("kinetic", "gravity", "elastic", "dissipated", "external_work", "residual"):
        assert getattr(result.energy, name).shape == (times,)
    assert result.peaks.hinge_force.shape == result.peaks.tooth_impulse.shape == (times, hinges)
    assert result.status == "finished"
    assert isinstance(result.message, str)
    assert result.success
    assert {
        "steps",
        "rejected",
        "evaluations",
        "onsets",
        "onsets_at_minimum_velocity",
    } <= result.stats.keys()
    assert any(key.startswith("wall_") for key in result.stats)
    assert result.to_xarray().sizes["time"] == len(result.to_pandas()) == times
    result.save("run.nc")
    np.testing.assert_array_equal(rc.load_result("run.nc").time, result.time)
    for figure in (
        result.plot.hinge_force(6),
        result.plot.tooth_force(6),
        result.plot.force_penetration(6),
        result.plot.orbit(6),
        result.plot.tension(),
        result.plot.drive(time=result.time[-1]),
    ):
        figure.savefig("figure.png")
        plt.close(figure)


# --- looking changes nothing


@pytest.mark.parametrize(
    "stops", [[1e-3, 2.5e-3, 4.4e-3], np.linspace(1e-5, 7.99e-3, 333).tolist()]
)
def test_step_to_reaches_each_time_exactly_and_keeps_the_path(stops, at_end):
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    for t in stops:
        simulation.step_to(t)
        assert simulation.time == t
    simulation.step_to(simulation.time)
    simulation.step_to(END)
    assert simulation.time == END
    assert_same_state(simulation.state(), at_end.state())


def test_a_run_goes_on_where_step_to_stopped(at_end):
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    simulation.step_to(4.05e-3)
    stopped = simulation.positions, simulation.velocities
    first = simulation.run(1e-3, record=("bodies", "energy"), progress=False)
    assert first.time[0] == 4.05e-3
    assert first.time[-1] == simulation.time == 4.05e-3 + 1e-3
    np.testing.assert_array_equal(first.array("positions")[0], stopped[0])
    np.testing.assert_array_equal(first.array("velocities")[0], stopped[1])
    second = simulation.run(END - simulation.time, record=("bodies", "energy"), progress=False)
    assert second.time[0] == first.time[-1]
    np.testing.assert_array_equal(second.array("positions")[0], first.array("positions")[-1])
    simulation.step_to(END)
    assert_same_path(simulation, at_end)


@pytest.mark.parametrize("energy", [False, True])
@pytest.mark.parametrize(
    ("report_step", "record"), [(1.0, ()), (1e-3, ALL), (1e-4, ("teeth",)), (3.7e-6, ALL)]
)
def test_reports_and_the_energy_balance_do_not_change_the_path(report_step, record, energy, at_end):
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    result = simulation.run(END, report_step, record=record, energy=energy, progress=False)
    assert_same_path(simulation, at_end)
    np.testing.assert_array_equal(result.final_positions, at_end.positions)
    assert result.time[-1] == END


def test_reports_are_where_they_were_asked_for():
    result = rc.Simulation(rc.paper_drive()).run(1e-3, 3e-4, record=("bodies",), progress=False)
    np.testing.assert_allclose(result.time, [0.0, 3e-4, 6e-4, 9e-4, 1e-3], rtol=1e-15)


def test_rows_at_equal_times_are_equal_whatever_the_report_step():
    results = [
        rc.Simulation(rc.paper_drive()).run(END, step, record=ALL, progress=False)
        for step in (2.0**-10, 2.0**-13)
    ]
    every = len(results[0].time) - 1  # the last row lies at the end, on no grid
    for name, values in results[0].arrays.items():
        if not name.startswith("peak"):
            np.testing.assert_array_equal(values[:every], results[1].arrays[name][: 8 * every : 8])


def test_the_same_run_twice_gives_the_same_bits():
    one, other = (
        rc.Simulation(rc.paper_drive(), rc.EnhancedCylinder()).run(
            0.015, record=ALL, progress=False
        )
        for _ in range(2)
    )
    assert one.array("hinge_force").any()
    assert one.array("tooth_force").any()
    assert one.arrays.keys() == other.arrays.keys()
    for name, values in one.arrays.items():
        np.testing.assert_array_equal(values, other.arrays[name], strict=True)


def test_evaluating_has_no_side_effects(at_end):
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    rng = np.random.default_rng(7)
    for t in (1e-3, 4.5e-3, 6e-3):
        simulation.step_to(t)
        before = simulation.state()
        positions = simulation.positions + 1e-6 * rng.standard_normal((40, 3))
        velocities = simulation.velocities + 0.1 * rng.standard_normal((40, 3))
        given = positions.copy(), velocities.copy()
        simulation.evaluate()
        simulation.evaluate(positions=positions, velocities=velocities, time=0.3)
        simulation.evaluate(velocities=velocities)
        np.testing.assert_array_equal((positions, velocities), given)
        assert_same_state(simulation.state(), before)
    simulation.step_to(END)
    assert_same_state(simulation.state(), at_end.state())


def test_what_is_handed_out_is_a_copy():
    simulation = rc.Simulation(rc.paper_drive())
    kept = simulation.positions, simulation.velocities
    before = np.array(kept)
    simulation.step_to(1e-4)
    np.testing.assert_array_equal(kept, before)
    state = simulation.state()
    state["positions"][:] = 0.0
    state["hinge_onset_speed"][:] = 1.0
    assert simulation.positions.any()
    assert not simulation.state()["hinge_onset_speed"].any()


def test_a_state_is_complete(at_end):
    state = at_end.state()
    evaluation = at_end.evaluate()
    assert state["time"] == END
    np.testing.assert_array_equal(state["positions"], at_end.positions)
    np.testing.assert_array_equal(state["velocities"], at_end.velocities)
    # Whatever touches has a memory; of the rest, what begins or ends inside the last step.
    for kind in ("hinge", "tooth"):
        touching = getattr(evaluation, f"{kind}_penetration") > 0.0
        remembered = state[f"{kind}_onset_speed"] > 0.0
        assert touching.any()
        assert remembered[touching].all()
        assert np.count_nonzero(remembered[~touching]) <= 2
    assert state["tooth_onset_surface"].shape == (38, 2)
    assert isinstance(state["snapshot"], bytes)
    assert len(state["snapshot"]) > 8 * 2 * 2 * 38 * 3


# --- what evaluate says


def test_positions_just_given_have_no_memory(at_end):
    """Without memory and at rest, a force is the elastic one."""
    rest = np.zeros_like(at_end.velocities)
    e = at_end.evaluate(positions=at_end.positions, velocities=rest)
    chain = at_end.drive.chain
    pin, bore = chain.hinge.pin_radius, chain.hinge.bore_radius
    modulus = chain.material.elastic_modulus / (2 * (1 - chain.material.poisson_ratio**2))
    stiffness = 4 / 3 * modulus * math.sqrt(pin * bore / (bore - pin))
    depth = np.maximum(e.hinge_penetration, 0.0)
    assert np.count_nonzero(depth) >= 3
    np.testing.assert_allclose(e.hinge_force, stiffness * depth**1.5, rtol=1e-9)
    np.testing.assert_allclose(
        np.hypot(*e.hinge_force_vector.T), e.hinge_force, rtol=1e-12, atol=1e-12
    )


def test_velocities_alone_keep_the_memory(at_end):
    e = at_end.evaluate(velocities=at_end.velocities)
    np.testing.assert_array_equal(e.accelerations, at_end.evaluate().accelerations)
    fresh = at_end.evaluate(positions=at_end.positions)
    np.testing.assert_array_equal(fresh.hinge_penetration, e.hinge_penetration)
    assert (fresh.hinge_force != e.hinge_force).any()


def test_a_given_time_moves_the_loads_only():
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    early, late = simulation.evaluate(time=0.0), simulation.evaluate(time=0.05)
    pull = 0.5 * 50.0  # half of the ramp
    change = late.accelerations - early.accelerations
    assert change[39, 0] == pytest.approx(pull / 0.817)
    change[39, 0] = 0.0
    assert not change.any()


# --- recording


@pytest.mark.parametrize("energy", [True, False, None])
@pytest.mark.parametrize("record", [(), *[(group,) for group in ALL], ("teeth", "bodies"), ALL])
def test_only_what_is_asked_for_is_recorded(record, energy):
    result = rc.Simulation(rc.paper_drive()).run(2e-4, record=record, energy=energy, progress=False)
    expected = {*record, "energy"} if energy else {*record}
    assert set(result.groups) == (expected - {"energy"} if energy is False else expected)
    first_words = {
        "hinges": {"hinge", "strand", "peak_hinge"},
        "teeth": {"tooth", "peak_tooth"},
        "sprockets": {"sprocket"},
        "bodies": {"positions", "velocities"},
        "energy": {"energy"},
    }
    allowed = ("time", *(word for group in result.groups for word in first_words[group]))
    assert all(name.startswith(allowed) for name in result.arrays)
    assert all(values.shape[0] == 3 for values in result.arrays.values())


def test_one_group_may_be_named_without_a_tuple():
    result = rc.Simulation(rc.paper_drive()).run(2e-4, record="teeth", energy=False, progress=False)
    assert result.groups == ("teeth",)


def test_recorded_values_are_those_of_evaluate():
    simulation = rc.Simulation(rc.paper_drive())
    result = simulation.run(END, record=ALL, progress=False)
    e = simulation.evaluate()
    np.testing.assert_allclose(result.array("hinge_force")[-1], e.hinge_force, rtol=1e-12)
    np.testing.assert_array_equal(result.array("hinge_penetration")[-1], e.hinge_penetration)
    np.testing.assert_array_equal(
        result.array("tooth_penetration")[-1], e.tooth_penetration.max(axis=1)
    )
    np.testing.assert_array_equal(result.array("tooth_force")[-1], e.tooth_force.max(axis=1))
    np.testing.assert_array_equal(result.array("positions")[-1], simulation.positions)
    eccentricity = np.hypot(*result.array("hinge_eccentricity")[-1].T)
    np.testing.assert_allclose(eccentricity - 25e-6, e.hinge_penetration, rtol=0.0, atol=1e-15)


def test_a_run_evaluates_twice_a_step_and_once_a_rejected_one():
    simulation = rc.Simulation(rc.paper_drive())
    stats = simulation.run(END, progress=False).stats
    # One at the start, and one that tests the first step.
    assert stats["evaluations"] == 2 + 2 * stats["steps"] + stats["rejected"]
    assert 0 < stats["onsets_at_minimum_velocity"] < stats["onsets"] < stats["steps"]
    assert all(stats[key] >= 0.0 for key in stats if key.startswith("wall_"))


# --- peaks


@pytest.fixture(scope="module")
def coarse_and_fine():
    """One path, reported every 1e-4 s and every 1e-7 s."""
    return [
        rc.Simulation(rc.paper_drive()).run(END, step, record=("hinges", "teeth"), progress=False)
        for step in (1e-4, 1e-7)
    ]


@pytest.mark.parametrize("kind", ["hinge", "tooth"])
def test_the_impulse_of_an_interval_is_the_integral_of_the_force(kind, coarse_and_fine):
    coarse, fine = coarse_and_fine
    force = fine.array(f"{kind}_force")
    area = np.zeros_like(force)
    area[1:] = np.cumsum(0.5 * np.diff(fine.time)[:, None] * (force[1:] + force[:-1]), axis=0)
    expected = np.diff(area[::1000], axis=0)
    impulse = coarse.array(f"peak_{kind}_impulse")
    assert np.count_nonzero(expected) > 50
    assert not impulse[0].any()
    np.testing.assert_allclose(impulse[1:], expected, rtol=1e-2, atol=3e-3 * expected.max())


@pytest.mark.parametrize("kind", ["hinge", "tooth"])
def test_a_peak_is_the_largest_force_of_its_interval(kind, coarse_and_fine):
    coarse, fine = coarse_and_fine
    peak, sampled = coarse.array(f"peak_{kind}_force"), coarse.array(f"{kind}_force")
    assert not peak[0].any()
    assert (peak[1:] >= sampled[1:]).all()
    assert (peak[1:] >= sampled[:-1]).all()
    links = peak.shape[1]
    force = fine.array(f"{kind}_force")
    largest = np.maximum(force[:-1].reshape(-1, 1000, links).max(axis=1), force[1000::1000])
    np.testing.assert_allclose(peak[1:], largest, rtol=0.02, atol=1e-3 * largest.max())
    # Most impacts are over before the next report.
    assert peak.max() > 1.2 * sampled.max()


# --- motions and loads


# --- the tensioner


# --- given starts


def test_a_start_of_ones_own_goes_the_same_way():
    generated = rc.Simulation(rc.paper_drive())
    own = rc.Simulation(
        rc.paper_drive(),
        positions=generated.positions.tolist(),
        velocities=np.asfortranarray(generated.velocities),
    )
    for simulation in (generated, own):
        simulation.step_to(6e-3)
    assert_same_path(generated, own)


def test_a_start_in_contact_begins_there(at_end):
    simulation = rc.Simulation(
        at_end.drive, positions=at_end.positions, velocities=at_end.velocities
    )
    np.testing.assert_allclose(simulation.positions, at_end.positions, rtol=0.0, atol=1e-17)
    touching = simulation.evaluate().hinge_penetration > 0.0
    np.testing.assert_array_equal(simulation.state()["hinge_onset_speed"] > 0.0, touching)
    assert simulation.time == 0.0
    simulation.step_to(1e-4)


# --- what goes wrong on the way


def test_a_run_that_cannot_go_on_says_when_and_where_and_keeps_its_rows():
    """Surfaces so hard that no step can follow the first contact, between 4 and 4.2 ms."""
    chain = replace(rc.paper_drive().chain, material=rc.Material(elastic_modulus=1e300))
    simulation = rc.Simulation(replace(rc.paper_drive(), chain=chain))
    with pytest.raises(rc.SimulationError, match=r"t = 0\.00") as caught:
        simulation.run(0.01, record=ALL, progress=False)
    error = caught.value
    assert isinstance(error, RuntimeError)
    assert 4.0e-3 <= error.time <= 4.2e-3
    assert 0.0 < error.step_size < 1e-3
    assert isinstance(error.contact, str)
    assert error.result.status == "failed"
    assert not error.result.success
    assert len(error.result.time) >= 40
    assert np.isfinite(error.result.array("positions")).all()


def test_a_failure_names_the_contact_it_happens_in():
    """The first contact of all, with surfaces so hard that no step can follow it."""
    soft = rc.Simulation(rc.paper_drive()).run(
        4.2e-3, 1e-6, record=("teeth", "energy"), progress=False
    )
    touching = soft.array("tooth_force") > 0.0
    row = int(np.argmax(touching.any(axis=1)))
    first, began = int(np.argmax(touching[row])) + 1, soft.time[row]
    chain = replace(rc.paper_drive().chain, material=rc.Material(elastic_modulus=1e300))
    simulation = rc.Simulation(replace(rc.paper_drive(), chain=chain))
    with pytest.raises(rc.SimulationError) as caught:
        simulation.run(6e-3, progress=False)
    error = caught.value
    assert abs(error.time - began) < 2e-6
    assert 0.0 < error.step_size < 1e-15
    assert re.search(rf"bushing {first} on sprocket [12], gap \d+ pressed by", error.contact)
    assert error.contact in str(error)


def test_links_that_are_torn_apart_are_refused():
    calm = rc.Simulation(rc.paper_drive())
    positions = calm.positions.copy()
    positions[16, 1] += 0.01
    with pytest.raises(rc.InvalidInput, match=r"positions = link_16 and link_17: hinge 16 is open"):
        rc.Simulation(rc.paper_drive(), positions=positions, velocities=calm.velocities)


@pytest.mark.parametrize("kind", ["hinge", "tooth"])
def test_peaks_are_the_same_in_one_run_and_in_two(kind):
    """The second run begins inside a step, whose end belongs to its first interval.

    Forces of a step of Newton's method are those before its last correction, those that a
    recording begins with are after it.
    """
    simulation = rc.Simulation(rc.paper_drive())
    parts = [simulation.run(0.01, 1e-3, progress=False).peaks for _ in range(2)]
    whole = rc.Simulation(rc.paper_drive()).run(0.02, 1e-3, progress=False).peaks
    for name, bound in (("impulse", 1e-9), ("force", 1e-4)):
        first, second = (getattr(peaks, f"{kind}_{name}") for peaks in parts)
        joined = np.concatenate([first, second[1:]])
        np.testing.assert_allclose(joined, getattr(whole, f"{kind}_{name}"), rtol=0, atol=bound)


def test_a_second_run_counts_energies_and_steps_from_its_own_start():
    simulation = rc.Simulation(rc.paper_drive())
    first = simulation.run(0.01, 1e-3, progress=False)
    second = simulation.run(0.01, 1e-3, progress=False)
    assert (
        second.energy.dissipated[0]
        == second.energy.external_work[0]
        == second.energy.residual[0]
        == 0
    )
    whole = rc.Simulation(rc.paper_drive()).run(0.02, 1e-3, progress=False)
    assert first.stats["steps"] + second.stats["steps"] == whole.stats["steps"]


def test_tolerances_below_rounding_are_said_so():
    simulation = rc.Simulation(rc.paper_drive(), solver=rc.Solver(rtol=1e-15, atol=1e-17))
    with pytest.raises(rc.SimulationError, match="raise rtol or atol") as caught:
        simulation.run(1e-3, progress=False)
    assert caught.value.time == 0.0
    assert len(caught.value.result.time) == 1


def test_leaving_the_range_of_a_law_warns_once_with_law_pair_and_value():
    drive = rc.two_sprocket_drive(chain="ANSI 160", teeth=(17, 17), links=38)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        simulation = rc.Simulation(drive, rc.EnhancedCylinder())
        simulation.run(1e-3, progress=False)
    assert all(warning.category is rc.RangeWarning for warning in caught)
    messages = [str(warning.message) for warning in caught]
    assert len(messages) == len(set(messages))
    assert all("enhanced" in message for message in messages)
    assert any("working" in message for message in messages)
    assert all(warning.filename == __file__ for warning in caught)
