//! Where drives begin: eccentric teeth, slack that a tensioner takes up under load, and velocities of a start at rest.

use crate::common;
use std::cell::Cell;
use std::sync::Arc;

use crate::common::layouts::{PITCH, three_shafts};
use rustchain::drive::{Drive, SprocketMotion, StraightTooth, Tensioner, ToothForm};
use rustchain::geometry::{Seat, Vec2};
use rustchain::layout::InitialConfiguration;
use rustchain::{Equilibrium, ForceLaws, Model, Simulation};

fn tensioner(number: usize, pretension: f64) -> Tensioner {
    Tensioner {
        sprocket: number,
        ..common::tensioner(pretension, 0.1)
    }
}

#[test]
fn eccentric_teeth_are_laid_whatever_their_angle() {
    let mut refused = Vec::new();
    for (name, drive) in [("two", common::paper_drive()), ("four", three_shafts())] {
        for (i, sprocket) in [(0, 1), (1, 0)].into_iter().cycle().take(48).enumerate() {
            let mut drive = drive.clone();
            drive.chain.links += 2 * u32::from(name == "four");
            let faults = &mut drive.sprockets[sprocket.0].faults;
            faults.eccentricity = if i % 4 < 2 { 5e-5 } else { 2e-4 };
            faults.eccentricity_angle = 0.131 * i as f64;
            drive.sprockets[1].center.x -= 1e-4 + 1e-5 * i as f64;
            match InitialConfiguration::generate(&drive) {
                Ok((start, layout)) => {
                    // The teeth are where their angle has them, and nothing touches.
                    assert!(layout.start_gap > 0.0, "{name} {i}: {}", layout.start_gap);
                    let model = Model::compile(&drive, &ForceLaws::default(), &start).unwrap();
                    let mut simulation =
                        Simulation::new(Arc::new(model), &start, common::control(1e-5)).unwrap();
                    let present = simulation.present();
                    let deepest = present.evaluated.teeth.penetration.iter().copied();
                    assert!(
                        deepest.fold(f64::NEG_INFINITY, f64::max) < 0.0,
                        "{name} {i}"
                    );
                }
                Err(error) => refused.push(format!("{name} {i}: {error}")),
            }
        }
    }
    assert!(
        refused.is_empty(),
        "{} refused: {refused:#?}",
        refused.len()
    );
}

/// Return how often a search that is refused has asked whether to give up: once for each layout that it tries.
fn tried(is_refused: impl Fn(&dyn Fn() -> bool) -> bool) -> u32 {
    let asked = Cell::new(0);
    let refused = is_refused(&|| {
        asked.set(asked.get() + 1);
        false
    });
    assert!(refused);
    asked.get()
}

#[test]
fn a_chain_that_is_refused_round_centered_teeth_is_searched_once_for_eccentric_ones() {
    let mut drive = three_shafts();
    drive.chain.links += 60;
    let tried = |drive: &Drive| {
        tried(|give_up| InitialConfiguration::generate_unless(drive, give_up).is_err())
    };
    let centered = tried(&drive);
    assert!(centered > 100, "{centered}");
    drive.sprockets[2].faults.eccentricity = 1e-4;
    assert_eq!(tried(&drive), centered);
}

#[test]
fn a_chain_that_fits_no_teeth_is_refused_soon_however_far_a_tensioner_would_move() {
    let mut drive = three_shafts();
    drive.chain.links += 16;
    let blunt = StraightTooth {
        flank_angle: 0.05,
        seat_radius: None,
        seat: Seat::BottomDiameter,
        roller_diameter: None,
        tip_diameter: None,
        edge_radius: None,
    };
    drive.sprockets[1].profile = ToothForm::Straight(blunt);
    let laid = |give_up: &dyn Fn() -> bool| {
        InitialConfiguration::generate_unless(&drive, give_up).is_err()
    };
    let once = tried(laid);
    let mut tensioned = drive.clone();
    tensioned.tensioner = Some(tensioner(4, 80.0));
    let far = tensioned.tensioner.unwrap().line(&tensioned).unwrap();
    assert!(far.taut_at.unwrap() > 4.0 * PITCH, "{far:?}");
    let at_rest = tried(|give_up| {
        Equilibrium::find_unless(&tensioned, &ForceLaws::default(), give_up).is_err()
    });
    assert!(at_rest < 30 * once, "{at_rest} of {once}");
}

/// A drive of four sprockets with a load and an arm, or a slide, that has slack to take up.
fn loaded(arm: bool, more_links: u32, load: f64, pretension: f64) -> Drive {
    let mut drive = three_shafts();
    drive.chain.links += more_links;
    drive.sprockets[1].motion = SprocketMotion::AppliedTorque((-load).into());
    drive.tensioner = Some(Tensioner {
        pivot: arm.then(|| Vec2::new(0.0, 0.05)),
        ..tensioner(4, pretension)
    });
    drive
}

#[test]
fn much_slack_is_taken_up_under_load() {
    // The strand that the load slackens keeps a part of the tension.
    for (arm, more_links, load, pretension) in [
        (false, 0, 3.0, 80.0),
        (true, 0, 3.0, 80.0),
        (false, 2, 3.0, 80.0),
        (true, 2, 3.0, 80.0),
        (false, 2, -3.0, 80.0),
        (true, 2, 8.0, 250.0),
    ] {
        let drive = loaded(arm, more_links, load, pretension);
        let line = drive.tensioner.unwrap().line(&drive).unwrap();
        let rest = Equilibrium::find(&drive, &ForceLaws::default());
        let rest = rest.unwrap_or_else(|error| {
            panic!("{arm} {more_links} {load}: {:?} m: {error}", line.taut_at)
        });
        assert!(rest.iterations < 5_000, "{}", rest.iterations);
    }
}

#[test]
fn an_equilibrium_found_soon_stores_the_surfaces_of_its_contacts() {
    let (drive, laws) = (loaded(false, 0, 3.0, 80.0), ForceLaws::default());
    let rest = Equilibrium::find(&drive, &laws).unwrap();
    // Surfaces are stored every 500 iterations, and when the forces are in balance.
    assert!(rest.iterations < 500, "{}", rest.iterations);
    let model = Arc::new(Model::compile(&drive, &laws, &rest.start).unwrap());
    let control = rustchain::integrator::StepControl::default();
    let mut simulation = Simulation::new(Arc::clone(&model), &rest.start, control).unwrap();
    let teeth = &simulation.present().evaluated.teeth;
    let touching = teeth.near.iter().map(|&pair| pair as usize);
    let touching = touching.filter(|&pair| teeth.penetration[pair] > 0.0);
    let mut touching: Vec<[usize; 2]> = touching
        .map(|pair| [pair % model.links, pair / model.links])
        .collect();
    touching.sort_unstable();
    let mut stored: Vec<[usize; 2]> = (rest.start.surfaces.iter())
        .map(|&[bushing, sprocket, _]| [bushing, sprocket])
        .collect();
    stored.sort_unstable();
    assert!(!stored.is_empty());
    assert_eq!(stored, touching);
}

/// Fastest approach in a loaded contact of `drive` at the first instant of a start at rest, over the chain's speed.
fn fastest_approach(drive: &Drive) -> f64 {
    let laws = ForceLaws::default();
    let rest = Equilibrium::find(drive, &laws).unwrap();
    let model = Arc::new(Model::compile(drive, &laws, &rest.start).unwrap());
    let control = rustchain::integrator::StepControl::default();
    let mut simulation = Simulation::new(Arc::clone(&model), &rest.start, control).unwrap();
    let present = simulation.present();
    let hinges = (0..model.links).map(|k| {
        (
            present.evaluated.hinges.penetration[k],
            present.evaluated.hinges.rate[k],
        )
    });
    let teeth = present.evaluated.teeth.near.iter().map(|&pair| {
        let pair = pair as usize;
        (
            present.evaluated.teeth.penetration[pair],
            present.evaluated.teeth.rate[pair],
        )
    });
    let fastest = hinges.chain(teeth).filter(|(depth, _)| *depth > 0.0);
    let fastest = fastest.map(|(_, rate)| rate.abs()).fold(0.0, f64::max);
    let SprocketMotion::PrescribedSpeed(speed) = &drive.sprockets[0].motion else {
        panic!("a driver of prescribed speed");
    };
    fastest / (speed.value(0.0) * model.sprockets[0].profile.pitch_radius)
}

#[test]
fn a_running_drive_that_starts_at_rest_moves_along_its_contacts() {
    for (arm, load, pretension) in [(false, 0.0, 80.0), (true, 3.0, 80.0), (false, 8.0, 250.0)] {
        let drive = loaded(arm, 0, load, pretension);
        let fastest = fastest_approach(&drive);
        assert!(
            fastest < 0.01,
            "{arm} {load}: {fastest} of the chain's speed"
        );
    }
}

#[test]
fn an_arm_may_move_along_its_way_wherever_it_begins() {
    let drive = loaded(true, 0, 0.0, 80.0);
    let rest = Equilibrium::find(&drive, &ForceLaws::default()).unwrap();
    let model = Arc::new(Model::compile(&drive, &ForceLaws::default(), &rest.start).unwrap());
    let body = model.links + 3;
    let [x, y, _] = rest.start.positions[body];
    let (s, tangent) = model.sprockets[3].slide_at(Vec2::new(x, y)).unwrap();
    assert!(s > 1e-3, "{s}");
    let mut start = rest.start;
    let control = rustchain::integrator::StepControl::default();
    for (velocity, fits) in [
        (0.1 * tangent, true),
        (0.1 * model_direction(&model), false),
    ] {
        [start.velocities[body][0], start.velocities[body][1]] = velocity.into();
        let made = Simulation::new(Arc::clone(&model), &start, control);
        assert_eq!(made.is_ok(), fits, "{:?}", made.err());
    }
}

/// Direction of the arm's way where it is described.
fn model_direction(model: &Model) -> Vec2 {
    match model.sprockets[3].support {
        rustchain::chain::model::Support::Slide { direction, .. } => direction,
        _ => Vec2::zeros(),
    }
}
