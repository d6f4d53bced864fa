//! The form of all logarithmic laws of line contact, δ = f/A [ln(B/f) + C], inverted exactly.
//!
//! The physical branch ends at the maximum of δ: `f_end` = B `e^(C - 1)`, `δ_end` = `f_end`/A. With f = `f_end` exp(-x) every such law
//! becomes x - ln(1 + x) = `ln(δ_end/δ)`, x >= 0. Newton's method converges from `δ_end` down to the smallest number (x = -1 - W₋₁(...),
//! the lower Lambert branch). The form depends on A, B and C through `δ_end` and `f_end` alone.

use super::ElasticLaw;
use crate::math::simd::ln_of_quotient;
use crate::math::{Real, Truth};

/// The logarithmic form; its constants are `δ_end` \[m\] and the secant stiffness there, A = `f_end/δ_end` \[N/m\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Logarithmic;

/// Penetration \[m\] below which the law continues as a secant; the force is below 1e-290 N.
const LEAST: f64 = 1e-300;

/// Coefficients of numerator and denominator, from the linear terms on, of x = s (1 + a s + b s²)/(1 + c s) with s = sqrt(2 tau). They are
/// a minimax fit for tau <= 730 with a relative error of 2.3e-4.
const START: ([f64; 2], f64) = (
    [0.512_902_676_511_076, 0.090_435_655_836_895_08],
    0.180_995_758_130_717_94,
);

impl ElasticLaw for Logarithmic {
    /// Return the force to 6 units in the last place for any δ from 1e-300 m on. Past the end the law has no value; the run warns and
    /// continues with the secant stiffness.
    ///
    /// exp(-x) is (δ/`δ_end`)/(1 + x). A closed-form initial value is corrected by one step of Fritsch, Shafer and Crowley (1973), of
    /// fourth order.
    #[inline(always)]
    fn elastic<R: Real>(self, [end, stiffness]: [R; 2], penetration: R) -> R {
        let number = |value| penetration.constant(value);
        let one = number(1.0);
        let secant = stiffness * penetration;

        let tau = ln_of_quotient(end, penetration.max(number(LEAST)));
        let s = (tau + tau).sqrt();
        let (a, b, c) = (number(START.0[0]), number(START.0[1]), number(START.1));
        // 1 + x = above/below and x = over/below. The factor `below` is kept to the end, which saves one division.
        let below = c.mul_add(s, one);
        let above = b.mul_add(s, a).mul_add(s, one).mul_add(s, below);
        let over = above - below;
        // z = x - ln(1 + x) - tau and q = 2 x (x - 2z/3), multiplied by below and by its square.
        let z = below.negate_mul_add(ln_of_quotient(above, below) + tau, over);
        let q = (over + over) * z.negate_mul_add(number(2.0 / 3.0), over);
        let z2 = z * below;
        let denominator = over * (q - (z2 + z2));
        let corrected = above * z.negate_mul_add(q - z2, denominator);
        let force = secant * below * denominator / corrected;
        penetration.less(end).select(force, secant)
    }

    /// Return the slope from d ln f = -dx and d ln δ = -x/(1 + x) dx. At the end of the branch, where it is infinite, it is bounded by 1/ε
    /// times the secant stiffness.
    #[inline(always)]
    fn slope<R: Real>(self, [end, stiffness]: [R; 2], penetration: R, [force, _]: [R; 2]) -> R {
        // The force is the secant's force over 1 + x; its slope is the secant stiffness over x.
        let number = |value| penetration.constant(value);
        let least = number(LEAST);
        let over = (stiffness * penetration) / force.max(least);
        let x = (over - number(1.0)).max(number(f64::EPSILON));
        let slope = penetration.less(end).select(stiffness / x, stiffness);
        penetration.greater(least).select(slope, number(0.0))
    }

    /// Return f²/A (x/2 + 1/4), the integral of f dδ with f = `f_end` exp(-x).
    fn stored(self, &[end, stiffness]: &[f64; 2], penetration: f64, force: f64) -> f64 {
        if penetration <= LEAST {
            return 0.0;
        }
        if penetration >= end {
            return 0.5 * stiffness * (penetration * penetration - 0.5 * end * end);
        }
        let x = stiffness * penetration / force - 1.0;
        force * force / stiffness * (0.5 * x + 0.25)
    }

    fn range_end(self, &[end, _]: &[f64; 2]) -> f64 {
        end
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::force_law::SurfacePair;
    use crate::force_law::line_contact::JOHNSON;
    use crate::force_law::testing::for_each_force;

    /// Johnson's law.
    fn prepare(surfaces: &SurfacePair) -> [f64; 2] {
        (JOHNSON.prepare)(surfaces)
    }

    /// The force by Newton's method.
    fn solved(&[end, stiffness]: &[f64; 2], penetration: f64) -> f64 {
        let tau = -(penetration / end).ln();
        stiffness * end * (-exponent(tau)).exp()
    }

    /// Solve x - ln(1 + x) = `tau` for x >= 0.
    fn exponent(tau: f64) -> f64 {
        if tau <= 0.0 {
            return 0.0;
        }
        // The function is convex and increasing: from any positive start Newton's method reaches the right of the root, then decreases to
        // it.
        let mut x = (2.0 * tau).sqrt() + 2.0 / 3.0 * tau;
        for _ in 0..8 {
            let step = (x - x.ln_1p() - tau) * (1.0 + x) / x;
            x -= step;
            if step.abs() <= 1e-9 * x {
                // Convergence is quadratic: the next step would be below rounding.
                break;
            }
        }
        x
    }

    fn pin_in_bushing() -> SurfacePair {
        SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, 2.07e11 / 1.82)
    }

    #[test]
    fn the_branch_of_pin_and_bushing_ends_at_13_micrometres_and_53_kilonewtons() {
        let pair = prepare(&pin_in_bushing());
        let [end, stiffness] = pair;
        assert!((end - 13.534e-6).abs() < 1e-9);
        assert!((end * stiffness - 53.2e3).abs() < 100.0);
    }

    #[test]
    fn inverse_returns_the_force_to_1e_12_up_to_0_9999_of_the_end() {
        let surfaces = pin_in_bushing();
        let pair = prepare(&surfaces);
        let scale = std::f64::consts::PI * surfaces.length * surfaces.contact_modulus;
        let mut penetration = 1e-15;
        while penetration < 0.9999 * pair[0] {
            let f = Logarithmic.force(&pair, penetration);
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
        let pair = prepare(&pin_in_bushing());
        for d in [1e-8, 1e-6, 10e-6, 15e-6] {
            let h = 1e-4 * d;
            let slope =
                (Logarithmic.energy(&pair, d + h) - Logarithmic.energy(&pair, d - h)) / (2.0 * h);
            assert!(
                (slope / Logarithmic.force(&pair, d) - 1.0).abs() < 1e-6,
                "{d}"
            );
        }
        // Both forms meet at the end; over this distance the energy changes by four times its share.
        let [end, stiffness] = pair;
        let [below, above] = [1.0 - 1e-9, 1.0 + 1e-9].map(|x| Logarithmic.energy(&pair, x * end));
        let change = (above - below) / (0.25 * stiffness * end * end);
        assert!((0.0..1e-8).contains(&change), "{change}");
    }

    /// The bound is the error of the solver: that of the exponent passed to exp, and that of δ/`δ_end` near the end.
    fn assert_as_solved(pair: &[f64; 2], penetrations: &[f64]) {
        for_each_force(Logarithmic, pair, penetrations, |set, d, force| {
            let reference = solved(pair, d);
            let exponent = (pair[0] * pair[1] / reference).ln();
            let to_end = 1.0 - d / pair[0];
            let bound = 1.2e-15 + 5e-16 * exponent + 1e-16 / to_end.max(f64::EPSILON).sqrt();
            assert!(
                (force / reference - 1.0).abs() <= bound,
                "{set} at {d:e}: {force:e} {reference:e}"
            );
        });
    }

    #[test]
    fn ends_of_the_range() {
        let pair = prepare(&pin_in_bushing());
        let end = pair[0];
        assert_as_solved(&pair, &[LEAST, 1e-299, 0.999 * end, end.next_down()]);
        let past = [0.0, end, end.next_up(), 2.0 * end, 1e10, f64::INFINITY];
        for_each_force(Logarithmic, &pair, &past, |set, d, force| {
            assert_eq!(force, pair[1] * d, "{set} at {d:e}");
        });
        for_each_force(Logarithmic, &pair, &[f64::NAN], |set, _, force| {
            assert!(force.is_nan(), "{set}");
        });
        let tiny = [5e-324, 1e-310, LEAST.next_down()];
        for_each_force(Logarithmic, &pair, &tiny, |set, d, force| {
            assert!(
                (0.9..1.1).contains(&(force / solved(&pair, d))) || force < 1e-310,
                "{set} at {d:e}"
            );
        });
    }

    #[test]
    fn vectors_return_the_force_up_to_the_end() {
        let surfaces = pin_in_bushing();
        let pair = prepare(&surfaces);
        let scale = std::f64::consts::PI * surfaces.length * surfaces.contact_modulus;
        let below = |to_end: f64| pair[0] * (1.0 - to_end);
        let depths: Vec<f64> = (1..4000).map(|i| below(0.996f64.powi(i))).collect();
        for_each_force(Logarithmic, &pair, &depths, |set, d, force| {
            let back =
                force / scale * ((4.0 * scale * surfaces.radius_difference / force).ln() - 1.0);
            assert!((back / d - 1.0).abs() < 2e-15, "{set} at {d:e}: {back:e}");
        });
    }

    proptest! {
        #[test]
        fn vectors_are_the_solved_force_to_its_error(
            clearance in 1e-6..1e-2f64,
            exponents in proptest::collection::vec(-15.0..0.0f64, 64),
            far in proptest::collection::vec(-290.0..0.0f64, 16),
        ) {
            let pair = prepare(&SurfacePair::internal(2.22e-3, 2.22e-3 + clearance, 0.011, 1e11));
            let depths = exponents.into_iter().chain(far).map(|e| pair[0] * 10f64.powf(e));
            assert_as_solved(&pair, &depths.collect::<Vec<_>>());
        }
    }
}
