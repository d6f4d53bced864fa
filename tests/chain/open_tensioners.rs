//! Tensioners of open chains: the tension asked for between two pins, and a load that a tensioner lifts.

use crate::common;
use crate::common::checks::{is_warned_of, rests_with};
use crate::common::open::{at_rest, first_row, hoist, tensions, tightened};
use crate::common::{channel, energies};
use rustchain::drive::{ChainEnd, Drive, SprocketMotion, Tensioner};
use rustchain::geometry::Vec2;
use rustchain::integrator::StepControl;
use rustchain::layout::InitialConfiguration;
use rustchain::{Equilibrium, ForceLaws};

fn tensions_at_rest(drive: &Drive) -> (Equilibrium, Vec<f64>) {
    let mut drive = drive.clone();
    drive.tensioner.as_mut().unwrap().ramp_time = 0.0;
    let (mut run, rest) = at_rest(&drive, &ForceLaws::default(), StepControl::default());
    (rest, tensions(&mut run, drive.sprockets.len() + 1))
}

#[test]
fn every_strand_between_two_pins_gets_the_tension_that_is_asked_for() {
    for (name, change) in [
        ("slide", (None, None, 0.0)),
        ("straight up", (Some(Vec2::y()), None, 0.0)),
        ("arm", (None, Some(Vec2::new(0.1, 0.06)), 0.0)),
        ("spring", (None, None, 4000.0)),
    ] {
        let (direction, pivot, stiffness) = change;
        let mut drive = tightened(80.0);
        drive.gravity = Vec2::zeros();
        drive.tensioner = Some(Tensioner {
            direction,
            pivot,
            stiffness,
            ..common::tensioner(80.0, 0.0)
        });
        rests_with(80.0, name, tensions_at_rest(&drive));
    }
}

#[test]
fn a_stop_before_the_slack_is_taken_up_is_warned_of() {
    let mut drive = tightened(80.0);
    let (_, free) = InitialConfiguration::generate(&drive).unwrap();
    assert!(
        free.warnings.iter().all(|w| !w.contains("tensioner")),
        "{:?}",
        free.warnings
    );
    drive.tensioner.as_mut().unwrap().travel = [0.0, 1e-4];
    is_warned_of(&drive, "can by 0.100 mm");
}

/// A wheel over which a load hangs, carried by a tensioner with a spring.
fn fork_lift(pretension: f64) -> Drive {
    let mut drive = hoist(40, 14, 10.0, SprocketMotion::Free);
    drive.ends.as_mut().unwrap()[0] = ChainEnd::Anchored {
        position: Vec2::new(-0.06, -0.2),
        velocity: [0.0.into(), 0.0.into()],
        links: None,
    };
    drive.tensioner = Some(Tensioner {
        sprocket: 1,
        direction: Some(Vec2::y()),
        stiffness: 4000.0,
        ..common::tensioner(pretension, 0.02)
    });
    drive
}

#[test]
fn a_tensioner_carries_its_wheel_the_chain_and_what_hangs_from_it() {
    for pretension in [115.0, 130.0] {
        let mut drive = fork_lift(pretension);
        drive.tensioner.as_mut().unwrap().ramp_time = 0.0;
        let (_, layout) = InitialConfiguration::generate(&drive).unwrap();
        let (mut run, rest) = at_rest(&drive, &ForceLaws::default(), StepControl::default());
        let row = first_row(&mut run);
        let links = drive.chain.links as usize;
        let raised = rest.start.positions[links + 2][1] - drive.sprockets[0].center.y;
        let chain: f64 = (0..links).map(|i| drive.chain.strand_link(i).mass).sum();
        let (wheel, _) = drive.sprockets[0].mass_properties(&drive.chain);
        // The chain pulls the anchor up, and the anchor the chain down.
        let carried = 9.81 * (chain + wheel + 10.0) + channel(&row, "end_force")[1];
        let pull = layout.tension_force - 4000.0 * raised;
        assert!(
            (pull / carried - 1.0).abs() < 1e-5,
            "{pull} N for {carried} N, raised by {raised} m"
        );
        // With a belt's tension on both sides of the wheel.
        assert!((layout.tension_force - 1.98 * pretension).abs() < 0.02 * pretension);
    }
}

#[test]
fn the_energy_of_a_tightened_open_chain_is_accounted_for() {
    for drive in [tightened(60.0), fork_lift(120.0)] {
        let mut run = common::simulation(&drive, &ForceLaws::default(), StepControl::default());
        let found = energies(&mut run, 0.04, 1e-3);
        let turned = found.external_work.last().unwrap().abs()
            + found.kinetic.last().unwrap()
            + found.dissipated.last().unwrap();
        let missing = found.largest_residual();
        assert!(
            turned > 1e-3 && missing < 5e-3 * turned,
            "{missing} J of {turned} J"
        );
    }
}

#[test]
fn a_tensioner_that_would_slacken_the_chain_is_refused() {
    let mut drive = tightened(60.0);
    drive.tensioner.as_mut().unwrap().direction = Some(-Vec2::y());
    let refusal = InitialConfiguration::generate(&drive)
        .unwrap_err()
        .to_string();
    assert!(refusal.contains("must tighten the chain"), "{refusal}");
}
