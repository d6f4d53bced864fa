//! Tensioners of every kind, and drives at rest: the tension that was asked for, catenaries, stops, energy.

use crate::common;
use std::sync::Arc;

use crate::common::checks::{is_warned_of, rests_with};
use crate::common::layouts::{PITCH, three_shafts};
use crate::common::open::tensions;
use rustchain::drive::{Drive, SprocketMotion, Tensioner};
use rustchain::geometry::path::wrap::pitch_radius;
use rustchain::geometry::{Vec2, unit};
use rustchain::layout::InitialConfiguration;
use rustchain::{Equilibrium, ForceLaws, Model, Simulation};

/// Tension of every strand of a drive at rest \[N\].
fn tensions_at_rest(drive: &Drive) -> (Equilibrium, Vec<f64>) {
    let laws = ForceLaws::default();
    let rest = Equilibrium::find(drive, &laws).unwrap();
    let mut held = drive.clone();
    for sprocket in &mut held.sprockets {
        if let SprocketMotion::PrescribedSpeed(speed) = &mut sprocket.motion {
            *speed = 0.0.into();
        }
    }
    if let Some(tensioner) = &mut held.tensioner {
        tensioner.ramp_time = 0.0;
    }
    let mut start = rest.start.clone();
    start.velocities.fill([0.0; 3]);
    let model = Arc::new(Model::compile(&held, &laws, &start).unwrap());
    let control = rustchain::integrator::StepControl::default();
    let mut simulation = Simulation::new(model, &start, control).unwrap();
    (rest, tensions(&mut simulation, drive.sprockets.len()))
}

fn tensioner(number: usize, pretension: f64) -> Tensioner {
    Tensioner {
        sprocket: number,
        ..common::tensioner(pretension, 0.1)
    }
}

#[test]
fn every_tensioner_gives_its_strands_the_tension_it_is_asked_for() {
    let mut drive = three_shafts();
    drive.gravity = Vec2::zeros();
    let spring = Tensioner {
        stiffness: 2000.0,
        ..tensioner(4, 80.0)
    };
    let arm = Tensioner {
        pivot: Some(Vec2::new(0.0, 0.05)),
        ..tensioner(4, 80.0)
    };
    for (name, tensioner) in [
        ("slide", tensioner(4, 80.0)),
        ("slide of a shaft", tensioner(2, 80.0)),
        ("arm", arm),
        ("spring", spring),
    ] {
        drive.tensioner = Some(tensioner);
        rests_with(80.0, name, tensions_at_rest(&drive));
    }
}

/// Return a drive of two sprockets whose second centre is `short` \[m\] nearer to the first one than a taut chain has it.
fn two_shafts(short: f64, tensioner: Tensioner) -> Drive {
    let mut drive = common::paper_drive();
    drive.gravity = Vec2::zeros();
    drive.sprockets[1].center.x -= short;
    drive.tensioner = Some(tensioner);
    drive
}

#[test]
fn two_sprockets_have_the_tension_that_is_asked_for_in_any_direction_and_behind_a_spring() {
    let along = |x: f64, y: f64| Tensioner {
        direction: Some(Vec2::new(x, y)),
        ..tensioner(2, 80.0)
    };
    let spring = Tensioner {
        stiffness: 1e4,
        ..tensioner(2, 80.0)
    };
    for (name, short, tensioner) in [
        ("line of centres", 0.0, tensioner(2, 80.0)),
        ("steep", 0.0, along(1.0, -0.4)),
        ("steeper", 0.0, along(1.0, 1.0)),
        ("spring", 3e-3, spring),
        ("steep with slack", 3e-3, along(1.0, 5.8)),
    ] {
        let drive = two_shafts(short, tensioner);
        rests_with(80.0, name, tensions_at_rest(&drive));
    }
}

#[test]
fn the_line_of_centres_as_direction_of_two_sprockets_leaves_the_pull_as_it_is_to_the_bit() {
    for i in 0..40 {
        let between = 0.3 * unit(0.161 * f64::from(i));
        let mut drive = two_shafts(0.0, tensioner(2, 80.0));
        drive.sprockets[1].teeth = 25;
        drive.sprockets[1].center = between;
        let pull = |direction: Option<Vec2>| {
            let tensioner = Tensioner {
                direction,
                ..tensioner(2, 80.0)
            };
            tensioner.line(&drive).unwrap().pull
        };
        let [r1, r2] = [17, 25].map(|teeth| pitch_radius(PITCH, teeth));
        let sin = (r1 - r2) / between.norm();
        let along = 2.0 * 80.0 * (1.0 - sin * sin).sqrt();
        assert_eq!(pull(None), along);
        assert_eq!(pull(Some(7.0 * between)), along);
    }
}

#[test]
fn two_sprockets_are_warned_of_a_stop_before_the_slack_is_taken_up() {
    let stopped = Tensioner {
        travel: [0.0, 2e-3],
        ..tensioner(2, 80.0)
    };
    is_warned_of(&two_shafts(3e-3, stopped), "can by 2.000 mm");
}

#[test]
fn a_direction_that_does_not_move_two_sprockets_apart_is_refused() {
    for (x, y, takes_up) in [(-1.0, 0.0, "-2.000"), (0.0, 1.0, "0.000")] {
        let drive = two_shafts(
            0.0,
            Tensioner {
                direction: Some(Vec2::new(x, y)),
                ..tensioner(2, 80.0)
            },
        );
        let error = InitialConfiguration::generate(&drive)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("Tensioner.direction") && error.contains(takes_up),
            "{error}"
        );
    }
}

#[test]
fn a_stop_before_the_slack_is_taken_up_is_warned_of_and_bears_the_pull() {
    let mut drive = three_shafts();
    drive.gravity = Vec2::zeros();
    drive.tensioner = Some(Tensioner {
        travel: [0.0, 5e-3],
        ..tensioner(4, 80.0)
    });
    let (_, layout) = InitialConfiguration::generate(&drive).unwrap();
    is_warned_of(&drive, "can by 5.000 mm");
    let (rest, tension) = tensions_at_rest(&drive);
    let sprocket = rest.start.positions[drive.chain.links as usize + 3];
    let moved = (Vec2::new(sprocket[0], sprocket[1]) - drive.sprockets[3].center).norm();
    // The stop gives way by 1e-7 m a newton.
    let past = layout.tension_force / 1e7;
    assert!((moved - 5e-3 - past).abs() < 1e-8, "{moved}");
    assert!(
        tension.iter().all(|tension| tension.abs() < 1.0),
        "{tension:?}"
    );
}

#[test]
fn a_slack_strand_comes_to_rest_on_its_catenary() {
    let mut drive = common::paper_drive();
    drive.chain.links = 60;
    let taut = rustchain::layout::closing_center_distance(PITCH, [17, 17], 60).unwrap();
    drive.sprockets[1].center.x = taut - 2e-3;
    drive.sprockets[1].motion = SprocketMotion::AppliedTorque((-2.0).into());
    let (rest, _) = tensions_at_rest(&drive);
    assert!(rest.residual < 1e-4);
    // The hanging strand: hinges of links near mid-span.
    let (_, layout) = InitialConfiguration::generate(&drive).unwrap();
    let links: Vec<&[f64; 3]> = rest.start.positions[..60]
        .iter()
        .filter(|p| p[1] < 0.0 && p[0] > 0.02 && p[0] < taut - 0.02)
        .collect();
    // Weight w of a metre and tension H at the lowest point give tan(angle) = w s / H along the arc s: a straight line.
    let slope: Vec<f64> = links.iter().map(|p| p[2].tan()).collect();
    let steps: Vec<f64> = slope.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    assert!(mean > 0.0 && layout.slack[1] > 0.0);
    for step in &steps {
        // Inner and outer links weigh 6.5 and 8.3 g: 12 % either way of the mean.
        assert!((step / mean - 1.0).abs() < 0.2, "{step} of {mean}");
    }
}

#[test]
fn slack_strands_of_any_sag_and_load_come_to_rest() {
    // 12 to 24 % of the span; with no load at all the wheels' weightless teeth find nothing to lean on but the chain's weight.
    let taut = rustchain::layout::closing_center_distance(PITCH, [17, 17], 60).unwrap();
    for slack in [5e-3, 11e-3, 19e-3] {
        for torque in [0.0, -5.0] {
            let mut drive = common::paper_drive();
            drive.chain.links = 60;
            drive.sprockets[1].center.x = taut - slack;
            drive.sprockets[1].motion = SprocketMotion::AppliedTorque(torque.into());
            let rest = Equilibrium::find(&drive, &ForceLaws::default()).unwrap();
            assert!(rest.residual < 1e-4 * rest.largest_force);
            assert!(
                rest.iterations < 4000,
                "{slack} {torque}: {}",
                rest.iterations
            );
        }
    }
}

#[test]
fn a_torque_that_nothing_holds_has_no_rest() {
    let mut drive = common::paper_drive();
    drive.sprockets[0].motion = SprocketMotion::AppliedTorque(1.0.into());
    let error = Equilibrium::find(&drive, &ForceLaws::default()).unwrap_err();
    assert!(
        error.to_string().contains("does not come to rest"),
        "{error}"
    );
}

#[test]
fn an_arm_with_spring_leak_and_inertia_keeps_the_energy_balance() {
    let mut drive = three_shafts();
    drive.tensioner = Some(Tensioner {
        ramp_time: 0.01,
        damping: 100.0,
        damping_back: Some(5e3),
        stiffness: 4e3,
        pivot: Some(Vec2::new(0.0, 0.15)),
        arm_inertia: 5e-4,
        ratchet: None,
        travel: [1e-3, 0.012],
        ..tensioner(4, 60.0)
    });
    let control = rustchain::integrator::StepControl::default();
    let mut simulation = common::simulation(&drive, &ForceLaws::default(), control);
    let energies = common::energies(&mut simulation, 0.04, 1e-3);
    let (missing, dissipated) = (
        energies.residual.last().unwrap().abs(),
        *energies.dissipated.last().unwrap(),
    );
    // The bound that a run warns at is 5 %.
    assert!(dissipated > 0.01, "{dissipated}");
    assert!(missing < 0.03 * dissipated, "{missing} J of {dissipated} J");
    // The centre stays on the circle about the pivot.
    let body = drive.chain.links as usize + 3;
    let motion = simulation.motion();
    let arm = Vec2::new(motion.x[body], motion.y[body]) - Vec2::new(0.0, 0.15);
    let length = (drive.sprockets[3].center - Vec2::new(0.0, 0.15)).norm();
    assert!((arm.norm() - length).abs() < 1e-14);
    let moved = (Vec2::new(motion.x[body], motion.y[body]) - drive.sprockets[3].center).norm();
    assert!(moved > 1e-4);
}

#[test]
fn a_step_ends_where_the_ramp_of_a_tensioner_ends() {
    let mut drive = common::paper_drive();
    drive.tensioner = Some(Tensioner {
        ramp_time: 1.3e-3,
        ..tensioner(2, 80.0)
    });
    let laws = ForceLaws::default();
    let (start, _) = InitialConfiguration::generate(&drive).unwrap();
    let model = Model::compile(&drive, &laws, &start).unwrap();
    assert_eq!(model.next_kink(0.0), 1.3e-3);
    assert_eq!(model.next_kink(1.3e-3), f64::INFINITY);
}
