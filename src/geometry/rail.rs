//! Smooth bodies that a chain slides along: bars with a straight or an arched face, and wheels without teeth.
//!
//! They are profiles of two equal gaps back to back: v points out of the face that the first gap stands for, and u along it.

use super::flank::{Curve, Flank};
use super::{Arc, Segment, ToothProfile, Vec2, turned_left};

impl ToothProfile {
    /// A wheel of `radius` \[m\] without teeth.
    #[must_use]
    pub fn smooth_wheel(radius: f64) -> Self {
        let rim = Curve::Convex(Arc {
            center: Vec2::zeros(),
            radius,
        });
        let flank = Flank::begin("rim", Vec2::new(0.0, radius), rim).end(Vec2::new(radius, 0.0));
        Self::of(2, 2.0 * radius, 0.0, radius, flank)
    }

    /// A bar of `length` \[m\] whose ends are round with radius `end` \[m\], its faces straight, or arched with the `radius` \[m\].
    ///
    /// `None` when there is no such bar: the ends are too large for the length, or the arch is smaller than the bar is long.
    #[must_use]
    pub fn bar(length: f64, radius: Option<f64>, end: f64) -> Option<Self> {
        let half = 0.5 * length - end;
        if !(half > 0.0 && end > 0.0) {
            return None;
        }
        let round = Curve::Convex(Arc {
            center: Vec2::new(half, 0.0),
            radius: end,
        });
        let flank = match radius {
            None => {
                let along = Vec2::x();
                let face = Curve::Straight(Segment {
                    start: Vec2::new(0.0, end),
                    tangent: along,
                    normal: -turned_left(along),
                    length: half,
                });
                Flank::begin("face", Vec2::new(0.0, end), face).then(
                    Vec2::new(half, end),
                    along,
                    "end",
                    round,
                )
            }
            Some(radius) => {
                // The arch touches the round ends from outside: its centre is (radius - end) from theirs.
                let below = ((radius - end).powi(2) - half * half).sqrt();
                if below.is_nan() || below <= 0.0 {
                    return None;
                }
                let arch = Arc {
                    center: Vec2::new(0.0, -below),
                    radius,
                };
                let outward = Vec2::new(half, below) / (radius - end);
                Flank::begin("face", arch.point(Vec2::y()), Curve::Convex(arch)).then(
                    arch.point(outward),
                    -turned_left(outward),
                    "end",
                    round,
                )
            }
        };
        let flank = flank.end(Vec2::new(half + end, 0.0));
        Some(Self::of(2, length, 0.0, 0.5 * length, flank))
    }
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
        assert!(ToothProfile::bar(0.1, Some(0.04), 0.004).is_none());
    }
}
