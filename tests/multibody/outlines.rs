//! Circles on outlines: corners where two sides bear, ends, tight arcs; and contacts that cannot be.

use std::sync::Arc;

use crate::common::mechanisms::{GRAVITY, Rows, control, ground, record, simulation};
use rustchain::force_law::{Damping, Elastic, ForceLaw, Regions};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, StepControl};
use rustchain::multibody::{
    Body, ContactLaw, ContactPair, ForceElement, ForceKind, Marker, Mechanism, MechanismModel,
    Piece, Profile, SpringLaw, Tribology,
};
use rustchain::run::MechanismSimulation;

const RADIUS: f64 = 0.1;

fn outline(points: &[(f64, f64)], closed: bool) -> Profile {
    let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Profile::polyline("outline", &points, closed).unwrap()
}

/// A ball of 0.5 kg on a profile.
fn ball(profile: Profile, law: ContactLaw, position: (f64, f64)) -> Mechanism {
    Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        bodies: vec![Body::new("ball", 0.5, 0.002).at(position.0, position.1, 0.0)],
        contacts: vec![ContactPair {
            name: "floor".into(),
            a: ground(0.0, 0.0),
            b: Marker::new("ball", 0.0, 0.0),
            profile,
            radius: RADIUS,
            law,
            tribology: Tribology::default(),
        }],
        ..Mechanism::default()
    }
}

fn linear(damping: f64) -> ContactLaw {
    ContactLaw::Linear {
        stiffness: 1e5,
        damping,
    }
}

fn refusal(mechanism: &Mechanism) -> String {
    let made = MechanismModel::compile(mechanism).and_then(|model| {
        let control = control(1e-8, 0.01);
        MechanismSimulation::assemble(Arc::new(model), control)
    });
    made.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn a_ball_in_a_corner_rests_on_both_sides() {
    // Sides at 30° and 60° to the level: the forces are the weight's components across them.
    let (s, c) = (0.5, 0.75f64.sqrt());
    let corner = outline(&[(s, c), (0.0, 0.0), (-c, s)], false);
    let (n_right, n_left) = (Vec2::new(-c, s), Vec2::new(s, c));
    let center = 1.001 * RADIUS * (n_right + n_left);
    let mechanism = ball(corner, linear(300.0), (center.x, center.y));
    let mut machine = simulation(&mechanism, 1e-9);
    let recording = record(&mut machine, 1.0, 1e-3);
    // Each side is met once, and stays: no chatter.
    assert_eq!(machine.statistics().onsets, 2);
    let weight = 0.5 * GRAVITY;
    assert!((recording.contact_force().last().unwrap() / weight - 1.0).abs() < 1e-6);
    let rest = Vec2::new(
        recording.positions()[recording.positions().len() - 3],
        recording.positions()[recording.positions().len() - 2],
    );
    // Depths are what the weight's components press into the springs.
    for (normal, part) in [(n_right, s), (n_left, c)] {
        let depth = RADIUS - rest.dot(&normal);
        assert!((depth - weight * part / 1e5).abs() < 1e-9, "{depth}");
    }
    assert!(machine.counts().steps < 2000, "{}", machine.counts().steps);
    let residual = recording.real("energy_residual").last().unwrap();
    assert!(residual.abs() < 1e-7, "{residual}");
}

/// A contact of hard surfaces, 10 mm long.
fn hard_surfaces() -> ContactLaw {
    ContactLaw::Surfaces {
        law: ForceLaw::default(),
        contact_modulus: 1e11,
        restitution: 0.9,
        length: 0.01,
        min_impact_velocity: 1e-3,
    }
}

#[test]
fn a_side_that_is_hit_remembers_its_own_onset() {
    // Rests on the floor, is driven against the wall: the restitution there is the law's, whatever the floor remembers.
    let law = hard_surfaces();
    let rebound = |profile: Profile, gravity: f64| {
        let mut mechanism = ball(profile, law.clone(), (0.3, RADIUS - 1e-9));
        mechanism.gravity.y = -gravity;
        mechanism.bodies[0].velocity[0] = 1.0;
        let mut machine = simulation(&mechanism, 1e-9);
        let recording = record(&mut machine, 0.6, 1e-3);
        recording.velocities()[recording.velocities().len() - 3]
    };
    let wall = rebound(outline(&[(0.9, 1.0), (0.9, -1.0)], false), 0.0);
    let both = rebound(
        outline(&[(0.9, 1.0), (0.9, 0.0), (-1.0, 0.0)], false),
        GRAVITY,
    );
    assert!(wall < -0.8, "{wall}");
    assert!((both - wall).abs() < 1e-3, "{both} {wall}");
}

/// A ball without weight at a distance of `gap` \[m\] from a disc of 0.2 m, with a velocity of `speed` \[m/s\] towards it.
fn thrown_at_a_disc(law: ContactLaw, speed: f64, gap: f64) -> Mechanism {
    let disc = Profile::Disc { radius: 0.2 };
    let mut mechanism = ball(disc, law, (0.0, 0.2 + RADIUS + gap));
    mechanism.gravity = Vec2::zeros();
    mechanism.bodies[0].velocity[1] = -speed;
    mechanism
}

#[test]
fn onsets_slower_than_the_minimum_impact_velocity_are_counted() {
    for (speed, slow) in [(2e-3, 0), (5e-4, 1)] {
        let law = hard_surfaces();
        let mut machine = simulation(&thrown_at_a_disc(law, speed, 1e-6), 1e-9);
        record(&mut machine, 0.01, 1e-3);
        let found = machine.statistics();
        assert_eq!(
            (found.onsets, found.onsets_at_minimum_velocity),
            (1, slow),
            "{speed}"
        );
    }
}

#[test]
fn rows_within_the_step_in_which_a_contact_ends_have_its_damping() {
    // A ball without weight on a disc: f = K δ (1 + λ δ'/δ'₀) until δ = 0, with the speed δ'₀ of its approach. The stored speed is that of
    // the dense output, 5e-6 away in Newton's method.
    let (stiffness, restitution, speed) = (1e6, 0.5, 0.5);
    let elastic = Elastic::Linear(stiffness);
    let damping = Damping::LankaraniNikravesh;
    let law = ContactLaw::Surfaces {
        law: ForceLaw {
            elastic,
            damping,
            regions: Regions::Kept,
        },
        contact_modulus: 1e11,
        restitution,
        length: 0.01,
        min_impact_velocity: 1e-3,
    };
    let lambda = 0.75 * (1.0 - restitution * restitution);
    let mechanism = thrown_at_a_disc(law, speed, 1e-4);
    for corrector in [Corrector::Pece, Corrector::Newton] {
        let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
        let control = StepControl {
            corrector,
            ..control(1e-6, 0.01)
        };
        let mut machine = MechanismSimulation::assemble(model, control).unwrap();
        let recording = record(&mut machine, 4e-3, 1e-6);
        let rows = recording.contact_force().iter().enumerate();
        let mut rebounding = 0;
        for (row, force) in rows {
            let height = recording.positions()[3 * row + 1];
            let rate = -recording.velocities()[3 * row + 1];
            let elastic = stiffness * (0.3 - height).max(0.0);
            let expected = elastic * (1.0 + lambda * rate / speed);
            assert!(
                (force - expected).abs() <= 1e-4 * (0.01 + expected),
                "{corrector:?} {row}: {force} {expected}"
            );
            rebounding += usize::from(elastic > 0.0 && rate < 0.0);
        }
        assert!(rebounding > 500, "{rebounding}");
    }
}

#[test]
fn a_ball_rolls_over_the_end_of_a_table_without_a_jump() {
    let table = outline(&[(0.0, 0.0), (-1.0, 0.0)], false);
    let mut mechanism = ball(table, linear(0.0), (-0.05, RADIUS - 0.5 * GRAVITY / 1e5));
    mechanism.bodies[0].velocity[0] = 0.3;
    let mut machine = simulation(&mechanism, 1e-9);
    let recording = record(&mut machine, 0.35, 1e-4);
    let jump = recording
        .contact_force()
        .windows(2)
        .map(|w| (w[1] - w[0]).abs());
    // No friction: once over the edge it slides off, and the force falls within some hundredths of a second.
    assert!(jump.fold(0.0, f64::max) < 0.1);
    assert_eq!(*recording.contact_force().last().unwrap(), 0.0);
    assert!(recording.energy().chunks(6).all(|row| row[5].abs() < 1e-7));
    assert_eq!(machine.statistics().onsets, 0);
}

#[test]
fn a_ball_pushed_round_an_end_to_the_back_leaves_the_contact_softly() {
    // A spring holds it near the end while it is carried round: from above to below the table.
    let table = outline(&[(0.0, 0.0), (-1.0, 0.0)], false);
    let mut mechanism = ball(table, linear(0.0), (0.08, 0.06));
    mechanism.gravity = Vec2::zeros();
    mechanism.bodies[0].velocity = [0.6, -0.8, 0.0];
    mechanism.forces.push(ForceElement::new(
        "lead",
        ground(-0.1, -0.3),
        Marker::new("ball", 0.0, 0.0),
        ForceKind::Spring {
            law: SpringLaw::linear(200.0, 0.0),
            rest: Some(0.0),
        },
    ));
    let mut machine = simulation(&mechanism, 1e-9);
    let recording = record(&mut machine, 0.3, 1e-4);
    let lowest = recording
        .positions()
        .chunks(3)
        .map(|p| p[1])
        .fold(0.0, f64::min);
    assert!(lowest < -0.05, "{lowest}");
    let energy = recording.energy();
    let worst = energy.chunks(6).map(|row| row[5].abs());
    assert!(worst.fold(0.0, f64::max) < 1e-6);
}

#[test]
fn a_disc_that_is_larger_than_an_arc_rests_on_its_flanks() {
    // A groove of 90° whose bottom is an arc of 0.03 m: the disc of 0.1 m cannot reach it.
    let r = 0.03;
    let c = r / std::f64::consts::SQRT_2;
    let bottom = Vec2::new(0.0, 2.0 * c);
    let piece = |from: (f64, f64), to: (f64, f64), center: Option<Vec2>| Piece {
        from: Vec2::new(from.0, from.1),
        to: Vec2::new(to.0, to.1),
        center,
        convex: false,
    };
    let profile = Profile::Outline {
        pieces: vec![
            piece((1.0, 1.0), (c, c), None),
            piece((c, c), (-c, c), Some(bottom)),
            piece((-c, c), (-1.0, 1.0), None),
        ],
        closed: false,
    };
    for law in [
        linear(300.0),
        ContactLaw::Surfaces {
            law: ForceLaw::default(),
            contact_modulus: 1e9,
            restitution: 0.5,
            length: 0.01,
            min_impact_velocity: 1e-3,
        },
    ] {
        let height = RADIUS * std::f64::consts::SQRT_2;
        let mechanism = ball(profile.clone(), law, (0.0, height));
        let mut machine = simulation(&mechanism, 1e-9);
        let recording = record(&mut machine, 1.0, 1e-3);
        let last = &recording.positions()[recording.positions().len() - 3..];
        assert!(
            (last[1] - height).abs() < 1e-4 && last[0].abs() < 1e-9,
            "{last:?}"
        );
        assert!(recording.contact_force().iter().any(|&force| force > 1.0));
    }
}

#[test]
fn starts_in_material_and_outlines_the_wrong_way_round_are_refused() {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let inside = ball(outline(&corners, true), linear(0.0), (0.5, 0.7));
    let text = refusal(&inside);
    assert!(
        text.contains("\"floor\"") && text.contains("3.000e-1 m"),
        "{text}"
    );
    let mut reversed = corners;
    reversed.reverse();
    let clockwise = ball(outline(&reversed, true), linear(0.0), (0.5, 1.2));
    let text = refusal(&clockwise);
    assert!(
        text.contains("clockwise") && text.contains("reverse"),
        "{text}"
    );
    // As a hole, the same outline is right.
    assert_eq!(
        refusal(&ball(outline(&reversed, true), linear(0.0), (0.5, 0.5))),
        ""
    );
    let disc = ball(Profile::Disc { radius: 0.5 }, linear(0.0), (0.2, 0.0));
    assert!(refusal(&disc).contains("into the material"));
    let pressed = ball(outline(&corners, true), linear(0.0), (0.5, 1.09));
    let warnings = simulation(&pressed, 1e-8).assembly().warnings.clone();
    assert!(
        warnings[0].contains("at a penetration of 1.000e-2 m"),
        "{warnings:?}"
    );
}

#[test]
fn what_acts_on_itself_or_contradicts_itself_is_refused() {
    let floor = || outline(&[(1.0, 0.0), (-1.0, 0.0)], false);
    let sound = ball(floor(), linear(0.0), (0.0, 0.2));
    let mut itself = sound.clone();
    itself.contacts[0].a.body = "ball".into();
    assert!(refusal(&itself).contains("bodies of contact \"floor\" = \"ball\" twice"));
    let spring = |a: &str, b: &str, law: SpringLaw| {
        let mut mechanism = sound.clone();
        let kind = ForceKind::Spring { law, rest: None };
        let ends = (Marker::new(a, 0.0, 0.0), Marker::new(b, 0.1, 0.0));
        mechanism
            .forces
            .push(ForceElement::new("spring", ends.0, ends.1, kind));
        refusal(&mechanism)
    };
    assert_eq!(spring("ground", "ball", SpringLaw::linear(1.0, 0.0)), "");
    let text = spring("ball", "ball", SpringLaw::linear(1.0, 0.0));
    assert!(text.contains("\"ball\" twice"), "{text}");
    let table = rustchain::math::Table::new("x", "m", &[(0.0, 0.0), (1.0, 5.0)]).unwrap();
    let both = SpringLaw {
        stiffness: 3.0,
        table: Some(table),
        ..SpringLaw::default()
    };
    let text = spring("ground", "ball", both);
    assert!(text.contains("stiffness of force \"spring\" = 3"), "{text}");
    let mut held = sound.clone();
    held.bodies
        .push(Body::new("post", 1.0, 1.0).moving(0.0, 1.0, 0.0).fixed());
    let text = refusal(&held);
    assert!(
        text.contains("velocity of body \"post\"") && text.contains("fixed body"),
        "{text}"
    );
}
