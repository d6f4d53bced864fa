//! Check of a start: held bodies are where the drive's description has them.

use std::f64::consts::PI;

use super::InitialConfiguration;
use crate::drive::{Bearing, ChainEnd, Drive, Mount, Rail, Sprocket};
use crate::error::{Error, Result, check};
use crate::geometry::Vec2;
use crate::geometry::path::guide_path;
use crate::math::Signal;

/// Share of the pitch by which a position may differ from the description: more than the rounding of a file with nine decimals, and
/// far below a clearance. Doubled, it is 25 nm of a pitch of 12.7 mm.
const OFF_ITS_PLACE: f64 = 1e-6;
/// Angle by which a guide that does not turn may differ from the description \[rad\]: as small.
const OFF_ITS_ANGLE: f64 = 1e-6;

/// Refuses a start that moves what is held: the centre of a sprocket on a fixed bearing or beside its tensioner's way, a guide, an anchor
/// that stands still.
pub(crate) fn check_places(drive: &Drive, start: &InitialConfiguration) -> Result<()> {
    check::rows("positions", &start.positions, drive.bodies())?;
    let at = |body: usize| {
        let [x, y, angle] = start.positions[body];
        (Vec2::new(x, y), angle)
    };
    let refuse = |name: String, found: Vec2, place: Vec2, why: &str| {
        Err(Error::invalid(
            format!("positions of {name}"),
            format!("({}, {})", found.x, found.y),
            format!("must be ({}, {}): {why}", place.x, place.y),
        ))
    };
    // What is no number is refused later, by its name.
    let is_off =
        |found: Vec2, place: Vec2| (found - place).norm() > OFF_ITS_PLACE * drive.chain.pitch;
    for (number, sprocket) in drive.sprockets.iter().enumerate() {
        let (found, _) = at(drive.first_wheel() + number);
        let Some((place, why)) = held_at(drive, number, sprocket, found)? else {
            continue;
        };
        if is_off(found, place) {
            return refuse(format!("sprocket_{}", number + 1), found, place, why);
        }
    }
    for (number, guide) in drive.guides.iter().enumerate() {
        let (found, angle) = at(drive.first_wheel() + drive.sprockets.len() + number);
        let name = format!("guide_{}", number + 1);
        if is_off(found, guide.bearing()) {
            return refuse(name, found, guide.bearing(), "it is held there");
        }
        check_angle(guide, &name, angle)?;
    }
    let links = drive.chain.links as usize;
    for (end, number) in drive.ends.iter().flatten().zip([1, 2]) {
        let ChainEnd::Anchored {
            position, velocity, ..
        } = end
        else {
            continue;
        };
        let (found, _) = at(links + 2 - number);
        if velocity.iter().all(Signal::is_zero) && is_off(found, *position) {
            return refuse(
                format!("end_{number}"),
                found,
                *position,
                "it is anchored there",
            );
        }
    }
    Ok(())
}

/// Check the angle of the guide `name` \[rad\] against its description.
fn check_angle(guide: &Rail, name: &str, angle: f64) -> Result<()> {
    let (off, described) = ((angle - guide.angle()).abs(), guide.angle());
    let (is_off, why) = match guide.mount {
        Mount::Fixed => (off > OFF_ITS_ANGLE, ": it does not turn"),
        Mount::Arm(_) => (
            off > PI,
            ", less than half a turn more or less: its stops are there",
        ),
        Mount::Turning { .. } => return Ok(()),
    };
    if !is_off {
        return Ok(());
    }
    Err(Error::invalid(
        format!("positions of {name}"),
        format!("{angle} rad"),
        format!("must be {described} rad{why}"),
    ))
}

/// Return the required position of a centre at `found`, and the reason; `None` for a free centre.
fn held_at(
    drive: &Drive,
    number: usize,
    sprocket: &Sprocket,
    found: Vec2,
) -> Result<Option<(Vec2, &'static str)>> {
    if let Some(tensioner) = drive.tensioner.filter(|t| t.sprocket == number + 1) {
        let line = tensioner.line(drive)?;
        let s = guide_path::place(line.direction, line.curvature, found - sprocket.center);
        let (moved, _) = guide_path::along(line.direction, line.curvature, s);
        return Ok(Some((
            sprocket.center + moved,
            "its tensioner leads it past there",
        )));
    }
    let fixed = "its bearing is fixed at Sprocket.center";
    Ok((sprocket.bearing == Bearing::Fixed).then_some((sprocket.center, fixed)))
}
