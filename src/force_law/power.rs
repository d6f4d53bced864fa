//! The form f = K δ^n with any exponent: the enhanced cylindrical laws and the linear law.

use super::ElasticLaw;
use crate::math::simd::{exp_of_remainder, octaves_of_quotient};
use crate::math::{Real, Truth};

/// The power form; its constants are the force at 2^-20 m \[N\], and n. Hertz's exponent 1.5 has a separate form, which requires only a
/// square root.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Power;

/// Reference penetration \[m\]: a power of two near a micrometre.
const REFERENCE: f64 = f64::from_bits((1023 - 20) << 52);

/// Penetration \[m\] below which the force is zero, 2^-600: a law with n >= 1 gives less than 1e-165 N there.
const LEAST: f64 = f64::from_bits((1023 - 600) << 52);

impl Power {
    /// Return the constants of K δ^n, K in N/m^n.
    pub(super) fn constants(stiffness: f64, exponent: f64) -> [f64; 2] {
        // 2^(-20 n) is computed as two factors: in a single one, the rounding of 20 n alone would cost 10 units in the last place.
        let whole = (-20.0 * exponent).round();
        let rest = exponent.mul_add(-20.0, -whole);
        [stiffness * rest.exp2() * whole.exp2(), exponent]
    }
}

impl ElasticLaw for Power {
    /// Return the force to 4 units in the last place from 2^-600 m to 2^600 m; zero below, infinite above.
    ///
    /// With ln(δ/2^-20 m) = k ln 2 + rest, the force is that at 2^-20 m times 2^j e^r, where j is an integer and j ln 2 + r = n (k ln 2 +
    /// rest). The integer part is subtracted before any rounding.
    #[inline(always)]
    fn elastic<R: Real>(self, [force, n]: [R; 2], penetration: R) -> R {
        let number = |value| penetration.constant(value);
        let (k, rest) = octaves_of_quotient(penetration, number(REFERENCE));
        // The head of n has a resolution of 2^-30: its product with k is exact.
        let rounding = number(1.5 * f64::from(1 << 22));
        let head = (n + rounding) - rounding;
        let tail = n - head;
        let within_octave = n * rest;
        let (j, power) = head
            .mul_add(k, within_octave * number(std::f64::consts::LOG2_E))
            .nearest_whole();
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
    fn slope<R: Real>(self, [_, n]: [R; 2], penetration: R, [force, _]: [R; 2]) -> R {
        n * force / penetration.max(penetration.constant(LEAST))
    }

    fn stored(self, [_, n]: &[f64; 2], penetration: f64, force: f64) -> f64 {
        force * penetration / (n + 1.0)
    }

    /// Return the force; a linear law requires no power.
    fn force(self, pair: &[f64; 2], penetration: f64) -> f64 {
        let [reference, n] = *pair;
        if penetration <= 0.0 {
            0.0
        } else if n == 1.0 {
            reference * (penetration / REFERENCE)
        } else {
            self.elastic(*pair, penetration)
        }
    }

    /// Return the slope from that force.
    fn stiffness(self, pair: &[f64; 2], penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        let force = self.force(pair, penetration);
        self.slope(*pair, penetration, [force; 2])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::force_law::SurfacePair;
    use crate::force_law::enhanced_cylinder::EnhancedCylinder;
    use crate::force_law::testing::for_each_force;
    use crate::math::simd::testing::ulps;

    /// K and n of a pin in a bore with this difference of the radii.
    fn pair(clearance: f64) -> [f64; 2] {
        let surfaces = SurfacePair::internal(2.22e-3, 2.22e-3 + clearance, 0.011, 2.07e11 / 1.82);
        EnhancedCylinder::Of2010.stiffness_and_exponent(&surfaces)
    }

    /// Assert that the force of K and n is K δ^n, to 5 units in the last place.
    fn assert_near_printed([stiffness, n]: [f64; 2], depths: &[f64]) {
        let pair = Power::constants(stiffness, n);
        for_each_force(Power, &pair, depths, |set, d, force| {
            let printed = stiffness * d.powf(n);
            assert!(
                ulps(force, printed) <= 5,
                "{set} at {d:e}: {force:e} {printed:e}"
            );
        });
    }

    #[test]
    fn ends_of_the_range() {
        let [stiffness, n] = pair(25e-6);
        let constants = Power::constants(stiffness, n);
        let zero = [0.0, -0.0, 5e-324, f64::MIN_POSITIVE, LEAST.next_down()];
        for_each_force(Power, &constants, &zero, |set, d, force| {
            assert_eq!(force, 0.0, "{set} at {d:e}");
            assert!(stiffness * d.powf(n) < 1e-170);
        });
        for_each_force(Power, &constants, &[f64::INFINITY], |set, _, force| {
            assert_eq!(force, f64::INFINITY, "{set}");
        });
        for_each_force(Power, &constants, &[f64::NAN], |set, _, force| {
            assert!(force.is_nan(), "{set}");
        });
        let ends = [
            LEAST,
            1.0 / LEAST,
            REFERENCE,
            0.75 * REFERENCE,
            1.5 * REFERENCE,
        ];
        assert_near_printed([stiffness, n], &ends);
    }

    proptest! {
        #[test]
        fn vectors_are_within_5_units_of_the_printed_law(
            clearance in 1e-6..1e-2f64,
            exponents in proptest::collection::vec(-12.0..-4.0f64, 64),
            far in proptest::collection::vec(-180.0..180.0f64, 16),
        ) {
            let depths: Vec<f64> = exponents.into_iter().chain(far).map(|e| 10f64.powf(e)).collect();
            assert_near_printed(pair(clearance), &depths);
        }
    }

    #[test]
    fn an_exponent_of_one_is_a_straight_line() {
        let depths: Vec<f64> = (-120..-20).map(|e| 1.7f64.powi(e)).collect();
        assert_near_printed([3e8, 1.0], &depths);
        for d in depths {
            assert_eq!(Power.force(&Power::constants(3e8, 1.0), d), 3e8 * d);
        }
    }
}
