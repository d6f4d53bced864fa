//! The vector between points of two bodies and its derivatives by their six coordinates: what linearised forces and joints need.

use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::{End, Frame};
use nalgebra::Matrix2;

/// A matrix over the coordinates of two bodies, [x, y, θ] of a, then of b.
pub(crate) type Block = [[f64; 6]; 6];

/// The vector d from point a to point b, as it changes with the coordinates; all in the ground's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    pub(crate) d: Vec2,
    /// Directions of the points from the centres of mass.
    arms: [Vec2; 2],
    /// Velocities of the coordinates.
    pub(crate) v: [f64; 6],
    /// Whether d is seen from body a, so that a turn of a turns it.
    seen_from_a: bool,
}

/// A force on b, its reaction on a at the same place, and how it changes with place and velocity of point b seen from a.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PairForce {
    pub(crate) force: Vec2,
    pub(crate) by_place: Matrix2<f64>,
    pub(crate) by_velocity: Matrix2<f64>,
}

impl PairForce {
    /// Adds another one between the same points.
    pub(crate) fn add(&mut self, part: &Self) {
        self.force += part.force;
        self.by_place += part.by_place;
        self.by_velocity += part.by_velocity;
    }
}

/// How a torque on b, with its reaction on a, changes with place and velocity of point b and the angular velocity of b, all seen
/// from a, and how the force beside it changes with that angular velocity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairTorque {
    pub(crate) force_by_spin: Vec2,
    pub(crate) by_place: Vec2,
    pub(crate) by_velocity: Vec2,
    pub(crate) by_spin: f64,
}

/// The coordinates that are angles.
const ANGLES: [usize; 2] = [2, 5];

impl Pair {
    pub(crate) fn new(a: End, b: End, frames: &[Frame], seen_from_a: bool) -> Self {
        let (fa, fb) = (&frames[a.body], &frames[b.body]);
        let arms = [fa.turned(a.point), fb.turned(b.point)];
        Self {
            d: (fb.origin - fa.origin) + (arms[1] - arms[0]),
            arms,
            v: [
                fa.velocity.x,
                fa.velocity.y,
                fa.spin,
                fb.velocity.x,
                fb.velocity.y,
                fb.spin,
            ],
            seen_from_a,
        }
    }

    /// ∂d/∂q of one coordinate.
    pub(crate) fn first(&self, k: usize) -> Vec2 {
        let turned = if self.seen_from_a && k == 2 {
            -turned_left(self.d)
        } else {
            Vec2::zeros()
        };
        self.plain_first(k) + turned
    }

    /// The same as seen from the ground.
    fn plain_first(&self, k: usize) -> Vec2 {
        match k {
            0 => Vec2::new(-1.0, 0.0),
            1 => Vec2::new(0.0, -1.0),
            2 => -turned_left(self.arms[0]),
            3 => Vec2::new(1.0, 0.0),
            4 => Vec2::new(0.0, 1.0),
            _ => turned_left(self.arms[1]),
        }
    }

    /// ∂²d/∂q² of two coordinates.
    pub(crate) fn second(&self, k: usize, l: usize) -> Vec2 {
        let mut found = match (k, l) {
            (2, 2) => self.arms[0],
            (5, 5) => -self.arms[1],
            _ => Vec2::zeros(),
        };
        if self.seen_from_a {
            if k == 2 {
                found -= turned_left(self.plain_first(l));
            }
            if l == 2 {
                found -= turned_left(self.plain_first(k));
            }
            if k == 2 && l == 2 {
                found -= self.d;
            }
        }
        found
    }

    /// d' along the velocities, seen from the ground.
    pub(crate) fn rate(&self) -> Vec2 {
        (0..6).map(|k| self.v[k] * self.plain_first(k)).sum()
    }

    /// d'' along the velocities, seen from the ground, without accelerations.
    pub(crate) fn second_rate(&self) -> Vec2 {
        self.v[2] * self.v[2] * self.arms[0] - self.v[5] * self.v[5] * self.arms[1]
    }

    /// How the rate changes with a coordinate, seen from the ground.
    pub(crate) fn rate_by(&self, k: usize) -> Vec2 {
        match k {
            2 => self.v[2] * self.arms[0],
            5 => -self.v[5] * self.arms[1],
            _ => Vec2::zeros(),
        }
    }

    /// How the second rate changes with a coordinate, seen from the ground.
    pub(crate) fn second_rate_by(&self, k: usize) -> Vec2 {
        match k {
            2 => self.v[2] * self.v[2] * turned_left(self.arms[0]),
            5 => -self.v[5] * self.v[5] * turned_left(self.arms[1]),
            _ => Vec2::zeros(),
        }
    }

    /// ∂d/∂q for plain d, for joints.
    pub(crate) fn slope(&self, k: usize) -> Vec2 {
        self.plain_first(k)
    }

    /// The same of a torque beside a pair force that is seen from a.
    pub(crate) fn add_torque(
        &self,
        torque: &PairTorque,
        by_velocity: f64,
        by_place: f64,
        block: &mut Block,
    ) {
        // ∂ω/∂v of ω = v₅ - v₂.
        let arm = [0.0, 0.0, -1.0, 0.0, 0.0, 1.0];
        let first: [Vec2; 6] = std::array::from_fn(|k| self.first(k));
        for l in 0..6 {
            let turning: Vec2 = (0..6).map(|j| self.v[j] * self.second(j, l)).sum();
            let with_velocity = torque.by_velocity.dot(&first[l]) + torque.by_spin * arm[l];
            let with_place = torque.by_place.dot(&first[l]) + torque.by_velocity.dot(&turning);
            let change = by_velocity * with_velocity + by_place * with_place;
            let force = by_velocity * arm[l] * torque.force_by_spin;
            for k in 0..6 {
                block[k][l] += arm[k] * change + first[k].dot(&force);
            }
        }
    }

    /// Adds ∂Q/∂v · `by_velocity` + ∂Q/∂q · `by_place` of the generalised forces Q of a pair force.
    pub(crate) fn add(
        &self,
        force: &PairForce,
        by_velocity: f64,
        by_place: f64,
        block: &mut Block,
    ) {
        let first: [Vec2; 6] = std::array::from_fn(|k| self.first(k));
        for l in 0..6 {
            // How the velocity seen changes with the coordinate.
            let turning: Vec2 = if self.seen_from_a {
                (0..6).map(|j| self.v[j] * self.second(j, l)).sum()
            } else {
                self.rate_by(l)
            };
            let with_velocity = force.by_velocity * first[l];
            let with_place = force.by_place * first[l] + force.by_velocity * turning;
            let change = by_velocity * with_velocity + by_place * with_place;
            for k in 0..6 {
                block[k][l] += first[k].dot(&change);
                if by_place != 0.0 && (ANGLES.contains(&k) || ANGLES.contains(&l)) {
                    block[k][l] += by_place * force.force.dot(&self.second(k, l));
                }
            }
        }
    }
}
