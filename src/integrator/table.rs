//! The loops of a step over all components, in registers: a block of components goes through all differences at once.

use pulp::{Simd, WithSimd};

use super::coefficients::Coefficients;
use super::column::Column;
use super::{MAX_ORDER, StepControl};
use crate::vector::{Lanes, Squares, WIDTH, load, vectors, vectors_mut};

/// Rows of a table of differences, one after the other; each is as long as the arrays beside it.
struct Rows<'a, S: Simd> {
    simd: S,
    table: &'a mut [S::f64s],
    blocks: usize,
}

impl<'a, S: Simd> Rows<'a, S> {
    #[inline(always)]
    fn new(simd: S, table: &'a mut [f64], dimension: usize) -> Self {
        let blocks = dimension / S::F64_LANES;
        let all = table.len() / S::F64_LANES;
        Self {
            simd,
            table: vectors_mut::<S>(table, all),
            blocks,
        }
    }

    #[inline(always)]
    fn get(&self, row: usize, block: usize) -> Lanes<S> {
        load(self.simd, &self.table[row * self.blocks + block])
    }

    #[inline(always)]
    fn set(&mut self, row: usize, block: usize, values: Lanes<S>) {
        self.table[row * self.blocks + block] = values.values();
    }
}

/// Turns φ into φ* and sums h Σ g φ*: what the predictor adds to y.
pub(super) struct Predict<'a> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) order: usize,
    pub(super) step: f64,
    pub(super) table: &'a mut [f64],
    pub(super) increment: &'a mut [f64],
}

impl WithSimd for Predict<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut beta = self.coefficients.beta;
        beta[..self.coefficients.equal_steps.min(MAX_ORDER)].fill(1.0);
        let (g, order) = (&self.coefficients.g, self.order);
        let step = Lanes::splat(simd, self.step);
        let zero = Lanes::splat(simd, 0.0);
        let mut rows = Rows::<S>::new(simd, self.table, self.increment.len());
        let blocks = rows.blocks;
        let increment = vectors_mut::<S>(self.increment, blocks);
        for (b, increment) in increment.iter_mut().enumerate() {
            // φ_{k+2} keeps the old φ_{k+1} for the error estimate one order up.
            rows.set(order + 1, b, rows.get(order, b));
            rows.set(order, b, zero);
            let (mut sum, mut above) = (zero, zero);
            for i in (0..order).rev() {
                let phi = rows.get(i, b) * zero.constant(beta[i]);
                sum = phi.mul_add(zero.constant(g[i]), sum);
                above = above + phi;
                rows.set(i, b, above);
            }
            *increment = (step * sum).values();
        }
    }
}

/// Takes back a prediction whose step failed.
pub(super) struct Retreat<'a> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) order: usize,
    pub(super) dimension: usize,
    pub(super) table: &'a mut [f64],
}

impl WithSimd for Retreat<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let inverse = self.coefficients.beta.map(|beta| 1.0 / beta);
        let mut rows = Rows::<S>::new(simd, self.table, self.dimension);
        for b in 0..rows.blocks {
            for (i, &inverse) in inverse.iter().enumerate().take(self.order) {
                let phi = rows.get(i, b) - rows.get(i + 1, b);
                rows.set(i, b, phi * phi.constant(inverse));
            }
        }
    }
}

/// Takes in the slope at the corrected solution.
pub(super) struct Update<'a> {
    pub(super) order: usize,
    pub(super) slope: &'a [f64],
    pub(super) table: &'a mut [f64],
}

impl WithSimd for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let order = self.order;
        let mut rows = Rows::<S>::new(simd, self.table, self.slope.len());
        let slope = vectors::<S>(self.slope, rows.blocks);
        for (b, slope) in slope.iter().enumerate() {
            let newest = load(simd, slope) - rows.get(0, b);
            rows.set(order, b, newest);
            rows.set(order + 1, b, newest - rows.get(order + 1, b));
            for i in 0..order {
                rows.set(i, b, rows.get(i, b) + newest);
            }
        }
    }
}

/// Sums of squared weighted differences: of the slope from the predicted one, and had the orders been one and two lower.
pub(super) struct Errors<'a> {
    pub(super) slope: &'a [f64],
    pub(super) first: &'a [f64],
    pub(super) one_below: &'a [f64],
    pub(super) two_below: &'a [f64],
    pub(super) inverse_weight: &'a [f64],
}

impl WithSimd for Errors<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
        let blocks = self.slope.len() / S::F64_LANES;
        let slope = vectors::<S>(self.slope, blocks);
        let first = vectors::<S>(self.first, blocks);
        let one_below = vectors::<S>(self.one_below, blocks);
        let two_below = vectors::<S>(self.two_below, blocks);
        let inverse_weight = vectors::<S>(self.inverse_weight, blocks);
        let parts = WIDTH / S::F64_LANES;
        let (mut at, mut one, mut two) =
            (Squares::new(simd), Squares::new(simd), Squares::new(simd));
        for group in 0..blocks / parts {
            for part in 0..parts {
                let b = group * parts + part;
                let weight = load(simd, &inverse_weight[b]);
                let change = load(simd, &slope[b]) - load(simd, &first[b]);
                at.add(part, change * weight);
                one.add(part, (load(simd, &one_below[b]) + change) * weight);
                two.add(part, (load(simd, &two_below[b]) + change) * weight);
            }
        }
        [at.total(), one.total(), two.total()]
    }
}

/// Sum of squared weighted values.
pub(super) struct WeightedSquares<'a> {
    pub(super) values: &'a [f64],
    pub(super) inverse_weight: &'a [f64],
}

impl WithSimd for WeightedSquares<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let blocks = self.values.len() / S::F64_LANES;
        let values = vectors::<S>(self.values, blocks);
        let inverse_weight = vectors::<S>(self.inverse_weight, blocks);
        let parts = WIDTH / S::F64_LANES;
        let mut sum = Squares::new(simd);
        for group in 0..blocks / parts {
            for part in 0..parts {
                let b = group * parts + part;
                sum.add(
                    part,
                    load(simd, &values[b]) * load(simd, &inverse_weight[b]),
                );
            }
        }
        sum.total()
    }
}

/// 1/(atol + rtol |y|).
pub(super) struct Weigh<'a> {
    pub(super) control: &'a StepControl,
    pub(super) y: &'a [f64],
    pub(super) inverse_weight: &'a mut [f64],
}

impl WithSimd for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.y.len() / S::F64_LANES;
        let rtol = Lanes::splat(simd, self.control.rtol);
        let atol = Lanes::splat(simd, self.control.atol);
        let y = vectors::<S>(self.y, blocks);
        for (weight, y) in vectors_mut::<S>(self.inverse_weight, blocks)
            .iter_mut()
            .zip(y)
        {
            let tolerance = load(simd, y).abs().mul_add(rtol, atol);
            *weight = (rtol.constant(1.0) / tolerance).values();
        }
    }
}

/// y = p + weight (f(p) - φ*_1).
pub(super) struct Correct<'a> {
    pub(super) weight: f64,
    pub(super) predicted: &'a [f64],
    pub(super) slope: &'a [f64],
    pub(super) first: &'a [f64],
    pub(super) y: &'a mut [f64],
}

impl WithSimd for Correct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.y.len() / S::F64_LANES;
        let weight = Lanes::splat(simd, self.weight);
        let predicted = vectors::<S>(self.predicted, blocks);
        let slope = vectors::<S>(self.slope, blocks);
        let first = vectors::<S>(self.first, blocks);
        let y = vectors_mut::<S>(self.y, blocks);
        for b in 0..blocks {
            let change = load(simd, &slope[b]) - load(simd, &first[b]);
            y[b] = change.mul_add(weight, load(simd, &predicted[b])).values();
        }
    }
}

/// Sums of squared weighted changes, of slopes and of the solution, between the two evaluations of a step.
pub(super) struct SlopeChange<'a> {
    pub(super) slope: &'a [f64],
    pub(super) at_prediction: &'a [f64],
    /// Where they were evaluated: prediction and solution.
    pub(super) ends: (&'a [f64], &'a [f64]),
    pub(super) inverse_weight: &'a [f64],
}

impl WithSimd for SlopeChange<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 2] {
        let blocks = self.slope.len().div_ceil(S::F64_LANES);
        let slope = Column::<S>::new(simd, self.slope);
        let at_prediction = Column::<S>::new(simd, self.at_prediction);
        let prediction = Column::<S>::new(simd, self.ends.0);
        let solution = Column::<S>::new(simd, self.ends.1);
        let inverse_weight = Column::<S>::new(simd, self.inverse_weight);
        let parts = WIDTH / S::F64_LANES;
        let (mut slopes, mut steps) = (Squares::new(simd), Squares::new(simd));
        for b in 0..blocks {
            let weight = inverse_weight.get(b);
            slopes.add(b % parts, (slope.get(b) - at_prediction.get(b)) * weight);
            steps.add(b % parts, (solution.get(b) - prediction.get(b)) * weight);
        }
        [slopes.total(), steps.total()]
    }
}
