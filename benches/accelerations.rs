//! One evaluation of the equations of motion: contacts, forces, accelerations of the paper's 40 bodies.

mod common;

use std::hint::black_box;

use common::{Halves, LAWS, contacts, print_counts};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rustchain::integrator::OdeSystem;

fn derivative(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("accelerations");
    group.throughput(Throughput::Elements(1));
    for (law, elastic, damping) in LAWS {
        let states = [
            ("start", common::at_start(elastic, damping)),
            ("under_way", common::under_way(elastic, damping)),
            ("pressed", common::pressed(elastic, damping)),
        ];
        for (place, mut simulation) in states {
            let Halves {
                mut dynamics,
                adams,
            } = Halves::of(&mut simulation);
            let (t, y) = (adams.time(), adams.y().to_vec());
            let mut dydt = vec![0.0; y.len()];
            dynamics.derivative(t, &y, &mut dydt);
            print_counts(
                &format!("accelerations/{law}/{place}"),
                &contacts(&dynamics),
            );
            group.bench_function(format!("{law}/{place}"), |b| {
                b.iter(|| dynamics.derivative(black_box(t), black_box(&y), &mut dydt));
            });
        }
    }
    group.finish();
}

/// The same with the sums of the energy balance.
fn derivative_with_energy(criterion: &mut Criterion) {
    let (law, elastic, damping) = LAWS[0];
    let Halves {
        mut dynamics,
        adams,
    } = Halves::of(&mut common::under_way(elastic, damping));
    let (t, y) = (adams.time(), adams.y().to_vec());
    let mut dydt = vec![0.0; y.len()];
    dynamics.keep_energy(true);
    let mut group = criterion.benchmark_group("accelerations");
    group.throughput(Throughput::Elements(1));
    group.bench_function(format!("{law}/under_way_with_energy"), |b| {
        b.iter(|| dynamics.derivative(black_box(t), black_box(&y), &mut dydt));
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = derivative, derivative_with_energy
}
criterion_main!(benches);
