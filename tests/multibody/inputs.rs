//! Speeds of drivers and torques set while a mechanism runs.

use std::time::Duration;

use super::clearance::machine;
use crate::common::mechanisms::{CRANK, ROD, ground, revolute, run_to, simulation, slider_crank};
use rustchain::Snapshot;
use rustchain::drive::InputQuantity::{self, Speed, Torque};
use rustchain::force_law::Elastic;
use rustchain::geometry::Vec2;
use rustchain::math::{Signal, Table};
use rustchain::multibody::{
    Body, ForceElement, ForceKind, Joint, JointKind, Marker, Mechanism, MechanismGroups,
    PrescribedMotion,
};
use rustchain::run::MechanismSimulation;

const INERTIA: f64 = 0.02;

fn shaft() -> Marker {
    Marker::new("wheel", 0.0, 0.0)
}

/// A flywheel on a bearing, turned by a torque "motor".
fn flywheel(torque: impl Into<Signal>) -> Mechanism {
    let kind = ForceKind::Torque(torque.into());
    Mechanism {
        gravity: Vec2::zeros(),
        bodies: vec![Body::new("wheel", 1.0, INERTIA)],
        joints: vec![revolute("bearing", ground(0.0, 0.0), shaft())],
        forces: vec![ForceElement::new("motor", ground(0.0, 0.0), shaft(), kind)],
        ..Mechanism::default()
    }
}

fn driver(name: &str, motion: PrescribedMotion) -> Joint {
    let kind = JointKind::DrivenAngle(motion);
    Joint::new(name, ground(0.0, 0.0), shaft(), kind)
}

fn rows(rows: &[(f64, f64)]) -> Signal {
    Table::new("rows", "1", rows).unwrap().into()
}

fn bytes(run: &MechanismSimulation) -> Vec<u8> {
    run.snapshot().to_bytes().unwrap()
}

/// Run to `duration` with one recording; `set` is called at every report, with its number. Return the energies at its end: kinetic,
/// external work and the largest residual.
fn recorded(
    run: &mut MechanismSimulation,
    duration: f64,
    mut set: impl FnMut(&mut MechanismSimulation, u32),
) -> [f64; 3] {
    run.start_recording(duration, 0.01 * duration, MechanismGroups::ALL);
    run.pause_at_reports();
    let mut reports = 0;
    while !run.record(Duration::MAX).unwrap() {
        set(run, reports);
        reports += 1;
    }
    assert_eq!(reports, 101);
    let recording = run.take_recording();
    let last = |name: &str| *recording.real(name).last().unwrap();
    let residual = recording.real("energy_residual").iter();
    [
        last("energy_kinetic"),
        last("energy_external_work"),
        residual.fold(0.0, |most, r| r.abs().max(most)),
    ]
}

#[test]
fn a_flywheel_turns_as_the_integral_of_the_torques_that_are_set() {
    // Torque 0.3 until 0.123 s, then 0.7, from 0.2 s on a ramp from 0.7 to -0.5 within 0.1 s.
    let mut run = simulation(&flywheel(0.3), 1e-10);
    run_to(&mut run, 0.123);
    run.set_input("motor", Torque, 0.7.into()).unwrap();
    run_to(&mut run, 0.2);
    let impulse = 0.3 * 0.123 + 0.7 * 0.077;
    assert!((run.velocities()[0][2] - impulse / INERTIA).abs() < 1e-9);
    run.set_input("motor", Torque, rows(&[(0.2, 0.7), (0.3, -0.5)]))
        .unwrap();
    run_to(&mut run, 0.4);
    let impulse = impulse + 0.1 * 0.1 - 0.5 * 0.1;
    assert!((run.velocities()[0][2] - impulse / INERTIA).abs() < 1e-9);
}

#[test]
fn the_work_of_torques_set_at_reports_is_the_kinetic_energy() {
    let mut run = simulation(&flywheel(0.0), 1e-9);
    let [kinetic, work, residual] = recorded(&mut run, 0.5, |run, report| {
        let torque = 0.2 * f64::from(report % 7) - 0.5;
        run.set_input("motor", Torque, torque.into()).unwrap();
    });
    assert!(kinetic > 1e-3, "{kinetic}");
    assert!((kinetic - work).abs() < 1e-9 * kinetic, "{kinetic} {work}");
    assert!(residual < 1e-9 * kinetic);
}

#[test]
fn a_crank_goes_on_from_its_angle_at_the_speed_that_is_set_and_the_slider_with_it() {
    let mut run = simulation(&slider_crank(10.0), 1e-9);
    run_to(&mut run, 0.0371);
    let before = run.positions();
    run.set_input("motor", Speed, 25.0.into()).unwrap();
    let after = run.positions();
    for (before, after) in before.iter().flatten().zip(after.iter().flatten()) {
        assert!((before - after).abs() < 1e-13);
    }
    let slider = |run: &mut MechanismSimulation, angle: f64, speed: f64| {
        // x = r cos θ + √(l² - r² sin² θ).
        let across = CRANK * angle.sin();
        let along = (ROD * ROD - across * across).sqrt();
        let place = CRANK * angle.cos() + along;
        let rate = -speed * across * (1.0 + CRANK * angle.cos() / along);
        let (found, found_rate) = (run.positions()[2][0], run.velocities()[2][0]);
        assert!((found - place).abs() < 1e-12, "{found} {place}");
        assert!((found_rate - rate).abs() < 1e-10, "{found_rate} {rate}");
    };
    slider(&mut run, 0.371, 25.0);
    run_to(&mut run, 0.05);
    let angle = 0.371 + 25.0 * (0.05 - 0.0371);
    slider(&mut run, angle, 25.0);
    // Rows that lie in the past count for what they are now.
    run.set_input("motor", Speed, rows(&[(0.0, 25.0), (0.1, 35.0)]))
        .unwrap();
    slider(&mut run, angle, 30.0);
    run_to(&mut run, 0.1);
    slider(&mut run, angle + 0.05 * 32.5, 35.0);
}

#[test]
fn the_impulse_of_a_jump_of_the_speed_works_as_much_as_the_kinetic_energy_changes() {
    let mut run = simulation(&slider_crank(10.0), 1e-9);
    let mut largest_jump = 0.0f64;
    let [_, _, residual] = recorded(&mut run, 0.5, |run, report| {
        let kinetic = |run: &mut MechanismSimulation| run.row().real("energy_kinetic")[0];
        let before = kinetic(run);
        let speed = 10.0 + 3.0 * f64::from(report % 5);
        run.set_input("motor", Speed, speed.into()).unwrap();
        largest_jump = largest_jump.max((kinetic(run) - before).abs());
    });
    assert!(largest_jump > 0.01, "{largest_jump}");
    assert!(residual < 1e-8 * largest_jump, "{residual} {largest_jump}");
}

#[test]
fn a_torque_that_is_set_does_what_the_same_step_in_a_table_does() {
    // Impacts in the clearance of the wrist pin amplify the errors of the steps, which fall with the tolerance.
    for (tolerance, bound) in [(1e-9, 1e-2), (1e-12, 2e-5)] {
        let (set_at, end) = (1.234_567e-3, 4e-3);
        let pushed = |torque: Signal| {
            let mut mechanism = machine(1e-4, Elastic::Hertz);
            let kind = ForceKind::Torque(torque);
            let rod = Marker::new("rod", 0.0, 0.0);
            let torque = ForceElement::new("torque", ground(0.0, 0.0), rod, kind);
            mechanism.forces.push(torque);
            simulation(&mechanism, tolerance)
        };
        let mut set = pushed(0.0.into());
        run_to(&mut set, set_at);
        set.set_input("torque", Torque, 2.0.into()).unwrap();
        let mut described = pushed(rows(&[(set_at - 1e-10, 0.0), (set_at, 2.0)]));
        let mut without = pushed(0.0.into());
        let [set, described, without] = [&mut set, &mut described, &mut without].map(|run| {
            run_to(run, end);
            run.positions()
        });
        let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            let apart = a.iter().flatten().zip(b.iter().flatten());
            apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let (moved, error) = (apart(&set, &without), apart(&set, &described));
        assert!(moved > 1e-6, "{moved:e}");
        assert!(
            error < bound * moved,
            "{tolerance:e}: {error:e} of {moved:e}"
        );
    }
}

#[test]
fn changes_that_are_none_leave_path_and_onsets() {
    // A pN m, on and off every 37 µs, wherever that lies in a step and in an impact.
    let mut mechanism = machine(1e-4, Elastic::Hertz);
    let rod = Marker::new("rod", 0.0, 0.0);
    let kind = ForceKind::Torque(0.0.into());
    mechanism.forces = vec![ForceElement::new("none", ground(0.0, 0.0), rod, kind)];
    let (times, every) = (100, 3.7e-5);
    let end = f64::from(times) * every;
    let mut plain = simulation(&mechanism, 1e-10);
    run_to(&mut plain, end);
    let mut run = simulation(&mechanism, 1e-10);
    for i in 0..times {
        run_to(&mut run, f64::from(i) * every);
        let torque = if i % 2 == 0 { 1e-12 } else { 0.0 };
        run.set_input("none", Torque, torque.into()).unwrap();
    }
    run_to(&mut run, end);
    let (set, free) = (run.positions(), plain.positions());
    let apart = set.iter().flatten().zip(free.iter().flatten());
    let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-7, "{apart:e}");
    assert!(
        plain.statistics().onsets >= 3,
        "{}",
        plain.statistics().onsets
    );
    assert_eq!(run.statistics().onsets, plain.statistics().onsets);
}

#[test]
fn a_state_after_a_change_goes_on_alike_in_a_simulation_of_the_mechanism_as_it_was() {
    let mechanism = machine(1e-4, Elastic::Hertz);
    let mut run = simulation(&mechanism, 1e-8);
    run_to(&mut run, 2.000_1e-3);
    run.set_input("motor", Speed, 600.0.into()).unwrap();
    for further in [0.0, 1e-4, 1e-3] {
        let now = run.time();
        run_to(&mut run, now + further);
        let state = bytes(&run);
        let mut other = simulation(&mechanism, 1e-8);
        other
            .restore(&Snapshot::from_bytes(&state).unwrap())
            .unwrap();
        assert!(bytes(&other) == state);
        let mut one = run.clone();
        let states = [&mut one, &mut other].map(|run| {
            recorded(run, 5e-4, |_, _| ());
            bytes(run)
        });
        assert!(states[0] == states[1], "{further} s after the change");
    }
    // Going back to the start takes the change away.
    let start = simulation(&mechanism, 1e-8).snapshot();
    let before = run.velocities()[0][2];
    run.restore(&start).unwrap();
    assert!((run.velocities()[0][2] - before).abs() > 50.0);
}

#[test]
fn an_input_that_holds_already_changes_no_bit() {
    let mut run = simulation(&flywheel(0.3), 1e-9);
    run_to(&mut run, 0.1);
    let before = bytes(&run);
    run.set_input("motor", Torque, 0.3.into()).unwrap();
    assert!(bytes(&run) == before);
}

#[test]
fn what_cannot_be_set_is_refused_by_name_and_nothing_is_changed() {
    let mut mechanism = flywheel(0.3);
    mechanism.bodies.push(Body::new("other", 1.0, INERTIA));
    let other = || Marker::new("other", 0.0, 0.0);
    let gear = JointKind::Gear {
        ratio: -2.0,
        carrier: None,
    };
    let curve = Table::new("curve", "N m", &[(0.0, 1.0), (9.0, 0.0)]).unwrap();
    mechanism.joints.extend([
        driver("speed", PrescribedMotion::Speed(4.0.into())),
        revolute("pin", ground(1.0, 0.0), other()),
        Joint::new("gear", shaft(), other(), gear),
        Joint::new(
            "geared",
            ground(0.0, 0.0),
            other(),
            JointKind::DrivenAngle(PrescribedMotion::Speed((-8.0).into())),
        ),
    ]);
    mechanism.forces.push(ForceElement::new(
        "curve",
        ground(0.0, 0.0),
        other(),
        ForceKind::TorqueBySpeed(curve),
    ));
    let mut run = simulation(&mechanism, 1e-9);
    run_to(&mut run, 0.1);
    let before = bytes(&run);
    let refused = |run: &mut MechanismSimulation, name, quantity: InputQuantity, value: f64| {
        run.set_input(name, quantity, value.into())
            .unwrap_err()
            .to_string()
    };
    for (name, quantity, value, text) in [
        ("spede", Speed, 1.0, "there are \"speed\", \"geared\""),
        ("bearing", Speed, 1.0, "a joint without prescribed motion"),
        ("moter", Torque, 1.0, "there are \"motor\""),
        ("curve", Torque, 1.0, "another kind of force element"),
        ("motor", Torque, f64::NAN, "torque of \"motor\""),
        (
            "speed",
            Speed,
            5.0,
            "that the other joints and drivers permit",
        ),
    ] {
        let found = refused(&mut run, name, quantity, value);
        assert!(found.contains(text), "{found}");
        assert!(bytes(&run) == before, "{name}");
    }
    let mut placed = flywheel(0.0);
    let turn = Signal::Sines {
        offset: 0.0,
        terms: vec![[0.1, 3.0, 0.0]],
    };
    placed
        .joints
        .push(driver("angle", PrescribedMotion::Position(turn)));
    let found = refused(&mut simulation(&placed, 1e-9), "angle", Speed, 1.0);
    assert!(found.contains("prescribes a coordinate"), "{found}");
}
