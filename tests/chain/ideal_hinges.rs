//! Ideal hinges: the same bits on every instruction set, with the projections onto the constraints; powers after a projection.

use crate::common;
use crate::common::checks::newton;
use crate::common::open::hoist;
use rustchain::ForceLaws;
use rustchain::drive::SprocketMotion::PrescribedSpeed;
use rustchain::drive::{Drive, HingeKind};
use rustchain::force_law::{Friction, Regularization};
use rustchain::integrator::{Corrector, StepControl};
use rustchain::math::simd::InstructionSet;
use rustchain::system::{PowerSum, System};

/// Friction on the teeth gives links moments.
const RUBBED: Friction = Friction {
    coefficient: 0.1,
    regularization: Regularization::Tanh,
    speed: 1e-3,
    dead_speed: 0.0,
};

/// A closed chain, and an open one.
fn drives() -> [Drive; 2] {
    let tightened = Drive {
        tensioner: Some(common::tensioner(100.0, 1e-3)),
        ..common::paper_drive()
    };
    [tightened, hoist(40, 14, 3.0, PrescribedSpeed(4.0.into()))].map(|drive| Drive {
        hinge_kind: HingeKind::Ideal,
        ..drive
    })
}

#[test]
fn every_width_runs_through_the_same_bits() {
    for (drive, tooth_friction) in drives()
        .iter()
        .flat_map(|drive| [(drive, None), (drive, Some(RUBBED))])
    {
        let laws = ForceLaws {
            tooth_friction,
            ..ForceLaws::default()
        };
        for corrector in [Corrector::Newton, Corrector::Pece] {
            let control = StepControl {
                corrector,
                ..StepControl::default()
            };
            let simulation = common::simulation(drive, &laws, control);
            let mut first: Option<Vec<f64>> = None;
            let sets = InstructionSet::available().into_iter();
            for set in sets.filter(|set| set.has_fused_multiply_add()) {
                let mut dynamics = simulation.dynamics().clone();
                let mut adams = simulation.integrator().clone();
                dynamics.use_instructions(set);
                adams.use_instructions(set);
                while adams.time() < 5e-3 {
                    dynamics.begin_step(&mut adams);
                    let step = adams.step_second_order(&mut dynamics).unwrap();
                    dynamics.finish_step(&mut adams, &step).unwrap();
                    adams.limit_step(dynamics.longest_step(&adams));
                }
                assert!(dynamics.event_counts().onsets > 0);
                let found = adams.y().to_vec();
                let same = *first.get_or_insert_with(|| found.clone()) == found;
                assert!(same, "{}, {corrector:?}", set.name());
            }
        }
    }
}

/// The projection moves the hinges after the last correction of every fourth step.
#[test]
fn the_powers_after_a_projection_are_evaluated() {
    for tooth_friction in [None, Some(RUBBED)] {
        let laws = ForceLaws {
            tooth_friction,
            ..ForceLaws::default()
        };
        let drive = Drive {
            hinge_kind: HingeKind::Ideal,
            tensioner: Some(common::tensioner(100.0, 1e-3)),
            ..common::paper_drive()
        };
        let mut simulation = common::simulation(&drive, &laws, newton(1e-9));
        common::advance(&mut simulation, 5e-3);
        let mut dynamics = simulation.dynamics().clone();
        let mut adams = simulation.integrator().clone();
        dynamics.begin_metering(&adams, adams.time());
        let (mut projected, mut corrected) = (0, 0);
        for _ in 0..200 {
            dynamics.begin_step(&mut adams);
            let step = adams.step_second_order(&mut dynamics).unwrap();
            dynamics.finish_step(&mut adams, &step).unwrap();
            dynamics.reach_step_end(&adams, &step, false);
            dynamics.meter_step(&adams, &step);
            // After the end of a step the sums grow with the power there.
            let mut power = dynamics.sums_at(step.end + 1.0);
            power.add_scaled(-1.0, &dynamics.sums_at(step.end));
            let exact = dynamics.clone().evaluate(step.end, adams.y());
            let error = (power.external_work - exact.external_work).abs();
            let same = error < 1e-9 * exact.external_work.abs();
            if adams.counts().steps.is_multiple_of(4) {
                assert!(same, "{tooth_friction:?}, {error:e} W of {exact:?}");
                projected += 1;
            } else {
                corrected += u32::from(!same);
            }
            adams.limit_step(dynamics.longest_step(&adams));
        }
        assert!(projected == 50 && corrected > 10, "{projected} {corrected}");
    }
}
