//! Variable-order, variable-step Adams-Bashforth-Moulton in PECE form, after Shampine and Gordon,
//! *Computer Solution of Ordinary Differential Equations* (1975), whose code is DE/STEP.
//!
//! Knows only [`OdeSystem`]: a pendulum will do.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

mod adams;
mod coefficients;
mod dense_output;
mod differences;
mod newton;
mod newton_table;
mod order_control;
mod table;

use serde::{Deserialize, Serialize};

pub use adams::{Adams, Counts, Step, StepFailure};
pub use dense_output::DenseOutput;

/// Highest order of the predictor.
pub const MAX_ORDER: usize = 12;

/// A first-order system dy/dt = f(t, y).
pub trait OdeSystem {
    /// Number of components.
    fn dimension(&self) -> usize;

    /// How many of the leading components the error test watches; the rest are sums that ride along.
    fn controlled(&self) -> usize {
        self.dimension()
    }

    /// Writes f(t, y) into `dydt`. Must depend on nothing that changes during a step.
    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]);
}

/// A system of second order: the first components are coordinates q, as many after them their velocities, the rest sums.
pub trait SecondOrderSystem: OdeSystem {
    /// Number of coordinates.
    fn coordinates(&self) -> usize;

    /// Prepares [`Self::correct`] at `y`, where the derivative was just evaluated: factors of 1 - γ da/dv - γ² da/dq
    /// for accelerations a. False when there are none.
    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool;

    /// Overwrites a residual of velocities by the correction that it asks for.
    fn correct(&mut self, residual: &mut [f64]);

    /// Writes for every coordinate the length that turns it into one \[m\]: 1 for lengths, an arm for angles.
    fn scale(&self, lengths: &mut [f64]);
}

/// Tolerances and limits of a run.
///
/// A step is accepted when the Euclidean norm over the components of error / (`atol` + `rtol` |y|) is at most one, as in
/// DE/STEP. (A root mean square would be laxer by the square root of the number of components: with one bushing in contact
/// among 38 links that lets errors of contacts through.)
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepControl {
    /// Relative tolerance.
    pub rtol: f64,
    /// Absolute tolerance, in the unit of each component.
    pub atol: f64,
    /// Largest step \[s\].
    pub max_step: f64,
    /// Highest order, 1 to [`MAX_ORDER`].
    pub max_order: usize,
    /// Which corrector.
    pub corrector: Corrector,
    /// Error in lengths that the implicit corrector allows a step \[m\], as a root mean square over all coordinates.
    pub accuracy: f64,
}

/// How the corrector's equation is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Corrector {
    /// Predict, evaluate, correct, evaluate.
    Pece,
    /// Newton's method.
    Newton,
}

impl Corrector {
    /// The name used in messages and descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pece => "pece",
            Self::Newton => "newton",
        }
    }
}

impl Default for StepControl {
    fn default() -> Self {
        Self {
            rtol: 1e-5,
            atol: 1e-5,
            max_step: 1e-4,
            max_order: MAX_ORDER,
            corrector: Corrector::Pece,
            accuracy: 1e-9,
        }
    }
}

impl StepControl {
    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> crate::error::Result<()> {
        use crate::error::{Error, check};
        check::not_negative("Solver.rtol", self.rtol, "relative units")?;
        check::not_negative("Solver.atol", self.atol, "the unit of each component")?;
        if self.rtol == 0.0 && self.atol == 0.0 {
            return Err(Error::invalid(
                "Solver.atol",
                self.atol,
                "rtol and atol must not both be zero",
            ));
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
                "must be between 1 and 12",
            ));
        }
        Ok(())
    }
}
