//! Relative kinematics of a hinge, or of a bushing and a sprocket, along the last step of the integrator.
//!
//! Only the coordinates of the two bodies are interpolated, with the dense output of the step.

use super::clearance_joint::pin_in_bushing;
use super::tooth_gap::{OnGap, SprocketFrame, bushing_near_gap};
use crate::chain::model::{Model, Rotation, SprocketModel, Support};
use crate::geometry::Contact;
use crate::geometry::{Vec2, turned_left, unit};
use crate::integrator::{Adams, DenseSums};

/// Largest rotation \[rad\] that [`turned`] evaluates by a series; its truncation error is then below 3e-19.
const SMALL_TURN: f64 = 0.0625;

/// Relative kinematics of hinge `k` along a step.
#[derive(Debug)]
pub struct HingePath<'a> {
    clearance: f64,
    /// Distances from the centres of both links to the hinge \[m\].
    arms: [f64; 2],
    /// Centre of link k relative to that of the next link \[m\], the angles of both links \[rad\], and the rates of all four.
    path: DenseSums<'a, 8>,
    /// Directions of both links at the end of the step.
    directions: [Vec2; 2],
}

impl<'a> HingePath<'a> {
    /// Create the path of hinge `k` of `model` along the last step of `adams`.
    #[must_use]
    pub fn new(model: &Model, adams: &'a Adams, k: usize) -> Self {
        let n = model.links;
        let next = if k + 1 == n { 0 } else { k + 1 };
        let path = adams.dense_sums(|row| {
            let (q, v) = row.split_at(model.coordinates);
            let relative = |q: &[f64]| {
                let (x, y) = (q[k] - q[next], q[n + k] - q[n + next]);
                [x, y, q[2 * n + k], q[2 * n + next]]
            };
            concatenated(relative(q), relative(v))
        });
        let [_, _, front, rear, ..] = path.end();
        Self {
            clearance: model.hinges.clearance,
            arms: [k, next].map(|i| model.chain.arms[i]),
            path,
            directions: [unit(front), unit(rear)],
        }
    }

    /// Return the contact at time `t` \[s\] inside the step.
    #[must_use]
    pub fn at(&self, t: f64) -> Contact {
        let [x, y, .., vx, vy, front_spin, rear_spin] = self.path.end();
        let [dx, dy, front, rear, dvx, dvy, front_spun, rear_spun] = self.path.change_at(t);
        let front = self.arms[0] * turned(self.directions[0], front);
        let rear = self.arms[1] * turned(self.directions[1], rear);
        let turning = (front_spin + front_spun) * front + (rear_spin + rear_spun) * rear;
        // Offset e of the front end of link k from the rear end of the next link, as in the kernels (chain/rhs/chain/hinges.rs):
        // e = x_k - x_next + a_k t_k + a_next t_next; de/dt has ω × a for both arms.
        pin_in_bushing(
            Vec2::new(x + dx, y + dy) + front + rear,
            Vec2::new(vx + dvx, vy + dvy) + turned_left(turning),
            self.clearance,
        )
    }
}

/// Relative kinematics of bushing `k` and sprocket `s` along a step.
#[derive(Debug)]
pub struct ToothPath<'a> {
    sprocket: &'a SprocketModel,
    bushing_radius: f64,
    /// Position of the bushing along the link, from the link's centre \[m\].
    arm: f64,
    /// Centre of the link relative to the sprocket's displacement \[m\], angles of link and sprocket \[rad\], and the rates of all four.
    ///
    /// A prescribed angle is zero here and is evaluated from its signal instead.
    path: DenseSums<'a, 8>,
    /// Directions of link and sprocket at the end of the step.
    directions: [Vec2; 2],
    /// Angle of the sprocket at the end of the step \[rad\].
    angle: f64,
    /// Tooth gap of the bushing at the end of the step.
    gap: u32,
    /// Origin of a tensioner's coordinate on the tangent of its guide path at the end of the step \[m\].
    origin: Vec2,
}

impl<'a> ToothPath<'a> {
    /// Create the path of bushing `k` of `model` relative to sprocket `s` along the last step of `adams`.
    #[must_use]
    pub fn new(model: &'a Model, adams: &'a Adams, k: usize, s: usize) -> Self {
        let n = model.links;
        // The contact circle of a roller is centred on the body: the arm is zero and the angle has no effect.
        let ([x_of, y_of, angle_of], arm) = if let Some(rollers) = &model.rollers {
            ([0, 1, 2].map(|i| rollers.first + i * n + k), 0.0)
        } else {
            let link = model.link_of_bushing(k);
            ([link, n + link, 2 * n + link], model.bushing_arm(k))
        };
        let sprocket = &model.sprockets[s];
        // The rotation of a tensioner arm within a step is negligible: its centre moves along the tangent at the end of the step.
        let (tangent, origin) = tangent_way(sprocket, adams.y());
        let path = adams.dense_sums(|row| {
            let (q, v) = row.split_at(model.coordinates);
            let relative = |q: &[f64]| {
                let center = match sprocket.support {
                    Support::Fixed => Vec2::zeros(),
                    Support::Slide { index, .. } => q[index] * tangent,
                    Support::Floating { x, y } => Vec2::new(q[x], q[y]),
                };
                let angle = match sprocket.rotation {
                    Rotation::Free { index, .. } => q[index],
                    Rotation::Prescribed(_) => 0.0,
                };
                let (x, y) = (q[x_of] - center.x, q[y_of] - center.y);
                [x, y, q[angle_of], angle]
            };
            concatenated(relative(q), relative(v))
        });
        let [_, _, link_angle, free_angle, ..] = path.end();
        let angle = prescribed(sprocket, adams.time()).map_or(free_angle, |[angle, _]| angle);
        let mut at = Self {
            sprocket,
            bushing_radius: model.teeth.contact_radius,
            arm,
            path,
            directions: [unit(link_angle), unit(angle)],
            angle,
            gap: 0,
            origin,
        };
        at.gap = at.at(adams.time()).gap;
        at
    }

    /// Return the contact at time `t` \[s\] inside the step, at any distance.
    ///
    /// A pair with a contact onset on its outermost surface is out of reach before the onset and has a surface there too.
    #[must_use]
    pub fn at(&self, t: f64) -> OnGap {
        let [x, y, .., vx, vy, link_spin, spin] = self.path.end();
        let [dx, dy, link_turn, turn, dvx, dvy, link_spun, spun] = self.path.change_at(t);
        let [turn, spin] = prescribed(self.sprocket, t)
            .map_or([turn, spin + spun], |[angle, spin]| {
                [angle - self.angle, spin]
            });
        // The coordinates of a floating centre are absolute. Those of other supports are zero or relative to this point.
        let center = match self.sprocket.support {
            Support::Fixed => self.sprocket.center,
            Support::Slide { .. } => self.origin,
            Support::Floating { .. } => Vec2::zeros(),
        };
        let arm = self.arm * turned(self.directions[0], link_turn);
        let direction = turned(self.directions[1], turn);
        let frame = SprocketFrame {
            center,
            velocity: Vec2::zeros(),
            spin,
            cos: direction.x,
            sin: direction.y,
        };
        let point = Vec2::new(x + dx, y + dy) + arm;
        let velocity = Vec2::new(vx + dvx, vy + dvy) + (link_spin + link_spun) * turned_left(arm);
        bushing_near_gap(
            self.sprocket,
            &frame,
            point,
            velocity,
            self.bushing_radius,
            self.gap,
        )
    }
}

/// Return the tangent of a tensioner's guide path in the state `y`, and the origin of its coordinate on that tangent \[m\].
fn tangent_way(sprocket: &SprocketModel, y: &[f64]) -> (Vec2, Vec2) {
    let Support::Slide {
        index,
        direction,
        guide,
        ..
    } = sprocket.support
    else {
        return (Vec2::zeros(), sprocket.center);
    };
    if guide.curvature == 0.0 {
        return (direction, sprocket.center);
    }
    let tangent = guide.tangent(direction, y[index]);
    let here = sprocket.center + guide.offset(direction, y[index]);
    (tangent, here - y[index] * tangent)
}

/// Return angle \[rad\] and angular speed \[rad/s\] of a sprocket with prescribed speed.
fn prescribed(sprocket: &SprocketModel, t: f64) -> Option<[f64; 2]> {
    match &sprocket.rotation {
        Rotation::Prescribed(speed) => Some([sprocket.phase + speed.integral(t), speed.value(t)]),
        Rotation::Free { .. } => None,
    }
}

/// Return the elements of both arrays in one array.
pub(super) fn concatenated([a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]) -> [f64; 8] {
    [a, b, c, d, e, f, g, h]
}

/// Return `direction` rotated by `angle` \[rad\], to round-off.
pub(super) fn turned(direction: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = if angle.abs() < SMALL_TURN {
        let z = angle * angle;
        // Taylor series up to angle⁹ and angle⁸: the first terms left out are angle¹¹/11! < 2e-21 and angle¹⁰/10! < 3e-19.
        let sin = 1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0)));
        let cos = 1.0 - 0.5 * z * (1.0 - z / 12.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0)));
        (angle * sin, cos)
    } else {
        angle.sin_cos()
    };
    cos * direction + sin * turned_left(direction)
}
