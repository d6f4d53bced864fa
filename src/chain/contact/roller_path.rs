//! Relative kinematics of a bushing and its roller along the last step of the integrator.

use super::clearance_joint::pin_in_bushing;
use super::pair_path::{concatenated, turned};
use crate::chain::model::Model;
use crate::geometry::Contact;
use crate::geometry::{Vec2, turned_left, unit};
use crate::integrator::{Adams, DenseSums};

/// Relative kinematics of bushing `k` and its roller along a step.
#[derive(Debug)]
pub struct RollerPath<'a> {
    clearance: f64,
    /// Position of the bushing along the link, from the link's centre \[m\].
    arm: f64,
    /// Centre of the link relative to that of the roller \[m\], the link's angle \[rad\], an unused zero, and the rates of all four.
    path: DenseSums<'a, 8>,
    /// Direction of the link at the end of the step.
    direction: Vec2,
}

impl<'a> RollerPath<'a> {
    /// Create the path of bushing `k` of `model` along the last step of `adams`; `None` where rollers are no bodies of their own.
    #[must_use]
    pub fn new(model: &Model, adams: &'a Adams, k: usize) -> Option<Self> {
        let rollers = model.rollers.as_ref()?;
        let n = model.links;
        let link = model.link_of_bushing(k);
        let path = adams.dense_sums(|row| {
            let (q, v) = row.split_at(model.coordinates);
            let relative = |q: &[f64]| {
                let roller = &q[rollers.first..];
                let (x, y) = (q[link] - roller[k], q[n + link] - roller[n + k]);
                [x, y, q[2 * n + link], 0.0]
            };
            concatenated(relative(q), relative(v))
        });
        let [_, _, angle, ..] = path.end();
        Some(Self {
            clearance: rollers.clearance,
            arm: model.bushing_arm(k),
            path,
            direction: unit(angle),
        })
    }

    /// Return the contact at time `t` \[s\] inside the step.
    #[must_use]
    pub fn at(&self, t: f64) -> Contact {
        let [x, y, _, _, vx, vy, spin, _] = self.path.end();
        let [dx, dy, turn, _, dvx, dvy, spun, _] = self.path.change_at(t);
        let arm = self.arm * turned(self.direction, turn);
        pin_in_bushing(
            Vec2::new(x + dx, y + dy) + arm,
            Vec2::new(vx + dvx, vy + dvy) + (spin + spun) * turned_left(arm),
            self.clearance,
        )
    }
}
