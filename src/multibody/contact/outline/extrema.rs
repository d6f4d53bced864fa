//! Local minima and maxima of the distance in their order along an outline, and the contact points among them.

use super::{ContactPoint, OutlinePart, OutlinePlace};
use crate::geometry::{Vec2, direction};

/// The extrema found so far along an outline.
#[derive(Default)]
pub(super) struct Extremum {
    first_least: Option<ContactPoint>,
    last_least: Option<ContactPoint>,
    /// The local maximum before the first local minimum of a closed outline.
    leading: Option<ContactPoint>,
    /// The local maximum after the last local minimum; the next local minimum is not yet found.
    pending: Option<ContactPoint>,
    /// The nearest local minimum with the circle's centre behind the surface.
    deep: Option<ContactPoint>,
    /// Smallest distance of the local minima with the circle's centre in front of the surface \[m\].
    nearest: Option<f64>,
}

impl Extremum {
    /// Add a local minimum (`least`) or maximum in the order along the outline, and call `visit` with the contact points it completes.
    pub(super) fn add(
        &mut self,
        least: bool,
        candidate: ContactPoint,
        radius: f64,
        visit: &mut impl FnMut(&ContactPoint),
    ) {
        if !least {
            if self.last_least.is_some() {
                self.pending = Some(candidate);
            } else {
                self.leading = Some(candidate);
            }
            return;
        }
        if let (Some(greatest), Some(before)) = (self.pending.take(), self.last_least) {
            between(&before, &greatest, &candidate, radius, visit);
        }
        self.last_least = Some(candidate);
        self.first_least.get_or_insert(candidate);
        // Each minimum in front of the surface is a contact point. Of those behind the surface only the nearest is kept.
        if candidate.distance >= 0.0 {
            self.nearest = Some(
                self.nearest
                    .map_or(candidate.distance, |n| n.min(candidate.distance)),
            );
            visit(&candidate);
        } else if self
            .deep
            .is_none_or(|deep| deep.distance < candidate.distance)
        {
            self.deep = Some(candidate);
        }
    }

    /// Add the end of an open outline. `away` is the direction of the outline out of its end, `front` its outward normal.
    ///
    /// From behind, the weight is w = cos²φ, φ being the angle of the centre from `away`: with a = arm · away, w = a²/|arm|² and
    /// ∇w = 2 a/|arm|² (away - a/|arm|² arm). The point below the surface past the end has the weight 1 - w.
    pub(super) fn at_end(
        &mut self,
        part: &OutlinePart,
        arm: Vec2,
        away: Vec2,
        front: Vec2,
        visit: &mut impl FnMut(&ContactPoint),
    ) {
        let distance = arm.norm();
        let mut candidate = part.contact_point(distance, direction(arm, distance), 1.0 / distance);
        let height = arm.dot(&front);
        candidate.place = OutlinePlace::EndFront;
        if height < 0.0 {
            let (along, square) = (arm.dot(&away).max(0.0), distance * distance);
            candidate.place = OutlinePlace::EndBack;
            candidate.weight = along * along / square;
            candidate.weight_gradient = (away - along / square * arm) * (2.0 * along / square);
            visit(&ContactPoint {
                distance: height,
                outward: front,
                weight: 1.0 - candidate.weight,
                weight_gradient: -candidate.weight_gradient,
                bend: 0.0,
                place: OutlinePlace::DeepAtEnd,
                ..candidate
            });
        }
        if let (Some(greatest), Some(before)) = (self.pending.take(), self.last_least) {
            between(&before, &greatest, &candidate, f64::INFINITY, visit);
        }
        self.last_least = Some(candidate);
        self.first_least.get_or_insert(candidate);
        self.nearest = Some(self.nearest.map_or(distance, |n| n.min(distance)));
        visit(&candidate);
    }

    /// Call `visit` with the last maximum of a closed outline and with the minimum behind the surface, if the centre is in the material.
    pub(super) fn finish(self, radius: f64, visit: &mut impl FnMut(&ContactPoint)) {
        if let (Some(first), Some(last)) = (self.first_least, self.last_least)
            && let Some(greatest) = self.pending.or(self.leading)
        {
            between(&last, &greatest, &first, radius, visit);
        }
        // The centre is in the material if the nearest minimum is one behind the surface.
        if let Some(deep) = self.deep
            && self.nearest.is_none_or(|nearest| -deep.distance <= nearest)
        {
            visit(&ContactPoint {
                place: OutlinePlace::Deep,
                ..deep
            });
        }
    }
}

/// Call `visit` with the local maximum between two local minima, once with the piece and side of each.
///
/// Let d₁ and d₂ be the differences between the maximum and the minima before and after it. The weights are -d₂/(d₁ + d₂) for the
/// piece before and -d₁/(d₁ + d₂) for the piece after: a minimum that merges with the maximum cancels it.
fn between(
    before: &ContactPoint,
    greatest: &ContactPoint,
    after: &ContactPoint,
    radius: f64,
    visit: &mut impl FnMut(&ContactPoint),
) {
    // A maximum farther than the radius has no force.
    if !(0.0..radius).contains(&greatest.distance) {
        return;
    }
    let (to_after, to_before) = (
        (greatest.distance - after.distance).max(0.0),
        (greatest.distance - before.distance).max(0.0),
    );
    let sum = to_after + to_before;
    let (mut share, mut gradient) = (0.5, Vec2::zeros());
    if sum > 0.0 {
        share = to_after / sum;
        let slopes = (
            greatest.outward - after.outward,
            greatest.outward - before.outward,
        );
        gradient = (to_before * slopes.0 - to_after * slopes.1) / (sum * sum);
    }
    for (of, weight, gradient) in [(before, share, gradient), (after, 1.0 - share, -gradient)] {
        visit(&ContactPoint {
            piece: of.piece,
            side: of.side,
            weight: -weight,
            weight_gradient: -gradient,
            ..*greatest
        });
    }
}
