//! Many scenes at once: the numbers of each are those of its run alone, and none suffers from another.
use crate::common;
use std::num::NonZero;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{control, paper_drive, tensioner};
use rustchain::drive::Drive;
use rustchain::force_law::Damping;
use rustchain::run::ensemble::{Case, Ensemble, Outcome};
use rustchain::{Error, ForceLaws, Groups};

const ALL: Groups = Groups {
    hinges: true,
    teeth: true,
    sprockets: true,
    bodies: true,
    energy: true,
};
/// Long after the first contacts, which come at 4.1 ms \[s\].
const DURATION: f64 = 6e-3;

fn case(pretension: f64) -> Case {
    let mut drive = paper_drive();
    drive.tensioner = (pretension > 0.0).then(|| tensioner(pretension, 1e-3));
    of_drive(drive, &ForceLaws::default())
}

fn of_drive(drive: Drive, laws: &ForceLaws) -> Case {
    Case {
        drive,
        laws: *laws,
        start: None,
        groups: ALL,
        control: control(1e-6),
        duration: DURATION,
        report_step: 1e-5,
    }
}

/// Cases that differ in what they simulate and in how long they take.
fn mixed() -> Vec<Case> {
    let mut cases: Vec<Case> = [0.0, 25.0, 5.0, 0.0, 100.0].map(case).into();
    cases[1].duration = 5e-3;
    let mut laws = ForceLaws::default();
    laws.tooth.damping = Damping::None;
    cases[3] = of_drive(paper_drive(), &laws);
    cases
}

/// What came of each case, in the order of the cases.
fn outcomes(cases: Vec<Case>, threads: usize) -> Vec<Outcome> {
    let found: Vec<_> = cases.iter().map(|_| Mutex::new(None)).collect();
    let ensemble = Ensemble::new(cases, NonZero::new(threads)).unwrap();
    assert_eq!(ensemble.threads(), threads.min(found.len()));
    ensemble.run(|number, outcome| {
        let before = found[number].lock().unwrap().replace(outcome);
        assert!(before.is_none(), "case {number} came twice");
    });
    let found = found.into_iter().map(|one| one.into_inner().unwrap());
    found.map(Option::unwrap).collect()
}

fn assert_runs_as_alone(outcome: &mut Outcome, case: &Case) {
    let run = outcome.as_mut().unwrap();
    let mut alone = common::simulation(&case.drive, &case.laws, case.control);
    assert_eq!(run.start.positions, alone.motion().positions());
    assert_eq!(run.start.velocities, alone.motion().velocities());
    let recording = common::record(&mut alone, case.duration, case.report_step, ALL);
    assert!(recording.time.len() > 400);
    assert_eq!(run.simulation.take_recording(), recording);
    assert_eq!(run.simulation.time(), case.duration);
    let (together, alone) = (run.simulation.statistics(), alone.statistics());
    assert_eq!(together.counts, alone.counts);
    assert_eq!(together.onsets, alone.onsets);
    assert!(alone.onsets > 0);
}

#[test]
fn every_case_is_its_run_alone_to_the_last_bit_whatever_the_number_of_threads() {
    let cases = mixed();
    for threads in [1, 2, 3, 9] {
        let mut found = outcomes(cases.clone(), threads);
        assert_eq!(found.len(), cases.len());
        for (outcome, case) in found.iter_mut().zip(&cases) {
            assert_runs_as_alone(outcome, case);
        }
    }
}

#[test]
fn a_case_that_fails_leaves_the_others_alone() {
    let mut cases = mixed();
    cases[0].drive.chain.links = 20;
    cases[2].drive.chain.material.elastic_modulus = 1e300;
    cases[3].report_step = -1.0;
    for threads in [1, 2] {
        let mut found = outcomes(cases.clone(), threads);
        for healthy in [1, 4] {
            assert_runs_as_alone(&mut found[healthy], &cases[healthy]);
        }
        let mut failures = [0, 2, 3].map(|number| found[number].clone().unwrap_err());
        assert!(failures[0].error.to_string().contains("links"));
        assert!(failures[0].run.is_none());
        // The first contact, at about 4 ms, is too hard for any step.
        let (Error::StepTooSmall { time, .. } | Error::NotFinite { time, .. }) = failures[1].error
        else {
            panic!("{:?} is no step that failed", failures[1].error);
        };
        assert!((3.8e-3..4.2e-3).contains(&time), "{time} s");
        let run = failures[1].run.as_mut().unwrap();
        let rows = run.simulation.take_recording().time;
        let since_last = time - rows.last().unwrap();
        assert!((0.0..=1e-5).contains(&since_last), "{since_last} s");
        assert!(failures[2].error.to_string().starts_with("report_step = "));
    }
}

#[test]
fn cancelling_keeps_what_has_ended_and_drops_the_rest() {
    let mut cases = vec![case(0.0); 6];
    for endless in &mut cases[3..] {
        endless.duration = 1e6;
        endless.report_step = 1.0;
    }
    for threads in [1, 2] {
        let ensemble = Ensemble::new(cases.clone(), NonZero::new(threads)).unwrap();
        let kept = Mutex::new(Vec::new());
        ensemble.run(|number, outcome| {
            assert!(outcome.is_ok());
            kept.lock().unwrap().push(number);
            if kept.lock().unwrap().len() == 3 {
                ensemble.cancel();
            }
        });
        let mut kept = kept.into_inner().unwrap();
        kept.sort_unstable();
        assert_eq!(kept, [0, 1, 2]);
        let simulated = ensemble.simulated();
        assert!((3.0 * DURATION..1e5).contains(&simulated), "{simulated} s");
    }
}

#[test]
fn no_more_cases_begin_than_there_are_threads_for() {
    // While a case is being handed over, its thread begins no other one.
    let (handed, inside) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let ensemble = Ensemble::new(vec![case(0.0); 6], NonZero::new(2)).unwrap();
    ensemble.run(|_, _| {
        assert!(inside.fetch_add(1, Ordering::SeqCst) < 2);
        // At most those that were handed over before, this one, and one of the other thread.
        let simulated = ensemble.simulated() / DURATION;
        let before = handed.fetch_add(1, Ordering::SeqCst);
        assert!(simulated < before as f64 + 2.0 + 1e-9, "{simulated}");
        inside.fetch_sub(1, Ordering::SeqCst);
    });
    assert_eq!(handed.into_inner(), 6);
    assert!((ensemble.simulated() - 6.0 * DURATION).abs() < 1e-12);
}

#[test]
fn no_cases_are_no_work() {
    let ensemble = Ensemble::new(Vec::new(), None).unwrap();
    ensemble.run(|number, _| panic!("case {number} of none"));
    assert_eq!(ensemble.simulated(), 0.0);
}
