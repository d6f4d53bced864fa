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
    let moves = || motion.each_position().zip(motion.each_velocity());
    let open = model.ends.is_some();
    let constants = model.chain.mass.iter().zip(&model.chain.inertia);
    for (i, (moves, (&mass, &inertia))) in moves().zip(constants).enumerate() {
        if !open || !model.is_held(i) {
            energy.add_body(mass, inertia, moves, model.gravity);
        }
    }
    if let Some(rollers) = &model.rollers {
        for (k, moves) in moves().skip(model.links).take(model.links).enumerate() {
            if !open || model.bushing_is_there(k) {
                energy.add_body(rollers.mass, rollers.inertia, moves, model.gravity);
            }
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
        let place = [motion.x[body], motion.y[body], motion.angle[body]];
        let moves = (place, [motion.vx[body], motion.vy[body], motion.spin[body]]);
        energy.add_body(mass, inertia, moves, model.gravity);
    }
    energy.kinetic += arms;
    energy.elastic = elastic_energy(dynamics) + springs;
    if !model.bristles.is_empty() {
        energy.elastic += dynamics.stored().total();
    }
    energy
}

impl Energy {
    /// Add a body at (x, y, θ) with these velocities: T = (m v² + J ω²)/2, V = -m g · r.
    #[inline]
    fn add_body(
        &mut self,
        mass: f64,
        inertia: f64,
        ([x, y, _], [vx, vy, spin]): ([f64; 3], [f64; 3]),
        gravity: Vec2,
    ) {
        self.kinetic += 0.5 * mass * (vx * vx + vy * vy) + 0.5 * inertia * spin * spin;
        self.gravity -= mass * gravity.dot(&Vec2::new(x, y));
    }
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
    let depths = &dynamics.evaluated.hinges.penetration;
    let hinges = match &model.hinges.compliance {
        None => form.energy_of_all(pair, depths),
        Some(compliance) => {
            let hinges = depths.iter().zip(compliance);
            let energies = hinges.map(|(&depth, &compliance)| {
                // Contact and plates in series: δ = δ_c + C f(δ_c), V = V_c(δ_c) + C f²/2.
                let pressed = depth_in_series(form, *pair, compliance, depth);
                let force = form.force(pair, pressed);
                form.energy(pair, pressed) + 0.5 * compliance * force * force
            });
            energies.sum()
        }
    };
    let rollers = model.rollers.as_ref().map_or(0.0, |rollers| {
        let depths = &dynamics.evaluated.rollers.penetration;
        rollers.law.pairs.pair(0).energy_of_all(depths)
    });
    let (law, teeth) = (&model.teeth.law.pairs, &dynamics.evaluated.teeth);
    let pressed = teeth
        .pairs()
        .filter(|&(pair, ..)| teeth.penetration[pair] > 0.0);
    let teeth: f64 = pressed
        .map(|(pair, s, _)| {
            let number = model.tooth_pair(s, dynamics.stiffness_surface(pair));
            law.pair(number).energy(teeth.penetration[pair])
        })
        .sum();
    hinges + teeth + rollers
}
