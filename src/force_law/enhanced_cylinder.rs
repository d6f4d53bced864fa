//! The enhanced cylindrical law f = (a ΔR + b) L E*/ΔR δ^n of Pereira, Ramalho and Ambrósio, with both sets of coefficients.
//!
//! Sources: Pereira, Ramalho and Ambrósio, ECCM 2010 (Eq. 6); Pereira, Ramalho and Ambrósio, "An enhanced cylindrical contact force model",
//! Multibody System Dynamics 35 (2015) 277, whose internal coefficients are taken from two secondary sources that agree. The coefficients
//! were fitted in mm and N/mm². They are converted to SI units once, here.

use super::{Conformity, Definition, Power, SurfacePair};

/// The enhanced cylindrical law; the sets differ for internal contact only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EnhancedCylinder {
    /// Coefficients of the conference paper.
    Of2010,
    /// Coefficients of the journal paper.
    Of2015,
}

/// Range of ΔR \[mm\] in which the internal exponents were fitted.
const INTERNAL_RANGE: (f64, f64) = (0.005, 10.0);

/// The law with the coefficients of 2010.
pub(super) const ENHANCED_CYLINDER: Definition = Definition {
    name: "enhanced-cylinder",
    prepare: |surfaces| EnhancedCylinder::Of2010.prepare(surfaces),
    range_note: EnhancedCylinder::range_note,
};

/// The law with the coefficients of 2015.
pub(super) const ENHANCED_CYLINDER_2015: Definition = Definition {
    name: "enhanced-cylinder-2015",
    prepare: |surfaces| EnhancedCylinder::Of2015.prepare(surfaces),
    range_note: EnhancedCylinder::range_note,
};

const METRE: f64 = 1e3; // in mm
const PASCAL: f64 = 1e-6; // in N/mm²

impl EnhancedCylinder {
    fn prepare(self, surfaces: &SurfacePair) -> [f64; 2] {
        let [stiffness, exponent] = self.stiffness_and_exponent(surfaces);
        Power::constants(stiffness, exponent)
    }

    /// Return K \[N/m^n\] and n of one pair.
    pub(super) fn stiffness_and_exponent(self, surfaces: &SurfacePair) -> [f64; 2] {
        let dr = surfaces.radius_difference * METRE;
        let (a, b, exponent) = match (surfaces.conformity, self) {
            (Conformity::External, _) => (0.39, 0.85, 1.094),
            (Conformity::Internal, Self::Of2010) => (0.49, 0.10, self.internal_exponent(dr)),
            (Conformity::Internal, Self::Of2015) => (0.965, 0.0965, self.internal_exponent(dr)),
        };
        let stiffness =
            (a * dr + b) * (surfaces.length * METRE) * (surfaces.contact_modulus * PASCAL) / dr;
        [stiffness * METRE.powf(exponent), exponent]
    }

    /// Return the exponent n of an internal contact, ΔR in mm; the factor Y is constant outside its fitted range.
    fn internal_exponent(self, radius_difference: f64) -> f64 {
        let dr = radius_difference.clamp(INTERNAL_RANGE.0, INTERNAL_RANGE.1);
        let logarithm = (1000.0 * dr).ln();
        let y = match self {
            Self::Of2010 if dr < 0.75 => 1.56 * logarithm.powf(-0.192),
            Self::Of2010 => 0.0028 * dr + 1.083,
            Self::Of2015 if dr < 0.349_54 => 1.51 * logarithm.powf(-0.151),
            Self::Of2015 => 0.0151 * dr + 1.151,
        };
        y * radius_difference.powf(-0.005)
    }

    /// Return the reason why the law is outside its range for these surfaces, if it is.
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
    use crate::force_law::ElasticLaw;

    const MODULUS: f64 = 2.07e11 / 1.82;

    #[test]
    fn exponents_of_the_paper_s_pairs() {
        let law = EnhancedCylinder::Of2010;
        assert!((law.internal_exponent(0.025) - 1.2696).abs() < 5e-5);
        assert!((law.internal_exponent(6.408) - 1.0908).abs() < 5e-5);
    }

    #[test]
    fn penetrations_of_the_published_drive_at_50_newtons() {
        let pin = SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, MODULUS);
        let working = SurfacePair::internal(3.968_75e-3, 10.376_694e-3, 0.007, MODULUS);
        for (law, surfaces, micrometres) in [
            (EnhancedCylinder::Of2010, pin, 0.1052),
            (EnhancedCylinder::Of2010, working, 0.2625),
            (EnhancedCylinder::Of2015, pin, 0.1143),
            (EnhancedCylinder::Of2015, working, 0.4055),
        ] {
            let [stiffness, exponent] = law.stiffness_and_exponent(&surfaces);
            let penetration = (50.0 / stiffness).powf(1.0 / exponent);
            let pair = law.prepare(&surfaces);
            assert!((penetration * 1e6 - micrometres).abs() < 5e-5, "{law:?}");
            assert!((Power.force(&pair, penetration) - 50.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_pieces_of_both_exponents_join() {
        // The printed digits leave gaps of 1.2e-4 and 5e-8.
        for (law, seam, gap) in [
            (EnhancedCylinder::Of2010, 0.75f64, 1.3e-4),
            (EnhancedCylinder::Of2015, 0.349_54, 1e-7),
        ] {
            let below = law.internal_exponent(seam.next_down());
            let jump = (law.internal_exponent(seam) - below).abs();
            assert!(jump < gap, "{law:?} {jump}");
        }
    }

    #[test]
    fn both_sets_are_one_law_outside() {
        let topping = SurfacePair::external(3.968_75e-3, 6.582_6e-3, 0.007, MODULUS);
        assert_eq!(
            EnhancedCylinder::Of2010.prepare(&topping),
            EnhancedCylinder::Of2015.prepare(&topping)
        );
    }

    #[test]
    fn a_clearance_outside_the_fit_of_internal_contacts_is_noted() {
        let note = |clearance: f64| {
            let pair = SurfacePair::internal(5e-3, 5e-3 + clearance, 0.01, MODULUS);
            EnhancedCylinder::range_note(&pair)
        };
        let (from, to) = (INTERNAL_RANGE.0 / METRE, INTERNAL_RANGE.1 / METRE);
        assert_eq!(note(1.01 * from), None);
        assert_eq!(note(0.99 * to), None);
        assert!(note(0.9 * from).is_some_and(|note| note.contains("dR = ")));
        assert!(note(1.1 * to).is_some_and(|note| note.contains("dR = ")));
        let outside = SurfacePair::external(5e-3, 0.1 * to, 0.01, MODULUS);
        assert_eq!(EnhancedCylinder::range_note(&outside), None);
    }
}
