//! Error weights: the error permitted for each component, and the norm over it.

use serde::{Deserialize, Serialize};

use super::difference_kernels::{Weigh, WeightedSquares};
use super::{OdeSystem, SecondOrderSystem, StepControl};
use crate::math::simd::{InstructionSet, Numbers, padded_zeros};

/// Ratio of the errors permitted for velocities and for coordinates \[1/s\]: 1 nm goes with 0.1 mm/s.
///
/// About the rate of a link's contact: at this rate both errors belong to the same energy (decision 19).
pub(crate) const SPEED_PER_LENGTH: f64 = 1e5;

/// Permitted error of lengths at which bristles may have an error of their full break-away deflection \[m\].
///
/// The relative error permitted for the break-away deflection is the accuracy over this length: 1e-3 at an accuracy of 1e-10 m. An
/// error of the deflection is a relative error of the friction force, not an error of a position.
pub(crate) const LENGTH_ERROR_OF_FULL_DEFLECTION: f64 = 1e-7;

/// Norm over the error permitted for each component.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct ErrorNorm {
    /// One over the permitted error; zero for components without error control.
    pub(super) inverse_weight: Numbers,
    /// Factor of a sum of squares: 1 for the Euclidean norm, 1/n for the root mean square.
    factor: f64,
}

impl ErrorNorm {
    pub(super) fn new(dimension: usize) -> Self {
        Self {
            inverse_weight: padded_zeros(dimension),
            factor: 1.0,
        }
    }

    /// Update the weights of a first-order system.
    ///
    /// Without `rtol` and `atol` the weights are constant: they are written at the start only.
    pub(super) fn update(
        &mut self,
        set: InstructionSet,
        control: &StepControl,
        system: &impl OdeSystem,
        (y, starting): (&[f64], bool),
    ) {
        let controlled = system.controlled();
        self.factor = 1.0;
        if control.is_by_component() {
            self.update_by_component(set, control, controlled, (y, starting));
        } else if starting {
            // Padding and sums have zero weight: they do not enter norms.
            self.inverse_weight.fill(0.0);
            self.inverse_weight[..controlled].fill(1.0 / control.accuracy);
        }
    }

    /// Update the weights of a second-order system, whose coordinates have a length scale each.
    ///
    /// `mean`: the norm is a root mean square where `accuracy` is the tolerance.
    pub(super) fn update_by_scale(
        &mut self,
        set: InstructionSet,
        control: &StepControl,
        system: &impl SecondOrderSystem,
        mean: bool,
        (y, starting): (&[f64], bool),
    ) {
        let controlled = system.controlled();
        self.factor = 1.0;
        if control.is_by_component() {
            self.update_by_component(set, control, controlled, (y, starting));
            return;
        }
        // One tolerance serves both correctors with different norms (decision 21).
        if mean {
            self.factor = mean_square_factor(control, controlled);
        }
        if starting {
            self.inverse_weight.fill(0.0);
            let (lengths, rest) = self.inverse_weight.split_at_mut(system.coordinates());
            system.scale(lengths);
            for (length, speed) in lengths.iter_mut().zip(rest) {
                // 1/weight: scale/accuracy for coordinates, 1e5/s times less for velocities.
                *length /= control.accuracy;
                *speed = *length / SPEED_PER_LENGTH;
            }
        }
    }

    /// Write 1/(atol + rtol |y|).
    fn update_by_component(
        &mut self,
        set: InstructionSet,
        control: &StepControl,
        controlled: usize,
        (y, starting): (&[f64], bool),
    ) {
        if starting {
            self.inverse_weight.fill(0.0);
        }
        set.run(Weigh {
            control,
            y,
            inverse_weight: &mut self.inverse_weight[..controlled],
        });
    }

    /// Return the norm of `values`.
    pub(super) fn of(&self, set: InstructionSet, values: &[f64]) -> f64 {
        self.of_parts(set, values, None)
    }

    /// Return the norm of the sum of `values` and `more`.
    pub(super) fn of_parts(
        &self,
        set: InstructionSet,
        values: &[f64],
        more: Option<&[f64]>,
    ) -> f64 {
        let sum = set.run(WeightedSquares {
            values,
            more,
            inverse_weight: &self.inverse_weight,
        });
        self.of_sum(sum)
    }

    /// Return the norm from a sum of weighted squares: Euclidean, as in DE/STEP, or a root mean square.
    pub(super) fn of_sum(&self, sum: f64) -> f64 {
        (sum * self.factor).sqrt()
    }
}

/// Return the factor that makes a sum of squares a mean square where `accuracy` is the tolerance; 1 elsewhere.
pub(super) fn mean_square_factor(control: &StepControl, controlled: usize) -> f64 {
    if control.is_by_component() {
        1.0
    } else {
        1.0 / controlled as f64
    }
}
