//! Roller contacts: clearance joint between each bushing and its roller, from the last evaluation of the kernels.

use super::HingeContacts;
use super::hinges::BoreContact;
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::chain::rhs::layout::ChainArrays;
use crate::geometry::{Vec2, turned_left};

/// Contacts of all rollers on their bushings; empty where rollers are no bodies of their own.
#[derive(Debug, Clone)]
pub struct RollerContacts {
    /// Unit vector from the roller's centre to the bushing's, x.
    pub direction_x: Vec<f64>,
    /// Unit vector from the roller's centre to the bushing's, y.
    pub direction_y: Vec<f64>,
    /// Penetration δ = |e| - c \[m\].
    pub penetration: Vec<f64>,
    /// Penetration rate dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Normal force \[N\].
    pub force: Vec<f64>,
    /// Friction on the roller, along the direction turned left \[N\]; zero without a law of friction.
    pub friction: Vec<f64>,
    /// Centre of the bushing relative to that of the roller \[m\].
    pub eccentricity: Vec<Vec2>,
}

impl RollerContacts {
    /// Create arrays of zeros for `rollers` rollers.
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
            eccentricity: vec![Vec2::zeros(); rollers],
        }
    }

    /// Copy all rollers from the arrays of an evaluation; the values of absent rollers remain unchanged.
    pub(crate) fn read(
        &mut self,
        model: &Model,
        motion: &Motion,
        hinges: &HingeContacts,
        arrays: Option<&ChainArrays>,
    ) {
        let (Some(rollers), Some(arrays)) = (&model.rollers, arrays) else {
            return;
        };
        for k in (0..model.links).filter(|&k| model.bushing_is_there(k)) {
            let body = model.links + k;
            let offset = hinges.bushing[k] - Vec2::new(motion.x[body], motion.y[body]);
            let gap = BoreContact::of(arrays, k, rollers.clearance);
            let direction = gap.over_distance * offset;
            (self.direction_x[k], self.direction_y[k]) = (direction.x, direction.y);
            (self.penetration[k], self.rate[k]) = (gap.penetration, gap.rate);
            (self.force[k], self.friction[k]) = (arrays.force[k], arrays.friction[k]);
            self.eccentricity[k] = offset;
        }
    }

    /// Return the force of the bushing on roller `k` \[N\].
    #[must_use]
    pub fn force_on_roller(&self, k: usize) -> Vec2 {
        let normal = Vec2::new(self.direction_x[k], self.direction_y[k]);
        self.force[k] * normal + self.friction[k] * turned_left(normal)
    }
}

/// Return ((centre, velocity), body) of the roller or bushing of hinge `k` that is in contact with the teeth \[m, m/s\].
#[must_use]
pub fn on_teeth(
    model: &Model,
    motion: &Motion,
    hinges: &HingeContacts,
    k: usize,
) -> ((Vec2, Vec2), usize) {
    if model.rollers.is_none() {
        return (hinges.bushing(k), model.link_of_bushing(k));
    }
    let body = model.links + k;
    let center = Vec2::new(motion.x[body], motion.y[body]);
    let velocity = Vec2::new(motion.vx[body], motion.vy[body]);
    ((center, velocity), body)
}
