//! The loops of the implicit corrector over all coordinates, each one pass.

use pulp::{Simd, WithSimd};

use super::column::{Column, ColumnMut};
use crate::vector::{Lanes, Squares, WIDTH};

/// Where the iteration begins: the predicted velocities, and the coordinates that follow from them.
pub(super) struct Begin<'a> {
    pub(super) gamma: f64,
    /// Predicted coordinates and velocities.
    pub(super) predicted: (&'a [f64], &'a [f64]),
    /// φ*_1 of the coordinates.
    pub(super) first: &'a [f64],
    pub(super) trial: (&'a mut [f64], &'a mut [f64]),
}

impl WithSimd for Begin<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.first.len().div_ceil(S::F64_LANES);
        let gamma = Lanes::splat(simd, self.gamma);
        let q = Column::<S>::new(simd, self.predicted.0);
        let v = Column::<S>::new(simd, self.predicted.1);
        let first = Column::<S>::new(simd, self.first);
        let mut trial_q = ColumnMut::<S>::new(simd, self.trial.0);
        let mut trial_v = ColumnMut::<S>::new(simd, self.trial.1);
        for b in 0..blocks {
            let speed = v.get(b);
            trial_v.set(b, speed);
            trial_q.set(b, gamma.mul_add(speed - first.get(b), q.get(b)));
        }
    }
}

/// What is wrong with the velocities: `p_v - v + γ (a - φ*_v)`; the sum of its squares over their weights.
pub(super) struct Residual<'a> {
    pub(super) gamma: f64,
    pub(super) predicted: &'a [f64],
    pub(super) trial: &'a [f64],
    pub(super) slope: &'a [f64],
    pub(super) first: &'a [f64],
    pub(super) inverse_weight: &'a [f64],
    pub(super) wrong: &'a mut [f64],
}

impl WithSimd for Residual<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let blocks = self.wrong.len().div_ceil(S::F64_LANES);
        let gamma = Lanes::splat(simd, self.gamma);
        let predicted = Column::<S>::new(simd, self.predicted);
        let trial = Column::<S>::new(simd, self.trial);
        let slope = Column::<S>::new(simd, self.slope);
        let first = Column::<S>::new(simd, self.first);
        let mut wrong = ColumnMut::<S>::new(simd, self.wrong);
        let inverse_weight = Column::<S>::new(simd, self.inverse_weight);
        let parts = WIDTH / S::F64_LANES;
        let mut sum = Squares::new(simd);
        for b in 0..blocks {
            let change = slope.get(b) - first.get(b);
            let distance = predicted.get(b) - trial.get(b);
            let left = gamma.mul_add(change, distance);
            wrong.set(b, left);
            sum.add(b % parts, left * inverse_weight.get(b));
        }
        sum.total()
    }
}

/// Adds a correction of velocities, and what follows for the coordinates; the sums of squares of both over
/// their weights.
pub(super) struct Apply<'a> {
    pub(super) gamma: f64,
    pub(super) correction: &'a [f64],
    /// Of coordinates and of velocities.
    pub(super) inverse_weight: (&'a [f64], &'a [f64]),
    pub(super) trial: (&'a mut [f64], &'a mut [f64]),
}

impl WithSimd for Apply<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 2] {
        let blocks = self.correction.len().div_ceil(S::F64_LANES);
        let gamma = Lanes::splat(simd, self.gamma);
        let correction = Column::<S>::new(simd, self.correction);
        let weight_q = Column::<S>::new(simd, self.inverse_weight.0);
        let weight_v = Column::<S>::new(simd, self.inverse_weight.1);
        let mut q = ColumnMut::<S>::new(simd, self.trial.0);
        let mut v = ColumnMut::<S>::new(simd, self.trial.1);
        let parts = WIDTH / S::F64_LANES;
        let (mut lengths, mut speeds) = (Squares::new(simd), Squares::new(simd));
        for b in 0..blocks {
            let change = correction.get(b);
            let length = gamma * change;
            q.set(b, q.get(b) + length);
            v.set(b, v.get(b) + change);
            lengths.add(b % parts, length * weight_q.get(b));
            speeds.add(b % parts, change * weight_v.get(b));
        }
        [lengths.total(), speeds.total()]
    }
}

/// The slopes that a solution stands for: dq/dt = v, `dv/dt = φ*_v + (v - p_v)/γ`.
pub(super) struct Slopes<'a> {
    pub(super) inverse_gamma: f64,
    pub(super) predicted: &'a [f64],
    pub(super) trial: &'a [f64],
    pub(super) first: &'a [f64],
    pub(super) slope: (&'a mut [f64], &'a mut [f64]),
}

impl WithSimd for Slopes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.trial.len().div_ceil(S::F64_LANES);
        let inverse = Lanes::splat(simd, self.inverse_gamma);
        let predicted = Column::<S>::new(simd, self.predicted);
        let trial = Column::<S>::new(simd, self.trial);
        let first = Column::<S>::new(simd, self.first);
        let mut rates = ColumnMut::<S>::new(simd, self.slope.0);
        let mut accelerations = ColumnMut::<S>::new(simd, self.slope.1);
        for b in 0..blocks {
            let speed = trial.get(b);
            rates.set(b, speed);
            let distance = speed - predicted.get(b);
            accelerations.set(b, inverse.mul_add(distance, first.get(b)));
        }
    }
}
