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
        if starting {
            // Padding and sums have zero weight: they do not enter norms.
            self.inverse_weight.fill(0.0);
        }
        if control.is_by_component() {
            self.update_by_component(set, control, controlled, y);
        } else if starting {
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
        if starting {
            self.inverse_weight.fill(0.0);
        }
        if control.is_by_component() {
            self.update_by_component(set, control, controlled, y);
            return;
        }
        // One tolerance serves both correctors with different norms (decision 21).
        if mean {
            self.factor = mean_square_factor(control, system.counted());
        }
        if starting {
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
        y: &[f64],
    ) {
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

    /// Return the weighted sum of squares of `values`, which belong to the components from `first` on.
    pub(super) fn squares_from(&self, set: InstructionSet, first: usize, values: &[f64]) -> f64 {
        set.run(WeightedSquares {
            values,
            more: None,
            inverse_weight: &self.inverse_weight[first..],
        })
    }

    /// Return the norm from a sum of weighted squares: Euclidean, as in DE/STEP, or a root mean square.
    pub(super) fn of_sum(&self, sum: f64) -> f64 {
        (sum * self.factor).sqrt()
    }
}

/// Return the factor that makes a sum of squares a mean square where `accuracy` is the tolerance; 1 elsewhere.
pub(super) fn mean_square_factor(control: &StepControl, counted: usize) -> f64 {
    if control.is_by_component() {
        1.0
    } else {
        1.0 / counted as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two coordinates with length scales of 1 and 0.1, and a sum without error control. Half of the components count in a mean.
    struct Scaled;

    impl OdeSystem for Scaled {
        fn dimension(&self) -> usize {
            5
        }
        fn controlled(&self) -> usize {
            4
        }
        fn derivative(&mut self, _t: f64, _y: &[f64], dydt: &mut [f64]) {
            dydt.fill(0.0);
        }
    }

    impl SecondOrderSystem for Scaled {
        fn coordinates(&self) -> usize {
            2
        }
        fn counted(&self) -> usize {
            2
        }
        fn factorise(&mut self, _y: &[f64], _gamma: f64) -> bool {
            true
        }
        fn correct(&mut self, _residual: &mut [f64]) {}
        fn scale(&self, lengths: &mut [f64]) {
            lengths.copy_from_slice(&[1.0, 0.1]);
        }
    }

    const Y: [f64; 5] = [1.0, -3.0, 0.0, 7.0, 9.0];

    fn by_accuracy(accuracy: f64) -> StepControl {
        StepControl {
            accuracy,
            ..StepControl::default()
        }
    }

    fn by_component(rtol: f64, atol: f64) -> StepControl {
        StepControl {
            rtol,
            atol,
            ..StepControl::default()
        }
    }

    fn norm_of(control: &StepControl, mean: bool) -> ErrorNorm {
        let mut norm = ErrorNorm::new(5);
        norm.update_by_scale(InstructionSet::detect(), control, &Scaled, mean, (&Y, true));
        norm
    }

    fn near(value: f64, expected: f64) {
        assert!((value / expected - 1.0).abs() < 1e-14, "{value}");
    }

    #[test]
    fn permitted_errors_follow_the_length_scale_of_each_coordinate() {
        let norm = norm_of(&by_accuracy(1e-6), false);
        // 1e-6 m and 1e-5 rad; 0.1 m/s and 1 rad/s.
        for (weight, permitted) in norm.inverse_weight.iter().zip([1e-6, 1e-5, 0.1, 1.0]) {
            near(1.0 / weight, permitted);
        }
        assert!(norm.inverse_weight[4..].iter().all(|weight| *weight == 0.0));
    }

    #[test]
    fn the_norm_is_euclidean_or_a_root_mean_square() {
        let set = InstructionSet::detect();
        // Each component has its permitted error; the sum does not count.
        let mut values = padded_zeros(5);
        values[..5].copy_from_slice(&[1e-6, 1e-5, 0.1, 1.0, 1e9]);
        near(norm_of(&by_accuracy(1e-6), false).of(set, &values), 2.0);
        let root = std::f64::consts::SQRT_2;
        near(norm_of(&by_accuracy(1e-6), true).of(set, &values), root);
        let halves: Vec<f64> = values.iter().map(|value| 0.5 * value).collect();
        let sum = norm_of(&by_accuracy(1e-6), true).of_parts(set, &halves, Some(&values));
        near(sum, 1.5 * root);
        near(norm_of(&by_accuracy(1e-6), true).of_sum(64.0), 4.0 * root);
    }

    #[test]
    fn a_part_of_the_components_has_its_own_weights() {
        // Parts of every length, with and without whole vectors, on every instruction set.
        let mut norm = ErrorNorm::new(40);
        for (i, weight) in norm.inverse_weight[..40].iter_mut().enumerate() {
            *weight = 1.0 + i as f64;
        }
        let values: Vec<f64> = (0..40).map(|i| f64::from(i) - 7.0).collect();
        for set in InstructionSet::available() {
            for (first, length) in [(0, 40), (3, 37), (5, 16), (9, 3), (20, 0)] {
                let part = &values[first..first + length];
                let expected: f64 = (first..first + length)
                    .map(|i| (values[i] * (1.0 + i as f64)).powi(2))
                    .sum();
                // Whole numbers: sums are exact.
                assert_eq!(norm.squares_from(set, first, part), expected);
            }
        }
    }

    #[test]
    fn tolerances_by_component_have_a_euclidean_norm() {
        for mean in [false, true] {
            let norm = norm_of(&by_component(1e-3, 1e-2), mean);
            for (weight, permitted) in norm.inverse_weight.iter().zip([0.011, 0.013, 0.01, 0.017]) {
                near(1.0 / weight, permitted);
            }
            assert_eq!(norm.inverse_weight[4], 0.0);
            assert_eq!(norm.of_sum(64.0), 8.0);
        }
        assert_eq!(mean_square_factor(&by_component(1e-3, 0.0), 4), 1.0);
        assert_eq!(mean_square_factor(&by_accuracy(1e-6), 4), 0.25);
    }

    #[test]
    fn systems_of_first_order_have_one_permitted_error() {
        let set = InstructionSet::detect();
        let mut norm = ErrorNorm::new(5);
        norm.update(set, &by_accuracy(1e-6), &Scaled, (&Y, true));
        assert!(
            norm.inverse_weight[..4]
                .iter()
                .all(|weight| *weight == 1.0 / 1e-6)
        );
        assert_eq!(norm.inverse_weight[4], 0.0);
        // Written at the start only; those by component in each step.
        norm.update(set, &by_accuracy(1e-3), &Scaled, (&Y, false));
        assert_eq!(norm.inverse_weight[0], 1.0 / 1e-6);
        norm.update(set, &by_component(0.0, 0.5), &Scaled, (&Y, false));
        assert_eq!(norm.inverse_weight[..5], [2.0, 2.0, 2.0, 2.0, 0.0]);
        assert_eq!(norm.of_sum(64.0), 8.0);
    }
}
