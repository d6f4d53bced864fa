//! The explicit corrector: predict, evaluate, correct, evaluate (PECE), after subroutine STEP of Shampine and Gordon.

use super::adams::Adams;
use super::corrector_switching::STEPS_PER_CHECK;
use super::order_control::{ErrorEstimate, SAFE_ERROR, choose_order, choose_step, gamma_star};
use super::stability::explicit_limit;
use super::step::{Step, StepFailure};
use super::{Corrector, OdeSystem, SecondOrderSystem};

/// Factor of the step size after a rejected step.
///
/// The value of DE/STEP. Doubled: a rejected step would be repeated without change.
const REJECTED: f64 = 0.5;

/// Failures of one step after which the order is one.
///
/// The value of DE/STEP: repeated failures show a discontinuity, at which a higher order gains nothing.
pub(super) const FAILURES_TO_ORDER_ONE: u32 = 3;

/// Difference of the two derivatives of a first step, times its size, over the tolerance, that is tolerated at any step size.
const NEGLIGIBLE_AT_START: f64 = 1e-3;

impl Adams {
    /// Make one step of any system with the explicit corrector.
    ///
    /// # Errors
    /// When the step size or the tolerances are below rounding.
    pub fn step(&mut self, system: &mut impl OdeSystem) -> Result<Step, StepFailure> {
        let state = (&self.vectors.y[..], self.starting);
        (self.norm).update(self.instructions, &self.control, system, state);
        self.step_with_weights(system)
    }

    /// Make one step of a second-order system; consider the implicit corrector every few steps where the choice is automatic.
    pub(super) fn step_pece(
        &mut self,
        system: &mut impl SecondOrderSystem,
    ) -> Result<Step, StepFailure> {
        let state = (&self.vectors.y[..], self.starting);
        (self.norm).update_by_scale(self.instructions, &self.control, system, false, state);
        let step = self.step_with_weights(system)?;
        // The check is a pass over all velocities: not in every step.
        let due = self.counts.steps.is_multiple_of(u64::from(STEPS_PER_CHECK));
        if due && self.control.corrector == Corrector::Auto {
            self.check_switch_to_implicit(system);
        }
        Ok(step)
    }

    fn step_with_weights(&mut self, system: &mut impl OdeSystem) -> Result<Step, StepFailure> {
        let controlled = system.controlled();
        self.check_tolerances(controlled)?;
        let first = self.starting;
        if first {
            self.start(system);
        }
        let begin = self.time;
        let set = self.instructions;
        let mut failures = 0;
        let estimate = loop {
            self.history.predict(set, &self.next, &mut self.vectors);
            // P and E: predicted value p, f(p).
            let end = self.time + self.next.size;
            self.vectors.evaluate_at_prediction(system, end);
            self.counts.evaluations += 1;
            let estimate =
                self.history
                    .estimate_error(set, &self.next, &self.norm, &mut self.vectors, true);
            if !estimate.accepts() || (first && !self.is_stable_at_start(system)) {
                failures += 1;
            } else if system.accepts_step(self.next.size, self.allowed()) {
                break estimate;
            }
            // An event that both ends of the step do not show is no failure of the formula.
            self.reject_step(&estimate, failures, controlled)?;
        };
        // C and E: corrected value y, f(y), and the differences with it.
        let above = self.correct_and_evaluate(system);
        self.choose_order_and_step(&estimate, above);
        Ok(Step {
            start: begin,
            end: self.time,
            degree: self.history.last_order,
        })
    }

    /// Return whether the derivative at the corrected value of a first step agrees with that at its predicted value.
    ///
    /// The error estimate of a first step is that of its prediction. At rest it is small at any step size, also far beyond the limit of
    /// stability. Without history nothing else shows the fastest rate.
    fn is_stable_at_start(&mut self, system: &mut impl OdeSystem) -> bool {
        if self.history.differences.compensates() {
            return true; // the corrected value is not written yet
        }
        let (n, h) = (self.vectors.dimension, self.next.size);
        let vectors = &mut self.vectors;
        let change = &mut vectors.residual[..n];
        system.derivative(self.time + h, &vectors.trial[..n], change);
        self.counts.evaluations += 1;
        for (change, at_prediction) in change.iter_mut().zip(&vectors.derivative[..n]) {
            *change = h * (*change - at_prediction);
        }
        let change = self.norm_of(&self.vectors.residual);
        let vectors = &mut self.vectors;
        let ends = vectors.trial[..n].iter().zip(&vectors.predicted[..n]);
        for (moved, (corrected, predicted)) in vectors.residual.iter_mut().zip(ends) {
            *moved = corrected - predicted;
        }
        let moved = self.norm_of(&self.vectors.residual);
        // h |Δf|/|Δy| is the step size times the fastest rate. Below the first bound it may be rounding.
        change <= NEGLIGIBLE_AT_START || change <= explicit_limit(1) * moved
    }

    /// Undo a rejected step and reduce its size; from the third failure on use order one (block 3 of STEP).
    fn reject_step(
        &mut self,
        estimate: &ErrorEstimate,
        failures: u32,
        controlled: usize,
    ) -> Result<(), StepFailure> {
        self.counts.rejected += 1;
        self.next.growing = false;
        let error = estimate.at_order;
        let mut shrink = REJECTED;
        // The error of order one is about h²: its optimal size follows from the square root.
        // `P5EPS < 0.25 ERK` of DE/STEP: the optimal step is below half of the present one.
        let hopeless = SAFE_ERROR < 0.25 * error && error.is_finite();
        if failures > FAILURES_TO_ORDER_ONE && hopeless {
            shrink = (SAFE_ERROR / error).sqrt();
        }
        self.undo_step(shrink * self.next.size, controlled)?;
        // The first failures keep the order unless a lower one is better.
        let order = self.next.order;
        if failures >= FAILURES_TO_ORDER_ONE {
            self.next.order = 1;
        } else if estimate.prefers_lower(order) {
            self.next.order = order - 1;
        }
        Ok(())
    }

    /// Accept the corrected value, evaluate there and update the differences; return |φ_{k+2}| where the order may be raised.
    fn correct_and_evaluate(&mut self, system: &mut impl OdeSystem) -> f64 {
        let (k, h) = (self.next.order, self.next.size);
        let (history, vectors) = (&mut self.history, &mut self.vectors);
        self.time += h;
        self.convergence.unmeasured = false;
        self.convergence.gamma = 0.0;
        // Without compensation the corrected value was written with the error estimate.
        if history.differences.compensates() {
            let weight = h * history.coefficients.g[k];
            history.differences.correct(
                weight,
                &vectors.predicted,
                &vectors.derivative,
                &mut vectors.trial,
            );
        }
        std::mem::swap(&mut vectors.y, &mut vectors.trial);
        // Corrector switching compares the derivatives at both evaluations.
        std::mem::swap(&mut vectors.derivative, &mut vectors.residual);
        vectors.evaluate_at_solution(system, self.time);
        self.counts.evaluations += 1;
        self.counts.steps += 1;
        // φ_{k+2} is needed only where the order may rise.
        let raise = history.may_raise(k, self.control.max_order);
        history.update(self.instructions, (k, h), &self.norm, vectors, raise)
    }

    /// Choose the next order and step size (block 4 of STEP).
    fn choose_order_and_step(&mut self, estimate: &ErrorEstimate, above: f64) {
        let (k, h) = (self.next.order, self.next.size);
        let max_order = self.control.max_order;
        if (self.next).grow(estimate, (k, h), max_order, &self.control) {
            return;
        }
        let choice = choose_order(
            k,
            max_order,
            estimate,
            self.history.may_raise(k, max_order),
            // Error of one order more, from the difference φ_{k+2}.
            || h * gamma_star(k + 1) * above,
        );
        self.next.order = choice.order;
        let size = choose_step(h, choice.order, choice.error);
        self.next.set_size(size, &self.control, self.time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::StepControl;

    /// y' = y^2, y(0) = 1: y = 1/(1 - t).
    struct Riccati;

    impl OdeSystem for Riccati {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
            dydt[0] = y[0] * y[0];
        }
    }

    fn control(tolerance: f64) -> StepControl {
        StepControl {
            rtol: tolerance,
            atol: tolerance,
            max_step: f64::INFINITY,
            max_order: 12,
            ..StepControl::default()
        }
    }

    #[test]
    fn two_evaluations_a_step_and_one_a_rejected_one() {
        let mut adams = Adams::new(1, control(1e-8));
        adams.restart(0.0, &[1.0]);
        while adams.time() < 0.9 {
            adams.step(&mut Riccati).unwrap();
        }
        let counts = adams.counts();
        // One at the start, and one that tests the first step.
        assert_eq!(counts.evaluations, 2 + 2 * counts.steps + counts.rejected);
        assert!(counts.rejected > 0);
    }

    #[test]
    fn dense_output_meets_both_ends_of_a_step() {
        let mut adams = Adams::new(1, control(1e-10));
        adams.restart(0.0, &[1.0]);
        for _ in 0..40 {
            let before = adams.y()[0];
            let step = adams.step(&mut Riccati).unwrap();
            assert!((adams.dense(step.end).value(0) - adams.y()[0]).abs() < 1e-15 * adams.y()[0]);
            assert!((adams.dense(step.start).value(0) - before).abs() < 1e-8 * before);
        }
    }

    #[test]
    fn a_pole_ends_in_a_failure_that_names_time_and_step() {
        let mut adams = Adams::new(1, control(1e-8));
        adams.restart(0.0, &[1.0]);
        let failure = loop {
            match adams.step(&mut Riccati) {
                Ok(_) => assert!(adams.counts().steps < 1_000_000),
                Err(failure) => break failure,
            }
        };
        match failure {
            StepFailure::TooSmall { time, .. }
            | StepFailure::NotFinite { time, .. }
            | StepFailure::ToleranceTooSmall { time, .. } => {
                assert!((time - 1.0).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_slope_beyond_all_numbers_ends_in_a_failure() {
        struct Steep(f64);
        impl OdeSystem for Steep {
            fn dimension(&self) -> usize {
                1
            }
            fn derivative(&mut self, _t: f64, _y: &[f64], dydt: &mut [f64]) {
                dydt[0] = self.0;
            }
        }
        for slope in [f64::INFINITY, f64::NAN] {
            let mut adams = Adams::new(1, control(1e-8));
            adams.restart(0.0, &[0.0]);
            let failure = adams.step(&mut Steep(slope)).unwrap_err();
            let names = matches!(
                failure,
                StepFailure::TooSmall { time: 0.0, .. } | StepFailure::NotFinite { time: 0.0, .. }
            );
            assert!(names && adams.counts().rejected < 2000, "{failure:?}");
        }
    }

    #[test]
    fn tolerances_below_rounding_are_refused() {
        let mut adams = Adams::new(1, control(1e-17));
        adams.restart(0.0, &[1.0]);
        let failure = adams.step(&mut Riccati).unwrap_err();
        assert!(matches!(failure, StepFailure::ToleranceTooSmall { factor, .. } if factor > 1.0));
    }

    /// A constant beside y' = 1e-3 - 1e6 y: at any step size the error estimate of the first step from rest is below the tolerance.
    struct AlmostAtRest;

    impl OdeSystem for AlmostAtRest {
        fn dimension(&self) -> usize {
            2
        }
        fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
            dydt.copy_from_slice(&[0.0, 1e-3 - 1e6 * y[1]]);
        }
    }

    #[test]
    fn a_first_step_beyond_the_limit_of_stability_is_rejected() {
        let control = StepControl {
            max_step: 1e-4,
            ..control(1e-4)
        };
        let mut adams = Adams::new(2, control);
        adams.restart(0.0, &[1.0, 0.0]);
        let step = adams.step(&mut AlmostAtRest).unwrap();
        assert!(adams.counts().rejected > 2);
        assert!(step.end - step.start < 1e-5, "{step:?}");
        // y tends to 1e-9. A step of 1e-4 s has -5e-6 at its end.
        for part in [0.0, 0.3, 0.7, 1.0] {
            let inside = adams.dense(part * step.end).value(1);
            assert!(inside.abs() < 1e-7, "{inside:e}");
        }
    }

    /// An integrator without past behind a step of this order and a size of 1 s.
    fn behind_step(order: usize) -> Adams {
        let control = StepControl {
            max_step: 100.0,
            ..control(1e-3)
        };
        let mut adams = Adams::new(1, control);
        adams.restart(0.0, &[1.0]);
        adams.norm.update(
            adams.instructions,
            &adams.control,
            &Riccati,
            (&adams.vectors.y, true),
        );
        adams.start(&mut Riccati);
        adams.next.growing = false;
        (adams.next.order, adams.next.size) = (order, 1.0);
        let history = &mut adams.history;
        (history.last_order, history.last_step_size) = (order, 1.0);
        history.coefficients.equal_steps = 5;
        adams
    }

    fn errors(one_below: f64, at_order: f64) -> ErrorEstimate {
        ErrorEstimate {
            local: at_order,
            two_below: 0.0,
            one_below,
            at_order,
        }
    }

    #[test]
    fn rejected_steps_are_halved_until_the_fourth_failure_takes_the_step_of_order_one() {
        let rejected = |failures: u32, error: f64| {
            let mut adams = behind_step(5);
            let estimate = errors(2.0 * error, error);
            adams.reject_step(&estimate, failures, 1).unwrap();
            (adams.next.order, adams.next.size)
        };
        // The third failure leads to order one; only a later one has the error of that order.
        for (failures, order) in [(1, 5), (2, 5), (3, 1)] {
            assert_eq!(rejected(failures, 50.0), (order, REJECTED));
        }
        // The size for half of the tolerance, where it is below half of the size.
        assert_eq!(rejected(4, 50.0), (1, 0.1));
        assert_eq!(rejected(4, 2.1), (1, (0.5f64 / 2.1).sqrt()));
        assert_eq!(rejected(4, 1.9), (1, REJECTED));
        assert_eq!(rejected(4, f64::INFINITY), (1, REJECTED));
    }

    #[test]
    fn a_rejected_step_takes_a_lower_order_with_smaller_errors() {
        let order = |one_below: f64, failures: u32| {
            let mut adams = behind_step(5);
            adams
                .reject_step(&errors(one_below, 1.0), failures, 1)
                .unwrap();
            adams.next.order
        };
        assert_eq!([order(1.0, 1), order(1.1, 1), order(1.0, 3)], [4, 5, 1]);
    }

    #[test]
    fn the_order_rises_by_the_error_one_order_up() {
        let chosen = |error: f64| {
            let mut adams = behind_step(3);
            // The norm of φ_5 for this error of order four.
            let above = error / gamma_star(4);
            adams.choose_order_and_step(&errors(9.0, 2.0), above);
            (adams.next.order, adams.next.size)
        };
        let (order, size) = chosen(1.9);
        assert_eq!(order, 4);
        assert!((size - (0.5f64 / 1.9).powf(0.2)).abs() < 1e-14);
        assert_eq!(chosen(2.1).0, 3);
    }

    /// y' = y, with a derivative far from it in some evaluations from now on.
    #[derive(Clone)]
    struct Disturbed(u32);

    impl OdeSystem for Disturbed {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
            dydt[0] = y[0];
            if self.0 > 0 {
                self.0 -= 1;
                dydt[0] = 1e15;
            }
        }
    }

    #[test]
    fn three_failures_of_a_step_reduce_its_order_to_one() {
        let mut adams = Adams::new(1, control(1e-8));
        adams.restart(0.0, &[1.0]);
        for _ in 0..60 {
            adams.step(&mut Disturbed(0)).unwrap();
        }
        let rejected = adams.counts().rejected;
        // Lower orders are not better at the first failures: all errors are those of the disturbance.
        for failures in [1, 2, 3] {
            let mut adams = adams.clone();
            let step = adams.step(&mut Disturbed(failures)).unwrap();
            assert_eq!(step.degree == 1, failures == 3, "{failures}");
            assert!(adams.counts().rejected >= rejected + u64::from(failures));
        }
    }
}
