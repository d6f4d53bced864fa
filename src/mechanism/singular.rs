//! Accelerations near a singular position, where joints lose their independence: taken from the motion on both sides of it.
//!
//! At a distance s from a singular position, round-off ε of positions comes back as ε/s in them, ε/s² in velocities and
//! ε/s³ in accelerations; at the position itself the constraints leave the accelerations open. The motion is smooth there
//! all the same. So accelerations are evaluated at positions a little ahead and a little behind on the way, each brought
//! onto the constraints, and are taken from the even polynomial through them.

use super::dynamics::MechanismDynamics;

/// Way between the places on both sides, in turns of the fastest body \[rad\].
const SPACING: f64 = 0.03;
/// Weights at ±1, ±2, ±3 spacings: the error is of order six.
const WEIGHTS: [f64; 3] = [0.75, -0.3, 0.05];
/// Independence of the constraints below which they count as near a singular position, and the same of the start's.
const NEAR: f64 = 1e-2;
const NEAR_OF_START: f64 = 0.05;

/// What counts as near for a mechanism whose constraints are as independent as this at the start.
pub(super) fn nearness(at_start: f64) -> f64 {
    NEAR.min(NEAR_OF_START * at_start)
}

impl MechanismDynamics {
    /// Accelerations and multipliers from both sides; false when nothing moves or a place cannot be reached.
    pub(super) fn accelerate_across(&mut self, t: f64) -> bool {
        let n = self.model.coordinates();
        let spin = self.frames.iter().map(|f| f.spin.abs()).fold(0.0, f64::max);
        let here = self.frames.clone();
        let mut start = vec![0.0; 2 * n];
        for (frame, first) in here.iter().zip(&self.model.first) {
            if let Some(i) = *first {
                start[i..i + 3].copy_from_slice(&[frame.origin.x, frame.origin.y, frame.angle]);
                let velocity = [frame.velocity.x, frame.velocity.y, frame.spin];
                start[n + i..n + i + 3].copy_from_slice(&velocity);
            }
        }
        let mut accelerations = vec![0.0; n];
        let mut multipliers = vec![0.0; self.rows.len()];
        let near = std::mem::replace(&mut self.near_singular, 0.0);
        let mut reached = spin > 0.0;
        'places: for (k, weight) in WEIGHTS.iter().enumerate() {
            for side in [-1.0, 1.0] {
                let delay = side * SPACING * (k + 1) as f64 / spin;
                let mut state = start.clone();
                for i in 0..n {
                    state[i] += delay * start[n + i];
                }
                reached = reached && self.accelerate_at(t + delay, &mut state);
                if !reached {
                    break 'places;
                }
                let found = self.accelerations.iter();
                accelerations
                    .iter_mut()
                    .zip(found)
                    .for_each(|(sum, a)| *sum += weight * a);
                let found = self.multipliers.iter();
                multipliers
                    .iter_mut()
                    .zip(found)
                    .for_each(|(sum, l)| *sum += weight * l);
            }
        }
        self.near_singular = near;
        self.frames = here;
        self.find_rows(t);
        if let Some(kkt) = &mut self.kkt {
            kkt.factorise(&self.rows);
        }
        if reached {
            self.accelerations.copy_from_slice(&accelerations);
            self.multipliers.copy_from_slice(&multipliers);
        }
        reached
    }

    /// Accelerations by the loads at hand at another place, which is brought onto the constraints.
    fn accelerate_at(&mut self, t: f64, state: &mut [f64]) -> bool {
        if !self.project(t, state, 20) {
            return false;
        }
        // With the velocities just projected, the right-hand sides are those of this place.
        self.find_rows(t);
        let Some(kkt) = &mut self.kkt else {
            return false;
        };
        kkt.factorise(&self.rows);
        kkt.solve(
            &self.forces,
            &self.rows,
            &mut self.accelerations,
            &mut self.multipliers,
        )
    }
}
