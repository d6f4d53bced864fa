//! Force and stored energy of a spring and damper as functions of length or angle.

use crate::error::{Error, Result, check};
use crate::math::Table;

/// Force law of a spring and damper: k x + `k_3` x³ (or a table of x) + c x'.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpringLaw {
    /// k \[N/m\] or \[N m/rad\].
    pub stiffness: f64,
    /// `k_3` \[N/m³\] or \[N m/rad³\].
    pub cubic: f64,
    /// c \[N s/m\] or \[N m s/rad\].
    pub damping: f64,
    /// Force as a function of x, instead of k and `k_3`.
    pub table: Option<Table>,
}

impl SpringLaw {
    /// Return the linear law k x + c x'.
    #[must_use]
    pub fn linear(stiffness: f64, damping: f64) -> Self {
        Self {
            stiffness,
            damping,
            ..Self::default()
        }
    }

    /// Return the elastic force at the deflection `x`.
    pub(crate) fn elastic(&self, x: f64) -> f64 {
        match &self.table {
            Some(curve) => curve.value(x),
            None => (self.stiffness + self.cubic * x * x) * x,
        }
    }

    /// Return the derivative of the elastic force with respect to `x`.
    pub(crate) fn stiffness(&self, x: f64) -> f64 {
        match &self.table {
            Some(curve) => curve.slope(x),
            None => self.stiffness + 3.0 * self.cubic * x * x,
        }
    }

    /// Return the elastic energy at the deflection `x` \[J\].
    pub(crate) fn energy(&self, x: f64) -> f64 {
        match &self.table {
            Some(curve) => curve.integral(x),
            None => (0.5 * self.stiffness + 0.25 * self.cubic * x * x) * x * x,
        }
    }

    /// Check every number, and that the law has at least one part other than zero.
    pub(crate) fn validate(&self, field: &str) -> Result<()> {
        for (name, value) in [("stiffness", self.stiffness), ("cubic", self.cubic)] {
            if self.table.is_some() && value != 0.0 {
                return Err(Error::invalid(
                    format!("{name} of {field}"),
                    value,
                    "excludes a table: give one of them",
                ));
            }
        }
        check::finite(&format!("stiffness of {field}"), self.stiffness, "N/m")?;
        check::finite(&format!("cubic of {field}"), self.cubic, "N/m^3")?;
        check::not_negative(&format!("damping of {field}"), self.damping, "N s/m")?;
        if self.table.is_none() && [self.stiffness, self.cubic, self.damping] == [0.0; 3] {
            return Err(Error::invalid(
                format!("stiffness of {field}"),
                0.0,
                "a spring without stiffness, cubic, damping and table does nothing: give one of them, or leave the \
                 spring out",
            ));
        }
        Ok(())
    }
}
