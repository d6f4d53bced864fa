//! Drive whose equilibrium is sought: motors held, loads and tensioner as after their ramps, chain laid nearly taut.

use crate::drive::{ChainEnd, Drive, Mount, SprocketMotion, Tensioner};
use crate::error::Result;
use crate::geometry::path::guide_path;
use crate::layout::{InitialConfiguration, Layout};
use crate::math::Signal;

/// Decrement of the tensioner's displacement from the taut position in each further attempt of the layout, in pitches.
const STEP_BACK: f64 = 0.05;
/// Number of these attempts. In 45 random drives with a layout, the fourth had it at the latest; a refusal takes up to 0.3 s each.
const MOST_STEPS_BACK: u32 = 20;

/// Return the drive with its motors held, and with all dependence on time and speed fixed at the start.
pub(super) fn held(drive: &Drive, layout: &Layout) -> Drive {
    let mut held = drive.clone();
    for (sprocket, &speed) in held.sprockets.iter_mut().zip(&layout.speeds) {
        sprocket.initial_speed = None;
        sprocket.motion = match &sprocket.motion {
            SprocketMotion::PrescribedSpeed(_) => SprocketMotion::PrescribedSpeed(0.0.into()),
            SprocketMotion::AppliedTorque(torque) => {
                SprocketMotion::AppliedTorque(torque.value(0.0).into())
            }
            SprocketMotion::TorqueCurve { torque, curve } => {
                SprocketMotion::AppliedTorque(Signal::from(torque.value(0.0) + curve.value(speed)))
            }
            SprocketMotion::Free => SprocketMotion::Free,
        };
    }
    for end in held.ends.iter_mut().flatten() {
        if let ChainEnd::Anchored { velocity, .. } = end {
            *velocity = [0.0.into(), 0.0.into()];
        }
    }
    held.end_ramps();
    if let Some(tensioner) = &mut held.tensioner {
        // The displacement locked by a ratchet would depend on the history of the motion.
        tensioner.ratchet = None;
    }
    for guide in &mut held.guides {
        if let Mount::Arm(arm) = &mut guide.mount {
            arm.ratchet = None;
        }
    }
    held
}

/// Generate the layout with the tensioner at the taut position, or as near to it as a layout exists. A tensioner that starts far from it
/// would drag the chain around all other sprockets, tooth by tooth; of two, the chain is laid round the described centres.
pub(super) fn lay_taut(
    drive: &Drive,
    give_up: &dyn Fn() -> bool,
) -> Result<(InitialConfiguration, Layout)> {
    let taut = |tensioner: &Tensioner| -> Option<(InitialConfiguration, Layout)> {
        let line = tensioner.line(drive).ok()?;
        let [_, forth] = tensioner.travel;
        let farthest = line.taut_at?.min(forth);
        let step = STEP_BACK * drive.chain.pitch;
        let mut places = (0..MOST_STEPS_BACK).map(|i| farthest - f64::from(i) * step);
        let mut places = places.by_ref().take_while(|&s| s > 0.0 && !give_up());
        places.find_map(|s| {
            let mut there = drive.clone();
            there.tensioner = None;
            there.sprockets[tensioner.sprocket - 1].center +=
                guide_path::along(line.direction, line.curvature, s).0;
            InitialConfiguration::generate_unless(&there, give_up).ok()
        })
    };
    let tensioner = drive.tensioner.as_ref();
    match tensioner
        .filter(|tensioner| !tensioner.separates_two_sprockets(drive))
        .and_then(taut)
    {
        Some(laid) => Ok(laid),
        None => InitialConfiguration::generate_unless(drive, give_up),
    }
}
