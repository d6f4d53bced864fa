//! Variable-order, variable-step Adams-Bashforth-Moulton, after Shampine and Gordon, *Computer Solution of Ordinary
//! Differential Equations* (1975), whose code is DE/STEP: in PECE form or, for systems of second order, with Newton's method,
//! and changing between the two on one table of differences.
//!
//! Knows only [`OdeSystem`]: a pendulum will do.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

mod adams;
mod coefficients;
mod corrector_switching;
mod dense_output;
mod difference_kernels;
mod differences;
pub mod event_location;
mod newton;
mod newton_kernels;
mod order_control;
mod progress;
mod slice_lanes;
mod stability;
mod weights;

use std::ops::Range;

use serde::{Deserialize, Serialize};

pub use adams::{Adams, Counts, Step, StepFailure};
pub use dense_output::DenseOutput;
pub(crate) use dense_output::DenseSums;
pub(crate) use progress::{MOST_STEPS, Progress};
pub(crate) use weights::SPEED_PER_LENGTH;

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

    /// Whether a step of `length` may end where the derivative was asked for last: false where it has jumped over something
    /// larger than `allowed` that its ends do not show. Asked when the error test has let it pass.
    fn accepts_step(&mut self, _length: f64, _allowed: f64) -> bool {
        true
    }
}

/// A system of second order: the first components are coordinates q, as many after them their velocities, the rest sums.
pub trait SecondOrderSystem: OdeSystem {
    /// Number of coordinates.
    fn coordinates(&self) -> usize;

    /// The derivative of the velocities; that of the coordinates, which are the velocities themselves, need not be written.
    fn accelerations(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.derivative(t, y, dydt);
    }

    /// The same, and whatever [`Self::factorise`] needs of it.
    fn accelerations_with_slopes(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.accelerations(t, y, dydt);
    }

    /// How many times worse than in the steps before corrections may converge at the last evaluation: once, or more where something began
    /// or ended within the step; endless for systems that cannot tell.
    fn contraction_safety_factor(&self) -> f64 {
        f64::INFINITY
    }

    /// Velocities for which the system solves by itself, where a step of Newton's method asks for accelerations: none, unless they are
    /// what first-order equations of their own lead to.
    fn local_unknowns(&self) -> Range<usize> {
        0..0
    }

    /// Begins such a step, or ends it: v = foretold + γ dv/dt is what [`Self::local_unknowns`] solves.
    fn begin_implicit_stage(&mut self, _step: Option<(&[f64], f64)>) {}

    /// Writes what was solved for at the last evaluation.
    fn write_local_solution(&self, _velocities: &mut [f64]) {}

    /// Whether a part of it is damped within a fraction of a step and bends besides, as oil in hinges: at order two its slope turns round
    /// from step to step, until no iteration ends.
    fn oscillates_at_order_two(&self) -> bool {
        false
    }

    /// Prepares [`Self::correct`] at `y`, where [`Self::accelerations_with_slopes`] was just evaluated: factors of 1 - γ da/dv - γ² da/dq
    /// for accelerations a. False when there are none.
    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool;

    /// Overwrites a residual of velocities by the correction that it asks for.
    fn correct(&mut self, residual: &mut [f64]);

    /// Writes for every coordinate the length that turns it into one \[m\]: 1 for lengths, an arm for angles.
    fn scale(&self, lengths: &mut [f64]);
}

/// Tolerances and limits of a run.
///
/// As long as `rtol` and `atol` are both zero, `accuracy` rules: it is the error allowed to lengths, 1e5/s times that to
/// speeds, and to angles and spins what makes as much at their arms. A step of Newton's method is accepted when the root mean
/// square over coordinates and velocities of error / allowed error is at most one, an explicit one when the Euclidean norm
/// is: at orders above two it costs little, and balances of energy then close about alike.
///
/// Otherwise a step is accepted when the Euclidean norm over the components of error / (`atol` + `rtol` |y|) is at most one,
/// as in DE/STEP. (A root mean square would be laxer by the square root of the number of components: with one bushing in
/// contact among 38 links that lets errors of contacts through.)
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
    /// Error in lengths that a step is allowed \[m\], unless `rtol` or `atol` are given.
    pub accuracy: f64,
}

/// How the corrector's equation is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Corrector {
    /// The cheaper of the two at each time.
    Auto,
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
            max_step: 1e-4,
            max_order: MAX_ORDER,
            corrector: Corrector::Auto,
            accuracy: 1e-10,
        }
    }
}

impl StepControl {
    /// Whether `rtol` and `atol` rule, component by component, and not `accuracy`.
    #[must_use]
    pub fn is_by_component(&self) -> bool {
        self.rtol > 0.0 || self.atol > 0.0
    }

    /// Error that a step is allowed in speeds that are nearly zero \[m/s\].
    #[must_use]
    pub fn speed_error(&self) -> f64 {
        if self.is_by_component() {
            self.atol
        } else {
            self.accuracy * SPEED_PER_LENGTH
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> crate::error::Result<()> {
        use crate::error::{Error, check};
        check::not_negative("Solver.rtol", self.rtol, "relative units")?;
        check::not_negative("Solver.atol", self.atol, "the unit of each component")?;
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
