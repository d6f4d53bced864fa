//! Roller on bushing: a clearance joint between each bushing and the roller that turns on it.

use super::HingeContacts;
use super::clearance_joint::pin_in_bushing;
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::geometry::{Vec2, turned_left};

/// All rollers on their bushings; empty where rollers are no bodies of their own.
#[derive(Debug, Clone)]
pub struct RollerContacts {
    /// Unit vector from the roller's centre to the bushing's, x.
    pub direction_x: Vec<f64>,
    /// The same, y.
    pub direction_y: Vec<f64>,
    /// Penetration δ = |e| - c \[m\].
    pub penetration: Vec<f64>,
    /// dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Normal force \[N\], written by the dynamics.
    pub force: Vec<f64>,
    /// Friction on the roller, along the direction turned left \[N\]; zero without a law of friction.
    pub friction: Vec<f64>,
    /// Moments of friction about the bushing and about the roller \[N m\].
    pub moments: Vec<[f64; 2]>,
    /// Bushing's centre seen from the roller's \[m\].
    pub eccentricity: Vec<Vec2>,
}

impl RollerContacts {
    /// Room for so many.
    #[must_use]
    pub fn new(rollers: usize) -> Self {
        let zeros = || vec![0.0; rollers];
        Self {
            direction_x: zeros(),
            direction_y: zeros(),
            penetration: zeros(),
            rate: zeros(),
            force: zeros(),
            friction: zeros(),
            moments: vec![[0.0; 2]; rollers],
            eccentricity: vec![Vec2::zeros(); rollers],
        }
    }

    /// Finds the depth of every bushing in its roller's bore, where there are rollers; the ends of links are known.
    pub fn find(&mut self, model: &Model, motion: &Motion, hinges: &HingeContacts) {
        let Some(rollers) = &model.rollers else {
            return;
        };
        for k in 0..model.links {
            if !model.bushing_is_there(k) {
                continue;
            }
            let ((bushing, bushing_velocity), (roller, velocity)) =
                (hinges.bushing(k), roller_center(model, motion, k));
            let offset = bushing - roller;
            let contact = pin_in_bushing(offset, bushing_velocity - velocity, rollers.clearance);
            self.direction_x[k] = contact.normal.x;
            self.direction_y[k] = contact.normal.y;
            self.penetration[k] = contact.penetration;
            self.rate[k] = contact.penetration_rate;
            self.eccentricity[k] = offset;
        }
    }

    /// Force on roller `k` of its bushing \[N\].
    #[must_use]
    pub fn force_on_roller(&self, k: usize) -> Vec2 {
        let normal = Vec2::new(self.direction_x[k], self.direction_y[k]);
        self.force[k] * normal + self.friction[k] * turned_left(normal)
    }
}

/// Centre of roller `k` and its velocity.
fn roller_center(model: &Model, motion: &Motion, k: usize) -> (Vec2, Vec2) {
    let body = model.links + k;
    (
        Vec2::new(motion.x[body], motion.y[body]),
        Vec2::new(motion.vx[body], motion.vy[body]),
    )
}

/// Centre of what meets the teeth at hinge `k`, roller or bushing, its velocity, and the body that it turns with.
#[must_use]
pub fn on_teeth(
    model: &Model,
    motion: &Motion,
    hinges: &HingeContacts,
    k: usize,
) -> ((Vec2, Vec2), usize) {
    if model.rollers.is_some() {
        (roller_center(model, motion, k), model.links + k)
    } else {
        (hinges.bushing(k), model.link_of_bushing(k))
    }
}
