//! Vector between points of two bodies and its derivatives with respect to their six coordinates, for linearised forces and joints.

use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::{End, Frame};
use nalgebra::Matrix2;

/// Matrix over the coordinates of two bodies: [x, y, θ] of a, then of b.
pub(crate) type CoordinateBlock = [[f64; 6]; 6];

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

impl Pair {
    /// Return the pair of points a and b; `seen_from_a`: d is measured relative to body a.
    pub(crate) fn new(a: End, b: End, frames: &[Frame], seen_from_a: bool) -> Self {
        let (fa, fb) = (&frames[a.body], &frames[b.body]);
        let arms = [fa.turned(a.point), fb.turned(b.point)];
        let ([xa, ya, turn_a], [xb, yb, turn_b]) = (fa.rates(), fb.rates());
        Self {
            d: (fb.origin - fa.origin) + (arms[1] - arms[0]),
            arms,
            v: [xa, ya, turn_a, xb, yb, turn_b],
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
    pub(crate) fn plain_first(&self, k: usize) -> Vec2 {
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

    /// Add ∂Q/∂v · `by_velocity` + ∂Q/∂q · `by_place` of the generalised forces Q of a torque. It acts with a pair force measured
    /// relative to body a.
    pub(crate) fn add_torque(
        &self,
        torque: &PairTorque,
        by_velocity: f64,
        by_place: f64,
        block: &mut CoordinateBlock,
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
        block: &mut CoordinateBlock,
    ) {
        // Change of the force by a displacement and by a change of the relative velocity.
        let by_change = by_place * force.by_velocity;
        let by_shift = by_velocity * force.by_velocity + by_place * force.by_place;
        let [turns_a, turns_b] = self.turnings();
        // A displacement changes the velocity relative to a by the spin of a.
        let spin = if self.seen_from_a { self.v[2] } else { 0.0 };
        let [x, y] =
            [Vec2::x(), Vec2::y()].map(|e| by_shift * e - spin * (by_change * turned_left(e)));
        let [turn_a, turn_b] = [2, 5].map(|k| self.first(k));
        let by_turn_a = by_shift * turn_a + by_change * turns_a;
        let by_turn_b = by_shift * turn_b + by_change * turns_b;
        let columns = [-x, -y, by_turn_a, x, y, by_turn_b];
        for (l, column) in columns.iter().enumerate() {
            block[0][l] -= column.x;
            block[1][l] -= column.y;
            block[2][l] += turn_a.dot(column);
            block[3][l] += column.x;
            block[4][l] += column.y;
            block[5][l] += turn_b.dot(column);
        }
        // The force itself times ∂²d/∂q².
        let along = by_place * force.force;
        block[5][5] -= along.dot(&self.arms[1]);
        if !self.seen_from_a {
            block[2][2] += along.dot(&self.arms[0]);
            return;
        }
        block[2][2] -= along.dot(&(self.arms[0] + self.d));
        let beside = along.dot(&self.arms[1]);
        for (l, bend) in [
            (0, along.y),
            (1, -along.x),
            (3, -along.y),
            (4, along.x),
            (5, beside),
        ] {
            block[2][l] += bend;
            block[l][2] += bend;
        }
    }

    /// Return the derivatives of the relative velocity with respect to both angles.
    fn turnings(&self) -> [Vec2; 2] {
        let ([arm_a, arm_b], [spin_a, spin_b]) = (self.arms, [self.v[2], self.v[5]]);
        if self.seen_from_a {
            let seen = -turned_left(self.rate()) - spin_a * self.d;
            [seen, (spin_a - spin_b) * arm_b]
        } else {
            [spin_a * arm_a, -spin_b * arm_b]
        }
    }
}
