//! Compiled guides: wheels without teeth, fixed, on bearings or on arms.

use super::{Guide, Ratchet, Rotation, SprocketModel, Support};
use crate::drive::{Chain, Mount, Rail, STOP_STIFFNESS};
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
    let profile = rail.for_bushings(chain.contact_radius()).profile()?;
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
            let lever = rail.lever(&arm);
            let torque = arm.force * lever;
            let torque = if arm.ramp_time > 0.0 {
                Signal::ramp(0.0, arm.ramp_time, 0.0, torque)?
            } else {
                torque.into()
            };
            // Conversion from the plunger's displacement to the arm's angle: angle = displacement/lever, torque = force · lever. Stiffness
            // and damping scale with lever². A negative lever exchanges both directions.
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
            let swing = Guide {
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
            };
            (free(Some(torque)), arm.inertia, Some(swing))
        }
    };
    Ok(SprocketModel {
        side: Side::Inside,
        reach: profile.reach(chain.contact_radius()) + rail.offset().norm(),
        offset: rail.offset(),
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
