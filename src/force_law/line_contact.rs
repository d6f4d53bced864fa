//! The published laws of line contact in logarithmic form, each as the three numbers that the form takes.
//!
//! With f the force, L the length and E* the contact modulus, ΔR = `R_j - R_i` inside and `R_i + R_j` outside:
//!
//! - Johnson, Contact Mechanics (1985), section 5.6: δ = f/(π L E*) [ln(4 π L E* ΔR/f) - 1].
//! - Hertz's cylinders as half-planes: δ = 2f/(π L E*) [ln(π L E* ΔR/f) - 1].
//! - Radzimovsky, University of Illinois Bulletin 408 (1953): δ = f/(π L E*) [2/3 + ln(4 `R_i/b`) + ln(4 `R_j/b`)],
//!   b = 1.6 sqrt(f `R_i` `R_j`/(L ΔR E*)), the width as Pereira, Ramalho and Ambrósio print it; `R_i` and `R_j` cancel.
//! - ESDU 78035 (1978), a circular cylinder in or on another: δ = f `(h_i + h_j)/L` [ln(4 L ΔR/(f `(h_i + h_j)`)) + 1],
//!   h = (1 - ν²)/(π E), so that `h_i + h_j` = 1/(π E*).
//!
//! The forms are those of Pereira, Ramalho and Ambrósio, "A critical overview of internal and external cylinder contact force
//! models", Nonlinear Dynamics 63 (2011) 681, checked against public code of multibody programs. Two want a word. With
//! diameters in the place of the radii b would be the width of Hertz's contact, 2.26 sqrt(...), and Radzimovsky's bracket have
//! ln 2 less; it is taken as printed. One code has π `(h_i + h_j)` with
//! h = (1 - ν²)/E in ESDU's law: nine times softer than any other law of lines, and not taken.

use super::{LogarithmicPair, SurfacePair};

/// A law of line contact in logarithmic form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the names say it
pub enum LineContact {
    Johnson,
    HertzCylinder,
    Radzimovsky,
    Esdu78035,
}

impl LineContact {
    /// (A over π L E*, k, C) of δ = f/A [ln(k A ΔR/f) + C].
    fn numbers(self) -> (f64, f64, f64) {
        match self {
            Self::Johnson => (1.0, 4.0, -1.0),
            Self::HertzCylinder => (0.5, 2.0, -1.0),
            // 16 R_i R_j/b² = (16/1.6²) L E* ΔR/f
            Self::Radzimovsky => (1.0, 6.25 / std::f64::consts::PI, 2.0 / 3.0),
            Self::Esdu78035 => (1.0, 4.0, 1.0),
        }
    }

    /// The end of the branch, for one pair.
    #[must_use]
    pub fn prepare(self, surfaces: &SurfacePair) -> LogarithmicPair {
        let (share, k, c) = self.numbers();
        let end_penetration = k * surfaces.radius_difference * (c - 1.0).exp();
        let line = std::f64::consts::PI * surfaces.length * surfaces.contact_modulus;
        LogarithmicPair {
            end_penetration,
            end_force: share * line * end_penetration,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::force_law::{ElasticLaw, Logarithmic};

    const ALL: [LineContact; 4] = [
        LineContact::Johnson,
        LineContact::HertzCylinder,
        LineContact::Radzimovsky,
        LineContact::Esdu78035,
    ];

    fn pairs() -> [(f64, f64, SurfacePair); 2] {
        let modulus = 2.07e11 / 1.82;
        let (pin, bore) = (2.22e-3, 2.245e-3);
        let (bushing, topping) = (3.968_75e-3, 6.582_6e-3);
        [
            (pin, bore, SurfacePair::internal(pin, bore, 0.011, modulus)),
            (
                bushing,
                topping,
                SurfacePair::external(bushing, topping, 0.007, modulus),
            ),
        ]
    }

    /// The laws as they are printed.
    fn penetration(law: LineContact, (r_i, r_j, s): (f64, f64, SurfacePair), force: f64) -> f64 {
        let (f, e, dr) = (force / s.length, s.contact_modulus, s.radius_difference);
        match law {
            LineContact::Johnson => f / (PI * e) * ((4.0 * PI * e * dr / f).ln() - 1.0),
            LineContact::HertzCylinder => 2.0 * f / (PI * e) * ((PI * e * dr / f).ln() - 1.0),
            LineContact::Radzimovsky => {
                let b = 1.6 * (f * r_i * r_j / (dr * e)).sqrt();
                f / (PI * e) * (2.0 / 3.0 + (4.0 * r_i / b).ln() + (4.0 * r_j / b).ln())
            }
            LineContact::Esdu78035 => {
                let h = 1.0 / (PI * e); // h_i + h_j
                let slope = force * h / s.length;
                slope * ((4.0 * s.length * dr / (force * h)).ln() + 1.0)
            }
        }
    }

    #[test]
    fn the_inverse_returns_the_force_of_the_printed_laws() {
        for law in ALL {
            for pair in pairs() {
                let constants = law.prepare(&pair.2);
                for share in [1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 0.9] {
                    let force = share * constants.end_force;
                    let back = Logarithmic::force(&constants, penetration(law, pair, force));
                    // Near the end a rounding of the depth is worth more of the force: 1/(1 - share) of it.
                    let bound = 1e-14 / (1.0 - share) * 40.0;
                    assert!((back / force - 1.0).abs() < bound, "{law:?} {share}");
                }
            }
        }
    }

    #[test]
    fn depth_grows_with_force_up_to_the_end_and_falls_after_it() {
        for law in ALL {
            for pair in pairs() {
                let constants = law.prepare(&pair.2);
                let at = |share: f64| penetration(law, pair, share * constants.end_force);
                assert!((at(1.0) / constants.end_penetration - 1.0).abs() < 1e-14);
                assert!((1..100).all(|i| at(f64::from(i) / 100.0) < at(f64::from(i + 1) / 100.0)));
                assert!(at(1.01) < at(1.0), "{law:?}");
            }
        }
    }

    #[test]
    fn energy_and_slope_belong_to_the_force_on_both_sides_of_the_end() {
        for law in ALL {
            let pair = law.prepare(&pairs()[0].2);
            for share in [1e-4, 0.1, 0.9, 1.5] {
                let d = share * pair.end_penetration;
                let h = 1e-5 * d;
                let difference = |of: fn(&LogarithmicPair, f64) -> f64| {
                    (of(&pair, d + h) - of(&pair, d - h)) / (2.0 * h)
                };
                let (slope, power) = (
                    difference(Logarithmic::force),
                    difference(Logarithmic::energy),
                );
                assert!(
                    (slope / Logarithmic::stiffness(&pair, d) - 1.0).abs() < 1e-7,
                    "{law:?}"
                );
                assert!(
                    (power / Logarithmic::force(&pair, d) - 1.0).abs() < 1e-8,
                    "{law:?}"
                );
            }
        }
    }
}
