"""Contact of bushings with teeth and of pins with bushings: geometry, before any force."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import EPS, DriveEquations
from reference.geometry import (
    ansi_tooth,
    circle_in_gap,
    circle_on_sprocket,
    pitch_radius,
    point_touching,
)
from rustchain import _rustchain

SEATS = ("pitch-circle", "bottom-diameter")
PITCH, ROLLER = 0.0127, 0.0079375
MM = 1e-3


def test_profile_of_17_teeth_has_the_standards_numbers():
    # ANSI/ASME B29.1 evaluated for N = 17, P = 12.7 mm, Dr = 7.9375 mm; lengths in mm.
    tooth = ansi_tooth(PITCH, 17, ROLLER, "bottom-diameter")
    radii = np.array([tooth.seating, tooth.working, tooth.topping]) / MM
    assert_allclose(radii, [4.026694, 10.376694, 6.582621], atol=6e-7)
    angles = np.degrees([tooth.seating_angle, tooth.flat_angle])
    assert_allclose(angles, [38.529412, 23.823529], atol=6e-7)
    x, y, z = tooth.junctions
    assert_allclose(x / MM, [3.150036, -2.508293], atol=6e-7)
    assert_allclose(y / MM, [4.525004, -0.235846], atol=6e-7)
    assert_allclose(z / MM, [4.901547, 0.616943], atol=6e-7)
    assert_allclose(tooth.working_center / MM, [-4.967532, 3.955518], atol=6e-7)
    assert_allclose(tooth.topping_center / MM, [10.923289, -2.041917], atol=6e-7)
    assert_allclose(np.hypot(*(y - x)) / MM, 2.656041, atol=6e-7)
    assert_allclose(np.hypot(*(z - y)) / MM, 0.932219, atol=6e-7)
    assert_allclose(tooth.seat_radius / MM, 34.615858, atol=6e-7)
    on_circle = ansi_tooth(PITCH, 17, ROLLER, "pitch-circle")
    assert_allclose(on_circle.seat_radius / MM, 34.557914, atol=6e-7)
    assert_allclose(pitch_radius(PITCH, 17) / MM, 69.115828 / 2, atol=6e-7)
    assert_allclose(on_circle.reach(0.5 * ROLLER) / MM, 43.4, atol=0.05)


@pytest.mark.parametrize("teeth", [9, 11, 17, 18, 25, 60, 120])
def test_regions_join_without_a_step_or_a_kink(teeth):
    tooth = ansi_tooth(PITCH, teeth, ROLLER, "bottom-diameter")
    radius = 0.5 * ROLLER
    for region in range(1, 7):
        ends = []
        for name, fraction in ((region, 1.0), (region + 1, 0.0)):
            left = name < 4
            ends.append(point_touching(tooth, name, 1.0 - fraction if left else fraction, radius))
        assert_allclose(ends[0], ends[1], atol=1e-15)
        across = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]) * 1e-10
        around = circle_in_gap(tooth, ends[0] + across, radius)
        assert set(around.region) == {region, region + 1}
        assert np.ptp(around.normal, axis=0).max() < 1e-5
        assert np.abs(around.penetration).max() < 1.1e-10


@pytest.mark.parametrize("region", range(1, 8))
def test_a_circle_that_just_touches_has_no_depth_and_gains_it_along_the_normal(region):
    tooth = ansi_tooth(PITCH, 17, ROLLER, "pitch-circle")
    radius = 0.5 * ROLLER
    points = np.array([point_touching(tooth, region, f, radius) for f in (0.1, 0.5, 0.9)])
    touching = circle_in_gap(tooth, points, radius)
    assert np.all(touching.region == region)
    assert np.abs(touching.penetration).max() < 1e-16
    deeper = circle_in_gap(tooth, points + 1e-6 * touching.normal, radius)
    assert_allclose(deeper.penetration, 1e-6, rtol=1e-9)


def test_the_drawn_outline_lies_on_the_seven_regions(paper):
    for sprocket in paper.sprockets:
        tooth = ansi_tooth(PITCH, sprocket.teeth, ROLLER, sprocket.profile.seat)
        outline = _rustchain.tooth_outline(sprocket, paper.chain, 40)
        tip = 0.5 * PITCH * (0.6 + 1.0 / np.tan(np.pi / sprocket.teeth))
        below = np.hypot(outline[:, 0], outline[:, 1]) < tip - 1e-9
        contact = circle_on_sprocket(tooth, np.zeros(2), 0.0, outline[below], 0.0)
        assert np.all(contact.near)
        assert np.abs(contact.penetration).max() < 1e-15
        assert set(contact.region) == set(range(1, 8))
        assert set(contact.gap) == set(range(sprocket.teeth))
        assert np.hypot(outline[:, 0], outline[:, 1]).max() < tip + 1e-12


@pytest.mark.parametrize("seat", SEATS)
def test_the_states_touch_every_region_and_many_hinges(seat, paper_with_seat, states_with_seat):
    law = rc.LankaraniNikravesh()
    equations = DriveEquations(paper_with_seat(seat), law, law)
    teeth = np.zeros((2, 8), dtype=int)
    hinges = past_johnson = 0
    for positions, velocities in states_with_seat(seat):
        kin = equations.kinematics(positions, velocities)
        for s in range(2):
            on = kin.tooth_penetration[:, s] > 0.0
            teeth[s] += np.bincount(kin.tooth_region[on, s], minlength=8)
        hinges += int(np.sum(kin.hinge_penetration > 0.0))
        past_johnson += int(np.sum(kin.hinge_penetration > 13.6e-6))
    assert len(states_with_seat(seat)) >= 100
    assert np.all(teeth.sum(axis=0)[1:] >= 5), teeth
    assert hinges >= 500
    assert past_johnson >= 1


@pytest.mark.parametrize("seat", SEATS)
def test_penetrations_agree_to_round_off(seat, paper_with_seat, states_with_seat):
    drive = paper_with_seat(seat)
    law = rc.LankaraniNikravesh()
    simulation = rc.Simulation(drive)
    equations = DriveEquations(drive, law, law)
    apart_but_near = far = 0
    for positions, velocities in states_with_seat(seat):
        kin = equations.kinematics(positions, velocities)
        e = simulation.evaluate(positions=positions, velocities=velocities)
        bound = 8.0 * EPS * np.max(np.abs(positions[:, :2]))
        assert_within(e.hinge_penetration, kin.hinge_penetration, bound, "hinge penetration")
        assert_within(e.tooth_penetration, kin.tooth_penetration, bound, "tooth penetration")
        far += int(np.sum(np.isneginf(e.tooth_penetration)))
        apart_but_near += int(np.sum(np.isfinite(e.tooth_penetration) & (e.tooth_penetration < 0)))
        touching = kin.tooth_penetration > bound
        assert np.array_equal(e.tooth_region[touching], kin.tooth_region[touching])
        assert np.array_equal(e.tooth_index[touching], kin.tooth_gap[touching])
    assert apart_but_near > 100
    assert far > 100


def test_a_bushing_out_of_reach_is_nowhere_near(paper):
    # Link 1 (inner) carries bushing 1 at its front and the last one at its rear.
    simulation = rc.Simulation(paper)
    tooth = ansi_tooth(PITCH, 17, ROLLER, "pitch-circle")
    reach = tooth.reach(0.5 * ROLLER)
    for offset, near in ((-1e-9, True), (1e-9, False)):
        positions = simulation.positions.copy()
        positions[0] = [-0.5 * PITCH, reach + offset, 0.0]  # bushing 1 above the driver's centre
        e = simulation.evaluate(positions=positions, velocities=simulation.velocities)
        assert np.isfinite(e.tooth_penetration[0, 0]) == near
        assert np.isneginf(e.tooth_penetration[0, 1])
        assert not np.any(np.isnan(e.tooth_penetration))
        assert not np.any(np.isnan(e.tooth_force))


def test_a_pin_exactly_in_the_middle_of_its_bore_is_no_trouble(paper):
    simulation = rc.Simulation(paper)
    positions = simulation.positions.copy()
    positions[0] = [0.0, 0.0, 0.0]
    positions[1] = [PITCH, 0.0, 0.0]  # front of link 1 and rear of link 2, both at p / 2
    e = simulation.evaluate(positions=positions, velocities=simulation.velocities)
    assert e.hinge_penetration[0] == -(paper.chain.hinge.bore_radius - paper.chain.hinge.pin_radius)
    assert e.hinge_force[0] == 0.0
    assert np.all(np.isfinite(e.accelerations))
