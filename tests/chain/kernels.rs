//! The kernels against the scalar reference: the same contacts, forces, accelerations and powers, to roundings that are stated.

#![allow(clippy::print_stdout)] // what a machine lacks is said

use crate::common::agreement::{Agreement, compare};
use crate::common::scenes::{Noise, Scene, VARIED, geared_drive, laws, varied_drive};
use crate::common::{control, paper_drive, roller_chain, roller_drive, tensioner};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rustchain::ForceLaws;
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::{Bearing, Chain, Drive, SprocketMotion};
use rustchain::force_law::{Damping, Elastic, Regions};
use rustchain::integrator::{Adams, OdeSystem, Step};
use rustchain::math::simd::InstructionSet;
use rustchain::system::System;

/// Drives of all kinds, by number.
const DRIVES: usize = 13 + VARIED;

fn scene(number: usize, laws: &ForceLaws) -> Scene {
    let drive: Drive = match number {
        0 => paper_drive(),
        1 => Drive {
            tensioner: Some(tensioner(25.0, 1e-3)),
            ..paper_drive()
        },
        2 => {
            let mut drive = paper_drive();
            drive.sprockets[1].bearing = Bearing::Floating;
            drive.sprockets[0].motion = SprocketMotion::AppliedTorque(1.5.into());
            drive
        }
        3 => geared_drive([17, 17], 40, 30.0),
        4 => geared_drive([9, 60], 64, -20.0),
        5 => geared_drive([25, 13], 202, 15.0),
        6 => geared_drive([6, 6], 12, 10.0),
        // Shorter than a register, and more.
        7..=10 => return Scene::ring([4, 6, 8, 10][number - 7], laws),
        11 => Drive {
            tensioner: Some(tensioner(25.0, 1e-3)),
            ..roller_drive()
        },
        12 => {
            let mut drive = geared_drive([13, 30], 62, 15.0);
            drive.chain = Chain {
                links: drive.chain.links,
                ..roller_chain()
            };
            drive
        }
        _ => varied_drive(number - 13),
    };
    Scene::laid(&drive, laws)
}

#[derive(Debug, Clone)]
struct Choice {
    drive: usize,
    elastic: [Elastic; 2],
    damping: [Damping; 2],
    regions: Regions,
    energy: bool,
    /// Powers of ten: how far bodies are shaken \[m\], and how fast \[m/s\].
    shake: f64,
    speed: f64,
    /// Share of contacts with a memory.
    remembered: f64,
    time: f64,
    seed: u64,
}

impl Choice {
    fn scene(&self) -> Scene {
        let mut laws = laws(self.elastic[0], self.damping[0], self.regions);
        laws.tooth.elastic = self.elastic[1];
        laws.tooth.damping = self.damping[1];
        let mut scene = scene(self.drive, &laws);
        scene.shake(
            &mut Noise(self.seed),
            10f64.powf(self.shake),
            10f64.powf(self.speed),
        );
        scene
    }

    fn agreement(&self, set: InstructionSet) -> Agreement {
        let scene = self.scene();
        let mut dynamics = scene.remembering(&mut Noise(!self.seed), self.remembered);
        dynamics.keep_energy(self.energy);
        dynamics.use_instructions(set);
        compare(&mut dynamics, self.time, &scene.y())
    }
}

fn choices() -> impl Strategy<Value = Choice> {
    let elastic = || {
        prop::sample::select(vec![
            Elastic::Hertz,
            Elastic::Johnson,
            Elastic::EnhancedCylinder,
            Elastic::LiuConformal,
            Elastic::Linear(1e8),
        ])
    };
    let damping = || prop::sample::select(vec![Damping::None, Damping::LankaraniNikravesh]);
    (
        (0..DRIVES, [elastic(), elastic()], [damping(), damping()]),
        prop::sample::select(vec![Regions::Kept, Regions::Sharp]),
        any::<bool>(),
        (-7.0..-1.5, -6.0..1.5),
        prop::sample::select(vec![0.0, 0.5, 1.0]),
        (0.0..2e-3, any::<u64>()),
    )
        .prop_map(
            |(
                (drive, elastic, damping),
                regions,
                energy,
                (shake, speed),
                remembered,
                (time, seed),
            )| {
                Choice {
                    drive,
                    elastic,
                    damping,
                    regions,
                    energy,
                    shake,
                    speed,
                    remembered,
                    time,
                    seed,
                }
            },
        )
}

/// Twice what 20 000 states showed for every instruction set.
fn assert_agreement(a: &Agreement, what: &str) {
    assert!(a.hinge_depth <= 4.5, "{what}: {a:?}");
    assert!(a.tooth_depth <= 2.0, "{what}: {a:?}");
    assert!(a.elastic <= 4.0, "{what}: {a:?}");
    assert!(a.force <= 2.0, "{what}: {a:?}");
    assert!(a.link <= 1.0, "{what}: {a:?}");
    assert!(a.sprocket <= 0.5, "{what}: {a:?}");
    assert!(a.power <= 0.35, "{what}: {a:?}");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3000,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn kernels_are_the_scalar_reference_to_first_order_in_roundings(choice in choices()) {
        for set in InstructionSet::available() {
            assert_agreement(&choice.agreement(set), set.name());
        }
    }
}

#[test]
fn the_states_compared_have_every_kind_of_contact() {
    let mut noise = Noise(3);
    let (mut surfaces, mut beyond) = ([0usize; 4], 0);
    let (mut hinges, mut open) = (0, 0);
    for number in 0..DRIVES {
        for shake in [1e-5, 1e-4, 3e-3] {
            let laws = ForceLaws::default();
            let mut scene = scene(number, &laws);
            scene.shake(&mut noise, shake, 1.0);
            let mut dynamics = scene.remembering(&mut noise, 0.5);
            dynamics.evaluate(0.0, &scene.y());
            let touching = dynamics
                .evaluated
                .hinges
                .penetration
                .iter()
                .filter(|&&d| d > 0.0);
            let touching = touching.count();
            hinges += touching;
            open += scene.model.links - touching;
            for &pair in &dynamics.evaluated.teeth.near {
                let pair = pair as usize;
                if dynamics.evaluated.teeth.penetration[pair] > 0.0 {
                    match surfaces.get_mut(dynamics.evaluated.teeth.surface(pair).index()) {
                        Some(count) => *count += 1,
                        None => beyond += 1, // edges, lands, damaged teeth
                    }
                }
            }
        }
    }
    assert!(hinges > 300 && open > 300, "{hinges} {open}");
    assert!(surfaces.iter().all(|&count| count > 20), "{surfaces:?}");
    assert!(beyond > 0);
}

/// One choice of each drive and law, shaken enough that a third of all hinges touch.
fn samples() -> Vec<Choice> {
    let mut samples = Vec::new();
    for drive in 0..DRIVES {
        for (i, elastic) in [
            Elastic::Hertz,
            Elastic::Johnson,
            Elastic::EnhancedCylinder,
            Elastic::LiuConformal,
            Elastic::Linear(1e8),
        ]
        .into_iter()
        .enumerate()
        {
            for damping in [Damping::None, Damping::LankaraniNikravesh] {
                samples.push(Choice {
                    drive,
                    elastic: [elastic; 2],
                    damping: [damping; 2],
                    regions: [Regions::Kept, Regions::Sharp][i % 2],
                    energy: i != 1,
                    shake: [-5.0, -4.0, -3.0, -2.0][(drive + i) % 4],
                    speed: -1.0,
                    remembered: 0.5,
                    time: 5e-4,
                    seed: (drive * 10 + i) as u64,
                });
            }
        }
    }
    samples
}

fn slope(choice: &Choice, set: InstructionSet) -> Vec<f64> {
    let scene = choice.scene();
    let mut dynamics = scene.remembering(&mut Noise(!choice.seed), choice.remembered);
    dynamics.keep_energy(choice.energy);
    dynamics.use_instructions(set);
    let mut dydt = vec![0.0; scene.dimension()];
    dynamics.derivative(choice.time, &scene.y(), &mut dydt);
    let powers = dynamics.powers(choice.time, &scene.y());
    dydt.extend([powers.dissipated, powers.external_work]);
    dydt
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// Sets with fused multiply-add; says so where there is nothing to compare.
fn fused() -> Vec<InstructionSet> {
    let mut sets = InstructionSet::available();
    sets.retain(|set| set.has_fused_multiply_add());
    if sets.len() < 2 {
        println!(
            "skipped: this machine has {} of AVX2, AVX-512 and NEON",
            sets.len()
        );
    }
    sets
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 1500,
        rng_seed: RngSeed::Fixed(2),
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_width_gives_the_same_bits(choice in choices()) {
        for pair in fused().windows(2) {
            prop_assert_eq!(bits(&slope(&choice, pair[0])), bits(&slope(&choice, pair[1])));
        }
    }
}

#[test]
fn every_width_steps_through_the_same_bits_for_ten_milliseconds_at_25_newtons() {
    same_bits(5000, |adams, dynamics| adams.step(dynamics).unwrap());
}

#[test]
fn every_width_solves_the_implicit_corrector_to_the_same_bits() {
    same_bits(500, |adams, dynamics| adams.step_newton(dynamics).unwrap());
}

fn same_bits(least: u64, make: impl Fn(&mut Adams, &mut Dynamics) -> Step) {
    let drive = Drive {
        tensioner: Some(tensioner(25.0, 1e-3)),
        ..paper_drive()
    };
    let scene = Scene::laid(&drive, &ForceLaws::default());
    let mut runs: Vec<_> = fused()
        .into_iter()
        .map(|set| {
            let (mut dynamics, mut adams) = scene.ready(control(1e-5));
            dynamics.use_instructions(set);
            adams.use_instructions(set);
            (dynamics, adams)
        })
        .collect();
    if runs.len() < 2 {
        return;
    }
    let (mut steps, mut refreshes) = (0u64, 0);
    while runs[0].1.time() < 0.01 {
        let mut middle = 0.0;
        for (dynamics, adams) in &mut runs {
            dynamics.forget_ended_contacts();
            let step = make(adams, dynamics);
            dynamics.record_contact_events(adams, &step);
            middle = 0.5 * (step.start + step.end);
        }
        let [(first, one), (_, other), ..] = &runs[..] else {
            unreachable!()
        };
        assert_eq!(one.time().to_bits(), other.time().to_bits(), "step {steps}");
        assert_eq!(bits(one.y()), bits(other.y()), "step {steps}");
        // The dense output has the differences of the slopes.
        let inside = |adams: &Adams| {
            let mut y = vec![0.0; adams.y().len()];
            adams.interpolate(middle, &mut y);
            y
        };
        assert_eq!(bits(&inside(one)), bits(&inside(other)), "step {steps}");
        steps += 1;
        refreshes = first.candidate_refreshes();
    }
    assert!(steps > least && refreshes >= 2, "{steps} {refreshes}");
}

#[test]
fn a_checkpoint_of_one_width_continues_to_the_same_bits_on_another() {
    let drive = Drive {
        tensioner: Some(tensioner(25.0, 1e-3)),
        ..paper_drive()
    };
    let scene = Scene::laid(&drive, &ForceLaws::default());
    let [wide, narrow, ..] = fused()[..] else {
        return;
    };
    let step = |dynamics: &mut Dynamics, adams: &mut Adams| {
        dynamics.forget_ended_contacts();
        let step = adams.step_newton(dynamics).unwrap();
        dynamics.record_contact_events(adams, &step);
    };
    let (mut dynamics, mut adams) = scene.ready(control(1e-5));
    dynamics.use_instructions(wide);
    adams.use_instructions(wide);
    while adams.time() < 0.005 {
        step(&mut dynamics, &mut adams);
    }
    assert!(dynamics.memory.counts().onsets > 10);
    let (mut fresh, _) = scene.ready(control(1e-5));
    fresh.use_instructions(narrow);
    let mut restored = fresh.restored(&dynamics.checkpoint(), &adams).unwrap();
    let mut continued = adams.clone();
    continued.use_instructions(narrow);
    assert_eq!(restored.instructions().name(), narrow.name());
    for number in 0..300 {
        step(&mut dynamics, &mut adams);
        step(&mut restored, &mut continued);
        assert_eq!(bits(adams.y()), bits(continued.y()), "step {number}");
    }
}

/// Both are vector forms of one scalar one; between them lie twice the roundings.
#[test]
fn the_plain_set_stays_as_near_to_the_scalar_reference_as_the_others() {
    let sets = InstructionSet::available();
    let plain = *sets.last().unwrap();
    assert!(!plain.has_fused_multiply_add());
    for choice in samples() {
        assert_agreement(&choice.agreement(plain), "plain");
    }
}
