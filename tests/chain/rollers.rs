//! Rollers as bodies of their own: forces beside the scalar reference, the implicit corrector's matrix, and runs.

use crate::common;
use crate::common::checks::{
    forces_and_powers_follow_from_a_correction, matrix_is_that_of_finite_differences, newton,
    powers_are_evaluated_after_several_corrections,
};
use crate::common::scenes::{Scene, laws};
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::Chain;
use rustchain::force_law::{Damping, Elastic, Friction, Regions, Regularization};
use rustchain::integrator::StepControl;
use rustchain::math::simd::InstructionSet;
use rustchain::{ForceLaws, Simulation, Snapshot};

const RUBBED: Option<Friction> = Some(Friction {
    coefficient: 0.1,
    regularization: Regularization::Tanh,
    speed: 1e-2,
    dead_speed: 0.0,
});

fn simulation(laws: &ForceLaws, pretension: f64, control: StepControl) -> Simulation {
    let mut drive = common::roller_drive();
    if pretension > 0.0 {
        drive.tensioner = Some(common::tensioner(pretension, 2e-3));
    }
    common::simulation(&drive, laws, control)
}

/// Laws of all forms, each with two pretensions, when hinges, rollers and teeth are pressed.
fn pressed_scenes() -> Vec<(String, Simulation)> {
    let mut scenes = Vec::new();
    for (elastic, damping) in [
        (Elastic::Hertz, Damping::LankaraniNikravesh),
        (Elastic::Hertz, Damping::None),
        (Elastic::Johnson, Damping::LankaraniNikravesh),
        (Elastic::LiuConformal, Damping::Flores),
    ] {
        for pretension in [25.0, 100.0] {
            let laws = laws(elastic, damping, Regions::Kept);
            let run = pressed(&laws, pretension);
            scenes.push((format!("{elastic:?} {damping:?} {pretension} N"), run));
        }
    }
    scenes
}

/// Friction in hinges and rollers, on teeth, and both, in the same state.
fn rubbed_scenes() -> Vec<(String, Simulation)> {
    let mut scenes = Vec::new();
    for [hinges, teeth] in [[true, false], [false, true], [true, true]] {
        for pretension in [25.0, 100.0] {
            let laws = ForceLaws {
                hinge_friction: RUBBED.filter(|_| hinges),
                tooth_friction: RUBBED.filter(|_| teeth),
                ..ForceLaws::default()
            };
            let run = pressed(&laws, pretension);
            scenes.push((format!("rubbed {hinges} {teeth} {pretension} N"), run));
        }
    }
    scenes
}

/// A run when hinges, rollers and teeth are pressed.
fn pressed(laws: &ForceLaws, pretension: f64) -> Simulation {
    let mut run = simulation(laws, pretension, common::control(1e-5));
    let mut time = 8e-3;
    common::advance(&mut run, time);
    while !all_kinds_touch(run.dynamics()) {
        time += 1e-4;
        common::advance(&mut run, time);
    }
    run
}

/// Whether some hinge, some bushing in its roller and some roller on a tooth touch.
fn all_kinds_touch(dynamics: &Dynamics) -> bool {
    dynamics.hinge_contacts().any(|(depth, _)| depth > 0.0)
        && dynamics.roller_contacts().any(|(depth, _)| depth > 0.0)
        && dynamics.candidates().any(|(_, _, depth, _)| depth > 0.0)
}

#[test]
fn the_matrix_is_that_of_finite_differences_but_for_angles_turned_in_a_step() {
    for (scene, run) in pressed_scenes() {
        matrix_is_that_of_finite_differences(&scene, &run, all_kinds_touch);
    }
}

#[test]
fn forces_and_powers_after_a_correction_need_no_evaluation() {
    let scenes = pressed_scenes().into_iter().chain(rubbed_scenes());
    let compared = forces_and_powers_follow_from_a_correction(scenes, 0.0);
    assert_eq!(compared, 24);
}

#[test]
fn only_steps_with_several_corrections_have_their_powers_from_an_evaluation() {
    let mut run = simulation(&ForceLaws::default(), 100.0, newton(1e-10));
    common::energies(&mut run, 0.02, 2e-3);
    powers_are_evaluated_after_several_corrections(&run);
}

#[test]
fn both_correctors_follow_one_path_before_chaos() {
    for laws in [
        ForceLaws::default(),
        ForceLaws {
            hinge_friction: RUBBED,
            tooth_friction: RUBBED,
            ..ForceLaws::default()
        },
    ] {
        let at_5_ms = |control| {
            let mut run = simulation(&laws, 0.0, control);
            common::advance(&mut run, 5e-3);
            run.motion().positions()
        };
        let reference = at_5_ms(common::control(1e-11));
        let off = |control| {
            at_5_ms(control)
                .iter()
                .zip(&reference)
                .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
                .fold(0.0, f64::max)
        };
        let errors = [1e-9, 1e-11].map(|accuracy| off(newton(accuracy)));
        // What a bushing chain is held to, 2e-6, times the mass of a link over that of a roller, whose errors may be so much larger.
        assert!(errors[0] < 1e-5, "{errors:?}");
        assert!(errors[1] < 0.2 * errors[0], "{errors:?}");
    }
}

#[test]
fn the_energy_balance_closes() {
    for (pretension, friction) in [(25.0, None), (100.0, None), (100.0, RUBBED)] {
        let with = ForceLaws {
            hinge_friction: friction,
            tooth_friction: friction,
            ..ForceLaws::default()
        };
        let [loose, tight] = [1e-9, 1e-11].map(|accuracy| {
            let mut run = simulation(&with, pretension, newton(accuracy));
            let energy = common::energies(&mut run, 0.03, 3e-3);
            energy.largest_residual() / energy.dissipated.last().unwrap()
        });
        assert!(
            loose < 0.02 && tight < 3e-3,
            "{pretension} N: {loose} {tight}"
        );
    }
}

#[test]
fn a_roller_that_nothing_touches_falls_and_keeps_its_turning() {
    let mut run = simulation(&ForceLaws::default(), 0.0, common::control(1e-9));
    let start = run.motion();
    let n = run.model().links;
    let span = 1e-3;
    common::advance(&mut run, span);
    let end = run.motion();
    let mut free = 0;
    for k in n..2 * n {
        let turned = start.angle[k] + start.spin[k] * span;
        assert!((end.angle[k] - turned).abs() < 1e-12);
        let fallen = start.y[k] + start.vy[k] * span - 0.5 * 9.81 * span * span;
        let along = start.x[k] + start.vx[k] * span;
        // Touched ones leave that path by micrometres.
        if (end.y[k] - fallen).abs() < 1e-12 && (end.x[k] - along).abs() < 1e-12 {
            free += 1;
        }
    }
    assert!(free > 10, "{free}");
}

#[test]
fn a_snapshot_goes_on_to_the_same_bits_in_both_correctors() {
    for control in [common::control(1e-5), newton(1e-9)] {
        let mut run = simulation(&ForceLaws::default(), 25.0, control);
        common::advance(&mut run, 7e-3);
        let bytes = run.snapshot().to_bytes().unwrap();
        let mut again = simulation(&ForceLaws::default(), 25.0, control);
        again
            .restore(&Snapshot::from_bytes(&bytes).unwrap())
            .unwrap();
        for run in [&mut run, &mut again] {
            common::advance(run, 9e-3);
        }
        assert_eq!(run.motion().positions(), again.motion().positions());
        assert_eq!(run.motion().velocities(), again.motion().velocities());
        let bushings = common::simulation(&common::paper_drive(), &ForceLaws::default(), control);
        let mut bushings = bushings;
        assert!(
            bushings
                .restore(&Snapshot::from_bytes(&bytes).unwrap())
                .is_err()
        );
    }
}

#[test]
fn every_width_runs_through_the_same_bits() {
    for laws in [
        ForceLaws::default(),
        ForceLaws {
            hinge_friction: RUBBED,
            tooth_friction: RUBBED,
            ..ForceLaws::default()
        },
    ] {
        for control in [common::control(1e-5), newton(1e-9)] {
            let mut drive = common::roller_drive();
            drive.tensioner = Some(common::tensioner(25.0, 2e-3));
            let scene = Scene::laid(&drive, &laws);
            let mut bits: Option<Vec<f64>> = None;
            let fused = InstructionSet::available().into_iter();
            for set in fused.filter(|set| set.has_fused_multiply_add()) {
                let (mut dynamics, mut adams) = scene.ready(control);
                dynamics.use_instructions(set);
                adams.use_instructions(set);
                while adams.time() < 7e-3 {
                    dynamics.forget_ended_contacts();
                    let step = adams.step_second_order(&mut dynamics).unwrap();
                    dynamics.record_contact_events(&adams, &step);
                    adams.limit_step(dynamics.longest_step_past_teeth());
                }
                let found = adams.y().to_vec();
                let same = *bits.get_or_insert_with(|| found.clone()) == found;
                assert!(same, "{}", set.name());
            }
        }
    }
}

#[test]
fn rollers_run_in_layouts_of_many_sprockets_with_guides() {
    let mut drive = common::layouts::guided_shafts();
    drive.chain = Chain {
        links: drive.chain.links,
        ..common::roller_chain()
    };
    let mut run = common::simulation(&drive, &ForceLaws::default(), StepControl::default());
    let energy = common::energies(&mut run, 0.02, 2e-3);
    let lost = *energy.dissipated.last().unwrap();
    assert!(lost > 0.0);
    assert!(
        energy.largest_residual() < 0.02 * lost,
        "{} {lost}",
        energy.largest_residual()
    );
}
