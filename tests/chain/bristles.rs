//! Friction of bristles in hinges, rollers and teeth: kernels beside the scalar reference, sticking, energy, restart, both correctors.

use crate::common;
use crate::common::checks::{floating, keeps_momentum, lacks, largest};
use crate::common::rubbing::{
    Standing, both_chains, kernels_beside_reference, lost, pulled, standing,
};
use rustchain::drive::{HingeKind, InputQuantity as Quantity};
use rustchain::force_law::{Film, Friction, LuGre, Regularization};
use rustchain::integrator::{Adams, Corrector, OdeSystem, SecondOrderSystem, StepControl};
use rustchain::{ForceLaws, Simulation};

fn bristles() -> LuGre {
    LuGre {
        static_coefficient: 0.15,
        kinetic_coefficient: 0.1,
        stiffness: 1e5,
        damping: 0.3,
        viscous_coefficient: 0.02,
        stribeck_speed: 5e-3,
        stribeck_exponent: 2.0,
    }
}

/// Bristles in hinges, on teeth, and both.
fn places(law: LuGre) -> [ForceLaws; 3] {
    [(true, false), (false, true), (true, true)].map(|(hinges, teeth)| ForceLaws {
        hinge_bristles: hinges.then_some(law),
        tooth_bristles: teeth.then_some(law),
        ..ForceLaws::default()
    })
}

fn control(corrector: Corrector) -> StepControl {
    StepControl {
        corrector,
        accuracy: 1e-10,
        ..StepControl::default()
    }
}

/// The paper's drive at 100 N.
fn drive(laws: &ForceLaws, corrector: Corrector) -> Simulation {
    pulled(common::paper_drive(), laws, 100.0, control(corrector))
}

/// Each of them with bristles in each of the places, and in hinges with thin oil, when all is pressed.
fn pressed() -> Vec<(ForceLaws, Standing)> {
    let oiled = ForceLaws {
        hinge_bristles: Some(bristles()),
        hinge_film: Some(Film {
            viscosity: 1e-3,
            length: None,
            handover: 0.9,
            tension: 1e5,
        }),
        ..ForceLaws::default()
    };
    let mut all = Vec::new();
    for drive in both_chains() {
        for laws in places(bristles()).into_iter().chain([oiled]) {
            let run = pulled(drive.clone(), &laws, 100.0, control(Corrector::Auto));
            all.push((laws, standing(run, 6e-3)));
        }
    }
    all
}

#[test]
fn kernels_give_what_the_scalar_reference_gives() {
    for (laws, state) in pressed() {
        for beside in kernels_beside_reference(&state, 0.0) {
            let model = state.0.model();
            let bent = &beside.slope[model.coordinates..][model.bristles.all()];
            let expected = beside.reference.bristle_rates(model);
            assert_eq!(bent.len(), expected.len());
            let size = largest(bent);
            for (rate, expected) in bent.iter().zip(expected) {
                assert!(
                    (rate - expected).abs() <= 1e-7 * size,
                    "{rate} for {expected}"
                );
            }
            assert!(bent.iter().filter(|rate| **rate != 0.0).count() > 4);
            let losses = beside.losses;
            // Oil may bear all hinges.
            if laws.hinge_film.is_none() {
                assert_eq!(losses.hinge_friction != 0.0, laws.hinge_bristles.is_some());
            }
            assert_eq!(losses.tooth_friction != 0.0, laws.tooth_bristles.is_some());
        }
    }
}

#[test]
fn bristles_take_no_momentum_from_a_drive_that_floats() {
    for laws in places(bristles()) {
        let mut run = floating(&laws, control(Corrector::Auto));
        let mut rubbed = 0;
        for report in 1..=200 {
            common::advance(&mut run, 1e-4 * f64::from(report));
            let losses = keeps_momentum(&run);
            rubbed += u32::from(losses.hinge_friction + losses.tooth_friction != 0.0);
        }
        assert!(rubbed > 2, "{rubbed}");
    }
}

#[test]
fn a_correction_by_newtons_matrix_lacks_little() {
    for (laws, (mut dynamics, t, y)) in pressed() {
        let model = dynamics.model().clone();
        let bent = y[model.coordinates..][model.bristles.all()].to_vec();
        for gamma in [5e-6, 1e-6, 1e-7] {
            dynamics.begin_implicit_stage(Some((&bent, gamma)));
            let found = lacks(&mut dynamics, t, &y, gamma);
            // Measured: at most 0.06, less with shorter steps.
            assert!(found < 0.3, "{laws:?}, {gamma:e}: {found}");
        }
        dynamics.begin_implicit_stage(None);
    }
}

#[test]
fn the_balance_closes_and_what_is_lost_adds_up() {
    for laws in places(bristles()) {
        for (corrector, span) in [
            (Corrector::Newton, 0.01),
            (Corrector::Auto, 0.01),
            (Corrector::Pece, 0.005),
        ] {
            let lost = lost(&mut drive(&laws, corrector), span, 1e-12);
            // Measured: at most 6e-5.
            let share = lost.missing;
            assert!(share < 1e-3, "{laws:?}, {corrector:?}: {share:e}");
            let rubbing = [laws.hinge_bristles, laws.tooth_bristles];
            for (place, law) in lost.places[2..].iter().zip(rubbing) {
                assert_eq!(place.last().unwrap() > &1e-5, law.is_some(), "{laws:?}");
                // Where a load changes a bent bristle's store changes with it.
                let falls = place.windows(2).map(|pair| pair[0] - pair[1]);
                assert!(falls.fold(0.0, f64::max) < 0.02 * lost.all, "{place:?}");
            }
        }
    }
}

/// The state a tenth of a millisecond on, in which bristles bend and slip and few contacts close.
fn goes_on(from: &Standing, corrector: Corrector, accuracy: f64) -> Vec<f64> {
    let (mut dynamics, t, mut y) = from.clone();
    let how = StepControl {
        accuracy,
        ..control(corrector)
    };
    let mut adams = Adams::new(y.len(), how);
    adams.restart(t, &y);
    let end = t + 1e-4;
    while adams.time() < end {
        adams.step_second_order(&mut dynamics).unwrap();
    }
    adams.interpolate(end, &mut y);
    y
}

/// The largest difference of two arrays.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn results_do_not_depend_on_where_steps_fall() {
    let [.., laws] = places(bristles());
    let from = standing(drive(&laws, Corrector::Auto), 5e-3);
    let model = from.0.model().clone();
    let scale = bristles().breakaway();
    let parts = |y: &[f64]| {
        let bent = y[model.coordinates..][model.bristles.all()].to_vec();
        (bent, y[..2 * model.links].to_vec())
    };
    let (begun, _) = parts(&from.2);
    let (bent, at) = parts(&goes_on(&from, Corrector::Pece, 1e-12));
    assert!(apart(&begun, &bent) > 0.2 * scale);
    for (corrector, accuracy) in [
        (Corrector::Pece, 1e-10),
        (Corrector::Newton, 1e-10),
        (Corrector::Newton, 1e-11),
    ] {
        let (other, there) = parts(&goes_on(&from, corrector, accuracy));
        let (bristles, places) = (apart(&bent, &other) / scale, apart(&at, &there));
        // Measured at 1e-10 m: 1.5e-2 of break-away, and 5e-9 m.
        assert!(bristles < 0.05 && places < 2e-8, "{bristles:e}, {places:e}");
    }
}

#[test]
fn speeds_set_under_way_leave_bristles_as_they_are() {
    let [.., laws] = places(bristles());
    let mut run = drive(&laws, Corrector::Auto);
    common::advance(&mut run, 2.000_3e-3);
    let before = run.present().evaluated.bristles.deflection.clone();
    run.set_input(0, Quantity::Speed, 13.0.into()).unwrap();
    let after = run.present().clone();
    for (i, (before, now)) in before
        .iter()
        .zip(&after.evaluated.bristles.deflection)
        .enumerate()
    {
        let links = after.model().links;
        let touches = if i < links {
            after.evaluated.hinges.penetration[i] > 0.0
        } else {
            after.evaluated.teeth.penetration[i - links] > 0.0
        };
        assert_eq!(*now, if touches { *before } else { 0.0 });
    }
    common::advance(&mut run, 2.2e-3);
}

#[test]
fn two_frictions_in_one_place_are_refused() {
    let laws = ForceLaws {
        hinge_bristles: Some(bristles()),
        hinge_friction: Some(Friction {
            coefficient: 0.1,
            regularization: Regularization::Tanh,
            speed: 1e-3,
            dead_speed: 0.0,
        }),
        ..ForceLaws::default()
    };
    let drive = common::paper_drive();
    let (start, _) = rustchain::layout::InitialConfiguration::generate(&drive).unwrap();
    let refused = rustchain::Model::compile(&drive, &laws, &start).unwrap_err();
    assert!(refused.to_string().contains("hinge_friction"), "{refused}");
}

#[test]
fn the_padding_of_a_state_has_no_derivative_error_or_correction() {
    let mut ideal = common::paper_drive();
    ideal.hinge_kind = HingeKind::Ideal;
    let drives = both_chains().into_iter().chain([ideal]);
    let mut padded = 0;
    for (drive, laws) in drives.flat_map(|drive| {
        let [hinges, teeth, both] = places(bristles());
        let plain = ForceLaws::default();
        let with_clearance = drive.hinge_kind == HingeKind::Clearance;
        let laws = [Some(plain), Some(teeth), with_clearance.then_some(hinges)];
        let laws = laws.into_iter().chain([with_clearance.then_some(both)]);
        laws.flatten()
            .map(|laws| (drive.clone(), laws))
            .collect::<Vec<_>>()
    }) {
        let run = pulled(drive, &laws, 100.0, control(Corrector::Newton));
        let mut dynamics = run.dynamics().clone();
        let y = run.integrator().y().to_vec();
        let (used, all) = (
            dynamics.model().used_coordinates,
            dynamics.model().coordinates,
        );
        assert!(used <= all && all < used + 8 && all.is_multiple_of(8));
        padded += all - used;
        let mut scale = vec![f64::NAN; all];
        dynamics.scale(&mut scale);
        let mut slope = vec![f64::NAN; 2 * all];
        dynamics.derivative(0.0, &y, &mut slope);
        dynamics.accelerations_with_slopes(0.0, &y, &mut slope);
        assert!(dynamics.factorise(&y, 1e-7));
        let mut residual = vec![1e-3; all];
        dynamics.correct(&mut residual);
        assert_eq!(dynamics.counted(), 2 * used);
        for i in used..all {
            let found = [scale[i], slope[i], slope[all + i], residual[i]];
            assert_eq!(found, [0.0; 4], "{i} of {used}");
        }
        for i in 0..used {
            assert!(scale[i] > 0.0 && slope[all + i].is_finite() && residual[i].is_finite());
        }
    }
    assert!(padded > 0);
}
