//! No contact is missed: what the kernels find among their candidates is what brute force over all pairs finds.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::scalar_reference::Reference;
use crate::common::scenes::{Noise, Scene, geared_drive, laws};
use crate::common::{control, paper_drive, roller_drive, tensioner};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rustchain::ForceLaws;
use rustchain::chain::contact::ContactId;
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::{Bearing, Drive, SprocketMotion};
use rustchain::force_law::{Damping, Elastic, Regions};
use rustchain::geometry::{Seat, ToothProfile, Vec2, unit};
use rustchain::integrator::OdeSystem;
use rustchain::math::Table;
use rustchain::math::simd::InstructionSet;
use rustchain::system::System;

/// Depth \[m\] that a contact needs to be above rounding: a hundred times the rounding of coordinates of a metre.
const ROUNDING: f64 = 3e-14;

/// Asserts that kernels (as last evaluated) and brute force find the same pairs at the same depths; says how many.
fn assert_none_missed(dynamics: &mut Dynamics, t: f64, y: &[f64]) -> usize {
    let kernels: Vec<_> = dynamics.candidates().filter(|c| c.2 > 0.0).collect();
    dynamics.evaluate(t, y);
    let links = dynamics.model().links;
    let reference = Reference::of(dynamics, t, y);
    let depth_of = |pair: usize| {
        reference.teeth[pair].map_or(f64::NEG_INFINITY, |tooth| tooth.contact.penetration)
    };
    let mut missing: Vec<usize> = (0..reference.teeth.len())
        .filter(|&pair| depth_of(pair) > ROUNDING)
        .collect();
    let count = missing.len();
    for (s, k, depth, _) in kernels {
        let pair = s * links + k;
        let expected = depth_of(pair).max(0.0);
        assert!(
            (depth - expected).abs() < ROUNDING,
            "bushing {k} on sprocket {s} at {t} s: {depth:e} m, by brute force {expected:e} m"
        );
        missing.retain(|&other| other != pair);
    }
    assert!(
        missing.is_empty(),
        "missed at {t} s: pairs {missing:?} of {links} links"
    );
    count
}

/// What a run met.
#[derive(Debug, Default)]
struct Met {
    steps: usize,
    contacts: usize,
    refreshes: u64,
    onsets: u64,
    /// Bushings that were seen in a gap other than the one of their last contact.
    other_gaps: usize,
}

/// Steps to `end` \[s\] and compares after every step; memory must be that of the contacts then, too.
fn run(scene: &Scene, tolerance: f64, end: f64) -> Met {
    let (mut dynamics, mut adams) = scene.ready(control(tolerance));
    let mut gaps = vec![None; scene.model.links * scene.model.sprockets.len()];
    let mut met = Met::default();
    while adams.time() < end {
        dynamics.forget_ended_contacts();
        let step = adams.step(&mut dynamics).unwrap();
        dynamics.record_contact_events(&adams, &step);
        let y = adams.y().to_vec();
        met.contacts += assert_none_missed(&mut dynamics, adams.time(), &y);
        assert_memory_is_that_of_contacts(&dynamics);
        for &pair in &dynamics.evaluated.teeth.near {
            let pair = pair as usize;
            if dynamics.evaluated.teeth.penetration[pair] > ROUNDING {
                let gap = dynamics.evaluated.teeth.gap[pair];
                met.other_gaps += usize::from(gaps[pair].is_some_and(|before| before != gap));
                gaps[pair] = Some(gap);
            }
        }
        met.steps += 1;
    }
    met.refreshes = dynamics.candidate_refreshes();
    met.onsets = dynamics.memory.counts().onsets;
    met
}

/// Pairs in contact have a memory, and pairs apart have one only until the next step begins.
fn assert_memory_is_that_of_contacts(dynamics: &Dynamics) {
    let ended = dynamics.ended_contacts();
    for (pair, &speed) in dynamics.memory.tooth_impact_velocity.iter().enumerate() {
        let depth = dynamics.evaluated.teeth.penetration[pair];
        if depth > ROUNDING {
            assert!(speed > 0.0, "pair {pair} at {depth:e} m has no memory");
        }
        if depth < -ROUNDING && speed > 0.0 {
            assert!(
                ended.contains(&ContactId::Tooth(pair)),
                "pair {pair} at {depth:e} m remembers"
            );
        }
    }
}

fn elastic_hertz() -> ForceLaws {
    laws(Elastic::Hertz, Damping::None, Regions::Kept)
}

#[test]
fn forward_and_backward_drives_miss_nothing_at_any_step() {
    for speed in [30.0, -30.0] {
        let mut drive = paper_drive();
        drive.sprockets[0].motion = SprocketMotion::PrescribedSpeed(speed.into());
        let met = run(&Scene::laid(&drive, &ForceLaws::default()), 1e-5, 0.04);
        assert!(met.contacts > 3 * met.steps && met.refreshes > 8, "{met:?}");
    }
}

#[test]
fn the_busiest_contact_has_the_largest_force_of_all_bodies() {
    let mut noise = Noise(7);
    for drive in [paper_drive(), roller_drive()] {
        for _ in 0..20 {
            let mut scene = Scene::laid(&drive, &ForceLaws::default());
            scene.shake(&mut noise, 4e-5, 0.1);
            let (mut dynamics, y) = (Dynamics::new(Arc::clone(&scene.model)), scene.y());
            dynamics.derivative(0.0, &y, &mut vec![0.0; y.len()]);
            let teeth = dynamics.candidates().map(|(.., force)| force);
            let joints = dynamics.hinge_contacts().chain(dynamics.roller_contacts());
            let forces = joints.map(|(_, force)| force).chain(teeth);
            let largest = forces.fold(0.0, f64::max);
            let busiest = System::busiest(&dynamics);
            let expected = format!("pressed by {largest:.3e} N");
            assert!(busiest.ends_with(&expected), "{busiest} for {expected}");
        }
    }
}

#[test]
fn a_drive_that_reverses_misses_nothing_at_any_step() {
    let rows = [(0.0, 40.0), (0.01, 40.0), (0.02, -40.0), (0.04, -40.0)];
    let table = Table::new("speed", "rad/s", &rows).unwrap();
    let drive = geared_drive([17, 17], 40, table);
    let met = run(&Scene::laid(&drive, &ForceLaws::default()), 1e-5, 0.035);
    assert!(met.contacts > 3 * met.steps && met.refreshes > 8, "{met:?}");
}

#[test]
fn six_thousand_turns_a_minute_and_unequal_sprockets_miss_nothing_at_any_step() {
    let fast = geared_drive([17, 17], 38, 200.0 * PI);
    let met = run(&Scene::laid(&fast, &ForceLaws::default()), 1e-4, 4e-3);
    assert!(met.refreshes > 15, "{met:?}");
    let unequal = geared_drive([9, 60], 100, 60.0);
    let met = run(&Scene::laid(&unequal, &elastic_hertz()), 1e-4, 0.015);
    assert!(2 * met.contacts > met.steps && met.refreshes > 3, "{met:?}");
}

#[test]
fn a_tensioned_sprocket_and_one_that_is_thrown_across_miss_nothing_at_any_step() {
    let drive = Drive {
        tensioner: Some(tensioner(25.0, 1e-3)),
        ..paper_drive()
    };
    let met = run(&Scene::laid(&drive, &ForceLaws::default()), 1e-5, 0.01);
    assert!(met.contacts > met.steps, "{met:?}");

    let mut drive = paper_drive();
    drive.sprockets[1].bearing = Bearing::Floating;
    let mut other_gaps = 0;
    for velocity in [[-60.0, 5.0], [-20.0, 40.0]] {
        let mut scene = Scene::laid(&drive, &elastic_hertz());
        let body = scene.model.links + 1;
        (scene.motion.vx[body], scene.motion.vy[body]) = (velocity[0], velocity[1]);
        scene.motion.spin[body] = 300.0;
        let met = run(&scene, 1e-4, 2e-3);
        assert!(met.refreshes > 10, "{met:?}");
        other_gaps += met.other_gaps;
    }
    assert!(other_gaps > 0);
}

#[test]
fn a_chain_that_jumps_over_teeth_misses_nothing_at_any_step() {
    // Hinges with room enough that bushings climb over the tips when their sprocket is jerked round.
    let mut drive = geared_drive([17, 17], 40, 5.0);
    drive.chain.hinge.bore_radius = 3.9e-3;
    drive.sprockets[1].center.x -= 2e-3;
    let mut scene = Scene::laid(&drive, &elastic_hertz());
    let mut noise = Noise(4);
    scene.shake(&mut noise, 0.0, 40.0);
    scene.motion.spin[scene.model.links + 1] = -900.0;
    let met = run(&scene, 1e-4, 0.01);
    assert!(met.other_gaps > 3 && met.refreshes > 100, "{met:?}");
}

/// Everything displaced or turned at once: the state of a step that went far.
fn moved(scene: &Scene, by: Vec2, link_turn: f64, sprocket_turn: f64) -> Vec<f64> {
    let mut scene = scene.clone();
    let n = scene.model.links;
    let center = scene.model.sprockets[0].center;
    for i in 0..n {
        let arm = Vec2::new(scene.motion.x[i], scene.motion.y[i]) - center;
        let turned = Vec2::new(
            arm.x * link_turn.cos() - arm.y * link_turn.sin(),
            arm.x * link_turn.sin() + arm.y * link_turn.cos(),
        );
        let place = center + turned + by;
        (scene.motion.x[i], scene.motion.y[i]) = (place.x, place.y);
        scene.motion.angle[i] += link_turn;
    }
    for s in 0..2 {
        scene.motion.angle[n + s] += sprocket_turn;
    }
    scene.y()
}

#[test]
fn a_state_that_is_a_gap_a_pitch_or_ten_pitches_or_any_angle_away_misses_nothing() {
    let mut drive = geared_drive([17, 25], 60, 10.0);
    drive.sprockets[1].bearing = Bearing::Floating;
    let mut scene = Scene::laid(&drive, &ForceLaws::default());
    scene.shake(&mut Noise(1), 2e-4, 0.1);
    let pitch = 2.0 * scene.model.half_pitch;
    let mut contacts = 0;
    for set in InstructionSet::available() {
        let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
        dynamics.use_instructions(set);
        let mut dydt = vec![0.0; scene.dimension()];
        let mut check = |y: &[f64]| {
            dynamics.derivative(0.0, y, &mut dydt);
            contacts += assert_none_missed(&mut dynamics, 0.0, y);
        };
        let gap = 2.0 * PI / 17.0;
        for step in [0.2, 0.35, 0.36, 0.49, 0.5, 0.51, 0.7, 0.72, 1.0, 10.0] {
            for direction in 0..16 {
                let by = step * pitch * unit(2.0 * PI * f64::from(direction) / 16.0);
                check(&moved(&scene, Vec2::zeros(), 0.0, 0.0));
                check(&moved(&scene, by, 0.0, 0.0));
                check(&moved(&scene, -by, 0.0, 0.0));
            }
        }
        for turn in 0..200 {
            let turn = 0.21 * gap * f64::from(turn);
            check(&moved(&scene, Vec2::zeros(), turn, 0.0));
            check(&moved(&scene, Vec2::zeros(), 0.0, turn));
            check(&moved(&scene, Vec2::zeros(), turn, turn + gap));
        }
    }
    assert!(contacts > 10_000, "{contacts}");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400,
        rng_seed: RngSeed::Fixed(3),
        ..ProptestConfig::default()
    })]

    /// Jumps of every size, from below the margin to right through the drive, of all bodies or of one.
    #[test]
    fn jumps_of_every_size_miss_nothing(
        seed in any::<u64>(),
        sizes in prop::collection::vec(-5.0..-0.7f64, 8),
        alone in any::<bool>(),
        number in 0..4usize,
    ) {
        let mut noise = Noise(seed);
        let laws = ForceLaws::default();
        let mut scene = match number {
            0 => Scene::ring([4, 6, 8, 10][(seed % 4) as usize], &laws),
            1 => Scene::laid(&geared_drive([6, 6], 12, 1.0), &laws),
            _ => {
                let mut drive = geared_drive([9, 24], 50, 1.0);
                drive.sprockets[1].bearing = Bearing::Floating;
                Scene::laid(&drive, &laws)
            }
        };
        let sets = InstructionSet::available();
        let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
        dynamics.use_instructions(sets[usize::try_from(seed % sets.len() as u64).unwrap()]);
        let mut dydt = vec![0.0; scene.dimension()];
        for size in sizes {
            let size = 10f64.powf(size);
            if alone {
                let body = usize::try_from(noise.next() % scene.model.bodies() as u64).unwrap();
                scene.motion.x[body] += size * noise.sign();
                scene.motion.y[body] += size * noise.sign();
                scene.motion.angle[body] += PI * noise.sign();
            } else {
                scene.shake(&mut noise, size, 0.0);
            }
            let y = scene.y();
            dynamics.derivative(0.0, &y, &mut dydt);
            assert_none_missed(&mut dynamics, 0.0, &y);
        }
    }
}

#[test]
fn a_pair_that_flies_off_within_a_step_forgets_its_contact() {
    let mut scene = Scene::laid(&paper_drive(), &elastic_hertz());
    scene.shake(&mut Noise(2), 1e-4, 0.1);
    let (mut dynamics, mut adams) = scene.ready(control(1e-5));
    let live = |dynamics: &Dynamics| {
        let speeds = dynamics.memory.tooth_impact_velocity.iter();
        speeds.filter(|&&speed| speed > 0.0).count()
    };
    assert!(live(&dynamics) > 5);
    // Where a step would have to go that takes the chain off its sprockets and beyond their candidates.
    scene.motion.y.iter_mut().for_each(|y| *y += 1.0);
    adams.restart(0.0, &scene.y());
    for _ in 0..2 {
        dynamics.forget_ended_contacts();
        let step = adams.step(&mut dynamics).unwrap();
        dynamics.record_contact_events(&adams, &step);
    }
    assert_eq!(live(&dynamics), 0);
}

/// Evaluations while the second of two sprockets is `links` away.
fn candidates_of(links: u32) -> (usize, u64) {
    let scene = Scene::laid(&geared_drive([17, 17], links, 10.0), &ForceLaws::default());
    let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
    let mut dydt = vec![0.0; scene.dimension()];
    for _ in 0..10 {
        dynamics.derivative(0.0, &scene.y(), &mut dydt);
    }
    (
        dynamics.candidates().count(),
        dynamics.candidate_refreshes(),
    )
}

#[test]
fn bushings_of_long_strands_are_no_candidates_and_nothing_is_chosen_anew_while_nothing_moves() {
    let counts: Vec<usize> = [60, 100, 200, 400, 1000]
        .map(|links| {
            let (count, refreshes) = candidates_of(links);
            assert_eq!(refreshes, 1);
            count
        })
        .to_vec();
    // Wraps of half a turn, and as far along both strands as margin and tooth height reach.
    assert!(
        counts
            .iter()
            .all(|&count| (2 * 9..=2 * 17).contains(&count)),
        "{counts:?}"
    );
    let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
    assert!(most - least <= 4, "{counts:?}");
}

#[test]
fn candidates_are_chosen_three_times_a_pitch_of_chain_travel_at_most() {
    for speed in [20.0, 100.0] {
        let drive = geared_drive([17, 17], 60, speed);
        let scene = Scene::laid(&drive, &ForceLaws::default());
        let radius = scene.model.sprockets[0].profile.pitch_radius;
        let time = 1.0 / speed;
        let met = run(&scene, 1e-5, time);
        // The margin, half a pitch, is shared between bushings and sprockets, which halves its square.
        let pitches = speed * time * radius / (2.0 * scene.model.half_pitch);
        let most = 3.0 * pitches + 1.0;
        assert!(
            (met.refreshes as f64) <= most && met.refreshes > 5,
            "{met:?} {most}"
        );
    }
}

/// Largest depth of a cylinder of `radius` in a gap's own wedge at distances from the centre that are `beyond` times its reach.
fn deepest_beyond(profile: &ToothProfile, radius: f64, beyond: f64) -> f64 {
    let half = 0.5 * profile.gap_angle();
    let distance = profile.reach(radius) * beyond;
    (0..=60)
        .map(|i| {
            let angle = half * f64::from(i) / 60.0;
            let (sin, cos) = angle.sin_cos();
            let point = Vec2::new(distance * sin, distance * cos - profile.seat_center_radius);
            profile.contact(point, radius).penetration
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn beyond_reach_nothing_in_a_gap_s_own_wedge_touches_its_nearest_surface() {
    let pitch = 0.0127;
    let mut touching = Vec::new();
    for teeth in (5..=150).chain([200, 400, 1000]) {
        for seat in [Seat::BottomDiameter, Seat::PitchCircle] {
            for share in (1..100).step_by(if teeth < 30 { 2 } else { 7 }) {
                let roller = 0.01 * f64::from(share) * pitch;
                let profile = ToothProfile::ansi(pitch, roller, teeth, seat);
                for slim in [1.0, 0.6, 0.3, 0.05] {
                    for beyond in [1.0, 1.0001, 1.01, 1.1, 2.0, 100.0] {
                        let depth = deepest_beyond(&profile, 0.5 * roller * slim, beyond);
                        if depth > 1e-12 * pitch {
                            touching.push((teeth, seat, share, slim, beyond, depth));
                        }
                    }
                }
            }
        }
    }
    assert!(
        touching.is_empty(),
        "{}: {:?}",
        touching.len(),
        &touching[..10.min(touching.len())]
    );
}

#[test]
fn just_inside_reach_the_tooth_s_tip_is_touched() {
    for teeth in 6..=150 {
        let profile = ToothProfile::ansi(0.0127, 7.9375e-3, teeth, Seat::PitchCircle);
        assert!(
            deepest_beyond(&profile, 3.968_75e-3, 1.0 - 1e-6) > 0.0,
            "{teeth} teeth"
        );
    }
}
