"""The published case over 2 s: what its figures show, as ranges and quantiles.

The drive is chaotic without pretension, so that no path can be compared beyond 7 ms. As the figures
do, bushings and pins 6 and 11 are sampled every 1e-4 s, at the published tolerances; where a claim
needs more impacts than two bushings have in 2 s, all of them are taken. The comments give what was
measured when the ranges were set.
"""

import numpy as np
import pytest

import rustchain as rc

pytestmark = pytest.mark.slow

SHOWN = (6, 11)
DURATION, REPORT_STEP = 2.0, 1e-4
TEETH, LINKS = 17, 38
CLEARANCE = 25e-6  # [m], of a pin in its bushing
MICRO = 1e-6
PASSAGE = 0.02  # [s] without contact, after which a bushing meets a sprocket anew
PRETENSION = 25.0
RAMPED = 0.11  # [s], when the tensioner pulls fully


def run(law):
    simulation = rc.Simulation(rc.paper_drive(), law)
    return simulation.run(DURATION, REPORT_STEP, progress=False)


@pytest.fixture(scope="module")
def nikravesh():
    return run(rc.LankaraniNikravesh())


@pytest.fixture(scope="module")
def enhanced():
    return run(rc.EnhancedCylinder())


@pytest.fixture(scope="module", params=["nikravesh", "enhanced"])
def either(request):
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="module")
def tensioned():
    simulation = rc.Simulation(rc.paper_drive(pretension=PRETENSION))
    return simulation.run(0.2, REPORT_STEP, progress=False)


def first_impacts(result, number):
    """Largest force [N] in the first 5 ms of a bushing's passages: of the samples, between them."""
    touching = np.flatnonzero(result.bushing(number).tooth_force > 0.0)
    begins = touching[1:][np.diff(result.time[touching]) > PASSAGE]
    sampled, peak = result.array("tooth_force"), result.array("peak_tooth_force")
    rows = [slice(begin, begin + 50) for begin in begins]
    return [(sampled[r, number - 1].max(), peak[r, number - 1].max()) for r in rows]


def loads_by_tooth(result):
    """RMS force [N] on each tooth of both sprockets, over the whole run."""
    force = result.array("tooth_force")
    sprocket, gap = result.array("tooth_sprocket"), result.array("tooth_index")
    return np.array(
        [
            [
                np.sqrt(np.sum(force[(sprocket == s) & (gap == g)] ** 2) / len(force))
                for g in range(TEETH)
            ]
            for s in (1, 2)
        ]
    )


def test_the_run_reaches_its_end(either):
    assert either.success
    assert len(either.time) == 20001


def test_first_impacts_are_tens_of_newtons(either):
    # Bushings 6 and 11, largest of their passages: LN 51 N, enhanced 38 to 108 N.
    shown = np.array([impact for number in SHOWN for impact in first_impacts(either, number)])
    assert len(shown) >= 5
    assert 10.0 <= shown[:, 0].max() <= 200.0
    assert 10.0 <= shown[:, 1].max() <= 300.0
    # All bushings, between the samples too: medians 31 N and 36 N, 0.9 quantiles 68 N and 135 N.
    every = np.array([i for number in range(1, LINKS + 1) for i in first_impacts(either, number)])
    assert len(every) >= 100
    assert 15.0 <= np.median(every[:, 1]) <= 60.0
    assert np.quantile(every[:, 1], 0.9) <= 250.0


def test_later_forces_are_a_few_newtons(either):
    for number in SHOWN:
        force = either.bushing(number).tooth_force
        force = force[force > 0.0]
        assert 0.2 <= np.median(force) <= 3.0  # 0.6
        assert 1.0 <= np.quantile(force, 0.9) <= 10.0  # 2.1 to 2.7
        assert 3.0 <= np.quantile(force, 0.99) <= 25.0  # 5.6 to 10.3


def test_penetration_into_the_teeth_is_up_to_some_micrometres(nikravesh):
    # The largest: 1.3 and 2.3 um.
    depth = np.stack([nikravesh.bushing(number).tooth_penetration for number in SHOWN])
    assert 1.0 * MICRO <= depth.max() <= 5.0 * MICRO
    assert np.quantile(depth[depth > 0.0], 0.999) <= 2.5 * MICRO  # 0.8


def test_pins_press_with_up_to_about_a_hundred_newtons(nikravesh):
    for number in SHOWN:
        hinge = nikravesh.hinge(number)
        assert 25.0 <= hinge.force.max() <= 200.0  # 76 and 50 N
        assert 0.3 * MICRO <= hinge.penetration.max() <= 1.4 * MICRO  # 0.75 and 0.78 um
        assert np.median(hinge.force) <= 5.0  # 1.7 N


@pytest.mark.parametrize("band", [(5.0, 10.0), (10.0, 20.0)])
@pytest.mark.parametrize("kind", ["tooth", "hinge"])
def test_the_enhanced_law_is_stiffer(kind, band, nikravesh, enhanced):
    low, high = band
    depth = []
    for result in (nikravesh, enhanced):
        force = result.array(f"{kind}_force")
        inside = (force > low) & (force < high)
        assert np.count_nonzero(inside) > 100
        depth.append(np.median(result.array(f"{kind}_penetration")[inside]))
    # Teeth: 0.60 against 0.04 um; pins: 0.21 against 0.02 um.
    assert 0.0 < depth[1] < 0.25 * depth[0]


def test_the_enhanced_law_penetrates_by_tenths_of_a_micrometre(enhanced):
    depth = np.stack([enhanced.bushing(number).tooth_penetration for number in SHOWN])
    # The largest value of a chaotic run is itself random: 0.27 to 0.84 um in six replicates.
    assert 0.1 * MICRO <= depth.max() <= 1.2 * MICRO
    assert np.quantile(depth[depth > 0.0], 0.99) <= 0.1 * MICRO  # 0.048 to 0.060 um


def test_the_enhanced_law_takes_more_steps(nikravesh, enhanced):
    # 1.17 and 2.60 million steps.
    assert enhanced.stats["steps"] > 1.3 * nikravesh.stats["steps"]
    assert 2e5 < nikravesh.stats["steps"] < 4e6
    assert enhanced.stats["onsets"] > nikravesh.stats["onsets"]


def test_a_simulated_second_takes_fewer_than_two_million_evaluations(nikravesh):
    stats = nikravesh.stats
    print({name: stats[name] for name in ("steps", "rejected", "evaluations", "onsets")})
    assert stats["evaluations"] / DURATION < 2e6  # measured 1.22e6; at 2.2 us each well below 10 s


def test_many_contacts_begin_slowly(nikravesh):
    share = nikravesh.stats["onsets_at_floor"] / nikravesh.stats["onsets"]
    assert 0.1 <= share <= 0.35  # 0.22


def test_orbits_lie_mostly_near_the_clearance_circle(either):
    for number in SHOWN:
        radius = np.hypot(*either.hinge(number).eccentricity.T) / CLEARANCE
        assert np.mean(radius > 0.9) >= 0.95  # 0.996
        assert np.mean(radius > 0.999) >= 0.8
        assert radius.max() <= 1.1  # 1.03
        # All round the circle, as the hinge opens and folds.
        angle = np.arctan2(*either.hinge(number).eccentricity[:, ::-1].T)
        assert np.ptp(angle) > np.pi


def test_bushings_meet_the_seats_and_both_flanks_below_the_tips(either):
    for number in SHOWN:
        bushing = either.bushing(number)
        regions = np.bincount(bushing.region[bushing.sprocket > 0], minlength=8)
        assert (regions[3:6] > 0.05 * regions.sum()).all()
        assert regions[3:6].sum() > 0.99 * regions.sum()


def test_every_tooth_is_loaded_alike(either):
    # Largest over smallest: LN 1.3, enhanced 1.7; standard deviation over mean: 0.08 and 0.15.
    for loads in loads_by_tooth(either):
        assert loads.max() < 2.5 * loads.min()
        assert loads.std() < 0.3 * loads.mean()


def test_the_driven_sprocket_keeps_up(either):
    speed = either.sprocket(2).speed
    assert speed.mean() == pytest.approx(4 * np.pi, rel=2e-3)
    assert 0.8 < speed.min() / (4 * np.pi) < speed.max() / (4 * np.pi) < 1.2


def test_the_energy_balance_closes(either):
    # 7.9e-5 J and 6.0e-5 J, against 3.0e-2 and 2.8e-2 J dissipated.
    energy = either.energy
    assert 5e-3 < energy.dissipated[-1] < 0.1
    assert (np.diff(energy.dissipated) >= -1e-9).all()
    assert abs(energy.residual).max() < 1e-2 * energy.dissipated[-1]


def test_the_balance_closes_under_pretension(tensioned):
    energy = tensioned.energy
    assert abs(energy.residual).max() < 1e-3 * energy.dissipated[-1]


def test_the_strands_swing_about_the_pretension(tensioned):
    late = tensioned.time > RAMPED
    for name in ("upper", "lower"):
        tension = tensioned.strand(name).tension[late]
        assert tension.mean() == pytest.approx(PRETENSION, rel=0.1)  # 25.1 and 24.8 N
        assert 1.0 < tension.std() < 12.0  # 6.0 N
        assert (tension > 0.0).all()


def test_pretension_keeps_hinges_in_contact(tensioned):
    late = tensioned.time > RAMPED
    force = tensioned.array("hinge_force")[late]
    assert np.mean(force > 0.0) > 0.99
    assert np.quantile(force, 0.99) < 4.0 * PRETENSION


def test_seated_bushings_carry_little(tensioned):
    """The teeth take the tension over from both ends of the wrap; its middle is nearly unloaded."""
    late = tensioned.time > RAMPED
    force = tensioned.array("tooth_force")[late]
    sprocket, gap = tensioned.array("tooth_sprocket")[late], tensioned.array("tooth_index")[late]
    for number, middle in ((1, np.pi), (2, 0.0)):
        angle = tensioned.sprocket(number).angle[late, None] + gap * 2 * np.pi / TEETH - middle
        off = abs(np.degrees(np.angle(np.exp(1j * angle))))
        seated = force[(sprocket == number) & (off < 30.0)]
        entering = force[(sprocket == number) & (off > 60.0) & (off < 90.0)]
        assert seated.mean() < 0.2 * PRETENSION  # 2.6 N
        assert np.quantile(seated, 0.9) < 0.3 * PRETENSION  # 4.1 N
        assert entering.mean() > 2.0 * seated.mean()  # 9.7 N


@pytest.mark.parametrize("pretension", [0.0, PRETENSION])
def test_the_residual_falls_with_the_tolerance(pretension):
    residuals = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        solver = rc.Solver(rtol=tolerance, atol=tolerance)
        simulation = rc.Simulation(rc.paper_drive(pretension), solver=solver)
        energy = simulation.run(0.02, record=("energy",), progress=False).energy
        residuals.append(abs(energy.residual).max() / energy.dissipated[-1])
    # 1.4e-4, 2.8e-5, 1.6e-6 at 0 N; 2.6e-4, 3.4e-5, 1.1e-6 at 25 N.
    assert residuals[0] > 2.0 * residuals[1] > 4.0 * residuals[2], residuals
    assert residuals[0] > 20.0 * residuals[2], residuals
    assert residuals[0] < 1e-2
