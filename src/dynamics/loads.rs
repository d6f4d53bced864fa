//! Contact, gravity, tensioner and drive loads gathered per body, and the accelerations that follow.

use super::Powers;
use crate::contact::{HingeContacts, ToothContacts};
use crate::geometry::Vec2;
use crate::model::{Model, Rotation, Support};
use crate::state::Motion;

/// Accelerations of all bodies, and what the chain does to the sprockets.
#[derive(Debug, Clone)]
pub struct Accelerations {
    /// d²x/dt² \[m/s²\]
    pub x: Vec<f64>,
    /// d²y/dt² \[m/s²\]
    pub y: Vec<f64>,
    /// d²θ/dt² \[rad/s²\]
    pub angle: Vec<f64>,
    /// Force of the chain on each sprocket \[N\].
    pub chain_force: Vec<Vec2>,
    /// Moment of the chain on each sprocket about its centre \[N m\].
    pub chain_moment: Vec<f64>,
    /// Tooth force on each bushing, x \[N\].
    tooth_x: Vec<f64>,
    /// Tooth force on each bushing, y \[N\].
    tooth_y: Vec<f64>,
}

impl Accelerations {
    pub(super) fn new(bodies: usize) -> Self {
        let zeros = || vec![0.0; bodies];
        Self {
            x: zeros(),
            y: zeros(),
            angle: zeros(),
            chain_force: vec![Vec2::zeros(); bodies],
            chain_moment: zeros(),
            tooth_x: zeros(),
            tooth_y: zeros(),
        }
    }

    pub(super) fn gather(
        &mut self,
        model: &Model,
        motion: &Motion,
        hinges: &HingeContacts,
        teeth: &ToothContacts,
        t: f64,
    ) {
        self.gather_teeth(model, teeth);
        self.accelerate_links(model, motion, hinges);
        self.accelerate_sprockets(model, motion, t);
    }

    /// Tooth forces by bushing and by sprocket.
    fn gather_teeth(&mut self, model: &Model, teeth: &ToothContacts) {
        self.tooth_x.fill(0.0);
        self.tooth_y.fill(0.0);
        self.chain_force.fill(Vec2::zeros());
        self.chain_moment.fill(0.0);
        for &pair in &teeth.near {
            let pair = pair as usize;
            let force = teeth.force[pair];
            if force == 0.0 {
                continue;
            }
            let (s, k) = (pair / model.links, pair % model.links);
            let push = force * Vec2::new(teeth.normal_x[pair], teeth.normal_y[pair]);
            self.tooth_x[k] -= push.x;
            self.tooth_y[k] -= push.y;
            self.chain_force[s] += push;
            self.chain_moment[s] += teeth.arm_x[pair] * push.y - teeth.arm_y[pair] * push.x;
        }
    }

    /// Each link: the hinge at its front, the one at its rear, and its bushings' teeth where it is an inner one.
    fn accelerate_links(&mut self, model: &Model, motion: &Motion, hinges: &HingeContacts) {
        let n = model.links;
        for i in 0..n {
            let before = if i == 0 { n - 1 } else { i - 1 };
            let mut front = hinges.force_on_front(i);
            let mut rear = -hinges.force_on_front(before);
            if Model::is_inner(i) {
                front += Vec2::new(self.tooth_x[i], self.tooth_y[i]);
                rear += Vec2::new(self.tooth_x[before], self.tooth_y[before]);
            }
            let moment = model.half_pitch
                * (motion.cos[i] * (front.y - rear.y) - motion.sin[i] * (front.x - rear.x));
            self.x[i] = (front.x + rear.x) * model.inverse_mass[i] + model.gravity.x;
            self.y[i] = (front.y + rear.y) * model.inverse_mass[i] + model.gravity.y;
            self.angle[i] = moment * model.inverse_inertia[i];
        }
    }

    fn accelerate_sprockets(&mut self, model: &Model, motion: &Motion, t: f64) {
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            let body = model.links + s;
            let force = self.chain_force[s];
            let acceleration = match sprocket.support {
                Support::Fixed => Vec2::zeros(),
                Support::Slide {
                    direction, damping, ..
                } => {
                    let speed = motion.vx[body] * direction.x + motion.vy[body] * direction.y;
                    let along = force.dot(&direction) + sprocket.pull(t) - damping * speed;
                    (along / sprocket.mass + model.gravity.dot(&direction)) * direction
                }
                Support::Floating { .. } => force / sprocket.mass + model.gravity,
            };
            self.x[body] = acceleration.x;
            self.y[body] = acceleration.y;
            self.angle[body] = match &sprocket.rotation {
                Rotation::Prescribed(speed) => speed.slope(t),
                Rotation::Free { .. } => {
                    (self.chain_moment[s] + sprocket.applied_torque(t)) / sprocket.inertia
                }
            };
        }
    }

    /// Torque on sprocket `s` from its motor or load \[N m\]: what it takes to move it as it moves.
    #[must_use]
    pub fn shaft_torque(&self, model: &Model, s: usize, t: f64) -> f64 {
        let sprocket = &model.sprockets[s];
        match &sprocket.rotation {
            Rotation::Prescribed(speed) => sprocket.inertia * speed.slope(t) - self.chain_moment[s],
            Rotation::Free { .. } => sprocket.applied_torque(t),
        }
    }
}

/// Adds the powers of motors, applied torques and tensioners.
///
/// A sprocket of prescribed speed is a support: its own kinetic energy stays out of the balance, and the work done on the
/// drive is that of its teeth on the chain.
pub(super) fn add_outside_powers(
    model: &Model,
    motion: &Motion,
    accelerations: &Accelerations,
    t: f64,
    powers: &mut Powers,
) {
    for (s, sprocket) in model.sprockets.iter().enumerate() {
        let body = model.links + s;
        let spin = motion.spin[body];
        powers.worked_in += match &sprocket.rotation {
            Rotation::Prescribed(_) => -accelerations.chain_moment[s] * spin,
            Rotation::Free { .. } => sprocket.applied_torque(t) * spin,
        };
        if let Support::Slide {
            direction, damping, ..
        } = sprocket.support
        {
            let speed = motion.vx[body] * direction.x + motion.vy[body] * direction.y;
            powers.worked_in += sprocket.pull(t) * speed;
            powers.dissipated += damping * speed * speed;
        }
    }
}
