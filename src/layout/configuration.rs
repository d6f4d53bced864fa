//! Initial configuration of a run: positions and velocities of all bodies.

use serde::{Deserialize, Serialize};

use super::report::Layout;
use super::strand_motion;
use crate::drive::{Drive, bushing_on_front};
use crate::geometry::{Vec2, turned_left, unit};

/// Positions and velocities of all bodies at time zero.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct InitialConfiguration {
    /// (x, y, θ) of every body \[m, m, rad\].
    pub positions: Vec<[f64; 3]>,
    /// Their rates \[m/s, m/s, rad/s\].
    pub velocities: Vec<[f64; 3]>,
    /// Surfaces of the contacts of a static equilibrium, with whose stiffness it was found, as numbers from 0: bushing, sprocket, surface of
    /// the tooth; of a mechanism contact, side and piece of the profile. Contacts that are not listed begin on the nearest surface.
    pub surfaces: Vec<[usize; 3]>,
}

impl InitialConfiguration {
    /// Return the configuration with the bodies at other positions; hinge velocities change only to keep the links' lengths.
    #[must_use]
    pub fn moved_to(
        &self,
        positions: Vec<[f64; 3]>,
        layout: &Layout,
        pitches: &[f64],
        rollers: bool,
    ) -> Self {
        let n = layout.seat_of.len();
        let hinges = |positions: &[[f64; 3]]| -> Vec<Vec2> {
            let end = |i: usize, side: f64| {
                let [x, y, angle] = positions[i];
                Vec2::new(x, y) + 0.5 * side * pitches[i] * unit(angle)
            };
            (0..n)
                .map(|k| 0.5 * (end(k, 1.0) + end((k + 1) % n, -1.0)))
                .collect()
        };
        let velocity = |k: usize| {
            let end = |i: usize, side: f64| {
                let ([_, _, angle], [vx, vy, spin]) = (self.positions[i], self.velocities[i]);
                Vec2::new(vx, vy) + 0.5 * side * pitches[i] * spin * turned_left(unit(angle))
            };
            0.5 * (end(k, 1.0) + end((k + 1) % n, -1.0))
        };
        let places = hinges(&positions);
        let mut velocities: Vec<Vec2> = (0..n).map(velocity).collect();
        strand_motion::keep_all_lengths(&layout.seat_of, &places, &mut velocities);
        let moving = velocities;
        let links = (0..n).map(|front| {
            let rear = (front + n - 1) % n;
            let [_, rates] = link_between(
                [rear, front].map(|k| places[k]),
                [rear, front].map(|k| moving[k]),
            );
            rates
        });
        let mut velocities: Vec<[f64; 3]> =
            links.chain(self.velocities[n..].iter().copied()).collect();
        if rollers {
            for (roller, hinge) in velocities[n..2 * n].iter_mut().zip(&moving) {
                [roller[0], roller[1]] = (*hinge).into();
            }
        }
        Self {
            positions,
            velocities,
            surfaces: Vec::new(),
        }
    }

    /// Return rollers concentric with the bushings at these hinges, with the angular velocities of their links.
    pub(super) fn add_rollers(&mut self, hinges: &[Vec2], velocities: &[Vec2]) {
        let n = hinges.len();
        for (k, (place, velocity)) in hinges.iter().zip(velocities).enumerate() {
            let link = if bushing_on_front(k, n) {
                k
            } else {
                (k + 1) % n
            };
            let spin = self.velocities[link][2];
            self.positions.push([place.x, place.y, 0.0]);
            self.velocities.push([velocity.x, velocity.y, spin]);
        }
    }

    /// Return the bodies from the hinges.
    pub(super) fn of_bodies(
        drive: &Drive,
        hinges: &[Vec2],
        velocities: &[Vec2],
        layout: &Layout,
    ) -> Self {
        let mut start = Self::default();
        for front in 0..hinges.len() {
            let ends = [(front + hinges.len() - 1) % hinges.len(), front];
            start.add(link_between(
                ends.map(|k| hinges[k]),
                ends.map(|k| velocities[k]),
            ));
        }
        if drive.chain.roller.is_some() {
            start.add_rollers(hinges, velocities);
        }
        start.add_sprockets(drive, layout);
        start
    }

    /// Add a body with its position and its velocity.
    pub(super) fn add(&mut self, [position, velocity]: [[f64; 3]; 2]) {
        self.positions.push(position);
        self.velocities.push(velocity);
    }

    /// Add the sprockets at their centres, with the angles and speeds of the layout.
    pub(super) fn add_sprockets(&mut self, drive: &Drive, layout: &Layout) {
        let turns = layout.phase.iter().zip(&layout.speeds);
        for (sprocket, (&phase, &speed)) in drive.sprockets.iter().zip(turns) {
            let center = sprocket.center;
            self.add([[center.x, center.y, phase], [0.0, 0.0, speed]]);
        }
    }
}

/// Return position and velocity of a link from those of its rear and front hinge: centre and velocity are the means, the angular
/// velocity is (d x dv)/d².
pub(super) fn link_between([rear, front]: [Vec2; 2], speeds: [Vec2; 2]) -> [[f64; 3]; 2] {
    let (along, apart) = (front - rear, speeds[1] - speeds[0]);
    let center = 0.5 * (front + rear);
    let velocity = 0.5 * (speeds[1] + speeds[0]);
    let spin = along.perp(&apart) / along.norm_squared();
    let angle = along.y.atan2(along.x);
    [[center.x, center.y, angle], [velocity.x, velocity.y, spin]]
}
