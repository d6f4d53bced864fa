//! One step of the Adams-Bashforth-Moulton method, told as a story; the details wait in the files beside it.

use crate::error::Error;
use serde::{Deserialize, Serialize};

use super::coefficients::Coefficients;
use super::corrector_switching::{CorrectorSwitching, STEPS_PER_CHECK};
use super::dense_output::DenseOutput;
use super::difference_kernels::{Correction, Errors};
use super::differences::Differences;
use super::order_control::{ErrorEstimate, choose_order, choose_step, gamma_star};
use super::stability::FastestRate;
use super::{Corrector, MAX_ORDER, OdeSystem, SecondOrderSystem, StepControl};
use crate::math::simd::{InstructionSet, Numbers, padded_zeros};

/// What is shorter \[m\] may be jumped over at any accuracy.
const LEAST_ALLOWED: f64 = 1e-9;

/// A step that was accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Where it began \[s\].
    pub start: f64,
    /// Where it ended \[s\].
    pub end: f64,
    /// Order of its predictor.
    pub order: usize,
}

/// Why a step could not be made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepFailure {
    /// The step size fell to rounding.
    TooSmall {
        /// Time reached \[s\].
        time: f64,
        /// The step that failed \[s\].
        step_size: f64,
        /// Component with the largest error.
        component: usize,
    },
    /// The derivative is not a number, however small the step.
    NotFinite {
        /// Time reached \[s\].
        time: f64,
        /// The step that failed \[s\].
        step_size: f64,
        /// First component that is not a number.
        component: usize,
    },
    /// The tolerances are below rounding.
    ToleranceTooSmall {
        /// Time reached \[s\].
        time: f64,
        /// The step that would be next \[s\].
        step_size: f64,
        /// By what factor they would have to grow.
        factor: f64,
        /// Component that is largest beside its tolerance.
        component: usize,
    },
}

impl StepFailure {
    /// What this failure means for a run; `name` turns time and component into words.
    pub(crate) fn into_error(self, name: impl FnOnce(f64, usize) -> String) -> Error {
        match self {
            Self::TooSmall {
                time,
                step_size,
                component,
            } => Error::StepTooSmall {
                time,
                step_size,
                culprit: name(time, component),
            },
            Self::NotFinite {
                time,
                step_size,
                component,
            } => Error::NotFinite {
                time,
                step_size,
                culprit: name(time, component),
            },
            Self::ToleranceTooSmall {
                time,
                step_size,
                factor,
                component,
            } => Error::ToleranceTooSmall {
                time,
                step_size,
                factor,
                culprit: name(time, component),
            },
        }
    }
}

/// Work done so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the derivative.
    pub evaluations: u64,
    /// Matrices that the implicit corrector factorised.
    pub jacobians: u64,
}

/// The integrator and all that it carries from step to step.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Adams {
    pub(super) control: StepControl,
    pub(super) time: f64,
    pub(super) step_size: f64,
    pub(super) order: usize,
    pub(super) last_step_size: f64,
    pub(super) last_order: usize,
    /// No step is to be longer for now \[s\].
    longest_step: f64,
    /// Below this, a step is lost in rounding \[s\].
    pub(super) smallest_step: f64,
    /// Nothing is known yet: the first step has to evaluate the slope at its start.
    pub(super) starting: bool,
    /// While the solution is smooth from the start on, order and step size grow with every step.
    pub(super) growing: bool,
    pub(super) dimension: usize,
    /// The arrays below are padded with zeros.
    pub(super) y: Numbers,
    pub(super) slope: Numbers,
    pub(super) predicted: Numbers,
    pub(super) inverse_weight: Numbers,
    pub(super) coefficients: Coefficients,
    pub(super) differences: Differences,
    pub(super) counts: Counts,
    /// Scratch: the solution being sought by the implicit corrector; its residual, or the slope at an explicit prediction.
    pub(super) trial: Numbers,
    pub(super) residual: Numbers,
    /// Share of a sum of squares over the weights that its norm is the root of.
    pub(super) norm_factor: f64,
    /// The fastest rate of the system met lately.
    pub(super) fastest: FastestRate,
    /// Size of the second correction of Newton's method over the square of the first one, both in units of the tolerance, when it
    /// was last measured; more since; infinite when nothing is known of it.
    pub(super) contraction: f64,
    /// Whether the last step of Newton's method ended with its first correction, convergence_unmeasured.
    pub(super) convergence_unmeasured: bool,
    /// Which corrector, where both are allowed.
    pub(super) switching: CorrectorSwitching,
    #[serde(skip)]
    pub(super) instructions: InstructionSet,
}

impl Adams {
    /// An integrator for systems of `dimension`; give it a start with [`Self::restart`].
    #[must_use]
    pub fn new(dimension: usize, control: StepControl) -> Self {
        Self {
            control,
            time: 0.0,
            step_size: 0.0,
            order: 1,
            last_step_size: 0.0,
            last_order: 0,
            longest_step: f64::INFINITY,
            smallest_step: 0.0,
            starting: true,
            growing: true,
            dimension,
            y: padded_zeros(dimension),
            slope: padded_zeros(dimension),
            predicted: padded_zeros(dimension),
            inverse_weight: padded_zeros(dimension),
            coefficients: Coefficients::new(),
            differences: Differences::new(dimension),
            counts: Counts::default(),
            trial: padded_zeros(dimension),
            residual: padded_zeros(dimension),
            norm_factor: 1.0,
            fastest: FastestRate::default(),
            contraction: f64::INFINITY,
            convergence_unmeasured: false,
            switching: CorrectorSwitching::new(),
            instructions: InstructionSet::detect_for(dimension),
        }
    }

    /// Goes on with other instructions than those that are best here for its dimension.
    pub fn use_instructions(&mut self, instructions: InstructionSet) {
        self.instructions = instructions;
    }

    /// The instructions in use.
    #[must_use]
    pub fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Tolerances and limits.
    #[must_use]
    pub fn control(&self) -> StepControl {
        self.control
    }

    /// Whether it can go on in the place of `other`: arrays of the same lengths, a solution of numbers, orders that exist.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let lengths = |adams: &Self| {
            let (solution, slope) = (adams.y.len(), adams.slope.len());
            let scratch = (adams.predicted.len(), adams.inverse_weight.len());
            let implicit = (adams.trial.len(), adams.residual.len());
            (adams.dimension, solution, slope, scratch, implicit)
        };
        lengths(self) == lengths(other)
            && self.differences.is_like(&other.differences)
            && self.time.is_finite()
            && self.y.iter().all(|y| y.is_finite())
            && (1..=MAX_ORDER).contains(&self.order)
            && self.last_order <= MAX_ORDER
            && self.coefficients.equal_steps <= MAX_ORDER + 1
    }

    /// Makes a component zero, with a past in which it was never anything else; for those that nothing feels just then.
    pub(crate) fn reset_component(&mut self, component: usize) {
        self.y[component] = 0.0;
        self.differences.reset_component(component);
    }

    /// Begins anew at (`t`, `y`) and forgets the history.
    pub fn restart(&mut self, t: f64, y: &[f64]) {
        self.restart_with_corrector(t, y);
        self.switching = CorrectorSwitching::new();
    }

    /// The same, of a system that is as stiff as it was: with the corrector in use.
    pub fn restart_with_corrector(&mut self, t: f64, y: &[f64]) {
        self.time = t;
        self.y[..self.dimension].copy_from_slice(y);
        self.last_order = 0;
        self.starting = true;
    }

    /// Whether no step was made since the start, or since the last restart.
    #[must_use]
    pub fn is_starting(&self) -> bool {
        self.starting
    }

    /// Time reached \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Solution at [`Self::time`].
    #[must_use]
    pub fn y(&self) -> &[f64] {
        &self.y[..self.dimension]
    }

    /// Writes the slope at [`Self::time`], once a step has been made.
    pub fn write_slope(&self, slope: &mut [f64]) {
        self.differences.write_slope(slope);
    }

    /// Whether the last evaluation was farther from [`Self::y`] than a small part of the tolerance: at a prediction that was then
    /// corrected, about by the tolerance.
    #[must_use]
    pub fn evaluation_differs_from_solution(&self) -> bool {
        self.convergence_unmeasured
    }

    /// Work done so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Size of the next step \[s\].
    #[must_use]
    pub fn step_size(&self) -> f64 {
        self.step_size
    }

    /// Makes the next step no longer than `longest` \[s\], the first one included.
    pub fn limit_step(&mut self, longest: f64) {
        self.longest_step = longest;
        let least = 4.0 * f64::EPSILON * self.time.abs();
        if longest < self.step_size {
            self.step_size = longest.max(least);
        }
    }

    /// Whether a step of size `h` is half of what is allowed at all, or more.
    pub(super) fn is_near_longest(&self, h: f64) -> bool {
        h >= 0.5 * self.control.max_step.min(self.longest_step)
    }

    /// Order of the next step.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The solution at `t` inside the last step.
    #[must_use]
    pub fn dense(&self, t: f64) -> DenseOutput<'_> {
        DenseOutput::new(
            t - self.time,
            self.last_order,
            &self.coefficients.psi,
            self.y(),
            &self.differences,
        )
    }

    /// Writes the solution at `t` inside the last step.
    pub fn interpolate(&self, t: f64, y: &mut [f64]) {
        self.dense(t).write(y);
    }

    /// Makes one step with the explicit corrector, of any system.
    ///
    /// # Errors
    /// When the step size falls to rounding or the tolerances are below it.
    pub fn step(&mut self, system: &mut impl OdeSystem) -> Result<Step, StepFailure> {
        self.update_weights(system);
        self.step_with_weights(system)
    }

    /// The same of a system of second order; looks out for the implicit one where it may change.
    pub(super) fn step_pece(
        &mut self,
        system: &mut impl SecondOrderSystem,
    ) -> Result<Step, StepFailure> {
        self.update_weights_by_scale(system, false);
        let step = self.step_with_weights(system)?;
        let looks = self.counts.steps.is_multiple_of(u64::from(STEPS_PER_CHECK));
        if looks && self.control.corrector == Corrector::Auto {
            self.check_switch_to_implicit(system);
        }
        Ok(step)
    }

    fn step_with_weights(&mut self, system: &mut impl OdeSystem) -> Result<Step, StepFailure> {
        let controlled = system.controlled();
        // What grows towards rounding does so in many steps.
        if self.starting || self.counts.steps.is_multiple_of(16) {
            self.check_tolerances(controlled)?;
        }
        if self.starting {
            self.start(system);
        }
        let begin = self.time;
        let mut failures = 0;
        let mut estimate;
        loop {
            self.predict();
            self.evaluate_prediction(system);
            estimate = self.estimate_and_correct();
            if estimate.accepts() {
                if system.accepts_step(self.step_size, self.allowed()) {
                    break;
                }
            } else {
                failures += 1;
            }
            self.reject_step(&estimate, failures, controlled)?;
        }
        let above = self.correct_and_evaluate(system);
        self.choose_order_and_step(&estimate, above);
        Ok(Step {
            start: begin,
            end: self.time,
            order: self.last_order,
        })
    }

    /// Length that a step may jump over \[m\].
    pub(super) fn allowed(&self) -> f64 {
        self.control.accuracy.max(LEAST_ALLOWED)
    }

    fn check_tolerances(&self, controlled: usize) -> Result<(), StepFailure> {
        let rounding = 2.0 * f64::EPSILON * self.norm(&self.y);
        if rounding > 0.5 {
            let size = |i: usize| (self.y[i] * self.inverse_weight[i]).abs();
            return Err(StepFailure::ToleranceTooSmall {
                time: self.time,
                step_size: self.step_size,
                factor: 2.0 * rounding,
                component: (0..controlled)
                    .max_by(|&a, &b| size(a).total_cmp(&size(b)))
                    .unwrap_or(0),
            });
        }
        Ok(())
    }

    /// The slope at the start and a first step that a method of order one would accept.
    pub(super) fn start(&mut self, system: &mut impl OdeSystem) {
        system.derivative(
            self.time,
            &self.y[..self.dimension],
            &mut self.slope[..self.dimension],
        );
        self.counts.evaluations += 1;
        let rounding = 2.0 * f64::EPSILON * self.norm(&self.y);
        self.differences
            .restart(&self.slope, 0.5 <= 100.0 * rounding);
        let slope = self.norm(&self.slope);
        let scale = if slope > 0.0 {
            self.norm(&self.y) / slope
        } else {
            1.0
        };
        let mut h = self.control.max_step.min(scale.max(1e-6));
        h = h.min(self.longest_step);
        if 16.0 * slope * h * h > 1.0 {
            h = 0.25 / slope.sqrt();
        }
        // A slope beyond all numbers asks for a step of nothing, which no failure would make smaller.
        let rounding = 4.0 * f64::EPSILON * self.time.abs().max(1e-3 * h);
        self.smallest_step = rounding.max(f64::MIN_POSITIVE);
        self.step_size = h.max(self.smallest_step);
        self.order = 1;
        self.last_step_size = 0.0;
        self.last_order = 0;
        self.coefficients = Coefficients::new();
        self.starting = false;
        self.growing = true;
        self.fastest = FastestRate::default();
        self.contraction = f64::INFINITY;
    }

    /// Coefficients of a step of the present size and order, and the prediction.
    pub(super) fn predict(&mut self) {
        self.update_coefficients();
        self.differences.predict(
            self.instructions,
            &self.coefficients,
            self.order,
            self.step_size,
            &self.y,
            &mut self.predicted,
        );
    }

    pub(super) fn update_coefficients(&mut self) {
        self.coefficients.update(
            self.step_size,
            self.order,
            self.last_step_size,
            self.last_order,
        );
    }

    fn evaluate_prediction(&mut self, system: &mut impl OdeSystem) {
        system.derivative(
            self.time + self.step_size,
            &self.predicted[..self.dimension],
            &mut self.slope[..self.dimension],
        );
        self.counts.evaluations += 1;
    }

    /// Errors of this step and, had steps been equal, of the two orders below.
    pub(super) fn estimate_error(&self) -> ErrorEstimate {
        let rows = self.differences.rows_of_errors(self.order);
        self.estimate_from(self.instructions.run(Errors {
            dimension: self.dimension,
            slope: &self.slope,
            rows,
            inverse_weight: &self.inverse_weight,
            correction: None,
        }))
    }

    /// The same, and the corrected solution as what is tried.
    fn estimate_and_correct(&mut self) -> ErrorEstimate {
        let rows = self.differences.rows_of_errors(self.order);
        let sums = self.instructions.run(Errors {
            dimension: self.dimension,
            slope: &self.slope,
            rows,
            inverse_weight: &self.inverse_weight,
            correction: Some(Correction {
                weight: self.step_size * self.coefficients.g[self.order],
                predicted: &self.predicted,
                corrected: &mut self.trial,
            }),
        });
        self.estimate_from(sums)
    }

    /// The same from sums of squares at the order and, where they are asked for, below.
    pub(super) fn estimate_from(&self, [at, one, two]: [f64; 3]) -> ErrorEstimate {
        let (k, h) = (self.order, self.step_size);
        let mean = |sum: f64| h * self.norm_of(sum);
        let c = &self.coefficients;
        let at = mean(at);
        ErrorEstimate {
            local: at * (c.g[k - 1] - c.g[k]),
            at_order: at * c.sigma[k] * gamma_star(k),
            one_below: if k >= 2 {
                mean(one) * c.sigma[k - 1] * gamma_star(k - 1)
            } else {
                0.0
            },
            two_below: if k >= 3 {
                mean(two) * c.sigma[k - 2] * gamma_star(k - 2)
            } else {
                0.0
            },
        }
    }

    /// Takes a failed step back and makes it smaller; from the third failure on at order one.
    fn reject_step(
        &mut self,
        estimate: &ErrorEstimate,
        failures: u32,
        controlled: usize,
    ) -> Result<(), StepFailure> {
        self.counts.rejected += 1;
        self.growing = false;
        let failed = self.step_size;
        let mut shrink = 0.5;
        if failures > 3 && 0.5 < 0.25 * estimate.at_order && estimate.at_order.is_finite() {
            shrink = (0.5 / estimate.at_order).sqrt();
        }
        self.check_size(shrink * failed, controlled)?;
        self.undo_prediction();
        if failures >= 3 {
            self.order = 1;
        } else if estimate.prefers_lower(self.order) {
            self.order -= 1;
        }
        self.step_size = shrink * failed;
        Ok(())
    }

    /// Takes the present prediction back.
    pub(super) fn undo_prediction(&mut self) {
        self.differences
            .undo_prediction(self.instructions, &self.coefficients, self.order);
        self.coefficients
            .undo_prediction(self.order, self.step_size);
    }

    /// An error when the next try would be lost in rounding, at `next` \[s\].
    pub(super) fn check_size(&mut self, next: f64, controlled: usize) -> Result<(), StepFailure> {
        let (time, failed) = (self.time, self.step_size);
        self.smallest_step = self.smallest_step.max(4.0 * f64::EPSILON * time.abs());
        if next >= self.smallest_step {
            return Ok(());
        }
        let component = self.worst_component(controlled);
        let finite = self.slope.iter().all(|slope| slope.is_finite());
        self.undo_prediction();
        self.step_size = next;
        Err(if finite {
            StepFailure::TooSmall {
                time,
                step_size: failed,
                component,
            }
        } else {
            StepFailure::NotFinite {
                time,
                step_size: failed,
                component,
            }
        })
    }

    /// The component whose slope was foretold worst, or is not a number.
    pub(super) fn worst_component(&self, controlled: usize) -> usize {
        let error = |i: usize| {
            ((self.slope[i] - self.differences.row(0)[i]) * self.inverse_weight[i]).abs()
        };
        (0..controlled)
            .find(|&i| error(i).is_nan())
            .or_else(|| (0..controlled).max_by(|&a, &b| error(a).total_cmp(&error(b))))
            .unwrap_or(0)
    }

    /// Takes the corrected solution and evaluates there; the norm of φ_{k+2}, where the order may be raised.
    fn correct_and_evaluate(&mut self, system: &mut impl OdeSystem) -> f64 {
        let (k, h) = (self.order, self.step_size);
        self.last_order = k;
        self.last_step_size = h;
        self.time += h;
        self.convergence_unmeasured = false;
        if self.differences.carries() {
            let weight = h * self.coefficients.g[k];
            self.differences
                .correct(weight, &self.predicted, &self.slope, &mut self.trial);
        }
        std::mem::swap(&mut self.y, &mut self.trial);
        // The slope at the prediction is kept for what the change from it tells.
        std::mem::swap(&mut self.slope, &mut self.residual);
        system.derivative(
            self.time,
            &self.y[..self.dimension],
            &mut self.slope[..self.dimension],
        );
        let above = self.differences.update(
            self.instructions,
            k,
            &self.slope,
            &self.inverse_weight,
            self.may_raise(),
        );
        self.counts.evaluations += 1;
        self.counts.steps += 1;
        self.norm_of(above)
    }

    /// Whether steps have been equal for long enough to raise the order of the last one.
    pub(super) fn may_raise(&self) -> bool {
        self.last_order < self.coefficients.equal_steps && self.last_order < self.control.max_order
    }

    fn choose_order_and_step(&mut self, estimate: &ErrorEstimate, above: f64) {
        let (k, h) = (self.order, self.step_size);
        if estimate.prefers_lower(k) || k >= self.control.max_order {
            self.growing = false;
        }
        if self.growing {
            self.order = k + 1;
            self.step_size = (2.0 * h).min(self.control.max_step);
            return;
        }
        let choice = choose_order(
            k,
            self.control.max_order,
            estimate,
            self.may_raise(),
            || h * gamma_star(k + 1) * above,
        );
        self.order = choice.order;
        self.step_size = choose_step(h, choice.order, choice.error)
            .max(4.0 * f64::EPSILON * self.time.abs())
            .min(self.control.max_step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(counts.evaluations, 1 + 2 * counts.steps + counts.rejected);
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
}
