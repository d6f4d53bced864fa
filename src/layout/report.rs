//! Report of a layout: the generator's choices, and warnings.

use super::tightness::{Tightness, tightness};
use crate::drive::{Bearing, Drive, HingeKind, Sprocket, SprocketMotion};
use crate::error::Result;
use crate::geometry::path::belt::Side;
use crate::geometry::path::wrap;
use crate::math::Signal;

/// Initial distances of seated bushings from their seats that are tried \[m\]; a stretched chain, whose bushings are beside
/// the middle of their seats, may need the larger ones.
pub(super) const START_GAPS: [f64; 4] = [1e-6, 3e-6, 1e-5, 3e-5];
/// Largest stretch of a chain at the start, over the hinge clearance.
pub(super) const LARGEST_STRETCH: f64 = 0.9;

/// Component of gravity across a strand, over gravity, below which rounding would choose the slack strand.
pub(super) const LEAST_GRAVITY_ACROSS: f64 = 1e-9;
/// Largest usual ratio of sag to span: a warning is given above, and the proposed tension of a tensioner has it.
pub(crate) const USUAL_SAG: f64 = 0.06;
/// Least usual wrap of a sprocket \[degrees\], less rounding: a third of its teeth is not below.
const LEAST_WRAP: f64 = 120.0 - 1e-9;
/// Difference of the chain speeds of two sprockets, over the larger one, above which a warning is given.
const SPEED_MISMATCH: f64 = 0.01;

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
    /// Strand or sprocket of the nearest bushing; `None` where none is near.
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

/// Return the reason why the drive's tensioner does not reach its tension, if any.
fn tensioner_warning(drive: &Drive) -> Option<String> {
    let tensioner = drive.tensioner.as_ref()?;
    let line = tensioner.line(drive).ok()?;
    let way = match line.taut_at {
        None => "anywhere on its way".to_string(),
        Some(s) if s > tensioner.travel[1] => format!(
            "before its stop: it would move by {:.3} mm and can by {:.3} mm",
            1e3 * s,
            1e3 * tensioner.travel[1]
        ),
        Some(_) => return None,
    };
    Some(format!(
        "the tensioner does not take up the chain's slack {way}"
    ))
}

/// Shortage that is told of an ideal chain \[m\]: as far as bushings begin off their seats.
const LEAST_SHORTAGE: f64 = 1e-6;

/// Ideal hinges that leave the chain too short somewhere on its way round. A tensioner or a floating sprocket gives way; so does a chain
/// with clearance in its hinges.
fn tightness_warning(drive: &Drive) -> Option<String> {
    let fixed = |sprocket: &Sprocket| sprocket.bearing == Bearing::Fixed;
    let stiff = drive.hinge_kind == HingeKind::Ideal
        && drive.ends.is_none()
        && drive.tensioner.is_none()
        && drive.sprockets.iter().all(fixed);
    if !stiff {
        return None;
    }
    let Tightness { shortage, tension } = tightness(drive).ok()?;
    (shortage >= LEAST_SHORTAGE).then(|| {
        format!(
            "ideal hinges do not open: where the polygon effect tightens it most, the chain is {:.1} um too short for these \
             centres, and its tension is about {tension:.0} N, more at speed; move a centre in \
             until the strands have so much more length, or take a tensioner, hinges='clearance', or sprockets with room in \
             their seats (AnsiTooth(seat='pitch-circle'))",
            1e6 * shortage
        )
    })
}

/// Largest displacement of a tensioner on a spring under load, in pitches, at which the chain counts as seated. Half a pitch is about the
/// height of a tooth; in runs of 17:25 teeth the chain jumps at 1.4 pitches.
const GIVES_WAY: f64 = 0.5;

/// Return the warning about a load with which the chain jumps teeth: it needs a larger difference of strand tensions than the
/// tensioner keeps as their sum.
fn overload_warning(drive: &Drive, speeds: &[f64]) -> Option<String> {
    let tensioner = drive.tensioner.as_ref().filter(|_| drive.ends.is_none())?;
    // A ratchet or a stop holds the centre at any load.
    if tensioner.ratchet.is_some() || tensioner.travel[0].is_finite() {
        return None;
    }
    // With more sprockets, strands away from the tensioner may be tight.
    let loaded = match drive.sprockets.len() {
        2 => 0..2,
        _ => tensioner.sprocket - 1..tensioner.sprocket,
    };
    let need = |i: usize| {
        let radius = wrap::pitch_radius(drive.chain.pitch, drive.sprockets[i].teeth);
        largest_torque(&drive.sprockets[i].motion, speeds[i])
            .map(|torque| (i, torque, torque / radius))
    };
    let (i, torque, needed) = loaded.filter_map(need).max_by(|a, b| a.2.total_cmp(&b.2))?;
    let sum = 2.0 * tensioner.pretension + GIVES_WAY * drive.chain.pitch * tensioner.stiffness;
    (needed > sum).then(|| {
        format!(
            "the load of {torque:.4} N m on sprocket {} needs {needed:.1} N more in one strand than in the other, and the tensioner \
             maintains a sum of {sum:.1} N: the chain will jump teeth; take a pretension of {:.1} N or more",
            i + 1,
            tensioner.pretension + 0.5 * (needed - sum)
        )
    })
}

/// Return the size of the largest torque on a sprocket at its initial angular velocity \[N m\]; `None` without torque.
fn largest_torque(motion: &SprocketMotion, speed: f64) -> Option<f64> {
    let largest = |torque: &Signal, of_speed: f64| {
        let [least, most] = torque.range().map(|torque| (torque + of_speed).abs());
        least.max(most)
    };
    match motion {
        SprocketMotion::AppliedTorque(torque) => Some(largest(torque, 0.0)),
        SprocketMotion::TorqueCurve { torque, curve } => Some(largest(torque, curve.value(speed))),
        SprocketMotion::PrescribedSpeed(_) | SprocketMotion::Free => None,
    }
}

/// Number of pitches in mesh below which a warning is given.
const FEW_IN_MESH: u32 = 3;

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

    /// Return the warnings about these choices.
    pub(super) fn warn(&mut self, drive: &Drive) {
        let mut warnings = Vec::new();
        // The ends determine the sag of an open chain.
        let closed = if drive.ends.is_none() {
            self.strands.len()
        } else {
            0
        };
        for i in 0..closed {
            let share = self.sag[i] / self.spans[i];
            if share > USUAL_SAG {
                warnings.push(format!(
                    "the {} strand sags by {:.1} % of its span; 4 to 6 % is usual",
                    self.strand_name(i),
                    100.0 * share
                ));
            }
        }
        for (i, sprocket) in drive.sprockets.iter().enumerate() {
            let gap = std::f64::consts::TAU / f64::from(sprocket.teeth);
            let wrap = (f64::from(self.seated[i]) * gap).to_degrees();
            // Idlers transmit no power: few teeth are sufficient.
            if drive.sprockets.len() == 2 || !matches!(sprocket.motion, SprocketMotion::Free) {
                if wrap < LEAST_WRAP {
                    warnings.push(format!(
                        "sprocket {} is wrapped by {wrap:.0} degrees only; 120 is usual",
                        i + 1
                    ));
                }
            } else if self.seated[i] < FEW_IN_MESH {
                let plural = if self.seated[i] == 1 { "" } else { "es" };
                warnings.push(format!(
                    "sprocket {} has {} pitch{plural} in mesh; {FEW_IN_MESH} are usual for an idler",
                    i + 1,
                    self.seated[i]
                ));
            }
        }
        self.warn_of_speeds(drive, &mut warnings);
        warnings.extend(tensioner_warning(drive));
        warnings.extend(overload_warning(drive, &self.speeds));
        warnings.extend(tightness_warning(drive));
        self.warnings = warnings;
    }

    fn warn_of_speeds(&self, drive: &Drive, warnings: &mut Vec<String>) {
        // Given speeds must agree; the others follow.
        let given: Vec<usize> = (0..drive.sprockets.len())
            .filter(|&i| given_speed(drive, i).is_some())
            .collect();
        let chain_speed =
            |i: usize| self.sides[i].sign() * self.speeds[i] * f64::from(drive.sprockets[i].teeth);
        if let [first, others @ ..] = given.as_slice() {
            for other in others {
                let (one, two) = (chain_speed(*first), chain_speed(*other));
                if (one - two).abs() > SPEED_MISMATCH * one.abs().max(two.abs()) {
                    warnings.push(format!(
                        "sprockets {} and {} start at {:.4} and {:.4} rad/s, which move the chain at different speeds",
                        first + 1,
                        other + 1,
                        self.speeds[*first],
                        self.speeds[*other]
                    ));
                }
            }
        }
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
