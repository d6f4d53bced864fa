//! Tests of Newton's iteration on three oscillators with known slopes.

#![allow(clippy::needless_range_loop)] // several arrays have one index

use std::ops::Range;

use super::super::{OdeSystem, StepControl, StepFailure};
use super::*;

const NQ: usize = 3;

/// `q'' = -k q - d q' - c q³` for each of three coordinates, and the sum of `q'` of the first one.
#[derive(Clone)]
struct Springs {
    stiffness: [f64; NQ],
    damping: [f64; NQ],
    cubic: f64,
    sums: usize,
    /// The last velocity has a first-order equation, which the system solves by itself.
    local: bool,
    /// Share of the correction that [`SecondOrderSystem::correct`] returns.
    share: f64,
    safety_factor: f64,
    /// Residual without the reactions of constraints.
    free: Option<[f64; NQ]>,
    /// Rate of the sum after a correction.
    sum_rate: Option<f64>,
    /// Diagonal of the matrix.
    matrix: [f64; NQ],
    /// Predicted part of the local unknown, and γ.
    stage: Option<(f64, f64)>,
}

impl Springs {
    fn new() -> Self {
        Self {
            stiffness: [1.0, 4.0, 9.0],
            damping: [0.1, 0.0, 0.3],
            cubic: 0.0,
            sums: 0,
            local: false,
            share: 1.0,
            safety_factor: f64::INFINITY,
            free: None,
            sum_rate: None,
            matrix: [1.0; NQ],
            stage: None,
        }
    }

    fn acceleration(&self, i: usize, q: f64, v: f64) -> f64 {
        if self.local && i == 2 {
            return -self.damping[2] * v;
        }
        -self.stiffness[i] * q - self.damping[i] * v - self.cubic * q.powi(3)
    }

    /// Return v = part + γ dv/dt of the local unknown.
    fn local_solution(&self) -> Option<f64> {
        (self.stage).map(|(part, gamma)| part / (1.0 + gamma * self.damping[2]))
    }
}

impl OdeSystem for Springs {
    fn dimension(&self) -> usize {
        2 * NQ + self.sums
    }
    fn controlled(&self) -> usize {
        2 * NQ
    }
    fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
        for i in 0..NQ {
            dydt[i] = y[NQ + i];
            dydt[NQ + i] = self.acceleration(i, y[i], y[NQ + i]);
        }
        dydt[2 * NQ..].fill(y[NQ]);
    }
}

impl SecondOrderSystem for Springs {
    fn coordinates(&self) -> usize {
        NQ
    }
    fn contraction_safety_factor(&self) -> f64 {
        self.safety_factor
    }
    fn local_unknowns(&self) -> Range<usize> {
        if self.local { 2..3 } else { 0..0 }
    }
    fn begin_implicit_stage(&mut self, stage: Option<(&[f64], f64)>) {
        self.stage = stage.map(|(parts, gamma)| {
            assert_eq!(parts.len(), 1);
            (parts[0], gamma)
        });
    }
    fn write_local_solution(&self, velocities: &mut [f64]) {
        velocities.copy_from_slice(&[self.local_solution().unwrap()]);
    }
    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        for i in 0..NQ {
            let slope = self.stiffness[i] + 3.0 * self.cubic * y[i].powi(2);
            self.matrix[i] = 1.0 + gamma * (self.damping[i] + gamma * slope);
        }
        true
    }
    fn correct(&mut self, residual: &mut [f64]) {
        for (residual, matrix) in residual.iter_mut().zip(self.matrix) {
            *residual *= self.share / matrix;
        }
        if self.local {
            residual[2] = 0.0;
        }
    }
    fn stiffness_residual(&self) -> Option<&[f64]> {
        self.free.as_ref().map(|free| &free[..])
    }
    fn correct_sum_rates(&self, rates: &mut [f64]) {
        assert_eq!(rates.len(), self.sums);
        if let Some(rate) = self.sum_rate {
            rates.fill(rate);
        }
    }
    fn scale(&self, lengths: &mut [f64]) {
        lengths.copy_from_slice(&[1.0, 2.0, 0.5]);
    }
}

/// An integrator behind `steps` implicit steps of at most 0.01 s, and the system.
fn stepped(system: Springs, steps: usize, max_order: usize) -> (Adams, Springs) {
    stepped_with(1e-7, system, steps, max_order)
}

fn stepped_with(
    accuracy: f64,
    mut system: Springs,
    steps: usize,
    max_order: usize,
) -> (Adams, Springs) {
    let control = StepControl {
        accuracy,
        max_step: 0.01,
        max_order,
        ..StepControl::default()
    };
    let mut adams = Adams::new(system.dimension(), control);
    let y = [1.0, -0.5, 0.7, 0.2, 0.3, -0.4, 0.0];
    adams.restart(0.0, &y[..system.dimension()]);
    for _ in 0..steps {
        adams.step_newton(&mut system).unwrap();
    }
    (adams, system)
}

/// The predictor of the explicit corrector: predicted value, φ*_1 and γ.
fn predicted(adams: &Adams) -> (Vec<f64>, Vec<f64>, f64) {
    let mut general = adams.clone();
    general
        .history
        .predict(general.instructions, &general.next, &mut general.vectors);
    let phi_1 = general.history.differences.row(0).to_vec();
    let gamma = general.history.gamma(&general.next);
    (general.vectors.predicted.to_vec(), phi_1, gamma)
}

fn near(found: f64, expected: f64, bound: f64) {
    assert!((found - expected).abs() <= bound, "{found} {expected}");
}

/// Rounding of sums of a few terms of size one.
const ROUNDING: f64 = 1e-14;

#[test]
fn the_first_iterate_follows_from_the_predicted_velocities_at_every_order() {
    for (sums, max_order) in [(0, 1), (0, 2), (1, 1), (1, 2), (0, 6), (1, 6)] {
        let system = Springs {
            sums,
            ..Springs::new()
        };
        let (mut adams, _) = stepped(system, 61, max_order);
        let order = adams.next.order;
        assert!(order == max_order || order > 2, "{order}");
        let (p, phi, gamma) = predicted(&adams);
        adams.vectors.predicted.fill(f64::NAN);
        adams.predict_implicit(NQ);
        for i in 0..NQ {
            let speed = adams.vectors.trial[NQ + i];
            near(speed, p[NQ + i], ROUNDING);
            near(adams.vectors.predicted[NQ + i], p[NQ + i], ROUNDING);
            let place = p[i] + gamma * (p[NQ + i] - phi[i]);
            near(adams.vectors.trial[i], place, ROUNDING);
            near(adams.history.differences.row(0)[i], phi[i], ROUNDING);
        }
        for i in 2 * NQ..2 * NQ + sums {
            near(adams.vectors.trial[i], p[i], ROUNDING);
        }
        // One pass at low orders without sums leaves the predicted coordinates out.
        let one_pass = max_order <= 2 && sums == 0;
        assert_eq!(adams.vectors.predicted[0].is_nan(), one_pass);
    }
}

#[test]
fn the_slope_behind_an_implicit_step_is_the_derivative_at_its_solution() {
    for (sums, max_order) in [(0, 1), (0, 2), (1, 2), (0, 6), (1, 6)] {
        let system = Springs {
            sums,
            ..Springs::new()
        };
        let n = system.dimension();
        let (adams, mut system) = stepped(system, 60, max_order);
        let mut exact = [0.0; 2 * NQ + 1];
        let [_, slope] = adams.slopes_of_last_step();
        system.derivative(adams.time, adams.y(), &mut exact[..n]);
        // The matrix of a linear system is exact: rounding of the velocities over γ is left.
        for (found, exact) in slope[..2 * NQ].iter().zip(exact) {
            near(*found, exact, 1e-11);
        }
    }
}

/// Solve the corrector from a predicted value.
fn solve(adams: &mut Adams, system: &mut impl SecondOrderSystem) -> Option<ErrorEstimate> {
    let newest_only = adams.needs_newest_difference_only(NQ);
    adams.solve_corrector(system, newest_only)
}

#[test]
fn a_converged_iterate_solves_the_equation_of_the_corrector() {
    for (sums, max_order) in [(0, 2), (1, 2), (0, 6), (1, 6)] {
        let system = Springs {
            cubic: 300.0,
            sums,
            ..Springs::new()
        };
        let (mut adams, mut system) = stepped(system, 80, max_order);
        let (p, phi, gamma) = predicted(&adams);
        let (k, h) = (adams.next.order, adams.next.size);
        let before = adams.counts;
        adams.predict_implicit(NQ);
        let estimate = solve(&mut adams, &mut system).unwrap();
        assert!(adams.counts.evaluations > before.evaluations);
        assert_eq!(adams.counts.jacobians, before.jacobians + 1);
        let weights = adams.norm.inverse_weight.to_vec();
        let (trial, g) = (&adams.vectors.trial, &adams.history.coefficients.g);
        let (mut rest, mut distance) = (0.0, 0.0);
        for i in 0..NQ {
            let (q, v) = (trial[i], trial[NQ + i]);
            near(q, p[i] + gamma * (v - phi[i]), ROUNDING);
            let a = system.acceleration(i, q, v);
            let residual = p[NQ + i] - v + gamma * (a - phi[NQ + i]);
            // The remaining correction of v, and that of q by γ.
            let left = residual / system.matrix[i];
            rest += (left * weights[NQ + i]).powi(2) + (gamma * left * weights[i]).powi(2);
            let newest = [v - phi[i], (v - p[NQ + i]) / gamma];
            distance += (newest[0] * weights[i]).powi(2) + (newest[1] * weights[NQ + i]).powi(2);
            if sums + max_order > 2 {
                near(adams.vectors.derivative[i], v, 0.0);
                let rate = phi[NQ + i] + newest[1];
                near(adams.vectors.derivative[NQ + i], rate, 1e-12 * rate.abs());
            } else {
                let row = adams.history.differences.row(k);
                near(row[i], newest[0], 0.0);
                near(row[NQ + i], newest[1], 1e-9 * newest[1].abs());
            }
        }
        assert!((rest / 6.0).sqrt() <= REMAINDER, "{rest}");
        let local = h * (g[k - 1] - g[k]) * (distance / 6.0).sqrt();
        near(estimate.local, local, 1e-9 * local);
        // The formula of the sum is of one order more.
        for i in 2 * NQ..2 * NQ + sums {
            let rate = adams.vectors.derivative[i];
            near(trial[i], p[i] + h * g[k] * (rate - phi[i]), ROUNDING);
        }
    }
}

/// The evaluations of one attempt, and whether it converged.
fn attempt(adams: &Adams, system: &Springs) -> (u64, bool) {
    let (mut adams, mut system) = (adams.clone(), system.clone());
    let before = adams.counts.evaluations;
    adams.predict_implicit(NQ);
    let estimate = solve(&mut adams, &mut system);
    (adams.counts.evaluations - before, estimate.is_some())
}

/// An integrator whose next step has a first correction of this size in units of the tolerance.
///
/// The steps are about as long as the periods: the error is about as large as the correction.
fn with_correction(size: f64) -> (Adams, Springs) {
    let stiff = Springs {
        stiffness: [4e4, 5e4, 6e4],
        ..Springs::new()
    };
    let (mut adams, system) = stepped_with(1e3, stiff, 60, 2);
    assert_eq!(adams.next.size, 0.01);
    let (mut trial, mut same) = (adams.clone(), system.clone());
    trial.predict_implicit(NQ);
    let gamma = trial.history.gamma(&trial.next);
    trial.evaluate_iterate(&mut same, gamma, true).unwrap();
    trial.find_residual(NQ, gamma, true);
    same.correct(&mut trial.vectors.residual[..NQ]);
    let applied = trial.apply_correction(NQ, gamma, (true, true));
    let found = trial.norm.of_sum(applied.lengths + applied.speeds);
    for weight in adams.norm.inverse_weight.iter_mut() {
        *weight *= size / found;
    }
    (adams, system)
}

#[test]
fn an_exact_matrix_takes_a_second_evaluation_only_above_the_remainder() {
    let (adams, system) = with_correction(0.9 * REMAINDER);
    assert_eq!(attempt(&adams, &system), (1, true));
    // Of a linear system the second correction is rounding.
    let (adams, system) = with_correction(1.1 * REMAINDER);
    assert_eq!(attempt(&adams, &system), (2, true));
}

#[test]
fn an_iteration_that_converges_slower_than_its_limit_ends_at_the_third_correction() {
    // The rate is one less the share of the correction; the remaining one is 19 and 4 times the last.
    let (adams, mut system) = with_correction(5.0);
    system.share = 0.05;
    assert_eq!(attempt(&adams, &system), (3, false));
    system.share = 0.2;
    assert_eq!(attempt(&adams, &system), (6, false));
    // At a half the corrections are 0.25, 0.125 and 0.0625 of the tolerance, and those that remain are as large as the last.
    let (adams, mut system) = with_correction(0.5);
    system.share = 0.5;
    assert_eq!(attempt(&adams, &system), (3, true));
}

#[test]
fn a_hopeless_step_takes_one_evaluation() {
    let (adams, system) = with_correction(1.0);
    let local = |adams: &Adams| {
        let (mut adams, mut system) = (adams.clone(), system.clone());
        adams.predict_implicit(NQ);
        solve(&mut adams, &mut system).unwrap().local
    };
    let unit = local(&adams);
    for (error, evaluations) in [(1.01 * HOPELESS, 1), (0.99 * HOPELESS, 2)] {
        let mut scaled = adams.clone();
        for weight in scaled.norm.inverse_weight.iter_mut() {
            *weight *= error / unit;
        }
        assert_eq!(attempt(&scaled, &system), (evaluations, true));
    }
}

#[test]
fn a_correction_that_is_not_a_number_is_no_convergence() {
    let (adams, mut system) = with_correction(0.5);
    system.share = f64::NAN;
    assert_eq!(attempt(&adams, &system), (1, false));
}

/// The same system whose matrix is singular at any step size.
struct Singular(Springs);

impl OdeSystem for Singular {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.0.derivative(t, y, dydt);
    }
}

impl SecondOrderSystem for Singular {
    fn coordinates(&self) -> usize {
        NQ
    }
    fn factorise(&mut self, _y: &[f64], _gamma: f64) -> bool {
        false
    }
    fn correct(&mut self, _residual: &mut [f64]) {}
    fn scale(&self, lengths: &mut [f64]) {
        self.0.scale(lengths);
    }
}

#[test]
fn a_singular_matrix_is_no_convergence() {
    let (mut adams, system) = with_correction(0.5);
    let mut system = Singular(system);
    // The defaults of a system: no bound on the contraction constant, no local unknowns.
    assert_eq!(system.contraction_safety_factor(), f64::INFINITY);
    assert!(system.local_unknowns().is_empty());
    adams.predict_implicit(NQ);
    assert!(solve(&mut adams, &mut system).is_none());
}

#[test]
fn a_measured_contraction_constant_spares_the_second_evaluation() {
    // Of a linear system the second correction is rounding: the first measurement spares those of all later steps.
    let (mut adams, mut system) = with_correction(5.0);
    system.safety_factor = 1.0;
    let before = adams.counts;
    for _ in 0..20 {
        adams.step_newton(&mut system).unwrap();
    }
    let counts = adams.counts;
    let [steps, rejected, evaluations] = [
        counts.steps - before.steps,
        counts.rejected - before.rejected,
        counts.evaluations - before.evaluations,
    ];
    assert_eq!([steps, evaluations], [20, 20 + rejected + 1]);
    assert_eq!(counts.jacobians - before.jacobians, 20 + rejected);
}

#[test]
fn local_unknowns_take_the_solution_of_the_system_and_leave_the_residual() {
    let system = Springs {
        local: true,
        ..Springs::new()
    };
    let (mut adams, mut system) = stepped(system, 30, 6);
    let (p, phi, gamma) = predicted(&adams);
    adams.predict_implicit(NQ);
    adams.begin_implicit_stage(&mut system);
    let (part, given) = system.stage.unwrap();
    near(part, p[5] - gamma * phi[5], ROUNDING);
    assert_eq!(given, gamma);
    adams.evaluate_iterate(&mut system, gamma, true).unwrap();
    assert_eq!(adams.vectors.trial[5], system.local_solution().unwrap());
    near(adams.vectors.derivative[5], phi[5], ROUNDING);
    adams.find_residual(NQ, gamma, true);
    assert_eq!(adams.vectors.residual[2], 0.0);
    // The solution decays with its damping.
    let exact = -0.4 * (-0.3 * adams.time).exp();
    near(adams.vectors.y[5], exact, 1e-6);
}

#[test]
fn the_fastest_rate_follows_from_the_residual_without_reactions() {
    let (mut adams, mut system) = with_correction(0.05);
    adams.fastest = crate::integrator::stability::FastestRate::default();
    let mut trial = adams.clone();
    trial.predict_implicit(NQ);
    let gamma = trial.history.gamma(&trial.next);
    trial.evaluate_iterate(&mut system, gamma, true).unwrap();
    let own = trial.find_residual(NQ, gamma, true);
    system.correct(&mut trial.vectors.residual[..NQ]);
    let speeds = trial.apply_correction(NQ, gamma, (true, true)).speeds;
    let weights = &adams.norm.inverse_weight[NQ..2 * NQ];
    let free = [0.3, -0.2, 0.1].map(|part| part * 1e3 / weights[0]);
    let squares: f64 = free.iter().zip(weights).map(|(r, w)| (r * w).powi(2)).sum();
    for (given, residual) in [(None, own), (Some(free), squares)] {
        let mut adams = adams.clone();
        system.free = given;
        adams.predict_implicit(NQ);
        solve(&mut adams, &mut system).unwrap();
        let mut expected = crate::integrator::stability::FastestRate::default();
        expected.record_correction(residual, speeds, gamma);
        let (found, expected) = (adams.fastest.value(), expected.value());
        near(found, expected, 1e-9 * expected);
        assert!(expected > 0.0);
    }
}

#[test]
fn sums_follow_the_rates_after_the_correction() {
    let system = Springs {
        sums: 1,
        ..Springs::new()
    };
    let (mut adams, mut system) = stepped(system, 60, 2);
    let (p, phi, _) = predicted(&adams);
    let (k, h) = (adams.next.order, adams.next.size);
    system.sum_rate = Some(7.0);
    adams.predict_implicit(NQ);
    solve(&mut adams, &mut system).unwrap();
    let weight = h * adams.history.coefficients.g[k];
    near(
        adams.vectors.trial[6],
        p[6] + weight * (7.0 - phi[6]),
        ROUNDING,
    );
}

/// One oscillator with a sum: coordinates, velocities and sums have as many components.
struct Single(f64);

impl OdeSystem for Single {
    fn dimension(&self) -> usize {
        3
    }
    fn controlled(&self) -> usize {
        2
    }
    fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
        dydt.copy_from_slice(&[y[1], -y[0], y[1]]);
    }
}

impl SecondOrderSystem for Single {
    fn coordinates(&self) -> usize {
        1
    }
    fn factorise(&mut self, _y: &[f64], gamma: f64) -> bool {
        self.0 = 1.0 + gamma * gamma;
        true
    }
    fn correct(&mut self, residual: &mut [f64]) {
        residual[0] /= self.0;
    }
    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
    }
}

#[test]
fn the_sum_of_velocities_is_the_coordinate_at_low_orders() {
    for max_order in [1, 2] {
        let control = StepControl {
            accuracy: 1e-6,
            max_step: 1e-3,
            max_order,
            ..StepControl::default()
        };
        let mut adams = Adams::new(3, control);
        adams.restart(0.0, &[1.0, 0.0, 0.0]);
        while adams.time < 0.1 {
            adams.step_newton(&mut Single(1.0)).unwrap();
        }
        // Backward Euler's error grows by at most h/2 |q''| in each step, that of the sum is of second order.
        let bound = 0.5 * 1e-3 * 0.1;
        near(adams.vectors.y[2], adams.vectors.y[0] - 1.0, bound);
        near(adams.vectors.y[2], adams.time.cos() - 1.0, bound);
    }
}

#[test]
fn a_failure_names_the_last_velocity_where_that_has_the_largest_error() {
    for sums in [0, 1] {
        let system = Springs {
            sums,
            ..Springs::new()
        };
        let (mut adams, mut system) = stepped(system, 30, 6);
        // A sudden stiffness, and no step size at which the matrix is regular.
        system.stiffness[2] = 1e9;
        let failure = adams.step_newton(&mut Singular(system)).unwrap_err();
        assert!(
            matches!(failure, StepFailure::TooSmall { component: 5, .. }),
            "{failure:?}"
        );
    }
}
