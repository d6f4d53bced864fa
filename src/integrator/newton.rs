//! The implicit corrector: the Adams-Moulton formula of the predictor's own order, solved by Newton's method for velocities.
//!
//! `y = p + γ (f(y) - φ*)`, `γ = h g_k`, of which order 2 is the trapezoid. For a system of second order the coordinates follow
//! from the velocities, `q = p_q + γ (v - φ*_q)`, so that Newton's method solves for v alone:
//! `v - p_v - γ (a(q, v) - φ*_v) = 0`.

use super::adams::{Adams, Step, StepFailure};
use super::newton_kernels::{Applied, Apply, Begin, FirstResidual, Residual, Slopes};
use super::order_control::{ErrorEstimate, choose_order, choose_step, gamma_star};
use super::stability::implicit_order;
use super::{Corrector, SecondOrderSystem};

/// Corrections a step may take before it is made smaller.
const MAX_ITERATIONS: u32 = 6;

/// What is left to correct, in units of the tolerance, when the iteration ends.
const REMAINDER: f64 = 0.1;

/// The same where it is not measured but known from earlier steps: as a length \[m\], and where there is none to say. It is a
/// fixed length because remainders have a sign, and so feed or drain energy, while errors of the trapezoid hardly do: the looser
/// the tolerance, the more of the balance would be theirs.
const UNMEASURED_LENGTH: f64 = 6e-11;
const UNMEASURED: f64 = 0.01;

/// Slower convergence is always measured.
const SLOWEST_UNMEASURED: f64 = 0.3;

/// First correction \[m\], and accuracy, above which one that is in safety_factor is measured: its contacts may have begun or ended in what it
/// corrects.
const LONGEST_IN_DOUBT: f64 = 2e-10;

/// What was measured is taken to be so many times worse after each step that did not measure it.
const DISTRUST: f64 = 1.2;

/// Share of the step that the error would allow which is taken: rejected steps cost a matrix each.
const SAFETY: f64 = 0.8;

/// Error after the first correction, in units of the tolerance, from which on no other one will make the step acceptable.
const HOPELESS: f64 = 1.2;

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
        self.update_weights_by_scale(system, true);
        if self.starting {
            self.start(system);
            self.step_size = self.step_size.min(FIRST_STEP);
        }
        let begin = self.time;
        let mut failures = 0;
        let estimate = loop {
            self.predict_implicit(system.coordinates());
            self.begin_implicit_stage(system);
            let estimate = self.solve_corrector(system);
            system.begin_implicit_stage(None);
            if let Some(estimate) = estimate {
                let shrink = if !estimate.accepts() {
                    failures += 1;
                    let exponent = -1.0 / (self.order + 1) as f64;
                    (SAFETY * estimate.local.powf(exponent)).clamp(0.2, 0.9)
                } else if system.accepts_step(self.step_size, self.allowed()) {
                    break estimate;
                } else {
                    0.5
                };
                self.reject_newton_step(shrink, failures, system.coordinates())?;
            } else {
                failures += 1;
                self.reject_newton_step(0.25, failures, system.coordinates())?;
                if system.oscillates_at_order_two() {
                    // At order one all of that is gone after one step.
                    self.order = 1;
                }
            }
        };
        let above = self.accept_newton(system.coordinates());
        self.choose_implicit_order_and_step(&estimate, above);
        if self.control.corrector == Corrector::Auto {
            self.check_switch_to_explicit();
        }
        Ok(Step {
            start: begin,
            end: self.time,
            order: self.last_order,
        })
    }

    /// Orders above two only where the fastest rate allows them; sizes by the error at the order taken. `above`: norm of φ_{k+2}.
    fn choose_implicit_order_and_step(&mut self, estimate: &ErrorEstimate, above: f64) {
        let (k, h) = (self.last_order, self.last_step_size);
        let max_order = self.highest_order(k, h);
        self.growing &= k < max_order && !estimate.prefers_lower(k);
        if self.growing {
            // Steps at order two would leave their error in the energy of vibrations that later ones follow exactly.
            self.order = k + 1;
            self.step_size = (2.0 * h).min(self.control.max_step);
            return;
        }
        let scale = |order: usize| h * gamma_star(order);
        let (order, error) = if k > max_order {
            let error = scale(max_order) * self.norm_of_difference(max_order);
            (max_order, error)
        } else if k < 2 || max_order <= 2 {
            ((k + 1).min(max_order), estimate.local)
        } else {
            let one_above = || scale(k + 1) * above;
            let choice = choose_order(k, max_order, estimate, self.may_raise(), one_above);
            (choice.order, choice.error)
        };
        // The trapezoid is stable: nothing is gained below it.
        self.order = order.max(max_order.min(2));
        let next = if order <= 2 {
            let error = error.max(1e-6);
            let root = if order == 1 {
                error.sqrt()
            } else {
                error.cbrt()
            };
            let grow = (SAFETY / root).clamp(0.3, LARGEST_GROWTH);
            // A step that is kept lets coefficients be kept.
            let keep = (0.9..1.15).contains(&grow);
            if keep { h } else { h * grow }
        } else {
            choose_step(h, order, error)
        };
        let least = 4.0 * f64::EPSILON * self.time.abs();
        self.step_size = next.max(least).min(self.control.max_step);
    }

    /// Highest order after a step of size `h` at `order`.
    fn highest_order(&self, order: usize, h: f64) -> usize {
        implicit_order(order, h * self.fastest.value()).min(self.control.max_order)
    }

    /// Solves the corrector from the prediction; the error of the step, or `None` when the iteration does not end.
    fn solve_corrector(&mut self, system: &mut impl SecondOrderSystem) -> Option<ErrorEstimate> {
        let (nq, h) = (system.coordinates(), self.step_size);
        let gamma = self.gamma();
        let end = self.time + h;
        let mut last = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            let trial = &self.trial[..self.dimension];
            let slope = &mut self.slope[..self.dimension];
            if iteration == 0 {
                system.accelerations_with_slopes(end, trial, slope);
            } else {
                system.accelerations(end, trial, slope);
            }
            self.counts.evaluations += 1;
            self.take_solved(system);
            if iteration == 0 {
                self.counts.jacobians += 1;
                if !system.factorise(&self.trial[..self.dimension], gamma) {
                    return None;
                }
            }
            let residual = self.find_residual(nq, gamma, iteration == 0);
            system.correct(&mut self.residual[..nq]);
            let applied = self.apply_correction(nq, gamma);
            if iteration == 0 {
                self.record_rate(residual, applied.speeds, gamma);
            }
            let size = self.norm_of(applied.lengths + applied.speeds);
            if !size.is_finite() {
                return None;
            }
            let rate = size / last;
            let left = if iteration == 0 {
                let estimate = self.estimate_from([applied.error, 0.0, 0.0]);
                if estimate.local > HOPELESS {
                    return Some(estimate);
                }
                if self.may_skip_second_correction(size, system.contraction_safety_factor()) {
                    return Some(self.finish_corrector(nq, gamma, applied.error));
                }
                size
            } else {
                self.contraction = size / (last * last);
                size * rate / (1.0 - rate).max(0.1)
            };
            if left <= REMAINDER {
                return Some(self.finish_corrector(nq, gamma, applied.error));
            }
            if iteration > 1 && rate > 0.9 {
                return None;
            }
            last = size;
        }
        None
    }

    /// Hands over what is foretold of the velocities that the system solves for by itself, `p_v - γ φ*_v`.
    fn begin_implicit_stage(&mut self, system: &mut impl SecondOrderSystem) {
        let (nq, own) = (system.coordinates(), system.local_unknowns());
        if own.is_empty() {
            return;
        }
        let gamma = self.gamma();
        let own = nq + own.start..nq + own.end;
        let first = &self.differences.row(0)[own.clone()];
        let foretold = &mut self.residual[..own.len()];
        for ((foretold, predicted), phi) in foretold.iter_mut().zip(&self.predicted[own]).zip(first)
        {
            *foretold = predicted - gamma * phi;
        }
        system.begin_implicit_stage(Some((foretold, gamma)));
    }

    /// Takes what the last evaluation solved for; nothing is then wrong with it.
    fn take_solved(&mut self, system: &impl SecondOrderSystem) {
        let (nq, own) = (system.coordinates(), system.local_unknowns());
        if own.is_empty() {
            return;
        }
        let own = nq + own.start..nq + own.end;
        system.write_local_solution(&mut self.trial[own.clone()]);
        self.slope[own.clone()].copy_from_slice(&self.differences.row(0)[own]);
    }

    /// Whether the first correction, of `size`, is the last one by what earlier steps showed of the second: it is `contraction` times the
    /// square of the first, and `safety_factor` times that in this step.
    fn may_skip_second_correction(&mut self, size: f64, safety_factor: f64) -> bool {
        if safety_factor.is_infinite() {
            self.contraction = f64::INFINITY;
        }
        let allowed = if self.control.is_by_component() {
            UNMEASURED
        } else {
            (UNMEASURED_LENGTH / self.control.accuracy).min(REMAINDER)
        };
        let longest = size.max(1.0) * self.control.accuracy;
        let is_short = !self.control.is_by_component() && longest <= LONGEST_IN_DOUBT;
        let rate = safety_factor * self.contraction * size;
        let ends = rate < SLOWEST_UNMEASURED
            && rate * size <= allowed
            && (safety_factor <= 1.0 || is_short);
        if ends {
            self.contraction *= DISTRUST;
        }
        self.convergence_unmeasured = ends;
        ends
    }

    /// γ of the present step.
    fn gamma(&self) -> f64 {
        self.step_size * self.coefficients.g[self.order - 1]
    }

    /// The prediction and, with its velocities, where the iteration begins.
    fn predict_implicit(&mut self, nq: usize) {
        if self.differences.can_predict_for_newton(self.order) && self.dimension == 2 * nq {
            self.update_coefficients();
            let parameters = (self.order, self.step_size, self.gamma());
            self.differences.predict_for_newton(
                self.instructions,
                &self.coefficients,
                parameters,
                self.y[..2 * nq].split_at(nq),
                &mut self.predicted[nq..2 * nq],
                self.trial[..2 * nq].split_at_mut(nq),
            );
            return;
        }
        self.predict();
        let gamma = self.gamma();
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

    /// Whether nothing is asked of the step but its error and its newest differences.
    fn is_plain(&self, nq: usize) -> bool {
        let k = self.order;
        let alone = k < 2 || (k == 2 && self.highest_order(k, self.step_size) <= 2);
        alone && self.dimension == 2 * nq
    }

    /// What is wrong with the velocities; the sum of its squares over their weights at the prediction.
    fn find_residual(&mut self, nq: usize, gamma: f64, at_prediction: bool) -> f64 {
        let velocities = nq..2 * nq;
        let slope = &self.slope[velocities.clone()];
        let first = &self.differences.row(0)[velocities.clone()];
        let residual = &mut self.residual[..nq];
        if at_prediction {
            return self.instructions.run(FirstResidual {
                gamma,
                slope,
                first,
                inverse_weight: &self.inverse_weight[velocities],
                residual,
            });
        }
        self.instructions.run(Residual {
            gamma,
            predicted: &self.predicted[velocities.clone()],
            trial: &self.trial[velocities],
            slope,
            first,
            residual,
        });
        0.0
    }

    fn apply_correction(&mut self, nq: usize, gamma: f64) -> Applied {
        let (weights_q, weights_v) = self.inverse_weight[..2 * nq].split_at(nq);
        let (q, v) = self.trial[..2 * nq].split_at_mut(nq);
        self.instructions.run(Apply {
            gamma,
            correction: &self.residual[..nq],
            inverse_weight: (weights_q, weights_v),
            predicted: &self.predicted[nq..2 * nq],
            first: &self.differences.row(0)[..nq],
            trial: (q, v),
        })
    }

    /// Takes in how much larger the first correction would be without the matrix, from sums of squares of both.
    fn record_rate(&mut self, residual: f64, corrected: f64, gamma: f64) {
        if corrected > 0.0 {
            let stiffness = ((residual / corrected).sqrt() - 1.0).max(0.0);
            self.fastest.record(stiffness.sqrt().max(stiffness) / gamma);
        } else {
            self.fastest.record(0.0);
        }
    }

    /// The slopes that the solution stands for, the sums, and the error; `error`: sum of squares of how far the slopes are from
    /// those foretold.
    fn finish_corrector(&mut self, nq: usize, gamma: f64, error: f64) -> ErrorEstimate {
        if self.is_plain(nq) {
            return self.estimate_from([error, 0.0, 0.0]);
        }
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

    /// Takes the solution; the norm of φ_{k+2}, where the order may be raised.
    fn accept_newton(&mut self, nq: usize) -> f64 {
        let (k, h) = (self.order, self.step_size);
        let mut above = 0.0;
        if self.is_plain(nq) {
            let velocities = nq..2 * nq;
            let inverse_gamma = 1.0 / self.gamma();
            let ends = [&self.predicted[velocities.clone()], &self.trial[velocities]];
            self.differences
                .append_newton_difference(self.instructions, k, inverse_gamma, ends);
        } else {
            let raises = k < self.coefficients.equal_steps && self.highest_order(k, h) > k;
            above = self.differences.update(
                self.instructions,
                k,
                &self.slope,
                &self.inverse_weight,
                raises,
            );
        }
        std::mem::swap(&mut self.y, &mut self.trial);
        (self.last_order, self.last_step_size) = (k, h);
        self.time += h;
        self.counts.steps += 1;
        self.norm_of(above)
    }

    /// Takes a step back and makes it smaller.
    fn reject_newton_step(
        &mut self,
        factor: f64,
        failures: u32,
        nq: usize,
    ) -> Result<(), StepFailure> {
        self.counts.rejected += 1;
        self.growing = false;
        // Evaluations left them out; should the step be the last one, its worst component is named.
        self.slope[..nq].copy_from_slice(&self.trial[nq..2 * nq]);
        let next = factor * self.step_size;
        self.check_size(next, 2 * nq)?;
        self.undo_prediction();
        if failures >= 3 {
            self.order = 1;
        }
        self.step_size = next;
        Ok(())
    }
}
