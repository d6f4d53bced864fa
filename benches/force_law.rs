//! Each elastic law over light and heavy contacts of a hinge and of a tooth, and the damping factor.

mod common;

use std::hint::black_box;

use common::print_counts;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use rustchain::drive::Material;
use rustchain::force_law::{
    Damping, ElasticLaw, EnhancedCylinder, Hertz, Johnson, SurfacePair, damping_factor,
};

/// Penetrations in a batch.
const COUNT: u32 = 1024;

/// From 1 nm to 10 um, evenly in their logarithms \[m\].
fn penetrations() -> Vec<f64> {
    (0..COUNT)
        .map(|i| 1e-9 * 1e4f64.powf(f64::from(i) / f64::from(COUNT - 1)))
        .collect()
}

fn law<L: ElasticLaw>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    surfaces: &[(&str, SurfacePair)],
) {
    let depths = penetrations();
    for (place, pair) in surfaces {
        let constants = L::prepare(pair);
        let largest = L::force(&constants, depths[depths.len() - 1]);
        let past_end = depths
            .iter()
            .filter(|&&depth| depth > L::range_end(&constants))
            .count();
        print_counts(
            &format!("force_law/{name}/{place}"),
            &format!("{COUNT} forces up to {largest:.1} N, {past_end} past the end of the law"),
        );
        group.bench_function(format!("{name}/{place}"), |b| {
            b.iter(|| {
                depths
                    .iter()
                    .map(|&depth| L::force(&constants, black_box(depth)))
                    .sum::<f64>()
            });
        });
    }
}

fn elastic(criterion: &mut Criterion) {
    let modulus = Material::default().contact_modulus();
    let surfaces = [
        (
            "pin_in_bushing",
            SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, modulus),
        ),
        (
            "bushing_in_seat",
            SurfacePair::internal(3.968_75e-3, 4.026_694e-3, 0.007, modulus),
        ),
        (
            "bushing_on_topping",
            SurfacePair::external(3.968_75e-3, 6.582_621e-3, 0.007, modulus),
        ),
    ];
    let mut group = criterion.benchmark_group("force_law");
    group.throughput(Throughput::Elements(u64::from(COUNT)));
    law::<Hertz>(&mut group, "hertz", &surfaces);
    law::<Johnson>(&mut group, "johnson", &surfaces);
    law::<EnhancedCylinder>(&mut group, "enhanced_cylinder", &surfaces);
    group.finish();
}

fn damping(criterion: &mut Criterion) {
    let lambda = Damping::LankaraniNikravesh.lambda(Material::default().restitution);
    let rates: Vec<f64> = (0..COUNT)
        .map(|i| 0.1 - 0.2 * f64::from(i) / f64::from(COUNT))
        .collect();
    let mut group = criterion.benchmark_group("force_law");
    group.throughput(Throughput::Elements(u64::from(COUNT)));
    group.bench_function("damping_factor", |b| {
        b.iter(|| {
            rates
                .iter()
                .map(|&rate| damping_factor(lambda, black_box(rate), 0.1))
                .sum::<f64>()
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = elastic, damping
}
criterion_main!(benches);
