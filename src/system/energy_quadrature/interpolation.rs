//! Interpolation of the power in the middle of a step, and the tests of it.

use serde::{Deserialize, Serialize};

use super::Wanted;
use crate::system::PowerSum;

/// Largest error of an interpolated power in the middle of a step, over that of Simpson's rule: its weight there is 2/3.
pub(super) const ERROR_IN_THE_MIDDLE: f64 = 1.5;

/// Steps in a row without an evaluation, at most. The middle of the next one is evaluated as a test of the interpolation.
///
/// Chosen among 7, 31, 63 and 127 on the published drive (decision 22).
const MOST_INTERPOLATED: u32 = 63;

/// Powers in the middle of a step that those at its ends and two powers before it predict.
///
/// The difference of cubic and parabola estimates the error where the power is smooth at the scale of the steps. Where steps are long beside
/// the relaxation of overdamped contacts, it does not show the error: evaluations in between test it ([`Interpolation`]).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Predicted<P> {
    pub(super) powers: P,
    /// Whether the estimated errors of dissipated and external power are accepted.
    pub(super) is_accurate: [bool; 2],
}

impl<P: PowerSum> Predicted<P> {
    /// Predict powers with errors of at most `accepted`, of dissipated and external power \[W\], from those at both `ends` of the step and at two
    /// places before it \[parts of the step\]. Without the one that is farthest away, a parabola is left.
    pub(super) fn new(one: (f64, &P), other: (f64, &P), ends: [&P; 2], accepted: [f64; 2]) -> Self {
        let (far, near) = if one.0 < other.0 {
            (one, other)
        } else {
            (other, one)
        };
        let places = [far.0, near.0];
        let weights = weights_in_the_middle(places);
        let nodes = [far.1, near.1, ends[0], ends[1]];
        // The cubic differs from the parabola by f[x0, x1, x2, x3] (x - x1) (x - x2) (x - x3). In this, the weight of node i is that in
        // the cubic times (x - xi)/(x - x0).
        let over = 1.0 / (0.5 - far.0);
        let shares = [1.0, (0.5 - near.0) * over, 0.5 * over, -0.5 * over];
        let mut error = [0.0; 2];
        for ((weight, share), node) in weights.iter().zip(shares).zip(nodes) {
            for (error, total) in error.iter_mut().zip(node.totals()) {
                *error += weight * share * total;
            }
        }
        Self {
            powers: P::combined([0, 1, 2, 3].map(|i| (weights[i], nodes[i]))),
            is_accurate: [0, 1].map(|i| error[i].abs() <= accepted[i]),
        }
    }
}

/// Interpolation of the powers in the middle of the steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "P: PowerSum")]
pub(super) struct Interpolation<P> {
    /// Time \[s\] and powers in the middle of the last step if all were evaluated there, else at the start of the step before it.
    pub(super) other: Option<(f64, P)>,
    /// Permits of the dissipated and of the external power.
    permits: [Permit; 2],
}

/// Interpolated steps that the last test of a power permits, and those of them that are left.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct Permit {
    permitted: u32,
    left: u32,
}

impl<P: PowerSum> Interpolation<P> {
    /// Return the powers to evaluate in the middle of a step, `None` without any; use the permits of those that are not evaluated.
    pub(super) fn wanted(&mut self, predicted: &Predicted<P>) -> Option<Wanted> {
        let [dissipated, external] = [0, 1].map(|i| {
            let permitted = self.permits[i].left > 0;
            predicted.is_accurate[i] && permitted
        });
        self.permits[0].left -= u32::from(dissipated);
        self.permits[1].left -= u32::from(dissipated && external);
        match (dissipated, external) {
            (true, true) => None,
            (true, false) => Some(Wanted::External),
            (false, _) => Some(Wanted::All),
        }
    }

    /// Compare evaluated powers with the predicted ones, if these were accurate by their estimate: twice as many steps may follow, or none.
    pub(super) fn test(
        &mut self,
        predicted: &Predicted<P>,
        evaluated: Wanted,
        error: [f64; 2],
        accepted: [f64; 2],
    ) {
        let is_evaluated = [evaluated == Wanted::All, true];
        for (i, permit) in self.permits.iter_mut().enumerate() {
            if !predicted.is_accurate[i] || !is_evaluated[i] {
                continue;
            }
            permit.permitted = if error[i].abs() <= accepted[i] {
                (2 * permit.permitted + 1).min(MOST_INTERPOLATED)
            } else {
                0
            };
            permit.left = permit.permitted;
        }
    }
}

/// Return whether the errors of dissipated and external power are at most `accepted` \[W\].
pub(super) fn is_below(errors: [f64; 2], accepted: f64) -> bool {
    errors.iter().all(|e| e.abs() <= accepted)
}

/// Return the weights of powers at places before a step \[parts of it\], at its start and at its end, in Lagrange's polynomial in the middle of
/// the step.
fn weights_in_the_middle([far, near]: [f64; 2]) -> [f64; 4] {
    let (from_far, from_near) = (0.5 - far, 0.5 - near);
    let both = 0.5 * from_far * from_near;
    let quarter = 0.25 / (near - far);
    [
        quarter * from_near / (far * (far - 1.0)),
        -quarter * from_far / (near * (near - 1.0)),
        both / (far * near),
        both / ((1.0 - far) * (1.0 - near)),
    ]
}
