//! Hertz's law for spheres, f = K δ^1.5 with K = (4/3) E* `sqrt(R_i` `R_j` / ΔR) (paper's Eq. 4 without its damping).

use pulp::Simd;

use super::{ElasticLaw, SurfacePair, VectorLaw};
use crate::math::simd::Lanes;

/// Hertz's law.
#[derive(Debug, Clone, Copy)]
pub struct Hertz;

/// Constants of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzPair {
    /// K \[N/m^1.5\].
    pub stiffness: f64,
}

impl Hertz {
    /// K of one pair.
    #[must_use]
    pub fn prepare(surfaces: &SurfacePair) -> HertzPair {
        HertzPair {
            stiffness: 4.0 / 3.0 * surfaces.contact_modulus * surfaces.effective_radius.sqrt(),
        }
    }
}

impl ElasticLaw for Hertz {
    type Pair = HertzPair;

    fn force(pair: &HertzPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        pair.stiffness * penetration * penetration.sqrt()
    }

    fn stiffness(pair: &HertzPair, penetration: f64) -> f64 {
        1.5 * pair.stiffness * penetration.max(0.0).sqrt()
    }

    fn energy(pair: &HertzPair, penetration: f64) -> f64 {
        0.4 * Self::force(pair, penetration) * penetration.max(0.0)
    }
}

impl VectorLaw for Hertz {
    fn constants(pair: &HertzPair) -> [f64; 2] {
        [pair.stiffness, 0.0]
    }

    #[inline(always)]
    fn forces<S: Simd>([stiffness, _]: [Lanes<S>; 2], penetration: Lanes<S>) -> Lanes<S> {
        stiffness * penetration * penetration.sqrt()
    }

    #[inline(always)]
    fn slopes<S: Simd>(
        [stiffness, _]: [Lanes<S>; 2],
        penetration: Lanes<S>,
        _forces: Lanes<S>,
    ) -> Lanes<S> {
        stiffness * penetration.constant(1.5) * penetration.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_law::testing::for_each_force;

    #[test]
    fn the_vector_form_has_the_bits_of_the_twin() {
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
        for_each_force::<Hertz>(
            &HertzPair { stiffness: 1e10 },
            &depths,
            |set, d, force, twin| {
                assert_eq!(force.to_bits(), twin.to_bits(), "{set} at {d:e}");
            },
        );
        for_each_force::<Hertz>(
            &HertzPair { stiffness: 1e10 },
            &[f64::NAN],
            |_, _, force, _| {
                assert!(force.is_nan());
            },
        );
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
        assert!((pair.stiffness * 10f64.powf(-4.5) - 3.844e5).abs() < 50.0);
        assert!((Hertz::force(&pair, 2.5e-6) - 48.05).abs() < 0.05);
    }

    #[test]
    fn energy_is_the_integral_of_the_force() {
        let pair = HertzPair { stiffness: 1e10 };
        let (d, h) = (2e-6, 1e-9);
        let slope = (Hertz::energy(&pair, d + h) - Hertz::energy(&pair, d - h)) / (2.0 * h);
        assert!((slope / Hertz::force(&pair, d) - 1.0).abs() < 1e-6);
    }
}
