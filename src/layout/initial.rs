//! Initial configuration of a run: positions and velocities of all bodies without contact.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::many_sprockets::Around;
use super::open_layout;
use super::report::Layout;
use super::strand_motion;
use super::two_sprockets::TwoSprocketDrive;
use crate::drive::Drive;
use crate::drive::bushing_on_front;
use crate::error::{Error, Result};
use crate::geometry::path::belt::Side;
use crate::geometry::path::wrap::Path;
use crate::geometry::{Vec2, turned_left, unit};

/// Largest number of layouts round eccentric teeth.
const MOST_ROUNDS: usize = 30;
/// Largest rotation of the wheels, in tooth gaps, where the iteration over eccentric positions does not converge.
const MOST_TURNS: u32 = 12;
/// Change of the positions in the last iteration, over the pitch: rounding.
const SETTLED: f64 = 1e-10;

/// Message of a search that its caller gave up.
pub(super) const GIVEN_UP: &str = "the search for an initial configuration was given up";

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
    /// Lay the chain of `drive` round its sprockets, and place its guides.
    ///
    /// # Errors
    /// When no initial configuration exists: the message has the numbers and the nearest possible configuration.
    pub fn generate(drive: &Drive) -> Result<(Self, Layout)> {
        Self::generate_unless(drive, &|| false)
    }

    /// Lay the chain as [`Self::generate`] does. The search, which may take seconds, ends with an error soon after `give_up` returns true.
    ///
    /// # Errors
    /// As [`Self::generate`], and when the search was given up.
    pub fn generate_unless(drive: &Drive, give_up: &dyn Fn() -> bool) -> Result<(Self, Layout)> {
        drive.validate()?;
        let (start, mut layout) = Self::lay_round(drive, give_up)?;
        let start = start.with_guides(drive, &mut layout)?;
        Ok((start, layout))
    }

    fn lay_round(drive: &Drive, give_up: &dyn Fn() -> bool) -> Result<(Self, Layout)> {
        if (drive.sprockets.iter()).all(|sprocket| sprocket.faults.eccentricity == 0.0) {
            return Self::lay(drive, give_up);
        }
        // The positions of eccentric teeth depend on the angles of the layout, which jump where another layout becomes
        // the better one. Rotated by a gap, the wheels jump at other positions.
        let gaps = drive.sprockets.iter().map(|s| s.teeth).min().unwrap_or(1);
        let mut why = None;
        for turned in (0..gaps.min(MOST_TURNS)).map(f64::from) {
            match Self::lay_eccentric(drive, turned, give_up) {
                Ok(Some(laid)) => return Ok(laid),
                Ok(None) => {}
                Err(error) if give_up() => return Err(error),
                Err(error) => {
                    why.get_or_insert(error);
                }
            }
        }
        Err(why.unwrap_or_else(|| {
            Error::Impossible(format!(
                "the chain has no initial configuration: the places of eccentric teeth, of eccentricities {:?} m, do not settle; \
                 take smaller \
                 ones or other angles",
                (drive.sprockets.iter())
                    .map(|sprocket| sprocket.faults.eccentricity)
                    .collect::<Vec<f64>>()
            ))
        }))
    }

    /// Lay the chain of `drive` round eccentric teeth, all wheels rotated by this number of gaps; `None` without convergence.
    fn lay_eccentric(
        drive: &Drive,
        turned: f64,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Option<(Self, Layout)>> {
        let gap = |i: usize| TAU / f64::from(drive.sprockets[i].teeth);
        let mut centered = drive.clone();
        let mut before: Option<Vec<f64>> = None;
        for _ in 0..MOST_ROUNDS {
            let (mut start, mut layout) = Self::lay(&centered, give_up)?;
            for (i, phase) in layout.phase.iter_mut().enumerate() {
                // The same gap in every iteration.
                let near = before.as_ref().map_or(turned * gap(i), |phase| phase[i]);
                *phase += ((near - *phase) / gap(i)).round() * gap(i);
                start.positions[drive.first_wheel() + i][2] = *phase;
            }
            let mut moved: f64 = 0.0;
            for (i, sprocket) in drive.sprockets.iter().enumerate() {
                let offset = sprocket.faults.offset();
                let angle = unit(layout.phase[i]);
                let teeth = sprocket.center + offset.x * angle + offset.y * turned_left(angle);
                moved = moved.max((teeth - centered.sprockets[i].center).norm());
                centered.sprockets[i].center = teeth;
                let body = drive.first_wheel() + i;
                [start.positions[body][0], start.positions[body][1]] = sprocket.center.into();
            }
            if moved <= SETTLED * drive.chain.pitch {
                return Ok(Some((start, layout)));
            }
            before = Some(layout.phase);
        }
        Ok(None)
    }

    fn lay(drive: &Drive, give_up: &dyn Fn() -> bool) -> Result<(Self, Layout)> {
        if give_up() {
            return Err(Error::Impossible(GIVEN_UP.to_string()));
        }
        if let Some(ends) = &drive.ends {
            return open_layout::lay(drive, ends);
        }
        if drive.sprockets.len() == 2 && drive.sprockets.iter().all(|s| s.side == Side::Inside) {
            let place = TwoSprocketDrive::new(drive)?;
            let path = place.find_path()?;
            let layout = place.layout(&path)?;
            return Ok((place.start(&path, &layout), layout));
        }
        let around = Around::new(drive)?;
        let found = around.find(give_up)?;
        let (speeds, velocities) = strand_motion::of(drive, &around.line, &found);
        let layout = around.layout(&found, speeds)?;
        let start = Self::of_bodies(drive, &found.polygon.hinges, &velocities, &layout);
        Ok((start, layout))
    }

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
    fn add_rollers(&mut self, hinges: &[Vec2], velocities: &[Vec2]) {
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
    fn of_bodies(drive: &Drive, hinges: &[Vec2], velocities: &[Vec2], layout: &Layout) -> Self {
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
    let spin = (along.x * apart.y - along.y * apart.x) / along.norm_squared();
    let angle = along.y.atan2(along.x);
    [[center.x, center.y, angle], [velocity.x, velocity.y, spin]]
}

impl TwoSprocketDrive<'_> {
    fn start(&self, path: &Path, layout: &Layout) -> InitialConfiguration {
        let origin = self.sprockets[0].center;
        let to_world = |p: Vec2| p.x * self.axis + p.y * turned_left(self.axis);
        let hinges: Vec<Vec2> = path.hinges.iter().map(|&p| origin + to_world(p)).collect();
        let velocities = self.hinge_velocities(path, self.speeds());
        let velocities: Vec<Vec2> = velocities.into_iter().map(to_world).collect();
        InitialConfiguration::of_bodies(self.drive, &hinges, &velocities, layout)
    }

    /// Seated hinges rotate with their sprocket; along a strand the velocity is linear from end to end.
    fn hinge_velocities(&self, path: &Path, speeds: [f64; 2]) -> Vec<Vec2> {
        let center = |i: usize| Vec2::new(if i == 0 { 0.0 } else { self.center_distance }, 0.0);
        let turned = |k: usize, i: usize| speeds[i] * turned_left(path.hinges[k] - center(i));
        strand_motion::linear_between_seats(&path.seat_of, turned)
    }
}
