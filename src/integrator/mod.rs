//! Variable-order, variable-step Adams-Bashforth-Moulton integrator with an explicit and an implicit corrector.
//!
//! After Shampine and Gordon, *Computer Solution of Ordinary Differential Equations* (1975), whose code is DE/STEP. The explicit
//! corrector is PECE; the implicit one, for second-order systems, is Newton's method. Both use one table of differences, so that the
//! integrator can change between them after any step.
//!
//! The integrator depends on [`OdeSystem`] and [`SecondOrderSystem`] only.
//!
//! Symbols: k is the order of the predictor and h the step size. `φ_i`, `ψ_i`, `g_i`, `σ_i`, `β_i` and α are those of the book, with
//! indices from 1; arrays begin at 0, so that `g[k]` is `g_{k+1}`. φ* are the differences after the prediction; φ*_1 is the predicted
//! derivative. `γ = h g_k` is the weight of the new derivative in the implicit formula, `γ*_i` are the error constants, and `γ_j`, `η_j`
//! in the dense output are those of subroutine INTRP.

#![allow(clippy::inline_always)] // code that is not inlined into a kernel is not compiled for its instruction set

mod adams;
mod alternation;
mod coefficients;
mod control;
mod convergence;
mod corrector_switching;
mod cubic_path;
mod dense_output;
mod difference_kernels;
mod differences;
pub mod event_location;
mod explicit;
mod history;
mod newton;
mod newton_iteration;
mod newton_kernels;
mod next_step;
mod order_control;
mod progress;
mod slice_lanes;
mod stability;
mod step;
mod switching_evidence;
mod vectors;
mod weights;

use std::ops::Range;

pub use adams::Adams;
pub use control::{Corrector, StepControl};
pub(crate) use convergence::SAFETY_AT_CONTACT_CHANGE;
pub use dense_output::DenseOutput;
pub(crate) use dense_output::DenseSums;
pub(crate) use progress::{MOST_STEPS, Progress};
pub use step::{Counts, Step, StepFailure};
pub(crate) use weights::{LENGTH_ERROR_OF_FULL_DEFLECTION, SPEED_PER_LENGTH};

/// Highest order of the predictor.
pub const MAX_ORDER: usize = 12;

/// A first-order system dy/dt = f(t, y).
pub trait OdeSystem {
    /// Return the number of components.
    fn dimension(&self) -> usize;

    /// Return the number of leading components under error control; the rest are sums without effect on them.
    fn controlled(&self) -> usize {
        self.dimension()
    }

    /// Write f(t, y) into `dydt`. The result must not depend on anything that changes during a step.
    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]);

    /// Return whether a step of `length` \[s\] may end at the last evaluation.
    ///
    /// Called after the error test has accepted the step. False where the step has skipped an event by more than `allowed`
    /// \[m\].
    fn accepts_step(&mut self, _length: f64, _allowed: f64) -> bool {
        true
    }
}

/// A second-order system: coordinates q, then their velocities, then sums.
pub trait SecondOrderSystem: OdeSystem {
    /// Return the number of coordinates.
    fn coordinates(&self) -> usize;

    /// Return the number of components in a mean of errors: all controlled ones without padding.
    fn counted(&self) -> usize {
        self.controlled()
    }

    /// Write the derivatives of the velocities and sums; those of the coordinates may be left out.
    fn accelerations(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.derivative(t, y, dydt);
    }

    /// Write the same derivatives, and keep the slopes that [`Self::factorise`] uses.
    fn accelerations_with_slopes(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.accelerations(t, y, dydt);
    }

    /// Return the factor by which the contraction constant c of earlier steps may be too small for the present step.
    ///
    /// It belongs to the last evaluation: 1 in a smooth step, larger after a contact onset or end in it, infinite if unknown.
    fn contraction_safety_factor(&self) -> f64 {
        f64::INFINITY
    }

    /// Return the velocities that the system solves for by itself in an implicit step; they must have first-order equations.
    fn local_unknowns(&self) -> Range<usize> {
        0..0
    }

    /// Begin an implicit stage with the predicted part and γ of v = part + γ dv/dt for the [`Self::local_unknowns`]; `None` ends it.
    fn begin_implicit_stage(&mut self, _stage: Option<(&[f64], f64)>) {}

    /// Write the local unknowns of the last evaluation.
    fn write_local_solution(&self, _velocities: &mut [f64]) {}

    /// Factorise the matrix 1 - γ ∂a/∂v - γ² ∂a/∂q at `y`, the point of the last [`Self::accelerations_with_slopes`].
    ///
    /// Return false where the matrix is singular, or where the system takes it as a sign that the step is too long (a chain: not
    /// definite); the step is then repeated with a smaller size.
    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool;

    /// Replace a residual of the velocities by their correction.
    fn correct(&mut self, residual: &mut [f64]);

    /// Return the residual of the velocities after the multipliers were corrected.
    ///
    /// |residual|/|correction| then measures the stiffness without the reactions of constraints. `None`: take the residual given to
    /// [`Self::correct`].
    fn stiffness_residual(&self) -> Option<&[f64]> {
        None
    }

    /// Write the derivatives of the sums anew after a correction, if the correction has changed the forces that do work.
    fn correct_sum_rates(&self, _rates: &mut [f64]) {}

    /// Write the length scale of every coordinate \[m\]: 1 for lengths, an arm for angles.
    fn scale(&self, lengths: &mut [f64]);
}
