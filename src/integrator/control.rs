//! Tolerances, limits and the corrector of a run.

use serde::{Deserialize, Serialize};

use super::{MAX_ORDER, SPEED_PER_LENGTH};
use crate::error::{Error, Result, check};

/// Default of the largest step size \[s\].
const DEFAULT_MAX_STEP: f64 = 1e-4;
/// Default of the permitted error of lengths in a step \[m\].
const DEFAULT_ACCURACY: f64 = 1e-10;

/// Tolerances and limits of a run.
///
/// While `rtol` and `atol` are both zero, `accuracy` is the tolerance: the permitted error of lengths. That of velocities is
/// 1e5/s times as large; those of angles and angular velocities follow from a length scale of each coordinate. An implicit
/// step is accepted when the root mean square of error / permitted error over coordinates and velocities is at most one, an
/// explicit step when the Euclidean norm is. The stricter norm costs little at orders above two and makes the energy balance
/// residuals of both correctors about equal.
///
/// With `rtol` or `atol` a step is accepted when the Euclidean norm of error / (`atol` + `rtol` |y|) over the components is at
/// most one, as in DE/STEP. A root mean square would permit larger errors of single contacts: with one bushing in contact
/// among 38 links it is 6 times as large.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepControl {
    /// Relative tolerance.
    pub rtol: f64,
    /// Absolute tolerance, in the unit of each component.
    pub atol: f64,
    /// Largest step size \[s\].
    pub max_step: f64,
    /// Highest order, 1 to [`MAX_ORDER`].
    pub max_order: usize,
    /// The corrector.
    pub corrector: Corrector,
    /// Permitted error of lengths in a step \[m\], unless `rtol` or `atol` are given.
    pub accuracy: f64,
}

/// Method of solution of the corrector's equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Corrector {
    /// Corrector switching: the cheaper of the two at each time.
    Auto,
    /// Explicit: predict, evaluate, correct, evaluate (PECE).
    Pece,
    /// Implicit: Newton's method.
    Newton,
}

impl Corrector {
    /// Return the name used in messages and descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Pece => "pece",
            Self::Newton => "newton",
        }
    }
}

impl Default for StepControl {
    fn default() -> Self {
        Self {
            rtol: 0.0,
            atol: 0.0,
            max_step: DEFAULT_MAX_STEP,
            max_order: MAX_ORDER,
            corrector: Corrector::Auto,
            accuracy: DEFAULT_ACCURACY,
        }
    }
}

impl StepControl {
    /// Return whether `rtol` and `atol` are the tolerances, component by component, and not `accuracy`.
    #[must_use]
    pub fn is_by_component(&self) -> bool {
        self.rtol > 0.0 || self.atol > 0.0
    }

    /// Return the permitted error of velocities near zero \[m/s\].
    #[must_use]
    pub fn speed_error(&self) -> f64 {
        if self.is_by_component() {
            self.atol
        } else {
            self.accuracy * SPEED_PER_LENGTH
        }
    }

    /// Return the error of an absolute tolerance of zero.
    pub(crate) fn no_atol() -> Error {
        let expected = "must be positive: coordinates and speeds pass through zero, where rtol allows no error";
        Error::invalid("Solver.atol", 0.0, expected)
    }

    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::not_negative("Solver.rtol", self.rtol, "relative units")?;
        check::not_negative("Solver.atol", self.atol, "the unit of each component")?;
        if self.rtol > 0.0 && self.atol == 0.0 {
            return Err(Self::no_atol());
        }
        check::positive("Solver.accuracy", self.accuracy, "m")?;
        if self.max_step.is_nan() || self.max_step <= 0.0 {
            return Err(Error::invalid(
                "Solver.max_step",
                self.max_step,
                "must be a positive number of seconds",
            ));
        }
        if !(1..=MAX_ORDER).contains(&self.max_order) {
            return Err(Error::invalid(
                "Solver.max_order",
                self.max_order,
                format!("must be between 1 and {MAX_ORDER}"),
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relative_tolerance_needs_an_absolute_one() {
        let given = |rtol, atol| StepControl {
            rtol,
            atol,
            ..StepControl::default()
        };
        assert_eq!(given(0.0, 0.0).validate(), Ok(()));
        assert_eq!(given(1e-6, 1e-300).validate(), Ok(()));
        let refused = given(1e-6, 0.0).validate().unwrap_err().to_string();
        assert!(
            refused.starts_with("Solver.atol = 0: must be positive"),
            "{refused}"
        );
    }

    #[test]
    fn the_permitted_error_of_velocities_is_absolute() {
        let control = StepControl::default();
        assert_eq!(control.speed_error(), 1e-10 * SPEED_PER_LENGTH);
        for (rtol, atol) in [(1e-6, 0.0), (0.0, 1e-7), (1e-6, 1e-7)] {
            let by_component = StepControl {
                rtol,
                atol,
                ..control
            };
            assert_eq!(by_component.speed_error(), atol);
        }
    }

    #[test]
    fn a_field_out_of_range_is_refused_with_its_name() {
        let refused = |change: fn(&mut StepControl)| {
            let mut control = StepControl::default();
            assert!(control.validate().is_ok());
            change(&mut control);
            control.validate().unwrap_err().to_string()
        };
        assert!(refused(|control| control.rtol = -1.0).contains("Solver.rtol"));
        assert!(refused(|control| control.atol = f64::NAN).contains("Solver.atol"));
        assert!(refused(|control| control.accuracy = 0.0).contains("Solver.accuracy"));
        assert!(refused(|control| control.max_step = f64::NAN).contains("Solver.max_step"));
        assert!(refused(|control| control.max_step = 0.0).contains("Solver.max_step"));
        assert!(refused(|control| control.max_order = 0).contains("Solver.max_order"));
        assert!(refused(|control| control.max_order = 13).contains("Solver.max_order"));
    }
}
