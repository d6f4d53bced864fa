//! Contact of a cylinder with the surfaces of a tooth gap: the nearest surface, its penetration, and where a cylinder cannot roll.

use std::ops::Range;

use super::{Surface, ToothProfile};
use crate::geometry::tooth::flank::nearest_piece;
use crate::geometry::{Vec2, turned_left};

/// Penetration of another surface, over the radius, above which a cylinder cannot roll along the gap.
const JAMMED: f64 = 1e-4;

/// Contact of a cylinder in one tooth gap, in the frame of the gap where no other is named.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothContact {
    /// The surface nearest to the cylinder.
    pub surface: Surface,
    /// Region of the surface, counted from 1 in the direction of +u; an ANSI gap has seven, the fourth is the seat.
    pub region: u8,
    /// Penetration δ \[m\]; negative when apart.
    pub penetration: f64,
    /// Unit vector of increasing penetration, in the gap's (u, v).
    pub normal: Vec2,
}

impl ToothProfile {
    /// Return the surface of a gap between undamaged teeth nearest to a cylinder at `point` (u, v).
    #[must_use]
    pub fn surface_at(&self, point: Vec2) -> Surface {
        self.nearest_of(0, Vec2::new(point.x.abs(), point.y))
    }

    /// Return the surface of a right flank nearest to `point`.
    #[allow(clippy::cast_possible_truncation)] // surfaces are counted when teeth are damaged
    fn nearest_of(&self, flank: usize, point: Vec2) -> Surface {
        let Range { start, end } = self.flanks[flank];
        Surface((start + nearest_piece(&self.surfaces[start..end], point)) as u8)
    }

    /// Return the contact of a cylinder of `radius` \[m\] at `point` (u, v) \[m\] with its nearest surface between undamaged teeth.
    #[must_use]
    pub fn contact(&self, point: Vec2, radius: f64) -> ToothContact {
        self.contact_with(self.surface_at(point), point, radius)
    }

    /// Return the contact in a given gap with damaged teeth; either flank may be the nearer one at any position.
    #[must_use]
    pub fn contact_in(&self, gap: u32, point: Vec2, radius: f64) -> ToothContact {
        let flank_of = |tooth: u32| {
            let damaged = self.damaged.iter().find(|(number, _)| *number == tooth);
            damaged.map_or(0, |&(_, flank)| flank)
        };
        let flanks = [gap.checked_sub(1).unwrap_or(self.teeth - 1), gap].map(flank_of);
        if flanks == [0, 0] {
            return self.contact(point, radius);
        }
        let own_side = point.x < 0.0;
        let on = |left: bool| {
            let across = Vec2::new(if left { -point.x } else { point.x }, point.y);
            let flank = flanks[usize::from(left)];
            let surface = self.nearest_of(flank, across);
            // The curve in the middle of the gap ends at u = 0 here.
            let there = left == own_side || surface.index() > self.flanks[flank].start;
            there.then(|| self.contact_on(surface, left, point, radius))
        };
        let deeper = |one: ToothContact, other: ToothContact| {
            if other.penetration > one.penetration {
                other
            } else {
                one
            }
        };
        match [on(false), on(true)] {
            [Some(right), Some(left)] => deeper(right, left),
            [one, other] => one.or(other).unwrap_or_else(|| self.contact(point, radius)),
        }
    }

    /// Return the nearest gap to a cylinder of `radius` \[m\] at `point` in the sprocket's frame \[m\], and the contact in it, whose normal is
    /// in that frame.
    pub(crate) fn contact_in_sprocket(&self, point: Vec2, radius: f64) -> (u32, ToothContact) {
        let gap = self.gap_towards(point);
        // Frame of the gap: v points radially outward through the gap, u is v turned clockwise.
        let v = self.gap_direction(gap);
        let u = Vec2::new(v.y, -v.x);
        let place = Vec2::new(point.dot(&u), point.dot(&v) - self.seat_center_radius);
        let found = self.contact_in(gap, place, radius);
        let normal = found.normal.x * u + found.normal.y * v;
        (gap, ToothContact { normal, ..found })
    }

    /// Return the contact with a given surface, extended past its ends, of the flank on the side of `point`.
    #[must_use]
    pub fn contact_with(&self, surface: Surface, point: Vec2, radius: f64) -> ToothContact {
        self.contact_on(surface, point.x < 0.0, point, radius)
    }

    /// The region of a surface on one flank of a gap, counted from 1 in the direction of +u.
    #[must_use]
    #[allow(clippy::cast_possible_truncation)] // regions are fewer than surfaces
    pub fn region(&self, surface: Surface, left: bool) -> u8 {
        let middle = self.flanks[0].len() as u8;
        let step = self.surfaces[surface.index()].step;
        if left { middle - step } else { middle + step }
    }

    fn contact_on(&self, surface: Surface, left: bool, point: Vec2, radius: f64) -> ToothContact {
        let across = Vec2::new(if left { -point.x } else { point.x }, point.y);
        let piece = &self.surfaces[surface.index()];
        let (penetration, mut normal) = piece.curve.depth(across, radius);
        if left {
            normal.x = -normal.x;
        }
        ToothContact {
            surface,
            region: self.region(surface, left),
            penetration,
            normal,
        }
    }

    /// Return the distance from the sprocket's centre \[m\] beyond which a cylinder of `radius` cannot touch a tooth.
    #[must_use]
    pub fn reach(&self, radius: f64) -> f64 {
        match &self.ansi {
            Some(curves) => curves.reach(self.seat_center_radius, self.gap_angle(), radius),
            None => self.outside_radius + radius,
        }
    }

    /// Return where a cylinder of `radius` \[m\] that touches one surface penetrates another one: both surfaces and the
    /// penetration \[m\]; `None` where it can roll along the whole gap.
    #[must_use]
    pub fn pinch(&self, radius: f64) -> Option<(Surface, f64)> {
        const POINTS: usize = 24;
        const POINTS_OF_OUTLINE: usize = 4 * POINTS;
        let outline = self.half_outline(POINTS_OF_OUTLINE);
        // The half of the outline on the side of the cylinder is the nearer one.
        let deepest = |place: Vec2| {
            let beside = Vec2::new(place.x.abs(), place.y);
            let depths = outline.iter().map(|p| radius - (p - beside).norm());
            depths.fold(f64::NEG_INFINITY, f64::max)
        };
        let axis = self.axis();
        for (number, piece) in (0..).zip(self.whole()) {
            for point in piece.curve.sweep(piece.start, piece.end, POINTS) {
                let tangent = piece.curve.tangent(point);
                let place = point + radius * turned_left(tangent);
                let from_center = place - self.center();
                if from_center.perp(&axis) > 0.0 {
                    continue;
                }
                let depth = deepest(place).max(self.contact(place, radius).penetration);
                if depth > JAMMED * radius {
                    return Some((Surface(number), depth));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Blank, Damage, OutlinePiece, Seat};

    fn paper() -> ToothProfile {
        ToothProfile::ansi(12.7, 7.9375, 17, Seat::BottomDiameter)
    }

    #[test]
    fn a_roller_of_the_chain_rolls_along_the_whole_gap() {
        for teeth in [9, 17, 60] {
            let p = ToothProfile::ansi(12.7, 7.9375, teeth, Seat::PitchCircle);
            let seat = p.ansi_curves().unwrap().seating.radius;
            for share in [0.2, 0.8, 0.999] {
                assert_eq!(p.pinch(share * seat), None, "{teeth} {share}");
            }
        }
    }

    #[test]
    fn a_roller_larger_than_the_seat_penetrates_the_working_curves_beside_it() {
        // Touching the bottom, its centre is higher than the seat's by the difference d of their radii.
        let p = paper();
        let curves = *p.ansi_curves().unwrap();
        let seat = curves.seating.radius;
        for share in [1.001, 1.02] {
            let radius = share * seat;
            let (surface, depth) = p.pinch(radius).unwrap();
            assert_eq!(surface, Surface::SEATING);
            let from_working = Vec2::new(0.0, radius - seat) - curves.working.center;
            let expected = from_working.norm() + radius - curves.working.radius;
            assert!((depth - expected).abs() < 1e-12, "{share}: {depth}");
        }
        // At one end of the seat it is 2 d cos² A = 1.224 d deep at the other one; 1e-4 of its radius are permitted.
        assert_eq!(p.pinch((1.0 + 7.5e-5) * seat), None);
        assert!(p.pinch((1.0 + 9e-5) * seat).is_some());
    }

    #[test]
    fn a_roller_is_pinched_between_flanks_that_come_nearer_to_each_other() {
        // Flanks at f towards the middle: at the end of the flank both are 2 X cos f apart at the roller's centre.
        let blank = Blank {
            pitch: 12.7,
            roller_diameter: 8.0,
            teeth: 17,
            seat: Seat::PitchCircle,
            outside_radius: 37.5,
            edge_radius: 0.2,
        };
        let (seat, lean) = (4.0, 0.1_f64);
        let p = ToothProfile::straight(&blank, seat, -lean).unwrap();
        let end = p.whole()[1].end;
        let radius = 3.9;
        let place = end + radius * Vec2::new(-lean.cos(), -lean.sin());
        // The lines have the distance 4 from the seat's centre, less the rise of the roller's centre.
        let to_left = seat + place.x * lean.cos() - place.y * lean.sin();
        let (surface, depth) = p.pinch(radius).unwrap();
        assert_eq!(surface, Surface(1));
        assert!((depth - (radius - to_left)).abs() < 1e-12, "{depth}");
        assert_eq!(p.pinch(3.0), None);
    }

    #[test]
    fn in_the_middle_of_a_gap_the_right_flank_is_taken() {
        let damaged = |teeth: &[u32]| {
            let damage: Vec<_> = teeth
                .iter()
                .map(|&tooth| Damage { tooth, height: 0.6 })
                .collect();
            paper().with_damage(&damage, 0.2).unwrap()
        };
        // The seat of the stump on the right, beside a whole tooth on the left.
        let p = damaged(&[2]);
        let seated = p.contact_in(3, Vec2::new(0.0, -0.5), 3.0);
        assert_eq!(seated.surface.index(), p.damaged().next().unwrap().1.start);
        // Above the seat between two stumps, both flanks are equally deep.
        let p = damaged(&[2, 3]);
        let between = p.contact_in(3, Vec2::new(0.0, 3.0), 3.0);
        assert!(between.normal.x > 0.0 && between.region > 4, "{between:?}");
    }

    #[test]
    fn a_roller_on_a_wide_bottom_meets_the_flank_before_it_rolls_into_a_fillet() {
        // Bottom of radius 50, fillet of 0.3 and a convex flank of 10. The bottom is nearest to the roller, but the flank is deeper.
        let (bottom, turn, fillet, flank) = (50.0, 0.03_f64, 0.3, 10.0);
        let lowest = Vec2::new(0.0, 30.5);
        let middle = lowest + bottom * Vec2::y();
        let down = |angle: f64| Vec2::new(angle.sin(), -angle.cos());
        let corner = middle + bottom * down(turn);
        let hollow = corner - fillet * down(turn);
        let normal = crate::geometry::unit(-0.25);
        let bend = hollow + fillet * normal;
        let round = bend + flank * normal;
        let piece = |start: Vec2, end: Vec2, center: Vec2| OutlinePiece {
            start,
            end,
            center: Some(center),
        };
        let pieces = [
            piece(lowest, corner, middle),
            piece(corner, bend, hollow),
            piece(bend, round + flank * crate::geometry::unit(1.9), round),
        ];
        let p = ToothProfile::custom(12.7, 17, &pieces, Some((37.0, 0.2))).unwrap();
        // 24 places on the bottom, of which the first is taken that is too deep. Points of the flank are 0.09 apart: on circles
        // of 2 and 10 they are off by up to s²/8 (1/2 + 1/10).
        let radius = 2.0;
        let depths = (0..24).map(|i| {
            let place = middle + (bottom - radius) * down(turn * f64::from(i) / 23.0);
            flank + radius - (round - place).norm()
        });
        let expected = depths
            .into_iter()
            .find(|&depth| depth > 1e-4 * radius)
            .unwrap();
        let (surface, depth) = p.pinch(radius).unwrap();
        assert_eq!(surface, Surface::SEATING);
        assert!((depth - expected).abs() < 6e-4, "{depth} {expected}");
        // A thin one rolls through the fillet.
        assert_eq!(p.pinch(0.29), None);
    }
}
