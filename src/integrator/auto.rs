//! Changes between the explicit and the implicit corrector while running: what a simulated second would cost with the other.

use serde::{Deserialize, Serialize};

use super::adams::{Adams, Step, StepFailure};
use super::order_control::gamma_star;
use super::stability::explicit_limit;
use super::table::SlopeChange;
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
const PATIENCE: u32 = 20;
const LONGEST_PATIENCE: u32 = 1280;

/// A stay of fewer steps than so many times the patience did not pay.
const SHORT_STAY: u32 = 5;

/// Explicit steps are looked at one in so many: a look at all components is a tenth of the integrator's own work.
pub(super) const STEPS_A_LOOK: u32 = 4;

/// The corrector in use and what speaks for the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Choice {
    implicit: bool,
    votes: u32,
    /// Votes that a change from the explicit corrector, and from the implicit one, takes.
    patience: [u32; 2],
    /// Steps since the last change.
    stay: u32,
}

impl Choice {
    pub(super) fn new() -> Self {
        Self {
            implicit: false,
            votes: 0,
            patience: [PATIENCE; 2],
            stay: 0,
        }
    }

    /// Counts `steps` that speak for a change or against it; true when it is time.
    fn vote(&mut self, change: bool, steps: u32) -> bool {
        self.stay = self.stay.saturating_add(steps);
        self.votes = if change {
            self.votes.saturating_add(steps)
        } else {
            self.votes.saturating_sub(steps)
        };
        let (own, other) = (usize::from(self.implicit), usize::from(!self.implicit));
        if self.votes < self.patience[own] {
            return false;
        }
        // Where it did not pay to come here, it takes longer next time.
        self.patience[other] = if self.stay < self.patience[own].saturating_mul(SHORT_STAY) {
            self.patience[other].saturating_mul(2).min(LONGEST_PATIENCE)
        } else {
            PATIENCE
        };
        self.implicit = !self.implicit;
        (self.votes, self.stay) = (0, 0);
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
            Corrector::Auto => self.choice.implicit,
            Corrector::Pece => false,
            Corrector::Newton => true,
        }
    }

    /// After one of [`STEPS_A_LOOK`] explicit steps: whether it made no use of a high order, or stability held it, although Newton's
    /// method at order two could make a longer one.
    pub(super) fn consider_implicit(&mut self, system: &impl SecondOrderSystem) {
        let rate = self.rate_from_slopes(system.coordinates());
        self.fastest.meet_after(STEPS_A_LOOK, rate);
        let (k, h) = (self.last_order, self.last_step_size);
        // A step near the longest allowed is not held by stability: Newton's method could not make it longer.
        let longest = self.is_near_longest(h);
        let unstable = || h * self.fastest.value() > NEAR_LIMIT * explicit_limit(k);
        let held = !longest && (k <= LOW_ORDER || unstable());
        let share = self.mean_share(system.controlled()).sqrt();
        let at_order_two = || share * h * gamma_star(2) * self.norm_of_difference(2);
        let pays = held && (k < 2 || at_order_two() <= LONGER);
        self.choice.vote(pays, STEPS_A_LOOK);
    }

    /// After a step of Newton's method: whether explicit ones would be long enough to be cheaper.
    pub(super) fn consider_explicit(&mut self) {
        let h = self.step_size;
        let explicit = h.min(EXPLICIT_REACH / self.fastest.value());
        let cost = if self.unmeasured {
            IMPLICIT_COST
        } else {
            IMPLICIT_COST_OF_TWO
        };
        let pays = explicit / EXPLICIT_COST > GAIN * h / cost;
        if self.choice.vote(pays, 1) {
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
