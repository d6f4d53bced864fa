//! What friction costs: the paper's drive under way with and without it, of the slip speed and of bristles, counts beside times.

#![allow(clippy::unwrap_used)] // a benchmark whose scenes cannot be built has nothing to say
#![allow(clippy::print_stdout)] // its figures

mod common;

use std::time::Duration;

use common::{drives, only_tried};
use cpu_time::ProcessTime;
use rustchain::ForceLaws;
use rustchain::force_law::{Friction, LuGre, Regularization};
use rustchain::integrator::{Counts, StepControl};

/// Simulated time, the same from 8 ms on for all \[s\].
const SPAN: f64 = 0.1;

/// Runs of each, one after the other; the least time counts.
const REPEATS: usize = 5;

fn run(laws: &ForceLaws, pretension: f64, span: f64) -> (Duration, Counts) {
    let mut drive = drives::paper_drive();
    drive.tensioner = Some(drives::tensioner(pretension, 2e-3));
    let mut simulation = drives::simulation(&drive, laws, StepControl::default());
    let begin = ProcessTime::now();
    drives::advance(&mut simulation, span);
    (begin.elapsed(), simulation.statistics().counts)
}

/// The laws that are compared; the first has no friction.
fn scenes() -> [(&'static str, ForceLaws); 8] {
    let law = |coefficient| {
        Some(Friction {
            coefficient,
            regularization: Regularization::Tanh,
            speed: 1e-3,
            dead_speed: 0.0,
        })
    };
    let threlfall = law(0.1).map(|law| Friction {
        regularization: Regularization::Threlfall,
        ..law
    });
    let bristles = |coefficient| {
        Some(LuGre {
            static_coefficient: coefficient,
            kinetic_coefficient: coefficient,
            stiffness: 1e5,
            damping: 0.3,
            viscous_coefficient: 0.0,
            stribeck_speed: 1e-3,
            stribeck_exponent: 2.0,
        })
    };
    [
        ("none", ForceLaws::default()),
        (
            "hinges 0.1",
            ForceLaws {
                hinge_friction: law(0.1),
                ..ForceLaws::default()
            },
        ),
        (
            "teeth 0.1",
            ForceLaws {
                tooth_friction: law(0.1),
                ..ForceLaws::default()
            },
        ),
        (
            "both 0.1",
            ForceLaws {
                hinge_friction: law(0.1),
                tooth_friction: law(0.1),
                ..ForceLaws::default()
            },
        ),
        (
            "Threlfall 0.1",
            ForceLaws {
                hinge_friction: threlfall,
                tooth_friction: threlfall,
                ..ForceLaws::default()
            },
        ),
        (
            "bristles in hinges 0.1",
            ForceLaws {
                hinge_bristles: bristles(0.1),
                ..ForceLaws::default()
            },
        ),
        (
            "bristles 0.1",
            ForceLaws {
                hinge_bristles: bristles(0.1),
                tooth_bristles: bristles(0.1),
                ..ForceLaws::default()
            },
        ),
        (
            "both 0.3",
            ForceLaws {
                hinge_friction: law(0.3),
                tooth_friction: law(0.3),
                ..ForceLaws::default()
            },
        ),
    ]
}

fn main() {
    let scenes = scenes();
    let (span, repeats) = if only_tried() {
        (1e-3, 1)
    } else {
        (SPAN, REPEATS)
    };
    println!(
        "pretension, friction, processor ms a simulated second, steps, evaluations, factorisations, time over that without"
    );
    for pretension in [25.0, 100.0] {
        let mut least = [Duration::MAX; 8];
        let mut counts = [Counts::default(); 8];
        for _ in 0..repeats {
            for ((_, laws), (least, counts)) in scenes.iter().zip(least.iter_mut().zip(&mut counts))
            {
                let (time, found) = run(laws, pretension, span);
                *least = time.min(*least);
                *counts = found;
            }
        }
        for ((name, _), (time, counts)) in scenes.iter().zip(least.iter().zip(&counts)) {
            println!(
                "{pretension:5} N  {name:22}  {:7.0}  {:6}  {:6}  {:6}  {:.2}",
                1e3 * time.as_secs_f64() / span,
                counts.steps,
                counts.evaluations,
                counts.jacobians,
                time.as_secs_f64() / least[0].as_secs_f64()
            );
        }
    }
}
