//! The paper's drive from the Rust side.

mod common;

use std::sync::Arc;
use std::time::Duration;

use rustchain::integrator::StepControl;
use rustchain::state::Start;
use rustchain::{ForceLaws, Groups, Model, Simulation};

#[test]
fn the_paper_s_drive_runs_and_closes_its_energy_balance() {
    let drive = common::paper_drive();
    let (start, _) = Start::generate(&drive).unwrap();
    let model = Arc::new(Model::compile(&drive, &ForceLaws::default(), &start).unwrap());
    let mut simulation = Simulation::new(model, &start, StepControl::default()).unwrap();
    simulation.start_recording(
        0.1,
        1e-3,
        Groups {
            energy: true,
            ..Groups::default()
        },
    );
    let begin = std::time::Instant::now();
    while !simulation.record(Duration::from_secs(1)).unwrap() {}
    eprintln!("{:?} {:?}", begin.elapsed(), simulation.statistics());
    let recording = simulation.take_recording();
    for channel in &recording.channels {
        if let rustchain::Values::Real(v) = &channel.values {
            eprintln!("{} {:.6e} {:.6e}", channel.name, v[0], v[v.len() - 1]);
        }
    }
}
