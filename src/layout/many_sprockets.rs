//! Layout of a chain round any number of sprockets inside and outside of it, and the reasons of failure.

use super::fit::{TAUT_STRETCH, bow_fault, even_links, remedy, shortage, without_fault};
use super::laid_chain::{LARGEST_STRETCH, Lie, START_GAPS, phase, wheel};
use super::report::{LEAST_GRAVITY_ACROSS, Layout, given_speed, strand_name, tension_force};
use crate::drive::{BeltLine, Drive};
use crate::error::{Error, Result};
use crate::geometry::path::polygon::{PlacedWheel, Polygon, WheelSequence};
use crate::geometry::{ToothProfile, Vec2, turned_left};

/// Message of a search that its caller gave up.
pub(super) const GIVEN_UP: &str = "the search for an initial configuration was given up";

/// Number of positions of the first seat within a pitch that are tried.
const SHIFTS: u32 = 48;

/// Return the positions of the first seat within a pitch that are tried.
pub(super) fn shifts() -> impl Iterator<Item = f64> {
    (0..SHIFTS).map(|i| f64::from(i) / f64::from(SHIFTS) - 0.5)
}

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

    /// Return the strands in the order in which they are tried for the slack: the largest outward component of gravity first; of
    /// equal ones, as without gravity, the first from the strand that leaves the driver on.
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
        let (gravity, spans) = (self.drive.gravity, &self.line.belt.spans);
        let longest = spans
            .iter()
            .fold(0.0, |most: f64, span| most.max(span.length));
        // In whole numbers of what rounding may change: equal components remain in the order of the chain.
        let least = LEAST_GRAVITY_ACROSS * gravity.norm() * longest;
        let outward = |i: usize| {
            let pull = gravity.dot(&-turned_left(spans[i].direction)) * spans[i].length;
            if least > 0.0 {
                (pull / least).round()
            } else {
                0.0
            }
        };
        let mut strands: Vec<usize> = (0..n).map(|i| (leaving + i) % n).collect();
        strands.sort_by(|&a, &b| outward(b).total_cmp(&outward(a)));
        strands
    }

    /// Return the chain with the first strand and position of its seats without contact, and with the smallest stretch.
    /// The search ends with an error soon after `give_up` returns true.
    pub(super) fn find(&self, give_up: &dyn Fn() -> bool) -> Result<ClosedLayout> {
        let chain = &self.drive.chain;
        let (clearance, pitch) = (chain.hinge.clearance(), chain.mean_pitch());
        let needed = self.line.pitches(self.drive);
        let missing = needed - f64::from(chain.links);
        if let Some(shortage) = shortage(chain, needed) {
            return self.refuse(&shortage);
        }
        let mut why = None;
        for gap in START_GAPS {
            let Some(course) = self.course(gap) else {
                continue;
            };
            let mut stretched: Option<ClosedLayout> = None;
            for slack in self.slack_strands() {
                for polygon in Self::by_merit(&course, slack, clearance) {
                    if give_up() {
                        return Err(Error::Impossible(GIVEN_UP.to_string()));
                    }
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
        let name = strand_name(&self.line.strands(), slack);
        let (span, sag) = (polygon.spans[slack], polygon.sag[slack]);
        if let Some(fault) = bow_fault(&name, polygon.slack[slack], span, sag) {
            why.get_or_insert(fault);
            return None;
        }
        let hinges = std::mem::take(&mut polygon.hinges);
        let place = format!("with the slack in the {name} strand, ");
        let fault = |hinges: &[Vec2]| {
            let lie = self.lie(hinges, &polygon.first_seat);
            lie.fault("hinges", [&place, ""])
        };
        polygon.hinges = without_fault(&self.drive.chain, hinges, why, fault)?;
        Some(polygon)
    }

    /// Return the polygons with the slack in one strand: smallest stretch first, then smallest distance of seats from the tangent points.
    fn by_merit(course: &WheelSequence, slack: usize, clearance: f64) -> Vec<Polygon> {
        let most = LARGEST_STRETCH * clearance / course.pitch;
        let polygons = shifts().filter_map(|shift| course.polygon(slack, shift, most));
        let mut polygons: Vec<Polygon> = polygons.collect();
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
            "the chain has no initial configuration: Chain.links = {}, where a taut chain has {:.3} pitches: {why}; {}",
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
                shifts().any(|shift| course.polygon(0, shift, 0.0).is_some())
            });
            if spare {
                break;
            }
            links += 2;
        }
        links
    }

    fn lie<'b>(&'b self, hinges: &'b [Vec2], first_seat: &[f64]) -> Lie<'b> {
        let sprockets = (0..self.profiles.len()).map(|i| {
            let first_seat = first_seat[self.line.place_of(i)];
            (
                self.drive.sprockets[i].center,
                first_seat,
                &self.profiles[i],
            )
        });
        Lie {
            chain: &self.drive.chain,
            hinges,
            sprockets: sprockets.collect(),
        }
    }

    pub(super) fn layout(&self, found: &ClosedLayout, speeds: Vec<f64>) -> Result<Layout> {
        let (drive, polygon) = (self.drive, &found.polygon);
        let n = drive.sprockets.len();
        let place = |i: usize| self.line.place_of(i);
        let lie = self.lie(&polygon.hinges, &polygon.first_seat);
        let chain_turn =
            |i: usize| drive.sprockets[i].side.sign() / f64::from(drive.sprockets[i].teeth);
        let hinge_radius = |i: usize| found.course.wheels[place(i)].wheel.hinge_radius;
        let by_sprocket = |value: &dyn Fn(usize) -> f64| (0..n).map(value).collect::<Vec<f64>>();
        Ok(Layout {
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
            hinge_stretch: lie.stretch(),
            start_gap: lie.smallest_gap(),
            tension_force: tension_force(drive)?,
            order: self.line.order.clone(),
            ..Layout::default()
        })
    }
}
