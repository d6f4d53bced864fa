//! Run time against error in Rust alone: a planet, a bouncing pin, the published drive with each instruction set, long chains.
//!
//! Prints a line of JSON for each run, which `work_precision.py` reads.

#![allow(clippy::print_stdout)] // a benchmark's figures
#![allow(clippy::unwrap_used)] // a benchmark whose drives cannot be built has nothing to say

mod common;
#[path = "work_precision/problems.rs"]
mod problems;

use common::drives;
use common::{Halves, laws, longer_drive, only_tried, pressed_into_seats};
use cpu_time::ThreadTime;
use problems::{Kepler, Pin};
use rustchain::ForceLaws;
use rustchain::force_law::{Damping, Elastic};
use rustchain::integrator::{Adams, Corrector, OdeSystem, StepControl};
use rustchain::math::simd::InstructionSet;

/// Timed runs of a planet or a pin.
const REPEATS: usize = 30;

/// Links of the sweep: of 38 to 2432.
const LINKS: [u32; 4] = [38, 152, 608, 2432];

/// Span of the sweep \[s\]: at least 300 steps of Newton's method for every chain.
const SPAN: f64 = 8e-3;

fn main() {
    let tolerances = [
        1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 3e-14,
    ];
    let mut cases = Vec::new();
    for tolerance in tolerances {
        for corrector in CORRECTORS {
            cases.push(Case::new("kepler", corrector, tolerance, kepler));
        }
    }
    for lambda in [0.0, Damping::LankaraniNikravesh.lambda(0.71)] {
        let name = if lambda == 0.0 { "pin" } else { "damped_pin" };
        for tolerance in tolerances {
            for corrector in CORRECTORS {
                let run = move |tolerance, corrector| pin(tolerance, lambda, corrector);
                cases.push(Case::new(name, corrector, tolerance, run));
            }
        }
    }
    // In turn: other load, for a while, would slow all runs of one case.
    for _ in 0..if only_tried() { 1 } else { REPEATS } {
        for case in &mut cases {
            case.go_on();
        }
    }
    cases.iter().for_each(Case::say);
    instruction_sets();
    chain_lengths();
}

/// What a run came to.
struct Known {
    wall: f64,
    steps: u64,
    evaluations: u64,
    error: f64,
}

/// A problem with a corrector and a tolerance, and its runs.
struct Case {
    problem: &'static str,
    corrector: Corrector,
    tolerance: f64,
    run: Box<dyn Fn(f64, Corrector) -> Known>,
    runs: Vec<Known>,
}

impl Case {
    fn new(
        problem: &'static str,
        corrector: Corrector,
        tolerance: f64,
        run: impl Fn(f64, Corrector) -> Known + 'static,
    ) -> Self {
        Self {
            problem,
            corrector,
            tolerance,
            run: Box::new(run),
            runs: Vec::new(),
        }
    }

    fn go_on(&mut self) {
        self.runs.push((self.run)(self.tolerance, self.corrector));
    }

    fn say(&self) {
        let (problem, method, tolerance) = (self.problem, self.corrector.name(), self.tolerance);
        let walls: Vec<f64> = self.runs.iter().map(|run| run.wall).collect();
        let Known {
            steps,
            evaluations,
            error,
            ..
        } = self.runs[0];
        println!(
            "{{\"kind\": \"{problem}\", \"method\": \"{method}\", \"tolerance\": {tolerance:e}, \"walls\": {walls:?}, \"steps\": {steps}, \
             \"evaluations\": {evaluations}, \"error\": {error:e}}}"
        );
    }
}

fn smooth_control(tolerance: f64, corrector: Corrector) -> StepControl {
    StepControl {
        max_step: 1.0,
        corrector,
        ..drives::control(tolerance)
    }
}

/// Ten periods; error as the distance from where the planet should be.
fn kepler(tolerance: f64, corrector: Corrector) -> Known {
    let end = 20.0 * std::f64::consts::PI;
    let mut adams = Adams::new(4, smooth_control(tolerance, corrector));
    let mut planet = Kepler::default();
    adams.restart(0.0, &Kepler::START);
    let begin = ThreadTime::now();
    while adams.time() < end {
        adams.step_second_order(&mut planet).unwrap();
    }
    let mut y = [0.0; 4];
    adams.interpolate(end, &mut y);
    let wall = begin.elapsed().as_secs_f64();
    known(
        &adams,
        wall,
        (y[0] - Kepler::START[0]).hypot(y[1] - Kepler::START[1]),
    )
}

/// One bounce; error of the position at the end without damping, of the final speed with it.
fn pin(tolerance: f64, lambda: f64, corrector: Corrector) -> Known {
    let mut pin = Pin::new(lambda);
    let mut adams = Adams::new(2, smooth_control(tolerance, corrector));
    adams.restart(0.0, &Pin::START);
    let begin = ThreadTime::now();
    while adams.time() < Pin::END {
        let step = adams.step_second_order(&mut pin).unwrap();
        let depth = adams.y()[0];
        pin.watch(step.start, step.end, depth, |t| {
            let at = adams.dense(t);
            [at.value(0), at.value(1)]
        });
    }
    let mut y = [0.0; 2];
    adams.interpolate(Pin::END, &mut y);
    let wall = begin.elapsed().as_secs_f64();
    known(&adams, wall, pin.error(&y))
}

fn known(adams: &Adams, wall: f64, error: f64) -> Known {
    Known {
        wall,
        steps: adams.counts().steps,
        evaluations: adams.counts().evaluations,
        error,
    }
}

/// All correctors, and those that a sweep tells apart.
const CORRECTORS: [Corrector; 3] = [Corrector::Pece, Corrector::Newton, Corrector::Auto];
const FORCED: [Corrector; 2] = [Corrector::Pece, Corrector::Newton];

fn control(corrector: Corrector) -> StepControl {
    StepControl {
        corrector,
        ..StepControl::default()
    }
}

/// Goes on to `end` with each step as a run makes it; steps, and the time that they took \[s\].
fn walk(run: &mut Halves, end: f64) -> (u64, f64) {
    let before = run.adams.counts().steps;
    let begin = ThreadTime::now();
    while run.adams.time() < end {
        run.dynamics.forget_ended_contacts();
        let step = run.adams.step_second_order(&mut run.dynamics).unwrap();
        run.dynamics.record_contact_events(&run.adams, &step);
    }
    (
        run.adams.counts().steps - before,
        begin.elapsed().as_secs_f64(),
    )
}

/// A run of `drive` from where `ready` is, with another corrector.
fn with_control(ready: &Halves, control: StepControl) -> Halves {
    let mut run = ready.clone();
    run.adams = Adams::new(ready.dynamics.dimension(), control);
    run.adams.restart(ready.adams.time(), ready.adams.y());
    run
}

/// The published drive from 10 ms on, with all instruction sets in turns.
fn instruction_sets() {
    let law = laws(Elastic::Hertz, Damping::LankaraniNikravesh);
    for pretension in [0.0, 25.0, 100.0] {
        let mut drive = drives::paper_drive();
        if pretension > 0.0 {
            drive.tensioner = Some(drives::tensioner(pretension, 1e-3));
        }
        let mut simulation = drives::simulation(&drive, &law, control(Corrector::Newton));
        drives::advance(&mut simulation, 10e-3);
        let ready = Halves::of(&mut simulation);
        for corrector in FORCED {
            let sets = InstructionSet::available();
            let mut least = vec![f64::INFINITY; sets.len()];
            let mut steps = 0;
            for _ in 0..if only_tried() { 1 } else { 8 } {
                for (set, least) in sets.iter().zip(&mut least) {
                    let mut run = with_control(&ready, control(corrector));
                    run.dynamics.use_instructions(*set);
                    run.adams.use_instructions(*set);
                    let (made, wall) = walk(&mut run, 14e-3);
                    *least = least.min(wall / made as f64);
                    steps = made;
                }
            }
            for (set, least) in sets.iter().zip(&least) {
                println!(
                    "{{\"kind\": \"instructions\", \"pretension\": {pretension}, \"method\": \"{}\", \"set\": \"{}\", \
                     \"steps\": {steps}, \"wall_step\": {least:e}}}",
                    corrector.name(),
                    set.name()
                );
            }
        }
    }
}

/// Chains pulled into all hinges and seats at once: cost of a simulated second over links.
fn chain_lengths() {
    let law: ForceLaws = laws(Elastic::Hertz, Damping::LankaraniNikravesh);
    let end = if only_tried() { 2e-4 } else { SPAN };
    let chains = LINKS.map(|links| {
        Halves::of(&mut pressed_into_seats(
            &longer_drive([17, 17], links),
            &law,
        ))
    });
    for corrector in FORCED {
        let mut found = [(0, f64::INFINITY); LINKS.len()];
        for _ in 0..if only_tried() { 1 } else { 3 } {
            for (ready, (steps, least)) in chains.iter().zip(&mut found) {
                let (made, wall) = walk(&mut with_control(ready, control(corrector)), end);
                (*steps, *least) = (made, least.min(wall));
            }
        }
        for (links, (steps, least)) in LINKS.into_iter().zip(found) {
            println!(
                "{{\"kind\": \"links\", \"method\": \"{}\", \"links\": {links}, \"steps\": {steps}, \"wall\": {:e}, \"wall_step\": {:e}}}",
                corrector.name(),
                least / end,
                least / steps as f64
            );
        }
    }
}
