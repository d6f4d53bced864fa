//! How near the implicit corrector comes to the explicit one on mechanisms: energy of contacts without damping, error by tolerance.

use std::sync::Arc;
use std::time::Duration;

use crate::common::mechanisms::{GRAVITY, Rows, bar_chain, ground, run_to};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, StepControl};
use rustchain::math::Signal;
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, ForceElement, ForceKind, Marker, Mechanism, MechanismGroups,
    MechanismModel, Profile, Tribology,
};
use rustchain::run::MechanismSimulation;

const LINEAR: ContactLaw = ContactLaw::Linear {
    stiffness: 1e7,
    damping: 0.0,
};
const HERTZIAN: ContactLaw = ContactLaw::HuntCrossley {
    stiffness: 1e9,
    exponent: 1.5,
    damping: 0.0,
};

fn simulation(mechanism: &Mechanism, control: StepControl) -> MechanismSimulation {
    let model = Arc::new(MechanismModel::compile(mechanism).unwrap());
    MechanismSimulation::assemble(model, control).unwrap()
}

fn control(accuracy: f64, max_step: f64, corrector: Corrector) -> StepControl {
    StepControl {
        accuracy,
        max_step,
        corrector,
        ..StepControl::default()
    }
}

/// A ball of 1 kg and 0.05 m at a height above a floor.
fn ball(law: ContactLaw, height: f64) -> Mechanism {
    let floor = [Vec2::new(9.0, 0.0), Vec2::new(-9.0, 0.0)];
    Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        bodies: vec![Body::new("ball", 1.0, 1e-3).at(0.0, height, 0.0)],
        contacts: vec![ContactPair {
            name: "floor".into(),
            a: ground(0.0, 0.0),
            b: Marker::new("ball", 0.0, 0.0),
            profile: Profile::polyline("floor", &floor, false).unwrap(),
            radius: 0.05,
            law,
            tribology: Tribology::default(),
        }],
        ..Mechanism::default()
    }
}

/// The ball pressed on the floor by 1000 N, moving about its rest at `speed`: it never leaves the floor.
fn pressed(law: ContactLaw, rest_depth: f64, speed: f64) -> Mechanism {
    let mut mechanism = ball(law, 0.05 - rest_depth);
    mechanism.gravity = Vec2::zeros();
    mechanism.bodies[0].velocity[1] = -speed;
    let press = ForceKind::Force {
        x: Signal::Constant(0.0),
        y: Signal::Constant(-1000.0),
        follows: false,
    };
    let center = Marker::new("ball", 0.0, 0.0);
    let press = ForceElement::new("press", ground(0.0, 0.0), center, press);
    mechanism.forces.push(press);
    mechanism
}

/// Root mean square of what is missing at the ends of runs \[J\].
fn missing(runs: &[Mechanism], control: StepControl, duration: f64) -> f64 {
    let squares = runs.iter().map(|mechanism| {
        let mut machine = simulation(mechanism, control);
        machine.start_recording(duration, 0.1 * duration, MechanismGroups::ALL);
        while !machine.record(Duration::MAX).unwrap() {}
        machine.take_recording().energy().last().unwrap().powi(2)
    });
    (squares.sum::<f64>() / runs.len() as f64).sqrt()
}

#[test]
fn a_vibration_in_a_contact_keeps_its_energy_with_both_correctors() {
    let soft = ContactLaw::Linear {
        stiffness: 1e6,
        damping: 0.0,
    };
    let bent = ContactLaw::HuntCrossley {
        stiffness: 1e7,
        exponent: 1.5,
        damping: 0.0,
    };
    for (law, rest) in [(soft, 1e-3), (bent, 1e-4f64.powf(2.0 / 3.0))] {
        let speeds = (0..6).map(|i| 0.05 * (1.0 + 0.01 * f64::from(i)));
        let runs: Vec<_> = speeds.map(|v| pressed(law.clone(), rest, v)).collect();
        for corrector in [Corrector::Newton, Corrector::Pece, Corrector::Auto] {
            for accuracy in [1e-5, 1e-6, 1e-7] {
                // Steps of 0.1 ms, a sixtieth of a period: none is held by its error.
                let missing = missing(&runs, control(accuracy, 1e-4, corrector), 0.05);
                let part = missing / (0.5 * 0.05 * 0.05);
                assert!(part < 2e-4, "{law:?} {corrector:?} {accuracy:e}: {part:e}");
            }
        }
    }
}

#[test]
fn bounces_without_damping_lose_no_more_than_with_the_explicit_corrector() {
    for law in [LINEAR, HERTZIAN] {
        let heights = (0..12).map(|i| 0.15 + 1.3e-3 * f64::from(i));
        let runs: Vec<_> = heights.map(|y| ball(law.clone(), y)).collect();
        for accuracy in [1e-6, 1e-7, 1e-8] {
            let [newton, pece] = [Corrector::Newton, Corrector::Pece]
                .map(|corrector| missing(&runs, control(accuracy, 1e-2, corrector), 0.5));
            // Both a twentieth to twice of what the allowed error of speeds makes of 1 J.
            let place = format!("{law:?} {accuracy:e}: {newton:e} {pece:e}");
            assert!(
                newton < 4.0 * pece && newton < 0.02 * (accuracy / 1e-8),
                "{place}"
            );
        }
    }
}

/// Largest error of a double pendulum's coordinates after 1 s.
fn pendulum_error(reference: &[[f64; 3]], control: StepControl) -> f64 {
    let mut machine = simulation(&bar_chain(2, 0.3), control);
    run_to(&mut machine, 1.0);
    let found = machine.positions().concat();
    let errors = found.iter().zip(reference.as_flattened());
    errors.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_error_of_newtons_method_falls_with_the_tolerance_to_its_last_digits() {
    let mut exact = simulation(&bar_chain(2, 0.3), control(1e-14, 0.05, Corrector::Pece));
    run_to(&mut exact, 1.0);
    let exact = exact.positions();
    // Means over neighbours: single tolerances are lucky at times.
    let mean = |tolerances: [f64; 3], by_component: bool| {
        let logarithms = tolerances.map(|tolerance| {
            let mut control = control(tolerance, 0.05, Corrector::Newton);
            if by_component {
                (control.rtol, control.atol) = (tolerance, tolerance);
            }
            pendulum_error(&exact, control).log10()
        });
        logarithms.iter().sum::<f64>() / 3.0
    };
    for (by_component, decades) in [(false, 6.0), (true, 6.5)] {
        let loose = mean([1e-4, 3e-5, 1e-5], by_component);
        let tight = mean([1e-11, 3e-12, 1e-12], by_component);
        assert!(loose - tight > decades, "{by_component}: {loose} {tight}");
    }
}
