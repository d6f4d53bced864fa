//! Chain polygon round any number of wheels: seated pitches, length of each strand, position of every
//! hinge.
//!
//! All strands but one are straight and taut; the slack is in that one. The chain is laid strand by strand from the
//! wheel after the slack strand. The seats of a wheel end at the one nearest to the tangent point of the belt line, and a
//! strand has the number of pitches that ends nearest to the next tangent point. Its end is the point
//! of that wheel's circle at exactly this number of pitches: the lengths of the strands include the polygon action.

use std::f64::consts::{PI, TAU};

use super::belt::{Belt, NoTangent, Pulley, Side};
use super::bow::Bow;
use super::wrap::Wheel;
use crate::geometry::{Vec2, turned_left, unit};
use crate::math::bisected;

/// A wheel with its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedWheel {
    /// Teeth and radius of the seated hinges.
    pub wheel: Wheel,
    /// Centre \[m\].
    pub center: Vec2,
    /// Side of the chain.
    pub side: Side,
}

impl PlacedWheel {
    fn pulley(&self) -> Pulley {
        Pulley {
            center: self.center,
            radius: self.wheel.hinge_radius,
            side: self.side,
        }
    }

    /// Return the angle of seat `index`, counted along the chain \[rad\].
    fn seat_angle(&self, first: f64, index: u32) -> f64 {
        first + self.side.sign() * f64::from(index) * self.wheel.gap_angle()
    }

    fn point(&self, angle: f64) -> Vec2 {
        self.center + self.wheel.hinge_radius * unit(angle)
    }
}

/// Wheels in the order along the chain path, counterclockwise.
#[derive(Debug, Clone)]
pub struct WheelSequence {
    /// Pitch of the chain \[m\].
    pub pitch: f64,
    /// Number of links.
    pub links: u32,
    /// The wheels.
    pub wheels: Vec<PlacedWheel>,
    belt: Belt,
}

/// A chain polygon; strand `i` leads from wheel `i` to the next one.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Pitches seated on each wheel.
    pub seated: Vec<u32>,
    /// Pitches in each strand.
    pub strands: Vec<u32>,
    /// Angle of the first seated hinge of each wheel, seen from its centre \[rad\].
    pub first_seat: Vec<f64>,
    /// Straight distance between the ends of each strand \[m\].
    pub spans: Vec<f64>,
    /// Chain length minus straight distance of each strand \[m\].
    pub slack: Vec<f64>,
    /// Sag of each strand \[m\].
    pub sag: Vec<f64>,
    /// Elongation of the links of taut strands that closes the chain, relative to the pitch; 0 for a chain that is long
    /// enough.
    pub stretch: f64,
    /// Largest distance of a first or last seat from the tangent point of the belt line, in pitches.
    pub off_tangent: f64,
    /// Hinge positions \[m\]: those on the first wheel first.
    pub hinges: Vec<Vec2>,
    /// Wheel on which each hinge is seated.
    pub seat_of: Vec<Option<usize>>,
}

/// Numbers of pitches and seats before the hinges are placed.
struct SeatPlan {
    seated: Vec<u32>,
    strands: Vec<u32>,
    first_seat: Vec<f64>,
    off_tangent: f64,
    /// Length of the slack strand minus the distance of its ends \[m\].
    spare: f64,
}

/// Return the angle in the range from -π to π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

impl WheelSequence {
    /// Return the sequence of wheels of a chain.
    ///
    /// # Errors
    /// When two consecutive wheels have no common tangent.
    pub fn new(pitch: f64, links: u32, wheels: Vec<PlacedWheel>) -> Result<Self, NoTangent> {
        let pulleys: Vec<Pulley> = wheels.iter().map(PlacedWheel::pulley).collect();
        Ok(Self {
            belt: Belt::around(&pulleys)?,
            pitch,
            links,
            wheels,
        })
    }

    /// Return the angle at which the belt line reaches (or leaves) wheel `i`, seen from its centre \[rad\].
    fn tangent_angle(&self, i: usize, leaving: bool) -> f64 {
        let n = self.wheels.len();
        let span = &self.belt.spans[if leaving { i } else { (i + n - 1) % n }];
        let outward = -self.wheels[i].side.sign() * turned_left(span.direction);
        outward.y.atan2(outward.x)
    }

    /// Lay the chain with the slack in strand `slack`. Its first seat after that strand is `shift` pitches past the tangent point;
    /// links of the taut strands are longer by the share `stretch`.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of pitches, not negative
    fn lay(&self, slack: usize, shift: f64, stretch: f64) -> Option<SeatPlan> {
        let n = self.wheels.len();
        let link = self.pitch * (1.0 + stretch);
        let mut laid = SeatPlan {
            seated: vec![0; n],
            strands: vec![0; n],
            first_seat: vec![0.0; n],
            off_tangent: shift.abs(),
            spare: 0.0,
        };
        let begin = (slack + 1) % n;
        let gap = |i: usize| self.wheels[i].wheel.gap_angle();
        laid.first_seat[begin] =
            self.tangent_angle(begin, false) + self.wheels[begin].side.sign() * shift * gap(begin);
        let mut used = 0;
        for step in 0..n {
            let i = (begin + step) % n;
            let wheel = &self.wheels[i];
            let sign = wheel.side.sign();
            let past = wrapped(sign * (laid.first_seat[i] - self.tangent_angle(i, false))) / gap(i);
            let last = (self.belt.wraps[i] / gap(i) - past).round();
            if last < 0.0 {
                return None;
            }
            laid.seated[i] = last as u32;
            used += laid.seated[i];
            let beyond = past + last - self.belt.wraps[i] / gap(i);
            laid.off_tangent = laid.off_tangent.max(past.abs()).max(beyond.abs());
            let from = wheel.point(wheel.seat_angle(laid.first_seat[i], laid.seated[i]));
            if i == slack {
                laid.strands[i] = self.links.checked_sub(used).filter(|&left| left > 0)?;
                let to = self.wheels[begin].point(laid.first_seat[begin]);
                laid.spare = f64::from(laid.strands[i]) * link - (to - from).norm();
                break;
            }
            let next = &self.wheels[(i + 1) % n];
            let radius = next.wheel.hinge_radius;
            let back = from - next.center;
            let distance = back.norm();
            let tangent = (distance * distance - radius * radius).max(0.0).sqrt();
            let pitches = (tangent / link).round().max(1.0);
            let length = pitches * link;
            let cos = (distance * distance + radius * radius - length * length)
                / (2.0 * distance * radius);
            if !(-1.0..=1.0).contains(&cos) {
                return None;
            }
            laid.strands[i] = pitches as u32;
            used += laid.strands[i];
            laid.first_seat[(i + 1) % n] = back.y.atan2(back.x) + next.side.sign() * cos.acos();
        }
        Some(laid)
    }

    /// Return the polygon with the slack in strand `slack` and the first seat after it `shift` pitches past the tangent point.
    /// A chain that is too short is stretched in all strands by up to `most` of a pitch per link. `None` where this is not enough.
    #[must_use]
    pub fn polygon(&self, slack: usize, shift: f64, most: f64) -> Option<Polygon> {
        let free = self.lay(slack, shift, 0.0)?;
        if free.spare >= 0.0 {
            return Some(self.place(&free, slack, 0.0));
        }
        // The slack grows with the stretch in proportion to the strands' lengths, until a strand takes another pitch.
        let laid = |stretch: f64| {
            let laid = self.lay(slack, shift, stretch);
            laid.filter(|laid| laid.spare >= 0.0)
        };
        laid(most)?;
        let [_, stretch] = bisected([0.0, most], 60, |stretch| laid(stretch).is_none());
        Some(self.place(&laid(stretch)?, slack, stretch))
    }

    /// Return the slack in strand `slack` \[m\] with all other strands taut; negative for a chain that is too short.
    #[must_use]
    pub fn spare(&self, slack: usize, shift: f64) -> Option<f64> {
        self.lay(slack, shift, 0.0).map(|laid| laid.spare)
    }

    /// Return the largest distance of first and last seats from the tangent points, in pitches.
    #[must_use]
    pub fn off_tangent(&self, slack: usize, shift: f64) -> Option<f64> {
        self.lay(slack, shift, 0.0).map(|laid| laid.off_tangent)
    }

    fn place(&self, laid: &SeatPlan, slack: usize, stretch: f64) -> Polygon {
        let n = self.wheels.len();
        let link = self.pitch * (1.0 + stretch);
        let mut polygon = Polygon {
            seated: laid.seated.clone(),
            strands: laid.strands.clone(),
            first_seat: laid.first_seat.clone(),
            spans: Vec::with_capacity(n),
            slack: Vec::with_capacity(n),
            sag: Vec::with_capacity(n),
            stretch,
            off_tangent: laid.off_tangent,
            hinges: Vec::with_capacity(self.links as usize),
            seat_of: Vec::with_capacity(self.links as usize),
        };
        for (i, wheel) in self.wheels.iter().enumerate() {
            for index in 0..=laid.seated[i] {
                let angle = wheel.seat_angle(laid.first_seat[i], index);
                polygon.hinges.push(wheel.point(angle));
                polygon.seat_of.push(Some(i));
            }
            let next = (i + 1) % n;
            let from = wheel.point(wheel.seat_angle(laid.first_seat[i], laid.seated[i]));
            let to = self.wheels[next].point(laid.first_seat[next]);
            let span = (to - from).norm();
            // Strands other than the slack one are straight in spite of rounding.
            let bow = Bow::new(span, laid.strands[i], if i == slack { link } else { 0.0 });
            polygon.spans.push(span);
            polygon
                .slack
                .push(f64::from(laid.strands[i]) * self.pitch - span);
            polygon.sag.push(bow.height());
            for index in 1..laid.strands[i] {
                polygon.hinges.push(bow.point(from, to, index));
                polygon.seat_of.push(None);
            }
        }
        polygon
    }
}

/// Return the angle at the ends of a bow of this height over this span \[rad\].
#[must_use]
pub fn bow_angle(sag: f64, span: f64) -> f64 {
    (2.0 * (2.0 * sag / span).atan()).min(PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    // Coordinates up to 0.5 m are rounded to 5e-17 m. Bounds of 1e-15 m to 1e-12 m permit sums of tens to thousands of such errors.
    const PITCH: f64 = 0.0127;

    fn wheel(teeth: u32, x: f64, y: f64, side: Side) -> PlacedWheel {
        PlacedWheel {
            wheel: Wheel::on_pitch_circle(PITCH, teeth),
            center: Vec2::new(x, y),
            side,
        }
    }

    fn course(links: u32) -> WheelSequence {
        let wheels = vec![
            wheel(17, 0.0, 0.0, Side::Inside),
            wheel(31, 0.3, -0.04, Side::Inside),
            wheel(13, 0.16, 0.05, Side::Outside),
        ];
        WheelSequence::new(PITCH, links, wheels).unwrap()
    }

    #[test]
    fn neighbouring_hinges_are_one_pitch_apart_and_the_chain_closes() {
        let needed = course(100).belt.length / PITCH;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of links
        let links = 2 * (0.5 * needed + 0.3).ceil() as u32;
        let course = course(links);
        assert!(course.belt.is_simple());
        for slack in 0..3 {
            for shift in [-0.4, 0.0, 0.3] {
                let polygon = course.polygon(slack, shift, 1e-3).unwrap();
                assert_eq!(polygon.hinges.len(), links as usize);
                assert_eq!(polygon.stretch, 0.0);
                let next = polygon.hinges.iter().cycle().skip(1);
                for (a, b) in polygon.hinges.iter().zip(next) {
                    assert!(((a - b).norm() - PITCH).abs() < 1e-13);
                }
                assert!(polygon.slack[slack] > 0.0);
            }
        }
    }

    #[test]
    fn a_chain_a_little_short_is_stretched_alike_in_all_strands() {
        let mut wheels = course(90).wheels;
        let needed = course(90).belt.length / PITCH;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of links
        let links = 2 * (0.5 * needed).floor() as u32;
        // Moved in until nearly taut.
        let taut = |x: f64, wheels: &mut Vec<PlacedWheel>| {
            wheels[1].center.x = x;
            WheelSequence::new(PITCH, links, wheels.clone()).unwrap()
        };
        let (mut low, mut high) = (0.2, 0.3);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let laid = taut(middle, &mut wheels).lay(0, 0.1, 0.0);
            if laid.is_some_and(|laid| laid.spare > 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        let short = taut(high + 1e-4, &mut wheels);
        let polygon = short.polygon(0, 0.1, 1e-2).unwrap();
        assert!(polygon.stretch > 0.0);
        for i in 0..3 {
            let length = f64::from(polygon.strands[i]) * PITCH * (1.0 + polygon.stretch);
            assert!((polygon.spans[i] - length).abs() < 1e-12);
        }
    }

    /// Angle from the tangent point of the belt line to a hinge of wheel `i`, along the chain, in pitches.
    fn past_tangent(course: &WheelSequence, i: usize, tangent: Vec2, hinge: Vec2) -> f64 {
        let wheel = &course.wheels[i];
        let [from, to] = [tangent, hinge].map(|p| p - wheel.center);
        wheel.side.sign() * from.perp(&to).atan2(from.dot(&to)) / wheel.wheel.gap_angle()
    }

    #[test]
    fn seats_begin_and_end_at_the_tangent_points_and_each_strand_has_its_own_length_and_sag() {
        let course = course(102);
        let spans = &course.belt.spans;
        for slack in 0..3 {
            for shift in [-0.4, -0.1, 0.0, 0.3] {
                let polygon = course.polygon(slack, shift, 1e-3).unwrap();
                assert_eq!(polygon.stretch, 0.0);
                let all = polygon.seated.iter().sum::<u32>() + polygon.strands.iter().sum::<u32>();
                assert_eq!(all, 102);
                let mut farthest: f64 = 0.0;
                let mut at = 0;
                for i in 0..3 {
                    let (seats, strand) = (polygon.seated[i] as usize, polygon.strands[i] as usize);
                    let [first, last] = [at, at + seats].map(|k| polygon.hinges[k]);
                    let reached = past_tangent(&course, i, spans[(i + 2) % 3].to, first);
                    let left = past_tangent(&course, i, spans[i].from, last);
                    farthest = farthest.max(reached.abs()).max(left.abs());
                    if i == (slack + 1) % 3 {
                        assert!((reached - shift).abs() < 1e-12);
                    }
                    // The nearest seat is half a pitch away, or less.
                    assert!(left.abs() <= 0.5 + 1e-12 && reached.abs() <= 0.5 + 1e-12);
                    let direction = first - course.wheels[i].center;
                    let turn = polygon.first_seat[i] - direction.y.atan2(direction.x);
                    assert!(wrapped(turn).abs() < 1e-13);
                    let next = at + seats + strand;
                    let span = (polygon.hinges[next % 102] - last).norm();
                    assert!((polygon.spans[i] - span).abs() < 1e-15);
                    let spare = strand as f64 * PITCH - span;
                    assert!((polygon.slack[i] - spare).abs() < 1e-15);
                    let bow = Bow::new(span, polygon.strands[i], PITCH);
                    let sag = if i == slack { bow.height() } else { 0.0 };
                    assert!((polygon.sag[i] - sag).abs() < 1e-6);
                    for k in at..next {
                        let seat = (k <= at + seats).then_some(i);
                        assert_eq!(polygon.seat_of[k], seat);
                        let across = polygon.hinges[k] - last;
                        let off = (polygon.hinges[next % 102] - last).perp(&across) / span;
                        assert!(seat.is_some() || i == slack || off.abs() < 1e-13);
                    }
                    at = next;
                }
                assert!((polygon.off_tangent - farthest).abs() < 1e-12);
                assert_eq!(course.off_tangent(slack, shift), Some(polygon.off_tangent));
                let spare = course.spare(slack, shift).unwrap();
                assert!((polygon.slack[slack] - spare).abs() < 1e-15 && spare > 0.0);
            }
        }
    }

    #[test]
    fn equal_wheels_at_whole_pitches_share_the_links_out_exactly() {
        // Sixteen teeth: half a turn is eight pitches. Twenty pitches apart: 2 x 20 + 2 x 8 links are taut.
        let wheels = |x: f64| {
            vec![
                wheel(16, 0.0, 0.0, Side::Inside),
                wheel(16, x, 0.0, Side::Inside),
            ]
        };
        let taut = 20.0 * PITCH;
        let long = WheelSequence::new(PITCH, 58, wheels(taut)).unwrap();
        for slack in 0..2 {
            let polygon = long.polygon(slack, 0.0, 0.0).unwrap();
            assert_eq!(polygon.seated, [8, 8]);
            assert_eq!(polygon.strands[slack], 22);
            assert_eq!(polygon.strands[1 - slack], 20);
            assert!(polygon.off_tangent < 1e-12);
            assert!((long.spare(slack, 0.0).unwrap() - 2.0 * PITCH).abs() < 1e-14);
        }
        // Farther apart by 1e-4 of the distance: every link of both strands is longer by this.
        let short = WheelSequence::new(PITCH, 56, wheels(taut * (1.0 + 1e-4))).unwrap();
        let spare = short.spare(0, 0.0).unwrap();
        // The taut strand without stretch leaves its wheel early, by 2e-3 of a pitch: the other one lacks about twice this.
        assert!((spare / PITCH + 4e-3).abs() < 1e-4, "{spare}");
        let polygon = short.polygon(0, 0.0, 1e-3).unwrap();
        assert!(
            (polygon.stretch - 1e-4).abs() < 1e-12,
            "{}",
            polygon.stretch
        );
        assert!((polygon.spans[0] - taut * (1.0 + 1e-4)).abs() < 1e-12);
        assert!((polygon.slack[0] + taut * 1e-4).abs() < 1e-12);
        assert!(polygon.sag.iter().all(|&sag| sag == 0.0));
        // Not enough stretch, or none of the links is left for the slack strand.
        assert_eq!(short.polygon(0, 0.0, 0.9e-4), None);
        let few = WheelSequence::new(PITCH, 36, wheels(taut)).unwrap();
        assert_eq!(few.spare(0, 0.0), None);
        let one = WheelSequence::new(PITCH, 37, wheels(taut)).unwrap();
        assert!((one.spare(0, 0.0).unwrap() + 19.0 * PITCH).abs() < 1e-14);
    }

    #[test]
    fn an_angle_is_brought_within_half_a_turn() {
        for turns in [-3.0, -1.0, 0.0, 2.0] {
            for angle in [-3.1, -0.4, 0.0, 1.2, 3.1] {
                assert!((wrapped(angle + turns * TAU) - angle).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn the_end_angle_of_a_bow_is_that_of_its_circle() {
        // Height R (1 - cos a) over a chord 2 R sin a; beyond half a circle the angle is bounded.
        assert_eq!(bow_angle(0.0, 1.0), 0.0);
        for angle in [0.1_f64, 1.0, 2.0, 3.0] {
            let (sag, span) = (0.7 * (1.0 - angle.cos()), 1.4 * angle.sin());
            assert!((bow_angle(sag, span) - angle).abs() < 1e-13);
        }
        assert!((bow_angle(1.0, 0.0) - PI).abs() < 1e-15);
    }

    #[test]
    fn links_of_all_strands_are_stretched_alike_where_the_slack_strand_keeps_a_bow() {
        // A strand that takes a pitch less when its links are longer leaves slack in another one.
        let mut bowed = 0;
        let mut all = 0;
        for i in 0..4000 {
            let mut wheels = course(90).wheels;
            wheels[1].center.x = 0.2 + 2.5e-5 * f64::from(i);
            let course = WheelSequence::new(PITCH, 64, wheels).unwrap();
            for turn in 0..9 {
                let slack = turn % 3;
                let shift = 0.1 * turn as f64 - 0.4;
                let Some(polygon) = course.polygon(slack, shift, 1e-2) else {
                    continue;
                };
                if polygon.stretch == 0.0 {
                    continue;
                }
                let link = PITCH * (1.0 + polygon.stretch);
                let spare = f64::from(polygon.strands[slack]) * link - polygon.spans[slack];
                assert!(spare > -1e-15);
                bowed += u32::from(spare > 1e-10);
                all += 1;
                let next = polygon.hinges.iter().zip(&polygon.seat_of).cycle().skip(1);
                for ((a, from), (b, to)) in polygon.hinges.iter().zip(&polygon.seat_of).zip(next) {
                    let expected = if from.is_some() && from == to {
                        PITCH
                    } else {
                        link
                    };
                    assert!(((a - b).norm() - expected).abs() < 1e-12);
                }
            }
        }
        assert!(bowed > 0, "{bowed} {all}");
    }

    #[test]
    fn a_chain_of_exactly_the_length_is_not_stretched() {
        // Some pitches close the taut chain of equal wheels without any rounding error.
        let mut exact = 0;
        for pitch in [1.0, 0.5, 0.0127, 0.009_525, 0.0254, 3.0, 5.0, 7.0] {
            let of = |x: f64| PlacedWheel {
                wheel: Wheel::on_pitch_circle(pitch, 16),
                center: Vec2::new(x, 0.0),
                side: Side::Inside,
            };
            let wheels = vec![of(0.0), of(20.0 * pitch)];
            let course = WheelSequence::new(pitch, 56, wheels).unwrap();
            if course.spare(0, 0.0) == Some(0.0) {
                exact += 1;
                assert_eq!(course.polygon(0, 0.0, 1e-3).unwrap().stretch, 0.0);
            }
        }
        assert!(exact > 0);
    }
}
