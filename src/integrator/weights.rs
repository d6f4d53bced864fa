//! What error is allowed to each component, and the norm that measures by it.

use super::difference_kernels::{Weigh, WeightedSquares};
use super::{Adams, OdeSystem, SecondOrderSystem};

/// Speed that is allowed for each length that is, in 1/s: an error of a nanometre goes with one of 0.1 mm/s.
pub(crate) const SPEED_PER_LENGTH: f64 = 1e5;

impl Adams {
    /// One over the error that is allowed to each component of any system; zero for those that ride along.
    pub(super) fn update_weights(&mut self, system: &impl OdeSystem) {
        let controlled = system.controlled();
        self.norm_factor = 1.0;
        if self.control.is_by_component() {
            self.update_weights_by_component(controlled);
        } else if self.starting {
            self.inverse_weight.fill(0.0);
            self.inverse_weight[..controlled].fill(1.0 / self.control.accuracy);
        }
    }

    /// The same for a system whose coordinates know their arms; `mean`: whether the norm is a root mean square where
    /// `accuracy` rules.
    pub(super) fn update_weights_by_scale(&mut self, system: &impl SecondOrderSystem, mean: bool) {
        let controlled = system.controlled();
        self.norm_factor = 1.0;
        if self.control.is_by_component() {
            self.update_weights_by_component(controlled);
            return;
        }
        if mean {
            self.norm_factor = self.mean_square_factor(controlled);
        }
        if self.starting {
            self.inverse_weight.fill(0.0);
            let (lengths, rest) = self.inverse_weight.split_at_mut(system.coordinates());
            system.scale(lengths);
            for (length, speed) in lengths.iter_mut().zip(rest) {
                *length /= self.control.accuracy;
                *speed = *length / SPEED_PER_LENGTH;
            }
        }
    }

    /// Share of a sum of squares over the weights that the norm of Newton's method is the root of.
    pub(super) fn mean_square_factor(&self, controlled: usize) -> f64 {
        if self.control.is_by_component() {
            1.0
        } else {
            1.0 / controlled as f64
        }
    }

    /// 1/(atol + rtol |y|).
    fn update_weights_by_component(&mut self, controlled: usize) {
        if self.starting {
            self.inverse_weight.fill(0.0);
        }
        self.instructions.run(Weigh {
            control: &self.control,
            y: &self.y,
            inverse_weight: &mut self.inverse_weight[..controlled],
        });
    }

    /// Norm of `values` over their weights.
    pub(super) fn norm(&self, values: &[f64]) -> f64 {
        self.norm_of_sum(values, None)
    }

    /// The same of φ_{i+1} after a step.
    pub(super) fn norm_of_difference(&self, i: usize) -> f64 {
        let (row, newest) = self.differences.parts_of_row(i);
        self.norm_of_sum(row, newest)
    }

    fn norm_of_sum(&self, values: &[f64], more: Option<&[f64]>) -> f64 {
        let sum = self.instructions.run(WeightedSquares {
            values,
            more,
            inverse_weight: &self.inverse_weight,
        });
        self.norm_of(sum)
    }

    /// Norm from the sum of squares: Euclidean, as DE/STEP has it, or a root mean square.
    pub(super) fn norm_of(&self, sum: f64) -> f64 {
        (sum * self.norm_factor).sqrt()
    }
}
