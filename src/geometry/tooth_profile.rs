//! The tooth gap of ANSI/ASME B29.1: seven regions from pitch, roller diameter and number of teeth.
//!
//! Everything here lives in the frame of one gap: `v` points radially outward through the middle of the gap, `u` is
//! tangential towards the tooth on the right (clockwise), the origin is the centre of the seating curve. The left flank
//! mirrors the right one, so only the right one is stored.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Arc, Segment, Vec2};

const INCH: f64 = 0.0254;

/// Where the centre of the seating curve lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seat {
    /// The standard's bottom diameter, pitch diameter less roller diameter: a seated roller just touches.
    BottomDiameter,
    /// On the pitch circle: a roller on the pitch circle has clearance all round.
    PitchCircle,
}

/// One of the seven regions of a gap, counted in the direction of +u.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
#[allow(missing_docs)] // the names say it
pub enum Region {
    ToppingLeft = 1,
    FlatLeft = 2,
    WorkingLeft = 3,
    Seating = 4,
    WorkingRight = 5,
    FlatRight = 6,
    ToppingRight = 7,
}

/// The kind of surface a region has; both flanks share one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
#[allow(missing_docs)] // the names say it
pub enum Surface {
    Seating = 0,
    Working = 1,
    Flat = 2,
    Topping = 3,
}

impl Surface {
    /// All four, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Seating, Self::Working, Self::Flat, Self::Topping];

    /// The name used in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Seating => "seating curve",
            Self::Working => "working curve",
            Self::Flat => "flat",
            Self::Topping => "topping curve",
        }
    }

    fn region(self, left: bool) -> Region {
        match (self, left) {
            (Self::Seating, _) => Region::Seating,
            (Self::Working, true) => Region::WorkingLeft,
            (Self::Working, false) => Region::WorkingRight,
            (Self::Flat, true) => Region::FlatLeft,
            (Self::Flat, false) => Region::FlatRight,
            (Self::Topping, true) => Region::ToppingLeft,
            (Self::Topping, false) => Region::ToppingRight,
        }
    }
}

/// A cylinder against one gap of a tooth profile, in the frame of the gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothContact {
    /// The surface nearest to the cylinder.
    pub surface: Surface,
    /// The region of the seven that it belongs to.
    pub region: Region,
    /// Penetration δ \[m\]; negative when apart.
    pub penetration: f64,
    /// Unit vector in which the penetration grows, in the gap's (u, v).
    pub normal: Vec2,
}

/// The gap between two neighbouring teeth after ANSI/ASME B29.1.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothProfile {
    /// Number of teeth N.
    pub teeth: u32,
    /// Radius of the pitch circle \[m\].
    pub pitch_radius: f64,
    /// Distance from the sprocket's centre to the centre of the seating curve \[m\].
    pub seat_center_radius: f64,
    /// Radius of the outside circle \[m\], where the blank ends.
    pub outside_radius: f64,
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

impl ToothProfile {
    /// The profile for chain `pitch` P and `roller_diameter` Dr, both \[m\] (ANSI/ASME B29.1).
    #[must_use]
    pub fn ansi(pitch: f64, roller_diameter: f64, teeth: u32, seat: Seat) -> Self {
        let n = f64::from(teeth);
        let degree = PI / 180.0;
        let dr = roller_diameter;
        let allowance = 0.0015 * INCH;

        let a_angle = (35.0 + 60.0 / n) * degree;
        let b_angle = (18.0 - 56.0 / n) * degree;
        let phi = (17.0 + 116.0 / n) * degree;
        let flat_angle = (17.0 - 64.0 / n) * degree;
        let half_pitch_angle = PI / n;
        let (sin_a, cos_a) = a_angle.sin_cos();
        let (sin_phi, cos_phi) = phi.sin_cos();
        let (sin_h, cos_h) = half_pitch_angle.sin_cos();

        let seating_radius = 0.5025 * dr + allowance;
        let working = Arc {
            center: Vec2::new(-0.8 * dr * cos_a, 0.8 * dr * sin_a),
            radius: 1.3025 * dr + allowance,
        };
        let normal = Vec2::new(cos_phi, -sin_phi);
        let flat = Segment {
            start: working.point(normal),
            tangent: Vec2::new(sin_phi, cos_phi),
            normal,
            length: dr * (1.4 * flat_angle.sin() - 0.8 * b_angle.sin()),
        };
        let topping = Arc {
            center: Vec2::new(1.4 * dr * cos_h, -1.4 * dr * sin_h),
            radius: dr * (0.8 * b_angle.cos() + 1.4 * flat_angle.cos() - 1.3025) - allowance,
        };
        let pitch_radius = pitch / (2.0 * sin_h);
        let seat_center_radius = match seat {
            Seat::BottomDiameter => pitch_radius + (seating_radius - 0.5 * dr),
            Seat::PitchCircle => pitch_radius,
        };
        Self {
            teeth,
            pitch_radius,
            seat_center_radius,
            outside_radius: 0.5 * pitch * (0.6 + cos_h / sin_h),
            seating: Arc {
                center: Vec2::zeros(),
                radius: seating_radius,
            },
            working,
            flat,
            topping,
            seat_end_tangent: Vec2::new(sin_a, cos_a),
        }
    }

    /// Angle from one gap to the next \[rad\].
    #[must_use]
    pub fn gap_angle(&self) -> f64 {
        2.0 * PI / f64::from(self.teeth)
    }

    /// The gap nearest to the direction `angle` \[rad\], between -π and π, in the sprocket's own frame.
    #[must_use]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_possible_wrap
    )] // at most half the teeth either side
    pub fn nearest_gap(&self, angle: f64) -> u32 {
        let gap = (angle / self.gap_angle()).round() as i32;
        (if gap < 0 {
            gap + self.teeth as i32
        } else {
            gap
        }) as u32
    }

    /// The surface of this gap that is nearest to a cylinder at `point` (u, v): the normals at the junctions divide the plane.
    #[must_use]
    pub fn surface_at(&self, point: Vec2) -> Surface {
        let right = Vec2::new(point.x.abs(), point.y);
        if right.dot(&self.seat_end_tangent) < 0.0 {
            return Surface::Seating;
        }
        let along = self.flat.along(right);
        if along < 0.0 {
            Surface::Working
        } else if along <= self.flat.length {
            Surface::Flat
        } else {
            Surface::Topping
        }
    }

    /// Contact of a cylinder of `radius` \[m\] centred at `point` (u, v) \[m\] with its nearest surface.
    #[must_use]
    pub fn contact(&self, point: Vec2, radius: f64) -> ToothContact {
        self.contact_with(self.surface_at(point), point, radius)
    }

    /// The same with a given surface, continued past its ends.
    #[must_use]
    pub fn contact_with(&self, surface: Surface, point: Vec2, radius: f64) -> ToothContact {
        let left = point.x < 0.0;
        let right = Vec2::new(point.x.abs(), point.y);
        let (penetration, mut normal) = match surface {
            Surface::Seating => self.seating.depth_inside(right, radius),
            Surface::Working => self.working.depth_inside(right, radius),
            Surface::Flat => self.flat.depth(right, radius),
            Surface::Topping => self.topping.depth_outside(right, radius),
        };
        if left {
            normal.x = -normal.x;
        }
        ToothContact {
            surface,
            region: surface.region(left),
            penetration,
            normal,
        }
    }

    /// Distance from the sprocket's centre \[m\] beyond which a cylinder of `radius` touches no tooth.
    ///
    /// There the circles of radius F + r about the topping centres of neighbouring gaps cross, on the tooth's centre line;
    /// inside it a cylinder cannot pass from one gap to the next without deep contact. Rollers thinner than a third of the
    /// pitch leave room for the topping's centre before that line: then its circle is farthest straight above the centre.
    /// Cylinders much thinner than a roller of nearly the pitch meet the line on the flat.
    #[must_use]
    pub fn reach(&self, radius: f64) -> f64 {
        let (sin, cos) = (0.5 * self.gap_angle()).sin_cos();
        let b = self.topping.center + Vec2::new(0.0, self.seat_center_radius);
        let beyond = b.x * cos - b.y * sin; // distance of b from the tooth's centre line
        let along = b.x * sin + b.y * cos;
        let touch = self.topping.radius + radius;
        if beyond < 0.0 {
            return b.norm() + touch;
        }
        let past_line = |p: Vec2| p.x * cos - p.y * sin;
        let to_cylinder = Vec2::new(0.0, self.seat_center_radius) - radius * self.flat.normal;
        let start = self.flat.start + to_cylinder;
        if past_line(self.flat.end() + to_cylinder) > 0.0 {
            // Where the flat meets the line, or where it begins, which is farther out than whatever lies before it.
            let meets = -past_line(start) / past_line(self.flat.tangent);
            return (start + meets.max(0.0) * self.flat.tangent).norm();
        }
        along + (touch * touch - beyond * beyond).max(0.0).sqrt()
    }

    /// The outline of the right half of a gap from the bottom of the seat to the outside circle, `points` to a curve \[m\].
    ///
    /// In the gap's (u, v); for drawings. Where the topping curve leaves the outside circle, it ends there.
    #[must_use]
    pub fn half_outline(&self, points: usize) -> Vec<Vec2> {
        let points = points.max(2);
        let a_angle = self.seat_end_tangent.x.atan2(self.seat_end_tangent.y);
        let phi = (-self.flat.normal.y).atan2(self.flat.normal.x);
        let sweep = |arc: &Arc, from: f64, to: f64| -> Vec<Vec2> {
            (0..points)
                .map(|i| {
                    arc.point(super::unit(
                        from + (to - from) * i as f64 / (points - 1) as f64,
                    ))
                })
                .collect()
        };
        let mut outline = sweep(&self.seating, -PI / 2.0, -a_angle);
        outline.extend(sweep(&self.working, -a_angle, -phi));
        outline.extend([self.flat.start, self.flat.end()]);
        // The topping curve turns clockwise about b, from facing the flat up to the outside circle or the tooth's centre line.
        let (sin, cos) = (0.5 * self.gap_angle()).sin_cos();
        let center = Vec2::new(0.0, -self.seat_center_radius);
        for tip in sweep(&self.topping, PI - phi, PI - phi - PI / 2.0) {
            let from_center = tip - center;
            let past_middle = from_center.x * cos - from_center.y * sin > 0.0;
            if from_center.norm() > self.outside_radius || past_middle {
                break;
            }
            outline.push(tip);
        }
        outline.push(self.tip());
        outline
    }

    /// Where the topping curve meets the outside circle or, before that, the tooth's centre line (u, v) \[m\].
    fn tip(&self) -> Vec2 {
        let center = Vec2::new(0.0, -self.seat_center_radius);
        let axis = super::unit(PI / 2.0 - 0.5 * self.gap_angle());
        let b = self.topping.center - center;
        let radius = self.topping.radius;
        // Intersection of two circles: outside circle about the sprocket's centre, topping circle about b.
        let distance = b.norm();
        let along = (distance * distance + self.outside_radius.powi(2) - radius * radius)
            / (2.0 * distance);
        let half_chord = (self.outside_radius.powi(2) - along * along)
            .max(0.0)
            .sqrt();
        let e = b / distance;
        let on_circle = along * e + half_chord * super::turned_left(e);
        if on_circle.x * axis.y - on_circle.y * axis.x <= 0.0 {
            return on_circle + center;
        }
        let beyond = b.x * axis.y - b.y * axis.x;
        let height = (radius * radius - beyond * beyond).max(0.0).sqrt();
        (b.dot(&axis) + height) * axis + center
    }

    /// The closed outline of the whole sprocket in its own frame, counterclockwise \[m\]; `points` to a curve.
    #[must_use]
    pub fn outline(&self, points: usize) -> Vec<Vec2> {
        let right = self.half_outline(points);
        let mut outline = Vec::new();
        for gap in 0..self.teeth {
            let (sin, cos) = (f64::from(gap) * self.gap_angle()).sin_cos();
            // Counterclockwise is -u: the right half is walked from tip to seat, then the left one from seat to tip.
            let place = |p: Vec2| {
                let (radial, tangential) = (p.y + self.seat_center_radius, -p.x);
                Vec2::new(
                    radial * cos - tangential * sin,
                    radial * sin + tangential * cos,
                )
            };
            outline.extend(right.iter().rev().map(|&p| place(p)));
            outline.extend(right.iter().skip(1).map(|&p| place(Vec2::new(-p.x, p.y))));
        }
        outline
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper() -> ToothProfile {
        ToothProfile::ansi(0.0127, 0.007_937_5, 17, Seat::BottomDiameter)
    }

    #[test]
    fn profile_of_the_seventeen_tooth_sprocket_has_the_tabulated_numbers() {
        let p = paper();
        let mm = 1e-3;
        let close = |a: f64, b: f64| (a - b).abs() < 6e-7 * mm;
        assert!(close(2.0 * p.pitch_radius, 69.115_828 * mm));
        assert!(close(p.seating.radius, 4.026_694 * mm));
        assert!(close(p.working.radius, 10.376_694 * mm));
        assert!(close(p.topping.radius, 6.582_621 * mm));
        assert!(close(p.flat.length, 0.932_219 * mm));
        assert!(close(2.0 * p.outside_radius, 75.558_999 * mm));
        assert!(close(p.seat_center_radius, 34.615_858 * mm));
        assert!(close(p.flat.start.x, 4.525_004 * mm) && close(p.flat.start.y, -0.235_846 * mm));
        assert!(close(p.flat.end().x, 4.901_547 * mm) && close(p.flat.end().y, 0.616_943 * mm));
        assert!(
            close(p.topping.center.x, 10.923_289 * mm)
                && close(p.topping.center.y, -2.041_917 * mm)
        );
        assert!((p.reach(0.003_968_75) - 43.4e-3).abs() < 0.1e-3);
    }

    #[test]
    fn a_seated_roller_just_touches_with_the_standard_seat() {
        let p = paper();
        let on_pitch_circle = Vec2::new(0.0, p.pitch_radius - p.seat_center_radius);
        let contact = p.contact(on_pitch_circle, 0.5 * 0.007_937_5);
        assert_eq!(contact.region, Region::Seating);
        assert!(contact.penetration.abs() < 1e-17);
    }

    #[test]
    fn outline_is_closed_counterclockwise_and_inside_the_outside_circle() {
        let p = paper();
        let outline = p.outline(12);
        let area: f64 = outline
            .iter()
            .zip(outline.iter().cycle().skip(1))
            .map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x))
            .sum();
        assert!(area > 0.8 * PI * p.pitch_radius.powi(2));
        assert!(
            outline
                .iter()
                .all(|q| q.norm() <= p.outside_radius * (1.0 + 1e-12))
        );
        let reaches_tip = outline
            .iter()
            .any(|q| q.norm() > p.outside_radius * (1.0 - 1e-12));
        assert!(reaches_tip);
    }
}
