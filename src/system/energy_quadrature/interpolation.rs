//! Interpolation of the powers in the middle of a step, and the tests of it.

use serde::{Deserialize, Serialize};

use super::{Wanted, in_parts_of};
use crate::integrator::Step;
use crate::system::PowerSum;

/// Largest error of an interpolated power in the middle of a step, over that of Simpson's rule: its weight there is 2/3.
pub(super) const ERROR_IN_THE_MIDDLE: f64 = 1.5;

/// Steps in a row without an evaluation, at most. The middle of the next one is evaluated as a test of the interpolation.
///
/// Chosen among 7, 31, 63 and 127 on the published drive (decision 22).
const MOST_INTERPOLATED: u32 = 63;

/// Number of powers before a step from which, with those at its ends, the powers in its middle are predicted.
pub(super) const BEFORE: usize = 3;

/// Powers in the middle of a step that those at its ends and [`BEFORE`] powers before it predict.
///
/// The difference of quartic and cubic estimates the error where the power is smooth at the scale of the steps. Where steps are long beside
/// the relaxation of overdamped contacts, it does not show the error: evaluations in between test it ([`Interpolation`]).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Predicted<P> {
    pub(super) powers: P,
    /// Whether the estimated errors of dissipated and external power are accepted.
    pub(super) is_accurate: [bool; 2],
}

impl<P: PowerSum> Predicted<P> {
    /// Predict powers with errors of at most `accepted` \[W\], from those at both `ends` of the step and at places before it \[parts of the
    /// step\], the earliest first. Without the earliest, a cubic is left.
    pub(super) fn new(before: [(f64, &P); BEFORE], ends: [&P; 2], accepted: f64) -> Self {
        let [(a, earliest), (b, earlier), (c, latest)] = before;
        let places = [a, b, c, 0.0, 1.0];
        let nodes = [earliest, earlier, latest, ends[0], ends[1]];
        let weights = weights_in_the_middle([a, b, c]);
        // The weight of node i in the quartic is that in the cubic times (x - x0)/(xi - x0). The difference of both weights is
        // the one in the quartic times (x - xi)/(x - x0).
        let over = 1.0 / (0.5 - a);
        let mut error = [0.0; 2];
        for ((weight, place), node) in weights.iter().zip(places).zip(nodes) {
            let share = weight * (0.5 - place) * over;
            for (error, total) in error.iter_mut().zip(node.totals()) {
                *error += share * total;
            }
        }
        Self {
            powers: P::combined([0, 1, 2, 3, 4].map(|i| (weights[i], nodes[i]))),
            is_accurate: error.map(|error| error.abs() <= accepted),
        }
    }
}

/// Interpolation of the powers in the middle of the steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "P: PowerSum")]
pub(super) struct Interpolation<P> {
    /// Times \[s\] and powers at the starts of the last steps, and in their middles where all powers were evaluated; the latest last.
    before: [Option<(f64, P)>; BEFORE],
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
    /// Return the powers before `step`, with their places in parts of it, the earliest first; `None` where there are too few.
    pub(super) fn places(&self, step: &Step) -> Option<[(f64, &P); BEFORE]> {
        let [Some(a), Some(b), Some(c)] = &self.before else {
            return None;
        };
        Some([a, b, c].map(|node| in_parts_of(step, node)))
    }

    /// Take the powers at `t`, later than all others, in place of the earliest.
    pub(super) fn remember(&mut self, t: f64, powers: P) {
        self.before.rotate_left(1);
        self.before[BEFORE - 1] = Some((t, powers));
    }

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
        accepted: f64,
    ) {
        let is_evaluated = [evaluated == Wanted::All, true];
        for (i, permit) in self.permits.iter_mut().enumerate() {
            if !predicted.is_accurate[i] || !is_evaluated[i] {
                continue;
            }
            permit.permitted = if error[i].abs() <= accepted {
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
fn weights_in_the_middle([a, b, c]: [f64; BEFORE]) -> [f64; BEFORE + 2] {
    let [from_a, from_b, from_c] = [0.5 - a, 0.5 - b, 0.5 - c];
    let (ab, bc, ca) = (a - b, b - c, c - a);
    // In the middle of the step x (1 - x) is a quarter.
    let all = 0.5 * from_a * from_b * from_c;
    [
        0.25 * from_b * from_c / (ab * ca * a * (a - 1.0)),
        0.25 * from_a * from_c / (ab * bc * b * (b - 1.0)),
        0.25 * from_a * from_b / (bc * ca * c * (c - 1.0)),
        -all / (a * b * c),
        all / ((1.0 - a) * (1.0 - b) * (1.0 - c)),
    ]
}
