//! The enhanced cylindrical law f = (a ΔR + b) L E*/ΔR δ^n of Pereira, Ramalho and Ambrósio (paper's Eq. 6).
//!
//! Fitted in millimetres and N/mm²; converted here, once, so that the run stays in SI.

use super::{Conformity, ElasticLaw, SurfacePair};

/// The enhanced cylindrical law.
#[derive(Debug, Clone, Copy)]
pub struct EnhancedCylinder;

/// Constants of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnhancedCylinderPair {
    /// Force at a penetration of one metre by the power law \[N\]: the stiffness in N/m^n.
    pub stiffness: f64,
    /// Exponent n.
    pub exponent: f64,
}

/// Range of ΔR \[mm\] in which the internal exponent was fitted.
const INTERNAL_RANGE: (f64, f64) = (0.005, 10.0);

const METRE: f64 = 1e3; // in mm
const PASCAL: f64 = 1e-6; // in N/mm²

/// Exponent n of an internal contact, ΔR in mm, held at the ends of its range.
fn internal_exponent(radius_difference: f64) -> f64 {
    let dr = radius_difference.clamp(INTERNAL_RANGE.0, INTERNAL_RANGE.1);
    let y = if dr < 0.75 {
        1.56 * (1000.0 * dr).ln().powf(-0.192)
    } else {
        0.0028 * dr + 1.083
    };
    y * radius_difference.powf(-0.005)
}

impl ElasticLaw for EnhancedCylinder {
    type Pair = EnhancedCylinderPair;

    fn prepare(surfaces: &SurfacePair) -> EnhancedCylinderPair {
        let dr = surfaces.radius_difference * METRE;
        let (a, b, exponent) = match surfaces.conformity {
            Conformity::External => (0.39, 0.85, 1.094),
            Conformity::Internal => (0.49, 0.10, internal_exponent(dr)),
        };
        let stiffness =
            (a * dr + b) * (surfaces.length * METRE) * (surfaces.contact_modulus * PASCAL) / dr;
        EnhancedCylinderPair {
            stiffness: stiffness * METRE.powf(exponent),
            exponent,
        }
    }

    fn force(pair: &EnhancedCylinderPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        pair.stiffness * penetration.powf(pair.exponent)
    }

    fn energy(pair: &EnhancedCylinderPair, penetration: f64) -> f64 {
        Self::force(pair, penetration) * penetration.max(0.0) / (pair.exponent + 1.0)
    }

    fn range_note(surfaces: &SurfacePair) -> Option<String> {
        let dr = surfaces.radius_difference * METRE;
        let (from, to) = INTERNAL_RANGE;
        (surfaces.conformity == Conformity::Internal && !(from..=to).contains(&dr)).then(|| {
            format!(
                "its exponent was fitted for an internal contact with {from} mm <= dR <= {to} mm, here dR = {dr:.4} mm; \
                 Y is held at the end of the range"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_of_the_paper_s_pairs() {
        assert!((internal_exponent(0.025) - 1.2696).abs() < 5e-5);
        assert!((internal_exponent(6.408) - 1.0908).abs() < 5e-5);
    }

    #[test]
    fn pin_in_bushing_carries_50_newtons_at_0_1052_micrometres() {
        let pair = EnhancedCylinder::prepare(&SurfacePair::internal(
            2.22e-3,
            2.245e-3,
            0.011,
            2.07e11 / 1.82,
        ));
        let penetration = (50.0 / pair.stiffness).powf(1.0 / pair.exponent);
        assert!((penetration - 0.1052e-6).abs() < 5e-11);
        assert!((EnhancedCylinder::force(&pair, penetration) - 50.0).abs() < 1e-9);
    }
}
