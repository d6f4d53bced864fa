//! Generation of the initial configuration: the chain is laid round its sprockets, without contact.

use std::f64::consts::TAU;

use super::configuration::InitialConfiguration;
use super::many_sprockets::{Around, GIVEN_UP};
use super::open_layout;
use super::report::Layout;
use super::strand_motion;
use super::two_sprockets::TwoSprocketDrive;
use crate::drive::Drive;
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
        let centered = Self::lay(drive, give_up)?;
        if (drive.sprockets.iter()).all(|sprocket| sprocket.faults.eccentricity == 0.0) {
            return Ok(centered);
        }
        // The positions of eccentric teeth depend on the angles of the layout, which jump where another layout becomes
        // the better one. Rotated by a gap, the wheels jump at other positions.
        let gaps = drive.sprockets.iter().map(|s| s.teeth).min().unwrap_or(1);
        let mut why = None;
        for turned in (0..gaps.min(MOST_TURNS)).map(f64::from) {
            match Self::lay_eccentric(drive, centered.clone(), turned, give_up) {
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

    /// Lay the chain of `drive` round eccentric teeth, from that round centered ones, all wheels rotated by this number of gaps; `None`
    /// without convergence.
    fn lay_eccentric(
        drive: &Drive,
        laid: (Self, Layout),
        turned: f64,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Option<(Self, Layout)>> {
        let gap = |i: usize| TAU / f64::from(drive.sprockets[i].teeth);
        let mut centered = drive.clone();
        let mut before: Option<Vec<f64>> = None;
        let described = laid.1.clone();
        let mut first = Some(laid);
        for _ in 0..MOST_ROUNDS {
            let (mut start, mut layout) = match first.take() {
                Some(laid) => laid,
                None => Self::lay(&centered, give_up)?,
            };
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
                // These are of the sprockets where they are described. The strands are those between the teeth.
                layout.tension_force = described.tension_force;
                layout.center_distance = described.center_distance;
                layout.belt_pitches = described.belt_pitches;
                layout.belt_wrap = described.belt_wrap;
                layout.warn(drive);
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
            let (start, mut layout) = open_layout::lay(drive, ends)?;
            layout.warn(drive);
            return Ok((start, layout));
        }
        if drive.sprockets.len() == 2 && drive.sprockets.iter().all(|s| s.side == Side::Inside) {
            let place = TwoSprocketDrive::new(drive)?;
            let path = place.find_path()?;
            let mut layout = place.layout(&path)?;
            layout.warn(drive);
            return Ok((place.start(&path, &layout), layout));
        }
        let around = Around::new(drive)?;
        let found = around.find(give_up)?;
        let (speeds, velocities) = strand_motion::of(drive, &around.line, &found);
        let mut layout = around.layout(&found, speeds)?;
        layout.warn(drive);
        let start = Self::of_bodies(drive, &found.polygon.hinges, &velocities, &layout);
        Ok((start, layout))
    }
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
