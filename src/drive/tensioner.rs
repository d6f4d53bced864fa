//! A tensioner: moves a sprocket's centre along a slide or about a pivot.

use serde::{Deserialize, Serialize};

use super::belt_line::{BeltLine, pitches, pulleys};
use super::{ChainEnd, Drive, HingeKind, OpenLine};
use crate::error::{Error, Result, check, decimal, pair};
use crate::geometry::path::belt::Belt;
use crate::geometry::path::guide_path;
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{Vec2, turned_left};

/// Stiffness of a stop \[N/m\]: 0.1 mm under 1 kN.
pub(crate) const STOP_STIFFNESS: f64 = 1e7;
/// Step of the search for the position of a taut chain, in pitches.
const SEARCH_STEP: f64 = 0.1;
/// Maximum number of these steps.
const MOST_STEPS: u32 = 1000;
/// Smallest ratio of the change of chain tension to the tensioner's force; below, the direction hardly tightens the chain. A safeguard.
const LEAST_SHARE: f64 = 0.05;

/// A force on the sprocket's centre along a slide or about a pivot. It grows linearly to its full value;
/// a spring, a dashpot and two stops act besides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tensioner {
    /// Number of the sprocket, from 1.
    pub sprocket: usize,
    /// Tension of each strand \[N\].
    pub pretension: f64,
    /// Duration of the linear ramp \[s\].
    pub ramp_time: f64,
    /// Damping coefficient \[N s/m\].
    pub damping: f64,
    /// Damping coefficient for motion against the pull \[N s/m\]: the leakage of a hydraulic tensioner with a check valve;
    /// `None`: the same in both directions.
    pub damping_back: Option<f64>,
    /// Direction of the pull; `None`: away from the other one of two sprockets, or along the bisector of the belt line.
    #[serde(with = "crate::geometry::components")]
    pub direction: Option<Vec2>,
    /// Stiffness of the spring: decrease of the pull with displacement \[N/m\].
    pub stiffness: f64,
    /// Largest displacement against and along the pull \[m\]; infinite without a stop.
    pub travel: [f64; 2],
    /// Pivot of the arm that carries the sprocket \[m\]; `None`: a slide.
    #[serde(with = "crate::geometry::components")]
    pub pivot: Option<Vec2>,
    /// Moment of inertia of the arm about its pivot, without the sprocket \[kg m²\].
    pub arm_inertia: f64,
    /// Pitch of a ratchet along the slide \[m\], which permits motion along the pull only; 0: it locks anywhere.
    pub ratchet: Option<f64>,
}

/// Guide path and pull of a tensioner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TensionerLine {
    /// Unit vector of the pull at the start.
    pub direction: Vec2,
    /// Curvature 1/length of the arm \[1/m\], positive for a pivot on the left of the direction; 0 for a slide.
    pub curvature: f64,
    /// Full pull \[N\].
    pub pull: f64,
    /// Displacement at which the chain is taut \[m\]; `None` where none exists.
    pub taut_at: Option<f64>,
}

impl Tensioner {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::not_negative("Tensioner.pretension", self.pretension, "N")?;
        check::not_negative("Tensioner.ramp_time", self.ramp_time, "s")?;
        check::not_negative("Tensioner.damping", self.damping, "N s/m")?;
        if let Some(back) = self.damping_back {
            check::not_negative("Tensioner.damping_back", back, "N s/m")?;
        }
        check::not_negative("Tensioner.stiffness", self.stiffness, "N/m")?;
        check::not_negative("Tensioner.arm_inertia", self.arm_inertia, "kg m^2")?;
        if let Some(step) = self.ratchet {
            check::not_negative("Tensioner.ratchet", step, "m")?;
        }
        let [back, forth] = self.travel;
        if !(back >= 0.0 && forth >= 0.0 && back + forth > 0.0) {
            return Err(Error::invalid(
                "Tensioner.travel",
                format!("({back}, {forth})"),
                "must be the travel of the centre against the tension force and along it in m: two numbers, not negative and not both \
                 zero",
            ));
        }
        if let Some(d) = self.direction {
            check::direction("Tensioner.direction", d)?;
            if self.pivot.is_some() {
                return Err(Error::invalid(
                    "Tensioner.direction",
                    format!("({}, {})", d.x, d.y),
                    "must be absent when there is a pivot: the arm leaves one direction only",
                ));
            }
        }
        if let Some(pivot) = self.pivot {
            check::point("Tensioner.pivot", pivot)?;
        } else if self.arm_inertia > 0.0 {
            return Err(Error::invalid(
                "Tensioner.arm_inertia",
                self.arm_inertia,
                "must be 0 without a pivot: there is no arm",
            ));
        }
        Ok(())
    }

    /// Return the guide path and pull in `drive`.
    ///
    /// The pull is the component along the guide path of the force of a belt of the given tension on the sprocket, at the position of a
    /// taut chain; there, a spring has reduced it to that. With two sprockets, the angle between a strand and the line of centres is that of
    /// the described centres.
    ///
    /// # Errors
    /// When the pull does not tighten the chain: the message has the ratio of tension to force.
    pub fn line(&self, drive: &Drive) -> Result<TensionerLine> {
        let number = self.sprocket - 1;
        let center = drive.sprockets[number].center;
        let line = match drive.ends {
            None => Some(BeltLine::of(drive)?),
            Some(_) => None,
        };
        let way = Way {
            drive,
            line: line.as_ref(),
            number,
        };
        if self.separates_two_sprockets(drive) {
            return self.line_from_the_other_sprocket(&way);
        }
        let against = -way.taut_at(Vec2::zeros()).map_err(Error::Impossible)?.pull;
        let (direction, curvature) = match (self.direction, self.pivot) {
            (_, Some(pivot)) => {
                let arm = center - pivot;
                let length = arm.norm();
                if length <= 0.0 {
                    return Err(Error::invalid(
                        "Tensioner.pivot",
                        format!("({}, {})", pivot.x, pivot.y),
                        format!("must lie off the centre of sprocket {}", self.sprocket),
                    ));
                }
                // Counterclockwise about the pivot, which is then on the left.
                let turning = turned_left(arm) / length;
                if turning.dot(&against) >= 0.0 {
                    (turning, 1.0 / length)
                } else {
                    (-turning, -1.0 / length)
                }
            }
            (Some(direction), None) => (direction.normalize(), 0.0),
            (None, None) => (against.normalize(), 0.0),
        };
        let share = self.share(direction, against)?;
        let taut_at = way.closing_place((direction, curvature));
        let s = taut_at.unwrap_or(0.0);
        let tight = way.share_at((direction, curvature), s).unwrap_or(share);
        Ok(TensionerLine {
            direction,
            curvature,
            pull: tight * self.pretension + self.stiffness * s,
            taut_at,
        })
    }

    /// Return the guide path and pull of one of two sprockets that slides.
    fn line_from_the_other_sprocket(&self, way: &Way) -> Result<TensionerLine> {
        let sprockets = &way.drive.sprockets;
        let between = sprockets[1].center - sprockets[0].center;
        let away = if way.number == 0 { -between } else { between };
        let [r1, r2] = [0, 1].map(|i| pitch_radius(way.drive.chain.pitch, sprockets[i].teeth));
        let sin = (r1 - r2) / between.norm();
        let cos = (1.0 - sin * sin).max(0.0).sqrt();
        let direction = self.direction.unwrap_or(away).normalize();
        self.share(direction, 2.0 * cos * away.normalize())?;
        let taut_at = way.closing_place((direction, 0.0));
        // The line of centres where the chain is taut: a steep direction turns it.
        let taut = away + taut_at.unwrap_or(0.0) * direction;
        // The cosine of the direction, from its sine: exactly one along the line of centres.
        let across = direction.perp(&taut) / taut.norm();
        let along = (1.0 - across * across).max(0.0).sqrt();
        Ok(TensionerLine {
            direction,
            curvature: 0.0,
            pull: 2.0 * self.pretension * cos * along + self.stiffness * taut_at.unwrap_or(0.0),
            taut_at,
        })
    }

    /// Return whether the tensioner slides one of two sprockets of a closed chain.
    pub(crate) fn separates_two_sprockets(&self, drive: &Drive) -> bool {
        self.pivot.is_none() && drive.ends.is_none() && drive.sprockets.len() == 2
    }

    /// Return the force along `direction` per unit of tension, where a belt of unit tension exerts the force -`against` on the sprocket.
    ///
    /// # Errors
    /// When the force does not tighten the chain.
    fn share(&self, direction: Vec2, against: Vec2) -> Result<f64> {
        let share = direction.dot(&against);
        if share >= LEAST_SHARE {
            return Ok(share);
        }
        let (field, value, motion) = match self.pivot {
            Some(pivot) => (
                "Tensioner.pivot",
                format!("({}, {})", pivot.x, pivot.y),
                format!(
                    "its arm moves sprocket {} along {}, which",
                    self.sprocket,
                    pair(direction, 4)
                ),
            ),
            None => (
                "Tensioner.direction",
                pair(direction, 4),
                format!("sprocket {} moved so", self.sprocket),
            ),
        };
        let (share, best) = (decimal(share, 3), pair(against.normalize(), 4));
        let most = against.norm();
        Err(Error::invalid(
            field,
            value,
            format!(
                "must tighten the chain: {motion} takes up {share} of its displacement; along {best} it takes up {most:.3}"
            ),
        ))
    }
}

/// A taut chain as a belt.
struct Taut {
    /// Force of a belt of unit tension on the sprocket.
    pull: Vec2,
    /// Pitches along the belt; `None` where an end of an open chain has no position.
    pitches: Option<f64>,
}

/// Taut chain round one moved sprocket.
struct Way<'a> {
    drive: &'a Drive,
    /// Belt line of a closed chain.
    line: Option<&'a BeltLine>,
    /// Index of the sprocket, from 0.
    number: usize,
}

impl Way<'_> {
    /// Return the belt with the sprocket's centre moved by `offset`.
    fn taut_at(&self, offset: Vec2) -> std::result::Result<Taut, String> {
        let Some(line) = self.line else {
            return self.open_at(offset);
        };
        let mut pulleys = pulleys(self.drive, &line.order);
        let place = line.place_of(self.number);
        pulleys[place].center += offset;
        let belt = Belt::around(&pulleys).ok().filter(Belt::is_simple);
        let belt = belt.ok_or("no belt line is left")?;
        Ok(Taut {
            pull: belt.pull(place),
            pitches: Some(pitches(self.drive, &line.order, &belt)),
        })
    }

    fn open_at(&self, offset: Vec2) -> std::result::Result<Taut, String> {
        let mut moved = self.drive.clone();
        moved.sprockets[self.number].center += offset;
        let ends = moved.ends.as_ref().ok_or("its chain is closed")?;
        let line = OpenLine::on_pitch_circles(&moved, ends)?;
        // Loaded and free ends move with the sprocket.
        let held = ends
            .iter()
            .all(|end| matches!(end, ChainEnd::Anchored { .. }));
        Ok(Taut {
            pull: line.pull(self.number)?,
            pitches: line.pitches()?.filter(|_| held),
        })
    }

    /// Return the force along the slide (direction, curvature) at displacement `s` \[m\], per unit of tension.
    fn share_at(&self, (direction, curvature): (Vec2, f64), s: f64) -> Option<f64> {
        let (offset, tangent) = guide_path::along(direction, curvature, s);
        Some(-self.taut_at(offset).ok()?.pull.dot(&tangent))
    }

    /// Return the displacement at which the belt is as long as the chain \[m\]. With a loaded or free end the chain is taut at zero.
    fn closing_place(&self, (direction, curvature): (Vec2, f64)) -> Option<f64> {
        let chain = &self.drive.chain;
        // Under tension every pin has gone to the end of its clearance, where it has one; an open chain has one more of them than links.
        let play = match self.drive.hinge_kind {
            HingeKind::Clearance => chain.hinge.clearance() / chain.pitch,
            HingeKind::Ideal => 0.0,
        };
        let one_more = if self.line.is_none() { play } else { 0.0 };
        let links = f64::from(chain.links) * (1.0 + play) + one_more;
        let spare = |s: f64| -> Option<f64> {
            let taut = self
                .taut_at(guide_path::along(direction, curvature, s).0)
                .ok()?;
            Some(taut.pitches.map_or(0.0, |along| links - along))
        };
        let first = spare(0.0)?;
        if first == 0.0 {
            return Some(0.0);
        }
        let step = first.signum() * SEARCH_STEP * chain.pitch;
        let (mut low, mut high) = (0.0, step);
        let mut steps = 0;
        while spare(high)? * step > 0.0 {
            (low, high) = (high, high + step);
            steps += 1;
            if steps == MOST_STEPS {
                return None;
            }
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if spare(middle)? * step > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(high)
    }
}
