//! The table of modified divided differences φ: predict, correct, and take back a prediction.

use serde::{Deserialize, Serialize};

use super::MAX_ORDER;
use super::coefficients::Coefficients;
use super::table::{Correct, Predict, Retreat, Update};
use crate::vector::{InstructionSet, Numbers, padded, padded_zeros};

/// `φ_1` .. φ_{k+2} of the slopes, one row a difference, and the sums that keep rounding out of y at tight tolerances.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Differences {
    /// Row i holds φ_{i+1} for every component, padded; the rows follow one another.
    table: Numbers,
    /// Components of a row, padded.
    width: usize,
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
            width,
            carry: None,
        }
    }

    /// Whether it is a table of the same size.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let carries = |carry: &Carry| [carry.kept.len(), carry.predicted.len()];
        self.width == other.width
            && self.table.len() == other.table.len()
            && (self.carry.iter()).all(|carry| carries(carry) == [self.width; 2])
    }

    /// Starts anew from the slope at one point.
    pub(super) fn restart(&mut self, slope: &[f64], compensate: bool) {
        self.table.fill(0.0);
        self.table[..slope.len()].copy_from_slice(slope);
        self.carry = compensate.then(|| Carry {
            kept: vec![0.0; slope.len()],
            predicted: vec![0.0; slope.len()],
        });
    }

    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.table[i * self.width..(i + 1) * self.width]
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
            step: h,
            table: &mut self.table,
            increment: predicted,
        });
        match &mut self.carry {
            None => predicted.iter_mut().zip(y).for_each(|(p, y)| *p += y),
            Some(carry) => {
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
    }

    /// Takes back a prediction whose step failed.
    pub(super) fn retreat(&mut self, set: InstructionSet, c: &Coefficients, order: usize) {
        set.run(Retreat {
            coefficients: c,
            order,
            dimension: self.width,
            table: &mut self.table,
        });
    }

    /// Corrects the prediction with the slope found there: y = p + h g_{k+1} (f(p) - φ*_1).
    pub(super) fn correct(
        &mut self,
        set: InstructionSet,
        weight: f64,
        predicted: &[f64],
        slope: &[f64],
        y: &mut [f64],
    ) {
        let first = &self.table[..self.width];
        match &mut self.carry {
            None => set.run(Correct {
                weight,
                predicted,
                slope,
                first,
                y,
            }),
            Some(carry) => {
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
    }

    /// Takes in the slope at the corrected solution.
    pub(super) fn update(&mut self, set: InstructionSet, order: usize, slope: &[f64]) {
        set.run(Update {
            order,
            slope,
            table: &mut self.table,
        });
    }
}
