//! Many scenes at once: the same cases on one thread and on two, and how much faster two are.

#![allow(clippy::unwrap_used)] // a benchmark whose cases fail has nothing to say

mod common;

use std::num::NonZero;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use common::{drives, only_tried, print_counts};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rustchain::integrator::StepControl;
use rustchain::run::ensemble::{Case, Ensemble};
use rustchain::{ForceLaws, Groups, Statistics};

/// Enough for two threads to end nearly together: at worst one case apart.
const CASES: u32 = 24;
/// Half of it under way \[s\].
const DURATION: f64 = 8e-3;
/// The ratio compares the least times of so many runs.
const REPETITIONS: usize = 5;

fn ensemble(criterion: &mut Criterion) {
    let counts = Mutex::new(Vec::new());
    prepare(1).run(|_, outcome| {
        let statistics = outcome.unwrap().simulation.statistics();
        counts.lock().unwrap().push(statistics);
    });
    let counts = totals(&counts.into_inner().unwrap());
    print_counts("ensemble", &format!("{counts}; {}", ratio()));

    let mut group = criterion.benchmark_group("ensemble");
    group.sample_size(10);
    group.throughput(Throughput::Elements(u64::from(CASES)));
    for threads in [1, 2] {
        let ready = prepare(threads);
        group.bench_function(format!("threads_{threads}"), |b| {
            b.iter(|| ready.run(|_, outcome| assert!(outcome.is_ok())));
        });
    }
    group.finish();
}

/// The paper's drive with the driver a little faster from case to case.
fn prepare(threads: usize) -> Ensemble {
    let case = |number: u32| {
        let mut drive = drives::paper_drive();
        let speed = 4.0 * std::f64::consts::PI * (1.0 + 1e-3 * f64::from(number));
        drive.sprockets[0].motion = rustchain::drive::SprocketMotion::PrescribedSpeed(speed.into());
        Case {
            drive,
            laws: ForceLaws::default(),
            start: None,
            groups: Groups {
                hinges: true,
                teeth: true,
                sprockets: true,
                bodies: false,
                energy: true,
            },
            control: StepControl::default(),
            duration: DURATION,
            report_step: 1e-4,
        }
    };
    Ensemble::new((0..CASES).map(case).collect(), NonZero::new(threads)).unwrap()
}

fn totals(statistics: &[Statistics]) -> String {
    let sum = |count: fn(&Statistics) -> u64| statistics.iter().map(count).sum::<u64>();
    format!(
        "{} cases, {} steps, {} evaluations, {} onsets",
        statistics.len(),
        sum(|s| s.counts.steps),
        sum(|s| s.counts.evaluations),
        sum(|s| s.onsets),
    )
}

/// How much faster two threads are than one, as words: the least times, taken by turns.
fn ratio() -> String {
    let mut least = [Duration::MAX; 2];
    for _ in 0..if only_tried() { 1 } else { REPETITIONS } {
        for (threads, least) in (1..).zip(&mut least) {
            let ready = prepare(threads);
            let begin = Instant::now();
            ready.run(|_, outcome| assert!(outcome.is_ok()));
            *least = begin.elapsed().min(*least);
        }
    }
    let [one, two] = least.map(|time| time.as_secs_f64());
    format!(
        "{one:.4} s on one thread, {two:.4} s on two: ratio {:.3}",
        one / two
    )
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = ensemble
}
criterion_main!(benches);
