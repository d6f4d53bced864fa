//! Every joint, driver and force element against a closed form, and mechanisms that cannot be.

use std::time::Duration;

use crate::common::mechanisms::{
    GRAVITY, Rows, bar, bar_chain, control, four_bars, ground, record, revolute, run_to,
    simulation, slider_crank,
};
use rustchain::geometry::Vec2;
use rustchain::math::{Signal, Spline, Table};
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, ForceElement, ForceKind, Joint, JointKind, Marker, Mechanism,
    MechanismModel, PrescribedMotion, Profile, SpringLaw, Tribology,
};
use rustchain::run::MechanismSimulation;
use std::sync::Arc;

fn without_gravity(bodies: Vec<Body>, joints: Vec<Joint>, forces: Vec<ForceElement>) -> Mechanism {
    Mechanism {
        gravity: Vec2::zeros(),
        bodies,
        joints,
        forces,
        ..Mechanism::default()
    }
}

fn refusal(mechanism: &Mechanism) -> String {
    let made = MechanismModel::compile(mechanism)
        .and_then(|model| MechanismSimulation::assemble(Arc::new(model), control(1e-8, 0.01)));
    made.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn a_body_on_a_spring_and_damper_follows_its_closed_form() {
    let (m, k, c, x0) = (2.0, 300.0, 4.0, 0.1);
    let along = JointKind::Prismatic {
        direction: Vec2::new(1.0, 0.0),
        angle: None,
    };
    let spring = ForceKind::Spring {
        law: SpringLaw::linear(k, c),
        rest: Some(0.5),
    };
    let mut machine = simulation(
        &without_gravity(
            vec![Body::new("block", m, 0.1).at(0.5 + x0, 0.0, 0.0)],
            vec![Joint::new(
                "guide",
                ground(0.0, 0.0),
                Marker::new("block", 0.0, 0.0),
                along,
            )],
            vec![ForceElement::new(
                "spring",
                ground(0.0, 0.0),
                Marker::new("block", 0.0, 0.0),
                spring,
            )],
        ),
        1e-11,
    );
    let recording = record(&mut machine, 2.0, 0.05);
    let (decay, frequency) = (c / (2.0 * m), (k / m - (c / (2.0 * m)).powi(2)).sqrt());
    for (row, t) in recording.time.iter().enumerate() {
        let x = x0
            * (-decay * t).exp()
            * ((frequency * t).cos() + decay / frequency * (frequency * t).sin());
        assert!((recording.positions()[3 * row] - 0.5 - x).abs() < 1e-9);
        let residual = recording.energy()[6 * row + 5];
        assert!(residual.abs() < 1e-8, "{residual:e}");
    }
}

#[test]
fn gears_share_their_inertia_by_the_square_of_the_ratio() {
    let turn = |name: &str| {
        revolute(
            &format!("bearing {name}"),
            ground(0.0, 0.0),
            Marker::new(name, 0.0, 0.0),
        )
    };
    let ratio = -0.4;
    let gear = JointKind::Gear {
        ratio,
        carrier: None,
    };
    let torque = ForceKind::Torque(Signal::Constant(3.0));
    let (ia, ib) = (0.02, 0.5);
    let mut machine = simulation(
        &without_gravity(
            vec![Body::new("a", 1.0, ia), Body::new("b", 1.0, ib)],
            vec![
                turn("a"),
                turn("b"),
                Joint::new(
                    "mesh",
                    Marker::new("a", 0.0, 0.0),
                    Marker::new("b", 0.0, 0.0),
                    gear,
                ),
            ],
            vec![ForceElement::new(
                "torque",
                ground(0.0, 0.0),
                Marker::new("a", 0.0, 0.0),
                torque,
            )],
        ),
        1e-10,
    );
    run_to(&mut machine, 1.0);
    let angle = 0.5 * 3.0 / (ia + ratio * ratio * ib);
    let found = machine.positions();
    assert!((found[0][2] - angle).abs() < 1e-8 * angle);
    assert!((found[1][2] - ratio * angle).abs() < 1e-8 * angle);
}

#[test]
fn a_planet_turns_on_its_carrier() {
    // Sun held, planet outside it: the planet turns by (1 + r_sun/r_planet) times the carrier's angle.
    let gear = JointKind::Gear {
        ratio: -2.0,
        carrier: Some("arm".into()),
    };
    let motor = JointKind::DrivenAngle(PrescribedMotion::Speed(Signal::Constant(1.5)));
    let mut machine = simulation(
        &without_gravity(
            vec![
                Body::new("arm", 1.0, 0.1),
                Body::new("planet", 0.2, 0.01).at(0.3, 0.0, 0.0),
            ],
            vec![
                revolute("axle", ground(0.0, 0.0), Marker::new("arm", 0.0, 0.0)),
                revolute(
                    "pin",
                    Marker::new("arm", 0.3, 0.0),
                    Marker::new("planet", 0.0, 0.0),
                ),
                Joint::new(
                    "mesh",
                    ground(0.0, 0.0),
                    Marker::new("planet", 0.0, 0.0),
                    gear,
                ),
                Joint::new(
                    "motor",
                    ground(0.0, 0.0),
                    Marker::new("arm", 0.0, 0.0),
                    motor,
                ),
            ],
            vec![],
        ),
        1e-10,
    );
    run_to(&mut machine, 2.0);
    assert!((machine.positions()[1][2] - 9.0).abs() < 1e-12);
}

#[test]
fn a_wheel_rolls_down_with_two_thirds_of_the_free_acceleration() {
    let (radius, slope) = (0.2, 0.3f64);
    let down = Vec2::new(slope.cos(), -slope.sin());
    let start = Vec2::new(slope.sin(), slope.cos()) * radius;
    let joints = vec![
        Joint::new(
            "rolls",
            ground(0.0, 0.0),
            Marker::new("wheel", 0.0, 0.0),
            JointKind::Rack {
                direction: down,
                radius: -radius,
            },
        ),
        Joint::new(
            "stays on",
            ground(start.x, start.y),
            Marker::new("wheel", 0.0, 0.0),
            JointKind::PointOnLine { direction: down },
        ),
    ];
    let mut machine = simulation(
        &Mechanism {
            gravity: Vec2::new(0.0, -GRAVITY),
            bodies: vec![
                Body::new("wheel", 3.0, 0.5 * 3.0 * radius * radius).at(start.x, start.y, 0.0),
            ],
            joints,
            ..Mechanism::default()
        },
        1e-10,
    );
    run_to(&mut machine, 1.0);
    let way = 0.5 * GRAVITY * slope.sin() * 2.0 / 3.0;
    let [x, y, angle] = machine.positions()[0];
    assert!((Vec2::new(x, y) - start - way * down).norm() < 1e-9);
    assert!((angle + way / radius).abs() < 1e-8);
}

#[test]
fn a_rod_of_next_to_no_mass_is_a_distance() {
    // Of the bob's mass: what it adds to the motion is of the same size.
    const LIGHT: f64 = 1e-9;
    let swing = |joints: Vec<Joint>, mut bodies: Vec<Body>| {
        bodies.push(Body::new("bob", 1.0, LIGHT).at(0.8, 0.0, 0.0));
        let mechanism = Mechanism {
            gravity: Vec2::new(0.0, -GRAVITY),
            bodies,
            joints,
            ..Mechanism::default()
        };
        let mut machine = simulation(&mechanism, 1e-10);
        run_to(&mut machine, 1.3);
        machine.positions().last().copied().unwrap()
    };
    let bob = || Marker::new("bob", 0.0, 0.0);
    let rod = Body::new("rod", LIGHT, LIGHT).at(0.4, 0.0, 0.0);
    let with_rod = swing(
        vec![
            revolute("top", ground(0.0, 0.0), Marker::new("rod", -0.4, 0.0)),
            Joint::new(
                "end",
                Marker::new("rod", 0.4, 0.0),
                bob(),
                JointKind::Fixed { angle: None },
            ),
        ],
        vec![rod],
    );
    let mut distance = vec![Joint::new(
        "string",
        ground(0.0, 0.0),
        bob(),
        JointKind::Distance { length: None },
    )];
    // The bob has next to no inertia, so its angle is held.
    distance.push(Joint::new(
        "no turning",
        ground(0.0, 0.0),
        bob(),
        JointKind::DrivenAngle(PrescribedMotion::Position(Signal::Constant(0.0))),
    ));
    let with_distance = swing(distance, vec![]);
    assert!((with_rod[0] - with_distance[0]).abs() < 1e-8);
    assert!((with_rod[1] - with_distance[1]).abs() < 1e-8);
    assert!((with_rod[0].hypot(with_rod[1]) - 0.8).abs() < 1e-14);
}

#[test]
fn a_driven_position_follows_its_spline_and_its_force_moves_the_mass() {
    let spline = Spline::new("way", "m", &[(0.0, 0.0), (0.4, 0.1), (1.0, -0.2)]).unwrap();
    let drive = JointKind::DrivenPosition {
        direction: Vec2::new(0.0, 1.0),
        motion: PrescribedMotion::Position(Signal::Spline(spline.clone())),
    };
    let along = JointKind::Prismatic {
        direction: Vec2::new(0.0, 1.0),
        angle: None,
    };
    let block = || Marker::new("block", 0.0, 0.0);
    let mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        bodies: vec![Body::new("block", 2.5, 0.1)],
        joints: vec![
            Joint::new("guide", ground(0.0, 0.0), block(), along),
            Joint::new("cylinder", ground(0.0, 0.0), block(), drive),
        ],
        ..Mechanism::default()
    };
    let mut machine = simulation(&mechanism, 1e-9);
    let recording = record(&mut machine, 1.0, 0.05);
    for (row, &t) in recording.time.iter().enumerate() {
        let [way, _, acceleration] = spline.derivatives(t);
        assert!((recording.positions()[3 * row + 1] - way).abs() < 1e-14);
        let force = recording.reactions()[3 * (2 * row + 1) + 1];
        assert!((force - 2.5 * (acceleration + GRAVITY)).abs() < 1e-10);
    }
}

#[test]
fn a_motor_by_its_speed_comes_to_the_speed_where_it_has_no_torque() {
    let table = Table::against(
        "torque",
        ("speed", "rad/s"),
        "N m",
        &[(0.0, 2.0), (100.0, 0.0)],
    )
    .unwrap();
    let mechanism = without_gravity(
        vec![Body::new("rotor", 1.0, 0.01)],
        vec![revolute(
            "bearing",
            ground(0.0, 0.0),
            Marker::new("rotor", 0.0, 0.0),
        )],
        vec![ForceElement::new(
            "motor",
            ground(0.0, 0.0),
            Marker::new("rotor", 0.0, 0.0),
            ForceKind::TorqueBySpeed(table),
        )],
    );
    let mut machine = simulation(&mechanism, 1e-10);
    run_to(&mut machine, 0.7);
    let expected = 100.0 * (1.0 - (-0.7f64 * 2.0).exp());
    assert!((machine.velocities()[0][2] - expected).abs() < 1e-6);
}

#[test]
fn a_fixed_joint_carries_the_torque_of_a_cantilever() {
    let mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        bodies: vec![bar("beam", Vec2::zeros(), Vec2::new(2.0, 0.0), 3.0)],
        joints: vec![Joint::new(
            "wall",
            ground(0.0, 0.0),
            Marker::new("beam", -1.0, 0.0),
            JointKind::Fixed { angle: None },
        )],
        ..Mechanism::default()
    };
    let row = simulation(&mechanism, 1e-9).row();
    let [x, y, torque] = [row.reactions()[0], row.reactions()[1], row.reactions()[2]];
    assert!(x.abs() < 1e-12 && (y - 3.0 * GRAVITY).abs() < 1e-12);
    assert!((torque - 3.0 * GRAVITY).abs() < 1e-12);
}

#[test]
fn redundant_joints_are_named_and_share_their_load_evenly() {
    // Two equal guides hold the same slider: each takes half.
    let along = || JointKind::Prismatic {
        direction: Vec2::new(1.0, 0.0),
        angle: None,
    };
    let mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        bodies: vec![Body::new("block", 2.0, 0.1)],
        joints: ["first", "second"]
            .map(|name| {
                Joint::new(
                    name,
                    ground(0.0, 0.0),
                    Marker::new("block", 0.0, 0.0),
                    along(),
                )
            })
            .to_vec(),
        ..Mechanism::default()
    };
    let mut machine = simulation(&mechanism, 1e-9);
    assert_eq!(machine.assembly().redundant, ["second", "second"]);
    assert_eq!(machine.assembly().degrees_of_freedom, 1);
    let row = machine.row();
    for joint in 0..2 {
        assert!((row.reactions()[3 * joint + 1] - GRAVITY).abs() < 1e-12);
    }
}

#[test]
fn five_parallel_posts_move_as_two() {
    // A platform on five parallel posts: three of them hold nothing new.
    let on_posts = |count: usize| {
        let mut mechanism = Mechanism {
            gravity: Vec2::new(0.0, -GRAVITY),
            ..Mechanism::default()
        };
        let lean = Vec2::new(0.3f64.sin(), 0.3f64.cos());
        let center = Vec2::new(2.0, 0.0) + lean;
        mechanism
            .bodies
            .push(Body::new("platform", 5.0, 1.0).at(center.x, center.y, 0.0));
        for k in 0..count {
            let x = 4.0 * k as f64 / (count - 1) as f64;
            let name = format!("post {k}");
            let foot = Vec2::new(x, 0.0);
            let mass = 2.0 / count as f64;
            mechanism.bodies.push(bar(&name, foot, foot + lean, mass));
            mechanism.joints.push(revolute(
                &format!("foot {k}"),
                ground(x, 0.0),
                Marker::new(name.clone(), -0.5, 0.0),
            ));
            mechanism.joints.push(revolute(
                &format!("head {k}"),
                Marker::new(name, 0.5, 0.0),
                Marker::new("platform", x - 2.0, 0.0),
            ));
        }
        let mut machine = simulation(&mechanism, 1e-9);
        assert_eq!(machine.assembly().degrees_of_freedom, 1);
        assert_eq!(machine.assembly().redundant.len(), count - 2);
        run_to(&mut machine, 0.5);
        machine.positions()[0]
    };
    let (two, five) = (on_posts(2), on_posts(5));
    for k in 0..3 {
        assert!((two[k] - five[k]).abs() < 1e-8, "{two:?} {five:?}");
    }
}

#[test]
fn positions_are_corrected_to_the_nearest_that_hold() {
    let mut mechanism = bar_chain(3, 0.2);
    for (k, body) in mechanism.bodies.iter_mut().enumerate() {
        body.position[0] += 0.01 * (k as f64 + 1.0);
        body.position[2] -= 0.02;
    }
    let mut machine = simulation(&mechanism, 1e-9);
    assert!(machine.drift()[0] < 1e-14);
    let assembly = machine.assembly();
    assert!(
        assembly.moved > 1e-3 && assembly.moved < 0.05,
        "{assembly:?}"
    );
}

#[test]
fn what_cannot_go_together_is_refused_with_the_joints_at_fault() {
    // A triangle of bars 1, 1 and 3 m.
    let mut mechanism = bar_chain(2, 0.5);
    let end = Marker::new("bar 1", 0.5, 0.0);
    mechanism
        .joints
        .push(revolute("far", ground(3.0, 0.0), end));
    let text = refusal(&mechanism);
    assert!(
        text.contains("cannot be assembled") && text.contains("\"far\""),
        "{text}"
    );
}

#[test]
fn drivers_that_contradict_each_other_are_refused() {
    let mut mechanism = slider_crank(10.0);
    let motor = JointKind::DrivenAngle(PrescribedMotion::Speed(Signal::Constant(11.0)));
    mechanism.joints.push(Joint::new(
        "second motor",
        ground(0.0, 0.0),
        Marker::new("crank", 0.0, 0.0),
        motor,
    ));
    let text = refusal(&mechanism);
    assert!(
        text.contains("velocities") && text.contains("motor"),
        "{text}"
    );
}

#[test]
fn bad_parts_are_refused_by_name() {
    let mut missing = bar_chain(2, 0.5);
    missing.joints[1].b.body = "bra 1".into();
    let text = refusal(&missing);
    assert!(
        text.contains("\"bra 1\"") && text.contains("\"bar 1\"") && text.contains("\"hinge 1\""),
        "{text}"
    );

    let mut massless = bar_chain(2, 0.5);
    massless.bodies[0].mass = 2.5;
    massless.bodies[1].mass = 0.0;
    let text = refusal(&massless);
    assert!(
        text.contains("mass of body \"bar 1\" = 0") && text.contains("2.5e-6 kg"),
        "{text}"
    );
    massless.bodies[1].mass = 1.0;
    massless.bodies[1].inertia = 0.0;
    assert!(refusal(&massless).contains("inertia of body \"bar 1\" = 0"));
    massless.bodies[1].fixed = true;
    massless.joints.clear();
    assert!(MechanismModel::compile(&massless).is_ok());

    let mut negative = bar_chain(1, 0.5);
    negative.bodies[0].mass = -1.0;
    assert!(refusal(&negative).contains("mass of body \"bar 0\" = -1"));

    let mut twice = bar_chain(2, 0.5);
    twice.bodies[1].name = "bar 0".into();
    assert!(refusal(&twice).contains("is taken already"));

    let mut itself = bar_chain(1, 0.5);
    itself.joints[0].a.body = "bar 0".into();
    assert!(refusal(&itself).contains("two different bodies"));
}

#[test]
fn parts_that_hang_on_nothing_and_bodies_moved_far_are_warned_of() {
    let mut loose = bar_chain(3, 0.5);
    loose.joints.remove(1);
    let warnings = simulation(&loose, 1e-9).assembly().warnings.clone();
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("\"bar 1\", \"bar 2\""), "{warnings:?}");

    let mut millimetres = four_bars(1);
    millimetres.bodies[0].position[0] = 300.0;
    let warnings = simulation(&millimetres, 1e-9).assembly().warnings.clone();
    assert!(
        warnings.iter().any(|w| w.contains("same unit")),
        "{warnings:?}"
    );
}

#[test]
fn a_jammed_mechanism_stops_with_the_time_and_the_joints() {
    // Bars of 1 m on feet 2 m apart: the crank comes no farther than cos θ = 1/4.
    let crank = Vec2::new(0.75f64.sqrt(), 0.5);
    let foot = Vec2::new(2.0, 0.0);
    let (middle, span) = (0.5 * (crank + foot), foot - crank);
    let rise = (1.0 - 0.25 * span.norm_squared()).sqrt();
    let knee = middle + rise * Vec2::new(-span.y, span.x) / span.norm();
    let motor = JointKind::DrivenAngle(PrescribedMotion::Speed(Signal::Constant(1.0)));
    let end = |name: &str, side: f64| Marker::new(name, 0.5 * side, 0.0);
    let mechanism = without_gravity(
        vec![
            bar("crank", Vec2::zeros(), crank, 1.0),
            bar("coupler", crank, knee, 1.0),
            bar("rocker", knee, foot, 1.0),
        ],
        vec![
            revolute("first foot", ground(0.0, 0.0), end("crank", -1.0)),
            revolute("crank pin", end("crank", 1.0), end("coupler", -1.0)),
            revolute("knee", end("coupler", 1.0), end("rocker", -1.0)),
            revolute("second foot", ground(2.0, 0.0), end("rocker", 1.0)),
            Joint::new(
                "motor",
                ground(0.0, 0.0),
                Marker::new("crank", 0.0, 0.0),
                motor,
            ),
        ],
        vec![],
    );
    let mut machine = simulation(&mechanism, 1e-8);
    let failure = loop {
        match machine.advance(5.0, Duration::from_secs(5)) {
            Ok(true) => panic!("went round"),
            Ok(false) => {}
            Err(error) => break error.to_string(),
        }
    };
    assert!(failure.contains("t = "), "{failure}");
    // The joints that miss, or the one with the largest load.
    let named = ["first foot", "crank pin", "knee", "second foot", "motor"]
        .iter()
        .any(|joint| failure.contains(&format!("{joint:?}")));
    assert!(named, "{failure}");
}

#[test]
fn a_ball_bounces_on_every_profile_as_high_as_it_fell() {
    let floor = |points: &[(f64, f64)], closed| {
        let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        Profile::polyline("floor", &points, closed).unwrap()
    };
    let profiles = [
        ("segment", floor(&[(1.0, 0.0), (-1.0, 0.0)], false)),
        (
            "square",
            floor(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 0.0), (-1.0, 0.0)], true),
        ),
        ("disc", Profile::Disc { radius: 0.5 }),
        ("bore", Profile::Bore { radius: 0.5 }),
    ];
    for (name, profile) in profiles {
        let surface = match name {
            "disc" => 0.5,
            "bore" => -0.5,
            _ => 0.0,
        };
        let radius = 0.1;
        let start = surface + radius + 0.2;
        let mechanism = Mechanism {
            gravity: Vec2::new(0.0, -GRAVITY),
            bodies: vec![Body::new("ball", 0.5, 0.01).at(0.0, start, 0.0)],
            contacts: vec![ContactPair {
                name: name.into(),
                a: ground(0.0, 0.0),
                b: Marker::new("ball", 0.0, 0.0),
                profile,
                radius,
                law: ContactLaw::HuntCrossley {
                    stiffness: 1e7,
                    exponent: 1.5,
                    damping: 0.0,
                },
                tribology: Tribology::default(),
            }],
            ..Mechanism::default()
        };
        let mut machine = simulation(&mechanism, 1e-9);
        let recording = record(&mut machine, 0.9, 1e-3);
        let heights = recording.positions().chunks(3).map(|p| p[1]);
        let after = heights.skip(300).fold(f64::NEG_INFINITY, f64::max);
        assert!((after - start).abs() < 1e-5, "{name} {after} {start}");
        assert!(machine.statistics().onsets >= 2);
        let worst = recording
            .energy()
            .chunks(6)
            .map(|row| row[5].abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-5, "{name} {worst}");
    }
}

#[test]
fn a_wheel_beside_its_bearing_is_brought_to_it() {
    for beside in [1e-12, 1e-3, 0.5] {
        let bearing = Joint::new(
            "bearing",
            ground(0.0, 0.0),
            Marker::new("wheel", 0.0, 0.0),
            JointKind::Revolute,
        );
        let wheel = Body::new("wheel", 1.0, 0.1).at(beside, 0.0, 0.0);
        let machine = without_gravity(vec![wheel], vec![bearing], vec![]);
        assert_eq!(refusal(&machine), "", "{beside}");
    }
}
