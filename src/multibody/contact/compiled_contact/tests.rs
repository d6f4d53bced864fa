//! Tests of contact states, laws of pieces and the back of open outlines.

use super::super::tests::{
    BALL, BLOCK, at_rest, contact, distance_to, evaluated, floor, frames, model, only, outline,
};
use super::*;
use crate::force_law::{Damping, Elastic, ForceLaw, Regions};
use crate::multibody::contact::contact_states::ContactStates;
use crate::multibody::description::contact_law::ContactLaw;
use crate::multibody::description::outline_piece::Piece;
use crate::multibody::model::MechanismModel;

const RADIUS: f64 = 0.1;
const IN_CONTACT: Memory = Memory {
    speed: 0.5,
    piece: 0,
    in_front: false,
};
const FROM_FRONT: Memory = Memory {
    speed: 0.5,
    piece: 0,
    in_front: true,
};

/// Return frames with the ball at a place and at a velocity.
fn at((x, y): (f64, f64), (vx, vy): (f64, f64)) -> Vec<Frame> {
    frames(&at_rest(), &[[x, y, 0.0], [vx, vy, 0.0], [0.0; 3]], 0.0)
}

fn hertz() -> ContactLaw {
    ContactLaw::Surfaces {
        law: ForceLaw {
            elastic: Elastic::Hertz,
            damping: Damping::LankaraniNikravesh,
            regions: Regions::Kept,
        },
        contact_modulus: 1e7,
        restitution: 0.9,
        length: 0.02,
        min_impact_velocity: 0.01,
    }
}

/// Return the force on the ball of a contact with Hertz' law.
fn force(profile: Profile, place: (f64, f64), memory: Memory) -> Vec2 {
    let mut pair = contact(profile, RADIUS);
    pair.law = hertz();
    let model = model(vec![pair]);
    let mut states = ContactStates::new(&model);
    states.memory.fill(memory);
    let load = evaluated(&model, &mut states, &at(place, (0.0, 0.0))).on[BALL];
    Vec2::new(load[0], load[1])
}

fn arc(radius: f64, convex: bool) -> Piece {
    let x = if convex { radius } else { -radius };
    Piece {
        from: Vec2::new(x, 0.0),
        to: Vec2::new(-x, 0.0),
        center: Some(Vec2::zeros()),
        convex,
    }
}

#[test]
fn an_arc_has_the_force_of_the_disc_or_the_bore_of_its_radius() {
    let half = |convex| Profile::Outline {
        pieces: vec![arc(0.3, convex)],
        closed: false,
    };
    for (one, other, place) in [
        (half(true), Profile::Disc { radius: 0.3 }, (0.1, 0.37)),
        (half(false), Profile::Bore { radius: 0.3 }, (0.05, 0.21)),
    ] {
        let [one, other] = [one, other].map(|profile| force(profile, place, IN_CONTACT));
        assert!((one - other).norm() < 1e-12 * other.norm() && other.norm() > 1.0);
    }
    // An arc into which the circle does not fit needs no law of its own.
    let pieces = vec![
        Piece {
            from: Vec2::new(1.05, 1.0),
            to: Vec2::new(0.05, 0.0),
            center: None,
            convex: true,
        },
        Piece {
            from: Vec2::new(0.05, 0.0),
            to: Vec2::new(-0.05, 0.0),
            center: Some(Vec2::new(0.0, 0.05)),
            convex: false,
        },
    ];
    let tight = Profile::Outline {
        pieces,
        closed: false,
    };
    let mut pair = contact(tight, RADIUS);
    pair.law = hertz();
    assert_eq!(only(&model(vec![pair])).pieces(), 2);
}

#[test]
fn a_contact_keeps_the_law_of_the_piece_of_its_onset() {
    // A flat and an arc of 0.15 m beside it.
    let pieces = vec![
        Piece {
            from: Vec2::new(1.0, 0.15),
            to: Vec2::new(0.0, 0.15),
            center: None,
            convex: true,
        },
        Piece {
            from: Vec2::new(0.0, 0.15),
            to: Vec2::new(-0.15, 0.0),
            center: Some(Vec2::zeros()),
            convex: true,
        },
    ];
    let shape = || Profile::Outline {
        pieces: pieces.clone(),
        closed: false,
    };
    let on = |memory: Memory| force(shape(), (0.5, 0.24), memory).y;
    let memory = |piece| Memory {
        piece,
        ..IN_CONTACT
    };
    let on_arc = force(Profile::Disc { radius: 0.15 }, (0.0, 0.24), IN_CONTACT).y;
    assert!((on(memory(1)) / on_arc - 1.0).abs() < 1e-12);
    assert!((on(memory(0)) / on_arc - 1.0).abs() > 1e-3);
    // Without memory, the law is that of the piece of the contact point.
    let without = Memory {
        piece: 1,
        ..Memory::default()
    };
    assert_eq!(on(without), on(memory(0)));
}

#[test]
fn only_a_circle_from_the_front_is_in_contact_behind_an_open_outline() {
    let model = model(vec![contact(floor(), RADIUS)]);
    let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
    let closed = super::super::tests::model(vec![contact(square, RADIUS)]);
    let may = |model: &MechanismModel, place, distance, memory| {
        let candidate = ContactPoint {
            distance,
            outward: Vec2::y(),
            piece: 0,
            side: 0,
            weight: 1.0,
            weight_gradient: Vec2::zeros(),
            bend: 0.0,
            place,
        };
        only(model).may_carry_force(&candidate, memory)
    };
    let none = Memory::default();
    for (place, distance, memory, expected) in [
        (OutlinePlace::DeepAtEnd, -0.01, FROM_FRONT, true),
        (OutlinePlace::DeepAtEnd, -0.01, IN_CONTACT, false),
        (OutlinePlace::DeepAtEnd, -0.01, none, false),
        (OutlinePlace::Deep, -0.5, FROM_FRONT, true),
        (OutlinePlace::Deep, -0.01, IN_CONTACT, false),
        (OutlinePlace::Deep, -0.049, none, true),
        (OutlinePlace::Deep, -0.05, none, false),
        (OutlinePlace::Deep, -0.051, none, false),
        (OutlinePlace::Deep, -0.01, Memory::BEHIND, false),
        (OutlinePlace::Front, 0.05, none, true),
        (OutlinePlace::Front, 0.05, Memory::BEHIND, false),
        (OutlinePlace::Front, 0.11, Memory::BEHIND, true),
        (OutlinePlace::EndBack, 0.05, Memory::BEHIND, false),
        (OutlinePlace::EndFront, 0.05, IN_CONTACT, true),
    ] {
        assert_eq!(
            may(&model, place, distance, memory),
            expected,
            "{place:?} {distance}"
        );
    }
    // Closed outlines have no back.
    assert!(may(&closed, OutlinePlace::Deep, -0.5, none));
}

#[test]
fn the_state_of_a_side_is_that_of_its_deepest_point() {
    // A re-entrant corner at the origin, with a wall along y and a floor along x, and an edge beyond the floor.
    let corner = outline(&[(0.5, -0.3), (0.4, 0.0), (0.0, 0.0), (0.0, 1.0)], false);
    let model = model(vec![contact(corner, RADIUS)]);
    let contact = only(&model);
    let here = at((0.07, 0.06), (-2.0, -3.0));
    let side = |k: usize, memory| contact.find(&here[BLOCK], &here[BALL], k, memory);
    let [floor, wall] = [0, 1].map(|k| side(k, Memory::default()));
    assert!((floor.contact.penetration - 0.04).abs() < 1e-15);
    assert!((wall.contact.penetration - 0.03).abs() < 1e-15);
    // Normals point into the material, and rates are velocities along them.
    assert_eq!(
        (floor.contact.normal, wall.contact.normal),
        (-Vec2::y(), -Vec2::x())
    );
    assert_eq!(
        (
            floor.contact.penetration_rate,
            wall.contact.penetration_rate
        ),
        (3.0, 2.0)
    );
    assert_eq!(
        (floor.piece, wall.piece, floor.place),
        (1, 2, OutlinePlace::Front)
    );
    let behind = side(0, Memory::BEHIND).contact.penetration;
    assert_eq!(behind, f64::NEG_INFINITY);
    let deepest = contact.penetration(&here, &[Memory::default(); 2]);
    assert!((deepest - 0.04).abs() < 1e-15);
    let mut states = ContactStates::new(&model);
    evaluated(&model, &mut states, &here);
    for (found, exact) in states.side_states.iter().zip([floor, wall]) {
        assert_eq!(found.contact, exact.contact);
    }
    assert!((states.deepest[0][0] - 0.04).abs() < 1e-15 && states.deepest[0][1] == 3.0);
}

#[test]
fn the_depth_of_a_centre_is_its_distance_from_the_outline_inside_of_it() {
    let points = [
        (-1.0, -1.0),
        (1.0, -1.0),
        (1.0, 1.0),
        (0.2, 0.1),
        (-1.0, 1.0),
    ];
    let round = [&points[..], &points[..1]].concat();
    let closed = model(vec![contact(outline(&points, true), RADIUS)]);
    for place in [(0.0, -0.3), (0.8, 0.4), (-0.9, -0.9), (0.5, -0.2)] {
        let depth = only(&closed).center_depth(&at(place, (0.0, 0.0)));
        let exact = distance_to(&round, Vec2::new(place.0, place.1));
        assert!((depth - exact).abs() < 1e-14, "{place:?}: {depth} {exact}");
    }
    for place in [(0.0, 1.4), (1.5, 0.0), (0.2, 0.4)] {
        let depth = only(&closed).center_depth(&at(place, (0.0, 0.0)));
        let exact = distance_to(&round, Vec2::new(place.0, place.1));
        assert!((depth + exact).abs() < 1e-14, "{place:?}: {depth} {exact}");
    }
    let open = model(vec![contact(floor(), RADIUS)]);
    let depth = only(&open).center_depth(&at((0.0, -0.3), (0.0, 0.0)));
    assert_eq!(depth, f64::NEG_INFINITY);
}

#[test]
fn a_circle_is_behind_an_open_outline_at_half_a_radius_unless_it_comes_out() {
    let open = model(vec![contact(floor(), RADIUS)]);
    for (y, speed, behind) in [
        (-0.051, 0.0, true),
        (-0.05, 0.0, true),
        (-0.049, 0.0, false),
        (-0.051, -1.0, true),
        (-0.051, 1.0, false),
        (0.051, -1.0, false),
    ] {
        let found = only(&open).is_behind(&at((0.0, y), (0.0, speed)));
        assert_eq!(found, behind, "{y} {speed}");
    }
    let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
    let closed = model(vec![contact(square, RADIUS)]);
    assert!(!only(&closed).is_behind(&at((0.0, 0.3), (0.0, 0.0))));
}

#[test]
fn a_memory_behind_ends_when_the_circle_is_outside_or_past_the_end() {
    let corner = outline(&[(1.0, 0.0), (0.0, 0.0), (0.0, 1.0)], false);
    let corner = model(vec![contact(corner, RADIUS)]);
    let open = model(vec![contact(floor(), RADIUS)]);
    let apart = |model: &MechanismModel, place, side, memory| {
        let here = at(place, (0.0, 0.0));
        only(model).apart(&here[BLOCK], &here[BALL], side, memory)
    };
    let none = Memory::default();
    for (place, before, expected) in [
        ((0.0, -0.3), none, Memory::BEHIND),
        ((0.0, -0.3), FROM_FRONT, Memory::BEHIND),
        ((0.0, 0.05), Memory::BEHIND, Memory::BEHIND),
        ((0.0, 0.15), Memory::BEHIND, none),
        ((0.0, 0.05), none, none),
        ((0.0, 0.15), IN_CONTACT, none),
        // Past the end, the circle is behind until it does not overlap.
        ((1.05, -0.02), Memory::BEHIND, Memory::BEHIND),
        ((1.05, -0.02), none, none),
        ((1.2, -0.02), Memory::BEHIND, none),
    ] {
        assert_eq!(apart(&open, place, 0, before), expected, "{place:?}");
    }
    // Each side has its own: behind the floor of the corner, and in front of its wall.
    assert_eq!(apart(&corner, (0.5, -0.05), 0, none), Memory::BEHIND);
    assert_eq!(apart(&corner, (0.5, -0.05), 1, none), none);
    let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
    let closed = model(vec![contact(square, RADIUS)]);
    assert_eq!(apart(&closed, (0.0, 0.0), 0, none), none);
}

#[test]
fn a_bore_has_its_clearance_a_clockwise_outline_is_a_hole_and_a_memory_at_the_minimum_is_slow() {
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mut hole = square;
    hole.reverse();
    for (profile, play, is_hole, pieces) in [
        (Profile::Bore { radius: 0.13 }, 0.03, false, 1),
        (Profile::Disc { radius: 0.13 }, 0.025, false, 1),
        (outline(&square, true), 0.025, false, 4),
        (outline(&hole, true), 0.025, true, 4),
        (floor(), 0.025, false, 1),
    ] {
        let mut pair = contact(profile, RADIUS);
        pair.law = hertz();
        let model = model(vec![pair]);
        let contact = only(&model);
        assert!((contact.play() - play).abs() < 1e-15);
        assert_eq!((contact.is_hole(), contact.pieces()), (is_hole, pieces));
        for (rate, speed, slow) in [(0.3, 0.3, false), (0.01, 0.01, true), (0.001, 0.01, true)] {
            let memory = contact.remember(pieces - 1, rate);
            let expected = Memory {
                speed,
                piece: pieces - 1,
                in_front: false,
            };
            assert_eq!((memory, contact.is_at_minimum(memory)), (expected, slow));
        }
    }
    // A disc is near up to the sum of the radii, 0.23 m.
    let model = model(vec![contact(Profile::Disc { radius: 0.13 }, RADIUS)]);
    assert!((only(&model).reach - 0.23).abs() < 1e-15);
    let apart = only(&model).apart_squared(&at((0.3, 0.4), (0.0, 0.0)));
    assert!((apart - 0.25).abs() < 1e-15);
}
