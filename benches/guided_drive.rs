//! Cost of layouts with guides: three shafts with an idler on an arm, a fixed rail and a hydraulic blade, and the same without guides.

#![allow(clippy::print_stdout)] // a benchmark's figures
#![allow(clippy::unwrap_used)] // a benchmark whose drives cannot be built has nothing to say

mod common;

use std::sync::Arc;
use std::time::Duration;

use common::drives::layouts::guided_shafts;
use common::only_tried;
use cpu_time::ProcessTime;
use rustchain::drive::Drive;
use rustchain::integrator::StepControl;
use rustchain::{Equilibrium, ForceLaws, Model, Simulation};

/// Time that is simulated \[s\].
const SPAN: f64 = 0.1;

/// Accuracies \[m\]: the default one, and the one at which forces are read off within some percent.
const ACCURACIES: [f64; 2] = [1e-10, 1e-9];

fn main() {
    let guided = guided_shafts();
    let mut bare = guided.clone();
    bare.guides.clear();
    println!(
        "{:<16}{:>10}{:>12}{:>14}{:>14}{:>10}",
        "layout", "links", "accuracy", "steps/s", "evaluations/s", "s/s"
    );
    let layouts = [("without guides", &bare), ("with guides", &guided)];
    let mut runs = Vec::new();
    for (name, drive) in layouts {
        for accuracy in ACCURACIES {
            runs.push((name, drive, accuracy, f64::INFINITY, (0, 0)));
        }
    }
    let (span, rounds) = if only_tried() { (1e-3, 1) } else { (SPAN, 5) };
    for _ in 0..rounds {
        for (_, drive, accuracy, least, counts) in &mut runs {
            let (time, steps, evaluations) = run(drive, *accuracy, span);
            *least = least.min(time);
            *counts = (steps, evaluations);
        }
    }
    for (name, drive, accuracy, least, (steps, evaluations)) in runs {
        println!(
            "{name:<16}{:>10}{accuracy:>12.0e}{:>14.0}{:>14.0}{:>10.2}",
            drive.chain.links,
            steps as f64 / span,
            evaluations as f64 / span,
            least / span
        );
    }
}

/// Processor time \[s\], steps and evaluations of a run over `span` \[s\] from a start at rest.
fn run(drive: &Drive, accuracy: f64, span: f64) -> (f64, u64, u64) {
    let laws = ForceLaws::default();
    let start = Equilibrium::find(drive, &laws).unwrap().start;
    let model = Arc::new(Model::compile(drive, &laws, &start).unwrap());
    let control = StepControl {
        accuracy,
        ..StepControl::default()
    };
    let mut simulation = Simulation::new(model, &start, control).unwrap();
    let begin = ProcessTime::now();
    simulation.advance(span, Duration::MAX).unwrap();
    let counts = simulation.statistics().counts;
    (
        begin.elapsed().as_secs_f64(),
        counts.steps,
        counts.evaluations,
    )
}
