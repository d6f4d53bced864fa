//! Past of the solution: the table of differences and the coefficients that belong to its steps.

use serde::{Deserialize, Serialize};

use super::coefficients::Coefficients;
use super::difference_kernels::Errors;
use super::differences::Differences;
use super::next_step::NextStep;
use super::order_control::ErrorEstimate;
use super::vectors::Vectors;
use super::weights::ErrorNorm;
use super::{DenseOutput, MAX_ORDER};
use crate::math::simd::InstructionSet;

/// Differences of the derivative over the last steps, with the coefficients of the Adams formulas.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct History {
    pub(super) coefficients: Coefficients,
    pub(super) differences: Differences,
    /// Size of the last accepted step \[s\].
    pub(super) last_step_size: f64,
    /// Order of the last accepted step; zero before the first one.
    pub(super) last_order: usize,
}

impl History {
    pub(super) fn new(dimension: usize) -> Self {
        Self {
            coefficients: Coefficients::new(),
            differences: Differences::new(dimension),
            last_step_size: 0.0,
            last_order: 0,
        }
    }

    /// Forget all steps; begin with the derivative `derivative` at the start.
    pub(super) fn restart(&mut self, derivative: &[f64], compensate: bool) {
        self.differences.restart(derivative, compensate);
        self.coefficients = Coefficients::new();
        self.last_step_size = 0.0;
        self.last_order = 0;
    }

    /// Return whether `other` can be replaced by this history: equal sizes and valid indices.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.differences.is_like(&other.differences)
            && self.last_order <= MAX_ORDER
            && self.coefficients.equal_steps <= MAX_ORDER + 1
    }

    /// Update the coefficients for a step of this size and order.
    pub(super) fn update_coefficients(&mut self, step: &NextStep) {
        let last = (self.last_step_size, self.last_order);
        self.coefficients
            .update(step.size, step.order, last.0, last.1);
    }

    /// Compute the predicted value; turns φ into φ*.
    pub(super) fn predict(&mut self, set: InstructionSet, step: &NextStep, vectors: &mut Vectors) {
        self.update_coefficients(step);
        self.differences
            .predict(set, &self.coefficients, step.order, step.size, vectors);
    }

    /// Undo the prediction of a rejected step.
    pub(super) fn undo_prediction(&mut self, set: InstructionSet, step: &NextStep) {
        self.differences
            .undo_prediction(set, &self.coefficients, step.order);
        self.coefficients.undo_prediction(step.order, step.size);
    }

    /// Return γ, the weight of the new derivative in the implicit formula of the predictor's order: h `g_k`, at order two with the damping.
    pub(super) fn gamma(&self, step: &NextStep) -> f64 {
        step.size * (self.coefficients.g[step.order - 1] + damping(step))
    }

    /// Return the error estimates at this order and at the two orders below, from the derivative at the predicted value.
    ///
    /// `correct`: write the corrected value `p + h g_{k+1} (f(p) - φ*_1)` into `trial` in the same pass.
    pub(super) fn estimate_error(
        &self,
        set: InstructionSet,
        step: &NextStep,
        norm: &ErrorNorm,
        vectors: &mut Vectors,
        correct: bool,
    ) -> ErrorEstimate {
        let sums = set.run_blocks(Errors {
            rows: self.differences.rows_of_errors(step.order),
            inverse_weight: &norm.inverse_weight,
            vectors,
            correction: correct.then(|| step.size * self.coefficients.g[step.order]),
        });
        self.estimate_from(step, norm, sums)
    }

    /// Return the estimates from sums of squares at orders k, k - 1 and k - 2.
    #[inline]
    pub(super) fn estimate_from(
        &self,
        step: &NextStep,
        norm: &ErrorNorm,
        sums: [f64; 3],
    ) -> ErrorEstimate {
        let size = (step.order, step.size);
        let mut estimate =
            ErrorEstimate::new(&self.coefficients, size, |sum| norm.of_sum(sum), sums);
        if damping(step) > 0.0 {
            estimate.local += step.size * damping(step) * norm.of_sum(sums[0]);
        }
        estimate
    }

    /// Replace the differences by those that include the derivative at the new solution; return |φ_{k+2}|, or zero without `above`.
    pub(super) fn update(
        &mut self,
        set: InstructionSet,
        (k, h): (usize, f64),
        norm: &ErrorNorm,
        vectors: &Vectors,
        above: bool,
    ) -> f64 {
        (self.last_order, self.last_step_size) = (k, h);
        let weights = &norm.inverse_weight;
        norm.of_sum(self.differences.update(set, k, vectors, weights, above))
    }

    /// Replace the differences after an implicit step of order `k` and size `h` whose corrections have written the newest one.
    pub(super) fn update_by_newest_difference(&mut self, (k, h): (usize, f64)) {
        (self.last_order, self.last_step_size) = (k, h);
        self.differences.append_newest(k);
    }

    /// Set the differences of the last step from row `first` on to zero.
    pub(super) fn clear_from(&mut self, first: usize) {
        self.differences.clear(first..=self.last_order);
    }

    /// Return whether steps were equal for long enough to estimate the error of one order more after a step of order `k`.
    pub(super) fn may_raise(&self, k: usize, max_order: usize) -> bool {
        k < self.coefficients.equal_steps && k < max_order
    }

    /// Return |φ_{i+1}| after a step.
    pub(super) fn norm_of_difference(
        &self,
        set: InstructionSet,
        norm: &ErrorNorm,
        i: usize,
    ) -> f64 {
        let (row, newest) = self.differences.parts_of_row(i);
        norm.of_parts(set, row, newest)
    }

    /// Return the component with the largest error, or the first one whose derivative is not a number.
    pub(super) fn worst_component(
        &self,
        norm: &ErrorNorm,
        vectors: &Vectors,
        controlled: usize,
    ) -> usize {
        // The largest term of the error estimate, f - φ*_1 over the weight.
        let phi_1 = self.differences.row(0);
        let error = |i: usize| ((vectors.derivative[i] - phi_1[i]) * norm.inverse_weight[i]).abs();
        (0..controlled)
            .find(|&i| error(i).is_nan())
            .or_else(|| (0..controlled).max_by(|&a, &b| error(a).total_cmp(&error(b))))
            .unwrap_or(0)
    }

    /// Return the dense output at `distance` \[s\] from the end of the last step, where the solution is `y`.
    pub(super) fn dense<'a>(&'a self, distance: f64, y: &'a [f64]) -> DenseOutput<'a> {
        DenseOutput::new(
            distance,
            self.last_order,
            &self.coefficients.psi,
            y,
            &self.differences,
        )
    }
}

/// Return the additional weight of the new derivative in a step, in step sizes: at order two alone.
fn damping(step: &NextStep) -> f64 {
    if step.order == 2 { step.damping } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_component_has_the_largest_change_of_its_derivative_in_units_of_its_tolerance() {
        let mut history = History::new(3);
        history.restart(&[1.0, -2.0, 3.0], false);
        let mut norm = ErrorNorm::new(3);
        let mut vectors = Vectors::new(3);
        norm.inverse_weight[..3].copy_from_slice(&[1.0, 10.0, 1.0]);
        // Changes of 2, 0.5 and 1 are 2, 5 and 1 tolerances; sums with the differences would be 4, 35 and 7.
        vectors.derivative[..3].copy_from_slice(&[3.0, -1.5, 4.0]);
        assert_eq!(history.worst_component(&norm, &vectors, 3), 1);
        norm.inverse_weight[1] = 0.1;
        assert_eq!(history.worst_component(&norm, &vectors, 3), 0);
        // 2 and 1.6 tolerances; changes plus weights would be 3 and 4.5.
        norm.inverse_weight[1] = 3.2;
        assert_eq!(history.worst_component(&norm, &vectors, 3), 0);
        norm.inverse_weight[1] = 0.1;
        // Derivatives that are large and do not change are no error.
        vectors.derivative[..3].copy_from_slice(&[1.0, -2.0, 3.5]);
        assert_eq!(history.worst_component(&norm, &vectors, 3), 2);
        // Changes of 1, 1 and 2; quotients of the derivatives would be 2, 0.5 and 1.7.
        norm.inverse_weight[..3].fill(1.0);
        vectors.derivative[..3].copy_from_slice(&[2.0, -1.0, 5.0]);
        assert_eq!(history.worst_component(&norm, &vectors, 3), 2);
        // Only controlled components count, and one that is not a number comes first.
        assert_eq!(history.worst_component(&norm, &vectors, 0), 0);
        vectors.derivative[1] = f64::NAN;
        assert_eq!(history.worst_component(&norm, &vectors, 3), 1);
    }

    #[test]
    fn the_order_may_rise_after_one_more_equal_step_than_its_number() {
        let mut history = History::new(1);
        history.coefficients.equal_steps = 3;
        assert!(history.may_raise(2, 12));
        assert!(!history.may_raise(3, 12));
        assert!(history.may_raise(2, 3));
        assert!(!history.may_raise(2, 2));
    }

    #[test]
    fn indices_beyond_the_highest_order_are_not_like_a_history() {
        let like = History::new(1);
        let changed = |order: usize, equal_steps: usize| {
            let mut history = History::new(1);
            history.last_order = order;
            history.coefficients.equal_steps = equal_steps;
            history.is_like(&like)
        };
        assert!(changed(MAX_ORDER, MAX_ORDER + 1));
        assert!(!changed(MAX_ORDER + 1, 0));
        assert!(!changed(0, MAX_ORDER + 2));
    }

    #[test]
    fn the_implicit_weight_of_equal_steps_is_that_of_adams_and_moulton() {
        let mut history = History::new(1);
        let mut step = NextStep::new();
        step.size = 0.5;
        for (order, share) in [(1, 1.0), (2, 0.5), (3, 5.0 / 12.0)] {
            step.order = order;
            history.update_coefficients(&step);
            (history.last_order, history.last_step_size) = (order, step.size);
            assert!((history.gamma(&step) - 0.5 * share).abs() < 1e-15);
        }
    }

    #[test]
    fn damping_adds_to_the_implicit_weight_and_to_the_error_at_order_two_alone() {
        let mut history = History::new(1);
        let mut norm = ErrorNorm::new(1);
        norm.inverse_weight[0] = 1.0;
        let mut step = NextStep::new();
        step.size = 0.5;
        for order in 1..=3 {
            step.order = order;
            step.damping = 0.0;
            history.update_coefficients(&step);
            (history.last_order, history.last_step_size) = (order, step.size);
            let found = |step: &NextStep| {
                let estimate = history.estimate_from(step, &norm, [4.0, 0.0, 0.0]);
                (history.gamma(step), estimate.local, estimate.at_order)
            };
            let without = found(&step);
            step.damping = 0.25;
            let with = found(&step);
            let share = if order == 2 { 0.125 } else { 0.0 };
            // The norm of the sum is two.
            assert!((with.0 - without.0 - share).abs() < 1e-15);
            assert!((with.1 - without.1 - 2.0 * share).abs() < 1e-15);
            assert_eq!(with.2, without.2);
        }
    }
}
