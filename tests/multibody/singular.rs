//! Singular positions passed with both correctors, at loose tolerances and long steps; runs that cannot go on end.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use std::time::Duration;

use crate::common::mechanisms::{Rows, bar_chain, four_bars, ground, run_to};
use rustchain::integrator::{Corrector, OdeSystem, SecondOrderSystem, StepControl};
use rustchain::math::Signal;
use rustchain::multibody::{
    Joint, JointKind, Marker, Mechanism, MechanismGroups, MechanismModel, PrescribedMotion,
};
use rustchain::run::MechanismSimulation;

const CORRECTORS: [Corrector; 3] = [Corrector::Newton, Corrector::Pece, Corrector::Auto];

fn simulation(mechanism: &Mechanism, accuracy: f64, corrector: Corrector) -> MechanismSimulation {
    let control = StepControl {
        accuracy,
        max_step: 0.01,
        corrector,
        ..StepControl::default()
    };
    let model = Arc::new(MechanismModel::compile(mechanism).unwrap());
    MechanismSimulation::assemble(model, control).unwrap()
}

/// Parallelograms in a row that turn clockwise at `speed` \[rad/s\].
fn turning(windows: usize, speed: f64) -> Mechanism {
    let mut mechanism = four_bars(windows);
    for velocity in mechanism.bodies.iter_mut().flat_map(|b| &mut b.velocity) {
        *velocity *= speed;
    }
    mechanism
}

/// The same with a motor on the first post.
fn driven(windows: usize, speed: f64) -> Mechanism {
    let mut mechanism = turning(windows, speed);
    let motor = JointKind::DrivenAngle(PrescribedMotion::Speed(Signal::Constant(-speed)));
    let post = Marker::new("post 0", 0.0, 0.0);
    let motor = Joint::new("motor", ground(0.0, 0.0), post, motor);
    mechanism.joints.push(motor);
    mechanism
}

/// Largest difference of the posts' angles, and turn of a coupler, from which a row folds over.
fn fold(simulation: &mut MechanismSimulation) -> f64 {
    let bodies = simulation.positions();
    let turns = bodies.iter().enumerate().map(|(i, q)| {
        let coupler = i > 0 && i % 2 == 0;
        let parallel_to = if coupler { 0.0 } else { bodies[0][2] };
        (q[2] - parallel_to).abs()
    });
    turns.fold(0.0, f64::max)
}

#[test]
fn driven_parallelograms_pass_singular_positions_with_both_correctors() {
    for (windows, speed) in [(1, 8.0), (2, 8.0), (1, 30.0)] {
        for accuracy in [1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
            for corrector in CORRECTORS {
                let mut machine = simulation(&driven(windows, speed), accuracy, corrector);
                // A whole number of turns and an eighth, away from all singular positions.
                let turns = if speed > 10.0 { 9.125 } else { 3.125 };
                let end = 4.0 * FRAC_PI_2 * turns / speed;
                run_to(&mut machine, end);
                let angle = machine.positions()[0][2];
                let (off, fold) = (angle - FRAC_PI_2 + speed * end, fold(&mut machine));
                let place = format!("{windows} {speed} {accuracy:e} {corrector:?}");
                assert!(
                    off.abs() < 1e-11 && fold < 1e-9,
                    "{place}: {off:e} {fold:e}"
                );
            }
        }
    }
}

#[test]
fn a_matrix_by_differences_leaves_the_evaluation_at_its_own_state() {
    let mut machine = simulation(&turning(1, 8.0), 1e-7, Corrector::Newton);
    // Both posts and the coupler are nearly in a line.
    run_to(&mut machine, FRAC_PI_2 / 8.0);
    let (mut dynamics, adams) = (machine.dynamics().clone(), machine.integrator());
    let (t, y) = (adams.time(), adams.y().to_vec());
    let mut slope = vec![0.0; y.len()];
    dynamics.derivative(t, &y, &mut slope);
    let (accelerations, multipliers) = (
        dynamics.accelerations().to_vec(),
        dynamics.multipliers().to_vec(),
    );
    assert!(dynamics.factorise(&y, 1e-3));
    assert_eq!(dynamics.accelerations(), accelerations);
    assert_eq!(dynamics.multipliers(), multipliers);
}

#[test]
fn parallelograms_without_a_motor_pass_them_as_well() {
    for windows in [1, 2] {
        for (accuracy, bound) in [(1e-5, 2.0), (1e-7, 0.1), (1e-9, 1e-3)] {
            for corrector in CORRECTORS {
                let mut machine = simulation(&turning(windows, 8.0), accuracy, corrector);
                machine.start_recording(2.0, 0.02, MechanismGroups::ALL);
                while !machine.record(Duration::MAX).unwrap() {}
                let recording = machine.take_recording();
                let energy = recording.energy();
                let residuals = energy.chunks(6).map(|row| row[5].abs());
                let worst = residuals.fold(0.0, f64::max);
                let fold = fold(&mut machine);
                let place = format!("{windows} {accuracy:e} {corrector:?}");
                // Of 85 or 130 J.
                assert!(worst < bound && fold < 1e-5, "{place}: {worst:e} {fold:e}");
            }
        }
    }
}

#[test]
fn loads_beyond_all_numbers_end_in_an_error_that_names_the_body() {
    for (mass, hinged) in [(1e308, false), (1e308, true), (1e200, true)] {
        for corrector in CORRECTORS {
            let mut mechanism = bar_chain(1, 0.3);
            mechanism.gravity *= 1e200;
            (mechanism.bodies[0].mass, mechanism.bodies[0].inertia) = (mass, mass);
            if !hinged {
                mechanism.joints.clear();
            }
            let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
            let control = StepControl {
                corrector,
                ..StepControl::default()
            };
            // Refused at the start, or stopped in the first step.
            let made = MechanismSimulation::assemble(model, control);
            if let Ok(mut machine) = made {
                let error = machine.advance(1.0, Duration::MAX).unwrap_err().to_string();
                assert!(error.contains("bar 0"), "{error}");
                assert!(machine.counts().rejected < 2000);
            }
        }
    }
}
