//! The implicit corrector: the Adams-Moulton formula of the predictor's own order, solved by Newton's method for velocities.
//!
//! `y = p + γ (f(y) - φ*)`, `γ = h g_k`; order 2 is the trapezoidal rule, damped by a larger γ where velocities alternate. For a second-order system the coordinates follow
//! from the velocities, `q = p_q + γ (v - φ*_q)`. Newton's method then solves for v alone:
//! `v - p_v - γ (a(q, v) - φ*_v) = 0`, with the matrix `1 - γ ∂a/∂v - γ² ∂a/∂q` (Hairer and Wanner, *Solving Ordinary Differential
//! Equations II*, section IV.8, for Runge-Kutta methods).

use super::adams::Adams;
use super::explicit::FAILURES_TO_ORDER_ONE;
use super::order_control::{ErrorEstimate, choose_order, choose_step, gamma_star};
use super::stability::implicit_order;
use super::step::{Step, StepFailure};
use super::{Corrector, SecondOrderSystem};

/// Share of the step size permitted by the error that the next step takes.
///
/// A rejected step costs a matrix. 0.7 and 0.9 cost the same within a few percent (decision 20).
const SAFETY: f64 = 0.8;

/// Longest first step \[s\].
///
/// The first step has order one, whose error the energy balance shows.
const FIRST_STEP: f64 = 1e-7;

/// Factor of the step size after an iteration that did not converge.
///
/// Chosen by trial; effects of other values: docs/development/constants.md.
const NOT_CONVERGED: f64 = 0.25;

/// Factor of the step size after an event that both ends of the step do not show: the factor of the explicit corrector.
const HIDDEN_EVENT: f64 = 0.5;

/// Smallest and largest factor of the step size after a failed error test.
///
/// Chosen by trial; effects of other values: docs/development/constants.md.
const REDUCTION_AFTER_ERROR: [f64; 2] = [0.2, 0.9];

/// Smallest and largest factor of the step size after an accepted step of order one or two.
///
/// Chosen by trial; effects of other values: docs/development/constants.md.
const LOW_ORDER_CHANGE: [f64; 2] = [0.3, 2.0];

/// Largest factor of the step size at order one or two in [`STEPS_OF_SLOW_GROWTH`] after a rejected step.
///
/// Larger growth rejects more steps where contacts have kinks (docs/performance/practical.md).
const SLOW_GROWTH: f64 = 1.25;

/// Accepted steps after a rejected one, behind [`STEPS_UNTIL_GROWTH`], in which the step size grows slowly.
///
/// Without a limit of their number, the first steps after each restart would grow slowly, too.
const STEPS_OF_SLOW_GROWTH: u32 = 60;

/// Factors of the step size between which it is kept: equal steps keep their coefficients.
///
/// Chosen by trial; effects of other values: docs/development/constants.md.
const KEPT: [f64; 2] = [0.9, 1.15];

/// Accepted steps after a rejected one before the step size may grow again.
///
/// The trapezoidal rule does not damp an overdamped contact: its error is small in every other step. A step that grew there was rejected
/// next: 29 % of all steps of a motorcycle drive at 1e-9 m, 6 % with four steps. Twelve steps were too careful with Coulomb's friction,
/// whose kinks are not alike (both before [`SLOW_GROWTH`]).
const STEPS_UNTIL_GROWTH: u32 = 4;

/// Order above which steps have to be stable for the fastest rate; orders one and two are A-stable.
const A_STABLE: usize = 2;

impl Adams {
    /// Make one step with the implicit corrector.
    ///
    /// # Errors
    /// When the step size or the tolerances are below rounding.
    pub fn step_newton(
        &mut self,
        system: &mut impl SecondOrderSystem,
    ) -> Result<Step, StepFailure> {
        let state = (&self.vectors.y[..], self.starting);
        (self.norm).update_by_scale(self.instructions, &self.control, system, true, state);
        self.check_tolerances(system.controlled())?;
        if self.starting {
            // The explicit rule for the first step does not include the stiffness.
            self.start(system);
            self.next.size = self.next.size.min(FIRST_STEP);
        }
        self.watch_alternation(system.coordinates());
        let begin = self.time;
        let (estimate, newest_only) = self.repeat_until_accepted(system)?;
        let above = self.accept_newton(newest_only);
        self.choose_implicit_order_and_step(&estimate, above);
        if self.control.corrector == Corrector::Auto {
            self.check_switch_to_explicit();
        }
        Ok(Step {
            start: begin,
            end: self.time,
            degree: self.history.last_order - 1,
        })
    }

    /// Choose the damping of the next step by the alternations of the last steps.
    fn watch_alternation(&mut self, nq: usize) {
        let velocities = nq..2 * nq;
        match self.history.differences.rows_of_last_step() {
            (_, Some(phi_2), newest) if self.history.last_order == A_STABLE => {
                self.alternation.watch(
                    self.instructions,
                    self.history.last_step_size,
                    (&phi_2[velocities.clone()], &newest[velocities.clone()]),
                    &self.norm.inverse_weight[velocities],
                );
            }
            _ => self.alternation.forget(),
        }
        self.next.damping = self.alternation.damping_of_next_step();
    }

    /// Solve the corrector with smaller and smaller steps until the iteration converges and the error test accepts the step. Return the
    /// error, and whether the corrections have written the newest difference.
    fn repeat_until_accepted(
        &mut self,
        system: &mut impl SecondOrderSystem,
    ) -> Result<(ErrorEstimate, bool), StepFailure> {
        let nq = system.coordinates();
        let mut failures = 0;
        loop {
            // One attempt: predicted value, local unknowns, Newton's method, error test, events.
            self.predict_implicit(nq);
            self.begin_implicit_stage(system);
            let newest_only = self.needs_newest_difference_only(nq);
            let estimate = self.solve_corrector(system, newest_only);
            system.begin_implicit_stage(None);
            let Some(estimate) = estimate else {
                // No convergence tells nothing about the error: a fixed factor.
                failures += 1;
                // The differences are rebuilt at the smaller size, at the same order.
                self.reject_newton_step(NOT_CONVERGED, failures, nq)?;
                continue;
            };
            let shrink = if !estimate.accepts() {
                failures += 1;
                // The error is about h^(k+1).
                let exponent = -1.0 / (self.next.order + 1) as f64;
                let [smallest, largest] = REDUCTION_AFTER_ERROR;
                let factor = SAFETY * estimate.local.powf(exponent);
                // An error that is not a number may be one at a smaller step size.
                if factor.is_nan() {
                    smallest
                } else {
                    factor.clamp(smallest, largest)
                }
            } else if system.accepts_step(self.next.size, self.allowed()) {
                return Ok((estimate, newest_only));
            } else {
                // An event inside: the error is within the tolerance, the step too long for the contact.
                HIDDEN_EVENT
            };
            self.reject_newton_step(shrink, failures, nq)?;
        }
    }

    /// Choose the next order and step size; `above` is |φ_{k+2}|, `None` after a step that needed the newest difference only.
    ///
    /// Orders above two are permitted only where the fastest rate is inside their stability region.
    fn choose_implicit_order_and_step(&mut self, estimate: &ErrorEstimate, above: Option<f64>) {
        let (k, h) = (self.history.last_order, self.history.last_step_size);
        // What a rise to order three needs is known one step later.
        let max_order = match above {
            Some(_) => self.highest_order(k, h),
            None => self.highest_order(k, h).min(A_STABLE),
        };
        // Order two at the start would leave its error in the energy of vibrations that later steps resolve.
        if (self.next).grow(estimate, (k, h), max_order, &self.control) {
            return;
        }
        let scale = |order: usize| h * gamma_star(order);
        // Order one has no advantage over the trapezoidal rule, which is A-stable, too.
        let lowest = max_order.min(A_STABLE);
        // The rate has grown: the order falls at once to the stable one, with its own error estimate.
        let (order, error) = if k > max_order {
            let norm = (self.history).norm_of_difference(self.instructions, &self.norm, max_order);
            (max_order, scale(max_order) * norm)
        } else if let Some(above) = above.filter(|_| k >= A_STABLE && max_order > A_STABLE) {
            // Inside the stability region the choice is that of the explicit corrector.
            let one_above = || scale(k + 1) * above;
            let raise = self.history.may_raise(k, self.control.max_order);
            let choice = choose_order(k, max_order, estimate, raise, one_above);
            (choice.order, choice.error)
        } else {
            // Up to the trapezoidal rule the order rises without an estimate one order up.
            (lowest, estimate.local)
        };
        // The step size follows from the error of the order that is taken.
        let (order, error) = if order < lowest {
            (lowest, estimate.local)
        } else {
            (order, error)
        };
        self.next.order = order;
        // Low orders follow the error; high orders keep equal steps for their coefficients.
        let size = if order <= A_STABLE {
            let most = match self.next.steps_of_limited_growth {
                0 => LOW_ORDER_CHANGE[1],
                1..=STEPS_OF_SLOW_GROWTH => SLOW_GROWTH,
                _ => 1.0,
            };
            self.next.steps_of_limited_growth = self.next.steps_of_limited_growth.saturating_sub(1);
            low_order_step(h, order, error).min(most * h)
        } else {
            choose_step(h, order, error)
        };
        self.next.set_size(size, &self.control, self.time);
    }

    /// Return the highest permitted order after a step of size `h` at `order`.
    fn highest_order(&self, order: usize, h: f64) -> usize {
        implicit_order(order, h * self.fastest.value()).min(self.control.max_order)
    }

    /// Return whether error and newest difference are enough: order one, or order two where no higher order is permitted, without sums.
    pub(super) fn needs_newest_difference_only(&self, nq: usize) -> bool {
        let k = self.next.order;
        let alone =
            k < A_STABLE || (k == A_STABLE && self.highest_order(k, self.next.size) <= A_STABLE);
        alone && self.vectors.dimension == 2 * nq
    }

    /// Accept the solution; return |φ_{k+2}|, zero where the order may not be raised, and `None` where `newest_only` is written.
    fn accept_newton(&mut self, newest_only: bool) -> Option<f64> {
        let (k, h) = (self.next.order, self.next.size);
        // φ_{k+2} is a second pass over the table: only where it may decide.
        let raise = !newest_only && self.history.may_raise(k, self.highest_order(k, h));
        let (history, vectors) = (&mut self.history, &mut self.vectors);
        history.differences.forget_rounding();
        let above = if newest_only {
            history.update_by_newest_difference((k, h));
            None
        } else {
            Some(history.update(self.instructions, (k, h), &self.norm, vectors, raise))
        };
        // No last evaluation: the derivative follows from the corrector's equation.
        std::mem::swap(&mut vectors.y, &mut vectors.trial);
        self.time += h;
        self.counts.steps += 1;
        above
    }

    /// Undo a rejected step and reduce its size by `factor`.
    fn reject_newton_step(
        &mut self,
        factor: f64,
        failures: u32,
        nq: usize,
    ) -> Result<(), StepFailure> {
        self.counts.rejected += 1;
        self.next.growing = false;
        self.next.steps_of_limited_growth = STEPS_UNTIL_GROWTH + STEPS_OF_SLOW_GROWTH;
        // Evaluations leave the rates of the coordinates out; a failure names its worst component from them.
        let vectors = &mut self.vectors;
        vectors.derivative[..nq].copy_from_slice(&vectors.trial[nq..2 * nq]);
        if let Err(failure) = self.undo_step(factor * self.next.size, 2 * nq) {
            // The attempts have written differences that may be no numbers, and dense output reads them.
            if self.next.order <= A_STABLE && self.vectors.dimension == 2 * nq {
                self.history.clear_from(self.next.order);
            }
            return Err(failure);
        }
        if failures >= FAILURES_TO_ORDER_ONE {
            self.next.order = 1;
        }
        Ok(())
    }
}

/// Return the next step size at order one or two, from the error: `h SAFETY / error^(1/(k+1))`, or h where the change is small.
fn low_order_step(h: f64, order: usize, error: f64) -> f64 {
    // Powers in place of roots decide whether the size is kept: cube roots are slow, and most steps keep it.
    let power = |root: f64| root * root * if order == 1 { 1.0 } else { root };
    let [largest, smallest] = KEPT.map(|change| power(SAFETY / change));
    if smallest < error && error <= largest {
        return h;
    }
    let root = if order == 1 {
        error.sqrt()
    } else {
        error.cbrt()
    };
    // An error of zero gives the largest change.
    h * (SAFETY / root).clamp(LOW_ORDER_CHANGE[0], LOW_ORDER_CHANGE[1])
}

#[cfg(test)]
mod tests;
