//! Normal forces of all contacts of one kind: one law, one loop.

use crate::contact::{HingeContacts, ImpactMemory, ToothContacts};
use crate::force_law::{ElasticLaw, Regions, damping_factor, depth_in_series};
use crate::model::Model;

/// Forces of all hinges \[N\], with λ and what the plates give way by \[m/N\]; returns the dissipated power \[W\] when `ENERGY` is asked for.
pub(super) fn hinge_forces<L: ElasticLaw, const ENERGY: bool>(
    pair: &L::Pair,
    (lambda, compliance): (f64, Option<f64>),
    memory: &ImpactMemory,
    hinges: &mut HingeContacts,
) -> f64 {
    let mut dissipated = 0.0;
    for k in 0..hinges.force.len() {
        let depth = hinges.penetration[k];
        if depth <= 0.0 {
            hinges.force[k] = 0.0;
            continue;
        }
        let rate = hinges.rate[k];
        let pressed = compliance.map_or(depth, |c| depth_in_series::<L>(pair, c, depth));
        let elastic = L::force(pair, pressed);
        let force = elastic
            * damping_factor(
                lambda,
                rate,
                memory.onset_speed(memory.hinge_speed()[k], rate),
            );
        hinges.force[k] = force;
        if ENERGY {
            dissipated += (force - elastic) * rate;
        }
    }
    dissipated
}

/// Forces of all bushings that are near a sprocket \[N\]; returns the dissipated power \[W\] when `ENERGY` is asked for.
pub(super) fn tooth_forces<L: ElasticLaw, const ENERGY: bool>(
    pairs: &[L::Pair],
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
