//! Ideal hinges on every instruction set: the same bits, with the projections onto the constraints.

use crate::common;
use rustchain::ForceLaws;
use rustchain::drive::{Drive, HingeKind};
use rustchain::force_law::{Friction, Regularization};
use rustchain::integrator::{Corrector, StepControl};
use rustchain::math::simd::InstructionSet;
use rustchain::system::System;

/// Friction on the teeth gives links moments.
const RUBBED: Friction = Friction {
    coefficient: 0.1,
    regularization: Regularization::Tanh,
    speed: 1e-3,
    dead_speed: 0.0,
};

#[test]
fn every_width_runs_through_the_same_bits() {
    for tooth_friction in [None, Some(RUBBED)] {
        let laws = ForceLaws {
            tooth_friction,
            ..ForceLaws::default()
        };
        for corrector in [Corrector::Newton, Corrector::Pece] {
            let control = StepControl {
                corrector,
                ..StepControl::default()
            };
            let drive = Drive {
                hinge_kind: HingeKind::Ideal,
                tensioner: Some(common::tensioner(100.0, 1e-3)),
                ..common::paper_drive()
            };
            let simulation = common::simulation(&drive, &laws, control);
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
