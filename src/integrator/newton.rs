//! The implicit corrector: the Adams-Moulton formula of the predictor's own order, solved by Newton's method for velocities.
//!
//! `y = p + γ (f(y) - φ*)`, `γ = h g_k`, of which order 2 is the trapezoid. For a system of second order the coordinates follow
//! from the velocities, `q = p_q + γ (v - φ*_q)`, so that Newton's method solves for v alone:
//! `v - p_v - γ (a(q, v) - φ*_v) = 0`.

use super::adams::{Adams, Step, StepFailure};
use super::newton_table::{Apply, Begin, Residual, Slopes};
use super::order_control::{ErrorEstimate, choose_order, choose_step, gamma_star};
use super::stability::implicit_order;
use super::{Corrector, SecondOrderSystem};

/// Corrections a step may take before it is made smaller.
const MAX_ITERATIONS: u32 = 6;

/// What is left to correct, in units of the tolerance, when the iteration ends.
const REMAINDER: f64 = 0.1;

/// Share of the step that the error would allow which is taken: rejected steps cost a matrix each.
const SAFETY: f64 = 0.8;

/// Longest first step \[s\].
const FIRST_STEP: f64 = 1e-7;

/// No step is longer than so many times the one before.
const LARGEST_GROWTH: f64 = 2.0;

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
        self.weigh_by_scale(system, true);
        if self.starting {
            self.start(system);
            self.step_size = self.step_size.min(FIRST_STEP);
        }
        self.growing = false;
        let begin = self.time;
        let mut failures = 0;
        let estimate = loop {
            self.predict();
            if let Some(estimate) = self.solve_corrector(system) {
                let shrink = if !estimate.accepts() {
                    failures += 1;
                    let exponent = -1.0 / (self.order + 1) as f64;
                    (SAFETY * estimate.local.powf(exponent)).clamp(0.2, 0.9)
                } else if system.stands(self.step_size, self.allowed()) {
                    break estimate;
                } else {
                    0.5
                };
                self.shrink(shrink, failures, controlled)?;
            } else {
                failures += 1;
                self.shrink(0.25, failures, controlled)?;
            }
        };
        self.accept_newton();
        self.choose_implicit_order_and_step(&estimate);
        if self.control.corrector == Corrector::Auto {
            self.consider_explicit();
        }
        Ok(Step {
            start: begin,
            end: self.time,
            order: self.last_order,
        })
    }

    /// Orders above two only where the fastest rate allows them; sizes by the error at the order taken.
    fn choose_implicit_order_and_step(&mut self, estimate: &ErrorEstimate) {
        let (k, h) = (self.last_order, self.last_step_size);
        let stable = implicit_order(k, h * self.fastest.value());
        let max_order = stable.min(self.control.max_order);
        let error_at =
            |order: usize| h * gamma_star(order) * self.norm(self.differences.row(order));
        let (order, error) = if k > max_order {
            (max_order, error_at(max_order))
        } else if k < 2 || max_order <= 2 {
            ((k + 1).min(max_order), estimate.local)
        } else {
            let equal = k < self.coefficients.equal_steps;
            let choice = choose_order(k, max_order, estimate, equal, || error_at(k + 1));
            (choice.order, choice.error)
        };
        // The trapezoid is stable: nothing is gained below it.
        self.order = order.max(max_order.min(2));
        let next = if order <= 2 {
            let exponent = -1.0 / (order + 1) as f64;
            let grow = (SAFETY * error.max(1e-6).powf(exponent)).clamp(0.3, LARGEST_GROWTH);
            // A step that is kept lets coefficients be kept.
            let keep = (0.9..1.15).contains(&grow);
            if keep { h } else { h * grow }
        } else {
            choose_step(h, order, error)
        };
        let least = 4.0 * f64::EPSILON * self.time.abs();
        self.step_size = next.max(least).min(self.control.max_step);
    }

    /// Solves the corrector from the prediction; the error of the step, or `None` when the iteration does not end.
    fn solve_corrector(&mut self, system: &mut impl SecondOrderSystem) -> Option<ErrorEstimate> {
        let (nq, k, h) = (system.coordinates(), self.order, self.step_size);
        let gamma = h * self.coefficients.g[k - 1];
        let end = self.time + h;
        self.begin(nq, gamma);
        let mut last = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            let trial = &self.trial[..self.dimension];
            let slope = &mut self.slope[..self.dimension];
            if iteration == 0 {
                system.derivative_with_slopes(end, trial, slope);
            } else {
                system.derivative(end, trial, slope);
            }
            self.counts.evaluations += 1;
            if iteration == 0 {
                self.counts.jacobians += 1;
                if !system.factorise(trial, gamma) {
                    return None;
                }
            }
            let (size, stiffness) = self.correct(system, nq, gamma);
            if iteration == 0 {
                let rate = stiffness.sqrt().max(stiffness) / gamma;
                self.fastest.meet(rate);
            }
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

    /// One correction; its size in units of the tolerance, and how much larger it would be without the matrix, less one.
    fn correct(
        &mut self,
        system: &mut impl SecondOrderSystem,
        nq: usize,
        gamma: f64,
    ) -> (f64, f64) {
        let velocities = nq..2 * nq;
        let (weights_q, weights_v) = self.inverse_weight[..2 * nq].split_at(nq);
        let wrong = self.instructions.run(Residual {
            inverse_weight: weights_v,
            gamma,
            predicted: &self.predicted[velocities.clone()],
            trial: &self.trial[velocities.clone()],
            slope: &self.slope[velocities.clone()],
            first: &self.differences.row(0)[velocities],
            wrong: &mut self.residual[..nq],
        });
        system.correct(&mut self.residual[..nq]);
        let (q, v) = self.trial[..2 * nq].split_at_mut(nq);
        let [lengths, speeds] = self.instructions.run(Apply {
            gamma,
            correction: &self.residual[..nq],
            inverse_weight: (weights_q, weights_v),
            trial: (q, v),
        });
        let without = if speeds > 0.0 {
            (wrong / speeds).sqrt()
        } else {
            1.0
        };
        (self.norm_of(lengths + speeds), (without - 1.0).max(0.0))
    }

    /// The slopes that the solution stands for, the sums, and the error.
    fn finish_corrector(&mut self, nq: usize, gamma: f64) -> ErrorEstimate {
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
        self.estimate_error()
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
