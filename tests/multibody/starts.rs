//! What is told of how a mechanism is placed and described: singular positions, circles behind outlines; and
//! that a bounce between two rows is no energy lost.

use std::sync::Arc;

use crate::common::mechanisms::{
    Rows, bar, bar_chain, control, ground, record, revolute, simulation,
};
use rustchain::geometry::Vec2;
use rustchain::integrator::StepControl;
use rustchain::layout::InitialConfiguration;
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, Joint, JointKind, Marker, Mechanism, MechanismModel,
    PrescribedMotion, Profile, Tribology,
};
use rustchain::run::MechanismSimulation;

fn warnings(mechanism: &Mechanism) -> Vec<String> {
    simulation(mechanism, 1e-8).assembly().warnings.clone()
}

/// Two cranks of 0.1 m and a coupler, at an angle from its position in one line.
fn parallelogram(angle: f64) -> Mechanism {
    let tip = 0.1 * Vec2::new(angle.cos(), angle.sin());
    let base = Vec2::new(0.2, 0.0);
    Mechanism {
        gravity: Vec2::zeros(),
        bodies: vec![
            bar("left", Vec2::zeros(), tip, 0.1),
            bar("right", base, base + tip, 0.1),
            bar("coupler", tip, base + tip, 0.2),
        ],
        joints: vec![
            revolute("a", ground(0.0, 0.0), Marker::new("left", -0.05, 0.0)),
            revolute("b", ground(0.2, 0.0), Marker::new("right", -0.05, 0.0)),
            revolute(
                "c",
                Marker::new("left", 0.05, 0.0),
                Marker::new("coupler", -0.1, 0.0),
            ),
            revolute(
                "d",
                Marker::new("right", 0.05, 0.0),
                Marker::new("coupler", 0.1, 0.0),
            ),
        ],
        ..Mechanism::default()
    }
}

fn told(found: &[String], words: &str) -> bool {
    found.iter().any(|text| text.contains(words))
}

#[test]
fn a_start_in_one_line_is_told_unless_velocities_say_how_it_goes_on() {
    let line = "singular position";
    assert!(!told(&warnings(&parallelogram(0.7)), line));
    let mut placed = parallelogram(0.0);
    let found = warnings(&placed);
    assert!(
        told(&found, line) && !told(&found, "redundant"),
        "{found:?}"
    );
    placed.joints.push(Joint::new(
        "motor",
        ground(0.0, 0.0),
        Marker::new("left", 0.0, 0.0),
        JointKind::DrivenAngle(PrescribedMotion::Speed(3.0.into())),
    ));
    assert!(told(&warnings(&placed), line));
    for body in &mut placed.bodies[..2] {
        *body = body.clone().moving(0.0, 0.15, 3.0);
    }
    placed.bodies[2] = placed.bodies[2].clone().moving(0.0, 0.3, 0.0);
    assert!(!told(&warnings(&placed), line));
    // A joint that is there twice is redundant everywhere.
    let mut twice = bar_chain(2, 0.4);
    let mut again = twice.joints[1].clone();
    again.name = "again".to_string();
    twice.joints.push(again);
    let found = warnings(&twice);
    assert!(
        !told(&found, line) && told(&found, "redundant"),
        "{found:?}"
    );
}

/// A ball of 0.1 m over a floor through these points.
fn ball(points: &[(f64, f64)], height: f64, law: ContactLaw) -> Mechanism {
    let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Mechanism {
        gravity: Vec2::new(0.0, -9.81),
        bodies: vec![Body::new("ball", 1.0, 4e-3).at(0.0, height, 0.0)],
        contacts: vec![ContactPair {
            name: "floor".to_string(),
            a: ground(0.0, 0.0),
            b: Marker::new("ball", 0.0, 0.0),
            profile: Profile::polyline("floor", &points, false).unwrap(),
            radius: 0.1,
            law,
            tribology: Tribology::default(),
        }],
        ..Mechanism::default()
    }
}

#[test]
fn a_circle_that_begins_behind_an_open_outline_is_told() {
    let law = || ContactLaw::Linear {
        stiffness: 1e6,
        damping: 0.0,
    };
    let leftwards = [(1.0, 0.0), (-1.0, 0.0)];
    let rightwards = [(-1.0, 0.0), (1.0, 0.0)];
    assert_eq!(warnings(&ball(&leftwards, 0.3, law())), [""; 0]);
    assert_eq!(warnings(&ball(&leftwards, 0.0999, law())), [""; 0]);
    assert!(told(&warnings(&ball(&rightwards, 0.3, law())), "reverse"));
    // One that is thrown through from behind is meant to be there.
    let mut thrown = ball(&leftwards, -0.3, law());
    thrown.bodies[0] = thrown.bodies[0].clone().moving(0.0, 3.0, 0.0);
    assert_eq!(warnings(&thrown), [""; 0]);
}

#[test]
fn bounces_between_rows_are_exchanged_and_a_loss_beside_rows_is_still_told() {
    let law = || ContactLaw::Linear {
        stiffness: 1e6,
        damping: 0.0,
    };
    let floor = [(1.0, 0.0), (-1.0, 0.0)];
    let note = |tolerance: f64, report_step: f64| {
        let model = MechanismModel::compile(&ball(&floor, 0.6, law())).unwrap();
        let control = control(tolerance, 0.05);
        let mut simulation = MechanismSimulation::assemble(Arc::new(model), control).unwrap();
        let found = record(&mut simulation, 4.0, report_step);
        let energy = found.energy();
        let residuals = energy.chunks(6).map(|row| row[5].abs());
        let missing = residuals.fold(0.0, f64::max);
        (simulation.balance_note().is_some(), missing)
    };
    // It falls by 0.5 m and comes back in 0.64 s: rows at the tops of bounces see next to no kinetic energy.
    let period = 2.0 * (2.0 * 0.5 / 9.81f64).sqrt();
    let (warned, missing) = note(1e-7, period);
    assert!(missing > 1e-4 && missing < 0.04, "{missing}");
    assert!(!warned, "{missing}");
    let (warned, missing) = note(3e-3, period);
    assert!(missing > 0.1 && warned, "{missing}");
}

#[test]
fn a_start_that_moves_a_fixed_body_or_is_no_number_is_refused() {
    let mechanism = Mechanism {
        bodies: vec![
            Body::new("base", 1.0, 1.0).fixed(),
            Body::new("ball", 1.0, 1.0),
        ],
        ..Mechanism::default()
    };
    let refused = |velocities: [[f64; 3]; 2]| {
        let model = MechanismModel::compile(&mechanism).unwrap();
        let start = InitialConfiguration {
            positions: vec![[0.0; 3]; 2],
            velocities: velocities.to_vec(),
            ..InitialConfiguration::default()
        };
        let control = StepControl::default();
        let made = MechanismSimulation::assemble_from(model, &start, control, &|| false);
        made.map_or_else(|error| error.to_string(), |_| String::new())
    };
    assert_eq!(refused([[0.0; 3], [1.0, 2.0, 3.0]]), "");
    let error = refused([[0.0, 3.0, 0.0], [0.0; 3]]);
    assert!(
        error.contains("velocity of body \"base\"") && error.contains("zero"),
        "{error}"
    );
    let error = refused([[0.0; 3], [0.0, f64::NAN, 0.0]]);
    assert!(error.contains("velocity of body \"ball\""), "{error}");
}

#[test]
fn only_joints_that_are_missed_are_listed() {
    let mut mechanism = bar_chain(3, 0.4);
    mechanism.joints.push(revolute(
        "far",
        ground(9.0, 0.0),
        Marker::new(mechanism.bodies[0].name.clone(), 0.0, 0.0),
    ));
    let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
    let refused = MechanismSimulation::assemble(model, control(1e-8, 0.05));
    let text = refused.unwrap_err().to_string();
    assert!(
        text.contains("\"far\" by") && !text.contains("0.000e0"),
        "{text}"
    );
}
