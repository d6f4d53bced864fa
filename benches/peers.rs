//! Single contacts beside those of parry2d: the same circles against circle, segment and arc, results compared, ns a contact.
//!
//! Depths only, one contact after the other. The vector kernels have no such query; their whole right-hand side, with forces and
//! accelerations, is given per pair that it looks at.

#![allow(clippy::print_stdout)] // a benchmark's figures
#![allow(clippy::unwrap_used)] // a benchmark whose inputs cannot be built has nothing to say

mod common;

use std::hint::black_box;

use common::{Effort, Halves, laws, longer_drive, pressed_into_seats, race};
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query::contact;
use parry2d_f64::query::details::{contact_ball_ball, contact_convex_polyhedron_ball};
use parry2d_f64::shape::{Ball, Polyline, Segment};
use rustchain::force_law::{Damping, Elastic};
use rustchain::geometry::{Vec2, unit};
use rustchain::integrator::OdeSystem;

/// Places of a circle, along each shape.
const PLACES: usize = 64;

/// Chords that stand for an arc, which parry has no shape for.
const CHORDS: u32 = 64;

/// Distance up to which parry is to answer \[m\]; ours always does.
const PREDICTION: f64 = 1e-4;

fn main() {
    let elastic = (Elastic::Hertz, Damping::LankaraniNikravesh);
    let model = common::at_start(elastic.0, elastic.1).model().clone();
    let profile = &model.sprockets[0].profile;
    let radius = model.teeth.contact_radius;
    let ball = Ball::new(radius);

    let share = |i: usize| (i as f64 + 0.5) / PLACES as f64;
    // From 1 um deep to 1 um apart.
    let depth = |i: usize| 1e-6 * (1.0 - 2.0 * ((7 * i) % PLACES) as f64 / PLACES as f64);

    let curves = profile.ansi_curves().unwrap();
    let topping = curves.topping;
    let tip = Ball::new(topping.radius);
    let round_the_tip =
        |i: usize| topping.center + (topping.radius + radius - depth(i)) * unit(6.0 * share(i));
    let flat = curves.flat;
    let segment = Segment::new(vector(flat.start), vector(flat.end()));
    let along_the_flat = |i: usize| {
        flat.start + share(i) * flat.length * flat.tangent - (radius - depth(i)) * flat.normal
    };
    let seating = curves.seating;
    let [from, to] = [-2.6, -0.5];
    let chords = (0..=CHORDS)
        .map(|i| {
            let angle = from + f64::from(i) / f64::from(CHORDS) * (to - from);
            vector(seating.point(unit(angle)))
        })
        .collect();
    let polyline = Polyline::new(chords, None);
    let in_the_seat = |i: usize| {
        let angle = from + (0.1 + 0.8 * share(i)) * (to - from);
        seating.center + (seating.radius - radius + depth(i)) * unit(angle)
    };

    println!(
        "{:<36}{:>8}{:>9}{:>8}  largest difference",
        "ns a contact", "ours", "parry2d", "ratio"
    );
    compare(
        "circle on circle",
        round_the_tip,
        |place| topping.depth_outside(place, radius).0,
        |place| {
            let apart = Pose::from_translation(vector(place - topping.center));
            let found = contact_ball_ball(&apart, &tip, &ball, PREDICTION);
            -found.unwrap().dist
        },
    );
    compare(
        "circle on segment",
        along_the_flat,
        |place| flat.depth(place, radius).0,
        |place| {
            let at = Pose::from_translation(vector(place));
            let found = contact_convex_polyhedron_ball(&at, &segment, &ball, PREDICTION);
            -found.unwrap().dist
        },
    );
    compare(
        "circle in arc (parry: 64 chords)",
        in_the_seat,
        |place| seating.depth_inside(place, radius).0,
        |place| {
            let at = Pose::from_translation(vector(place));
            let found = contact(&Pose::IDENTITY, &polyline, &at, &ball, PREDICTION);
            -found.unwrap().unwrap().dist
        },
    );

    println!(
        "\n{:<36}{:>8}{:>8}",
        "ns a pair, with force and load", "vector", "pairs"
    );
    for links in [38, 2432] {
        let [kernels, pairs] = right_hand_side(links, elastic);
        println!(
            "{:<36}{kernels:>8.2}{pairs:>8.0}",
            format!("right-hand side, {links} links")
        );
    }
}

fn vector(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

/// Prints the times of our depth and of parry's over the same places, and by how much they differ.
fn compare(
    name: &str,
    place: impl Fn(usize) -> Vec2,
    ours: impl Fn(Vec2) -> f64,
    parry: impl Fn(Vec2) -> f64,
) {
    let places: Vec<Vec2> = (0..PLACES).map(place).collect();
    let difference = |&place: &Vec2| (ours(place) - parry(place)).abs();
    let largest = places.iter().map(difference).fold(0.0, f64::max);
    let effort = Effort {
        batches: 2000,
        calls: 10,
    };
    let mut ours_found = [0.0; PLACES];
    let mut parry_found = [0.0; PLACES];
    let least = race(
        effort.or_once(),
        &mut [
            Box::new(|| walk(&places, &ours, &mut ours_found)),
            Box::new(|| walk(&places, &parry, &mut parry_found)),
        ],
    );
    let [ours, parry] = [0, 1].map(|i| least[i] / PLACES as f64);
    println!(
        "{name:<36}{ours:>8.2}{parry:>9.2}{:>8.1}  {largest:.1e} m",
        parry / ours
    );
}

fn walk(places: &[Vec2], depth: impl Fn(Vec2) -> f64, found: &mut [f64; PLACES]) {
    for (&place, found) in black_box(places).iter().zip(black_box(found)) {
        *found = depth(place);
    }
}

/// ns a pair of the vector kernels, and the number of pairs, hinges and candidates, all hinges pressed.
fn right_hand_side(links: u32, (elastic, damping): (Elastic, Damping)) -> [f64; 2] {
    let drive = longer_drive([17, 17], links);
    let mut simulation = pressed_into_seats(&drive, &laws(elastic, damping));
    let Halves {
        mut dynamics,
        adams,
    } = Halves::of(&mut simulation);
    let (t, y) = (adams.time(), adams.y().to_vec());
    let mut dydt = y.clone();
    dynamics.derivative(t, &y, &mut dydt);
    let pairs = (dynamics.model().links + dynamics.candidates().count()) as f64;
    let effort = Effort {
        batches: 300,
        calls: 20_000 / links as usize,
    };
    let least = race(
        effort.or_once(),
        &mut [Box::new(|| {
            dynamics.derivative(black_box(t), black_box(&y), &mut dydt);
        })],
    );
    [least[0] / pairs, pairs]
}
