//! The table of modified divided differences φ: predict, correct, and take back a prediction.

use serde::{Deserialize, Serialize};

use super::MAX_ORDER;
use super::coefficients::Coefficients;

/// `φ_1` .. φ_{k+2} of the slopes, one row a difference, and the sums that keep rounding out of y at tight tolerances.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Differences {
    /// Row i holds φ_{i+1} for every component.
    rows: Vec<Vec<f64>>,
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
        Self {
            rows: vec![vec![0.0; dimension]; MAX_ORDER + 2],
            carry: None,
        }
    }

    /// Starts anew from the slope at one point.
    pub(super) fn restart(&mut self, slope: &[f64], compensate: bool) {
        self.rows[0].copy_from_slice(slope);
        for row in &mut self.rows[1..] {
            row.fill(0.0);
        }
        self.carry = compensate.then(|| Carry {
            kept: vec![0.0; slope.len()],
            predicted: vec![0.0; slope.len()],
        });
    }

    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.rows[i]
    }

    /// Turns φ into φ* and writes the predicted solution.
    pub(super) fn predict(
        &mut self,
        c: &Coefficients,
        order: usize,
        h: f64,
        y: &[f64],
        predicted: &mut [f64],
    ) {
        for i in c.equal_steps..order {
            let beta = c.beta[i];
            self.rows[i].iter_mut().for_each(|phi| *phi *= beta);
        }
        // φ_{k+2} keeps the old φ_{k+1} for the error estimate one order up.
        let (low, high) = self.rows.split_at_mut(order + 1);
        high[0].copy_from_slice(&low[order]);
        low[order].fill(0.0);
        predicted.fill(0.0);
        for i in (0..order).rev() {
            let g = c.g[i];
            let (low, high) = self.rows.split_at_mut(i + 1);
            for ((p, phi), next) in predicted.iter_mut().zip(&mut low[i]).zip(&high[0]) {
                *p += g * *phi;
                *phi += next;
            }
        }
        match &mut self.carry {
            None => predicted
                .iter_mut()
                .zip(y)
                .for_each(|(p, y)| *p = y + h * *p),
            Some(carry) => {
                for (((p, y), kept), lost) in predicted
                    .iter_mut()
                    .zip(y)
                    .zip(&carry.kept)
                    .zip(&mut carry.predicted)
                {
                    let tau = h * *p - kept;
                    *p = y + tau;
                    *lost = (*p - y) - tau;
                }
            }
        }
    }

    /// Takes back a prediction whose step failed.
    pub(super) fn retreat(&mut self, c: &Coefficients, order: usize) {
        for i in 0..order {
            let inverse = 1.0 / c.beta[i];
            let (low, high) = self.rows.split_at_mut(i + 1);
            for (phi, next) in low[i].iter_mut().zip(&high[0]) {
                *phi = inverse * (*phi - next);
            }
        }
    }

    /// Corrects the prediction with the slope found there: y = p + h g_{k+1} (f(p) - φ*_1).
    pub(super) fn correct(
        &mut self,
        c: &Coefficients,
        order: usize,
        h: f64,
        predicted: &[f64],
        slope: &[f64],
        y: &mut [f64],
    ) {
        let weight = h * c.g[order];
        let first = &self.rows[0];
        match &mut self.carry {
            None => {
                for (((y, p), slope), phi) in y.iter_mut().zip(predicted).zip(slope).zip(first) {
                    *y = p + weight * (slope - phi);
                }
            }
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
    pub(super) fn update(&mut self, order: usize, slope: &[f64]) {
        let (low, high) = self.rows.split_at_mut(order + 1);
        let (old, newest) = low.split_at_mut(order);
        for (((newest, after), first), slope) in newest[0]
            .iter_mut()
            .zip(&mut high[0])
            .zip(&old[0])
            .zip(slope)
        {
            *newest = slope - first;
            *after = *newest - *after;
        }
        for row in old {
            for (phi, newest) in row.iter_mut().zip(&newest[0]) {
                *phi += newest;
            }
        }
    }

    /// Takes the past of one component to have had a constant `slope`.
    pub(super) fn assume_constant_slope(&mut self, component: usize, slope: f64) {
        for row in &mut self.rows {
            row[component] = 0.0;
        }
        self.rows[0][component] = slope;
    }
}
