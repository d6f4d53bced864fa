//! Accelerations near a singular position, where joints lose their independence: taken from the motion on both sides of it.
//!
//! At a distance s from a singular position, round-off ε of positions comes back as ε/s in them, ε/s² in velocities and
//! ε/s³ in accelerations; at the position itself the constraints leave the accelerations open. The motion is smooth there
//! all the same. So accelerations are evaluated at positions a little ahead and a little behind on the way, each brought
//! onto the constraints, and are taken from the even polynomial through them.

use crate::multibody::assembly::projection::AtHand;
use crate::multibody::dynamics::MechanismDynamics;

/// Way between the places on both sides, in turns of the fastest body \[rad\].
const SPACING: f64 = 0.03;
/// Weights at ±1, ±2, ±3 spacings: the error is of order six.
const WEIGHTS: [f64; 3] = [0.75, -0.3, 0.05];
/// Independence of the constraints below which they count as near a singular position, and the same of the start's.
const NEAR: f64 = 1e-2;
const NEAR_OF_START: f64 = 0.05;

/// Iterations that bringing a place onto the constraints may take.
const ITERATIONS: usize = 20;

/// What counts as near for a mechanism whose constraints are as independent as this at the start.
pub(crate) fn nearness(at_start: f64) -> f64 {
    NEAR.min(NEAR_OF_START * at_start)
}

impl MechanismDynamics {
    /// Accelerations and multipliers from both sides; false when nothing moves or a place cannot be reached.
    pub(crate) fn accelerate_across(&mut self, t: f64) -> bool {
        let here = self.frames.clone();
        let start = self.read_state();
        let mut accelerations = vec![0.0; start.len() / 2];
        let mut multipliers = vec![0.0; self.rows.len()];
        let reached = self.on_both_sides(t, &start, |dynamics, t, _, weight| {
            let reached = dynamics.accelerate_here(t);
            add(&mut accelerations, weight, &dynamics.accelerations);
            add(&mut multipliers, weight, &dynamics.multipliers);
            reached
        });
        self.frames = here;
        self.find_rows(t);
        self.factorise_whole();
        if reached {
            self.accelerations.copy_from_slice(&accelerations);
            self.multipliers.copy_from_slice(&multipliers);
        }
        reached
    }

    /// Moves `state` to where both sides say that it is; false, and nothing moved, when they do not say.
    pub(crate) fn project_across(&mut self, t: f64, state: &mut [f64]) -> bool {
        let mut sum = vec![0.0; state.len()];
        let reached = self.on_both_sides(t, state, |_, _, place, weight| {
            add(&mut sum, weight, place);
            true
        });
        if reached {
            state.copy_from_slice(&sum);
        }
        self.place(state);
        self.find_rows(t);
        reached
    }

    /// Shows `visit` the places on both sides of `state`, with their times and weights, each brought onto the constraints; false
    /// when nothing moves, a place cannot be reached or a visit ends it.
    fn on_both_sides(
        &mut self,
        t: f64,
        state: &[f64],
        mut visit: impl FnMut(&mut Self, f64, &[f64], f64) -> bool,
    ) -> bool {
        let n = state.len() / 2;
        self.place(state);
        let spin = self.frames.iter().map(|f| f.spin.abs()).fold(0.0, f64::max);
        if !(spin > 0.0 && spin.is_finite()) {
            return false;
        }
        // Places on the sides are taken as they are.
        let aside = std::mem::replace(&mut self.aside, true);
        let mut place = vec![0.0; 2 * n];
        let mut places = (1..=WEIGHTS.len()).flat_map(|k| [(k, -1.0), (k, 1.0)]);
        let reached = places.all(|(k, side)| {
            let delay = side * SPACING * k as f64 / spin;
            place.copy_from_slice(state);
            add(&mut place[..n], delay, &state[n..]);
            self.project(t + delay, &mut place, ITERATIONS, AtHand::Nothing)
                && visit(self, t + delay, &place, WEIGHTS[k - 1])
        });
        self.aside = aside;
        reached
    }

    /// Positions and velocities of the bodies that are not held.
    pub(crate) fn read_state(&self) -> Vec<f64> {
        let n = self.model.coordinates();
        let mut state = vec![0.0; 2 * n];
        for (frame, first) in self.frames.iter().zip(&self.model.first) {
            if let Some(i) = *first {
                state[i..i + 3].copy_from_slice(&[frame.origin.x, frame.origin.y, frame.angle]);
                let velocity = [frame.velocity.x, frame.velocity.y, frame.spin];
                state[n + i..n + i + 3].copy_from_slice(&velocity);
            }
        }
        state
    }

    /// Accelerations by the loads at hand where the bodies were just brought onto the constraints.
    fn accelerate_here(&mut self, t: f64) -> bool {
        // With the velocities just projected, the right-hand sides are those of this place.
        self.find_rows(t);
        self.factorise_whole();
        self.solve_constrained()
    }
}

/// Adds `weight` times `values` to sums.
fn add(sums: &mut [f64], weight: f64, values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}
