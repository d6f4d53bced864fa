//! The tooth form of ISO 606 with convex flanks, and one with straight flanks.

use std::f64::consts::PI;

use super::flank::{Flank, SurfaceCurve};
use crate::geometry::{Arc, Seat, Segment, ToothProfile, Vec2, turned_left, unit};

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
            seat_radius: 0.505 * d1 + share * play,
            flank_radius: between(0.12 * d1 * (z + 2.0), 0.008 * d1 * (z * z + 180.0)),
            seat_angle: between(140.0 - 90.0 / z, 120.0 - 90.0 / z).to_radians(),
        }
    }
}

/// Return the standard's smallest and largest tip diameter \[m\] for z teeth.
#[must_use]
pub fn iso_tip_diameters(pitch: f64, roller_diameter: f64, teeth: u32) -> [f64; 2] {
    let d = 2.0 * crate::geometry::path::wrap::pitch_radius(pitch, teeth);
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
    fn seat_center_radius(&self, seat_radius: f64) -> f64 {
        let pitch_radius = crate::geometry::path::wrap::pitch_radius(self.pitch, self.teeth);
        match self.seat {
            Seat::BottomDiameter => pitch_radius + (seat_radius - 0.5 * self.roller_diameter),
            Seat::PitchCircle => pitch_radius,
        }
    }

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
        let seat_center_radius = self.seat_center_radius(seat_radius);
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
}
