//! Relative kinematics of a hinge, or of a bushing and a sprocket, along the last step of the integrator.
//!
//! Only the coordinates of the two bodies are interpolated, with the dense output of the step.

use super::clearance_joint::pin_in_bushing;
use super::tooth_gap::{OnGap, SprocketFrame, bushing_near_gap};
use crate::chain::model::{Model, Rotation, SprocketModel, Support};
use crate::geometry::{Contact, Vec2, turned_left, unit};
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

#[cfg(test)]
mod tests {
    use super::super::tests::{compiled, drive, inside, moved, with_rollers, with_tensioner};
    use super::super::{RollerPath, bushing_on_sprocket};
    use super::*;
    use crate::chain::motion::Motion;
    use crate::drive::{Bearing, Drive, SprocketMotion};
    use crate::math::Table;

    /// Return the model of a drive, an integrator behind a step of it, and times in that step with coordinates and velocities there.
    fn scene(drive: &Drive) -> (Model, Adams, Vec<(f64, Vec<f64>)>) {
        let (model, start) = compiled(drive);
        let mut y = vec![0.0; 2 * model.coordinates];
        let mut motion = Motion::new(model.bodies());
        motion.set(&start.positions, &start.velocities);
        motion.write(&model, &mut y);
        let (adams, [begin, end]) = moved(&y);
        let times = [0.0, 0.3, 0.8, 1.0].map(|part| begin + part * (end - begin));
        let states = times.map(|t| (t, inside(&adams, t, y.len())));
        (model, adams, states.to_vec())
    }

    /// Return position \[m\] and velocity \[m/s\] of the point `arm` along body `i` in a state, from the first coordinate of all bodies.
    fn point(model: &Model, y: &[f64], (first, i): (usize, usize), arm: f64) -> [Vec2; 2] {
        let n = model.links;
        let (q, v) = y.split_at(model.coordinates);
        let of = |of: &[f64]| [0, 1, 2].map(|c| of[first + c * n + i]);
        let ([x, y, angle], [vx, vy, spin]) = (of(q), of(v));
        let (sin, cos) = angle.sin_cos();
        [
            Vec2::new(x + arm * cos, y + arm * sin),
            Vec2::new(vx - arm * spin * sin, vy + arm * spin * cos),
        ]
    }

    /// Assert that a pin has the clearance and approach of two points.
    fn assert_in_bore(found: Contact, inner: [Vec2; 2], outer: [Vec2; 2], clearance: f64) {
        let [offset, velocity] = [0, 1].map(|i| inner[i] - outer[i]);
        // Rounding of coordinates below 1 m and of velocities below 10 m/s, divided by an offset of some tens of micrometres.
        let distance = offset.norm();
        assert!((found.penetration - (distance - clearance)).abs() < 1e-15);
        let direction = offset / distance;
        assert!((found.normal - direction).norm() < 4e-16 / distance);
        let rate = direction.dot(&velocity);
        assert!((found.penetration_rate - rate).abs() < 2e-14 + 1e-14 / distance);
    }

    #[test]
    fn a_hinge_inside_a_step_is_that_of_the_interpolated_links() {
        let (model, adams, states) = scene(&drive());
        for k in 0..model.links {
            let path = HingePath::new(&model, &adams, k);
            let next = (k + 1) % model.links;
            for (t, y) in &states {
                let pin = point(&model, y, (0, k), model.chain.arms[k]);
                let bore = point(&model, y, (0, next), -model.chain.arms[next]);
                assert_in_bore(path.at(*t), pin, bore, model.hinges.clearance);
            }
        }
    }

    #[test]
    fn a_roller_inside_a_step_is_that_of_the_interpolated_bodies() {
        let (model, adams, states) = scene(&with_rollers());
        let rollers = model.rollers.as_ref().unwrap();
        for k in 0..model.links {
            let path = RollerPath::new(&model, &adams, k).unwrap();
            // Bushings are at both ends of inner links, which are links 0, 2, ... or 1, 3, ...
            let link = model.link_of_bushing(k);
            assert!(link == k || link == (k + 1) % model.links);
            let arm = if link == k { 1.0 } else { -1.0 } * model.chain.arms[link];
            for (t, y) in &states {
                let bushing = point(&model, y, (0, link), arm);
                let roller = point(&model, y, (rollers.first, k), 0.0);
                assert_in_bore(path.at(*t), bushing, roller, rollers.clearance);
            }
        }
        let (model, adams, _) = scene(&drive());
        assert!(RollerPath::new(&model, &adams, 0).is_none());
    }

    /// Return the frame of a sprocket in the state `y`; a centre on a guide path moves along the tangent at the end of the step.
    fn sprocket_frame(sprocket: &SprocketModel, t: f64, y: &[f64], end: &[f64]) -> SprocketFrame {
        let (q, v) = y.split_at(y.len() / 2);
        let (center, velocity) = match sprocket.support {
            Support::Fixed => (sprocket.center, Vec2::zeros()),
            Support::Floating { x, y } => (Vec2::new(q[x], q[y]), Vec2::new(v[x], v[y])),
            Support::Slide {
                index,
                direction,
                guide,
                ..
            } => {
                let place = |s: f64| sprocket.center + guide.offset(direction, s);
                let (here, h) = (end[index], 1e-5);
                // The error of the difference is of the order h² over the square of the arm's length.
                let tangent = (place(here + h) - place(here - h)) / (2.0 * h);
                (
                    place(here) + (q[index] - here) * tangent,
                    v[index] * tangent,
                )
            }
        };
        let (angle, spin) = match &sprocket.rotation {
            Rotation::Free { index, .. } => (q[*index], v[*index]),
            Rotation::Prescribed(signal) => (sprocket.phase + signal.integral(t), signal.value(t)),
        };
        SprocketFrame::new(center, velocity, angle, spin)
    }

    /// Assert that all bushings near the sprockets of a drive have the contact of the interpolated bodies; return their number.
    fn assert_teeth(drive: &Drive, tolerance: f64) -> usize {
        let (model, adams, states) = scene(drive);
        let mut count = 0;
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            for k in 0..model.links {
                let path = ToothPath::new(&model, &adams, k, s);
                for (t, y) in &states {
                    let body = match &model.rollers {
                        Some(rollers) => (rollers.first, k),
                        None => (0, model.link_of_bushing(k)),
                    };
                    let arm = if model.rollers.is_some() {
                        0.0
                    } else {
                        model.bushing_arm(k)
                    };
                    let [place, velocity] = point(&model, y, body, arm);
                    let frame = sprocket_frame(sprocket, *t, y, adams.y());
                    let radius = model.teeth.contact_radius;
                    let Some(exact) =
                        bushing_on_sprocket(sprocket, &frame, place, velocity, radius)
                    else {
                        continue;
                    };
                    let found = path.at(*t);
                    assert_eq!((found.gap, found.surface), (exact.gap, exact.surface));
                    assert_eq!(found.region, exact.region);
                    let (found, exact) = (found.contact, exact.contact);
                    assert!((found.penetration - exact.penetration).abs() < tolerance);
                    assert!((found.normal - exact.normal).norm() < 1e3 * tolerance);
                    let rate = found.penetration_rate - exact.penetration_rate;
                    assert!(rate.abs() < 1e3 * tolerance, "{s} {k}: {rate}");
                    count += 1;
                }
            }
        }
        count
    }

    #[test]
    fn a_bushing_near_teeth_inside_a_step_is_that_of_the_interpolated_bodies() {
        let mut floating = drive();
        floating.sprockets[1].bearing = Bearing::Floating;
        let ramp = Table::new("speed", "rad/s", &[(0.0, 0.0), (1.0, 30.0)]).unwrap();
        floating.sprockets[0].motion = SprocketMotion::PrescribedSpeed(ramp.into());
        let arm = Some(Vec2::new(0.15, 0.05));
        for (drive, tolerance) in [
            (drive(), 1e-14),
            (with_rollers(), 1e-14),
            (floating, 1e-14),
            // The tangents have the errors of a difference.
            (with_tensioner(None), 1e-12),
            (with_tensioner(arm), 1e-10),
        ] {
            // Half a wrap of each sprocket, at four times.
            let count = assert_teeth(&drive, tolerance);
            assert!(count > 4 * 14, "{count}");
        }
    }

    #[test]
    fn a_direction_turns_by_the_sum_of_angles() {
        for angle in [-3.0, -0.0624, 1e-9, 0.03, 0.0624, 0.0626, 2.0] {
            for before in [0.0, 1.2, -2.5] {
                let found = turned(unit(before), angle);
                // Two roundings.
                assert!((found - unit(before + angle)).norm() < 5e-16, "{angle}");
            }
        }
        // Along the axis the sine itself is compared.
        let small = turned(Vec2::x(), 0.0624);
        assert!((small.y - 0.0624f64.sin()).abs() <= 1.4e-17);
        assert!((small.x - 0.0624f64.cos()).abs() <= 1.2e-16);
    }
}
