//! The belt line of a drive: the order of its sprockets along the chain path, and the reasons why no belt line exists.

use std::f64::consts::TAU;

use super::{Drive, Sprocket};
use crate::error::{Error, Result};
use crate::geometry::path::belt;
use crate::geometry::path::belt::{Belt, NoTangent, Pulley, Side};
use crate::geometry::path::wrap::pitch_radius;

/// Largest number of sprockets for which the error of a wrong order names the right one: all orders are tried.
const MOST_TO_ORDER: usize = 8;

/// Belt line on the pitch circles.
#[derive(Debug, Clone, PartialEq)]
pub struct BeltLine {
    /// Sprockets (from 0) in the order along the chain path, counterclockwise; the first one first.
    pub order: Vec<usize>,
    /// Belt: spans and wraps in that order.
    pub belt: Belt,
}

impl BeltLine {
    /// Return the belt line of `drive`, whose sprockets are listed in either direction along the chain path.
    ///
    /// # Errors
    /// When no belt line exists: sprockets overlap, the order or a side makes no loop, the line crosses itself or a sprocket,
    /// or a wrap is below one tooth. The message has the numbers.
    pub fn of(drive: &Drive) -> Result<Self> {
        check_room(drive)?;
        let n = drive.sprockets.len();
        let listed: Vec<usize> = (0..n).collect();
        let found = loop_in(drive, &listed).or_else(|| loop_in(drive, &reversed(&listed)));
        let Some(line) = found else {
            return refuse(&why_no_loop(drive, &listed));
        };
        match line.fault(drive, &|| remedy_of_crossing(drive)) {
            Some(why) => refuse(&why),
            None => Ok(line),
        }
    }

    /// Return the length of a taut chain along the line, in pitches; a wrap has as many pitches as teeth (chords, not arcs).
    #[must_use]
    pub fn pitches(&self, drive: &Drive) -> f64 {
        pitches(drive, &self.order, &self.belt)
    }

    /// Return the position of sprocket `i` in the order.
    #[must_use]
    pub fn place_of(&self, i: usize) -> usize {
        self.order.iter().position(|&j| j == i).unwrap_or(0)
    }

    /// Return the sprockets at both ends of each strand.
    #[must_use]
    pub fn strands(&self) -> Vec<[usize; 2]> {
        let next = self.order.iter().cycle().skip(1);
        self.order.iter().zip(next).map(|(&a, &b)| [a, b]).collect()
    }

    /// Return the first fault of a loop, if any: strands that cross, a strand that runs into a sprocket, or a wrap below one tooth.
    ///
    /// `remedy` of a crossing is called for its message only.
    fn fault(&self, drive: &Drive, remedy: &dyn Fn() -> String) -> Option<String> {
        let strands = self.strands();
        let name = |i: usize| format!("{}-{}", strands[i][0] + 1, strands[i][1] + 1);
        for (i, span) in self.belt.spans.iter().enumerate() {
            for (j, other) in self.belt.spans.iter().enumerate().skip(i + 1) {
                if belt::cross(span, other) {
                    return Some(format!(
                        "the strands {} and {} cross: {}",
                        name(i),
                        name(j),
                        remedy()
                    ));
                }
            }
            for (k, sprocket) in drive.sprockets.iter().enumerate() {
                if strands[i].contains(&k) {
                    continue;
                }
                let distance = belt::distance_from(span, sprocket.center);
                let reach = outside_radius(drive, sprocket) + drive.chain.contact_radius();
                if distance < reach {
                    return Some(format!(
                        "the strand {} runs into sprocket {}: it passes its centre at {:.3} mm, and teeth and bushings need \
                         {:.3} mm",
                        name(i),
                        k + 1,
                        1e3 * distance,
                        1e3 * reach
                    ));
                }
            }
        }
        self.short_wrap(drive)
    }

    /// Return whether [`BeltLine::of`] accepts this loop.
    fn is_accepted(&self, drive: &Drive) -> bool {
        self.fault(drive, &String::new).is_none()
    }

    /// Return the fault of the first wrap below one tooth, if any.
    fn short_wrap(&self, drive: &Drive) -> Option<String> {
        self.order.iter().zip(&self.belt.wraps).find_map(|(&i, wrap)| {
            let sprocket = &drive.sprockets[i];
            let (gap, wrap) = (360.0 / f64::from(sprocket.teeth), wrap.to_degrees());
            (wrap < gap).then(|| {
                format!(
                    "sprocket {} is wrapped by {wrap:.2} degrees, less than one of its {} tooth gaps, {gap:.2} degrees: move \
                     it {}",
                    i + 1,
                    sprocket.teeth,
                    match sprocket.side {
                        Side::Inside => "outward",
                        Side::Outside => "into the loop",
                    }
                )
            })
        })
    }
}

fn refuse<T>(why: &str) -> Result<T> {
    Err(Error::Impossible(format!("no chain path exists: {why}")))
}

/// Return the outside radius \[m\]; zero for an invalid profile, whose error the description reports.
fn outside_radius(drive: &Drive, sprocket: &Sprocket) -> f64 {
    let profile = sprocket.tooth_profile(&drive.chain);
    profile.map_or(0.0, |profile| profile.outside_radius)
}

fn check_room(drive: &Drive) -> Result<()> {
    let radius = |i: usize| outside_radius(drive, &drive.sprockets[i]);
    for i in 0..drive.sprockets.len() {
        for j in i + 1..drive.sprockets.len() {
            let distance = (drive.sprockets[j].center - drive.sprockets[i].center).norm();
            let needed = radius(i) + radius(j);
            if distance <= needed {
                return refuse(&format!(
                    "sprockets {} and {} overlap: their centres are {distance:.6} m apart, their outside radii {:.6} m and {:.6} \
                     m need more than {needed:.6} m",
                    i + 1,
                    j + 1,
                    radius(i),
                    radius(j)
                ));
            }
        }
    }
    Ok(())
}

/// Return the same loop in the other direction, from the same sprocket.
fn reversed(order: &[usize]) -> Vec<usize> {
    let (first, rest) = order.split_at(1);
    first.iter().chain(rest.iter().rev()).copied().collect()
}

/// Return the wheels of a belt on the pitch circles, in this order.
pub(super) fn pulleys(drive: &Drive, order: &[usize]) -> Vec<Pulley> {
    let pulley = |&i: &usize| {
        let sprocket = &drive.sprockets[i];
        Pulley {
            center: sprocket.center,
            radius: pitch_radius(drive.chain.mean_pitch(), sprocket.teeth),
            side: sprocket.side,
        }
    };
    order.iter().map(pulley).collect()
}

/// Return the length of a taut chain along `belt`, in pitches.
pub(super) fn pitches(drive: &Drive, order: &[usize], belt: &Belt) -> f64 {
    let straight: f64 = belt.spans.iter().map(|span| span.length).sum();
    let seated = order
        .iter()
        .zip(&belt.wraps)
        .map(|(&i, wrap)| wrap / TAU * f64::from(drive.sprockets[i].teeth));
    straight / drive.chain.mean_pitch() + seated.sum::<f64>()
}

/// Return the belt in this order, if its winding number is one.
fn loop_in(drive: &Drive, order: &[usize]) -> Option<BeltLine> {
    let belt = Belt::around(&pulleys(drive, order)).ok()?;
    belt.is_simple().then(|| BeltLine {
        order: order.to_vec(),
        belt,
    })
}

fn why_no_loop(drive: &Drive, listed: &[usize]) -> String {
    if let Err(NoTangent {
        wheels: [a, b],
        distance,
        needed,
    }) = Belt::around(&pulleys(drive, listed))
    {
        return format!(
            "sprockets {} and {} have no common tangent: their centres are {:.3} mm apart and need more than {:.3} mm",
            a + 1,
            b + 1,
            1e3 * distance,
            1e3 * needed
        );
    }
    let order = suggested_order(drive);
    if !order.is_empty() {
        return format!(
            "the sprockets are not listed in the order in which a chain meets them{order}"
        );
    }
    if let Some((i, other)) = sprocket_to_flip(drive) {
        return format!(
            "sprocket {} stands where a chain in this order would have it {}; it has side=\"{}\"",
            i + 1,
            other.name(),
            drive.sprockets[i].side.name()
        );
    }
    let turns = Belt::around(&pulleys(drive, listed)).map_or(0.0, |belt| belt.turns);
    format!(
        "a chain round the sprockets in this order would turn {turns:.2} times round instead of once; check their order, \
         centres and sides"
    )
}

/// Return what to change so that no strands cross: the order, or the side of one sprocket.
fn remedy_of_crossing(drive: &Drive) -> String {
    let order = suggested_order(drive);
    if !order.is_empty() {
        return format!("list the sprockets in the order in which the chain meets them{order}");
    }
    match sprocket_to_flip(drive) {
        Some((i, side)) => format!(
            "give sprocket {} side=\"{}\" (it has side=\"{}\"), or move it to the other side of the chain",
            i + 1,
            side.name(),
            drive.sprockets[i].side.name()
        ),
        None => "check the order, centres and sides of the sprockets".into(),
    }
}

/// Return the first sprocket with whose other side a chain in the listed order has a belt line, and that side.
fn sprocket_to_flip(drive: &Drive) -> Option<(usize, Side)> {
    let listed: Vec<usize> = (0..drive.sprockets.len()).collect();
    let mut flipped = drive.clone();
    for i in 0..listed.len() {
        let side = drive.sprockets[i].side;
        let other = match side {
            Side::Inside => Side::Outside,
            Side::Outside => Side::Inside,
        };
        flipped.sprockets[i].side = other;
        let found = loop_in(&flipped, &listed).or_else(|| loop_in(&flipped, &reversed(&listed)));
        if found.is_some_and(|line| line.is_accepted(&flipped)) {
            return Some((i, other));
        }
        flipped.sprockets[i].side = side;
    }
    None
}

/// Return the text that names the shortest belt line in another order; empty for none, or for too many sprockets.
fn suggested_order(drive: &Drive) -> String {
    let n = drive.sprockets.len();
    if n > MOST_TO_ORDER {
        return String::new();
    }
    let mut best: Option<BeltLine> = None;
    let mut order: Vec<usize> = (0..n).collect();
    for_each_order(&mut order, 1, &mut |order| {
        let Some(line) = loop_in(drive, order) else {
            return;
        };
        let shorter = best
            .as_ref()
            .is_none_or(|best| line.belt.length < best.belt.length);
        if shorter && line.is_accepted(drive) {
            best = Some(line);
        }
    });
    best.map_or(String::new(), |line| {
        let names: Vec<String> = line.order.iter().map(|i| (i + 1).to_string()).collect();
        format!(": {} would do", names.join(", "))
    })
}

/// Call `take` with every order that keeps the first `fixed` entries.
fn for_each_order(order: &mut [usize], fixed: usize, take: &mut impl FnMut(&[usize])) {
    if fixed >= order.len() {
        take(order);
        return;
    }
    for i in fixed..order.len() {
        order.swap(fixed, i);
        for_each_order(order, fixed + 1, take);
        order.swap(fixed, i);
    }
}
