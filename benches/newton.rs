//! What Newton's corrector costs with every instruction set: an evaluation, one that leaves slopes, the matrix made and
//! factorised, one solution.

mod common;

use std::hint::black_box;

use common::{Effort, Halves, contacts, race};
use rustchain::Simulation;
use rustchain::force_law::{Damping, Elastic};
use rustchain::integrator::{OdeSystem, SecondOrderSystem};
use rustchain::math::simd::InstructionSet;

/// Makes a state.
type Build = fn() -> Simulation;

const LAW: (Elastic, Damping) = (Elastic::Hertz, Damping::LankaraniNikravesh);

#[allow(clippy::print_stdout)] // a benchmark's figures
fn main() {
    let effort = Effort {
        batches: 3000,
        calls: 50,
    }
    .or_once();
    println!("Newton's corrector on the paper's drive, ns a call");
    println!(
        "{:<24}{:>12}{:>13}{:>13}{:>10}  contacts",
        "", "evaluation", "with slopes", "factorised", "solved"
    );
    for set in InstructionSet::available() {
        let places: [(&str, Build); 5] = [
            ("start", || common::at_start(LAW.0, LAW.1)),
            ("under way", || common::under_way(LAW.0, LAW.1)),
            ("pressed", || common::pressed(LAW.0, LAW.1)),
            ("25 N", || common::tensioned(25.0)),
            ("100 N", || common::tensioned(100.0)),
        ];
        for (place, simulation) in places {
            let mut simulation = simulation();
            let Halves {
                mut dynamics,
                adams,
            } = Halves::of(&mut simulation);
            dynamics.use_instructions(set);
            let (t, y, gamma) = (adams.time(), adams.y().to_vec(), 3e-6);
            let mut dydt = vec![0.0; y.len()];
            let mut residual: Vec<f64> = (0..dynamics.coordinates())
                .map(|i| (i * 37 % 17) as f64 - 8.0)
                .collect();
            dynamics.accelerations_with_slopes(t, &y, &mut dydt);
            assert!(dynamics.factorise(&y, gamma));
            let (mut plain, mut sloped, mut factorised) =
                (dynamics.clone(), dynamics.clone(), dynamics.clone());
            let (mut first, mut second) = (dydt.clone(), dydt);
            let solved = &mut dynamics;
            let before = residual.clone();
            let times = race(
                effort,
                &mut [
                    Box::new(|| plain.derivative(black_box(t), black_box(&y), &mut first)),
                    Box::new(|| {
                        sloped.accelerations_with_slopes(black_box(t), black_box(&y), &mut second);
                    }),
                    Box::new(|| {
                        black_box(factorised.factorise(black_box(&y), gamma));
                    }),
                    Box::new(|| {
                        residual.copy_from_slice(&before);
                        solved.correct(black_box(&mut residual));
                    }),
                ],
            );
            println!(
                "{:<24}{:>12.0}{:>13.0}{:>13.0}{:>10.0}  {}",
                format!("{}, {place}", set.name()),
                times[0],
                times[1],
                times[2],
                times[3],
                contacts(&plain)
            );
        }
    }
}
