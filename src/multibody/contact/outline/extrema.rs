//! Local minima and maxima of the distance in their order along an outline, and the contact points among them.

use super::{Bearing, Part, Place, direction};
use crate::geometry::Vec2;

/// The extrema found so far along an outline.
#[derive(Default)]
pub(super) struct Found {
    first_least: Option<Bearing>,
    last_least: Option<Bearing>,
    /// The local maximum before the first local minimum of a closed outline.
    leading: Option<Bearing>,
    /// The local maximum after the last local minimum; the next local minimum is not yet found.
    pending: Option<Bearing>,
    /// The nearest local minimum with the circle's centre behind the surface.
    deep: Option<Bearing>,
    /// Smallest distance of the local minima with the circle's centre in front of the surface \[m\].
    nearest: Option<f64>,
}

impl Found {
    /// Add a local minimum (`least`) or maximum in the order along the outline, and call `visit` with the contact points it completes.
    pub(super) fn add(
        &mut self,
        least: bool,
        bearing: Bearing,
        radius: f64,
        visit: &mut impl FnMut(&Bearing),
    ) {
        if !least {
            if self.last_least.is_some() {
                self.pending = Some(bearing);
            } else {
                self.leading = Some(bearing);
            }
            return;
        }
        if let (Some(greatest), Some(before)) = (self.pending.take(), self.last_least) {
            between(&before, &greatest, &bearing, radius, visit);
        }
        self.last_least = Some(bearing);
        self.first_least.get_or_insert(bearing);
        // Each minimum in front of the surface is a contact point. Of those behind the surface only the nearest is kept.
        if bearing.distance >= 0.0 {
            self.nearest = Some(
                self.nearest
                    .map_or(bearing.distance, |n| n.min(bearing.distance)),
            );
            visit(&bearing);
        } else if self
            .deep
            .is_none_or(|deep| deep.distance < bearing.distance)
        {
            self.deep = Some(bearing);
        }
    }

    /// Add the end of an open outline. `away` is the direction of the outline out of its end, `front` its outward normal.
    ///
    /// From behind, the weight is w = cos²φ, φ being the angle of the centre from `away`: with a = arm · away, w = a²/|arm|² and
    /// ∇w = 2 a/|arm|² (away - a/|arm|² arm). The point below the surface past the end has the weight 1 - w.
    pub(super) fn at_end(
        &mut self,
        part: &Part,
        arm: Vec2,
        away: Vec2,
        front: Vec2,
        visit: &mut impl FnMut(&Bearing),
    ) {
        let distance = arm.norm();
        let mut bearing = part.bearing(distance, direction(arm, distance), 1.0 / distance);
        let height = arm.dot(&front);
        bearing.place = Place::EndFront;
        if height < 0.0 {
            let (along, square) = (arm.dot(&away).max(0.0), distance * distance);
            bearing.place = Place::EndBack;
            bearing.weight = along * along / square;
            bearing.slope = (away - along / square * arm) * (2.0 * along / square);
            visit(&Bearing {
                distance: height,
                outward: front,
                weight: 1.0 - bearing.weight,
                slope: -bearing.slope,
                bend: 0.0,
                place: Place::DeepAtEnd,
                ..bearing
            });
        }
        if let (Some(greatest), Some(before)) = (self.pending.take(), self.last_least) {
            between(&before, &greatest, &bearing, f64::INFINITY, visit);
        }
        self.last_least = Some(bearing);
        self.first_least.get_or_insert(bearing);
        self.nearest = Some(self.nearest.map_or(distance, |n| n.min(distance)));
        visit(&bearing);
    }

    /// Call `visit` with the last maximum of a closed outline and with the minimum behind the surface, if the centre is in the material.
    pub(super) fn finish(self, radius: f64, visit: &mut impl FnMut(&Bearing)) {
        if let (Some(first), Some(last)) = (self.first_least, self.last_least)
            && let Some(greatest) = self.pending.or(self.leading)
        {
            between(&last, &greatest, &first, radius, visit);
        }
        // The centre is in the material if the nearest minimum is one behind the surface.
        if let Some(deep) = self.deep
            && self.nearest.is_none_or(|nearest| -deep.distance <= nearest)
        {
            visit(&Bearing {
                place: Place::Deep,
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
    before: &Bearing,
    greatest: &Bearing,
    after: &Bearing,
    radius: f64,
    visit: &mut impl FnMut(&Bearing),
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
    let (mut share, mut slope) = (0.5, Vec2::zeros());
    if sum > 0.0 {
        share = to_after / sum;
        let slopes = (
            greatest.outward - after.outward,
            greatest.outward - before.outward,
        );
        slope = (to_before * slopes.0 - to_after * slopes.1) / (sum * sum);
    }
    for (of, weight, slope) in [(before, share, slope), (after, 1.0 - share, -slope)] {
        visit(&Bearing {
            piece: of.piece,
            side: of.side,
            weight: -weight,
            slope: -slope,
            ..*greatest
        });
    }
}
