//! Hertz's law for spheres, f = K δ^1.5 with K = (4/3) E* `sqrt(R_i` `R_j` / ΔR) (paper's Eq. 4 without its damping).

use super::{Definition, ElasticLaw, SurfacePair};
use crate::math::Real;

/// Hertz's law; its constants are K \[N/m^1.5\] and zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hertz;

/// The law as selected by the user.
pub(super) const HERTZ: Definition = Definition {
    name: "hertz",
    prepare: Hertz::prepare,
    range_note: |_| None,
};

impl Hertz {
    /// Return K of one pair, and zero.
    fn prepare(surfaces: &SurfacePair) -> [f64; 2] {
        let stiffness = 4.0 / 3.0 * surfaces.contact_modulus * surfaces.effective_radius.sqrt();
        [stiffness, 0.0]
    }
}

impl ElasticLaw for Hertz {
    #[inline(always)]
    fn elastic<R: Real>(self, pair: [R; 2], penetration: R) -> R {
        self.elastic_and_root(pair, penetration)[0]
    }

    #[inline(always)]
    fn elastic_and_root<R: Real>(self, [stiffness, _]: [R; 2], penetration: R) -> [R; 2] {
        let root = penetration.sqrt();
        [stiffness * penetration * root, root]
    }

    #[inline(always)]
    fn slope<R: Real>(self, [stiffness, _]: [R; 2], penetration: R, [_, root]: [R; 2]) -> R {
        stiffness * penetration.constant(1.5) * root
    }

    fn stored(self, _: &[f64; 2], penetration: f64, force: f64) -> f64 {
        0.4 * force * penetration
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_law::testing::for_each_force;

    const PAIR: [f64; 2] = [1e10, 0.0];

    #[test]
    fn vectors_have_the_bits_of_the_printed_formula() {
        let depths = [
            0.0,
            5e-324,
            1e-310,
            1e-12,
            2.5e-6,
            1e-4,
            1e200,
            f64::INFINITY,
        ];
        for_each_force(Hertz, &PAIR, &depths, |set, d, force| {
            let printed = PAIR[0] * d * d.sqrt();
            assert_eq!(force.to_bits(), printed.to_bits(), "{set} at {d:e}");
        });
        for_each_force(Hertz, &PAIR, &[f64::NAN], |_, _, force| {
            assert!(force.is_nan());
        });
    }

    #[test]
    fn bushing_on_the_working_curve_carries_48_newtons_at_2500_nanometres() {
        let modulus = 2.07e11 / (2.0 * (1.0 - 0.09));
        let pair = Hertz::prepare(&SurfacePair::internal(
            3.968_75e-3,
            10.376_694e-3,
            0.007,
            modulus,
        ));
        assert!((pair[0] * 10f64.powf(-4.5) - 3.844e5).abs() < 50.0);
        assert!((Hertz.force(&pair, 2.5e-6) - 48.05).abs() < 0.05);
    }

    #[test]
    fn energy_is_the_integral_of_the_force() {
        let (d, h) = (2e-6, 1e-9);
        let slope = (Hertz.energy(&PAIR, d + h) - Hertz.energy(&PAIR, d - h)) / (2.0 * h);
        assert!((slope / Hertz.force(&PAIR, d) - 1.0).abs() < 1e-6);
    }
}
