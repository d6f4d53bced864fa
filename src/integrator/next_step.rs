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
    /// Number of accepted implicit steps at order one or two until the growth of the step size is not limited by a rejected one any more.
    pub(super) steps_of_limited_growth: u32,
    /// Additional weight of the new derivative in an implicit step of order two, in step sizes; zero for the trapezoidal rule.
    pub(super) damping: f64,
}

impl NextStep {
    pub(super) fn new() -> Self {
        Self {
            size: 0.0,
            order: 1,
            longest: f64::INFINITY,
            smallest: 0.0,
            growing: true,
            steps_of_limited_growth: 0,
            damping: 0.0,
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
        self.steps_of_limited_growth = 0;
        self.damping = 0.0;
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
        self.growing = self.growing && k < max_order && !estimate.prefers_lower(k);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn control() -> StepControl {
        StepControl {
            max_step: 0.1,
            ..StepControl::default()
        }
    }

    /// The first step at `time`, of at most 0.1 s.
    fn first(time: f64, scale: f64, slope: f64) -> NextStep {
        let mut next = NextStep::new();
        next.start(&control(), time, scale, slope);
        next
    }

    #[test]
    fn the_first_step_takes_a_sixteenth_of_the_tolerance() {
        // 16 |f| h² is one.
        let next = first(0.0, 1.0, 100.0);
        assert_eq!(next.size, 0.025);
        assert_eq!(16.0 * 100.0 * next.size * next.size, 1.0);
        // Shorter than that already: the time scale and the longest steps.
        assert_eq!(first(0.0, 0.02, 100.0).size, 0.02);
        assert_eq!(first(0.0, 1.0, 1.0).size, 0.1);
        let mut limited = NextStep::new();
        limited.limit(0.01, 0.0);
        limited.start(&control(), 0.0, 1.0, 1.0);
        assert_eq!(limited.size, 0.01);
        assert!(limited.growing && limited.order == 1);
    }

    #[test]
    fn a_step_is_not_below_the_rounding_of_time() {
        let epsilon = f64::EPSILON;
        assert_eq!(first(8.0, 1.0, 1e60).size, 32.0 * epsilon);
        assert_eq!(first(-8.0, 1.0, 1e60).size, 32.0 * epsilon);
        // At time zero a share of the first step is the smallest, and a step of any size there is.
        let mut next = first(0.0, 1.0, 1.0);
        assert!(next.exceeds_rounding(4.1e-4 * epsilon, 0.0));
        assert!(!next.exceeds_rounding(3.9e-4 * epsilon, 0.0));
        assert!(next.exceeds_rounding(4.0 * epsilon, 1.0));
        assert!(!next.exceeds_rounding(3.9 * epsilon, 1.0));
        assert_eq!(first(0.0, 1.0, f64::INFINITY).size, f64::MIN_POSITIVE);
    }

    #[test]
    fn limits_shorten_the_next_step_and_never_lengthen_it() {
        let mut next = first(1.0, 1.0, 1.0);
        next.limit(0.2, 1.0);
        assert_eq!(next.size, 0.1);
        next.limit(0.03, 1.0);
        assert_eq!(next.size, 0.03);
        next.limit(1e-30, 1.0);
        assert_eq!(next.size, 4.0 * f64::EPSILON);
        next.set_size(0.05, &control(), 1.0);
        assert_eq!(next.size, 0.05);
        next.set_size(0.5, &control(), 1.0);
        assert_eq!(next.size, 0.1);
        next.set_size(0.0, &control(), 2.0);
        assert_eq!(next.size, 8.0 * f64::EPSILON);
    }

    #[test]
    fn half_of_the_longest_step_is_near_it() {
        let mut next = NextStep::new();
        assert!(next.is_near_longest(&control(), 0.05));
        assert!(!next.is_near_longest(&control(), 0.049));
        next.limit(0.01, 0.0);
        assert!(next.is_near_longest(&control(), 0.005));
        assert!(!next.is_near_longest(&control(), 0.0049));
    }

    #[test]
    fn order_and_size_grow_until_a_lower_order_is_as_good() {
        let falling = ErrorEstimate {
            two_below: 4.0,
            one_below: 2.0,
            at_order: 1.0,
            local: 1.0,
        };
        let mut next = first(0.0, 0.02, 1.0);
        assert!(next.grow(&falling, (3, 0.02), 12, &control()));
        assert_eq!((next.order, next.size), (4, 0.04));
        assert!(next.grow(&falling, (4, 0.08), 12, &control()));
        assert_eq!((next.order, next.size), (5, 0.1));
        let noise = ErrorEstimate {
            two_below: 1.0,
            ..falling
        };
        let rising = ErrorEstimate {
            one_below: 1.0,
            ..noise
        };
        assert!(next.clone().grow(&noise, (5, 0.1), 12, &control()));
        assert!(!next.clone().grow(&rising, (5, 0.1), 12, &control()));
        assert!(!next.clone().grow(&falling, (12, 0.1), 12, &control()));
        assert!(next.clone().grow(&falling, (11, 0.1), 12, &control()));
        // It has ended for good.
        next.growing = false;
        assert!(!next.grow(&falling, (5, 0.02), 12, &control()));
        assert_eq!((next.order, next.size), (5, 0.1));
    }
}
