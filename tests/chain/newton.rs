//! The implicit corrector: its matrix against finite differences, and runs with it.

use crate::common;
use crate::common::checks::{
    forces_and_powers_follow_from_a_correction, matrix_is_that_of_finite_differences, newton,
};
use crate::common::scenes::laws;
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::{Drive, HingeKind};
use rustchain::force_law::{Damping, Elastic, Film, Regions};
use rustchain::integrator::{Adams, OdeSystem, SecondOrderSystem, StepControl};
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
    common::simulation(&drive, &laws(elastic, damping, Regions::Kept), control)
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

/// Drives with ideal hinges at two pretensions, when teeth are pressed.
fn pressed_ideal_scenes() -> impl Iterator<Item = (String, Simulation)> {
    [25.0, 100.0].into_iter().map(|pretension| {
        let drive = Drive {
            hinge_kind: HingeKind::Ideal,
            tensioner: Some(common::tensioner(pretension, 2e-3)),
            ..common::paper_drive()
        };
        let mut run = common::simulation(&drive, &ForceLaws::default(), newton(1e-9));
        common::advance(&mut run, 8e-3);
        (format!("ideal {pretension} N"), run)
    })
}

/// Whether some hinge or some bushing on a tooth touches.
fn touches(dynamics: &Dynamics) -> bool {
    dynamics.hinge_contacts().any(|(depth, _)| depth > 0.0)
        || dynamics.candidates().any(|(_, _, depth, _)| depth > 0.0)
}

#[test]
fn the_matrix_is_that_of_finite_differences_but_for_angles_turned_in_a_step() {
    for (scene, run) in pressed_scenes() {
        matrix_is_that_of_finite_differences(&scene, &run, touches);
    }
}

/// The correction of the accelerations of a run's state, by the matrix of a step or by one that may be indefinite.
fn corrected(run: &Simulation, gamma: f64, indefinite: bool) -> Vec<f64> {
    let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
    let mut dynamics = run.dynamics().clone();
    let nq = dynamics.coordinates();
    let mut slope = vec![0.0; y.len()];
    dynamics.accelerations_with_slopes(t, &y, &mut slope);
    let regular = if indefinite {
        dynamics.factorise_indefinite(gamma)
    } else {
        dynamics.factorise(&y, gamma)
    };
    assert!(regular, "{gamma:e}");
    let mut correction = slope[nq..].to_vec();
    dynamics.correct(&mut correction);
    correction
}

/// A step's matrix has single precision, one that may be indefinite double precision. The matrix neglects some 1e-2 of a correction.
#[test]
fn single_precision_changes_a_correction_by_a_ten_thousandth_at_most() {
    for (scene, run) in pressed_scenes().into_iter().chain(pressed_ideal_scenes()) {
        for (gamma, bound) in [
            (1e-9, 1e-6),
            (1e-7, 1e-6),
            (1e-6, 1e-6),
            (1e-5, 3e-6),
            (2.9e-5, 1e-4),
        ] {
            let (single, double) = (corrected(&run, gamma, false), corrected(&run, gamma, true));
            let largest = (double.iter()).fold(0.0f64, |largest, x| largest.max(x.abs()));
            let errors = single.iter().zip(&double).map(|(a, b)| (a - b).abs());
            let error = errors.fold(0.0, f64::max) / largest;
            assert!(error < bound, "{scene} {gamma:e}: {error:e}");
            assert!(
                error > 0.0,
                "{scene} {gamma:e}: both have the same precision"
            );
        }
    }
}

/// Where rounding in single precision would be too large.
#[test]
fn long_steps_and_films_have_double_precision() {
    let mut scenes: Vec<_> = (pressed_scenes().into_iter())
        .map(|(scene, run)| (scene, run, 3.1e-5))
        .collect();
    let laws = ForceLaws {
        hinge_film: Some(Film {
            viscosity: 10.0,
            length: None,
            handover: 0.9,
            tension: 1e5,
        }),
        ..ForceLaws::default()
    };
    let drive = common::paper_drive();
    let mut run = common::simulation(&drive, &laws, newton(1e-9));
    common::advance(&mut run, 1e-4);
    scenes.push(("film".to_string(), run, 1e-6));
    for (scene, run, gamma) in scenes {
        let (step, double) = (corrected(&run, gamma, false), corrected(&run, gamma, true));
        assert_eq!(step, double, "{scene}");
    }
}

#[test]
fn forces_and_powers_after_a_correction_need_no_evaluation() {
    let compared = forces_and_powers_follow_from_a_correction(pressed_scenes(), 0.0);
    assert_eq!(compared, 16);
    // With ideal hinges the losses change by 2e-8 to 3e-7 W only. The external power, of some watts, is compared to 1e-8 W.
    let compared = forces_and_powers_follow_from_a_correction(pressed_ideal_scenes(), 1e-8);
    assert_eq!(compared, 4);
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
