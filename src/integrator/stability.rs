//! Stability of the formulas of each order for the fastest rate of the system.
//!
//! The rate takes no evaluation of its own. With the explicit corrector it is the change of the derivative over the change of the
//! solution between the two evaluations of a step. With the implicit corrector it follows from the ratio of the residual and its
//! Newton correction.

use serde::{Deserialize, Serialize};

use super::MAX_ORDER;

/// Factor of an earlier rate per step: a rate counts for about twenty steps, as many as the threshold of corrector switching.
const FADING: f64 = 0.95;

/// Step size times rate at which the Adams-Moulton formula of each order becomes unstable.
///
/// The smallest of the limits of an undamped vibration, a damped one (ζ = 0.71) and a damper, from the roots of the recurrence.
/// Orders 1 and 2 are A-stable. Limits are rounded to two digits. At 0.95 of a limit the growth per step is at most 0.9 % at orders 3
/// and 4, and 0.1 % above. The unit test of this module checks these bounds.
const IMPLICIT: [f64; MAX_ORDER] = [
    f64::INFINITY,
    f64::INFINITY,
    0.7,
    0.89,
    1.2,
    1.2,
    0.77,
    0.5,
    0.31,
    0.2,
    0.11,
    0.07,
];

/// The same limits for PECE with a corrector of one order more than the predictor; growth at 0.95 of a limit is at most 0.8 %.
const EXPLICIT: [f64; MAX_ORDER] = [
    0.5, 1.2, 1.18, 0.95, 0.71, 0.52, 0.37, 0.26, 0.18, 0.12, 0.08, 0.045,
];

/// Return the step size times rate up to which the explicit formula of `order` is stable.
pub(super) fn explicit_limit(order: usize) -> f64 {
    EXPLICIT[order - 1]
}

/// Return the highest implicit order, at most `order` + 1, that is stable at `step_times_rate`.
pub(super) fn implicit_order(order: usize, step_times_rate: f64) -> usize {
    let stable = |k: usize| step_times_rate <= IMPLICIT[k - 1];
    // The order rises by one at most; limits decrease above order six, so that the first unstable order ends the search.
    let highest = (order + 1).min(MAX_ORDER);
    (3..=highest).take_while(|&k| stable(k)).last().unwrap_or(2)
}

/// Largest rate of the last steps \[1/s\].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct FastestRate(f64);

impl FastestRate {
    /// Record the rate of one step.
    pub(super) fn record(&mut self, rate: f64) {
        self.record_after(1, rate);
    }

    /// Record the rate of the last of `steps`.
    pub(super) fn record_after(&mut self, steps: u32, rate: f64) {
        // A rate that was not excited for some steps is forgotten gradually.
        let faded = FADING.powi(steps.cast_signed()) * self.0;
        self.0 = if rate.is_finite() {
            faded.max(rate)
        } else {
            faded
        };
    }

    /// Record the rate of one step from the first correction of Newton's method.
    ///
    /// For one direction of stiffness ω² and damping d the residual over the correction is `1 + γ d + γ² ω²`. `residual` and `corrected`
    /// are sums of squares over all directions. One number cannot tell a spring from a damper: the larger of both rates is taken, which is
    /// above ω for a spring with γ ω > 1. Of several directions the sum of squares shows a mean, which is below the largest rate.
    pub(super) fn record_correction(&mut self, residual: f64, corrected: f64, gamma: f64) {
        let rate = if corrected > 0.0 {
            // γ d + γ² ω² of the directions in the residual.
            let stiffness = ((residual / corrected).sqrt() - 1.0).max(0.0);
            // ω = sqrt(s)/γ for a spring, d = s/γ for a damper: the larger one.
            stiffness.sqrt().max(stiffness) / gamma
        } else {
            0.0
        };
        self.record(rate);
    }

    pub(super) fn value(self) -> f64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Complex;

    use super::*;

    /// Weights of f(n), f(n - 1), ... from those of backward differences.
    fn weights(differences: &[f64]) -> Vec<f64> {
        let mut weights = vec![0.0; differences.len()];
        for (i, difference) in differences.iter().enumerate() {
            let mut binomial = 1.0;
            for (j, weight) in weights.iter_mut().enumerate().take(i + 1) {
                *weight += difference * binomial;
                binomial *= -((i - j) as f64) / (j + 1) as f64;
            }
        }
        weights
    }

    /// Differences' weights of the Adams-Bashforth and the Adams-Moulton formula of `order`.
    fn formulas(order: usize) -> (Vec<f64>, Vec<f64>) {
        let (mut explicit, mut implicit) = (Vec::new(), Vec::new());
        for m in 0..order {
            let sum = |gammas: &[f64]| -> f64 {
                let terms = gammas.iter().enumerate();
                terms.map(|(j, gamma)| gamma / (m + 1 - j) as f64).sum()
            };
            explicit.push(1.0 - sum(&explicit));
            implicit.push(f64::from(u8::from(m == 0)) - sum(&implicit));
        }
        (weights(&explicit), weights(&implicit))
    }

    /// Growth a step over many steps of size `h` of y' = i y, a damped vibration, or y' = -y, whichever is largest.
    fn growth(h: f64, step: impl Fn(Complex<f64>, &[Complex<f64>]) -> Complex<f64>) -> f64 {
        let half = 0.5f64.sqrt();
        [(0.0, 1.0), (-half, half), (-1.0, 0.0)]
            .map(|(re, im)| growth_at(Complex::new(h * re, h * im), &step))
            .into_iter()
            .fold(0.0, f64::max)
    }

    fn growth_at(
        z: Complex<f64>,
        step: &impl Fn(Complex<f64>, &[Complex<f64>]) -> Complex<f64>,
    ) -> f64 {
        let steps = 20_000;
        let mut logarithm = 0.0;
        let mut past: Vec<_> = (0..=MAX_ORDER)
            .map(|i| Complex::new(1.0, (i * i % 7) as f64))
            .collect();
        for n in 0..steps {
            let next = step(z, &past);
            past.rotate_right(1);
            past[0] = next;
            let size = past.iter().map(|y| y.norm()).fold(0.0, f64::max);
            if n >= steps / 2 {
                logarithm += size.ln();
            }
            for y in &mut past {
                *y /= size;
            }
        }
        (logarithm / f64::from(steps / 2)).exp()
    }

    fn sum(weights: &[f64], past: &[Complex<f64>]) -> Complex<f64> {
        weights.iter().zip(past).map(|(w, y)| y * *w).sum()
    }

    #[test]
    fn vibrations_are_bounded_below_the_limits_and_grow_above() {
        for order in 1..=MAX_ORDER {
            let (predictor, own) = formulas(order);
            let (_, corrector) = formulas(order + 1);
            let implicit = |z: Complex<f64>, past: &[Complex<f64>]| {
                (past[0] + z * sum(&own[1..], past)) / (Complex::new(1.0, 0.0) - z * own[0])
            };
            let explicit = |z: Complex<f64>, past: &[Complex<f64>]| {
                let predicted = past[0] + z * sum(&predictor, past);
                past[0] + z * (predicted * corrector[0] + sum(&corrector[1..], past))
            };
            if order > 2 {
                let limit = IMPLICIT[order - 1];
                let bound = if order <= 4 { 1.009 } else { 1.001 };
                assert!(growth(0.95 * limit, implicit) < bound, "order {order}");
                assert!(growth(1.2 * limit, implicit) > 1.001, "order {order}");
            } else {
                assert!(growth(1e3, implicit) < 1.0 + 1e-9, "order {order}");
            }
            let limit = EXPLICIT[order - 1];
            assert!(growth(0.95 * limit, explicit) < 1.008, "order {order}");
            assert!(growth(1.2 * limit, explicit) > 1.001, "order {order}");
        }
    }

    #[test]
    fn orders_above_two_need_a_rate_that_is_slow_enough() {
        assert_eq!(implicit_order(2, 0.0), 3);
        assert_eq!(implicit_order(12, 0.0), 12);
        assert_eq!(implicit_order(2, 0.8), 2);
        assert_eq!(implicit_order(9, 0.6), 7);
        assert_eq!(implicit_order(5, 100.0), 2);
    }

    #[test]
    fn a_rate_is_kept_for_some_steps_and_then_fades() {
        let mut rate = FastestRate::default();
        rate.record(100.0);
        (0..10).for_each(|_| rate.record(1.0));
        assert!(rate.value() > 50.0);
        rate.record(f64::NAN);
        (0..200).for_each(|_| rate.record(1.0));
        assert_eq!(rate.value(), 1.0);
    }

    #[test]
    fn the_first_correction_gives_the_rate_of_a_spring_and_of_a_damper() {
        let gamma = 0.1;
        let rate = |residual: f64, corrected: f64| {
            let mut rate = FastestRate::default();
            rate.record_correction(residual, corrected, gamma);
            rate.value()
        };
        // The residual is the correction times 1 + γ² ω² or 1 + γ d; both enter with their squares.
        let (omega, damping) = (3.0, 50.0);
        let spring = 1.0 + (gamma * omega).powi(2);
        assert!((rate(4.0 * spring.powi(2), 4.0) - omega).abs() < 1e-12);
        let damper = 1.0 + gamma * damping;
        assert!((rate(4.0 * damper.powi(2), 4.0) - damping).abs() < 1e-11);
        assert_eq!(rate(1.0, 4.0), 0.0);
        assert_eq!(rate(1.0, 0.0), 0.0);
    }

    #[test]
    fn explicit_limits_fall_from_order_two_on() {
        let limits: Vec<f64> = (1..=MAX_ORDER).map(explicit_limit).collect();
        assert_eq!(limits, EXPLICIT);
        assert!(limits[1..].windows(2).all(|pair| pair[1] < pair[0]));
    }
}
