//! What is told of numbers in wrong units, and drivers and forces that change within less than a step.

use crate::common::mechanisms::{bar_chain, four_bars, ground, record, simulation, slider_crank};
use rustchain::geometry::Vec2;
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, Curve, ForceElement, ForceKind, Joint, JointKind, Marker,
    Mechanism, Motion, Profile, TimeFunction, Tribology,
};

fn warnings(mechanism: &Mechanism) -> Vec<String> {
    simulation(mechanism, 1e-8).assembly().warnings.clone()
}

/// A slider-crank with play in its wrist pin.
fn with_play() -> Mechanism {
    let mut mechanism = slider_crank(100.0);
    mechanism.joints.retain(|joint| joint.name != "wrist pin");
    mechanism.contacts.push(ContactPair {
        name: "wrist pin".into(),
        a: Marker::new("slider", 0.0, 0.0),
        b: Marker::new("rod", 0.06, 0.0),
        profile: Profile::Bore { radius: 0.01 },
        radius: 0.0099,
        law: ContactLaw::Linear {
            stiffness: 1e7,
            damping: 10.0,
        },
        tribology: Tribology::default(),
    });
    mechanism
}

#[test]
fn a_mass_or_inertia_off_by_a_thousand_is_told_with_body_value_expectation_and_factor() {
    for mechanism in [
        slider_crank(10.0),
        four_bars(1),
        bar_chain(4, 0.5),
        with_play(),
    ] {
        assert_eq!(warnings(&mechanism), Vec::<String>::new());
        for (i, body) in mechanism.bodies.iter().enumerate() {
            for (field, factor) in [
                ("mass", 1e3),
                ("mass", 1e-3),
                ("inertia", 1e3),
                ("inertia", 1e-3),
            ] {
                // A slider that does not turn may have any inertia.
                if body.name == "slider" && field == "inertia" {
                    continue;
                }
                let mut odd = mechanism.clone();
                let value = if field == "mass" {
                    &mut odd.bodies[i].mass
                } else {
                    &mut odd.bodies[i].inertia
                };
                *value *= factor;
                let shown = format!("{value:.4e}");
                let found = warnings(&odd);
                let told = found.iter().any(|text| {
                    text.contains(&format!("{:?}", body.name))
                        && text.contains(field)
                        && text.contains(&shown)
                        && text.contains("would be expected") | text.contains("other bodies")
                        && text.contains("1000 times")
                });
                assert!(told, "{field} of {} by {factor}: {found:?}", body.name);
                // Nothing else is blamed: a change of one number is one warning, of the field that was changed.
                let blamed = format!("{field} of body {:?}", body.name);
                assert!(
                    found.len() == 1 && found[0].starts_with(&blamed),
                    "{blamed} by {factor}: {found:?}"
                );
            }
        }
    }
}

#[test]
fn radii_lengths_and_gravity_in_millimetres_are_told() {
    let told = |change: &dyn Fn(&mut Mechanism), words: &[&str]| {
        let mut odd = with_play();
        odd.gravity = Vec2::new(0.0, -9.81);
        change(&mut odd);
        let found = warnings(&odd);
        let all = found
            .iter()
            .any(|text| words.iter().all(|word| text.contains(word)));
        assert!(all, "{words:?}: {found:?}");
    };
    let radii = |m: &mut Mechanism, bore: f64, pin: f64| {
        m.contacts[0].profile = Profile::Bore { radius: bore };
        m.contacts[0].radius = pin;
    };
    told(
        &|m| radii(m, 10.0, 9.9),
        &[
            "radius of contact",
            "wrist pin",
            "9.9000e0",
            "1000 times too large",
        ],
    );
    told(
        &|m| radii(m, 10.0, 0.0099),
        &[
            "bore_radius",
            "wrist pin",
            "1.0000e1",
            "1000 times too large",
        ],
    );
    told(
        &|m| radii(m, 1e-5, 9.9e-6),
        &[
            "radius of contact",
            "wrist pin",
            "9.9000e-6",
            "1000 times too small",
        ],
    );
    told(
        &|m| m.gravity.y *= 1000.0,
        &["gravity", "9.8100e3", "9.81 would", "1000 times too large"],
    );
    let mut far = bar_chain(4, 0.5);
    let end = Marker::new("bar 3", 500.0, 0.0);
    let push = ForceKind::Force {
        x: 1.0.into(),
        y: 0.0.into(),
        follows: false,
    };
    far.forces
        .push(ForceElement::new("push", ground(0.0, 0.0), end, push));
    let found = warnings(&far);
    assert!(
        found
            .iter()
            .any(|w| w.contains("points of body \"bar 3\"") && w.contains("5.0000e2")),
        "{found:?}"
    );
}

#[test]
fn a_body_placed_beside_its_joints_is_told_by_name() {
    let mut mechanism = four_bars(1);
    mechanism.bodies[1].position[0] += 0.25;
    let found = warnings(&mechanism);
    let post = format!("{:?}", mechanism.bodies[1].name);
    assert!(
        found
            .iter()
            .any(|w| w.contains("had to be moved") && w.contains(&post)),
        "{found:?}"
    );
}

/// A wheel on an axle, turned by a driver, and a weight on it off the axle.
fn driven(motion: Motion) -> Mechanism {
    let wheel = Body::new("wheel", 2.0, 0.5).at(0.3, 0.0, 0.0);
    Mechanism {
        gravity: Vec2::new(0.0, -9.81),
        bodies: vec![wheel],
        joints: vec![
            Joint::new(
                "axle",
                ground(0.0, 0.0),
                Marker::new("wheel", -0.3, 0.0),
                JointKind::Revolute,
            ),
            Joint::new(
                "motor",
                ground(0.0, 0.0),
                Marker::new("wheel", 0.0, 0.0),
                JointKind::DrivenAngle(motion),
            ),
        ],
        ..Mechanism::default()
    }
}

#[test]
fn the_work_of_a_driver_closes_better_with_the_tolerance_however_short_its_motion() {
    for span in [1.0, 1e-2, 1e-4] {
        let motion = Motion::Position(TimeFunction::SmoothStep {
            start: 0.5,
            end: 0.5 + span,
            from: 0.0,
            to: 1.0,
        });
        let residual = |tolerance: f64| {
            let mut machine = simulation(&driven(motion.clone()), tolerance);
            let recording = record(&mut machine, 2.0, 0.1);
            let rows = recording.energy.chunks(6);
            // What the wheel has on the way, at 15/8 of its mean speed.
            let energy = 0.5 * 0.68 * (1.875 / span).powi(2) + 5.0;
            rows.map(|row| row[5].abs()).fold(0.0, f64::max) / energy
        };
        let residuals = [1e-4, 1e-7, 1e-10].map(residual);
        assert!(residuals[0] < 1e-2, "{span}: {residuals:?}");
        assert!(residuals[1] < 1e-5, "{span}: {residuals:?}");
        assert!(residuals[2] < 1e-8, "{span}: {residuals:?}");
    }
}

#[test]
fn a_pulse_of_torque_shorter_than_a_step_is_not_passed_over() {
    let rows = [(1.0, 0.0), (1.001, 50.0), (1.003, 50.0), (1.004, 0.0)];
    let pulse = TimeFunction::Table(Curve::new("torque", &rows).unwrap());
    let mechanism = Mechanism {
        bodies: vec![Body::new("wheel", 1.0, 0.5)],
        forces: vec![ForceElement::new(
            "pulse",
            ground(0.0, 0.0),
            Marker::new("wheel", 0.0, 0.0),
            ForceKind::Torque(pulse),
        )],
        ..Mechanism::default()
    };
    let missed = [1e-5, 1e-9].map(|tolerance| {
        let mut machine = simulation(&mechanism, tolerance);
        let recording = record(&mut machine, 2.0, 1.0);
        let spin = *recording.velocities.last().unwrap();
        // 50 N m for 3 ms on 0.5 kg m².
        assert!((spin - 0.3).abs() < 10.0 * tolerance, "{spin}");
        recording.energy.last().unwrap().abs()
    });
    assert!(missed[0] < 1e-3 && missed[1] < 1e-6, "{missed:?}");
}
