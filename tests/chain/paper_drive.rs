//! The paper's drive from its published start: first contacts, a converged path, and reports that only look on.
//!
//! Paths are compared up to 6 ms only: from 7 ms on the drive is chaotic.

use crate::common;
use std::time::Duration;

use crate::common::{advance, control, paper_drive, record, simulation};
use rustchain::integrator::{Counts, StepControl};
use rustchain::{ForceLaws, Groups, Simulation};

/// Where paths are compared \[s\].
const END: f64 = 6e-3;

fn run(control: StepControl) -> Simulation {
    simulation(&paper_drive(), &ForceLaws::default(), control)
}

/// Largest distance of any hinge or centre between two runs \[m\]: a turn of a body moves what is half a pitch off its centre.
fn distance(one: &Simulation, other: &Simulation) -> f64 {
    let half_pitch = one.model().half_pitch;
    let (one, other) = (one.motion(), other.motion());
    let apart = |a: &[f64], b: &[f64], arm: f64| {
        a.iter()
            .zip(b)
            .fold(0.0f64, |largest, (a, b)| largest.max(arm * (a - b).abs()))
    };
    let shift = apart(&one.x, &other.x, 1.0).hypot(apart(&one.y, &other.y, 1.0));
    shift + apart(&one.angle, &other.angle, half_pitch)
}

#[test]
fn nothing_touches_before_the_first_tooth_at_4_09_ms_and_the_first_hinge_at_4_32_ms() {
    // The times are known to 0.01 ms.
    let mut simulation = run(control(1e-10));
    let (mut first_tooth, mut first_hinge) = (None, None);
    for microseconds in 0..4400 {
        let time = 1e-6 * f64::from(microseconds);
        advance(&mut simulation, time);
        let present = simulation.present();
        if present
            .evaluated
            .teeth
            .penetration
            .iter()
            .any(|&depth| depth > 0.0)
        {
            first_tooth.get_or_insert(time);
        }
        if present
            .evaluated
            .hinges
            .penetration
            .iter()
            .any(|&depth| depth > 0.0)
        {
            first_hinge.get_or_insert(time);
        }
    }
    let (tooth, hinge) = (first_tooth.unwrap(), first_hinge.unwrap());
    assert!((tooth - 4.09e-3).abs() <= 0.005e-3, "{tooth} s");
    assert!((hinge - 4.32e-3).abs() <= 0.005e-3, "{hinge} s");
}

#[test]
fn the_path_to_6_ms_converges_whatever_the_largest_step() {
    // From 4 to 6 ms errors grow 250 to 600 times. Twelve runs at 1e-9, whose tolerances differ by a percent, are 8e-10 to 1.1e-8 m from
    // the finest run; six at 1e-10 are 7e-11 to 1e-9 m from it. At 1e-11 and 1e-12: 4e-11 and 6e-12 m.
    let with = |tolerance: f64, max_step: f64| {
        let mut simulation = run(StepControl {
            max_step,
            ..control(tolerance)
        });
        advance(&mut simulation, END);
        simulation
    };
    let finest = with(1e-12, 3e-5);
    for (tolerance, bound) in [(1e-9, 2e-8), (1e-10, 4e-9), (1e-11, 4e-10), (1e-12, 1e-10)] {
        for max_step in [1e-4, 3e-5] {
            let apart = distance(&with(tolerance, max_step), &finest);
            assert!(
                apart <= bound,
                "{tolerance:e}, steps up to {max_step} s: {apart:e} m"
            );
        }
    }
}

#[test]
fn reports_do_not_change_the_path() {
    let everything = Groups {
        hinges: true,
        teeth: true,
        sprockets: true,
        bodies: true,
        energy: false,
    };
    let mut plain = run(control(1e-6));
    advance(&mut plain, END);
    for report_step in [1e-3, 1.7e-5, 1e-6] {
        let mut reported = run(control(1e-6));
        let recording = record(&mut reported, END, report_step, everything);
        assert!(recording.time.len() as f64 >= END / report_step);
        assert_same_bits(&reported, &plain);
    }
}

#[test]
fn keeping_the_energy_balance_does_not_change_the_path() {
    let mut plain = run(control(1e-6));
    advance(&mut plain, END);
    let mut balanced = run(control(1e-6));
    common::energies(&mut balanced, END, 1e-4);
    let coordinates = 2 * plain.model().coordinates;
    assert_eq!(
        balanced.integrator().y()[..coordinates],
        plain.integrator().y()[..coordinates]
    );
    assert_eq!(balanced.statistics().counts, plain.statistics().counts);
}

#[test]
fn going_in_pieces_is_going_in_one() {
    let mut whole = run(control(1e-6));
    advance(&mut whole, END);
    for pieces in [2, 60, 7001] {
        let mut parts = run(control(1e-6));
        for piece in 1..=pieces {
            advance(&mut parts, END * f64::from(piece) / f64::from(pieces));
        }
        assert_same_bits(&parts, &whole);
    }
}

#[test]
fn stopping_for_the_clock_and_going_on_is_going_in_one() {
    let mut whole = run(control(1e-6));
    advance(&mut whole, END);
    let mut stopped = run(control(1e-6));
    let mut stops = 0;
    while !stopped.advance(END, Duration::ZERO).unwrap() {
        stops += 1;
        assert!(stopped.time() < END);
    }
    assert!(stops > 10);
    assert_same_bits(&stopped, &whole);
}

#[test]
fn the_same_run_twice_is_the_same_to_the_last_bit() {
    let twice = |control: StepControl| {
        let (mut one, mut other) = (run(control), run(control));
        advance(&mut one, 0.02);
        advance(&mut other, 0.02);
        assert_same_bits(&one, &other);
        one
    };
    let changing = twice(StepControl::default()).statistics().counts;
    assert!(changing.jacobians > 0 && changing.jacobians < changing.steps);
    let one = twice(control(1e-5));
    let Counts {
        steps,
        evaluations,
        rejected,
        ..
    } = one.statistics().counts;
    // One at the start, and one that tests the first step.
    assert_eq!(evaluations, 2 + 2 * steps + rejected);
    assert!(one.statistics().onsets > 100);
}

fn assert_same_bits(one: &Simulation, other: &Simulation) {
    assert_eq!(one.time(), other.time());
    assert_eq!(one.integrator().time(), other.integrator().time());
    assert_eq!(one.integrator().y(), other.integrator().y());
    assert_eq!(one.dynamics().memory, other.dynamics().memory);
    assert_eq!(one.statistics().counts, other.statistics().counts);
    assert_eq!(one.motion().positions(), other.motion().positions());
}
