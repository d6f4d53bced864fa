//! Half a tooth gap as a sequence of tangent curves, and the curve nearest to a cylinder.
//!
//! Right half in the frame of a gap (u, v): from the middle of the gap to the middle of the tooth, the material on
//! the right.

use crate::geometry::{Arc, Segment, Vec2, turned_left, unit};

/// Distance past the end of a piece, over the radius of the cut, at which a point still is on it: rounding.
const PAST_END: f64 = 1e-9;

/// A curve of a flank, seen from outside the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurfaceCurve {
    /// A concave arc: the cylinder is inside.
    Concave(Arc),
    /// A convex arc: the cylinder is outside.
    Convex(Arc),
    /// A straight line.
    Straight(Segment),
}

impl SurfaceCurve {
    /// Return the penetration \[m\] of a cylinder of `radius` at `point`, and its direction of increase.
    #[must_use]
    pub fn depth(&self, point: Vec2, radius: f64) -> (f64, Vec2) {
        match self {
            Self::Concave(arc) => arc.depth_inside(point, radius),
            Self::Convex(arc) => arc.depth_outside(point, radius),
            Self::Straight(segment) => segment.depth(point, radius),
        }
    }

    /// Return the unit tangent at `point` of the curve, along the flank.
    #[must_use]
    pub fn tangent(&self, point: Vec2) -> Vec2 {
        match self {
            Self::Concave(arc) => turned_left((point - arc.center) / arc.radius),
            Self::Convex(arc) => -turned_left((point - arc.center) / arc.radius),
            Self::Straight(segment) => segment.tangent,
        }
    }

    /// Return the centres of circles of `radius` in the material that touch the curve and the inside of a circle of
    /// `outside` about `center`.
    fn inscribed(&self, radius: f64, center: Vec2, outside: f64) -> Vec<Vec2> {
        let within = outside - radius;
        match self {
            Self::Concave(arc) => crossings(arc.center, arc.radius + radius, center, within),
            Self::Convex(arc) => crossings(arc.center, arc.radius - radius, center, within),
            Self::Straight(segment) => {
                let from = segment.start + radius * segment.normal - center;
                let along = -from.dot(&segment.tangent);
                let foot = from + along * segment.tangent;
                let half = (within * within - foot.norm_squared()).sqrt();
                if half.is_nan() {
                    return Vec::new();
                }
                [half, -half]
                    .map(|half| center + foot + half * segment.tangent)
                    .to_vec()
            }
        }
    }

    /// Return the point of the curve nearest to `center` of a tangent circle.
    fn touched_from(&self, center: Vec2) -> Vec2 {
        match self {
            Self::Concave(arc) | Self::Convex(arc) => arc.point((center - arc.center).normalize()),
            Self::Straight(segment) => segment.start + segment.along(center) * segment.tangent,
        }
    }

    /// Return `points` of the curve from `start` to `end`; the two ends of a straight line.
    pub(crate) fn sweep(&self, start: Vec2, end: Vec2, points: usize) -> Vec<Vec2> {
        let (arc, sense) = match self {
            Self::Straight(_) => return vec![start, end],
            Self::Concave(arc) => (arc, 1.0),
            Self::Convex(arc) => (arc, -1.0),
        };
        let (first, last) = (start - arc.center, end - arc.center);
        let turn = sense * first.perp(&last).atan2(first.dot(&last));
        let turn = if turn < 0.0 {
            turn + 2.0 * std::f64::consts::PI
        } else {
            turn
        };
        let from = first.y.atan2(first.x);
        (0..points)
            .map(|i| {
                if i + 1 == points {
                    end
                } else {
                    arc.point(unit(from + sense * turn * i as f64 / (points - 1) as f64))
                }
            })
            .collect()
    }
}

/// Return the intersections of two circles, if any.
fn crossings(a: Vec2, radius_a: f64, b: Vec2, radius_b: f64) -> Vec<Vec2> {
    let between = b - a;
    let distance = between.norm();
    let along = 0.5 * (distance + (radius_a - radius_b) * (radius_a + radius_b) / distance);
    let half = (radius_a * radius_a - along * along).sqrt();
    if radius_a <= 0.0 || radius_b <= 0.0 || half.is_nan() {
        return Vec::new();
    }
    let e = between / distance;
    [half, -half]
        .map(|half| a + along * e + half * turned_left(e))
        .to_vec()
}

/// Normal at the junction of two curves: the second curve is nearest to points at `limit` or more along `tangent`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Boundary {
    pub(crate) foot: Vec2,
    pub(crate) tangent: Vec2,
    /// \[m\]
    pub(crate) limit: f64,
}

impl Boundary {
    /// Return the distance of `point` past the normal \[m\].
    fn past(&self, point: Vec2) -> f64 {
        (point - self.foot).dot(&self.tangent) - self.limit
    }
}

/// A curve of a flank with its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePiece {
    /// The curve.
    pub curve: SurfaceCurve,
    /// First point \[m\].
    pub start: Vec2,
    /// Last point \[m\].
    pub end: Vec2,
    /// Name in messages.
    pub name: &'static str,
    /// Number of regions of the tooth between this one and the middle of the gap.
    pub step: u8,
    pub(crate) boundary: Boundary,
}

/// Curves of half a gap in order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Flank {
    pub(crate) pieces: Vec<SurfacePiece>,
}

impl Flank {
    /// Begin a flank at `start` with `curve`.
    pub(crate) fn begin(name: &'static str, start: Vec2, curve: SurfaceCurve) -> Self {
        let boundary = Boundary {
            foot: start,
            tangent: curve.tangent(start),
            limit: 0.0,
        };
        Self {
            pieces: vec![SurfacePiece {
                curve,
                start,
                end: start,
                name,
                step: 0,
                boundary,
            }],
        }
    }

    /// Append `curve` at `point`, where both have the unit `tangent`.
    pub(crate) fn then(
        mut self,
        point: Vec2,
        tangent: Vec2,
        name: &'static str,
        curve: SurfaceCurve,
    ) -> Self {
        let mut step = 0;
        if let Some(last) = self.pieces.last_mut() {
            let (foot, limit) = match (last.curve, curve) {
                (_, SurfaceCurve::Straight(segment)) => (segment.start, 0.0),
                (SurfaceCurve::Straight(segment), _) if point == segment.end() => {
                    (segment.start, segment.length)
                }
                (SurfaceCurve::Straight(segment), _) => (segment.start, segment.along(point)),
                (SurfaceCurve::Concave(arc) | SurfaceCurve::Convex(arc), _) => (arc.center, 0.0),
            };
            last.end = point;
            last.boundary = Boundary {
                foot,
                tangent,
                limit,
            };
            step = last.step + 1;
        }
        self.pieces.extend(Self::begin(name, point, curve).pieces);
        if let Some(last) = self.pieces.last_mut() {
            last.step = step;
        }
        self
    }

    /// End the flank at `point`.
    pub(crate) fn end(mut self, point: Vec2) -> Self {
        if let Some(last) = self.pieces.last_mut() {
            last.end = point;
        }
        self
    }

    /// Return the normal at the end of a piece: that of its junction, or at the end of the flank.
    fn end_of(&self, number: usize) -> Boundary {
        let piece = &self.pieces[number];
        match self.pieces.get(number + 1) {
            Some(_) => piece.boundary,
            None => Boundary {
                foot: piece.end,
                tangent: piece.curve.tangent(piece.end),
                limit: 0.0,
            },
        }
    }

    /// Return the flank cut by the circle of `outside` about `center`, its edge rounded by an arc of radius `edge`; `axis` is the
    /// unit vector from `center` along the middle of the tooth. `None` where the circle does not meet the flank.
    pub(crate) fn cut(&self, center: Vec2, axis: Vec2, outside: f64, edge: f64) -> Option<Self> {
        let slack = PAST_END * outside;
        for (i, piece) in self.pieces.iter().enumerate() {
            for middle in piece.curve.inscribed(edge, center, outside) {
                let from_center = middle - center;
                let touched = piece.curve.touched_from(middle);
                let before = i > 0 && self.pieces[i - 1].boundary.past(touched) < -slack;
                let behind = self.end_of(i).past(touched) > slack;
                let beside = middle.x < 0.0 || from_center.perp(&axis) > 0.0;
                if before || behind || beside {
                    continue;
                }
                let mut cut = Self {
                    pieces: self.pieces[..=i].to_vec(),
                };
                let round = Arc {
                    center: middle,
                    radius: edge,
                };
                let land = Arc {
                    center,
                    radius: outside,
                };
                cut = cut.then(
                    touched,
                    piece.curve.tangent(touched),
                    "edge",
                    SurfaceCurve::Convex(round),
                );
                let corner = land.point(from_center.normalize());
                let level = SurfaceCurve::Convex(land);
                cut = cut.then(corner, level.tangent(corner), "land", level);
                return Some(cut.end(center + outside * axis));
            }
        }
        None
    }

    /// Return the land of a tooth cut down to the circle of `outside` about `center`.
    pub(crate) fn level(center: Vec2, axis: Vec2, outside: f64) -> Self {
        let land = SurfaceCurve::Convex(Arc {
            center,
            radius: outside,
        });
        Self::begin("land", center + Vec2::new(0.0, outside), land).end(center + outside * axis)
    }
}

/// Return the number of the piece nearest to `point` on the right half: the normals at the junctions divide the plane.
pub(crate) fn nearest_piece(pieces: &[SurfacePiece], point: Vec2) -> usize {
    let last = pieces.len() - 1;
    let within = |piece: &SurfacePiece| {
        let Boundary {
            foot,
            tangent,
            limit,
        } = piece.boundary;
        (point - foot).dot(&tangent) < limit
    };
    pieces[..last].iter().position(within).unwrap_or(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tooth::checks::{largest_corner, largest_gap};
    use crate::geometry::{Seat, ToothProfile};

    // Coordinates up to 10 are rounded to 1e-15; bounds of 1e-14 and 1e-13 permit sums of ten and a hundred of such errors.
    fn arc(x: f64, y: f64, radius: f64) -> Arc {
        Arc {
            center: Vec2::new(x, y),
            radius,
        }
    }

    #[test]
    fn circles_of_three_and_four_about_centres_five_apart_cross_at_right_angles() {
        // Along 3:4, so that the crossings are off the line of centres by 12/5.
        let (a, along) = (Vec2::new(1.0, 2.0), Vec2::new(0.6, 0.8));
        let b = a + 5.0 * along;
        let foot = a + 1.8 * along;
        let off = 2.4 * Vec2::new(-0.8, 0.6);
        let found = crossings(a, 3.0, b, 4.0);
        assert_eq!(found.len(), 2);
        assert!((found[0] - foot - off).norm() < 1e-14);
        assert!((found[1] - foot + off).norm() < 1e-14);
        // Too far apart, or one within the other; a circle without radius.
        assert!(crossings(a, 2.0, b, 2.5).is_empty());
        assert!(crossings(a, 12.0, b, 4.0).is_empty());
        assert!(crossings(a, -3.0, b, 4.0).is_empty());
        assert!(crossings(a, 3.0, b, -4.0).is_empty());
        assert!(crossings(a, 0.0, b, 5.0).is_empty() && crossings(a, 5.0, b, 0.0).is_empty());
    }

    #[test]
    fn inscribed_circles_touch_the_curve_and_the_outside_circle() {
        let (center, outside, radius) = (Vec2::new(0.5, -3.0), 6.0, 0.75);
        let slope = Segment {
            start: Vec2::new(-1.0, 0.5),
            tangent: Vec2::new(0.8, -0.6),
            normal: Vec2::new(-0.6, -0.8),
            length: 2.0,
        };
        for curve in [
            SurfaceCurve::Concave(arc(0.0, 4.0, 3.0)),
            SurfaceCurve::Convex(arc(1.0, 2.0, 2.5)),
            SurfaceCurve::Straight(slope),
        ] {
            let found = curve.inscribed(radius, center, outside);
            assert_eq!(found.len(), 2);
            // On a line, the one farther along is the first.
            let apart = found[0] - found[1];
            assert!(apart.norm() > 1.0);
            assert!(!matches!(curve, SurfaceCurve::Straight(_)) || apart.dot(&slope.tangent) > 0.0);
            for middle in found {
                assert!(((middle - center).norm() - (outside - radius)).abs() < 1e-14);
                // In the material, so that its radius is its own penetration twice over.
                assert!((curve.depth(middle, radius).0 - 2.0 * radius).abs() < 1e-14);
                let touched = curve.touched_from(middle);
                assert!(((touched - middle).norm() - radius).abs() < 1e-14);
                assert!(curve.depth(touched, 0.0).0.abs() < 1e-14);
            }
        }
        assert!(
            SurfaceCurve::Straight(slope)
                .inscribed(0.75, center, 1.0)
                .is_empty()
        );
    }

    #[test]
    fn points_of_an_arc_divide_its_turn_evenly_also_beyond_half_a_circle() {
        let circle = arc(2.0, -1.0, 0.5);
        let at = |angle: f64| circle.point(unit(angle));
        for (first, turn) in [(0.3, 0.4), (2.9, 0.5), (-1.0, 4.0), (1.0, 6.0), (0.5, 0.0)] {
            for (curve, sense) in [
                (SurfaceCurve::Concave(circle), 1.0),
                (SurfaceCurve::Convex(circle), -1.0),
            ] {
                let points = curve.sweep(at(first), at(first + sense * turn), 6);
                assert_eq!(points.len(), 6);
                assert_eq!(points[5], at(first + sense * turn));
                for (i, point) in (0..).zip(points) {
                    let expected = at(first + sense * turn * f64::from(i) / 5.0);
                    assert!((point - expected).norm() < 1e-14, "{first} {turn} {i}");
                }
            }
        }
    }

    #[test]
    fn tangents_lead_along_the_flank_with_the_material_on_the_right() {
        let circle = arc(2.0, -1.0, 0.5);
        let right = circle.point(Vec2::x());
        assert_eq!(SurfaceCurve::Concave(circle).tangent(right), Vec2::y());
        assert_eq!(SurfaceCurve::Convex(circle).tangent(right), -Vec2::y());
    }

    /// A concave quarter circle, a line that rises along 4:3 of a circle's tangent, and the circles at its ends.
    fn seat_line_and_tip(unit: f64) -> Flank {
        let (slope, normal) = (Vec2::new(0.6, 0.8), Vec2::new(0.8, -0.6));
        let line = Segment {
            start: 2.0 * unit * normal,
            tangent: slope,
            normal,
            length: 5.0 * unit,
        };
        let tip = Arc {
            center: line.end() + 3.0 * unit * normal,
            radius: 3.0 * unit,
        };
        Flank::begin(
            "seat",
            Vec2::new(0.0, -2.0 * unit),
            SurfaceCurve::Concave(arc(0.0, 0.0, 2.0 * unit)),
        )
        .then(line.start, slope, "line", SurfaceCurve::Straight(line))
        .then(line.end(), slope, "tip", SurfaceCurve::Convex(tip))
        .end(tip.point(Vec2::y()))
    }

    #[test]
    fn normals_at_the_junctions_divide_the_plane_among_the_pieces() {
        let flank = seat_line_and_tip(1.0);
        assert!(largest_gap(&flank.pieces) < 1e-14 && largest_corner(&flank.pieces) < 1e-14);
        let steps: Vec<_> = flank.pieces.iter().map(|piece| piece.step).collect();
        assert_eq!(steps, [0, 1, 2]);
        // The same line ends before its length: the normal is at the last point.
        let mut shorter = flank.clone();
        let SurfaceCurve::Straight(line) = shorter.pieces[1].curve else {
            panic!("the second piece is straight");
        };
        let middle = line.start + 2.0 * line.tangent;
        shorter = Flank {
            pieces: shorter.pieces[..2].to_vec(),
        }
        .then(middle, line.tangent, "tip", flank.pieces[2].curve)
        .end(flank.pieces[2].end);
        for flank in [flank, shorter] {
            for piece in 0..2 {
                let junction = flank.pieces[piece].end;
                for off in [-1.5, 0.0, 1.5] {
                    let near = junction + off * line.normal;
                    let step = 1e-9 * line.tangent;
                    assert_eq!(nearest_piece(&flank.pieces, near - step), piece);
                    assert_eq!(nearest_piece(&flank.pieces, near + step), piece + 1);
                }
            }
            assert_eq!(nearest_piece(&flank.pieces[..1], Vec2::zeros()), 0);
        }
    }

    /// Assert that `cut` is the tooth of `pieces` within a circle, with an edge of this radius.
    fn assert_cut(pieces: &[SurfacePiece], cut: &Flank, center: Vec2, outside: f64, edge: f64) {
        assert!(largest_gap(&cut.pieces) < 1e-13 && largest_corner(&cut.pieces) < 1e-11);
        let [.., below, round, land] = &cut.pieces[..] else {
            panic!("two more pieces");
        };
        assert_eq!((round.name, land.name), ("edge", "land"));
        assert_eq!((round.step, land.step), (below.step + 1, below.step + 2));
        let circle = |piece: &SurfacePiece| match piece.curve {
            SurfaceCurve::Convex(arc) => (arc.center, arc.radius),
            _ => panic!("edges and lands are convex"),
        };
        assert_eq!(circle(land), (center, outside));
        let (middle, radius) = circle(round);
        assert_eq!(radius, edge);
        assert!(((middle - center).norm() + edge - outside).abs() < 1e-13);
        // Pieces below the edge are those of the tooth; the last one ends earlier.
        let kept = cut.pieces.len() - 2;
        for (i, (piece, whole)) in cut.pieces[..kept].iter().zip(pieces).enumerate() {
            assert_eq!((piece.curve, piece.start), (whole.curve, whole.start));
            assert!(i + 1 == kept || piece.end == whole.end);
        }
        let whole = pieces[kept - 1];
        let after = |from: Vec2, to: Vec2| (to - from).dot(&whole.curve.tangent(from));
        assert!(after(whole.start, below.end) > -1e-7 * outside);
        assert!(after(below.end, whole.end) > -1e-7 * outside);
        // Neither the edge nor the land goes back towards the gap.
        assert!(middle.x >= 0.0 && round.end.x >= 0.0);
        let outward = [below.end, middle, round.end].map(|p| (p - center).norm());
        assert!(outward[0] <= outward[2] + 1e-13 && outward[1] < outward[2]);
    }

    #[test]
    fn a_tooth_is_cut_at_any_height_through_any_of_its_pieces() {
        let tooth = ToothProfile::ansi(12.7, 7.9375, 17, Seat::BottomDiameter);
        let (center, axis) = (tooth.center(), tooth.axis());
        let flank = Flank {
            pieces: tooth.whole().to_vec(),
        };
        let bottom = tooth.seat_center_radius - 4.1;
        let mut cut_through = [0; 4];
        for i in 1..60 {
            for edge in [0.01, 0.1, 0.4] {
                let outside = bottom + (tooth.outside_radius - bottom) * f64::from(i) / 60.0;
                let Some(cut) = flank.cut(center, axis, outside, edge) else {
                    // An edge fits anywhere but near the bottom and at the tip.
                    assert!(!(12..=55).contains(&i), "{i} {edge}");
                    continue;
                };
                cut_through[cut.pieces.len() - 3] += 1;
                assert_cut(&flank.pieces, &cut, center, outside, edge);
                assert!((cut.pieces.last().unwrap().end - center - outside * axis).norm() < 1e-13);
            }
        }
        assert!(
            cut_through.iter().all(|&times| times > 5),
            "{cut_through:?}"
        );
    }

    #[test]
    fn a_straight_flank_is_cut_where_a_circle_between_it_and_the_outside_circle_touches_it() {
        // Outside circles about the seat's centre; the flank's line has the distance 2 from it.
        let flank = seat_line_and_tip(1.0);
        let center = Vec2::zeros();
        let axis = unit(-0.1);
        for (outside, edge) in [(5.0_f64, 0.5), (5.0, 0.125), (3.0, 0.25)] {
            let cut = flank.cut(center, axis, outside, edge).unwrap();
            assert_cut(&flank.pieces, &cut, center, outside, edge);
            // The edge's centre is 2 + e off the line and R - e from the centre.
            let along = ((outside - edge).powi(2) - (2.0 + edge).powi(2)).sqrt();
            let touched = flank.pieces[1].start + along * Vec2::new(0.6, 0.8);
            assert!((cut.pieces[2].start - touched).norm() < 1e-14);
        }
        // Higher up the tip is cut, in any unit of length.
        for unit in [1.0, 1e-6] {
            let flank = seat_line_and_tip(unit);
            let (outside, edge) = (7.0 * unit, 0.25 * unit);
            let cut = flank.cut(center, axis, outside, edge).unwrap();
            assert_eq!(cut.pieces.len(), 5);
            assert_cut(&flank.pieces, &cut, center, outside, edge);
        }
        // A circle beyond the end of the tip or the whole of it does not meet the flank, and a tooth needs room for its edge.
        assert_eq!(flank.cut(center, axis, 9.5, 0.25), None);
        assert_eq!(flank.cut(center, axis, 20.0, 0.1), None);
        assert_eq!(flank.cut(center, unit(1.0), 5.0, 0.5), None);
    }

    #[test]
    fn a_tooth_that_is_missing_is_a_circle_from_gap_to_gap() {
        let (center, axis) = (Vec2::new(0.0, -3.0), unit(1.2));
        let level = Flank::level(center, axis, 2.0);
        assert_eq!(level.pieces.len(), 1);
        assert_eq!(level.pieces[0].start, Vec2::new(0.0, -1.0));
        assert!(largest_gap(&level.pieces) < 1e-15 && largest_corner(&level.pieces) < 1e-15);
        assert!((level.pieces[0].end - center - 2.0 * axis).norm() < 1e-15);
        assert!((level.pieces[0].curve.depth(Vec2::new(0.0, 0.0), 0.5).0 + 0.5).abs() < 1e-15);
    }

    #[test]
    fn an_edge_without_room_on_a_line_is_not_put_on_the_next_curve_continued_backwards() {
        // An upright line, and an arc that leans back from its end. The middle of the tooth lies between the edge on the line and
        // that on the circle of the arc, which leaves the line to the left below its end, too.
        let line = Segment {
            start: Vec2::x(),
            tangent: Vec2::y(),
            normal: Vec2::x(),
            length: 5.0,
        };
        let hollow = arc(-9.0, 5.0, 10.0);
        let flank = Flank::begin("line", line.start, SurfaceCurve::Straight(line))
            .then(
                line.end(),
                Vec2::y(),
                "hollow",
                SurfaceCurve::Concave(hollow),
            )
            .end(hollow.point(unit(0.3)));
        let center = Vec2::zeros();
        assert_eq!(
            flank.cut(center, Vec2::new(0.445, 1.0).normalize(), 4.0, 0.5),
            None
        );
        // With the middle farther to the right, the edge is on the line.
        let cut = flank.cut(center, unit(1.0), 4.0, 0.5).unwrap();
        assert_eq!(cut.pieces.len(), 3);
        let along = (3.5_f64.powi(2) - 1.5 * 1.5).sqrt();
        assert!((cut.pieces[1].start - Vec2::new(1.0, along)).norm() < 1e-14);
    }

    #[test]
    fn an_edge_may_begin_in_the_middle_of_the_gap_and_end_in_that_of_the_tooth() {
        // The circle of 6 about (0, -8) touches the bottom of the seat.
        let flank = seat_line_and_tip(1.0);
        let center = Vec2::new(0.0, -8.0);
        let cut = flank.cut(center, unit(1.3), 6.0, 0.5).unwrap();
        assert_eq!(cut.pieces[1].start, Vec2::new(0.0, -2.0));
        // A bar of which the end is round.
        let line = Segment {
            start: Vec2::new(0.0, 2.0),
            tangent: Vec2::x(),
            normal: -Vec2::y(),
            length: 10.0,
        };
        let bar = Flank::begin("face", line.start, SurfaceCurve::Straight(line)).end(line.end());
        let cut = bar.cut(Vec2::zeros(), Vec2::x(), 5.0, 2.0).unwrap();
        assert_eq!(cut.pieces[1].start, Vec2::new(3.0, 2.0));
        assert_eq!(cut.pieces[2].start, Vec2::new(5.0, 0.0));
    }

    #[test]
    fn a_point_on_the_normal_of_a_junction_belongs_to_the_second_piece() {
        let line = |from: f64| Segment {
            start: Vec2::new(from, 2.0),
            tangent: Vec2::x(),
            normal: -Vec2::y(),
            length: 4.0,
        };
        let flank = Flank::begin("one", line(0.0).start, SurfaceCurve::Straight(line(0.0)))
            .then(
                line(4.0).start,
                Vec2::x(),
                "two",
                SurfaceCurve::Straight(line(4.0)),
            )
            .end(line(4.0).end());
        assert_eq!(nearest_piece(&flank.pieces, Vec2::new(4.0, 5.0)), 1);
        assert_eq!(nearest_piece(&flank.pieces, Vec2::new(3.9, 5.0)), 0);
    }

    #[test]
    fn an_edge_may_miss_the_ends_of_a_piece_by_1e_9_of_the_outside_radius() {
        // An outside circle of 1e9 m: the permitted distance is 1 m. A round end of 2048 m begins at x = 1e9 m - 1024 m.
        let (outside, edge) = (1e9, 1024.0);
        let begins = outside - edge;
        let level = |from: f64, to: f64| Segment {
            start: Vec2::new(from, edge),
            tangent: Vec2::x(),
            normal: -Vec2::y(),
            length: to - from,
        };
        let cut = |flank: Flank| flank.cut(Vec2::zeros(), Vec2::x(), outside, edge);
        for (miss, fits) in [(-1.0, true), (1.0, true), (2.0, false)] {
            let face = level(0.0, begins - miss);
            let short = Flank::begin("face", face.start, SurfaceCurve::Straight(face));
            assert_eq!(cut(short.end(face.end())).is_some(), fits, "{miss}");
            // The first piece is too strongly curved for the edge.
            let face = level(begins + miss, begins + 10.0);
            let corner = Arc {
                center: face.start - 512.0 * Vec2::y(),
                radius: 512.0,
            };
            let late = Flank::begin("corner", face.start, SurfaceCurve::Convex(corner))
                .then(face.start, Vec2::x(), "face", SurfaceCurve::Straight(face))
                .end(face.end());
            assert_eq!(cut(late).is_some(), fits, "{miss}");
        }
    }
}
