//! Cost of layouts with guides: three shafts with an idler on an arm, a fixed rail and a hydraulic blade, and the same without guides.

#![allow(clippy::print_stdout)] // a benchmark's figures
#![allow(clippy::unwrap_used)] // a benchmark whose drives cannot be built has nothing to say

mod common;

use std::sync::Arc;
use std::time::{Duration, Instant};

use common::drives::layouts::guided_shafts;
use common::only_tried;
use rustchain::drive::Drive;
use rustchain::integrator::StepControl;
use rustchain::{Equilibrium, ForceLaws, Model, Simulation};

/// Time that is simulated \[s\].
const SPAN: f64 = 0.1;

fn main() {
    let guided = guided_shafts();
    let mut bare = guided.clone();
    bare.guides.clear();
    println!(
        "{:<16}{:>10}{:>14}{:>14}{:>14}",
        "layout", "links", "steps/s", "evaluations/s", "s/s"
    );
    let layouts = [("without guides", &bare), ("with guides", &guided)];
    let mut least = [f64::INFINITY; 2];
    let mut counts = [(0, 0); 2];
    let (span, rounds) = if only_tried() { (1e-3, 1) } else { (SPAN, 5) };
    for _ in 0..rounds {
        for (i, (_, drive)) in layouts.iter().enumerate() {
            let (time, steps, evaluations) = run(drive, span);
            least[i] = least[i].min(time);
            counts[i] = (steps, evaluations);
        }
    }
    for (i, (name, drive)) in layouts.iter().enumerate() {
        let (steps, evaluations) = counts[i];
        println!(
            "{name:<16}{:>10}{:>14.0}{:>14.0}{:>14.2}",
            drive.chain.links,
            steps as f64 / span,
            evaluations as f64 / span,
            least[i] / span
        );
    }
}

/// Seconds, steps and evaluations of a run over `span` \[s\] from a start at rest.
fn run(drive: &Drive, span: f64) -> (f64, u64, u64) {
    let laws = ForceLaws::default();
    let start = Equilibrium::find(drive, &laws).unwrap().start;
    let model = Arc::new(Model::compile(drive, &laws, &start).unwrap());
    let mut simulation = Simulation::new(model, &start, StepControl::default()).unwrap();
    let begin = Instant::now();
    simulation.advance(span, Duration::MAX).unwrap();
    let counts = simulation.statistics().counts;
    (
        begin.elapsed().as_secs_f64(),
        counts.steps,
        counts.evaluations,
    )
}
