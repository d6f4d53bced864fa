//! Bodies that spin about ideal joints: the error follows the accuracy, however long the steps may be.

use std::sync::Arc;

use crate::common::mechanisms::{ground, revolute, run_to};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, StepControl};
use rustchain::multibody::{Body, Marker, Mechanism, MechanismModel};
use rustchain::run::MechanismSimulation;

/// A body whose centre is held at a distance of `arm` \[m\] from the ground's origin and that turns freely at `speed` \[rad/s\].
fn spinning(arm: f64, speed: f64) -> Mechanism {
    let mut body = Body::new("rotor", 1.0, 0.01);
    body.position = [arm, 0.0, 0.0];
    body.velocity = [0.0, arm * speed, speed];
    Mechanism {
        gravity: Vec2::zeros(),
        bodies: vec![body],
        joints: vec![revolute(
            "bearing",
            ground(0.0, 0.0),
            Marker::new("rotor", -arm, 0.0),
        )],
        ..Mechanism::default()
    }
}

/// Angle and spin after a second.
fn turned(mechanism: &Mechanism, control: StepControl) -> ([f64; 2], u64) {
    let model = Arc::new(MechanismModel::compile(mechanism).unwrap());
    let mut simulation = MechanismSimulation::assemble(model, control).unwrap();
    run_to(&mut simulation, 1.0);
    let (angle, spin) = (simulation.positions()[0][2], simulation.velocities()[0][2]);
    ([angle, spin], simulation.counts().steps)
}

#[test]
fn the_angle_of_a_free_rotor_follows_the_accuracy_at_any_longest_step() {
    for corrector in [Corrector::Newton, Corrector::Pece, Corrector::Auto] {
        for (arm, speed) in [(0.1, 100.0), (0.01, 1000.0), (1.0, 10.0), (0.1, -30.0)] {
            for accuracy in [1e-5, 1e-6, 1e-7, 1e-9] {
                for max_step in [0.1, 1e-2, 1e-3] {
                    let control = StepControl {
                        accuracy,
                        max_step,
                        corrector,
                        ..StepControl::default()
                    };
                    let ([angle, spin], steps) = turned(&spinning(arm, speed), control);
                    // Each step may be off by the accuracy along the rim and by as much times the speed in its rate, which then
                    // runs for half of the second on the mean.
                    let steps = steps as f64;
                    let rate = accuracy * steps * speed.abs();
                    let bound = accuracy * steps + 0.5 * rate;
                    let off = arm * (angle - speed).abs();
                    let place = format!("{corrector:?} {arm} {speed} {accuracy:e} {max_step:e}");
                    assert!(off < bound, "{place}: {off:e} of {bound:e} m");
                    let off = arm * (spin - speed).abs();
                    assert!(off < rate, "{place}: {off:e} of {rate:e} m/s");
                }
            }
        }
    }
}

#[test]
fn newtons_method_in_long_steps_keeps_the_turns_that_short_steps_make() {
    let control = |accuracy, max_step| StepControl {
        accuracy,
        max_step,
        corrector: Corrector::Newton,
        ..StepControl::default()
    };
    let ([short, _], _) = turned(&spinning(0.1, 100.0), control(1e-9, 1e-4));
    let ([long, _], _) = turned(&spinning(0.1, 100.0), control(1e-7, 1e-2));
    // 2.2e-4 rad; where coordinates do not follow the projected velocities it is 0.36.
    assert!((long - short).abs() < 2e-3, "{long} {short}");
}
