//! Liu's law of a pin in a close bore, f = (π/2) E* L δ sqrt(δ/(2 (ΔR + δ))): the contact's arc grows with its depth.
//!
//! Source: Liu, Zhang and Yang, "The FEM analysis and approximate model for cylindrical joints with clearances", Mechanism and
//! Machine Theory 42 (2007) 183, from a Winkler foundation fitted to finite elements; checked against public code. Depth and
//! force grow together without end. With ΔR = `R_i + R_j` the same formula is used outside, where it is a formality.

use pulp::Simd;

use super::{Conformity, ElasticLaw, SurfacePair, VectorLaw};
use crate::math::simd::Lanes;

/// Liu's conformal law.
#[derive(Debug, Clone, Copy)]
pub struct Conformal;

/// Constants of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConformalPair {
    /// π E* L / sqrt(8) \[N/m\]: the secant's stiffness of a contact much deeper than ΔR.
    pub stiffness: f64,
    /// ΔR \[m\].
    pub radius_difference: f64,
}

impl Conformal {
    /// Stiffness and ΔR of one pair.
    #[must_use]
    pub fn prepare(surfaces: &SurfacePair) -> ConformalPair {
        ConformalPair {
            stiffness: std::f64::consts::PI * surfaces.contact_modulus * surfaces.length
                / 8.0f64.sqrt(),
            radius_difference: surfaces.radius_difference,
        }
    }

    /// Why the law is outside its range for these surfaces, if it is.
    #[must_use]
    pub fn range_note(surfaces: &SurfacePair) -> Option<String> {
        (surfaces.conformity == Conformity::External).then(|| {
            "it is of a cylinder in a bore, here two convex surfaces touch; dR is the sum of their radii"
                .to_string()
        })
    }
}

impl ElasticLaw for Conformal {
    type Pair = ConformalPair;

    fn force(pair: &ConformalPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        let share = penetration / (pair.radius_difference + penetration);
        pair.stiffness * penetration * share.sqrt()
    }

    fn stiffness(pair: &ConformalPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        let share = penetration / (pair.radius_difference + penetration);
        pair.stiffness * share.sqrt() * (1.5 - 0.5 * share)
    }

    fn energy(pair: &ConformalPair, penetration: f64) -> f64 {
        let dr = pair.radius_difference;
        pair.stiffness * dr * dr * integral(penetration.max(0.0) / dr)
    }
}

/// Integral of `x^1.5 (1 + x)^-0.5` from zero.
fn integral(x: f64) -> f64 {
    if x > 0.1 {
        return (x * (1.0 + x)).sqrt() * (0.5 * x - 0.75) + 0.75 * x.sqrt().asinh();
    }
    // The closed form loses what is small; the binomial series has 17 digits after 16 terms.
    let (mut power, mut sum) = (1.0, 0.0);
    for k in 0..16 {
        let k = f64::from(k);
        sum += power / (k + 2.5);
        power *= -x * (k + 0.5) / (k + 1.0);
    }
    x * x * x.sqrt() * sum
}

impl VectorLaw for Conformal {
    fn constants(pair: &ConformalPair) -> [f64; 2] {
        [pair.stiffness, pair.radius_difference]
    }

    #[inline(always)]
    fn forces<S: Simd>(
        [stiffness, radius_difference]: [Lanes<S>; 2],
        penetration: Lanes<S>,
    ) -> Lanes<S> {
        let share = penetration / (radius_difference + penetration);
        stiffness * penetration * share.sqrt()
    }

    #[inline(always)]
    fn slopes<S: Simd>(
        [stiffness, radius_difference]: [Lanes<S>; 2],
        penetration: Lanes<S>,
        _forces: Lanes<S>,
    ) -> Lanes<S> {
        let share = penetration / (radius_difference + penetration);
        let rise = share.negate_mul_add(share.constant(0.5), share.constant(1.5));
        stiffness * share.sqrt() * rise
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_law::testing::for_each_force;

    fn pair() -> ConformalPair {
        Conformal::prepare(&SurfacePair::internal(
            2.22e-3,
            2.245e-3,
            0.011,
            2.07e11 / 1.82,
        ))
    }

    #[test]
    fn the_force_is_the_printed_formula() {
        let (length, modulus, dr) = (0.011, 2.07e11 / 1.82, 2.5e-5);
        for d in [1e-9, 1e-7, 1e-5, 1e-4] {
            let printed =
                0.5 * std::f64::consts::PI * d * modulus * length * f64::sqrt(d / (2.0 * (dr + d)));
            assert!((Conformal::force(&pair(), d) / printed - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_vector_form_has_the_bits_of_the_twin() {
        let depths = [0.0, 5e-324, 1e-310, 1e-12, 2.5e-6, 1e-4, 1e200];
        for_each_force::<Conformal>(&pair(), &depths, |set, d, force, twin| {
            assert_eq!(force.to_bits(), twin.to_bits(), "{set} at {d:e}");
        });
        // A share of infinities is no number, here as in the twin.
        let beyond = [f64::INFINITY, f64::NAN];
        for_each_force::<Conformal>(&pair(), &beyond, |_, _, force, twin| {
            assert!(force.is_nan() && twin.is_nan());
        });
    }

    #[test]
    fn energy_and_slope_belong_to_the_force() {
        let pair = pair();
        for d in [1e-10, 1e-8, 2.4e-6, 2.6e-6, 1e-5, 1e-4, 1e-3] {
            let h = 1e-4 * d;
            let difference = |of: fn(&ConformalPair, f64) -> f64| {
                (of(&pair, d + h) - of(&pair, d - h)) / (2.0 * h)
            };
            let slope = difference(Conformal::force) / Conformal::stiffness(&pair, d);
            let power = difference(Conformal::energy) / Conformal::force(&pair, d);
            assert!((slope - 1.0).abs() < 1e-7, "{d}");
            assert!((power - 1.0).abs() < 1e-7, "{d}");
        }
    }

    #[test]
    fn the_series_of_the_energy_meets_its_closed_form() {
        let (below, above) = (integral(0.1), integral(0.1f64.next_up()));
        assert!((above / below - 1.0).abs() < 1e-13, "{below} {above}");
    }
}
