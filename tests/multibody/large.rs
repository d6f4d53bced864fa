//! Large mechanisms: joints, energy, shared loads, at a cost that grows with the number of bodies.

use crate::common::mechanisms::{
    GRAVITY, Rows, bar, bar_chain, four_bars, ground, record, revolute, run_to, simulation,
};
use rustchain::geometry::Vec2;
use rustchain::multibody::{Body, Marker, Mechanism};

/// A chain of bars between two points of the same height, hanging in a zigzag.
fn hung(count: usize) -> Mechanism {
    let mut mechanism = bar_chain(count, 0.0);
    for (k, body) in mechanism.bodies.iter_mut().enumerate() {
        let slope: f64 = if k % 2 == 0 { -0.3 } else { 0.3 };
        body.position = [
            (k as f64 + 0.5) * slope.cos(),
            0.5 * slope.sin() - if k % 2 == 0 { 0.0 } else { 0.3f64.sin() },
            slope,
        ];
        if k % 2 == 1 {
            body.position[1] = 0.5 * (-0.3f64).sin();
        }
    }
    let last = Marker::new(format!("bar {}", count - 1), 0.5, 0.0);
    let end = ground(count as f64 * 0.3f64.cos(), 0.0);
    mechanism.joints.push(revolute("far end", end, last));
    mechanism
}

#[test]
fn a_hung_chain_keeps_its_joints_its_energy_and_carries_its_weight() {
    let count = 200;
    let mut chain = simulation(&hung(count), 1e-8);
    assert_eq!(chain.assembly().degrees_of_freedom, count - 2);
    assert!(chain.assembly().redundant.is_empty());
    let row = chain.row();
    // Momentum: what both ends carry is the weight less what the mass accelerates downwards.

    let sinks: f64 = row.accelerations().chunks(3).map(|a| a[1]).sum();
    let weight = count as f64 * GRAVITY;
    assert!((row.reactions()[1] + row.reactions()[3 * count + 1] - weight - sinks).abs() < 1e-7);
    let before: f64 = row.energy()[..3].iter().sum();
    run_to(&mut chain, 0.3);
    let drift = chain.drift();
    assert!(drift[0] < 1e-12 && drift[1] < 1e-11, "{drift:?}");
    let after: f64 = chain.row().energy()[..3].iter().sum();
    assert!((after - before).abs() < 1e-4, "{before} {after}");
}

#[test]
fn a_closed_ring_in_free_fall_has_two_joints_of_its_angles_less() {
    // Bars in a ring: 3 motions of the whole and count - 3 of its shape.
    let count = 60;
    let mut ring = bar_chain(count, 0.0);
    let turn = 2.0 * std::f64::consts::PI / count as f64;
    let radius = 0.5 / (0.5 * turn).tan();
    for (k, body) in ring.bodies.iter_mut().enumerate() {
        let angle = turn * k as f64;
        body.position = [radius * angle.sin(), -radius * angle.cos(), angle];
    }
    ring.joints[0] = revolute(
        "hinge 0",
        Marker::new(format!("bar {}", count - 1), 0.5, 0.0),
        Marker::new("bar 0", -0.5, 0.0),
    );
    let mut ring = simulation(&ring, 1e-9);
    assert_eq!(ring.assembly().degrees_of_freedom, 3 * count - 2 * count);
    let row = ring.row();
    // All falls alike, nothing pulls.
    for a in row.accelerations().chunks(3) {
        assert!(a[0].abs() < 1e-9 && (a[1] + GRAVITY).abs() < 1e-9 && a[2].abs() < 1e-9);
    }
    assert!(row.reactions().iter().all(|r| r.abs() < 1e-9));
}

#[test]
fn a_joint_twice_is_named_and_shares_the_load_in_a_large_mechanism_too() {
    let mut single = simulation(&hung(50), 1e-8);
    let mut mechanism = hung(50);
    for name in ["twice", "thrice"] {
        let mut again = mechanism.joints[20].clone();
        again.name = name.into();
        mechanism.joints.push(again);
    }
    let mut chain = simulation(&mechanism, 1e-8);
    assert_eq!(chain.assembly().degrees_of_freedom, 48);
    assert_eq!(
        chain.assembly().redundant,
        ["twice", "twice", "thrice", "thrice"]
    );
    let (once, row) = (single.row(), chain.row());
    for (a, b) in once.accelerations().iter().zip(row.accelerations()) {
        assert!((a - b).abs() < 1e-9);
    }
    // Of all reactions that move the chain so, the least: a third each.
    let joints = mechanism.joints.len();
    for joint in [20, joints - 2, joints - 1] {
        for k in 0..2 {
            let (whole, part) = (once.reactions()[60 + k], row.reactions()[3 * joint + k]);
            assert!((whole - 3.0 * part).abs() < 1e-9, "{whole} {part}");
        }
    }
}

#[test]
fn many_parallel_posts_carry_the_platform_that_falls_with_them() {
    // Posts of 2 kg in all and a platform of 5 kg on a circle of 1 m: (5 + 2/3) θ'' = (5 + 2/2) g sin θ at rest.
    let (count, lean) = (16, 0.3f64);
    let mut machine = simulation(&posts(count), 1e-9);
    assert_eq!(machine.assembly().degrees_of_freedom, 1);
    assert_eq!(machine.assembly().redundant.len(), count - 2);
    let row = machine.row();
    let fall = -6.0 * GRAVITY * lean.sin().powi(2) / (5.0 + 2.0 / 3.0);
    assert!((row.accelerations()[1] - fall).abs() < 1e-9);
    let heads = row.reactions().chunks(6).map(|both| both[4]);
    assert!((heads.sum::<f64>() - 5.0 * (GRAVITY + fall)).abs() < 1e-8);
}

#[test]
fn a_long_row_of_four_bars_passes_its_singular_positions_too() {
    for windows in [10, 12, 30] {
        let mut machine = simulation(&four_bars(windows), 1e-10);
        assert_eq!(machine.assembly().degrees_of_freedom, 1);
        let recording = record(&mut machine, 3.0, 0.01);
        let bodies = 2 * windows + 1;
        let heights = recording.positions().chunks(3 * bodies).map(|row| row[1]);
        let heights: Vec<f64> = heights.collect();
        let pairs = heights.windows(2);
        let singular = pairs.filter(|h| h[0].signum() != h[1].signum()).count();
        let energy = recording.energy();
        let worst = energy.chunks(6).map(|row| row[5].abs());
        let worst = worst.fold(0.0, f64::max);
        let last = &recording.positions()[recording.positions().len() - 3 * bodies..];
        let fold = (1..=windows).map(|k| (last[3 * (2 * k - 1) + 2] - last[2]).abs());
        let fold = fold.fold(0.0, f64::max);
        assert!(singular >= 2 && fold < 1e-7, "{windows} {singular} {fold}");
        assert!(worst < 1e-5, "{windows} {worst}");
    }
}

/// A platform of 5 kg on parallel posts of 2 kg in all, each hinged at foot and head.
fn posts(count: usize) -> Mechanism {
    let mut mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        ..Mechanism::default()
    };
    let lean = Vec2::new(0.3f64.sin(), 0.3f64.cos());
    let center = Vec2::new(2.0, 0.0) + lean;
    let platform = Body::new("platform", 5.0, 1.0).at(center.x, center.y, 0.0);
    mechanism.bodies.push(platform);
    for k in 0..count {
        let x = 4.0 * k as f64 / (count - 1) as f64;
        let name = format!("post {k}");
        let foot = Vec2::new(x, 0.0);
        let post = bar(&name, foot, foot + lean, 2.0 / count as f64);
        mechanism.bodies.push(post);
        mechanism.joints.push(revolute(
            &format!("foot {k}"),
            Marker::new("ground", x, 0.0),
            Marker::new(name.clone(), -0.5, 0.0),
        ));
        mechanism.joints.push(revolute(
            &format!("head {k}"),
            Marker::new(name, 0.5, 0.0),
            Marker::new("platform", x - 2.0, 0.0),
        ));
    }
    mechanism
}
