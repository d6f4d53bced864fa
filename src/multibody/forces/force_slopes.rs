//! How force elements change with positions and velocities: exactly, but for callables, of which differences are taken.

use nalgebra::Matrix2;

use crate::geometry::{Vec2, turned_left};
use crate::multibody::constraints::relative_kinematics::{Block, Pair, PairForce};
use crate::multibody::description::body::Frame;
use crate::multibody::description::force_element::{CustomForce, Force, ForceKind};
use crate::multibody::description::spring_law::SpringLaw;

/// Change of a coordinate and of a velocity that differences of a callable are taken over.
const CHANGE: f64 = 1e-7;

impl Force {
    /// Adds ∂Q/∂v · `by_velocity` + ∂Q/∂q · `by_place` of its generalised forces Q on bodies a and b.
    pub(crate) fn add_slopes(
        &self,
        t: f64,
        frames: &[Frame],
        by_velocity: f64,
        by_place: f64,
        block: &mut Block,
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
                    let turning = turned_left(fb.turned(given));
                    block[3][5] += by_place * turning.x;
                    block[4][5] += by_place * turning.y;
                } else {
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
                let position = [fb.origin.x, fb.origin.y, fb.angle];
                let velocity = [fb.velocity.x, fb.velocity.y, fb.spin];
                let here = function(t, position, velocity);
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

    /// Without a direction between the points there is no force.
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

/// A slope of the torque on b by the angle or spin of b seen from a.
pub(crate) fn add_twist(slope: f64, block: &mut Block) {
    for (k, sign) in [(2, -1.0), (5, 1.0)] {
        block[k][5] += sign * slope;
        block[k][2] -= sign * slope;
    }
}
