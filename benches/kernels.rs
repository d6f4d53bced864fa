//! The right-hand side with every instruction set beside the scalar twins, as ratios of one run.

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
        "right-hand side of the paper's drive, ns a call; in brackets how many times faster than the twins"
    );
    print!("{:<36}{:>9}", "", "twins");
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
                vec![(dynamics.clone(), vec![0.0; y.len()]); 1 + sets.len()];
            for ((dynamics, _), set) in scenes[1..].iter_mut().zip(&sets) {
                dynamics.use_instructions(*set);
            }
            let (twins, kernels) = scenes.split_at_mut(1);
            let twin = &mut twins[0].0;
            let mut competitors: Vec<Box<dyn FnMut()>> = vec![Box::new(|| {
                black_box(twin.evaluate(black_box(t), black_box(&y)));
            })];
            for (dynamics, dydt) in kernels {
                let y = &y;
                competitors.push(Box::new(move || {
                    dynamics.derivative(black_box(t), black_box(y), dydt);
                }));
            }
            let times = race(effort, &mut competitors);
            print!("{:<36}{:>9.0}", format!("{law}, {place}"), times[0]);
            for time in &times[1..] {
                print!("{:>9.0} ({:>4.1})", time, times[0] / time);
            }
            println!("  {}", contacts(&dynamics));
        }
    }
}
