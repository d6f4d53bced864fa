//! The start generated from a drive: where every body lies and how it moves, with nothing in contact.

use std::f64::consts::PI;

use crate::drive::{Drive, Motion, Sprocket};
use crate::error::{Error, Result};
use crate::geometry::wrap::{self, Path, Strand, Wheel};
use crate::geometry::{ToothProfile, Vec2, turned_left, unit};

/// How far off its seat a bushing starts that would otherwise touch \[m\].
const START_GAP: f64 = 1e-6;
/// Share of the hinge clearance that a chain may be stretched by at the start.
const LARGEST_STRETCH: f64 = 0.9;
/// Largest angle of a slack strand's bow at its ends \[rad\].
const LARGEST_BOW: f64 = 0.45 * PI;

/// Positions and velocities of all bodies at time zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// (x, y, θ) of every body \[m, m, rad\].
    pub positions: Vec<[f64; 3]>,
    /// Their rates \[m/s, m/s, rad/s\].
    pub velocities: Vec<[f64; 3]>,
}

/// What the generator chose.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Chain and path in the frame of the line of centres.
    pub path: Path,
    /// Centre distance at which the chain is taut \[m\], where there is one.
    pub closing_center_distance: Option<f64>,
    /// Pitch radii \[m\].
    pub pitch_radius: [f64; 2],
    /// How far outside the pitch circle the seated hinges start \[m\].
    pub seat_offset: [f64; 2],
    /// θ of each sprocket \[rad\].
    pub phase: [f64; 2],
    /// Largest opening of a hinge at the start \[m\]: the chain is stretched by this much a pitch.
    pub hinge_stretch: f64,
    /// Smallest distance of a bushing from a tooth at the start \[m\].
    pub start_gap: f64,
    /// Mean speed of the second sprocket over that of the first.
    pub speed_ratio: f64,
    /// Pull of the tensioner \[N\].
    pub tension_force: f64,
    /// What a designer should know.
    pub warnings: Vec<String>,
}

impl Start {
    /// Lays the chain of `drive` round its sprockets.
    ///
    /// # Errors
    /// When no such start exists: the numbers that show why, and the nearest that works.
    pub fn generate(drive: &Drive) -> Result<(Self, Layout)> {
        drive.validate()?;
        let place = Place::new(drive)?;
        let path = place.find_path()?;
        let layout = place.layout(path);
        Ok((place.start(&layout), layout))
    }
}

/// A drive seen along its line of centres.
struct Place<'a> {
    drive: &'a Drive,
    sprockets: [&'a Sprocket; 2],
    profiles: [ToothProfile; 2],
    wheels: [Wheel; 2],
    center_distance: f64,
    /// Unit vector from the first to the second centre.
    axis: Vec2,
}

impl<'a> Place<'a> {
    fn new(drive: &'a Drive) -> Result<Self> {
        let chain = &drive.chain;
        let sprockets = [&drive.sprockets[0], &drive.sprockets[1]];
        let profiles = sprockets.map(|s| s.tooth_profile(chain));
        let wheels = [0, 1].map(|i| Wheel {
            teeth: sprockets[i].teeth,
            hinge_radius: seated_radius(&profiles[i], chain.bushing_radius),
        });
        let between = sprockets[1].center - sprockets[0].center;
        let center_distance = between.norm();
        let apart = profiles[0].outside_radius + profiles[1].outside_radius;
        let place = Self {
            drive,
            sprockets,
            profiles,
            wheels,
            center_distance,
            axis: if center_distance > 0.0 {
                between / center_distance
            } else {
                Vec2::new(1.0, 0.0)
            },
        };
        if center_distance <= apart {
            return Err(Error::Impossible(format!(
                "sprockets overlap: their centres are {center_distance:.6} m apart, their outside radii {:.6} m and {:.6} m \
                 need more than {apart:.6} m{}",
                place.profiles[0].outside_radius,
                place.profiles[1].outside_radius,
                place.suggestion()
            )));
        }
        Ok(place)
    }

    fn teeth(&self) -> [u32; 2] {
        self.sprockets.map(|s| s.teeth)
    }

    /// Angular speeds at the start \[rad/s\]: as given, else what turns both at one mean chain speed.
    fn speeds(&self) -> [f64; 2] {
        let given = self.sprockets.map(|s| match &s.motion {
            Motion::PrescribedSpeed(table) => Some(table.value(0.0)),
            _ => s.initial_speed,
        });
        let [n1, n2] = self.teeth().map(f64::from);
        match given {
            [Some(first), Some(second)] => [first, second],
            [Some(first), None] => [first, first * (n1 / n2)],
            [None, Some(second)] => [second * (n2 / n1), second],
            [None, None] => [0.0, 0.0],
        }
    }

    /// The strand that hangs outward under gravity takes the slack; without gravity, the one that leaves the driver.
    fn slack_strand(&self) -> Strand {
        let up = turned_left(self.axis);
        let pull = self.drive.gravity.dot(&up);
        if pull.abs() > 1e-9 * self.drive.gravity.norm() {
            return if pull < 0.0 { Strand::Lower } else { Strand::Upper };
        }
        if self.speeds()[0] >= 0.0 {
            Strand::Lower
        } else {
            Strand::Upper
        }
    }

    /// What would work instead, for messages.
    fn suggestion(&self) -> String {
        let (pitch, teeth, links) = (self.drive.chain.pitch, self.teeth(), self.drive.chain.links);
        let mut text = String::new();
        if let Some(distance) = closing_center_distance(pitch, teeth, links) {
            text += &format!("; {links} links are taut at a centre distance of {distance:.6} m");
        } else {
            text += &format!(
                "; {links} links are too few for {} and {} teeth at any centre distance",
                teeth[0], teeth[1]
            );
        }
        let apart = self.profiles[0].outside_radius + self.profiles[1].outside_radius;
        let distance = self.center_distance.max(1.02 * apart);
        let fewest = links_for(pitch, teeth, distance);
        text + &format!("; a centre distance of {distance:.6} m takes {fewest} links")
    }

    fn find_path(&self) -> Result<Path> {
        let chain = &self.drive.chain;
        let slack_strand = self.slack_strand();
        let needed = wrap::belt_length(chain.pitch, self.teeth(), self.center_distance);
        let refuse = |why: String| {
            Err(Error::Impossible(format!(
                "the chain cannot be laid: {} links at a centre distance of {:.6} m, where a taut chain has {needed:.3} pitches: \
                 {why}{}",
                chain.links,
                self.center_distance,
                self.suggestion()
            )))
        };
        let stretch = (needed - f64::from(chain.links)) * chain.pitch / f64::from(chain.links);
        let allowed = LARGEST_STRETCH * chain.hinge.clearance();
        if stretch > 3.0 * allowed + 0.01 * chain.pitch {
            return refuse(format!(
                "it is {:.3} mm too short, {:.1} um a hinge, and a hinge's clearance gives {:.1} um",
                1e3 * (needed - f64::from(chain.links)) * chain.pitch,
                1e6 * stretch,
                1e6 * chain.hinge.clearance()
            ));
        }
        let mut why = "no whole numbers of pitches fit the strands".to_string();
        for split in wrap::splits_at(
            chain.pitch,
            self.teeth(),
            chain.links,
            self.center_distance,
            slack_strand,
        ) {
            let Some(path) = wrap::path_at(chain.pitch, self.wheels, split, self.center_distance, slack_strand) else {
                continue;
            };
            match self.fault(&path) {
                None => return Ok(path),
                Some(fault) => why = fault,
            }
        }
        refuse(why)
    }

    /// Why a path will not do.
    fn fault(&self, path: &Path) -> Option<String> {
        let chain = &self.drive.chain;
        let stretch = self.stretch(path);
        if stretch >= LARGEST_STRETCH * chain.hinge.clearance() {
            return Some(format!(
                "it would open every hinge of a strand by {:.1} um, and their clearance is {:.1} um",
                1e6 * stretch,
                1e6 * chain.hinge.clearance()
            ));
        }
        for (strand, name) in [(Strand::Upper, "upper"), (Strand::Lower, "lower")] {
            let i = strand as usize;
            let (span, sag) = (path.spans[i], path.sag[i]);
            let bow = 2.0 * (2.0 * sag / span).atan();
            if bow > LARGEST_BOW {
                return Some(format!(
                    "the {name} strand has {:.3} mm of slack over {:.3} mm and would bow out by {:.3} mm",
                    1e3 * path.slack[i],
                    1e3 * span,
                    1e3 * sag
                ));
            }
        }
        let gap = self.smallest_gap(path);
        (gap <= 0.0).then(|| format!("a bushing would start {:.3} um deep in a tooth", -1e6 * gap))
    }

    /// Largest excess of the distance of two neighbouring hinges over the pitch \[m\].
    fn stretch(&self, path: &Path) -> f64 {
        neighbours(&path.hinges)
            .map(|(a, b)| (b - a).norm() - self.drive.chain.pitch)
            .fold(0.0, |a, b| a.max(b.abs()))
    }

    fn smallest_gap(&self, path: &Path) -> f64 {
        let radius = self.drive.chain.bushing_radius;
        let mut gap = f64::INFINITY;
        for (i, profile) in self.profiles.iter().enumerate() {
            let center = Vec2::new(if i == 0 { 0.0 } else { self.center_distance }, 0.0);
            for hinge in &path.hinges {
                let offset = hinge - center;
                if offset.norm() >= profile.reach(radius) {
                    continue;
                }
                let angle = offset.y.atan2(offset.x) - path.first_seat[i];
                let middle = unit(path.first_seat[i] + f64::from(profile.nearest_gap(angle)) * profile.gap_angle());
                let point = Vec2::new(
                    offset.x * middle.y - offset.y * middle.x,
                    offset.dot(&middle) - profile.seat_center_radius,
                );
                gap = gap.min(-profile.contact(point, radius).penetration);
            }
        }
        gap
    }

    fn layout(&self, path: Path) -> Layout {
        let chain = &self.drive.chain;
        let pitch_radius = [0, 1].map(|i| self.profiles[i].pitch_radius);
        let tilt = self.axis.y.atan2(self.axis.x);
        let phase = [0, 1].map(|i| {
            let gap = self.profiles[i].gap_angle();
            let angle = path.first_seat[i] + tilt;
            angle - (angle / gap).round() * gap
        });
        let mut warnings = Vec::new();
        for (i, name) in ["upper", "lower"].iter().enumerate() {
            let share = path.sag[i] / path.spans[i];
            if share > 0.06 {
                warnings.push(format!(
                    "the {name} strand sags by {:.1} % of its span; 4 to 6 % is usual",
                    100.0 * share
                ));
            }
        }
        for i in 0..2 {
            let wrap = f64::from(path.split.seated[i]) * self.profiles[i].gap_angle().to_degrees();
            if wrap < 120.0 {
                warnings.push(format!(
                    "sprocket {} is wrapped by {wrap:.0} degrees only; 120 is usual",
                    i + 1
                ));
            }
        }
        let [n1, n2] = self.teeth().map(f64::from);
        Layout {
            closing_center_distance: closing_center_distance(chain.pitch, self.teeth(), chain.links),
            pitch_radius,
            seat_offset: [0, 1].map(|i| self.wheels[i].hinge_radius - pitch_radius[i]),
            phase,
            hinge_stretch: self.stretch(&path),
            start_gap: self.smallest_gap(&path),
            speed_ratio: n1 / n2,
            tension_force: self
                .drive
                .tensioner
                .map_or(0.0, |t| crate::model::tensioner_pull(self.drive, t.pretension)),
            warnings,
            path,
        }
    }

    /// Bodies from hinges: a link's centre and velocity are the means of its two hinges, its rate is (d x dv)/d².
    fn start(&self, layout: &Layout) -> Start {
        let speeds = self.speeds();
        let origin = self.sprockets[0].center;
        let to_world = |p: Vec2| p.x * self.axis + p.y * turned_left(self.axis);
        let hinges: Vec<Vec2> = layout.path.hinges.iter().map(|&p| origin + to_world(p)).collect();
        let velocities = self.hinge_velocities(&layout.path, speeds);
        let velocities: Vec<Vec2> = velocities.into_iter().map(to_world).collect();

        let mut start = Start {
            positions: Vec::new(),
            velocities: Vec::new(),
        };
        for front in 0..hinges.len() {
            let rear = (front + hinges.len() - 1) % hinges.len();
            let along = hinges[front] - hinges[rear];
            let apart = velocities[front] - velocities[rear];
            let center = 0.5 * (hinges[front] + hinges[rear]);
            let velocity = 0.5 * (velocities[front] + velocities[rear]);
            let spin = (along.x * apart.y - along.y * apart.x) / along.norm_squared();
            start.positions.push([center.x, center.y, along.y.atan2(along.x)]);
            start.velocities.push([velocity.x, velocity.y, spin]);
        }
        for i in 0..2 {
            let center = self.sprockets[i].center;
            start.positions.push([center.x, center.y, layout.phase[i]]);
            start.velocities.push([0.0, 0.0, speeds[i]]);
        }
        start
    }

    /// Seated hinges turn with their sprocket; along a strand the velocity changes linearly from end to end.
    fn hinge_velocities(&self, path: &Path, speeds: [f64; 2]) -> Vec<Vec2> {
        let n = path.hinges.len();
        let seated = |k: usize| {
            path.seat_of[k].map(|i| {
                let center = Vec2::new(if i == 0 { 0.0 } else { self.center_distance }, 0.0);
                speeds[i] * turned_left(path.hinges[k] - center)
            })
        };
        let mut velocities = vec![Vec2::zeros(); n];
        let mut last_seat = (0, Vec2::zeros());
        let mut k = 0;
        while k < n {
            if let Some(velocity) = seated(k) {
                velocities[k] = velocity;
                last_seat = (k, velocity);
                k += 1;
                continue;
            }
            let next = (k..n).find(|&j| path.seat_of[j].is_some()).unwrap_or(n);
            let ahead = seated(next % n).unwrap_or_default();
            let (from, behind) = last_seat;
            for (j, velocity) in velocities.iter_mut().enumerate().take(next).skip(k) {
                let share = (j - from) as f64 / (next - from) as f64;
                *velocity = behind + share * (ahead - behind);
            }
            k = next;
        }
        velocities
    }
}

/// Neighbours round the loop.
fn neighbours(hinges: &[Vec2]) -> impl Iterator<Item = (Vec2, Vec2)> {
    hinges.iter().copied().zip(hinges.iter().copied().cycle().skip(1))
}

/// Radius on which seated hinges start \[m\]: the pitch circle's, or a little outside where a bushing there would touch.
fn seated_radius(profile: &ToothProfile, bushing_radius: f64) -> f64 {
    let on_pitch_circle = Vec2::new(0.0, profile.pitch_radius - profile.seat_center_radius);
    let depth = profile.contact(on_pitch_circle, bushing_radius).penetration;
    profile.pitch_radius + (depth + START_GAP).max(0.0)
}

/// Centre distance \[m\] at which a chain of `links` lies taut round two sprockets, its hinges on the pitch circles.
#[must_use]
pub fn closing_center_distance(pitch: f64, teeth: [u32; 2], links: u32) -> Option<f64> {
    wrap::taut_path(pitch, teeth.map(|n| Wheel::on_pitch_circle(pitch, n)), links).map(|path| path.center_distance)
}

/// Smallest even number of links that closes at a centre distance \[m\].
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of links
pub fn links_for(pitch: f64, teeth: [u32; 2], center_distance: f64) -> u32 {
    let needed = wrap::belt_length(pitch, teeth, center_distance);
    let mut links = 2 * (0.5 * needed - 0.05).ceil().max(2.0) as u32;
    // The chain is a polygon: a taut one of this many links may still fall a little short.
    while closing_center_distance(pitch, teeth, links).is_some_and(|c| c < center_distance * (1.0 - 1e-12)) {
        links += 2;
    }
    links
}
