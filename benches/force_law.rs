//! Each elastic law over light and heavy contacts of a hinge and of a tooth, one by one and in registers, and the damping factor.

mod common;

use std::hint::black_box;

use common::{Effort, print_counts, race};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use rustchain::drive::Material;
use rustchain::force_law::{
    Damping, Elastic, ElasticPair, SurfacePair, VectorForces, damping_factor,
};
use rustchain::math::simd::InstructionSet;

/// Penetrations in a batch.
const COUNT: u32 = 1024;

/// From 1 nm to 10 um, evenly in their logarithms \[m\].
fn penetrations() -> Vec<f64> {
    (0..COUNT)
        .map(|i| 1e-9 * 1e4f64.powf(f64::from(i) / f64::from(COUNT - 1)))
        .collect()
}

fn law(group: &mut BenchmarkGroup<'_, WallTime>, law: Elastic, surfaces: &[(&str, SurfacePair)]) {
    let depths = penetrations();
    let name = law.name();
    for (place, surfaces) in surfaces {
        let pair = ElasticPair::prepare(law, surfaces);
        let largest = pair.force(depths[depths.len() - 1]);
        let past_end = depths.iter().filter(|&&d| d > pair.range_end()).count();
        print_counts(
            &format!("force_law/{name}/{place}"),
            &format!("{COUNT} forces up to {largest:.1} N, {past_end} past the end of the law"),
        );
        group.bench_function(format!("{name}/{place}"), |b| {
            b.iter(|| {
                depths
                    .iter()
                    .map(|&depth| pair.force(black_box(depth)))
                    .sum::<f64>()
            });
        });
    }
}

/// Time of one force \[ns\]: one by one, and in the registers of every instruction set; all laws in turns.
#[allow(clippy::print_stdout)] // a benchmark's figures
fn registers(_: &mut Criterion) {
    let effort = Effort {
        batches: 300,
        calls: 5,
    }
    .or_once();
    let modulus = Material::default().contact_modulus();
    let pin = SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, modulus);
    let depths = penetrations();
    let sets = InstructionSet::available();
    print!("{:<26}{:>12}", "ns a force, pin", "one by one");
    for set in &sets {
        print!("{:>9}", set.name());
    }
    println!();
    let mut competitors: Vec<Box<dyn FnMut()>> = Vec::new();
    for law in Elastic::ALL {
        let (pair, depths) = (ElasticPair::prepare(law, &pin), depths.clone());
        let single = depths.clone();
        competitors.push(Box::new(move || {
            let sum: f64 = single.iter().map(|&d| pair.force(black_box(d))).sum();
            black_box(sum);
        }));
        for set in &sets {
            let mut forces = VectorForces::new(law, &pin, &depths, *set);
            competitors.push(Box::new(move || {
                black_box(forces.evaluate());
            }));
        }
    }
    let times = race(effort, &mut competitors);
    for (law, row) in Elastic::ALL.iter().zip(times.chunks(1 + sets.len())) {
        print!("{:<26}{:>12.2}", law.name(), row[0] / f64::from(COUNT));
        for time in &row[1..] {
            print!("{:>9.2}", time / f64::from(COUNT));
        }
        println!();
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
    for each in Elastic::ALL {
        law(&mut group, each, &surfaces);
    }
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
    targets = registers, elastic, damping
}
criterion_main!(benches);
