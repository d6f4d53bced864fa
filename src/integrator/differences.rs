//! The table of modified divided differences φ: predict, correct, and take back a prediction.

use serde::{Deserialize, Serialize};

use super::MAX_ORDER;
use super::coefficients::Coefficients;
use super::difference_kernels::{Predict, UndoPrediction, UpdateDifferences};
use super::newton_kernels::{NewtonDifference, PredictForNewton};
use crate::math::simd::{InstructionSet, Numbers, padded, padded_zeros};

/// `φ_1` .. φ_{k+2} of the slopes, one row a difference, and the sums that keep rounding out of y at tight tolerances.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Differences {
    /// Row i holds φ_{i+1} for every component, padded; the rows follow one another.
    table: Numbers,
    dimension: usize,
    /// Components of a row, padded.
    width: usize,
    /// The newest row, which those before it have not had added yet; zero when they have.
    newest: usize,
    /// What rounding took from y so far; used when the tolerance is near rounding.
    carry: Option<Carry>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Carry {
    /// Lost in the accepted solution.
    kept: Vec<f64>,
    /// Lost in the prediction.
    predicted: Vec<f64>,
}

impl Differences {
    pub(super) fn new(dimension: usize) -> Self {
        let width = padded(dimension);
        Self {
            table: padded_zeros(width * (MAX_ORDER + 2)),
            dimension,
            width,
            newest: 0,
            carry: None,
        }
    }

    /// Whether it is a table of the same size.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let carries = |carry: &Carry| [carry.kept.len(), carry.predicted.len()];
        (self.dimension, self.width) == (other.dimension, other.width)
            && self.table.len() == other.table.len()
            && self.newest <= MAX_ORDER
            && (self.carry.iter()).all(|carry| carries(carry) == [self.width; 2])
    }

    /// Starts anew from the slope at one point.
    pub(super) fn restart(&mut self, slope: &[f64], compensate: bool) {
        self.table.fill(0.0);
        self.table[..slope.len()].copy_from_slice(slope);
        self.newest = 0;
        self.carry = compensate.then(|| Carry {
            kept: vec![0.0; slope.len()],
            predicted: vec![0.0; slope.len()],
        });
    }

    /// Forgets what a component was.
    pub(super) fn reset_component(&mut self, component: usize) {
        for row in self.table.chunks_exact_mut(self.width) {
            row[component] = 0.0;
        }
        if let Some(carry) = &mut self.carry {
            (carry.kept[component], carry.predicted[component]) = (0.0, 0.0);
        }
    }

    /// Row `i` as it is in the table: one of a prediction, or the newest one.
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.table[i * self.width..(i + 1) * self.width]
    }

    /// The rows that a step of `order` is judged by: φ*_1, and those of one and two orders below.
    pub(super) fn rows_of_errors(&self, order: usize) -> [&[f64]; 3] {
        [0, order - 1, order.saturating_sub(2)].map(|i| self.row(i))
    }

    /// Row `i` and, where the newest difference is still to be added to it, that one.
    pub(super) fn parts_of_row(&self, i: usize) -> (&[f64], Option<&[f64]>) {
        let newest = (i < self.newest).then(|| self.row(self.newest));
        (self.row(i), newest)
    }

    /// Turns φ into φ* and writes the predicted solution.
    pub(super) fn predict(
        &mut self,
        set: InstructionSet,
        c: &Coefficients,
        order: usize,
        h: f64,
        y: &[f64],
        predicted: &mut [f64],
    ) {
        set.run(Predict {
            coefficients: c,
            order,
            newest: std::mem::take(&mut self.newest),
            step: h,
            dimension: self.dimension,
            table: &mut self.table,
            y: self.carry.is_none().then_some(y),
            predicted: &mut *predicted,
        });
        if let Some(carry) = &mut self.carry {
            for (((p, y), kept), lost) in predicted
                .iter_mut()
                .zip(y)
                .zip(&carry.kept)
                .zip(&mut carry.predicted)
            {
                let tau = *p - kept;
                *p = y + tau;
                *lost = (*p - y) - tau;
            }
        }
    }

    /// Whether [`Self::predict_for_newton`] does for a prediction of `order`.
    pub(super) fn can_predict_for_newton(&self, order: usize) -> bool {
        order <= 2 && self.newest <= 2 && self.carry.is_none()
    }

    /// Turns φ into φ*, writes predicted velocities, and where Newton's method begins.
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
            beta: if c.equal_steps >= 2 { 1.0 } else { c.beta[1] },
            g: [c.g[0], c.g[1]],
            table: &mut self.table[..3 * self.width],
            width: self.width,
            y,
            predicted,
            trial,
        });
    }

    /// Takes in the slopes that a solution of Newton's method stands for; see [`NewtonDifference`].
    pub(super) fn append_newton_difference(
        &mut self,
        set: InstructionSet,
        order: usize,
        inverse_gamma: f64,
        [predicted, trial]: [&[f64]; 2],
    ) {
        let n = trial.len();
        self.newest = order;
        let (before, from) = self.table.split_at_mut(order * self.width);
        let (newest_q, newest_v) = from[..2 * n].split_at_mut(n);
        set.run(NewtonDifference {
            inverse_gamma,
            predicted,
            trial,
            first: &before[..n],
            rows: (newest_q, newest_v),
        });
    }

    /// Writes the slope at the end of the last step.
    pub(super) fn write_slope(&self, slope: &mut [f64]) {
        match self.parts_of_row(0) {
            (row, None) => slope.copy_from_slice(&row[..slope.len()]),
            (row, Some(newest)) => {
                for ((slope, phi), newest) in slope.iter_mut().zip(row).zip(newest) {
                    *slope = phi + newest;
                }
            }
        }
    }

    /// Takes back a prediction whose step failed.
    pub(super) fn undo_prediction(&mut self, set: InstructionSet, c: &Coefficients, order: usize) {
        set.run(UndoPrediction {
            coefficients: c,
            order,
            width: self.width,
            table: &mut self.table,
        });
    }

    /// Whether rounding is kept track of, so that [`Self::correct`] has to make the correction.
    pub(super) fn carries(&self) -> bool {
        self.carry.is_some()
    }

    /// Corrects the prediction with the slope found there and keeps what rounding takes: y = p + h g_{k+1} (f(p) - φ*_1).
    pub(super) fn correct(&mut self, weight: f64, predicted: &[f64], slope: &[f64], y: &mut [f64]) {
        let first = &self.table[..self.width];
        if let Some(carry) = &mut self.carry {
            let sums = carry.kept.iter_mut().zip(&carry.predicted);
            for ((((y, p), slope), phi), (kept, lost)) in
                y.iter_mut().zip(predicted).zip(slope).zip(first).zip(sums)
            {
                let rho = weight * (slope - phi) - lost;
                *y = p + rho;
                *kept = (*y - p) - rho;
            }
        }
    }

    /// Takes in the slope at the corrected solution; the sum of squares of φ_{k+2} over the weights, if it is asked for `above`.
    pub(super) fn update(
        &mut self,
        set: InstructionSet,
        order: usize,
        slope: &[f64],
        inverse_weight: &[f64],
        above: bool,
    ) -> f64 {
        self.newest = order;
        set.run(UpdateDifferences {
            order,
            dimension: self.dimension,
            slope,
            table: &mut self.table,
            inverse_weight,
            above,
        })
    }
}
