//! Friction of contacts and of pins, and lubricant in clearance joints, against closed-form answers.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::mechanisms::{
    GRAVITY, Rows, bar, bar_chain, control, ground, record, revolute, simulation,
};
use rustchain::force_law::{Film, Friction, LuGre, Regularization};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, StepControl};
use rustchain::math::Signal;
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, ForceElement, ForceKind, FrictionLaw, Joint, JointKind, Marker,
    Mechanism, MechanismDynamics, MechanismModel, PinFriction, PrescribedMotion, Profile,
    Tribology,
};
use rustchain::run::MechanismSimulation;

fn coulomb(coefficient: f64, speed: f64) -> Friction {
    Friction {
        coefficient,
        regularization: Regularization::Tanh,
        speed,
        dead_speed: 0.0,
    }
}

fn bristles(coefficient: f64) -> LuGre {
    LuGre {
        static_coefficient: coefficient,
        kinetic_coefficient: coefficient,
        stiffness: 1e5,
        damping: 10.0,
        viscous_coefficient: 0.0,
        stribeck_speed: 1e-3,
        stribeck_exponent: 2.0,
    }
}

/// A block of 1 kg on two feet on the x axis; gravity is turned by the slope's angle \[rad\].
fn incline(angle: f64, friction: FrictionLaw) -> Mechanism {
    let (radius, height, stiffness) = (0.02, 0.05, 1e6);
    let depth = 0.5 * GRAVITY * angle.cos() / stiffness;
    let floor = Profile::polyline(
        "floor",
        &[Vec2::new(20.0, 0.0), Vec2::new(-20.0, 0.0)],
        false,
    );
    let floor = floor.unwrap();
    let foot = |name: &str, x: f64| ContactPair {
        name: name.into(),
        a: ground(0.0, 0.0),
        b: Marker::new("block", x, -height),
        profile: floor.clone(),
        radius,
        law: ContactLaw::Linear {
            stiffness,
            damping: 500.0,
        },
        tribology: Tribology {
            friction: Some(friction),
            film: None,
        },
    };
    Mechanism {
        gravity: GRAVITY * Vec2::new(angle.sin(), -angle.cos()),
        bodies: vec![Body::new("block", 1.0, 0.01).at(0.0, height + radius - depth, 0.0)],
        contacts: vec![foot("rear", -0.2), foot("front", 0.2)],
        ..Mechanism::default()
    }
}

fn run(mechanism: &Mechanism, corrector: Corrector) -> MechanismSimulation {
    let how = StepControl {
        corrector,
        max_step: 1e-3,
        ..StepControl::default()
    };
    let model = Arc::new(MechanismModel::compile(mechanism).unwrap());
    MechanismSimulation::assemble(model, how).unwrap()
}

#[test]
fn a_block_on_an_incline_with_bristles_sticks_below_the_friction_angle_and_slides_above_it() {
    let mu: f64 = 0.3;
    let law = bristles(mu);
    for corrector in [Corrector::Auto, Corrector::Newton] {
        for part in [0.5, 0.95] {
            let mut run = run(
                &incline((part * mu).atan(), FrictionLaw::LuGre(law)),
                corrector,
            );
            let found = record(&mut run, 1.0, 0.5);
            let [half, end] = [1, 2].map(|i| found.positions()[3 * i]);
            // From unbent bristles it starts with a jerk, which breaks it away for a moment at 0.95.
            assert!(half < 1e-4, "{part}: {half:e}");
            // Vibration left of the start shakes them loose by so much; tanh of 1e-3 m/s would creep 1e-3 m at 0.95.
            assert!((end - half).abs() < 1e-6, "{part}: {:e}", end - half);
        }
        let angle = (1.5 * mu).atan();
        let mut run = run(&incline(angle, FrictionLaw::LuGre(law)), corrector);
        let found = record(&mut run, 1.0, 0.5);
        let acceleration = (found.velocities()[6] - found.velocities()[3]) / 0.5;
        let expected = GRAVITY * (angle.sin() - mu * angle.cos());
        assert!(
            (acceleration / expected - 1.0).abs() < 1e-5,
            "{acceleration} {expected}"
        );
    }
}

#[test]
fn a_block_on_an_incline_with_coulomb_friction_creeps_at_the_speed_of_its_regularisation() {
    let (mu, speed): (f64, f64) = (0.3, 1e-3);
    let law = FrictionLaw::Coulomb(coulomb(mu, speed));
    let part: f64 = 0.8;
    let mut below = run(&incline((part * mu).atan(), law), Corrector::Auto);
    let found = record(&mut below, 0.5, 0.25);
    let creep = found.velocities()[6];
    assert!(
        (creep / (speed * part.atanh()) - 1.0).abs() < 1e-5,
        "{creep:e}"
    );
    let angle = (1.5 * mu).atan();
    let mut above = run(&incline(angle, law), Corrector::Auto);
    let found = record(&mut above, 0.5, 0.25);
    let acceleration = (found.velocities()[6] - found.velocities()[3]) / 0.25;
    let expected = GRAVITY * (angle.sin() - mu * angle.cos());
    assert!(
        (acceleration / expected - 1.0).abs() < 1e-5,
        "{acceleration} {expected}"
    );
    assert!(found.energy()[11] > 0.0 || found.energy()[15] > 0.0);
}

#[test]
fn energy_of_a_block_that_sticks_and_one_that_slides_is_balanced() {
    for law in [
        FrictionLaw::LuGre(bristles(0.3)),
        FrictionLaw::Coulomb(coulomb(0.3, 1e-3)),
    ] {
        for part in [0.8, 1.5f64] {
            // The implicit corrector, with which closed contacts start, has a residual of 3e-8 J at the default accuracy.
            let how = StepControl {
                corrector: Corrector::Auto,
                max_step: 1e-3,
                accuracy: 1e-12,
                ..StepControl::default()
            };
            let incline = incline((part * 0.3).atan(), law);
            let model = Arc::new(MechanismModel::compile(&incline).unwrap());
            let mut run = MechanismSimulation::assemble(model, how).unwrap();
            let found = record(&mut run, 0.2, 0.02);
            let last = &found.energy()[found.energy().len() - 6..];
            let moved = GRAVITY * found.positions()[found.positions().len() - 3].abs();
            assert!(
                last[5].abs() < 1e-5 * moved.max(1e-5),
                "{law:?} {part}: {last:?}"
            );
        }
    }
}

/// A point mass on a massless arm would have no inertia: a bar of `length` that hangs, turned by `angle`.
fn pendulum(angle: f64, radius: f64, law: Friction) -> Mechanism {
    let tip = Vec2::new(angle.sin(), -angle.cos());
    let joint = revolute("pin", ground(0.0, 0.0), Marker::new("bar", -0.5, 0.0));
    Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        bodies: vec![bar("bar", Vec2::zeros(), tip, 2.0)],
        joints: vec![joint.with_friction(PinFriction { radius, law })],
        ..Mechanism::default()
    }
}

#[test]
fn a_pendulum_with_pin_friction_loses_the_same_angle_in_each_swing() {
    let (start, radius, mu) = (0.01, 0.01, 0.02);
    // Weight at half a metre: a torque of μ r m g takes 2 μ r / 0.5 m off each half swing.
    let loss = 2.0 * mu * radius / 0.5;
    for corrector in [Corrector::Auto, Corrector::Newton, Corrector::Pece] {
        let how = StepControl {
            corrector,
            ..control(1e-9, 1e-3)
        };
        let mechanism = pendulum(start, radius, coulomb(mu, 1e-6));
        let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
        let mut run = MechanismSimulation::assemble(model, how).unwrap();
        let period = 2.0 * PI * (2.0 / 3.0 / GRAVITY).sqrt();
        let swings = 5;
        let found = record(&mut run, (f64::from(swings) + 0.1) * period, 1e-3);
        let angles = found.positions().chunks(3).map(|row| row[2] + 0.5 * PI);
        let angles: Vec<f64> = angles.collect();
        let turns: Vec<f64> = angles
            .windows(3)
            .filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0)
            // The vertex of the parabola through three rows.
            .map(|w| w[1] - (w[2] - w[0]).powi(2) / (8.0 * (w[2] - 2.0 * w[1] + w[0])))
            .collect();
        assert!(turns.len() >= 9, "{turns:?}");
        for (i, turn) in turns.iter().enumerate() {
            let expected = start - loss * (i + 1) as f64;
            assert!(
                (turn.abs() - expected).abs() < 2e-3 * loss * (i + 1) as f64,
                "{corrector:?}, half swing {i}: {} for {expected}",
                turn.abs()
            );
        }
        let last = &found.energy()[found.energy().len() - 6..];
        assert!(last[5].abs() < 1e-4 * last[3], "{last:?}");
    }
}

/// Bars that hang one from another, each pin with friction.
fn rubbing_chain(count: usize, law: Friction, radius: f64) -> Mechanism {
    let mut chain = bar_chain(count, 0.4);
    for joint in &mut chain.joints {
        if joint.kind == JointKind::Revolute {
            joint.friction = Some(PinFriction { radius, law });
        }
    }
    chain
}

#[test]
fn pin_torques_are_those_of_the_reactions_that_they_cause() {
    let law = coulomb(0.3, 0.01);
    let radius = 0.05;
    let mechanism = rubbing_chain(4, law, radius);
    let mut run = simulation(&mechanism, 1e-8);
    let found = record(&mut run, 0.5, 0.1);
    let joints = mechanism.joints.len();
    for (row, velocities) in found.velocities().chunks(12).enumerate().skip(1) {
        for k in 0..joints {
            let [x, y, torque] = [0, 1, 2].map(|i| found.reactions()[3 * (joints * row + k) + i]);
            let before = if k == 0 { 0.0 } else { velocities[3 * k - 1] };
            let spin = velocities[3 * k + 2] - before;
            let expected = -0.3 * radius * x.hypot(y) * law.share(radius * spin).0;
            assert!(
                (torque - expected).abs() < 1e-11 * x.hypot(y),
                "{row} {k}: {torque} for {expected}"
            );
        }
    }
    let last = &found.energy()[found.energy().len() - 6..];
    assert!(last[3] > 0.1 && last[5].abs() < 1e-6 * last[3], "{last:?}");
}

#[test]
fn both_correctors_find_the_same_motion_of_a_chain_with_pin_friction() {
    let mechanism = rubbing_chain(6, coulomb(0.2, 0.01), 0.02);
    let ends = [Corrector::Pece, Corrector::Newton].map(|corrector| {
        let how = StepControl {
            corrector,
            ..control(1e-9, 1e-3)
        };
        let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
        let mut run = MechanismSimulation::assemble(model, how).unwrap();
        let found = record(&mut run, 0.3, 0.3);
        found.positions()[18..].to_vec()
    });
    for (a, b) in ends[0].iter().zip(&ends[1]) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn a_pin_that_locks_itself_ends_the_run_with_its_name_for_it() {
    // μ r is longer than the bar.
    let mechanism = pendulum(1.0, 1.0, coulomb(3.0, 1e-6));
    let mut moving = mechanism.clone();
    moving.bodies[0] = moving.bodies[0].clone().moving(0.5 * 0.54, 0.5 * 0.84, 1.0);
    let model = Arc::new(MechanismModel::compile(&moving).unwrap());
    let how = control(1e-8, 1e-3);
    let mut run = MechanismSimulation::assemble(model, how).unwrap();
    let error = run.advance(1.0, std::time::Duration::MAX).unwrap_err();
    assert!(error.to_string().contains("locks itself"), "{error}");
}

const VISCOSITY: f64 = 0.05;
const LENGTH: f64 = 0.03;
const JOURNAL: f64 = 0.01;
const CLEARANCE: f64 = 2e-5;
const SPIN: f64 = 100.0;

/// A journal in a bore of the ground with a half film, at an eccentricity along x over the clearance; `load` on it.
fn journal(ratio: f64, mass: f64, load: [f64; 2]) -> Mechanism {
    let film = Film {
        viscosity: VISCOSITY,
        length: Some(LENGTH),
        handover: 0.99,
        tension: 0.0,
    };
    Mechanism {
        bodies: vec![
            Body::new("journal", mass, 1e-4)
                .at(ratio * CLEARANCE, 0.0, 0.0)
                .moving(0.0, 0.0, SPIN),
        ],
        joints: vec![Joint::new(
            "motor",
            ground(0.0, 0.0),
            Marker::new("journal", 0.0, 0.0),
            JointKind::DrivenAngle(PrescribedMotion::Speed(Signal::Constant(SPIN))),
        )],
        forces: vec![ForceElement {
            name: "load".into(),
            a: ground(0.0, 0.0),
            b: Marker::new("journal", 0.0, 0.0),
            kind: ForceKind::Force {
                x: Signal::Constant(load[0]),
                y: Signal::Constant(load[1]),
                follows: false,
            },
        }],
        contacts: vec![ContactPair {
            name: "bearing".into(),
            a: ground(0.0, 0.0),
            b: Marker::new("journal", 0.0, 0.0),
            profile: Profile::Bore {
                radius: JOURNAL + CLEARANCE,
            },
            radius: JOURNAL,
            law: ContactLaw::Linear {
                stiffness: 1e8,
                damping: 0.0,
            },
            tribology: Tribology {
                friction: None,
                film: Some(film),
            },
        }],
        ..Mechanism::default()
    }
}

/// Half-Sommerfeld forces of a long bearing on a journal whose centre rests, along its eccentricity and left of it.
fn half_sommerfeld(ratio: f64) -> [f64; 2] {
    let scale = VISCOSITY * SPIN * JOURNAL * LENGTH * (JOURNAL / CLEARANCE).powi(2);
    let rest = 1.0 - ratio * ratio;
    let slant = 2.0 + ratio * ratio;
    [
        -scale * 12.0 * ratio * ratio / (slant * rest),
        scale * 6.0 * PI * ratio / (slant * rest.sqrt()),
    ]
}

#[test]
fn a_journal_has_the_forces_and_the_torque_of_half_sommerfeld() {
    for ratio in [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9] {
        let mechanism = journal(ratio, 1.0, [0.0; 2]);
        let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
        let mut run = MechanismSimulation::assemble(model, control(1e-8, 1e-3)).unwrap();
        let row = run.row();
        let expected = half_sommerfeld(ratio);
        for (found, expected) in row.accelerations().iter().zip(expected) {
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{ratio}: {found} {expected}"
            );
        }
        // Petroff's shear with the eccentricity, and half of the couple of the wedge.
        let shear = 2.0 * PI * VISCOSITY * LENGTH * JOURNAL.powi(3) / CLEARANCE;
        let torque =
            shear * SPIN / (1.0 - ratio * ratio).sqrt() + 0.5 * ratio * CLEARANCE * expected[1];
        assert!((row.reactions()[2] / torque - 1.0).abs() < 1e-12, "{ratio}");
    }
}

#[test]
fn a_light_journal_under_load_comes_to_rest_where_half_sommerfeld_has_it() {
    for ratio in [0.1, 0.5, 0.9] {
        let [along, left] = half_sommerfeld(ratio);
        for corrector in [Corrector::Auto, Corrector::Newton] {
            let how = StepControl {
                corrector,
                ..StepControl::default()
            };
            let mechanism = journal(0.02, 1e-3, [-along, -left]);
            let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
            let mut run = MechanismSimulation::assemble(model, how).unwrap();
            let found = record(&mut run, 1.0, 0.5);
            let [x, y] = [6, 7].map(|i| found.positions()[i] / CLEARANCE);
            assert!(
                (x - ratio).abs() < 1e-3 && y.abs() < 1e-3,
                "{ratio}: {x} {y}"
            );
            let last = &found.energy()[12..];
            assert!(last[5].abs() < 1e-3 * last[3], "{ratio} {last:?}");
        }
    }
}

#[test]
fn friction_and_films_that_mean_nothing_are_refused_with_their_part() {
    let refused =
        |mechanism: &Mechanism| MechanismModel::compile(mechanism).unwrap_err().to_string();
    let mut slope = incline(0.1, FrictionLaw::Coulomb(coulomb(-0.1, 1e-3)));
    let error = refused(&slope);
    assert!(
        error.contains("friction of contact \"rear\".coefficient"),
        "{error}"
    );
    slope = incline(0.1, FrictionLaw::LuGre(bristles(0.3)));
    slope.contacts[0].tribology.film = journal(0.1, 1.0, [0.0; 2]).contacts[0].tribology.film;
    let error = refused(&slope);
    assert!(
        error.contains("film of contact \"rear\"") && error.contains("bore"),
        "{error}"
    );
    let mut bearing = journal(0.1, 1.0, [0.0; 2]);
    if let Some(film) = &mut bearing.contacts[0].tribology.film {
        film.length = None;
    }
    assert!(refused(&bearing).contains("give the film a length"));
    let mut pin = pendulum(0.1, -1.0, coulomb(0.1, 1e-3));
    assert!(refused(&pin).contains("radius of joint \"pin\""));
    pin = pendulum(0.1, 0.01, coulomb(0.1, 1e-3));
    pin.joints[0].kind = JointKind::Fixed { angle: None };
    assert!(refused(&pin).contains("only revolute joints"));
}

#[test]
fn a_friction_evaluation_at_rest_has_no_torque() {
    let mechanism = pendulum(0.3, 0.01, coulomb(0.5, 1e-3));
    let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
    let mut run = MechanismSimulation::assemble(model, control(1e-8, 1e-3)).unwrap();
    let dynamics: &MechanismDynamics = run.present();
    let expected = -1.5 * GRAVITY * (0.3f64).sin();
    assert!((dynamics.accelerations()[2] - expected).abs() < 1e-9);
}
