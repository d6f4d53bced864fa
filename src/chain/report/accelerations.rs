//! Accelerations of all bodies, and what the chain does to sprockets and ends, as the kernels left them.

use crate::chain::dynamics::{Moves, SprocketLoad, sprocket_acceleration};
use crate::chain::model::{Model, Rotation};
use crate::chain::motion::Motion;
use crate::geometry::Vec2;

/// Accelerations of all bodies, and what the chain does to the sprockets.
#[derive(Debug, Clone)]
pub struct Accelerations {
    /// d²x/dt² \[m/s²\]
    pub x: Vec<f64>,
    /// d²y/dt² \[m/s²\]
    pub y: Vec<f64>,
    /// d²θ/dt² \[rad/s²\]
    pub angle: Vec<f64>,
    /// What the chain does to each sprocket.
    pub chain: Vec<SprocketLoad>,
    /// Force of the chain on both ends of an open one \[N\].
    pub on_ends: [Vec2; 2],
}

impl Accelerations {
    pub(crate) fn new(bodies: usize, sprockets: usize) -> Self {
        let zeros = || vec![0.0; bodies];
        Self {
            x: zeros(),
            y: zeros(),
            angle: zeros(),
            chain: vec![SprocketLoad::default(); sprockets],
            on_ends: [Vec2::zeros(); 2],
        }
    }

    /// Takes the accelerations of links and rollers from those of their coordinates, `rates`, and finds those of the sprockets under
    /// the loads that they have.
    pub(crate) fn read(
        &mut self,
        model: &Model,
        motion: &Motion,
        rates: &[f64],
        pawls: &[f64],
        t: f64,
    ) {
        let n = model.links;
        let rollers = model.rollers.as_ref().map(|of| (of.first, n));
        for (first, body) in std::iter::once((0, 0)).chain(rollers) {
            let of = |axis: usize| &rates[first + axis * n..first + (axis + 1) * n];
            self.x[body..body + n].copy_from_slice(of(0));
            self.y[body..body + n].copy_from_slice(of(1));
            self.angle[body..body + n].copy_from_slice(of(2));
        }
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            let body = model.wheel_body(s);
            let moves = Moves::of(motion, body);
            let load = &self.chain[s];
            let (center, angle) =
                sprocket_acceleration(sprocket, model.gravity, &moves, load, pawls[s], t);
            (self.x[body], self.y[body]) = (center.x, center.y);
            self.angle[body] = angle;
        }
    }

    /// Torque on sprocket `s`, which turns at `spin` \[rad/s\], from its motor or load \[N m\]: what it takes to move it as it moves.
    #[must_use]
    pub fn shaft_torque(&self, model: &Model, s: usize, t: f64, spin: f64) -> f64 {
        let sprocket = &model.sprockets[s];
        match &sprocket.rotation {
            Rotation::Prescribed(speed) => sprocket.inertia * speed.slope(t) - self.chain[s].moment,
            Rotation::Free { .. } => sprocket.applied_torque(t, spin),
        }
    }
}
