//! Derivatives of force elements with respect to positions and velocities: analytical, by differences for callables.

use nalgebra::Matrix2;

use crate::geometry::{Vec2, turned_left};
use crate::multibody::constraints::relative_kinematics::{CoordinateBlock, Pair, PairForce};
use crate::multibody::description::body::Frame;
use crate::multibody::description::force_element::{CustomForce, Force, ForceKind};
use crate::multibody::description::spring_law::SpringLaw;

/// Increment of coordinates and velocities in the forward differences of a callable \[m, rad, m/s, rad/s\].
const CHANGE: f64 = 1e-7;

impl Force {
    /// Add ∂Q/∂v · `by_velocity` + ∂Q/∂q · `by_place` of the generalised forces Q of the element on bodies a and b.
    ///
    /// Rows and columns 0 to 2 of the block belong to body a, 3 to 5 to body b.
    pub(crate) fn add_slopes(
        &self,
        t: f64,
        frames: &[Frame],
        by_velocity: f64,
        by_place: f64,
        block: &mut CoordinateBlock,
    ) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        match &self.kind {
            ForceKind::Torque(_) => {}
            ForceKind::TorqueBySpeed(table) => {
                add_twist(by_velocity * table.slope(fb.spin - fa.spin), block);
            }
            ForceKind::TorsionSpring { law, .. } => {
                let stiffness = law.stiffness(fb.angle - fa.angle - self.rest);
                add_twist(-(by_velocity * law.damping + by_place * stiffness), block);
            }
            ForceKind::Force { x, y, follows } => {
                let given = Vec2::new(x.value(t), y.value(t));
                if *follows {
                    // The force rotates with the body: dF/dθ = F turned left. Its torque about the centre of mass is constant.
                    let turning = turned_left(fb.turned(given));
                    block[3][5] += by_place * turning.x;
                    block[4][5] += by_place * turning.y;
                } else {
                    // The arm r rotates with the body: d(r × F)/dθ = -r·F.
                    block[5][5] -= by_place * fb.turned(self.b.point).dot(&given);
                }
            }
            ForceKind::Spring { law, .. } => {
                let pair = Pair::new(self.a, self.b, frames, false);
                if let Some(force) = self.pull_slopes(law, &pair) {
                    pair.add(&force, by_velocity, by_place, block);
                }
            }
            ForceKind::Custom(CustomForce(function)) => {
                let (position, velocity) = (fb.position(), fb.rates());
                let here = function(t, position, velocity);
                // Column l by forward differences of the coordinate and of the velocity l.
                for l in 0..3 {
                    let (mut q, mut v) = (position, velocity);
                    q[l] += CHANGE;
                    v[l] += CHANGE;
                    let (moved, faster) = (function(t, q, velocity), function(t, position, v));
                    for k in 0..3 {
                        let change =
                            by_place * (moved[k] - here[k]) + by_velocity * (faster[k] - here[k]);
                        block[3 + k][3 + l] += change / CHANGE;
                    }
                }
            }
        }
    }

    /// Return force and slopes of a spring between two points, or `None` if the points coincide, as the direction is then undefined.
    ///
    /// The force on b is F = -T n with T = f(x) + c n·v. The derivatives are ∂F/∂d = -(n (k n + c P v)ᵀ + T P) and ∂F/∂v = -c n nᵀ,
    /// with P = (1 - n nᵀ)/|d|.
    fn pull_slopes(&self, law: &SpringLaw, pair: &Pair) -> Option<PairForce> {
        let length = pair.d.norm();
        if length <= 0.0 {
            return None;
        }
        let n = pair.d / length;
        let (x, rate) = (length - self.rest, pair.rate());
        let tension = law.elastic(x) + law.damping * n.dot(&rate);
        let across = (Matrix2::identity() - n * n.transpose()) / length;
        let along = law.stiffness(x) * n + law.damping * (across * rate);
        Some(PairForce {
            force: -tension * n,
            by_place: -(n * along.transpose() + tension * across),
            by_velocity: -law.damping * (n * n.transpose()),
        })
    }
}

/// Add the slope of the torque on b with respect to the angle or angular velocity of b relative to a.
pub(crate) fn add_twist(slope: f64, block: &mut CoordinateBlock) {
    for (k, sign) in [(2, -1.0), (5, 1.0)] {
        block[k][5] += sign * slope;
        block[k][2] -= sign * slope;
    }
}
