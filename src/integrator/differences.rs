//! The table of modified divided differences φ of the derivative (Shampine and Gordon, chapter 5).
//!
//! φ* are the differences extrapolated to the end of the step, `φ*_i = β_i φ_i + φ*_{i+1}`; φ*_1 is the predicted derivative.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::MAX_ORDER;
use super::coefficients::Coefficients;
use super::difference_kernels::{Predict, UndoPrediction, UpdateDifferences};
use super::newton_kernels::PredictForNewton;
use super::vectors::Vectors;
use crate::math::simd::{InstructionSet, Numbers, padded, padded_zeros};

/// Differences `φ_1` … φ_{k+2} of the derivative, one row each, and the compensation of rounding at tight tolerances.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Differences {
    /// Row i holds φ_{i+1} of every component, padded.
    table: Numbers,
    dimension: usize,
    /// Length of a row, padded.
    width: usize,
    /// Index of the newest difference, whose addition to the rows before it is deferred to the next prediction; zero for none.
    ///
    /// The deferral saves one pass over the table per step.
    newest: usize,
    /// Compensation of rounding, for tolerances near rounding (`NORND` of STEP).
    compensation: Option<Compensation>,
}

/// Rounding errors of sums, subtracted from the next increment.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Compensation {
    /// Rounding error of the accepted solution.
    kept: Vec<f64>,
    /// Rounding error of the predicted value.
    predicted: Vec<f64>,
}

impl Compensation {
    /// Replace the increment in the predicted value by the compensated sum p = y + increment.
    fn add_increment(&mut self, vectors: &mut Vectors) {
        let ends = vectors.predicted.iter_mut().zip(vectors.y.iter());
        for (((p, y), kept), lost) in ends.zip(&self.kept).zip(&mut self.predicted) {
            // kept: rounding of the sums so far; lost: rounding of this sum.
            let tau = *p - kept;
            *p = y + tau;
            *lost = (*p - y) - tau;
        }
    }
}

impl Differences {
    pub(super) fn new(dimension: usize) -> Self {
        let width = padded(dimension);
        Self {
            table: padded_zeros(width * (MAX_ORDER + 2)),
            dimension,
            width,
            newest: 0,
            compensation: None,
        }
    }

    /// Return whether `other` is a table of the same size.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let lengths = |of: &Compensation| [of.kept.len(), of.predicted.len()];
        (self.dimension, self.width) == (other.dimension, other.width)
            && self.table.len() == other.table.len()
            && self.newest <= MAX_ORDER
            && (self.compensation.iter()).all(|of| lengths(of) == [self.width; 2])
    }

    /// Restart from the derivative at one point.
    pub(super) fn restart(&mut self, derivative: &[f64], compensate: bool) {
        // At order one the only difference is the derivative itself.
        self.table.fill(0.0);
        self.table[..derivative.len()].copy_from_slice(derivative);
        self.newest = 0;
        self.compensation = compensate.then(|| Compensation {
            kept: vec![0.0; derivative.len()],
            predicted: vec![0.0; derivative.len()],
        });
    }

    /// Set the history of a component to zero.
    pub(super) fn reset_component(&mut self, component: usize) {
        for row in self.table.chunks_exact_mut(self.width) {
            row[component] = 0.0;
        }
        if let Some(compensation) = &mut self.compensation {
            (
                compensation.kept[component],
                compensation.predicted[component],
            ) = (0.0, 0.0);
        }
    }

    /// Return row `i` as stored: φ* after a prediction, or the newest difference.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.table[i * self.width..(i + 1) * self.width]
    }

    /// Return the table from the rows of the error estimates at `order` on: φ*_1, φ*_k and φ*_{k-1}.
    #[inline(always)]
    pub(super) fn rows_of_errors(&self, order: usize) -> [&[f64]; 3] {
        let from = |row: usize| &self.table[row * self.width..];
        [from(0), from(order - 1), from(order.saturating_sub(2))]
    }

    /// Return row `i` and, where its addition is deferred, the newest difference.
    pub(super) fn parts_of_row(&self, i: usize) -> (&[f64], Option<&[f64]>) {
        // Rows before the newest difference lack it until the next prediction.
        let newest = (i < self.newest).then(|| self.row(self.newest));
        (self.row(i), newest)
    }

    /// Return difference `i` of one component, with the newest one where its addition is deferred.
    #[inline]
    pub(super) fn value(&self, i: usize, component: usize) -> f64 {
        let at = |row: usize| self.table[row * self.width + component];
        at(i)
            + if i < self.newest {
                at(self.newest)
            } else {
                0.0
            }
    }

    /// Replace φ by φ* and write the predicted value `p = y + h Σ g_i β_i φ_i`.
    pub(super) fn predict(
        &mut self,
        set: InstructionSet,
        c: &Coefficients,
        order: usize,
        h: f64,
        vectors: &mut Vectors,
    ) {
        set.run_blocks(Predict {
            coefficients: c,
            order,
            newest: std::mem::take(&mut self.newest),
            step: h,
            table: &mut self.table,
            compensates: self.compensation.is_some(),
            vectors: &mut *vectors,
        });
        if let Some(compensation) = &mut self.compensation {
            compensation.add_increment(vectors);
        }
    }

    /// Return whether [`Self::predict_for_newton`] is valid for `order`: three rows of the table and no compensation.
    pub(super) fn can_predict_for_newton(&self, order: usize) -> bool {
        order <= 2 && self.newest <= 2 && self.compensation.is_none()
    }

    /// Replace φ by φ*; write the predicted velocities and the first Newton iterate.
    pub(super) fn predict_for_newton(
        &mut self,
        set: InstructionSet,
        c: &Coefficients,
        (order, h, gamma): (usize, f64, f64),
        y: (&[f64], &[f64]),
        predicted: &mut [f64],
        trial: (&mut [f64], &mut [f64]),
    ) {
        set.run(PredictForNewton {
            order,
            newest: std::mem::take(&mut self.newest),
            step: h,
            gamma,
            beta: c.beta[1],
            g: [c.g[0], c.g[1]],
            table: &mut self.table[..3 * self.width],
            width: self.width,
            y,
            predicted,
            trial,
        });
    }

    /// Set these rows to zero.
    pub(super) fn clear(&mut self, rows: RangeInclusive<usize>) {
        for row in rows {
            self.table[row * self.width..(row + 1) * self.width].fill(0.0);
        }
    }

    /// Return φ*_1, and the row of the newest difference of a step at `order`.
    ///
    /// A rejected attempt leaves its own difference in that row, φ_{k+1}. Only φ_{k+2} needs the one before, which takes k + 1 equal steps.
    pub(super) fn first_and_newest(&mut self, order: usize) -> (&[f64], &mut [f64]) {
        let (before, from) = self.table.split_at_mut(order * self.width);
        (&before[..self.width], &mut from[..self.width])
    }

    /// Append the newest difference of a step at `order`, which its last correction has written.
    pub(super) fn append_newest(&mut self, order: usize) {
        // The rows before the newest one receive it in the next prediction.
        self.newest = order;
    }

    /// Return φ*_1 and, above order one, φ*_2 of the last step, and its newest difference; valid until the next prediction.
    pub(super) fn rows_of_last_step(&self) -> (&[f64], Option<&[f64]>, &[f64]) {
        let phi_2 = (self.newest > 1).then(|| self.row(1));
        (self.row(0), phi_2, self.row(self.newest))
    }

    /// Replace φ* by φ after a rejected step.
    pub(super) fn undo_prediction(&mut self, set: InstructionSet, c: &Coefficients, order: usize) {
        set.run_blocks(UndoPrediction {
            coefficients: c,
            order,
            dimension: self.dimension,
            width: self.width,
            table: &mut self.table,
        });
    }

    /// Return whether rounding is compensated, so that [`Self::correct`] has to correct.
    pub(super) fn compensates(&self) -> bool {
        self.compensation.is_some()
    }

    /// Set the rounding error of the accepted solution to zero: that of an implicit step is unknown.
    ///
    /// The error of an earlier solution would be subtracted again in every prediction.
    pub(super) fn forget_rounding(&mut self) {
        if let Some(compensation) = &mut self.compensation {
            compensation.kept.fill(0.0);
        }
    }

    /// Write the corrected value `y = p + h g_{k+1} (f(p) - φ*_1)` by compensated summation; `weight` is `h g_{k+1}`.
    pub(super) fn correct(
        &mut self,
        weight: f64,
        predicted: &[f64],
        derivative: &[f64],
        y: &mut [f64],
    ) {
        let phi_1 = &self.table[..self.width];
        if let Some(compensation) = &mut self.compensation {
            let roundings = compensation.kept.iter_mut().zip(&compensation.predicted);
            for ((((y, p), derivative), phi), (kept, lost)) in y
                .iter_mut()
                .zip(predicted)
                .zip(derivative)
                .zip(phi_1)
                .zip(roundings)
            {
                let rho = weight * (derivative - phi) - lost;
                *y = p + rho;
                *kept = (*y - p) - rho;
            }
        }
    }

    /// Append the newest difference, from the derivative at the solution; return the weighted sum of squares of φ_{k+2} with `above`.
    pub(super) fn update(
        &mut self,
        set: InstructionSet,
        order: usize,
        vectors: &Vectors,
        inverse_weight: &[f64],
        above: bool,
    ) -> f64 {
        // Deferred addition to the rows before, as above.
        self.newest = order;
        set.run_blocks(UpdateDifferences {
            order,
            table: &mut self.table,
            vectors,
            inverse_weight,
            above,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::{Adams, OdeSystem, StepControl};

    /// y' = 1e-6: an increment of 450.4 units in the last place of one in each step of 1e-7 s.
    struct Slow;

    impl OdeSystem for Slow {
        fn dimension(&self) -> usize {
            1
        }
        fn derivative(&mut self, _t: f64, _y: &[f64], dydt: &mut [f64]) {
            dydt[0] = 1e-6;
        }
    }

    /// The error of 4000 steps.
    fn error(tolerance: f64) -> f64 {
        let control = StepControl {
            rtol: 0.0,
            atol: tolerance,
            max_step: 1e-7,
            ..StepControl::default()
        };
        let mut adams = Adams::new(1, control);
        adams.restart(0.0, &[1.0]);
        for _ in 0..4000 {
            adams.step(&mut Slow).unwrap();
        }
        (adams.y()[0] - 1.0) - 1e-6 * adams.time()
    }

    #[test]
    fn the_rounding_of_sums_is_compensated_at_tolerances_near_it() {
        assert!(error(1e-14).abs() <= f64::EPSILON);
        // Each step loses about a third of a unit in the last place.
        assert!(error(1e-12).abs() > 1000.0 * 0.2 * f64::EPSILON);
    }

    #[test]
    fn a_table_of_other_sizes_or_with_invalid_indices_is_not_like_one() {
        let like = Differences::new(3);
        let refused = |change: fn(&mut Differences)| {
            let mut changed = Differences::new(3);
            changed.restart(&padded_zeros(3), true);
            assert!(changed.is_like(&like));
            change(&mut changed);
            !changed.is_like(&like)
        };
        assert!(refused(|table| table.dimension = 4));
        assert!(refused(|table| table.width *= 2));
        assert!(refused(|table| table.table = padded_zeros(8)));
        assert!(refused(|table| table.newest = MAX_ORDER + 1));
        assert!(!refused(|table| table.newest = MAX_ORDER));
        assert!(refused(|table| table
            .compensation
            .as_mut()
            .unwrap()
            .kept
            .clear()));
        assert!(refused(|table| table
            .compensation
            .as_mut()
            .unwrap()
            .predicted
            .clear()));
    }

    #[test]
    fn the_corrected_value_is_compensated_and_its_rounding_kept() {
        let mut table = Differences::new(1);
        table.restart(&padded_zeros(1), true);
        let mut y = [0.0];
        // An increment of 1.25 units in the last place of one: rounded to one of them.
        let increment = 1.25 * f64::EPSILON;
        table.correct(0.5, &[1.0], &[2.0 * increment], &mut y);
        assert_eq!(y, [1.0 + f64::EPSILON]);
        let compensation = table.compensation.as_mut().unwrap();
        assert_eq!(compensation.kept[0], -0.25 * f64::EPSILON);
        // What the prediction lost is subtracted: one unit is left, without rounding.
        compensation.predicted[0] = 0.25 * f64::EPSILON;
        table.correct(0.5, &[1.0], &[2.0 * increment], &mut y);
        assert_eq!(y, [1.0 + f64::EPSILON]);
        assert_eq!(table.compensation.as_ref().unwrap().kept[0], 0.0);
    }

    #[test]
    fn one_pass_predicts_at_orders_one_and_two_without_compensation() {
        let mut table = Differences::new(1);
        assert!(table.can_predict_for_newton(1) && table.can_predict_for_newton(2));
        assert!(!table.can_predict_for_newton(3));
        table.newest = 3;
        assert!(!table.can_predict_for_newton(2));
        table.restart(&padded_zeros(1), true);
        assert!(!table.can_predict_for_newton(2));
    }

    #[test]
    fn the_error_estimates_take_the_rows_of_three_orders() {
        let mut table = Differences::new(1);
        for (i, row) in table.table.chunks_exact_mut(table.width).enumerate() {
            row[0] = i as f64;
        }
        let rows = |order: usize| table.rows_of_errors(order).map(|row| row[0]);
        assert_eq!(rows(1), [0.0, 0.0, 0.0]);
        assert_eq!(rows(2), [0.0, 1.0, 0.0]);
        assert_eq!(rows(5), [0.0, 4.0, 3.0]);
        assert_eq!(table.table.len(), (MAX_ORDER + 2) * table.width);
    }

    #[test]
    fn the_error_estimates_are_sums_of_squares_at_three_orders() {
        use crate::integrator::difference_kernels::Errors;
        for set in InstructionSet::available() {
            // One vector, and several with a part of one.
            for dimension in [3, 43] {
                let rows: [Numbers; 3] = [1.0, 5.0, 8.0].map(|phase| {
                    let mut row = padded_zeros(dimension);
                    for i in 0..dimension {
                        row[i] = (phase + i as f64).sin();
                    }
                    row
                });
                let (mut vectors, mut weights) = (Vectors::new(dimension), padded_zeros(dimension));
                for i in 0..dimension {
                    (vectors.derivative[i], vectors.predicted[i]) = (0.3 * i as f64, i as f64);
                    weights[i] = 1.0 + 0.1 * i as f64;
                }
                let sums = set.run_blocks(Errors {
                    rows: rows.each_ref().map(|row| &row[..]),
                    inverse_weight: &weights,
                    vectors: &mut vectors,
                    correction: Some(0.25),
                });
                let mut expected = [0.0; 3];
                for i in 0..dimension {
                    let change = vectors.derivative[i] - rows[0][i];
                    let changes = [change, change + rows[1][i], change + rows[2][i]];
                    for (sum, change) in expected.iter_mut().zip(changes) {
                        *sum += (change * weights[i]).powi(2);
                    }
                    let corrected = vectors.predicted[i] + 0.25 * change;
                    assert!((vectors.trial[i] - corrected).abs() < 1e-14, "{i}");
                }
                for (sum, expected) in sums.iter().zip(expected) {
                    assert!((sum / expected - 1.0).abs() < 1e-13, "{sum} {expected}");
                }
            }
        }
    }

    #[test]
    fn rows_above_a_fallen_order_are_completed_for_a_later_rise() {
        let mut table = Differences::new(1);
        let width = table.width;
        for (row, value) in [1.0, 10.0, 100.0, 1000.0].into_iter().enumerate() {
            table.table[row * width] = value;
        }
        table.newest = 3;
        let mut coefficients = Coefficients::new();
        coefficients.update(1.0, 1, 1.0, 3);
        let mut vectors = Vectors::new(1);
        let set = InstructionSet::detect();
        table.predict(set, &coefficients, 1, 1.0, &mut vectors);
        let rows = [0, 1, 2, 3].map(|row| table.row(row)[0]);
        assert_eq!(rows, [1001.0, 1010.0, 1100.0, 1000.0]);
        assert_eq!((vectors.predicted[0], table.newest), (1001.0, 0));
    }

    #[test]
    fn a_forgotten_rounding_is_zero() {
        let mut table = Differences::new(1);
        table.restart(&padded_zeros(1), true);
        let compensation = table.compensation.as_mut().unwrap();
        (compensation.kept[0], compensation.predicted[0]) = (1.0, 2.0);
        table.forget_rounding();
        let compensation = table.compensation.as_ref().unwrap();
        assert_eq!(
            (compensation.kept[0], compensation.predicted[0]),
            (0.0, 2.0)
        );
    }

    /// Return the coefficients of a step of 0.25 s at this order, after four of other sizes.
    fn coefficients_of_a_step(order: usize) -> Coefficients {
        let mut c = Coefficients::new();
        let mut last = (0.0, 0);
        for (i, h) in [0.1, 0.3, 0.2, 0.4, 0.25].into_iter().enumerate() {
            c.update(h, (i + 1).min(order), last.0, last.1);
            last = (h, (i + 1).min(order));
        }
        c
    }

    #[test]
    fn an_undone_prediction_leaves_the_differences_with_the_newest_one_added() {
        // Whole vectors of every width and a part of one.
        let dimension = 11;
        for set in InstructionSet::available() {
            for order in 1..=4 {
                let mut table = Differences::new(dimension);
                let width = table.width;
                for (i, value) in table.table.iter_mut().enumerate() {
                    *value = if i % width < dimension {
                        (i as f64).sin()
                    } else {
                        0.0
                    };
                }
                table.newest = order;
                let c = coefficients_of_a_step(order);
                let before = table.clone();
                table.predict(set, &c, order, 0.25, &mut Vectors::new(dimension));
                for i in 0..dimension {
                    // φ*_1 is the sum of all β φ.
                    let sum: f64 = (0..order)
                        .map(|row| c.beta[row] * (before.row(row)[i] + before.row(order)[i]))
                        .sum();
                    assert!((table.row(0)[i] - sum).abs() < 1e-13, "{order} {i}");
                }
                table.undo_prediction(set, &c, order);
                for row in 0..order {
                    let rows = table.row(row).iter().zip(before.row(row));
                    for (i, (found, before_row)) in rows.enumerate() {
                        let expected = before_row + before.row(order)[i];
                        assert!((found - expected).abs() < 1e-13, "{order} {row} {i}");
                    }
                }
            }
        }
    }

    /// Predict and update a system of `dimension` components, of which the first `count` are not zero; return predicted values and rows of
    /// these, and the sum of squares.
    fn bits_of_a_step(
        set: InstructionSet,
        (dimension, count): (usize, usize),
        (order, newest): (usize, usize),
    ) -> Vec<u64> {
        let mut table = Differences::new(dimension);
        let width = table.width;
        for (i, value) in table.table.iter_mut().enumerate() {
            if i % width < count {
                *value = ((7 * (i / width) + i % width) as f64).sin();
            }
        }
        table.newest = newest;
        let c = coefficients_of_a_step(order);
        let mut vectors = Vectors::new(dimension);
        let mut weights = padded_zeros(dimension);
        for i in 0..count {
            (vectors.y[i], vectors.derivative[i]) = (1.0 + i as f64, (i as f64).cos());
            weights[i] = 3.0 + i as f64;
        }
        table.predict(set, &c, order, 0.25, &mut vectors);
        let predicted = vectors.predicted[..count].to_vec();
        let stars: Vec<f64> = table
            .table
            .chunks(width)
            .flat_map(|row| row[..count].to_vec())
            .collect();
        let sum = table.update(set, order, &vectors, &weights, true);
        let rows = table
            .table
            .chunks(width)
            .flat_map(|row| row[..count].to_vec());
        let all = predicted.into_iter().chain(stars).chain(rows).chain([sum]);
        all.map(f64::to_bits).collect()
    }

    #[test]
    fn a_system_of_one_vector_has_the_bits_of_the_same_components_in_a_longer_one() {
        for set in InstructionSet::available() {
            for count in [1, 2, 3, 4, 7, 8] {
                for (order, newest) in (1..=5).flat_map(|k| (0..=6).map(move |i| (k, i))) {
                    let alone = bits_of_a_step(set, (count, count), (order, newest));
                    let longer = bits_of_a_step(set, (count + 16, count), (order, newest));
                    assert_eq!(alone, longer, "{}, {count}, {order}, {newest}", set.name());
                }
            }
        }
    }

    #[test]
    fn the_predicted_value_is_compensated_and_its_rounding_kept() {
        let mut table = Differences::new(1);
        let mut slope = padded_zeros(1);
        // An increment of 1.25 units in the last place of one: rounded to one of them.
        slope[0] = 1.25 * f64::EPSILON;
        table.restart(&slope, true);
        let mut vectors = Vectors::new(1);
        vectors.y[0] = 1.0;
        let mut c = Coefficients::new();
        c.update(1.0, 1, 0.0, 0);
        table.predict(InstructionSet::detect(), &c, 1, 1.0, &mut vectors);
        assert_eq!(vectors.predicted[0], 1.0 + f64::EPSILON);
        let compensation = table.compensation.as_ref().unwrap();
        assert_eq!(compensation.predicted[0], -0.25 * f64::EPSILON);
    }

    #[test]
    fn compensated_steps_differ_from_others_by_rounding_only() {
        /// y' = -y.
        struct Decay;
        impl OdeSystem for Decay {
            fn dimension(&self) -> usize {
                1
            }
            fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
                dydt[0] = -y[0];
            }
        }
        // Of the two tolerances the smaller one is 95 times the rounding of the solution.
        let [compensated, plain] = [95.0, 105.0].map(|roundings| {
            let control = StepControl {
                rtol: 0.0,
                atol: 2.0 * roundings * 2.0 * f64::EPSILON,
                max_step: 1e-3,
                max_order: 3,
                ..StepControl::default()
            };
            let mut adams = Adams::new(1, control);
            adams.restart(0.0, &[1.0]);
            while adams.time() < 0.1 {
                adams.step(&mut Decay).unwrap();
            }
            assert_eq!(adams.history.differences.compensates(), roundings < 100.0);
            adams.y()[0] / (-adams.time()).exp() - 1.0
        });
        // The truncation of steps at the tolerance, of which there are some hundreds.
        assert!(
            compensated.abs() < 2e-11 && plain.abs() < 2e-11,
            "{compensated} {plain}"
        );
    }
}
