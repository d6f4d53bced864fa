//! Tests of motions in the frame of a profile and of contacts that begin and end within a step.

use super::super::tests::{
    BALL, BLOCK, Course, accelerations, at_rest, contact, floor, frames, model, only, outline,
};
use super::*;
use crate::math::testing::random;
use crate::multibody::description::profile::Profile;
use crate::multibody::forces::loads::BodyLoads;

const RADIUS: f64 = 0.1;

#[test]
fn the_motion_in_the_frame_of_a_turning_profile_is_that_of_the_places_in_it() {
    let mut pair = contact(floor(), RADIUS);
    (pair.a.point, pair.b.point) = (Vec2::new(0.3, -0.2), Vec2::new(-0.1, 0.4));
    let model = model(vec![pair]);
    let mut next = random(11);
    for _ in 0..100 {
        let [block, ball] = [(); 2].map(|()| [(); 3].map(|()| [next(), next(), next()]));
        let here = frames(&block, &ball, 0.0);
        let end =
            only(&model).end_of_step([-0.01, 0.2], &model, &here, &accelerations(&block, &ball));
        assert_eq!(end.depth, [-0.01, 0.2]);
        let local = |t: f64| {
            let all = frames(&block, &ball, t);
            only(&model).local(&all[BLOCK], &all[BALL])
        };
        let h = 1e-4;
        let [before, at, after] = [-h, 0.0, h].map(local);
        let exact = [
            at,
            (after - before) / (2.0 * h),
            (after - 2.0 * at + before) / (h * h),
        ];
        for (found, exact) in end.motion.unwrap().iter().zip(exact) {
            // The differences have errors of h² and of rounding over h², 1e-7.
            assert!(
                (Vec2::from(*found) - exact).norm() < 3e-6,
                "{found:?} {exact}"
            );
        }
    }
}

#[test]
fn a_circle_farther_than_a_quarter_radius_has_no_motion() {
    let model = model(vec![contact(floor(), RADIUS)]);
    let here = frames(&at_rest(), &at_rest(), 0.0);
    let end = |depth: f64| only(&model).end_of_step([depth, 1.0], &model, &here, &[0.0; 6]);
    assert_eq!(end(-0.0251), ContactEnd::FAR);
    assert!(end(-0.0249).motion.is_some());
    assert!(end(0.5).motion.is_some());
}

#[test]
fn the_penetration_out_of_reach_is_that_of_the_enclosing_circle() {
    // The corners of the square are at √2 from its middle.
    let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
    let model = model(vec![contact(square, RADIUS)]);
    for (gap, near) in [(0.01, true), (0.0249, true), (0.0251, false), (3.0, false)] {
        let apart = 2.0f64.sqrt() + RADIUS + gap;
        let depth = only(&model).outer_depth(apart * apart);
        if near {
            assert!((depth + gap).abs() < 1e-14, "{depth}");
        } else {
            assert_eq!(depth, f64::NEG_INFINITY);
        }
    }
}

#[test]
fn a_path_with_one_end_far_away_continues_the_motion_of_the_other_end() {
    let (length, a) = (0.4, Vec2::new(3.0, -5.0));
    let (p, v) = (Vec2::new(0.2, 0.1), Vec2::new(-1.0, 2.0));
    let parabola = |t: f64| p + t * v + 0.5 * t * t * a;
    let known = |t: f64| ContactEnd {
        depth: [0.0; 2],
        motion: Some([parabola(t), v + t * a, a].map(Into::into)),
    };
    for (start, end) in [
        (known(0.0), known(length)),
        (known(0.0), ContactEnd::FAR),
        (ContactEnd::FAR, known(length)),
    ] {
        let path = path_between(&start, &end, length).unwrap();
        for part in [0.0, 0.3, 0.8, 1.0] {
            assert!((path.at(part) - parabola(part * length)).norm() < 1e-15);
        }
    }
    assert!(path_between(&ContactEnd::FAR, &ContactEnd::FAR, length).is_none());
}

#[test]
fn the_penetration_along_a_path_is_that_in_the_nearest_side_that_carries_force() {
    let corner = [(1.0, 0.0), (0.0, 0.0), (0.0, 1.0)];
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corner = model(vec![contact(outline(&corner, false), RADIUS)]);
    let square = model(vec![contact(outline(&square, true), RADIUS)]);
    let depth = |model: &MechanismModel, (x, y): (f64, f64), memory: Memory| {
        only(model).depth_at(Vec2::new(x, y), &[memory; 2])
    };
    let none = Memory::default();
    let from_front = Memory {
        speed: 1.0,
        piece: 0,
        in_front: true,
    };
    for (model, place, memory, expected) in [
        // Outside of a square and in it.
        (&square, (0.3, 1.05), none, 0.05),
        (&square, (0.3, 0.95), none, 0.15),
        // A depth of more than the radius in air is that radius.
        (&square, (0.3, 1.25), none, -RADIUS),
        // In the quadrant in front of the corner, 40 mm from one side.
        (&corner, (0.04, 0.3), none, 0.06),
        (&corner, (0.3, 0.5), none, -RADIUS),
        // Behind an open outline by less than half a radius, or by more.
        (&corner, (-0.04, 0.7), none, 0.14),
        (&corner, (-0.06, 0.7), none, -RADIUS),
        (&corner, (-0.06, 0.7), from_front, 0.16),
        (&corner, (-0.04, 0.7), Memory::BEHIND, -RADIUS),
        (&corner, (0.04, 0.7), Memory::BEHIND, -RADIUS),
    ] {
        let found = depth(model, place, memory);
        assert!((found - expected).abs() < 1e-14, "{place:?}: {found}");
    }
}

/// Height of a circle above a floor, with its velocity and acceleration, by the part of the step that has passed.
type Height = fn(f64, f64) -> [f64; 3];

/// Return whether a contact passes in a step of 0.1 s. `height` is that of the circle's lowest point.
fn passes(profile: &Profile, from_origin: f64, height: Height, parameter: f64) -> bool {
    let model = model(vec![contact(profile.clone(), RADIUS)]);
    let length = 0.1;
    let mut states = ContactStates::new(&model);
    let mut loads = BodyLoads::new(3, 6);
    let ends = [0.0, 1.0].map(|part| {
        let [y, v, a] = height(part, parameter);
        let (v, a) = (v / length, a / (length * length));
        let ball: Course = [
            [0.0, from_origin + RADIUS + y, 0.0],
            [0.0, v, 0.0],
            [0.0, a, 0.0],
        ];
        (
            frames(&at_rest(), &ball, 0.0),
            accelerations(&at_rest(), &ball),
        )
    });
    states.add_loads(&model, &ends[0].0, &mut loads);
    states.begin_screening(&model, &ends[0].0, &ends[0].1);
    states.add_loads(&model, &ends[1].0, &mut loads);
    states.passes_contact(&model, &ends[1].0, &ends[1].1, length)
}

/// Return a parabola with its lowest value at 0.45.
fn valley(part: f64, lowest: f64) -> [f64; 3] {
    let x = part - 0.45;
    [lowest + 0.05 * x * x, 0.1 * x, 0.1]
}

#[test]
fn a_contact_inside_a_step_is_found_if_it_is_deeper_than_the_neglected_one() {
    for (profile, from_origin) in [(floor(), 0.0), (Profile::Disc { radius: 0.2 }, 0.2)] {
        for (lowest, found) in [
            (-1e-3, true),
            (-2.0 * UNSEEN, true),
            (-0.5 * UNSEEN, false),
            (0.5 * UNSEEN, false),
            (1e-3, false),
        ] {
            assert_eq!(
                passes(&profile, from_origin, valley, lowest),
                found,
                "{lowest}"
            );
        }
        // Far away at the start, at 0.05 m, where only the motion of the end is known, or at the end.
        for mirrored in [false, true] {
            let dive: [Height; 2] = [
                |part, lowest| {
                    let x = part - 0.8;
                    [lowest + 0.1 * x * x, 0.2 * x, 0.2]
                },
                |part, lowest| {
                    let x = part - 0.2;
                    [lowest + 0.1 * x * x, 0.2 * x, 0.2]
                },
            ];
            let height = dive[usize::from(mirrored)];
            assert!(passes(&profile, from_origin, height, -1e-4));
            assert!(!passes(&profile, from_origin, height, 1e-4));
        }
        // Far away at both ends.
        assert!(!passes(
            &profile,
            from_origin,
            |part, far| [far + part, 1.0, 0.0],
            1.0
        ));
    }
}

#[test]
fn a_contact_that_lasts_at_the_end_hides_none_that_is_deeper_before() {
    // The circle touches at 0.2 of the step; its path has the lowest point at `parameter` of the step.
    let height: Height = |part, lowest| {
        let slope = |part: f64| 0.1 * (part - lowest);
        let value = |part: f64| 0.05 * (part - lowest) * (part - lowest);
        [value(part) - value(0.2), slope(part), 0.1]
    };
    assert!(passes(&floor(), 0.0, height, 0.4));
    assert!(!passes(&floor(), 0.0, height, 1.5));
}

#[test]
fn a_contact_that_ends_and_begins_again_inside_a_step_is_found() {
    // In contact up to 0.1 and, below the parameter as height, near 0.6.
    let height: Height = |part, lowest| {
        let square = [
            (part - 0.6) * (part - 0.6) + lowest,
            2.0 * (part - 0.6),
            2.0,
        ];
        let x = part - 0.1;
        [
            0.1 * x * square[0],
            0.1 * (square[0] + x * square[1]),
            0.1 * (2.0 * square[1] + x * square[2]),
        ]
    };
    assert!(passes(&floor(), 0.0, height, -0.01));
    assert!(!passes(&floor(), 0.0, height, 0.01));
}

#[test]
fn a_separation_inside_a_step_with_contact_at_both_ends_is_found() {
    for (gap, found) in [
        (1e-3, true),
        (2.0 * UNSEEN, true),
        (0.5 * UNSEEN, false),
        (-1e-3, false),
    ] {
        let height: Height = |part, highest| {
            let [y, v, a] = valley(part, 0.0);
            [highest - y, -v, -a]
        };
        assert_eq!(passes(&floor(), 0.0, height, gap), found, "{gap}");
    }
}

#[test]
fn any_of_several_contacts_is_found_in_a_step() {
    // The step of the second contact of two; each has its own memory and its own start.
    let mut pairs = [
        contact(Profile::Disc { radius: 5.0 }, RADIUS),
        contact(floor(), RADIUS),
    ];
    pairs[0].name = "other".into();
    pairs[0].a.point.y = 20.0;
    let model = model(pairs.to_vec());
    let mut states = ContactStates::new(&model);
    let mut loads = BodyLoads::new(3, 6);
    let ball = |y: f64, v: f64| [[0.0, RADIUS + y, 0.0], [0.0, v, 0.0], [0.0, 2.0, 0.0]];
    // y = -0.001 + t², from -0.1 s to 0.1 s.
    let (before, after) = (ball(0.009, -0.2), ball(0.009, 0.2));
    let all = [before, after].map(|ball| frames(&at_rest(), &ball, 0.0));
    states.add_loads(&model, &all[0], &mut loads);
    states.begin_screening(&model, &all[0], &accelerations(&at_rest(), &before));
    states.add_loads(&model, &all[1], &mut loads);
    let found = |states: &mut ContactStates| {
        states.passes_contact(&model, &all[1], &accelerations(&at_rest(), &after), 0.2)
    };
    assert!(found(&mut states));
    states.memory[model.sides_of_contact[1].start] = Memory::BEHIND;
    assert!(!found(&mut states));
    // The next step begins where this one ends, as if it had been evaluated there again; another evaluation is not that end.
    let mut other = states.clone();
    other.screened = false;
    for states in [&mut states, &mut other] {
        states.begin_screening(&model, &all[1], &accelerations(&at_rest(), &after));
    }
    assert_eq!(states.starts, other.starts);
    found(&mut states);
    states.add_loads(&model, &all[0], &mut loads);
    states.begin_screening(&model, &all[0], &accelerations(&at_rest(), &before));
    assert_ne!(states.starts, other.starts);
}
