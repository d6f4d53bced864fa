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
        let behind = outline.is_open() && b.place == Place::Deep;
        if b.place != Place::DeepAtEnd && !behind {
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
