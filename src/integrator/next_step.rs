//! Size and order of the next step, and their limits.

use serde::{Deserialize, Serialize};

use super::StepControl;
use super::order_control::ErrorEstimate;

/// Smallest step size in units of the rounding of time: four units in the last place of t, the `FOURU` of DE/STEP.
///
/// Doubled: a run that fails does so at twice the step size; other runs do not change.
const ROUNDING_OF_TIME: f64 = 4.0 * f64::EPSILON;

/// Share of the first step size from which the smallest step size follows while time is zero.
///
/// The rounding of time zero is zero; a first step may still be rejected many times. Doubled: no change in runs that do not fail there.
const FIRST_STEP_SHARE: f64 = 1e-3;

/// Share of the longest permitted step from which on a step counts as limited by that length.
///
/// One doubling more exceeds the permitted length. Doubled: only a step of exactly the longest size counts.
const NEAR_LONGEST: f64 = 0.5;

/// Size and order of the next step.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct NextStep {
    /// Step size h \[s\].
    pub(super) size: f64,
    /// Order k of the predictor.
    pub(super) order: usize,
    /// Longest step permitted by the caller at present \[s\].
    longest: f64,
    /// Smallest step size that changes time \[s\].
    smallest: f64,
    /// Start phase: order and step size grow with every step as long as the solution is smooth.
    pub(super) growing: bool,
    /// Number of accepted implicit steps until the step size may grow again.
    pub(super) steps_until_growth: u32,
}

impl NextStep {
    pub(super) fn new() -> Self {
        Self {
            size: 0.0,
            order: 1,
            longest: f64::INFINITY,
            smallest: 0.0,
            growing: true,
            steps_until_growth: 0,
        }
    }

    /// Begin at order one with a step size that a method of order one accepts (Shampine and Gordon, subroutine STEP, block 0).
    ///
    /// `scale` is |y|/|f|, the time in which the solution changes by its own size \[s\]; `slope` is |f| in units of the tolerance.
    pub(super) fn start(&mut self, control: &StepControl, time: f64, scale: f64, slope: f64) {
        // The solution changes by its own size in the time scale: the first step is not longer.
        let mut h = control.max_step.min(scale).min(self.longest);
        // The error of order one is about h² |f|; the first step takes a sixteenth of the tolerance.
        // h = sqrt(1/16)/sqrt(|f|) makes h² |f| a sixteenth of the tolerance (DE/STEP).
        if 16.0 * slope * h * h > 1.0 {
            h = 0.25 / slope.sqrt();
        }
        // An infinite derivative gives h = 0, which no rejection can make smaller.
        let rounding = shortest_at(time).max(ROUNDING_OF_TIME * FIRST_STEP_SHARE * h);
        self.smallest = rounding.max(f64::MIN_POSITIVE);
        self.size = h.max(self.smallest);
        self.order = 1;
        self.growing = true;
    }

    /// Limit the next step, the first one included, to `longest` \[s\].
    pub(super) fn limit(&mut self, longest: f64, time: f64) {
        self.longest = longest;
        if longest < self.size {
            self.size = longest.max(shortest_at(time));
        }
    }

    /// Return whether a step of size `h` is within a factor of two of the longest permitted one.
    pub(super) fn is_near_longest(&self, control: &StepControl, h: f64) -> bool {
        h >= NEAR_LONGEST * control.max_step.min(self.longest)
    }

    /// Return whether a step of size `h` \[s\] changes `time` by more than rounding.
    pub(super) fn exceeds_rounding(&mut self, h: f64, time: f64) -> bool {
        self.smallest = self.smallest.max(shortest_at(time));
        h >= self.smallest
    }

    /// Set the next step size, between the rounding of `time` and the largest step. The caller applies [`Self::limit`] afterwards.
    pub(super) fn set_size(&mut self, h: f64, control: &StepControl, time: f64) {
        self.size = h.max(shortest_at(time)).min(control.max_step);
    }

    /// Raise the order by one and double the step size in the start phase; return false outside of it.
    ///
    /// The phase ends at the highest order, or when a lower order has the smaller error (Shampine and Gordon, chapter 10).
    pub(super) fn grow(
        &mut self,
        estimate: &ErrorEstimate,
        (k, h): (usize, f64),
        max_order: usize,
        control: &StepControl,
    ) -> bool {
        // Rise while the errors decrease with the order.
        self.growing &= k < max_order && !estimate.prefers_lower(k);
        if self.growing {
            self.order = k + 1;
            self.size = (2.0 * h).min(control.max_step);
        }
        self.growing
    }
}

/// Return the smallest step size that changes `time` \[s\].
fn shortest_at(time: f64) -> f64 {
    ROUNDING_OF_TIME * time.abs()
}
