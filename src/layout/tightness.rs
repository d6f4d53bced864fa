//! How far a chain whose hinges do not open is too short for its sprockets, and what that presses into their teeth.

use super::many_sprockets::{Around, SHIFTS};
use super::report::seat_depth;
use crate::drive::Drive;
use crate::error::Result;
use crate::force_law::{Elastic, elastic_forces, tooth_surfaces};

/// A chain with ideal hinges where the polygon effect tightens it most.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Tightness {
    /// Length that the chain lacks, room in the seats counted \[m\]; zero where it does not lack any.
    pub(super) shortage: f64,
    /// Tension of a chain whose bushings are pressed into their seats by as much \[N\], by Hertz' law.
    pub(super) tension: f64,
}

/// How tight the closed chain of `drive` gets while its sprockets turn by a pitch, if its hinges do not open and no centre gives way.
///
/// Seats that the bushings are pressed into by d, towards the middle of the wrap α, make both strands longer by d sin(α/2) each; the
/// tension follows from the work of the seats' forces.
///
/// # Errors
/// When no belt line can be laid.
pub(super) fn tightness(drive: &Drive) -> Result<Tightness> {
    let around = Around::new(drive)?;
    let Some(course) = around.course(0.0) else {
        return Ok(Tightness::default());
    };
    let slack = around.slack_strands()[0];
    let shift = |i: u32| f64::from(i) / f64::from(SHIFTS) - 0.5;
    let spare = (0..SHIFTS)
        .filter_map(|i| course.spare(slack, shift(i)))
        .fold(f64::INFINITY, f64::min);
    let wheels = || {
        let wraps = &around.line.belt.wraps;
        let order = around.line.order.iter();
        order
            .zip(wraps)
            .map(|(&i, &wrap)| (&around.profiles[i], wrap))
    };
    // What the strands gain for each metre that the seats give way.
    let gain: f64 = wheels().map(|(_, wrap)| 2.0 * (0.5 * wrap).sin()).sum();
    let room: f64 = wheels()
        .map(|(profile, wrap)| {
            2.0 * (0.5 * wrap).sin() * (-seat_depth(profile, &drive.chain)).max(0.0)
        })
        .sum();
    let shortage = (-spare - room).max(0.0);
    let depth = shortage / gain;
    let chain = &drive.chain;
    let pressed = wheels().map(|(profile, wrap)| {
        let seat = &tooth_surfaces(
            profile,
            chain.contact_radius(),
            chain.teeth_contact_length(),
            chain.material.contact_modulus(),
        )[0];
        let gap = profile.gap_angle();
        let seats = (wrap / gap).round();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of seats
        let along = (0..=seats as u32).map(|k| (gap * (f64::from(k) - 0.5 * seats)).cos().max(0.0));
        along
            .map(|share| elastic_forces(Elastic::Hertz, seat, &[share * depth])[0] * share)
            .sum::<f64>()
    });
    let tension = pressed.sum::<f64>() / gain;
    Ok(Tightness { shortage, tension })
}
