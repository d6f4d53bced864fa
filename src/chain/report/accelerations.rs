//! Accelerations of all bodies, and loads of the chain on sprockets and ends, from the last evaluation of the kernels.

use crate::chain::loads::{SprocketKinematics, SprocketLoad, sprocket_acceleration};
use crate::chain::model::{Model, Rotation};
use crate::chain::motion::Motion;
use crate::geometry::Vec2;

/// Accelerations of all bodies, and loads of the chain on sprockets and ends.
#[derive(Debug, Clone)]
pub struct Accelerations {
    /// d²x/dt² \[m/s²\]
    pub x: Vec<f64>,
    /// d²y/dt² \[m/s²\]
    pub y: Vec<f64>,
    /// d²θ/dt² \[rad/s²\]
    pub angle: Vec<f64>,
    /// Load of the chain on each sprocket.
    pub chain: Vec<SprocketLoad>,
    /// Force of an open chain on both of its ends \[N\].
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

    /// Copy the accelerations of links and rollers from those of their coordinates, `rates`, and compute those of the sprockets.
    ///
    /// The accelerations of the sprockets follow from the loads in `chain`.
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
            let moves = SprocketKinematics::of(motion, body);
            let load = &self.chain[s];
            let (center, angle) =
                sprocket_acceleration(sprocket, model.gravity, &moves, load, pawls[s], t);
            (self.x[body], self.y[body]) = (center.x, center.y);
            self.angle[body] = angle;
        }
    }

    /// Return the shaft torque on sprocket `s` at time `t` \[s\] and angular speed `spin` \[rad/s\], by motor or load \[N m\].
    ///
    /// Prescribed speed: J dω/dt - M, with the moment M of the chain. Other rotations: applied torque.
    #[must_use]
    pub fn shaft_torque(&self, model: &Model, s: usize, t: f64, spin: f64) -> f64 {
        let sprocket = &model.sprockets[s];
        match &sprocket.rotation {
            Rotation::Prescribed(speed) => sprocket.inertia * speed.slope(t) - self.chain[s].moment,
            Rotation::Free { .. } => sprocket.applied_torque(t, spin),
        }
    }
}
