//! Normal forces of all contacts of one kind: one law, one loop.

use crate::chain::contact::{HingeContacts, ImpactMemory, RollerContacts, ToothContacts};
use crate::chain::model::Model;
use crate::force_law::{ElasticLaw, Regions, damping_factor, depth_in_series};

/// Contacts of one pair of cylinders, one in the other: depths \[m\], their rates and onset speeds, zero without memory \[m/s\].
struct Joints<'a> {
    penetration: &'a [f64],
    rate: &'a [f64],
    onset: &'a [f64],
}

/// Forces of all hinges \[N\], with λ and what the plates at each give way by \[m/N\]; returns the dissipated power \[W\] when `ENERGY` is asked for.
pub(super) fn hinge_forces<L: ElasticLaw, const ENERGY: bool>(
    pair: &[f64; 2],
    (lambda, compliance): (f64, Option<&[f64]>),
    memory: &ImpactMemory,
    hinges: &mut HingeContacts,
) -> f64 {
    let joints = Joints {
        penetration: &hinges.penetration,
        rate: &hinges.rate,
        onset: memory.hinge_speed(),
    };
    joint_forces::<L, ENERGY>(
        pair,
        (lambda, compliance),
        memory,
        &joints,
        &mut hinges.force,
    )
}

/// Forces of all bushings in their rollers, likewise.
pub(super) fn roller_forces<L: ElasticLaw, const ENERGY: bool>(
    pair: &[f64; 2],
    lambda: f64,
    memory: &ImpactMemory,
    rollers: &mut RollerContacts,
) -> f64 {
    let joints = Joints {
        penetration: &rollers.penetration,
        rate: &rollers.rate,
        onset: memory.roller_speed(),
    };
    joint_forces::<L, ENERGY>(pair, (lambda, None), memory, &joints, &mut rollers.force)
}

fn joint_forces<L: ElasticLaw, const ENERGY: bool>(
    pair: &[f64; 2],
    (lambda, compliance): (f64, Option<&[f64]>),
    memory: &ImpactMemory,
    joints: &Joints,
    forces: &mut [f64],
) -> f64 {
    let mut dissipated = 0.0;
    for (k, place) in forces.iter_mut().enumerate() {
        let depth = joints.penetration[k];
        if depth <= 0.0 {
            *place = 0.0;
            continue;
        }
        let rate = joints.rate[k];
        let pressed =
            compliance.map_or(depth, |all| depth_in_series::<f64, L>(*pair, all[k], depth));
        let elastic = L::force(pair, pressed);
        let onset = memory.onset_speed(joints.onset[k], rate);
        let force = elastic * damping_factor(lambda, rate, onset);
        *place = force;
        if ENERGY {
            dissipated += (force - elastic) * rate;
        }
    }
    dissipated
}

/// Forces of all bushings that are near a sprocket \[N\]; returns the dissipated power \[W\] when `ENERGY` is asked for.
pub(super) fn tooth_forces<L: ElasticLaw, const ENERGY: bool>(
    pairs: &[[f64; 2]],
    model: &Model,
    memory: &ImpactMemory,
    teeth: &mut ToothContacts,
) -> f64 {
    let kept = model.tooth_law.regions == Regions::Kept;
    let lambda = model.tooth_law.lambda;
    let mut dissipated = 0.0;
    for &pair in &teeth.near {
        let pair = pair as usize;
        let depth = teeth.penetration[pair];
        if depth <= 0.0 {
            teeth.force[pair] = 0.0;
            continue;
        }
        let rate = teeth.rate[pair];
        let remembered = memory.tooth_speed[pair];
        let surface = if kept && remembered > 0.0 {
            memory.tooth_surface[pair]
        } else {
            teeth.surface[pair]
        };
        let elastic = L::force(&pairs[model.tooth_pair(pair / model.links, surface)], depth);
        let force = elastic * damping_factor(lambda, rate, memory.onset_speed(remembered, rate));
        teeth.force[pair] = force;
        if ENERGY {
            dissipated += (force - elastic) * rate;
        }
    }
    dissipated
}
