//! Recorded rows of hinges, rollers, teeth and sprockets.

use super::ends;
use crate::chain::dynamics::Dynamics;
use crate::chain::report::{ToothContacts, pairs};
use crate::geometry::Vec2;
use crate::geometry::path::belt::Pulley;
use crate::layout::ChainRow;
use crate::system::Row;

/// Write force, force vector, penetration, eccentricity and impact velocity of every hinge, and the strand tensions. Ideal hinges have
/// the distance of their ends as penetration, and no impact velocity.
pub(super) fn write_hinges(row: &mut Row, dynamics: &Dynamics) {
    let hinges = &dynamics.evaluated.hinges;
    row.copy(hinges.recorded_forces());
    row.vectors(hinges.forces_on_pins());
    if dynamics.model().hinges.ideal {
        row.real(hinges.distances());
        row.vectors(hinges.eccentricities());
    } else {
        row.copy(&hinges.penetration);
        row.vectors(hinges.eccentricities());
        row.real(onset_speeds(
            &hinges.penetration,
            dynamics.memory.hinge_impact_velocity(),
        ));
    }
    row.real(strand_tensions(dynamics));
}

/// Return the tensions of the strands \[N\], in the order of the model's strands.
fn strand_tensions(dynamics: &Dynamics) -> Vec<f64> {
    let (model, motion, hinges) = (
        dynamics.model(),
        &dynamics.evaluated.motion,
        &dynamics.evaluated.hinges,
    );
    // The first strand of an open chain leaves no sprocket.
    let wheels = || {
        let from = model.strands.iter().map(|[from, _]| *from);
        from.filter(|&s| s < model.toothed())
    };
    let pulley = |s: usize| {
        let body = model.wheel_body(s);
        Pulley {
            center: Vec2::new(motion.x[body], motion.y[body]),
            radius: model.sprockets[s].profile.pitch_radius,
            side: model.sprockets[s].side,
        }
    };
    let mut links = [&motion.x, &motion.y].map(|axis| axis[..model.links].to_vec());
    if let Some(ends) = &model.ends {
        // The centre of a load leaves the line of the chain as it swings; with it, a strand of -22 N counted as 5 N.
        for (body, arm) in ends::arms(dynamics, ends) {
            links[0][body] += arm.x;
            links[1][body] += arm.y;
        }
    }
    let chain = ChainRow {
        links: links.each_ref().map(Vec::as_slice),
        bushings: hinges.bushing.each_ref().map(Vec::as_slice),
        on_front: hinges.on_front.each_ref().map(Vec::as_slice),
        pulleys: &wheels().map(pulley).collect::<Vec<_>>(),
        reaches: &wheels()
            .map(|s| model.sprockets[s].reach)
            .collect::<Vec<_>>(),
    };
    if model.ends.is_some() {
        chain.open_strand_tensions(|k| model.hinge_is_open(k))
    } else {
        chain.strand_tensions()
    }
}

/// Write force, force vector, penetration, eccentricity and impact velocity of every bushing in its roller.
pub(super) fn write_rollers(row: &mut Row, dynamics: &Dynamics) {
    let rollers = &dynamics.evaluated.rollers;
    row.copy(&rollers.force);
    row.vectors(rollers.forces_on_rollers());
    row.copy(&rollers.penetration);
    row.vectors(pairs(&rollers.eccentricity));
    row.real(onset_speeds(
        &rollers.penetration,
        dynamics.memory.roller_impact_velocity(),
    ));
}

/// Return the initial impact velocities of closed contacts, and 0 for open ones \[m/s\].
fn onset_speeds<'a>(depths: &'a [f64], speeds: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    let pairs = depths.iter().zip(speeds);
    pairs.map(|(&depth, &speed)| if depth > 0.0 { speed } else { 0.0 })
}

/// Write the tooth contact with the largest penetration of every bushing; without contact, only the penetration.
#[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // few sprockets, gaps and regions
pub(super) fn write_teeth(row: &mut Row, dynamics: &Dynamics) {
    let (teeth, sprockets) = (&dynamics.evaluated.teeth, &dynamics.model().sprockets);
    let force = row.next_real();
    let (vector, _) = row.next_real().as_chunks_mut::<2>();
    let [penetration, onset_speed] = [row.next_real(), row.next_real()];
    let [sprocket, gap, region] = [0; 3].map(|_| row.next_whole());
    force.fill(0.0);
    vector.fill([0.0; 2]);
    penetration.fill(f64::NEG_INFINITY);
    onset_speed.fill(0.0);
    sprocket.fill(0);
    gap.fill(-1);
    region.fill(0);
    for (pair, s, k) in teeth.pairs() {
        let depth = teeth.penetration[pair];
        if depth <= penetration[k] {
            continue;
        }
        penetration[k] = depth;
        if depth > 0.0 {
            force[k] = teeth.force[pair];
            vector[k] = [teeth.on_bushing[0][pair], teeth.on_bushing[1][pair]];
            onset_speed[k] = dynamics.memory.tooth_impact_velocity[pair];
            sprocket[k] = s as i32 + 1;
            gap[k] = teeth.gap[pair] as i32;
            region[k] = i32::from(teeth.region(&sprockets[s].profile, pair));
        }
    }
}

/// Write angle, speed, torque and centre of every sprocket and guide at time `t` \[s\].
pub(super) fn write_sprockets(row: &mut Row, dynamics: &Dynamics, t: f64) {
    let model = dynamics.model();
    let sprockets = model.wheel_body(0)..model.bodies();
    row.copy(&dynamics.evaluated.motion.angle[sprockets.clone()]);
    row.copy(&dynamics.evaluated.motion.spin[sprockets.clone()]);
    row.real((0..model.sprockets.len()).map(|s| {
        dynamics.evaluated.accelerations.shaft_torque(
            model,
            s,
            t,
            dynamics.evaluated.motion.spin[model.wheel_body(s)],
        )
    }));
    row.vectors(sprockets.map(|body| {
        [
            dynamics.evaluated.motion.x[body],
            dynamics.evaluated.motion.y[body],
        ]
    }));
}

/// Sum the tooth forces on every bushing over all sprockets \[N\].
pub(super) fn gather_by_bushing(teeth: &ToothContacts, forces: &mut [f64]) {
    forces.fill(0.0);
    for (pair, _, k) in teeth.pairs() {
        forces[k] += teeth.force[pair];
    }
}
