//! Hinge contacts: pin in bushing of every hinge, from the last evaluation of the kernels.

use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::chain::rhs::layout::ChainArrays;
use crate::drive::bushing_on_front;
use crate::geometry::{Vec2, turned_left};
use crate::math::simd::Numbers;

/// Contacts of all hinges. Hinge `k` joins the front end of link `k` and the rear end of link `k + 1`; one is the pin, one the bushing.
#[derive(Debug, Clone)]
pub struct HingeContacts {
    /// Centres of the bushings \[m\].
    pub bushing: Vec<Vec2>,
    /// Velocities of the bushing centres \[m/s\].
    pub bushing_velocity: Vec<Vec2>,
    /// Front end of link k relative to the rear end of link k + 1 \[m\]; zero at open hinges of an open chain.
    pub offset: Vec<Vec2>,
    /// Unit vector along `offset`, x; zero where the centres coincide.
    pub direction_x: Vec<f64>,
    /// Unit vector along `offset`, y.
    pub direction_y: Vec<f64>,
    /// Penetration δ = |e| - c \[m\].
    pub penetration: Vec<f64>,
    /// Penetration rate dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Normal force \[N\].
    pub force: Vec<f64>,
    /// Friction on the rear end of link k + 1, along the direction turned left \[N\]; zero without a law of friction.
    pub friction: Vec<f64>,
    /// Force of the lubricant film on the front end of link k \[N\]; zero without a film.
    pub film: Vec<Vec2>,
}

impl HingeContacts {
    /// Create arrays of zeros for `links` hinges.
    #[must_use]
    pub fn new(links: usize) -> Self {
        let zeros = || vec![0.0; links];
        let points = || vec![Vec2::zeros(); links];
        Self {
            bushing: points(),
            bushing_velocity: points(),
            offset: points(),
            direction_x: zeros(),
            direction_y: zeros(),
            penetration: zeros(),
            rate: zeros(),
            force: zeros(),
            friction: zeros(),
            film: points(),
        }
    }

    /// Copy all hinges from the arrays `chain` of an evaluation at this motion.
    pub(crate) fn read(&mut self, model: &Model, motion: &Motion, chain: &ChainArrays) {
        let n = model.links;
        self.force.copy_from_slice(&chain.force[..n]);
        self.friction.copy_from_slice(&chain.friction[..n]);
        let both = |[x, y]: &[Numbers; 2], k: usize| Vec2::new(x[k], y[k]);
        let arm = |i: usize| model.chain.arms[i] * Vec2::new(chain.cos[i], chain.sin[i]);
        let center = |i: usize| Vec2::new(motion.x[i], motion.y[i]);
        for k in 0..n {
            let next = if k + 1 == n { 0 } else { k + 1 };
            self.bushing[k] = both(&chain.bushing, k);
            self.bushing_velocity[k] = both(&chain.bushing_velocity, k);
            self.film[k] = both(&chain.film, k);
            // e = x_k - x_next + a_k t_k + a_next t_next: front end of link k relative to the rear end of the next link, as in the kernels
            // (chain/rhs/chain/hinges.rs).
            self.offset[k] = if model.hinge_is_open(k) {
                Vec2::zeros()
            } else {
                center(k) - center(next) + arm(k) + arm(next)
            };
            let contact = BoreContact::of(chain, k, model.hinges.clearance);
            (self.penetration[k], self.rate[k]) = (contact.penetration, contact.rate);
            let direction = contact.over_distance * self.offset[k];
            (self.direction_x[k], self.direction_y[k]) = (direction.x, direction.y);
        }
    }

    /// Return centre \[m\] and velocity \[m/s\] of bushing `k`, which belongs to the inner one of the two links.
    #[must_use]
    pub fn bushing(&self, k: usize) -> (Vec2, Vec2) {
        (self.bushing[k], self.bushing_velocity[k])
    }

    /// Return the centre of the pin of hinge `k` relative to that of its bushing \[m\].
    #[must_use]
    pub fn eccentricity(&self, k: usize) -> Vec2 {
        if bushing_on_front(k, self.offset.len()) {
            -self.offset[k]
        } else {
            self.offset[k]
        }
    }

    /// Return the force on the pin of hinge `k` \[N\].
    #[must_use]
    pub fn force_on_pin(&self, k: usize) -> Vec2 {
        let on_front = self.force_on_front(k);
        if bushing_on_front(k, self.offset.len()) {
            -on_front
        } else {
            on_front
        }
    }

    /// Return the force on the front end of link `k` at hinge `k` \[N\]: film - normal force · n - friction · n turned left.
    #[must_use]
    pub fn force_on_front(&self, k: usize) -> Vec2 {
        let normal = Vec2::new(self.direction_x[k], self.direction_y[k]);
        self.film[k] - self.force[k] * normal - self.friction[k] * turned_left(normal)
    }
}

/// Penetration and penetration rate of a cylinder in a bore, from the distance of the centres.
pub(super) struct BoreContact {
    /// Penetration \[m\]; negative where apart.
    pub(super) penetration: f64,
    /// Penetration rate \[m/s\].
    pub(super) rate: f64,
    /// Inverse of the distance \[1/m\]; zero where the centres coincide.
    pub(super) over_distance: f64,
}

impl BoreContact {
    /// Return the contact of joint `k` of these arrays, with a radial `clearance` \[m\].
    pub(super) fn of(arrays: &ChainArrays, k: usize, clearance: f64) -> Self {
        let distance = arrays.distance_squared[k].sqrt();
        let over_distance = if distance > 0.0 { 1.0 / distance } else { 0.0 };
        // The kernel's penetration decides on contact: with zero penetration, a positive distance - clearance is rounding.
        let depth = arrays.depth[k];
        let apart = f64::min(distance - clearance, 0.0);
        Self {
            penetration: if depth == 0.0 { apart } else { depth },
            rate: arrays.along[k] * over_distance,
            over_distance,
        }
    }
}
