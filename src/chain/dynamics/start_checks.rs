//! Checks of an initial configuration: finite numbers, closed hinges, agreement with supports, motors and ends.

use super::{CLOSED, Dynamics};
use crate::chain::model::{Model, Rotation, Support};
use crate::drive::MOST_CHAIN_SPEED;
use crate::error::{Error, Result, check};
use crate::geometry::Vec2;
use crate::layout::InitialConfiguration;

/// Distance of the centres of a hinge or a roller, over half the pitch, above which it counts as open.
const OPEN: f64 = 0.1;
/// Relative deviation of an initial velocity from a prescribed one or a guide path that counts as none: rounding. Prescribed velocities
/// below 1 m/s or 1 rad/s permit it in these units.
const VELOCITY_ROUNDING: f64 = 1e-9;

/// Check that there is one row of finite numbers for every body.
///
/// # Errors
/// When the number of rows is wrong or a number is not finite; the message names the body and the number.
pub(crate) fn check_rows(model: &Model, field: &str, rows: &[[f64; 3]]) -> Result<()> {
    check::finite_rows(field, rows, &model.body_names())
}

impl Dynamics {
    /// Check that pins lie in their bushings, and bushings in their rollers, at the last evaluation.
    ///
    /// # Errors
    /// When the centres of a hinge or a roller are farther apart than a tenth of half the pitch; the message names it and the distance.
    pub(crate) fn check_joints(&self) -> Result<()> {
        check_hinges(self)?;
        check_rollers(self)
    }
}

/// Check that every pin lies in its bushing; penetration is permitted.
fn check_hinges(dynamics: &Dynamics) -> Result<()> {
    let model = dynamics.model();
    if model.hinges.ideal {
        let mut distances = dynamics.evaluated.hinges.distances().enumerate();
        let closed = 0.0..=CLOSED * model.half_pitch; // without NaN
        let open = distances.find(|(_, apart)| !closed.contains(apart));
        return open.map_or(Ok(()), |(k, apart)| {
            Err(Error::invalid(
                "positions",
                format!("{} and {}", model.link_name(k), model.link_name((k + 1) % model.links)),
                format!(
                    "ideal hinge {} cannot be closed from here: its ends stay {apart:.3e} m apart; place each link where its hinges meet",
                    k + 1
                ),
            ))
        });
    }
    // Open hinges have coincident centres in these arrays: they pass this check.
    let apart = |k: usize| dynamics.evaluated.hinges.penetration[k] + model.hinges.clearance;
    let Some(k) = (0..model.links).find(|&k| apart(k) > OPEN * model.half_pitch) else {
        return Ok(());
    };
    Err(Error::invalid(
        "positions",
        format!(
            "{} and {}",
            model.link_name(k),
            model.link_name((k + 1) % model.links)
        ),
        format!(
            "hinge {} is open: its pin and bushing are {:.3e} m apart, with a clearance of {:.3e} m",
            k + 1,
            apart(k),
            model.hinges.clearance
        ),
    ))
}

/// Check that every bushing lies in its roller; penetration is permitted.
fn check_rollers(dynamics: &Dynamics) -> Result<()> {
    let model = dynamics.model();
    let Some(rollers) = &model.rollers else {
        return Ok(());
    };
    let apart = |k: usize| dynamics.evaluated.rollers.penetration[k] + rollers.clearance;
    let Some(k) = (0..model.links).find(|&k| apart(k) > OPEN * model.half_pitch) else {
        return Ok(());
    };
    Err(Error::invalid(
        "positions",
        format!("roller_{}", k + 1),
        format!(
            "it is off its bushing: their centres are {:.3e} m apart, with a clearance of {:.3e} m",
            apart(k),
            rollers.clearance
        ),
    ))
}

/// Check the initial velocities of the end bodies against the prescribed ones.
fn check_ends(model: &Model, start: &InitialConfiguration) -> Result<()> {
    for end in model.ends.iter().flat_map(|ends| &ends.bodies) {
        let Some(given) = end.given_velocity(0.0) else {
            continue;
        };
        let [vx, vy, spin] = start.velocities[end.body];
        if (Vec2::new(vx, vy) - given).norm() > VELOCITY_ROUNDING * given.norm().max(1.0)
            || spin != 0.0
        {
            return Err(Error::invalid(
                format!("velocities of {}", model.link_name(end.body)),
                format!("({vx}, {vy}, {spin})"),
                format!(
                    "its velocity is prescribed: must be ({}, {}, 0) at the start",
                    given.x, given.y
                ),
            ));
        }
    }
    Ok(())
}

/// Check the initial speeds of all bodies against the bounds of a drive.
fn check_speeds(model: &Model, start: &InitialConfiguration) -> Result<()> {
    let field = |body: usize| format!("velocities of {}", model.body_names()[body]);
    for (body, [vx, vy, _]) in start.velocities.iter().enumerate() {
        if vx.hypot(*vy) > MOST_CHAIN_SPEED {
            return Err(Error::invalid(
                field(body),
                format!("({vx}, {vy})"),
                format!(
                    "expected at most {MOST_CHAIN_SPEED} m/s where real chains run below 40 m/s; check the unit"
                ),
            ));
        }
    }
    for (s, sprocket) in model.sprockets.iter().enumerate() {
        if let Some(bounds) = &sprocket.input_bounds {
            let body = model.wheel_body(s);
            bounds.check_speed(&field(body), start.velocities[body][2])?;
        }
    }
    Ok(())
}

/// Check that the bushings, sprockets and surfaces of the stored tooth contacts exist.
fn check_surfaces(model: &Model, start: &InitialConfiguration) -> Result<()> {
    for &[bushing, sprocket, surface] in &start.surfaces {
        let profile = model.sprockets.get(sprocket).map(|s| &s.profile);
        let exists = profile.is_some_and(|p| surface < p.surfaces().len());
        if bushing >= model.links || !exists {
            return Err(Error::invalid(
                "surfaces",
                format!("({bushing}, {sprocket}, {surface})"),
                "must have a bushing, a sprocket and a surface of its teeth, each counted from 0",
            ));
        }
    }
    Ok(())
}

/// Check the numbers of an initial configuration, and their agreement with supports, motors and ends.
pub(crate) fn check_start(model: &Model, start: &InitialConfiguration) -> Result<()> {
    check_rows(model, "positions", &start.positions)?;
    check_rows(model, "velocities", &start.velocities)?;
    check_ends(model, start)?;
    check_speeds(model, start)?;
    check_surfaces(model, start)?;
    (0..model.sprockets.len()).try_for_each(|s| check_wheel_velocity(model, start, s))
}

/// Check the initial velocity of sprocket `s` against its bearing or tensioner and its prescribed speed.
fn check_wheel_velocity(model: &Model, start: &InitialConfiguration, s: usize) -> Result<()> {
    let sprocket = &model.sprockets[s];
    let body = model.wheel_body(s);
    let [vx, vy, spin] = start.velocities[body];
    let [x, y, _] = start.positions[body];
    let refuse = |value: String, expected: String| {
        Err(Error::invalid(
            format!("velocities of {}", model.body_names()[body]),
            value,
            expected,
        ))
    };
    match sprocket.support {
        Support::Fixed if vx != 0.0 || vy != 0.0 => {
            return refuse(
                format!("({vx}, {vy})"),
                "its bearing is fixed: must be (0, 0)".to_string(),
            );
        }
        Support::Slide { .. } => {
            // The guide path of an arm is curved: its tangent at the initial centre applies, not that at the described one.
            let way = sprocket.slide_at(Vec2::new(x, y));
            let tangent = way.map_or(Vec2::zeros(), |(_, tangent)| tangent);
            let across = tangent.perp(&Vec2::new(vx, vy));
            if across.abs() > VELOCITY_ROUNDING * vx.hypot(vy) {
                return refuse(
                    format!("({vx}, {vy})"),
                    format!(
                        "its tensioner permits displacement along ({}, {}) only, at its start",
                        tangent.x, tangent.y
                    ),
                );
            }
        }
        _ => {}
    }
    if let Rotation::Prescribed(speed) = &sprocket.rotation {
        let prescribed = speed.value(0.0);
        if (spin - prescribed).abs() > VELOCITY_ROUNDING * prescribed.abs().max(1.0) {
            return refuse(
                spin.to_string(),
                format!("its speed is prescribed: must be {prescribed} rad/s at the start"),
            );
        }
    }
    Ok(())
}
