//! The tooth form of ANSI/ASME B29.1: seven regions from pitch, roller diameter and number of teeth.

use std::f64::consts::PI;

use super::flank::{Flank, SurfaceCurve};
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{Arc, Seat, Segment, ToothProfile, Vec2, turned_left, unit};

const INCH: f64 = 0.0254;

/// Curves of an ANSI tooth in the frame of a tooth gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnsiCurves {
    /// Seating curve: centre a, radius R.
    pub seating: Arc,
    /// Working curve of the right flank: centre c, radius E.
    pub working: Arc,
    /// Flat of the right flank, from y to z.
    pub flat: Segment,
    /// Topping curve of the right flank: centre b, radius F.
    pub topping: Arc,
    /// Unit tangent of the right flank where seating and working curve meet, (sin A, cos A).
    pub seat_end_tangent: Vec2,
}

impl AnsiCurves {
    /// Return the curves for roller diameter Dr \[m\] and N teeth (ANSI/ASME B29.1).
    #[must_use]
    pub fn new(roller_diameter: f64, teeth: u32) -> Self {
        let n = f64::from(teeth);
        let degree = PI / 180.0;
        let dr = roller_diameter;
        let allowance = 0.0015 * INCH;

        let a_angle = (35.0 + 60.0 / n) * degree;
        let b_angle = (18.0 - 56.0 / n) * degree;
        let phi = (17.0 + 116.0 / n) * degree;
        let flat_angle = (17.0 - 64.0 / n) * degree;
        let (sin_a, cos_a) = a_angle.sin_cos();
        let (sin_phi, cos_phi) = phi.sin_cos();
        let (sin_h, cos_h) = (PI / n).sin_cos();

        let working = Arc {
            center: Vec2::new(-0.8 * dr * cos_a, 0.8 * dr * sin_a),
            radius: 1.3025 * dr + allowance,
        };
        let normal = Vec2::new(cos_phi, -sin_phi);
        Self {
            seating: Arc {
                center: Vec2::zeros(),
                radius: 0.5025 * dr + allowance,
            },
            working,
            flat: Segment {
                start: working.point(normal),
                tangent: Vec2::new(sin_phi, cos_phi),
                normal,
                length: dr * (1.4 * flat_angle.sin() - 0.8 * b_angle.sin()),
            },
            topping: Arc {
                center: Vec2::new(1.4 * dr * cos_h, -1.4 * dr * sin_h),
                radius: dr * (0.8 * b_angle.cos() + 1.4 * flat_angle.cos() - 1.3025) - allowance,
            },
            seat_end_tangent: Vec2::new(sin_a, cos_a),
        }
    }

    /// Return the distance from the sprocket's centre \[m\] beyond which a cylinder of `radius` cannot touch a tooth.
    ///
    /// The circles of radius F + r about the topping centres of neighbouring gaps cross there, on the tooth's centre line.
    /// Inside, a cylinder cannot pass from one gap to the next without deep penetration. Rollers thinner than a third of the
    /// pitch reach the topping's centre before that line: their circle is then farthest straight above the centre.
    /// Cylinders much thinner than a roller of nearly the pitch reach the line on the flat.
    pub(crate) fn reach(&self, seat_center_radius: f64, gap_angle: f64, radius: f64) -> f64 {
        let (sin, cos) = (0.5 * gap_angle).sin_cos();
        let b = self.topping.center + Vec2::new(0.0, seat_center_radius);
        let beyond = b.x * cos - b.y * sin; // distance of b from the tooth's centre line
        let along = b.x * sin + b.y * cos;
        let touch = self.topping.radius + radius;
        if beyond < 0.0 {
            return b.norm() + touch;
        }
        let past_line = |p: Vec2| p.x * cos - p.y * sin;
        let to_cylinder = Vec2::new(0.0, seat_center_radius) - radius * self.flat.normal;
        let start = self.flat.start + to_cylinder;
        if past_line(self.flat.end() + to_cylinder) > 0.0 {
            // The point of the flat on the line, or the start of the flat, which is farther out than all curves before it.
            let meets = -past_line(start) / past_line(self.flat.tangent);
            return (start + meets.max(0.0) * self.flat.tangent).norm();
        }
        along + (touch * touch - beyond * beyond).max(0.0).sqrt()
    }

    /// Return the intersection of the topping curve with the circle of `outside`, or with the tooth's centre line before it (u, v) \[m\].
    fn tip(&self, seat_center_radius: f64, gap_angle: f64, outside: f64) -> Vec2 {
        let center = Vec2::new(0.0, -seat_center_radius);
        let axis = unit(PI / 2.0 - 0.5 * gap_angle);
        let b = self.topping.center - center;
        let radius = self.topping.radius;
        // Intersection of two circles: outside circle about the sprocket's centre, topping circle about b.
        let distance = b.norm();
        let along = (distance * distance + outside.powi(2) - radius * radius) / (2.0 * distance);
        let half_chord = (outside.powi(2) - along * along).max(0.0).sqrt();
        let e = b / distance;
        let on_circle = along * e + half_chord * turned_left(e);
        if on_circle.perp(&axis) <= 0.0 {
            return on_circle + center;
        }
        let beyond = b.perp(&axis);
        let height = (radius * radius - beyond * beyond).max(0.0).sqrt();
        (b.dot(&axis) + height) * axis + center
    }
}

/// Return the outside radius \[m\] of a sprocket of z teeth: half of the standard's diameter P (0.6 + cot(180°/z)).
#[must_use]
pub fn ansi_outside_radius(pitch: f64, teeth: u32) -> f64 {
    let half = PI / f64::from(teeth);
    0.5 * pitch * (0.6 + half.cos() / half.sin())
}

impl ToothProfile {
    /// Return the profile for chain `pitch` P and `roller_diameter` Dr, both \[m\] (ANSI/ASME B29.1).
    ///
    /// Its topping curves continue to the middle of the tooth; [`Self::cut`] ends them at the outside circle.
    #[must_use]
    pub fn ansi(pitch: f64, roller_diameter: f64, teeth: u32, seat: Seat) -> Self {
        let curves = AnsiCurves::new(roller_diameter, teeth);
        let half = PI / f64::from(teeth);
        let seat_radius = curves.seating.radius;
        let seat_center_radius =
            seat.center_radius(pitch_radius(pitch, teeth), seat_radius, roller_diameter);
        let outside_radius = ansi_outside_radius(pitch, teeth);
        let AnsiCurves {
            seating,
            working,
            flat,
            topping,
            seat_end_tangent,
        } = curves;
        let bottom = Vec2::new(0.0, -seating.radius);
        let seat_end = seating.point(-turned_left(seat_end_tangent));
        let flank = Flank::begin("seating curve", bottom, SurfaceCurve::Concave(seating))
            .then(
                seat_end,
                seat_end_tangent,
                "working curve",
                SurfaceCurve::Concave(working),
            )
            .then(
                flat.start,
                flat.tangent,
                "flat",
                SurfaceCurve::Straight(flat),
            )
            .then(
                flat.end(),
                flat.tangent,
                "topping curve",
                SurfaceCurve::Convex(topping),
            )
            .end(curves.tip(seat_center_radius, 2.0 * half, outside_radius));
        Self::of(teeth, pitch, seat_center_radius, outside_radius, flank).with_ansi(curves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_topping_curve_ends_at_the_outside_circle_or_in_the_middle_of_the_tooth() {
        for (pitch, roller) in [
            (12.7e-3, 7.9375e-3),
            (9.525e-3, 5.08e-3),
            (6.35e-3, 3.302e-3),
            // Teeth so thin that their topping curves meet inside the outside circle.
            (12.7e-3, 9.5e-3),
            (12.7e-3, 10.0e-3),
        ] {
            for teeth in 9..=120 {
                let profile = ToothProfile::ansi(pitch, roller, teeth, Seat::PitchCircle);
                let curves = profile.ansi_curves().unwrap();
                let half = PI / f64::from(teeth);
                let tip = profile.surfaces().last().unwrap().end;
                let from_center = tip - profile.center();
                let off_topping = (tip - curves.topping.center).norm() - curves.topping.radius;
                assert!(off_topping.abs() < 1e-12, "{teeth}: {off_topping}");
                let above = (tip - curves.topping.center).dot(&profile.axis());
                assert!(
                    above > 0.0,
                    "the farther end of the middle: {teeth}: {above}"
                );
                // Position beside the middle of the tooth, at the angle `half` from that of the gap.
                let beside = from_center.x * half.cos() - from_center.y * half.sin();
                let outside = 0.5 * pitch * (0.6 + 1.0 / half.tan());
                assert!(beside < 1e-12, "{teeth}: {beside}");
                assert!(
                    beside.abs() < 1e-12 || (from_center.norm() - outside).abs() < 1e-12,
                    "{teeth}: {beside} {}",
                    from_center.norm() - outside
                );
                assert!(from_center.norm() < 1.001 * outside, "{teeth}");
                assert!(tip.y > 0.0 || roller > 0.7 * pitch, "{teeth}");
                assert!((profile.axis() - Vec2::new(half.sin(), half.cos())).norm() < 1e-15);
            }
        }
    }

    /// Return the largest distance from the sprocket's centre at which a cylinder of `radius` touches a tooth before its centre line.
    fn farthest_touching(profile: &ToothProfile, radius: f64) -> f64 {
        let curves = profile.ansi_curves().unwrap();
        let center = profile.center();
        let axis = unit(PI / 2.0 - PI / f64::from(profile.teeth));
        let flat_angle = (-curves.flat.normal.y).atan2(curves.flat.normal.x);
        let seat_angle = curves.seat_end_tangent.x.atan2(curves.seat_end_tangent.y);
        // Centres beside the working curve, the flat and the topping curve down to the far side of its circle.
        let count = 20_000;
        let shares = (0..=count).map(|i| f64::from(i) / f64::from(count));
        let places = shares.flat_map(|share| {
            let working = unit(-(seat_angle + share * (flat_angle - seat_angle)));
            let topping = unit(PI - flat_angle - share * PI);
            [
                curves.working.center + (curves.working.radius - radius) * working,
                curves.flat.start + share * curves.flat.length * curves.flat.tangent
                    - radius * curves.flat.normal,
                curves.topping.center + (curves.topping.radius + radius) * topping,
            ]
        });
        places
            .map(|place| place - center)
            .filter(|place| place.perp(&axis) <= 0.0)
            .map(|place| place.norm())
            .fold(0.0, f64::max)
    }

    #[test]
    fn beyond_its_reach_a_tooth_touches_no_cylinder() {
        // Ordinary rollers, very thin ones, and rollers as large as the pitch with thin cylinders; shares of the pitch.
        for (roller, radius) in [
            (0.625, 0.3125),
            (0.625, 0.1),
            (0.3, 0.15),
            (0.25, 0.1),
            (0.9, 0.45),
            (0.95, 0.05),
            (0.98, 0.02),
            (1.0, 0.01),
        ] {
            for teeth in [9, 17, 40, 120] {
                for seat in [Seat::BottomDiameter, Seat::PitchCircle] {
                    let profile = ToothProfile::ansi(1.0, roller, teeth, seat);
                    let found = profile.reach(radius);
                    let expected = farthest_touching(&profile, radius);
                    let flat = profile.ansi_curves().unwrap().flat;
                    let start = flat.start - radius * flat.normal - profile.center();
                    if start.perp(&profile.axis()) > 0.0 {
                        // The whole flat is behind the line: its start is an upper bound.
                        assert!((found - start.norm()).abs() < 1e-14 && found > expected);
                        continue;
                    }
                    // Half a step of the curves at a slope of one: 3 / 20,000.
                    assert!(
                        (found - expected).abs() < 1.5e-4,
                        "{roller} {radius} {teeth}: {found} {expected}"
                    );
                }
            }
        }
    }
}
