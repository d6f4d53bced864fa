//! Time per link of a right-hand side and of a step, and memory per link, for chains of 38 to 9728 links.
//!
//! Two sprockets of 17 teeth and long strands: what a link costs should not depend on how many there are. The candidates on the
//! teeth are as many for every length and weigh on short chains.

#![allow(clippy::print_stdout)] // a benchmark's figures
#![allow(clippy::unwrap_used)] // a benchmark whose drives cannot be built has nothing to say
#![allow(unsafe_code)] // a counting allocator has to be one

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Effort, Halves, laws, longer_drive, only_tried, pressed_into_seats, race};
use rustchain::Simulation;
use rustchain::chain::dynamics::Dynamics;
use rustchain::force_law::{Damping, Elastic};
use rustchain::integrator::OdeSystem;
use rustchain::math::simd::InstructionSet;

const LINKS: [u32; 5] = [38, 152, 608, 2432, 9728];

/// Calls that give one batch about the same length for every chain, in links.
const LINKS_PER_BATCH: usize = 40_000;

/// Steps that a batch walks.
const STEPS: usize = 20;

/// Counts the bytes in use.
struct Weighing;

static IN_USE: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Weighing {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        IN_USE.fetch_add(layout.size(), Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        IN_USE.fetch_add(size, Ordering::Relaxed);
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static WEIGHING: Weighing = Weighing;

fn main() {
    let sets = InstructionSet::available();
    println!("ns a link; in brackets over the least of all chains with the same instructions");
    print!("{:<40}", "links");
    for links in LINKS {
        print!("{links:>14}");
    }
    println!();
    let at_start = |links| {
        common::at_start_of(
            &longer_drive([17, 17], links),
            &laws(Elastic::Hertz, Damping::LankaraniNikravesh),
        )
    };
    let pressed = |links| {
        pressed_into_seats(
            &longer_drive([17, 17], links),
            &laws(Elastic::Hertz, Damping::LankaraniNikravesh),
        )
    };
    let starts: Vec<Simulation> = LINKS.into_iter().map(at_start).collect();
    let presses: Vec<Simulation> = LINKS.into_iter().map(pressed).collect();
    for (state, simulations) in [("nothing touches", &starts), ("pressed", &presses)] {
        for set in &sets {
            let times: Vec<f64> = simulations
                .iter()
                .map(|simulation| derivative(simulation.clone(), *set))
                .collect();
            print_row(&format!("right-hand side, {state}, {}", set.name()), &times);
        }
    }
    for (state, simulations) in [("nothing touches", &starts), ("pressed", &presses)] {
        for set in &sets {
            let times: Vec<f64> = simulations
                .iter()
                .map(|simulation| steps(simulation.clone(), *set))
                .collect();
            print_row(&format!("step, {state}, {}", set.name()), &times);
        }
    }
    print!("{:<40}", "bytes a link that Dynamics holds");
    for simulation in &starts {
        let before = IN_USE.load(Ordering::Relaxed);
        let dynamics = Dynamics::new(simulation.model().clone());
        let bytes = IN_USE.load(Ordering::Relaxed) - before;
        print!("{:>14}", bytes / dynamics.model().links);
    }
    println!();
}

/// Least time of a right-hand side over the number of links \[ns\].
fn derivative(mut simulation: Simulation, set: InstructionSet) -> f64 {
    let Halves {
        mut dynamics,
        adams,
    } = Halves::of(&mut simulation);
    dynamics.use_instructions(set);
    let (t, y) = (adams.time(), adams.y().to_vec());
    let mut dydt = y.clone();
    let links = dynamics.model().links;
    let effort = Effort {
        batches: 100,
        calls: LINKS_PER_BATCH / links,
    };
    let mut call = || dynamics.derivative(black_box(t), black_box(&y), &mut dydt);
    call();
    race(effort.or_once(), &mut [Box::new(call)])[0] / links as f64
}

/// Least time of a step over the number of links \[ns\], of the first ones from a start.
fn steps(mut simulation: Simulation, set: InstructionSet) -> f64 {
    let mut ready = Halves::of(&mut simulation);
    ready.dynamics.use_instructions(set);
    ready.adams.use_instructions(set);
    let links = ready.dynamics.model().links;
    let batches = (2_000_000 / (STEPS * links)).max(60);
    let mut least = f64::INFINITY;
    for _ in 0..if only_tried() { 1 } else { batches } {
        let mut run = ready.clone();
        let begin = std::time::Instant::now();
        for _ in 0..STEPS {
            run.step();
        }
        let time = begin.elapsed().as_secs_f64() * 1e9;
        least = least.min(time / (STEPS * links) as f64);
    }
    least
}

fn print_row(what: &str, times: &[f64]) {
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    print!("{what:<40}");
    for time in times {
        print!("{time:>8.2} ({:.2})", time / least);
    }
    println!();
}
