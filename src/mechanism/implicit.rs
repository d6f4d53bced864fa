//! What the implicit corrector asks of a mechanism: the matrix 1 - γ ∂a/∂v - γ² ∂a/∂q, by differences of whole evaluations.
//!
//! Accelerations follow from forces and constraints together, so that their differences along one velocity, with the
//! coordinate that goes with it, hold both. The matrix is dense: for mechanisms of some tens of bodies.

use nalgebra::{DMatrix, DVectorViewMut};

use super::dynamics::MechanismDynamics;
use crate::integrator::SecondOrderSystem;

/// Change of a velocity that differences are taken over \[m/s\]; of an angular one over its arm.
const CHANGE: f64 = 1e-6;

impl MechanismDynamics {
    /// The length that turns each coordinate into one: for angles the farthest point of the body.
    fn lengths(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
        for angle in lengths.iter_mut().skip(2).step_by(3) {
            *angle = 0.0;
        }
        let model = &self.model;
        let joints = model.equations.iter().flat_map(|e| [e.a, e.b]);
        let contacts = model.contacts.iter().flat_map(|c| [c.a, c.b]);
        for end in joints.chain(contacts) {
            if let Some(first) = model.first[end.body] {
                lengths[first + 2] = end.point.norm().max(lengths[first + 2]);
            }
        }
        for angle in lengths.iter_mut().skip(2).step_by(3) {
            if *angle == 0.0 {
                *angle = 1.0;
            }
        }
    }
}

impl SecondOrderSystem for MechanismDynamics {
    fn coordinates(&self) -> usize {
        self.model.coordinates()
    }

    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        let n = self.model.coordinates();
        let mut lengths = vec![1.0; n];
        self.lengths(&mut lengths);
        let mut state: Vec<f64> = y.iter().zip(&self.shift).map(|(y, s)| y + s).collect();
        let here = self.accelerations.clone();
        let mut matrix = DMatrix::identity(n, n);
        for i in 0..n {
            let change = CHANGE / lengths[i];
            let kept = (state[i], state[n + i]);
            state[i] += gamma * change;
            state[n + i] += change;
            self.evaluate(self.time, &state);
            (state[i], state[n + i]) = kept;
            for (k, (there, here)) in self.accelerations.iter().zip(&here).enumerate() {
                matrix[(k, i)] -= gamma * (there - here) / change;
            }
        }
        let factors = matrix.lu();
        let regular = factors.is_invertible();
        self.corrector = Some(factors);
        regular
    }

    fn correct(&mut self, residual: &mut [f64]) {
        let n = residual.len();
        if let Some(factors) = &self.corrector
            && !factors.solve_mut(&mut DVectorViewMut::from_slice(residual, n))
        {
            residual.fill(f64::NAN);
        }
    }

    fn scale(&self, lengths: &mut [f64]) {
        self.lengths(lengths);
    }
}
