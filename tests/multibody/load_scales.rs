//! Springs, forces, drivers and contact lengths in wrong units are told where the mechanism shows it; what is sound is not.

use crate::common::mechanisms::{andrews, bar_chain, ground, simulation, slider_crank};
use rustchain::force_law::ForceLaw;
use rustchain::geometry::Vec2;
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, ForceElement, ForceKind, Joint, JointKind, Marker, Mechanism,
    Motion, Profile, SpringLaw, TimeFunction, Tribology,
};

fn warnings(mechanism: &Mechanism) -> Vec<String> {
    simulation(mechanism, 1e-8).assembly().warnings.clone()
}

/// A weight of 2 kg on a slide and a spring of 0.3 m, pushed by 10 N, its fork turned by a spring.
fn suspension(spring: SpringLaw, rest: Option<f64>, push: f64) -> Mechanism {
    let end = || Marker::new("weight", 0.0, 0.05);
    Mechanism {
        gravity: Vec2::new(0.0, -9.81),
        bodies: vec![
            Body::new("weight", 2.0, 2e-3).at(0.0, 0.25, 0.0),
            Body::new("fork", 1.0, 3e-3).at(0.1, 0.25, 0.0),
        ],
        joints: vec![
            Joint::new(
                "slide",
                ground(0.0, 0.0),
                Marker::new("weight", 0.0, 0.0),
                JointKind::Prismatic {
                    direction: Vec2::new(0.0, 1.0),
                    angle: None,
                },
            ),
            Joint::new(
                "pin",
                Marker::new("weight", 0.0, 0.0),
                Marker::new("fork", -0.1, 0.0),
                JointKind::Revolute,
            ),
        ],
        forces: vec![
            ForceElement::new(
                "strut",
                ground(0.0, 0.0),
                end(),
                ForceKind::Spring { law: spring, rest },
            ),
            ForceElement::new(
                "push",
                ground(0.0, 0.0),
                end(),
                ForceKind::Force {
                    x: 0.0.into(),
                    y: push.into(),
                    follows: false,
                },
            ),
            ForceElement::new(
                "twist",
                Marker::new("weight", 0.0, 0.0),
                Marker::new("fork", 0.0, 0.0),
                ForceKind::TorsionSpring {
                    law: SpringLaw::linear(20.0, 0.02),
                    rest: None,
                },
            ),
        ],
        ..Mechanism::default()
    }
}

fn sound() -> Mechanism {
    suspension(SpringLaw::linear(500.0, 4.0), Some(0.33), 10.0)
}

#[test]
fn sound_mechanisms_are_told_nothing() {
    for mechanism in [sound(), slider_crank(500.0), bar_chain(4, 0.5), andrews()] {
        assert_eq!(warnings(&mechanism), Vec::<String>::new());
    }
}

/// The one thing that is told has all of `words`.
fn told(mechanism: &Mechanism, words: &[&str]) {
    let found = warnings(mechanism);
    let all = words
        .iter()
        .all(|word| found.first().is_some_and(|text| text.contains(word)));
    assert!(found.len() == 1 && all, "{words:?}: {found:?}");
}

#[test]
fn springs_off_by_a_thousand_are_told() {
    let (k, c, rest) = (500.0, 4.0, 0.33);
    let strut = |k, c, rest| suspension(SpringLaw::linear(k, c), Some(rest), 10.0);
    let spring = "of spring \"strut\"";
    told(
        &strut(k / 1000.0, c / 1000.0, rest),
        &["stiffness", spring, "5.0000e-1 N/m", "1000 times too small"],
    );
    told(
        &strut(k, c * 1000.0, rest),
        &["damping", spring, "4.0000e3", "1000 times too large"],
    );
    told(
        &strut(k, c / 1000.0, rest),
        &["damping", spring, "4.0000e-3", "1000 times too small"],
    );
    told(
        &strut(k, c, rest * 1000.0),
        &["rest_length", spring, "3.3000e2", "1000 times too large"],
    );
    told(
        &strut(k, c, rest / 1000.0),
        &["rest_length", spring, "3.3000e-4", "1000 times too small"],
    );
    told(
        &strut(-k, c, rest),
        &["stiffness", spring, "is the sign right"],
    );
    // A spring of two stable lengths is none of this.
    let snap = SpringLaw {
        stiffness: -500.0,
        cubic: 1e5,
        ..SpringLaw::default()
    };
    assert_eq!(
        warnings(&suspension(snap, Some(0.33), 10.0)),
        Vec::<String>::new()
    );
}

#[test]
fn forces_and_torques_off_by_a_thousand_are_told() {
    let push = |force| suspension(SpringLaw::linear(500.0, 4.0), Some(0.33), force);
    for (force, words) in [
        (
            1e4,
            ["force \"push\"", "1.0000e4 N", "1000 times too large"],
        ),
        (
            1e-2,
            ["force \"push\"", "1.0000e-2 N", "1000 times too small"],
        ),
    ] {
        told(&push(force), &words);
    }
    let motor = |torque: f64| {
        let mut mechanism = andrews();
        mechanism.forces[1].kind = ForceKind::Torque(TimeFunction::Constant(torque));
        mechanism
    };
    assert_eq!(warnings(&motor(0.33)), Vec::<String>::new());
    told(
        &motor(3300.0),
        &["torque \"torque\"", "3.3000e3 N m", "too large"],
    );
}

#[test]
fn a_load_may_be_small_beside_what_makes_masses_go_round() {
    // 10 N beside m ω² r of some 2e5 N, which the pin bears.
    let mut mechanism = sound();
    mechanism.bodies[1].velocity = [0.0, 50.0, 500.0]; // about the pin
    assert_eq!(warnings(&mechanism), Vec::<String>::new());
}

#[test]
fn drivers_off_by_a_thousand_are_told() {
    told(
        &slider_crank(500e3),
        &["speed of driver", "5.0000e5 rad/s", "faster than sound"],
    );
    let lift = |way: f64| {
        let mut mechanism = sound();
        mechanism.forces.truncate(1);
        mechanism.joints.push(Joint::new(
            "lift",
            ground(0.0, 0.0),
            Marker::new("weight", 0.0, 0.0),
            JointKind::DrivenPosition {
                direction: Vec2::new(0.0, 1.0),
                motion: Motion::Position(TimeFunction::SmoothStep {
                    start: 0.1,
                    end: 0.5,
                    from: 0.25,
                    to: way,
                }),
            },
        ));
        mechanism
    };
    assert_eq!(warnings(&lift(0.35)), Vec::<String>::new());
    told(&lift(350.0), &["position of driver \"lift\"", "3.5000e2 m"]);
}

#[test]
fn contact_lengths_off_by_a_thousand_are_told() {
    let with_play = |length: f64| {
        let mut mechanism = slider_crank(100.0);
        mechanism.joints.retain(|joint| joint.name != "wrist pin");
        mechanism.contacts.push(ContactPair {
            name: "wrist pin".into(),
            a: Marker::new("slider", 0.0, 0.0),
            b: Marker::new("rod", 0.06, 0.0),
            profile: Profile::Bore { radius: 0.01 },
            radius: 0.0099,
            law: ContactLaw::Surfaces {
                law: ForceLaw::default(),
                contact_modulus: 1e11,
                restitution: 0.9,
                length,
                min_approach_speed: 1e-3,
            },
            tribology: Tribology::default(),
        });
        mechanism
    };
    assert_eq!(warnings(&with_play(0.015)), Vec::<String>::new());
    let name = "length of contact \"wrist pin\"";
    told(
        &with_play(15.0),
        &[name, "1.5000e1 m", "1000 times too large"],
    );
    told(
        &with_play(1.5e-5),
        &[name, "1.5000e-5 m", "1000 times too small"],
    );
    // Of radii in millimetres, these are told and not the length beside them.
    let mut wide = with_play(0.015);
    wide.contacts[0].profile = Profile::Bore { radius: 10.0 };
    wide.contacts[0].radius = 9.9;
    told(&wide, &["radius of contact \"wrist pin\"", "9.9000e0 m"]);
}
