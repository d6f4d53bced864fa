//! The loops of the implicit corrector over all coordinates, each one pass.

use pulp::{Simd, WithSimd};

use super::slice_lanes::{SliceLanes, SliceLanesMut, each_register, registers};
use crate::math::simd::{Lanes, Squares};

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
        let n = self.first.len();
        let gamma = Lanes::splat(simd, self.gamma);
        let q = SliceLanes::<S>::new(simd, self.predicted.0, n);
        let v = SliceLanes::<S>::new(simd, self.predicted.1, n);
        let first = SliceLanes::<S>::new(simd, self.first, n);
        let mut trial_q = SliceLanesMut::<S>::new(simd, self.trial.0, n);
        let mut trial_v = SliceLanesMut::<S>::new(simd, self.trial.1, n);
        let (whole, rest) = registers::<S>(n);
        for b in 0..whole {
            let speed = v.get(b);
            trial_v.set(b, speed);
            trial_q.set(b, gamma.mul_add(speed - first.get(b), q.get(b)));
        }
        if rest > 0 {
            let speed = v.rest();
            trial_v.set_rest(speed);
            trial_q.set_rest(gamma.mul_add(speed - first.rest(), q.rest()));
        }
    }
}

/// Where the iteration begins, and the table of the prediction, in one pass: for orders one and two, and one row at most that
/// those before it have not had added yet.
pub(super) struct PredictForNewton<'a> {
    pub(super) order: usize,
    /// See [`Predict`](super::difference_kernels::Predict).
    pub(super) newest: usize,
    pub(super) step: f64,
    pub(super) gamma: f64,
    /// `β_2`, and `g_1` and `g_2`.
    pub(super) beta: f64,
    pub(super) g: [f64; 2],
    /// The first three rows of the table, and the length of each.
    pub(super) table: &'a mut [f64],
    pub(super) width: usize,
    pub(super) y: (&'a [f64], &'a [f64]),
    /// Predicted velocities; predicted coordinates are not needed.
    pub(super) predicted: &'a mut [f64],
    pub(super) trial: (&'a mut [f64], &'a mut [f64]),
}

/// The constants of [`PredictForNewton`] in registers.
struct LowOrderPredictor<S: Simd> {
    two: bool,
    newest: usize,
    step: Lanes<S>,
    beta: Lanes<S>,
    g: [Lanes<S>; 2],
}

impl<S: Simd> LowOrderPredictor<S> {
    /// φ*_1 and φ*_2 from what the first three rows hold, and the prediction from y.
    #[inline(always)]
    fn predict(&self, rows: [Lanes<S>; 3], y: Lanes<S>) -> ([Lanes<S>; 2], Lanes<S>) {
        let [mut first, mut second, third] = rows;
        if self.newest == 2 {
            (first, second) = (first + third, second + third);
        } else if self.newest == 1 {
            first = first + second;
        }
        if self.two {
            let phi = second * self.beta;
            let sum = first.mul_add(self.g[0], phi * self.g[1]);
            ([phi + first, phi], self.step * sum + y)
        } else {
            ([first, second], self.step * (first * self.g[0]) + y)
        }
    }
}

impl WithSimd for PredictForNewton<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let splat = |value| Lanes::splat(simd, value);
        let n = self.predicted.len();
        let gamma = splat(self.gamma);
        let with = LowOrderPredictor::<S> {
            two: self.order == 2,
            newest: self.newest,
            step: splat(self.step),
            beta: splat(self.beta),
            g: self.g.map(splat),
        };
        let (first, rest) = self.table.split_at_mut(self.width);
        let (second, third) = rest.split_at_mut(self.width);
        let (first_q, first_v) = first.split_at_mut(n);
        let (second_q, second_v) = second.split_at_mut(n);
        let (third_q, third_v) = third[..2 * n].split_at(n);
        let mut first_q = SliceLanesMut::<S>::new(simd, first_q, n);
        let mut first_v = SliceLanesMut::<S>::new(simd, first_v, n);
        let mut second_q = SliceLanesMut::<S>::new(simd, second_q, n);
        let mut second_v = SliceLanesMut::<S>::new(simd, second_v, n);
        let third_q = SliceLanes::<S>::new(simd, third_q, n);
        let third_v = SliceLanes::<S>::new(simd, third_v, n);
        let y_q = SliceLanes::<S>::new(simd, self.y.0, n);
        let y_v = SliceLanes::<S>::new(simd, self.y.1, n);
        let mut predicted = SliceLanesMut::<S>::new(simd, self.predicted, n);
        let mut trial_q = SliceLanesMut::<S>::new(simd, self.trial.0, n);
        let mut trial_v = SliceLanesMut::<S>::new(simd, self.trial.1, n);
        let (whole, rest) = registers::<S>(n);
        for b in 0..whole {
            let rows = [first_v.get(b), second_v.get(b), third_v.get(b)];
            let (rows, speed) = with.predict(rows, y_v.get(b));
            first_v.set(b, rows[0]);
            second_v.set(b, rows[1]);
            predicted.set(b, speed);
            trial_v.set(b, speed);
            let rows = [first_q.get(b), second_q.get(b), third_q.get(b)];
            let (rows, place) = with.predict(rows, y_q.get(b));
            first_q.set(b, rows[0]);
            second_q.set(b, rows[1]);
            trial_q.set(b, gamma.mul_add(speed - rows[0], place));
        }
        if rest > 0 {
            let rows = [first_v.rest(), second_v.rest(), third_v.rest()];
            let (rows, speed) = with.predict(rows, y_v.rest());
            first_v.set_rest(rows[0]);
            second_v.set_rest(rows[1]);
            predicted.set_rest(speed);
            trial_v.set_rest(speed);
            let rows = [first_q.rest(), second_q.rest(), third_q.rest()];
            let (rows, place) = with.predict(rows, y_q.rest());
            first_q.set_rest(rows[0]);
            second_q.set_rest(rows[1]);
            trial_q.set_rest(gamma.mul_add(speed - rows[0], place));
        }
    }
}

/// The newest difference that a solution stands for: `v - φ*_q` and `(v - p_v)/γ`.
pub(super) struct NewtonDifference<'a> {
    pub(super) inverse_gamma: f64,
    pub(super) predicted: &'a [f64],
    pub(super) trial: &'a [f64],
    /// φ*_1 of the coordinates.
    pub(super) first: &'a [f64],
    /// Where it goes, of coordinates and of velocities.
    pub(super) rows: (&'a mut [f64], &'a mut [f64]),
}

impl WithSimd for NewtonDifference<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.trial.len();
        let inverse = Lanes::splat(simd, self.inverse_gamma);
        let predicted = SliceLanes::<S>::new(simd, self.predicted, n);
        let trial = SliceLanes::<S>::new(simd, self.trial, n);
        let first = SliceLanes::<S>::new(simd, self.first, n);
        let mut newest_q = SliceLanesMut::<S>::new(simd, self.rows.0, n);
        let mut newest_v = SliceLanesMut::<S>::new(simd, self.rows.1, n);
        let (whole, rest) = registers::<S>(n);
        for b in 0..whole {
            let speed = trial.get(b);
            newest_q.set(b, speed - first.get(b));
            newest_v.set(b, (speed - predicted.get(b)) * inverse);
        }
        if rest > 0 {
            let speed = trial.rest();
            newest_q.set_rest(speed - first.rest());
            newest_v.set_rest((speed - predicted.rest()) * inverse);
        }
    }
}

/// What is wrong with the velocities at the prediction, `γ (a - φ*_v)`; the sum of its squares over their weights.
pub(super) struct FirstResidual<'a> {
    pub(super) gamma: f64,
    pub(super) slope: &'a [f64],
    pub(super) first: &'a [f64],
    pub(super) inverse_weight: &'a [f64],
    pub(super) residual: &'a mut [f64],
}

impl WithSimd for FirstResidual<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let n = self.residual.len();
        let gamma = Lanes::splat(simd, self.gamma);
        let slope = SliceLanes::<S>::new(simd, self.slope, n);
        let first = SliceLanes::<S>::new(simd, self.first, n);
        let weight = SliceLanes::<S>::new(simd, self.inverse_weight, n);
        let mut residual = SliceLanesMut::<S>::new(simd, self.residual, n);
        let mut sum = Squares::new(simd);
        each_register!(
            S,
            n,
            |part, b| {
                let left = gamma * (slope.get(b) - first.get(b));
                residual.set(b, left);
                sum.add(part, left * weight.get(b));
            },
            {
                let left = gamma * (slope.rest() - first.rest());
                residual.set_rest(left);
                sum.add(part, left * weight.rest());
            }
        );
        sum.total()
    }
}

/// What is wrong with the velocities: `p_v - v + γ (a - φ*_v)`.
pub(super) struct Residual<'a> {
    pub(super) gamma: f64,
    pub(super) predicted: &'a [f64],
    pub(super) trial: &'a [f64],
    pub(super) slope: &'a [f64],
    pub(super) first: &'a [f64],
    pub(super) residual: &'a mut [f64],
}

impl WithSimd for Residual<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.residual.len();
        let gamma = Lanes::splat(simd, self.gamma);
        let predicted = SliceLanes::<S>::new(simd, self.predicted, n);
        let trial = SliceLanes::<S>::new(simd, self.trial, n);
        let slope = SliceLanes::<S>::new(simd, self.slope, n);
        let first = SliceLanes::<S>::new(simd, self.first, n);
        let mut residual = SliceLanesMut::<S>::new(simd, self.residual, n);
        let (whole, rest) = registers::<S>(n);
        for b in 0..whole {
            let distance = predicted.get(b) - trial.get(b);
            residual.set(b, gamma.mul_add(slope.get(b) - first.get(b), distance));
        }
        if rest > 0 {
            let distance = predicted.rest() - trial.rest();
            residual.set_rest(gamma.mul_add(slope.rest() - first.rest(), distance));
        }
    }
}

/// Adds a correction of velocities, and what follows for the coordinates.
pub(super) struct Apply<'a> {
    pub(super) gamma: f64,
    pub(super) correction: &'a [f64],
    /// Of coordinates and of velocities.
    pub(super) inverse_weight: (&'a [f64], &'a [f64]),
    /// Predicted velocities.
    pub(super) predicted: &'a [f64],
    /// φ*_1 of the coordinates.
    pub(super) first: &'a [f64],
    pub(super) trial: (&'a mut [f64], &'a mut [f64]),
}

/// Sums of squares over the weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Applied {
    /// Of the correction of coordinates.
    pub(super) lengths: f64,
    /// Of velocities.
    pub(super) speeds: f64,
    /// Of how far the slopes that the solution stands for are from those foretold: `v - φ*_q` and `(v - p_v)/γ`.
    pub(super) error: f64,
}

/// The sums of [`Apply`] in registers.
struct ApplySums<S: Simd> {
    gamma: Lanes<S>,
    inverse: Lanes<S>,
    lengths: Squares<S>,
    speeds: Squares<S>,
    error: Squares<S>,
}

/// A register of what [`Apply`] reads.
struct Correction<S: Simd> {
    change: Lanes<S>,
    weight_q: Lanes<S>,
    weight_v: Lanes<S>,
    predicted: Lanes<S>,
    first: Lanes<S>,
    q: Lanes<S>,
    v: Lanes<S>,
}

impl<S: Simd> ApplySums<S> {
    /// Coordinates and velocities with their correction.
    #[inline(always)]
    fn correct(&mut self, part: usize, at: &Correction<S>) -> [Lanes<S>; 2] {
        let length = self.gamma * at.change;
        let v = at.v + at.change;
        self.lengths.add(part, length * at.weight_q);
        self.speeds.add(part, at.change * at.weight_v);
        let acceleration = (v - at.predicted) * self.inverse;
        // Coordinates and velocities into parts of one sum.
        self.error.add(part, (v - at.first) * at.weight_q);
        self.error.add(part, acceleration * at.weight_v);
        [at.q + length, v]
    }
}

impl WithSimd for Apply<'_> {
    type Output = Applied;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Applied {
        let n = self.correction.len();
        let correction = SliceLanes::<S>::new(simd, self.correction, n);
        let weight_q = SliceLanes::<S>::new(simd, self.inverse_weight.0, n);
        let weight_v = SliceLanes::<S>::new(simd, self.inverse_weight.1, n);
        let predicted = SliceLanes::<S>::new(simd, self.predicted, n);
        let first = SliceLanes::<S>::new(simd, self.first, n);
        let mut q = SliceLanesMut::<S>::new(simd, self.trial.0, n);
        let mut v = SliceLanesMut::<S>::new(simd, self.trial.1, n);
        let mut sums = ApplySums {
            gamma: Lanes::splat(simd, self.gamma),
            inverse: Lanes::splat(simd, 1.0 / self.gamma),
            lengths: Squares::new(simd),
            speeds: Squares::new(simd),
            error: Squares::new(simd),
        };
        each_register!(
            S,
            n,
            |part, b| {
                let at = Correction {
                    change: correction.get(b),
                    weight_q: weight_q.get(b),
                    weight_v: weight_v.get(b),
                    predicted: predicted.get(b),
                    first: first.get(b),
                    q: q.get(b),
                    v: v.get(b),
                };
                let [to_q, to_v] = sums.correct(part, &at);
                q.set(b, to_q);
                v.set(b, to_v);
            },
            {
                let at = Correction {
                    change: correction.rest(),
                    weight_q: weight_q.rest(),
                    weight_v: weight_v.rest(),
                    predicted: predicted.rest(),
                    first: first.rest(),
                    q: q.rest(),
                    v: v.rest(),
                };
                let [to_q, to_v] = sums.correct(part, &at);
                q.set_rest(to_q);
                v.set_rest(to_v);
            }
        );
        Applied {
            lengths: sums.lengths.total(),
            speeds: sums.speeds.total(),
            error: sums.error.total(),
        }
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
        let n = self.trial.len();
        let inverse = Lanes::splat(simd, self.inverse_gamma);
        let predicted = SliceLanes::<S>::new(simd, self.predicted, n);
        let trial = SliceLanes::<S>::new(simd, self.trial, n);
        let first = SliceLanes::<S>::new(simd, self.first, n);
        let mut rates = SliceLanesMut::<S>::new(simd, self.slope.0, n);
        let mut accelerations = SliceLanesMut::<S>::new(simd, self.slope.1, n);
        let (whole, rest) = registers::<S>(n);
        for b in 0..whole {
            let speed = trial.get(b);
            rates.set(b, speed);
            let distance = speed - predicted.get(b);
            accelerations.set(b, inverse.mul_add(distance, first.get(b)));
        }
        if rest > 0 {
            let speed = trial.rest();
            rates.set_rest(speed);
            let distance = speed - predicted.rest();
            accelerations.set_rest(inverse.mul_add(distance, first.rest()));
        }
    }
}
