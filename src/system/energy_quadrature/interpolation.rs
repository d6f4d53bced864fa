//! Interpolation of the power in the middle of a step, and the tests of it.

use serde::{Deserialize, Serialize};

use crate::system::PowerSum;

/// Largest error of an interpolated power in the middle of a step, over that of Simpson's rule: its weight there is 2/3.
pub(super) const ERROR_IN_THE_MIDDLE: f64 = 1.5;

/// Steps in a row without an evaluation, at most. The middle of the next one is evaluated as a test of the interpolation.
///
/// 31 in its place saves 3 % of the evaluations on the published drive.
const MOST_INTERPOLATED: u32 = 7;

/// Interpolation of the power in the middle of a step from the powers at its ends and at those of the two steps before.
///
/// The difference of cubic and parabola estimates its error where the power is smooth at the scale of the steps. Where steps are long beside
/// the relaxation of overdamped contacts, it does not show the error: evaluations in between test it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "P: PowerSum")]
pub(super) struct Interpolation<P> {
    /// Time \[s\] and powers at the start of the step before the last one.
    pub(super) earlier: Option<(f64, P)>,
    /// Interpolated steps that the last test permits, and those of them that are left.
    permitted: u32,
    left: u32,
}

impl<P: PowerSum> Interpolation<P> {
    /// Use one of the permitted steps; false where the middle has to be evaluated.
    pub(super) fn take(&mut self) -> bool {
        let taken = self.left > 0;
        self.left -= u32::from(taken);
        taken
    }

    /// Compare an evaluated power with the interpolated one: twice as many steps may follow, or none.
    pub(super) fn test(&mut self, error: P, accepted: f64) {
        self.permitted = if is_below(error, accepted) {
            (2 * self.permitted + 1).min(MOST_INTERPOLATED)
        } else {
            0
        };
        self.left = self.permitted;
    }
}

/// Return the powers in the middle of a step if their estimated error is accepted; nodes are places in parts of the step and powers.
pub(super) fn middle<P: PowerSum>(nodes: [(f64, P); 4], accepted: f64) -> Option<P> {
    let cubic = value_in_the_middle(&nodes);
    let parabola = value_in_the_middle(&nodes[1..]);
    is_below(cubic + parabola.scaled(-1.0), accepted).then_some(cubic)
}

/// Return whether the error of dissipated and external power is at most `accepted` \[W\].
pub(super) fn is_below<P: PowerSum>(error: P, accepted: f64) -> bool {
    error.totals().iter().all(|e| e.abs() <= accepted)
}

/// Return Lagrange's polynomial through powers at places in parts of a step, in the middle of the step.
fn value_in_the_middle<P: PowerSum>(nodes: &[(f64, P)]) -> P {
    let mut sum = P::default();
    for (i, &(place, powers)) in nodes.iter().enumerate() {
        let others = nodes.iter().enumerate().filter(|&(j, _)| j != i);
        let weight: f64 =
            (others.map(|(_, &(other, _))| (0.5 - other) / (place - other))).product();
        sum += powers.scaled(weight);
    }
    sum
}
