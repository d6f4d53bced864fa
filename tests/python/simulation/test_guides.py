"""Guides from Python: descriptions, names, drawings, and what they do to a drive."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc


def guided(**changes):
    """Two sprockets and a blade that presses the slack lower strand upward."""
    drive = rc.two_sprocket_drive(
        chain="ANSI 40", teeth=(17, 17), links=60, center_distance=0.2715, speed=10.0, torque=-1.0
    )
    arm = rc.GuideArm(pivot=(0.055, -0.075), force=40.0, ramp_time=2e-3)
    blade = rc.GuideRail(
        center=(0.136, -0.07), direction=(0.0, 1.0), length=0.12, radius=0.25, arm=arm
    )
    rail = rc.GuideRail(center=(0.136, 0.0445), direction=(0.0, -1.0), length=0.1)
    return replace(drive, gravity=(0.0, -9.81), guides=[blade, rail], **changes)


def test_guides_are_bodies_with_names_and_channels():
    drive = guided()
    simulation = rc.Simulation(drive)
    assert simulation.body_names[-2:] == ["guide_1", "guide_2"]
    result = simulation.run(0.02, record=["hinges", "teeth", "sprockets", "energy"])
    swung = result.guide(1)
    assert np.ptp(swung.angle) > 1e-3
    assert not np.any(result.guide(2).speed)
    with pytest.raises(IndexError, match="guides are numbered 1 to 2"):
        result.guide(3)
    # Bushings on the blade name it as sprocket 3.
    assert np.any(result.array("tooth_sprocket") == 3)
    assert result.to_xarray().sizes["sprocket"] == 4
    assert result.strand("lower").tension.shape == result.time.shape


def test_at_rest_a_blade_tightens_both_strands():
    loose = replace(guided(), guides=())
    tight = guided()

    def lower(drive):
        still = replace(drive.sprockets[0], motion=rc.PrescribedSpeed(0.0))
        drive = replace(drive, sprockets=(still, drive.sprockets[1]))
        run = rc.Simulation(drive, start="static").run(
            1e-5, report_step=1e-5, record=["hinges", "energy"]
        )
        return run.strand("lower").tension[-1]

    assert lower(tight) > lower(loose) + 10.0


def test_a_blade_stays_at_rest_after_a_static_start():
    """The plunger of the equilibrium pushes with its full force from the beginning of the run."""
    drive = guided()
    still = replace(drive.sprockets[0], motion=rc.PrescribedSpeed(0.0))
    arm = replace(drive.guides[0].arm, ramp_time=0.1)
    guides = (replace(drive.guides[0], arm=arm), drive.guides[1])
    simulation = rc.Simulation(
        replace(drive, sprockets=(still, drive.sprockets[1]), guides=guides), start="static"
    )
    swung = simulation.run(2e-3, 1e-4, record=["sprockets"]).guide(1).angle
    # With a ramp the spring of the strand would turn the arm by milliradians.
    assert np.ptp(swung) < 1e-6


def test_a_drive_with_guides_goes_to_a_file_and_back(tmp_path):
    drive = guided(name="guided")
    assert rc.ChainDrive.from_json(drive.to_json()) == drive
    assert json.loads(drive.to_json())["guides"][0]["arm"]["force"] == 40.0
    simulation = rc.Simulation(drive)
    simulation.step_to(1e-3)
    simulation.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    simulation.step_to(2e-3)
    again.step_to(2e-3)
    assert np.array_equal(simulation.positions, again.positions)
    result = simulation.run(1e-3, record=["bodies", "energy"])
    result.save(tmp_path / "run.nc")
    assert rc.load_result(tmp_path / "run.nc").drive == drive
    figure = result.plot.drive()
    assert figure.axes


def test_an_outline_is_that_of_the_bar():
    straight = rc.GuideRail((0.0, 0.0), (1.0, 0.0), length=0.1, end_radius=0.004).outline(200)
    after = np.roll(straight, -1, axis=0)
    area = 0.5 * np.sum(straight[:, 0] * after[:, 1] - straight[:, 1] * after[:, 0])
    assert area == pytest.approx(0.092 * 0.008 + math.pi * 0.004**2, rel=1e-4)
    wheel = rc.SmoothIdler(0.02, (0.1, 0.0)).outline()
    assert np.hypot(*wheel.T) == pytest.approx(0.02)


REFUSED = {
    "GuideRail.direction": {"direction": (0.0, 0.0)},
    "GuideRail.length": {"length": 0.0},
    "GuideRail.end_radius": {"end_radius": 0.2},
    "GuideArm.pivot": {"arm": rc.GuideArm((0.136, -0.2), 10.0)},
}


@pytest.mark.parametrize("field", REFUSED)
def test_a_guide_that_cannot_be_is_refused_by_name(field):
    rail = guided().guides[0]
    with pytest.raises(ValueError, match=field):
        replace(rail, **REFUSED[field])


@pytest.mark.parametrize("radius", [None, 0.5, -0.5, -0.12, -0.06])
def test_plates_shorten_the_gap_to_a_rail_by_their_height_beyond_the_bushings(radius):
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=60, gravity=(0.0, 0.0))
    center = (0.5 * drive.sprockets[1].center[0], 0.055)
    gaps = [
        replace(
            drive,
            guides=[rc.GuideRail(center, (0.0, -1.0), 0.1, radius=radius, plate_height=height)],
        )
        .check()
        .guide_gap[0]
        for height in (None, 0.012)
    ]
    assert gaps[0] - gaps[1] == pytest.approx(0.006 - drive.chain.contact_radius, abs=1e-9)


@pytest.mark.parametrize("direction", [(-0.0, -1.0), (0.2, -1.0)])
def test_a_rail_in_the_chain_is_refused_with_how_far(direction: tuple[float, float]):
    rail = rc.GuideRail(center=(0.136, 0.04), direction=direction, length=0.1)
    with pytest.raises(rc.InvalidInput) as refused:
        replace(guided(), guides=[rail]).check()
    said = re.fullmatch(
        r"guide 1 overlaps the chain of the initial configuration by [\d.]+ mm; move "
        r"GuideRail\.center = \(0\.136, 0\.04\) m against GuideRail\.direction = \(0(?:\.2)?, -1\) "
        r"by ([\d.]+) mm or more, or give it a GuideRail\.arm, .*",
        str(refused.value),
    )
    assert said, refused.value
    back = 1e-3 * float(said[1]) / np.hypot(*direction)
    x, y = 0.136 - back * direction[0], 0.04 - back * direction[1]
    replace(guided(), guides=[replace(rail, center=(x, y))]).check()


@pytest.mark.parametrize(
    ("radius", "center"),
    [
        *[(radius, (0.12, y)) for radius in (0.01, 0.03, 0.06) for y in (0.05, 0.04)],
        *[(radius, center) for radius in (0.03, 0.06) for center in ((0.13, 0.02), (0.1, -0.06))],
    ],
)
def test_an_idler_in_the_chain_is_refused_with_a_centre_that_is_clear(radius, center):
    drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, 25), links=60, speed=10.0)
    idler = rc.SmoothIdler(radius, center)
    with pytest.raises(rc.InvalidInput) as refused:
        replace(drive, guides=[idler]).check()
    said = re.search(
        r"; move SmoothIdler\.center = \(.*\) m to \((.*), (.*)\) m$", str(refused.value)
    )
    assert said, refused.value
    clear = (float(said[1]), float(said[2]))
    replace(drive, guides=[replace(idler, center=clear)]).check()
    assert math.dist(clear, center) < 2 * radius + 0.02


def test_a_blade_and_an_idler_in_the_chain_are_refused_with_fields_of_their_own():
    arm = rc.GuideArm(pivot=(0.12, -0.052), force=40.0)  # in the strand, and the rail about it
    blade = replace(guided().guides[0], center=(0.136, -0.052), arm=arm)
    with pytest.raises(rc.InvalidInput, match="no rotation of its arm clears it; move GuideRail"):
        replace(guided(), guides=[blade]).check()
    idler = rc.SmoothIdler(0.01, (0.136, 0.04))
    with pytest.raises(rc.InvalidInput, match=r"move SmoothIdler\.center = .* m to \("):
        replace(guided(), guides=[idler]).check()


def test_mechanisms_take_no_guides():
    with pytest.raises(ValueError, match="expected none in a mechanism"):
        guided().to_mechanism()


def test_a_sweep_changes_the_fields_of_guides():
    sweep = rc.sweep(
        guided(),
        {"guides.1.arm.force": [5.0, 50.0]},
        lambda result: {"turned": np.ptp(result.guide(1).angle)},
        duration=2e-3,
        record=["sprockets", "energy"],
    )
    soft, hard = sweep.to_pandas()["turned"]
    assert hard > 2.0 * soft


def test_an_arm_is_not_swung_back_past_its_stop():
    drive = guided()
    blade = drive.guides[0]
    tight = replace(blade, center=(0.136, -0.062), arm=replace(blade.arm, travel=(1e-3, 0.1)))
    said = (
        r"guide 1: .* past its stop at 1\.000 mm; give GuideArm\.travel a first number of at least "
    )
    with pytest.raises(rc.InvalidInput, match=said) as refused:
        rc.Simulation(replace(drive, guides=[tight]))
    number = re.search(said + r"([\d.]+) m, or move GuideRail\.center", str(refused.value))
    assert number
    back = float(number[1])
    loose = replace(tight, arm=replace(blade.arm, travel=(back, 0.1)))
    rc.Simulation(replace(drive, guides=[loose]))
