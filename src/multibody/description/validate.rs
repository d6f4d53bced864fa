//! Checks of a mechanism as a whole: gravity, at least one body, names, masses and inertias.

use std::collections::HashSet;

use crate::error::{Error, Result};
use crate::multibody::{Body, Mechanism};

impl Mechanism {
    /// Check all properties that do not belong to a single part.
    pub(crate) fn validate(&self) -> Result<()> {
        if !(self.gravity.x.is_finite() && self.gravity.y.is_finite()) {
            return Err(Error::invalid(
                "gravity",
                format!("({}, {})", self.gravity.x, self.gravity.y),
                "must be two finite numbers (x, y) in m/s^2",
            ));
        }
        if self.bodies.is_empty() {
            return Err(Error::invalid(
                "bodies",
                "none",
                "a mechanism needs at least one body: add what moves",
            ));
        }
        for body in &self.bodies {
            check_name("body", &body.name)?;
        }
        self.check_masses()?;
        check_names("joint", self.joints.iter().map(|j| &j.name))?;
        check_names("force", self.forces.iter().map(|f| &f.name))?;
        check_names("contact", self.contacts.iter().map(|c| &c.name))
    }
}

/// Smallest mass or inertia proposed in the error message, over the largest of the mechanism. The constrained equations lose
/// accuracy by this factor.
const LEAST_SHARE: f64 = 1e-6;

impl Mechanism {
    /// Check mass and inertia of all bodies that are not fixed: the equations of motion divide by them.
    fn check_masses(&self) -> Result<()> {
        self.check_above_zero("mass", "kg", |body| body.mass)?;
        self.check_above_zero("inertia", "kg m^2", |body| body.inertia)
    }

    fn check_above_zero(&self, name: &str, unit: &str, value: fn(&Body) -> f64) -> Result<()> {
        let moving = || self.bodies.iter().filter(|body| !body.fixed);
        let Some(without) = moving().find(|body| value(body) == 0.0) else {
            return Ok(());
        };
        let largest = moving().map(value).fold(0.0, f64::max);
        let least = if largest > 0.0 {
            let least = LEAST_SHARE * largest;
            format!(
                "; {least:.1e} {unit}, {LEAST_SHARE:e} of the largest of the mechanism, is the smallest useful value"
            )
        } else {
            String::new()
        };
        let expected = format!("must be above zero in {unit}, for a body that moves{least}");
        let field = format!("{name} of body {:?}", without.name);
        Err(Error::invalid(field, 0.0, expected))
    }
}

/// Check that a name is not blank: results and messages identify a part by its name.
fn check_name(kind: &str, name: &str) -> Result<()> {
    if !name.trim().is_empty() {
        return Ok(());
    }
    Err(Error::invalid(
        format!("name of a {kind}"),
        format!("{name:?}"),
        "must not be blank: results and messages are by name",
    ))
}

/// Check that names are unique and not blank.
fn check_names<'a>(kind: &str, names: impl Iterator<Item = &'a String>) -> Result<()> {
    let mut seen = HashSet::new();
    for name in names {
        check_name(kind, name)?;
        if !seen.insert(name) {
            return Err(Error::invalid(
                format!("name of a {kind}"),
                format!("{name:?}"),
                "is taken already: names must be unique",
            ));
        }
    }
    Ok(())
}
