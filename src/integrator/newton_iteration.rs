//! Newton's iteration of the implicit corrector within one step.

use super::SecondOrderSystem;
use super::adams::Adams;
use super::convergence::REMAINDER;
use super::newton_kernels::{Applied, Apply, Begin, DerivativeAtSolution, FirstResidual, Residual};
use super::order_control::ErrorEstimate;

/// Corrections of one step before it is rejected.
///
/// A safeguard: [`SLOWEST_RATE`] ends iterations that do not converge. Doubled: see docs/development/constants.md.
const MAX_ITERATIONS: u32 = 6;

/// Convergence rate from which on an iteration of more than two corrections is given up.
///
/// A safeguard: at this rate the remaining correction is ten times the last one. Doubled: no iteration is given up before
/// [`MAX_ITERATIONS`].
const SLOWEST_RATE: f64 = 0.9;

/// Error after the first correction, in units of the tolerance, from which on the step is rejected without a second one.
///
/// A second correction changes the error little. 1.2 saves 2 to 4 % of the time of 2 on the published drive (decision 20).
const HOPELESS: f64 = 1.2;

impl Adams {
    /// Compute the predicted value and, with its velocities, the first iterate.
    pub(super) fn predict_implicit(&mut self, nq: usize) {
        let (set, next, history) = (self.instructions, &self.next, &mut self.history);
        // Orders one and two without sums: one pass for table, velocities and iterate.
        let low_order = history.differences.can_predict_for_newton(next.order);
        if low_order && self.vectors.dimension == 2 * nq {
            history.update_coefficients(next);
            let parameters = (next.order, next.size, history.gamma(next));
            history.differences.predict_for_newton(
                set,
                &history.coefficients,
                parameters,
                self.vectors.y[..2 * nq].split_at(nq),
                &mut self.vectors.predicted[nq..2 * nq],
                self.vectors.trial[..2 * nq].split_at_mut(nq),
            );
            return;
        }
        history.predict(set, next, &mut self.vectors);
        let gamma = history.gamma(next);
        let predicted = &self.vectors.predicted;
        // The iteration begins at v = p_v and the coordinates that belong to it; sums at their predicted value.
        let (q, v) = predicted[..2 * nq].split_at(nq);
        self.vectors.trial[2 * nq..].copy_from_slice(&predicted[2 * nq..]);
        set.run(Begin {
            gamma,
            predicted: (q, v),
            phi_1: &history.differences.row(0)[..nq],
            trial: self.vectors.trial[..2 * nq].split_at_mut(nq),
        });
    }

    /// Solve the corrector from the predicted value; return the error of the step, or `None` without convergence.
    ///
    /// The matrix is made once, at the predicted value (simplified Newton iteration). `newest_only`: the table of differences needs the newest
    /// one only, which the corrections write.
    pub(super) fn solve_corrector(
        &mut self,
        system: &mut impl SecondOrderSystem,
        newest_only: bool,
    ) -> Option<ErrorEstimate> {
        let nq = system.coordinates();
        let gamma = self.history.gamma(&self.next);
        self.convergence.gamma = gamma;
        // Norm of the correction before; infinite, so that the first convergence rate is zero.
        let mut last = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            let first = iteration == 0;
            // Residual r = p_v - v + γ (a - φ*_v) at the iterate; at the first one v = p_v.
            self.evaluate_iterate(system, gamma, first)?;
            let residual = self.find_residual(nq, gamma, first);
            // Δ = (1 - γ ∂a/∂v - γ² ∂a/∂q)⁻¹ r, with the factors of the first iterate.
            system.correct(&mut self.vectors.residual[..nq]);
            system.correct_sum_rates(&mut self.vectors.derivative[2 * nq..self.vectors.dimension]);
            // Local unknowns have left the predicted value already.
            let at_prediction = first && system.local_unknowns().is_empty();
            let applied = self.apply_correction(nq, gamma, (newest_only, at_prediction));
            if first {
                // The ratio |r|/|Δ| measures the stiffness; later residuals are too small for that.
                let residual = (system.stiffness_residual()).map_or(residual, |free| {
                    self.norm.squares_from(self.instructions, nq, free)
                });
                self.fastest
                    .record_correction(residual, applied.speeds, gamma);
            }
            // Norm of the correction over coordinates and velocities, as in the error test.
            let size = self.norm.of_sum(applied.lengths + applied.speeds);
            if !size.is_finite() {
                return None;
            }
            let squares = [applied.distance, 0.0, 0.0];
            let estimate = self.history.estimate_from(&self.next, &self.norm, squares);
            let remaining = if first {
                // The error estimate after one correction decides already.
                if estimate.local > HOPELESS {
                    return Some(estimate);
                }
                let safety_factor = system.contraction_safety_factor();
                let (control, convergence) = (&self.control, &mut self.convergence);
                // The second correction, c |Δ₁|², may be negligible by the constant c of earlier steps.
                if convergence.may_skip_second_correction(control, size, safety_factor) {
                    return Some(self.finish_corrector((nq, gamma), estimate, newest_only));
                }
                size
            } else {
                self.convergence.measure(size, last, iteration == 1)
            };
            // Converged: the remaining corrections are far below the error test.
            if remaining <= REMAINDER {
                return Some(self.finish_corrector((nq, gamma), estimate, newest_only));
            }
            // The first rate may be large after a contact onset; the second one is decisive.
            if iteration > 1 && size / last > SLOWEST_RATE {
                return None;
            }
            last = size;
        }
        None
    }

    /// Evaluate the right-hand side at the iterate; the `first` time factorise the matrix, too. `None` for a singular matrix.
    fn evaluate_iterate(
        &mut self,
        system: &mut impl SecondOrderSystem,
        gamma: f64,
        first: bool,
    ) -> Option<()> {
        let end = self.time + self.next.size;
        let n = self.vectors.dimension;
        let (trial, derivative) = (&self.vectors.trial[..n], &mut self.vectors.derivative[..n]);
        if first {
            system.accelerations_with_slopes(end, trial, derivative);
        } else {
            system.accelerations(end, trial, derivative);
        }
        self.counts.evaluations += 1;
        // Local unknowns are exact for this iterate: they leave the residual.
        self.take_local_solution(system);
        if !first {
            return Some(());
        }
        self.counts.jacobians += 1;
        (system.factorise(&self.vectors.trial[..n], gamma)).then_some(())
    }

    /// Give the system the predicted part `p_v - γ φ*_v` of its local unknowns.
    pub(super) fn begin_implicit_stage(&mut self, system: &mut impl SecondOrderSystem) {
        let (nq, local) = (system.coordinates(), system.local_unknowns());
        if local.is_empty() {
            return;
        }
        let gamma = self.history.gamma(&self.next);
        let local = nq + local.start..nq + local.end;
        let phi_1 = &self.history.differences.row(0)[local.clone()];
        let parts = &mut self.vectors.residual[..local.len()];
        for ((part, predicted), phi) in parts
            .iter_mut()
            .zip(&self.vectors.predicted[local])
            .zip(phi_1)
        {
            *part = predicted - gamma * phi;
        }
        system.begin_implicit_stage(Some((parts, gamma)));
    }

    /// Take the local unknowns solved for in the last evaluation; their residual is then zero.
    fn take_local_solution(&mut self, system: &impl SecondOrderSystem) {
        let (nq, local) = (system.coordinates(), system.local_unknowns());
        if local.is_empty() {
            return;
        }
        let local = nq + local.start..nq + local.end;
        let phi_1 = &self.history.differences.row(0)[local.clone()];
        system.write_local_solution(&mut self.vectors.trial[local.clone()]);
        self.vectors.derivative[local].copy_from_slice(phi_1);
    }

    /// Write the residual of the velocities; return its sum of squares over the weights, at the predicted value.
    fn find_residual(&mut self, nq: usize, gamma: f64, at_prediction: bool) -> f64 {
        let velocities = nq..2 * nq;
        let vectors = &mut self.vectors;
        let derivative = &vectors.derivative[velocities.clone()];
        let phi_1 = &self.history.differences.row(0)[velocities.clone()];
        let residual = &mut vectors.residual[..nq];
        // At the predicted value p_v - v vanishes.
        if at_prediction {
            return self.instructions.run(FirstResidual {
                gamma,
                derivative,
                phi_1,
                inverse_weight: &self.norm.inverse_weight[velocities],
                residual,
            });
        }
        self.instructions.run(Residual {
            gamma,
            predicted: &vectors.predicted[velocities.clone()],
            trial: &vectors.trial[velocities],
            derivative,
            phi_1,
            written: residual,
        });
        0.0
    }

    /// Add the correction. `newest_only`: write the newest difference; `at_prediction`: velocities are predicted ones.
    fn apply_correction(
        &mut self,
        nq: usize,
        gamma: f64,
        (newest_only, at_prediction): (bool, bool),
    ) -> Applied {
        let (vectors, differences) = (&mut self.vectors, &mut self.history.differences);
        let (phi_1, newest) = differences.first_and_newest(self.next.order);
        macro_rules! apply {
            ($newest:literal, $first:literal) => {
                self.instructions.run(Apply::<$newest, $first> {
                    gamma,
                    correction: &vectors.residual[..nq],
                    inverse_weight: self.norm.inverse_weight[..2 * nq].split_at(nq),
                    predicted: &vectors.predicted[nq..2 * nq],
                    phi_1: &phi_1[..nq],
                    newest: newest[..2 * nq].split_at_mut(nq),
                    trial: vectors.trial[..2 * nq].split_at_mut(nq),
                })
            };
        }
        match (newest_only, at_prediction) {
            (true, true) => apply!(true, true),
            (true, false) => apply!(true, false),
            (false, true) => apply!(false, true),
            (false, false) => apply!(false, false),
        }
    }

    /// Compute the derivative at the solution from the corrector's equation, and the sums, unless the newest difference is all that is
    /// needed; return the error estimates. `estimate` is that of the last correction, at this order alone.
    fn finish_corrector(
        &mut self,
        (nq, gamma): (usize, f64),
        estimate: ErrorEstimate,
        newest_only: bool,
    ) -> ErrorEstimate {
        if newest_only {
            return estimate;
        }
        // Higher orders and sums need the derivative itself, for the table of differences.
        let (k, h) = (self.next.order, self.next.size);
        let velocities = nq..2 * nq;
        let (vectors, history) = (&mut self.vectors, &self.history);
        let phi_1 = history.differences.row(0);
        self.instructions.run(DerivativeAtSolution {
            inverse_gamma: 1.0 / gamma,
            predicted: &vectors.predicted[velocities.clone()],
            trial: &vectors.trial[velocities.clone()],
            phi_1: &phi_1[velocities],
            derivative: vectors.derivative[..2 * nq].split_at_mut(nq),
        });
        // Sums have no effect on the motion: the formula of one order more is as stable and has a smaller error.
        let weight = h * history.coefficients.g[k];
        let sum_components = 2 * nq..vectors.dimension;
        let derivatives = vectors.derivative[sum_components.clone()].iter();
        let slopes = derivatives.zip(&phi_1[sum_components.clone()]);
        let predicted = vectors.predicted[sum_components.clone()].iter().zip(slopes);
        for (sum, (predicted, (derivative, phi))) in
            vectors.trial[sum_components].iter_mut().zip(predicted)
        {
            *sum = predicted + weight * (derivative - phi);
        }
        history.estimate_error(self.instructions, &self.next, &self.norm, vectors, false)
    }
}

#[cfg(test)]
mod tests;
