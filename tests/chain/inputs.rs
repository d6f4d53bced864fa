//! Speeds and torques set while a drive runs.

use crate::common;
use crate::common::{advance, control, energies, paper_drive, simulation, tensioner};
use rustchain::drive::InputQuantity as Quantity;
use rustchain::drive::{Drive, SprocketMotion};
use rustchain::integrator::StepControl;
use rustchain::math::Table;
use rustchain::{ForceLaws, Simulation, Snapshot};

const DRIVER: usize = 0;
const DRIVEN: usize = 1;
const SPEED: f64 = 4.0 * std::f64::consts::PI;

fn tight() -> Drive {
    Drive {
        tensioner: Some(tensioner(100.0, 1e-3)),
        ..paper_drive()
    }
}

fn run_of(drive: &Drive, control: StepControl) -> Simulation {
    simulation(drive, &ForceLaws::default(), control)
}

fn spin(simulation: &Simulation, sprocket: usize) -> f64 {
    simulation.motion().spin[simulation.model().links + sprocket]
}

fn angle(simulation: &Simulation, sprocket: usize) -> f64 {
    simulation.motion().angle[simulation.model().links + sprocket]
}

#[test]
fn setting_what_holds_already_changes_no_bit() {
    let mut run = run_of(&tight(), StepControl::default());
    advance(&mut run, 5e-3);
    let before = run.snapshot().to_bytes().unwrap();
    run.set_input(DRIVER, Quantity::Speed, SPEED.into())
        .unwrap();
    run.set_input(DRIVEN, Quantity::Torque, 0.0.into()).unwrap();
    assert_eq!(run.snapshot().to_bytes().unwrap(), before);
}

#[test]
fn a_sprocket_goes_on_from_its_angle_at_the_speed_that_is_set() {
    let mut run = run_of(&paper_drive(), StepControl::default());
    advance(&mut run, 2e-3);
    let start = angle(&run, DRIVER);
    run.set_input(DRIVER, Quantity::Speed, 10.0.into()).unwrap();
    assert!((angle(&run, DRIVER) - start).abs() < 1e-14);
    assert_eq!(spin(&run, DRIVER), 10.0);
    advance(&mut run, 3e-3);
    // Rows that lie in the past count for what they are now.
    let ramp = Table::new("speed", "rad/s", &[(0.0, 7.0), (4e-3, 11.0)]).unwrap();
    run.set_input(DRIVER, Quantity::Speed, ramp.into()).unwrap();
    assert!((spin(&run, DRIVER) - 10.0).abs() < 1e-13);
    advance(&mut run, 4e-3);
    assert!((spin(&run, DRIVER) - 11.0).abs() < 1e-13);
    let turned = 10.0 * 1e-3 + 10.5 * 1e-3;
    assert!((angle(&run, DRIVER) - start - turned).abs() < 1e-13);
}

#[test]
fn a_torque_that_is_set_does_what_the_same_step_in_a_table_does() {
    let (set_at, torque, end) = (2.3456e-3, -0.8, 3.5e-3);
    for control in [control(1e-10), StepControl::default()] {
        let mut run = run_of(&paper_drive(), control);
        advance(&mut run, set_at);
        run.set_input(DRIVEN, Quantity::Torque, torque.into())
            .unwrap();
        advance(&mut run, end);

        let rows = [(set_at - 1e-9, 0.0), (set_at, torque)];
        let mut drive = paper_drive();
        drive.sprockets[DRIVEN].motion =
            SprocketMotion::AppliedTorque(Table::new("torque", "N m", &rows).unwrap().into());
        let mut described = run_of(&drive, control);
        advance(&mut described, end);
        let (set, described) = (run.motion().positions(), described.motion().positions());
        let apart = set.iter().flatten().zip(described.iter().flatten());
        let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The torque moves the sprocket by 1e-3 rad meanwhile.
        assert!(apart < 2e-7, "{apart:e}");
    }
}

#[test]
fn changes_that_are_none_leave_path_contacts_and_balance() {
    // A pN m, on and off every 37 µs, wherever that lies in a step.
    let (times, every, begin) = (60, 3.7e-5, 4e-3);
    let end = begin + f64::from(times) * every;
    let drive = tight();
    let mut plain = run_of(&drive, control(1e-9));
    advance(&mut plain, end);
    let mut run = run_of(&drive, control(1e-9));
    advance(&mut run, begin);
    for i in 0..times {
        let torque = if i % 2 == 0 { 1e-12 } else { 0.0 };
        run.set_input(DRIVEN, Quantity::Torque, torque.into())
            .unwrap();
        let depths = run.present().evaluated.hinges.penetration.clone();
        let speeds = run.dynamics().memory.hinge_impact_velocity();
        for (k, (depth, speed)) in depths.iter().zip(speeds).enumerate() {
            assert_eq!(*depth > 0.0, *speed > 0.0, "hinge {} after {i}", k + 1);
        }
        let now = run.time();
        advance(&mut run, now + every);
    }
    let pairs = run.motion().positions();
    let apart = pairs.iter().flatten().zip(
        plain
            .motion()
            .positions()
            .into_iter()
            .flatten()
            .collect::<Vec<_>>(),
    );
    let apart = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart:e}");
    let onsets = [&run, &plain].map(|run| run.statistics().onsets);
    assert!(onsets[1] > 100);
    assert!(onsets[0].abs_diff(onsets[1]) <= 3, "{onsets:?}");
}

#[test]
fn the_energy_balance_goes_on_over_jumps_of_speed_and_torque() {
    let mut run = run_of(&paper_drive(), control(1e-8));
    // One recording over all changes: reports go on whoever sets what between them.
    run.start_recording(
        8e-3,
        1e-4,
        rustchain::Groups {
            energy: true,
            ..rustchain::Groups::default()
        },
    );
    run.pause_at_reports();
    let mut reports = 0u32;
    while !run.record(std::time::Duration::MAX).unwrap() {
        reports += 1;
        if reports.is_multiple_of(7) {
            let up = reports.is_multiple_of(2);
            let speed = if up { 13.0 } else { SPEED };
            run.set_input(DRIVER, Quantity::Speed, speed.into())
                .unwrap();
            let torque = if up { -0.4 } else { 0.3 };
            run.set_input(DRIVEN, Quantity::Torque, torque.into())
                .unwrap();
        }
    }
    assert_eq!(reports, 81);
    let energy = common::energies_of(&run.take_recording());
    let residual = energy.largest_residual();
    let external_work = energy.external_work.last().unwrap().abs();
    assert!(external_work > 1e-3, "{external_work:e}");
    assert!(
        residual < 1e-3 * external_work,
        "{residual:e} of {external_work:e}"
    );
}

#[test]
fn a_state_after_a_change_goes_on_alike_in_a_simulation_of_the_drive_as_it_was() {
    for control in [control(1e-6), StepControl::default()] {
        let mut run = run_of(&tight(), control);
        advance(&mut run, 4.000_001e-3);
        run.set_input(DRIVER, Quantity::Speed, 12.0.into()).unwrap();
        run.set_input(DRIVEN, Quantity::Torque, (-1.0).into())
            .unwrap();
        for further in [0.0, 1e-4, 1e-3] {
            let now = run.time();
            advance(&mut run, now + further);
            let bytes = run.snapshot().to_bytes().unwrap();
            let mut other = run_of(&tight(), control);
            other
                .restore(&Snapshot::from_bytes(&bytes).unwrap())
                .unwrap();
            assert_eq!(other.snapshot().to_bytes().unwrap(), bytes);
            let mut one = run.clone();
            let end = one.time() + 5e-4;
            for run in [&mut one, &mut other] {
                energies(run, 2e-4, 1e-5);
                advance(run, end);
            }
            let bytes = [one, other].map(|run| run.snapshot().to_bytes().unwrap());
            assert!(bytes[0] == bytes[1], "{further} s after the change");
        }
        // What was set is no other drive: going back to the start takes it away.
        let start = run_of(&tight(), control).snapshot();
        run.restore(&start).unwrap();
        assert!((spin(&run, DRIVER) - SPEED).abs() < 1e-12);
    }
}

#[test]
fn what_a_sprocket_does_not_have_is_refused_by_name() {
    let mut run = run_of(&paper_drive(), StepControl::default());
    advance(&mut run, 1e-3);
    let before = run.snapshot().to_bytes().unwrap();
    for (sprocket, quantity, text) in [
        (
            2,
            Quantity::Speed,
            "sprocket_3: is not a sprocket of this drive",
        ),
        (
            0,
            Quantity::Torque,
            "sprocket_1: turns at a prescribed speed",
        ),
        (
            1,
            Quantity::Speed,
            "sprocket_2: has a speed that follows from torque and chain",
        ),
    ] {
        let error = run.set_input(sprocket, quantity, 1.0.into()).unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
    }
    assert_eq!(run.snapshot().to_bytes().unwrap(), before);
}
