//! Compiled guides: wheels without teeth, fixed, on bearings or on arms.

use super::{Guide, Ratchet, Rotation, SprocketModel, Support};
use crate::drive::{Arm, Chain, Mount, Rail, STOP_STIFFNESS};
use crate::error::Result;
use crate::geometry::path::belt::Side;
use crate::math::Signal;

/// Return the model of a guide: a wheel without teeth, fixed, rotating, or on an arm that swings about its pivot.
pub(super) fn place_rail(
    rail: &Rail,
    chain: &Chain,
    angle: f64,
    mut take: impl FnMut() -> usize,
) -> Result<SprocketModel> {
    // The outline for bushings: clipped at its middle, it is deeper than the described one.
    let outline = rail.for_bushings(chain.contact_radius());
    let (profile, offset) = (outline.profile()?, outline.offset());
    let gap_directions = vec![(1.0, 0.0), (-1.0, 0.0)];
    let mut free = |torque: Option<Signal>| Rotation::Free {
        index: take(),
        torque,
        curve: None,
    };
    let (rotation, inertia, swing) = match rail.mount {
        Mount::Fixed => (Rotation::Prescribed(0.0.into()), 1.0, None),
        Mount::Turning { inertia } => (free(None), inertia, None),
        Mount::Arm(arm) => {
            let torque = Signal::growing(arm.force * rail.lever(&arm), arm.ramp_time)?;
            let swing = swing_of(&arm, rail.lever(&arm));
            (free(Some(torque)), arm.inertia, Some(swing))
        }
    };
    Ok(SprocketModel {
        side: Side::Inside,
        reach: profile.reach(chain.contact_radius()) + offset.norm(),
        offset,
        profile,
        first_pair: 0,
        gap_directions,
        mass: 1.0,
        inertia,
        center: rail.bearing(),
        phase: if swing.is_some() { rail.angle() } else { angle },
        support: Support::Fixed,
        rotation,
        swing,
        input_bounds: None,
    })
}

/// Return spring, stops, dashpots and ratchet of a plunger as functions of the rotation of its arm, on which it presses at `lever` \[m\].
///
/// angle = displacement/lever, torque = force · lever: stiffness and damping scale with lever². A negative lever exchanges both directions.
fn swing_of(arm: &Arm, lever: f64) -> Guide {
    let [back, out] = arm.travel.map(|way| way / lever.abs());
    let square = lever * lever;
    let mut dashpots = [
        square * arm.damping_back.unwrap_or(arm.damping),
        square * arm.damping,
    ];
    let mut stops = [-back, out];
    if lever < 0.0 {
        dashpots.reverse();
        stops = [-out, back];
    }
    Guide {
        curvature: 0.0,
        stiffness: square * arm.stiffness,
        stops,
        stop_stiffness: square * STOP_STIFFNESS,
        dashpots,
        extra_mass: 0.0,
        ratchet: arm.ratchet.map(|step| Ratchet {
            step: step / lever.abs(),
            forward: lever.signum(),
        }),
    }
}
