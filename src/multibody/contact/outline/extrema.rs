//! The places of least and greatest distance in the order of the way along an outline, and what bears of them.

use super::{Bearing, Part, Place, direction};
use crate::geometry::Vec2;

/// The places seen so far on the way along an outline.
#[derive(Default)]
pub(super) struct Found {
    first_least: Option<Bearing>,
    last_least: Option<Bearing>,
    /// A greatest distance before the first least one, of a closed outline.
    leading: Option<Bearing>,
    /// A greatest distance whose next least one is still to come.
    pending: Option<Bearing>,
    /// The nearest place with the point behind it.
    deep: Option<Bearing>,
    /// Least distance of what the point is in front of.
    nearest: Option<f64>,
}

impl Found {
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

    /// The end of an open outline, which runs out of it along `away`, its outside along `front`. From behind, the part falls
    /// as the square of the cosine.
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

    pub(super) fn finish(self, radius: f64, visit: &mut impl FnMut(&Bearing)) {
        if let (Some(first), Some(last)) = (self.first_least, self.last_least)
            && let Some(greatest) = self.pending.or(self.leading)
        {
            between(&last, &greatest, &first, radius, visit);
        }
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

/// The greatest distance between two least ones: it takes part with the laws of both, more of the one that it is about to meet.
fn between(
    before: &Bearing,
    greatest: &Bearing,
    after: &Bearing,
    radius: f64,
    visit: &mut impl FnMut(&Bearing),
) {
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
