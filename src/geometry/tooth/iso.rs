//! The tooth form of ISO 606 with convex flanks, and one with straight flanks.

use std::f64::consts::PI;

use super::flank::{Flank, SurfaceCurve};
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{Arc, Seat, Segment, ToothProfile, Vec2, turned_left, unit};

/// Smallest seat radius over the roller diameter, of ISO 606.
pub const SEAT_OVER_ROLLER: f64 = 0.505;

/// Dimensions of an ISO 606 tooth gap \[m, rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IsoGap {
    /// Roller seating radius `r_i`.
    pub seat_radius: f64,
    /// Tooth flank radius `r_e`.
    pub flank_radius: f64,
    /// Roller seating angle α.
    pub seat_angle: f64,
}

impl IsoGap {
    /// Return the gap between the standard's minimum (`share` 0) and maximum (1) for roller diameter d1 \[m\] and z teeth; each dimension is
    /// interpolated linearly between its limits.
    #[must_use]
    pub fn new(roller_diameter: f64, teeth: u32, share: f64) -> Self {
        let (d1, z) = (roller_diameter, f64::from(teeth));
        let between = |least: f64, most: f64| least + share * (most - least);
        // The standard's formula 0.069 cbrt(d1) is in millimetres.
        let play = 0.069e-3 * (1e3 * d1).cbrt();
        Self {
            seat_radius: SEAT_OVER_ROLLER * d1 + share * play,
            flank_radius: between(0.12 * d1 * (z + 2.0), 0.008 * d1 * (z * z + 180.0)),
            seat_angle: between(140.0 - 90.0 / z, 120.0 - 90.0 / z).to_radians(),
        }
    }
}

/// Return the standard's smallest and largest tip diameter \[m\] for z teeth.
#[must_use]
pub fn iso_tip_diameters(pitch: f64, roller_diameter: f64, teeth: u32) -> [f64; 2] {
    let d = 2.0 * pitch_radius(pitch, teeth);
    let z = f64::from(teeth);
    [
        d + pitch * (1.0 - 1.6 / z) - roller_diameter,
        d + 1.25 * pitch - roller_diameter,
    ]
}

/// Dimensions of a blank for any tooth form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blank {
    /// Pitch of the chain \[m\].
    pub pitch: f64,
    /// Roller diameter of the form \[m\].
    pub roller_diameter: f64,
    /// Number of teeth.
    pub teeth: u32,
    /// Position of the seating curve's centre.
    pub seat: Seat,
    /// Radius of the outside circle \[m\].
    pub outside_radius: f64,
    /// Radius of the edge at the tip \[m\].
    pub edge_radius: f64,
}

impl Blank {
    /// Return the flank of a seat of `seat_radius` that continues at `seat_end`, a unit vector from its centre, with `curve`.
    fn profile(
        &self,
        seat_radius: f64,
        seat_end: Vec2,
        curve: SurfaceCurve,
    ) -> Result<ToothProfile, f64> {
        let seat = Arc {
            center: Vec2::zeros(),
            radius: seat_radius,
        };
        let from = seat.point(seat_end);
        let far = self.outside_radius;
        // Longer than any tooth; the cut ends it.
        let end = match curve {
            SurfaceCurve::Straight(segment) => segment.end(),
            SurfaceCurve::Concave(arc) | SurfaceCurve::Convex(arc) => {
                arc.point(Vec2::new(0.0, 1.0))
            }
        };
        let flank = Flank::begin(
            "seating curve",
            seat.point(Vec2::new(0.0, -1.0)),
            SurfaceCurve::Concave(seat),
        )
        .then(from, turned_left(seat_end), "flank", curve)
        .end(end);
        let pitch_radius = pitch_radius(self.pitch, self.teeth);
        let seat_center_radius =
            (self.seat).center_radius(pitch_radius, seat_radius, self.roller_diameter);
        ToothProfile::of(self.teeth, self.pitch, seat_center_radius, far, flank)
            .cut(self.outside_radius, self.edge_radius)
    }
}

impl ToothProfile {
    /// Return an ISO 606 tooth: a seat and convex flank arcs, tangent at the end of the seat.
    ///
    /// # Errors
    /// The radius \[m\] at which the flanks meet, when that is inside the outside circle.
    pub fn iso(blank: &Blank, gap: &IsoGap) -> Result<Self, f64> {
        let seat_end = unit(0.5 * gap.seat_angle - PI / 2.0);
        let flank = Arc {
            center: (gap.seat_radius + gap.flank_radius) * seat_end,
            radius: gap.flank_radius,
        };
        blank.profile(gap.seat_radius, seat_end, SurfaceCurve::Convex(flank))
    }

    /// Return a tooth with straight flanks at `flank_angle` \[rad\] from the middle of the gap, tangent to a seat of `seat_radius`
    /// \[m\].
    ///
    /// # Errors
    /// The radius \[m\] at which the flanks meet, when that is inside the outside circle.
    pub fn straight(blank: &Blank, seat_radius: f64, flank_angle: f64) -> Result<Self, f64> {
        let seat_end = unit(-flank_angle);
        let flank = Segment {
            start: seat_radius * seat_end,
            tangent: turned_left(seat_end),
            normal: seat_end,
            length: blank.outside_radius,
        };
        blank.profile(seat_radius, seat_end, SurfaceCurve::Straight(flank))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tooth::checks::{largest_corner, largest_gap};

    /// Numbers of z = 17, p = 12.7 mm, d1 = 7.92 mm, worked out by hand from the standard's formulas.
    #[test]
    fn seventeen_teeth_have_the_standard_s_numbers() {
        let close = |metres: f64, mm: f64| (1e3 * metres - mm).abs() < 6e-6 * mm;
        for (share, seat, flank, angle) in [
            (0.0, 3.9996, 18.0576, 134.7059),
            (1.0, 4.13714, 29.71584, 114.7059),
        ] {
            let gap = IsoGap::new(7.92e-3, 17, share);
            assert!(close(gap.seat_radius, seat) && close(gap.flank_radius, flank));
            assert!((gap.seat_angle.to_degrees() - angle).abs() < 6e-5);
        }
        let [least, most] = iso_tip_diameters(12.7e-3, 7.92e-3, 17);
        assert!(close(least, 72.7005) && close(most, 77.0708));
    }

    fn blank(seat: Seat, outside_radius: f64, edge_radius: f64) -> Blank {
        Blank {
            pitch: 12.7,
            roller_diameter: 7.92,
            teeth: 17,
            seat,
            outside_radius,
            edge_radius,
        }
    }

    #[test]
    fn seat_flank_edge_and_land_follow_each_other_without_corners() {
        let pitch_radius = 6.35 / (PI / 17.0).sin();
        for seat in [Seat::BottomDiameter, Seat::PitchCircle] {
            for share in [0.0, 0.4, 1.0] {
                let gap = IsoGap::new(7.92e-3, 17, share);
                let gap = IsoGap {
                    seat_radius: 1e3 * gap.seat_radius,
                    flank_radius: 1e3 * gap.flank_radius,
                    ..gap
                };
                let curved = ToothProfile::iso(&blank(seat, 36.8, 0.3), &gap).unwrap();
                let straight =
                    ToothProfile::straight(&blank(seat, 36.8, 0.3), gap.seat_radius, 0.35).unwrap();
                for profile in [&curved, &straight] {
                    let pieces = profile.surfaces();
                    let names: Vec<_> = pieces.iter().map(|piece| piece.name).collect();
                    assert_eq!(names, ["seating curve", "flank", "edge", "land"]);
                    assert!(largest_gap(pieces) < 1e-13 && largest_corner(pieces) < 1e-13);
                    assert_eq!(pieces[0].start, Vec2::new(0.0, -gap.seat_radius));
                    let from_center = pieces[3].end - profile.center();
                    assert!((from_center - 36.8 * profile.axis()).norm() < 1e-13);
                    let raised = match seat {
                        Seat::BottomDiameter => gap.seat_radius - 3.96,
                        Seat::PitchCircle => 0.0,
                    };
                    assert!((profile.seat_center_radius - pitch_radius - raised).abs() < 1e-13);
                    // A cylinder touches the seat, and one against the flank has its depth.
                    let seated = profile.contact(Vec2::new(0.0, -1.0), gap.seat_radius - 1.0);
                    assert!(seated.penetration.abs() < 1e-14);
                }
                // Half the seating angle to either side of the middle; the flank's radius joins both centres.
                let turn = 0.5 * gap.seat_angle;
                let end = gap.seat_radius * Vec2::new(turn.sin(), -turn.cos());
                assert!((curved.surfaces()[1].start - end).norm() < 1e-14);
                let SurfaceCurve::Convex(flank) = curved.surfaces()[1].curve else {
                    panic!("the flank is convex");
                };
                assert_eq!(flank.radius, gap.flank_radius);
                assert!((flank.center - end - flank.radius * end.normalize()).norm() < 1e-13);
                let slope = Vec2::new(0.35_f64.sin(), 0.35_f64.cos());
                let along = straight.surfaces()[1].end - straight.surfaces()[1].start;
                assert!((along.normalize() - slope).norm() < 1e-13);
            }
        }
    }

    #[test]
    fn a_tooth_that_ends_inside_the_outside_circle_is_pointed_where_its_flanks_meet() {
        // Straight flanks at the angle f meet the middle of the tooth, at the angle h, by the law of sines.
        for (angle, outside) in [(0.3, 60.0), (0.5, 45.0), (0.6, 44.0)] {
            let profile =
                ToothProfile::straight(&blank(Seat::PitchCircle, outside, 0.2), 4.0, angle);
            let half: f64 = PI / 17.0;
            let pitch_radius = 6.35 / half.sin();
            // The flank's line has the distance 4 mm from the seat's centre, beside the sprocket's centre by p.
            let beside: f64 = 4.0 - pitch_radius * f64::sin(angle);
            let expected = beside / (half - angle).sin();
            let found = profile.unwrap_err();
            assert!(
                (found - expected).abs() < 1e-10,
                "{angle}: {found} {expected}"
            );
            assert!(expected < outside);
        }
    }
}
