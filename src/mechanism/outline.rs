//! Where a circle bears on an outline: every place of least distance, less the places of greatest distance between them.
//!
//! Going along an outline, the distance from the circle's centre has places of least and of greatest value in turn. With an
//! elastic energy E(δ) of one place, that of all is U = Σ E at the least - Σ E at the greatest distances that are near. In a
//! corner between two sides both bear; where the circle slides over an edge or along a bent line, a least place and a greatest
//! one meet and vanish with the same δ, so that U and its slope, the force, go on without a jump. An arc that is tighter than
//! the circle is such a corner, rounded.

use super::piece::Piece;
use super::profile::Curvature;
use crate::geometry::{Vec2, turned_left};

/// Turns to the right below this are rounding, not corners \[sine\].
const SMOOTH: f64 = 1e-6;

/// A place where a circle may bear on a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bearing {
    /// Distance of the circle's centre from the surface \[m\], negative inside the material.
    pub(super) distance: f64,
    /// Unit vector out of the material, the slope of the distance.
    pub(super) outward: Vec2,
    /// Number of the piece.
    pub(super) piece: usize,
    /// Number of the side: what lies between two corners.
    pub(super) side: usize,
    /// Part that it has in force and energy; negative for a place of greatest distance.
    pub(super) weight: f64,
    /// Slope of the weight \[1/m\].
    pub(super) slope: Vec2,
    /// How the outward direction turns as the centre moves along the surface \[1/m\]: one over its distance from the centre
    /// of curvature, negative where that lies in front.
    pub(super) bend: f64,
    /// Where on the profile it is.
    pub(super) place: Place,
}

/// Where on a profile a place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Place {
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
pub(super) struct Outline {
    parts: Vec<Part>,
    closed: bool,
    sides: usize,
}

impl Outline {
    /// For a circle of `radius`.
    pub(super) fn new(pieces: &[Piece], closed: bool, radius: f64) -> Self {
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
    pub(super) fn sides(&self) -> usize {
        self.sides
    }

    pub(super) fn is_open(&self) -> bool {
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
    pub(super) fn bearings(&self, point: Vec2, radius: f64, mut visit: impl FnMut(&Bearing)) {
        let mut found = Found::default();
        let last = self.parts.len() - 1;
        let mut descending = if self.closed {
            let part = &self.parts[last];
            part.tangents[1].dot(&(point - part.piece.to)) > 0.0
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
                match before {
                    Some(before) => found.add(
                        !starts,
                        at_corner(before, part, at_start),
                        radius,
                        &mut visit,
                    ),
                    None => {
                        let away = -part.tangents[0];
                        found.at_end(part, at_start, away, turned_left(away), &mut visit);
                    }
                }
            }
            descending = part.tangents[1].dot(&(point - part.piece.to)) > 0.0;
            if starts != descending {
                found.add(starts, part.inside(point, starts), radius, &mut visit);
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
pub(super) fn is_tight(curvature: Curvature, radius: f64) -> bool {
    matches!(curvature, Curvature::Concave(own) if own <= radius)
}

impl Part {
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

/// The places seen so far on the way along an outline.
#[derive(Default)]
struct Found {
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
    fn add(
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
    fn at_end(
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

    fn finish(self, radius: f64, visit: &mut impl FnMut(&Bearing)) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn polyline(points: &[(f64, f64)], closed: bool) -> Vec<Piece> {
        let at = |k: usize| Vec2::new(points[k % points.len()].0, points[k % points.len()].1);
        let count = points.len() - usize::from(!closed);
        (0..count)
            .map(|k| Piece {
                from: at(k),
                to: at(k + 1),
                center: None,
                convex: true,
            })
            .collect()
    }

    /// Energy of all places, of a law δ^1.5 / 1.5, and the force.
    fn sum(outline: &Outline, point: Vec2, radius: f64) -> (f64, Vec2) {
        let (mut energy, mut force) = (0.0, Vec2::zeros());
        outline.bearings(point, radius, |b| {
            let depth = (radius - b.distance).max(0.0);
            // What is behind an open outline has not come through it here.
            let behind = outline.is_open() && b.place == Place::Deep;
            if b.place != Place::DeepAtEnd && !behind {
                let stored = depth.powf(2.5) / 2.5;
                energy += b.weight * stored;
                force += b.weight * depth.powf(1.5) * b.outward - stored * b.slope;
            }
        });
        (energy, force)
    }

    /// The largest change of the force along a way in small steps, and the largest difference from the slope of the energy.
    fn roughness(outline: &Outline, radius: f64, way: impl Fn(f64) -> Vec2) -> (f64, f64) {
        let (mut jump, mut wrong) = (0.0f64, 0.0f64);
        let mut before = sum(outline, way(0.0), radius).1;
        let steps = 20_000;
        for k in 1..=steps {
            let point = way(f64::from(k) / f64::from(steps));
            let (_, force) = sum(outline, point, radius);
            jump = jump.max((force - before).norm());
            before = force;
            if k % 100 == 0 {
                let h = 1e-6;
                let at = |x: f64, y: f64| sum(outline, point + Vec2::new(x, y), radius).0;
                let slope =
                    Vec2::new(at(h, 0.0) - at(-h, 0.0), at(0.0, h) - at(0.0, -h)) / (2.0 * h);
                wrong = wrong.max((slope + force).norm());
            }
        }
        (jump, wrong)
    }

    #[test]
    fn in_a_corner_both_sides_bear() {
        let outline = Outline::new(
            &polyline(
                &[(0.0, 2.0), (0.0, 0.0), (2.0, 0.0)].map(|(x, y)| (y, x)),
                false,
            ),
            false,
            0.5,
        );
        assert_eq!(outline.sides(), 2);
        let (mut sides, point) = (Vec::new(), Vec2::new(0.4, 0.3));
        outline.bearings(point, 0.5, |b| {
            if b.distance < 0.5 {
                sides.push((b.side, b.distance, b.weight));
            }
        });
        sides.sort_by_key(|s| s.0);
        assert_eq!(sides.len(), 2, "{sides:?}");
        let distances = [sides[0].1, sides[1].1];
        assert!((distances[0] - 0.3).abs() < 1e-15 && (distances[1] - 0.4).abs() < 1e-15);
    }

    #[test]
    fn along_edges_corners_bends_and_ends_the_force_does_not_jump_and_is_the_slope_of_the_energy() {
        let bent = [(2.0, 0.02), (0.0, 0.0), (-2.0, 0.03)];
        let tight = [
            Piece {
                from: Vec2::new(1.05, 1.0),
                to: Vec2::new(0.05, 0.0),
                center: None,
                convex: true,
            },
            Piece {
                from: Vec2::new(0.05, 0.0),
                to: Vec2::new(-0.05, 0.0),
                center: Some(Vec2::new(0.0, 0.05)),
                convex: false,
            },
            Piece {
                from: Vec2::new(-0.05, 0.0),
                to: Vec2::new(-1.05, 1.0),
                center: None,
                convex: true,
            },
        ];
        let along = |from: (f64, f64), to: (f64, f64)| {
            move |s: f64| Vec2::new(from.0 + s * (to.0 - from.0), from.1 + s * (to.1 - from.1))
        };
        let square = polyline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
        let notch = polyline(
            &[
                (-2.0, -1.0),
                (2.0, -1.0),
                (2.0, 1.0),
                (0.3, 0.0),
                (-0.3, 0.0),
                (-2.0, 1.0),
            ],
            true,
        );
        let radius = 0.25;
        let cases: [(&str, &[Piece], bool, Box<dyn Fn(f64) -> Vec2>); 6] = [
            (
                "bent floor",
                &polyline(&bent, false),
                false,
                Box::new(along((-1.0, 0.22), (1.0, 0.21))),
            ),
            (
                "tight arc",
                &tight,
                false,
                Box::new(along((-0.5, 0.6), (0.4, 0.42))),
            ),
            (
                "round a square",
                &square,
                true,
                Box::new(along((-1.4, 1.15), (1.3, 1.24))),
            ),
            (
                "an end",
                &polyline(&[(0.0, 0.0), (-2.0, 0.0)], false),
                false,
                Box::new(|s| {
                    let angle = 1.7 - 4.2 * s;
                    0.15 * Vec2::new(angle.cos(), angle.sin())
                }),
            ),
            (
                "an end of arcs",
                &tight,
                false,
                Box::new(|s| {
                    let angle = 2.2 - 3.2 * s;
                    Vec2::new(1.05, 1.0) + 0.2 * Vec2::new(angle.cos(), angle.sin())
                }),
            ),
            (
                "a notch",
                &notch,
                true,
                Box::new(along((-0.9, 0.5), (0.8, 0.3))),
            ),
        ];
        for (name, pieces, closed, way) in cases {
            let outline = Outline::new(pieces, closed, radius);
            let (jump, wrong) = roughness(&outline, radius, way);
            // Steps of 1e-4 of forces of 0.1 over lengths of 0.1.
            assert!(jump < 1e-3, "{name}: a jump of {jump}");
            assert!(wrong < 2e-5, "{name}: {wrong} beside the slope");
        }
    }

    #[test]
    fn a_tight_arc_bears_as_the_corner_that_it_rounds() {
        let corner = Outline::new(
            &polyline(&[(1.0, 1.0), (0.0, 0.0), (-1.0, 1.0)], false),
            false,
            0.3,
        );
        let r = 1e-7;
        let c = r * std::f64::consts::SQRT_2;
        let rounded = [
            (Vec2::new(1.0, 1.0), Vec2::new(0.5 * c, 0.5 * c), None),
            (
                Vec2::new(0.5 * c, 0.5 * c),
                Vec2::new(-0.5 * c, 0.5 * c),
                Some(Vec2::new(0.0, c)),
            ),
            (Vec2::new(-0.5 * c, 0.5 * c), Vec2::new(-1.0, 1.0), None),
        ]
        .map(|(from, to, center)| Piece {
            from,
            to,
            center,
            convex: false,
        });
        let rounded = Outline::new(&rounded, false, 0.3);
        assert_eq!((corner.sides(), rounded.sides()), (2, 2));
        for point in [(0.0, 0.35), (0.05, 0.3), (-0.1, 0.28), (0.01, 0.22)] {
            let point = Vec2::new(point.0, point.1);
            let (sharp, round) = (sum(&corner, point, 0.3).1, sum(&rounded, point, 0.3).1);
            assert!((sharp - round).norm() < 1e-6, "{point}: {sharp} {round}");
            assert!(sharp.y > 0.0);
        }
    }

    #[test]
    fn an_open_row_of_bends_has_a_side_for_each_and_a_convex_one_has_one() {
        let concave = [(2.0, 0.5), (1.0, 0.0), (-1.0, 0.0), (-2.0, 0.5)];
        assert_eq!(
            Outline::new(&polyline(&concave, false), false, 0.1).sides(),
            3
        );
        let convex = concave.map(|(x, y)| (x, -y));
        assert_eq!(
            Outline::new(&polyline(&convex, false), false, 0.1).sides(),
            1
        );
        let heart = [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0), (0.0, 0.5)];
        let outline = Outline::new(&polyline(&heart, true), true, 0.1);
        assert_eq!(outline.sides(), 2);
        assert_ne!(outline.parts[2].side, outline.parts[3].side);
    }
}
