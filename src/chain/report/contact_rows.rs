//! Recorded rows of hinges, rollers, teeth and sprockets.

use super::ToothContacts;
use super::end_rows;
use crate::chain::dynamics::Dynamics;
use crate::geometry::Vec2;
use crate::geometry::path::belt::Pulley;
use crate::layout::ChainRow;
use crate::system::Row;

/// Write force, force vector, penetration, eccentricity and impact velocity of every hinge, and the strand tensions.
pub(super) fn write_hinges(row: &mut Row, dynamics: &Dynamics) {
    let hinges = &dynamics.evaluated.hinges;
    let n = hinges.force.len();
    row.real(hinges.force.iter().copied());
    row.real((0..n).flat_map(|k| <[f64; 2]>::from(hinges.force_on_pin(k))));
    row.real(hinges.penetration.iter().copied());
    row.real((0..n).flat_map(|k| <[f64; 2]>::from(hinges.eccentricity(k))));
    row.real(onset_speeds(
        &hinges.penetration,
        dynamics.memory.hinge_impact_velocity(),
    ));
    if dynamics.model().ends.is_some() {
        row.real(end_rows::tensions(dynamics));
    } else {
        row.real(strand_tensions(dynamics));
    }
}

/// Return the tensions of the strands of a closed chain \[N\], in the order of the model's strands.
fn strand_tensions(dynamics: &Dynamics) -> Vec<f64> {
    let (model, motion, hinges) = (
        dynamics.model(),
        &dynamics.evaluated.motion,
        &dynamics.evaluated.hinges,
    );
    let place = |body: usize| Vec2::new(motion.x[body], motion.y[body]);
    let wheels = || model.strands.iter().map(|[from, _]| *from);
    let pulley = |s: usize| Pulley {
        center: place(model.wheel_body(s)),
        radius: model.sprockets[s].profile.pitch_radius,
        side: model.sprockets[s].side,
    };
    let links = 0..model.links;
    ChainRow {
        links: &links.clone().map(place).collect::<Vec<_>>(),
        bushings: &links
            .clone()
            .map(|k| hinges.bushing(k).0)
            .collect::<Vec<_>>(),
        on_front: &links.map(|k| hinges.force_on_front(k)).collect::<Vec<_>>(),
        pulleys: &wheels().map(pulley).collect::<Vec<_>>(),
        reaches: &wheels()
            .map(|s| model.sprockets[s].reach)
            .collect::<Vec<_>>(),
    }
    .strand_tensions()
}

/// Write force, force vector, penetration, eccentricity and impact velocity of every bushing in its roller.
pub(super) fn write_rollers(row: &mut Row, dynamics: &Dynamics) {
    let rollers = &dynamics.evaluated.rollers;
    let n = rollers.force.len();
    row.real(rollers.force.iter().copied());
    row.real((0..n).flat_map(|k| <[f64; 2]>::from(rollers.force_on_roller(k))));
    row.real(rollers.penetration.iter().copied());
    row.real(
        rollers
            .eccentricity
            .iter()
            .flat_map(|&e| <[f64; 2]>::from(e)),
    );
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

/// Write the tooth contact with the largest penetration of every bushing.
#[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // few sprockets, gaps and regions
pub(super) fn write_teeth(row: &mut Row, dynamics: &Dynamics) {
    let (teeth, model) = (&dynamics.evaluated.teeth, dynamics.model());
    let (links, sprockets) = (model.links, model.sprockets.len());
    let deepest: Vec<(usize, f64)> = (0..links)
        .map(|k| {
            (0..sprockets)
                .map(|s| (s * links + k, teeth.penetration[s * links + k]))
                .fold((k, f64::NEG_INFINITY), |a, b| if b.1 > a.1 { b } else { a })
        })
        .collect();
    row.real(
        deepest
            .iter()
            .map(|&(pair, depth)| if depth > 0.0 { teeth.force[pair] } else { 0.0 }),
    );
    row.real(deepest.iter().flat_map(|&(pair, depth)| {
        if depth > 0.0 {
            <[f64; 2]>::from(teeth.force_on_bushing(pair))
        } else {
            [0.0; 2]
        }
    }));
    row.real(deepest.iter().map(|&(_, depth)| depth));
    row.real(deepest.iter().map(|&(pair, depth)| {
        if depth > 0.0 {
            dynamics.memory.tooth_impact_velocity[pair]
        } else {
            0.0
        }
    }));
    row.whole(deepest.iter().map(|&(pair, depth)| {
        if depth > 0.0 {
            (pair / links + 1) as i32
        } else {
            0
        }
    }));
    row.whole(deepest.iter().map(|&(pair, depth)| {
        if depth > 0.0 {
            teeth.gap[pair] as i32
        } else {
            -1
        }
    }));
    row.whole(deepest.iter().map(|&(pair, depth)| {
        if depth > 0.0 {
            i32::from(teeth.region[pair])
        } else {
            0
        }
    }));
}

/// Write angle, speed, torque and centre of every sprocket and guide at time `t` \[s\].
pub(super) fn write_sprockets(row: &mut Row, dynamics: &Dynamics, t: f64) {
    let model = dynamics.model();
    let sprockets = model.wheel_body(0)..model.bodies();
    row.real(
        dynamics.evaluated.motion.angle[sprockets.clone()]
            .iter()
            .copied(),
    );
    row.real(
        dynamics.evaluated.motion.spin[sprockets.clone()]
            .iter()
            .copied(),
    );
    row.real((0..model.sprockets.len()).map(|s| {
        dynamics.evaluated.accelerations.shaft_torque(
            model,
            s,
            t,
            dynamics.evaluated.motion.spin[model.wheel_body(s)],
        )
    }));
    row.real(sprockets.flat_map(|body| {
        [
            dynamics.evaluated.motion.x[body],
            dynamics.evaluated.motion.y[body],
        ]
    }));
}

/// Sum the tooth forces on every bushing over all sprockets \[N\].
pub(super) fn gather_by_bushing(teeth: &ToothContacts, links: usize, forces: &mut [f64]) {
    forces.fill(0.0);
    for &pair in &teeth.near {
        forces[pair as usize % links] += teeth.force[pair as usize];
    }
}
