"""Open chains from Python: against the NumPy reference, their results, files and messages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import rustchain as rc
from reference.compare import assert_within
from reference.open_chain import OpenChainEquations

LN = rc.LankaraniNikravesh()
CHAIN = rc.paper_drive().chain


def hoist(links=40, motion=None, **ends):
    """Return a chain over a wheel of 17 teeth, slack on its left and a load on its right."""
    anchor = rc.AnchoredEnd((-0.12, -0.05), links=14)
    load = rc.LoadedEnd(3.0, 1e-3, arm=0.04)
    wheel = rc.Sprocket(17, motion=motion or rc.PrescribedSpeed(0.0))
    return rc.open_chain(CHAIN, (ends.get("first", anchor), ends.get("last", load)), links, [wheel])


def strand(links=20, first=None, last=None):
    """Return a chain between two ends, by default two anchors 180 mm apart."""
    ends = (first or rc.AnchoredEnd((0.0, 0.0)), last or rc.AnchoredEnd((0.18, 0.02)))
    return rc.open_chain(CHAIN, ends, links)


def elastic(drive, stiffness):
    """Return the same with links of this axial stiffness."""
    return replace(drive, chain=replace(drive.chain, link_stiffness=stiffness))


SCENES = {
    "anchors": strand(),
    "odd": strand(21),
    "load": strand(15, last=rc.LoadedEnd(0.7, 1e-4, arm=0.02)),
    "loose": strand(14, last=rc.FreeEnd()),
    "loose and odd": strand(15, last=rc.FreeEnd()),
    "moved": strand(16, first=rc.AnchoredEnd((0.0, 0.0), [(0.0, 0.1, 0.0), (0.1, -0.3, 0.2)])),
    "hoist": hoist(),
    "odd hoist": hoist(41, rc.AppliedTorque(1.0)),
    "elastic": elastic(strand(15, last=rc.LoadedEnd(0.7, 1e-4, arm=0.02)), 2e8),
    "elastic hoist": elastic(hoist(), rc.Plates(3.7e-5, 3.2e-5)),
    "loose on a wheel": hoist(46, first=rc.FreeEnd(), last=rc.LoadedEnd(1.0, 1e-4, links=8)),
}


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("law", [LN, rc.Johnson(), rc.LiuConformal(damping="flores")])
@pytest.mark.filterwarnings("ignore::rustchain.RangeWarning")
def test_forces_and_accelerations_agree_to_round_off(scene, law):
    drive = SCENES[scene]
    simulation = rc.Simulation(drive, force_law=law)
    equations = OpenChainEquations(drive, law, law)
    generator = np.random.default_rng(7)
    still = [body for body, _ in equations.held]
    pushed = 0
    for shake in (1e-5, 3e-5, 1e-4, 3e-4, 1e-3) * 4:
        unit = np.array([1.0, 1.0, 1.0 / CHAIN.pitch])
        noise = generator.uniform(-1.0, 1.0, (2, *simulation.positions.shape)) * unit
        positions = simulation.positions + shake * noise[0]
        velocities = simulation.velocities + 0.3 * noise[1]
        velocities[still] = simulation.velocities[still]
        if drive.sprockets:
            positions[-1, :2] = simulation.positions[-1, :2]
            velocities[-1] = simulation.velocities[-1]
        expected = equations.evaluate(positions, velocities, 0.04)
        e = simulation.evaluate(positions=positions, velocities=velocities, time=0.04)
        assert_within(e.hinge_force, expected.hinge_force, expected.hinge_force_bound, "hinges")
        assert_within(e.tooth_force, expected.tooth_force, expected.tooth_force_bound, "teeth")
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        pushed += int(np.sum(expected.hinge_force > 0.0))
    assert pushed > 60


def test_a_hanging_chain_pulls_on_its_ends_with_its_weight():
    drive = strand()
    simulation = rc.Simulation(drive, start="static")
    assert simulation.rest["residual"] < 1e-6
    result = simulation.run(duration=1e-3, report_step=1e-4)
    first, last = result.end(1), result.end(2)
    links = [CHAIN.inner.mass if i % 2 == 0 else CHAIN.outer.mass for i in range(20)]
    assert_allclose(first.force[0] + last.force[0], [0.0, -9.81 * sum(links)], atol=2e-6)
    assert_allclose(first.position, [[0.0, 0.0]] * 11, atol=1e-15)
    assert_allclose(last.velocity, 0.0, atol=1e-15)
    assert result.strand_names == ("end_1-end_2",)
    assert_allclose(result.hinge(20).force[0], np.hypot(*last.force[0]), rtol=1e-12)
    assert not result.hinge(21).force.any()
    assert_allclose(result.hinge(22).force[0], np.hypot(*first.force[0]), rtol=1e-12)
    with pytest.raises(IndexError, match="hinges are numbered 1 to 22"):
        result.hinge(23)
    with pytest.raises(IndexError, match="ends are numbered 1 to 2"):
        result.end(3)
    assert simulation.body_names[-2:] == ["end_2", "end_1"]


@pytest.mark.parametrize("mass", [10.0, 18.9, 30.0])
def test_a_load_comes_to_rest_on_teeth_that_push_the_free_strand(mass):
    # On the way there links bear compression: the stiffness is indefinite.
    profile = rc.IsoTooth(gap=0.3484, seat="pitch-circle")
    sprocket = rc.Sprocket(12, (0.0, 0.0), rc.PrescribedSpeed(0.0), profile=profile)
    drive = rc.open_chain("ANSI 40", (rc.LoadedEnd(mass), rc.FreeEnd(links=18)), 55, [sprocket])
    simulation = rc.Simulation(drive, start="static")
    assert simulation.rest["residual"] < 1e-5
    force = simulation.evaluate().hinge_force
    # The load hangs on the last hinge; the next ones towards the sprocket bear a link more each.
    assert_allclose(force[-1], 9.81 * mass, rtol=1e-6)
    inner, outer = drive.chain.inner.mass, drive.chain.outer.mass
    weights = 9.81 * np.array([inner, outer, inner])
    assert_allclose(np.diff(force[[-1, 0, 1, 2]]), weights, rtol=1e-3)


def test_results_and_states_of_open_chains_go_through_files(tmp_path):
    drive = hoist(motion=rc.PrescribedSpeed([(0.0, 0.0), (0.05, 5.0)]))
    simulation = rc.Simulation(drive, start="static")
    record = ("hinges", "teeth", "sprockets", "bodies", "energy")
    result = simulation.run(duration=4e-3, report_step=1e-3, record=record)
    result.save(tmp_path / "run.nc")
    again = rc.load_result(tmp_path / "run.nc")
    assert again.drive == drive
    assert_allclose(again.end(2).force, result.end(2).force)
    assert list(again.to_xarray()["end"].values) == [1, 2]
    assert result.strand("1-end_2").tension[0] > 0.9 * 3.0 * 9.81
    result.plot.drive(time=1.0)
    result.plot.tension()
    simulation.save_state(tmp_path / "state.npz")
    other = rc.Simulation.load_state(tmp_path / "state.npz")
    for each in (simulation, other):
        each.step_to(6e-3)
    assert (simulation.positions == other.positions).all()


def test_a_drive_file_describes_an_open_chain(tmp_path):
    path = tmp_path / "hoist.toml"
    path.write_text(
        """
        [drive]
        type = "open_chain"
        chain = "ANSI 40"
        links = 40
        ends = [
            { type = "AnchoredEnd", position = [-0.12, -0.05], links = 14 },
            { type = "LoadedEnd", mass = 3.0 },
        ]
        sprockets = [{ teeth = 17, motion = { type = "PrescribedSpeed", speed = 0.0 } }]
        [simulation]
        start = "static"
        [run]
        duration = 1e-3
        """
    )
    scene = rc.load_scene(path)
    assert scene.drive.ends[1] == rc.LoadedEnd(3.0)
    assert "end_1-1" in str(scene.drive.check())


def test_a_sweep_takes_fields_of_the_ends():
    sweep = rc.sweep(
        rc.Scene(strand(8, last=rc.LoadedEnd(0.5)), start="static"),
        {"ends.2.mass": [0.5, 2.0]},
        lambda result: {"pull": -result.end(1).force[0, 1]},
        duration=1e-4,
    )
    weight = 9.81 * (4 * (CHAIN.inner.mass + CHAIN.outer.mass) + np.array([0.5, 2.0]))
    assert_allclose(sweep.to_pandas()["pull"], weight, rtol=1e-6)


def test_check_tells_how_an_open_chain_lies():
    report = hoist().check()
    assert report.strands == ("end_1-1", "1-end_2")
    assert report.strand_pitches[0] == 14
    assert sum(report.strand_pitches) + sum(report.wrap_pitches) == 40
    assert "end_1-1" in str(report)
    assert "sprocket" not in str(strand().check())


def test_the_report_of_an_open_chain_leaves_out_what_it_does_not_have(tmp_path):
    """A gap to teeth, a ratio of speeds; the sag over a span of zero between ends at one point."""
    report = strand().check()
    assert "smallest gap" not in str(report)
    assert "smallest gap at the start" in str(hoist().check())
    for fewer in (report, hoist().check()):
        with pytest.raises(rc.InvalidInput, match=r"speed_ratio: got \d sprockets?; expected two"):
            _ = fewer.speed_ratio
    folded = rc.open_chain("ANSI 40", 2 * [rc.AnchoredEnd((0.0, 0.0))], links=40)
    rows = dict(folded.check().rows())
    assert (rows["span [mm]"], rows["sag [% of span]"]) == (("0.0000",), ("",))
    assert "sag" in folded._repr_html_()
    result = rc.Simulation(folded).run(1e-4, progress=False)
    result.report(tmp_path / "report.html")


def test_a_strand_between_coincident_ends_has_the_sag_of_nearly_coincident_ones():
    def sag(distance):
        ends = rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((distance, 0.0))
        return rc.open_chain("ANSI 40", ends, 6).check().sag[0]

    # Three links hang down, three lead up.
    assert sag(0.0) == pytest.approx(3.0 * 0.0127, rel=1e-9)
    assert sag(1e-12) == pytest.approx(3.0 * 0.0127, rel=1e-9)


def test_what_an_open_chain_cannot_be_is_refused():
    with pytest.raises(rc.InvalidInput, match=r"24 links would do"):
        strand(10, last=rc.AnchoredEnd((0.3, 0.0))).check()
    with pytest.raises(rc.InvalidInput, match=r"ChainDrive\.ends = .*must be None, or two of"):
        replace(strand(), ends=(rc.FreeEnd(),))
    with pytest.raises(rc.InvalidInput, match=r"LoadedEnd\.mass = 0"):
        rc.LoadedEnd(0.0)
    with pytest.raises(rc.InvalidInput, match=r"AnchoredEnd\.velocity = .*each row must be"):
        rc.AnchoredEnd((0.0, 0.0), [(0.0, 1.0)])
    with pytest.raises(rc.InvalidInput, match=r"AnchoredEnd\.velocity = 0 s after 1 s"):
        rc.AnchoredEnd((0.0, 0.0), [(1.0, 0.0, 0.0), (0.0, 0.0, 0.0)])
    with pytest.raises(rc.InvalidInput, match=r"AnchoredEnd\.velocity = NaN"):
        rc.AnchoredEnd((0.0, 0.0), (float("nan"), 0.0))
    with pytest.raises(rc.InvalidInput, match=r"ChainDrive\.ends\.2 = 3: must be an AnchoredEnd"):
        replace(strand(), ends=(rc.FreeEnd(), 3))
    with pytest.raises(rc.InvalidInput, match=r"FreeEnd\.links = 0"):
        rc.FreeEnd(links=0)
    with pytest.raises(rc.InvalidInput, match="cannot be a mechanism"):
        strand().to_mechanism()
    result = rc.Simulation(strand()).run(
        duration=1e-4, report_step=1e-4, record=("hinges", "teeth", "sprockets", "bodies", "energy")
    )
    for output in (result.hinge_loads, result.link_tension):
        with pytest.raises(rc.InvalidInput, match=r"ChainDrive\.ends"):
            output()
    velocities = np.array(rc.Simulation(strand()).velocities)
    velocities[-1, 0] = 1.0
    with pytest.raises(rc.InvalidInput, match="its velocity is prescribed"):
        rc.Simulation(strand(), velocities=velocities)


def test_links_may_carry_masses():
    carried = [(2, 0.5), (7, 1.5)]
    drive = strand(8, last=rc.LoadedEnd(2.0))
    loaded = replace(drive, chain=replace(drive.chain, carried=carried))
    simulation = rc.Simulation(loaded, start="static")
    still = simulation.evaluate(velocities=np.zeros_like(simulation.velocities))
    weights = [CHAIN.inner.mass, CHAIN.outer.mass] * 4
    for link, mass in carried:
        weights[link - 1] += mass
    below = 9.81 * (2.0 + np.cumsum(weights[::-1])[::-1])
    assert_allclose(still.hinge_force[-1], below[0], rtol=1e-6)
    assert_allclose(still.hinge_force[:8], [*below[1:], 9.81 * 2.0], rtol=1e-6)
    with pytest.raises(rc.InvalidInput, match=r"Chain\.carried = 9: .*1 to 8"):
        replace(drive.chain, carried=[(9, 1.0)])
    with pytest.raises(rc.InvalidInput, match=r"Chain\.carried = 2: .*once"):
        replace(drive.chain, carried=[(2, 1.0), (2, 1.0)])
    with pytest.raises(rc.InvalidInput, match=r"Chain\.carried \(mass\) = -1"):
        replace(drive.chain, carried=[(2, -1.0)])


def test_a_closed_chain_carries_what_its_links_carry():
    drive = rc.paper_drive()
    loaded = replace(drive, chain=replace(drive.chain, carried=[(3, 0.25)]))
    plain, heavy = (rc.Simulation(each).evaluate() for each in (drive, loaded))
    assert_allclose(heavy.accelerations[:, :2], plain.accelerations[:, :2], atol=1e-12)
    runs = [rc.Simulation(each).run(1e-4, progress=False) for each in (drive, loaded)]
    light, full = (run.energy.gravity[0] for run in runs)
    height = rc.Simulation(drive).positions[2, 1]
    assert_allclose(full - light, 0.25 * 9.81 * height, rtol=1e-12)


def test_rollers_of_an_open_chain_are_bodies():
    chain = rc.catalogue_chain("ANSI 40", 40, rollers="bodies")
    drive = rc.open_chain(
        "ANSI 40",
        (rc.AnchoredEnd((-0.12, -0.05), links=14), rc.LoadedEnd(3.0)),
        40,
        [rc.Sprocket(17, motion=rc.PrescribedSpeed(0.0))],
        rollers="bodies",
    )
    # At the default accuracy the seated rollers chatter at 1e-9 J, of which the run warns.
    simulation = rc.Simulation(drive, start="static", solver=rc.Solver(accuracy=1e-11))
    names = simulation.body_names
    assert names.index("roller_1") == 42
    assert "roller_42" in names
    assert names[-1] == "sprocket_1"
    record = ("hinges", "teeth", "sprockets", "bodies", "energy")
    result = simulation.run(0.01, 1e-4, record=record, progress=False)
    # The load bears 3 kg, and the chain with all of its rollers hangs above it.
    assert_allclose(result.end(2).force[0, 1], 9.81 * 3.0 + 9.81 * chain.roller.mass, rtol=1e-4)
    assert result.roller(41).force.max() == 0.0
    assert result.roller(20).force.max() > 0.0
    seated = result.bushing(20).tooth_force.max()
    assert seated > 0.0
    lost = abs(result.energy.residual[-1])
    assert lost < 1e-2 * (result.energy.dissipated[-1] + 1e-4)


@pytest.mark.parametrize("rollers", ["fixed", "bodies"])
def test_a_tensioner_between_anchors_gives_the_tension_asked_for(rollers):
    drive = rc.open_chain(
        "ANSI 40",
        (rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((0.36, 0.0))),
        44,
        [rc.Sprocket(15, (0.1, 0.12)), rc.Sprocket(17, (0.25, 0.12))],
        gravity=(0.0, 0.0),
        tensioner=rc.Tensioner(80.0, sprocket=2),
        rollers=rollers,
    )
    assert drive.check().tension_force > 0.0
    simulation = rc.Simulation(drive, start="static")
    result = simulation.run(1e-4, 1e-4, progress=False)
    for name in result.strand_names:
        assert result.strand(name).tension[0] == pytest.approx(80.0, abs=4.0)


def test_a_slack_side_that_is_too_light_is_refused_with_what_it_lacks():
    drive = rc.open_chain(
        "ANSI 40",
        (rc.AnchoredEnd((-0.12, -0.05), links=16), rc.LoadedEnd(60.0)),
        40,
        [rc.Sprocket(17, motion=rc.PrescribedSpeed(0.0))],
    )
    # A load has no place at an anchored end.
    lack = r"end 1 weighs 1\.\d+ N.*58\d\.\d N at end 2.*hang more links at end 1"
    with pytest.raises(rc.InvalidInput, match=lack):
        rc.Simulation(drive, start="static")


def test_a_hoist_has_pressures_and_key_figures():
    drive = rc.open_chain(
        "ANSI 40",
        (rc.AnchoredEnd((-0.16, -0.02), links=30), rc.LoadedEnd(10.0, arm=0.08)),
        60,
        [rc.Sprocket(17, motion=rc.PrescribedSpeed(0.0))],
    )
    result = rc.Simulation(drive, start="static").run(2e-3, 1e-4, progress=False)
    for contact, part in (("hinge", "hinge"), ("tooth", "bushing")):
        pressure = result.contact_pressure(contact)
        force = result.array(f"{contact}_force")
        assert dict(pressure.sizes) == {"time": len(result.time), part: force.shape[1]}
        assert np.array_equal(pressure["pressure"] > 0.0, force > 0.0)
    figures = result.summary()
    assert figures["tension_1-end_2"] == pytest.approx(98.1, abs=3.0)
    assert figures["tooth_force_largest"] > 0.0


PITCH = 0.0127


@pytest.mark.parametrize(
    "solver",
    [
        rc.Solver(rtol=1e-10, atol=1e-12),
        rc.Solver(method="pece", rtol=1e-10, atol=1e-12),
        rc.Solver(method="newton", rtol=1e-10, atol=1e-12),
        rc.Solver(max_step=5e-11),
        rc.Solver(),
    ],
    ids=lambda solver: f"{solver.method} {solver.rtol} {solver.max_step}",
)
def test_a_free_wheel_beside_an_anchor_at_rest_turns_as_the_exact_curve(solver):
    # Nothing touches it: J dw/dt = 2 (1 - w/50) about w = 0, by the torque's curve.
    place = (-6 * PITCH, -2 * PITCH)
    torque = rc.AppliedTorque(1.5, [(-50.0, 2.0), (50.0, -2.0)])
    drive = rc.open_chain(
        "ANSI 40",
        ends=(rc.AnchoredEnd(place), rc.FreeEnd()),
        links=40,
        sprockets=[rc.Sprocket(9, (0.0, 0.0), torque)],
    )
    simulation = rc.Simulation(drive, solver=solver)
    wheel = simulation.body_names.index("sprocket_1")
    inertia = 1.5 / simulation.evaluate().accelerations[wheel, 2]
    end = 2e-8 if solver.max_step < 1e-9 else 2e-6
    simulation.step_to(end)
    exact = 37.5 * -np.expm1(-0.04 / inertia * end)
    assert_allclose(simulation.velocities[wheel, 2], exact, rtol=1e-9)


def test_rows_that_change_nothing_of_an_anchor_change_nothing_of_the_chain():
    def run(rows):
        drive = rc.open_chain(
            "ANSI 25",
            ends=(rc.AnchoredEnd((-0.04, -0.01), velocity=rows), rc.LoadedEnd(20.0)),
            links=30,
            sprockets=[rc.Sprocket(12, (0.0, 0.0), rc.AppliedTorque(-5.0))],
        )
        solver = rc.Solver(method="pece", rtol=1e-9, atol=1e-11)
        simulation = rc.Simulation(drive, solver=solver, start="generated")
        simulation.step_to(1.5e-4)
        return simulation

    still = run((0.0, 0.0))
    moved = run([(1e-4 * k, 0.0, 0.0) for k in range(3)])
    assert_allclose(moved.positions, still.positions, atol=1e-8)
    assert_allclose(moved.velocities[:, :2], still.velocities[:, :2], atol=1e-3)


@pytest.mark.parametrize("share", [1e-9, 1e-3, 0.2])
def test_a_taut_open_chain_takes_a_spread_and_shorter_links_into_its_clearances(share):
    chain = rc.catalogue_chain("ANSI 40", 20)
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((20 * chain.pitch, 0.0)))
    deviation = share * chain.hinge.clearance / chain.pitch
    for seed in range(10):
        for elongation in (-deviation, 0.0, deviation):
            worn = replace(chain, pitch_spread=deviation, elongation=elongation, seed=seed)
            drive = rc.open_chain(worn, ends, 20)
            assert drive.check().hinge_stretch < 0.9 * chain.hinge.clearance
            assert np.max(rc.Simulation(drive).evaluate().hinge_penetration) < 0.0


def test_an_open_chain_shorter_than_its_clearances_give_is_refused():
    chain = rc.catalogue_chain("ANSI 40", 20)
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((20 * chain.pitch, 0.0)))
    worn = replace(chain, elongation=-1.1 * chain.hinge.clearance / chain.pitch)
    with pytest.raises(rc.InvalidInput, match="it is too short: 20 links reach"):
        rc.open_chain(worn, ends, 20).check()


def test_fewer_links_than_a_chain_needs_are_refused_with_what_takes_them():
    for links in (1, 2, 3):
        ends = (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd())
        with pytest.raises(rc.InvalidInput, match=r"between 4 and 100000; .* of a Mechanism"):
            rc.open_chain("ANSI 40", ends, links)


def test_the_place_of_a_guide_beside_an_open_chain_is_the_strand_that_is_nearest_to_it():
    rail = rc.GuideRail((0.05, -0.3), (0.0, 1.0), 0.2)
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((0.09, 0.0)))
    assert rc.open_chain("ANSI 40", ends, 8, guides=[rail]).check().guide_place == (
        "strand end_1-end_2",
    )
    ends = (rc.AnchoredEnd((-0.2, -0.3)), rc.AnchoredEnd((0.2, -0.3)))
    beside = [rc.GuideRail((x, -0.25), (1.0, 0.0), 0.05) for x in (-0.23, 0.23)]
    drive = rc.open_chain("ANSI 40", ends, 64, [rc.Sprocket(17, (0.0, 0.0))], guides=beside)
    assert drive.check().guide_place == ("strand end_1-1", "strand 1-end_2")


@pytest.mark.parametrize("rows", [((0.0, 0.0), (0.5, 0.2)), [(0.0, 0.0), (0.2, 0.1), (0.5, 0.2)]])
def test_each_part_of_the_velocity_of_an_end_may_be_rows(rows):
    anchor = rc.AnchoredEnd((0.0, 0.0), velocity=(rows, 0.0))
    drive = rc.open_chain("ANSI 40", (anchor, rc.FreeEnd()), links=4)
    table = rc.AnchoredEnd((0.0, 0.0), velocity=(rc.Table(rows), 0.0))
    same = rc.open_chain("ANSI 40", (table, rc.FreeEnd()), links=4)
    found, expected = (rc.Simulation(each).run(5e-3, progress=False) for each in (drive, same))
    assert_array_equal(found.array("hinge_force"), expected.array("hinge_force"))
