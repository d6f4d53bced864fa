//! What rollers as bodies cost: the paper's drive under way as a bushing chain and with rollers, counts beside times.

#![allow(clippy::unwrap_used)] // a benchmark whose scenes cannot be built has nothing to say
#![allow(clippy::print_stdout)] // its figures

mod common;

use std::time::Duration;

use common::{drives, only_tried};
use cpu_time::ProcessTime;
use rustchain::ForceLaws;
use rustchain::drive::Drive;
use rustchain::force_law::{Friction, Regularization};
use rustchain::integrator::{Corrector, Counts, StepControl};

/// Simulated time \[s\].
const SPAN: f64 = 0.05;

/// Runs of each, one after the other; the least time counts.
const REPEATS: usize = 3;

/// Runs from slightly different ramps, which chaos tells apart: counts are their means.
const STARTS: u32 = 4;

fn run(drive: &Drive, laws: &ForceLaws, corrector: Corrector, span: f64) -> (Duration, Counts) {
    let control = StepControl {
        corrector,
        ..StepControl::default()
    };
    let mut simulation = drives::simulation(drive, laws, control);
    // Of the processor: other programs have no part in it.
    let begin = ProcessTime::now();
    drives::advance(&mut simulation, span);
    (begin.elapsed(), simulation.statistics().counts)
}

/// Time and counts of all starts.
fn starts(
    drive: &Drive,
    laws: &ForceLaws,
    pretension: f64,
    corrector: Corrector,
    span: f64,
) -> (Duration, Counts) {
    let (mut time, mut all) = (Duration::ZERO, Counts::default());
    for i in 0..STARTS {
        let mut drive = drive.clone();
        if pretension > 0.0 {
            let ramp = 2e-3 * (1.0 + 0.01 * f64::from(i));
            drive.tensioner = Some(drives::tensioner(pretension, ramp));
        } else {
            // Without a tensioner the loads differ instead.
            drive.gravity.y *= 1.0 + 1e-3 * f64::from(i);
        }
        let (took, counts) = run(&drive, laws, corrector, span);
        time += took;
        all.steps += counts.steps;
        all.rejected += counts.rejected;
        all.evaluations += counts.evaluations;
        all.jacobians += counts.jacobians;
    }
    (time, all)
}

fn main() {
    let rubbed = Some(Friction {
        coefficient: 0.1,
        regularization: Regularization::Tanh,
        speed: 1e-3,
        dead_speed: 0.0,
    });
    let smooth = ForceLaws::default();
    let rough = ForceLaws {
        hinge_friction: rubbed,
        tooth_friction: rubbed,
        ..smooth
    };
    let drives = [
        ("bushings", drives::paper_drive()),
        ("rollers", drives::roller_drive()),
    ];
    let (span, repeats) = if only_tried() {
        (1e-3, 1)
    } else {
        (SPAN, REPEATS)
    };
    println!(
        "pretension, friction, corrector, chain, processor ms a simulated second, steps, rejected, evaluations, factorisations, us a step, \
         time over that of bushings"
    );
    for (pretension, friction, laws, corrector) in [
        (0.0, "none", &smooth, Corrector::Auto),
        (25.0, "none", &smooth, Corrector::Auto),
        (100.0, "none", &smooth, Corrector::Auto),
        (25.0, "none", &smooth, Corrector::Newton),
        (100.0, "none", &smooth, Corrector::Newton),
        (25.0, "0.1", &rough, Corrector::Auto),
        (100.0, "0.1", &rough, Corrector::Auto),
    ] {
        let mut least = [Duration::MAX; 2];
        let mut counts = [Counts::default(); 2];
        for _ in 0..repeats {
            for ((_, drive), (least, counts)) in
                drives.iter().zip(least.iter_mut().zip(&mut counts))
            {
                let (time, found) = starts(drive, laws, pretension, corrector, span);
                *least = time.min(*least);
                *counts = found;
            }
        }
        for ((name, _), (time, counts)) in drives.iter().zip(least.iter().zip(&counts)) {
            let runs = u64::from(STARTS);
            let seconds = time.as_secs_f64();
            println!(
                "{pretension:5} N  {friction:4}  {:6}  {name:8}  {:7.0}  {:6}  {:6}  {:6}  {:6}  {:.2}  {:.2}",
                corrector.name(),
                1e3 * seconds / (span * f64::from(STARTS)),
                counts.steps / runs,
                counts.rejected / runs,
                counts.evaluations / runs,
                counts.jacobians / runs,
                1e6 * seconds / (counts.steps + counts.rejected) as f64,
                seconds / least[0].as_secs_f64()
            );
        }
    }
}
