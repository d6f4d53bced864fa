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
    use crate::geometry::unit;

    /// Distance of a point from the outline \[m\], in the body's own frame.
    fn apart(profile: &ToothProfile, point: Vec2) -> f64 {
        let outline = profile.outline(400);
        let next = outline.iter().cycle().skip(1);
        let distances = outline.iter().zip(next).map(|(from, to)| {
            let along = to - from;
            let share = (point - from).dot(&along) / along.norm_squared().max(1e-30);
            (from + share.clamp(0.0, 1.0) * along - point).norm()
        });
        distances.fold(f64::INFINITY, f64::min)
    }

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
                let across = place.x * middle.y - place.y * middle.x;
                let in_gap = Vec2::new(across, place.dot(&middle));
                let depth = profile.contact(in_gap, 0.0).penetration;
                let apart = apart(&profile, place);
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
}
