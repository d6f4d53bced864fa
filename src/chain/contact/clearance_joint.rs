//! Pin in bushing: every hinge of the chain (paper's Eqs. 2 and 3).

use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::drive::bushing_on_front;
use crate::geometry::Contact;
use crate::geometry::{Vec2, turned_left};

/// All hinges. Hinge `k` has an end of link `k` (its front) and one of link `k + 1` (its rear); one is the pin, one the bushing.
#[derive(Debug, Clone)]
pub struct HingeContacts {
    /// Front end of link k, x \[m\].
    pub front_x: Vec<f64>,
    /// Front end of link k, y \[m\].
    pub front_y: Vec<f64>,
    /// Its velocity, x \[m/s\].
    pub front_vx: Vec<f64>,
    /// Its velocity, y \[m/s\].
    pub front_vy: Vec<f64>,
    /// Rear end of link k, x \[m\].
    pub rear_x: Vec<f64>,
    /// Rear end of link k, y \[m\].
    pub rear_y: Vec<f64>,
    /// Its velocity, x \[m/s\].
    pub rear_vx: Vec<f64>,
    /// Its velocity, y \[m/s\].
    pub rear_vy: Vec<f64>,
    /// Unit vector from the rear end of link k + 1 to the front end of link k, x.
    pub direction_x: Vec<f64>,
    /// The same, y.
    pub direction_y: Vec<f64>,
    /// Penetration δ = |e| - c \[m\].
    pub penetration: Vec<f64>,
    /// dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Normal force \[N\], written by the dynamics.
    pub force: Vec<f64>,
    /// Friction on the rear end of link k + 1, along the direction turned left \[N\]; zero without a law of friction.
    pub friction: Vec<f64>,
    /// Force of lubricant on the front end of link k \[N\]; zero without any.
    pub film: Vec<Vec2>,
    /// Moments of friction and lubricant about the front end of link k and the rear end of link k + 1 \[N m\].
    pub moments: Vec<[f64; 2]>,
    /// The hinges that are none, where an open chain is open.
    open: Vec<usize>,
}

impl HingeContacts {
    /// Room for `links` hinges.
    #[must_use]
    pub fn new(links: usize) -> Self {
        let zeros = || vec![0.0; links];
        Self {
            front_x: zeros(),
            front_y: zeros(),
            front_vx: zeros(),
            front_vy: zeros(),
            rear_x: zeros(),
            rear_y: zeros(),
            rear_vx: zeros(),
            rear_vy: zeros(),
            direction_x: zeros(),
            direction_y: zeros(),
            penetration: zeros(),
            rate: zeros(),
            force: zeros(),
            friction: zeros(),
            film: vec![Vec2::zeros(); links],
            moments: vec![[0.0; 2]; links],
            open: Vec::new(),
        }
    }

    /// Room for the hinges of `model`, of which some may be none.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        Self {
            open: (0..model.links)
                .filter(|&k| model.hinge_is_open(k))
                .collect(),
            ..Self::new(model.links)
        }
    }

    /// Finds the depth of every hinge.
    pub fn find(&mut self, model: &Model, motion: &Motion) {
        let n = model.links;
        self.place_ends(model, motion);
        for k in 0..n {
            let next = if k + 1 == n { 0 } else { k + 1 };
            let offset = Vec2::new(
                self.front_x[k] - self.rear_x[next],
                self.front_y[k] - self.rear_y[next],
            );
            let velocity = Vec2::new(
                self.front_vx[k] - self.rear_vx[next],
                self.front_vy[k] - self.rear_vy[next],
            );
            let contact = pin_in_bushing(offset, velocity, model.clearance);
            self.direction_x[k] = contact.normal.x;
            self.direction_y[k] = contact.normal.y;
            self.penetration[k] = contact.penetration;
            self.rate[k] = contact.penetration_rate;
        }
        for &k in &self.open {
            // As of centres that coincide.
            (self.direction_x[k], self.direction_y[k]) = (0.0, 0.0);
            (self.penetration[k], self.rate[k]) = (-model.clearance, 0.0);
        }
    }

    /// Finds the ends of the links only, and with them the bushings.
    pub(crate) fn place_ends(&mut self, model: &Model, motion: &Motion) {
        for i in 0..model.links {
            let (dx, dy) = (model.arms[i] * motion.cos[i], model.arms[i] * motion.sin[i]);
            let (dvx, dvy) = (-dy * motion.spin[i], dx * motion.spin[i]);
            self.front_x[i] = motion.x[i] + dx;
            self.front_y[i] = motion.y[i] + dy;
            self.rear_x[i] = motion.x[i] - dx;
            self.rear_y[i] = motion.y[i] - dy;
            self.front_vx[i] = motion.vx[i] + dvx;
            self.front_vy[i] = motion.vy[i] + dvy;
            self.rear_vx[i] = motion.vx[i] - dvx;
            self.rear_vy[i] = motion.vy[i] - dvy;
        }
    }

    /// Centre of bushing `k` and its velocity; it belongs to the inner one of the two links.
    #[must_use]
    pub fn bushing(&self, k: usize) -> (Vec2, Vec2) {
        if bushing_on_front(k, self.rear_x.len()) {
            (
                Vec2::new(self.front_x[k], self.front_y[k]),
                Vec2::new(self.front_vx[k], self.front_vy[k]),
            )
        } else {
            let next = if k + 1 == self.rear_x.len() { 0 } else { k + 1 };
            (
                Vec2::new(self.rear_x[next], self.rear_y[next]),
                Vec2::new(self.rear_vx[next], self.rear_vy[next]),
            )
        }
    }

    /// Pin centre of hinge `k` seen from its bushing's \[m\].
    #[must_use]
    pub fn eccentricity(&self, k: usize) -> Vec2 {
        if self.open.contains(&k) {
            return Vec2::zeros();
        }
        let next = if k + 1 == self.rear_x.len() { 0 } else { k + 1 };
        let offset = Vec2::new(
            self.front_x[k] - self.rear_x[next],
            self.front_y[k] - self.rear_y[next],
        );
        if bushing_on_front(k, self.rear_x.len()) {
            -offset
        } else {
            offset
        }
    }

    /// Force on the pin of hinge `k` \[N\].
    #[must_use]
    pub fn force_on_pin(&self, k: usize) -> Vec2 {
        let on_front = self.force_on_front(k);
        if bushing_on_front(k, self.rear_x.len()) {
            -on_front
        } else {
            on_front
        }
    }

    /// Force on the front end of link `k` at hinge `k` \[N\].
    #[must_use]
    pub fn force_on_front(&self, k: usize) -> Vec2 {
        let normal = Vec2::new(self.direction_x[k], self.direction_y[k]);
        self.film[k] - self.force[k] * normal - self.friction[k] * turned_left(normal)
    }
}

/// One cylinder in a bore with radial `clearance`: `offset` and `velocity` of the inner centre seen from the outer one.
#[must_use]
pub(super) fn pin_in_bushing(offset: Vec2, velocity: Vec2, clearance: f64) -> Contact {
    let distance = offset.norm();
    let normal = if distance > 0.0 {
        offset / distance
    } else {
        Vec2::zeros()
    };
    Contact {
        normal,
        penetration: distance - clearance,
        penetration_rate: normal.dot(&velocity),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_contact_up_to_the_edge_of_the_clearance() {
        let contact = pin_in_bushing(Vec2::new(0.0, 25e-6), Vec2::new(3.0, 0.5), 25e-6);
        assert!(contact.penetration <= 0.0);
        assert!((contact.penetration_rate - 0.5).abs() < 1e-15);
    }

    #[test]
    fn coincident_centres_are_one_clearance_apart_and_have_no_direction() {
        let contact = pin_in_bushing(Vec2::zeros(), Vec2::new(1.0, 1.0), 25e-6);
        assert_eq!(contact.penetration, -25e-6);
        assert_eq!(contact.normal, Vec2::zeros());
    }
}
