//! Vector between points of two bodies and its derivatives with respect to their six coordinates, for linearised forces and joints.

use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::{End, Frame};
use nalgebra::Matrix2;

/// Matrix over the coordinates of two bodies: [x, y, θ] of a, then of b.
pub(crate) type Block = [[f64; 6]; 6];

/// Vector d from point a to point b and its derivatives; components in the ground's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    pub(crate) d: Vec2,
    /// Vectors from the centres of mass to the points.
    arms: [Vec2; 2],
    /// Velocities of the six coordinates.
    pub(crate) v: [f64; 6],
    /// Whether d is measured relative to body a: its derivative with respect to `θ_a` then includes the rotation of the frame of a.
    seen_from_a: bool,
}

/// Force on b with its reaction on a at the same place, and its derivatives with respect to the position and velocity of point b
/// relative to a.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PairForce {
    pub(crate) force: Vec2,
    pub(crate) by_place: Matrix2<f64>,
    pub(crate) by_velocity: Matrix2<f64>,
}

impl PairForce {
    /// Add another force between the same points.
    pub(crate) fn add(&mut self, part: &Self) {
        self.force += part.force;
        self.by_place += part.by_place;
        self.by_velocity += part.by_velocity;
    }
}

/// Derivatives of a torque on b, with its reaction on a, and of the force that acts with it.
///
/// The torque depends on position and velocity of point b and on the angular velocity of b, all relative to a; `force_by_spin` is the
/// derivative of the force with respect to that angular velocity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairTorque {
    pub(crate) force_by_spin: Vec2,
    pub(crate) by_place: Vec2,
    pub(crate) by_velocity: Vec2,
    pub(crate) by_spin: f64,
}

/// Numbers of the coordinates that are angles.
const ANGLES: [usize; 2] = [2, 5];

impl Pair {
    /// Return the pair of points a and b; `seen_from_a`: d is measured relative to body a.
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

    /// Return ∂d/∂q of one coordinate.
    pub(crate) fn first(&self, k: usize) -> Vec2 {
        // Relative to the frame of a, d rotates by -`θ_a`.
        let turned = if self.seen_from_a && k == 2 {
            -turned_left(self.d)
        } else {
            Vec2::zeros()
        };
        self.plain_first(k) + turned
    }

    /// Return the same relative to the ground.
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

    /// Return ∂²d/∂q² of two coordinates.
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

    /// Return d' = ∂d/∂q v relative to the ground.
    pub(crate) fn rate(&self) -> Vec2 {
        (0..6).map(|k| self.v[k] * self.plain_first(k)).sum()
    }

    /// Return d'' relative to the ground at zero accelerations.
    pub(crate) fn second_rate(&self) -> Vec2 {
        self.v[2] * self.v[2] * self.arms[0] - self.v[5] * self.v[5] * self.arms[1]
    }

    /// Return the derivative of d' with respect to a coordinate, relative to the ground.
    pub(crate) fn rate_by(&self, k: usize) -> Vec2 {
        match k {
            2 => self.v[2] * self.arms[0],
            5 => -self.v[5] * self.arms[1],
            _ => Vec2::zeros(),
        }
    }

    /// Return the derivative of d'' with respect to a coordinate, relative to the ground.
    pub(crate) fn second_rate_by(&self, k: usize) -> Vec2 {
        match k {
            2 => self.v[2] * self.v[2] * turned_left(self.arms[0]),
            5 => -self.v[5] * self.v[5] * turned_left(self.arms[1]),
            _ => Vec2::zeros(),
        }
    }

    /// Return ∂d/∂q relative to the ground, for joints.
    pub(crate) fn slope(&self, k: usize) -> Vec2 {
        self.plain_first(k)
    }

    /// Add ∂Q/∂v · `by_velocity` + ∂Q/∂q · `by_place` of the generalised forces Q of a torque. It acts with a pair force measured
    /// relative to body a.
    pub(crate) fn add_torque(
        &self,
        torque: &PairTorque,
        by_velocity: f64,
        by_place: f64,
        block: &mut Block,
    ) {
        // Torque: ω = v₅ - v₂, so `arm` is ∂ω/∂v and Q = `arm`ᵀ τ. The force adds (∂d/∂q)ᵀ `force_by_spin` ∂ω/∂v.
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

    /// Add ∂Q/∂v · `by_velocity` + ∂Q/∂q · `by_place` of the generalised forces Q of a pair force.
    pub(crate) fn add(
        &self,
        force: &PairForce,
        by_velocity: f64,
        by_place: f64,
        block: &mut Block,
    ) {
        let [turn_a, turn_b] = ANGLES.map(|k| self.first(k));
        // Change of the force by one coordinate. The columns of the two points' displacements differ in their signs.
        let change = |l: usize, first: Vec2| {
            let turning = self.turning(l);
            let with_velocity = force.by_velocity * first;
            let with_place = force.by_place * first + force.by_velocity * turning;
            by_velocity * with_velocity + by_place * with_place
        };
        let [x, y] = [3, 4].map(|l| change(l, self.first(l)));
        let columns = [-x, -y, change(2, turn_a), x, y, change(5, turn_b)];
        for (l, column) in columns.iter().enumerate() {
            block[0][l] -= column.x;
            block[1][l] -= column.y;
            block[2][l] += turn_a.dot(column);
            block[3][l] += column.x;
            block[4][l] += column.y;
            block[5][l] += turn_b.dot(column);
        }
        if by_place == 0.0 {
            return;
        }
        let along = by_place * force.force;
        for k in ANGLES {
            #[allow(clippy::needless_range_loop)] // l is a column of one line and a line of another
            for l in 0..6 {
                let bend = along.dot(&self.second(k, l));
                block[k][l] += bend;
                if !ANGLES.contains(&l) {
                    block[l][k] += bend;
                }
            }
        }
    }

    /// Return the derivative of the relative velocity with respect to a coordinate.
    fn turning(&self, l: usize) -> Vec2 {
        if !self.seen_from_a {
            return self.rate_by(l);
        }
        // ∂²d/∂q² of two coordinates vanishes without an angle.
        if ANGLES.contains(&l) {
            (0..6).map(|j| self.v[j] * self.second(j, l)).sum()
        } else {
            ANGLES.map(|j| self.v[j] * self.second(j, l)).iter().sum()
        }
    }
}
