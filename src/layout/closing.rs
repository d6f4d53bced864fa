//! Closing of the chain: number of links from the centres, or a centre from the number of links.

use super::fit::even_links;
use super::many_sprockets::{Around, shifts};
use crate::drive::{BeltLine, Drive};
use crate::error::{Error, Result};
use crate::geometry::Vec2;
use crate::geometry::path::wrap::{self, Wheel};
use crate::math::bisected;

/// Step of the search for the nearest closed belt line, in pitches.
const BELT_STEP: f64 = 0.5;
/// Largest step of the secant method, in pitches: the taut polygon is near the belt line.
const LARGEST_SECANT_STEP: f64 = 0.02;
/// First step of the secant method, over the largest.
const FIRST_SECANT_STEP: f64 = 0.01;
/// Maximum number of steps of the secant method.
const MOST_SECANT_STEPS: u32 = 60;
/// Difference of slack below which a secant has no slope \[m\]: a quotient by zero.
const LEAST_DIFFERENCE: f64 = 1e-300;

/// Return the displacement of sprocket `moved` along `direction` at which the drive's chain is taut \[m\],
/// within `reach` \[m\] in both directions.
///
/// # Errors
/// When the chain is too short or too long within this range: the message has the lengths at both ends.
pub fn closing_move(drive: &Drive, moved: usize, direction: Vec2, reach: f64) -> Result<f64> {
    let along = direction.normalize();
    let at = |s: f64| {
        let mut there = drive.clone();
        there.sprockets[moved].center += s * along;
        there
    };
    let links = f64::from(drive.chain.links);
    let pitches = |s: f64| BeltLine::of(&at(s)).map(|line| line.pitches(drive));
    // Search for the nearest position where the belt line is as long as the chain, in steps to both sides.
    let step = BELT_STEP * drive.chain.pitch;
    let spare = |s: f64| pitches(s).ok().map(|needed| links - needed);
    let here = links - pitches(0.0)?;
    let mut bracket = (here == 0.0).then_some([0.0; 2]);
    let mut fronts: [Option<(f64, f64)>; 2] = [Some((0.0, here)); 2];
    let mut ends = [(0.0, here); 2];
    let mut steps = 0;
    while bracket.is_none() && fronts.iter().any(Option::is_some) {
        steps += 1;
        for (side, front) in fronts.iter_mut().enumerate() {
            let Some((from, _)) = *front else { continue };
            // The last step is shortened: it ends at `reach`, and so does the search on this side.
            let distance = (f64::from(steps) * step).min(reach);
            let to = (1.0 - 2.0 * side as f64) * distance;
            *front = spare(to)
                .filter(|_| distance > from.abs())
                .map(|spare| (to, spare));
            let Some((_, there)) = *front else { continue };
            ends[side] = (to, there);
            if there * here <= 0.0 && bracket.is_none() {
                bracket = Some([from, to]);
            }
        }
    }
    let none_fits = |ranges: String| {
        Error::Impossible(format!(
            "no place of sprocket {} along ({:.4}, {:.4}) suits {} links: {ranges}",
            moved + 1,
            along.x,
            along.y,
            drive.chain.links
        ))
    };
    let Some(bracket) = bracket else {
        return Err(none_fits(format!(
            "from {:.3} mm to {:.3} mm along it a taut chain has {:.3} to {:.3} pitches, {:.3} where it is",
            1e3 * ends[1].0,
            1e3 * ends[0].0,
            links - ends[1].1,
            links - ends[0].1,
            links - here
        )));
    };
    let is_before = |s: f64| spare(s).is_some_and(|there| there * here > 0.0);
    let [low, high] = bisected(bracket, 60, is_before);
    let belt_place = 0.5 * (low + high);
    let found = closing_polygon(&at, belt_place, drive).unwrap_or(belt_place);
    // The taut polygon closes near the place of the belt line, which may be on the other side of the limit.
    if found.abs() > reach {
        return Err(none_fits(format!(
            "the nearest is {:.6} mm along it, beyond the reach of {:.6} mm",
            1e3 * found,
            1e3 * reach
        )));
    }
    Ok(found)
}

/// Return the displacement near `belt_place` at which the best polygon is taut to rounding.
fn closing_polygon(at: &impl Fn(f64) -> Drive, belt_place: f64, drive: &Drive) -> Option<f64> {
    let there = at(belt_place);
    let around = Around::new(&there).ok()?;
    let slack = around.slack_strands()[0];
    // A twentieth of a pitch of slack permits every split of the pitches.
    let course = around.course(0.0)?;
    let mut best: Option<(f64, f64)> = None;
    for shift in shifts() {
        let Some(off) = course.off_tangent(slack, shift) else {
            continue;
        };
        if best.is_none_or(|(least, _)| off < least) {
            best = Some((off, shift));
        }
    }
    let (_, shift) = best?;
    let spare = |s: f64| {
        let there = at(s);
        Around::new(&there).ok()?.course(0.0)?.spare(slack, shift)
    };
    let step = LARGEST_SECANT_STEP * drive.chain.pitch;
    let (mut a, mut b) = (belt_place, belt_place + FIRST_SECANT_STEP * step);
    let (mut f, mut g) = (spare(a)?, spare(b)?);
    for _ in 0..MOST_SECANT_STEPS {
        if (g - f).abs() < LEAST_DIFFERENCE || a == b {
            break;
        }
        let next = (b - g * (b - a) / (g - f)).clamp(b - step, b + step);
        (a, f) = (b, g);
        b = next;
        g = spare(b)?;
        if g == 0.0 {
            break;
        }
    }
    (g.abs() < wrap::CLOSED).then_some(b)
}

/// Return the smallest even number of links that closes round the sprockets of `drive`.
///
/// # Errors
/// When no belt line exists.
pub fn links_around(drive: &Drive) -> Result<u32> {
    Ok(Around::new(drive)?.links_that_close())
}

/// Return the centre distance \[m\] of a taut chain of `links` on two sprockets, its hinges on the pitch circles.
#[must_use]
pub fn closing_center_distance(pitch: f64, teeth: [u32; 2], links: u32) -> Option<f64> {
    wrap::taut_path(
        pitch,
        teeth.map(|n| Wheel::on_pitch_circle(pitch, n)),
        links,
    )
    .map(|path| path.center_distance)
}

/// Return the smallest even number of links that closes at a centre distance \[m\].
#[must_use]
pub fn links_for(pitch: f64, teeth: [u32; 2], center_distance: f64) -> u32 {
    let mut links = even_links(wrap::belt_length(pitch, teeth, center_distance));
    // A taut polygon of this number of links may be slightly shorter than the belt.
    while closing_center_distance(pitch, teeth, links)
        .is_some_and(|c| c < center_distance * (1.0 - wrap::CLOSED_SHARE))
    {
        links += 2;
    }
    links
}
