//! Kinetic, gravitational and elastic energy of the whole drive.

use super::Dynamics;
use crate::chain::model::{Rotation, Support};
use crate::force_law::{ElasticLaw, depth_in_series};
use crate::geometry::Vec2;
use crate::system::Energy;

/// Return the energies at the last evaluation \[J\].
///
/// Bodies with prescribed motion are supports: fixed centres, prescribed rotations ([`prescribed_energy`]), and anchored or free ends have
/// no energy here.
pub(super) fn energy(dynamics: &Dynamics) -> Energy {
    let (model, motion) = (dynamics.model(), &dynamics.evaluated.motion);
    let mut energy = Energy::default();
    let mut add_body = |body: usize, mass: f64, inertia: f64| {
        let (vx, vy, spin) = (motion.vx[body], motion.vy[body], motion.spin[body]);
        // T = (m v² + J ω²)/2, V = -m g · r.
        energy.kinetic += 0.5 * mass * (vx * vx + vy * vy) + 0.5 * inertia * spin * spin;
        energy.gravity -= mass
            * model
                .gravity
                .dot(&Vec2::new(motion.x[body], motion.y[body]));
    };
    for i in (0..model.links).filter(|&i| !model.is_held(i)) {
        add_body(i, model.chain.mass[i], model.chain.inertia[i]);
    }
    if let Some(rollers) = &model.rollers {
        for k in (0..model.links).filter(|&k| model.bushing_is_there(k)) {
            add_body(model.links + k, rollers.mass, rollers.inertia);
        }
    }
    let (mut arms, mut springs) = (0.0, 0.0);
    for (s, sprocket) in model.sprockets.iter().enumerate() {
        let body = model.wheel_body(s);
        let mass = if sprocket.support == Support::Fixed {
            0.0
        } else {
            sprocket.mass
        };
        if let Support::Slide { guide, .. } = sprocket.support {
            let center = Vec2::new(motion.x[body], motion.y[body]);
            let (place, _) = sprocket.slide_at(center).unwrap_or_default();
            let (vx, vy) = (motion.vx[body], motion.vy[body]);
            arms += 0.5 * guide.extra_mass * (vx * vx + vy * vy);
            springs += guide.energy(place, dynamics.memory.pawls[s]);
        }
        if let Some(swing) = sprocket.swing {
            let turned = motion.angle[body] - sprocket.phase;
            springs += swing.energy(turned, dynamics.memory.pawls[s]);
        }
        let inertia = if matches!(sprocket.rotation, Rotation::Prescribed(_)) {
            0.0
        } else {
            sprocket.inertia
        };
        add_body(body, mass, inertia);
    }
    energy.kinetic += arms;
    energy.elastic = elastic_energy(dynamics) + springs;
    if !model.bristles.is_empty() {
        energy.elastic += dynamics.stored().total();
    }
    energy
}

/// Return the kinetic energy of the prescribed rotations \[J\].
pub(super) fn prescribed_energy(dynamics: &Dynamics) -> f64 {
    let (model, motion) = (dynamics.model(), &dynamics.evaluated.motion);
    let prescribed = model.sprockets.iter().enumerate();
    let prescribed = prescribed.filter(|(_, s)| matches!(s.rotation, Rotation::Prescribed(_)));
    prescribed
        .map(|(s, sprocket)| 0.5 * sprocket.inertia * motion.spin[model.wheel_body(s)].powi(2))
        .sum()
}

/// Return the elastic energy of all hinges, rollers and teeth \[J\].
fn elastic_energy(dynamics: &Dynamics) -> f64 {
    let model = dynamics.model();
    let law = &model.hinges.law.pairs;
    let (form, pair) = (law.form(), &law.pairs()[0]);
    let hinges = dynamics.evaluated.hinges.penetration.iter().enumerate();
    let hinges = hinges.map(|(k, &depth)| match model.hinges.compliance_at(k) {
        None => form.energy(pair, depth),
        Some(compliance) => {
            // Contact and plates in series: δ = δ_c + C f(δ_c), V = V_c(δ_c) + C f²/2.
            let pressed = depth_in_series(form, *pair, compliance, depth);
            let force = form.force(pair, pressed);
            form.energy(pair, pressed) + 0.5 * compliance * force * force
        }
    });
    let hinges: f64 = hinges.sum();
    let rollers: f64 = model.rollers.as_ref().map_or(0.0, |rollers| {
        let pair = rollers.law.pairs.pair(0);
        let depths = dynamics.evaluated.rollers.penetration.iter();
        depths.map(|&depth| pair.energy(depth)).sum()
    });
    let law = &model.teeth.law.pairs;
    let teeth = dynamics.evaluated.teeth.near.iter().map(|&pair| {
        let pair = pair as usize;
        let number = model.tooth_pair(pair / model.links, dynamics.stiffness_surface(pair));
        law.pair(number)
            .energy(dynamics.evaluated.teeth.penetration[pair])
    });
    let teeth: f64 = teeth.sum();
    hinges + teeth + rollers
}
