//! Recordings of one group of channels: the same rows as in a recording of everything, and no contact looked for in vain.

use crate::common::{advance, control, paper_drive, record, roller_drive, simulation, tensioner};
use rustchain::drive::{Drive, SprocketMotion};
use rustchain::force_law::{Friction, Regularization};
use rustchain::integrator::StepControl;
use rustchain::math::simd::InstructionSet;
use rustchain::{ForceLaws, Groups, Recording, Simulation};

const NOTHING: Groups = Groups {
    hinges: false,
    teeth: false,
    sprockets: false,
    bodies: false,
    energy: false,
};

const ALL: Groups = Groups {
    hinges: true,
    teeth: true,
    sprockets: true,
    bodies: true,
    energy: true,
};

fn single_groups() -> [Groups; 5] {
    let mut groups = [NOTHING; 5];
    groups[0].hinges = true;
    groups[1].teeth = true;
    groups[2].sprockets = true;
    groups[3].bodies = true;
    groups[4].energy = true;
    groups
}

/// A drive just after its first contacts.
fn in_contact(drive: &Drive) -> Simulation {
    let mut simulation = simulation(drive, &ForceLaws::default(), control(1e-5));
    advance(&mut simulation, 5e-3);
    simulation
}

#[test]
fn a_group_recorded_alone_has_the_rows_of_a_recording_of_everything() {
    let mut tensioned = paper_drive();
    tensioned.tensioner = Some(tensioner(25.0, 1e-3));
    let mut turned = paper_drive();
    turned.sprockets[0].motion = SprocketMotion::AppliedTorque(0.2.into());
    turned.sprockets[0].initial_speed = Some(4.0 * std::f64::consts::PI);
    for drive in [paper_drive(), tensioned, turned] {
        let ready = in_contact(&drive);
        let everything = record(&mut ready.clone(), 1e-3, 1e-5, ALL);
        assert!(everything.time.len() > 100);
        let mut channels = 0;
        for groups in single_groups() {
            let alone = record(&mut ready.clone(), 1e-3, 1e-5, groups);
            assert_eq!(alone.time, everything.time);
            for channel in &alone.channels {
                assert!(everything.channels.contains(channel), "{}", channel.name);
                channels += 1;
            }
        }
        assert_eq!(channels, everything.channels.len());
    }
}

#[test]
fn a_report_looks_for_no_contact_that_its_channels_do_not_need() {
    let ready = in_contact(&paper_drive());
    let before = {
        let mut ready = ready.clone();
        ready.present().clone()
    };
    for groups in single_groups().into_iter().chain([NOTHING]) {
        let mut simulation = ready.clone();
        simulation.present();
        record(&mut simulation, 1e-3, 1e-4, groups);
        let after = simulation.dynamics();
        // The driver's torque is what its teeth leave to it.
        let teeth = groups.teeth || groups.sprockets;
        let found = |wanted: bool, before: &[f64], after: &[f64], what: &str| {
            assert_eq!(before != after, wanted, "{what}, recording {groups:?}");
        };
        found(
            true,
            &before.evaluated.motion.x,
            &after.evaluated.motion.x,
            "positions of bodies",
        );
        found(
            groups.hinges || groups.energy,
            &before.evaluated.hinges.penetration,
            &after.evaluated.hinges.penetration,
            "depths of hinges",
        );
        found(
            groups.hinges || groups.energy,
            &before.evaluated.hinges.force,
            &after.evaluated.hinges.force,
            "forces of hinges",
        );
        found(
            teeth || groups.energy,
            &before.evaluated.teeth.penetration,
            &after.evaluated.teeth.penetration,
            "depths of teeth",
        );
        found(
            false,
            &before.evaluated.accelerations.x,
            &after.evaluated.accelerations.x,
            "accelerations",
        );
    }
}

#[test]
fn every_width_records_the_same_bits() {
    let friction = Friction {
        coefficient: 0.1,
        regularization: Regularization::Tanh,
        speed: 1e-3,
        dead_speed: 0.0,
    };
    for mut drive in [paper_drive(), roller_drive()] {
        drive.tensioner = Some(tensioner(25.0, 0.1));
        for friction in [None, Some(friction)] {
            let laws = ForceLaws {
                hinge_friction: friction,
                tooth_friction: friction,
                ..ForceLaws::default()
            };
            let recordings = InstructionSet::available()
                .into_iter()
                .filter(|set| set.has_fused_multiply_add())
                .map(|set| {
                    let mut run = simulation(&drive, &laws, StepControl::default());
                    run.use_instructions(set);
                    record(&mut run, 0.06, 1e-3, ALL)
                });
            let recordings: Vec<Recording> = recordings.collect();
            for pair in recordings.windows(2) {
                for (one, other) in pair[0].channels.iter().zip(&pair[1].channels) {
                    assert!(one == other, "{}, {laws:?}", one.name);
                }
            }
        }
    }
}
