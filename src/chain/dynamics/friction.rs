//! Friction of all contacts of one kind, after their normal forces, by a law: of a contact's number, normal force and slip.
//!
//! It acts along t, left of the normal n, at one point that both bodies have: the pin's outermost one in a hinge, the bushing's
//! on a tooth. The slip is the velocity along t of the one body's material point there seen from the other's.

use crate::chain::contact::{HingeContacts, RollerContacts, ToothContacts, on_teeth};
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::drive::bushing_on_front;
use crate::geometry::{Vec2, turned_left};

/// Friction of all hinges; returns the power it dissipates \[W\].
pub(super) fn rub_hinges(
    mut law: impl FnMut(usize, f64, f64) -> f64,
    model: &Model,
    motion: &Motion,
    hinges: &mut HingeContacts,
) -> f64 {
    let n = model.links;
    let mut dissipated = 0.0;
    for k in 0..n {
        if hinges.penetration[k] <= 0.0 {
            hinges.friction[k] = 0.0;
            hinges.moments[k] = [0.0; 2];
            continue;
        }
        let next = if k + 1 == n { 0 } else { k + 1 };
        let distance = hinges.penetration[k] + model.clearance;
        let from_front = if bushing_on_front(k, n) {
            -(model.pin_radius + distance)
        } else {
            model.pin_radius
        };
        let from_rear = from_front + distance;
        let across = turned_left(Vec2::new(hinges.direction_x[k], hinges.direction_y[k]));
        let velocity = Vec2::new(
            hinges.front_vx[k] - hinges.rear_vx[next],
            hinges.front_vy[k] - hinges.rear_vy[next],
        );
        let slip =
            across.dot(&velocity) + from_front * motion.spin[k] - from_rear * motion.spin[next];
        let friction = law(k, hinges.force[k], slip);
        hinges.friction[k] = friction;
        hinges.moments[k] = [-from_front * friction, from_rear * friction];
        dissipated += friction * slip;
    }
    dissipated
}

/// Friction of all bushings in their rollers; returns the power it dissipates \[W\].
pub(super) fn rub_rollers(
    mut law: impl FnMut(usize, f64, f64) -> f64,
    model: &Model,
    motion: &Motion,
    hinges: &HingeContacts,
    rollers: &mut RollerContacts,
) -> f64 {
    let Some(of) = &model.rollers else {
        return 0.0;
    };
    let mut dissipated = 0.0;
    for k in 0..model.links {
        if rollers.penetration[k] <= 0.0 {
            rollers.friction[k] = 0.0;
            rollers.moments[k] = [0.0; 2];
            continue;
        }
        // The contact is the bushing's outermost point.
        let from_bushing = of.bushing_radius;
        let from_roller = from_bushing + (rollers.penetration[k] + of.clearance);
        let across = turned_left(Vec2::new(rollers.direction_x[k], rollers.direction_y[k]));
        let (_, velocity) = hinges.bushing(k);
        let roller = model.links + k;
        let seen = velocity - Vec2::new(motion.vx[roller], motion.vy[roller]);
        let link = model.link_of_bushing(k);
        let slip = across.dot(&seen) + from_bushing * motion.spin[link]
            - from_roller * motion.spin[roller];
        let friction = law(k, rollers.force[k], slip);
        rollers.friction[k] = friction;
        rollers.moments[k] = [-from_bushing * friction, from_roller * friction];
        dissipated += friction * slip;
    }
    dissipated
}

/// Friction of all bushings near a sprocket; returns the power it dissipates \[W\].
pub(super) fn rub_teeth(
    mut law: impl FnMut(usize, f64, f64) -> f64,
    model: &Model,
    motion: &Motion,
    hinges: &HingeContacts,
    teeth: &mut ToothContacts,
) -> f64 {
    let n = model.links;
    let mut dissipated = 0.0;
    for &pair in &teeth.near {
        let pair = pair as usize;
        if teeth.penetration[pair] <= 0.0 {
            teeth.friction[pair] = 0.0;
            continue;
        }
        let (sprocket, k) = (model.wheel_body(pair / n), pair % n);
        let ((_, velocity), body) = on_teeth(model, motion, hinges, k);
        let arm = Vec2::new(teeth.arm_x[pair], teeth.arm_y[pair]);
        let center = Vec2::new(motion.vx[sprocket], motion.vy[sprocket]);
        let spin = motion.spin[sprocket];
        let seen = velocity - center - spin * turned_left(arm);
        let across = turned_left(Vec2::new(teeth.normal_x[pair], teeth.normal_y[pair]));
        let turning = motion.spin[body] - spin;
        let slip = across.dot(&seen) + model.contact_radius * turning;
        let friction = law(pair, teeth.force[pair], slip);
        teeth.friction[pair] = friction;
        dissipated += friction * slip;
    }
    dissipated
}
