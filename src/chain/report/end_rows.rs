//! Recorded rows of an open chain: forces on its ends, their positions and velocities, and strand tensions.

use crate::chain::dynamics::Dynamics;
use crate::chain::model::OpenEnds;
use crate::geometry::{Vec2, turned_left};
use crate::system::Row;

/// Write the force of the chain on each end \[N\], and position \[m\] and velocity \[m/s\] of its pin.
pub(super) fn write(row: &mut Row, dynamics: &Dynamics, ends: &OpenEnds) {
    let (model, motion, hinges) = (
        dynamics.model(),
        &dynamics.evaluated.motion,
        &dynamics.evaluated.hinges,
    );
    // The body of the first end is the front link of its hinge, the body of the last end the rear link.
    let of = |end: usize| (&ends.bodies[end], if end == 0 { 1.0 } else { -1.0 });
    row.vectors([0, 1].map(|i| {
        let (end, sign) = of(i);
        <[f64; 2]>::from(sign * hinges.force_on_front(end.hinge))
    }));
    let arm = |i: usize| {
        let (end, sign) = of(i);
        let body = end.body;
        (
            body,
            sign * model.chain.arms[body] * Vec2::new(motion.cos[body], motion.sin[body]),
        )
    };
    row.vectors([0, 1].map(|i| {
        let (body, arm) = arm(i);
        [motion.x[body] + arm.x, motion.y[body] + arm.y]
    }));
    row.vectors([0, 1].map(|i| {
        let (body, arm) = arm(i);
        let turn = motion.spin[body] * turned_left(arm);
        [motion.vx[body] + turn.x, motion.vy[body] + turn.y]
    }));
}

/// Return the mean tension along the chain of the hinges of each strand \[N\], from the first end to the last.
///
/// A hinge within reach of a sprocket's teeth belongs to no strand; the following hinges belong to the next strand. The tension of a
/// strand without hinges is zero.
pub(super) fn tensions(dynamics: &Dynamics) -> Vec<f64> {
    let (model, motion, hinges) = (
        dynamics.model(),
        &dynamics.evaluated.motion,
        &dynamics.evaluated.hinges,
    );
    let Some(ends) = &model.ends else {
        return Vec::new();
    };
    let n = model.links;
    let count = model.strands.len();
    let (mut sums, mut counts) = (vec![0.0; count], vec![0.0; count]);
    let near = |k: usize, s: usize| {
        let wheel = model.wheel_body(s);
        let center = Vec2::new(motion.x[wheel], motion.y[wheel]);
        (hinges.bushing(k) - center).norm() < model.sprockets[s].reach
    };
    let mut strand = 0_usize;
    for k in std::iter::once(n - 1).chain(0..ends.links) {
        let here = strand.saturating_sub(1)..(strand + 1).min(model.toothed());
        if let Some(s) = here.rev().find(|&s| near(k, s)) {
            strand = s + 1;
            continue;
        }
        if model.hinge_is_open(k) {
            continue;
        }
        let link = if k + 1 == n { 0 } else { k };
        let along = Vec2::new(motion.cos[link], motion.sin[link]);
        sums[strand] += hinges.force_on_front(k).dot(&along);
        counts[strand] += 1.0;
    }
    for (sum, count) in sums.iter_mut().zip(counts) {
        *sum /= f64::max(count, 1.0);
    }
    sums
}
