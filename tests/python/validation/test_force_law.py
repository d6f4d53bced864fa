"""The laws of force: the reference against hand-evaluated numbers, the simulator against both."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose

import rustchain as rc
from reference import force_law
from reference.force_law import Pair
from rustchain import _rustchain

STEEL = rc.Material(elastic_modulus=2.07e11, poisson_ratio=0.3, restitution=0.71)
MODULUS = 113736263736.26374  # E / (2 (1 - nu^2)) = 2.07e11 / 1.82

PAIRS = {
    "pin in bushing": Pair(True, 2.22e-3, 2.245e-3, 0.011, MODULUS),
    "bushing in seat": Pair(True, 3.96875e-3, 4.02669375e-3, 0.007, MODULUS),
    "bushing on working curve": Pair(True, 3.96875e-3, 10.37669375e-3, 0.007, MODULUS),
    "bushing on topping curve": Pair(False, 3.96875e-3, 6.5826213939641431e-3, 0.007, MODULUS),
}
LAWS = {
    "hertz": rc.Hertz(),
    "johnson": rc.Johnson(),
    "enhanced-cylinder": rc.EnhancedCylinder(damping=None),
    "hertz-cylinder": rc.HertzCylinder(),
    "radzimovsky": rc.Radzimovsky(),
    "esdu-78035": rc.Esdu78035(),
    "liu-conformal": rc.LiuConformal(),
}

# Penetration in um under 1, 50 and 1000 N, evaluated to 40 digits from
#   hertz              (F / K)^(2/3), K = (4 E* / 3) sqrt(R_i R_j / dR)
#   johnson            F / (pi L E*) [ln(4 pi L E* dR / F) - 1]
#   enhanced-cylinder  (F / K)^(1/n) in mm and N/mm^2, K = (a dR + b) L E* / dR
# with E* = 1.1373626e5 N/mm^2 and
#   pin:      dR = 0.025 mm,      L = 11 mm, a = 0.49, b = 0.10, n = 1.26956718194
#   seat:     dR = 0.05794375 mm, L = 7 mm,  a = 0.49, b = 0.10, n = 1.20915895637
#   working:  dR = 6.40794375 mm, L = 7 mm,  a = 0.49, b = 0.10, n = 1.09076436752
#   topping:  dR = 10.551371394 mm (sum),  L = 7 mm,  a = 0.39, b = 0.85, n = 1.094
LOADS = (1.0, 50.0, 1000.0)  # [N]
PENETRATIONS = {
    ("pin in bushing", "hertz"): (0.06019564887185482, 0.8169806487006202, 6.019564887185482),
    ("pin in bushing", "johnson"): (0.003022986794188951, 0.1013836658481544, 1.26548641215923),
    ("pin in bushing", "enhanced-cylinder"): (
        0.004826044496157146,
        0.1051523659691857,
        1.11327219898988,
    ),
    ("bushing in seat", "hertz"): (0.05402270037425432, 0.7332008479595209, 5.402270037425432),
    ("bushing in seat", "johnson"): (0.00490577850173983, 0.1670857233049594, 2.143992187121696),
    ("bushing in seat", "enhanced-cylinder"): (
        0.00682319626988175,
        0.1734091253586372,
        2.065623843378979,
    ),
    ("bushing on working curve", "hertz"): (
        0.1891371556132609,
        2.566986135746439,
        18.91371556132609,
    ),
    ("bushing on working curve", "johnson"): (
        0.006787210530975702,
        0.261157324766753,
        4.025424216357568,
    ),
    ("bushing on working curve", "enhanced-cylinder"): (
        0.007270710125743313,
        0.2625261903554192,
        4.09205726013384,
    ),
    ("bushing on topping curve", "hertz"): (
        0.2599323305688484,
        3.527824486093264,
        25.99323305688484,
    ),
    ("bushing on topping curve", "johnson"): (
        0.006986602498639651,
        0.2711269231499504,
        4.224816184021517,
    ),
    ("bushing on topping curve", "enhanced-cylinder"): (
        0.008040668356711587,
        0.2872639875835513,
        4.44142667957892,
    ),
}


def compiled_force(law: rc.ForceLaw, pair: Pair, penetration: np.ndarray) -> np.ndarray:
    kind = "internal" if pair.inside else "external"
    return _rustchain.law_force(
        law,
        kind,
        pair.radius_i,
        pair.radius_j,
        pair.length,
        STEEL,
        np.ascontiguousarray(penetration, dtype=float),
    )


def reference_force(name: str, pair: Pair, penetration: np.ndarray) -> np.ndarray:
    return force_law.elastic(name, pair, penetration).force


@pytest.mark.parametrize(("pair", "law"), PENETRATIONS)
def test_both_sides_give_the_hand_evaluated_loads(pair, law):
    penetration = 1e-6 * np.array(PENETRATIONS[pair, law])
    assert_allclose(reference_force(law, PAIRS[pair], penetration), LOADS, rtol=1e-11)
    assert_allclose(compiled_force(LAWS[law], PAIRS[pair], penetration), LOADS, rtol=1e-11)


def test_published_figures_come_out():
    # Pereira et al., Fig. 6: 48 N at 2.5 um on the working curve; K = 3.844e5 N/mm^1.5.
    working = PAIRS["bushing on working curve"]
    for force in (
        reference_force("hertz", working, np.array([2.5e-6])),
        compiled_force(rc.Hertz(), working, np.array([2.5e-6])),
    ):
        assert_allclose(force, 48.05, atol=0.01)
    # N/mm^1.5 for N = 17: seat 2.52e6, working 3.84e5, topping 2.39e5; the flat is sqrt(R_i) alone.
    per_mm = 1e-3**1.5
    flat = Pair(False, 3.96875e-3, 6.5826e-3, 0.007, MODULUS, flat=True)
    measured = [
        force_law.hertz_stiffness(pair) * per_mm
        for pair in (PAIRS["bushing in seat"], working, flat, PAIRS["bushing on topping curve"])
    ]
    assert_allclose(measured, [2.52e6, 3.84e5, 3.02e5, 2.39e5], rtol=3e-3)
    # Johnson ends at 13.5 um and 53 kN for the pin in its bushing.
    end = force_law.johnson_end(PAIRS["pin in bushing"])
    assert_allclose(end, (13.533528e-6, 53.192763e3), rtol=1e-7)
    # Exponents of the enhanced law.
    exponents = [
        force_law.enhanced_cylinder_constants(pair)[1]
        for pair in (PAIRS["pin in bushing"], working)
    ]
    assert_allclose(exponents, [1.2696, 1.0908], atol=5e-5)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("pair", PAIRS)
def test_the_simulator_follows_the_reference_over_ten_decades(pair, law):
    penetration = np.geomspace(1e-14, 1e-4, 401)
    expected = reference_force(law, PAIRS[pair], penetration)
    if (
        law in force_law.LOGARITHMS
    ):  # ill-conditioned at the end: tested with the error's own measure
        end = force_law.logarithmic_end(law, PAIRS[pair])
        keep = np.abs(penetration / end - 1.0) > 1e-3
        penetration, expected = penetration[keep], expected[keep]
    assert_allclose(compiled_force(LAWS[law], PAIRS[pair], penetration), expected, rtol=1e-12)


@pytest.mark.parametrize("dr", [5.001e-6, 2.5e-5, 7.4999e-4, 7.5001e-4, 9.99e-3, 1.001e-2, 2.0e-2])
def test_the_enhanced_law_follows_its_fit_on_both_sides_of_every_seam(dr):
    pair = Pair(True, 0.05, 0.05 + dr, 0.007, MODULUS)
    penetration = np.array([1e-8, 1e-6, 1e-5])
    assert_allclose(
        compiled_force(rc.EnhancedCylinder(), pair, penetration),
        reference_force("enhanced-cylinder", pair, penetration),
        rtol=1e-11,
    )


@pytest.mark.parametrize("pair", PAIRS)
def test_johnson_is_inverted_to_1e_12_up_to_its_end(pair):
    end, _ = force_law.johnson_end(PAIRS[pair])
    fractions = np.concatenate([np.geomspace(1e-12, 0.5, 60), np.linspace(0.5, 0.9999, 60)])
    penetration = fractions * end
    force = compiled_force(rc.Johnson(), PAIRS[pair], penetration)
    assert_allclose(force_law.johnson_penetration(PAIRS[pair], force), penetration, rtol=1e-12)
    # Against the lower Lambert branch with forty digits.
    with mpmath.workdps(40):
        dr = mpmath.mpf(PAIRS[pair].radius_difference)
        line = mpmath.pi * mpmath.mpf(PAIRS[pair].length) * mpmath.mpf(MODULUS)
        exact = [
            float(
                4
                * line
                * dr
                / mpmath.e
                * mpmath.exp(mpmath.lambertw(-d * mpmath.e / (4 * dr), -1)).real
            )
            for d in map(mpmath.mpf, penetration)
        ]
    assert_allclose(force, exact, rtol=1e-12)


@pytest.mark.parametrize("pair", PAIRS)
def test_johnson_is_inverted_up_to_0_9999_of_the_force_at_its_end(pair):
    end, end_force = force_law.johnson_end(PAIRS[pair])
    fractions = np.array([0.9, 0.99, 0.999, 0.9999])
    penetration = force_law.johnson_penetration(PAIRS[pair], fractions * end_force)
    force = compiled_force(rc.Johnson(), PAIRS[pair], penetration)
    # d(penetration)/d(force) falls to -ln(fraction) of the secant: rounding of the penetration,
    # a few eps, comes back divided by it.
    rounding = 8.0 * np.finfo(float).eps / -np.log(fractions)
    assert np.all(np.abs(force / (fractions * end_force) - 1.0) <= 1e-12 + rounding)
    assert np.all(penetration < end)


@pytest.mark.parametrize("pair", PAIRS)
def test_johnson_goes_on_past_its_end_with_the_secant(pair):
    end, end_force = force_law.johnson_end(PAIRS[pair])
    beyond = np.array([1.0 + 1e-9, 1.01, 2.0, 10.0])
    expected = end_force * beyond
    assert_allclose(reference_force("johnson", PAIRS[pair], beyond * end), expected, rtol=1e-12)
    assert_allclose(compiled_force(rc.Johnson(), PAIRS[pair], beyond * end), expected, rtol=1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("pair", PAIRS)
def test_the_force_is_continuous_where_contact_begins(pair, law):
    apart = np.array([-1.0, -1e-6, -1e-300, -0.0, 0.0])
    assert np.all(compiled_force(LAWS[law], PAIRS[pair], apart) == 0.0)
    barely = np.geomspace(1e-300, 1e-9, 300)
    force = compiled_force(LAWS[law], PAIRS[pair], barely)
    assert np.all(np.isfinite(force))
    assert np.all(np.diff(force) >= 0.0)
    assert force[0] == pytest.approx(0.0, abs=1e-280)
    # No law is stiffer at the first touch than a line of contact: f <= 4 E* L d.
    limit = 4.0 * MODULUS * PAIRS[pair].length * barely
    assert np.all(force <= limit)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("pair", PAIRS)
def test_derivative_and_energy_of_the_reference_belong_to_its_force(pair, law):
    depth = np.array([1e-8, 1e-7, 1e-6, 5e-6])
    if law in force_law.LOGARITHMS:
        end = force_law.logarithmic_end(law, PAIRS[pair])
        depth = np.append(depth, [0.9 * end, 1.5 * end])
    step = 1e-5 * depth
    low = force_law.elastic(law, PAIRS[pair], depth - step)
    high = force_law.elastic(law, PAIRS[pair], depth + step)
    middle = force_law.elastic(law, PAIRS[pair], depth)
    assert_allclose((high.force - low.force) / (2.0 * step), middle.stiffness, rtol=1e-6)
    assert_allclose((high.energy - low.energy) / (2.0 * step), middle.force, rtol=1e-6)


def test_damping_multiplies_and_never_pulls():
    part = force_law.elastic("hertz", PAIRS["pin in bushing"], np.full(4, 1e-6))
    factor = force_law.lankarani_nikravesh_factor(0.71)
    assert factor == pytest.approx(0.371925)  # 0.75 (1 - 0.71^2)
    rate = np.array([0.2, 0.0, -0.2, -0.6])  # 1 + 0.371925 rate / 0.2
    damped = force_law.damped(part, factor, rate, np.full(4, 0.2))
    assert_allclose(damped.force / part.force, [1.371925, 1.0, 0.628075, 0.0], rtol=1e-13)
