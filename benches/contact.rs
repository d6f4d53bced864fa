//! One gap of a tooth profile, and the location of a contact onset inside a step.

mod common;

use std::hint::black_box;

use common::{Halves, LAWS, print_counts};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rustchain::chain::contact::{HingePath, ToothPath};
use rustchain::geometry::Vec2;
use rustchain::integrator::event_location::onset_in_step;

/// Points to each of the curves of a flank.
const POINTS: usize = 64;

/// A bushing 1 um deep in every part of a gap, walked from the left tooth's tip to the right one's.
fn one_gap(criterion: &mut Criterion) {
    let (_, elastic, damping) = LAWS[0];
    let model = common::at_start(elastic, damping).model().clone();
    let profile = &model.sprockets[0].profile;
    let radius = model.teeth.contact_radius;
    let right = profile.half_outline(POINTS);
    let left = right.iter().rev().map(|p| Vec2::new(-p.x, p.y));
    let places: Vec<Vec2> = left
        .chain(right.iter().copied())
        .map(|point| point + (1e-6 - radius) * profile.contact(point, 0.0).normal)
        .collect();
    let mut regions = [0; 7];
    for &place in &places {
        regions[profile.contact(place, radius).region as usize - 1] += 1;
    }
    let mut group = criterion.benchmark_group("contact");
    print_counts(
        "contact/tooth_gap",
        &format!("{} places, {regions:?} in regions 1 to 7", places.len()),
    );
    group.throughput(Throughput::Elements(places.len() as u64));
    group.bench_function("tooth_gap", |b| {
        b.iter(|| {
            let depth = |&place: &Vec2| profile.contact(black_box(place), radius).penetration;
            places.iter().map(depth).sum::<f64>()
        });
    });
    group.finish();
}

/// The onset of a hinge's and of a bushing's contact inside a step of the drive under way.
fn onset(criterion: &mut Criterion) {
    let (_, elastic, damping) = LAWS[0];
    let mut run = Halves::of(&mut common::under_way(elastic, damping));
    let mut group = criterion.benchmark_group("contact");
    for kind in ["hinge_onset", "tooth_onset"] {
        let (start, end, index) = step_to_onset(&mut run, kind == "tooth_onset");
        let model = run.dynamics.model();
        let (k, s) = (index % model.links, index / model.links);
        let find = || {
            let start = black_box(start);
            if kind == "tooth_onset" {
                let path = ToothPath::new(model, &run.adams, k, s);
                onset_in_step(|t| path.at(t).contact, start, end)
            } else {
                let path = HingePath::new(model, &run.adams, k);
                onset_in_step(|t| path.at(t), start, end)
            }
        };
        let (at, rate) = find();
        let counts = format!(
            "pair {index}, {:.2} of the way through the step, {rate:.4} m/s",
            (at - start) / (end - start)
        );
        print_counts(&format!("contact/{kind}"), &counts);
        group.throughput(Throughput::Elements(1));
        group.bench_function(kind, |b| b.iter(find));
    }
    group.finish();
}

/// Steps until a contact begins; returns the step's start and end and the pair.
fn step_to_onset(run: &mut Halves, of_tooth: bool) -> (f64, f64, usize) {
    loop {
        let before = run.clone();
        let start = run.adams.time();
        run.step();
        let pairs = |halves: &Halves| {
            let memory = &halves.dynamics.memory;
            if of_tooth {
                memory.tooth_impact_velocity.clone()
            } else {
                memory.hinge_impact_velocity().to_vec()
            }
        };
        let (old, new) = (pairs(&before), pairs(run));
        if let Some(pair) = (0..new.len()).find(|&i| old[i] == 0.0 && new[i] > 0.0) {
            return (start, run.adams.time(), pair);
        }
    }
}

criterion_group! {
    name = benches;
    config = common::criterion();
    targets = one_gap, onset
}
criterion_main!(benches);
