//! Lubricant of all hinges, after their normal forces and friction.

use crate::chain::contact::HingeContacts;
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::force_law::HingeFilm;
use crate::geometry::{Vec2, turned_left};

/// Forces and moments of the film in all hinges; returns the power it dissipates \[W\].
pub(super) fn fill_hinges(
    film: &HingeFilm,
    model: &Model,
    motion: &Motion,
    hinges: &mut HingeContacts,
) -> f64 {
    let n = model.links;
    let mut dissipated = 0.0;
    for k in (0..n).filter(|&k| !model.hinge_is_open(k)) {
        let next = if k + 1 == n { 0 } else { k + 1 };
        let offset = Vec2::new(
            hinges.front_x[k] - hinges.rear_x[next],
            hinges.front_y[k] - hinges.rear_y[next],
        );
        let distance = offset.norm();
        // In the middle any direction will do.
        let along = if distance > 0.0 {
            offset / distance
        } else {
            Vec2::new(1.0, 0.0)
        };
        let across = turned_left(along);
        let velocity = Vec2::new(
            hinges.front_vx[k] - hinges.rear_vx[next],
            hinges.front_vy[k] - hinges.rear_vy[next],
        );
        let mean_spin = 0.5 * (motion.spin[k] + motion.spin[next]);
        let seen = [
            velocity.dot(&along),
            velocity.dot(&across) - mean_spin * distance,
        ];
        let filled = film.at(distance, seen);
        let [push, drag] = filled.force;
        let turning = motion.spin[next] - motion.spin[k];
        let shear = filled.shear * turning;
        let lever = 0.5 * distance * drag;
        hinges.film[k] = push * along + drag * across;
        let rubbed = if model.hinges_rub() {
            hinges.moments[k]
        } else {
            [0.0; 2]
        };
        hinges.moments[k] = [rubbed[0] + shear - lever, rubbed[1] - shear - lever];
        dissipated += shear * turning - (push * seen[0] + drag * seen[1]);
    }
    dissipated
}
