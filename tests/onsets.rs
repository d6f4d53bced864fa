//! Contacts begin at the same times and speeds wherever steps fall, and no step jumps over one that matters.

#![allow(clippy::unwrap_used)]

mod common;

use common::scenes::{Noise, Scene, geared_drive};
use rustchain::ForceLaws;
use rustchain::contact::{hinge_at, tooth_at};
use rustchain::integrator::{Corrector, StepControl};

/// What a run has seen of its contacts.
#[derive(Debug, Default)]
struct Seen {
    steps: usize,
    /// Onset speeds of all hinges and of all pairs of bushing and sprocket at the end \[m/s\].
    onset_speeds: Vec<f64>,
    onsets: u64,
    /// Deepest touch inside a step of a pair that is apart and without memory at both of its ends \[m\].
    unseen: f64,
    /// Deepest touch at the end of a step \[m\].
    deepest: f64,
}

/// Runs `scene` for `duration`; with `look`, also inside the steps.
fn run(scene: &Scene, control: StepControl, duration: f64, look: bool) -> Seen {
    let (mut dynamics, mut adams) = scene.ready(control);
    let model = &scene.model;
    let n = model.links;
    let mut seen = Seen::default();
    let mut live = vec![false; n * (1 + model.sprockets.len())];
    while adams.time() < duration {
        dynamics.begin_step();
        let step = adams.step_second_order(&mut dynamics).unwrap();
        dynamics.finish_step(&adams, &step);
        seen.steps += 1;
        let depths = dynamics.hinge_contacts().map(|(depth, _)| depth);
        let depths = depths.chain(dynamics.candidates().map(|(.., depth, _)| depth));
        seen.deepest = depths.fold(seen.deepest, f64::max);
        let speeds = dynamics.memory.hinge_speed().iter();
        let speeds = speeds.chain(&dynamics.memory.tooth_speed);
        for (pair, (&speed, live)) in speeds.zip(&mut live).enumerate() {
            let was_live = std::mem::replace(live, speed > 0.0);
            if !look || was_live || *live {
                continue;
            }
            for i in 1..16 {
                let t = step.start + f64::from(i) / 16.0 * (step.end - step.start);
                let depth = if pair < n {
                    hinge_at(model, &adams, pair, t).penetration
                } else {
                    tooth_at(model, &adams, pair % n, pair / n - 1, t)
                        .map_or(0.0, |found| found.contact.penetration)
                };
                seen.unseen = seen.unseen.max(depth);
            }
        }
    }
    seen.onsets = dynamics.memory.counts().onsets;
    seen.onset_speeds = dynamics.memory.hinge_speed().to_vec();
    seen.onset_speeds.extend(&dynamics.memory.tooth_speed);
    seen
}

fn explicit(tolerance: f64, max_step: f64) -> StepControl {
    StepControl {
        max_step,
        ..common::control(tolerance)
    }
}

fn implicit(accuracy: f64, max_step: f64) -> StepControl {
    StepControl {
        corrector: Corrector::Newton,
        accuracy,
        max_step,
        ..StepControl::default()
    }
}

#[test]
fn onset_speeds_do_not_depend_on_where_steps_fall() {
    let scene = Scene::laid(&geared_drive([17, 17], 38, 628.3), &ForceLaws::default());
    let reference = run(&scene, explicit(1e-12, 1e-2), 2e-4, false);
    println!("{} onsets", reference.onsets);
    assert!(reference.onsets > 3);
    let off = |control| {
        let seen = run(&scene, control, 2e-4, false);
        assert_eq!(seen.onsets, reference.onsets, "{control:?}");
        let pairs = seen.onset_speeds.iter().zip(&reference.onset_speeds);
        pairs
            .map(|(a, b)| (a - b).abs() / b.max(1e-3))
            .fold(0.0, f64::max)
    };
    for max_step in [1e-2, 1e-5, 1e-6] {
        let (fine, rough) = (
            off(explicit(1e-11, max_step)),
            off(explicit(1e-8, max_step)),
        );
        println!("max_step {max_step:e}: {fine:.1e} at 1e-11, {rough:.1e} at 1e-8");
        assert!(fine < 1e-5 && rough < 1e-2, "{max_step:e}: {fine} {rough}");
    }
}

/// Drives in which bodies are fast: a fast sprocket; a chain thrown at its sprockets; links thrown about.
fn fast_scenes() -> [(&'static str, Scene); 3] {
    let laws = ForceLaws::default();
    let turning = Scene::laid(&geared_drive([17, 17], 38, 628.3), &laws);
    let mut thrown = Scene::laid(&common::paper_drive(), &laws);
    thrown.motion.vy[..38].fill(10.0);
    let mut about = Scene::laid(&common::paper_drive(), &laws);
    about.shake(&mut Noise(5), 0.0, 10.0);
    [("6000 rpm", turning), ("thrown", thrown), ("about", about)]
}

#[test]
fn large_steps_miss_no_contact_of_fast_bodies() {
    for (name, mut scene) in fast_scenes() {
        // What is held or driven keeps its motion.
        let n = scene.model.links;
        for s in 0..scene.model.sprockets.len() {
            (scene.motion.vx[n + s], scene.motion.vy[n + s]) = (0.0, 0.0);
        }
        for control in [explicit, implicit] {
            let tolerance = if control(1.0, 1.0).corrector == Corrector::Pece {
                1e-5
            } else {
                1e-9
            };
            let large = run(&scene, control(tolerance, 1e-2), 2e-4, true);
            let small = run(&scene, control(tolerance, 2e-7), 2e-4, true);
            println!(
                "{name} {:?}: {} and {} steps, {} and {} onsets, unseen {:.1e} and {:.1e} m of {:.1e} m",
                control(1.0, 1.0).corrector,
                large.steps,
                small.steps,
                large.onsets,
                small.onsets,
                large.unseen,
                small.unseen,
                large.deepest
            );
            assert!(large.onsets > 10);
            assert!(
                large.unseen < 1e-3 * large.deepest,
                "{name}: {:e} m",
                large.unseen
            );
        }
    }
}
