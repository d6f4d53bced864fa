//! Accelerations of all bodies from the forces of one evaluation: links, rollers, sprockets, and prescribed ends of an open chain.

use super::Kernels;
use super::link_accelerations::{AccelerateLinks, AccelerateRollers};
use crate::chain::arrays::layout::FIRST;
use crate::chain::loads::sprocket_acceleration;
use crate::chain::model::{Model, OpenEnds, Rotation, Support};
use crate::geometry::Vec2;

impl Kernels {
    /// Write the accelerations of the links.
    pub(super) fn accelerate_links(&mut self, model: &Model, accelerations: &mut [f64]) {
        let n = model.links;
        let (x, rest) = accelerations.split_at_mut(n);
        let (y, rest) = rest.split_at_mut(n);
        let of_bodies = [x, y, &mut rest[..n]];
        macro_rules! accelerate {
            ($friction:literal) => {
                self.instructions.run(AccelerateLinks::<$friction> {
                    constants: &self.links,
                    arrays: &mut self.chain,
                    overhang: self.candidates.overhang,
                    gravity: model.gravity.into(),
                    accelerations: of_bodies,
                })
            };
        }
        if model.has_moments() {
            accelerate!(true);
        } else {
            accelerate!(false);
        }
    }

    /// Write the accelerations of the rollers.
    pub(super) fn accelerate_rollers(&mut self, model: &Model, accelerations: &mut [f64]) {
        let (Some(rollers), Some(of)) = (&mut self.rollers, &model.rollers) else {
            return;
        };
        let n = model.links;
        let (x, rest) = accelerations[of.first..].split_at_mut(n);
        let (y, rest) = rest.split_at_mut(n);
        let of_bodies = [x, y, &mut rest[..n]];
        macro_rules! accelerate {
            ($friction:literal) => {
                self.instructions.run(AccelerateRollers::<$friction> {
                    arrays: &mut rollers.arrays,
                    overhang: self.candidates.overhang,
                    gravity: model.gravity.into(),
                    inverse_mass: 1.0 / of.mass,
                    inverse_inertia: 1.0 / of.inertia,
                    accelerations: of_bodies,
                })
            };
        }
        if model.has_friction() {
            accelerate!(true);
        } else {
            accelerate!(false);
        }
        // Missing rollers of an open chain stay at rest.
        for k in model.absent_rollers() {
            (accelerations[of.first + k], accelerations[of.first + n + k]) = (0.0, 0.0);
        }
    }

    /// Write the prescribed accelerations of the ends of an open chain.
    pub(super) fn move_ends(&self, ends: &OpenEnds, t: f64, accelerations: &mut [f64]) {
        let n = ends.links + 2;
        for end in &ends.bodies {
            if let Some(given) = end.given_acceleration(t, self.step_start) {
                let i = end.body;
                (
                    accelerations[i],
                    accelerations[n + i],
                    accelerations[2 * n + i],
                ) = (given.x, given.y, 0.0);
            }
        }
    }

    /// Return the force of the chain on both ends of an open chain at the last evaluation \[N\].
    pub(super) fn on_ends(&self, ends: &OpenEnds) -> [Vec2; 2] {
        ends.bodies.each_ref().map(|end| {
            let [front, rear] = [&self.chain.front_force, &self.chain.rear_force];
            let [x, y] = [0, 1].map(|axis| front[axis][end.body] + rear[axis][FIRST + end.body]);
            Vec2::new(x, y)
        })
    }

    /// Write the accelerations of the sprockets' own coordinates.
    pub(super) fn accelerate_sprockets(
        &self,
        model: &Model,
        pawls: &[f64],
        t: f64,
        accelerations: &mut [f64],
    ) {
        let moved = model.sprockets.iter().zip(&self.poses).zip(&self.loads);
        for (((sprocket, pose), load), &pawl) in moved.zip(pawls) {
            if sprocket.support == Support::Fixed
                && matches!(sprocket.rotation, Rotation::Prescribed(_))
            {
                continue;
            }
            let moves = pose.kinematics();
            let (center, angle) =
                sprocket_acceleration(sprocket, model.gravity, &moves, load, pawl, t);
            match sprocket.support {
                Support::Fixed => {}
                Support::Slide { index, .. } => {
                    let (_, tangent) = sprocket.slide_at(moves.center).unwrap_or_default();
                    accelerations[index] = center.dot(&tangent);
                }
                Support::Floating { x, y } => {
                    (accelerations[x], accelerations[y]) = (center.x, center.y);
                }
            }
            if let Rotation::Free { index, .. } = sprocket.rotation {
                accelerations[index] = angle;
            }
        }
    }
}
