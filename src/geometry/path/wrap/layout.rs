//! Both sprockets in their places: shift of the seats and centre distance at which strands of given pitches close.

use std::f64::consts::PI;

use super::{Path, Split, Strand, Wheel};
use crate::geometry::path::bow::Bow;
use crate::geometry::{Vec2, turned_left, unit};

/// Both sprockets in their places, for strands of given pitches.
pub(super) struct Layout {
    pub(super) pitch: f64,
    pub(super) wheels: [Wheel; 2],
    pub(super) split: Split,
}

impl Layout {
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
            if !(shift.is_finite() && distance.is_finite()) {
                return None;
            }
        }
        (best < 1e-12 * distance).then_some(solution)
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
        (best < 1e-12).then_some(solution)
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
