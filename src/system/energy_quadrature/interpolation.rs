//! Interpolation of the power in the middle of a step, and the tests of it.

use serde::{Deserialize, Serialize};

use crate::system::PowerSum;

/// Largest error of an interpolated power in the middle of a step, over that of Simpson's rule: its weight there is 2/3.
pub(super) const ERROR_IN_THE_MIDDLE: f64 = 1.5;

/// Steps in a row without an evaluation, at most. The middle of the next one is evaluated as a test of the interpolation.
///
/// Chosen among 7, 31 and 63 on the published drive (decision 22).
const MOST_INTERPOLATED: u32 = 31;

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
    pub(super) fn test(&mut self, error: [f64; 2], accepted: f64) {
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
    let [_, rest @ ..] = &nodes;
    let cubic = weights_in_the_middle(&nodes);
    let parabola = weights_in_the_middle(rest);
    let totals = nodes.map(|(_, powers)| powers.totals());
    let is_accurate = |which: usize| {
        let mut error = cubic[0] * totals[0][which];
        for node in 0..3 {
            error += (cubic[node + 1] - parabola[node]) * totals[node + 1][which];
        }
        error.abs() <= accepted
    };
    (is_accurate(0) && is_accurate(1)).then(|| {
        let mut sum = P::default();
        for ((_, powers), weight) in nodes.iter().zip(cubic) {
            sum.add_scaled(weight, powers);
        }
        sum
    })
}

/// Return whether the errors of dissipated and external power are at most `accepted` \[W\].
pub(super) fn is_below(errors: [f64; 2], accepted: f64) -> bool {
    errors.iter().all(|e| e.abs() <= accepted)
}

/// Return the weights of powers at places in parts of a step in Lagrange's polynomial, in the middle of the step.
fn weights_in_the_middle<P, const N: usize>(nodes: &[(f64, P); N]) -> [f64; N] {
    let mut weights = [1.0; N];
    for (i, weight) in weights.iter_mut().enumerate() {
        let (mut above, mut below) = (1.0, 1.0);
        for j in (0..N).filter(|&j| j != i) {
            above *= 0.5 - nodes[j].0;
            below *= nodes[i].0 - nodes[j].0;
        }
        *weight = above / below;
    }
    weights
}
