//! Readers of the recorded groups and the solver of a run.

use pyo3::prelude::*;

use super::reader::{Reader, number, truth};
use crate::chain::Groups;
use crate::integrator::{Corrector, StepControl};
use crate::multibody::MechanismGroups;
use crate::run::simulation::check_reports;

/// Read and check duration \[s\], report interval \[s\], and whether the energy is recorded.
pub(crate) fn reports(
    duration: &Bound<'_, PyAny>,
    report_step: &Bound<'_, PyAny>,
    energy: Option<&Bound<'_, PyAny>>,
) -> PyResult<(f64, f64, bool)> {
    let duration = number(duration, "duration", "s")?;
    let report_step = number(report_step, "report_step", "s")?;
    let energy = energy.map_or(Ok(true), |energy| truth(energy, "energy"))?;
    check_reports(duration, report_step)?;
    Ok((duration, report_step, energy))
}

/// Return the recorded groups of a drive from their names.
pub(crate) fn drive_groups(names: &[String], energy: bool) -> Groups {
    let has = |name: &str| names.iter().any(|n| n == name);
    Groups {
        hinges: has("hinges"),
        teeth: has("teeth"),
        sprockets: has("sprockets"),
        bodies: has("bodies"),
        energy,
    }
}

/// Return the recorded groups of a mechanism from their names; `None`: all groups.
pub(crate) fn mechanism_groups(names: Option<&[String]>, energy: bool) -> MechanismGroups {
    let has = |name: &str| names.is_none_or(|names| names.iter().any(|n| n == name));
    MechanismGroups {
        bodies: has("bodies"),
        joints: has("joints"),
        contacts: has("contacts"),
        energy,
    }
}

/// Default of `rtol` or `atol` if only the other one is given.
const DEFAULT_TOLERANCE: f64 = 1e-5;

/// Read a `Solver` and check it.
pub(crate) fn solver(object: &Bound<'_, PyAny>) -> PyResult<StepControl> {
    let read = Reader::new(object, "solver", &["Solver"])?;
    let corrector = read.word(
        "method",
        &[
            ("auto", Corrector::Auto),
            ("pece", Corrector::Pece),
            ("newton", Corrector::Newton),
        ],
    )?;
    let rtol = read.optional_number("rtol", "relative units")?;
    let atol = read.optional_number("atol", "the unit of each component")?;
    if atol == Some(0.0) {
        return Err(StepControl::no_atol().into());
    }
    let given = rtol.is_some() || atol.is_some();
    let tolerance =
        |value: Option<f64>| value.unwrap_or(if given { DEFAULT_TOLERANCE } else { 0.0 });
    let control = StepControl {
        rtol: tolerance(rtol),
        atol: tolerance(atol),
        max_step: read.number("max_step", "s")?,
        max_order: read.count("max_order")? as usize,
        corrector,
        accuracy: read.number("accuracy", "m")?,
    };
    control.validate()?;
    Ok(control)
}
