//! Open chains in motion: free fall, pendulums against Bessel's zeros, energy, both correctors, matrices, states.

use crate::common;
use crate::common::agreement::compare;
use crate::common::checks::{lacks, newton};
use crate::common::open::{at_rest, hoist, strand, tightened};
use crate::common::scenes::{Noise, Scene, laws};
use crate::common::{advance, channel, control, record, simulation};
use nalgebra::{DMatrix, DVector};
use rustchain::drive::{ChainEnd, Drive, LinkStiffness, SprocketMotion};
use rustchain::force_law::{Damping, Elastic, Friction, Regions, Regularization};
use rustchain::geometry::Vec2;
use rustchain::integrator::StepControl;
use rustchain::layout::InitialConfiguration;
use rustchain::math::Table;
use rustchain::math::simd::InstructionSet;
use rustchain::{ForceLaws, Groups, Model, Simulation, Snapshot};

const GRAVITY: f64 = 9.81;
const STILL: SprocketMotion = SprocketMotion::Free;

/// A chain without ends, dropped from the curve on which it hung.
fn dropped() -> Drive {
    let loose = |x: f64| ChainEnd::Free {
        position: Some(Vec2::new(x, 0.0)),
        links: None,
    };
    strand(20, [loose(0.0), loose(0.17)])
}

#[test]
fn a_dropped_chain_falls_with_its_momentum() {
    for control in [control(1e-8), newton(1e-10)] {
        let drive = dropped();
        let (mut start, _) = InitialConfiguration::generate(&drive).unwrap();
        let mut noise = Noise(5);
        for velocity in &mut start.velocities[..20] {
            *velocity = [0.2 * noise.sign(), 0.2 * noise.sign(), 10.0 * noise.sign()];
        }
        let model = Model::compile(&drive, &ForceLaws::default(), &start).unwrap();
        let mass = model.chain.mass[..20].to_vec();
        let mut run = Simulation::new(model.into(), &start, control).unwrap();
        let sums = |run: &mut Simulation| {
            let motion = &run.present().evaluated.motion;
            let mut sums = [Vec2::zeros(); 2];
            for (i, &m) in mass.iter().enumerate() {
                sums[0] += m * Vec2::new(motion.x[i], motion.y[i]);
                sums[1] += m * Vec2::new(motion.vx[i], motion.vy[i]);
            }
            let total: f64 = mass.iter().sum();
            sums.map(|sum| sum / total)
        };
        let [place, velocity] = sums(&mut run);
        let time = 0.02;
        advance(&mut run, time);
        assert!(run.statistics().onsets > 20, "{}", run.statistics().onsets);
        let [fallen, falls] = sums(&mut run);
        let down = Vec2::new(0.0, -GRAVITY);
        assert!((falls - velocity - time * down).norm() < 1e-12);
        let expected = place + time * velocity + 0.5 * time * time * down;
        assert!(
            (fallen - expected).norm() < 1e-12,
            "{}",
            (fallen - expected).norm()
        );
        // Loose ends are nowhere: their bodies stay.
        for (body, at) in [(21, start.positions[21]), (20, start.positions[20])] {
            assert_eq!(run.present().evaluated.motion.positions()[body], at);
        }
    }
}

/// Lowest modes of a chain that hangs from its first link: squared angular frequencies and shapes, over x of the rears and fronts of all
/// links. Links of their length and mass, joined by weightless ones of the play that the load has taken up.
fn lowest_mode(drive: &Drive, play: f64, load: f64) -> (f64, DVector<f64>, DMatrix<f64>) {
    let n = drive.chain.links as usize;
    let pitches = drive.chain.link_pitches();
    let link = |i: usize| drive.chain.strand_link(i);
    let (mut mass, mut stiffness) = (
        DMatrix::<f64>::zeros(2 * n, 2 * n),
        DMatrix::<f64>::zeros(2 * n, 2 * n),
    );
    let below = |i: usize| load + (i..n).map(|j| link(j).mass).sum::<f64>();
    for (i, &length) in pitches.iter().enumerate() {
        let (rear, front) = (2 * i, 2 * i + 1);
        // m at the mean of both ends, J about it.
        let (m, j) = (link(i).mass, link(i).inertia / (length * length));
        for (a, b, value) in [
            (rear, rear, 0.25 * m + j),
            (front, front, 0.25 * m + j),
            (rear, front, 0.25 * m - j),
            (front, rear, 0.25 * m - j),
        ] {
            mass[(a, b)] += value;
        }
        let mut spring = |from: Option<usize>, to: usize, value: f64| {
            stiffness[(to, to)] += value;
            if let Some(from) = from {
                stiffness[(from, from)] += value;
                stiffness[(from, to)] -= value;
                stiffness[(to, from)] -= value;
            }
        };
        spring(rear.checked_sub(1), rear, GRAVITY * below(i) / play);
        spring(
            Some(rear),
            front,
            0.5 * GRAVITY * (below(i) + below(i + 1)) / length,
        );
    }
    let cholesky = mass.clone().cholesky().unwrap();
    let inverse = cholesky.l().try_inverse().unwrap();
    let symmetric: DMatrix<f64> = &inverse * stiffness * inverse.transpose();
    let eigen = (0.5 * (&symmetric + symmetric.transpose())).symmetric_eigen();
    let lowest = eigen.eigenvalues.imin();
    let column: DVector<f64> = eigen.eigenvectors.column(lowest).into_owned();
    let shape = inverse.transpose() * column;
    (eigen.eigenvalues[lowest], shape, mass)
}

#[test]
fn a_hanging_chain_swings_at_the_zeros_of_bessels_function() {
    let links = 41;
    let drive = strand(links, [ChainEnd::anchored(Vec2::zeros()), ChainEnd::free()]);
    let n = links as usize;
    let laws = ForceLaws::default();
    let (run, rest) = at_rest(&drive, &laws, StepControl::default());
    let depth = run
        .dynamics()
        .evaluated
        .hinges
        .penetration
        .iter()
        .sum::<f64>()
        / n as f64;
    let play = drive.chain.hinge.clearance() + depth.max(0.0);
    let (squared, shape, mass) = lowest_mode(&drive, play, 0.0);
    let omega = squared.sqrt();
    // The continuous chain: half the first zero of J0 times sqrt(g/L). A link's own inertia makes up 0.4 % here.
    let length = f64::from(links) * (drive.chain.pitch + play);
    let continuous = 0.5 * 2.404_825_557_695_773 * (GRAVITY / length).sqrt();
    assert!(
        (omega / continuous - 1.0).abs() < 0.01,
        "{omega} {continuous}"
    );
    // Let go from that shape, 2 mm aside at its end.
    let aside = 2e-3 / shape[2 * n - 1];
    let mut start = rest.start.clone();
    for i in 0..n {
        let (rear, front) = (aside * shape[2 * i], aside * shape[2 * i + 1]);
        start.positions[i][0] += 0.5 * (rear + front);
        start.positions[i][2] += (front - rear) / drive.chain.pitch;
    }
    let model = Model::compile(&drive, &laws, &start).unwrap();
    let mut run = Simulation::new(model.into(), &start, newton(1e-9)).unwrap();
    let groups = Groups {
        bodies: true,
        ..Groups::default()
    };
    let period = std::f64::consts::TAU / omega;
    let recording = record(&mut run, 0.8 * period, 1e-3, groups);
    let positions = channel(&recording, "positions");
    let weights = &mass * &shape;
    let moved: Vec<f64> = positions
        .chunks(3 * (n + 2))
        .map(|row| {
            let ends = (0..n).flat_map(|i| {
                let turn =
                    0.5 * drive.chain.pitch * (row[3 * i + 2] + 0.5 * std::f64::consts::PI).sin();
                [row[3 * i] - turn, row[3 * i] + turn]
            });
            ends.zip(weights.iter()).map(|(x, w)| x * w).sum()
        })
        .collect();
    let crossings: Vec<f64> = (1..moved.len())
        .filter(|&i| moved[i - 1] * moved[i] < 0.0)
        .map(|i| recording.time[i - 1] + 1e-3 * moved[i - 1] / (moved[i - 1] - moved[i]))
        .collect();
    assert_eq!(crossings.len(), 2);
    let half = crossings[1] - crossings[0];
    assert!(
        (half / (0.5 * period) - 1.0).abs() < 1e-3,
        "{half} of {}",
        0.5 * period
    );
    assert!(
        (crossings[0] / (0.25 * period) - 1.0).abs() < 2e-3,
        "{crossings:?}"
    );
}

#[test]
fn the_energy_of_a_hoist_and_of_a_moved_strand_is_accounted_for() {
    // A motor lifts 10 kg, gently enough for the chain to stay on its wheel.
    let speed = Table::new("speed", "rad/s", &[(0.0, 0.0), (0.02, 4.0)]).unwrap();
    let lifting = hoist(60, 24, 10.0, SprocketMotion::PrescribedSpeed(speed.into()));
    // A torque that gives way to the load.
    let lowering = hoist(60, 24, 10.0, SprocketMotion::AppliedTorque(2.0.into()));
    let shaken = {
        let x = Table::new("velocity", "m/s", &[(0.0, 0.0), (0.01, 0.5), (0.02, -0.5)]).unwrap();
        let anchor = ChainEnd::Anchored {
            position: Vec2::zeros(),
            velocity: [x.into(), 0.0.into()],
            links: None,
        };
        strand(20, [anchor, ChainEnd::loaded(0.5, 1e-4)])
    };
    let rolled = rolling(lifting.clone());
    for (name, drive, time) in [
        ("lifting", lifting, 0.03),
        ("lifting with rollers", rolled, 0.03),
        ("lowering", lowering, 0.01),
        ("shaken", shaken, 0.03),
    ] {
        for control in [control(1e-7), StepControl::default()] {
            let laws = ForceLaws::default();
            let mut run = if name == "lowering" {
                simulation(&drive, &laws, control)
            } else {
                at_rest(&drive, &laws, control).0
            };
            let energies = common::energies(&mut run, time, 1e-3);
            let turned = energies.external_work.last().unwrap().abs()
                + energies.kinetic.last().unwrap()
                + energies.dissipated.last().unwrap();
            let missing = energies.largest_residual();
            assert!(turned > 1e-3, "{name}: {turned} J");
            assert!(missing < 2e-3 * turned, "{name}: {missing} J of {turned} J");
        }
    }
}

#[test]
fn an_anchor_goes_where_its_velocity_takes_it() {
    let rows = [(0.0, 0.0), (0.013, 0.4), (0.03, -0.2)];
    let x = Table::new("velocity", "m/s", &rows).unwrap();
    let anchor = ChainEnd::Anchored {
        position: Vec2::new(0.1, 0.2),
        velocity: [x.clone().into(), 0.3.into()],
        links: None,
    };
    let drive = strand(15, [anchor, ChainEnd::loaded(0.2, 1e-5)]);
    for control in [control(1e-7), StepControl::default()] {
        let mut run = simulation(&drive, &ForceLaws::default(), control);
        advance(&mut run, 0.04);
        let motion = &run.present().evaluated.motion;
        let at = Vec2::new(motion.x[16], motion.y[16]);
        let expected = Vec2::new(0.1 + x.integral(0.04), 0.2 + 0.3 * 0.04);
        assert!(
            (at - expected).norm() < 1e-14,
            "{:e}",
            (at - expected).norm()
        );
        assert!((motion.vx[16] - x.value(0.04)).abs() < 1e-13);
        assert_eq!(motion.angle[16], 0.0);
    }
}

#[test]
fn both_correctors_follow_the_same_path() {
    // Let go from rest, aside by no more than the hinges allow: all contacts stay closed.
    let drive = strand(
        12,
        [
            ChainEnd::anchored(Vec2::zeros()),
            ChainEnd::loaded(1.0, 1e-4),
        ],
    );
    let laws = laws(Elastic::Hertz, Damping::LankaraniNikravesh, Regions::Kept);
    let (_, rest) = at_rest(&drive, &laws, StepControl::default());
    let mut start = rest.start.clone();
    for velocity in &mut start.velocities[..13] {
        velocity[0] = 0.0;
    }
    start.velocities[12][0] = 0.05;
    let path = |control: StepControl| {
        let model = Model::compile(&drive, &laws, &start).unwrap();
        let mut run = Simulation::new(model.into(), &start, control).unwrap();
        advance(&mut run, 5e-3);
        run.present().evaluated.motion.positions()
    };
    let (explicit, implicit) = (path(control(1e-10)), path(newton(1e-12)));
    for (a, b) in explicit.iter().zip(&implicit) {
        let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
        assert!(apart < 2e-9, "{apart:e}");
    }
    assert!((explicit[12][0] - rest.start.positions[12][0]).abs() > 1e-4);
}

/// With rollers as bodies.
fn rolling(mut drive: Drive) -> Drive {
    let links = drive.chain.links;
    drive.chain = common::roller_chain();
    drive.chain.links = links;
    drive
}

/// Open scenes of all kinds of ends, laid.
fn scenes() -> Vec<Drive> {
    let anchor = |x: f64, y: f64| ChainEnd::anchored(Vec2::new(x, y));
    vec![
        strand(4, [anchor(0.0, 0.0), ChainEnd::free()]),
        strand(5, [ChainEnd::loaded(0.3, 1e-5), anchor(0.0, 0.0)]),
        strand(14, [anchor(0.0, 0.0), anchor(0.11, 0.05)]),
        strand(27, [anchor(0.0, 0.0), ChainEnd::loaded(2.0, 1e-4)]),
        dropped(),
        hoist(40, 14, 3.0, STILL),
        hoist(41, 16, 3.0, SprocketMotion::PrescribedSpeed(4.0.into())),
        {
            let mut drive = hoist(46, 14, 3.0, SprocketMotion::AppliedTorque(1.0.into()));
            drive.ends.as_mut().unwrap()[0] = ChainEnd::free();
            drive.ends.as_mut().unwrap()[1] = ChainEnd::Loaded {
                mass: 1.0,
                inertia: 1e-4,
                arm: 0.02,
                position: None,
                links: Some(3),
            };
            drive
        },
        tightened(30.0),
        rolling(strand(12, [anchor(0.0, 0.0), ChainEnd::free()])),
        rolling(strand(13, [ChainEnd::loaded(0.3, 1e-5), anchor(0.0, 0.0)])),
        rolling(hoist(
            41,
            16,
            3.0,
            SprocketMotion::PrescribedSpeed(4.0.into()),
        )),
        rolling(tightened(30.0)),
    ]
}

/// With links that stretch.
fn elastic() -> Drive {
    let mut drive = hoist(40, 14, 3.0, STILL);
    drive.chain.link_stiffness = Some(LinkStiffness::Given(5e7));
    drive
}

#[test]
fn kernels_and_the_scalar_reference_agree_on_open_chains() {
    let mut touching = 0;
    for (number, drive) in scenes().into_iter().enumerate() {
        for (i, elastic) in [Elastic::Hertz, Elastic::Johnson, Elastic::LiuConformal]
            .into_iter()
            .enumerate()
        {
            for shake in [1e-5, 1e-4, 1e-3, 3e-2] {
                let laws = laws(
                    elastic,
                    [Damping::None, Damping::LankaraniNikravesh][i % 2],
                    Regions::Kept,
                );
                let seed = (10 * number + i) as u64;
                let mut scene = Scene::laid(&drive, &laws);
                scene.shake(&mut Noise(seed), shake, 0.3);
                for set in InstructionSet::available() {
                    let mut dynamics = scene.remembering(&mut Noise(!seed), 0.5);
                    dynamics.use_instructions(set);
                    dynamics.keep_energy(true);
                    let found = compare(&mut dynamics, 1e-3, &scene.y());
                    touching += found.touching;
                    // The bounds of closed chains.
                    let bounds = [4.5, 2.0, 4.0, 2.0, 1.0, 0.5, 0.35];
                    for (value, bound) in found.values().into_iter().zip(bounds) {
                        assert!(value <= bound, "{number}, {}: {found:?}", set.name());
                    }
                    let forces: Vec<f64> =
                        dynamics.hinge_contacts().map(|(_, force)| force).collect();
                    assert_eq!(forces[forces.len() - 2], 0.0);
                }
            }
        }
    }
    assert!(touching > 1000, "{touching}");
}

#[test]
fn the_matrices_of_open_chains_are_those_of_finite_differences() {
    let scenes = scenes().into_iter().chain([elastic()]);
    for (number, drive) in scenes.enumerate() {
        let laws = laws(Elastic::Hertz, Damping::LankaraniNikravesh, Regions::Kept);
        let mut run = simulation(&drive, &laws, StepControl::default());
        advance(&mut run, 12e-3);
        let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
        let mut dynamics = run.dynamics().clone();
        for gamma in [1e-5, 1e-6] {
            // Angles turned in a step, as for closed chains.
            let lacking = lacks(&mut dynamics, t, &y, gamma);
            assert!(
                lacking < 5e4 * gamma + 1e-3,
                "{number}, {gamma:e}: {lacking:e}"
            );
        }
    }
}

#[test]
fn friction_in_the_hinges_of_an_open_chain_dissipates_what_the_balance_misses() {
    let drive = strand(
        20,
        [
            ChainEnd::anchored(Vec2::zeros()),
            ChainEnd::anchored(Vec2::new(0.15, 0.0)),
        ],
    );
    let friction = Friction {
        coefficient: 0.2,
        regularization: Regularization::Tanh,
        speed: 1e-3,
        dead_speed: 0.0,
    };
    let laws = ForceLaws {
        hinge_friction: Some(friction),
        ..ForceLaws::default()
    };
    for control in [control(1e-7), StepControl::default()] {
        let mut run = simulation(&drive, &laws, control);
        let groups = Groups {
            energy: true,
            ..Groups::default()
        };
        let recording = record(&mut run, 0.03, 1e-3, groups);
        let last = |name: &str| *channel(&recording, name).last().unwrap();
        let (rubbed, missing) = (last("energy_hinge_friction"), last("energy_residual"));
        assert!(rubbed > 1e-7, "{rubbed}");
        let dissipated = last("energy_dissipated");
        assert!(
            missing.abs() < 0.02 * dissipated,
            "{missing} J of {dissipated} J"
        );
    }
}

#[test]
fn a_run_of_an_open_chain_goes_on_from_its_state_to_the_same_bits() {
    for drive in scenes() {
        for control in [control(1e-6), StepControl::default()] {
            let laws = ForceLaws::default();
            let mut whole = simulation(&drive, &laws, control);
            advance(&mut whole, 8e-3);
            let bytes = whole.snapshot().to_bytes().unwrap();
            let mut successor = simulation(&drive, &laws, control);
            successor
                .restore(&Snapshot::from_bytes(&bytes).unwrap())
                .unwrap();
            for run in [&mut whole, &mut successor] {
                advance(run, 14e-3);
            }
            let [a, b] = [whole, successor].map(|run| run.snapshot().to_bytes().unwrap());
            assert!(a == b);
        }
    }
}
