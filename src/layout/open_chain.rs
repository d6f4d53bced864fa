//! Layout of an open chain: from its first end along the sprockets to its last end; slack strands hang.

mod strands;

use std::f64::consts::{PI, TAU};

use super::laid_chain::wheel;
use crate::drive::{ChainEnd, Drive, OpenLine};
use crate::geometry::{ToothProfile, Vec2, turned_left, unit};

/// Largest number of layouts until the tangent points of hanging strands do not change.
const MOST_ROUNDS: u32 = 60;
/// Change of a direction in the last of them \[rad\]: rounding.
const SETTLED: f64 = 1e-12;
/// Pitches by which a strand may be too short: rounding.
const JUST: f64 = 1e-9;

/// A laid open chain.
pub(super) struct OpenChainShape {
    /// Both ends of every link, one more than links \[m\].
    pub(super) hinges: Vec<Vec2>,
    /// Sprocket on which each hinge is seated.
    pub(super) seat_of: Vec<Option<usize>>,
    /// Pitches seated on each sprocket.
    pub(super) seated: Vec<u32>,
    /// Angle of the first seat of each sprocket \[rad\].
    pub(super) first_seat: Vec<f64>,
    /// Radius of its seated hinges \[m\].
    pub(super) hinge_radius: Vec<f64>,
    /// Sense of rotation of the chain path on each sprocket.
    pub(super) sense: Vec<f64>,
    /// Wrap of each sprocket: angle between the tangents on both sides \[rad\].
    pub(super) wraps: Vec<f64>,
    /// Pitches in each strand.
    pub(super) strands: Vec<u32>,
}

/// A drive with an open chain, and the parameters of its layout.
pub(super) struct OpenChainLayout<'a> {
    drive: &'a Drive,
    ends: &'a [ChainEnd; 2],
    /// Circles of the seated hinges.
    line: OpenLine<'a>,
    teeth: Vec<u32>,
    /// Distance of the first seat from the tangent point, in tooth gaps.
    shift: f64,
}

impl<'a> OpenChainLayout<'a> {
    /// Return a layout with seated bushings at least `gap` \[m\] off their seats.
    pub(super) fn new(
        drive: &'a Drive,
        ends: &'a [ChainEnd; 2],
        profiles: &[ToothProfile],
        (gap, shift): (f64, f64),
    ) -> Result<Self, String> {
        let wheels = profiles.iter().map(|p| wheel(p, &drive.chain, gap));
        let radius: Vec<f64> = wheels.map(|wheel| wheel.hinge_radius).collect();
        Ok(Self {
            drive,
            ends,
            line: if radius.is_empty() {
                OpenLine::new(drive, ends, radius, 1.0)
            } else {
                OpenLine::least_turn(drive, ends, &radius)?
            },
            teeth: profiles.iter().map(|p| p.teeth).collect(),
            shift,
        })
    }

    /// Return why the sprockets' positions are impossible.
    fn overlap(&self) -> Option<String> {
        let sprockets = &self.drive.sprockets;
        let pairs = (0..sprockets.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let mut apart = pairs.map(|(i, j)| {
            let distance = (sprockets[i].center - sprockets[j].center).norm();
            (i, j, distance, self.line.radius[i] + self.line.radius[j])
        });
        let (i, j, distance, least) = apart.find(|(_, _, distance, least)| distance < least)?;
        Some(format!(
            "sprockets {} and {} overlap: their centres are {:.3} mm apart, and the pitch radii add up to {:.3} mm",
            i + 1,
            j + 1,
            1e3 * distance,
            1e3 * least
        ))
    }

    /// Lay the chain; the error is the reason of failure.
    pub(super) fn lay(&self) -> Result<OpenChainShape, String> {
        if self.line.radius.is_empty() {
            return self.lay_alone();
        }
        if let Some(overlap) = self.overlap() {
            return Err(overlap);
        }
        let mut slack = [None, None];
        let mut laid = Err("nothing is laid".to_string());
        for _ in 0..MOST_ROUNDS {
            let directions = self.line.directions(slack)?;
            let along = self.along_sprockets(&directions)?;
            let (next, leaving) = self.with_ends(along)?;
            laid = Ok(next);
            let last = directions.len() - 1;
            let turned = [0, 1].map(|end| {
                let Some(to) = leaving[end] else { return 0.0 };
                let from = directions[if end == 0 { 0 } else { last }];
                (to - from).norm()
            });
            slack = leaving;
            if turned[0].max(turned[1]) < SETTLED {
                break;
            }
        }
        laid
    }

    /// Lay the seated and taut part: hinges from the first seat of the first sprocket to the last seat of the last.
    fn along_sprockets(&self, directions: &[Vec2]) -> Result<OpenChainShape, String> {
        let pitch = self.drive.chain.mean_pitch();
        let mut laid = OpenChainShape {
            hinges: Vec::new(),
            seat_of: Vec::new(),
            seated: Vec::new(),
            first_seat: Vec::new(),
            hinge_radius: self.line.radius.clone(),
            sense: self.line.sense.clone(),
            wraps: Vec::new(),
            strands: Vec::new(),
        };
        for i in 0..self.line.radius.len() {
            let (center, sense) = (self.drive.sprockets[i].center, self.line.sense[i]);
            let gap = TAU / f64::from(self.teeth[i]);
            let meets = |along: Vec2| -sense * turned_left(along);
            let angle_of = |v: Vec2| v.y.atan2(v.x);
            let first = if i == 0 {
                angle_of(meets(directions[0])) + self.shift * gap
            } else {
                let from = laid.hinges[laid.hinges.len() - 1];
                let wanted = center + self.line.radius[i] * meets(directions[i]);
                let (seat, pitches) = seat_at(from, wanted, (center, self.line.radius[i]), pitch)
                    .ok_or_else(|| {
                    format!(
                        "sprockets {} and {} are too near each other for a link between them",
                        i,
                        i + 1
                    )
                })?;
                for k in 1..pitches {
                    let share = f64::from(k) / f64::from(pitches);
                    laid.hinges.push(from + share * (seat - from));
                    laid.seat_of.push(None);
                }
                laid.strands.push(pitches);
                angle_of(seat - center)
            };
            let wrap = self.line.wrap(i, [directions[i], directions[i + 1]]);
            let left = sense * (angle_of(meets(directions[i + 1])) - first);
            let left = wrap + (left - wrap + PI).rem_euclid(TAU) - PI;
            if wrap < gap {
                return Err(format!(
                    "sprocket {} is wrapped by {:.1} degrees, less than one tooth ({:.1}): place it in the chain path, or on its \
                     other side",
                    i + 1,
                    wrap.to_degrees(),
                    gap.to_degrees()
                ));
            }
            let seated = (left / gap).round().max(1.0);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of teeth
            let count = seated as u32;
            for k in 0..=count {
                let at = first + sense * f64::from(k) * gap;
                laid.hinges.push(center + self.line.radius[i] * unit(at));
                laid.seat_of.push(Some(i));
            }
            laid.seated.push(count);
            laid.first_seat.push(first);
            laid.wraps.push(wrap);
        }
        Ok(laid)
    }

    /// Add the strands of both ends, and the directions in which hanging strands leave the sprockets.
    fn with_ends(
        &self,
        seated: OpenChainShape,
    ) -> Result<(OpenChainShape, [Option<Vec2>; 2]), String> {
        let count = seated.hinges.len() - 1;
        let seats = [seated.hinges[0], seated.hinges[count]];
        #[allow(clippy::cast_possible_truncation)] // at most the chain's links
        let [first, last] = self.links_of_ends(seats, count as u32)?;
        let links = self.drive.chain.links as usize;
        let (to_first, leaving_first) = self.strand(0, seats[0], 0..first as usize)?;
        let (to_last, leaving_last) = self.strand(1, seats[1], links - last as usize..links)?;
        let mut laid = seated;
        let ahead = to_first.len() - 1;
        laid.hinges
            .splice(0..0, to_first.into_iter().rev().take(ahead));
        laid.hinges.extend(to_last.into_iter().skip(1));
        laid.seat_of.splice(0..0, vec![None; ahead]);
        laid.seat_of.resize(links + 1, None);
        laid.strands.insert(0, first);
        laid.strands.push(last);
        Ok((laid, [leaving_first, leaving_last]))
    }

    /// Return the numbers of links between the ends and the first and last seat, with `between` links from seat to seat.
    fn links_of_ends(&self, seats: [Vec2; 2], between: u32) -> Result<[u32; 2], String> {
        let chain = &self.drive.chain;
        // Counted for the nominal chain; shorter links reach as far with half of their clearance open.
        let (links, mean) = (chain.links, chain.mean_pitch());
        let pitch = mean + (chain.pitch - mean).clamp(0.0, 0.5 * chain.hinge.clearance());
        let needed = [0, 1].map(|end: usize| {
            let apart = self.ends[end]
                .position()
                .map_or(0.0, |point| (point - seats[end]).norm());
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of links
            let needed = (apart / pitch - JUST).ceil().max(1.0) as u32;
            needed
        });
        let fewest = needed[0] + between + needed[1];
        if links < fewest {
            return Err(format!(
                "it is too short: {links} links, where {} lead from end 1 to the first seat, {between} along the sprockets and {} \
                 from the last seat to end 2; {fewest} links would do",
                needed[0], needed[1]
            ));
        }
        let rest = links - between;
        let asked = [self.ends[0].links(), self.ends[1].links()];
        let hangs = |end: usize| self.ends[end].position().is_none();
        let found = match asked {
            [Some(first), Some(last)] if first + last != rest => {
                return Err(format!(
                    "its ends ask for {first} and {last} links, and {between} lie along the sprockets: {} links would do, it has \
                     {links}",
                    first + last + between
                ));
            }
            [Some(first), _] => [first, rest.saturating_sub(first)],
            [None, Some(last)] => [rest.saturating_sub(last), last],
            [None, None] if hangs(0) && hangs(1) => [rest / 2, rest - rest / 2],
            [None, None] if hangs(0) => [rest - needed[1], needed[1]],
            [None, None] => [needed[0], rest - needed[0]],
        };
        for end in 0..2 {
            if found[end] < needed[end] {
                return Err(format!(
                    "{} links are left for the strand at end {}, which needs {}: its chain of {links} has {between} along the \
                     sprockets and {} at the other end",
                    found[end],
                    end + 1,
                    needed[end],
                    found[1 - end]
                ));
            }
        }
        Ok(found)
    }
}

/// Return the point of a circle at a whole number of pitches from `from` nearest to `wanted`, and that number.
fn seat_at(
    from: Vec2,
    wanted: Vec2,
    (center, radius): (Vec2, f64),
    pitch: f64,
) -> Option<(Vec2, u32)> {
    let nearest = ((wanted - from).norm() / pitch).round();
    let apart = center - from;
    let distance = apart.norm();
    let along = apart / distance;
    let mut best: Option<(Vec2, f64)> = None;
    for pitches in [nearest - 1.0, nearest, nearest + 1.0] {
        let reach = pitches * pitch;
        let before = (distance * distance + reach * reach - radius * radius) / (2.0 * distance);
        let beside = reach * reach - before * before;
        if pitches < 1.0 || beside < 0.0 {
            continue;
        }
        for side in [1.0, -1.0] {
            let point = from + before * along + side * beside.sqrt() * turned_left(along);
            let nearer =
                |(other, _): (Vec2, f64)| (point - wanted).norm() < (other - wanted).norm();
            if best.is_none_or(nearer) {
                best = Some((point, pitches));
            }
        }
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of pitches
    best.map(|(point, pitches)| (point, pitches as u32))
}
