//! A panic in a run is an error with its time: the rows until then are kept, and the run does not go on.
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)] // rows are few

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use crate::common::{control, paper_drive};
use rustchain::drive::SprocketMotion;
use rustchain::layout::InitialConfiguration;
use rustchain::{Error, ForceLaws, Groups, Model, Simulation, Values};

const REPORT_STEP: f64 = 1e-5;

/// A drive whose model lacks the gaps of a sprocket that its bushings come to later.
fn defective() -> Simulation {
    let mut drive = paper_drive();
    // A tooth a millisecond, in the direction in which the numbers of the gaps rise.
    drive.sprockets[0].motion = SprocketMotion::PrescribedSpeed((-400.0).into());
    let laws = ForceLaws::default();
    let (start, _) = InitialConfiguration::generate(&drive).unwrap();
    let with_gaps = |count: usize| {
        let mut model = Model::compile(&drive, &laws, &start).unwrap();
        model.sprockets[0].gap_directions.truncate(count);
        let made = AssertUnwindSafe(|| Simulation::new(Arc::new(model), &start, control(1e-6)));
        catch_unwind(made)
    };
    let first = (1..17).find_map(|count| with_gaps(count).ok());
    first.unwrap().unwrap()
}

#[test]
fn a_panic_in_a_run_is_an_error_with_its_time_and_keeps_the_rows_until_then() {
    let mut simulation = defective();
    let before = simulation.snapshot();
    let groups = Groups {
        hinges: true,
        teeth: true,
        sprockets: true,
        bodies: true,
        energy: true,
    };
    simulation.start_recording(0.01, REPORT_STEP, groups);
    let error = simulation.record(Duration::MAX).unwrap_err();
    let Error::Panicked { time, message } = &error else {
        panic!("{error} is no panic");
    };
    let time = time.unwrap();
    assert!(time > 0.0 && time == simulation.time(), "{time}");
    assert!(message.contains("index out of bounds"), "{message}");
    assert_eq!(simulation.record(Duration::MAX), Err(error.clone()));
    assert_eq!(simulation.check_intact(), Err(error));

    let recording = simulation.take_recording();
    let rows = recording.time.len();
    assert_eq!(rows, (time / REPORT_STEP) as usize + 1);
    for channel in recording.channels {
        let numbers = match channel.values {
            Values::Real(values) => values.len(),
            Values::Whole(values) => values.len(),
        };
        let each: usize = channel.row_shape.iter().product();
        assert_eq!(numbers, rows * each, "{}", channel.name);
    }

    simulation.restore(&before).unwrap();
    assert_eq!(simulation.advance(REPORT_STEP, Duration::MAX), Ok(true));
}
