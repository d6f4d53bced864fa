//! The form f = K δ^n with any exponent: the enhanced cylindrical laws, and the linear one.

use pulp::Simd;

use super::{ElasticLaw, VectorLaw};
use crate::math::simd::{Lanes, exp_of_remainder, nearest_whole, octaves_of_quotient};

/// The power form. Hertz's exponent 1.5 has a form of its own, which needs a square root only.
#[derive(Debug, Clone, Copy)]
pub struct Power;

/// Constants of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerPair {
    /// Force at a penetration of one metre by the power law \[N\]: the stiffness in N/m^n.
    pub stiffness: f64,
    /// Exponent n.
    pub exponent: f64,
}

/// Penetration \[m\] that the vector form measures others by: a power of two near a micrometre.
const REFERENCE: f64 = f64::from_bits((1023 - 20) << 52);

/// Penetration \[m\] below which the vector form gives zero, 2^-600: a law with n >= 1 gives less than 1e-165 N there.
const LEAST: f64 = f64::from_bits((1023 - 600) << 52);

impl ElasticLaw for Power {
    type Pair = PowerPair;

    fn force(pair: &PowerPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        pair.stiffness * penetration.powf(pair.exponent)
    }

    fn stiffness(pair: &PowerPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        pair.exponent * Self::force(pair, penetration) / penetration
    }

    fn energy(pair: &PowerPair, penetration: f64) -> f64 {
        Self::force(pair, penetration) * penetration.max(0.0) / (pair.exponent + 1.0)
    }
}

impl VectorLaw for Power {
    /// The force at 2^-20 m, and n.
    fn constants(pair: &PowerPair) -> [f64; 2] {
        // In two factors: of 2^(-20 n) in one the rounding of 20 n alone would cost 10 units in the last place.
        let whole = (-20.0 * pair.exponent).round();
        let rest = pair.exponent.mul_add(-20.0, -whole);
        [pair.stiffness * rest.exp2() * whole.exp2(), pair.exponent]
    }

    /// From 2^-600 m to 2^600 m to 4 units in the last place; zero below, infinite above.
    ///
    /// With ln(δ/2^-20 m) = k ln 2 + rest the force is that at 2^-20 m times 2^j e^r, where j is whole and
    /// j ln 2 + r = n (k ln 2 + rest). The whole part is taken off before anything is rounded.
    #[inline(always)]
    fn forces<S: Simd>([force, n]: [Lanes<S>; 2], penetration: Lanes<S>) -> Lanes<S> {
        let number = |value| penetration.constant(value);
        let (k, rest) = octaves_of_quotient(penetration, number(REFERENCE));
        // n to 2^-30: its product with k is exact.
        let rounding = number(1.5 * f64::from(1 << 22));
        let head = (n + rounding) - rounding;
        let tail = n - head;
        let within_octave = n * rest;
        let (j, power) =
            nearest_whole(head.mul_add(k, within_octave * number(std::f64::consts::LOG2_E)));
        let ln_2 = number(std::f64::consts::LN_2);
        let r = head
            .mul_add(k, -j)
            .mul_add(ln_2, (tail * k).mul_add(ln_2, within_octave));
        let force = force * exp_of_remainder(r) * power;

        let force = penetration.less(number(LEAST)).select(number(0.0), force);
        let beyond = penetration * number(f64::INFINITY);
        penetration
            .exceeds(number(1.0 / LEAST))
            .select(beyond, force)
    }

    #[inline(always)]
    fn slopes<S: Simd>([_, n]: [Lanes<S>; 2], penetration: Lanes<S>, forces: Lanes<S>) -> Lanes<S> {
        n * forces / penetration.max(penetration.constant(LEAST))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::force_law::testing::for_each_force;
    use crate::force_law::{EnhancedCylinder, SurfacePair};
    use crate::math::simd::testing::ulps;

    fn pair(inner: f64, outer: f64) -> PowerPair {
        EnhancedCylinder::Of2010.prepare(&SurfacePair::internal(
            inner,
            outer,
            0.011,
            2.07e11 / 1.82,
        ))
    }

    #[test]
    fn ends_of_the_range_of_the_vector_form() {
        let pair = pair(2.22e-3, 2.245e-3);
        let zero = [0.0, -0.0, 5e-324, f64::MIN_POSITIVE, LEAST.next_down()];
        for_each_force::<Power>(&pair, &zero, |set, d, force, twin| {
            assert_eq!(force, 0.0, "{set} at {d:e}");
            assert!(twin < 1e-170);
        });
        let beyond = [f64::INFINITY, f64::NAN];
        for_each_force::<Power>(&pair, &beyond, |set, d, force, twin| {
            assert_eq!(ulps(force, twin), 0, "{set} at {d:e}");
        });
        let ends = [
            LEAST,
            1.0 / LEAST,
            REFERENCE,
            0.75 * REFERENCE,
            1.5 * REFERENCE,
        ];
        for_each_force::<Power>(&pair, &ends, |set, d, force, twin| {
            assert!(ulps(force, twin) <= 5, "{set} at {d:e}: {force:e} {twin:e}");
        });
    }

    proptest! {
        #[test]
        fn the_vector_form_is_within_5_units_of_the_twin(
            clearance in 1e-6..1e-2f64,
            exponents in proptest::collection::vec(-12.0..-4.0f64, 64),
            far in proptest::collection::vec(-180.0..180.0f64, 16),
        ) {
            let depths: Vec<f64> = exponents.into_iter().chain(far).map(|e| 10f64.powf(e)).collect();
            let pair = pair(2.22e-3, 2.22e-3 + clearance);
            for_each_force::<Power>(&pair, &depths, |set, d, force, twin| {
                assert!(ulps(force, twin) <= 5, "{set} at {d:e}: {force:e} {twin:e} {pair:?}");
            });
        }
    }

    #[test]
    fn an_exponent_of_one_is_a_straight_line_in_both_forms() {
        let pair = PowerPair {
            stiffness: 3e8,
            exponent: 1.0,
        };
        let depths: Vec<f64> = (-120..-20).map(|e| 1.7f64.powi(e)).collect();
        for_each_force::<Power>(&pair, &depths, |set, d, force, twin| {
            assert_eq!(twin, 3e8 * d);
            assert!(ulps(force, twin) <= 5, "{set} at {d:e}: {force:e} {twin:e}");
        });
    }
}
