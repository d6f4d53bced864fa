//! A custom tooth form of arcs and lines, and the errors of its pieces.

use serde::{Deserialize, Serialize};

use super::flank::{Flank, SurfaceCurve};
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{Arc, Segment, ToothProfile, Vec2, turned_left};

/// Largest permitted gap between two pieces \[m\]: coordinates with seven decimals.
const LARGEST_GAP: f64 = 1e-7;
/// Largest permitted angle between the tangents of two pieces \[rad\].
const LARGEST_ANGLE: f64 = 1e-4;

/// A piece of an outline. Frame: origin in the sprocket's centre, u across the tooth gap, v outward through its middle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OutlinePiece {
    /// First point \[m\].
    #[serde(with = "crate::geometry::components")]
    pub start: Vec2,
    /// Last point \[m\].
    #[serde(with = "crate::geometry::components")]
    pub end: Vec2,
    /// Centre of an arc of less than half a turn; `None`: a straight line.
    #[serde(with = "crate::geometry::components")]
    pub center: Option<Vec2>,
}

/// Error of a flank's pieces; pieces are numbered from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Misfit {
    /// No pieces.
    Nothing,
    /// A piece of zero length, or an arc whose ends have different distances from its centre \[m\].
    NoCurve(usize, f64, f64),
    /// Gap between a piece and the one before it \[m\].
    Apart(usize, f64),
    /// Angle between the tangents of a piece and the one before it \[rad\], counterclockwise positive.
    Corner(usize, f64),
    /// Distance of the first piece from the middle of the tooth gap \[m\].
    Beside(f64),
    /// Angle of the first piece at its mirror image \[rad\].
    Leans(f64),
    /// Distance of the last piece from the middle of an uncut tooth \[m\].
    Open(f64),
    /// Angle of the last piece at its mirror image \[rad\]: a pointed tooth.
    Point(f64),
    /// Radius at which the flanks meet \[m\], inside the outside circle.
    Pointed(f64),
}

/// Return a misfit of this `size` where it is larger than `limit`.
fn above(size: f64, limit: f64) -> Option<f64> {
    (size.abs() > limit).then_some(size)
}

impl OutlinePiece {
    fn curve(&self, number: usize) -> Result<SurfaceCurve, Misfit> {
        let chord = self.end - self.start;
        let length = chord.norm();
        let Some(center) = self.center else {
            if length <= LARGEST_GAP {
                return Err(Misfit::NoCurve(number, length, length));
            }
            let tangent = chord / length;
            return Ok(SurfaceCurve::Straight(Segment {
                start: self.start,
                tangent,
                normal: -turned_left(tangent),
                length,
            }));
        };
        let [first, last] = [self.start, self.end].map(|end| (end - center).norm());
        if length <= LARGEST_GAP || above(first - last, LARGEST_GAP).is_some() {
            return Err(Misfit::NoCurve(number, first, last));
        }
        let arc = Arc {
            center,
            radius: 0.5 * (first + last),
        };
        // The material is on the right: an arc about a centre on the left is concave.
        Ok(if chord.perp(&(center - self.start)) > 0.0 {
            SurfaceCurve::Concave(arc)
        } else {
            SurfaceCurve::Convex(arc)
        })
    }
}

impl ToothProfile {
    /// Return a tooth of `pieces`, from the middle of the gap along the right flank. They end in the middle of the tooth, or are cut at
    /// a circle: (its radius, radius of the edge) \[m\].
    ///
    /// # Errors
    /// The position and size of the first misfit.
    pub fn custom(
        pitch: f64,
        teeth: u32,
        pieces: &[OutlinePiece],
        tip: Option<(f64, f64)>,
    ) -> Result<Self, Misfit> {
        let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
            return Err(Misfit::Nothing);
        };
        // A seat with its centre in the middle of the gap is the origin of the frame, as in the other forms.
        let seat = first.center.filter(|center| center.x.abs() <= LARGEST_GAP);
        let pitch_radius = pitch_radius(pitch, teeth);
        let origin = Vec2::new(0.0, seat.map_or(pitch_radius, |center| center.y));
        let moved: Vec<OutlinePiece> = pieces
            .iter()
            .map(|piece| OutlinePiece {
                start: piece.start - origin,
                end: piece.end - origin,
                center: piece.center.map(|center| center - origin),
            })
            .collect();
        if let Some(beside) = above(first.start.x, LARGEST_GAP) {
            return Err(Misfit::Beside(beside));
        }
        let curve = moved[0].curve(1)?;
        let leaning = curve.tangent(moved[0].start).y.asin();
        if let Some(leaning) = above(leaning, LARGEST_ANGLE) {
            return Err(Misfit::Leans(leaning));
        }
        let mut flank = Flank::begin("piece", moved[0].start, curve);
        let mut before = curve;
        for (i, (end, piece)) in moved.iter().zip(&moved[1..]).enumerate() {
            let curve = piece.curve(i + 2)?;
            let apart = (piece.start - end.end).norm();
            if let Some(apart) = above(apart, LARGEST_GAP) {
                return Err(Misfit::Apart(i + 2, apart));
            }
            let (from, to) = (before.tangent(end.end), curve.tangent(piece.start));
            let turn = from.perp(&to).atan2(from.dot(&to));
            if let Some(turn) = above(turn, LARGEST_ANGLE) {
                return Err(Misfit::Corner(i + 2, turn));
            }
            flank = flank.then(piece.start, to.normalize(), "piece", curve);
            before = curve;
        }
        flank = flank.end(last.end - origin);
        let outermost = pieces
            .iter()
            .flat_map(|piece| [piece.start.norm(), piece.end.norm()])
            .fold(0.0, f64::max);
        let profile = Self::of(teeth, pitch, origin.y, outermost, flank);
        if let Some((outside, edge)) = tip {
            return profile.cut(outside, edge).map_err(Misfit::Pointed);
        }
        let axis = profile.axis();
        let open = axis.perp(&last.end);
        if let Some(open) = above(open, LARGEST_GAP) {
            return Err(Misfit::Open(open));
        }
        let tangent = before.tangent(last.end - origin);
        let point = tangent.dot(&axis).asin();
        if let Some(point) = above(point, LARGEST_ANGLE) {
            return Err(Misfit::Point(point));
        }
        Ok(profile)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::geometry::tooth::checks::{largest_corner, largest_gap};
    use crate::geometry::{Surface, unit};

    const PITCH: f64 = 0.0127;
    const TEETH: u32 = 17;
    /// Distance of the seat's centre beyond the pitch circle \[m\].
    const RAISED: f64 = 5e-5;

    fn arc(start: Vec2, end: Vec2, center: Vec2) -> OutlinePiece {
        OutlinePiece {
            start,
            end,
            center: Some(center),
        }
    }

    fn line(start: Vec2, end: Vec2) -> OutlinePiece {
        OutlinePiece {
            start,
            end,
            center: None,
        }
    }

    fn pitch_radius() -> f64 {
        0.5 * PITCH / (PI / f64::from(TEETH)).sin()
    }

    /// Unit vector from the sprocket's centre along the middle of the tooth.
    fn axis() -> Vec2 {
        unit(PI / 2.0 - PI / f64::from(TEETH))
    }

    /// A seat of 4 mm, 1 mm of a line tangent to it and an arc to the middle of the tooth, which it leaves `tilt` \[rad\] from a right angle.
    fn pieces(tilt: f64) -> [OutlinePiece; 3] {
        let seat = Vec2::new(0.0, pitch_radius() + RAISED);
        let normal = unit(-0.4);
        let bend = seat + 4e-3 * normal;
        let edge = bend + 1e-3 * turned_left(normal);
        // Both the edge's radius along the flank's normal and that along the tooth end on its middle.
        let top = unit(axis().y.atan2(axis().x) + tilt);
        let radius = -axis().perp(&edge) / axis().perp(&(normal + top));
        let center = edge + radius * normal;
        [
            arc(seat - 4e-3 * Vec2::y(), bend, seat),
            line(bend, edge),
            arc(edge, center + radius * top, center),
        ]
    }

    fn tooth(pieces: &[OutlinePiece]) -> Result<ToothProfile, Misfit> {
        ToothProfile::custom(PITCH, TEETH, pieces, None)
    }

    /// The pieces, all moved or turned about a point.
    fn each(pieces: [OutlinePiece; 3], change: impl Fn(Vec2) -> Vec2) -> [OutlinePiece; 3] {
        pieces.map(|piece| OutlinePiece {
            start: change(piece.start),
            end: change(piece.end),
            center: piece.center.map(&change),
        })
    }

    fn turned(point: Vec2, about: Vec2, angle: f64) -> Vec2 {
        let (sin, cos) = angle.sin_cos();
        let offset = point - about;
        about + cos * offset + sin * turned_left(offset)
    }

    /// Assert that a size is the expected one to 1e-4: coordinates of 4 cm are rounded to 7e-18 m, the least size is 5e-8 m.
    fn assert_close(size: f64, expected: f64) {
        assert!(
            (size - expected).abs() < 1e-4 * expected.abs(),
            "{size} {expected}"
        );
    }

    #[test]
    fn a_seat_a_line_and_an_edge_are_a_tooth_with_its_origin_in_the_seat() {
        let profile = tooth(&pieces(0.0)).unwrap();
        let surfaces = profile.surfaces();
        assert_eq!(surfaces.len(), 3);
        assert!(largest_gap(surfaces) < 1e-16 && largest_corner(surfaces) < 1e-12);
        assert!(matches!(surfaces[0].curve, SurfaceCurve::Concave(_)));
        assert!(matches!(surfaces[1].curve, SurfaceCurve::Straight(_)));
        assert!(matches!(surfaces[2].curve, SurfaceCurve::Convex(_)));
        assert_eq!(profile.seat_center_radius, pitch_radius() + RAISED);
        let tip = pieces(0.0)[2].end;
        assert_eq!(profile.outside_radius, tip.norm());
        // A roller of 3 mm, 0.1 mm deep in the middle of the line.
        let place = 0.5e-3 * turned_left(unit(-0.4)) + 1.1e-3 * unit(-0.4);
        let contact = profile.contact(place, 3e-3);
        assert_eq!(contact.surface, Surface(1));
        assert!((contact.penetration - 1e-4).abs() < 1e-16);
        assert!((contact.normal - unit(-0.4)).norm() < 1e-13);
    }

    #[test]
    fn a_gap_that_begins_with_a_line_has_its_origin_on_the_pitch_circle() {
        let middle = Vec2::new(0.0, pitch_radius() - 4e-3);
        let corner = middle + 2e-3 * Vec2::x();
        let radius = 1e-3;
        let seat = corner + radius * Vec2::y();
        let bend = seat + radius * unit(-0.4);
        // A line and an edge as in the other tooth, from the end of the smaller seat.
        let edge = bend + 1e-3 * turned_left(unit(-0.4));
        let rounding = -axis().perp(&edge) / axis().perp(&unit(-0.4));
        let center = edge + rounding * unit(-0.4);
        let profile = tooth(&[
            line(middle, corner),
            arc(corner, bend, seat),
            line(bend, edge),
            arc(edge, center + rounding * axis(), center),
        ])
        .unwrap();
        assert_eq!(profile.seat_center_radius, pitch_radius());
        assert!(largest_gap(profile.surfaces()) < 1e-16);
        // A bottom that leans by more than is permitted, and by less.
        let sloping = |slope: f64| {
            let end = Vec2::new(2e-3, middle.y + 2e-3 * slope);
            tooth(&[line(middle, end), line(end, 2.0 * end)])
        };
        for slope in [2e-4, -2e-4] {
            let Err(Misfit::Leans(angle)) = sloping(slope) else {
                panic!("{slope}");
            };
            assert_close(angle, slope);
        }
        assert!(matches!(sloping(0.5e-4), Err(Misfit::Corner(2, _))));
    }

    #[test]
    fn a_seat_whose_centre_is_beside_the_middle_leans() {
        // Turned about its lowest point, with both ends.
        let [seat, ..] = pieces(0.0);
        for angle in [2e-4, -2e-4] {
            let leaning = OutlinePiece {
                end: turned(seat.end, seat.start, angle),
                center: seat.center.map(|center| turned(center, seat.start, angle)),
                ..seat
            };
            let Err(Misfit::Leans(found)) = tooth(&[leaning]) else {
                panic!("{angle}");
            };
            assert_close(found, angle);
        }
    }

    #[test]
    fn no_pieces_are_no_tooth() {
        assert_eq!(tooth(&[]), Err(Misfit::Nothing));
    }

    #[test]
    fn pieces_without_length_and_arcs_of_two_radii_are_no_curves() {
        let all = pieces(0.0);
        let along = turned_left(unit(-0.4));
        // A line of half the permitted gap, and one of twice.
        let mut short = all;
        short[1].end = short[1].start + 0.5e-7 * along;
        let Err(Misfit::NoCurve(2, first, last)) = tooth(&short) else {
            panic!("a line without length");
        };
        assert!(first == last && (first - 0.5e-7).abs() < 1e-16);
        short[1].end = short[1].start + 2e-7 * along;
        assert!(matches!(tooth(&short), Err(Misfit::Apart(3, _))));
        let mut closed = all;
        closed[2].end = closed[2].start;
        assert!(matches!(tooth(&closed), Err(Misfit::NoCurve(3, _, _))));
        for off in [3e-7, -3e-7] {
            let mut oval = all;
            let center = oval[0].center.unwrap();
            oval[0].end = center + (4e-3 + off) * unit(-0.4);
            let Err(Misfit::NoCurve(1, first, last)) = tooth(&oval) else {
                panic!("two radii");
            };
            assert!((first - 4e-3).abs() < 1e-16 && (last - first - off).abs() < 1e-15);
            // A third of the permitted difference is half of it in the radius.
            let mut nearly = all;
            nearly[0].end = center + (4e-3 + off / 9.0) * unit(-0.4);
            let found = tooth(&nearly).unwrap();
            let SurfaceCurve::Concave(seat) = found.surfaces()[0].curve else {
                panic!("the seat is concave");
            };
            assert!((seat.radius - 4e-3 - off / 18.0).abs() < 1e-16);
        }
    }

    #[test]
    fn pieces_may_be_a_tenth_of_a_micrometre_apart() {
        let along = turned_left(unit(-0.4));
        for piece in [1, 2] {
            for (gap, fits) in [
                (0.5e-7, true),
                (-0.5e-7, true),
                (2e-7, false),
                (-2e-7, false),
            ] {
                let mut all = pieces(0.0);
                // Backwards along the line, so that directions remain.
                all[piece].start += gap * along;
                if let Some(center) = &mut all[piece].center {
                    *center += gap * along;
                    all[piece].end += gap * along;
                }
                match tooth(&all) {
                    Err(Misfit::Apart(number, size)) => {
                        assert!(!fits && number == piece + 1);
                        assert!((size - gap.abs()).abs() < 1e-16);
                    }
                    other => assert!(fits, "{piece} {gap}: {other:?}"),
                }
            }
        }
    }

    #[test]
    fn corners_between_pieces_are_named_with_their_angle_to_the_left() {
        for (angle, fits) in [
            (0.5e-4, true),
            (-0.5e-4, true),
            (2e-4, false),
            (-2e-4, false),
        ] {
            let mut all = pieces(0.0);
            all[1].end = turned(all[1].end, all[1].start, angle);
            match tooth(&all) {
                Err(Misfit::Corner(2, found)) => {
                    assert!(!fits);
                    assert_close(found, angle);
                }
                other => assert!(fits && other.is_ok(), "{angle}: {other:?}"),
            }
        }
    }

    #[test]
    fn the_first_piece_begins_in_the_middle_of_the_gap() {
        for (off, fits) in [
            (0.5e-7, true),
            (-0.5e-7, true),
            (2e-7, false),
            (-2e-7, false),
        ] {
            let moved = each(pieces(0.0), |point| point + off * Vec2::x());
            match tooth(&moved) {
                Err(Misfit::Beside(found)) => assert!(!fits && (found - off).abs() < 1e-18),
                other => assert!(fits && other.is_ok(), "{off}: {other:?}"),
            }
        }
    }

    #[test]
    fn the_last_piece_ends_in_the_middle_of_the_tooth_at_a_right_angle() {
        for (off, fits) in [
            (0.5e-7, true),
            (-0.5e-7, true),
            (2e-7, false),
            (-2e-7, false),
        ] {
            let mut all = pieces(0.0);
            let center = all[2].center.unwrap();
            let radius = (all[2].end - center).norm();
            all[2].end = turned(all[2].end, center, off / radius);
            match tooth(&all) {
                Err(Misfit::Open(found)) => {
                    assert!(!fits);
                    assert_close(found, off);
                }
                other => assert!(fits && other.is_ok(), "{off}: {other:?}"),
            }
        }
        for (tilt, fits) in [
            (0.5e-4, true),
            (-0.5e-4, true),
            (2e-4, false),
            (-2e-4, false),
        ] {
            match tooth(&pieces(tilt)) {
                Err(Misfit::Point(found)) => {
                    assert!(!fits);
                    assert_close(found, tilt);
                }
                other => assert!(fits && other.is_ok(), "{tilt}: {other:?}"),
            }
        }
    }

    #[test]
    fn pieces_of_a_tooth_that_is_cut_need_not_end_in_its_middle() {
        let [seat, flank, _] = pieces(0.0);
        let longer = line(flank.start, flank.start + 12.0 * (flank.end - flank.start));
        let cut = |outside: f64| {
            ToothProfile::custom(PITCH, TEETH, &[seat, longer], Some((outside, 1e-4)))
        };
        let profile = cut(0.036).unwrap();
        assert_eq!(profile.outside_radius, 0.036);
        assert_eq!(profile.surfaces().len(), 4);
        // The flank's line meets the middle of the tooth as in a triangle with the seat's centre.
        let half = PI / f64::from(TEETH);
        let meet = (4e-3 - (pitch_radius() + RAISED) * 0.4_f64.sin()) / (half - 0.4).sin();
        let Err(Misfit::Pointed(found)) = cut(1.1 * meet) else {
            panic!("beyond its point");
        };
        assert!((found - meet).abs() < 1e-14, "{found} {meet}");
        assert_eq!(tooth(&[seat, longer]).unwrap_err(), {
            let open = axis().perp(&longer.end);
            Misfit::Open(open)
        });
    }

    #[test]
    fn a_misfit_of_exactly_the_limit_is_permitted() {
        assert_eq!(above(LARGEST_GAP, LARGEST_GAP), None);
        assert_eq!(above(-LARGEST_ANGLE, LARGEST_ANGLE), None);
        assert_eq!(above(-2e-7, LARGEST_GAP), Some(-2e-7));
    }
}
