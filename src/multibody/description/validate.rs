//! What is checked of a mechanism as a whole: gravity, that there is something, and names.

use std::collections::HashSet;

use crate::error::{Error, Result};
use crate::multibody::Mechanism;

impl Mechanism {
    /// Checks what is of no part alone.
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
        check_names("joint", self.joints.iter().map(|j| &j.name))?;
        check_names("force", self.forces.iter().map(|f| &f.name))?;
        check_names("contact", self.contacts.iter().map(|c| &c.name))
    }
}

/// Results and messages tell of a part by its name.
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
