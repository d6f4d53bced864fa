//! The belt line: the closed line of tangents and arcs round any number of wheels, inside or outside of it.
//!
//! Wheels are in the order along the belt, which runs counterclockwise. A wheel inside lies on the left of the belt and
//! turns counterclockwise; a wheel outside lies on the right and turns clockwise.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::geometry::{Vec2, turned_left};

/// Angle below a full turn from which on a wrap counts as none \[rad\]: rounding must not make a wheel that is only touched a full turn.
pub(crate) const WRAP_ROUNDING: f64 = 1e-9;
/// Deviation of the winding number from one that counts as none: other loops differ by a whole turn.
const TURNS_ROUNDING: f64 = 1e-6;

/// Side of the loop on which a wheel lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Side {
    /// Inside the loop, as most sprockets; it turns with the driver.
    #[default]
    Inside,
    /// Outside the loop: a reverse idler, which turns against the driver.
    Outside,
}

impl Side {
    /// Return the name in descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Inside => "inside",
            Self::Outside => "outside",
        }
    }

    /// Return +1 inside, -1 outside: the sense of rotation for a counterclockwise chain.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Inside => 1.0,
            Self::Outside => -1.0,
        }
    }
}

/// A wheel of a belt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulley {
    /// Centre \[m\].
    pub center: Vec2,
    /// Radius of the belt's circle \[m\].
    pub radius: f64,
    /// Side of the belt.
    pub side: Side,
}

/// A straight span of the belt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Tangent point on its first wheel \[m\].
    pub from: Vec2,
    /// Tangent point on the next wheel \[m\].
    pub to: Vec2,
    /// Unit vector from the first to the second tangent point.
    pub direction: Vec2,
    /// Length \[m\].
    pub length: f64,
}

/// A belt round wheels.
#[derive(Debug, Clone, PartialEq)]
pub struct Belt {
    /// Span `i` leads from wheel `i` to the next one.
    pub spans: Vec<Span>,
    /// Wrap of each wheel \[rad\].
    pub wraps: Vec<f64>,
    /// Winding number, counterclockwise positive: 1 for a loop without crossings.
    pub turns: f64,
    /// Length \[m\].
    pub length: f64,
}

/// Two wheels without a common tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoTangent {
    /// Their indices in the order.
    pub wheels: [usize; 2],
    /// Distance of their centres \[m\].
    pub distance: f64,
    /// Lower bound of that distance \[m\].
    pub needed: f64,
}

impl Belt {
    /// Return the belt round `pulleys`, in the order along the belt.
    ///
    /// The common tangent of two wheels at distance L, with radii r counted negative for a wheel outside, is turned by
    /// -asin((r₂ - r₁)/L) from the line of centres.
    ///
    /// # Errors
    /// When two consecutive wheels are too near to have a common tangent.
    pub fn around(pulleys: &[Pulley]) -> Result<Self, NoTangent> {
        let n = pulleys.len();
        let mut spans = Vec::with_capacity(n);
        for (i, from) in pulleys.iter().enumerate() {
            let next = (i + 1) % n;
            spans.push(
                tangent(from, &pulleys[next]).map_err(|(distance, needed)| NoTangent {
                    wheels: [i, next],
                    distance,
                    needed,
                })?,
            );
        }
        let mut wraps = Vec::with_capacity(n);
        for (i, pulley) in pulleys.iter().enumerate() {
            let [before, after] = [spans[(i + n - 1) % n], spans[i]].map(|span| span.direction);
            let turn = before.perp(&after).atan2(before.dot(&after));
            let wrap = (pulley.side.sign() * turn).rem_euclid(TAU);
            wraps.push(if wrap > TAU - WRAP_ROUNDING {
                0.0
            } else {
                wrap
            });
        }
        let turned = pulleys.iter().zip(&wraps).map(|(p, w)| p.side.sign() * w);
        let arcs = pulleys.iter().zip(&wraps).map(|(p, w)| p.radius * w);
        Ok(Self {
            turns: turned.sum::<f64>() / TAU,
            length: spans.iter().map(|span| span.length).sum::<f64>() + arcs.sum::<f64>(),
            spans,
            wraps,
        })
    }

    /// Return whether the winding number is one.
    #[must_use]
    pub fn is_simple(&self) -> bool {
        (self.turns - 1.0).abs() < TURNS_ROUNDING
    }

    /// Return the force of a belt tension of 1 N in both spans on wheel `i` \[N\].
    #[must_use]
    pub fn pull(&self, i: usize) -> Vec2 {
        let n = self.spans.len();
        self.spans[i].direction - self.spans[(i + n - 1) % n].direction
    }
}

/// Return the common tangent of two wheels, or their distance and its lower bound.
fn tangent(from: &Pulley, to: &Pulley) -> Result<Span, (f64, f64)> {
    let between = to.center - from.center;
    let distance = between.norm();
    let [r1, r2] = [from, to].map(|pulley| pulley.side.sign() * pulley.radius);
    let step = r2 - r1;
    if distance <= step.abs() || distance == 0.0 {
        return Err((distance, step.abs()));
    }
    let along = between / distance;
    let sin = -step / distance;
    let cos = (1.0 - sin * sin).sqrt();
    let direction = cos * along + sin * turned_left(along);
    let right = -turned_left(direction);
    Ok(Span {
        from: from.center + r1 * right,
        to: to.center + r2 * right,
        direction,
        length: distance * cos,
    })
}

/// Return the distance of `point` from the span between its ends \[m\].
#[must_use]
pub fn distance_from(span: &Span, point: Vec2) -> f64 {
    let along = (point - span.from)
        .dot(&span.direction)
        .clamp(0.0, span.length);
    (point - span.from - along * span.direction).norm()
}

/// Return whether two spans cross.
#[must_use]
pub fn cross(a: &Span, b: &Span) -> bool {
    let side = |span: &Span, point: Vec2| span.direction.perp(&(point - span.from));
    side(a, b.from) * side(a, b.to) < 0.0 && side(b, a.from) * side(b, a.to) < 0.0
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::geometry::unit;

    fn pulley(x: f64, y: f64, radius: f64, side: Side) -> Pulley {
        Pulley {
            center: Vec2::new(x, y),
            radius,
            side,
        }
    }

    #[test]
    fn two_wheels_have_the_textbook_length() {
        let (distance, r1, r2): (f64, f64, f64) = (0.5, 0.1, 0.04);
        let belt = Belt::around(&[
            pulley(0.0, 0.0, r1, Side::Inside),
            pulley(distance, 0.0, r2, Side::Inside),
        ])
        .unwrap();
        let beta = ((r1 - r2) / distance).asin();
        let expected = 2.0 * distance * beta.cos() + PI * (r1 + r2) + 2.0 * beta * (r1 - r2);
        assert!((belt.length - expected).abs() < 1e-14);
        assert!((belt.wraps[0] - (PI + 2.0 * beta)).abs() < 1e-14);
        assert!(belt.is_simple());
    }

    #[test]
    fn three_equal_wheels_have_the_length_of_their_triangle_and_one_circle() {
        let corners = [(0.0, 0.0), (0.4, 0.0), (0.1, 0.3)];
        let pulleys = corners.map(|(x, y)| pulley(x, y, 0.05, Side::Inside));
        let belt = Belt::around(&pulleys).unwrap();
        let sides: f64 = (0..3)
            .map(|i| (pulleys[(i + 1) % 3].center - pulleys[i].center).norm())
            .sum();
        assert!((belt.length - (sides + TAU * 0.05)).abs() < 1e-14);
    }

    #[test]
    fn a_wheel_that_presses_a_straight_part_inward_lengthens_it_as_its_crossed_tangents_say() {
        // Midway between two equal wheels, its edge `depth` below the upper straight part.
        let (half, r, idler, depth): (f64, f64, f64, f64) = (0.3, 0.06, 0.03, 0.02);
        let belt = Belt::around(&[
            pulley(-half, 0.0, r, Side::Inside),
            pulley(half, 0.0, r, Side::Inside),
            pulley(0.0, r - depth + idler, idler, Side::Outside),
        ])
        .unwrap();
        let (rise, run) = (r - depth + idler, half);
        let apart = rise.hypot(run);
        // Crossed tangent: its angle to the line of centres, and that line's own.
        let wrap = 2.0 * (((r + idler) / apart).asin() - (rise / run).atan());
        let straight = (apart * apart - (r + idler).powi(2)).sqrt();
        let expected = 2.0 * half + 2.0 * straight + idler * wrap + r * (TAU + wrap);
        assert!((belt.wraps[2] - wrap).abs() < 1e-14);
        assert!((belt.length - expected).abs() < 1e-14);
        assert!(belt.is_simple());
    }

    #[test]
    fn listed_the_wrong_way_round_a_belt_does_not_go_round_once() {
        let corners = [(0.0, 0.0), (0.1, 0.3), (0.4, 0.0)];
        let belt = Belt::around(&corners.map(|(x, y)| pulley(x, y, 0.05, Side::Inside))).unwrap();
        assert!(!belt.is_simple());
    }

    #[test]
    fn wheels_within_one_another_have_no_tangent() {
        let fault = Belt::around(&[
            pulley(0.0, 0.0, 0.1, Side::Inside),
            pulley(0.05, 0.0, 0.02, Side::Inside),
        ])
        .unwrap_err();
        assert_eq!(fault.wheels, [0, 1]);
        assert!((fault.needed - 0.08).abs() < 1e-15);
    }

    #[test]
    fn a_wheel_that_is_only_touched_has_no_wrap_in_any_direction_of_the_belt() {
        let (r, half) = (0.05, 0.3);
        for i in 0..40 {
            let along = unit(0.16 * f64::from(i));
            // A wheel outside touches the same side of the belt as those inside.
            let wheel = |place: f64, side| {
                let across = if side == Side::Outside { -2.0 * r } else { 0.0 };
                Pulley {
                    center: place * along + across * turned_left(along),
                    radius: r,
                    side,
                }
            };
            for side in [Side::Inside, Side::Outside] {
                let belt = Belt::around(&[
                    wheel(-half, Side::Inside),
                    wheel(0.0, side),
                    wheel(half, Side::Inside),
                ])
                .unwrap();
                // Tangents of 0.3 m are rounded to 1e-16 of their length, which is far below the limit of a wrap.
                assert!(belt.wraps[1] < 1e-9, "{i}: {}", belt.wraps[1]);
                assert!((belt.length - (4.0 * half + TAU * r)).abs() < 1e-9);
                assert!(belt.is_simple());
            }
        }
    }

    #[test]
    fn belt_tension_pulls_a_wheel_by_twice_the_sine_of_half_its_wrap() {
        let belt = Belt::around(&[
            pulley(0.0, 0.0, 0.06, Side::Inside),
            pulley(0.4, 0.0, 0.04, Side::Inside),
            pulley(0.2, 0.05, 0.02, Side::Outside),
        ])
        .unwrap();
        for (i, wrap) in belt.wraps.iter().enumerate() {
            assert!((belt.pull(i).norm() - 2.0 * (0.5 * wrap).sin()).abs() < 1e-14);
        }
        assert!((0..3).map(|i| belt.pull(i)).sum::<Vec2>().norm() < 1e-15);
        // Towards the other wheels; the wheel outside is pushed up.
        assert!(belt.pull(0).x > 0.0 && belt.pull(1).x < 0.0 && belt.pull(2).y > 0.0);
    }

    #[test]
    fn wheels_that_touch_from_inside_or_share_a_centre_have_no_tangent() {
        for (x, r1, r2, needed) in [
            (0.5, 0.75, 0.25, 0.5),
            (0.5, 0.25, 0.75, 0.5),
            (0.0, 0.25, 0.25, 0.0),
        ] {
            let fault = Belt::around(&[
                pulley(0.0, 0.0, r1, Side::Inside),
                pulley(x, 0.0, r2, Side::Inside),
            ])
            .unwrap_err();
            assert_eq!((fault.distance, fault.needed), (x, needed));
        }
        // A wheel on either side: its circle may not reach the other one.
        let fault = Belt::around(&[
            pulley(0.0, 0.0, 0.25, Side::Inside),
            pulley(0.5, 0.0, 0.5, Side::Outside),
        ])
        .unwrap_err();
        assert_eq!((fault.distance, fault.needed), (0.5, 0.75));
    }

    /// The span between two points.
    fn span(from: (f64, f64), to: (f64, f64)) -> Span {
        let [from, to] = [from, to].map(|(x, y)| Vec2::new(x, y));
        let length = (to - from).norm();
        Span {
            from,
            to,
            direction: (to - from) / length,
            length,
        }
    }

    #[test]
    fn a_point_is_as_far_from_a_span_as_from_its_line_or_its_nearer_end() {
        // From (1, 1) along 3:4 for 10 m.
        let slope = span((1.0, 1.0), (9.0, 7.0));
        for (place, expected) in [
            (Vec2::new(1.0 + 3.2 - 1.2, 1.0 + 2.4 + 1.6), 2.0),
            (Vec2::new(1.0 + 3.2 + 1.2, 1.0 + 2.4 - 1.6), 2.0),
            (Vec2::new(-2.0, -3.0), 5.0),
            (Vec2::new(12.0, 11.0), 5.0),
        ] {
            assert!((distance_from(&slope, place) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn spans_cross_only_where_each_has_an_end_on_both_sides_of_the_other() {
        let one = span((1.0, 1.0), (5.0, 4.0));
        for (other, crosses) in [
            (span((1.0, 4.0), (5.0, 1.0)), true),
            (span((5.0, 1.0), (1.0, 4.0)), true),
            // Its line crosses, behind or before its ends.
            (span((1.0, 4.0), (2.0, 3.25)), false),
            (span((4.0, 1.75), (5.0, 1.0)), false),
            // It passes the ends of the first.
            (span((0.0, 1.0), (1.0, 0.0)), false),
            (span((5.0, 5.0), (6.0, 4.0)), false),
            (span((1.0, 2.0), (5.0, 5.0)), false),
        ] {
            assert_eq!(cross(&one, &other), crosses, "{other:?}");
            assert_eq!(cross(&other, &one), crosses, "{other:?}");
        }
    }

    #[test]
    fn a_span_that_ends_on_another_one_does_not_cross_it() {
        let level = span((0.0, 0.0), (4.0, 0.0));
        for upright in [
            span((2.0, 0.0), (2.0, 3.0)),
            span((2.0, 3.0), (2.0, 0.0)),
            span((2.0, 0.0), (2.0, -3.0)),
            span((2.0, -3.0), (2.0, 0.0)),
        ] {
            assert!(!cross(&level, &upright) && !cross(&upright, &level));
        }
    }
}
