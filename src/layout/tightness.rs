//! Tightness of a chain with ideal hinges: its missing length and the resulting tension.

use super::laid_chain::seat_depth;
use super::many_sprockets::{Around, shifts};
use crate::drive::Drive;
use crate::error::Result;
use crate::force_law::{Elastic, elastic_forces, tooth_surfaces};

/// Tightness at the position where the polygon action is largest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Tightness {
    /// Missing length of the chain after the clearance of the seats \[m\]; zero for a chain that is long enough.
    pub(super) shortage: f64,
    /// Tension of a chain whose bushings penetrate their seats by as much \[N\], by Hertz' law.
    pub(super) tension: f64,
}

/// Return the tightness of the closed chain of `drive` over one pitch of rotation, with ideal hinges and fixed centres.
///
/// A penetration d of the seats towards the middle of the wrap α makes both strands longer by d sin(α/2) each; the
/// tension follows from the work of the seats' forces.
///
/// # Errors
/// When no belt line exists.
pub(super) fn tightness(drive: &Drive) -> Result<Tightness> {
    let around = Around::new(drive)?;
    let Some(course) = around.course(0.0) else {
        return Ok(Tightness::default());
    };
    let slack = around.slack_strands()[0];
    let spare = shifts()
        .filter_map(|shift| course.spare(slack, shift))
        .fold(f64::INFINITY, f64::min);
    let wheels = || {
        let wraps = &around.line.belt.wraps;
        let order = around.line.order.iter();
        order
            .zip(wraps)
            .map(|(&i, &wrap)| (&around.profiles[i], wrap))
    };
    // Elongation of the strands per unit of penetration.
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
