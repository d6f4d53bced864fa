//! How the chain of a drive is laid round its sprockets: the choices of the generator, and what cannot be laid.

use std::f64::consts::PI;

use super::fit::fit;
use crate::drive::{Drive, Motion, Sprocket};
use crate::error::{Error, Result};
use crate::geometry::wrap::{self, Path, Split, Strand, Wheel};
use crate::geometry::{ToothProfile, Vec2, turned_left, unit};

/// How far off its seat a bushing starts that would otherwise touch \[m\]; a stretched chain, whose bushings stand beside
/// the middle of their seats, may need more.
const START_GAPS: [f64; 4] = [1e-6, 3e-6, 1e-5, 3e-5];
/// Share of the hinge clearance below which a stretched chain counts as taut.
const TAUT_STRETCH: f64 = 0.02;
/// Share of the hinge clearance that a chain may be stretched by at the start.
const LARGEST_STRETCH: f64 = 0.9;
/// Largest angle of a slack strand's bow at its ends \[rad\].
const LARGEST_BOW: f64 = 0.45 * PI;

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

/// A drive seen along its line of centres.
pub(super) struct Place<'a> {
    pub(super) drive: &'a Drive,
    pub(super) sprockets: [&'a Sprocket; 2],
    profiles: [ToothProfile; 2],
    pub(super) center_distance: f64,
    /// Unit vector from the first to the second centre.
    pub(super) axis: Vec2,
}

impl<'a> Place<'a> {
    pub(super) fn new(drive: &'a Drive) -> Result<Self> {
        let chain = &drive.chain;
        let sprockets = [&drive.sprockets[0], &drive.sprockets[1]];
        let profiles = [
            sprockets[0].tooth_profile(chain)?,
            sprockets[1].tooth_profile(chain)?,
        ];
        let between = sprockets[1].center - sprockets[0].center;
        let center_distance = between.norm();
        let apart = profiles[0].outside_radius + profiles[1].outside_radius;
        let place = Self {
            drive,
            sprockets,
            profiles,
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
    pub(super) fn speeds(&self) -> [f64; 2] {
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
            return if pull < 0.0 {
                Strand::Lower
            } else {
                Strand::Upper
            };
        }
        if self.speeds()[0] >= 0.0 {
            Strand::Lower
        } else {
            Strand::Upper
        }
    }

    /// What would work instead, for messages.
    fn suggestion(&self) -> String {
        let (pitch, teeth, links) = (
            self.drive.chain.mean_pitch(),
            self.teeth(),
            self.drive.chain.links,
        );
        let taut = match closing_center_distance(pitch, teeth, links) {
            Some(distance) => {
                format!("{links} links are taut at a centre distance of {distance:.6} m")
            }
            None => format!(
                "{links} links are too few for {} and {} teeth at any centre distance",
                teeth[0], teeth[1]
            ),
        };
        let apart = self.profiles[0].outside_radius + self.profiles[1].outside_radius;
        let distance = self.center_distance.max(1.02 * apart);
        let fewest = links_for(pitch, teeth, distance);
        format!("; {taut}; a centre distance of {distance:.6} m takes {fewest} links")
    }

    pub(super) fn find_path(&self) -> Result<Path> {
        let chain = &self.drive.chain;
        let pitch = chain.mean_pitch();
        let slack_strand = self.slack_strand();
        let needed = wrap::belt_length(pitch, self.teeth(), self.center_distance);
        let refuse = |why: String| {
            Err(Error::Impossible(format!(
                "the chain cannot be laid: {} links at a centre distance of {:.6} m, where a taut chain has {needed:.3} pitches: \
                 {why}{}",
                chain.links,
                self.center_distance,
                self.suggestion()
            )))
        };
        let stretch = (needed - f64::from(chain.links)) * pitch / f64::from(chain.links);
        let allowed = LARGEST_STRETCH * chain.hinge.clearance();
        if stretch > 3.0 * allowed + 0.01 * pitch {
            return refuse(format!(
                "it is {:.3} mm too short, {:.1} um a hinge, and a hinge's clearance gives {:.1} um",
                1e3 * (needed - f64::from(chain.links)) * pitch,
                1e6 * stretch,
                1e6 * chain.hinge.clearance()
            ));
        }
        let mut why = None; // what is wrong with the most natural path
        for gap in START_GAPS {
            let wheels = self.wheels(gap);
            let mut best: Option<(f64, Path)> = None;
            for split in self.splits(wheels, slack_strand) {
                let path = wrap::path_at(pitch, wheels, split, self.center_distance, slack_strand);
                let Some(path) = path.and_then(|path| self.fitted(path)) else {
                    continue;
                };
                if let Some(fault) = self.fault(&path) {
                    why.get_or_insert(fault);
                    continue;
                }
                // Taut or slack as it should be; a stretched one waits for a better split.
                let stretch = [0, 1]
                    .map(|i| -path.slack[i] / f64::from(path.split.strands[i]))
                    .into_iter()
                    .fold(0.0, f64::max);
                if stretch <= TAUT_STRETCH * chain.hinge.clearance() {
                    return Ok(path);
                }
                if best.as_ref().is_none_or(|(least, _)| stretch < *least) {
                    best = Some((stretch, path));
                }
            }
            if let Some((_, path)) = best {
                return Ok(path);
            }
        }
        refuse(why.unwrap_or_else(|| "no whole numbers of pitches fit the strands".to_string()))
    }

    /// The path with links of their own lengths, where they differ.
    fn fitted(&self, mut path: Path) -> Option<Path> {
        let pitches = self.drive.chain.link_pitches();
        let mean = self.drive.chain.mean_pitch();
        if pitches.iter().all(|&pitch| (pitch - mean).abs() <= 1e-15) {
            return Some(path);
        }
        // Hinges that the path opens stay as open.
        let n = pitches.len();
        let lengths: Vec<f64> = (0..n)
            .map(|i| {
                let laid = path.hinges[i] - path.hinges[(i + n - 1) % n];
                laid.norm() + (pitches[i] - mean)
            })
            .collect();
        fit(&mut path.hinges, &lengths).then_some(path)
    }

    /// Wheels whose seated bushings start `gap` \[m\] off their seats at least.
    fn wheels(&self, gap: f64) -> [Wheel; 2] {
        let radius = self.drive.chain.bushing_radius;
        [0, 1].map(|i| {
            let profile = &self.profiles[i];
            // A chain that is longer than its pitch lies farther out.
            let hinge_circle = wrap::pitch_radius(self.drive.chain.mean_pitch(), profile.teeth);
            let on_pitch_circle = Vec2::new(0.0, hinge_circle - profile.seat_center_radius);
            let depth = profile.contact(on_pitch_circle, radius).penetration;
            Wheel {
                teeth: profile.teeth,
                hinge_radius: hinge_circle + (depth + gap).max(0.0),
            }
        })
    }

    /// Splits to try: at the distance at which the chain is taut, the taut one first.
    fn splits(&self, wheels: [Wheel; 2], slack_strand: Strand) -> Vec<Split> {
        let chain = &self.drive.chain;
        let pitch = chain.mean_pitch();
        let taut = wrap::taut_path(pitch, wheels, chain.links)
            .filter(|path| (path.center_distance - self.center_distance).abs() < 1e-3 * pitch)
            .map(|path| path.split);
        let others = wrap::splits_at(
            pitch,
            self.teeth(),
            chain.links,
            self.center_distance,
            slack_strand,
        );
        taut.into_iter().chain(others).collect()
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
        (gap < 0.9 * START_GAPS[0]).then(|| {
            format!(
                "a bushing would start {:.3} um off a tooth (negative: inside)",
                1e6 * gap
            )
        })
    }

    /// Ends of every link as the model will have them, (rear, front): its hinges lie at half a pitch from its middle.
    fn link_ends(&self, path: &Path) -> Vec<(Vec2, Vec2)> {
        let n = path.hinges.len();
        let pitches = self.drive.chain.link_pitches();
        (0..n)
            .map(|i| {
                let (rear, front) = (path.hinges[(i + n - 1) % n], path.hinges[i]);
                let middle = 0.5 * (rear + front);
                let half = 0.5 * pitches[i] * (front - rear).normalize();
                (middle - half, middle + half)
            })
            .collect()
    }

    /// Largest distance of a pin's centre from its bushing's \[m\].
    fn stretch(&self, path: &Path) -> f64 {
        let ends = self.link_ends(path);
        let next = ends.iter().cycle().skip(1);
        ends.iter()
            .zip(next)
            .map(|((_, front), (rear, _))| (front - rear).norm())
            .fold(0.0, f64::max)
    }

    /// Smallest distance of a bushing from a tooth \[m\].
    fn smallest_gap(&self, path: &Path) -> f64 {
        let radius = self.drive.chain.bushing_radius;
        let bushings: Vec<Vec2> = self
            .link_ends(path)
            .into_iter()
            .step_by(2) // the inner links
            .flat_map(|(rear, front)| [rear, front])
            .collect();
        let mut gap = f64::INFINITY;
        for (i, profile) in self.profiles.iter().enumerate() {
            let center = Vec2::new(if i == 0 { 0.0 } else { self.center_distance }, 0.0);
            for bushing in &bushings {
                let offset = bushing - center;
                if offset.norm() >= profile.reach(radius) {
                    continue;
                }
                let gap_angle = profile.gap_angle();
                let nearest = ((offset.y.atan2(offset.x) - path.first_seat[i]) / gap_angle).round();
                let middle = unit(path.first_seat[i] + nearest * gap_angle);
                let point = Vec2::new(
                    offset.x * middle.y - offset.y * middle.x,
                    offset.dot(&middle) - profile.seat_center_radius,
                );
                gap = gap.min(-profile.contact(point, radius).penetration);
            }
        }
        gap
    }

    pub(super) fn layout(&self, path: Path) -> Layout {
        let chain = &self.drive.chain;
        let pitch = chain.mean_pitch();
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
        let [first, second] = self.speeds();
        if (first * n1 - second * n2).abs() > 0.01 * (first * n1).abs().max((second * n2).abs()) {
            warnings.push(format!(
                "the sprockets start at {first:.4} and {second:.4} rad/s, which pull the chain at different speeds"
            ));
        }
        Layout {
            closing_center_distance: closing_center_distance(pitch, self.teeth(), chain.links),
            pitch_radius,
            seat_offset: [0, 1].map(|i| path.hinge_radius[i] - pitch_radius[i]),
            phase,
            hinge_stretch: self.stretch(&path),
            start_gap: self.smallest_gap(&path),
            speed_ratio: n1 / n2,
            tension_force: self.drive.tensioner.map_or(0.0, |t| {
                crate::model::tensioner_pull(self.drive, t.pretension)
            }),
            warnings,
            path,
        }
    }
}

/// Centre distance \[m\] at which a chain of `links` lies taut round two sprockets, its hinges on the pitch circles.
#[must_use]
pub fn closing_center_distance(pitch: f64, teeth: [u32; 2], links: u32) -> Option<f64> {
    wrap::taut_path(
        pitch,
        teeth.map(|n| Wheel::on_pitch_circle(pitch, n)),
        links,
    )
    .map(|path| path.center_distance)
}

/// Smallest even number of links that closes at a centre distance \[m\].
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of links
pub fn links_for(pitch: f64, teeth: [u32; 2], center_distance: f64) -> u32 {
    let needed = wrap::belt_length(pitch, teeth, center_distance);
    let mut links = 2 * (0.5 * needed - 0.05).ceil().max(2.0) as u32;
    // The chain is a polygon: a taut one of this many links may still fall a little short.
    while closing_center_distance(pitch, teeth, links)
        .is_some_and(|c| c < center_distance * (1.0 - 1e-12))
    {
        links += 2;
    }
    links
}
