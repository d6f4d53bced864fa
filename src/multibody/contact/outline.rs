//! Where a circle bears on an outline: every place of least distance, less the places of greatest distance between them.
//!
//! Going along an outline, the distance from the circle's centre has places of least and of greatest value in turn. With an
//! elastic energy E(δ) of one place, that of all is U = Σ E at the least - Σ E at the greatest distances that are near. In a
//! corner between two sides both bear; where the circle slides over an edge or along a bent line, a least place and a greatest
//! one meet and vanish with the same δ, so that U and its slope, the force, go on without a jump. An arc that is tighter than
//! the circle is such a corner, rounded.

mod extrema;

use self::extrema::Found;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::outline_piece::Piece;
use crate::multibody::description::profile::Curvature;

/// Turns to the right below this are rounding, not corners \[sine\].
const SMOOTH: f64 = 1e-6;

/// Radii of the circle within which places are looked for first.
const NEAR: f64 = 2.0;

/// A place where a circle may bear on a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bearing {
    /// Distance of the circle's centre from the surface \[m\], negative inside the material.
    pub(crate) distance: f64,
    /// Unit vector out of the material, the slope of the distance.
    pub(crate) outward: Vec2,
    /// Number of the piece.
    pub(crate) piece: usize,
    /// Number of the side: what lies between two corners.
    pub(crate) side: usize,
    /// Part that it has in force and energy; negative for a place of greatest distance.
    pub(crate) weight: f64,
    /// Slope of the weight \[1/m\].
    pub(crate) slope: Vec2,
    /// How the outward direction turns as the centre moves along the surface \[1/m\]: one over its distance from the centre
    /// of curvature, negative where that lies in front.
    pub(crate) bend: f64,
    /// Where on the profile it is.
    pub(crate) place: Place,
}

/// Where on a profile a place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Place {
    /// In front of the surface.
    #[default]
    Front,
    /// Around the end of an open outline, in front of it.
    EndFront,
    /// Around the end of an open outline, from behind: the part fades to nothing where the back begins.
    EndBack,
    /// The centre is in the material.
    Deep,
    /// The centre came through the surface and slides out past the end, far below it.
    DeepAtEnd,
}

/// A piece, or a part of an arc of at most a quarter turn.
#[derive(Debug, Clone, Copy)]
struct Part {
    piece: Piece,
    number: usize,
    side: usize,
    /// Directions at its ends.
    tangents: [Vec2; 2],
    radius: f64,
}

/// An outline as a run needs it.
#[derive(Debug, Clone)]
pub(crate) struct Outline {
    parts: Vec<Part>,
    closed: bool,
    sides: usize,
}

impl Outline {
    /// For a circle of `radius`.
    pub(crate) fn new(pieces: &[Piece], closed: bool, radius: f64) -> Self {
        let mut parts = Vec::new();
        for (number, piece) in pieces.iter().enumerate() {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most 5
            let count = (piece.span() / std::f64::consts::FRAC_PI_2 - 1e-9)
                .ceil()
                .max(1.0) as usize;
            parts.extend(piece.split(count).into_iter().map(|part| Part {
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

    /// How many sides there are between corners.
    pub(crate) fn sides(&self) -> usize {
        self.sides
    }

    pub(crate) fn is_open(&self) -> bool {
        !self.closed
    }

    /// A side ends at a corner that turns to the right, or with an arc that a circle of `radius` does not fit into.
    fn number_sides(&mut self, radius: f64) {
        let count = self.parts.len();
        let tight = |part: &Part| is_tight(part.piece.curvature(), radius);
        let begins = |i: usize| {
            let (before, here) = (&self.parts[(i + count - 1) % count], &self.parts[i]);
            let corner = before.tangents[1].perp(&here.tangents[0]) < -SMOOTH;
            corner || tight(before) && !tight(here)
        };
        let mut starts: Vec<usize> = (usize::from(!self.closed)..count)
            .filter(|&i| begins(i))
            .collect();
        if self.closed && starts.len() == 1 {
            // Both sides of the only corner are to be told apart.
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

    /// Shows `visit` every place where a circle of `radius` around `point` may bear, and those farther off that face it.
    pub(crate) fn bearings(&self, point: Vec2, radius: f64, visit: impl FnMut(&Bearing)) {
        self.bearings_within(f64::INFINITY, point, radius, visit);
    }

    /// The same for forces: along a closed outline, places nearer than some radii alone, where there are any.
    pub(crate) fn bearings_near(&self, point: Vec2, radius: f64, mut visit: impl FnMut(&Bearing)) {
        let limit = if self.closed {
            NEAR * radius
        } else {
            f64::INFINITY
        };
        let mut none = true;
        self.bearings_within(limit, point, radius, |bearing| {
            none = false;
            visit(bearing);
        });
        // Far from all of it, the centre may be deep in the material.
        if none && self.closed {
            self.bearings(point, radius, visit);
        }
    }

    /// Places farther off than `limit`, which is not below `radius`, are left out: a greatest distance that bears lies between
    /// least ones that are nearer still.
    fn bearings_within(
        &self,
        limit: f64,
        point: Vec2,
        radius: f64,
        mut visit: impl FnMut(&Bearing),
    ) {
        let farthest = limit * limit;
        let mut found = Found::default();
        let last = self.parts.len() - 1;
        let mut descending = if self.closed {
            self.parts[last].descends(point)
        } else {
            true
        };
        for (i, part) in self.parts.iter().enumerate() {
            let at_start = point - part.piece.from;
            let starts = part.tangents[0].dot(&at_start) > 0.0;
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
            if starts != descending {
                let bearing = part.inside(point, starts);
                if bearing.distance.abs() <= limit {
                    found.add(starts, bearing, radius, &mut visit);
                }
            }
        }
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

/// Whether a circle of `radius` finds no place in an arc.
pub(crate) fn is_tight(curvature: Curvature, radius: f64) -> bool {
    matches!(curvature, Curvature::Concave(own) if own <= radius)
}

impl Part {
    /// Whether the distance still falls at its end.
    fn descends(&self, point: Vec2) -> bool {
        self.tangents[1].dot(&(point - self.piece.to)) > 0.0
    }

    /// The least (or greatest) distance inside the part.
    fn inside(&self, point: Vec2, least: bool) -> Bearing {
        let Some(center) = self.piece.center else {
            let outward = -turned_left(self.tangents[0]);
            return self.bearing((point - self.piece.from).dot(&outward), outward, 0.0);
        };
        let arm = point - center;
        let length = arm.norm();
        let direction = direction(arm, length);
        match (least, self.piece.convex) {
            (true, true) => self.bearing(length - self.radius, direction, 1.0 / length),
            (true, false) => self.bearing(self.radius - length, -direction, -1.0 / length),
            (false, false) => self.bearing(self.radius + length, direction, 1.0 / length),
            // The far side of a disc does not face the circle.
            (false, true) => self.bearing(f64::INFINITY, direction, 0.0),
        }
    }

    fn bearing(&self, distance: f64, outward: Vec2, bend: f64) -> Bearing {
        Bearing {
            distance,
            outward,
            piece: self.number,
            side: self.side,
            weight: 1.0,
            slope: Vec2::zeros(),
            bend,
            place: Place::Front,
        }
    }
}

fn direction(vector: Vec2, length: f64) -> Vec2 {
    if length > 0.0 {
        vector / length
    } else {
        Vec2::zeros()
    }
}

/// A corner as a place of least or greatest distance; behind it the distance is negative.
fn at_corner(before: &Part, part: &Part, arm: Vec2) -> Bearing {
    let distance = arm.norm();
    let outward = -turned_left(before.tangents[1] + part.tangents[0]);
    let side = if arm.dot(&outward) >= 0.0 { 1.0 } else { -1.0 };
    part.bearing(
        side * distance,
        side * direction(arm, distance),
        side / distance,
    )
}

#[cfg(test)]
mod tests;
