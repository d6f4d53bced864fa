//! Report of a layout: the generator's choices.

use crate::drive::{Drive, SprocketMotion};
use crate::error::Result;
use crate::geometry::path::belt::Side;

/// Component of gravity across a strand, over gravity, below which rounding would choose the slack strand.
pub(super) const LEAST_GRAVITY_ACROSS: f64 = 1e-9;
/// Largest usual ratio of sag to span: a warning is given above, and the proposed tension of a tensioner has it.
pub(crate) const USUAL_SAG: f64 = 0.06;

/// Choices of the generator, one entry per sprocket in the described order or per strand.
///
/// With two sprockets the strands are the upper one (left of the line from the first to the second centre) and the lower one.
/// With more, strand `i` leads from `order[i]` to the next one, counterclockwise.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layout {
    /// Sprockets (from 0) in the order along the chain path, counterclockwise.
    pub order: Vec<usize>,
    /// Side of the chain of each sprocket.
    pub sides: Vec<Side>,
    /// Sprocket on which each hinge is seated.
    pub seat_of: Vec<Option<usize>>,
    /// Pitch radii \[m\].
    pub pitch_radius: Vec<f64>,
    /// Distance of the seated hinges outside the pitch circle \[m\].
    pub seat_offset: Vec<f64>,
    /// Pitches seated on each sprocket.
    pub seated: Vec<u32>,
    /// Wrap of each sprocket by the belt line on the pitch circles \[rad\].
    pub belt_wrap: Vec<f64>,
    /// Angle of the first seated hinge of each sprocket \[rad\]: seen from its centre; with two sprockets, from the line of centres.
    pub first_seat: Vec<f64>,
    /// θ of each sprocket \[rad\].
    pub phase: Vec<f64>,
    /// Angular speeds at the start \[rad/s\].
    pub speeds: Vec<f64>,
    /// Ratio of the mean angular velocity of each sprocket to that of the first; negative for the opposite sense.
    pub speed_ratio: Vec<f64>,
    /// Sprockets (from 0) at both ends of each strand.
    pub strands: Vec<[usize; 2]>,
    /// Pitches in each strand.
    pub strand_pitches: Vec<u32>,
    /// Straight distance between the ends of each strand \[m\].
    pub spans: Vec<f64>,
    /// Chain length minus straight distance of each strand \[m\]: positive for slack, negative for a stretched strand.
    pub slack: Vec<f64>,
    /// Outward sag of each strand \[m\].
    pub sag: Vec<f64>,
    /// Length of a taut chain along the belt line, in pitches.
    pub belt_pitches: f64,
    /// Distance of the centres of two sprockets \[m\].
    pub center_distance: Option<f64>,
    /// Centre distance of two sprockets at which the chain is taut \[m\], where there is one.
    pub closing_center_distance: Option<f64>,
    /// Largest opening of a hinge at the start \[m\]: the stretch of the chain per pitch.
    pub hinge_stretch: f64,
    /// Smallest distance of a bushing from a tooth at the start \[m\].
    pub start_gap: f64,
    /// Force of the tensioner \[N\].
    pub tension_force: f64,
    /// Initial positions of the guides.
    pub guides: Vec<GuidePlacement>,
    /// Warnings about the design.
    pub warnings: Vec<String>,
}

/// Initial position of a guide relative to the laid chain.
#[derive(Debug, Clone, PartialEq)]
pub struct GuidePlacement {
    /// Smallest distance of a bushing, or of a plate where plates are in contact \[m\].
    pub gap: f64,
    /// Rotation of its arm from the described position \[rad\].
    pub turn: f64,
    /// Remaining backward and outward displacement of its plunger \[m\]; infinite without a stop, zero without an arm.
    pub travel: [f64; 2],
    /// Number of bushings within half a pitch of its face.
    pub bushings: u32,
    /// Strand or sprocket of the nearest bushing.
    pub place: String,
}

/// Return the angular velocity of a sprocket at the start \[rad/s\], if given.
pub(super) fn given_speed(drive: &Drive, sprocket: usize) -> Option<f64> {
    match &drive.sprockets[sprocket].motion {
        SprocketMotion::PrescribedSpeed(table) => Some(table.value(0.0)),
        _ => drive.sprockets[sprocket].initial_speed,
    }
}

/// Return the full force of the drive's tensioner \[N\]; zero without one.
pub(super) fn tension_force(drive: &Drive) -> Result<f64> {
    match &drive.tensioner {
        Some(tensioner) => Ok(tensioner.line(drive)?.pull),
        None => Ok(0.0),
    }
}

impl Layout {
    /// Return the name of a strand.
    #[must_use]
    pub fn strand_name(&self, strand: usize) -> String {
        strand_name(&self.strands, strand)
    }

    /// Return the name of the sprocket or strand of `hinge`.
    pub(super) fn place_of(&self, hinge: usize) -> String {
        if let Some(sprocket) = self.seat_of[hinge] {
            return format!("sprocket {}", sprocket + 1);
        }
        let first = |seats: &[Option<usize>]| seats.iter().find_map(|seat| *seat);
        let last = |seats: &[Option<usize>]| seats.iter().rev().find_map(|seat| *seat);
        let (before, behind) = self.seat_of.split_at(hinge);
        let [mut from, mut to] = [last(before), first(behind)];
        if is_open(&self.strands) {
            // The first and the last strand lead to the ends of the chain.
            [from, to] = [from, to].map(|sprocket| sprocket.or(Some(usize::MAX)));
        } else {
            [from, to] = [from.or(last(behind)), to.or(first(before))];
        }
        let joins = |&[a, b]: &[usize; 2]| [Some(a), Some(b)] == [from, to];
        let strand = self.strands.iter().position(joins);
        strand.map_or(String::new(), |i| format!("strand {}", self.strand_name(i)))
    }
}

/// Return whether strands lead to the ends of an open chain.
fn is_open(strands: &[[usize; 2]]) -> bool {
    strands[0][0] == usize::MAX
}

/// Return "upper" and "lower" for two sprockets, "1-3" from sprocket 1 to sprocket 3 of more; `"end_1-1"` from the end of an open chain.
#[must_use]
pub fn strand_name(strands: &[[usize; 2]], strand: usize) -> String {
    let [from, to] = strands[strand];
    if is_open(strands) {
        let name = |i: usize, end: &str| match i {
            usize::MAX => end.to_string(),
            i => (i + 1).to_string(),
        };
        return format!("{}-{}", name(from, "end_1"), name(to, "end_2"));
    }
    if strands.len() == 2 {
        return ["upper", "lower"][strand].to_string();
    }
    format!("{}-{}", from + 1, to + 1)
}
