//! Functions of time in place of constants: speeds, torques and velocities of ends against their closed integrals.

use crate::common::open::strand;
use crate::common::{advance, control, paper_drive, simulation};
use rustchain::drive::{ChainEnd, Drive, SprocketMotion};
use rustchain::geometry::Vec2;
use rustchain::integrator::StepControl;
use rustchain::math::{Signal, Spline, Table};
use rustchain::{ForceLaws, Simulation};

const SPEED: f64 = 12.566;
const END: f64 = 4e-3;

/// Signals, and their integrals from 0 to [`END`] by hand.
fn signals() -> Vec<(Signal, f64)> {
    let (amplitude, frequency, phase) = (2.0, 3000.0, 0.4);
    // The natural spline through (0, s), (h, s + a) and (2 h, s) has the second derivative -3 a/h² in the middle, and
    // 5/8 a h below each half of its arch.
    let (rise, h) = (1.5, 0.5 * END);
    let arch = [(0.0, SPEED), (h, SPEED + rise), (END, SPEED)];
    vec![
        (
            Signal::Sines {
                offset: SPEED,
                terms: vec![[amplitude, frequency, phase]],
            },
            SPEED * END
                + amplitude / frequency * (f64::cos(phase) - f64::cos(frequency * END + phase)),
        ),
        (
            // Half a smooth step's rise goes by while it rises.
            Signal::SmoothStep {
                start: 1e-3,
                end: 1.8e-3,
                from: SPEED,
                to: SPEED + 2.0,
            },
            SPEED * END + 2.0 * (0.5 * 0.8e-3 + END - 1.8e-3),
        ),
        (
            Signal::Spline(Spline::new("speed", "rad/s", &arch).unwrap()),
            SPEED * END + 2.0 * 0.625 * rise * h,
        ),
        (
            Table::new("speed", "rad/s", &arch).unwrap().into(),
            SPEED * END + rise * h,
        ),
    ]
}

fn driven(speed: Signal) -> Drive {
    let mut drive = paper_drive();
    drive.sprockets[0].motion = SprocketMotion::PrescribedSpeed(speed);
    drive
}

fn run_of(drive: &Drive, control: StepControl) -> Simulation {
    simulation(drive, &ForceLaws::default(), control)
}

#[test]
fn a_sprocket_turns_by_the_integral_of_its_speed() {
    for (signal, turned) in signals() {
        for control in [control(1e-8), StepControl::default()] {
            let mut run = run_of(&driven(signal.clone()), control);
            let wheel = run.model().links;
            let start = run.motion().angle[wheel];
            advance(&mut run, END);
            let motion = run.motion();
            let missed = motion.angle[wheel] - start - turned;
            assert!(missed.abs() < 1e-14, "{signal:?}: {missed:e}");
            assert_eq!(motion.spin[wheel], signal.value(END));
        }
    }
}

#[test]
fn a_drive_follows_sines_as_the_limit_of_ever_finer_tables() {
    let (waves, _) = signals().swap_remove(0);
    let end = 2e-3;
    let places = |speed: Signal| {
        let mut run = run_of(&driven(speed), control(1e-11));
        advance(&mut run, end);
        run.motion().positions()
    };
    let exact = places(waves.clone());
    let apart = [10_u32, 20, 40].map(|count| {
        let row = |k: u32| {
            let t = end * f64::from(k) / f64::from(count);
            (t, waves.value(t))
        };
        let rows: Vec<(f64, f64)> = (0..=count).map(row).collect();
        let table = Table::new("speed", "rad/s", &rows).unwrap();
        let found = places(table.into());
        let pairs = found.iter().flatten().zip(exact.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    });
    // Straight lines between rows h apart miss speeds by h²/8 of their second derivative: a quarter for half of h.
    for pair in apart.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((3.0..5.5).contains(&ratio), "{apart:?}");
    }
    assert!(apart[0] > 1e-8, "{apart:?}");
}

#[test]
fn an_anchor_goes_where_a_velocity_of_any_signal_takes_it() {
    let (speed, frequency) = (0.3, 700.0);
    let x = Signal::Sines {
        offset: 0.0,
        terms: vec![[speed, frequency, 0.0]],
    };
    let y = Signal::SmoothStep {
        start: 5e-3,
        end: 0.015,
        from: 0.0,
        to: 0.2,
    };
    let anchor = ChainEnd::Anchored {
        position: Vec2::new(0.1, 0.2),
        velocity: [x, y],
        links: None,
    };
    let drive = strand(15, [anchor, ChainEnd::loaded(0.2, 1e-5)]);
    let end = 0.04;
    let moved = speed / frequency * (1.0 - f64::cos(frequency * end));
    let expected = Vec2::new(0.1 + moved, 0.2 + 0.2 * (end - 0.01));
    for control in [control(1e-7), StepControl::default()] {
        let mut run = run_of(&drive, control);
        advance(&mut run, end);
        let motion = &run.present().evaluated.motion;
        // What one step misses: the anchor is put in its place before the next one.
        let missed = (Vec2::new(motion.x[16], motion.y[16]) - expected).norm();
        assert!(missed < 1e-9, "{missed:e}");
        let missed = motion.vx[16] - speed * f64::sin(frequency * end);
        assert!(missed.abs() < 1e-5, "{missed:e}");
    }
}

#[test]
fn a_pulse_of_torque_within_a_step_is_followed() {
    // 20 µs of 50 N m on a heavy sprocket: what it gains is the integral over the inertia.
    let rows: Vec<(f64, f64)> = (0..=30_u32)
        .map(|k| (f64::from(k) * 1e-5, if k == 11 { 50.0 } else { 0.0 }))
        .collect();
    let pulse = Signal::Spline(Spline::new("torque", "N m", &rows).unwrap());
    let kick = pulse.integral(2e-4);
    let spin_under = |torque: Signal| {
        let mut drive = paper_drive();
        drive.sprockets[1].motion = SprocketMotion::AppliedTorque(torque);
        drive.sprockets[1].load_inertia = 1.0;
        let mut run = run_of(&drive, StepControl::default());
        advance(&mut run, 2e-4);
        run.motion().spin[run.model().links + 1]
    };
    let gained = spin_under(pulse) - spin_under(0.0.into());
    assert!(
        kick > 2e-4 && (gained / kick - 1.0).abs() < 0.02,
        "{gained:e} {kick:e}"
    );
}
