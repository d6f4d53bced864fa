//! Johnson's law for cylinders, δ = f/(π L E*) [ln(4 π L E* ΔR / f) - 1] (paper's Eq. 5), inverted exactly.
//!
//! The physical branch ends where δ is largest: `δ_end` = 4 ΔR/e², `f_end` = 4 π L E* ΔR/e² (e: Euler's number). With
//! f = `f_end` exp(-x) the law reads x - ln(1 + x) = `ln(δ_end/δ)`, x >= 0, which Newton's method solves without trouble from
//! `δ_end` down to the smallest number (x = -1 - W₋₁(...), the lower Lambert branch).

use super::{ElasticLaw, SurfacePair};

/// Johnson's law. Elastic by itself.
#[derive(Debug, Clone, Copy)]
pub struct Johnson;

/// Constants of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JohnsonPair {
    /// Penetration at the end of the physical branch \[m\].
    pub end_penetration: f64,
    /// Force there \[N\].
    pub end_force: f64,
}

impl ElasticLaw for Johnson {
    type Pair = JohnsonPair;

    fn prepare(surfaces: &SurfacePair) -> JohnsonPair {
        let end_penetration = 4.0 * surfaces.radius_difference * (-2.0f64).exp();
        JohnsonPair {
            end_penetration,
            end_force: std::f64::consts::PI
                * surfaces.length
                * surfaces.contact_modulus
                * end_penetration,
        }
    }

    fn force(pair: &JohnsonPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        if penetration >= pair.end_penetration {
            // Past the end the law has no value; the run says so and goes on with the secant's stiffness.
            return pair.end_force * (penetration / pair.end_penetration);
        }
        pair.end_force * (-exponent(-(penetration / pair.end_penetration).ln())).exp()
    }

    fn energy(pair: &JohnsonPair, penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        // With f = f_end exp(-x): the integral of f dδ is f² /(π L E*) (x/2 + 1/4), and π L E* = f_end/δ_end.
        let up_to =
            |x: f64| pair.end_force * pair.end_penetration * (-2.0 * x).exp() * (0.5 * x + 0.25);
        if penetration >= pair.end_penetration {
            let past = penetration / pair.end_penetration;
            return up_to(0.0) + 0.5 * pair.end_force * pair.end_penetration * (past * past - 1.0);
        }
        up_to(exponent(-(penetration / pair.end_penetration).ln()))
    }

    fn range_end(pair: &JohnsonPair) -> f64 {
        pair.end_penetration
    }
}

/// Solves x - ln(1 + x) = `tau` for x >= 0.
fn exponent(tau: f64) -> f64 {
    if tau <= 0.0 {
        return 0.0;
    }
    // Convex and increasing: from any positive start Newton lands right of the root and then falls onto it.
    let mut x = (2.0 * tau).sqrt() + 2.0 / 3.0 * tau;
    for _ in 0..8 {
        let step = (x - x.ln_1p() - tau) * (1.0 + x) / x;
        x -= step;
        if step.abs() <= 1e-9 * x {
            // Quadratic: the next step would be below rounding.
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pin_in_bushing() -> SurfacePair {
        SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, 2.07e11 / 1.82)
    }

    #[test]
    fn the_branch_of_pin_and_bushing_ends_at_13_micrometres_and_53_kilonewtons() {
        let pair = Johnson::prepare(&pin_in_bushing());
        assert!((pair.end_penetration - 13.534e-6).abs() < 1e-9);
        assert!((pair.end_force - 53.2e3).abs() < 100.0);
    }

    #[test]
    fn inverse_returns_the_force_to_1e_12_up_to_0_9999_of_the_end() {
        let surfaces = pin_in_bushing();
        let pair = Johnson::prepare(&surfaces);
        let scale = std::f64::consts::PI * surfaces.length * surfaces.contact_modulus;
        let mut penetration = 1e-15;
        while penetration < 0.9999 * pair.end_penetration {
            let f = Johnson::force(&pair, penetration);
            let back = f / scale * ((4.0 * scale * surfaces.radius_difference / f).ln() - 1.0);
            assert!(
                (back / penetration - 1.0).abs() < 1e-12,
                "{penetration} {back}"
            );
            penetration *= 1.07;
        }
    }

    #[test]
    fn energy_is_the_integral_of_the_force_before_and_past_the_end() {
        let pair = Johnson::prepare(&pin_in_bushing());
        for d in [1e-8, 1e-6, 10e-6, 15e-6] {
            let h = 1e-4 * d;
            let slope = (Johnson::energy(&pair, d + h) - Johnson::energy(&pair, d - h)) / (2.0 * h);
            assert!((slope / Johnson::force(&pair, d) - 1.0).abs() < 1e-6, "{d}");
        }
    }
}
