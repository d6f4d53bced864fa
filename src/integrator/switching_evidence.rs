//! Evidence for a change of the corrector: steps for it and against it, and how many it takes.

use serde::{Deserialize, Serialize};

/// Steps in favour of a change, net of those against it, that make it.
pub(super) const SWITCH_THRESHOLD: u32 = 20;
/// Upper bound of the threshold, which doubles after each change that did not pay.
const MAX_SWITCH_THRESHOLD: u32 = 1280;

/// A change did not pay when the next one follows within this number of thresholds.
const SHORT_USE: u32 = 5;

/// The corrector in use, and the evidence for the other one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct CorrectorSwitching {
    pub(super) implicit: bool,
    /// Steps in favour of a change, net of those against it.
    pub(super) evidence: u32,
    /// Evidence that a change takes, from the explicit corrector and from the implicit one.
    threshold: [u32; 2],
    pub(super) steps_since_switch: u32,
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

    /// Record `steps` in favour of a change or against it; return true when the change is made.
    pub(super) fn record(&mut self, change: bool, steps: u32) -> bool {
        self.steps_since_switch = self.steps_since_switch.saturating_add(steps);
        // A counter with a lower bound of zero: single steps of noise do not change the corrector.
        self.evidence = if change {
            self.evidence.saturating_add(steps)
        } else {
            self.evidence.saturating_sub(steps)
        };
        let (own, other) = (usize::from(self.implicit), usize::from(!self.implicit));
        if self.evidence < self.threshold[own] {
            return false;
        }
        // A corrector that was left soon needs more evidence next time.
        let short = self.threshold[own].saturating_mul(SHORT_USE);
        self.threshold[other] = if self.steps_since_switch < short {
            let doubled = self.threshold[other].saturating_mul(2);
            doubled.min(MAX_SWITCH_THRESHOLD)
        } else {
            SWITCH_THRESHOLD
        };
        // Both counters begin again with the other corrector.
        self.implicit = !self.implicit;
        (self.evidence, self.steps_since_switch) = (0, 0);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of single steps in favour of a change that make it.
    fn steps_to_change(switching: &mut CorrectorSwitching) -> u32 {
        (1..10_000).find(|_| switching.record(true, 1)).unwrap()
    }

    #[test]
    fn a_change_takes_twenty_steps_net_of_those_against_it() {
        let mut switching = CorrectorSwitching::new();
        assert!(!switching.record(false, 100));
        assert!(!switching.record(true, 19));
        assert!(!switching.record(false, 4));
        assert!(!switching.record(true, 4));
        assert!(!switching.implicit);
        assert!(switching.record(true, 1));
        assert!(switching.implicit);
        assert_eq!((switching.evidence, switching.steps_since_switch), (0, 0));
    }

    #[test]
    fn changes_that_did_not_pay_double_the_threshold_up_to_a_bound() {
        let mut switching = CorrectorSwitching::new();
        // The first corrector was in use for less than five thresholds, and so is each that follows.
        let steps = [(); 16].map(|()| steps_to_change(&mut switching));
        let expected = [
            20, 40, 40, 80, 80, 160, 160, 320, 320, 640, 640, 1280, 1280, 1280, 1280, 1280,
        ];
        assert_eq!(steps, expected);
    }

    #[test]
    fn a_corrector_that_was_of_use_has_the_first_threshold_again() {
        let mut switching = CorrectorSwitching::new();
        assert_eq!(steps_to_change(&mut switching), 20);
        // In use for 99 and for 100 steps, five times its threshold of twenty.
        let mut short = CorrectorSwitching {
            threshold: [160, 20],
            ..switching
        };
        let mut long = short;
        short.record(false, 79);
        long.record(false, 80);
        assert_eq!(steps_to_change(&mut short), 20);
        assert_eq!(steps_to_change(&mut long), 20);
        assert_eq!(short.threshold, [320, 20]);
        assert_eq!(long.threshold, [SWITCH_THRESHOLD, 20]);
    }
}
