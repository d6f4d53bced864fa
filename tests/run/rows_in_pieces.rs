//! Rows that are taken during a recording: the same as those of a recording that is taken at its end.

use std::time::Duration;

use crate::common::{control, paper_drive, record, simulation};
use rustchain::{ForceLaws, Groups, Recording, Simulation, Values};

const ALL: Groups = Groups {
    hinges: true,
    teeth: true,
    sprockets: true,
    bodies: true,
    energy: true,
};
const RUN: (f64, f64) = (2.05e-3, 1e-4);

fn fresh() -> Simulation {
    simulation(&paper_drive(), &ForceLaws::default(), control(1e-6))
}

#[test]
fn pieces_join_to_the_recording() {
    let mut whole = fresh();
    let expected = record(&mut whole, RUN.0, RUN.1, ALL);
    let mut pieces = fresh();
    pieces.start_recording(RUN.0, RUN.1, ALL);
    pieces.pause_at_reports();
    let mut found: Vec<Recording> = Vec::new();
    let mut reports = 0;
    while !pieces.record(Duration::MAX).unwrap() {
        reports += 1;
        match reports % 4 {
            0 => found.push(pieces.take_rows(3)),
            2 => found.push(pieces.take_rows(usize::MAX)),
            _ => {}
        }
    }
    found.push(pieces.take_recording());
    let time: Vec<f64> = found.iter().flat_map(|piece| piece.time.clone()).collect();
    assert_eq!(time, expected.time);
    for channel in &expected.channels {
        let name = channel.name;
        let real: Vec<f64> = found
            .iter()
            .flat_map(|piece| piece.real(name))
            .copied()
            .collect();
        let whole: Vec<i32> = found
            .iter()
            .flat_map(|piece| piece.whole(name))
            .copied()
            .collect();
        assert_eq!(real, expected.real(name), "{name}");
        assert_eq!(whole, expected.whole(name), "{name}");
    }
    assert_eq!(pieces.balance_note(), whole.balance_note());
    assert!(pieces.snapshot().to_bytes().unwrap() == whole.snapshot().to_bytes().unwrap());
}

#[test]
fn memory_of_all_rows_is_reserved_at_the_beginning() {
    let mut run = fresh();
    let recording = record(
        &mut run,
        1e-3,
        1e-7,
        Groups {
            hinges: true,
            ..Groups::default()
        },
    );
    assert_eq!(recording.time.len(), 10_001);
    for channel in &recording.channels {
        let Values::Real(values) = &channel.values else {
            panic!("{}", channel.name);
        };
        assert_eq!(values.len(), 10_001 * channel.row_length());
        // Doubled arrays would have room for 16,384 rows.
        assert!(
            values.capacity() < 10_100 * channel.row_length(),
            "{}",
            channel.name
        );
    }
}

#[test]
fn a_recording_that_ends_early_keeps_the_memory_of_its_rows_only() {
    let mut run = fresh();
    run.start_recording(1.0, 1e-4, ALL);
    run.advance(1e-3, Duration::MAX).unwrap();
    let recording = run.take_recording();
    let rows = recording.time.len();
    assert!((10..=11).contains(&rows), "{rows}");
    for channel in &recording.channels {
        let capacity = match &channel.values {
            Values::Real(values) => values.capacity(),
            Values::Whole(values) => values.capacity(),
        };
        assert_eq!(capacity, rows * channel.row_length(), "{}", channel.name);
    }
}

#[test]
fn without_a_recording_there_are_no_rows() {
    assert_eq!(fresh().take_rows(usize::MAX), Recording::default());
}
