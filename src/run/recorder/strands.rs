//! Tensions of the strands between two sprockets, and between any number of them.

use crate::chain::dynamics::Dynamics;
use crate::geometry::Vec2;
use crate::geometry::path::belt::{Belt, Pulley, Span};

/// Mean pull along the chain of the hinges of each strand \[N\], in the order of the model's strands; zero for one without hinges.
///
/// A hinge is in a strand when it lies between that strand's tangent points and the strand leaves or meets the sprocket that the
/// chain touched last; of two such, the nearer one.
pub(super) fn tensions(dynamics: &Dynamics) -> Vec<f64> {
    let (model, motion, hinges) = (dynamics.model(), &dynamics.motion, &dynamics.hinges);
    let (n, strands) = (model.links, &model.strands);
    let pulley = |s: usize| Pulley {
        center: Vec2::new(motion.x[model.wheel_body(s)], motion.y[model.wheel_body(s)]),
        radius: model.sprockets[s].profile.pitch_radius,
        side: model.sprockets[s].side,
    };
    let pulleys: Vec<Pulley> = strands.iter().map(|[from, _]| pulley(*from)).collect();
    let (mut sums, mut counts) = (vec![0.0; strands.len()], vec![0.0; strands.len()]);
    let Ok(belt) = Belt::around(&pulleys) else {
        return sums;
    };
    let reaches: Vec<f64> = strands
        .iter()
        .map(|[from, _]| model.sprockets[*from].reach)
        .collect();
    let touched = |k: usize| {
        let bushing = hinges.bushing(k).0;
        (0..pulleys.len()).find(|&i| (bushing - pulleys[i].center).norm() < reaches[i])
    };
    // The last sprocket that the chain touches before its first hinge.
    let Some(mut last) = (0..n).rev().find_map(touched) else {
        return sums;
    };
    for k in 0..n {
        last = touched(k).unwrap_or(last);
        let bushing = hinges.bushing(k).0;
        let meeting = (last + strands.len() - 1) % strands.len();
        let near = [last, meeting]
            .into_iter()
            .filter_map(|i| beside(&belt.spans[i], bushing).map(|apart| (apart, i)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, strand)) = near else { continue };
        let next = (k + 1) % n;
        let along =
            Vec2::new(motion.x[next] - motion.x[k], motion.y[next] - motion.y[k]).normalize();
        sums[strand] += hinges.force_on_front(k).dot(&along);
        counts[strand] += 1.0;
    }
    for (sum, count) in sums.iter_mut().zip(counts) {
        *sum /= f64::max(count, 1.0);
    }
    sums
}

/// Distance from the line of a strand of a point that lies between its ends \[m\].
fn beside(span: &Span, point: Vec2) -> Option<f64> {
    let offset = point - span.from;
    let along = offset.dot(&span.direction);
    (0.0..=span.length)
        .contains(&along)
        .then(|| (offset - along * span.direction).norm())
}

/// Mean pull along the chain of the hinges between the two sprockets: upper strand (left of the line from the first to the
/// second centre), lower strand \[N\].
pub(super) fn two_strand_tensions(dynamics: &Dynamics) -> [f64; 2] {
    let (model, motion, hinges) = (dynamics.model(), &dynamics.motion, &dynamics.hinges);
    let n = model.links;
    let center = |s: usize| {
        let body = model.wheel_body(s);
        Vec2::new(motion.x[body], motion.y[body])
    };
    let line = center(1) - center(0);
    let distance = line.norm();
    let axis = line / distance;
    let [r1, r2] = [0, 1].map(|s| model.sprockets[s].profile.pitch_radius);
    // A common tangent leaves each pitch circle where its normal does.
    let cos = (r1 - r2) / distance;
    let between = (r1 * cos)..=(distance + r2 * cos);
    let (mut sums, mut counts) = ([0.0; 2], [0.0; 2]);
    for k in 0..n {
        let offset = hinges.bushing(k).0 - center(0);
        if !between.contains(&offset.dot(&axis)) {
            continue;
        }
        let next = (k + 1) % n;
        let along =
            Vec2::new(motion.x[next] - motion.x[k], motion.y[next] - motion.y[k]).normalize();
        let strand = usize::from(axis.x * offset.y - axis.y * offset.x < 0.0);
        sums[strand] += hinges.force_on_front(k).dot(&along);
        counts[strand] += 1.0;
    }
    [0, 1].map(|i| {
        if counts[i] > 0.0 {
            sums[i] / counts[i]
        } else {
            0.0
        }
    })
}
