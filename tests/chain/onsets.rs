//! Contacts begin at the same times and speeds wherever steps fall, and no step jumps over one that matters.

use crate::common;
use std::sync::Arc;

use crate::common::scenes::{Noise, Scene, geared_drive};
use rustchain::ForceLaws;
use rustchain::chain::contact::{HingePath, ToothPath};
use rustchain::chain::dynamics::Dynamics;
use rustchain::geometry::Contact;
use rustchain::integrator::{Corrector, StepControl};
use rustchain::math::Table;

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
        dynamics.forget_ended_contacts();
        let step = adams.step_second_order(&mut dynamics).unwrap();
        dynamics.record_contact_events(&adams, &step);
        adams.limit_step(dynamics.longest_step_past_teeth());
        seen.steps += 1;
        let depths = dynamics.hinge_contacts().map(|(depth, _)| depth);
        let depths = depths.chain(dynamics.candidates().map(|(.., depth, _)| depth));
        seen.deepest = depths.fold(seen.deepest, f64::max);
        let speeds = dynamics.memory.hinge_impact_velocity().iter();
        let speeds = speeds.chain(&dynamics.memory.tooth_impact_velocity);
        for (pair, (&speed, live)) in speeds.zip(&mut live).enumerate() {
            let was_live = std::mem::replace(live, speed > 0.0);
            if !look || was_live || *live {
                continue;
            }
            let depth: Box<dyn Fn(f64) -> f64> = if pair < n {
                let path = HingePath::new(model, &adams, pair);
                Box::new(move |t| path.at(t).penetration)
            } else {
                let path = ToothPath::new(model, &adams, pair % n, pair / n - 1);
                Box::new(move |t| path.at(t).contact.penetration)
            };
            for i in 1..16 {
                let t = step.start + f64::from(i) / 16.0 * (step.end - step.start);
                seen.unseen = seen.unseen.max(depth(t));
            }
        }
    }
    seen.onsets = dynamics.memory.counts().onsets;
    seen.onset_speeds = dynamics.memory.hinge_impact_velocity().to_vec();
    seen.onset_speeds
        .extend(&dynamics.memory.tooth_impact_velocity);
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
        assert!(fine < 1e-5 && rough < 1e-2, "{max_step:e}: {fine} {rough}");
    }
}

#[test]
fn a_pair_along_a_step_is_where_the_whole_state_has_it() {
    let mut pulled = common::paper_drive();
    pulled.tensioner = Some(common::tensioner(100.0, 1e-4));
    let laws = ForceLaws::default();
    let mut ring = Scene::ring(8, &laws);
    ring.shake(&mut Noise(3), 1e-5, 0.3);
    let table = Table::new("speed", "rad/s", &[(0.0, 0.0), (1e-3, 100.0)]).unwrap();
    for scene in [
        Scene::laid(&pulled, &laws),
        Scene::laid(&geared_drive([17, 17], 38, table), &laws),
        ring,
    ] {
        let (mut dynamics, mut adams) = scene.ready(explicit(1e-6, 1e-3));
        let model = &scene.model;
        let n = model.links;
        let mut y = vec![0.0; scene.dimension()];
        let mut teeth = 0;
        for _ in 0..40 {
            let step = adams.step_second_order(&mut dynamics).unwrap();
            dynamics.record_contact_events(&adams, &step);
            for part in [0.0, 0.3, 1.0] {
                let t = step.start + part * (step.end - step.start);
                adams.interpolate(t, &mut y);
                dynamics.evaluate(t, &y);
                let same = |contact: &Contact, depth: f64, rate: f64| {
                    let off = (contact.penetration - depth).abs();
                    let rate_off = (contact.penetration_rate - rate).abs();
                    // Where a pin is in the middle of its bushing to round-off, it has no direction.
                    let middle = contact.penetration + model.hinges.clearance < 1e-9;
                    assert!(off < 1e-15, "{off:e} m");
                    assert!(rate_off < 1e-10 || middle, "{rate_off:e} m/s");
                };
                for k in 0..n {
                    let contact = HingePath::new(model, &adams, k).at(t);
                    let hinges = &dynamics.evaluated.hinges;
                    same(&contact, hinges.penetration[k], hinges.rate[k]);
                }
                for &pair in &dynamics.evaluated.teeth.near {
                    let (pair, found) = (pair as usize, &dynamics.evaluated.teeth);
                    let path = ToothPath::new(model, &adams, pair % n, pair / n);
                    let at = path.at(t);
                    same(&at.contact, found.penetration[pair], found.rate[pair]);
                    assert_eq!(at.gap, found.gap[pair]);
                    teeth += 1;
                }
            }
        }
        assert!(teeth > 0);
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
            assert!(large.onsets > 10);
            // Grazing contacts may come and go with the steps: one in 67 did, none in 153 and 190.
            assert!(large.onsets.abs_diff(small.onsets) <= 1 + small.onsets / 20);
            assert!(
                large.unseen < 1e-3 * large.deepest,
                "{name}: {:e} m",
                large.unseen
            );
        }
    }
}

/// A ring of links in free flight past a sprocket, its lowest bushing 1 um deep in a tip at most.
fn grazing_ring(speed: f64) -> (Scene, f64) {
    let mut scene = Scene::ring(8, &ForceLaws::default());
    let (n, from) = (scene.model.links, -0.02);
    let duration = 0.04 / speed;
    let laid = scene.motion.clone();
    // The floating sprocket is out of the way.
    scene.motion.y[n + 1] = 1.0;
    scene.motion.vx[..n].fill(speed);
    let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
    let mut deepest = |scene: &mut Scene, height: f64| {
        let mut deepest = f64::NEG_INFINITY;
        for i in 0..=4000 {
            let t = duration * f64::from(i) / 4000.0;
            for k in 0..n {
                scene.motion.x[k] = laid.x[k] + from + speed * t;
                scene.motion.y[k] = laid.y[k] + height;
            }
            dynamics.evaluate(t, &scene.y());
            deepest = (dynamics.evaluated.teeth.penetration.iter()).fold(deepest, |a, &b| a.max(b));
        }
        deepest
    };
    let (mut low, mut high) = (0.03, 0.05);
    while high - low > 1e-10 {
        let middle = 0.5 * (low + high);
        if deepest(&mut scene, middle) > 1e-6 {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert!((deepest(&mut scene, low) - 1e-6).abs() < 1e-8);
    for k in 0..n {
        scene.motion.x[k] = laid.x[k] + from;
    }
    (scene, duration)
}

/// Steps until the first onset, and its speed \[m/s\].
fn first_onset(scene: &Scene, control: StepControl, duration: f64) -> (usize, f64) {
    let (mut dynamics, mut adams) = scene.ready(control);
    let before = dynamics.memory.counts().onsets;
    let mut steps = 0;
    while dynamics.memory.counts().onsets == before {
        assert!(adams.time() < duration, "no onset in {steps} steps");
        dynamics.forget_ended_contacts();
        let step = adams.step_second_order(&mut dynamics).unwrap();
        dynamics.record_contact_events(&adams, &step);
        adams.limit_step(dynamics.longest_step_past_teeth());
        steps += 1;
    }
    let speeds = dynamics.memory.hinge_impact_velocity().iter();
    let speeds = speeds.chain(&dynamics.memory.tooth_impact_velocity);
    (steps, speeds.fold(0.0, |a, &b| a.max(b)))
}

#[test]
fn a_touch_that_is_over_before_the_step_is_not_jumped_over() {
    let (scene, duration) = grazing_ring(10.0);
    let newton = StepControl {
        corrector: Corrector::Newton,
        ..explicit(1e-2, 1e-3)
    };
    let (many, expected) = first_onset(&scene, explicit(1e-8, 1e-6), duration);
    for control in [explicit(1e-2, 1e-3), newton] {
        let (steps, speed) = first_onset(&scene, control, duration);
        // The touch lasts 29 us, the flight a hundred times as long.
        assert!(steps < 80 && many > 1000);
        assert!((speed - expected).abs() < 0.05 * expected);
    }
}

#[test]
fn a_contact_that_opens_and_closes_inside_a_step_begins_anew() {
    let mut scene = Scene::ring(8, &ForceLaws::default());
    let (n, clearance, speed) = (scene.model.links, scene.model.hinges.clearance, 10.0);
    scene.motion.y[..n].iter_mut().for_each(|y| *y += 0.5);
    // A link in touch with both neighbours, thrown at their other sides.
    scene.motion.x[2] += clearance + 1e-11;
    scene.motion.vx[2] = -speed;
    // Not deep: with the memory of the first touch the second one is damped ten thousand times as strongly.
    let once = (2.0 * clearance + 3e-11) / speed;
    for (max_step, steps) in [(once, 1..=1), (1e-7, 40..=60)] {
        let (mut dynamics, mut adams) = scene.ready(explicit(1e-2, max_step));
        assert_eq!(dynamics.memory.counts().onsets, 2);
        let mut made = 0;
        while adams.time() < once {
            dynamics.forget_ended_contacts();
            let step = adams.step_second_order(&mut dynamics).unwrap();
            dynamics.record_contact_events(&adams, &step);
            made += 1;
        }
        let depths: Vec<f64> = dynamics.hinge_contacts().map(|(depth, _)| depth).collect();
        assert!(steps.contains(&made), "{made} steps");
        assert!(depths[1] > 0.0 && depths[2] > 0.0);
        assert_eq!(dynamics.memory.counts().onsets, 4, "{made} steps");
        for k in [1, 2] {
            let onset = dynamics.memory.hinge_impact_velocity()[k];
            assert!((onset - speed).abs() < 1e-3 * speed, "{onset} m/s");
        }
    }
}

#[test]
fn no_step_moves_a_bushing_past_a_tooth() {
    let mut scene = Scene::ring(8, &ForceLaws::default());
    let (n, speed) = (scene.model.links, 10.0);
    // In free flight nothing else holds the steps.
    scene.motion.y[..n].iter_mut().for_each(|y| *y += 0.5);
    scene.motion.vx[..n].fill(speed);
    let (mut dynamics, mut adams) = scene.ready(explicit(1e-2, 1e-3));
    let mut longest: f64 = 0.0;
    while adams.time() < 5e-3 {
        dynamics.forget_ended_contacts();
        let step = adams.step_second_order(&mut dynamics).unwrap();
        dynamics.record_contact_events(&adams, &step);
        adams.limit_step(dynamics.longest_step_past_teeth());
        longest = longest.max(step.end - step.start);
    }
    let pitches = speed * longest / (2.0 * scene.model.half_pitch);
    assert!(pitches > 0.09 && pitches <= 0.1, "{pitches} pitches");
}
