//! The implicit corrector: its matrix against finite differences, and runs with it.

#![allow(clippy::unwrap_used)]

mod common;

use rustchain::force_law::{Damping, Elastic, ForceLaw};
use rustchain::integrator::{Adams, Corrector, OdeSystem, SecondOrderSystem, StepControl};
use rustchain::vector::InstructionSet;
use rustchain::{ForceLaws, Simulation};

fn simulation(
    elastic: Elastic,
    damping: Damping,
    pretension: f64,
    control: StepControl,
) -> Simulation {
    let mut drive = common::paper_drive();
    if pretension > 0.0 {
        drive.tensioner = Some(common::tensioner(pretension, 2e-3));
    }
    let law = ForceLaw {
        elastic,
        damping,
        ..ForceLaw::default()
    };
    let laws = ForceLaws {
        hinge: law,
        tooth: law,
        ..ForceLaws::default()
    };
    common::simulation(&drive, &laws, control)
}

/// Laws of all forms, each with two pretensions, when hinges and teeth are pressed.
fn pressed_scenes() -> Vec<(String, Simulation)> {
    let mut scenes = Vec::new();
    for (elastic, damping) in [
        (Elastic::Hertz, Damping::LankaraniNikravesh),
        (Elastic::Hertz, Damping::None),
        (Elastic::Johnson, Damping::LankaraniNikravesh),
        (Elastic::EnhancedCylinder, Damping::LankaraniNikravesh),
        (Elastic::LiuConformal, Damping::Flores),
    ] {
        for pretension in [25.0, 100.0] {
            let mut run = simulation(elastic, damping, pretension, StepControl::default());
            common::advance(&mut run, 8e-3);
            scenes.push((format!("{elastic:?} {damping:?} {pretension} N"), run));
        }
    }
    scenes
}

fn residuals(coordinates: usize) -> impl Iterator<Item = Vec<f64>> {
    let entry = |seed: usize, i: usize| ((i * 37 + seed * 101) % 17) as f64 / 17.0 - 0.5;
    (0..5).map(move |seed| (0..coordinates).map(|i| entry(seed, i)).collect())
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |a: f64, b| a.max(b.abs()))
}

#[test]
fn the_exact_matrix_is_that_of_finite_differences() {
    for (scene, run) in pressed_scenes() {
        let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
        let mut dynamics = run.dynamics().clone();
        let nq = dynamics.coordinates();
        let gamma = 1e-5;
        let mut slope = vec![0.0; y.len()];
        for residual in residuals(nq) {
            dynamics.derivative(t, &y, &mut slope);
            let touching = dynamics.hinge_contacts().filter(|(d, _)| *d > 0.0).count()
                + dynamics.candidates().filter(|c| c.2 > 0.0).count();
            assert!(touching > 0);
            let mut x = residual.clone();
            assert!(dynamics.correct_exactly(&y, gamma, &mut x));
            let size = largest(&x);
            let step = 1e-5 / (gamma * size);
            let mut at = |sign: f64| {
                let mut z = y.clone();
                for i in 0..nq {
                    z[i] += sign * step * gamma * gamma * x[i];
                    z[nq + i] += sign * step * gamma * x[i];
                }
                let mut slope = vec![0.0; y.len()];
                dynamics.derivative(t, &z, &mut slope);
                slope
            };
            let (up, down) = (at(1.0), at(-1.0));
            for i in 0..nq {
                let product = x[i] - (up[nq + i] - down[nq + i]) / (2.0 * step);
                // Measured: 1.3e-4, the differences' own error at shallow contacts.
                assert!(
                    (product - residual[i]).abs() < 5e-4 * size.max(1.0),
                    "{scene}, coordinate {i}: {product} for {}",
                    residual[i]
                );
            }
        }
    }
}

#[test]
fn the_kernels_matrix_is_the_exact_one_but_for_angles_turned_in_a_step() {
    for (scene, run) in pressed_scenes() {
        let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
        let mut bits: Option<Vec<Vec<f64>>> = None;
        for set in InstructionSet::available() {
            let mut dynamics = run.dynamics().clone();
            dynamics.use_instructions(set);
            let mut slope = vec![0.0; y.len()];
            let mut found = Vec::new();
            for gamma in [1e-5, 1e-6, 1e-8] {
                dynamics.accelerations_with_slopes(t, &y, &mut slope);
                assert!(dynamics.factorise(&y, gamma));
                for residual in residuals(dynamics.coordinates()) {
                    let (mut x, mut exact) = (residual.clone(), residual);
                    dynamics.correct(&mut x);
                    assert!(dynamics.correct_exactly(&y, gamma, &mut exact));
                    let error = x.iter().zip(&exact).map(|(a, b)| (a - b).abs());
                    let error = error.fold(0.0, f64::max) / largest(&exact);
                    // Slip over radius is up to 1e4 1/s here; a border that is only swept leaves as much.
                    assert!(error < 5e4 * gamma, "{scene}, {gamma:e}: {error:e}");
                    found.push(x);
                }
            }
            if set.has_fused_multiply_add() {
                let same = *bits.get_or_insert_with(|| found.clone()) == found;
                assert!(same, "{scene}, {}", set.name());
            }
        }
    }
}

fn newton(accuracy: f64) -> StepControl {
    StepControl {
        corrector: Corrector::Newton,
        accuracy,
        ..StepControl::default()
    }
}

/// Largest energy residual over energy dissipated in the first `duration`, as a root mean square over runs that differ slightly,
/// and steps of all of them.
fn balance(pretension: f64, duration: f64, accuracy: f64) -> (f64, u64) {
    let (mut squares, mut steps, runs) = (0.0, 0, 4);
    for i in 0..runs {
        let mut drive = common::paper_drive();
        drive.tensioner = Some(common::tensioner(
            pretension,
            2e-3 * (1.0 + 0.01 * f64::from(i)),
        ));
        let mut run = common::simulation(&drive, &ForceLaws::default(), newton(accuracy));
        let energy = common::energies(&mut run, duration, 0.1 * duration);
        let share = energy.largest_residual() / energy.dissipated.last().unwrap();
        squares += share * share / f64::from(runs);
        steps += run.statistics().counts.steps;
    }
    (squares.sqrt(), steps)
}

#[test]
fn the_balance_closes_better_with_the_accuracy() {
    for pretension in [25.0, 100.0] {
        let [(loose, few), (tight, many)] =
            [1e-9, 1e-11].map(|accuracy| balance(pretension, 0.05, accuracy));
        assert!(
            loose < 0.02 && tight < 2e-3,
            "{pretension} N: {loose} {tight}"
        );
        assert!(tight < 0.5 * loose, "{pretension} N: {loose} {tight}");
        // Steps grow as the cube root of one over the accuracy, or less where it is not what holds them.
        assert!(many < 6 * few, "{pretension} N: {few} {many}");
    }
}

#[test]
fn stiff_contacts_do_not_hold_the_steps() {
    let steps = |control| {
        let mut run = simulation(Elastic::Hertz, Damping::LankaraniNikravesh, 100.0, control);
        common::advance(&mut run, 0.01);
        run.statistics().counts.steps
    };
    let (explicit, implicit) = (steps(common::control(1e-5)), steps(newton(1e-9)));
    assert!(10 * implicit < explicit, "{implicit} {explicit}");
}

/// Largest distance of a link from where it is in a run at tight tolerances, at 5 ms without pretension \[m\].
#[test]
fn the_path_converges_to_that_of_the_explicit_method() {
    let at_5_ms = |control| {
        let mut run = simulation(Elastic::Hertz, Damping::LankaraniNikravesh, 0.0, control);
        common::advance(&mut run, 5e-3);
        run.motion().positions()
    };
    let reference = at_5_ms(common::control(1e-12));
    let off = |accuracy| {
        at_5_ms(newton(accuracy))
            .iter()
            .zip(&reference)
            .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
            .fold(0.0, f64::max)
    };
    let errors = [1e-9, 1e-10, 1e-11, 1e-12].map(off);
    assert!(errors[0] < 2e-6, "{errors:?}");
    // Two paths differ in where the first onsets fall: single errors scatter threefold.
    assert!(errors[2] < 0.2 * errors[0], "{errors:?}");
    assert!(errors[3] < 2e-8, "{errors:?}");
}

/// q'' = -100 sin q - q'/2: smooth, with a velocity in it.
struct Pendulum {
    factor: f64,
}

impl OdeSystem for Pendulum {
    fn dimension(&self) -> usize {
        2
    }
    fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
        dydt[0] = y[1];
        dydt[1] = -100.0 * y[0].sin() - 0.5 * y[1];
    }
}

impl SecondOrderSystem for Pendulum {
    fn coordinates(&self) -> usize {
        1
    }
    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        self.factor = 1.0 + 0.5 * gamma + gamma * gamma * 100.0 * y[0].cos();
        true
    }
    fn correct(&mut self, residual: &mut [f64]) {
        residual[0] /= self.factor;
    }
    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
    }
}

#[test]
fn a_smooth_motion_is_followed_at_order_two() {
    let end = |accuracy: f64| {
        let mut adams = Adams::new(
            2,
            StepControl {
                max_step: 1.0,
                max_order: 2,
                ..newton(accuracy)
            },
        );
        adams.restart(0.0, &[1.0, 0.0]);
        let mut pendulum = Pendulum { factor: 1.0 };
        while adams.time() < 2.0 {
            adams.step_newton(&mut pendulum).unwrap();
        }
        (adams.dense(2.0).value(0), adams.counts().steps)
    };
    let (exact, _) = end(1e-11);
    let [(rough, few), (fine, many)] = [1e-6, 1e-9].map(end);
    let ratio = ((rough - exact) / (fine - exact)).abs().ln() / (many as f64 / few as f64).ln();
    assert!(
        (ratio - 2.0).abs() < 0.4,
        "order {ratio}, {few} and {many} steps"
    );
    assert!((fine - exact).abs() < 1e-5);
}
