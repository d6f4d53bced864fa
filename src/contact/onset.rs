//! When a pair came into contact within the last step, and how fast: the root of the dense output.

use super::Contact;
use super::clearance_joint::pin_in_bushing;
use super::tooth_contact::{OnGap, SprocketFrame, bushing_on_sprocket};
use crate::geometry::Vec2;
use crate::integrator::Adams;
use crate::model::Model;
use crate::state::sprocket_motion;

/// Time in (`start`, `end`] at which the penetration turned positive, and its rate there.
///
/// `contact` is the pair along the last step, `None` when it is not even near; it is apart at `start` and deep at `end`.
/// Newton on the penetration, kept inside the shrinking bracket by bisection.
pub fn first_crossing(
    contact: impl Fn(f64) -> Option<Contact>,
    start: f64,
    end: f64,
) -> (f64, f64) {
    let depth = |t| {
        contact(t).map_or((f64::NEG_INFINITY, 0.0), |c| {
            (c.penetration, c.penetration_rate)
        })
    };
    let (at_start, rate_at_start) = depth(start);
    if at_start >= 0.0 {
        // The dense output meets the start of a step to within the tolerance only.
        return (start, rate_at_start);
    }
    let (mut low, mut high, mut t) = (start, end, end);
    let mut rate = 0.0;
    for _ in 0..100 {
        let (value, slope) = depth(t);
        rate = slope;
        if value > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let newton = t - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let settled = (next - t).abs() <= f64::EPSILON * t.abs() || next <= low || next >= high;
        if settled || value == 0.0 {
            break;
        }
        t = next;
    }
    (t, rate)
}

/// Hinge `k` at time `t` inside the last step of `adams`.
#[must_use]
pub fn hinge_at(model: &Model, adams: &Adams, k: usize, t: f64) -> Contact {
    let value = component_reader(model, adams, t);
    let next = (k + 1) % model.links;
    let (front, front_velocity) = link_end(model, &value, k, 1.0);
    let (rear, rear_velocity) = link_end(model, &value, next, -1.0);
    pin_in_bushing(
        front - rear,
        front_velocity - rear_velocity,
        model.clearance,
    )
}

/// Bushing `k` on sprocket `s` at time `t` inside the last step of `adams`; `None` when out of reach.
#[must_use]
pub fn tooth_at(model: &Model, adams: &Adams, k: usize, s: usize, t: f64) -> Option<OnGap> {
    let value = component_reader(model, adams, t);
    let link = model.link_of_bushing(k);
    let side = if link == k { 1.0 } else { -1.0 };
    let (point, velocity) = link_end(model, &value, link, side);
    let sprocket = &model.sprockets[s];
    let ((center, speed), (angle, spin)) = sprocket_motion(sprocket, t, &value);
    let frame = SprocketFrame::new(center, speed, angle, spin);
    bushing_on_sprocket(sprocket, &frame, point, velocity, model.bushing_radius)
}

/// Reads (coordinate, velocity) of a generalized coordinate at one time.
fn component_reader<'a>(
    model: &Model,
    adams: &'a Adams,
    t: f64,
) -> impl Fn(usize) -> (f64, f64) + 'a {
    let dense = adams.dense(t);
    let coordinates = model.coordinates;
    move |i| (dense.value(i), dense.value(coordinates + i))
}

fn link_end(
    model: &Model,
    value: &impl Fn(usize) -> (f64, f64),
    link: usize,
    side: f64,
) -> (Vec2, Vec2) {
    let n = model.links;
    let ((x, vx), (y, vy), (angle, spin)) = (value(link), value(n + link), value(2 * n + link));
    let arm = side * model.half_pitch * crate::geometry::unit(angle);
    (
        Vec2::new(x, y) + arm,
        Vec2::new(vx, vy) + spin * crate::geometry::turned_left(arm),
    )
}
