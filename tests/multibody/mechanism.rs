//! Mechanisms with ideal joints against published answers and closed forms.

use crate::common::mechanisms::{
    ANDREWS_END, CRANK, GRAVITY, ROD, Rows, andrews, andrews_angles, bar_chain, four_bars, record,
    run_to, simulation, slider_crank,
};

/// Period of a pendulum by the arithmetic-geometric mean.
fn pendulum_period(amplitude: f64, length: f64) -> f64 {
    let (mut a, mut g) = (1.0f64, (0.5 * amplitude).cos());
    for _ in 0..10 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    2.0 * std::f64::consts::PI * (length / GRAVITY).sqrt() / a
}

#[test]
fn a_pendulum_comes_back_after_its_period() {
    // A bar of 1 m swings as a point at 2/3 m; from level, its amplitude is 90 degrees.
    let period = pendulum_period(std::f64::consts::FRAC_PI_2, 2.0 / 3.0);
    for (tolerance, bound) in [(1e-7, 3e-6), (1e-10, 5e-9)] {
        let mut pendulum = simulation(&bar_chain(1, 0.0), tolerance);
        run_to(&mut pendulum, period);
        let [x, y, angle] = pendulum.positions()[0];
        let error = (x - 0.5).abs().max(y.abs()).max(angle.abs());
        assert!(error < bound, "{tolerance} {error}");
    }
}

#[test]
fn a_pendulum_pulls_at_its_bearing_with_weight_and_centripetal_force() {
    let mut pendulum = simulation(&bar_chain(1, 0.0), 1e-11);
    let recording = record(&mut pendulum, 1.0, 0.01);
    for row in 0..recording.time.len() {
        let angle = recording.positions()[3 * row + 2];
        let spin = recording.velocities()[3 * row + 2];
        // Energy: ω² = -3 g sin θ / l. Along the bar: N = m (ω² l/2 - g sin θ) inwards; across: m g cos θ / 4.
        assert!((spin * spin + 3.0 * GRAVITY * angle.sin()).abs() < 1e-7);
        let inwards = -2.5 * GRAVITY * angle.sin();
        let across = 0.25 * GRAVITY * angle.cos();
        let expected = [
            -inwards * angle.cos() - across * angle.sin(),
            -inwards * angle.sin() + across * angle.cos(),
        ];
        for (axis, expected) in expected.iter().enumerate() {
            let found = recording.reactions()[3 * row + axis];
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert!(recording.reactions()[3 * row + 2].abs() < 1e-12);
    }
}

#[test]
fn a_double_pendulum_keeps_its_energy_as_the_tolerance_asks() {
    for (tolerance, bound) in [(1e-7, 3e-4), (1e-9, 3e-6), (1e-11, 5e-8)] {
        let mut pendulum = simulation(&bar_chain(2, 0.3), tolerance);
        let recording = record(&mut pendulum, 5.0, 0.05);
        let worst = recording
            .energy()
            .chunks(6)
            .map(|row| row[5].abs())
            .fold(0.0, f64::max);
        assert!(worst < bound, "{tolerance} {worst}");
    }
}

#[test]
fn projection_holds_positions_and_velocities_to_round_off() {
    let mut pendulum = simulation(&bar_chain(3, 0.3), 1e-8);
    let mut worst = [0.0f64; 2];
    for k in 1..=200 {
        run_to(&mut pendulum, 0.05 * f64::from(k));
        let drift = pendulum.drift();
        worst = [worst[0].max(drift[0]), worst[1].max(drift[1])];
    }
    assert!(worst[0] < 1e-14 && worst[1] < 1e-13, "{worst:?}");
}

#[test]
fn projection_costs_the_integrator_no_steps_and_no_accuracy() {
    let mut pendulum = simulation(&bar_chain(2, 0.3), 1e-9);
    let recording = record(&mut pendulum, 4.0, 0.05);
    let energy = recording.energy();
    let worst = energy.chunks(6).map(|row| row[5].abs());
    // The same run without projection had 831 steps and a residual of 6.7e-8 J.
    let steps = pendulum.counts().steps;
    assert!(steps as f64 <= 1.05 * 831.0, "{steps}");
    let worst = worst.fold(0.0, f64::max);
    assert!(worst <= 3.0 * 6.7e-8, "{worst}");
}

#[test]
fn a_slider_crank_follows_its_closed_form() {
    let speed = 2.0 * std::f64::consts::PI * 10.0;
    let mut machine = simulation(&slider_crank(speed), 1e-10);
    let assembly = machine.assembly().clone();
    assert_eq!(assembly.degrees_of_freedom, 0);
    assert!(assembly.redundant.is_empty());
    let recording = record(&mut machine, 0.3, 1e-3);
    for (row, t) in recording.time.iter().enumerate() {
        let (sin, cos) = (speed * t).sin_cos();
        let root = (ROD * ROD - CRANK * CRANK * sin * sin).sqrt();
        let slope = -CRANK * CRANK * sin * cos / root;
        let x = CRANK * cos + root;
        let v = speed * (-CRANK * sin + slope);
        let bend = -CRANK * CRANK * (cos * cos - sin * sin) / root - slope * slope / root;
        let a = speed * speed * (-CRANK * cos + bend);
        let at = 9 * row + 6;
        assert!((recording.positions()[at] - x).abs() < 1e-13);
        assert!((recording.velocities()[at] - v).abs() < 1e-12 * speed);
        assert!((recording.accelerations()[at] - a).abs() < 1e-11 * speed * speed);
        // The guide carries what the slider does not: with the wrist pin it is all of m a.
        let wrist = recording.reactions()[3 * (5 * row + 2)];
        assert!((wrist - 0.14 * a).abs() < 1e-9 * speed * speed);
        assert!(recording.energy()[6 * row + 5].abs() < 1e-7);
    }
}

#[test]
fn andrews_squeezing_mechanism_meets_the_test_set_to_nine_digits() {
    let expected = andrews_angles(ANDREWS_END);
    for (tolerance, bound) in [(1e-9, 1e-8), (1e-12, 1e-9), (1e-13, 1e-9)] {
        let mut machine = simulation(&andrews(), tolerance);
        assert_eq!(machine.assembly().degrees_of_freedom, 1);
        assert!(machine.assembly().moved < 1e-15);
        run_to(&mut machine, 0.03);
        let found: Vec<f64> = machine.positions().iter().map(|q| q[2]).collect();
        // The problem's own angles are taken between neighbours.
        let own = [
            found[0],
            found[1] - found[0],
            found[2],
            found[3] - found[4],
            found[4],
            found[5] - found[6],
            found[6],
        ];
        let errors = ANDREWS_END.iter().zip(&own);
        let worst = errors.map(|(e, f)| ((e - f) / e).abs()).fold(0.0, f64::max);
        assert!(worst < bound, "{tolerance} {worst:e}");
        // What remains is one delay for all seven bodies, about 1e-12 s at the last tolerances.
        let speeds: Vec<f64> = machine.velocities().iter().map(|v| v[2]).collect();
        let delay = (expected[0] - found[0]) / speeds[0];
        for ((expected, found), speed) in expected.iter().zip(&found).zip(&speeds) {
            let left = expected - found - delay * speed;
            assert!(left.abs() < 1e-13, "{tolerance} {left:e}");
        }
    }
}

#[test]
fn a_row_of_four_bars_passes_its_singular_positions_for_ten_seconds() {
    for windows in [2, 5] {
        let mut machine = simulation(&four_bars(windows), 1e-10);
        assert_eq!(machine.assembly().degrees_of_freedom, 1);
        let recording = record(&mut machine, 10.0, 0.01);
        let bodies = 2 * windows + 1;
        let worst = recording
            .energy()
            .chunks(6)
            .map(|row| row[5].abs())
            .fold(0.0, f64::max);
        let mut singular = 0;
        for row in recording
            .positions()
            .chunks(3 * bodies)
            .collect::<Vec<_>>()
            .windows(2)
        {
            singular += usize::from(row[0][1].signum() != row[1][1].signum());
        }
        // All posts stay parallel: no window folds over.
        let last = &recording.positions()[recording.positions().len() - 3 * bodies..];
        let fold = (1..=windows).map(|k| (last[3 * (2 * k - 1) + 2] - last[2]).abs());
        let fold = fold.fold(0.0, f64::max);
        assert!(singular >= 8 && fold < 1e-9, "{singular} {fold}");
        assert!(worst < 1e-5, "{windows} {worst}");
    }
}

#[test]
fn bodies_without_joints_have_no_constrained_system() {
    let mut mechanism = bar_chain(1, 0.4);
    mechanism.joints.clear();
    let mut free = simulation(&mechanism, 1e-9);
    assert!(!free.present().is_constrained());
    run_to(&mut free, 1.0);
    let fallen = 0.5 * 0.4f64.sin() - 0.5 * GRAVITY;
    assert!((free.positions()[0][1] - fallen).abs() < 1e-9);
}
