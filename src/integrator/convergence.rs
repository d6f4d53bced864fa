//! Convergence of Newton's method: the contraction constant measured in earlier steps, and when a second correction is skipped.

use serde::{Deserialize, Serialize};

use super::StepControl;

/// Safety factor on the contraction constant of earlier steps, for a step with a contact onset or end.
///
/// Chosen on the published drive at 0, 25 and 100 N, with and without rollers: a measured contraction constant would have changed the
/// decision for one in a thousand of the steps accepted with this factor. Doubled or halved, evaluations change by 1 % at most.
pub(crate) const SAFETY_AT_CONTACT_CHANGE: f64 = 10.0;

/// Largest remaining correction of a converged iteration, in units of the tolerance.
///
/// A decade below the error test; 0.15 and 0.2 cost the same within a few percent (decision 20).
pub(super) const REMAINDER: f64 = 0.1;

/// Largest remaining correction that may stay unmeasured \[m\].
///
/// It rules above an accuracy of 6e-10 m; below, the limit is [`REMAINDER`]: 1e-11 m at the default accuracy. A fixed length: remaining corrections have a sign and do work, while the truncation errors of the trapezoidal rule nearly
/// conserve energy. A share of the tolerance would make the energy balance residual grow with it. Chosen as the largest
/// of the tried lengths that did not raise the residual (decision 20).
const UNMEASURED_LENGTH: f64 = 6e-11;

/// The same limit in units of the tolerance, where `rtol` and `atol` are given.
///
/// A tenth of [`REMAINDER`] (decision 20).
const UNMEASURED: f64 = 0.01;

/// Longest first correction \[m\] that may stay unmeasured in a step with contact onsets or ends.
///
/// The contraction constant of such a step differs from those before. Twice the default accuracy: nothing was gained above
/// (decision 20).
const LONGEST_WITH_EVENTS: f64 = 2e-10;

/// Growth of the contraction constant in each step that does not measure it.
///
/// An old measurement is trusted less. Smaller growth saves corrections, but makes more steps with a lubricant film (decision 20).
const GROWTH: f64 = 1.1;

/// Estimate of the convergence of Newton's method from earlier steps.
///
/// The first correction has the matrix of its own point. The second one is about `c |Δ₁|²` if the matrix is exact; a part `γ|w| |Δ₁|`
/// of the omitted terms (drives) is included in the measured c. With the contraction constant c of earlier steps the size of the second
/// correction is known before its evaluation. Later corrections use the first matrix and converge linearly.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct NewtonConvergence {
    /// Contraction constant c, in units of one over the tolerance; infinite while it is unknown.
    contraction: f64,
    /// Whether the last step ended with its first correction.
    pub(super) unmeasured: bool,
    /// γ of the last step \[s\]; zero after an explicit one.
    pub(super) gamma: f64,
}

impl NewtonConvergence {
    pub(super) fn new() -> Self {
        Self {
            contraction: f64::INFINITY,
            unmeasured: false,
            gamma: 0.0,
        }
    }

    /// Forget the contraction constant.
    pub(super) fn restart(&mut self) {
        self.contraction = f64::INFINITY;
    }

    /// Return the remaining correction after one of `size` that follows one of `last`; the `second` correction gives the contraction
    /// constant.
    ///
    /// The sum of a geometric series, `Δ θ/(1 - θ)` with the rate θ (Hairer and Wanner, *Solving Ordinary Differential Equations II*,
    /// section IV.8).
    pub(super) fn measure(&mut self, size: f64, last: f64, second: bool) -> f64 {
        let rate = size / last;
        // Later corrections converge linearly: their ratio to the square of the one before says nothing about the first one.
        if second {
            self.contraction = size / (last * last);
        }
        // Infinite for θ of one and above: no convergence.
        size * rate / (1.0 - rate).max(0.0)
    }

    /// Return whether the first correction, of `size`, is the last one of this step.
    ///
    /// The predicted rate is `safety_factor` c |Δ₁| and the remaining correction is that times |Δ₁|.
    pub(super) fn may_skip_second_correction(
        &mut self,
        control: &StepControl,
        size: f64,
        safety_factor: f64,
    ) -> bool {
        if safety_factor.is_infinite() {
            self.contraction = f64::INFINITY;
        }
        let by_component = control.is_by_component();
        let allowed = if by_component {
            UNMEASURED
        } else {
            (UNMEASURED_LENGTH / control.accuracy).min(REMAINDER)
        };
        // Both the first correction and the accuracy must be at most this length (decision 20).
        let length = size.max(1.0) * control.accuracy;
        let is_short = !by_component && length <= LONGEST_WITH_EVENTS;
        let rate = safety_factor * self.contraction * size;
        self.unmeasured =
            rate < 1.0 && rate * size <= allowed && (safety_factor <= 1.0 || is_short);
        if self.unmeasured {
            self.contraction *= GROWTH;
        }
        self.unmeasured
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contraction_constant_is_that_of_the_second_correction() {
        let mut convergence = NewtonConvergence::new();
        convergence.measure(2.0, 10.0, true);
        convergence.measure(0.4, 2.0, false);
        assert!((convergence.contraction - 0.02).abs() < 1e-15);
    }

    /// A measured contraction constant `c`.
    fn measured(c: f64) -> NewtonConvergence {
        let mut convergence = NewtonConvergence::new();
        convergence.measure(c, 1.0, true);
        convergence
    }

    fn skips(c: f64, accuracy: f64, size: f64, safety: f64) -> bool {
        let control = StepControl {
            accuracy,
            ..StepControl::default()
        };
        measured(c).may_skip_second_correction(&control, size, safety)
    }

    #[test]
    fn the_remaining_correction_is_the_sum_of_a_geometric_series() {
        let rest = measured(1.0).measure(0.5, 2.0, false);
        let series: f64 = (1..60).map(|i| 0.5 * 0.25f64.powi(i)).sum();
        assert!((rest - series).abs() < 1e-15);
        assert_eq!(measured(1.0).measure(2.0, 2.0, false), f64::INFINITY);
        assert_eq!(measured(1.0).measure(3.0, 2.0, false), f64::INFINITY);
    }

    #[test]
    fn a_second_correction_is_skipped_below_the_largest_remaining_one() {
        // The predicted remaining correction is c size²: 0.08 and 0.106 of the tolerance, with a limit of 0.1.
        assert!(skips(0.02, 1e-10, 2.0, 1.0));
        assert!(!skips(0.02, 1e-10, 2.3, 1.0));
        // The limit is 6e-11 m, here 0.01 of the tolerance.
        assert!(skips(0.02, 6e-9, 0.7, 1.0));
        assert!(!skips(0.02, 6e-9, 0.8, 1.0));
        // A rate of 0.8, 1 and 1.2: the iteration has to converge.
        assert!(skips(20.0, 1e-10, 0.04, 1.0));
        assert!(!skips(20.0, 1e-10, 0.05, 1.0));
        assert!(!skips(20.0, 1e-10, 0.06, 1.0));
    }

    #[test]
    fn a_step_with_a_contact_onset_skips_only_short_corrections() {
        let safety = SAFETY_AT_CONTACT_CHANGE;
        assert!(skips(0.02, 1e-10, 0.5, safety));
        // Ten times c size² is 0.11 here.
        assert!(!skips(0.02, 1e-10, 0.75, safety));
        // 1.9e-10 m and 2.1e-10 m of a correction, 2.1e-10 m of an accuracy.
        assert!(skips(1e-4, 1e-10, 1.9, safety));
        assert!(!skips(1e-4, 1e-10, 2.1, safety));
        assert!(!skips(1e-4, 2.1e-10, 0.5, safety));
        assert!(skips(1e-4, 1e-10, 2.1, 1.0));
    }

    #[test]
    fn tolerances_by_component_have_a_limit_of_their_own() {
        let control = StepControl {
            rtol: 1e-8,
            ..StepControl::default()
        };
        let skips =
            |size, safety| measured(0.02).may_skip_second_correction(&control, size, safety);
        assert!(skips(0.7, 1.0) && !skips(0.8, 1.0));
        assert!(!skips(0.1, SAFETY_AT_CONTACT_CHANGE));
    }

    #[test]
    fn a_contraction_constant_is_trusted_less_each_step_and_forgotten_at_a_restart() {
        let control = StepControl::default();
        let mut convergence = measured(0.0212);
        // 0.085, 0.093 and 0.103 of the tolerance.
        let skipped = [(); 3].map(|()| convergence.may_skip_second_correction(&control, 2.0, 1.0));
        assert_eq!(skipped, [true, true, false]);
        assert!(!convergence.unmeasured);
        let mut unknown = measured(1e-9);
        unknown.restart();
        assert!(!unknown.may_skip_second_correction(&control, 1e-3, 1.0));
        let mut changed = measured(1e-9);
        assert!(!changed.may_skip_second_correction(&control, 1e-3, f64::INFINITY));
        assert!(!changed.may_skip_second_correction(&control, 1e-3, 1.0));
    }
}
