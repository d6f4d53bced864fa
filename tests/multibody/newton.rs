//! The implicit corrector's matrix of a mechanism: against differences, against the chain's own, and how it scales.

use crate::common;
use std::sync::Arc;

use crate::common::mechanisms::{bar_chain, ground};
use crate::common::scenes::laws;
use nalgebra::{DMatrix, DVector};
use rustchain::ForceLaws;
use rustchain::drive::Drive;
use rustchain::force_law::{
    Damping, Elastic, Film, ForceLaw, Friction, LuGre, Regions, Regularization,
};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, OdeSystem, SecondOrderSystem, StepControl};
use rustchain::math::{Signal, Table};
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, CustomForce, ForceElement, ForceKind, FrictionLaw, Joint,
    JointKind, Marker, Mechanism, MechanismDynamics, MechanismModel, Piece, PinFriction,
    PrescribedMotion, Profile, SpringLaw, Tribology,
};
use rustchain::run::MechanismSimulation;

/// Numbers between -1 and 1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn marker(body: &str, x: f64, y: f64) -> Marker {
    Marker::new(body, x, y)
}

const ALONG: Vec2 = Vec2::new(0.6, 0.8);

fn waves() -> Signal {
    Signal::Sines {
        offset: 0.1,
        terms: vec![[0.3, 2.0, 0.4]],
    }
}

/// Every joint, every force and every profile on six bodies.
fn zoo() -> Mechanism {
    Mechanism {
        gravity: Vec2::new(0.0, -9.81),
        bodies: ["a", "b", "c", "d", "e", "f"]
            .iter()
            .enumerate()
            .map(|(i, name)| Body::new(*name, 1.0 + i as f64, 0.3 + 0.1 * i as f64))
            .collect(),
        joints: joints(),
        forces: forces(),
        contacts: contacts(),
    }
}

fn joints() -> Vec<Joint> {
    let joint = |name: &str, a: Marker, b: Marker, kind| Joint::new(name, a, b, kind);
    vec![
        joint(
            "revolute",
            ground(0.1, 0.2),
            marker("a", -0.5, 0.1),
            JointKind::Revolute,
        ),
        joint(
            "slide",
            marker("a", 0.4, 0.0),
            marker("b", 0.1, 0.2),
            JointKind::Prismatic {
                direction: ALONG,
                angle: Some(0.2),
            },
        ),
        joint(
            "weld",
            marker("b", 0.3, 0.1),
            marker("c", -0.2, 0.0),
            JointKind::Fixed { angle: Some(0.1) },
        ),
        joint(
            "line",
            marker("c", 0.1, 0.0),
            marker("d", 0.3, -0.2),
            JointKind::PointOnLine { direction: ALONG },
        ),
        joint(
            "rod",
            marker("d", 0.1, 0.4),
            marker("e", -0.3, 0.1),
            JointKind::Distance { length: Some(0.7) },
        ),
        joint(
            "gear",
            marker("e", 0.0, 0.0),
            marker("f", 0.0, 0.0),
            JointKind::Gear {
                ratio: -1.7,
                carrier: Some("a".into()),
            },
        ),
        joint(
            "rack",
            marker("d", 0.0, 0.1),
            marker("f", 0.0, 0.0),
            JointKind::Rack {
                direction: ALONG,
                radius: 0.3,
            },
        ),
        joint(
            "motor",
            ground(0.0, 0.0),
            marker("e", 0.0, 0.0),
            JointKind::DrivenAngle(PrescribedMotion::Position(waves())),
        ),
        joint(
            "ram",
            marker("a", 0.1, 0.0),
            marker("f", 0.2, 0.1),
            JointKind::DrivenPosition {
                direction: ALONG,
                motion: PrescribedMotion::Speed(waves()),
            },
        ),
    ]
}

fn forces() -> Vec<ForceElement> {
    let law = SpringLaw {
        stiffness: 40.0,
        cubic: 7.0,
        damping: 3.0,
        table: None,
    };
    let torque = Table::against(
        "torque",
        ("speed", "rad/s"),
        "N m",
        &[(-50.0, 20.0), (0.0, 1.0), (50.0, -30.0)],
    )
    .unwrap();
    let custom = CustomForce(Arc::new(|t, q, v| {
        [
            q[1] * v[2] + t,
            -3.0 * q[0] * q[2],
            v[0] - 0.2 * v[2] * v[2],
        ]
    }));
    let force = |name: &str, a: Marker, b: Marker, kind| ForceElement::new(name, a, b, kind);
    let push = |follows| ForceKind::Force {
        x: 3.0.into(),
        y: waves(),
        follows,
    };
    let spring = ForceKind::Spring {
        law: law.clone(),
        rest: Some(0.4),
    };
    vec![
        force(
            "spring",
            marker("a", 0.2, 0.3),
            marker("d", -0.1, 0.2),
            spring,
        ),
        force(
            "twist",
            marker("c", 0.0, 0.0),
            marker("f", 0.0, 0.0),
            ForceKind::TorsionSpring {
                law,
                rest: Some(0.2),
            },
        ),
        force("push", ground(0.0, 0.0), marker("b", 0.3, 0.2), push(false)),
        force(
            "thrust",
            ground(0.0, 0.0),
            marker("c", 0.2, -0.3),
            push(true),
        ),
        force(
            "motor torque",
            marker("b", 0.0, 0.0),
            marker("e", 0.0, 0.0),
            ForceKind::TorqueBySpeed(torque),
        ),
        force(
            "own",
            ground(0.0, 0.0),
            marker("d", 0.0, 0.0),
            ForceKind::Custom(custom),
        ),
    ]
}

/// One contact of each kind, so large that all are pressed wherever the bodies are.
fn contacts() -> Vec<ContactPair> {
    let points = |rows: &[(f64, f64)]| {
        rows.iter()
            .map(|&(x, y)| Vec2::new(x, y))
            .collect::<Vec<_>>()
    };
    let linear = ContactLaw::Linear {
        stiffness: 50.0,
        damping: 0.5,
    };
    let hunt = ContactLaw::HuntCrossley {
        stiffness: 30.0,
        exponent: 1.5,
        damping: 0.02,
    };
    let arc = |from: (f64, f64), to: (f64, f64), center: (f64, f64), convex| Piece {
        from: Vec2::new(from.0, from.1),
        to: Vec2::new(to.0, to.1),
        center: Some(Vec2::new(center.0, center.1)),
        convex,
    };
    let dome = Profile::Outline {
        pieces: vec![arc((6.0, 0.0), (-6.0, 0.0), (0.0, 0.0), true)],
        closed: false,
    };
    let bowl = Profile::Outline {
        pieces: vec![arc((9.0, 5.0), (-9.0, 5.0), (0.0, 5.0), false)],
        closed: false,
    };
    let contact = |name: &str, a: &str, b: &str, profile, radius, law: &ContactLaw| ContactPair {
        name: name.into(),
        a: marker(a, 0.2, 0.1),
        b: marker(b, -0.1, 0.3),
        profile,
        radius,
        law: law.clone(),
        tribology: Tribology::default(),
    };
    let floor = Profile::polyline("floor", &points(&[(9.0, -3.0), (-9.0, -3.0)]), false).unwrap();
    let corner = Profile::polyline(
        "corner",
        &points(&[(-3.0, 9.0), (-3.0, -3.0), (9.0, -3.0)].map(|(x, y)| (-x, y))),
        false,
    );
    vec![
        contact("bore", "a", "c", Profile::Bore { radius: 0.5 }, 0.45, &hunt),
        contact(
            "disc",
            "b",
            "d",
            Profile::Disc { radius: 4.0 },
            5.0,
            &linear,
        ),
        contact("floor", "ground", "e", floor, 8.0, &hunt),
        contact("corner", "f", "b", corner.unwrap(), 5.0, &linear),
        contact("dome", "c", "e", dome, 3.0, &linear),
        contact("bowl", "d", "f", bowl, 6.0, &hunt),
    ]
}

fn dynamics(mechanism: &Mechanism) -> MechanismDynamics {
    let model = Arc::new(MechanismModel::compile(mechanism).unwrap());
    MechanismDynamics::new(model)
}

/// Overwrites a residual of velocities by the solution with 1 - γ ∂a/∂v - γ² ∂a/∂q, from central differences of the derivative at `y`.
fn correct_by_differences(
    dynamics: &mut MechanismDynamics,
    y: &[f64],
    gamma: f64,
    residual: &mut [f64],
) {
    let (n, bodies) = (dynamics.coordinates(), dynamics.local_unknowns().start);
    let mut lengths = vec![1.0; n];
    dynamics.scale(&mut lengths);
    let mut accelerations_at = |i: usize, change: f64| {
        let (mut y, mut slope) = (y.to_vec(), vec![0.0; y.len()]);
        y[i] += gamma * change;
        y[n + i] += change;
        dynamics.derivative(0.3, &y, &mut slope);
        DVector::from_column_slice(&slope[n..n + bodies])
    };
    let mut matrix = DMatrix::identity(bodies, bodies);
    for (i, length) in lengths[..bodies].iter().enumerate() {
        let change = 1e-6 / length;
        let slope = accelerations_at(i, change) - accelerations_at(i, -change);
        let column = matrix.column(i) - 0.5 * gamma * slope / change;
        matrix.set_column(i, &column);
    }
    let solution = matrix
        .lu()
        .solve(&DVector::from_column_slice(&residual[..bodies]))
        .unwrap();
    residual[..bodies].copy_from_slice(solution.as_slice());
    residual[bodies..].fill(0.0);
}

/// The largest difference of corrections by the sparse matrix and by differences, in parts of the largest correction.
fn difference(dynamics: &mut MechanismDynamics, y: &[f64], gamma: f64, random: &mut Random) -> f64 {
    let n = dynamics.coordinates();
    let mut slope = vec![0.0; y.len()];
    let residual: Vec<f64> = (0..n).map(|_| random.next()).collect();
    let (mut sparse, mut dense) = (residual.clone(), residual);
    dynamics.derivative(0.3, y, &mut slope);
    assert!(dynamics.factorise(y, gamma));
    dynamics.correct(&mut sparse);
    correct_by_differences(dynamics, y, gamma, &mut dense);
    let size = dense.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let apart = sparse.iter().zip(&dense).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f64::max) / size
}

#[test]
fn the_sparse_matrix_is_that_of_differences_for_every_joint_force_and_contact() {
    let whole = zoo();
    let mut random = Random(7);
    let mut parts: Vec<(String, Mechanism)> = vec![("all".into(), whole.clone())];
    for joint in &whole.joints {
        let mut one = whole.clone();
        (one.joints, one.forces, one.contacts) = (vec![joint.clone()], vec![], vec![]);
        parts.push((joint.name.clone(), one));
    }
    for force in &whole.forces {
        let mut one = whole.clone();
        (one.joints, one.forces, one.contacts) = (vec![], vec![force.clone()], vec![]);
        parts.push((force.name.clone(), one));
    }
    for contact in &whole.contacts {
        let mut one = whole.clone();
        (one.joints, one.forces, one.contacts) = (vec![], vec![], vec![contact.clone()]);
        parts.push((contact.name.clone(), one));
    }
    for (name, mechanism) in parts {
        let mut dynamics = dynamics(&mechanism);
        let n = dynamics.coordinates();
        for gamma in [0.3, 0.01] {
            for _ in 0..10 {
                let mut y: Vec<f64> = (0..2 * n).map(|_| random.next()).collect();
                y.extend([0.0, 0.0]);
                let apart = difference(&mut dynamics, &y, gamma, &mut random);
                // Differences over 1e-6 of accelerations of up to 1e3 have an error of 1e-7.
                assert!(apart < 2e-6, "{name}, {gamma}: {apart:e}");
            }
        }
    }
}

/// All that rubs, by name: contacts with each friction law, a film at all eccentricities, pins of revolute joints.
fn rubbing() -> Vec<(String, Mechanism)> {
    let whole = zoo();
    let mut laws = Regularization::ALL.map(|regularization| {
        FrictionLaw::Coulomb(Friction {
            coefficient: 0.4,
            regularization,
            speed: 3.0,
            dead_speed: if regularization == Regularization::Ambrosio {
                0.5
            } else {
                0.0
            },
        })
    });
    let lugre = FrictionLaw::LuGre(LuGre {
        static_coefficient: 0.5,
        kinetic_coefficient: 0.3,
        stiffness: 2.0,
        damping: 0.7,
        viscous_coefficient: 0.1,
        stribeck_speed: 1.5,
        stribeck_exponent: 1.7,
    });
    let mut parts = Vec::new();
    for law in laws.iter_mut().chain([&mut lugre.clone()]) {
        for contact in &whole.contacts {
            let mut one = whole.clone();
            (one.joints, one.forces, one.contacts) = (vec![], vec![], vec![contact.clone()]);
            one.contacts[0].tribology.friction = Some(*law);
            if contact.name == "corner" {
                // The corner itself is out of reach: how its share in each side bends is left out of the matrix.
                one.contacts[0].radius = 2.7;
            }
            parts.push((format!("{law:?} in {}", contact.name), one));
        }
    }
    for tension in [0.0, 30.0] {
        let mut one = whole.clone();
        (one.joints, one.forces) = (vec![], vec![]);
        one.contacts.truncate(1);
        let bore = &mut one.contacts[0];
        (bore.profile, bore.radius) = (Profile::Bore { radius: 4.5 }, 0.5);
        bore.tribology.film = Some(Film {
            viscosity: 200.0,
            length: Some(1.0),
            handover: 0.3,
            tension,
        });
        parts.push((format!("film with a tension of {tension}"), one));
    }
    let mut pins = whole.clone();
    (pins.forces, pins.contacts) = (vec![], vec![]);
    pins.joints
        .retain(|joint| joint.kind == JointKind::Revolute);
    for joint in &mut pins.joints {
        let FrictionLaw::Coulomb(law) = laws[0] else {
            continue;
        };
        joint.friction = Some(PinFriction { radius: 0.2, law });
    }
    assert!(!pins.joints.is_empty());
    parts.push(("pins".into(), pins));
    parts
}

#[test]
fn the_sparse_matrix_has_friction_films_and_pins_as_differences_do() {
    let mut random = Random(11);
    for (name, mechanism) in rubbing() {
        let mut dynamics = dynamics(&mechanism);
        let n = dynamics.coordinates();
        let bristles = dynamics.local_unknowns().len();
        assert_eq!(bristles > 0, name.starts_with("LuGre"), "{name}");
        for gamma in [0.3, 0.01] {
            for _ in 0..10 {
                let mut y: Vec<f64> = (0..2 * n).map(|_| random.next()).collect();
                if name.ends_with("corner") {
                    y[..n].iter_mut().for_each(|q| *q *= 0.25);
                }
                y.extend([0.0, 0.0]);
                let predicted: Vec<f64> = (0..bristles).map(|_| 0.1 * random.next()).collect();
                dynamics.begin_implicit_stage((bristles > 0).then_some((&predicted, gamma)));
                let apart = difference(&mut dynamics, &y, gamma, &mut random);
                assert!(apart < 2e-6, "{name}, {gamma}: {apart:e}");
            }
        }
    }
}

#[test]
fn redundant_joints_leave_the_matrix_regular() {
    let mut mechanism = bar_chain(3, 0.4);
    let mut again = mechanism.joints[1].clone();
    again.name = "again".into();
    mechanism.joints.push(again);
    let mut dynamics = dynamics(&mechanism);
    let mut y: Vec<f64> = mechanism
        .bodies
        .iter()
        .flat_map(|body| body.position)
        .collect();
    y.extend([0.0; 11]);
    let apart = difference(&mut dynamics, &y, 0.01, &mut Random(3));
    assert!(apart < 1e-5, "{apart:e}");
}

#[test]
fn a_chain_of_a_thousand_bars_is_followed_in_as_many_steps_as_a_short_one() {
    let steps = |count: usize| {
        let model = Arc::new(MechanismModel::compile(&bar_chain(count, 0.1)).unwrap());
        let control = StepControl {
            corrector: Corrector::Newton,
            accuracy: 1e-7,
            max_step: 0.01,
            ..StepControl::default()
        };
        let mut machine = MechanismSimulation::assemble(model, control).unwrap();
        while !machine.advance(0.02, std::time::Duration::MAX).unwrap() {}
        assert!(machine.drift()[0] < 1e-11 * count as f64);
        machine.counts().steps
    };
    let [few, many] = [30, 1000].map(steps);
    assert!(many < 3 * few, "{few} {many}");
}

#[test]
fn fast_bars_are_held_in_long_steps_where_factors_of_a_state_beside_give_few_digits() {
    let mut pendulum = bar_chain(2, 0.0);
    for (body, speed) in pendulum.bodies.iter_mut().zip([25.0, 75.0]) {
        body.inertia = 0.01;
        body.velocity = [0.0, speed, 50.0];
    }
    let model = Arc::new(MechanismModel::compile(&pendulum).unwrap());
    let control = StepControl {
        corrector: Corrector::Newton,
        accuracy: 5e-4,
        max_step: 5e-3,
        ..StepControl::default()
    };
    let mut machine = MechanismSimulation::assemble(model, control).unwrap();
    while !machine.advance(2.0, std::time::Duration::MAX).unwrap() {}
    let [places, speeds] = machine.drift();
    assert!(places < 1e-11 && speeds < 1e-7, "{places:e} {speeds:e}");
}

/// The paper's drive with its tensioner as bodies, clearance joints and sprockets, in motion as given.
fn as_mechanism(
    drive: &Drive,
    law: ForceLaw,
    positions: &[[f64; 3]],
    velocities: &[[f64; 3]],
) -> Mechanism {
    let (chain, links) = (&drive.chain, drive.chain.links as usize);
    let surfaces = |length| ContactLaw::Surfaces {
        law,
        contact_modulus: chain.material.contact_modulus(),
        restitution: chain.material.restitution,
        length,
        min_impact_velocity: ForceLaws::default().min_impact_velocity,
    };
    let mut mechanism = Mechanism {
        gravity: drive.gravity,
        ..Mechanism::default()
    };
    for (i, (q, v)) in positions.iter().zip(velocities).enumerate() {
        let (name, mass, inertia) = if i < links {
            let kind = if i % 2 == 0 {
                &chain.inner
            } else {
                &chain.outer
            };
            (format!("link {i}"), kind.mass, kind.inertia)
        } else {
            let wheel = &drive.sprockets[i - links];
            (
                format!("wheel {}", i - links),
                wheel.mass.unwrap(),
                wheel.inertia.unwrap(),
            )
        };
        let body = Body::new(name, mass, inertia);
        mechanism
            .bodies
            .push(body.at(q[0], q[1], q[2]).moving(v[0], v[1], v[2]));
    }
    let half = 0.5 * chain.pitch;
    for k in 0..links {
        let ends = [(k, half), ((k + 1) % links, -half)]
            .map(|(i, x)| marker(&format!("link {i}"), x, 0.0));
        let [first, second] = ends;
        let (inner, outer) = if k % 2 == 0 {
            (first, second)
        } else {
            (second, first)
        };
        for (s, wheel) in drive.sprockets.iter().enumerate() {
            mechanism.contacts.push(ContactPair {
                name: format!("bushing {k} on wheel {s}"),
                a: marker(&format!("wheel {s}"), 0.0, 0.0),
                b: inner.clone(),
                profile: Profile::Teeth(Box::new(wheel.tooth_profile(chain).unwrap())),
                radius: chain.bushing_radius,
                law: surfaces(chain.tooth_contact_length),
                tribology: Tribology::default(),
            });
        }
        mechanism.contacts.push(ContactPair {
            name: format!("hinge {k}"),
            a: inner,
            b: outer,
            profile: Profile::Bore {
                radius: chain.hinge.bore_radius,
            },
            radius: chain.hinge.pin_radius,
            law: surfaces(chain.hinge.length),
            tribology: Tribology::default(),
        });
    }
    let center = positions[links];
    let axle = ground(center[0], center[1]);
    let motor = JointKind::DrivenAngle(PrescribedMotion::Speed(velocities[links][2].into()));
    let slide = JointKind::PointOnLine {
        direction: Vec2::new(1.0, 0.0),
    };
    mechanism.joints = vec![
        Joint::new(
            "axle",
            axle.clone(),
            marker("wheel 0", 0.0, 0.0),
            JointKind::Revolute,
        ),
        Joint::new("motor", axle, marker("wheel 0", 0.0, 0.0), motor),
        Joint::new(
            "slide",
            ground(0.0, positions[links + 1][1]),
            marker("wheel 1", 0.0, 0.0),
            slide,
        ),
    ];
    let damper = ForceKind::Spring {
        law: SpringLaw::linear(0.0, drive.tensioner.as_ref().unwrap().damping),
        rest: None,
    };
    let behind = ground(-10.0, positions[links + 1][1]);
    mechanism.forces.push(ForceElement::new(
        "damper",
        behind,
        marker("wheel 1", 0.0, 0.0),
        damper,
    ));
    mechanism
}

#[test]
fn the_matrix_of_a_drive_laid_out_as_a_mechanism_is_the_chains_own() {
    for (elastic, pretension) in [
        (Elastic::Hertz, 25.0),
        (Elastic::Hertz, 100.0),
        (Elastic::Johnson, 100.0),
    ] {
        // Without damping, no onset has to be remembered the same.
        let laws = laws(elastic, Damping::None, Regions::Kept);
        let mut drive = common::paper_drive();
        drive.tensioner = Some(common::tensioner(pretension, 2e-3));
        let mut run = common::simulation(&drive, &laws, common::control(1e-8));
        common::advance(&mut run, 7e-3);
        // To where the integrator is already, so that positions are those of its state.
        let end = run.integrator().time();
        common::advance(&mut run, end);
        let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
        let mut chain = run.dynamics().clone();
        let mut slope = vec![0.0; y.len()];
        let coordinates = chain.coordinates();
        let motion = run.motion();
        let (positions, velocities) = (motion.positions(), motion.velocities());
        let mechanism = as_mechanism(&drive, laws.hinge, &positions, &velocities);
        let mut dynamics = dynamics(&mechanism);
        let n = dynamics.coordinates();
        let mut state: Vec<f64> = positions.concat();
        state.extend(velocities.concat());
        state.extend([0.0, 0.0]);
        let mut rates = vec![0.0; state.len()];
        let (links, mut random) = (drive.chain.links as usize, Random(5));
        // So long that the chain's border is eliminated, not only swept.
        for gamma in [1e-3, 1e-4] {
            let mut own: Vec<f64> = (0..coordinates).map(|_| random.next()).collect();
            let mut general = vec![0.0; n];
            for i in 0..links {
                for k in 0..3 {
                    general[3 * i + k] = own[k * links + i];
                }
            }
            // Of the second sprocket, the chain has its way along the slide and its angle.
            (general[n - 3], general[n - 1]) = (own[3 * links], own[3 * links + 1]);
            dynamics.derivative(t, &state, &mut rates);
            let pressed = dynamics
                .contact_forces()
                .iter()
                .filter(|f| f[0] != 0.0)
                .count();
            assert!(pressed > 1, "{pressed}");
            assert!(dynamics.factorise(&state, gamma));
            dynamics.correct(&mut general);
            chain.accelerations_with_slopes(t, &y, &mut slope);
            assert!(chain.factorise(&y, gamma));
            chain.correct(&mut own);
            let size = own.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            for i in 0..links {
                for k in 0..3 {
                    let (a, b) = (general[3 * i + k], own[k * links + i]);
                    assert!(
                        (a - b).abs() < 1e-6 * size,
                        "{elastic:?} {gamma:e} {i} {k}: {a} {b}"
                    );
                }
            }
        }
    }
}
