//! The implicit corrector: the Adams-Moulton formula of the predictor's own order, solved by Newton's method for velocities.
//!
//! `y = p + γ (f(y) - φ*)`, `γ = h g_k`, of which order 2 is the trapezoid. For a system of second order the coordinates follow
//! from the velocities, `q = p_q + γ (v - φ*_q)`, so that Newton's method solves for v alone:
//! `v - p_v - γ (a(q, v) - φ*_v) = 0`.

use super::SecondOrderSystem;
use super::adams::{Adams, Step, StepFailure};
use super::newton_table::{Apply, Begin, Residual, Slopes};
use super::table::Errors;

/// Corrections a step may take before it is made smaller.
const MAX_ITERATIONS: u32 = 6;

/// What is left to correct, in units of the tolerance, when the iteration ends.
const REMAINDER: f64 = 0.1;

/// Share of the step that the error would allow which is taken: rejected steps cost a matrix each.
const SAFETY: f64 = 0.8;

/// No step is longer than so many times the one before.
const LARGEST_GROWTH: f64 = 2.0;

/// Speed that is allowed for each length that is, in 1/s: an error of a nanometre goes with one of 0.1 mm/s.
const SPEED_PER_LENGTH: f64 = 1e5;

impl Adams {
    /// Makes one step with the implicit corrector.
    ///
    /// # Errors
    /// When the step size falls to rounding.
    pub fn step_newton(
        &mut self,
        system: &mut impl SecondOrderSystem,
    ) -> Result<Step, StepFailure> {
        let controlled = system.controlled();
        if self.starting {
            self.weigh_by_scale(system);
            self.start(system);
            self.step_size = self.step_size.min(1e-7);
        }
        let begin = self.time;
        let mut failures = 0;
        let error = loop {
            self.predict();
            if let Some(error) = self.solve_corrector(system) {
                if error <= 1.0 {
                    break error;
                }
                failures += 1;
                let shrink = (SAFETY * error.powf(-1.0 / (self.order + 1) as f64)).clamp(0.2, 0.9);
                self.shrink(shrink, failures, controlled)?;
            } else {
                failures += 1;
                self.shrink(0.25, failures, controlled)?;
            }
        };
        self.accept_newton();
        let order = self.last_order;
        let grow =
            (SAFETY * error.max(1e-6).powf(-1.0 / (order + 1) as f64)).clamp(0.3, LARGEST_GROWTH);
        self.order = (order + 1).min(2).min(self.control.max_order);
        // A step that is kept lets coefficients be kept.
        if !(0.9..1.15).contains(&grow) {
            self.step_size *= grow;
        }
        self.step_size = self
            .step_size
            .max(4.0 * f64::EPSILON * self.time.abs())
            .min(self.control.max_step);
        Ok(Step {
            start: begin,
            end: self.time,
            order,
        })
    }

    /// One over the error that is allowed for each component: `accuracy` in lengths, a hundred thousand times that a second in
    /// speeds, angles through their arms.
    fn weigh_by_scale(&mut self, system: &impl SecondOrderSystem) {
        let nq = system.coordinates();
        let (lengths, rest) = self.inverse_weight.split_at_mut(nq);
        system.scale(lengths);
        for length in lengths.iter_mut() {
            *length /= self.control.accuracy;
        }
        let (speeds, sums) = rest.split_at_mut(nq);
        for (speed, length) in speeds.iter_mut().zip(lengths) {
            *speed = *length / SPEED_PER_LENGTH;
        }
        sums.fill(0.0);
    }

    /// Root mean square over coordinates and velocities, in units of the tolerance.
    fn mean(sum: f64, coordinates: usize) -> f64 {
        (sum / (2 * coordinates) as f64).sqrt()
    }

    /// Solves the corrector from the prediction; the error of the step, or `None` when the iteration does not end.
    fn solve_corrector(&mut self, system: &mut impl SecondOrderSystem) -> Option<f64> {
        let (nq, k, h) = (system.coordinates(), self.order, self.step_size);
        let gamma = h * self.coefficients.g[k - 1];
        let end = self.time + h;
        self.begin(nq, gamma);
        let mut last = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            let trial = &self.trial[..self.dimension];
            system.derivative(end, trial, &mut self.slope[..self.dimension]);
            self.counts.evaluations += 1;
            if iteration == 0 {
                self.counts.jacobians += 1;
                if !system.factorise(trial, gamma) {
                    return None;
                }
            }
            let size = self.correct(system, nq, gamma);
            if !size.is_finite() {
                return None;
            }
            let rate = size / last;
            let left = if iteration == 0 {
                size
            } else {
                size * rate / (1.0 - rate).max(0.1)
            };
            if left <= REMAINDER {
                return Some(self.finish_corrector(nq, gamma));
            }
            if iteration > 1 && rate > 0.9 {
                return None;
            }
            last = size;
        }
        None
    }

    fn begin(&mut self, nq: usize, gamma: f64) {
        let (q, v) = self.predicted[..2 * nq].split_at(nq);
        self.trial[2 * nq..].copy_from_slice(&self.predicted[2 * nq..]);
        let (trial_q, trial_v) = self.trial[..2 * nq].split_at_mut(nq);
        self.instructions.run(Begin {
            gamma,
            predicted: (q, v),
            first: &self.differences.row(0)[..nq],
            trial: (trial_q, trial_v),
        });
    }

    /// One correction; its size in units of the tolerance.
    fn correct(&mut self, system: &mut impl SecondOrderSystem, nq: usize, gamma: f64) -> f64 {
        let velocities = nq..2 * nq;
        self.instructions.run(Residual {
            gamma,
            predicted: &self.predicted[velocities.clone()],
            trial: &self.trial[velocities.clone()],
            slope: &self.slope[velocities.clone()],
            first: &self.differences.row(0)[velocities],
            wrong: &mut self.residual[..nq],
        });
        system.correct(&mut self.residual[..nq]);
        let (q, v) = self.trial[..2 * nq].split_at_mut(nq);
        let sum = self.instructions.run(Apply {
            gamma,
            correction: &self.residual[..nq],
            inverse_weight: &self.inverse_weight[..nq],
            trial: (q, v),
        });
        // A speed weighs as much as the length it makes in the time that goes with it.
        Self::mean(sum * (gamma * gamma + SPEED_PER_LENGTH.powi(-2)), nq)
    }

    /// The slopes that the solution stands for, the sums, and the error.
    fn finish_corrector(&mut self, nq: usize, gamma: f64) -> f64 {
        let (k, h) = (self.order, self.step_size);
        let velocities = nq..2 * nq;
        let (rates, accelerations) = self.slope[..2 * nq].split_at_mut(nq);
        self.instructions.run(Slopes {
            inverse_gamma: 1.0 / gamma,
            predicted: &self.predicted[velocities.clone()],
            trial: &self.trial[velocities.clone()],
            first: &self.differences.row(0)[velocities],
            slope: (rates, accelerations),
        });
        // Sums feed nothing back: the formula of one order more is as stable and closes balances better.
        let weight = h * self.coefficients.g[k];
        let phi = self.differences.row(0);
        let sums = 2 * nq..self.dimension;
        let foretold = self.predicted[sums.clone()].iter().zip(&phi[sums.clone()]);
        let slopes = self.slope[sums.clone()].iter().zip(foretold);
        for (sum, (slope, (predicted, phi))) in self.trial[sums].iter_mut().zip(slopes) {
            *sum = predicted + weight * (slope - phi);
        }
        let [at, ..] = self.instructions.run(Errors {
            slope: &self.slope,
            first: phi,
            one_below: self.differences.row(k - 1),
            two_below: self.differences.row(k.saturating_sub(2)),
            inverse_weight: &self.inverse_weight,
        });
        h * (self.coefficients.g[k - 1] - self.coefficients.g[k]).abs() * Self::mean(at, nq)
    }

    fn accept_newton(&mut self) {
        self.last_order = self.order;
        self.last_step_size = self.step_size;
        self.time += self.step_size;
        std::mem::swap(&mut self.y, &mut self.trial);
        self.differences
            .update(self.instructions, self.order, &self.slope);
        self.counts.steps += 1;
    }

    /// Takes a step back and makes it smaller.
    fn shrink(&mut self, factor: f64, failures: u32, controlled: usize) -> Result<(), StepFailure> {
        self.counts.rejected += 1;
        let failed = self.step_size;
        let component = self.worst_component(controlled);
        self.differences
            .retreat(self.instructions, &self.coefficients, self.order);
        self.coefficients.retreat(self.order, failed);
        if failures >= 3 {
            self.order = 1;
        }
        let finite = self.slope.iter().all(|slope| slope.is_finite());
        self.try_smaller(factor * failed, component, finite)
    }
}
