//! Redundant joints at any size: found, named, shared in the least way, and no hindrance to the motion.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use crate::common::mechanisms::{GRAVITY, Rows, bar, ground, record, revolute, run_to, simulation};
use nalgebra::{DMatrix, DVector};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, StepControl};
use rustchain::multibody::{
    Body, Joint, JointKind, Marker, Mechanism, MechanismDynamics, MechanismModel,
};
use rustchain::run::MechanismSimulation;

/// A platform of 1 kg on parallel posts of 1 m and 0.1 kg, 0.1 m apart, which lean by `lean` and turn at `speed` \[rad/s\].
fn posts(count: usize, lean: f64, speed: f64) -> Mechanism {
    let mut mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        ..Mechanism::default()
    };
    let along = Vec2::new(-lean.sin(), lean.cos());
    let sweep = speed * Vec2::new(-along.y, along.x);
    let middle = 0.05 * (count - 1) as f64;
    let mut platform = Body::new("platform", 1.0, 1.0).at(middle + along.x, along.y, 0.0);
    platform = platform.moving(sweep.x, sweep.y, 0.0);
    mechanism.bodies.push(platform);
    for k in 0..count {
        let (x, name) = (0.1 * k as f64, format!("post {k}"));
        let foot = Vec2::new(x, 0.0);
        let post = bar(&name, foot, foot + along, 0.1);
        let post = post.moving(0.5 * sweep.x, 0.5 * sweep.y, speed);
        mechanism.bodies.push(post);
        let [low, high] = [-0.5, 0.5].map(|x| Marker::new(name.clone(), x, 0.0));
        let head = Marker::new("platform", x - middle, 0.0);
        mechanism
            .joints
            .push(revolute(&format!("foot {k}"), ground(x, 0.0), low));
        mechanism
            .joints
            .push(revolute(&format!("head {k}"), high, head));
    }
    mechanism
}

/// The posts' angle after 0.5 s: one degree of freedom, by Runge and Kutta's formulas in short steps.
fn swung(count: usize, lean: f64, speed: f64) -> f64 {
    let n = count as f64;
    let rate = |angle: f64| -(0.05 * n + 1.0) * GRAVITY * angle.cos() / (0.1 * n / 3.0 + 1.0);
    let (mut angle, mut spin, h) = (FRAC_PI_2 + lean, speed, 1e-4);
    for _ in 0..5000 {
        let k1 = (spin, rate(angle));
        let k2 = (spin + 0.5 * h * k1.1, rate(angle + 0.5 * h * k1.0));
        let k3 = (spin + 0.5 * h * k2.1, rate(angle + 0.5 * h * k2.0));
        let k4 = (spin + h * k3.1, rate(angle + h * k3.0));
        angle += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
        spin += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
    }
    angle
}

/// Bays of 1 m with both diagonals, bars of 0.5 kg pinned to each other, hung at a corner: a redundant equation a bay. Also the first
/// moment of the masses about the pin \[kg m\].
fn braced(bays: usize, turned: f64, spin: f64, gravity: f64) -> (Mechanism, Vec2) {
    let mut mechanism = Mechanism {
        gravity: Vec2::new(0.0, -gravity),
        ..Mechanism::default()
    };
    let mut ends = vec![[(0, 0), (0, 1)]];
    for i in 0..bays {
        ends.extend([
            [(i, 0), (i + 1, 0)],
            [(i, 1), (i + 1, 1)],
            [(i, 0), (i + 1, 1)],
            [(i, 1), (i + 1, 0)],
            [(i + 1, 0), (i + 1, 1)],
        ]);
    }
    let (sin, cos) = turned.sin_cos();
    let at = |(x, y): (usize, usize)| {
        let (x, y) = (x as f64, y as f64);
        Vec2::new(cos * x - sin * y, sin * x + cos * y)
    };
    let mut moment = Vec2::zeros();
    let mut first = std::collections::HashMap::new();
    for (k, nodes) in ends.iter().enumerate() {
        let [from, to] = nodes.map(at);
        let (name, middle) = (format!("bar {k}"), 0.5 * (from + to));
        let body = bar(&name, from, to, 0.5);
        mechanism
            .bodies
            .push(body.moving(-spin * middle.y, spin * middle.x, spin));
        moment += 0.5 * middle;
        let half = 0.5 * (to - from).norm();
        for (node, x) in nodes.iter().zip([-half, half]) {
            let here = Marker::new(name.clone(), x, 0.0);
            if let Some(there) = first.insert(*node, here.clone()) {
                let joint = format!("joint {k} {node:?}");
                mechanism.joints.push(revolute(&joint, there, here));
            }
        }
    }
    let corner = Marker::new("bar 0", -0.5, 0.0);
    mechanism
        .joints
        .push(revolute("pin", ground(0.0, 0.0), corner));
    (mechanism, moment)
}

#[test]
fn a_braced_truss_that_turns_bears_the_same_all_round() {
    for bays in [1, 2, 4, 8] {
        let (mechanism, moment) = braced(bays, 0.4, 2.0, 0.0);
        let pull = 4.0 * moment.norm();
        let joints = mechanism.joints.len();
        let mut machine = run_of(&mechanism, 1e-9, Corrector::Pece);
        let recording = record(&mut machine, 3.2, 2e-3);
        let sizes = |row: &[f64]| -> Vec<f64> { row.chunks(3).map(|r| r[0].hypot(r[1])).collect() };
        let rows = recording.reactions().chunks(3 * joints);
        let first = sizes(&recording.reactions()[..3 * joints]);
        assert!((first[joints - 1] - pull).abs() < 1e-9 * pull);
        let mut worst: f64 = 0.0;
        for row in rows {
            for (found, expected) in sizes(row).iter().zip(&first) {
                worst = worst.max((found - expected).abs() / pull);
            }
        }
        assert!(worst < 1e-7, "{bays}: {worst:e}");
    }
}

#[test]
fn a_braced_truss_hangs_and_swings_on() {
    for bays in [2, 3, 5, 8] {
        for (accuracy, max_step) in [(1e-6, 1e-2), (1e-7, 1e-3)] {
            for corrector in [Corrector::Pece, Corrector::Newton] {
                let mechanism = braced(bays, -1.57, 0.05, GRAVITY).0;
                let control = StepControl {
                    accuracy,
                    max_step,
                    corrector,
                    ..StepControl::default()
                };
                let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
                let mut machine = MechanismSimulation::assemble(model, control).unwrap();
                run_to(&mut machine, 0.5);
            }
        }
    }
}

fn run_of(mechanism: &Mechanism, accuracy: f64, corrector: Corrector) -> MechanismSimulation {
    let control = StepControl {
        accuracy,
        max_step: 0.01,
        corrector,
        ..StepControl::default()
    };
    let model = Arc::new(MechanismModel::compile(mechanism).unwrap());
    MechanismSimulation::assemble(model, control).unwrap()
}

#[test]
fn a_platform_swings_on_any_number_of_posts_in_as_many_steps() {
    for corrector in [Corrector::Pece, Corrector::Newton] {
        let mut few = 0;
        for count in [3, 15, 20, 30, 40, 60] {
            let mut machine = run_of(&posts(count, 0.3, 2.0), 1e-8, corrector);
            assert_eq!(machine.assembly().degrees_of_freedom, 1, "{count}");
            assert_eq!(machine.assembly().redundant.len(), count - 2, "{count}");
            run_to(&mut machine, 0.5);
            let off = machine.positions()[1][2] - swung(count, 0.3, 2.0);
            let bound = if corrector == Corrector::Pece {
                1e-7
            } else {
                1e-5
            };
            assert!(off.abs() < bound, "{count} {corrector:?}: {off:e}");
            let steps = machine.counts().steps;
            few = if few == 0 { steps } else { few };
            assert!(steps < 2 * few, "{count} {corrector:?}: {steps} {few}");
        }
    }
}

#[test]
fn a_platform_passes_where_its_posts_lie_in_steps_of_any_length() {
    for count in [3, 10, 14, 20, 30] {
        for corrector in [Corrector::Pece, Corrector::Newton] {
            for (accuracy, max_step) in [(1e-10, 1e-4), (1e-8, 1e-2)] {
                let control = StepControl {
                    accuracy,
                    max_step,
                    corrector,
                    ..StepControl::default()
                };
                let mechanism = posts(count, 0.3, 8.0);
                let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
                let mut machine = MechanismSimulation::assemble(model, control).unwrap();
                run_to(&mut machine, 0.25);
                let place = format!("{count} {corrector:?} {accuracy:e}");
                assert!(machine.positions()[1][2] > 1.05 * PI, "{place}");
            }
        }
    }
}

#[test]
fn redundant_joints_are_not_taken_for_a_singular_start() {
    for count in [3, 15, 20, 30, 40] {
        for lean in [0.0, 0.3] {
            let machine = simulation(&posts(count, lean, 0.0), 1e-8);
            let warnings = &machine.assembly().warnings;
            let told = warnings.iter().any(|warning| warning.contains("singular"));
            assert!(!told, "{count} {lean}: {warnings:?}");
        }
        let machine = simulation(&posts(count, FRAC_PI_2, 0.0), 1e-8);
        let warnings = &machine.assembly().warnings;
        let told = warnings.iter().any(|warning| warning.contains("singular"));
        assert!(told, "{count} lying: {:?}", machine.assembly());
    }
}

/// Wheels in a row that three rods a pair couple, a third of a turn apart: one pair of rods or another is always at its dead
/// points, and never are all three.
fn coupled_wheels(count: usize, speed: f64) -> Mechanism {
    let mut mechanism = Mechanism::default();
    for k in 0..count {
        let wheel = Body::new(format!("wheel {k}"), 1.0, 0.01).at(k as f64, 0.0, 0.0);
        mechanism.bodies.push(wheel.moving(0.0, 0.0, speed));
        let center = Marker::new(format!("wheel {k}"), 0.0, 0.0);
        mechanism.joints.push(revolute(
            &format!("axle {k}"),
            ground(k as f64, 0.0),
            center,
        ));
        for rod in (0..3).filter(|_| k > 0) {
            let name = format!("rod {k} {rod}");
            let angle = TAU / 3.0 * f64::from(rod);
            let pin = 0.2 * Vec2::new(angle.cos(), angle.sin());
            let sweep = 0.2 * speed * Vec2::new(-angle.sin(), angle.cos());
            let from = Vec2::new(k as f64 - 1.0, 0.0) + pin;
            let body = bar(&name, from, from + Vec2::new(1.0, 0.0), 0.1);
            mechanism.bodies.push(body.moving(sweep.x, sweep.y, 0.0));
            for (end, wheel) in [(-0.5, k - 1), (0.5, k)] {
                mechanism.joints.push(revolute(
                    &format!("{name} on {wheel}"),
                    Marker::new(format!("wheel {wheel}"), pin.x, pin.y),
                    Marker::new(name.clone(), end, 0.0),
                ));
            }
        }
    }
    mechanism
}

#[test]
fn wheels_coupled_by_three_rods_pass_the_dead_points_of_each() {
    for corrector in [Corrector::Pece, Corrector::Newton] {
        for count in [2, 4, 12] {
            let mut machine = run_of(&coupled_wheels(count, 8.0), 1e-8, corrector);
            assert_eq!(machine.assembly().degrees_of_freedom, 1);
            assert_eq!(machine.assembly().redundant.len(), 2 * (count - 1));
            run_to(&mut machine, 1.0);
            let bodies = machine.positions();
            let turned = (0..count).map(|k| bodies[if k == 0 { 0 } else { 4 * k - 3 }][2]);
            // Balanced wheels and rods that stay level turn on as they did.
            let off = turned.map(|angle| (angle - 8.0).abs()).fold(0.0, f64::max);
            let bound = if corrector == Corrector::Pece {
                1e-6
            } else {
                1e-4
            };
            assert!(off < bound, "{count} {corrector:?}: {off:e}");
            let steps = machine.counts().steps;
            assert!(steps < 400, "{count} {corrector:?}: {steps}");
        }
    }
}

/// Numbers from 0 to 1 that look as if by chance.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Nodes of a grid, a body each, and rods of given length between neighbours, each there with the likelihood `density`, so that
/// some parts are held more than once and others move.
fn truss(columns: usize, rows: usize, density: f64, seed: u64) -> Mechanism {
    let mut chance = Chance(seed);
    let mut mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        ..Mechanism::default()
    };
    let name = |i: usize, j: usize| format!("node {i} {j}");
    for i in 0..columns {
        for j in 0..rows {
            let mut off = || 0.3 * (chance.next() - 0.5);
            let (x, y) = (i as f64 + off(), j as f64 + off());
            let body = Body::new(name(i, j), 1.0 + off(), 0.1).at(x, y, off());
            mechanism.bodies.push(body);
        }
    }
    let centers: Vec<_> = mechanism.bodies.iter().map(|b| b.position).collect();
    for i in 0..columns {
        for j in 0..rows {
            // Along the grid, and both diagonals of each window.
            for ends in [
                [(i, j), (i + 1, j)],
                [(i, j), (i, j + 1)],
                [(i, j), (i + 1, j + 1)],
                [(i, j + 1), (i + 1, j)],
            ] {
                let inside = ends.iter().all(|&(i, j)| i < columns && j < rows);
                if !inside || chance.next() > density {
                    continue;
                }
                let [a, b] = ends.map(|(i, j)| centers[i * rows + j]);
                let length = (b[0] - a[0]).hypot(b[1] - a[1]);
                let [a, b] = ends.map(|(i, j)| Marker::new(name(i, j), 0.0, 0.0));
                let kind = JointKind::Distance {
                    length: Some(length),
                };
                let rod = format!("rod {}", mechanism.joints.len());
                mechanism.joints.push(Joint::new(rod, a, b, kind));
            }
        }
        let pinned = Marker::new(name(i, 0), 0.0, 0.0);
        let [x, y, _] = centers[i * rows];
        if i % 4 == 0 {
            mechanism
                .joints
                .push(revolute(&format!("pin {i}"), ground(x, y), pinned));
        }
    }
    mechanism
}

#[test]
fn random_trusses_have_the_rank_accelerations_and_least_multipliers_of_dense_factors() {
    for (seed, (columns, rows)) in [(3, 2), (4, 2), (5, 3), (8, 3), (10, 4), (14, 5)]
        .into_iter()
        .cycle()
        .take(24)
        .enumerate()
    {
        let density = [0.55, 0.7, 0.85, 1.0][seed / 6];
        let mechanism = truss(columns, rows, density, seed as u64 + 1);
        let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
        let mut dynamics = MechanismDynamics::new(model);
        let assembly = dynamics.assemble().unwrap();
        let (mass, loads) = dynamics.masses_and_loads();
        let (n, m) = (mass.len(), dynamics.gamma().len());
        // G D⁻¹ of full length, and its pseudoinverse.
        let mut weighed = DMatrix::<f64>::zeros(m, n);
        for (row, column, value) in dynamics.jacobian() {
            weighed[(row, column)] += value / mass[column].sqrt();
        }
        // G M⁻¹ Gᵀ by its own directions, of which those without a hold do nothing.
        let own = (&weighed * weighed.transpose()).symmetric_eigen();
        let held = own.eigenvalues.map(|value| value > 1e-10);
        let rank = held.iter().filter(|held| **held).count();
        let least = own.eigenvalues.iter().filter(|value| **value > 1e-10);
        let least = least.copied().fold(f64::INFINITY, f64::min);
        let condition = (own.eigenvalues.max() / least).sqrt();
        let place = format!("{columns} x {rows}, {density}, seed {seed}, {condition:e}");
        assert_eq!(assembly.degrees_of_freedom, n - rank, "{place}");
        assert_eq!(assembly.redundant.len(), m - rank, "{place}");
        let forces = DVector::from_fn(n, |i, _| loads[i] / mass[i].sqrt());
        // At rest, G a = 0: λ is what is nearest to the forces along the constraints.
        let mut along = own.eigenvectors.tr_mul(&(&weighed * &forces));
        for ((along, value), held) in along.iter_mut().zip(&own.eigenvalues).zip(&held) {
            *along = if *held { *along / value } else { 0.0 };
        }
        let multipliers = &own.eigenvectors * along;
        let accelerations = &forces - weighed.transpose() * &multipliers;
        let bound = 1e-9 + 1e-13 * condition * condition;
        for (i, a) in dynamics.accelerations().iter().enumerate() {
            let expected = accelerations[i] / mass[i].sqrt();
            assert!((a - expected).abs() < bound, "{place}: {a} {expected}");
        }
        let largest = multipliers.amax();
        for (found, expected) in dynamics.multipliers().iter().zip(&multipliers) {
            let off = (found - expected).abs();
            assert!(off < bound * (1.0 + largest), "{place}: {found} {expected}");
        }
    }
}
