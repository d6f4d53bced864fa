//! Layout of a chain around two sprockets: choices of the generator, and errors.

use std::f64::consts::PI;

use super::closing::{closing_center_distance, links_for};
use super::fit::{TAUT_STRETCH, bow_fault, remedy, shortage, without_fault};
use super::laid_chain::{Lie, START_GAPS, phase, wheel};
use super::report::{LEAST_GRAVITY_ACROSS, Layout, given_speed, tension_force};
use crate::drive::{Drive, Sprocket};
use crate::error::{Error, Result};
use crate::geometry::path::belt::Side;
use crate::geometry::path::wrap;
use crate::geometry::path::wrap::{Path, Split, Strand, Wheel};
use crate::geometry::{ToothProfile, Vec2, turned_left};

/// Least centre distance that is proposed, over the sum of the outside radii, at which the sprockets overlap.
const LEAST_PROPOSED_DISTANCE: f64 = 1.02;
/// Pitches between the centre distance and that of the taut chain below which the division of the taut chain is tried first.
const NEARLY_TAUT: f64 = 1e-3;

/// A drive seen along its line of centres.
pub(super) struct TwoSprocketDrive<'a> {
    pub(super) drive: &'a Drive,
    pub(super) sprockets: [&'a Sprocket; 2],
    profiles: [ToothProfile; 2],
    pub(super) center_distance: f64,
    /// Unit vector from the first to the second centre.
    pub(super) axis: Vec2,
}

impl<'a> TwoSprocketDrive<'a> {
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
        let given = [0, 1].map(|i| given_speed(self.drive, i));
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
        if pull.abs() > LEAST_GRAVITY_ACROSS * self.drive.gravity.norm() {
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

    /// Return a remedy for messages.
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
        let distance = self.center_distance.max(LEAST_PROPOSED_DISTANCE * apart);
        let fewest = links_for(pitch, teeth, distance);
        let enough = if fewest == links && self.center_distance > apart {
            remedy(&self.drive.chain, fewest)
        } else {
            format!("a centre distance of {distance:.6} m takes {fewest} links")
        };
        format!("; {taut}; {enough}")
    }

    pub(super) fn find_path(&self) -> Result<Path> {
        let chain = &self.drive.chain;
        let pitch = chain.mean_pitch();
        let slack_strand = self.slack_strand();
        let needed = wrap::belt_length(pitch, self.teeth(), self.center_distance);
        let refuse = |why: String| {
            Err(Error::Impossible(format!(
                "the chain has no initial configuration: Chain.links = {} at a centre distance of {:.6} m, where a taut chain has \
                 {needed:.3} pitches: \
                 {why}{}",
                chain.links,
                self.center_distance,
                self.suggestion()
            )))
        };
        if let Some(shortage) = shortage(chain, needed) {
            return refuse(shortage);
        }
        let mut why = None; // what is wrong with the most natural path
        for gap in START_GAPS {
            let wheels = self.wheels(gap);
            let mut best: Option<(f64, Path)> = None;
            for split in self.splits(wheels, slack_strand) {
                let path = wrap::path_at(pitch, wheels, split, self.center_distance, slack_strand);
                let Some(path) = path.and_then(|path| self.fitted(path, &mut why)) else {
                    continue;
                };
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

    /// The path with links of their own lengths, where that has no fault; the first fault is kept in `why`.
    fn fitted(&self, mut path: Path, why: &mut Option<String>) -> Option<Path> {
        // A strand that is far too long is refused before its links are fitted, one by one.
        if let Some(fault) = Self::bow(&path) {
            why.get_or_insert(fault);
            return None;
        }
        let hinges = std::mem::take(&mut path.hinges);
        let fault = |hinges: &[Vec2]| {
            let lie = self.lie(hinges, &path.first_seat);
            lie.fault("every hinge of a strand", ["", ""])
        };
        path.hinges = without_fault(&self.drive.chain, hinges, why, fault)?;
        Some(path)
    }

    /// Wheels whose seated bushings start `gap` \[m\] off their seats at least.
    fn wheels(&self, gap: f64) -> [Wheel; 2] {
        [0, 1].map(|i| wheel(&self.profiles[i], &self.drive.chain, gap))
    }

    /// Splits to try: at the distance at which the chain is taut, the taut one first.
    fn splits(&self, wheels: [Wheel; 2], slack_strand: Strand) -> Vec<Split> {
        let chain = &self.drive.chain;
        let pitch = chain.mean_pitch();
        let taut = wrap::taut_path(pitch, wheels, chain.links)
            .filter(|path| {
                (path.center_distance - self.center_distance).abs() < NEARLY_TAUT * pitch
            })
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

    /// Return the fault of a strand that bows out too far, if any.
    fn bow(path: &Path) -> Option<String> {
        [(Strand::Upper, "upper"), (Strand::Lower, "lower")]
            .into_iter()
            .find_map(|(strand, name)| {
                let i = strand as usize;
                bow_fault(name, path.slack[i], path.spans[i], path.sag[i])
            })
    }

    /// The chain and both sprockets in the frame of the line of centres.
    fn lie<'b>(&'b self, hinges: &'b [Vec2], first_seat: &[f64; 2]) -> Lie<'b> {
        let at = |i: usize| {
            let x = if i == 0 { 0.0 } else { self.center_distance };
            (Vec2::new(x, 0.0), first_seat[i], &self.profiles[i])
        };
        Lie {
            chain: &self.drive.chain,
            hinges,
            sprockets: vec![at(0), at(1)],
        }
    }

    pub(super) fn layout(&self, path: &Path) -> Result<Layout> {
        let chain = &self.drive.chain;
        let pitch = chain.mean_pitch();
        let pitch_radius = [0, 1].map(|i| self.profiles[i].pitch_radius);
        let tilt = self.axis.y.atan2(self.axis.x);
        let lie = self.lie(&path.hinges, &path.first_seat);
        let [n1, n2] = self.teeth().map(f64::from);
        let tangent = ((pitch_radius[0] - pitch_radius[1]) / self.center_distance).acos();
        Ok(Layout {
            order: vec![0, 1],
            sides: vec![Side::Inside; 2],
            seat_of: path.seat_of.clone(),
            closing_center_distance: closing_center_distance(pitch, self.teeth(), chain.links),
            center_distance: Some(path.center_distance),
            belt_pitches: wrap::belt_length(pitch, self.teeth(), self.center_distance),
            belt_wrap: vec![2.0 * (PI - tangent), 2.0 * tangent],
            seat_offset: [0, 1]
                .map(|i| path.hinge_radius[i] - pitch_radius[i])
                .to_vec(),
            pitch_radius: pitch_radius.to_vec(),
            seated: path.split.seated.to_vec(),
            first_seat: path.first_seat.to_vec(),
            phase: [0, 1]
                .map(|i| phase(&self.profiles[i], path.first_seat[i] + tilt))
                .to_vec(),
            speeds: self.speeds().to_vec(),
            speed_ratio: vec![1.0, n1 / n2],
            strands: vec![[1, 0], [0, 1]],
            strand_pitches: path.split.strands.to_vec(),
            spans: path.spans.to_vec(),
            slack: path.slack.to_vec(),
            sag: path.sag.to_vec(),
            hinge_stretch: lie.stretch(),
            start_gap: lie.smallest_gap(),
            tension_force: tension_force(self.drive)?,
            ..Layout::default()
        })
    }
}
