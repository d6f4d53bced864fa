//! Whether a mechanism is placed where two ways of going on meet: joints that hold independently beside it do not do so there.

use super::acceleration::nearness;
use crate::multibody::assembly::projection::AtHand;
use crate::multibody::dynamics::MechanismDynamics;

/// Independence of the constraints below which the start is looked at.
const NEAR: f64 = 1e-6;
/// How far beside the start it is looked, in radians and parts of the size.
const BESIDE: f64 = 0.01;
/// Independence there, over that at the start, that tells the one from the other.
const MORE: f64 = 100.0;
/// Independence that tells something where joints hold but for rounding.
const TOLD: f64 = 1e-6;
const ITERATIONS: usize = 40;
/// Independence of those that are kept that is tried, best first.
const HOLDS: [f64; 3] = [1e-2, 3e-3, 1e-3];
const TRIALS: usize = 3;

impl MechanismDynamics {
    /// Finds how many constraints are independent near the start in `state`, which was just evaluated, and from when on they
    /// count as nearly dependent. Returns whether the start is a place where ways of going on meet, and no velocity was given
    /// to choose one.
    pub(crate) fn look_beside(&mut self, state: &[f64]) -> bool {
        let Some(kkt) = &self.kkt else {
            return false;
        };
        let (rank, independence) = (kkt.rank(), kkt.independence());
        (self.rank, self.near_singular) = (rank, nearness(independence));
        if rank == self.rows.len() && independence > NEAR {
            return false;
        }
        // Drivers go on, too.
        let rates = self.rows.iter().map(|row| row.time_rate.abs());
        let fastest = rates.fold(0.0, f64::max);
        let delay = if fastest > 0.0 { BESIDE / fastest } else { 0.0 };
        let (n, size) = (self.model.coordinates(), self.size());
        let aside = std::mem::replace(&mut self.aside, true);
        let mut place = vec![0.0; state.len()];
        let mut change = vec![0.0; n];
        let mut along = vec![0.0; self.rows.len()];
        let mut found = (rank, false);
        for trial in 1..=TRIALS {
            for (i, change) in change.iter_mut().enumerate() {
                let unit = if i % 3 == 2 { 1.0 } else { size };
                *change = BESIDE * unit * (1.7 * (i + 1) as f64 * trial as f64).sin();
            }
            // Along the constraints: what is redundant seems to be independent as far as joints are apart.
            self.evaluate(0.0, state);
            self.along_rows(&change, &mut along);
            if let Some(kkt) = &mut self.kkt {
                kkt.correct(&along, &mut change);
            }
            place.copy_from_slice(state);
            for (q, change) in place.iter_mut().zip(&change) {
                *q += change;
            }
            // What lost its hold at the start alone may have little of it back.
            let near = self.near_singular;
            let reached = [1.0, 0.1, 0.01].iter().any(|part| {
                self.near_singular = part * near;
                self.project(delay, &mut place, ITERATIONS, AtHand::Nothing)
            });
            self.near_singular = near;
            let Some(kkt) = self.kkt.as_mut().filter(|_| reached) else {
                continue;
            };
            kkt.factorise(&self.rows, TOLD);
            let beside = kkt.independence();
            found.0 = found.0.max(kkt.rank());
            let grown = kkt.rank() == rank && beside > MORE * independence.max(NEAR);
            if grown {
                self.near_singular = nearness(beside);
            }
            found.1 |= kkt.rank() > rank || grown;
        }
        self.aside = aside;
        self.rank = found.0;
        self.evaluate(0.0, state);
        self.hold_by_what_holds_best();
        self.evaluate(0.0, state);
        let given = (self.model.bodies.iter()).any(|body| body.velocity != [0.0; 3]);
        found.1 && !given
    }

    /// Where some constraints are redundant, the start may hold by others than those that come first: what these leave tells nothing then.
    fn hold_by_what_holds_best(&mut self) {
        if let Some(kkt) = self.kkt.as_mut().filter(|_| self.rank < self.rows.len()) {
            let holds = HOLDS.into_iter().find(|&part| {
                kkt.factorise(&self.rows, part);
                kkt.rank() == self.rank
            });
            self.near_singular =
                holds.map_or(self.near_singular, |part| part.max(self.near_singular));
        }
    }

    /// G x of each constraint.
    fn along_rows(&self, x: &[f64], along: &mut [f64]) {
        for (sum, row) in along.iter_mut().zip(&self.rows) {
            *sum = 0.0;
            for (body, part) in row.bodies.iter().zip(&row.jacobian) {
                if let Some(first) = self.model.first[*body] {
                    *sum += (0..3).map(|k| part[k] * x[first + k]).sum::<f64>();
                }
            }
        }
    }
}
