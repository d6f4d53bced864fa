"""What is told of guides: where they begin, what they bear, ratchets, hollow faces, pictures."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rustchain as rc


def guided(**of_arm):
    """Two sprockets, a blade that presses the slack lower strand upward, and a rail above."""
    drive = rc.two_sprocket_drive(
        chain="ANSI 40", teeth=(17, 17), links=60, center_distance=0.2715, speed=10.0, torque=-1.0
    )
    arm = rc.GuideArm((0.055, -0.075), **({"force": 40.0, "ramp_time": 2e-3} | of_arm))
    blade = rc.GuideRail((0.136, -0.07), (0.0, 1.0), length=0.12, radius=0.25, arm=arm)
    rail = rc.GuideRail((0.136, 0.0445), (0.0, -1.0), length=0.1)
    return replace(drive, gravity=(0.0, -9.81), guides=[blade, rail])


@pytest.fixture(scope="module")
def result():
    simulation = rc.Simulation(guided(), start="static")
    return simulation.run(
        0.03, 2e-4, record=("hinges", "teeth", "sprockets", "bodies", "energy"), progress=False
    )


def test_check_tells_where_guides_begin():
    drive = guided(travel=(0.01, 0.03))
    report = drive.check()
    assert report.guide_place == ("strand lower", "strand upper")
    assert all(gap > 0.0 for gap in report.guide_gap)
    # 0.1 m of 12.7 mm each.
    assert 7 <= report.guide_bushings[1] <= 9
    # A lever of 81 mm: what the arm has swung, its plunger has gone.
    (back, out), fixed = report.guide_travel
    assert fixed == (0.0, 0.0)
    assert back + out == pytest.approx(0.04)
    assert back - 0.01 == pytest.approx(0.081 * report.guide_turn[0], abs=1e-9)
    table = str(report)
    for row in ("guide ", "gap to the chain [mm]", "bushings along it"):
        assert row in table
    rows = {row[0]: row[1] for row in report.rows()}
    assert rows["plunger to outer stop [mm]"][1] == ""  # the rail has no arm
    assert float(rows["plunger to inner stop [mm]"][0]) == pytest.approx(1e3 * back, abs=1e-3)
    rail = str(replace(drive, guides=drive.guides[1:]).check())
    assert "gap to the chain [mm]" in rail
    assert "plunger" not in rail
    assert "arm swung" not in rail
    assert "guide" not in str(replace(drive, guides=()).check())


def test_guides_in_a_sprocket_or_off_the_chain_are_told():
    inside = rc.SmoothIdler(0.005, (0.2715, 0.01))
    with pytest.raises(rc.InvalidInput, match=r"guide 1 stands in sprocket 2 by \d"):
        replace(guided(), guides=[inside]).check()
    far = replace(guided(), guides=[rc.SmoothIdler(0.01, (0.1, 0.3))])
    (warning,) = (text for text in far.check().warnings if "guide 1" in text)
    assert "it has no contact" in warning


def test_the_load_of_a_guide_is_what_its_bushings_bear(result):
    found = result.guide_loads("guide_1", start=5e-3)
    rows = result.time >= 5e-3 - 1e-12
    wheel, force = result.array("tooth_sprocket")[rows], result.array("tooth_force")[rows]
    np.testing.assert_allclose(found["force"], np.where(wheel == 3, force, 0.0).sum(1))
    # In the mean the chain's moment on the blade is its plunger's, but for its own motion: the
    # bushings press at 81 mm from the pivot, more or less.
    assert 20.0 < found.attrs["mean_force"] < 80.0
    loaded = found["position"].to_numpy()[found["largest"].to_numpy() > 0.0]
    # The arched blade bears within its length of 9.4 pitches.
    assert loaded.size
    assert np.abs(loaded).max() < 6.0
    share = found["bushing_mean"].sum()
    assert float(share) == pytest.approx(found.attrs["mean_force"])
    assert result.guide_loads(2).attrs["guide"] == 2
    with pytest.raises(rc.InvalidInput, match=r"guide = 3: must be the number of a guide, 1 to 2"):
        result.guide_loads(3)
    with pytest.raises(rc.InvalidInput, match="those of guide_loads"):
        result.tooth_loads("guide_1")


def test_engagements_of_a_guide_are_asked_for_by_its_name(result):
    onto = result.engagements("guide_1")
    assert set(onto["sprocket"]) == {3}
    assert set(result.engagements()["sprocket"]) <= {1, 2}
    with pytest.raises(rc.InvalidInput, match="guide = 'guide_7'"):
        result.engagements("guide_7")


def test_figures_of_guides_strands_and_cycles(result):
    loads = result.plot.guide_loads(1, "guide_2")
    for number, (left, right) in enumerate(zip(loads.axes[::2], loads.axes[1::2], strict=True), 1):
        found = result.guide_loads(number)
        assert left.get_ylabel() == f"guide {number}, force of a bushing [N]"
        seen = found.dropna("position", subset=["largest"])
        drawn = {line.get_label(): line.get_xydata().T for line in left.lines}
        for name in ("mean", "largest"):
            np.testing.assert_array_equal(drawn[name], [seen["position"], seen[name]])
        force, mean = (line.get_ydata() for line in right.lines)
        np.testing.assert_array_equal(force, found["force"])
        assert set(mean) == {found.attrs["mean_force"]}
    figures = [
        loads,
        result.plot.strand_motion("lower", "upper"),
        result.plot.pressure_cycles("tooth", bins=10),
        result.plot.pressure_cycles("tooth", 1),
        result.plot.engagements("guide_1"),
    ]
    assert [len(figure.axes) for figure in figures] == [4, 2, 2, 2, 2]
    for figure in figures:
        plt.close(figure)


def test_the_picture_has_arms_and_room_for_guides(result):
    figure = result.plot.drive(0.0)
    plt.close(figure)
    axes = figure.axes[0]
    blade = result.drive.guides[0]
    low, high = axes.get_ylim()
    assert low < blade.arm.pivot[1] < high
    # The arm's bar and the ring round its pivot.
    centers = [
        collection.get_paths()[0].vertices.mean(axis=0)
        for collection in axes.collections
        if len(collection.get_paths()) == 1
    ]
    assert any(np.hypot(*(center - blade.arm.pivot)) < 1e-3 for center in centers)


def test_a_ratchet_holds_a_blade_where_it_has_been():
    paper = rc.paper_drive()
    middle = 0.5 * paper.sprockets[1].center[0]

    def back(ratchet):
        arm = rc.GuideArm((middle - 0.08, -0.075), 40.0, 1e-3, damping=50.0, ratchet=ratchet)
        blade = rc.GuideRail((middle, -0.057), (0.0, 1.0), length=0.12, radius=0.25, arm=arm)
        drive = replace(paper, gravity=(0.0, 0.0), guides=[blade])
        run = rc.Simulation(drive).run(0.019, 2e-4, record=["sprockets", "energy"], progress=False)
        angle = run.guide(1).angle
        return (np.maximum.accumulate(angle) - angle).max()

    # The chain presses it back from where it has drawn it tight: on the rack, by what that gives.
    assert back(0.0) < 0.5 * back(None)
    for drive in (guided(ratchet=1e-3), guided()):
        assert rc.ChainDrive.from_json(drive.to_json()) == drive
    with pytest.raises(rc.InvalidInput, match=r"GuideArm.ratchet = -0.001: must"):
        guided(ratchet=-1e-3)
    with pytest.raises(rc.InvalidInput, match=r"Tensioner.ratchet = -0.001: must"):
        rc.Tensioner(100.0, ratchet=-1e-3)


def test_a_radius_that_cannot_be_is_blamed_and_outlines_take_whole_numbers():
    rail = guided().guides[1]
    for radius in (0.03, -0.03):
        with pytest.raises(rc.InvalidInput, match=rf"GuideRail.radius = {radius}: must be above"):
            replace(rail, radius=radius)
    with pytest.raises(rc.InvalidInput, match=r"GuideRail.end_radius = 0.2: must be below half"):
        replace(rail, end_radius=0.2)
    for points in (-1, 0):
        with pytest.raises(rc.InvalidInput, match=f"points = {points}: must be"):
            rail.outline(points)
    with pytest.raises(rc.InvalidInput, match=r"outline\(points\): got 2\.5; expected a whole num"):
        rail.outline(2.5)


def test_a_hollow_rail_is_hollow_and_says_so_of_its_pressure():
    hollow = rc.GuideRail((0.0, 0.0), (1.0, 0.0), length=0.1, radius=-0.2, end_radius=0.004)
    outline = hollow.outline(200)
    face = outline[(np.abs(outline[:, 1]) < 0.04) & (outline[:, 0] > -0.004)]
    center = np.array([np.sqrt(0.204**2 - 0.046**2), 0.0])
    np.testing.assert_allclose(np.hypot(*(face - center).T), 0.2, rtol=1e-9)
    assert face[:, 0].max() > face[:, 0].min()


def test_plates_need_to_reach_beyond_the_bushings():
    drive = guided()
    low = replace(drive.guides[1], plate_height=0.002)
    with pytest.raises(rc.InvalidInput, match=r"plate_height = 0.002: must be the diameter"):
        replace(drive, guides=[low]).check()
    high = replace(drive.guides[1], center=(0.136, 0.0475), plate_height=0.0116)
    on_bushings = drive.check().guide_gap[1]
    lift = 0.5 * 0.0116 - drive.chain.bushing_radius
    on_plates = replace(drive, guides=[high]).check().guide_gap[0]
    assert on_plates == pytest.approx(on_bushings + 0.003 - lift, abs=1e-9)
