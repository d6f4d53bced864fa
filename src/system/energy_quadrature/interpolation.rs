//! Interpolation of the dissipated powers in the middle of a step, and the tests of it.

use serde::{Deserialize, Serialize};

use super::in_parts_of;
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
    /// Whether the estimated error of the dissipated power is accepted.
    pub(super) is_accurate: bool,
}

impl<P: PowerSum> Predicted<P> {
    /// Predict powers, the dissipated one with an error of at most `accepted` \[W\], from those at both `ends` of the step and at places before it \[parts of the
    /// step\], the earliest first. Without the earliest, a cubic is left.
    pub(super) fn new(before: [(f64, &P); BEFORE], ends: [&P; 2], accepted: f64) -> Self {
        let [(a, earliest), (b, earlier), (c, latest)] = before;
        let places = [a, b, c, 0.0, 1.0];
        let nodes = [earliest, earlier, latest, ends[0], ends[1]];
        let weights = weights_in_the_middle([a, b, c]);
        // The weight of node i in the quartic is that in the cubic times (x - x0)/(xi - x0). The difference of both weights is
        // the one in the quartic times (x - xi)/(x - x0).
        let over = 1.0 / (0.5 - a);
        let mut error = 0.0;
        for ((weight, place), node) in weights.iter().zip(places).zip(nodes) {
            error += weight * (0.5 - place) * over * node.totals()[0];
        }
        Self {
            powers: P::combined([0, 1, 2, 3, 4].map(|i| (weights[i], nodes[i]))),
            is_accurate: error.abs() <= accepted,
        }
    }
}

/// Interpolation of the powers in the middle of the steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "P: PowerSum")]
pub(super) struct Interpolation<P> {
    /// Times \[s\] and powers at the starts of the last steps, and in their middles where powers were evaluated; the latest last.
    before: [Option<(f64, P)>; BEFORE],
    /// Steps in a row that the last test permits to interpolate, and those of them that are left.
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

    /// Return whether the predicted powers are accurate and permitted; use a permit if they are.
    pub(super) fn permits(&mut self, predicted: &Predicted<P>) -> bool {
        let permits = predicted.is_accurate && self.left > 0;
        self.left -= u32::from(permits);
        permits
    }

    /// Permit twice as many interpolated steps, or none, after an evaluation of powers that were predicted: if these were accurate by their
    /// estimate, whether they are near the evaluated ones is a test.
    pub(super) fn test(&mut self, predicted: &Predicted<P>, are_near: bool) {
        if predicted.is_accurate {
            let more = (2 * self.permitted + 1).min(MOST_INTERPOLATED);
            self.permitted = if are_near { more } else { 0 };
            self.left = self.permitted;
        }
    }
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
