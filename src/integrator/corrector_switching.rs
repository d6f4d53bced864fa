//! Changes between the explicit and the implicit corrector while running: what a simulated second would cost with the other.

use serde::{Deserialize, Serialize};

use super::adams::{Adams, Step, StepFailure};
use super::difference_kernels::SlopeChange;
use super::order_control::gamma_star;
use super::stability::explicit_limit;
use super::{Corrector, SecondOrderSystem};

/// Cost of a step with Newton's method that ends with one correction, in evaluations: one, a matrix and a solution. Measured on the
/// published drive: 1.25 times an explicit step. A number and not the clock: the same run takes the same steps everywhere.
const IMPLICIT_COST: f64 = 2.5;

/// The same of a step that measures its convergence by a second correction: twice an explicit step.
const IMPLICIT_COST_OF_TWO: f64 = 4.0;

/// Cost of an explicit step.
const EXPLICIT_COST: f64 = 2.0;

/// Explicit steps are taken to be this times the fastest rate long where stability holds them. (The rate that Newton's method
/// shows is a lower bound: where the system is stiff its corrections are small.)
const EXPLICIT_REACH: f64 = 0.4;

/// An explicit step this near to its limit of stability is held by it.
const NEAR_LIMIT: f64 = 0.5;

/// Explicit steps of these orders gain nothing from it, whether stability holds them or contacts that begin and end.
const LOW_ORDER: usize = 4;

/// Error at order two, at the size of the explicit step and by the norm that Newton's method takes, below which that is expected
/// to make steps long enough to pay: 2.5 times as long.
const LONGER: f64 = 0.033;

/// A change has to make a simulated second cheaper by this factor.
const GAIN: f64 = 1.2;

/// Steps that have to speak for a change, net of those that speak against it; more where changes did not pay.
const SWITCH_THRESHOLD: u32 = 20;
const MAX_SWITCH_THRESHOLD: u32 = 1280;

/// A steps_since_switch of fewer steps than so many times the threshold did not pay.
const UNPROFITABLE_STAY: u32 = 5;

/// Explicit steps are looked at one in so many: a look at all components is a tenth of the integrator's own work.
pub(super) const STEPS_PER_CHECK: u32 = 4;

/// The corrector in use and what speaks for the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct CorrectorSwitching {
    implicit: bool,
    evidence: u32,
    /// Votes that a change from the explicit corrector, and from the implicit one, takes.
    threshold: [u32; 2],
    /// Steps since the last change.
    steps_since_switch: u32,
}

impl CorrectorSwitching {
    pub(super) fn new() -> Self {
        Self {
            implicit: false,
            evidence: 0,
            threshold: [SWITCH_THRESHOLD; 2],
            steps_since_switch: 0,
        }
    }

    /// Counts `steps` that speak for a change or against it; true when it is time.
    fn record(&mut self, change: bool, steps: u32) -> bool {
        self.steps_since_switch = self.steps_since_switch.saturating_add(steps);
        self.evidence = if change {
            self.evidence.saturating_add(steps)
        } else {
            self.evidence.saturating_sub(steps)
        };
        let (own, other) = (usize::from(self.implicit), usize::from(!self.implicit));
        if self.evidence < self.threshold[own] {
            return false;
        }
        // Where it did not pay to come here, it takes longer next time.
        self.threshold[other] =
            if self.steps_since_switch < self.threshold[own].saturating_mul(UNPROFITABLE_STAY) {
                self.threshold[other]
                    .saturating_mul(2)
                    .min(MAX_SWITCH_THRESHOLD)
            } else {
                SWITCH_THRESHOLD
            };
        self.implicit = !self.implicit;
        (self.evidence, self.steps_since_switch) = (0, 0);
        true
    }
}

impl Adams {
    /// Makes one step with the corrector that [`StepControl::corrector`](super::StepControl::corrector) names.
    ///
    /// # Errors
    /// When the step size falls to rounding or the tolerances are below it.
    pub fn step_second_order(
        &mut self,
        system: &mut impl SecondOrderSystem,
    ) -> Result<Step, StepFailure> {
        if self.is_implicit() {
            self.step_newton(system)
        } else {
            self.step_pece(system)
        }
    }

    /// Whether the next step is one of Newton's method.
    #[must_use]
    pub fn is_implicit(&self) -> bool {
        match self.control.corrector {
            Corrector::Auto => self.switching.implicit,
            Corrector::Pece => false,
            Corrector::Newton => true,
        }
    }

    /// After one of [`STEPS_PER_CHECK`] explicit steps: whether it made no use of a high order, or stability held it, although Newton's
    /// method at order two could make a longer one.
    pub(super) fn check_switch_to_implicit(&mut self, system: &impl SecondOrderSystem) {
        let rate = self.rate_from_slopes(system.coordinates());
        self.fastest.record_after(STEPS_PER_CHECK, rate);
        let (k, h) = (self.last_order, self.last_step_size);
        // A step near the longest allowed is not held by stability: Newton's method could not make it longer.
        let longest = self.is_near_longest(h);
        let unstable = || h * self.fastest.value() > NEAR_LIMIT * explicit_limit(k);
        let held = !longest && (k <= LOW_ORDER || unstable());
        let share = self.mean_square_factor(system.controlled()).sqrt();
        let at_order_two = || share * h * gamma_star(2) * self.norm_of_difference(2);
        let pays = held && (k < 2 || at_order_two() <= LONGER);
        self.switching.record(pays, STEPS_PER_CHECK);
    }

    /// After a step of Newton's method: whether explicit ones would be long enough to be cheaper.
    pub(super) fn check_switch_to_explicit(&mut self) {
        let h = self.step_size;
        let explicit = h.min(EXPLICIT_REACH / self.fastest.value());
        let cost = if self.convergence_unmeasured {
            IMPLICIT_COST
        } else {
            IMPLICIT_COST_OF_TWO
        };
        let pays = explicit / EXPLICIT_COST > GAIN * h / cost;
        if self.switching.record(pays, 1) {
            self.step_size = explicit;
        }
    }

    /// Rate \[1/s\] at which accelerations changed with velocities between the two evaluations of an explicit step.
    fn rate_from_slopes(&self, coordinates: usize) -> f64 {
        let velocities = coordinates..2 * coordinates;
        let [accelerations, speeds] = self.instructions.run(SlopeChange {
            slope: &self.slope[velocities.clone()],
            at_prediction: &self.residual[velocities.clone()],
            ends: (
                &self.predicted[velocities.clone()],
                &self.y[velocities.clone()],
            ),
            inverse_weight: &self.inverse_weight[velocities],
        });
        if speeds > 0.0 {
            (accelerations / speeds).sqrt()
        } else {
            0.0
        }
    }
}
