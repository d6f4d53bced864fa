//! Smooth guides: bars with a straight, convex or concave face, and wheels without teeth.
//!
//! They are profiles of two equal gaps back to back: v is the outward normal of the first gap's face, u is along it.

use crate::geometry::tooth::flank::{Flank, SurfaceCurve};
use crate::geometry::{Arc, Segment, ToothProfile, Vec2, turned_left};

impl ToothProfile {
    /// Return a wheel of `radius` \[m\] without teeth.
    #[must_use]
    pub fn smooth_wheel(radius: f64) -> Self {
        let rim = SurfaceCurve::Convex(Arc {
            center: Vec2::zeros(),
            radius,
        });
        let flank = Flank::begin("rim", Vec2::new(0.0, radius), rim).end(Vec2::new(radius, 0.0));
        Self::of(2, 2.0 * radius, 0.0, radius, flank)
    }

    /// Return a bar of `length` \[m\] with round ends of radius `end` \[m\] and faces of `radius` \[m\]; negative for concave
    /// ones.
    ///
    /// The middle of a concave bar lies below the centres of its ends by [`Self::hollow_depth`]; both faces look outward from there.
    ///
    /// `None` where the ends are too large for the length, or the radius of the face is smaller than the length permits.
    #[must_use]
    pub fn bar(length: f64, radius: Option<f64>, end: f64) -> Option<Self> {
        let half = 0.5 * length - end;
        if !(half > 0.0 && end > 0.0) {
            return None;
        }
        let depth = radius.map_or(0.0, |radius| Self::hollow_depth(length, radius, end));
        if depth.is_nan() {
            return None;
        }
        let ends = Vec2::new(half, depth);
        let round = SurfaceCurve::Convex(Arc {
            center: ends,
            radius: end,
        });
        let flank = match radius {
            None => {
                let along = Vec2::x();
                Flank::begin(
                    "face",
                    Vec2::new(0.0, end),
                    straight(Vec2::new(0.0, end), along, half),
                )
                .then(Vec2::new(half, end), along, "end", round)
            }
            Some(radius) if radius > 0.0 => {
                // The face touches the round ends from outside: its centre is (radius - end) from theirs.
                let below = ((radius - end).powi(2) - half * half).sqrt();
                if below.is_nan() || below <= 0.0 || radius <= end {
                    return None;
                }
                let arch = Arc {
                    center: Vec2::new(0.0, -below),
                    radius,
                };
                let outward = Vec2::new(half, below) / (radius - end);
                Flank::begin("face", arch.point(Vec2::y()), SurfaceCurve::Convex(arch)).then(
                    arch.point(outward),
                    -turned_left(outward),
                    "end",
                    round,
                )
            }
            Some(radius) => {
                let hollow = Arc {
                    center: Vec2::new(0.0, depth + hollow_height(half, -radius, end)),
                    radius: -radius,
                };
                let outward = (ends - hollow.center).normalize();
                let side = Vec2::new(half + end, depth);
                Flank::begin(
                    "face",
                    hollow.point(-Vec2::y()),
                    SurfaceCurve::Concave(hollow),
                )
                .then(hollow.point(outward), turned_left(outward), "end", round)
                .then(side, -Vec2::y(), "side", straight(side, -Vec2::y(), depth))
            }
        };
        let flank = flank.end(Vec2::new(half + end, 0.0));
        let farthest = (ends.norm() + end).max(0.5 * length);
        Some(Self::of(2, length, 0.0, farthest, flank))
    }

    /// Return the depth of the middle of a concave bar below the centres of its ends \[m\]; its thinnest section is as thick as an end.
    /// Zero for a convex bar; NaN where the radius is smaller than the length permits.
    #[must_use]
    pub fn hollow_depth(length: f64, radius: f64, end: f64) -> f64 {
        if radius > 0.0 {
            return 0.0;
        }
        if -radius > 0.5 * length {
            let half = 0.5 * length - end;
            (-radius - hollow_height(half, -radius, end)).max(0.0) + end
        } else {
            f64::NAN
        }
    }
}

/// Return the height of the centre of a concave face of `radius` above the centres of the ends \[m\].
fn hollow_height(half: f64, radius: f64, end: f64) -> f64 {
    ((radius + end).powi(2) - half * half).sqrt()
}

fn straight(start: Vec2, along: Vec2, length: f64) -> SurfaceCurve {
    SurfaceCurve::Straight(Segment {
        start,
        tangent: along,
        normal: -turned_left(along),
        length,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tooth::checks::{distance_from_outline, largest_corner, largest_gap};
    use crate::geometry::tooth::flank::SurfacePiece;
    use crate::geometry::unit;

    #[test]
    fn a_cylinder_beside_a_rail_is_as_far_from_it_as_from_its_outline() {
        let rails = [
            ToothProfile::smooth_wheel(0.03),
            ToothProfile::bar(0.12, None, 0.004).unwrap(),
            ToothProfile::bar(0.12, Some(0.3), 0.004).unwrap(),
            ToothProfile::bar(0.12, Some(-0.2), 0.004).unwrap(),
        ];
        for profile in rails {
            for i in 0..40 {
                let direction = unit(0.157 * f64::from(i) + 0.01);
                let gap = profile.nearest_gap(direction.y.atan2(direction.x));
                let middle = unit(f64::from(gap) * std::f64::consts::PI);
                let place = 0.08 * direction;
                let in_gap = Vec2::new(place.perp(&middle), place.dot(&middle));
                let depth = profile.contact(in_gap, 0.0).penetration;
                let apart = distance_from_outline(&profile, place);
                assert!((depth + apart).abs() < 1e-6, "{i}: {depth} {apart}");
            }
        }
    }

    #[test]
    fn a_bar_that_cannot_be_is_none() {
        assert!(ToothProfile::bar(0.1, None, 0.05).is_none());
        for radius in [0.04, 0.0, -0.04, f64::NAN] {
            assert!(ToothProfile::bar(0.1, Some(radius), 0.004).is_none());
        }
    }

    /// Radii of the faces of a bar: straight, hardly and strongly convex, hardly and strongly concave.
    const FACES: [Option<f64>; 5] = [None, Some(3.0), Some(0.061), Some(-3.0), Some(-0.061)];

    #[test]
    fn a_bar_has_its_length_its_round_ends_and_faces_without_corners() {
        let (length, end) = (0.12, 0.004);
        for face in FACES {
            let bar = ToothProfile::bar(length, face, end).unwrap();
            let pieces = bar.surfaces();
            // Centres up to 3 m away are rounded to 4e-16 m; an angle at the end is this over its radius of 4e-3 m.
            assert!(largest_gap(pieces) < 1e-14, "{face:?}");
            assert!(largest_corner(pieces) < 1e-12, "{face:?}");
            assert_eq!(pieces[0].start.x, 0.0);
            let last = pieces.last().unwrap();
            assert!((last.end - Vec2::new(0.5 * length, 0.0)).norm() < 1e-15);
            assert!((last.curve.tangent(last.end) + Vec2::y()).norm() < 1e-12);
            let round = |piece: &SurfacePiece| match piece.curve {
                SurfaceCurve::Convex(arc) => Some(arc.radius),
                SurfaceCurve::Concave(arc) => Some(-arc.radius),
                SurfaceCurve::Straight(_) => None,
            };
            assert_eq!(round(&pieces[0]), face);
            assert_eq!(round(&pieces[1]), Some(end));
            // Concave bars have straight sides, and are at least as thick as an end: more where the face bulges over them.
            let concave = face.is_some_and(|radius| radius < 0.0);
            assert_eq!(pieces.len(), if concave { 3 } else { 2 });
            if concave {
                let (half, radius) = (0.5 * length - end, -face.unwrap());
                let height = ((radius + end).powi(2) - half * half).sqrt();
                let thickness = end + (height - radius).max(0.0);
                assert!((pieces[0].start.y - thickness).abs() < 1e-15);
            }
            assert_eq!(bar.seat_center_radius, 0.0);
            // Thickness in the middle, from the sagitta of the circle of the ends' centres.
            if let Some(radius) = face.filter(|&radius| radius > 0.0) {
                let (half, reach) = (0.5 * length - end, radius - end);
                let height = end + reach - (reach * reach - half * half).sqrt();
                assert!((pieces[0].start.y - height).abs() < 1e-15);
            }
            let outline = bar.outline(50);
            let farthest = outline.iter().map(Vec2::norm).fold(0.0, f64::max);
            assert!(farthest <= bar.outside_radius + 1e-15, "{face:?}");
            // The bound is that of the round ends.
            assert!(farthest > 0.99 * bar.outside_radius, "{face:?}");
        }
    }

    #[test]
    fn the_middle_of_a_concave_bar_lies_below_its_ends_by_the_sagitta_and_half_a_thickness() {
        // Centres of ends on a circle of R + e about that of the face: right triangles with sides that are finite decimals.
        let (end, half) = (1.0, 4.0);
        let length = 2.0 * (half + end);
        // Too strong: half the length is 5.
        assert!(ToothProfile::hollow_depth(length, -4.5, end).is_nan());
        // R + e = 8.5 over 4 m: the height is 7.5, the sagitta of the face 7.5 - 7.5.
        let depth = ToothProfile::hollow_depth(length, -7.5, end);
        assert!((depth - (7.5 - 7.5 + end)).abs() < 1e-15);
        // R + e = 7.025 over 4 m: the height is 5.775, the sagitta of the face 6.025 - 5.775.
        let (radius, height) = (6.025, 5.775);
        let depth = ToothProfile::hollow_depth(length, -radius, end);
        assert!((depth - (radius - height + end)).abs() < 1e-14, "{depth}");
        // Hardly concave: the ends stand out over the middle of the face.
        assert_eq!(ToothProfile::hollow_depth(length, -100.0, end), end);
        assert_eq!(ToothProfile::hollow_depth(length, 100.0, end), 0.0);
    }

    #[test]
    fn the_limits_of_a_bar_are_half_its_length() {
        // Ends as large as half the length leave no face; smaller ones do. Ends have a radius.
        assert!(ToothProfile::bar(1.0, None, 0.5).is_none());
        assert!(ToothProfile::bar(1.0, None, 0.499).is_some());
        assert!(ToothProfile::bar(1.0, None, 0.0).is_none());
        for (radius, possible) in [(0.5, false), (0.501, true), (-0.5, false), (-0.501, true)] {
            let bar = ToothProfile::bar(1.0, Some(radius), 0.125);
            assert_eq!(bar.is_some(), possible, "{radius}");
        }
        // A face of the radius of the ends would be a circle.
        assert!(ToothProfile::bar(1.0, Some(0.25), 0.25).is_none());
        assert!(ToothProfile::bar(1.0, Some(0.125), 0.4).is_none());
    }

    #[test]
    fn a_smooth_wheel_is_a_circle() {
        let wheel = ToothProfile::smooth_wheel(0.03);
        assert_eq!((wheel.teeth, wheel.outside_radius), (2, 0.03));
        assert!((wheel.pitch_radius - 0.03).abs() < 1e-17);
        assert!(largest_gap(wheel.surfaces()) < 1e-17 && largest_corner(wheel.surfaces()) < 1e-15);
        for point in wheel.outline(20) {
            assert!((point.norm() - 0.03).abs() < 1e-17);
        }
        let contact = wheel.contact(Vec2::new(0.03, 0.04), 0.02);
        assert!((contact.penetration).abs() < 1e-17);
        assert!((contact.normal + Vec2::new(0.6, 0.8)).norm() < 1e-15);
    }
}
