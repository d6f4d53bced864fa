//! Accelerations near a singular position, where the constraints become dependent: interpolated from both sides of it.
//!
//! At a distance s from a singular position, round-off ε of positions becomes ε/s in positions, ε/s² in velocities and ε/s³ in
//! accelerations. At the position itself the constraints do not determine the accelerations. The motion is smooth there nevertheless.
//! Accelerations are therefore evaluated at positions ahead and behind along the motion, each projected onto the constraints. The
//! result is the value of the even interpolating polynomial.

use crate::multibody::assembly::projection::{AtHand, Projector};
use crate::multibody::dynamics::MechanismDynamics;

/// Distance between the interpolation points: rotation of the fastest body \[rad\].
const SPACING: f64 = 0.03;
/// Interpolation weights at ±1, ±2, ±3 spacings; the error is of order six.
const WEIGHTS: [f64; 3] = [0.75, -0.3, 0.05];
/// Independence of the constraints below which a position counts as near-singular.
const NEAR: f64 = 1e-2;
/// The same threshold over the independence at the start; the smaller of both holds.
const NEAR_OF_START: f64 = 0.05;

/// Largest number of iterations of the projection of an interpolation point.
const ITERATIONS: usize = 20;

/// Return the near-singular threshold for the independence of the constraints at the start.
pub(crate) fn nearness(at_start: f64) -> f64 {
    NEAR.min(NEAR_OF_START * at_start)
}

impl MechanismDynamics {
    /// Interpolate accelerations and multipliers across a singular position.
    ///
    /// Return false when nothing rotates or an interpolation point cannot be projected.
    pub(crate) fn accelerate_across(&mut self, t: f64) -> bool {
        let here = self.frames.clone();
        let start = self.model.read_state(&here);
        let mut accelerations = vec![0.0; start.len() / 2];
        let mut multipliers = vec![0.0; self.constraints.rows.len()];
        let (loads, found) = (&self.loads.free, &mut self.accelerations);
        let mut projector = Projector {
            model: &self.model,
            frames: &mut self.frames,
            constraints: &mut self.constraints,
            corrector: &mut self.corrector,
            give_up: &|| false,
        };
        let reached = projector.on_both_sides(t, &start, |projector, t, _, weight| {
            let reached = projector.accelerate_here(t, loads, found);
            add(&mut accelerations, weight, found);
            add(&mut multipliers, weight, &projector.constraints.multipliers);
            reached
        });
        self.frames = here;
        let constraints = &mut self.constraints;
        constraints.find_rows(&self.model, t, &self.frames);
        constraints.factorise_whole();
        if reached {
            self.accelerations.copy_from_slice(&accelerations);
            constraints.multipliers.copy_from_slice(&multipliers);
        }
        reached
    }
}

impl Projector<'_> {
    /// Replace `state` by its interpolation across a singular position. Return false, with `state` unchanged, when it fails.
    pub(crate) fn project_across(&mut self, t: f64, state: &mut [f64]) -> bool {
        let mut sum = vec![0.0; state.len()];
        let reached = self.on_both_sides(t, state, |_, _, place, weight| {
            add(&mut sum, weight, place);
            true
        });
        if reached {
            state.copy_from_slice(&sum);
        }
        self.place(t, state);
        reached
    }

    /// Call `visit` with the time, state and weight of each interpolation point on both sides of `state`, projected onto the
    /// constraints.
    ///
    /// Return false when nothing rotates, a point cannot be projected or a call returns false.
    fn on_both_sides(
        &mut self,
        t: f64,
        state: &[f64],
        mut visit: impl FnMut(&mut Self, f64, &[f64], f64) -> bool,
    ) -> bool {
        let n = state.len() / 2;
        self.model.place(self.frames, state);
        let spin = self.frames.iter().map(|f| f.spin.abs()).fold(0.0, f64::max);
        if !(spin > 0.0 && spin.is_finite()) {
            return false;
        }
        // No interpolation within the interpolation: the points are evaluated directly.
        let aside = std::mem::replace(&mut self.constraints.aside, true);
        let mut place = vec![0.0; 2 * n];
        let mut places = (1..=WEIGHTS.len()).flat_map(|k| [(k, -1.0), (k, 1.0)]);
        // Points at t ± k Δt with Δt = SPACING / ω, where ω is the largest angular velocity: q(t) ± k Δt v(t), before projection.
        let reached = places.all(|(k, side)| {
            let delay = side * SPACING * k as f64 / spin;
            place.copy_from_slice(state);
            add(&mut place[..n], delay, &state[n..]);
            self.project(t + delay, &mut place, ITERATIONS, AtHand::Nothing)
                && visit(self, t + delay, &place, WEIGHTS[k - 1])
        });
        self.constraints.aside = aside;
        reached
    }

    /// Solve for accelerations at a state just projected onto the constraints, with the `loads` on the free coordinates.
    fn accelerate_here(&mut self, t: f64, loads: &[f64], accelerations: &mut [f64]) -> bool {
        // γ depends on the velocities, which the projection has changed.
        self.find_rows(t);
        self.constraints.factorise_whole();
        self.constraints
            .solve(self.model, self.frames, loads, accelerations)
    }
}

/// Add `weight` times `values` to `sums`.
fn add(sums: &mut [f64], weight: f64, values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}
