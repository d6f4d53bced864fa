//! Forces on a circle along edges, corners, bends and ends of outlines.

use super::*;

fn polyline(points: &[(f64, f64)], closed: bool) -> Vec<Piece> {
    let at = |k: usize| Vec2::new(points[k % points.len()].0, points[k % points.len()].1);
    let count = points.len() - usize::from(!closed);
    (0..count)
        .map(|k| Piece {
            from: at(k),
            to: at(k + 1),
            center: None,
            convex: true,
        })
        .collect()
}

/// Return energy and force of all contact points for the energy δ^2.5/2.5 and the force δ^1.5.
fn sum(outline: &Outline, point: Vec2, radius: f64) -> (f64, Vec2) {
    let (mut energy, mut force) = (0.0, Vec2::zeros());
    outline.contact_points(point, radius, |b| {
        let depth = (radius - b.distance).max(0.0);
        // A circle behind an open outline is not in contact here: it did not come through the surface.
        let behind = outline.is_open() && b.place == OutlinePlace::Deep;
        if b.place != OutlinePlace::DeepAtEnd && !behind {
            let stored = depth.powf(2.5) / 2.5;
            energy += b.weight * stored;
            force += b.weight * depth.powf(1.5) * b.outward - stored * b.weight_gradient;
        }
    });
    (energy, force)
}

/// Path of the circle's centre by a parameter from 0 to 1.
type Way = Box<dyn Fn(f64) -> Vec2>;

/// Return the largest change of the force between small steps along a path, and the largest difference from the energy gradient.
fn roughness(outline: &Outline, radius: f64, way: impl Fn(f64) -> Vec2) -> (f64, f64) {
    let (mut jump, mut wrong) = (0.0f64, 0.0f64);
    let mut before = sum(outline, way(0.0), radius).1;
    let steps = 20_000;
    for k in 1..=steps {
        let point = way(f64::from(k) / f64::from(steps));
        let (_, force) = sum(outline, point, radius);
        jump = jump.max((force - before).norm());
        before = force;
        if k % 100 == 0 {
            let h = 1e-6;
            let at = |x: f64, y: f64| sum(outline, point + Vec2::new(x, y), radius).0;
            let gradient =
                Vec2::new(at(h, 0.0) - at(-h, 0.0), at(0.0, h) - at(0.0, -h)) / (2.0 * h);
            wrong = wrong.max((gradient + force).norm());
        }
    }
    (jump, wrong)
}

#[test]
fn in_a_corner_both_sides_bear() {
    let outline = Outline::new(
        &polyline(
            &[(0.0, 2.0), (0.0, 0.0), (2.0, 0.0)].map(|(x, y)| (y, x)),
            false,
        ),
        false,
        0.5,
    );
    assert_eq!(outline.sides(), 2);
    let (mut sides, point) = (Vec::new(), Vec2::new(0.4, 0.3));
    outline.contact_points(point, 0.5, |b| {
        if b.distance < 0.5 {
            sides.push((b.side, b.distance, b.weight));
        }
    });
    sides.sort_by_key(|s| s.0);
    assert_eq!(sides.len(), 2, "{sides:?}");
    let distances = [sides[0].1, sides[1].1];
    assert!((distances[0] - 0.3).abs() < 1e-15 && (distances[1] - 0.4).abs() < 1e-15);
}

/// A corner rounded by an arc of a radius below that of the circle.
fn tight_arc() -> [Piece; 3] {
    [
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
        Piece {
            from: Vec2::new(-0.05, 0.0),
            to: Vec2::new(-1.05, 1.0),
            center: None,
            convex: true,
        },
    ]
}

#[test]
fn along_edges_corners_bends_and_ends_the_force_does_not_jump_and_is_the_slope_of_the_energy() {
    let bent = [(2.0, 0.02), (0.0, 0.0), (-2.0, 0.03)];
    let tight = tight_arc();
    let along = |from: (f64, f64), to: (f64, f64)| {
        move |s: f64| Vec2::new(from.0 + s * (to.0 - from.0), from.1 + s * (to.1 - from.1))
    };
    let square = polyline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
    let notch = polyline(
        &[
            (-2.0, -1.0),
            (2.0, -1.0),
            (2.0, 1.0),
            (0.3, 0.0),
            (-0.3, 0.0),
            (-2.0, 1.0),
        ],
        true,
    );
    let radius = 0.25;
    let cases: [(&str, &[Piece], bool, Way); 6] = [
        (
            "bent floor",
            &polyline(&bent, false),
            false,
            Box::new(along((-1.0, 0.22), (1.0, 0.21))),
        ),
        (
            "tight arc",
            &tight,
            false,
            Box::new(along((-0.5, 0.6), (0.4, 0.42))),
        ),
        (
            "round a square",
            &square,
            true,
            Box::new(along((-1.4, 1.15), (1.3, 1.24))),
        ),
        (
            "an end",
            &polyline(&[(0.0, 0.0), (-2.0, 0.0)], false),
            false,
            Box::new(|s| {
                let angle = 1.7 - 4.2 * s;
                0.15 * Vec2::new(angle.cos(), angle.sin())
            }),
        ),
        (
            "an end of arcs",
            &tight,
            false,
            Box::new(|s| {
                let angle = 2.2 - 3.2 * s;
                Vec2::new(1.05, 1.0) + 0.2 * Vec2::new(angle.cos(), angle.sin())
            }),
        ),
        (
            "a notch",
            &notch,
            true,
            Box::new(along((-0.9, 0.5), (0.8, 0.3))),
        ),
    ];
    for (name, pieces, closed, way) in cases {
        let outline = Outline::new(pieces, closed, radius);
        let (jump, wrong) = roughness(&outline, radius, way);
        // The steps are 1e-4 long, and forces change by 0.1 over lengths of 0.1.
        assert!(jump < 1e-3, "{name}: a jump of {jump}");
        assert!(wrong < 2e-5, "{name}: {wrong} beside the slope");
    }
}

#[test]
fn a_tight_arc_bears_as_the_corner_that_it_rounds() {
    let corner = Outline::new(
        &polyline(&[(1.0, 1.0), (0.0, 0.0), (-1.0, 1.0)], false),
        false,
        0.3,
    );
    let r = 1e-7;
    let c = r * std::f64::consts::SQRT_2;
    let rounded = [
        (Vec2::new(1.0, 1.0), Vec2::new(0.5 * c, 0.5 * c), None),
        (
            Vec2::new(0.5 * c, 0.5 * c),
            Vec2::new(-0.5 * c, 0.5 * c),
            Some(Vec2::new(0.0, c)),
        ),
        (Vec2::new(-0.5 * c, 0.5 * c), Vec2::new(-1.0, 1.0), None),
    ]
    .map(|(from, to, center)| Piece {
        from,
        to,
        center,
        convex: false,
    });
    let rounded = Outline::new(&rounded, false, 0.3);
    assert_eq!((corner.sides(), rounded.sides()), (2, 2));
    for point in [(0.0, 0.35), (0.05, 0.3), (-0.1, 0.28), (0.01, 0.22)] {
        let point = Vec2::new(point.0, point.1);
        let (sharp, round) = (sum(&corner, point, 0.3).1, sum(&rounded, point, 0.3).1);
        assert!((sharp - round).norm() < 1e-6, "{point}: {sharp} {round}");
        assert!(sharp.y > 0.0);
    }
}

#[test]
fn an_open_row_of_bends_has_a_side_for_each_and_a_convex_one_has_one() {
    let concave = [(2.0, 0.5), (1.0, 0.0), (-1.0, 0.0), (-2.0, 0.5)];
    assert_eq!(
        Outline::new(&polyline(&concave, false), false, 0.1).sides(),
        3
    );
    let convex = concave.map(|(x, y)| (x, -y));
    assert_eq!(
        Outline::new(&polyline(&convex, false), false, 0.1).sides(),
        1
    );
    let heart = [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0), (0.0, 0.5)];
    let outline = Outline::new(&polyline(&heart, true), true, 0.1);
    assert_eq!(outline.sides(), 2);
    assert_ne!(outline.parts[2].side, outline.parts[3].side);
}

#[test]
fn forces_ask_for_near_places_and_get_what_all_give() {
    // The cases are a wheel with notches, the same points clockwise (a hole), and a lens of two arcs.
    let wheel: Vec<(f64, f64)> = (0..24)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 12.0).sin_cos();
            let radius = if k % 2 == 0 { 0.9 } else { 1.2 };
            (radius * cos, radius * sin)
        })
        .collect();
    let hole: Vec<(f64, f64)> = wheel.iter().rev().copied().collect();
    let arc = |from: f64, to: f64| Piece {
        from: Vec2::new(from, 0.0),
        to: Vec2::new(to, 0.0),
        center: Some(Vec2::new(0.0, 0.5 * from)),
        convex: true,
    };
    let outlines = [
        polyline(&wheel, true),
        polyline(&hole, true),
        vec![arc(1.0, -1.0), arc(-1.0, 1.0)],
    ];
    let (mut candidate, mut deep) = (0, 0);
    for pieces in outlines {
        for radius in [0.05, 0.3, 1.5] {
            let outline = Outline::new(&pieces, true, radius);
            for k in 0..4000 {
                let point =
                    2.0 * Vec2::new((0.7 * f64::from(k)).sin(), (0.011 * f64::from(k)).cos());
                let mut all = Vec::new();
                outline.contact_points(point, radius, |b| all.push(*b));
                let mut near = Vec::new();
                outline.contact_points_near(point, radius, |b| near.push(*b));
                let bears = |b: &ContactPoint| b.distance < radius;
                all.retain(bears);
                near.retain(bears);
                assert_eq!(all, near, "{point:?}, {radius}");
                candidate += all.len();
                deep += usize::from(all.iter().any(|b| b.distance < -NEAR * radius));
            }
        }
    }
    assert!(candidate > 10_000 && deep > 1000, "{candidate} {deep}");
}

fn points_of(outline: &Outline, point: Vec2, radius: f64) -> Vec<ContactPoint> {
    let mut found = Vec::new();
    outline.contact_points(point, radius, |b| found.push(*b));
    found
}

/// Return the part of a circle of `radius` about (0, `height`) from one angle to another one \[rad\].
fn arc(height: f64, radius: f64, from: f64, to: f64) -> Piece {
    let center = Vec2::new(0.0, height);
    let at = |angle: f64| center + radius * Vec2::new(angle.cos(), angle.sin());
    Piece {
        from: at(from),
        to: at(to),
        center: Some(center),
        convex: to > from,
    }
}

#[test]
fn distances_weights_and_directions_change_as_their_gradients_say() {
    let outlines: [(Vec<Piece>, bool); 6] = [
        (
            polyline(&[(1.0, 0.3), (0.0, 0.0), (-1.0, 0.7)], false),
            false,
        ),
        (tight_arc().to_vec(), false),
        (vec![arc(0.0, 0.5, 0.0, -3.0)], false),
        (vec![arc(0.0, 0.5, -0.4, 4.0)], false),
        (
            polyline(
                &[
                    (-1.0, -0.5),
                    (1.0, -0.5),
                    (1.0, 0.5),
                    (0.2, 0.1),
                    (-0.3, 0.0),
                    (-1.0, 0.5),
                ],
                true,
            ),
            true,
        ),
        (polyline(&[(0.6, 0.0), (-0.4, 0.1)], false), false),
    ];
    let (radius, h) = (0.6, 1e-6);
    let (mut compared, mut weighted, mut bent) = (0, 0, 0);
    let same = |a: &ContactPoint, b: &ContactPoint| {
        a.piece == b.piece
            && a.side == b.side
            && a.place == b.place
            && (a.weight > 0.0) == (b.weight > 0.0)
    };
    for (pieces, closed) in outlines {
        let outline = Outline::new(&pieces, closed, radius);
        for k in 0..3000 {
            let point = Vec2::new((0.7 * f64::from(k)).sin(), (0.013 * f64::from(k)).cos());
            let here = points_of(&outline, point, radius);
            for axis in [Vec2::x(), Vec2::y()] {
                let [before, after] =
                    [-h, h].map(|x| points_of(&outline, point + x * axis, radius));
                for b in here
                    .iter()
                    .filter(|b| b.distance.is_finite() && b.distance.abs() > 0.05)
                {
                    let alike = |all: &[ContactPoint]| {
                        let found: Vec<_> = all.iter().filter(|c| same(b, c)).copied().collect();
                        (found.len() == 1).then(|| found[0])
                    };
                    // Points that appear, vanish or have a double are left out.
                    let (Some(_), Some(p), Some(q)) = (alike(&here), alike(&before), alike(&after))
                    else {
                        continue;
                    };
                    let change = |p: f64, q: f64| (q - p) / (2.0 * h);
                    // The sign of a corner, and the piece of a merging pair, may change in between.
                    if (q.distance - p.distance).abs() > 3.0 * h
                        || (q.outward - p.outward).norm() > 0.01
                    {
                        continue;
                    }
                    compared += 1;
                    let slope = change(p.distance, q.distance);
                    assert!((slope - b.outward.dot(&axis)).abs() < 1e-7, "{b:?} {point}");
                    let slope = change(p.weight, q.weight);
                    let expected = b.weight_gradient.dot(&axis);
                    // The second difference of a weight is of the order of the square of its gradient.
                    let least = 1e-6 * (1.0 + b.weight_gradient.norm_squared());
                    if b.weight_gradient.norm() < 100.0 {
                        assert!((slope - expected).abs() < least, "{b:?} {slope} {expected}");
                        weighted += usize::from(expected.abs() > 0.1);
                    }
                    let along = turned_left(b.outward);
                    let turned = b.bend * along.dot(&axis) * along;
                    let slope = (q.outward - p.outward) / (2.0 * h);
                    assert!(
                        (slope - turned).norm() < 1e-6,
                        "{b:?} {slope} {turned} {point}"
                    );
                    bent += usize::from(turned.norm() > 0.1);
                }
            }
        }
    }
    assert!(
        compared > 30_000 && weighted > 1000 && bent > 5000,
        "{compared} {weighted} {bent}"
    );
}

#[test]
fn weights_of_a_corner_are_the_shares_of_the_distances_to_its_sides() {
    // Sides at right angles: distances are the coordinates, and the corner is the farthest place between the two feet.
    let corner = Outline::new(
        &polyline(&[(1.0, 0.0), (0.0, 0.0), (0.0, 1.0)], false),
        false,
        0.5,
    );
    for (x, y) in [(0.1, 0.2), (0.3, 0.05), (0.2, 0.2)] {
        let found = points_of(&corner, Vec2::new(x, y), 0.5);
        let far = f64::hypot(x, y);
        let weights: Vec<_> = found.iter().filter(|b| b.weight < 0.0).collect();
        assert_eq!(weights.len(), 2);
        for b in weights {
            assert!((b.distance - far).abs() < 1e-15);
            let (floor, wall) = (far - y, far - x);
            // The piece whose foot merges with the corner takes the whole weight: the floor is piece 0.
            let share = if b.piece == 0 { wall } else { floor } / (floor + wall);
            assert!((b.weight + share).abs() < 1e-14, "{b:?}");
        }
    }
    // In the corner itself both feet and the corner are one point, with the weight of one.
    let found = points_of(&corner, Vec2::zeros(), 0.5);
    let sum: f64 = found.iter().map(|b| b.weight).sum();
    assert_eq!(sum, 1.0);
}

#[test]
fn the_nearest_point_of_a_pointed_outline_has_the_distance_of_all_its_sides() {
    for closed in [
        vec![(0.0, 0.0), (1.0, 0.1), (0.1, 0.4)],
        vec![(0.0, 0.0), (0.3, 0.0), (0.1, 0.9)],
    ] {
        let mut round = closed.clone();
        round.push(closed[0]);
        let outline = Outline::new(&polyline(&closed, true), true, 0.3);
        for k in 0..4000 {
            let point = Vec2::new(
                1.3 * (0.7 * f64::from(k)).sin(),
                1.3 * (0.013 * f64::from(k)).cos(),
            );
            let edges = closed.iter().zip(&round[1..]);
            // Inside of a convex polygon, the point is on the left of all its edges.
            let inside = edges.clone().all(|(a, b)| {
                let (a, b) = (Vec2::new(a.0, a.1), Vec2::new(b.0, b.1));
                (b - a).perp(&(point - a)) > 0.0
            });
            let exact =
                super::super::tests::distance_to(&round, point) * if inside { -1.0 } else { 1.0 };
            let found = points_of(&outline, point, 0.3);
            let found = found.iter().filter(|b| b.weight > 0.0).map(|b| b.distance);
            let nearest = if inside {
                found.fold(f64::NEG_INFINITY, f64::max)
            } else {
                found.fold(f64::INFINITY, f64::min)
            };
            assert!(
                (nearest - exact).abs() < 1e-14,
                "{point}: {nearest} {exact}"
            );
        }
    }
}

#[test]
fn arcs_have_one_part_for_each_quarter_turn_and_are_met_all_round() {
    use std::f64::consts::PI;
    for (turn, parts) in [
        (0.3, 1),
        (0.5 * PI, 1),
        (0.6 * PI, 2),
        (PI, 2),
        (1.5 * PI, 3),
        (1.9 * PI, 4),
    ] {
        for turn in [turn, -turn] {
            let piece = arc(0.3, 0.5, 0.4, 0.4 + turn);
            let outline = Outline::new(&[piece], false, 0.1);
            assert_eq!(outline.parts.len(), parts, "{turn}");
            for k in 1..100 {
                let angle = 0.4 + 0.01 * f64::from(k) * turn;
                // A convex arc is met from outside, a concave one from inside.
                let distance = if turn > 0.0 { 0.57 } else { 0.43 };
                let point = Vec2::new(0.0, 0.3) + distance * Vec2::new(angle.cos(), angle.sin());
                let found = points_of(&outline, point, 0.1);
                let met = found.iter().filter(|b| (b.distance - 0.07).abs() < 1e-14);
                assert_eq!(met.count(), 1, "{turn} {angle}");
            }
        }
    }
}

#[test]
fn sides_are_numbered_along_the_outline_and_one_corner_divides_it_into_halves() {
    let sides = |points: &[(f64, f64)], closed: bool| {
        let outline = Outline::new(&polyline(points, closed), closed, 0.1);
        assert!(outline.is_open() != closed);
        let sides: Vec<usize> = outline.parts.iter().map(|part| part.side).collect();
        assert!(sides.iter().all(|&side| side < outline.sides()));
        sides
    };
    assert_eq!(
        sides(&[(2.0, 0.5), (1.0, 0.0), (-1.0, 0.0), (-2.0, 0.5)], false),
        [0, 1, 2]
    );
    assert_eq!(
        sides(&[(2.0, 0.5), (1.0, 0.0), (-1.0, 0.0), (-2.0, -0.5)], false),
        [0, 1, 1]
    );
    assert_eq!(
        sides(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true),
        [0; 4]
    );
    // Three notches, and one: the re-entrant corners are at odd numbers.
    let star = |inner: usize| -> Vec<(f64, f64)> {
        let at = |k: usize| {
            let radius = if k % 2 == 1 && k < 2 * inner {
                0.3
            } else {
                1.0
            };
            let (sin, cos) = (k as f64 * std::f64::consts::PI / 3.0).sin_cos();
            (radius * cos, radius * sin)
        };
        (0..6).map(at).collect()
    };
    assert_eq!(sides(&star(3), true), [2, 0, 0, 1, 1, 2]);
    for turns in 0..6 {
        let mut one = star(1);
        one.rotate_left(turns);
        let found = sides(&one, true);
        // The part that begins in the corner and the one before it are of different sides, of three parts each.
        let corner = (1 + 6 - turns) % 6;
        assert_ne!(found[corner], found[(corner + 5) % 6]);
        assert_eq!(found.iter().sum::<usize>(), 3);
        for k in 0..3 {
            assert_eq!(found[(corner + k) % 6], found[corner], "{turns} {found:?}");
        }
    }
}

#[test]
fn near_points_are_those_within_two_radii_unless_there_are_none() {
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let comb = [
        (-1.0, -1.0),
        (1.0, -1.0),
        (1.0, 1.0),
        (0.5, 1.0),
        (0.4, 0.0),
        (0.1, 0.0),
        (0.0, 1.0),
        (-0.1, 0.2),
        (-1.0, 1.0),
    ];
    for (points, radius) in [
        (&square[..], 0.05),
        (&square[..], 3.0),
        (&comb[..], 0.05),
        (&comb[..], 0.7),
    ] {
        let outline = Outline::new(&polyline(points, true), true, radius);
        let mut near_alone = 0;
        for k in 0..4000 {
            let point = 2.0 * Vec2::new((0.7 * f64::from(k)).sin(), (0.011 * f64::from(k)).cos());
            let mut near = Vec::new();
            outline.contact_points_near(point, radius, |b| near.push(*b));
            let all = points_of(&outline, point, radius);
            let within = |b: &&ContactPoint| b.distance.abs() <= NEAR * radius;
            if all.iter().any(|b| within(&b)) {
                let of = |points: &[ContactPoint]| {
                    points
                        .iter()
                        .filter(|b| b.place != OutlinePlace::Deep)
                        .copied()
                        .collect::<Vec<_>>()
                };
                let exact: Vec<_> = all.iter().filter(within).copied().collect();
                assert!(near.iter().all(|b| within(&b)), "{point} {radius}");
                assert_eq!(of(&near), of(&exact), "{point} {radius}");
                near_alone += usize::from(all.len() > exact.len());
            } else {
                assert_eq!(near, all);
            }
        }
        assert!(
            points.len() == 4 || radius > 0.5 || near_alone > 50,
            "{near_alone}"
        );
    }
}

#[test]
fn past_either_end_of_a_line_a_circle_is_in_front_or_behind_by_the_side_of_its_centre() {
    let line = Outline::new(&polyline(&[(1.0, 0.0), (-1.0, 0.0)], false), false, 0.1);
    for x in [1.05, -1.05] {
        let places = |y: f64| {
            let found = points_of(&line, Vec2::new(x, y), 0.1);
            let mut places: Vec<_> = found.iter().map(|b| (b.place, b.distance)).collect();
            places.sort_by(|a, b| a.1.total_cmp(&b.1));
            places
        };
        let far = f64::hypot(0.05, 0.02);
        let assert_places = |found: &[(OutlinePlace, f64)], expected: &[(OutlinePlace, f64)]| {
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-15);
            }
        };
        // The other end is no minimum of the distance.
        assert_places(&places(0.02), &[(OutlinePlace::EndFront, far)]);
        assert_places(
            &places(-0.02),
            &[
                (OutlinePlace::DeepAtEnd, -0.02),
                (OutlinePlace::EndBack, far),
            ],
        );
    }
}

#[test]
fn a_bend_below_rounding_has_the_weight_of_one_line() {
    // Both feet and the corner are at the same distance to rounding.
    let bent = Outline::new(
        &polyline(&[(1.0, 1e-9), (0.0, 0.0), (-1.0, 1e-9)], false),
        false,
        0.2,
    );
    let found = points_of(&bent, Vec2::new(0.0, 0.1), 0.2);
    assert_eq!(found.len(), 4);
    assert!(
        found
            .iter()
            .all(|b| b.distance == 0.1 && b.weight_gradient == Vec2::zeros())
    );
    assert_eq!(found.iter().map(|b| b.weight).sum::<f64>(), 1.0);
}
