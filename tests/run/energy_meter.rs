//! Error of the energy quadrature: its share in the residual, and its agreement with evaluations of the right-hand side inside steps.

use crate::common;
use rustchain::drive::{Drive, SprocketMotion};
use rustchain::force_law::{Friction, Regularization};
use rustchain::integrator::{Corrector, StepControl};
use rustchain::{ForceLaws, Simulation};

/// Quantities of a run at its end.
struct Metered {
    /// Residual, dissipated energy and external work \[J\].
    residual: f64,
    dissipated: f64,
    external_work: f64,
    steps: u64,
    /// Evaluations of the right-hand side by the quadrature.
    evaluations: u64,
}

/// Record the energies of `run` for `duration` \[s\]; with `panels`, by evaluations in as many panels of each section of a step.
fn metered(mut run: Simulation, panels: Option<usize>, duration: f64) -> Metered {
    if let Some(panels) = panels {
        run.refine_meter(panels);
    }
    let energy = common::energies(&mut run, duration, duration / 5.0);
    let statistics = run.statistics();
    Metered {
        residual: *energy.residual.last().unwrap(),
        dissipated: *energy.dissipated.last().unwrap(),
        external_work: *energy.worked_in.last().unwrap(),
        steps: statistics.counts.steps,
        evaluations: statistics.meter_evaluations,
    }
}

fn newton(accuracy: f64) -> StepControl {
    StepControl {
        corrector: Corrector::Newton,
        accuracy,
        ..StepControl::default()
    }
}

fn tensioned(pretension: f64, variation: f64) -> Simulation {
    let mut drive = common::paper_drive();
    drive.gravity *= variation;
    if pretension > 0.0 {
        drive.tensioner = Some(common::tensioner(pretension, 2e-3));
    }
    common::simulation(&drive, &ForceLaws::default(), newton(1e-9))
}

/// Shares of the quadrature in the residual: along the paths of contacts, by evaluations, and by evaluations in two panels, over several
/// slightly different runs.
fn assert_a_small_part_of_the_residual(pretension: f64) {
    let runs = 16;
    let (mut residuals, mut differences) = (0.0, [0.0; 3]);
    for i in 0..runs {
        let variation = 1.0 + 1e-3 * f64::from(i);
        let [paths, one, two, many] = [None, Some(1), Some(2), Some(16)]
            .map(|panels| metered(tensioned(pretension, variation), panels, 0.05));
        assert_eq!(
            paths.steps, many.steps,
            "the motion depends on the quadrature"
        );
        assert_eq!(paths.evaluations, 0);
        assert!(one.evaluations > 2 * one.steps);
        residuals += many.residual.powi(2);
        for (difference, run) in differences.iter_mut().zip([&paths, &one, &two]) {
            *difference += (run.residual - many.residual).powi(2);
        }
    }
    let share = differences.map(|difference: f64| (difference / residuals).sqrt());
    // Measured over 24 runs by evaluations: 0.10, 0.16, 0.005 of residuals of 1.4e-5, 0.9e-5, 6.6e-5 J at 0, 25 and 100 N; half of that in
    // two panels. Sixteen runs scatter by a fifth on either side of the quotient.
    assert!(share[0] < 0.2, "{pretension} N: {share:?}");
    assert!(share[2] < share[1], "{pretension} N: {share:?}");
}

#[test]
fn the_meter_has_a_small_part_of_the_residual_of_the_slack_chain() {
    assert_a_small_part_of_the_residual(0.0);
}

#[test]
fn the_meter_has_a_small_part_of_the_residual_under_25_newtons() {
    assert_a_small_part_of_the_residual(25.0);
}

#[test]
fn the_meter_has_a_small_part_of_the_residual_under_100_newtons() {
    assert_a_small_part_of_the_residual(100.0);
}

/// Return the paper's drive with rollers, friction in all contacts, a tensioner with a dashpot, and a driven sprocket free to turn.
fn drive_with_all_losses(free: bool) -> (Drive, ForceLaws) {
    let mut drive = common::paper_drive();
    drive.chain = common::roller_chain();
    drive.tensioner = Some(common::tensioner(25.0, 2e-3));
    if free {
        drive.sprockets[1].motion = SprocketMotion::AppliedTorque((-0.1).into());
        drive.sprockets[1].initial_speed = Some(4.0 * std::f64::consts::PI);
    }
    let friction = Friction {
        coefficient: 0.1,
        regularization: Regularization::Tanh,
        speed: 1e-2,
        dead_speed: 0.0,
    };
    let laws = ForceLaws {
        hinge_friction: Some(friction),
        tooth_friction: Some(friction),
        ..ForceLaws::default()
    };
    (drive, laws)
}

/// Penetrations, sliding velocities and lever arms are cubics of their own along the paths. Evaluations use cubics of the coordinates.
/// Both have errors of order four: a quotient of 16 for a halved step.
#[test]
fn powers_along_paths_are_those_of_evaluations() {
    for free in [false, true] {
        let (drive, laws) = drive_with_all_losses(free);
        let difference = |max_step: f64| {
            let control = StepControl {
                max_step,
                ..newton(1e-8)
            };
            let [paths, evaluations] = [None, Some(1)]
                .map(|panels| metered(common::simulation(&drive, &laws, control), panels, 2e-3));
            assert_eq!(paths.steps, evaluations.steps);
            [
                (paths.dissipated - evaluations.dissipated).abs() / evaluations.dissipated,
                (paths.external_work - evaluations.external_work).abs()
                    / evaluations.external_work.abs(),
            ]
        };
        let [coarse, fine] = [4e-7, 1e-7].map(difference);
        println!("{coarse:?} {fine:?}");
    }
}
