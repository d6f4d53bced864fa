//! Vectors of one step: solution, derivative, predicted value and Newton iterate.

use serde::{Deserialize, Serialize};

use super::OdeSystem;
use crate::math::simd::{Numbers, padded_zeros};

/// Vectors over all components, padded with zeros to whole SIMD vectors.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Vectors {
    /// Number of components without padding.
    pub(super) dimension: usize,
    /// Solution at the time reached.
    pub(super) y: Numbers,
    /// Derivative at the last evaluation.
    pub(super) derivative: Numbers,
    /// Predicted value p.
    pub(super) predicted: Numbers,
    /// Corrected value or Newton iterate of a step that is not accepted yet.
    pub(super) trial: Numbers,
    /// Residual of Newton's method; after an explicit step, the derivative at the predicted value.
    pub(super) residual: Numbers,
}

impl Vectors {
    pub(super) fn new(dimension: usize) -> Self {
        let zeros = || padded_zeros(dimension);
        Self {
            dimension,
            y: zeros(),
            derivative: zeros(),
            predicted: zeros(),
            trial: zeros(),
            residual: zeros(),
        }
    }

    /// Evaluate the right-hand side at the solution.
    pub(super) fn evaluate_at_solution(&mut self, system: &mut impl OdeSystem, t: f64) {
        let n = self.dimension;
        system.derivative(t, &self.y[..n], &mut self.derivative[..n]);
    }

    /// Evaluate the right-hand side at the predicted value.
    pub(super) fn evaluate_at_prediction(&mut self, system: &mut impl OdeSystem, t: f64) {
        let n = self.dimension;
        system.derivative(t, &self.predicted[..n], &mut self.derivative[..n]);
    }

    /// Return the lengths of all vectors.
    pub(super) fn lengths(&self) -> [usize; 6] {
        let vectors = [
            &self.y,
            &self.derivative,
            &self.predicted,
            &self.trial,
            &self.residual,
        ];
        let [y, derivative, predicted, trial, residual] =
            vectors.map(|vector| vector.as_slice().len());
        [self.dimension, y, derivative, predicted, trial, residual]
    }
}
