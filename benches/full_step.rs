//! Full steps of the paper's drive under way: prediction, two evaluations, error, order, and the search for onsets.

mod common;

use common::{Halves, LAWS, contacts, print_counts};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};

/// Steps in a row: enough to meet every order, step size and a few onsets.
const STEPS: u64 = 100;

fn full_step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("full_step");
    group.throughput(Throughput::Elements(STEPS));
    for (law, elastic, damping) in LAWS {
        let ready = Halves::of(&mut common::under_way(elastic, damping));
        let walk = |run: &mut Halves| (0..STEPS).for_each(|_| run.step());
        print_counts(&format!("full_step/{law}"), &counts(&ready, walk));
        group.bench_function(law, |b| {
            b.iter_batched_ref(|| ready.clone(), walk, BatchSize::SmallInput);
        });
    }
    group.finish();
}

/// What the steps cost, in evaluations, and what they met.
fn counts(ready: &Halves, walk: impl Fn(&mut Halves)) -> String {
    let mut run = ready.clone();
    walk(&mut run);
    let work = |halves: &Halves| {
        (
            halves.adams.counts(),
            halves.dynamics.memory.counts().onsets,
            halves.adams.time(),
        )
    };
    let ((before, onsets_before, begin), (after, onsets_after, end)) = (work(ready), work(&run));
    format!(
        "{} steps over {:.3e} s, {} rejected, {} evaluations, {} onsets; {}",
        after.steps - before.steps,
        end - begin,
        after.rejected - before.rejected,
        after.evaluations - before.evaluations,
        onsets_after - onsets_before,
        contacts(&run.dynamics),
    )
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = full_step
}
criterion_main!(benches);
