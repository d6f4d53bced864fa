//! Laws that all forces obey: momentum, and Newton's matrix as their derivative.

use rustchain::chain::dynamics::{Dynamics, Losses};
use rustchain::chain::model::Model;
use rustchain::drive::Drive;
use rustchain::force_law::PairTable;
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, OdeSystem, SecondOrderSystem, StepControl};
use rustchain::layout::InitialConfiguration;
use rustchain::math::simd::InstructionSet;
use rustchain::{Equilibrium, ForceLaws, Simulation};

/// The largest of all, whatever its sign.
pub fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |a: f64, b| a.max(b.abs()))
}

/// What is lost now and where; asserts that all forces and moments of the drive are those between its bodies.
pub fn keeps_momentum(run: &Simulation) -> Losses {
    let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
    let mut dynamics = run.dynamics().clone();
    dynamics.keep_energy(true);
    let powers = dynamics.evaluate(t, &y);
    let (model, motion) = (dynamics.model().clone(), &dynamics.evaluated.motion);
    let found = &dynamics.evaluated.accelerations;
    let (mut force, mut moment, mut size) = (Vec2::zeros(), 0.0, 0.0);
    for body in 0..model.links + 2 {
        let (mass, inertia) = if body < model.links {
            (model.chain.mass[body], model.chain.inertia[body])
        } else {
            let sprocket = &model.sprockets[body - model.links];
            (sprocket.mass, sprocket.inertia)
        };
        let own = mass * Vec2::new(found.x[body], found.y[body]);
        let place = Vec2::new(motion.x[body], motion.y[body]);
        force += own;
        moment += place.perp(&own) + inertia * found.angle[body];
        size += own.norm();
    }
    // Lengths are of a tenth of a metre; the pin's radius is two millimetres.
    assert!(force.norm() <= 1e-13 * size, "{force} of {size}");
    assert!(moment.abs() <= 1e-14 * size, "{moment} of {size}");
    powers.losses
}

/// Asserts that a drive rests, and that all of its strands have the tension that is asked for.
pub fn rests_with(asked: f64, name: &str, (rest, tensions): (Equilibrium, Vec<f64>)) {
    assert!(rest.residual < 1e-4, "{name}: {} N left", rest.residual);
    // Bushings are pushed up the flanks of the teeth: with the play of the seats the strands pull on slightly other arms.
    for (i, tension) in tensions.iter().enumerate() {
        assert!(
            (tension - asked).abs() < 4.0,
            "{name}, strand {}: {tension} N",
            i + 1
        );
    }
}

/// Asserts that the layout of a drive is warned of with this text.
pub fn is_warned_of(drive: &Drive, text: &str) {
    let (_, layout) = InitialConfiguration::generate(drive).unwrap();
    let warned = layout.warnings.iter().any(|found| found.contains(text));
    assert!(warned, "{:?}", layout.warnings);
}

/// What a correction lacks: the residual that is left by it over the one before, as norms, for random residuals.
pub fn lacks(dynamics: &mut Dynamics, t: f64, y: &[f64], gamma: f64) -> f64 {
    let nq = dynamics.model().coordinates;
    let n = dynamics.model().links;
    let rollers = dynamics
        .model()
        .rollers
        .as_ref()
        .map_or(nq, |of| of.first + 2 * n);
    let turns = move |i: usize| (2 * n..3 * n).contains(&i) || i >= rollers;
    let mut slope = vec![0.0; y.len()];
    let mut worst: f64 = 0.0;
    for seed in 0..4 {
        let residual: Vec<f64> = (0..nq)
            .map(|i| {
                let entry = ((i * 37 + seed * 101) % 17) as f64 / 17.0 - 0.5;
                if turns(i) { 300.0 * entry } else { entry }
            })
            .collect();
        dynamics.accelerations_with_slopes(t, y, &mut slope);
        assert!(dynamics.factorise(y, gamma));
        let mut first = residual.clone();
        dynamics.correct(&mut first);
        // The residual that is left, corrected: how far the first correction was off.
        let step = 1e-7 / (gamma * largest(&first).max(1e-300));
        let mut at = |sign: f64| {
            let mut z = y.to_vec();
            for i in 0..nq {
                z[i] += sign * step * gamma * gamma * first[i];
                z[nq + i] += sign * step * gamma * first[i];
            }
            let mut slope = vec![0.0; y.len()];
            dynamics.derivative(t, &z, &mut slope);
            slope
        };
        let (up, down) = (at(1.0), at(-1.0));
        let mut left: Vec<f64> = (0..nq)
            .map(|i| residual[i] - first[i] + (up[nq + i] - down[nq + i]) / (2.0 * step))
            .collect();
        dynamics.correct(&mut left);
        let norm = |x: &[f64]| {
            let weight = |i: usize| {
                if turns(i) { 6e-3 } else { 1.0 }
            };
            let squares = x.iter().enumerate().map(|(i, x)| (x * weight(i)).powi(2));
            squares.sum::<f64>().sqrt()
        };
        worst = worst.max(norm(&left) / norm(&first));
    }
    worst
}

/// The implicit corrector at this accuracy \[m\].
pub fn newton(accuracy: f64) -> StepControl {
    StepControl {
        corrector: Corrector::Newton,
        accuracy,
        ..StepControl::default()
    }
}

/// The paper's drive on two floating shafts, free and without gravity: nothing outside acts on it.
pub fn floating(laws: &ForceLaws, how: StepControl) -> Simulation {
    let mut drive = super::paper_drive();
    drive.gravity = Vec2::zeros();
    for (sprocket, speed) in drive.sprockets.iter_mut().zip([12.0, 18.0]) {
        sprocket.motion = rustchain::drive::SprocketMotion::Free;
        sprocket.initial_speed = Some(speed);
        sprocket.bearing = rustchain::drive::Bearing::Floating;
    }
    super::simulation(&drive, laws, how)
}

/// Asserts that Newton's matrix of a run's present state is that of finite differences of the kernels, but for angles turned in a
/// step, with the same bits on every width; `reached` tells whether the state has the contacts that it is to have.
pub fn matrix_is_that_of_finite_differences(
    scene: &str,
    run: &Simulation,
    reached: impl Fn(&Dynamics) -> bool,
) {
    let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
    for set in InstructionSet::available() {
        let mut dynamics = run.dynamics().clone();
        dynamics.use_instructions(set);
        for gamma in [1e-5, 1e-6, 1e-8] {
            let lacking = lacks(&mut dynamics, t, &y, gamma);
            assert!(reached(&dynamics), "{scene}");
            // Slip over radius is up to 1e4 1/s here; a border that is only swept leaves as much. The rest is the differences' own
            // error at shallow contacts.
            assert!(
                lacking < 5e4 * gamma + 1e-3,
                "{scene}, {gamma:e}: {lacking:e}"
            );
        }
    }
    assert!(
        corrections_have_the_same_bits(run.dynamics(), t, &y),
        "{scene}"
    );
}

/// Whether a correction of this state has the same bits with all instructions that multiply and add at once.
pub fn corrections_have_the_same_bits(dynamics: &Dynamics, t: f64, y: &[f64]) -> bool {
    let found = InstructionSet::available()
        .into_iter()
        .filter(|set| set.has_fused_multiply_add())
        .map(|set| {
            let mut dynamics = dynamics.clone();
            dynamics.use_instructions(set);
            let mut slope = vec![0.0; y.len()];
            dynamics.accelerations_with_slopes(t, y, &mut slope);
            assert!(dynamics.factorise(y, 2e-6));
            dynamics.correct(&mut slope[y.len() / 2..]);
            slope
        });
    let found: Vec<Vec<f64>> = found.collect();
    found.windows(2).all(|pair| pair[0] == pair[1])
}
/// The impact velocity of the damping law: the remembered one, or the present rate, at least the minimum.
pub fn impact_velocity(model: &Model, remembered: f64, rate: f64) -> f64 {
    if remembered > 0.0 {
        remembered
    } else {
        rate.max(model.min_impact_velocity)
    }
}

/// Elastic force of a pair of surfaces with a compliance \[m/N\] in series \[N\].
pub fn elastic(table: &PairTable, pair: usize, compliance: f64, depth: f64) -> f64 {
    let pair = table.pair(pair);
    let mut pressed = depth;
    if compliance > 0.0 {
        for _ in 0..50 {
            let excess = pressed + compliance * pair.force(pressed) - depth;
            pressed -= excess / (1.0 + compliance * pair.stiffness(pressed));
        }
    }
    pair.force(pressed)
}

/// Errors of the corrected dissipated power, the largest of all kinds and their sum, of the external power and of a force, the largest, and
/// the changes of the dissipated power and of this force by the correction. The residual of the velocities is `part` of γ times the accelerations.
fn errors_of_corrected_forces(run: &Simulation, gamma: f64, part: f64) -> [f64; 5] {
    let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
    let mut dynamics = run.dynamics().clone();
    dynamics.keep_energy(true);
    let nq = dynamics.coordinates();
    let mut slope = vec![0.0; y.len()];
    dynamics.accelerations_with_slopes(t, &y, &mut slope);
    let before = dynamics.powers(t, &y);
    let forces = |dynamics: &Dynamics| -> Vec<f64> {
        let hinges = dynamics.hinge_contacts().chain(dynamics.roller_contacts());
        let teeth = dynamics.candidates().map(|(.., force)| force);
        hinges.map(|(_, force)| force).chain(teeth).collect()
    };
    let forces_before = forces(&dynamics);
    assert!(dynamics.factorise(&y, gamma));
    let mut correction: Vec<f64> = slope[nq..].iter().map(|a| part * gamma * a).collect();
    dynamics.correct(&mut correction);
    let mut corrected = y.clone();
    for (i, velocity) in correction.iter().enumerate() {
        corrected[i] += gamma * velocity;
        corrected[nq + i] += velocity;
    }
    let mut without_forces = dynamics.clone();
    without_forces.correct_powers((gamma, &correction), false);
    dynamics.correct_powers((gamma, &correction), true);
    let found = dynamics.powers(t, &corrected);
    assert_eq!(without_forces.powers(t, &corrected), found);
    // Forces of ideal hinges are unknowns of the correction itself.
    let first = if dynamics.model().hinges.ideal {
        dynamics.model().links
    } else {
        0
    };
    assert_eq!(forces(&without_forces)[first..], forces_before[first..]);
    let forces_found = forces(&dynamics);
    let exact = dynamics.evaluate(t, &corrected);
    dynamics.accelerations(t, &corrected, &mut slope);
    let forces_exact = forces(&dynamics);
    let differs = |of: &[f64]| {
        let pairs = of.iter().zip(&forces_exact);
        largest(&pairs.map(|(of, exact)| of - exact).collect::<Vec<_>>())
    };
    let kinds = found.losses.values().into_iter().zip(exact.losses.values());
    let errors: Vec<f64> = kinds.map(|(found, exact)| found - exact).collect();
    [
        largest(&errors).max((found.dissipated - exact.dissipated).abs()),
        found.external_work - exact.external_work,
        differs(&forces_found),
        exact.dissipated - before.dissipated,
        differs(&forces_before),
    ]
}

/// Asserts that forces and powers after a correction agree with an evaluation there, in all damped scenes; the number of comparisons.
/// `rounding` \[W\] is subtracted from the error of the external power: the root of the sum of its squares over eight states.
pub fn forces_and_powers_follow_from_a_correction(
    scenes: impl IntoIterator<Item = (String, Simulation)>,
    rounding: f64,
) -> usize {
    let mut compared = 0;
    let gammas = [1e-7, 1e-8];
    for (scene, mut run) in scenes {
        if scene.contains("None") {
            continue;
        }
        let begin = run.integrator().time() + 1e-3;
        // Sums of squares over several states: in a single one the change may be small by chance.
        let mut squares = [[0.0; 5]; 2];
        for state in 1..=8 {
            super::advance(&mut run, begin + 5e-5 * f64::from(state));
            for (squares, gamma) in squares.iter_mut().zip(gammas) {
                let found = errors_of_corrected_forces(&run, gamma, 0.01);
                for (square, found) in squares.iter_mut().zip(found) {
                    *square += found * found;
                }
            }
        }
        for ([dissipated, external, force, lost, pushed], gamma) in squares.into_iter().zip(gammas)
        {
            let errors = [
                (dissipated / lost).sqrt(),
                (external.sqrt() - rounding).max(0.0) / lost.sqrt(),
                // The largest of all contacts, where the errors of sums cancel in part.
                0.5 * (force / pushed).sqrt(),
            ];
            // Left out is how far normals turn, as in the matrix, where slip over radius is up to 1e4 1/s, and a part of the second order.
            let allowed = 5e4 * gamma + 1e-3;
            assert!(
                errors.iter().all(|&error| error < allowed),
                "{scene}, {gamma:e}: {errors:?}"
            );
            compared += 1;
        }
    }
    compared
}

/// Asserts that a run, made with Newton's method and smooth at the scale of its steps, evaluated the powers at the ends of steps with several
/// corrections, and not of all others.
pub fn powers_are_evaluated_after_several_corrections(run: &Simulation) {
    let (counts, taken) = (run.statistics().counts, run.statistics().energy_evaluations);
    // At most so many steps took several corrections, rejected ones included; the others have an evaluation in their middle, at most.
    let several = counts.evaluations - counts.steps - counts.rejected;
    assert!(
        (several / 2..several + counts.steps / 4).contains(&taken),
        "{taken} {counts:?}"
    );
}
