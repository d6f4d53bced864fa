//! The integrator: its parts, its state at the time reached, and the dense output of the last step.

use serde::{Deserialize, Serialize};

use super::alternation::Alternation;
use super::convergence::NewtonConvergence;
use super::dense_output::DenseOutput;
use super::history::History;
use super::next_step::NextStep;
use super::order_control::SAFE_ERROR;
use super::stability::FastestRate;
use super::step::{Counts, StepFailure};
use super::switching_evidence::CorrectorSwitching;
use super::vectors::Vectors;
use super::weights::ErrorNorm;
use super::{MAX_ORDER, OdeSystem, StepControl};
use crate::math::simd::InstructionSet;

/// Smallest length \[m\] that event screening may skip, at any accuracy.
///
/// Ten times the default accuracy (decision 24): an event that is missed by less repeats no step.
const LEAST_ALLOWED: f64 = 1e-9;

/// Rounding of a sum in the norm: two units in the last place, the `TWOU` of DE/STEP.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// Tolerance over rounding below which sums are compensated.
///
/// Chosen by Shampine and Gordon (subroutine STEP, `NORND`). Doubled: runs whose tolerance is 100 to 200 roundings of the solution
/// compensate, too.
const COMPENSATED_BELOW: f64 = 100.0;

/// Lower bound of the time scale |y|/|f| of the first step \[s\].
///
/// Prevents a first step of zero where the initial values are zero.
const SHORTEST_SCALE: f64 = 1e-6;

/// Steps between two checks of the tolerances against rounding.
///
/// The check is a pass over all components, and a solution grows towards rounding in many steps. Doubled: a tolerance below rounding is
/// found up to 16 steps later.
const STEPS_PER_TOLERANCE_CHECK: u64 = 16;

/// Variable-order, variable-step Adams integrator.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Adams {
    pub(super) control: StepControl,
    /// Time reached \[s\].
    pub(super) time: f64,
    /// No step has been made since the last restart.
    pub(super) starting: bool,
    pub(super) vectors: Vectors,
    pub(super) norm: ErrorNorm,
    pub(super) history: History,
    pub(super) next: NextStep,
    /// Largest rate of the system in the last steps.
    pub(super) fastest: FastestRate,
    pub(super) convergence: NewtonConvergence,
    pub(super) alternation: Alternation,
    pub(super) switching: CorrectorSwitching,
    pub(super) counts: Counts,
    #[serde(skip)]
    pub(super) instructions: InstructionSet,
}

impl Adams {
    /// Return an integrator for systems of `dimension` components; [`Self::restart`] sets its initial values.
    #[must_use]
    pub fn new(dimension: usize, control: StepControl) -> Self {
        Self {
            control,
            time: 0.0,
            starting: true,
            vectors: Vectors::new(dimension),
            norm: ErrorNorm::new(dimension),
            history: History::new(dimension),
            next: NextStep::new(),
            fastest: FastestRate::default(),
            convergence: NewtonConvergence::new(),
            alternation: Alternation::new(dimension / 2),
            switching: CorrectorSwitching::new(),
            counts: Counts::default(),
            instructions: InstructionSet::detect_for(dimension),
        }
    }

    /// Use this instruction set in place of the fastest one for the dimension.
    pub fn use_instructions(&mut self, instructions: InstructionSet) {
        self.instructions = instructions;
    }

    /// Return the instruction set in use.
    #[must_use]
    pub fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Return the tolerances and limits.
    #[must_use]
    pub fn control(&self) -> StepControl {
        self.control
    }

    /// Return whether this integrator can replace `other`: equal vector lengths, a finite solution and valid orders.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.vectors.lengths() == other.vectors.lengths()
            && self.norm.inverse_weight.len() == other.norm.inverse_weight.len()
            && self.history.is_like(&other.history)
            && self.alternation.is_like(&other.alternation)
            && self.time.is_finite()
            && self.vectors.y.iter().all(|y| y.is_finite())
            && (1..=MAX_ORDER).contains(&self.next.order)
    }

    /// Set a component and its history to zero; for components without any effect at present.
    pub(crate) fn reset_component(&mut self, component: usize) {
        self.vectors.y[component] = 0.0;
        self.history.differences.reset_component(component);
    }

    /// Put a component of the solution elsewhere; what is known of its derivative stays.
    pub(crate) fn set_component(&mut self, component: usize, value: f64) {
        self.vectors.y[component] = value;
    }

    /// Return the solution, to be put elsewhere; what is known of its derivative stays.
    pub(crate) fn solution_mut(&mut self) -> &mut [f64] {
        &mut self.vectors.y[..self.vectors.dimension]
    }

    /// Restart at (`t`, `y`) without history, with the explicit corrector.
    pub fn restart(&mut self, t: f64, y: &[f64]) {
        self.restart_with_corrector(t, y);
        self.switching = CorrectorSwitching::new();
    }

    /// Restart at (`t`, `y`) without history, with the corrector in use; for systems whose stiffness did not change.
    pub fn restart_with_corrector(&mut self, t: f64, y: &[f64]) {
        self.time = t;
        self.vectors.y[..self.vectors.dimension].copy_from_slice(y);
        self.history.last_order = 0;
        self.starting = true;
    }

    /// Begin with the implicit corrector, where the choice is free.
    ///
    /// For systems that are stiff at the start. The explicit corrector would be unstable up to its error test, and excite vibrations that are
    /// not those of the system (decision 21).
    pub fn begin_implicit(&mut self) {
        self.switching.implicit = true;
    }

    /// Return whether no step has been made since the last restart.
    #[must_use]
    pub fn is_starting(&self) -> bool {
        self.starting
    }

    /// Return the time reached \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Return the solution at [`Self::time`].
    #[must_use]
    #[inline]
    pub fn y(&self) -> &[f64] {
        &self.vectors.y[..self.vectors.dimension]
    }

    /// Return γ \[s\] and the velocities of the last step's last correction, which Newton's method makes after its last evaluation; `None` after
    /// an explicit step, whose last evaluation was at its end.
    #[must_use]
    pub fn correction_after_evaluation(&self) -> Option<(f64, &[f64])> {
        let velocities = self.vectors.dimension / 2;
        let gamma = self.convergence.gamma;
        (gamma > 0.0).then(|| (gamma, &self.vectors.residual[..velocities]))
    }

    /// Return whether the last step was one of Newton's method with a single correction.
    #[must_use]
    pub fn ended_with_first_correction(&self) -> bool {
        self.convergence.unmeasured
    }

    /// Return the counts of work.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Return the size of the next step \[s\].
    #[must_use]
    pub fn step_size(&self) -> f64 {
        self.next.size
    }

    /// Limit the next step, the first one included, to `longest` \[s\].
    pub fn limit_step(&mut self, longest: f64) {
        self.next.limit(longest, self.time);
    }

    /// Return the solution at `t` inside the last step.
    #[must_use]
    pub fn dense(&self, t: f64) -> DenseOutput<'_> {
        self.history.dense(t - self.time, self.y())
    }

    /// Write the solution at `t` inside the last step.
    pub fn interpolate(&self, t: f64, y: &mut [f64]) {
        self.dense(t).write(self.instructions, y);
    }

    /// Return the length that event screening may skip in a step \[m\].
    pub(super) fn allowed(&self) -> f64 {
        self.control.accuracy.max(LEAST_ALLOWED)
    }

    /// Return the norm of a vector of all components.
    pub(super) fn norm_of(&self, values: &[f64]) -> f64 {
        self.norm.of(self.instructions, values)
    }

    /// Check the tolerances against rounding, now and then.
    ///
    /// # Errors
    /// When half of the tolerance is below the rounding of the solution.
    #[inline]
    pub(super) fn check_tolerances(&self, controlled: usize) -> Result<(), StepFailure> {
        let due = (self.counts.steps).is_multiple_of(STEPS_PER_TOLERANCE_CHECK);
        if self.starting || due {
            self.compare_with_rounding(controlled)
        } else {
            Ok(())
        }
    }

    #[inline(never)] // one step in many calls it
    fn compare_with_rounding(&self, controlled: usize) -> Result<(), StepFailure> {
        let (y, weights) = (&self.vectors.y, &self.norm.inverse_weight);
        let rounding = ROUNDING * self.norm_of(y);
        let size = |i: usize| (y[i] * weights[i]).abs();
        if rounding > SAFE_ERROR {
            let component = (0..controlled).max_by(|&a, &b| size(a).total_cmp(&size(b)));
            let component = component.unwrap_or(0);
            return Err(StepFailure::ToleranceTooSmall {
                time: self.time,
                step_size: self.next.size,
                factor: rounding / SAFE_ERROR,
                value: y[component],
                component,
            });
        }
        Ok(())
    }

    /// Evaluate the derivative at the initial values and choose the first step.
    pub(super) fn start(&mut self, system: &mut impl OdeSystem) {
        self.vectors.evaluate_at_solution(system, self.time);
        self.counts.evaluations += 1;
        let size = self.norm_of(&self.vectors.y);
        let compensate = SAFE_ERROR <= COMPENSATED_BELOW * (ROUNDING * size);
        self.history.restart(&self.vectors.derivative, compensate);
        let slope = self.norm_of(&self.vectors.derivative);
        let scale = if slope > 0.0 { size / slope } else { 1.0 };
        let scale = scale.max(SHORTEST_SCALE);
        self.next.start(&self.control, self.time, scale, slope);
        self.starting = false;
        self.fastest = FastestRate::default();
        self.convergence.restart();
    }

    /// Undo the prediction of a rejected step and take `next` \[s\] as the next step size.
    ///
    /// # Errors
    /// When `next` is lost in the rounding of time.
    pub(super) fn undo_step(&mut self, next: f64, controlled: usize) -> Result<(), StepFailure> {
        let (time, failed) = (self.time, self.next.size);
        let possible = self.next.exceeds_rounding(next, time);
        // The predicted derivative of the failed step is in the table until the prediction is undone.
        let component = if possible {
            0
        } else {
            (self.history).worst_component(&self.norm, &self.vectors, controlled)
        };
        self.history.undo_prediction(self.instructions, &self.next);
        self.next.size = next;
        if possible {
            return Ok(());
        }
        let finite = self
            .vectors
            .derivative
            .iter()
            .all(|value| value.is_finite());
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
}

#[cfg(test)]
mod tests;
