//! Recorded rows of an open chain: forces on its ends, their positions and velocities.

use crate::chain::dynamics::Dynamics;
use crate::chain::model::OpenEnds;
use crate::geometry::{Vec2, turned_left};
use crate::system::Row;

/// Return the body of each end, and its pin relative to its centre \[m\].
pub(super) fn arms(dynamics: &Dynamics, ends: &OpenEnds) -> [(usize, Vec2); 2] {
    let (model, motion) = (dynamics.model(), &dynamics.evaluated.motion);
    // The body of the first end is the front link of its hinge, the body of the last end the rear link.
    [(0, 1.0), (1, -1.0)].map(|(end, sign)| {
        let body = ends.bodies[end].body;
        let axis = Vec2::new(motion.cos[body], motion.sin[body]);
        (body, sign * model.chain.arms[body] * axis)
    })
}

/// Write the force of the chain on each end \[N\], and position \[m\] and velocity \[m/s\] of its pin.
pub(super) fn write(row: &mut Row, dynamics: &Dynamics, ends: &OpenEnds) {
    let (motion, hinges) = (&dynamics.evaluated.motion, &dynamics.evaluated.hinges);
    let [first, last] = [0, 1].map(|end| hinges.force_on_front(ends.bodies[end].hinge));
    row.vectors([first, -last].map(<[f64; 2]>::from));
    let arms = arms(dynamics, ends);
    row.vectors(arms.map(|(body, arm)| [motion.x[body] + arm.x, motion.y[body] + arm.y]));
    row.vectors(arms.map(|(body, arm)| {
        let turn = motion.spin[body] * turned_left(arm);
        [motion.vx[body] + turn.x, motion.vy[body] + turn.y]
    }));
}
