//! Layout of a chain round any number of sprockets inside and outside of it, and the reasons of failure.

use std::f64::consts::PI;

use super::closing::even_links;
use super::fit::{for_own_lengths, remedy};
use super::laid_chain::{Lie, phase, wheel};
use super::report::{LARGEST_STRETCH, Layout, START_GAPS, given_speed, strand_name, tension_force};
use crate::drive::{BeltLine, Drive};
use crate::error::{Error, Result};
use crate::geometry::path::polygon::{PlacedWheel, Polygon, WheelSequence, bow_angle};
use crate::geometry::{ToothProfile, turned_left};

/// Share of the hinge clearance below which a stretched chain counts as taut.
const TAUT_STRETCH: f64 = 0.02;
/// Largest angle at the ends of a slack strand's bow \[rad\]: nearly vertical ends.
const LARGEST_BOW: f64 = 0.45 * PI;
/// Number of positions of the first seat within a pitch that are tried.
pub(super) const SHIFTS: u32 = 48;

/// A drive and its belt line.
pub(super) struct Around<'a> {
    drive: &'a Drive,
    pub(super) line: BeltLine,
    /// Profiles of the sprockets in their described order.
    pub(super) profiles: Vec<ToothProfile>,
}

/// A chain laid round its sprockets.
pub(super) struct ClosedLayout {
    pub(super) course: WheelSequence,
    pub(super) polygon: Polygon,
    /// The strand with the slack.
    pub(super) slack: usize,
}

impl<'a> Around<'a> {
    pub(super) fn new(drive: &'a Drive) -> Result<Self> {
        let profiles = drive
            .sprockets
            .iter()
            .map(|s| s.tooth_profile(&drive.chain))
            .collect::<Result<_>>()?;
        Ok(Self {
            line: BeltLine::of(drive)?,
            drive,
            profiles,
        })
    }

    /// Return the wheels in the order of the chain, with seated bushings at least `gap` \[m\] off their seats.
    pub(super) fn course(&self, gap: f64) -> Option<WheelSequence> {
        let chain = &self.drive.chain;
        let placed = |&i: &usize| PlacedWheel {
            wheel: wheel(&self.profiles[i], chain, gap),
            center: self.drive.sprockets[i].center,
            side: self.drive.sprockets[i].side,
        };
        let wheels = self.line.order.iter().map(placed).collect();
        WheelSequence::new(chain.mean_pitch(), chain.links, wheels).ok()
    }

    /// Return the strands in the order in which they are tried for the slack: the largest outward component of gravity first; without
    /// gravity, the strand that leaves the driver.
    pub(super) fn slack_strands(&self) -> Vec<usize> {
        let n = self.line.order.len();
        let driver = (0..n)
            .find(|&i| given_speed(self.drive, i).is_some())
            .unwrap_or(0);
        let place = self.line.place_of(driver);
        let forward = given_speed(self.drive, driver).unwrap_or(0.0)
            * self.drive.sprockets[driver].side.sign()
            >= 0.0;
        let leaving = if forward { place } else { (place + n - 1) % n };
        let gravity = self.drive.gravity;
        let outward = |i: usize| {
            let span = &self.line.belt.spans[i];
            let pull = gravity.dot(&-turned_left(span.direction)) * span.length;
            // Differences by rounding do not decide.
            if pull.abs() > 1e-9 * gravity.norm() * span.length {
                pull
            } else {
                0.0
            }
        };
        let mut strands: Vec<usize> = (0..n).map(|i| (leaving + i) % n).collect();
        strands.sort_by(|&a, &b| outward(b).total_cmp(&outward(a)));
        strands
    }

    /// Return the chain with the first strand and position of its seats without contact, and with the smallest stretch.
    pub(super) fn find(&self) -> Result<ClosedLayout> {
        let chain = &self.drive.chain;
        let (clearance, pitch) = (chain.hinge.clearance(), chain.mean_pitch());
        let needed = self.line.pitches(self.drive);
        let missing = needed - f64::from(chain.links);
        let stretch = missing * pitch / f64::from(chain.links);
        if stretch > 3.0 * LARGEST_STRETCH * clearance + 0.01 * pitch {
            return self.refuse(&format!(
                "it is {:.3} mm too short, {:.1} um a hinge, and a hinge's clearance gives {:.1} um",
                1e3 * missing * pitch,
                1e6 * stretch,
                1e6 * clearance
            ));
        }
        let mut why = None;
        for gap in START_GAPS {
            let Some(course) = self.course(gap) else {
                continue;
            };
            let mut stretched: Option<ClosedLayout> = None;
            for slack in self.slack_strands() {
                for polygon in Self::by_merit(&course, slack, clearance) {
                    let Some(polygon) = self.fitted(polygon, slack, &mut why) else {
                        continue;
                    };
                    let found = ClosedLayout {
                        course: course.clone(),
                        polygon,
                        slack,
                    };
                    let stretch = found.polygon.stretch;
                    if stretch * pitch <= TAUT_STRETCH * clearance {
                        return Ok(found);
                    }
                    if stretched
                        .as_ref()
                        .is_none_or(|least| stretch < least.polygon.stretch)
                    {
                        stretched = Some(found);
                    }
                    break;
                }
            }
            if let Some(found) = stretched {
                return Ok(found);
            }
        }
        self.refuse(&why.unwrap_or_else(|| {
            if missing > 0.0 {
                format!(
                    "it is {:.3} mm too short, more than the clearance of its hinges gives, {:.1} um each",
                    1e3 * missing * pitch,
                    1e6 * clearance
                )
            } else {
                "no whole numbers of pitches fit the strands".to_string()
            }
        }))
    }

    /// Return the polygon with links of their own lengths if it has no fault; the first fault is stored in `why`.
    fn fitted(
        &self,
        mut polygon: Polygon,
        slack: usize,
        why: &mut Option<String>,
    ) -> Option<Polygon> {
        // A strand that is far too long is refused before its links are fitted, one by one.
        if let Some(fault) = self.bow(&polygon, slack) {
            why.get_or_insert(fault);
            return None;
        }
        let hinges = std::mem::take(&mut polygon.hinges);
        for own in for_own_lengths(&self.drive.chain, hinges) {
            polygon.hinges = own;
            let Some(fault) = self.fault(&polygon, slack) else {
                return Some(polygon);
            };
            why.get_or_insert(fault);
        }
        None
    }

    /// Return the polygons with the slack in one strand: smallest stretch first, then smallest distance of seats from the tangent points.
    fn by_merit(course: &WheelSequence, slack: usize, clearance: f64) -> Vec<Polygon> {
        let most = LARGEST_STRETCH * clearance / course.pitch;
        let shift = |i: u32| f64::from(i) / f64::from(SHIFTS) - 0.5;
        let mut polygons: Vec<Polygon> = (0..SHIFTS)
            .filter_map(|i| course.polygon(slack, shift(i), most))
            .collect();
        let taut = |p: &Polygon| p.stretch.max(TAUT_STRETCH * clearance / course.pitch);
        polygons.sort_by(|a, b| {
            taut(a)
                .total_cmp(&taut(b))
                .then(a.off_tangent.total_cmp(&b.off_tangent))
        });
        polygons
    }

    fn refuse<T>(&self, why: &str) -> Result<T> {
        let chain = &self.drive.chain;
        Err(Error::Impossible(format!(
            "the chain has no initial configuration: {} links, where a taut chain has {:.3} pitches: {why}; these centres {}",
            chain.links,
            self.line.pitches(self.drive),
            remedy(chain, self.links_that_close())
        )))
    }

    /// Return the smallest even number of links that is not shorter than a taut chain.
    pub(super) fn links_that_close(&self) -> u32 {
        let mut links = even_links(self.line.pitches(self.drive));
        // The polygon may be slightly longer than the belt.
        for _ in 0..3 {
            let spare = self.course(0.0).is_some_and(|mut course| {
                course.links = links;
                (0..SHIFTS).any(|i| {
                    let shift = f64::from(i) / f64::from(SHIFTS) - 0.5;
                    course.polygon(0, shift, 0.0).is_some()
                })
            });
            if spare {
                break;
            }
            links += 2;
        }
        links
    }

    /// Return the fault of a slack strand that bows out too far, if any; it does not depend on the lengths of single links.
    fn bow(&self, polygon: &Polygon, slack: usize) -> Option<String> {
        let (span, sag) = (polygon.spans[slack], polygon.sag[slack]);
        (bow_angle(sag, span) > LARGEST_BOW).then(|| {
            format!(
                "the {} strand has {:.3} mm of slack over {:.3} mm and would bow out by {:.3} mm",
                strand_name(&self.line.strands(), slack),
                1e3 * polygon.slack[slack],
                1e3 * span,
                1e3 * sag
            )
        })
    }

    /// Return any other fault of a polygon.
    fn fault(&self, polygon: &Polygon, slack: usize) -> Option<String> {
        let chain = &self.drive.chain;
        let lie = self.lie(polygon);
        let stretch = lie.stretch();
        if stretch >= LARGEST_STRETCH * chain.hinge.clearance() {
            return Some(format!(
                "it would open hinges by {:.1} um, and their clearance is {:.1} um",
                1e6 * stretch,
                1e6 * chain.hinge.clearance()
            ));
        }
        let gap = lie.smallest_gap();
        (gap < 0.9 * START_GAPS[0]).then(|| {
            format!(
                "with the slack in the {} strand, a bushing would start {:.3} um off a tooth (negative: inside)",
                strand_name(&self.line.strands(), slack),
                1e6 * gap
            )
        })
    }

    fn lie<'b>(&'b self, polygon: &'b Polygon) -> Lie<'b> {
        let sprockets = (0..self.profiles.len()).map(|i| {
            let first_seat = polygon.first_seat[self.line.place_of(i)];
            (
                self.drive.sprockets[i].center,
                first_seat,
                &self.profiles[i],
            )
        });
        Lie {
            chain: &self.drive.chain,
            hinges: &polygon.hinges,
            sprockets: sprockets.collect(),
        }
    }

    pub(super) fn layout(&self, found: &ClosedLayout, speeds: Vec<f64>) -> Result<Layout> {
        let (drive, polygon) = (self.drive, &found.polygon);
        let n = drive.sprockets.len();
        let place = |i: usize| self.line.place_of(i);
        let lie = self.lie(polygon);
        let chain_turn =
            |i: usize| drive.sprockets[i].side.sign() / f64::from(drive.sprockets[i].teeth);
        let hinge_radius = |i: usize| found.course.wheels[place(i)].wheel.hinge_radius;
        let by_sprocket = |value: &dyn Fn(usize) -> f64| (0..n).map(value).collect::<Vec<f64>>();
        let mut layout = Layout {
            sides: drive.sprockets.iter().map(|s| s.side).collect(),
            seat_of: polygon
                .seat_of
                .iter()
                .map(|seat| seat.map(|place| self.line.order[place]))
                .collect(),
            pitch_radius: by_sprocket(&|i| self.profiles[i].pitch_radius),
            seat_offset: by_sprocket(&|i| hinge_radius(i) - self.profiles[i].pitch_radius),
            seated: (0..n).map(|i| polygon.seated[place(i)]).collect(),
            belt_wrap: by_sprocket(&|i| self.line.belt.wraps[place(i)]),
            first_seat: by_sprocket(&|i| polygon.first_seat[place(i)]),
            phase: by_sprocket(&|i| phase(&self.profiles[i], polygon.first_seat[place(i)])),
            speeds,
            speed_ratio: by_sprocket(&|i| chain_turn(i) / chain_turn(0)),
            strands: self.line.strands(),
            strand_pitches: polygon.strands.clone(),
            spans: polygon.spans.clone(),
            slack: polygon.slack.clone(),
            sag: polygon.sag.clone(),
            belt_pitches: self.line.pitches(drive),
            center_distance: None,
            closing_center_distance: None,
            hinge_stretch: lie.stretch(),
            start_gap: lie.smallest_gap(),
            tension_force: tension_force(drive)?,
            guides: Vec::new(),
            warnings: Vec::new(),
            order: self.line.order.clone(),
        };
        layout.warn(drive);
        Ok(layout)
    }
}
