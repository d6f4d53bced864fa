"""Contact force of every kind of guide and tooth form against its law, surface by surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from reference import force_law
from rustchain import _rustchain

# Loads come from a gravity far above the usual one.
pytestmark = pytest.mark.filterwarnings("ignore:gravity = ")

# Without damping the force is that of the elastic part, K d^1.5.
STEEL = rc.Material(restitution=1.0)
BRONZE = rc.Material(elastic_modulus=1.0e11, poisson_ratio=0.34, restitution=1.0)
CHAIN = replace(rc.catalogue_chain("ANSI 40", 60), material=STEEL)
RADIUS, LENGTH = CHAIN.bushing_radius, CHAIN.tooth_contact_length
LOW = (0.136, -0.08)

# Guides, to be raised to the lower strand of `level`, with the radii of their surfaces: positive
# where hollow, negative where round, infinite where straight, as `tooth_radii` gives them.
GUIDES = {
    "fixed idler": (rc.SmoothIdler(0.02, LOW), [-0.02]),
    "turning idler": (rc.SmoothIdler(0.02, LOW, inertia=1e-5), [-0.02]),
    "bronze idler": (rc.SmoothIdler(0.02, LOW, material=BRONZE), [-0.02]),
    "idler under plates": (rc.SmoothIdler(0.018, LOW, plate_height=0.0116), [-0.018]),
    "straight rail": (
        rc.GuideRail(LOW, (0.0, 1.0), 0.1, end_radius=0.005),
        [np.inf, -0.005],
    ),
    "arched rail": (
        rc.GuideRail(LOW, (0.0, 1.0), 0.1, radius=0.3, end_radius=0.005),
        [-0.3, -0.005],
    ),
    "hollow rail": (
        rc.GuideRail(LOW, (0.0, 1.0), 0.1, radius=-0.3, end_radius=0.005),
        [0.3, -0.005, np.inf],
    ),
    "blade": (
        rc.GuideRail(
            LOW,
            (0.0, 1.0),
            0.12,
            radius=0.25,
            end_radius=0.006,
            arm=rc.GuideArm(pivot=(0.055, -0.085), force=40.0, ramp_time=2e-3),
        ),
        [-0.25, -0.006],
    ),
}

ONE_ARC = rc.CustomTooth(
    [rc.ToothArc((0.0, 0.0305), (0.0051, 0.0356), (0.0, 0.0356))], tip_diameter=0.069
)
FORMS = {
    "ansi": rc.AnsiTooth(),
    "cut ansi": rc.AnsiTooth(tip="cut"),
    "iso": rc.IsoTooth(0.5),
    "straight": rc.StraightTooth(0.4),
    "one arc, cut": ONE_ARC,
}


def level(guides=(), profile=None):
    """Two sprockets of 17 teeth on a level, almost taut, under a hundredfold gravity."""
    drive = rc.two_sprocket_drive(
        chain=CHAIN, teeth=(17, 17), links=60, center_distance=0.27304, speed=20.0, torque=-1.0
    )
    sprockets = drive.sprockets
    if profile is not None:
        sprockets = tuple(replace(each, profile=profile) for each in sprockets)
    drive = replace(drive, sprockets=sprockets, guides=guides, gravity=(0.0, -981.0))
    for _ in range(3 if guides else 0):
        (x, y), gap = drive.guides[0].center, drive.check().guide_gap[0]
        raised = replace(drive.guides[0], center=(x, y + gap - 5e-6))
        drive = replace(drive, guides=(raised, *drive.guides[1:]))
    return drive


def stiffnesses(radii, radius, other=STEEL):
    """K [N/m^1.5] of a cylinder on surfaces of the given radii."""
    compliance = [(1.0 - m.poisson_ratio**2) / m.elastic_modulus for m in (STEEL, other)]
    pairs = (
        force_law.Pair(r > 0.0, radius, abs(r), LENGTH, 1.0 / sum(compliance), bool(np.isinf(r)))
        for r in radii
    )
    return np.array([force_law.hertz_stiffness(pair) for pair in pairs])


def dropped(profile):
    """A chain that falls on the tips of a sprocket that is turned by half a gap."""
    ends = [rc.FreeEnd((-0.1, 0.01)), rc.FreeEnd((0.1, 0.01))]
    sprocket = rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(0.0), profile=profile)
    drive = rc.open_chain(CHAIN, ends, 18, [sprocket])
    laid = rc.Simulation(drive)
    positions, velocities = laid.positions.copy(), laid.velocities.copy()
    away = np.sign(positions[9, 1])
    positions[:18, 1] += away * 0.01
    velocities[:18, 1] = -2.0 * away
    positions[-1, 2] += np.pi / 17
    return rc.Simulation(drive, positions=positions, velocities=velocities)


def assert_law_holds(simulation, wheel, expected, times):
    """Hold the forces on a sprocket or guide (from 0) against those of the surfaces at onset."""
    before = np.zeros(simulation.evaluate().tooth_force.shape[0], bool)
    count = 0
    for time in times:
        simulation.step_to(time)
        state, found = simulation.state(), simulation.evaluate()
        depth = found.tooth_penetration[:, wheel]
        live = (depth > 0.0) & (state["tooth_onset_speed"][:, wheel] > 0.0)
        surface = state["tooth_onset_surface"][live, wheel]
        assert np.all(surface < len(expected))
        law = expected[surface] * depth[live] ** 1.5
        np.testing.assert_allclose(found.tooth_force[live, wheel], law, rtol=1e-12)
        # A contact that has just begun is still on the surface on which it began, or on the next.
        here = np.abs(found.tooth_region[live, wheel] - len(expected))
        new = ~before[live]
        assert np.all(np.abs(surface[new] - here[new]) <= 1)
        before = live
        count += np.count_nonzero(live)
    assert count > 20


@pytest.mark.parametrize("kind", GUIDES)
def test_a_guide_bears_by_the_law_of_its_own_surfaces(kind):
    guide, radii = GUIDES[kind]
    radius = RADIUS if guide.plate_height is None else 0.5 * guide.plate_height
    expected = stiffnesses(radii, radius, guide.material or STEEL)
    assert_law_holds(rc.Simulation(level([guide])), 2, expected, np.arange(1, 501) * 4e-5)


@pytest.mark.parametrize("form", FORMS)
def test_teeth_bear_by_the_law_of_their_own_surfaces(form):
    simulation = rc.Simulation(level(profile=FORMS[form]))
    radii = _rustchain.tooth_radii(simulation.drive.sprockets[1], CHAIN)
    times = np.arange(1, 501) * 4e-5
    assert_law_holds(simulation, 1, stiffnesses(radii, RADIUS), times)


@pytest.mark.parametrize("form", FORMS)
def test_tips_bear_by_the_law_of_their_own_surfaces(form):
    simulation = dropped(FORMS[form])
    radii = _rustchain.tooth_radii(simulation.drive.sprockets[0], CHAIN)
    times = np.arange(1, 1201) * 1e-5
    assert_law_holds(simulation, 0, stiffnesses(radii, RADIUS), times)


def test_what_bears_on_an_idler_does_not_depend_on_other_guides():
    idler = GUIDES["fixed idler"][0]
    rail = rc.GuideRail((0.136, -1.0), (0.0, 1.0), 0.1, material=BRONZE)
    runs = [
        rc.Simulation(level([idler, *others])).run(0.02, report_step=1e-4)
        for others in ([], [rail, rail], [replace(rail, material=STEEL)] * 2)
    ]
    first, *others = (run.array("tooth_penetration") for run in runs)
    assert np.any(first > 0.0)
    for other in others:
        assert np.array_equal(first, other)
