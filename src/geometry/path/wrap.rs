//! The chain's path round two sprockets: which pitches are seated, how long the strands are, where every hinge lies.
//!
//! Local frame: the first sprocket's centre is the origin, the second one's lies on the +x axis. The path runs
//! counterclockwise, from the first seat of sprocket 1 at its upper side, round its far side, along the lower strand,
//! round sprocket 2 and back along the upper strand.

mod layout;

use std::f64::consts::PI;

use crate::geometry::Vec2;
use layout::WrapLayout;

/// Difference of the lengths of a strand and of its links that counts as none \[m\]: rounding.
pub(crate) const CLOSED: f64 = 1e-12;
/// The same, and a difference of centre distances, over the centre distance.
pub(crate) const CLOSED_SHARE: f64 = 1e-12;
/// Least centre distance of a belt, in pitches: on wheels of one size it is not zero.
const LEAST_DISTANCE: f64 = 1e-3;
/// Width of the bracket of a centre distance at which bisection ends, over the distance: some roundings.
const NARROW: f64 = 1e-15;
/// Pitches by which ties of rounding to whole pitches are decided on every machine: rounding of a wrap or a length is less.
const TIE: f64 = 1e-9;

/// Properties of a sprocket that the path depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wheel {
    /// Number of teeth.
    pub teeth: u32,
    /// Radius on which the seated hinges lie \[m\].
    pub hinge_radius: f64,
}

impl Wheel {
    /// A wheel whose seated hinges lie on the pitch circle.
    #[must_use]
    pub fn on_pitch_circle(pitch: f64, teeth: u32) -> Self {
        Self {
            teeth,
            hinge_radius: pitch_radius(pitch, teeth),
        }
    }

    pub(crate) fn gap_angle(&self) -> f64 {
        2.0 * PI / f64::from(self.teeth)
    }
}

/// Radius of the pitch circle \[m\].
#[must_use]
pub fn pitch_radius(pitch: f64, teeth: u32) -> f64 {
    pitch / (2.0 * (PI / f64::from(teeth)).sin())
}

/// The two strands, in the order of arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
#[allow(missing_docs)] // the names say it
pub enum Strand {
    Upper = 0,
    Lower = 1,
}

impl Strand {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Upper => Self::Lower,
            Self::Lower => Self::Upper,
        }
    }
}

/// Numbers of pitches on sprockets and strands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// Pitches between the first and the last seated hinge of each sprocket.
    pub seated: [u32; 2],
    /// Pitches in the upper and in the lower strand.
    pub strands: [u32; 2],
}

/// A chain laid round two sprockets.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Distance of the sprockets' centres \[m\].
    pub center_distance: f64,
    /// Numbers of pitches on sprockets and strands.
    pub split: Split,
    /// Angle of the first seated hinge of each sprocket, seen from its centre \[rad\].
    pub first_seat: [f64; 2],
    /// Radius on which the hinges of each sprocket are seated \[m\].
    pub hinge_radius: [f64; 2],
    /// Straight distance between the ends of the upper and the lower strand \[m\].
    pub spans: [f64; 2],
    /// Chain length in each strand less the straight distance \[m\]: positive when it sags, negative when it is stretched.
    pub slack: [f64; 2],
    /// Outward bow of each strand \[m\].
    pub sag: [f64; 2],
    /// Hinge positions \[m\], hinge 1 first.
    pub hinges: Vec<Vec2>,
    /// Sprocket (0 or 1) on which each hinge is seated.
    pub seat_of: Vec<Option<usize>>,
}

/// Chain length in pitches that an open belt on the pitch circles needs at `center_distance`.
///
/// Real chains are polygons; the difference is a small fraction of a pitch.
#[must_use]
pub fn belt_length(pitch: f64, teeth: [u32; 2], center_distance: f64) -> f64 {
    let (straight, wrap) = belt(pitch, teeth, center_distance);
    2.0 * straight + wrap[0] + wrap[1]
}

/// Length of one straight strand and the wraps of both sprockets, in pitches, of the open belt on the pitch circles.
fn belt(pitch: f64, teeth: [u32; 2], center_distance: f64) -> (f64, [f64; 2]) {
    let difference = pitch_radius(pitch, teeth[0]) - pitch_radius(pitch, teeth[1]);
    let tangent_angle = (difference / center_distance).clamp(-1.0, 1.0).acos();
    let straight = (center_distance.powi(2) - difference.powi(2))
        .max(0.0)
        .sqrt();
    let [n1, n2] = teeth.map(f64::from);
    (
        straight / pitch,
        [n1 * (1.0 - tangent_angle / PI), n2 * tangent_angle / PI],
    )
}

/// Centre distance \[m\] at which an open belt of `links` pitches is taut; `None` when it is too short for the two sprockets.
#[must_use]
pub fn belt_center_distance(pitch: f64, teeth: [u32; 2], links: u32) -> Option<f64> {
    let shortest = (pitch_radius(pitch, teeth[0]) - pitch_radius(pitch, teeth[1])).abs();
    let excess = |c: f64| belt_length(pitch, teeth, c) - f64::from(links);
    let (mut low, mut high) = (
        shortest.max(LEAST_DISTANCE * pitch),
        f64::from(links) * pitch,
    );
    if excess(low) > 0.0 {
        return None;
    }
    while high - low > NARROW * high {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// Whole wrapped pitches of both sprockets, each the nearest to the belt's wrap.
///
/// A strand begins d pitches before its tangent point, with d at most a quarter from the rounding of its sprocket's wrap and
/// a quarter from the shift that strands of odd pitches need. Its first free hinge lies (d - 1/2) p²/R inside the pitch
/// circle, so that d up to one half keeps it out of the teeth; a negative d only seats a bushing past the tangent point.
#[must_use]
pub fn seated_pitches(pitch: f64, teeth: [u32; 2], center_distance: f64) -> [u32; 2] {
    let (_, wrap) = belt(pitch, teeth, center_distance);
    // Ties go down on the first and up on the second on every machine: 8.5 and 8.5 pitches are 8 and 9.
    [
        whole((wrap[0] - TIE).round()),
        whole((wrap[1] + TIE).round()),
    ]
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts of pitches, clamped to what u32 holds
fn whole(x: f64) -> u32 {
    x.max(0.0) as u32
}

/// Splits `links` pitches so that the strands differ by one at most; `None` when a strand would have no pitch.
#[must_use]
pub fn even_split(seated: [u32; 2], links: u32) -> Option<Split> {
    let rest = links.checked_sub(seated[0] + seated[1])?;
    (rest >= 2).then(|| Split {
        seated,
        strands: [rest / 2, rest - rest / 2],
    })
}

/// The taut chain with two straight strands: its centre distance follows from the number of links.
#[must_use]
pub fn taut_path(pitch: f64, wheels: [Wheel; 2], links: u32) -> Option<Path> {
    let teeth = wheels.map(|w| w.teeth);
    let guess = belt_center_distance(pitch, teeth, links)?;
    let split = even_split(seated_pitches(pitch, teeth, guess), links)?;
    let layout = WrapLayout {
        pitch,
        wheels,
        split,
    };
    let (shift, distance) = layout.close(guess)?;
    Some(layout.path(shift, distance))
}

/// The chain at a given centre distance: one strand taut and the slack in `slack_strand`, or, where the chain is short,
/// both strands stretched alike.
#[must_use]
pub fn path_at(
    pitch: f64,
    wheels: [Wheel; 2],
    split: Split,
    center_distance: f64,
    slack_strand: Strand,
) -> Option<Path> {
    let layout = WrapLayout {
        pitch,
        wheels,
        split,
    };
    let tight = slack_strand.other();
    if let Some(shift) = layout.tighten(tight, center_distance) {
        let path = layout.path(shift, center_distance);
        if path.slack[slack_strand as usize] > -CLOSED_SHARE * center_distance {
            return Some(path);
        }
    }
    let shift = layout.balance(center_distance)?;
    let path = layout.path(shift, center_distance);
    path.slack.iter().all(|&s| s <= CLOSED).then_some(path)
}

/// Splits to try at a given centre distance, the most natural first.
#[must_use]
pub fn splits_at(
    pitch: f64,
    teeth: [u32; 2],
    links: u32,
    center_distance: f64,
    slack_strand: Strand,
) -> Vec<Split> {
    let (straight, _) = belt(pitch, teeth, center_distance);
    let natural = seated_pitches(pitch, teeth, center_distance);
    let mut splits = Vec::new();
    for (more_first, more_second) in [
        (0, 0),
        (0, -1),
        (-1, 0),
        (-1, -1),
        (0, 1),
        (1, 0),
        (1, 1),
        (-2, -2),
    ] {
        let (Some(first), Some(second)) = (
            natural[0].checked_add_signed(more_first),
            natural[1].checked_add_signed(more_second),
        ) else {
            continue;
        };
        let Some(even) = even_split([first, second], links) else {
            continue;
        };
        let rest = even.strands[0] + even.strands[1];
        // The tight strand takes what lies straight, and never more than half.
        let tight = whole((straight - TIE).round()).clamp(1, rest / 2);
        for tight in [
            tight,
            tight.saturating_sub(1).max(1),
            (tight + 1).min(rest - 1),
        ] {
            let mut split = even;
            split.strands[slack_strand as usize] = rest - tight;
            split.strands[slack_strand.other() as usize] = tight;
            if !splits.contains(&split) {
                splits.push(split);
            }
        }
    }
    splits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::path::bow::Bow;

    // Coordinates up to 0.5 m are rounded to 5e-17 m. Bounds of 1e-15 m to 1e-12 m permit sums of tens to thousands of such errors.
    const PITCH: f64 = 0.0127;

    fn wheels(teeth: [u32; 2]) -> [Wheel; 2] {
        teeth.map(|n| Wheel::on_pitch_circle(PITCH, n))
    }

    #[test]
    fn thirty_eight_links_close_at_the_published_centre_distance() {
        let path = taut_path(PITCH, wheels([17, 17]), 38).unwrap();
        assert!((path.center_distance - 0.133_348_698_813).abs() < 1e-12);
        assert_eq!(path.split.seated, [8, 9]);
        assert_eq!(path.split.strands, [10, 11]);
        assert!((path.first_seat[0].to_degrees() - 89.999_948_194).abs() < 1e-9);
        assert_eq!(path.hinges.len(), 38);
    }

    #[test]
    fn neighbouring_hinges_of_a_slack_chain_are_one_pitch_apart() {
        for (teeth, links, distance) in [
            ([17, 17], 40, 0.14),
            ([13, 31], 70, 0.3),
            ([40, 12], 90, 0.38),
        ] {
            for strand in [Strand::Lower, Strand::Upper] {
                let split = splits_at(PITCH, teeth, links, distance, strand)[0];
                let path = path_at(PITCH, wheels(teeth), split, distance, strand).unwrap();
                assert_eq!(path.hinges.len(), links as usize);
                for (a, b) in path.hinges.iter().zip(path.hinges.iter().cycle().skip(1)) {
                    assert!(((a - b).norm() - PITCH).abs() < 1e-13, "{teeth:?} {links}");
                }
                assert!(path.slack[strand as usize] > 0.0 && path.sag[strand as usize] > 0.0);
            }
        }
    }

    #[test]
    fn too_few_links_have_no_belt() {
        assert_eq!(belt_center_distance(PITCH, [17, 60], 40), None);
    }

    #[test]
    fn hinges_on_the_pitch_circle_are_the_corners_of_a_regular_polygon() {
        // Sides of a triangle, a square and a hexagon.
        for (teeth, radius) in [(3, 1.0 / 3.0_f64.sqrt()), (4, 0.5_f64.sqrt()), (6, 1.0)] {
            assert!((pitch_radius(PITCH, teeth) - PITCH * radius).abs() < 1e-16);
            let wheel = Wheel::on_pitch_circle(PITCH, teeth);
            assert_eq!(wheel.hinge_radius, pitch_radius(PITCH, teeth));
            assert!((wheel.gap_angle() * f64::from(teeth) - 2.0 * PI).abs() < 1e-15);
        }
    }

    #[test]
    fn the_belt_s_length_is_that_of_two_tangents_and_two_arcs() {
        // Equal wheels: twice the distance and one wheel's teeth.
        assert!((belt_length(PITCH, [17, 17], 10.0 * PITCH) - 37.0).abs() < 1e-13);
        // Unequal ones: arcs of a circle of N pitches, by the angle β of the tangents.
        for teeth in [[13, 31], [40, 12]] {
            let distance = 25.0 * PITCH;
            let [r1, r2] = teeth.map(|n| pitch_radius(PITCH, n));
            let beta = ((r1 - r2) / distance).asin();
            let [n1, n2] = teeth.map(f64::from);
            let wraps = [n1 * (0.5 + beta / PI), n2 * (0.5 - beta / PI)];
            let expected = 2.0 * distance * beta.cos() / PITCH + wraps[0] + wraps[1];
            assert!((belt_length(PITCH, teeth, distance) - expected).abs() < 1e-13);
            assert_eq!(
                seated_pitches(PITCH, teeth, distance).map(f64::from),
                wraps.map(f64::round)
            );
            // The distance of a belt of that length is that distance again.
            let found = belt_center_distance(PITCH, teeth, 80).unwrap();
            assert!((belt_length(PITCH, teeth, found) - 80.0).abs() < 1e-12);
        }
        // Wheels within one another: the belt is the larger circle, and half a belt of equal wheels is 8.5 pitches.
        assert!((belt_length(PITCH, [40, 12], 0.5 * PITCH) - 40.0).abs() < 1e-13);
        assert_eq!(seated_pitches(PITCH, [40, 12], 0.5 * PITCH), [40, 0]);
        assert_eq!(seated_pitches(PITCH, [17, 17], 10.0 * PITCH), [8, 9]);
        assert_eq!(seated_pitches(PITCH, [18, 20], 1e5 * PITCH), [9, 10]);
    }

    #[test]
    fn equal_wheels_may_be_as_near_as_the_links_permit() {
        // 17 teeth and one link more: half a pitch between the centres. With 17 links there is no strand.
        for (links, pitches) in [(18, 0.5), (19, 1.0), (117, 50.0)] {
            let found = belt_center_distance(PITCH, [17, 17], links).unwrap();
            assert!((found - pitches * PITCH).abs() < 1e-14, "{links}: {found}");
        }
        assert_eq!(belt_center_distance(PITCH, [17, 17], 17), None);
        // A belt of 40 pitches fits round 40 teeth at every distance at which 12 teeth are within their circle.
        let touching = belt_center_distance(PITCH, [40, 12], 40).unwrap();
        assert!((belt_length(PITCH, [40, 12], touching) - 40.0).abs() < 1e-12);
        assert_eq!(belt_center_distance(PITCH, [40, 12], 39), None);
    }

    #[test]
    fn links_beside_the_seats_are_shared_evenly() {
        let of = |links| even_split([8, 9], links).map(|split| split.strands);
        assert_eq!(of(38), Some([10, 11]));
        assert_eq!(of(37), Some([10, 10]));
        assert_eq!(of(19), Some([1, 1]));
        assert_eq!((of(18), of(17), of(16)), (None, None, None));
        assert_eq!(even_split([8, 9], 38).unwrap().seated, [8, 9]);
    }

    #[test]
    fn the_taut_chain_of_equal_wheels_is_as_long_as_its_strands() {
        // Sixteen teeth seat eight pitches each; the other links are two straight strands between the highest points.
        for links in [36, 56] {
            let path = taut_path(PITCH, wheels([16, 16]), links).unwrap();
            let strand = 0.5 * f64::from(links - 16) * PITCH;
            assert!((path.center_distance - strand).abs() < 1e-14);
            assert_eq!(path.split.seated, [8, 8]);
            let right_angle = 0.5 * PI;
            assert!((path.first_seat[0] - right_angle).abs() < 1e-12);
            assert!((path.first_seat[1] + right_angle).abs() < 1e-12);
            for strand in [0, 1] {
                assert!(path.slack[strand].abs() < 1e-14 && path.sag[strand] == 0.0);
            }
            let radius = pitch_radius(PITCH, 16);
            assert!((path.hinges[0] - Vec2::new(0.0, radius)).norm() < 1e-13);
            let second = links as usize / 2;
            let lower = Vec2::new(path.center_distance, -radius);
            assert!((path.hinges[second] - lower).norm() < 1e-13);
            let seated = path.seat_of.iter().filter(|seat| seat.is_some()).count();
            assert_eq!(seated, 18);
            assert_eq!((path.seat_of[0], path.seat_of[second]), (Some(0), Some(1)));
        }
        assert_eq!(taut_path(PITCH, wheels([17, 60]), 40), None);
    }

    #[test]
    fn hinges_of_a_taut_chain_on_unequal_wheels_are_one_pitch_apart() {
        for (teeth, links) in [
            ([13, 31], 70),
            ([40, 12], 91),
            ([17, 25], 41),
            ([9, 10], 200),
            ([60, 9], 61),
        ] {
            let path = taut_path(PITCH, wheels(teeth), links).unwrap();
            assert_eq!(path.hinges.len(), links as usize);
            for (a, b) in path.hinges.iter().zip(path.hinges.iter().cycle().skip(1)) {
                assert!(((a - b).norm() - PITCH).abs() < 1e-13, "{teeth:?} {links}");
            }
            for (i, hinge) in path.hinges.iter().enumerate() {
                if let Some(seat) = path.seat_of[i] {
                    let center = Vec2::new(seat as f64 * path.center_distance, 0.0);
                    assert!(((hinge - center).norm() - path.hinge_radius[seat]).abs() < 1e-15);
                }
            }
            // The polygon is longer than its belt by a small part of a pitch.
            let belt = belt_center_distance(PITCH, teeth, links).unwrap();
            assert!((path.center_distance - belt).abs() < 0.05 * PITCH);
        }
    }

    #[test]
    fn links_seated_on_larger_circles_need_more_length() {
        // Hinges a little outside the pitch circle, at the same angles: both strands keep their length.
        let teeth = [16, 16];
        let raised = wheels(teeth).map(|wheel| Wheel {
            hinge_radius: 1.01 * wheel.hinge_radius,
            ..wheel
        });
        let path = taut_path(PITCH, raised, 56).unwrap();
        assert!((path.center_distance - 20.0 * PITCH).abs() < 1e-14);
        assert_eq!(path.hinge_radius, raised.map(|wheel| wheel.hinge_radius));
        assert!((path.hinges[0].y - raised[0].hinge_radius).abs() < 1e-14);
    }

    #[test]
    fn the_slack_is_in_the_chosen_strand_and_the_other_one_is_straight() {
        for strand in [Strand::Lower, Strand::Upper] {
            let split = Split {
                seated: [8, 8],
                strands: if strand == Strand::Upper {
                    [22, 20]
                } else {
                    [20, 22]
                },
            };
            let path = path_at(PITCH, wheels([16, 16]), split, 20.0 * PITCH, strand).unwrap();
            let [slack, tight] = [strand as usize, strand.other() as usize];
            assert!((path.slack[slack] - 2.0 * PITCH).abs() < 1e-13);
            assert!(path.slack[tight].abs() < 1e-13 && path.sag[tight] < 1e-6);
            assert!((path.spans[0] - 20.0 * PITCH).abs() < 1e-13);
            assert!((path.sag[slack] - Bow::new(20.0 * PITCH, 22, PITCH).height()).abs() < 1e-13);
            // It bows away from the other strand.
            let radius = pitch_radius(PITCH, 16);
            let highest = path
                .hinges
                .iter()
                .map(|hinge| hinge.y.abs())
                .fold(0.0, f64::max);
            assert!((highest - radius - path.sag[slack]).abs() < 1e-12);
            let outermost = path
                .hinges
                .iter()
                .max_by(|a, b| a.y.abs().total_cmp(&b.y.abs()));
            let sign = if strand == Strand::Upper { 1.0 } else { -1.0 };
            assert!(outermost.unwrap().y * sign > 0.0);
        }
    }

    #[test]
    fn a_chain_a_little_short_is_stretched_alike_in_both_strands() {
        // Equal strands of 20 and 21 links on 17 teeth: both are longer by the same share.
        let taut = taut_path(PITCH, wheels([17, 17]), 58).unwrap();
        let far = taut.center_distance + 1e-3 * PITCH;
        for strand in [Strand::Lower, Strand::Upper] {
            let path = path_at(PITCH, wheels([17, 17]), taut.split, far, strand).unwrap();
            let share = |strand: usize| {
                let links = f64::from(path.split.strands[strand]) * PITCH;
                assert!((links - path.spans[strand] - path.slack[strand]).abs() < 1e-15);
                path.slack[strand] / links
            };
            assert!((share(0) - share(1)).abs() < 1e-13);
            // Both strands together are longer by about twice the distance.
            let all = path.slack[0] + path.slack[1];
            assert!((all + 2e-3 * PITCH).abs() < 2e-5 * PITCH, "{all}");
            assert_eq!(path.sag, [0.0, 0.0]);
        }
        // Nearer, the same links are slack.
        let near = taut.center_distance - 1e-3 * PITCH;
        let path = path_at(PITCH, wheels([17, 17]), taut.split, near, Strand::Lower).unwrap();
        assert!(path.slack[1] > 1e-3 * PITCH && path.slack[0].abs() < 1e-14);
    }

    #[test]
    fn splits_are_all_links_with_the_even_one_and_the_tight_strand_nearest_to_the_belt_first() {
        // Equal wheels of 16 teeth, 20 pitches apart: 8 + 20 + 8 + 22 pitches.
        for (strand, first) in [(Strand::Upper, [22, 20]), (Strand::Lower, [20, 22])] {
            let splits = splits_at(PITCH, [16, 16], 58, 20.0 * PITCH, strand);
            assert_eq!(splits[0].seated, [8, 8]);
            assert_eq!(splits[0].strands, first);
            for (i, split) in splits.iter().enumerate() {
                assert_eq!(split.seated.iter().chain(&split.strands).sum::<u32>(), 58);
                assert!(split.strands.iter().all(|&strand| strand > 0));
                assert!(!splits[..i].contains(split));
            }
            // Each of eight pairs of seats with three tight strands.
            let seats = [
                (8, 8),
                (8, 7),
                (7, 8),
                (7, 7),
                (8, 9),
                (9, 8),
                (9, 9),
                (6, 6),
            ];
            let tight: Vec<_> = splits
                .iter()
                .map(|split| (split.seated.into(), split.strands[strand.other() as usize]))
                .collect();
            let expected: Vec<_> = seats
                .into_iter()
                .flat_map(|seats| [20, 19, 21].map(|tight| (seats, tight)))
                .collect();
            assert_eq!(tight, expected);
        }
        // Few links: the tight strand has at least one and at most half of those that are left.
        let strands: Vec<_> = splits_at(PITCH, [16, 16], 19, 3.0 * PITCH, Strand::Upper)
            .into_iter()
            .filter(|split| split.seated == [8, 8])
            .map(|split| split.strands)
            .collect();
        assert_eq!(strands, [[2, 1], [1, 2]]);
        assert_eq!(splits_at(PITCH, [16, 16], 12, PITCH, Strand::Upper), []);
        let one_each: Vec<_> = splits_at(PITCH, [16, 16], 18, PITCH, Strand::Upper)
            .into_iter()
            .filter(|split| split.seated == [8, 8])
            .map(|split| split.strands)
            .collect();
        assert_eq!(one_each, [[1, 1]]);
        // Half a pitch is left to the slack strand.
        let halved = splits_at(PITCH, [16, 16], 59, 20.5 * PITCH, Strand::Upper);
        assert_eq!(halved[0].strands, [23, 20]);
    }

    #[test]
    fn a_chain_short_by_2e_12_of_its_distance_is_stretched_and_one_short_by_less_is_taut() {
        let split = Split {
            seated: [8, 8],
            strands: [20, 20],
        };
        let taut = 20.0 * PITCH;
        let at = |distance: f64| {
            path_at(PITCH, wheels([16, 16]), split, distance, Strand::Lower).unwrap()
        };
        // Equal strands have half of the length that is missing.
        let stretched = at(taut * (1.0 + 4e-12));
        for slack in stretched.slack {
            assert!((slack + 4e-12 * taut).abs() < 1e-13 * taut, "{slack}");
        }
        let [upper, lower] = at(taut * (1.0 + 1e-13)).slack;
        assert!(upper.abs() < 2e-14 * taut && (lower + 2e-13 * taut).abs() < 3e-14 * taut);
    }

    #[test]
    fn a_taut_chain_is_found_in_any_unit_of_length() {
        for (teeth, links) in [
            ([13, 31], 70),
            ([40, 12], 91),
            ([17, 25], 41),
            ([17, 19], 60),
        ] {
            let [small, large] = [PITCH, 1e7 * PITCH].map(|pitch| {
                let wheels = teeth.map(|n| Wheel::on_pitch_circle(pitch, n));
                taut_path(pitch, wheels, links).unwrap().center_distance / pitch
            });
            assert!((small - large).abs() < 1e-12 * small, "{teeth:?}");
        }
    }
}
