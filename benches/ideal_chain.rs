//! What a chain of ideal hinges costs: an evaluation of 38 to 10,000 links, beside faer's sparse factors of the same system.
//!
//! Prints the two tables of docs/performance/mechanisms.md. `--test` leaves out the long chains and the runs of 1 s, which above 300
//! links would take long.

#![allow(clippy::print_stdout)] // a table is what it is for

use std::sync::Arc;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use faer::prelude::*;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};
use rustchain::geometry::Vec2;
use rustchain::integrator::{OdeSystem, StepControl};
use rustchain::multibody::{
    Body, Joint, JointKind, Marker, Mechanism, MechanismDynamics, MechanismModel,
};
use rustchain::run::MechanismSimulation;

/// A chain of links of an ANSI 40's size hung level between two points, both ends held.
fn hung(links: usize) -> Mechanism {
    let (pitch, slope) = (12.7e-3, 0.3f64);
    let mut mechanism = Mechanism {
        gravity: Vec2::new(0.0, -9.81),
        ..Mechanism::default()
    };
    for k in 0..=links {
        let end = |k: usize, side: f64| Marker::new(format!("link {k}"), side * 0.5 * pitch, 0.0);
        let before = match k {
            0 => Marker::new("ground", 0.0, 0.0),
            _ => end(k - 1, 1.0),
        };
        let after = if k == links {
            let low = if links.is_multiple_of(2) {
                0.0
            } else {
                -pitch * slope.sin()
            };
            Marker::new("ground", links as f64 * pitch * slope.cos(), low)
        } else {
            let turn = if k.is_multiple_of(2) { -slope } else { slope };
            let x = (k as f64 + 0.5) * pitch * slope.cos();
            let y = -0.5 * pitch * slope.sin();
            mechanism
                .bodies
                .push(Body::new(format!("link {k}"), 7e-3, 1.5e-7).at(x, y, turn));
            end(k, -1.0)
        };
        let name = format!("hinge {k}");
        mechanism
            .joints
            .push(Joint::new(name, before, after, JointKind::Revolute));
    }
    mechanism
}

/// Least time of one call \[s\].
fn least(calls: usize, mut call: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..calls {
        let begin = Instant::now();
        call();
        best = best.min(begin.elapsed().as_secs_f64());
    }
    best
}

/// The same accelerations by faer's sparse LU of [M Gᵀ; G 0]: time of factors and solution, and the largest difference.
fn by_faer(dynamics: &MechanismDynamics, calls: usize) -> (f64, f64) {
    let (mass, loads) = dynamics.masses_and_loads();
    let (n, gamma) = (mass.len(), dynamics.gamma());
    let mut entries: Vec<_> = (0..n).map(|i| Triplet::new(i, i, mass[i])).collect();
    for (row, column, value) in dynamics.jacobian() {
        entries.push(Triplet::new(n + row, column, value));
        entries.push(Triplet::new(column, n + row, value));
    }
    let size = n + gamma.len();
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &entries)
        .expect("entries inside the matrix");
    let symbolic =
        SymbolicLu::try_new(matrix.symbolic()).expect("a structure that can be factorised");
    let right = Col::from_fn(size, |i| if i < n { loads[i] } else { gamma[i - n] });
    let mut solution = right.clone();
    let time = least(calls, || {
        let factors = Lu::try_new_with_symbolic(symbolic.clone(), matrix.as_ref())
            .expect("independent constraints");
        solution = factors.solve(&right);
    });
    let apart = dynamics.accelerations().iter().enumerate();
    let apart = apart
        .map(|(i, a)| (a - solution[i]).abs())
        .fold(0.0, f64::max);
    (time, apart)
}

fn main() {
    let short = std::env::args().any(|a| a == "--test");
    let lengths: &[usize] = if short {
        &[11, 38, 100]
    } else {
        &[
            2, 3, 4, 6, 8, 11, 17, 25, 31, 32, 37, 38, 100, 300, 1000, 3000, 10_000,
        ]
    };
    println!(
        "| links | evaluation \\[µs\\] | per link \\[ns\\] | faer, factors and solution \\[µs\\] | largest difference \\[m/s²\\] |"
    );
    println!("|---|---|---|---|---|");
    for &links in lengths {
        evaluation(links);
    }
    println!();
    println!(
        "| links | steps, first 0.1 s | time \\[s\\] | steps, 1 s | time \\[s\\] | per step and link \\[ns\\] |"
    );
    println!("|---|---|---|---|---|---|");
    for &links in lengths {
        run(links, !short && links <= LONGEST_OF_A_SECOND);
    }
}

/// Prints what one evaluation costs, of ours and of faer's.
fn evaluation(links: usize) {
    let calls = (200_000 / links).clamp(10, 1000);
    let model = Arc::new(MechanismModel::compile(&hung(links)).expect("a sound chain"));
    let mut dynamics = MechanismDynamics::new(Arc::clone(&model));
    let mut y = dynamics
        .assemble()
        .expect("a chain that goes together")
        .state;
    y.extend([0.0; 2]);
    let mut slope = vec![0.0; y.len()];
    let own = least(calls, || dynamics.derivative(0.0, &y, &mut slope));
    let (faer, apart) = by_faer(&dynamics, (calls / 10).max(5));
    println!(
        "| {links} | {:.1} | {:.0} | {:.1} | {apart:.1e} |",
        1e6 * own,
        1e9 * own / links as f64,
        1e6 * faer
    );
}

/// The longest chain that is run for a whole second.
const LONGEST_OF_A_SECOND: usize = 300;

/// Prints what a run from rest costs: its first tenth of a second and, where asked for, the whole one.
fn run(links: usize, whole: bool) {
    let model = Arc::new(MechanismModel::compile(&hung(links)).expect("a sound chain"));
    let control = StepControl {
        rtol: 1e-6,
        atol: 1e-6,
        max_step: 0.01,
        ..StepControl::default()
    };
    let mut run =
        MechanismSimulation::assemble(model, control).expect("a chain that goes together");
    let begin = ProcessTime::now();
    let mut to = |t: f64| {
        while !run.advance(t, Duration::MAX).expect("a chain that holds") {}
        (run.counts().steps, begin.elapsed().as_secs_f64())
    };
    let (first, early) = to(0.1);
    let (steps, time) = if whole { to(1.0) } else { (first, early) };
    let of_second = if whole {
        format!("{steps} | {time:.2}")
    } else {
        "| ".to_string()
    };
    println!(
        "| {links} | {first} | {early:.2} | {of_second} | {:.0} |",
        1e9 * time / (steps as f64 * links as f64)
    );
}
