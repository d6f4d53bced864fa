//! Contact points of a circle on an outline: all local minima of the distance, less the local maxima between them.
//!
//! Along an outline, the distance from the circle's centre has local minima and local maxima in turn. With the elastic energy
//! E(δ) of one point, the total is U = Σ E(minima) - Σ E(maxima), over the points nearer than the radius. In a re-entrant corner
//! both sides carry load. Where the circle slides over an edge or along a bent line, a minimum and a maximum merge and vanish at
//! the same δ. U and its gradient, the force, are therefore continuous. An arc of a radius below that of the circle is a rounded
//! re-entrant corner.

mod extrema;

use self::extrema::Extremum;
use crate::geometry::{Vec2, direction, turned_left};
use crate::multibody::description::outline_piece::Curvature;
use crate::multibody::description::outline_piece::Piece;

/// Angle of a turn to the right below which it is a rounding error and no re-entrant corner \[sine\].
const SMOOTH: f64 = 1e-6;

/// Distance of the contact points included in the first search, over the radius of the circle.
const NEAR: f64 = 2.0;

/// Quarter turns by which an arc may exceed a whole number of them without another part: rounding of its angle.
const QUARTER_ROUNDING: f64 = 1e-9;

/// A candidate contact point: a local minimum or maximum of the distance between a profile and the centre of a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactPoint {
    /// Distance of the circle's centre from the surface \[m\], negative inside the material.
    pub(crate) distance: f64,
    /// Unit vector out of the material, the gradient of the distance.
    pub(crate) outward: Vec2,
    /// Number of the piece.
    pub(crate) piece: usize,
    /// Number of the side, which is the part of the outline between two re-entrant corners.
    pub(crate) side: usize,
    /// Weight in force and energy; negative for a local maximum of the distance.
    pub(crate) weight: f64,
    /// Gradient of the weight \[1/m\].
    pub(crate) weight_gradient: Vec2,
    /// Rotation of the outward direction per displacement of the centre along the surface \[1/m\]: one over its distance from
    /// the centre of curvature, negative where that centre lies in front of the surface.
    pub(crate) bend: f64,
    /// Position relative to the surface and the ends of the profile.
    pub(crate) place: OutlinePlace,
}

impl ContactPoint {
    /// Return whether it is a local maximum of the distance, between two sides or pieces: its weight is negative, or minus zero.
    pub(crate) fn is_between(&self) -> bool {
        self.weight.is_sign_negative()
    }
}

/// Position of a contact point relative to the surface and the ends of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum OutlinePlace {
    /// The centre is in front of the surface.
    #[default]
    Front,
    /// The point is the end of an open outline, and the centre is in front of it.
    EndFront,
    /// The point is the end of an open outline, and the centre is behind it. The weight decreases to zero where the back begins.
    EndBack,
    /// The centre is in the material.
    Deep,
    /// The centre is behind the end of an open outline. The point carries load only if the centre came through the surface.
    DeepAtEnd,
}

/// A piece, or a part of an arc of at most a quarter turn, inside which the distance has at most one extremum.
#[derive(Debug, Clone, Copy)]
struct OutlinePart {
    piece: Piece,
    number: usize,
    side: usize,
    /// Unit tangents at both ends.
    tangents: [Vec2; 2],
    radius: f64,
}

/// An outline prepared for the evaluation of contacts.
#[derive(Debug, Clone)]
pub(crate) struct Outline {
    parts: Vec<OutlinePart>,
    closed: bool,
    sides: usize,
}

impl Outline {
    /// Return the outline prepared for contacts with a circle of `radius` \[m\].
    pub(crate) fn new(pieces: &[Piece], closed: bool, radius: f64) -> Self {
        let mut parts = Vec::new();
        for (number, piece) in pieces.iter().enumerate() {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most 5
            let count = (piece.span() / std::f64::consts::FRAC_PI_2 - QUARTER_ROUNDING)
                .ceil()
                .max(1.0) as usize;
            parts.extend(piece.split(count).into_iter().map(|part| OutlinePart {
                piece: part,
                number,
                side: 0,
                tangents: [part.tangent(part.from), part.tangent(part.to)],
                radius: part.radius(),
            }));
        }
        let mut outline = Self {
            parts,
            closed,
            sides: 1,
        };
        outline.number_sides(radius);
        outline
    }

    /// Return the number of sides between re-entrant corners.
    pub(crate) fn sides(&self) -> usize {
        self.sides
    }

    pub(crate) fn is_open(&self) -> bool {
        !self.closed
    }

    /// Number the sides. A side ends at a corner that turns to the right, or with an arc of a radius not above `radius`.
    fn number_sides(&mut self, radius: f64) {
        let count = self.parts.len();
        let tight = |part: &OutlinePart| is_tight(part.piece.curvature(), radius);
        let begins = |i: usize| {
            let (before, here) = (&self.parts[(i + count - 1) % count], &self.parts[i]);
            let corner = before.tangents[1].perp(&here.tangents[0]) < -SMOOTH;
            corner || tight(before) && !tight(here)
        };
        let mut starts: Vec<usize> = (usize::from(!self.closed)..count)
            .filter(|&i| begins(i))
            .collect();
        if self.closed && starts.len() == 1 {
            // With a single corner both of its sides would have the same number: a second start divides the outline.
            starts.push((starts[0] + count.div_ceil(2)) % count);
            starts.sort_unstable();
            starts.dedup();
        }
        let open = usize::from(!self.closed);
        self.sides = (starts.len() + open).max(1);
        for (i, part) in self.parts.iter_mut().enumerate() {
            let passed = starts.iter().filter(|&&start| start <= i).count();
            part.side = (passed + self.sides - 1 + open) % self.sides;
        }
    }

    /// Call `visit` with every candidate contact point of a circle of `radius` around `point`, at any distance.
    pub(crate) fn contact_points(
        &self,
        point: Vec2,
        radius: f64,
        visit: impl FnMut(&ContactPoint),
    ) {
        self.contact_points_within(f64::INFINITY, point, radius, visit);
    }

    /// Call `visit` with the contact points that are needed for forces. On a closed outline points farther than [`NEAR`] radii are
    /// left out if any point is nearer.
    pub(crate) fn contact_points_near(
        &self,
        point: Vec2,
        radius: f64,
        mut visit: impl FnMut(&ContactPoint),
    ) {
        let limit = if self.closed {
            NEAR * radius
        } else {
            f64::INFINITY
        };
        let mut none = true;
        self.contact_points_within(limit, point, radius, |candidate| {
            none = false;
            visit(candidate);
        });
        // A centre that is far from the whole outline may be deep in the material.
        if none && self.closed {
            self.contact_points(point, radius, visit);
        }
    }

    /// Call `visit` with the contact points not farther than `limit` \[m\], which must not be below `radius`.
    ///
    /// A local maximum with a force lies between local minima that are nearer still: the limit excludes none of them. The sign of the
    /// distance's derivative along the outline changes at an extremum: inside a part, or from one part to the next in a corner.
    fn contact_points_within(
        &self,
        limit: f64,
        point: Vec2,
        radius: f64,
        mut visit: impl FnMut(&ContactPoint),
    ) {
        let farthest = limit * limit;
        let mut found = Extremum::default();
        let last = self.parts.len() - 1;
        let mut descending = if self.closed {
            self.parts[last].descends(point)
        } else {
            true
        };
        for (i, part) in self.parts.iter().enumerate() {
            let at_start = point - part.piece.from;
            let starts = part.tangents[0].dot(&at_start) > 0.0;
            // Extremum in the common point of two parts, or at the first end of an open outline.
            if descending != starts {
                let before = match i {
                    0 if self.closed => Some(&self.parts[last]),
                    0 => None,
                    _ => Some(&self.parts[i - 1]),
                };
                if let Some(before) = before {
                    if at_start.norm_squared() <= farthest {
                        let corner = at_corner(before, part, at_start);
                        found.add(!starts, corner, radius, &mut visit);
                    }
                } else {
                    let away = -part.tangents[0];
                    found.at_end(part, at_start, away, turned_left(away), &mut visit);
                }
            }
            descending = part.descends(point);
            // Extremum inside the part.
            if starts != descending {
                let candidate = part.inside(point, starts);
                if candidate.distance.abs() <= limit {
                    found.add(starts, candidate, radius, &mut visit);
                }
            }
        }
        // The distance decreases up to the last end of an open outline.
        if !self.closed && descending {
            let part = &self.parts[last];
            let away = part.tangents[1];
            found.at_end(
                part,
                point - part.piece.to,
                away,
                -turned_left(away),
                &mut visit,
            );
        }
        found.finish(radius, &mut visit);
    }
}

/// Return whether a circle of `radius` does not fit into an arc.
pub(crate) fn is_tight(curvature: Curvature, radius: f64) -> bool {
    matches!(curvature, Curvature::Concave(own) if own <= radius)
}

impl OutlinePart {
    /// Return whether the distance decreases along the outline at the end of the part.
    fn descends(&self, point: Vec2) -> bool {
        self.tangents[1].dot(&(point - self.piece.to)) > 0.0
    }

    /// Return the local minimum (or maximum) of the distance inside the part.
    fn inside(&self, point: Vec2, least: bool) -> ContactPoint {
        let Some(center) = self.piece.center else {
            let outward = -turned_left(self.tangents[0]);
            return self.contact_point((point - self.piece.from).dot(&outward), outward, 0.0);
        };
        let arm = point - center;
        let length = arm.norm();
        let direction = direction(arm, length);
        match (least, self.piece.convex) {
            (true, true) => self.contact_point(length - self.radius, direction, 1.0 / length),
            (true, false) => self.contact_point(self.radius - length, -direction, -1.0 / length),
            (false, false) => self.contact_point(self.radius + length, direction, 1.0 / length),
            // The far side of a convex arc faces away from the circle: it has no force.
            (false, true) => self.contact_point(f64::INFINITY, direction, 0.0),
        }
    }

    fn contact_point(&self, distance: f64, outward: Vec2, bend: f64) -> ContactPoint {
        ContactPoint {
            distance,
            outward,
            piece: self.number,
            side: self.side,
            weight: 1.0,
            weight_gradient: Vec2::zeros(),
            bend,
            place: OutlinePlace::Front,
        }
    }
}

/// Return a corner as a local minimum or maximum of the distance; the distance is negative behind the corner.
fn at_corner(before: &OutlinePart, part: &OutlinePart, arm: Vec2) -> ContactPoint {
    let distance = arm.norm();
    let outward = -turned_left(before.tangents[1] + part.tangents[0]);
    let side = if arm.dot(&outward) >= 0.0 { 1.0 } else { -1.0 };
    part.contact_point(
        side * distance,
        side * direction(arm, distance),
        side / distance,
    )
}

#[cfg(test)]
mod tests;
