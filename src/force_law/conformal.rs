//! Liu's law of a pin in a close bore, f = (π/2) E* L δ sqrt(δ/(2 (ΔR + δ))): the contact arc grows with the penetration.
//!
//! Source: Liu, Zhang and Yang, "The FEM analysis and approximate model for cylindrical joints with clearances", Mechanism and Machine
//! Theory 42 (2007) 183, from a Winkler foundation fitted to finite elements; checked against public code. Penetration and force have no
//! upper limit. With ΔR = `R_i + R_j` the same formula is applied to convex surfaces, as a formal extension.

use super::{Conformity, Definition, ElasticLaw, SurfacePair};
use crate::math::Real;

/// Liu's conformal law. Its constants are π E* L / sqrt(8) \[N/m\], the secant stiffness for δ much larger than ΔR, and ΔR \[m\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Conformal;

/// The law as selected by the user.
pub(super) const LIU_CONFORMAL: Definition = Definition {
    name: "liu-conformal",
    prepare: Conformal::prepare,
    range_note: Conformal::range_note,
};

impl Conformal {
    /// Return stiffness and ΔR of one pair.
    fn prepare(surfaces: &SurfacePair) -> [f64; 2] {
        let stiffness =
            std::f64::consts::PI * surfaces.contact_modulus * surfaces.length / 8.0f64.sqrt();
        [stiffness, surfaces.radius_difference]
    }

    /// Return the reason why the law is outside its range for these surfaces, if it is.
    fn range_note(surfaces: &SurfacePair) -> Option<String> {
        (surfaces.conformity == Conformity::External).then(|| {
            "it is of a cylinder in a bore, here two convex surfaces touch; dR is the sum of their radii"
                .to_string()
        })
    }
}

impl ElasticLaw for Conformal {
    #[inline(always)]
    fn elastic<R: Real>(self, pair: [R; 2], penetration: R) -> R {
        self.elastic_and_root(pair, penetration)[0]
    }

    #[inline(always)]
    fn elastic_and_root<R: Real>(
        self,
        [stiffness, radius_difference]: [R; 2],
        penetration: R,
    ) -> [R; 2] {
        let root = (penetration / (radius_difference + penetration)).sqrt();
        [stiffness * penetration * root, root]
    }

    #[inline(always)]
    fn slope<R: Real>(
        self,
        [stiffness, radius_difference]: [R; 2],
        penetration: R,
        [_, root]: [R; 2],
    ) -> R {
        let share = penetration / (radius_difference + penetration);
        // d/dδ of δ sqrt(s), s = δ/(ΔR + δ), is sqrt(s) (1.5 - 0.5 s).
        let rise = share.negate_mul_add(share.constant(0.5), share.constant(1.5));
        stiffness * root * rise
    }

    fn stored(self, [stiffness, dr]: &[f64; 2], penetration: f64, _force: f64) -> f64 {
        stiffness * dr * dr * integral(penetration / dr)
    }
}

/// Return the integral of `x^1.5 (1 + x)^-0.5` from zero.
fn integral(x: f64) -> f64 {
    if x > 0.1 {
        return (x * (1.0 + x)).sqrt() * (0.5 * x - 0.75) + 0.75 * x.sqrt().asinh();
    }
    // The closed form suffers cancellation for small x; the binomial series has 17 digits after 16 terms.
    let (mut power, mut sum) = (1.0, 0.0);
    for k in 0..16 {
        let k = f64::from(k);
        sum += power / (k + 2.5);
        power *= -x * (k + 0.5) / (k + 1.0);
    }
    x * x * x.sqrt() * sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_law::testing::for_each_force;

    fn pair() -> [f64; 2] {
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
            assert!((Conformal.force(&pair(), d) / printed - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn vectors_have_the_bits_of_the_formula() {
        let depths = [0.0, 5e-324, 1e-310, 1e-12, 2.5e-6, 1e-4, 1e200];
        for_each_force(Conformal, &pair(), &depths, |set, d, force| {
            let [stiffness, dr] = pair();
            let expected = stiffness * d * (d / (dr + d)).sqrt();
            assert_eq!(force.to_bits(), expected.to_bits(), "{set} at {d:e}");
        });
        // The ratio of two infinities is NaN.
        let beyond = [f64::INFINITY, f64::NAN];
        for_each_force(Conformal, &pair(), &beyond, |_, _, force| {
            assert!(force.is_nan());
        });
    }

    #[test]
    fn energy_and_slope_belong_to_the_force() {
        let pair = pair();
        for d in [1e-10, 1e-8, 2.4e-6, 2.6e-6, 1e-5, 1e-4, 1e-3] {
            let h = 1e-4 * d;
            let difference =
                |of: fn(&[f64; 2], f64) -> f64| (of(&pair, d + h) - of(&pair, d - h)) / (2.0 * h);
            let slope =
                difference(|pair, d| Conformal.force(pair, d)) / Conformal.stiffness(&pair, d);
            let power = difference(|pair, d| Conformal.energy(pair, d)) / Conformal.force(&pair, d);
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
