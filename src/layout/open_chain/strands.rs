//! Strands of an open chain between a seat and an end, or between its ends: hanging or straight.

use super::{JUST, OpenChainLayout, OpenChainShape};
use crate::geometry::path::hanging::{Hanging, HangingLink, hang};
use crate::geometry::{Vec2, turned_left};
use crate::layout::laid_chain::LARGEST_STRETCH;

impl OpenChainLayout<'_> {
    /// Return the points from a seat to an end, and the direction of the chain at the seat of a hanging strand.
    pub(super) fn strand(
        &self,
        end: usize,
        seat: Vec2,
        links: std::ops::Range<usize>,
    ) -> Result<(Vec<Vec2>, Option<Vec2>), String> {
        let lengths = self.lengths(links);
        let Some(point) = self.ends[end].position() else {
            return Ok((
                straight(seat, self.line.down(end)?, &order(end, lengths)),
                None,
            ));
        };
        let points = self.between(seat, point, &order(end, lengths))?;
        let along = (points[1] - points[0]).normalize();
        Ok((points, Some(if end == 0 { -along } else { along })))
    }

    /// Return the lengths and weights of these links.
    pub(super) fn lengths(&self, links: std::ops::Range<usize>) -> Vec<HangingLink> {
        let chain = &self.drive.chain;
        let pitches = chain.link_pitches();
        let gravity = self.drive.gravity.norm();
        // Without gravity the chain is laid with a fictitious one.
        let heavy = if gravity > 0.0 { gravity } else { 1.0 };
        // Rollers are on the hinges. A link bears half of the one at each of its ends.
        let roller = chain.roller.as_ref().map_or(0.0, |roller| roller.mass);
        let rollers = f64::from(chain.strands) * roller;
        links
            .map(|i| HangingLink {
                length: pitches[i],
                weight: (chain.strand_link(i).mass + rollers) * heavy,
            })
            .collect()
    }

    /// Return the points of links that hang between two points; sideways without gravity.
    pub(super) fn between(
        &self,
        from: Vec2,
        to: Vec2,
        links: &[HangingLink],
    ) -> Result<Vec<Vec2>, String> {
        let apart = to - from;
        let down = self
            .line
            .gravity_direction()
            .unwrap_or_else(|| -turned_left(apart).try_normalize(0.0).unwrap_or(Vec2::x()));
        let length: f64 = links.iter().map(|link| link.length).sum();
        match hang(from, to, down, links) {
            Some(Hanging { mut points, .. }) => {
                // Equal except for rounding.
                points[links.len()] = to;
                Ok(points)
            }
            // Too short by rounding, or by the count of links.
            None if apart.norm() >= length && apart.norm() < length * (1.0 + JUST) => {
                Ok(straight(from, apart.normalize(), links))
            }
            // Too short by the open clearances: every link takes its share of the distance.
            None if apart.norm() >= length && apart.norm() < length + self.opening(links) => {
                let mut points = straight(from, apart / length, links);
                points[links.len()] = to;
                Ok(points)
            }
            None if apart.norm() >= length => Err(format!(
                "it is too short: {} links reach {:.6} m, and its ends are {:.6} m apart; {} links would do",
                links.len(),
                length,
                apart.norm(),
                (apart.norm() / self.drive.chain.mean_pitch()).ceil()
            )),
            None => Err(format!(
                "{} links of {:.4} m do not come to rest between points {:.6} m apart, {:.6} m of that sideways: they would hang \
                 folded; move the ends apart",
                links.len(),
                length,
                apart.norm(),
                apart.perp(&down).abs()
            )),
        }
    }

    /// Return the largest sum of clearances of these links at the start \[m\].
    pub(super) fn opening(&self, links: &[HangingLink]) -> f64 {
        LARGEST_STRETCH * self.drive.chain.hinge.clearance() * links.len() as f64
    }

    /// Lay a chain without sprockets.
    pub(super) fn lay_alone(&self) -> Result<OpenChainShape, String> {
        let links = self.drive.chain.links;
        let all = self.lengths(0..links as usize);
        let hinges = match [self.ends[0].position(), self.ends[1].position()] {
            [Some(from), Some(to)] => self.between(from, to, &all)?,
            [Some(from), None] => straight(from, self.line.down(1)?, &all),
            [None, Some(to)] => {
                let mut hinges = straight(to, self.line.down(0)?, &order(0, all));
                hinges.reverse();
                hinges
            }
            [None, None] => {
                return Err(
                    "its position is undefined: give one of its ends a position, or run it over a sprocket"
                        .to_string(),
                );
            }
        };
        Ok(OpenChainShape {
            seat_of: vec![None; hinges.len()],
            hinges,
            seated: Vec::new(),
            first_seat: Vec::new(),
            hinge_radius: Vec::new(),
            sense: Vec::new(),
            wraps: Vec::new(),
            strands: vec![links],
        })
    }
}

/// Return the links from a seat to an end; those of the first end in reverse order.
fn order(end: usize, mut links: Vec<HangingLink>) -> Vec<HangingLink> {
    if end == 0 {
        links.reverse();
    }
    links
}

fn straight(from: Vec2, along: Vec2, links: &[HangingLink]) -> Vec<Vec2> {
    let mut points = vec![from];
    let mut reach = 0.0;
    for link in links {
        reach += link.length;
        points.push(from + reach * along);
    }
    points
}
