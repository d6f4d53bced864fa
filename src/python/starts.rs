//! Starts, inputs and wall time budget of a run for Python, and texts of its warnings.

use std::time::Duration;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use super::arrays::rows;
use super::describe;
use super::errors::InvalidInput;
use super::interrupt::interruptible;
use crate::chain::contact::ToothJump;
use crate::chain::model::ForceLaws;
use crate::drive::{Drive, HingeKind, InputQuantity};
use crate::error::Error;
use crate::integrator::StepControl;
use crate::layout::{InitialConfiguration, Layout};
use crate::math::Signal;
use crate::panics::contained;

/// Return the text of a warning of tooth jumps: their number and the first one; none without jumps.
pub(super) fn describe_tooth_jumps(jumps: &[ToothJump]) -> Option<String> {
    let first = jumps.first()?;
    let teeth = if jumps.len() == 1 { "tooth" } else { "teeth" };
    let (number, time) = (first.sprocket + 1, first.time);
    Some(format!(
        "the chain jumped {} {teeth}, first on sprocket {number} at t = {time:.6} s: outputs that need a \
         seated chain do not hold there; raise the pretension, lower the load or, where the tensioner force was still growing, begin with \
         start='static'; see Result.tooth_jumps",
        jumps.len()
    ))
}

/// Positions, velocities and surfaces at which a run begins: arguments of Python.
pub(super) type StartArguments<'a, 'py> = (
    Option<&'a PyReadonlyArray2<'py, f64>>,
    Option<&'a PyReadonlyArray2<'py, f64>>,
    Vec<[usize; 3]>,
);

/// Chain drive with its laws, its solver and the start of its run.
pub(super) struct DriveScene {
    pub(super) drive: Drive,
    pub(super) laws: ForceLaws,
    pub(super) control: StepControl,
    /// Start given by the user; `None`: the generated initial configuration.
    pub(super) start: Option<InitialConfiguration>,
}

impl DriveScene {
    /// Read a `Scene` that has a drive.
    pub(super) fn new(scene: &Bound<'_, PyAny>, place: StartArguments<'_, '_>) -> PyResult<Self> {
        let drive = drive_of(scene)?;
        if drive.hinge_kind == HingeKind::Ideal {
            check_ideal_hinge_law(scene)?;
        }
        Ok(Self {
            laws: describe::force_laws(scene)?,
            control: describe::solver(&scene.getattr("solver")?)?,
            start: own_start(scene.py(), &drive, place)?,
            drive,
        })
    }

    /// Return the start of the user, or the generated one.
    pub(super) fn own_or_generated_start(&self, py: Python<'_>) -> PyResult<InitialConfiguration> {
        match &self.start {
            Some(start) => Ok(start.clone()),
            None => Ok(generated(py, &self.drive)?.0),
        }
    }
}

/// Reject friction, film and a separate force law of hinges: ideal hinges have no contact.
fn check_ideal_hinge_law(scene: &Bound<'_, PyAny>) -> PyResult<()> {
    let (force_law, hinge_law) = (
        scene.getattr("force_law")?,
        describe::law_of(scene, "hinge_law")?,
    );
    let law = hinge_law.as_ref().unwrap_or(&force_law);
    for (field, remedy) in [
        ("friction", "give that of the teeth in tooth_law, or take"),
        ("film", "take"),
    ] {
        let value = law.getattr_opt(field)?.filter(|value| !value.is_none());
        if let Some(value) = value {
            let message = format!(
                "{field} = {}: must be None with ChainDrive.hinges = 'ideal', whose hinges have no contact; {remedy} \
                 hinges = 'clearance'",
                value.repr()?
            );
            return Err(InvalidInput::new_err(message));
        }
    }
    if let Some(law) = hinge_law
        && law.ne(force_law)?
    {
        return Err(InvalidInput::new_err(format!(
            "hinge_law = {}: must be None with ChainDrive.hinges = 'ideal', whose hinges have no contact; it is for 'clearance'",
            law.repr()?
        )));
    }
    Ok(())
}

/// Generate the initial configuration and the layout of a drive; Ctrl-C ends the search.
pub(super) fn generated(py: Python<'_>, drive: &Drive) -> PyResult<(InitialConfiguration, Layout)> {
    let found = interruptible(py, |give_up| {
        contained(|| InitialConfiguration::generate_unless(drive, give_up))
    })?;
    Ok(found?)
}

/// Return the drive of a `Scene`; at a static start its tensioner and the plungers of its guides have no ramp.
pub(super) fn drive_of(scene: &Bound<'_, PyAny>) -> PyResult<Drive> {
    let mut drive = describe::drive(&scene.getattr("system")?)?;
    if scene.getattr("start")?.eq("static")? {
        drive.end_ramps();
    }
    Ok(drive)
}

/// Return a user's start, with generated positions if only velocities are given; `None` if nothing is given.
///
/// Surfaces are those of [`InitialConfiguration::surfaces`], at given positions.
fn own_start(
    py: Python<'_>,
    drive: &Drive,
    (positions, velocities, surfaces): StartArguments<'_, '_>,
) -> PyResult<Option<InitialConfiguration>> {
    let positions = rows("positions", positions)?;
    let velocities = rows("velocities", velocities)?;
    match (positions, velocities) {
        (None, None) => Ok(None),
        (Some(positions), Some(velocities)) => Ok(Some(InitialConfiguration {
            positions,
            velocities,
            surfaces,
        })),
        (None, Some(velocities)) => {
            let (generated, _) = generated(py, drive)?;
            Ok(Some(InitialConfiguration {
                velocities,
                ..generated
            }))
        }
        (Some(_), None) => {
            Err(Error::invalid("velocities", "None", "must be given when positions are").into())
        }
    }
}

/// Read the quantity of an input.
pub(super) fn input_quantity(name: &str) -> crate::error::Result<InputQuantity> {
    match name {
        "speed" => Ok(InputQuantity::Speed),
        "torque" => Ok(InputQuantity::Torque),
        "tensioner_force" => Ok(InputQuantity::TensionerForce),
        _ => {
            let expected = "must be speed, torque or tensioner_force";
            Err(Error::invalid("quantity of an input", name, expected))
        }
    }
}

/// Read the quantity and the signal of an input.
pub(super) fn input(quantity: &str, value: &Bound<'_, PyAny>) -> PyResult<(InputQuantity, Signal)> {
    let quantity = input_quantity(quantity)?;
    let signal = match quantity {
        InputQuantity::Speed => describe::signal(value, "speed", "rad/s")?,
        InputQuantity::Torque => describe::signal(value, "torque", "N m")?,
        InputQuantity::TensionerForce => match describe::finite(value, "force", "N") {
            Ok(force) => Signal::Constant(force),
            Err(_) if describe::signal(value, "force", "N").is_ok() => {
                let expected =
                    "must be a number in N; set it again at each time at which it changes";
                return Err(describe::refuse("force", value, expected));
            }
            Err(error) => return Err(error),
        },
    };
    Ok((quantity, signal))
}

/// Return a wall time budget.
pub(super) fn budget(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}
