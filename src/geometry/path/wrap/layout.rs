//! Both sprockets in their places: shift of the seats and centre distance at which strands of given pitches close.

use std::f64::consts::PI;

use super::{CLOSED, CLOSED_SHARE, Path, Split, Strand, Wheel};
use crate::geometry::path::bow::Bow;
use crate::geometry::{Vec2, turned_left, unit};

/// Both sprockets in their places, for strands of given pitches.
pub(super) struct WrapLayout {
    pub(super) pitch: f64,
    pub(super) wheels: [Wheel; 2],
    pub(super) split: Split,
}

impl WrapLayout {
    /// First seat angles for a shift \[m of arc\] of both sprockets that shortens the upper and lengthens the lower strand.
    fn first_seats(&self, shift: f64) -> [f64; 2] {
        let [first, second] = self.wheels;
        let [k1, k2] = self.split.seated.map(f64::from);
        [
            PI - 0.5 * k1 * first.gap_angle() - shift / first.hinge_radius,
            -0.5 * k2 * second.gap_angle() + shift / second.hinge_radius,
        ]
    }

    fn seat(&self, sprocket: usize, first_seat: f64, index: u32, center_distance: f64) -> Vec2 {
        let wheel = self.wheels[sprocket];
        let center = if sprocket == 0 { 0.0 } else { center_distance };
        Vec2::new(center, 0.0)
            + wheel.hinge_radius * unit(first_seat + f64::from(index) * wheel.gap_angle())
    }

    /// First and last hinge of a strand, in the direction of the path.
    fn strand_ends(&self, strand: Strand, seats: [f64; 2], center_distance: f64) -> (Vec2, Vec2) {
        let [k1, k2] = self.split.seated;
        match strand {
            Strand::Upper => (
                self.seat(1, seats[1], k2, center_distance),
                self.seat(0, seats[0], 0, center_distance),
            ),
            Strand::Lower => (
                self.seat(0, seats[0], k1, center_distance),
                self.seat(1, seats[1], 0, center_distance),
            ),
        }
    }

    /// Straight length of a strand \[m\] and its derivatives by shift and by centre distance.
    fn span(&self, strand: Strand, shift: f64, center_distance: f64) -> (f64, f64, f64) {
        let seats = self.first_seats(shift);
        let (from, to) = self.strand_ends(strand, seats, center_distance);
        let along = to - from;
        let length = along.norm();
        let e = along / length;
        let center = Vec2::new(center_distance, 0.0);
        // One metre of shift turns each sprocket by 1/radius: the first clockwise, the second counterclockwise.
        let by_turn = |p: Vec2, c: Vec2, radius: f64| turned_left(p - c) / radius;
        let [r1, r2] = self.wheels.map(|w| w.hinge_radius);
        let (by_shift, by_center) = match strand {
            Strand::Upper => (
                e.dot(&(-by_turn(to, Vec2::zeros(), r1) - by_turn(from, center, r2))),
                -e.x,
            ),
            Strand::Lower => (
                e.dot(&(by_turn(to, center, r2) + by_turn(from, Vec2::zeros(), r1))),
                e.x,
            ),
        };
        (length, by_shift, by_center)
    }

    fn length(&self, strand: Strand) -> f64 {
        f64::from(self.split.strands[strand as usize]) * self.pitch
    }

    /// Shift and centre distance at which both strands are straight and taut (Newton from the belt's values).
    pub(super) fn close(&self, center_distance: f64) -> Option<(f64, f64)> {
        let (mut shift, mut distance) = (0.0, center_distance);
        let mut best = f64::INFINITY;
        let mut solution = (shift, distance);
        for _ in 0..60 {
            let (upper, a, b) = self.span(Strand::Upper, shift, distance);
            let (lower, c, d) = self.span(Strand::Lower, shift, distance);
            let (f, g) = (
                upper - self.length(Strand::Upper),
                lower - self.length(Strand::Lower),
            );
            let residual = f.abs().max(g.abs());
            if residual < best {
                (best, solution) = (residual, (shift, distance));
            }
            let det = a * d - b * c;
            shift -= (d * f - b * g) / det;
            distance -= (a * g - c * f) / det;
            if ![shift, distance].into_iter().all(f64::is_finite) {
                return None;
            }
        }
        (best < CLOSED_SHARE * distance).then_some(solution)
    }

    /// Shift at which `residual(shift)`, with its slope, vanishes.
    fn solve_shift(&self, residual: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
        let (mut shift, mut best, mut solution) = (0.0, f64::INFINITY, 0.0);
        for _ in 0..60 {
            let (value, slope) = residual(shift);
            if value.abs() < best {
                (best, solution) = (value.abs(), shift);
            }
            shift -= value / slope;
            if !shift.is_finite() || shift.abs() > 3.0 * self.pitch {
                break;
            }
        }
        (best < CLOSED).then_some(solution)
    }

    /// Shift at which `strand` is straight and taut.
    pub(super) fn tighten(&self, strand: Strand, center_distance: f64) -> Option<f64> {
        self.solve_shift(|shift| {
            let (length, by_shift, _) = self.span(strand, shift, center_distance);
            (length - self.length(strand), by_shift)
        })
    }

    /// Shift at which both strands are stretched alike, relative to their lengths.
    pub(super) fn balance(&self, center_distance: f64) -> Option<f64> {
        self.solve_shift(|shift| {
            let (upper, a, _) = self.span(Strand::Upper, shift, center_distance);
            let (lower, b, _) = self.span(Strand::Lower, shift, center_distance);
            let [u, l] = [Strand::Upper, Strand::Lower].map(|s| self.length(s));
            (upper / u - lower / l, a / u - b / l)
        })
    }

    pub(super) fn path(&self, shift: f64, center_distance: f64) -> Path {
        let first_seat = self.first_seats(shift);
        let mut path = Path {
            center_distance,
            split: self.split,
            first_seat,
            hinge_radius: self.wheels.map(|wheel| wheel.hinge_radius),
            spans: [0.0; 2],
            slack: [0.0; 2],
            sag: [0.0; 2],
            hinges: Vec::new(),
            seat_of: Vec::new(),
        };
        for (sprocket, strand) in [(0, Strand::Lower), (1, Strand::Upper)] {
            for index in 0..=self.split.seated[sprocket] {
                path.hinges
                    .push(self.seat(sprocket, first_seat[sprocket], index, center_distance));
                path.seat_of.push(Some(sprocket));
            }
            let (from, to) = self.strand_ends(strand, first_seat, center_distance);
            let links = self.split.strands[strand as usize];
            let span = (to - from).norm();
            let bow = Bow::new(span, links, self.pitch);
            path.spans[strand as usize] = span;
            path.slack[strand as usize] = self.length(strand) - span;
            path.sag[strand as usize] = bow.height();
            for index in 1..links {
                path.hinges.push(bow.point(from, to, index));
                path.seat_of.push(None);
            }
        }
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Newton's method ends at rounding errors: 1e-16 of the distance, times the slope of a strand's length, below 5.
    /// Two wheels of 16 teeth with eight pitches on each.
    fn layout(pitch: f64, strands: [u32; 2]) -> WrapLayout {
        WrapLayout {
            pitch,
            wheels: [Wheel::on_pitch_circle(pitch, 16); 2],
            split: Split {
                seated: [8, 8],
                strands,
            },
        }
    }

    #[test]
    fn a_strand_is_taut_at_the_shift_that_turns_both_wheels_towards_it() {
        // Each end moves by r sin(a) along the strand: 20 pitches less 2 r sin(a) are left, at the arc r a.
        let pitch = 0.0127;
        let radius = pitch / (2.0 * (PI / 16.0).sin());
        for (links, strand) in [
            (16, Strand::Upper),
            (18, Strand::Upper),
            (16, Strand::Lower),
        ] {
            let mut strands = [40 - links; 2];
            strands[strand as usize] = links;
            let shorter = 0.5 * f64::from(20 - links) * pitch;
            let arc = radius * (shorter / radius).asin();
            let sign = if strand == Strand::Upper { 1.0 } else { -1.0 };
            let found = layout(pitch, strands)
                .tighten(strand, 20.0 * pitch)
                .unwrap();
            assert!((found - sign * arc).abs() < 1e-12, "{links}: {found} {arc}");
        }
        // Fifteen links need 3.46 pitches of shift; at most three are tried.
        let arc = radius * (2.5 * pitch / radius).asin();
        assert!(arc > 3.0 * pitch && arc < 3.5 * pitch);
        assert_eq!(
            layout(pitch, [15, 25]).tighten(Strand::Upper, 20.0 * pitch),
            None
        );
    }

    #[test]
    fn both_strands_close_in_any_unit_of_length() {
        for pitch in [0.0127, 1e7, 1e-6] {
            let (shift, distance) = layout(pitch, [20, 20]).close(21.0 * pitch).unwrap();
            assert!(shift.abs() < 1e-12 * pitch);
            assert!((distance - 20.0 * pitch).abs() < 1e-12 * pitch);
        }
    }

    #[test]
    fn strands_that_differ_by_more_than_four_radii_close_at_no_distance() {
        // An end is at most a radius from its wheel's centre: strands of 1 and 40 pitches differ by 15 radii.
        let pitch = 0.0127;
        for distance in [5.0, 20.0, 40.0] {
            assert_eq!(layout(pitch, [1, 40]).close(distance * pitch), None);
        }
    }

    #[test]
    fn steep_strands_of_one_pitch_close_as_the_sides_of_their_triangles() {
        // 57 of 60 teeth leave 9 degrees above and below the line of centres, one of 9 teeth 20 degrees.
        let pitch = 0.0127;
        let wheels = [60, 9].map(|teeth| Wheel::on_pitch_circle(pitch, teeth));
        let split = Split {
            seated: [57, 1],
            strands: [1, 1],
        };
        let layout = WrapLayout {
            pitch,
            wheels,
            split,
        };
        let [first, second] = [(0, 9.0_f64), (1, 20.0)]
            .map(|(i, degrees)| wheels[i].hinge_radius * unit(degrees.to_radians()));
        let rise = second.y - first.y;
        let expected = first.x + (pitch * pitch - rise * rise).sqrt() - second.x;
        let (shift, distance) = layout.close(8.3 * pitch).unwrap();
        assert!(shift.abs() < 1e-13 * pitch);
        assert!((distance - expected).abs() < 1e-12 * pitch);
    }

    #[test]
    fn level_strands_close_from_any_first_distance() {
        // Their lengths are linear in the distance, so that Newton's method is exact.
        let pitch = 0.0127;
        let (shift, distance) = layout(pitch, [20, 20]).close(1e6 * pitch).unwrap();
        assert!(shift.abs() < 1e-12 * pitch && (distance - 20.0 * pitch).abs() < 1e-12 * pitch);
    }

    #[test]
    fn a_shift_of_three_pitches_and_a_residual_below_the_limit_are_permitted() {
        let layout = layout(0.0127, [20, 20]);
        let limit = 3.0 * layout.pitch;
        assert_eq!(
            layout.solve_shift(|shift| (shift - limit, 1.0)),
            Some(limit)
        );
        assert_eq!(layout.solve_shift(|_| (1e-12, 1e3)), None);
        // Of equal residuals the first one is kept.
        assert_eq!(layout.solve_shift(|_| (1e-13, 1e3)), Some(0.0));
    }
}
