//! Body frames of a state, and the shift between the integrator's solution and the state.

#![allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set

use pulp::{Simd, WithSimd};

use super::contact::compiled_contact::CompiledContact;
use super::description::body::Frame;
use super::model::MechanismModel;
use crate::geometry::Vec2;
use crate::math::simd::{load, sin_cos};

/// Angles whose sines and cosines are computed at once: a vector of AVX2.
const ANGLES: usize = 4;

impl MechanismModel {
    /// Set the body frames to positions and velocities (q, then v), without a shift.
    pub(crate) fn place(&self, frames: &mut [Frame], state: &[f64]) {
        let (positions, velocities) = state.split_at(self.coordinates());
        let frames = frames.iter_mut().zip(&self.first);
        self.instructions.run(Placement {
            frames: frames.filter_map(|(frame, first)| first.map(|_| frame)),
            positions: positions.as_chunks().0,
            velocities: velocities.as_chunks().0,
        });
    }

    /// Set the body frames to positions and velocities nearby.
    pub(crate) fn place_nearby(&self, frames: &mut [Frame], state: &[f64]) {
        let n = self.coordinates();
        for (frame, first) in frames.iter_mut().zip(&self.first) {
            if let Some(i) = *first {
                let [position, velocity] =
                    [i, n + i].map(|i| [state[i], state[i + 1], state[i + 2]]);
                *frame = frame.moved(position, velocity);
            }
        }
    }

    /// Set the velocities of the body frames; positions remain.
    pub(crate) fn move_with(&self, frames: &mut [Frame], state: &[f64]) {
        let n = self.coordinates();
        for (frame, first) in frames.iter_mut().zip(&self.first) {
            if let Some(i) = *first {
                frame.velocity = Vec2::new(state[n + i], state[n + i + 1]);
                frame.spin = state[n + i + 2];
            }
        }
    }

    /// Return positions and velocities (q, then v) of the bodies that are not fixed.
    pub(crate) fn read_state(&self, frames: &[Frame]) -> Vec<f64> {
        let n = self.coordinates();
        let mut state = vec![0.0; 2 * n];
        for (frame, first) in frames.iter().zip(&self.first) {
            if let Some(i) = *first {
                state[i..i + 3].copy_from_slice(&frame.position());
                state[n + i..n + i + 3].copy_from_slice(&frame.rates());
            }
        }
        state
    }

    /// Return the components of a body in `accelerations`; zero for a fixed body.
    pub(crate) fn accelerations_of(&self, body: usize, accelerations: &[f64]) -> [f64; 3] {
        match self.first[body] {
            None => [0.0; 3],
            Some(i) => [0, 1, 2].map(|k| accelerations[i + k]),
        }
    }

    /// Return the accelerations of bodies a and b of a contact \[m/s², m/s², rad/s²\].
    pub(crate) fn accelerations_of_pair(
        &self,
        contact: &CompiledContact,
        accelerations: &[f64],
    ) -> [[f64; 3]; 2] {
        [contact.a.body, contact.b.body].map(|body| self.accelerations_of(body, accelerations))
    }
}

/// Frames of the free bodies, in the order of their coordinates, as a kernel: sines and cosines of several angles at once.
struct Placement<'a, F> {
    frames: F,
    positions: &'a [[f64; 3]],
    velocities: &'a [[f64; 3]],
}

impl<'a, F: Iterator<Item = &'a mut Frame>> WithSimd for Placement<'a, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let groups = self
            .positions
            .chunks(ANGLES)
            .zip(self.velocities.chunks(ANGLES));
        for (positions, velocities) in groups {
            let (mut sines, mut cosines) = ([0.0; ANGLES], [0.0; ANGLES]);
            let mut angles = [0.0; ANGLES];
            let of_bodies = angles.iter_mut().zip(positions);
            of_bodies.for_each(|(angle, position)| *angle = position[2]);
            let found = S::as_mut_simd_f64s(&mut sines).0.iter_mut();
            let found = found.zip(S::as_mut_simd_f64s(&mut cosines).0);
            for ((sine, cosine), angle) in found.zip(S::as_simd_f64s(&angles).0) {
                let (s, c) = sin_cos(load(simd, angle));
                (*sine, *cosine) = (s.values(), c.values());
            }
            let directions = cosines
                .into_iter()
                .zip(sines)
                .map(|(cosine, sine)| Vec2::new(cosine, sine));
            let bodies = positions.iter().zip(velocities).zip(directions);
            for ((position, velocity), direction) in bodies {
                if let Some(frame) = self.frames.next() {
                    *frame = Frame::directed(*position, direction, *velocity);
                }
            }
        }
    }
}

/// State less the integrator's solution: the sum of the corrections of all projections.
///
/// During a step the shift of velocities is constant and that of coordinates grows at its rate. Thus dq/dt = v holds in the
/// integrator's solution as in the state, and an implicit corrector can compute coordinates from velocities.
#[derive(Debug, Clone)]
pub(crate) struct Shift {
    /// Shift of [q, v] at `time`.
    pub(crate) values: Vec<f64>,
    /// Time at which the shift of coordinates has the stored value \[s\].
    pub(crate) time: f64,
}

impl Shift {
    /// Return no shift, for `n` coordinates.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            values: vec![0.0; 2 * n],
            time: 0.0,
        }
    }

    /// Set the shift to zero from `t` on.
    pub(crate) fn clear(&mut self, t: f64) {
        self.values.fill(0.0);
        self.time = t;
    }

    /// Add the shift at `t` to the integrator's coordinates and velocities.
    pub(crate) fn add(&self, t: f64, state: &mut [f64]) {
        let n = self.values.len() / 2;
        let since = t - self.time;
        let (shift_q, shift_v) = self.values.split_at(n);
        let (q, v) = state.split_at_mut(n);
        for (((q, v), place), rate) in q.iter_mut().zip(v).zip(shift_q).zip(shift_v) {
            *q += place + since * rate;
            *v += rate;
        }
    }

    /// Return component `i` of [q, v] at `t` for the integrator's `value`.
    pub(crate) fn shifted(&self, i: usize, t: f64, value: f64) -> f64 {
        let n = self.values.len() / 2;
        let grown = if i < n {
            (t - self.time) * self.values[n + i]
        } else {
            0.0
        };
        value + self.values[i] + grown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multibody::{Body, Mechanism};

    #[test]
    fn frames_are_those_of_the_angles_of_the_free_bodies() {
        let body = |k: usize| {
            let body = Body::new(format!("body {k}"), 1.0, 1.0);
            if k == 2 { body.fixed() } else { body }
        };
        let bodies = (0..8).map(body).collect();
        let mechanism = Mechanism {
            bodies,
            ..Mechanism::default()
        };
        let model = MechanismModel::compile(&mechanism).unwrap();
        let mut frames = model.start_frames();
        let kept = frames.clone();
        let state: Vec<f64> = (0..42)
            .map(|i| 7.0 * f64::from(i).sin() + f64::from(i))
            .collect();
        model.place(&mut frames, &state);
        assert_eq!(model.read_state(&frames), state);
        for (body, frame) in frames.iter().enumerate() {
            let direction = frame.turned(Vec2::x());
            assert!((direction - crate::geometry::unit(frame.angle)).norm() < 4e-16);
            assert_eq!(body == 0 || body == 3, *frame == kept[body]);
        }
    }
}
