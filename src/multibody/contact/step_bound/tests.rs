//! Tests of the time in which a circle may reach a profile.

use super::super::contact_states::ContactStates;
use super::super::tests::{
    BALL, BLOCK, Course, accelerations, at_rest, contact, distance_to, floor, frames, mechanism,
    model, only, outline,
};
use super::*;
use crate::geometry::Contact;
use crate::math::testing::random;
use crate::math::{Signal, Table};
use crate::multibody::description::body::Marker;
use crate::multibody::description::driver::PrescribedMotion;
use crate::multibody::description::force_element::{ForceElement, ForceKind};
use crate::multibody::description::joint::{Joint, JointKind};
use crate::multibody::description::profile::Profile;
use crate::multibody::{MechanismDynamics, MechanismModel};
use std::sync::Arc;

/// Return whether circles stay close to their profiles within a time \[s\].
fn stay(model: &MechanismModel, block: &Course, ball: &Course, within: f64) -> bool {
    let all = accelerations(block, ball);
    let of_body = |body| model.accelerations_of(body, &all);
    (model.contact_bodies).stay_close(&frames(block, ball, 0.0), of_body, within)
}

/// Return the positive root t of `speed` t + `acceleration` t²/2 = `way`.
fn time_through(way: f64, speed: f64, acceleration: f64) -> f64 {
    if acceleration == 0.0 {
        return way / speed;
    }
    ((speed * speed + 2.0 * acceleration * way).sqrt() - speed) / acceleration
}

#[test]
fn the_common_bound_is_the_time_in_which_one_motion_covers_a_quarter_of_the_radius() {
    let mut pair = contact(floor(), 0.1);
    pair.b.point = Vec2::new(-0.3, 0.4);
    let model = model(vec![pair]);
    let way = 0.025;
    let body = |velocity: [f64; 3], acceleration: [f64; 3]| [[0.0; 3], velocity, acceleration];
    // The circle is 0.5 m from the centre of mass of its body. The bound for rotations is larger by √2.
    let arm = 0.5 * SQRT_2;
    let of_circle = [
        ([2.0, 0.0, 0.0], [0.0; 3], 2.0, 0.0),
        ([0.0, -3.0, 0.0], [0.0; 3], 3.0, 0.0),
        ([0.0; 3], [-8.0, 0.0, 0.0], 0.0, 8.0),
        ([0.0; 3], [0.0, 5.0, 0.0], 0.0, 5.0),
        ([-0.5, 0.0, 0.0], [0.0, -5.0, 0.0], 0.5, 5.0),
        ([0.0; 3], [0.0, 0.0, -7.0], 0.0, 7.0 * arm),
        // Circular motion: speed ω r and centripetal acceleration ω² r.
        ([0.0, 0.0, -3.0], [0.0; 3], 3.0 * arm, 9.0 * arm),
    ];
    for (velocity, acceleration, speed, faster) in of_circle {
        let ball = body(velocity, acceleration);
        let time = time_through(way, speed, faster);
        assert!(stay(&model, &at_rest(), &ball, 0.999_999 * time));
        assert!(!stay(&model, &at_rest(), &ball, 1.000_001 * time));
    }
    // The ball's centre of mass is 7 m away along the axes, and its circle up to 0.5 m more; the block's is 5 m on the other side.
    let far = SQRT_2 * (5.0 + 7.0 + 0.5);
    let of_profile = [
        ([2.0, 0.0, 0.0], [0.0; 3], 2.0, 0.0),
        ([0.0; 3], [0.0, -5.0, 0.0], 0.0, 5.0),
        ([0.0; 3], [0.0, 0.0, -7.0], 0.0, 7.0 * far),
        ([0.0, 0.0, 0.5], [0.0; 3], 0.5 * far, 0.25 * far),
    ];
    for (velocity, acceleration, speed, faster) in of_profile {
        let block = [[-2.0, 3.0, 0.4], velocity, acceleration];
        let ball = [[3.0, -4.0, 0.0], [0.0; 3], [0.0; 3]];
        let time = time_through(way, speed, faster);
        assert!(stay(&model, &block, &ball, 0.999_999 * time));
        assert!(!stay(&model, &block, &ball, 1.000_001 * time));
    }
    // Opposite motions add up. A way of exactly a quarter of the radius is too long.
    let (block, ball) = (
        body([1.0, 0.0, 0.0], [0.0; 3]),
        body([-3.0, 0.0, 0.0], [0.0; 3]),
    );
    assert!(stay(&model, &block, &ball, 0.999 * way / 4.0));
    assert!(!stay(&model, &block, &ball, 1.001 * way / 4.0));
    let dyadic = super::super::tests::model(vec![contact(floor(), 0.5)]);
    let ball = body([1.0, 0.0, 0.0], [0.0; 3]);
    assert!(!stay(&dyadic, &at_rest(), &ball, 0.125));
}

#[test]
fn the_common_bound_is_that_of_the_smallest_circle_and_of_the_farthest_one() {
    let mut pairs = [0.3, 0.1, 0.2].map(|radius| contact(floor(), radius));
    for (k, pair) in pairs.iter_mut().enumerate() {
        pair.name = format!("contact {k}");
    }
    pairs[1].b.point.x = 0.1;
    pairs[2].b.point.y = -0.5;
    let model = model(pairs.to_vec());
    let ball = [[0.0; 3], [0.0; 3], [0.0, 0.0, 1.0]];
    let time = time_through(0.025, 0.0, 0.5 * SQRT_2);
    assert!(stay(&model, &at_rest(), &ball, 0.999_999 * time));
    assert!(!stay(&model, &at_rest(), &ball, 1.000_001 * time));
}

#[test]
fn no_circle_moves_farther_than_the_common_bound() {
    // Random motions: circles that stay close do not move by more in the frame of the profile, by the motions themselves.
    let mut pair = contact(floor(), 0.1);
    pair.b.point = Vec2::new(0.2, -0.1);
    let model = model(vec![pair]);
    let mut next = random(7);
    let mut tightest: f64 = 0.0;
    for _ in 0..2000 {
        let [block, ball] = [(); 2].map(|()| [(); 3].map(|()| [next(), next(), next()]));
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            *(if stay(&model, &block, &ball, middle) {
                &mut low
            } else {
                &mut high
            }) = middle;
        }
        let local = |t: f64| {
            let all = frames(&block, &ball, t);
            only(&model).local(&all[BLOCK], &all[BALL])
        };
        let moved = (local(low) - local(0.0)).norm();
        // The present motion is continued with constant accelerations; rotation changes it by less than a hundredth in this time.
        assert!(moved < 1.01 * 0.025, "{moved}");
        tightest = tightest.max(moved);
    }
    // Bounds of sums of absolute values exceed norms by up to a factor of 2 here.
    assert!(tightest > 0.012, "{tightest}");
}

#[test]
fn a_circle_reaches_a_disc_when_its_present_motion_has_covered_the_gap() {
    let model = model(vec![contact(Profile::Disc { radius: 0.2 }, 0.1)]);
    let states = ContactStates::new(&model).side_states;
    for (velocity, acceleration) in [
        ([-0.3, -0.4, 0.0], [0.0; 3]),
        ([0.0; 3], [-6.0, 8.0, 0.0]),
        ([0.3, -0.4, 0.0], [-6.0, -8.0, 0.0]),
    ] {
        for gap in [0.03, 0.5] {
            let ball = [
                [0.6 * (0.3 + gap), 0.8 * (0.3 + gap), 0.0],
                velocity,
                acceleration,
            ];
            let all = frames(&at_rest(), &ball, 0.0);
            let found = only(&model).free_time(&all, [[0.0; 3], acceleration], &states, 10.0);
            let norm = |of: [f64; 3]| of[0].hypot(of[1]);
            let exact = time_through(gap, norm(velocity), norm(acceleration));
            assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
        }
    }
}

#[test]
fn a_time_is_infinite_if_the_circle_covers_less_than_a_quarter_radius() {
    let model = model(vec![contact(Profile::Disc { radius: 0.2 }, 0.1)]);
    let states = ContactStates::new(&model).side_states;
    let free = |velocity: [f64; 3], acceleration: [f64; 3], within: f64| {
        let ball = [[0.0, 0.9, 0.0], velocity, acceleration];
        let all = frames(&at_rest(), &ball, 0.0);
        only(&model).free_time(&all, [[0.0; 3], acceleration], &states, within)
    };
    for (velocity, acceleration, speed, faster) in [
        ([2.0, 0.0, 0.0], [0.0; 3], 2.0, 0.0),
        ([-1.0, 3.0, 0.0], [0.0; 3], 4.0, 0.0),
        ([0.0; 3], [3.0, -5.0, 0.0], 0.0, 8.0),
        ([0.5, 0.0, 0.0], [0.0, 5.0, 0.0], 0.5, 5.0),
    ] {
        let within = time_through(0.025, speed, faster);
        assert!(free(velocity, acceleration, 0.999_999 * within).is_infinite());
        assert!(free(velocity, acceleration, 1.000_001 * within).is_finite());
    }
    // Exactly a quarter of the radius is not less.
    let half = super::super::tests::model(vec![contact(Profile::Disc { radius: 0.5 }, 0.5)]);
    let ball = [[0.0, 3.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]];
    let all = frames(&at_rest(), &ball, 0.0);
    let found = only(&half).free_time(&all, [[0.0; 3]; 2], &states, 0.125);
    assert_eq!(found, 2.0);
    // In contact, the circle may move by a quarter of its radius.
    let ball = [[0.0, 0.29, 0.0], [0.0, 2.0, 0.0], [0.0; 3]];
    let mut states = states;
    states[0].contact.penetration = 0.01;
    let all = frames(&at_rest(), &ball, 0.0);
    let found = only(&model).free_time(&all, [[0.0; 3]; 2], &states, 1.0);
    assert!((found - 0.025 / 2.0).abs() < 1e-15, "{found}");
}

#[test]
fn the_gap_to_a_closed_outline_is_that_of_its_nearest_side() {
    let square = outline(
        &[
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, 0.0),
            (0.0, 0.0),
            (0.0, 1.0),
            (-1.0, 1.0),
        ],
        true,
    );
    let model = model(vec![contact(square, 0.1)]);
    let side = |penetration: f64| SideState {
        contact: Contact {
            normal: Vec2::zeros(),
            penetration,
            penetration_rate: 0.0,
        },
        ..SideState::default()
    };
    let gap = |x: f64, y: f64, states: &[SideState]| {
        // The outline is at (3, -2).
        let block = [[3.0, -2.0, 0.0], [0.0; 3], [0.0; 3]];
        let ball = [[3.0 + x, y - 2.0, 0.0], [0.0; 3], [0.0; 3]];
        only(&model).gap(&frames(&block, &ball, 0.0), states)
    };
    let states = [side(-0.3), side(-0.2)];
    // Within the circle that encloses the outline, the sides have the gap; beyond it, that circle.
    assert_eq!(gap(0.4, 0.3, &states), 0.2);
    assert!((gap(3.0, 4.0, &states) - (5.0 - SQRT_2 - 0.1)).abs() < 1e-14);
}

#[test]
fn the_gap_to_an_open_outline_is_the_distance_from_either_side_of_it() {
    let radius = 0.1;
    for points in [
        vec![(1.0, 0.0), (-1.0, 0.0)],
        vec![(1.0, 0.6), (0.1, 0.0), (-1.0, 0.5)],
        vec![(1.0, -0.6), (0.1, 0.0), (-1.0, -0.5)],
    ] {
        let model = model(vec![contact(outline(&points, false), radius)]);
        let states = ContactStates::new(&model).side_states;
        let mut next = random(3);
        for _ in 0..2000 {
            let ball = [[1.5 * next(), next(), 0.0], [0.0; 3], [0.0; 3]];
            let gap = only(&model).gap(&frames(&at_rest(), &ball, 0.0), &states);
            let exact = distance_to(&points, Vec2::new(ball[0][0], ball[0][1])) - radius;
            assert!(
                (gap - exact).abs() < 1e-14,
                "{points:?} {ball:?}: {gap} {exact}"
            );
        }
    }
}

#[test]
fn the_longest_step_ends_at_the_nearest_of_contact_kink_of_a_force_and_kink_of_a_driver() {
    let ramp = |end: f64| {
        Signal::from(Table::new("ramp", "N", &[(0.0, 0.0), (end, 1.0), (2.0 * end, 1.0)]).unwrap())
    };
    for (nearest, force, driver, speed) in [
        ("force", 0.3, 5.0, 0.1),
        ("driver", 5.0, 0.3, 0.1),
        ("contact", 5.0, 4.0, 1.0),
        ("none", 5.0, 4.0, 1e-6),
    ] {
        let mut described = mechanism(vec![contact(Profile::Disc { radius: 0.2 }, 0.1)]);
        described.bodies[1].position = [0.0, 0.8, 0.0];
        described.bodies[1].velocity = [0.0, -speed, 0.0];
        let kind = ForceKind::Force {
            x: ramp(force),
            y: 0.0.into(),
            follows: false,
        };
        let ground = || Marker::new("ground", 0.0, 0.0);
        let block = || Marker::new("block", 0.0, 0.0);
        described.forces = vec![ForceElement::new("push", ground(), block(), kind)];
        described.joints = vec![Joint::new(
            "drive",
            ground(),
            block(),
            JointKind::DrivenAngle(PrescribedMotion::Speed(ramp(driver))),
        )];
        let model = Arc::new(MechanismModel::compile(&described).unwrap());
        let dynamics = MechanismDynamics::new(model);
        let found = dynamics.longest_step_within(0.0, 2.0);
        let expected = match nearest {
            "force" | "driver" => 0.3,
            // 0.5 m at 1 m/s.
            "contact" => 0.5,
            // The contact is not within 2 s: the next kink is that of the driver.
            _ => 4.0,
        };
        assert!((found - expected).abs() < 1e-9, "{nearest}: {found}");
    }
}
