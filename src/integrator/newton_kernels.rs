//! SIMD kernels of the implicit corrector over all coordinates, one pass each.

use pulp::{Simd, WithSimd};

use super::slice_lanes::{At, SliceLanes, SliceLanesMut, each_vector, vector_count};
use crate::math::simd::{Lanes, Squares};

/// Write the first iterate: `v = p_v` and `q = p_q + γ (v - φ*_q)`.
pub(super) struct Begin<'a> {
    pub(super) gamma: f64,
    /// Predicted coordinates and velocities.
    pub(super) predicted: (&'a [f64], &'a [f64]),
    /// φ*_1 of the coordinates.
    pub(super) phi_1: &'a [f64],
    pub(super) trial: (&'a mut [f64], &'a mut [f64]),
}

impl WithSimd for Begin<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.phi_1.len();
        let gamma = Lanes::splat(simd, self.gamma);
        let q = SliceLanes::<S>::new(simd, self.predicted.0, n);
        let v = SliceLanes::<S>::new(simd, self.predicted.1, n);
        let phi_1 = SliceLanes::<S>::new(simd, self.phi_1, n);
        let mut trial_q = SliceLanesMut::<S>::new(simd, self.trial.0, n);
        let mut trial_v = SliceLanesMut::<S>::new(simd, self.trial.1, n);
        each_vector!(S, n, |at| {
            let speed = v.get(at);
            // v = p_v; q = p_q + γ (v - φ*_q).
            trial_v.set(at, speed);
            trial_q.set(at, gamma.mul_add(speed - phi_1.get(at), q.get(at)));
        });
    }
}

/// Predict at orders one and two and write the first iterate in one pass.
///
/// The general [`Predict`](super::difference_kernels::Predict) and [`Begin`] would be two passes.
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
    /// Predicted velocities; the corrector needs no predicted coordinates.
    pub(super) predicted: &'a mut [f64],
    pub(super) trial: (&'a mut [f64], &'a mut [f64]),
}

/// Constants of [`PredictForNewton`] as SIMD vectors.
struct LowOrderPredictor<S: Simd> {
    beta: Lanes<S>,
    /// `h g_1` and `h g_2`.
    weights: [Lanes<S>; 2],
}

impl<S: Simd> LowOrderPredictor<S> {
    /// Return φ*_1, φ*_2 and the predicted value from the first three rows and y.
    #[inline(always)]
    fn predict<const TWO: bool, const NEWEST: usize>(
        &self,
        rows: [Lanes<S>; 3],
        y: Lanes<S>,
    ) -> ([Lanes<S>; 2], Lanes<S>) {
        let [mut first, mut second, third] = rows;
        // Deferred addition of the newest difference.
        if NEWEST == 2 {
            (first, second) = (first + third, second + third);
        } else if NEWEST == 1 {
            first = first + second;
        }
        // Order two: p = y + h (g_1 φ_1 + g_2 β_2 φ_2); order one: p = y + h g_1 φ_1.
        if TWO {
            let phi = second * self.beta;
            let with_second = phi.mul_add(self.weights[1], y);
            (
                [phi + first, phi],
                first.mul_add(self.weights[0], with_second),
            )
        } else {
            ([first, second], first.mul_add(self.weights[0], y))
        }
    }
}

impl WithSimd for PredictForNewton<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // Nearly all steps have order two after a step of order two.
        match (self.order == 2, self.newest) {
            (true, 2) => self.run::<S, true, 2>(simd),
            (true, 1) => self.run::<S, true, 1>(simd),
            (true, _) => self.run::<S, true, 0>(simd),
            (false, 2) => self.run::<S, false, 2>(simd),
            (false, 1) => self.run::<S, false, 1>(simd),
            (false, _) => self.run::<S, false, 0>(simd),
        }
    }
}

impl PredictForNewton<'_> {
    /// Predict at order two or one, with the newest difference in row `NEWEST` or added already.
    #[inline(always)]
    fn run<S: Simd, const TWO: bool, const NEWEST: usize>(self, simd: S) {
        let splat = |value| Lanes::splat(simd, value);
        let n = self.predicted.len();
        let gamma = splat(self.gamma);
        let with = LowOrderPredictor::<S> {
            beta: splat(self.beta),
            weights: self.g.map(|g| splat(self.step * g)),
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
        each_vector!(S, n, |at| {
            // Velocities first: their predicted value enters the coordinates.
            let rows = [first_v.get(at), second_v.get(at), third_v.get(at)];
            let (rows, speed) = with.predict::<TWO, NEWEST>(rows, y_v.get(at));
            first_v.set(at, rows[0]);
            second_v.set(at, rows[1]);
            predicted.set(at, speed);
            trial_v.set(at, speed);
            let rows = [first_q.get(at), second_q.get(at), third_q.get(at)];
            let (rows, place) = with.predict::<TWO, NEWEST>(rows, y_q.get(at));
            first_q.set(at, rows[0]);
            second_q.set(at, rows[1]);
            trial_q.set(at, gamma.mul_add(speed - rows[0], place));
        });
    }
}

/// Write the residual at the predicted value, `γ (a - φ*_v)`; return its weighted sum of squares.
pub(super) struct FirstResidual<'a> {
    pub(super) gamma: f64,
    pub(super) derivative: &'a [f64],
    pub(super) phi_1: &'a [f64],
    pub(super) inverse_weight: &'a [f64],
    pub(super) residual: &'a mut [f64],
}

impl WithSimd for FirstResidual<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let n = self.residual.len();
        let gamma = Lanes::splat(simd, self.gamma);
        let derivative = SliceLanes::<S>::new(simd, self.derivative, n);
        let phi_1 = SliceLanes::<S>::new(simd, self.phi_1, n);
        let weight = SliceLanes::<S>::new(simd, self.inverse_weight, n);
        let mut residual = SliceLanesMut::<S>::new(simd, self.residual, n);
        let mut sum = Squares::new(simd);
        each_vector!(S, n, |part, at| {
            // r = γ (a - φ*_v) at the predicted value.
            let left = gamma * (derivative.get(at) - phi_1.get(at));
            residual.set(at, left);
            sum.add(part, left * weight.get(at));
        });
        sum.total()
    }
}

/// Write the residual `p_v - v + γ (a - φ*_v)`.
pub(super) struct Residual<'a> {
    pub(super) gamma: f64,
    pub(super) predicted: &'a [f64],
    pub(super) trial: &'a [f64],
    pub(super) derivative: &'a [f64],
    pub(super) phi_1: &'a [f64],
    pub(super) written: &'a mut [f64],
}

impl WithSimd for Residual<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.written.len();
        let gamma = Lanes::splat(simd, self.gamma);
        let predicted = SliceLanes::<S>::new(simd, self.predicted, n);
        let trial = SliceLanes::<S>::new(simd, self.trial, n);
        let derivative = SliceLanes::<S>::new(simd, self.derivative, n);
        let phi_1 = SliceLanes::<S>::new(simd, self.phi_1, n);
        let mut residual = SliceLanesMut::<S>::new(simd, self.written, n);
        each_vector!(S, n, |at| {
            // r = p_v - v + γ (a - φ*_v).
            let distance = predicted.get(at) - trial.get(at);
            residual.set(
                at,
                gamma.mul_add(derivative.get(at) - phi_1.get(at), distance),
            );
        });
    }
}

/// Add a correction Δ of the velocities, and γ Δ to the coordinates. `NEWEST`: write the newest difference, too, from the corrector's
/// equation: `v - φ*_q` and `(v - p_v)/γ`. `FIRST`: v is the predicted value before, so that the latter is Δ/γ.
pub(super) struct Apply<'a, const NEWEST: bool, const FIRST: bool> {
    pub(super) gamma: f64,
    pub(super) correction: &'a [f64],
    /// Weights of coordinates and of velocities.
    pub(super) inverse_weight: (&'a [f64], &'a [f64]),
    /// Predicted velocities.
    pub(super) predicted: &'a [f64],
    /// φ*_1 of the coordinates.
    pub(super) phi_1: &'a [f64],
    /// Newest difference of coordinates and of velocities; not used without `NEWEST`.
    pub(super) newest: (&'a mut [f64], &'a mut [f64]),
    pub(super) trial: (&'a mut [f64], &'a mut [f64]),
}

/// Weighted sums of squares.
#[derive(Debug, Clone, Copy)]
pub(super) struct Applied {
    /// Correction of the coordinates.
    pub(super) lengths: f64,
    /// Correction of the velocities.
    pub(super) speeds: f64,
    /// Newest difference, from which the error estimate follows.
    pub(super) distance: f64,
}

/// Sums of [`Apply`] as SIMD vectors.
struct ApplySums<S: Simd> {
    gamma: Lanes<S>,
    inverse: Lanes<S>,
    /// Of the correction of the coordinates over γ.
    lengths: Squares<S>,
    speeds: Squares<S>,
    distance: Squares<S>,
}

/// One vector of the operands of [`Apply`].
struct Operands<S: Simd> {
    change: Lanes<S>,
    weight_q: Lanes<S>,
    weight_v: Lanes<S>,
    predicted: Lanes<S>,
    phi_1: Lanes<S>,
    q: Lanes<S>,
    v: Lanes<S>,
}

impl<S: Simd> ApplySums<S> {
    /// Return corrected coordinates and velocities, and the newest difference of both; add their squares to the sums.
    #[inline(always)]
    fn correct<const FIRST: bool>(&mut self, part: usize, at: &Operands<S>) -> [[Lanes<S>; 2]; 2] {
        let v = at.v + at.change;
        self.lengths.add(part, at.change * at.weight_q);
        self.speeds.add(part, at.change * at.weight_v);
        // φ_{k+1} of velocities, (v - p_v)/γ, from the corrector's equation.
        let distance = if FIRST { at.change } else { v - at.predicted };
        let newest = [v - at.phi_1, distance * self.inverse];
        // Both differences go into one sum: the error norm is over coordinates and velocities.
        self.distance.add(part, newest[0] * at.weight_q);
        if !FIRST {
            self.distance.add(part, newest[1] * at.weight_v);
        }
        // q follows v with the factor γ.
        [[self.gamma.mul_add(at.change, at.q), v], newest]
    }
}

impl<const NEWEST: bool, const FIRST: bool> WithSimd for Apply<'_, NEWEST, FIRST> {
    type Output = Applied;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Applied {
        let n = self.correction.len();
        let correction = SliceLanes::<S>::new(simd, self.correction, n);
        let weight_q = SliceLanes::<S>::new(simd, self.inverse_weight.0, n);
        let weight_v = SliceLanes::<S>::new(simd, self.inverse_weight.1, n);
        let predicted = SliceLanes::<S>::new(simd, self.predicted, n);
        let phi_1 = SliceLanes::<S>::new(simd, self.phi_1, n);
        let mut q = SliceLanesMut::<S>::new(simd, self.trial.0, n);
        let mut v = SliceLanesMut::<S>::new(simd, self.trial.1, n);
        let written = if NEWEST { n } else { 0 };
        let mut newest_q = SliceLanesMut::<S>::new(simd, self.newest.0, written);
        let mut newest_v = SliceLanesMut::<S>::new(simd, self.newest.1, written);
        let mut sums = ApplySums {
            gamma: Lanes::splat(simd, self.gamma),
            inverse: Lanes::splat(simd, 1.0 / self.gamma),
            lengths: Squares::new(simd),
            speeds: Squares::new(simd),
            distance: Squares::new(simd),
        };
        each_vector!(S, n, |part, at| {
            let values = Operands {
                change: correction.get(at),
                weight_q: weight_q.get(at),
                weight_v: weight_v.get(at),
                predicted: predicted.get(at),
                phi_1: phi_1.get(at),
                q: q.get(at),
                v: v.get(at),
            };
            let [ends, newest] = sums.correct::<FIRST>(part, &values);
            q.set(at, ends[0]);
            v.set(at, ends[1]);
            if NEWEST {
                newest_q.set(at, newest[0]);
                newest_v.set(at, newest[1]);
            }
        });
        let speeds = sums.speeds.total();
        let gamma_squared = self.gamma * self.gamma;
        let of_velocities = if FIRST { speeds / gamma_squared } else { 0.0 };
        Applied {
            lengths: gamma_squared * sums.lengths.total(),
            speeds,
            distance: sums.distance.total() + of_velocities,
        }
    }
}

/// Write the derivative at a solution from the corrector's equation: `dq/dt = v`, `dv/dt = φ*_v + (v - p_v)/γ`.
pub(super) struct DerivativeAtSolution<'a> {
    pub(super) inverse_gamma: f64,
    pub(super) predicted: &'a [f64],
    pub(super) trial: &'a [f64],
    pub(super) phi_1: &'a [f64],
    pub(super) derivative: (&'a mut [f64], &'a mut [f64]),
}

impl WithSimd for DerivativeAtSolution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.trial.len();
        let inverse = Lanes::splat(simd, self.inverse_gamma);
        let predicted = SliceLanes::<S>::new(simd, self.predicted, n);
        let trial = SliceLanes::<S>::new(simd, self.trial, n);
        let phi_1 = SliceLanes::<S>::new(simd, self.phi_1, n);
        let mut rates = SliceLanesMut::<S>::new(simd, self.derivative.0, n);
        let mut accelerations = SliceLanesMut::<S>::new(simd, self.derivative.1, n);
        each_vector!(S, n, |at| {
            let speed = trial.get(at);
            rates.set(at, speed);
            let distance = speed - predicted.get(at);
            accelerations.set(at, inverse.mul_add(distance, phi_1.get(at)));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::simd::InstructionSet;

    /// Numbers: whole vectors of every width and a part of one.
    const N: usize = 11;
    const GAMMA: f64 = 0.3;

    /// Numbers of size one, another sequence for each `seed`.
    fn numbers(seed: f64, count: usize) -> Vec<f64> {
        (0..count).map(|i| (seed + 1.7 * i as f64).sin()).collect()
    }

    /// Check against values of size one, which differ by a few roundings of sums of some terms.
    fn near(found: &[f64], expected: impl Fn(usize) -> f64) {
        for (i, found) in found.iter().enumerate() {
            let expected = expected(i);
            assert!((found - expected).abs() < 1e-14, "{i}: {found} {expected}");
        }
    }

    fn sum_of(term: impl Fn(usize) -> f64) -> f64 {
        (0..N).map(|i| term(i).powi(2)).sum()
    }

    #[test]
    fn the_first_iterate_has_the_coordinates_of_the_predicted_velocities() {
        let [q, v, phi] = [1.0, 2.0, 3.0].map(|seed| numbers(seed, N));
        for set in InstructionSet::available() {
            let (mut trial_q, mut trial_v) = (vec![0.0; N], vec![0.0; N]);
            set.run(Begin {
                gamma: GAMMA,
                predicted: (&q, &v),
                phi_1: &phi,
                trial: (&mut trial_q, &mut trial_v),
            });
            near(&trial_q, |i| q[i] + GAMMA * (v[i] - phi[i]));
            assert_eq!(trial_v, v);
        }
    }

    #[test]
    fn one_pass_predicts_velocities_and_first_iterate_with_the_newest_difference() {
        let (width, step, beta, g) = (2 * N + 2, 0.7, 1.3, [0.9, 0.5]);
        let rows = [4.0, 5.0, 6.0].map(|seed| numbers(seed, width));
        let y = numbers(7.0, 2 * N);
        // φ with the newest difference, then φ* and p by the formulas of Shampine and Gordon.
        let stars = |order: usize, newest: usize, i: usize| {
            let mut phi = [rows[0][i], rows[1][i]];
            for phi in &mut phi[..newest] {
                *phi += rows[newest][i];
            }
            if order == 1 {
                return (phi[0], phi[1], y[i] + step * g[0] * phi[0]);
            }
            let second = beta * phi[1];
            let sum = g[0] * phi[0] + g[1] * second;
            (phi[0] + second, second, y[i] + step * sum)
        };
        for set in InstructionSet::available() {
            for (order, newest) in [(1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)] {
                let mut table = rows.concat();
                let (mut predicted, mut trial) = (vec![0.0; N], vec![0.0; 2 * N]);
                set.run(PredictForNewton {
                    order,
                    newest,
                    step,
                    gamma: GAMMA,
                    beta,
                    g,
                    table: &mut table,
                    width,
                    y: y.split_at(N),
                    predicted: &mut predicted,
                    trial: trial.split_at_mut(N),
                });
                let of = |i: usize| stars(order, newest, i);
                near(&table[..2 * N], |i| of(i).0);
                near(&table[width..width + 2 * N], |i| of(i).1);
                near(&predicted, |i| of(N + i).2);
                near(&trial[N..], |i| of(N + i).2);
                near(&trial[..N], |i| {
                    let (phi, _, place) = of(i);
                    place + GAMMA * (of(N + i).2 - phi)
                });
            }
        }
    }

    #[test]
    fn residuals_are_those_of_the_equation_of_the_corrector() {
        let [predicted, trial, derivative, phi, weight] =
            [1.0, 2.0, 3.0, 4.0, 5.0].map(|seed| numbers(seed, N));
        let first = |i: usize| GAMMA * (derivative[i] - phi[i]);
        for set in InstructionSet::available() {
            let mut residual = vec![0.0; N];
            let sum = set.run(FirstResidual {
                gamma: GAMMA,
                derivative: &derivative,
                phi_1: &phi,
                inverse_weight: &weight,
                residual: &mut residual,
            });
            near(&residual, first);
            assert!((sum - sum_of(|i| first(i) * weight[i])).abs() < 1e-14);
            set.run(Residual {
                gamma: GAMMA,
                predicted: &predicted,
                trial: &trial,
                derivative: &derivative,
                phi_1: &phi,
                written: &mut residual,
            });
            near(&residual, |i| predicted[i] - trial[i] + first(i));
        }
    }

    /// Apply a correction; return coordinates, velocities and newest difference, and the sums.
    fn applied<const NEWEST: bool, const FIRST: bool>(
        set: InstructionSet,
        [change, weight_q, weight_v, predicted, phi, q, v]: &[Vec<f64>; 7],
    ) -> ([Vec<f64>; 4], [f64; 3]) {
        let (mut trial_q, mut trial_v) = (q.clone(), v.clone());
        let length = if NEWEST { N } else { 0 };
        let (mut newest_q, mut newest_v) = (vec![0.0; length], vec![0.0; length]);
        let sums = set.run(Apply::<NEWEST, FIRST> {
            gamma: GAMMA,
            correction: change,
            inverse_weight: (weight_q, weight_v),
            predicted,
            phi_1: phi,
            newest: (&mut newest_q, &mut newest_v),
            trial: (&mut trial_q, &mut trial_v),
        });
        let sums = [sums.lengths, sums.speeds, sums.distance];
        ([trial_q, trial_v, newest_q, newest_v], sums)
    }

    #[test]
    fn a_correction_moves_the_coordinates_by_gamma_and_is_measured_in_weights() {
        let mut operands = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|seed| numbers(seed, N));
        for first in [false, true] {
            if first {
                // The first correction begins at the predicted velocities.
                operands[3] = operands[6].clone();
            }
            let [change, weight_q, weight_v, predicted, phi, q, v] = &operands;
            let end = |i: usize| v[i] + change[i];
            let acceleration = |i: usize| (end(i) - predicted[i]) / GAMMA;
            let lengths = sum_of(|i| GAMMA * change[i] * weight_q[i]);
            let speeds = sum_of(|i| change[i] * weight_v[i]);
            let distance = sum_of(|i| (end(i) - phi[i]) * weight_q[i])
                + sum_of(|i| acceleration(i) * weight_v[i]);
            for set in InstructionSet::available() {
                let (vectors, found) = if first {
                    applied::<true, true>(set, &operands)
                } else {
                    applied::<true, false>(set, &operands)
                };
                near(&vectors[0], |i| q[i] + GAMMA * change[i]);
                near(&vectors[1], end);
                near(&vectors[2], |i| end(i) - phi[i]);
                near(&vectors[3], acceleration);
                for (found, expected) in found.into_iter().zip([lengths, speeds, distance]) {
                    assert!((found / expected - 1.0).abs() < 1e-14);
                }
                let (without, sums) = if first {
                    applied::<false, true>(set, &operands)
                } else {
                    applied::<false, false>(set, &operands)
                };
                assert_eq!((&without[..2], sums), (&vectors[..2], found));
            }
        }
    }

    #[test]
    fn the_derivative_at_a_solution_follows_from_the_equation_of_the_corrector() {
        let [predicted, trial, phi] = [1.0, 2.0, 3.0].map(|seed| numbers(seed, N));
        for set in InstructionSet::available() {
            let (mut rates, mut accelerations) = (vec![0.0; N], vec![0.0; N]);
            set.run(DerivativeAtSolution {
                inverse_gamma: 1.0 / GAMMA,
                predicted: &predicted,
                trial: &trial,
                phi_1: &phi,
                derivative: (&mut rates, &mut accelerations),
            });
            assert_eq!(rates, trial);
            near(&accelerations, |i| {
                phi[i] + (trial[i] - predicted[i]) / GAMMA
            });
        }
    }
}
