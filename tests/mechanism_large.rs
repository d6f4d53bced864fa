//! Large mechanisms: sparse factors beside dense ones, at a cost that grows with the number of bodies.

mod common {
    pub(crate) mod mechanisms;
}

use common::mechanisms::{GRAVITY, bar_chain, ground, revolute, run_to, simulation};
use rustchain::mechanism::{Marker, Mechanism};

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
fn sparse_factors_give_what_dense_ones_give() {
    // 30 bars have 62 constraints and dense factors; with a 31st body's worth of joints they are sparse.
    let dense = simulation(&hung(30), 1e-9).row();
    let mut more = hung(30);
    let mut twin = bar_chain(1, 0.3);
    twin.bodies[0].name = "apart".into();
    twin.joints[0].name = "apart".into();
    twin.joints[0].b.body = "apart".into();
    more.bodies.extend(twin.bodies);
    more.joints.extend(twin.joints);
    let sparse = simulation(&more, 1e-9).row();
    for (a, b) in dense.accelerations.iter().zip(&sparse.accelerations) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    for (a, b) in dense.reactions.iter().zip(&sparse.reactions) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
}

#[test]
fn a_hung_chain_keeps_its_joints_its_energy_and_carries_its_weight() {
    let count = 200;
    let mut chain = simulation(&hung(count), 1e-8);
    assert_eq!(chain.assembly().degrees_of_freedom, count - 2);
    assert!(chain.assembly().redundant.is_empty());
    let row = chain.row();
    // Momentum: what both ends carry is the weight less what the mass accelerates downwards.

    let sinks: f64 = row.accelerations.chunks(3).map(|a| a[1]).sum();
    let weight = count as f64 * GRAVITY;
    assert!((row.reactions[1] + row.reactions[3 * count + 1] - weight - sinks).abs() < 1e-7);
    let before: f64 = row.energy[..3].iter().sum();
    run_to(&mut chain, 0.3);
    let drift = chain.drift();
    assert!(drift[0] < 1e-12 && drift[1] < 1e-11, "{drift:?}");
    let after: f64 = chain.row().energy[..3].iter().sum();
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
    for a in row.accelerations.chunks(3) {
        assert!(a[0].abs() < 1e-9 && (a[1] + GRAVITY).abs() < 1e-9 && a[2].abs() < 1e-9);
    }
    assert!(row.reactions.iter().all(|r| r.abs() < 1e-9));
}

#[test]
fn a_joint_twice_is_found_in_a_large_mechanism_too() {
    let mut mechanism = hung(50);
    let mut twice = mechanism.joints[20].clone();
    twice.name = "twice".into();
    mechanism.joints.push(twice);
    let chain = simulation(&mechanism, 1e-8);
    assert_eq!(chain.assembly().degrees_of_freedom, 48);
    let named = &chain.assembly().redundant;
    assert_eq!(named.len(), 2);
    assert!(
        named
            .iter()
            .all(|name| name == "twice" || name == "hinge 20"),
        "{named:?}"
    );
}
