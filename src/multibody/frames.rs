//! Body frames of a state, and the constraint equations at them.

use super::description::body::Frame;
use super::dynamics::MechanismDynamics;
use crate::geometry::Vec2;

impl MechanismDynamics {
    /// Set the body frames to positions and velocities (q, then v), without a shift.
    pub(crate) fn place(&mut self, state: &[f64]) {
        self.place_by(state, |_, position, velocity| {
            Frame::new(position, velocity)
        });
    }

    /// Set the body frames to positions and velocities nearby.
    pub(crate) fn place_nearby(&mut self, state: &[f64]) {
        self.place_by(state, Frame::moved);
    }

    fn place_by(&mut self, state: &[f64], frame_at: impl Fn(&Frame, [f64; 3], [f64; 3]) -> Frame) {
        let n = self.model.coordinates();
        for (frame, first) in self.frames.iter_mut().zip(&self.model.first) {
            if let Some(i) = *first {
                let [position, velocity] =
                    [i, n + i].map(|i| [state[i], state[i + 1], state[i + 2]]);
                *frame = frame_at(frame, position, velocity);
            }
        }
    }

    /// Set the velocities of the body frames; positions remain.
    pub(crate) fn move_with(&mut self, state: &[f64]) {
        let n = self.model.coordinates();
        for (frame, first) in self.frames.iter_mut().zip(&self.model.first) {
            if let Some(i) = *first {
                frame.velocity = Vec2::new(state[n + i], state[n + i + 1]);
                frame.spin = state[n + i + 2];
            }
        }
    }

    /// Evaluate the constraint equations at the body frames.
    pub(crate) fn find_rows(&mut self, t: f64) {
        let model = &self.model;
        for range in &model.equations_of_joint {
            let equations = &model.equations[range.clone()];
            let rows = &mut self.rows[range.clone()];
            let mut done = 0;
            // Both equations of a point share the arms.
            if let ([first, _, ..], Some(point)) = (equations, rows.first_chunk_mut())
                && first.begins_point()
            {
                *point = first.evaluate_point(&self.frames);
                done = point.len();
            }
            for (row, equation) in rows.iter_mut().zip(equations).skip(done) {
                *row = equation.evaluate(t, &self.frames);
            }
        }
    }

    /// Add the shift at `t` to the integrator's coordinates and velocities.
    pub(crate) fn add_shift(&self, t: f64, state: &mut [f64]) {
        let n = self.model.coordinates();
        let since = t - self.shift_time;
        let (shift_q, shift_v) = self.shift.split_at(n);
        let (q, v) = state.split_at_mut(n);
        for (((q, v), place), rate) in q.iter_mut().zip(v).zip(shift_q).zip(shift_v) {
            *q += place + since * rate;
            *v += rate;
        }
    }
}
