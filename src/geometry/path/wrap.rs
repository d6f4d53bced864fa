//! The chain's path round two sprockets: which pitches are seated, how long the strands are, where every hinge lies.
//!
//! Local frame: the first sprocket's centre is the origin, the second one's lies on the +x axis. The path runs
//! counterclockwise, from the first seat of sprocket 1 at its upper side, round its far side, along the lower strand,
//! round sprocket 2 and back along the upper strand.

mod layout;

use std::f64::consts::PI;

use crate::geometry::Vec2;
use layout::Layout;

/// What the path needs to know of a sprocket.
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

/// How many pitches lie where.
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
    /// How many pitches lie where.
    pub split: Split,
    /// Angle of the first seated hinge of each sprocket, seen from its centre \[rad\].
    pub first_seat: [f64; 2],
    /// Radius on which the hinges of each sprocket are seated \[m\].
    pub hinge_radius: [f64; 2],
    /// Straight distance between the ends of the upper and the lower strand \[m\].
    pub spans: [f64; 2],
    /// Chain length in each strand less the straight distance \[m\]: positive when it sags, negative when it is stretched.
    pub slack: [f64; 2],
    /// How far each strand bows outward \[m\].
    pub sag: [f64; 2],
    /// Hinge positions \[m\], hinge 1 first.
    pub hinges: Vec<Vec2>,
    /// Which sprocket (0 or 1) each hinge is seated on.
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
    let (mut low, mut high) = (shortest.max(1e-3 * pitch), f64::from(links) * pitch);
    if excess(low) > 0.0 {
        return None;
    }
    while high - low > 1e-15 * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
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
        whole((wrap[0] - 1e-9).round()),
        whole((wrap[1] + 1e-9).round()),
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
    let layout = Layout {
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
    let layout = Layout {
        pitch,
        wheels,
        split,
    };
    let tight = slack_strand.other();
    if let Some(shift) = layout.tighten(tight, center_distance) {
        let path = layout.path(shift, center_distance);
        if path.slack[slack_strand as usize] > -1e-12 * center_distance {
            return Some(path);
        }
    }
    let shift = layout.balance(center_distance)?;
    let path = layout.path(shift, center_distance);
    path.slack.iter().all(|&s| s <= 1e-12).then_some(path)
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
        let tight = whole((straight - 1e-9).round()).clamp(1, rest / 2);
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
}
