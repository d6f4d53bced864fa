//! The right-hand side with every instruction set beside the plain one, as ratios of one run.

mod common;

use std::hint::black_box;

use common::{Effort, Halves, LAWS, contacts, race};
use rustchain::chain::dynamics::Dynamics;
use rustchain::integrator::OdeSystem;
use rustchain::math::simd::InstructionSet;

#[allow(clippy::print_stdout)] // a benchmark's figures
fn main() {
    let effort = Effort {
        batches: 3000,
        calls: 50,
    }
    .or_once();
    let sets = InstructionSet::available();
    println!(
        "right-hand side of the paper's drive, ns a call; in brackets how many times faster than the plain set"
    );
    print!("{:<36}", "");
    for set in &sets {
        print!("{:>16}", set.name());
    }
    println!("  contacts");
    for (law, elastic, damping) in LAWS {
        let states = [
            ("start", common::at_start(elastic, damping)),
            ("under way", common::under_way(elastic, damping)),
            ("pressed", common::pressed(elastic, damping)),
        ];
        for (place, mut simulation) in states {
            let Halves { dynamics, adams } = Halves::of(&mut simulation);
            let (t, y) = (adams.time(), adams.y().to_vec());
            let mut scenes: Vec<(Dynamics, Vec<f64>)> =
                vec![(dynamics.clone(), vec![0.0; y.len()]); sets.len()];
            for ((dynamics, _), set) in scenes.iter_mut().zip(&sets) {
                dynamics.use_instructions(*set);
            }
            let mut competitors: Vec<Box<dyn FnMut()>> = Vec::new();
            for (dynamics, dydt) in &mut scenes {
                let y = &y;
                competitors.push(Box::new(move || {
                    dynamics.derivative(black_box(t), black_box(y), dydt);
                }));
            }
            let times = race(effort, &mut competitors);
            print!("{:<36}", format!("{law}, {place}"));
            for time in &times {
                print!("{:>9.0} ({:>4.1})", time, times[times.len() - 1] / time);
            }
            println!("  {}", contacts(&dynamics));
        }
    }
}
