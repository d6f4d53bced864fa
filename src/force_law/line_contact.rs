//! The published laws of line contact in logarithmic form, each as the three numbers of that form.
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
//! The forms are those of Pereira, Ramalho and Ambrósio, "A critical overview of internal and external cylinder contact force models",
//! Nonlinear Dynamics 63 (2011) 681, checked against public code of multibody programs. Two of them are ambiguous. With diameters in the
//! place of the radii b would be the width of Hertz's contact, 2.26 sqrt(...), and Radzimovsky's bracket would have ln 2 less; the printed
//! form is used. One code has π `(h_i + h_j)` with h = (1 - ν²)/E in ESDU's law; that form is nine times softer than any other law of lines
//! and is not used.

use super::{Definition, SurfacePair};

/// Johnson's cylinders.
pub(super) const JOHNSON: Definition = Definition {
    name: "johnson",
    prepare: |surfaces| line(surfaces, 1.0, 4.0, -1.0),
    range_note: |_| None,
};

/// Hertz's cylinders as two half-planes.
pub(super) const HERTZ_CYLINDER: Definition = Definition {
    name: "hertz-cylinder",
    prepare: |surfaces| line(surfaces, 0.5, 2.0, -1.0),
    range_note: |_| None,
};

/// Radzimovsky's cylinders: 16 `R_i R_j/b²` = (16/1.6²) L E* ΔR/f.
pub(super) const RADZIMOVSKY: Definition = Definition {
    name: "radzimovsky",
    prepare: |surfaces| line(surfaces, 1.0, 6.25 / std::f64::consts::PI, 2.0 / 3.0),
    range_note: |_| None,
};

/// Item 78035 of the Engineering Sciences Data Unit.
pub(super) const ESDU_78035: Definition = Definition {
    name: "esdu-78035",
    prepare: |surfaces| line(surfaces, 1.0, 4.0, 1.0),
    range_note: |_| None,
};

/// Return the constants of δ = f/A [ln(k A ΔR/f) + C] with A = `share` π L E*.
fn line(surfaces: &SurfacePair, share: f64, k: f64, c: f64) -> [f64; 2] {
    let end_penetration = k * surfaces.radius_difference * (c - 1.0).exp();
    let line = std::f64::consts::PI * surfaces.length * surfaces.contact_modulus;
    let end_force = share * line * end_penetration;
    [end_penetration, end_force / end_penetration]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::force_law::{ElasticLaw, Logarithmic};

    const ALL: [Definition; 4] = [JOHNSON, HERTZ_CYLINDER, RADZIMOVSKY, ESDU_78035];

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

    /// The laws as printed.
    fn penetration(law: &Definition, (r_i, r_j, s): (f64, f64, SurfacePair), force: f64) -> f64 {
        let (f, e, dr) = (force / s.length, s.contact_modulus, s.radius_difference);
        match law.name {
            "johnson" => f / (PI * e) * ((4.0 * PI * e * dr / f).ln() - 1.0),
            "hertz-cylinder" => 2.0 * f / (PI * e) * ((PI * e * dr / f).ln() - 1.0),
            "radzimovsky" => {
                let b = 1.6 * (f * r_i * r_j / (dr * e)).sqrt();
                f / (PI * e) * (2.0 / 3.0 + (4.0 * r_i / b).ln() + (4.0 * r_j / b).ln())
            }
            _ => {
                let h = 1.0 / (PI * e); // h_i + h_j
                let slope = force * h / s.length;
                slope * ((4.0 * s.length * dr / (force * h)).ln() + 1.0)
            }
        }
    }

    #[test]
    fn the_inverse_returns_the_force_of_the_printed_laws() {
        for law in &ALL {
            for pair in pairs() {
                let constants = (law.prepare)(&pair.2);
                for share in [1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 0.9] {
                    let force = share * constants[0] * constants[1];
                    let back = Logarithmic.force(&constants, penetration(law, pair, force));
                    // Near the end of the range a rounding error of the penetration is amplified in the force, by 1/(1 - share).
                    let bound = 1e-14 / (1.0 - share) * 40.0;
                    assert!((back / force - 1.0).abs() < bound, "{} {share}", law.name);
                }
            }
        }
    }

    #[test]
    fn depth_grows_with_force_up_to_the_end_and_falls_after_it() {
        for law in &ALL {
            for pair in pairs() {
                let constants = (law.prepare)(&pair.2);
                let at = |share: f64| penetration(law, pair, share * constants[0] * constants[1]);
                assert!((at(1.0) / constants[0] - 1.0).abs() < 1e-14);
                assert!((1..100).all(|i| at(f64::from(i) / 100.0) < at(f64::from(i + 1) / 100.0)));
                assert!(at(1.01) < at(1.0), "{}", law.name);
            }
        }
    }

    #[test]
    fn energy_and_slope_belong_to_the_force_on_both_sides_of_the_end() {
        for law in &ALL {
            let pair = (law.prepare)(&pairs()[0].2);
            for share in [1e-4, 0.1, 0.9, 1.5] {
                let d = share * pair[0];
                let h = 1e-5 * d;
                let difference = |of: fn(&[f64; 2], f64) -> f64| {
                    (of(&pair, d + h) - of(&pair, d - h)) / (2.0 * h)
                };
                let (slope, power) = (
                    difference(|pair, d| Logarithmic.force(pair, d)),
                    difference(|pair, d| Logarithmic.energy(pair, d)),
                );
                assert!(
                    (slope / Logarithmic.stiffness(&pair, d) - 1.0).abs() < 1e-7,
                    "{}",
                    law.name
                );
                assert!(
                    (power / Logarithmic.force(&pair, d) - 1.0).abs() < 1e-8,
                    "{}",
                    law.name
                );
            }
        }
    }
}
