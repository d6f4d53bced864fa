//! Initial configuration of an open chain: the first layout without contact, its velocities, and the report.

use super::configuration::{InitialConfiguration, link_between};
use super::laid_chain::{Lie, START_GAPS, phase};
use super::open_chain::{OpenChainLayout, OpenChainShape};
use super::report::{Layout, given_speed, tension_force};
use super::strand_motion::keep_lengths_from;
use crate::drive::bushing_on_front;
use crate::drive::{ChainEnd, Drive};
use crate::error::{Error, Result};
use crate::geometry::{ToothProfile, Vec2, turned_left, unit};

/// Number of positions of the first seat within a pitch that are tried.
const SHIFTS: u32 = 16;

/// Lay the open chain of `drive`.
pub(super) fn lay(drive: &Drive, ends: &[ChainEnd; 2]) -> Result<(InitialConfiguration, Layout)> {
    let profiles = (drive.sprockets.iter())
        .map(|sprocket| sprocket.tooth_profile(&drive.chain))
        .collect::<Result<Vec<_>>>()?;
    let laid = find(drive, ends, &profiles).map_err(|why| {
        Error::Impossible(format!(
            "the open chain has no initial configuration: {why}"
        ))
    })?;
    let forward = forward_rate(drive, &laid);
    let velocities = hinge_velocities(drive, ends, &laid, forward);
    let mut layout = layout(drive, &profiles, &laid, forward);
    layout.tension_force = tension_force(drive)?;
    Ok((start(drive, ends, &laid, &velocities, &layout), layout))
}

fn find(
    drive: &Drive,
    ends: &[ChainEnd; 2],
    profiles: &[ToothProfile],
) -> std::result::Result<OpenChainShape, String> {
    let mut why = None;
    for gap in START_GAPS {
        for i in 0..=SHIFTS {
            // Shifts of 0, 1, -1, 2, ... sixteenths of a gap.
            let shift = f64::from(i.div_ceil(2)) / f64::from(SHIFTS);
            let shift = if i.is_multiple_of(2) { -shift } else { shift };
            let course = OpenChainLayout::new(drive, ends, profiles, (gap, shift));
            match course.and_then(|course| course.lay()) {
                Ok(laid) => match fault(drive, profiles, &laid) {
                    None => return Ok(laid),
                    Some(fault) => {
                        why.get_or_insert(fault);
                    }
                },
                Err(refusal) => {
                    why.get_or_insert(refusal);
                }
            }
            if drive.sprockets.is_empty() {
                break;
            }
        }
    }
    Err(why.unwrap_or_default())
}

fn lie<'a>(drive: &'a Drive, profiles: &'a [ToothProfile], laid: &'a OpenChainShape) -> Lie<'a> {
    let sprockets = profiles.iter().enumerate().map(|(i, profile)| {
        let center = drive.sprockets[i].center;
        (center, laid.first_seat[i], profile)
    });
    Lie {
        chain: &drive.chain,
        hinges: &laid.hinges,
        sprockets: sprockets.collect(),
    }
}

/// Return the fault of a layout, if any.
fn fault(drive: &Drive, profiles: &[ToothProfile], laid: &OpenChainShape) -> Option<String> {
    lie(drive, profiles, laid).fault("hinges", ["", "; move the ends or the sprockets"])
}

/// Return the speed of the chain towards the last end in pitches per second, from the first given speed.
fn forward_rate(drive: &Drive, laid: &OpenChainShape) -> f64 {
    let rate = |i: usize| {
        let turn = laid.sense[i] * f64::from(drive.sprockets[i].teeth) / std::f64::consts::TAU;
        given_speed(drive, i).map(|speed| speed * turn)
    };
    (0..drive.sprockets.len()).find_map(rate).unwrap_or(0.0)
}

fn sprocket_speed(drive: &Drive, laid: &OpenChainShape, forward: f64, i: usize) -> f64 {
    let follows =
        laid.sense[i] * forward * std::f64::consts::TAU / f64::from(drive.sprockets[i].teeth);
    given_speed(drive, i).unwrap_or(follows)
}

/// Return the velocities of all hinges. Seated hinges rotate with their sprockets; a hanging strand moves along itself, others
/// linearly from end to end, with the correction that keeps the links' lengths.
fn hinge_velocities(
    drive: &Drive,
    ends: &[ChainEnd; 2],
    laid: &OpenChainShape,
    forward: f64,
) -> Vec<Vec2> {
    let seated = |k: usize| {
        laid.seat_of[k].map(|i| {
            let arm = laid.hinges[k] - drive.sprockets[i].center;
            sprocket_speed(drive, laid, forward, i) * turned_left(arm)
        })
    };
    let count = laid.hinges.len();
    let mut velocities: Vec<Vec2> = (0..count).map(|k| seated(k).unwrap_or_default()).collect();
    let known = |end: usize| ends[end].position().map(|_| ends[end].velocity());
    let last = count - 1;
    if laid.sense.is_empty() {
        // The whole chain moves with the end that has a position.
        let given = [known(0), known(1)];
        let [first, final_one] = [given[0].or(given[1]), given[1].or(given[0])];
        velocities[0] = first.unwrap_or_default();
        velocities[last] = final_one.unwrap_or_default();
        fill(&laid.hinges, &mut velocities, 0, last);
        return velocities;
    }
    let mut from = 0;
    for (strand, &pitches) in laid.strands.iter().enumerate() {
        let to = from + pitches as usize;
        // Each end: its index, its hinge, the seat of its strand, and the hinge beside that.
        let end = match (strand, to == last) {
            (0, _) => Some((0, 0, to, to - 1)),
            (_, true) => Some((1, last, from, from + 1)),
            _ => None,
        };
        match end {
            Some((end, hinge, seat, beside)) if known(end).is_none() => {
                let along = (laid.hinges[beside] - laid.hinges[seat]).normalize();
                let moved = velocities[seat].dot(&along) * along;
                let strand = hinge.min(beside)..=hinge.max(beside);
                velocities[strand].fill(moved);
            }
            Some((end, hinge, ..)) => {
                velocities[hinge] = known(end).unwrap_or_default();
                fill(&laid.hinges, &mut velocities, from, to);
            }
            None => fill(&laid.hinges, &mut velocities, from, to),
        }
        from = to + laid.seated.get(strand).map_or(0, |&seated| seated as usize);
    }
    velocities
}

/// Write the velocities between two hinges.
fn fill(hinges: &[Vec2], velocities: &mut [Vec2], from: usize, to: usize) {
    let ends = [velocities[from], velocities[to]];
    let count = (to - from) as f64;
    for (k, velocity) in velocities[from..to].iter_mut().enumerate().skip(1) {
        *velocity = ends[0] + k as f64 / count * (ends[1] - ends[0]);
    }
    keep_lengths_from(from, to - from, hinges, velocities);
}

fn start(
    drive: &Drive,
    ends: &[ChainEnd; 2],
    laid: &OpenChainShape,
    velocities: &[Vec2],
    layout: &Layout,
) -> InitialConfiguration {
    let mut start = InitialConfiguration::default();
    for (places, speeds) in laid.hinges.windows(2).zip(velocities.windows(2)) {
        start.add(link_between([places[0], places[1]], [speeds[0], speeds[1]]));
    }
    let last = laid.hinges.len() - 1;
    // The end of the last link comes first; a load hangs down under gravity.
    for (end, hinge, sign) in [(1, last, 1.0), (0, 0, -1.0)] {
        let along = if drive.gravity.norm() > 0.0 {
            sign * drive.gravity.normalize()
        } else {
            unit(start.positions[if end == 0 { 0 } else { last - 1 }][2])
        };
        let held = matches!(ends[end], ChainEnd::Anchored { .. } | ChainEnd::Free { .. });
        let center = laid.hinges[hinge] + sign * ends[end].arm() * along;
        let angle = if held { 0.0 } else { along.y.atan2(along.x) };
        let velocity = match ends[end] {
            ChainEnd::Anchored { .. } => ends[end].velocity(),
            ChainEnd::Loaded { .. } => velocities[hinge],
            ChainEnd::Free { .. } => Vec2::zeros(),
        };
        start.positions.push([center.x, center.y, angle]);
        start.velocities.push([velocity.x, velocity.y, 0.0]);
    }
    if drive.chain.roller.is_some() {
        add_rollers(&mut start, ends, laid, velocities);
    }
    start.add_sprockets(drive, layout);
    start
}

/// Add rollers concentric with their bushings, hinge by hinge; at rest where there is no bushing.
fn add_rollers(
    start: &mut InitialConfiguration,
    ends: &[ChainEnd; 2],
    laid: &OpenChainShape,
    velocities: &[Vec2],
) {
    let links = laid.hinges.len() - 1;
    let count = links + 2;
    for k in 0..count {
        // The hinge after the last link is that of end 2, the last one that of end 1.
        let place = if k == links + 1 {
            0
        } else {
            (k + 1).min(links)
        };
        let on_front = bushing_on_front(k, count);
        let loose = matches!(ends[1], ChainEnd::Free { .. });
        let there = k != links && (k + 1 != links || !loose || on_front);
        let link = if on_front { k } else { (k + 1) % count };
        let at = laid.hinges[place];
        let (velocity, spin) = if there {
            (velocities[place], start.velocities[link][2])
        } else {
            (Vec2::zeros(), 0.0)
        };
        start.positions.push([at.x, at.y, 0.0]);
        start.velocities.push([velocity.x, velocity.y, spin]);
    }
}

/// Return the report, in the terms of closed chains.
fn layout(drive: &Drive, profiles: &[ToothProfile], laid: &OpenChainShape, forward: f64) -> Layout {
    let count = drive.sprockets.len();
    let by_sprocket = |value: &dyn Fn(usize) -> f64| (0..count).map(value).collect::<Vec<f64>>();
    let pitches = drive.chain.link_pitches();
    let (mut spans, mut slack, mut sag) = (Vec::new(), Vec::new(), Vec::new());
    let mut from = 0;
    for (strand, &links) in laid.strands.iter().enumerate() {
        let to = from + links as usize;
        let chord = laid.hinges[to] - laid.hinges[from];
        let span = chord.norm();
        let length: f64 = pitches[from..to].iter().sum();
        let off = (from..=to).map(|k| {
            let from_end = laid.hinges[k] - laid.hinges[from];
            // Coincident ends have no chord: the sag is the largest distance from them.
            if span > 0.0 {
                from_end.dot(&turned_left(chord / span)).abs()
            } else {
                from_end.norm()
            }
        });
        spans.push(span);
        slack.push(length - span);
        sag.push(off.fold(0.0, f64::max));
        from = to + laid.seated.get(strand).map_or(0, |&seated| seated as usize);
    }
    let lie = lie(drive, profiles, laid);
    let turn = |i: usize| laid.sense[i] / f64::from(drive.sprockets[i].teeth);
    let seated: u32 = laid.seated.iter().sum();
    Layout {
        order: (0..count).collect(),
        sides: drive.sprockets.iter().map(|s| s.side).collect(),
        seat_of: laid.seat_of.clone(),
        pitch_radius: by_sprocket(&|i| profiles[i].pitch_radius),
        seat_offset: by_sprocket(&|i| laid.hinge_radius[i] - profiles[i].pitch_radius),
        seated: laid.seated.clone(),
        belt_wrap: laid.wraps.clone(),
        first_seat: laid.first_seat.clone(),
        phase: by_sprocket(&|i| phase(&profiles[i], laid.first_seat[i])),
        speeds: by_sprocket(&|i| sprocket_speed(drive, laid, forward, i)),
        speed_ratio: by_sprocket(&|i| turn(i) / turn(0)),
        strands: open_strands(count),
        strand_pitches: laid.strands.clone(),
        belt_pitches: f64::from(seated) + spans.iter().sum::<f64>() / drive.chain.mean_pitch(),
        spans,
        slack,
        sag,
        hinge_stretch: lie.stretch(),
        start_gap: lie.smallest_gap(),
        ..Layout::default()
    }
}

/// Return the strands of an open chain along this number of sprockets; its ends are [`usize::MAX`].
pub(super) fn open_strands(sprockets: usize) -> Vec<[usize; 2]> {
    let at = |i: Option<usize>| i.filter(|&i| i < sprockets).unwrap_or(usize::MAX);
    (0..=sprockets)
        .map(|i| [at(i.checked_sub(1)), at(Some(i))])
        .collect()
}
