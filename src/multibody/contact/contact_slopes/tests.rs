//! Tests of contact forces, friction and films: slopes against differences, powers against stored energies.

use super::super::tests::{BALL, BLOCK, Course, contact, evaluated, frames, model, outline, power};
use super::*;
use crate::force_law::{
    Damping, Elastic, Film, ForceLaw, Friction, LuGre, Regions, Regularization,
};
use crate::geometry::Vec2;
use crate::multibody::description::contact_law::ContactLaw;
use crate::multibody::description::contact_pair::ContactPair;
use crate::multibody::description::outline_piece::Piece;
use crate::multibody::description::profile::Profile;
use crate::multibody::description::tribology::FrictionLaw;

/// A contact at one state.
struct Case {
    name: &'static str,
    pair: ContactPair,
    /// Place of the circle relative to the profile \[m\].
    place: (f64, f64),
    memory: Memory,
    /// Slopes that are neglected, over the largest stiffness.
    neglected: f64,
}

fn damped() -> ContactLaw {
    ContactLaw::Linear {
        stiffness: 1e4,
        damping: 20.0,
    }
}

fn restoring() -> ContactLaw {
    ContactLaw::Surfaces {
        law: ForceLaw {
            elastic: Elastic::Hertz,
            damping: Damping::LankaraniNikravesh,
            regions: Regions::Kept,
        },
        contact_modulus: 1e7,
        restitution: 0.8,
        length: 0.02,
        min_impact_velocity: 1e-3,
    }
}

/// Return contacts of a circle of 0.1 m with all kinds of profiles, without friction.
fn cases() -> Vec<Case> {
    let arc = |convex: bool| Profile::Outline {
        pieces: vec![Piece {
            from: Vec2::new(if convex { 0.3 } else { -0.3 }, 0.0),
            to: Vec2::new(if convex { -0.3 } else { 0.3 }, 0.0),
            center: Some(Vec2::zeros()),
            convex,
        }],
        closed: false,
    };
    let case = |name, profile, law, place| Case {
        name,
        pair: ContactPair {
            law,
            ..contact(profile, 0.1)
        },
        place,
        memory: Memory {
            speed: 0.7,
            piece: 0,
            in_front: false,
        },
        neglected: 1e-6,
    };
    let corner = || outline(&[(1.0, 0.6), (0.0, 0.0), (-1.0, 1.0)], false);
    let line = || outline(&[(0.0, 0.0), (-1.0, 0.0)], false);
    vec![
        case("line", line(), damped(), (-0.5, 0.08)),
        case(
            "disc",
            Profile::Disc { radius: 0.2 },
            restoring(),
            (0.23, 0.15),
        ),
        case(
            "bore",
            Profile::Bore { radius: 0.13 },
            restoring(),
            (0.03, 0.02),
        ),
        case("convex arc", arc(true), damped(), (0.1, 0.36)),
        case("end", line(), damped(), (0.04, 0.08)),
        // The other side of the corner has no force.
        case("one of two sides", corner(), damped(), (0.5588, 0.4286)),
        Case {
            // The largest distance, that of the corner, is 1 mm below the radius. Neglected: E ∂²w/∂x².
            neglected: 2e-3,
            ..case("re-entrant corner", corner(), damped(), (0.012, 0.098))
        },
        Case {
            neglected: 2e-3,
            ..case("end from behind", line(), damped(), (0.09, -0.04))
        },
        Case {
            memory: Memory::default(),
            ..case(
                "without memory",
                Profile::Disc { radius: 0.2 },
                restoring(),
                (0.23, 0.15),
            )
        },
    ]
}

/// Return the frames of both bodies with the circle at a place relative to the profile. `spin` is that of the ball.
fn moving(place: Vec2, velocity: Vec2, spin: f64) -> Vec<Frame> {
    let block: Course = [[0.3, -0.2, 0.4], [0.2, -0.1, 0.6], [0.0; 3]];
    let here = frames(&block, &block, 0.0)[BLOCK];
    let (ball, v) = (
        here.place(place),
        here.velocity_at(here.place(place)) + velocity,
    );
    let ball = [[ball.x, ball.y, 0.1], [v.x, v.y, spin], [0.0; 3]];
    frames(&block, &ball, 0.0)
}

const SPIN: f64 = -1.7;

fn velocity() -> Vec2 {
    Vec2::new(0.3, -0.5)
}

/// Assert that force and torque on the circle change as their slopes say, by central differences.
fn assert_slopes(case: &Case, bent: Option<f64>, implicit: Option<f64>) {
    let model = model(vec![case.pair.clone()]);
    let mut states = ContactStates::new(&model);
    states.memory.fill(case.memory);
    let place = Vec2::new(case.place.0, case.place.1);
    let mut load = |place: Vec2, velocity: Vec2, spin: f64| {
        if let Some(bent) = bent {
            states.bristles.deflection.fill(bent);
            let predicted = vec![bent; model.bristles];
            states
                .bristles
                .begin_implicit_stage(implicit.map(|gamma| (&predicted[..], gamma)));
        }
        let found = evaluated(&model, &mut states, &moving(place, velocity, spin)).on[BALL];
        (Vec2::new(found[0], found[1]), found[2])
    };
    let h = (1e-6 * place.norm().min(0.1)).max(1e-8);
    // Displacements in the frame of the ground; places are in that of the block.
    let turn = moving(place, velocity(), SPIN)[BLOCK];
    let by = |moved: [(Vec2, f64); 2], step: f64| {
        let [(f, t), (g, u)] = moved;
        ((f - g) / (2.0 * step), (t - u) / (2.0 * step))
    };
    let axes = [Vec2::x(), Vec2::y()];
    let by_place = axes.map(|axis| {
        let step = h * turn.into_local(axis);
        by(
            [place + step, place - step].map(|at| load(at, velocity(), SPIN)),
            h,
        )
    });
    let fast = 1e-5;
    let by_velocity = axes.map(|axis| {
        let moved = [fast, -fast].map(|step| load(place, velocity() + step * axis, SPIN));
        by(moved, fast)
    });
    let by_spin = by(
        [fast, -fast].map(|step| load(place, velocity(), SPIN + step)),
        fast,
    );
    let (force, torque) = load(place, velocity(), SPIN);

    let here = moving(place, velocity(), SPIN);
    let (mut sum, mut turning) = (PairForce::default(), [Vec2::zeros(); 3]);
    let mut torque_by_spin = 0.0;
    states.visit_slopes(&model, &here, 0, |force, torque| {
        sum.add(force);
        if let Some(torque) = torque {
            turning[0] += torque.by_place;
            turning[1] += torque.by_velocity;
            turning[2] += torque.force_by_spin;
            torque_by_spin += torque.by_spin;
        }
    });
    assert!(states.has_force(&model, 0));
    let name = case.name;
    assert!((sum.force - force).norm() < 1e-9 * force.norm(), "{name}");
    assert!(force.norm() > 0.0 && torque.is_finite());
    let stiffest = sum.by_place.norm();
    let damping = sum.by_velocity.norm() + turning[2].norm();
    for k in 0..2 {
        let ((f, t), (g, u)) = (by_place[k], by_velocity[k]);
        let place: Vec2 = sum.by_place.column(k).into();
        let speed: Vec2 = sum.by_velocity.column(k).into();
        let least = case.neglected * stiffest;
        assert!((place - f).norm() < least, "{name}: {place} {f} {stiffest}");
        assert!(
            (turning[0][k] - t).abs() < 0.1 * least,
            "{name}: {} {t}",
            turning[0][k]
        );
        let least = 1e-6 * damping + 1e-9 * stiffest;
        assert!((speed - g).norm() < least, "{name}: {speed} {g}");
        assert!(
            (turning[1][k] - u).abs() < 0.1 * least,
            "{name}: {} {u}",
            turning[1][k]
        );
    }
    let least = 1e-6 * damping + 1e-9 * stiffest;
    assert!(
        (turning[2] - by_spin.0).norm() < least,
        "{name}: {} {}",
        turning[2],
        by_spin.0
    );
    assert!(
        (torque_by_spin - by_spin.1).abs() < 0.1 * least,
        "{name}: {torque_by_spin} {}",
        by_spin.1
    );
}

/// Assert that the power of all loads is what the stored energy loses, less what is dissipated.
fn assert_power(case: &Case, bent: f64) {
    let model = model(vec![case.pair.clone()]);
    let mut states = ContactStates::new(&model);
    states.memory.fill(case.memory);
    states.bristles.deflection.fill(bent);
    let place = Vec2::new(case.place.0, case.place.1);
    let here = moving(place, velocity(), SPIN);
    let course = |k: usize| {
        let frame: &Frame = &here[k];
        let position = [frame.origin.x, frame.origin.y, frame.angle];
        [
            position,
            [frame.velocity.x, frame.velocity.y, frame.spin],
            [0.0; 3],
        ]
    };
    let h = 1e-6;
    let mut stored = |t: f64| {
        let all = frames(&course(BLOCK), &course(BALL), t);
        evaluated(&model, &mut states, &all).elastic
    };
    let gain = (stored(h) - stored(-h)) / (2.0 * h);
    let loads = evaluated(&model, &mut states, &here);
    let balance = power(&loads, &here) + gain + loads.dissipated;
    assert!(
        balance.abs() < 1e-6 * (gain.abs() + loads.dissipated.abs()),
        "{}: {balance} {gain}",
        case.name
    );
    // Neither body gains momentum from nothing, nor moment about the origin.
    let [a, b] = [loads.on[BLOCK], loads.on[BALL]];
    let [p, q] = [here[BLOCK].origin, here[BALL].origin];
    let moment = |at: Vec2, load: [f64; 3]| at.x * load[1] - at.y * load[0] + load[2];
    let largest = b[0].abs() + b[1].abs();
    assert!((a[0] + b[0]).abs() + (a[1] + b[1]).abs() < 1e-12 * largest);
    assert!((moment(p, a) + moment(q, b)).abs() < 1e-12 * largest);
}

#[test]
fn slopes_of_normal_forces_are_their_derivatives() {
    for case in cases() {
        assert_slopes(&case, None, None);
    }
}

#[test]
fn normal_forces_take_from_the_motion_what_they_store_and_dissipate() {
    for case in cases() {
        assert_power(&case, 0.0);
    }
}

fn coulomb() -> FrictionLaw {
    FrictionLaw::Coulomb(Friction {
        coefficient: 0.3,
        regularization: Regularization::Tanh,
        speed: 0.5,
        dead_speed: 0.0,
    })
}

fn lugre() -> LuGre {
    LuGre {
        static_coefficient: 0.4,
        kinetic_coefficient: 0.3,
        stiffness: 1e3,
        damping: 0.8,
        viscous_coefficient: 0.1,
        stribeck_speed: 0.6,
        stribeck_exponent: 1.5,
    }
}

/// Return the contacts with friction.
fn with_friction(friction: FrictionLaw) -> Vec<Case> {
    let mut all = cases();
    for case in &mut all {
        case.pair.tribology.friction = Some(friction);
        // With a force at the neglected second derivatives, friction has them too.
        if case.neglected > 1e-6 {
            case.neglected *= 2.0;
        }
    }
    all
}

#[test]
fn slopes_of_friction_are_its_derivatives() {
    for case in with_friction(coulomb()) {
        assert_slopes(&case, None, None);
    }
    for case in with_friction(FrictionLaw::LuGre(lugre())) {
        assert_slopes(&case, Some(2e-4), Some(1e-3));
    }
}

#[test]
fn friction_dissipates_what_it_takes_from_the_motion() {
    for case in with_friction(coulomb()) {
        assert_power(&case, 0.0);
    }
    for case in with_friction(FrictionLaw::LuGre(lugre())) {
        assert_power(&case, 2e-4);
    }
}

#[test]
fn the_film_of_a_pin_dissipates_what_it_takes_and_its_slopes_are_its_derivatives() {
    // Clearance 30 mm, eccentricity below it: no dry contact. The film fades out from 0.8 of the clearance.
    // An eccentricity of 1e-6 m is within a hundred steps of the differences.
    for (place, neglected) in [
        ((0.005, 0.008), 1e-6),
        ((-0.02, 0.016), 1e-6),
        ((8e-7, -6e-7), 1e-3),
    ] {
        let mut pair = contact(Profile::Bore { radius: 0.13 }, 0.1);
        pair.tribology.film = Some(Film {
            viscosity: 0.5,
            length: Some(0.05),
            handover: 0.8,
            tension: 40.0,
        });
        let case = Case {
            name: "film",
            pair,
            place,
            memory: Memory::default(),
            neglected,
        };
        assert_slopes(&case, None, None);
        assert_power(&case, 0.0);
    }
}

#[test]
fn a_concentric_pin_has_the_film_of_a_tiny_eccentricity() {
    let mut pair = contact(Profile::Bore { radius: 0.13 }, 0.1);
    pair.tribology.film = Some(Film {
        viscosity: 0.5,
        length: Some(0.05),
        handover: 0.8,
        tension: 40.0,
    });
    let model = model(vec![pair]);
    let mut states = ContactStates::new(&model);
    let mut found = |x: f64| {
        // Neither turns: the film force is against the velocity, along x.
        let course = [[0.0; 3]; 3];
        let ball = [[x, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0; 3]];
        let here = frames(&course, &ball, 0.0);
        let loads = evaluated(&model, &mut states, &here).on[BALL];
        let push = states.pushes(&model).next().unwrap();
        assert_eq!([push.x, push.y], [loads[0], loads[1]]);
        let mut slopes = PairForce::default();
        states.visit_slopes(&model, &here, 0, |force, _| slopes.add(force));
        (Vec2::new(loads[0], loads[1]), slopes)
    };
    let ((force, slopes), (beside, slopes_beside)) = (found(0.0), found(1e-12));
    assert!(force.x < 0.0 && force.y == 0.0);
    assert!((force - beside).norm() < 1e-9 * force.norm());
    assert!(
        (slopes.by_velocity - slopes_beside.by_velocity).norm() < 1e-9 * slopes.by_velocity.norm()
    );
    // Turning the direction within 1e-7 of the clearance leaves the force: its slopes cancel to rounding of force over this length.
    let change = (slopes.by_place - slopes_beside.by_place).norm();
    assert!(change < 1e-9 * force.norm() / (1e-7 * 0.03));
}

#[test]
fn friction_is_against_the_sliding_and_its_bristles_have_the_energy_of_their_deflection() {
    // A pin that slides over a level line by 0.3 m/s and turns: the contact point slides by 0.3 + r ω.
    let case = |friction| {
        let mut pair = contact(outline(&[(1.0, 0.0), (-1.0, 0.0)], false), 0.1);
        pair.tribology.friction = Some(friction);
        model(vec![pair])
    };
    let course = [[0.0; 3]; 3];
    let ball = [[0.0, 0.08, 0.0], [0.3, 0.0, 2.0], [0.0; 3]];
    let here = frames(&course, &ball, 0.0);
    let (normal, slip) = (1e3 * 0.02, 0.5);
    let model = case(coulomb());
    let loads = evaluated(&model, &mut ContactStates::new(&model), &here);
    let friction = normal * 0.3 * (slip / 0.5f64).tanh();
    for (found, expected) in loads.on[BALL]
        .iter()
        .zip([-friction, normal, -0.1 * friction])
    {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    let model = case(FrictionLaw::LuGre(lugre()));
    let mut states = ContactStates::new(&model);
    states.bristles.deflection[0] = -3e-4;
    let loads = evaluated(&model, &mut states, &here);
    // The tangent is to the left of the normal: against x.
    let bent = lugre().bent(-3e-4, -slip);
    assert!((loads.on[BALL][0] - normal * bent.share).abs() < 1e-12);
    assert!((states.bristles.rate[0] - bent.rate).abs() < 1e-12);
    assert!((loads.bristles - normal * 0.5 * 1e3 * 9e-8).abs() < 1e-12);
    assert_eq!(states.side_states[0].friction.x, loads.on[BALL][0]);
    let pushed: Vec<Vec2> = states.pushes(&model).collect();
    assert!((pushed[0] - Vec2::new(loads.on[BALL][0], normal)).norm() < 1e-12);
    // Apart there is neither.
    let away = frames(&course, &[[0.0, 0.2, 0.0], [0.3, 0.0, 2.0], [0.0; 3]], 0.0);
    let loads = evaluated(&model, &mut states, &away);
    assert_eq!(
        (loads.on[BALL], loads.bristles, states.bristles.rate[0]),
        ([0.0; 3], 0.0, 0.0)
    );
    assert!(!states.has_force(&model, 0));
}
