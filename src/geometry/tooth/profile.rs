//! Profile of a sprocket: the surfaces of a tooth gap, the surface nearest to a cylinder, and its penetration.
//!
//! All quantities are in the frame of one gap: `v` points radially outward through the middle of the gap, `u` is
//! tangential towards the tooth on the right (clockwise), the origin is the centre of the seating curve. The left flank
//! mirrors the right one; only the right one is stored.

mod contact;

use std::f64::consts::PI;
use std::ops::Range;

use serde::{Deserialize, Serialize};

pub use contact::ToothContact;

use super::flank::{Flank, SurfacePiece};
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{AnsiCurves, Vec2, unit};
use crate::math::bisected;
use crate::math::simd::arc_tangent;

/// Position of the centre of the seating curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Seat {
    /// The standards' bottom diameter, pitch diameter minus roller diameter: a seated roller touches without force.
    BottomDiameter,
    /// On the pitch circle: a roller on the pitch circle has clearance all round.
    PitchCircle,
}

impl Seat {
    /// Return the distance from the sprocket's centre to the centre of the seating curve \[m\].
    pub(super) fn center_radius(
        self,
        pitch_radius: f64,
        seat_radius: f64,
        roller_diameter: f64,
    ) -> f64 {
        match self {
            Self::BottomDiameter => pitch_radius + (seat_radius - 0.5 * roller_diameter),
            Self::PitchCircle => pitch_radius,
        }
    }
}

/// Number of a surface of a profile. Both flanks of undamaged teeth share their surfaces, from the seat outward; those of damaged
/// teeth follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Surface(pub u8);

impl Surface {
    /// Seating curve: the middle of the gap in every form.
    pub const SEATING: Self = Self(0);
    /// Working curve of an ANSI tooth.
    pub const WORKING: Self = Self(1);
    /// Flat of an ANSI tooth.
    pub const FLAT: Self = Self(2);
    /// Topping curve of an ANSI tooth.
    pub const TOPPING: Self = Self(3);
    /// The four surfaces of an ANSI tooth, in the order of their numbers.
    pub const ANSI: [Self; 4] = [Self::SEATING, Self::WORKING, Self::FLAT, Self::TOPPING];

    /// Return the index in an array over the surfaces of a profile.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// A damaged tooth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Damage {
    /// Number of the tooth, from 0: tooth k lies between gaps k and k + 1.
    pub tooth: u32,
    /// Remaining height above the bottom of the gap, from 0 (missing) to 1.
    pub height: f64,
}

/// The tooth gaps of a sprocket.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothProfile {
    /// Number of teeth N.
    pub teeth: u32,
    /// Radius of the pitch circle \[m\].
    pub pitch_radius: f64,
    /// Distance from the sprocket's centre to the origin of a gap's frame, the centre of the seating curve \[m\].
    pub seat_center_radius: f64,
    /// Radius of the outside circle \[m\].
    pub outside_radius: f64,
    /// Curves of an uncut ANSI tooth.
    ansi: Option<AnsiCurves>,
    /// Surfaces by their number.
    surfaces: Vec<SurfacePiece>,
    /// Surfaces of each kind of flank: undamaged teeth first, then damaged ones.
    flanks: Vec<Range<usize>>,
    /// Damaged teeth and their flanks.
    damaged: Vec<(u32, usize)>,
    /// Unit vectors from the centre through the middle of each gap; that of gap 0 lies along x.
    gap_directions: Vec<Vec2>,
}

impl ToothProfile {
    pub(crate) fn of(
        teeth: u32,
        pitch: f64,
        seat_center_radius: f64,
        outside_radius: f64,
        flank: Flank,
    ) -> Self {
        Self {
            teeth,
            pitch_radius: pitch_radius(pitch, teeth),
            seat_center_radius,
            outside_radius,
            ansi: None,
            flanks: vec![0..flank.pieces.len(); 1],
            surfaces: flank.pieces,
            damaged: Vec::new(),
            gap_directions: (0..teeth)
                .map(|gap| unit(f64::from(gap) * (2.0 * PI / f64::from(teeth))))
                .collect(),
        }
    }

    pub(crate) fn with_ansi(self, curves: AnsiCurves) -> Self {
        Self {
            ansi: Some(curves),
            ..self
        }
    }

    /// Return the profile of an ANSI tooth whose topping curves continue to the middle of the tooth.
    #[must_use]
    pub fn ansi_curves(&self) -> Option<&AnsiCurves> {
        self.ansi.as_ref()
    }

    /// Return all surfaces by their number.
    #[must_use]
    pub fn surfaces(&self) -> &[SurfacePiece] {
        &self.surfaces
    }

    /// Return the surfaces of undamaged teeth, from the seat outward.
    #[must_use]
    pub fn whole(&self) -> &[SurfacePiece] {
        &self.surfaces[self.flanks[0].clone()]
    }

    /// Return the damaged teeth, each with the numbers of its surfaces.
    pub fn damaged(&self) -> impl Iterator<Item = (u32, Range<usize>)> {
        let flanks = &self.flanks;
        self.damaged
            .iter()
            .map(|&(tooth, flank)| (tooth, flanks[flank].clone()))
    }

    /// Return the sprocket's centre in the frame of a gap \[m\].
    #[must_use]
    pub fn center(&self) -> Vec2 {
        Vec2::new(0.0, -self.seat_center_radius)
    }

    /// Return the unit vector from the sprocket's centre along the middle of the tooth on the right.
    pub(crate) fn axis(&self) -> Vec2 {
        unit(PI / 2.0 - 0.5 * self.gap_angle())
    }

    /// Return the same teeth cut at a circle of `outside` \[m\], their edges rounded by a radius `edge` \[m\].
    ///
    /// # Errors
    /// The radius \[m\] at which the flanks meet, when that is inside the circle.
    pub fn cut(&self, outside: f64, edge: f64) -> Result<Self, f64> {
        let whole = Flank {
            pieces: self.whole().to_vec(),
        };
        let cut = whole.cut(self.center(), self.axis(), outside, edge);
        let cut = cut.ok_or_else(|| self.point_radius())?;
        let mut profile = Self {
            outside_radius: outside,
            ansi: None,
            ..self.clone()
        };
        profile.flanks = vec![0..cut.pieces.len(); 1];
        profile.surfaces = cut.pieces;
        profile.damaged = Vec::new();
        Ok(profile)
    }

    /// Return the radius \[m\] at which the extended flanks meet in the middle of a tooth.
    fn point_radius(&self) -> f64 {
        let (center, axis) = (self.center(), self.axis());
        let outside = |radius: f64| self.contact(center + radius * axis, 0.0).penetration < 0.0;
        let between = [0.8, 2.0].map(|share| share * self.pitch_radius);
        bisected(between, 60, |radius| !outside(radius))[1]
    }

    /// Return the same profile with damaged teeth, their edges rounded by a radius `edge` \[m\]; `None` for more surfaces than
    /// numbers.
    #[must_use]
    pub fn with_damage(mut self, damage: &[Damage], edge: f64) -> Option<Self> {
        let bottom = self.seat_center_radius
            + self
                .contact_with(Surface::SEATING, Vec2::zeros(), 0.0)
                .penetration;
        let whole = Flank {
            pieces: self.whole().to_vec(),
        };
        let last_step = whole.pieces.last().map_or(0, |piece| piece.step);
        let mut heights: Vec<f64> = Vec::new();
        for damage in damage {
            let known = heights.iter().position(|&height| height == damage.height);
            let flank = known.unwrap_or(heights.len());
            if known.is_none() {
                heights.push(damage.height);
                let outside = bottom + damage.height * (self.outside_radius - bottom);
                let (center, axis) = (self.center(), self.axis());
                let stump = (damage.height > 0.0)
                    .then(|| whole.cut(center, axis, outside, edge))
                    .flatten();
                let cut = stump.unwrap_or_else(|| Flank::level(center, axis, outside));
                let first = self.surfaces.len();
                self.surfaces
                    .extend(cut.pieces.into_iter().map(|piece| SurfacePiece {
                        step: piece.step.min(last_step),
                        ..piece
                    }));
                self.flanks.push(first..self.surfaces.len());
            }
            self.damaged.push((damage.tooth, 1 + flank));
        }
        u8::try_from(self.surfaces.len()).is_ok().then_some(self)
    }

    /// Return the angle from one gap to the next \[rad\].
    #[must_use]
    pub fn gap_angle(&self) -> f64 {
        2.0 * PI / f64::from(self.teeth)
    }

    /// Return the unit vector from the sprocket's centre through the middle of a gap, in the sprocket's frame.
    pub(crate) fn gap_direction(&self, gap: u32) -> Vec2 {
        self.gap_directions[gap as usize]
    }

    /// Return the gap nearest to the direction of a point in the sprocket's frame.
    pub(crate) fn gap_towards(&self, point: Vec2) -> u32 {
        let beside = arc_tangent(point.y / point.x);
        self.nearest_gap(if point.x < 0.0 {
            beside + PI.copysign(point.y)
        } else {
            beside
        })
    }

    /// Return the gap nearest to the direction `angle` \[rad\], between -π and π, in the sprocket's frame.
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

    /// Return the outline of the right half of a gap between undamaged teeth, from its middle to that of the tooth, `points` per curve \[m\].
    ///
    /// In the gap's (u, v); for drawings. Uncut teeth end at the outside circle.
    #[must_use]
    pub fn half_outline(&self, points: usize) -> Vec<Vec2> {
        self.outline_of(0, points)
    }

    fn outline_of(&self, flank: usize, points: usize) -> Vec<Vec2> {
        let pieces = &self.surfaces[self.flanks[flank].clone()];
        let sweep = |piece: &SurfacePiece| piece.curve.sweep(piece.start, piece.end, points.max(2));
        pieces.iter().flat_map(sweep).collect()
    }

    /// Return the closed outline of the whole sprocket in its own frame, counterclockwise \[m\]; `points` per curve.
    #[must_use]
    pub fn outline(&self, points: usize) -> Vec<Vec2> {
        let halves: Vec<Vec<Vec2>> = (0..self.flanks.len())
            .map(|flank| self.outline_of(flank, points))
            .collect();
        let half_of = |tooth: u32| {
            let damaged = self.damaged.iter().find(|(number, _)| *number == tooth);
            &halves[damaged.map_or(0, |&(_, flank)| flank)]
        };
        let mut outline = Vec::new();
        for gap in 0..self.teeth {
            let (sin, cos) = (f64::from(gap) * self.gap_angle()).sin_cos();
            // Counterclockwise is -u: the right half from tip to seat, then the left half from seat to tip.
            let place = |p: Vec2| {
                let (radial, tangential) = (p.y + self.seat_center_radius, -p.x);
                Vec2::new(
                    radial * cos - tangential * sin,
                    radial * sin + tangential * cos,
                )
            };
            let before = half_of(gap.checked_sub(1).unwrap_or(self.teeth - 1));
            outline.extend(before.iter().rev().map(|&p| place(p)));
            let behind = half_of(gap).iter().skip(1);
            outline.extend(behind.map(|&p| place(Vec2::new(-p.x, p.y))));
        }
        outline
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tooth::checks::distance_from_outline;

    fn paper() -> ToothProfile {
        ToothProfile::ansi(0.0127, 0.007_937_5, 17, Seat::BottomDiameter)
    }

    #[test]
    fn profile_of_the_seventeen_tooth_sprocket_has_the_tabulated_numbers() {
        let p = paper();
        let c = p.ansi_curves().unwrap();
        let mm = 1e-3;
        let close = |a: f64, b: f64| (a - b).abs() < 6e-7 * mm;
        assert!(close(2.0 * p.pitch_radius, 69.115_828 * mm));
        assert!(close(c.seating.radius, 4.026_694 * mm));
        assert!(close(c.working.radius, 10.376_694 * mm));
        assert!(close(c.topping.radius, 6.582_621 * mm));
        assert!(close(c.flat.length, 0.932_219 * mm));
        assert!(close(2.0 * p.outside_radius, 75.558_999 * mm));
        assert!(close(p.seat_center_radius, 34.615_858 * mm));
        assert!(close(c.flat.start.x, 4.525_004 * mm) && close(c.flat.start.y, -0.235_846 * mm));
        assert!(close(c.flat.end().x, 4.901_547 * mm) && close(c.flat.end().y, 0.616_943 * mm));
        assert!(
            close(c.topping.center.x, 10.923_289 * mm)
                && close(c.topping.center.y, -2.041_917 * mm)
        );
        assert!((p.reach(0.003_968_75) - 43.4e-3).abs() < 0.1e-3);
    }

    #[test]
    fn a_seated_roller_just_touches_with_the_standard_seat() {
        let p = paper();
        let on_pitch_circle = Vec2::new(0.0, p.pitch_radius - p.seat_center_radius);
        let contact = p.contact(on_pitch_circle, 0.5 * 0.007_937_5);
        assert_eq!(contact.region, 4);
        assert!(contact.penetration.abs() < 1e-17);
    }

    #[test]
    fn outline_is_closed_counterclockwise_and_inside_the_outside_circle() {
        let p = paper();
        let outline = p.outline(12);
        let area: f64 = outline
            .iter()
            .zip(outline.iter().cycle().skip(1))
            .map(|(a, b)| 0.5 * a.perp(b))
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

    #[test]
    fn every_direction_belongs_to_the_gap_half_a_pitch_to_either_side() {
        for teeth in [9, 16] {
            let p = ToothProfile::ansi(0.0127, 0.007_937_5, teeth, Seat::PitchCircle);
            assert!((f64::from(teeth) * p.gap_angle() - 2.0 * PI).abs() < 1e-14);
            for gap in 0..teeth {
                for off in [-0.49, 0.0, 0.49] {
                    let direction = unit((f64::from(gap) + off) * p.gap_angle());
                    assert_eq!(p.nearest_gap(direction.y.atan2(direction.x)), gap);
                    assert_eq!(p.gap_towards(0.7 * direction), gap);
                }
            }
        }
    }

    #[test]
    fn the_standard_seat_is_lower_than_one_on_the_pitch_circle_by_half_the_play() {
        // 2 R - Dr is 0.005 Dr and 0.003 in; the seat's centre lies farther out by half of it.
        let [bottom, pitch] = [Seat::BottomDiameter, Seat::PitchCircle]
            .map(|seat| ToothProfile::ansi(0.0127, 0.007_937_5, 17, seat).seat_center_radius);
        let play = 0.005 * 0.007_937_5 + 0.003 * 0.0254;
        assert!((bottom - pitch - 0.5 * play).abs() < 1e-15);
        assert_eq!(pitch, paper().pitch_radius);
    }

    #[test]
    fn damaged_teeth_of_one_height_share_their_surfaces() {
        let damage =
            [(3, 0.5), (16, 0.5), (5, 0.0)].map(|(tooth, height)| Damage { tooth, height });
        let p = paper().with_damage(&damage, 1e-4).unwrap();
        let damaged: Vec<_> = p.damaged().collect();
        let numbers = |tooth: u32| {
            let found = damaged.iter().find(|(number, _)| *number == tooth);
            found.unwrap().1.clone()
        };
        assert_eq!(damaged.len(), 3);
        assert_eq!(numbers(3), numbers(16));
        assert_eq!(numbers(3).start, 4);
        assert_eq!(numbers(5), numbers(3).end..p.surfaces().len());
        assert_eq!(p.whole(), paper().surfaces());
        // Height is counted from the bottom of the gap to the outside circle.
        let bottom = p.seat_center_radius - p.ansi_curves().unwrap().seating.radius;
        for (tooth, height) in [(3, 0.5), (5, 0.0)] {
            let land = p.surfaces()[numbers(tooth).end - 1];
            let outside = bottom + height * (p.outside_radius - bottom);
            assert!(((land.end - p.center()).norm() - outside).abs() < 1e-15);
        }
        // Regions are counted from the seat, and there are no more than those of whole teeth.
        for surface in 0..p.surfaces().len() {
            let number = Surface(u8::try_from(surface).unwrap());
            let step = p.surfaces()[surface].step;
            assert!(step <= 3);
            assert_eq!(
                [p.region(number, true), p.region(number, false)],
                [4 - step, 4 + step]
            );
        }
    }

    #[test]
    fn surfaces_are_at_most_as_many_as_numbers() {
        // 255 numbers: four surfaces of whole teeth, one for a missing tooth, and stumps of different heights.
        let p = ToothProfile::ansi(0.0127, 0.007_937_5, 150, Seat::PitchCircle);
        let damage: Vec<_> = (0..150)
            .map(|tooth| Damage {
                tooth,
                height: 0.3 + 1e-3 * f64::from(tooth),
            })
            .collect();
        let count = |heights: usize| {
            let damaged = p.clone().with_damage(&damage[..heights], 1e-5);
            damaged.map(|p| p.surfaces().len())
        };
        let possible = (0..150)
            .take_while(|&heights| count(heights).is_some())
            .count();
        let largest = count(possible - 1).unwrap();
        assert!((250..=255).contains(&largest), "{largest}");
    }

    #[test]
    fn a_cut_profile_has_its_land_and_no_damage() {
        let p = paper()
            .with_damage(
                &[Damage {
                    tooth: 1,
                    height: 0.2,
                }],
                1e-4,
            )
            .unwrap();
        let cut = p.cut(0.036, 2e-4).unwrap();
        assert_eq!(cut.outside_radius, 0.036);
        assert_eq!((cut.damaged().count(), cut.ansi_curves()), (0, None));
        assert_eq!(cut.whole(), cut.surfaces());
        let farthest = cut.outline(9).iter().map(Vec2::norm).fold(0.0, f64::max);
        assert!((farthest - 0.036).abs() < 1e-15);
        // A cylinder on the land has no reach beyond it.
        assert!((cut.reach(0.004) - 0.040).abs() < 1e-17);
        // A tooth that is cut beyond its point: its topping curves meet where their circles cross the middle of the tooth.
        let curves = *p.ansi_curves().unwrap();
        let b = curves.topping.center - p.center();
        let beside = b.perp(&p.axis());
        let meet = b.dot(&p.axis()) + (curves.topping.radius.powi(2) - beside * beside).sqrt();
        let found = p.cut(1.2 * meet, 1e-4).unwrap_err();
        assert!((found - meet).abs() < 1e-15, "{found} {meet}");
    }

    #[test]
    fn the_outline_has_each_damaged_tooth_in_its_place() {
        let damage = [(3, 0.5), (16, 0.2)].map(|(tooth, height)| Damage { tooth, height });
        let p = paper().with_damage(&damage, 1e-4).unwrap();
        let outline = p.outline(30);
        let bottom = p.seat_center_radius - p.ansi_curves().unwrap().seating.radius;
        for tooth in 0..17 {
            // Tooth k is between gaps k and k + 1.
            let middle = (f64::from(tooth) + 0.5) * p.gap_angle();
            let on_it = outline.iter().filter(|q| {
                let off = unit(middle).perp(q).atan2(unit(middle).dot(q));
                off.abs() < 0.5 * p.gap_angle()
            });
            let highest = on_it.map(Vec2::norm).fold(0.0, f64::max);
            let height = damage
                .iter()
                .find(|d| d.tooth == tooth)
                .map_or(1.0, |d| d.height);
            let expected = bottom + height * (p.outside_radius - bottom);
            assert!(
                (highest - expected).abs() < 1e-12,
                "{tooth}: {highest} {expected}"
            );
        }
        // Each point once: no corner of the outline is a whole pitch from the next one.
        for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
            assert!((a - b).norm() < 0.003);
        }
    }

    #[test]
    fn a_cylinder_in_a_damaged_gap_is_as_far_from_the_teeth_as_from_their_outline() {
        let damage = [(3, 0.5), (4, 0.0), (16, 0.15), (8, 0.9)];
        let damage = damage.map(|(tooth, height)| Damage { tooth, height });
        // Cut, so that lands and edges close the outline without corners.
        let cut = paper().cut(0.0374, 3e-4).unwrap();
        let p = cut.with_damage(&damage, 3e-4).unwrap();
        for gap in [0, 1, 3, 4, 5, 8, 9, 16] {
            let middle = unit(f64::from(gap) * p.gap_angle());
            for radial in [0.0315, 0.033, 0.0345, 0.0365, 0.0375, 0.039] {
                for turn in [-0.45, -0.3, -0.12, -0.01, 0.02, 0.15, 0.28, 0.46] {
                    let direction = unit(turn * p.gap_angle());
                    // In the gap's own frame: v outward, u clockwise.
                    let (u, v) = (-radial * direction.y, radial * direction.x);
                    let in_gap = Vec2::new(u, v) + p.center();
                    let found = p.contact_in(gap, in_gap, 0.0);
                    if found.penetration > 0.0 {
                        continue;
                    }
                    let place = v * middle - u * crate::geometry::turned_left(middle);
                    let apart = distance_from_outline(&p, place);
                    // Arcs are drawn by 400 points; beyond both flanks of a low tooth the own gap's flanks are nearest.
                    assert!(
                        (found.penetration + apart).abs() < 2e-7,
                        "{gap} {radial} {turn}: {found:?} {apart}"
                    );
                    assert!((found.normal.norm() - 1.0).abs() < 1e-14);
                }
            }
        }
    }
}
