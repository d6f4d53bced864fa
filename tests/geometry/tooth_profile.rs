//! The tooth of ANSI/ASME B29.1: its pieces meet, and an independent collision library finds the same contacts.
//!
//! All lengths are compared in units of the roller diameter, which every coordinate of a gap is a small multiple of.

use std::f64::consts::FRAC_PI_2;

use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query::{Contact, contact};
use parry2d_f64::shape::{Ball, Polyline, Segment, Shape};
use rustchain::geometry::{AnsiCurves, Seat, Surface, ToothContact, ToothProfile, Vec2};

const INCH: f64 = 0.0254;

/// Pitch and roller (or bushing) diameter \[in\] of the standard's chains 25, 35, 41, 40, 50, 60, 80 to 240.
const SIZES: [(f64, f64); 14] = [
    (0.25, 0.130),
    (0.375, 0.200),
    (0.5, 0.306),
    (0.5, 5.0 / 16.0),
    (0.625, 0.400),
    (0.75, 15.0 / 32.0),
    (1.0, 5.0 / 8.0),
    (1.25, 3.0 / 4.0),
    (1.5, 7.0 / 8.0),
    (1.75, 1.0),
    (2.0, 9.0 / 8.0),
    (2.25, 45.0 / 32.0),
    (2.5, 25.0 / 16.0),
    (3.0, 15.0 / 8.0),
];

/// Coordinates of a gap reach twice the roller diameter and go through about ten rounded operations: 10 x 2 eps.
const ROUNDING: f64 = 20.0 * f64::EPSILON;

/// Every size with 9 to 120 teeth.
fn every_profile() -> impl Iterator<Item = Gap> {
    SIZES
        .into_iter()
        .flat_map(|(pitch, roller)| (9..=120).map(move |teeth| Gap::new(pitch, roller, teeth)))
}

/// Every size with a few numbers of teeth, for the slower comparisons.
fn some_profiles() -> impl Iterator<Item = Gap> {
    SIZES.into_iter().flat_map(|(pitch, roller)| {
        [9, 11, 17, 28, 60, 120].map(|teeth| Gap::new(pitch, roller, teeth))
    })
}

/// A profile with its roller diameter and the angles of its normals, written down anew from the standard.
struct Gap {
    profile: ToothProfile,
    roller: f64,
    /// Slope A of the normal where seating and working curve meet \[rad\].
    seat_end: f64,
    /// Slope φ = A - B of the flat's normal \[rad\].
    flat: f64,
}

impl Gap {
    fn new(pitch_inches: f64, roller_inches: f64, teeth: u32) -> Self {
        let n = f64::from(teeth);
        let a = 35.0 + 60.0 / n;
        let b = 18.0 - 56.0 / n;
        let roller = roller_inches * INCH;
        Self {
            profile: ToothProfile::ansi(pitch_inches * INCH, roller, teeth, Seat::BottomDiameter),
            roller,
            seat_end: a.to_radians(),
            flat: (a - b).to_radians(),
        }
    }

    fn curves(&self) -> &AnsiCurves {
        self.profile.ansi_curves().unwrap()
    }

    /// The unit normal into the material that points `slope` \[rad\] below +u.
    fn normal(slope: f64) -> Vec2 {
        Vec2::new(slope.cos(), -slope.sin())
    }

    /// The surface's point with a normal of `slope`; on the flat, which has one normal, `share` of the way along.
    fn point(&self, surface: Surface, slope: f64, share: f64) -> Vec2 {
        let (p, n) = (self.curves(), Self::normal(slope));
        match surface {
            Surface::SEATING => p.seating.center + p.seating.radius * n,
            Surface::WORKING => p.working.center + p.working.radius * n,
            Surface::FLAT => p.flat.start + share * p.flat.length * p.flat.tangent,
            _ => p.topping.center - p.topping.radius * n,
        }
    }

    /// Slope of the topping curve's normal where it meets the outside circle \[rad\].
    fn tip(&self) -> f64 {
        let outline = self.profile.half_outline(2);
        let normal = self.curves().topping.center - outline[outline.len() - 1];
        (-normal.y).atan2(normal.x)
    }

    /// Slopes of the normals from one end of a surface's right half to the other.
    fn slopes(&self, surface: Surface) -> (f64, f64) {
        match surface {
            Surface::SEATING => (FRAC_PI_2, self.seat_end),
            Surface::WORKING => (self.seat_end, self.flat),
            Surface::FLAT => (self.flat, self.flat),
            _ => (self.flat, self.tip()),
        }
    }

    /// Places of a cylinder of `radius` along `surface`, off and in the material: (place, its depth).
    fn places(&self, surface: Surface, radius: f64) -> Vec<(Vec2, f64)> {
        let (from, to) = self.slopes(surface);
        let mut places = Vec::new();
        for share in [0.02, 0.31, 0.5, 0.77, 0.98] {
            let slope = from + share * (to - from);
            for depth in [-0.02, -1e-3, -1e-4, 0.0, 1e-6, 1e-3, 0.02] {
                let depth = depth * self.roller;
                let place =
                    self.point(surface, slope, share) + (depth - radius) * Self::normal(slope);
                // Where the gap is too narrow to be that far from the right flank, the left one is nearer.
                if place.x > 0.0 {
                    places.push((place, depth));
                }
            }
        }
        places
    }
}

fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

#[test]
fn seating_and_working_curve_meet_at_x_in_line_with_both_centres() {
    for gap in every_profile() {
        let close = ROUNDING * gap.roller;
        let x = gap.point(Surface::SEATING, gap.seat_end, 0.0);
        assert!(
            ((x - gap.curves().working.center).norm() - gap.curves().working.radius).abs() <= close
        );
        let (to_center, to_x) = (
            gap.curves().working.center - gap.curves().seating.center,
            x - gap.curves().seating.center,
        );
        assert!(cross(to_center.normalize(), to_x.normalize()).abs() <= ROUNDING);
        assert!(
            to_center.dot(&to_x) < 0.0,
            "the working curve is the flatter one: its centre is beyond a"
        );
        assert!(gap.curves().seat_end_tangent.dot(&to_x.normalize()).abs() <= ROUNDING);
        assert!((gap.curves().seat_end_tangent.norm() - 1.0).abs() <= ROUNDING);
    }
}

#[test]
fn working_curve_flat_and_topping_curve_meet_at_y_and_z_with_one_normal() {
    for gap in every_profile() {
        let close = ROUNDING * gap.roller;
        let (y, z) = (gap.curves().flat.start, gap.curves().flat.end());
        assert!(
            ((y - gap.curves().working.center).norm() - gap.curves().working.radius).abs() <= close
        );
        assert!(
            ((z - gap.curves().topping.center).norm() - gap.curves().topping.radius).abs() <= close
        );
        for radius_line in [
            y - gap.curves().working.center,
            gap.curves().topping.center - z,
        ] {
            assert!(cross(radius_line.normalize(), gap.curves().flat.normal).abs() <= ROUNDING);
            assert!(radius_line.dot(&gap.curves().flat.normal) > 0.0);
        }
        assert!((gap.curves().flat.normal - Gap::normal(gap.flat)).norm() <= ROUNDING);
        assert!(
            gap.curves()
                .flat
                .tangent
                .dot(&gap.curves().flat.normal)
                .abs()
                <= ROUNDING
        );
    }
}

#[test]
fn the_standard_s_length_of_the_flat_is_the_distance_of_y_and_z() {
    for gap in every_profile() {
        let p = &gap.profile;
        let n = f64::from(p.teeth);
        let y = gap.point(Surface::WORKING, gap.flat, 0.0);
        let z = gap.point(Surface::TOPPING, gap.flat, 0.0);
        let sine = |degrees: f64| degrees.to_radians().sin();
        let length = gap.roller * (1.4 * sine(17.0 - 64.0 / n) - 0.8 * sine(18.0 - 56.0 / n));
        assert!(length > 0.0);
        assert!(((z - y).norm() - length).abs() <= ROUNDING * gap.roller);
        assert!((gap.curves().flat.length - length).abs() <= ROUNDING * gap.roller);
    }
}

#[test]
fn a_maker_s_sheet_has_the_same_numbers() {
    // One-inch pitch, 5/8 in rollers, 28 teeth; printed to four places, so half a unit of the fourth and a little.
    let gap = Gap::new(1.0, 0.625, 28);
    let x = gap.point(Surface::SEATING, gap.seat_end, 0.0);
    for (name, metres, inches) in [
        ("R", gap.curves().seating.radius, 0.3156),
        ("M", -gap.curves().working.center.x, 0.3986),
        ("T", gap.curves().working.center.y, 0.3019),
        ("E", gap.curves().working.radius, 0.8156),
        ("chord xy", (gap.curves().flat.start - x).norm(), 0.2270),
        ("yz", gap.curves().flat.length, 0.0844),
        ("W", gap.curves().topping.center.x, 0.8695),
        ("V", -gap.curves().topping.center.y, 0.0980),
        ("F", gap.curves().topping.radius, 0.5114),
    ] {
        assert!(
            (metres / INCH - inches).abs() <= 0.6e-4,
            "{name}: {} in",
            metres / INCH
        );
    }
}

#[test]
fn the_outline_lies_on_the_profile_and_leaves_no_gap() {
    const POINTS: usize = 40;
    for gap in some_profiles() {
        let p = &gap.profile;
        let half = p.half_outline(POINTS);
        for &point in &half[..half.len() - 1] {
            assert!(p.contact(point, 0.0).penetration.abs() <= ROUNDING * gap.roller);
        }
        // The longest piece that may stay straight is the flat; the arcs, a quarter turn at most, are cut into POINTS - 1.
        let arc_piece = FRAC_PI_2 * gap.curves().topping.radius / (POINTS - 1) as f64;
        let longest = gap.curves().flat.length.max(arc_piece) + ROUNDING * gap.roller;
        assert!(
            half.windows(2)
                .all(|pair| (pair[1] - pair[0]).norm() <= longest)
        );
        // Round the sprocket: between two gaps only the land on the outside circle is left.
        let outline = p.outline(POINTS);
        let tip = half[half.len() - 1] + Vec2::new(0.0, p.seat_center_radius);
        let land = 2.0 * (0.5 * p.gap_angle() - tip.x.atan2(tip.y)) * tip.norm();
        assert!(land >= -ROUNDING * p.outside_radius);
        for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
            assert!((b - a).norm() <= longest.max(land) + ROUNDING * p.outside_radius);
        }
    }
}

#[test]
fn the_left_flank_mirrors_the_right_one_bit_for_bit() {
    for gap in every_profile() {
        let radius = 0.5 * gap.roller;
        for surface in Surface::ANSI {
            for (place, _) in gap.places(surface, radius) {
                let right = gap.profile.contact(place, radius);
                let left = gap.profile.contact(Vec2::new(-place.x, place.y), radius);
                assert_eq!(left.penetration, right.penetration);
                assert_eq!(left.normal, Vec2::new(-right.normal.x, right.normal.y));
                assert_eq!(left.region + right.region, 8);
                assert!(surface == Surface::SEATING || (left.region) < 4);
            }
        }
    }
}

#[test]
fn each_place_along_the_profile_belongs_to_its_own_region_with_its_own_depth() {
    for gap in every_profile() {
        for radius in [0.1, 0.35, 0.5].map(|share| share * gap.roller) {
            for (number, surface) in Surface::ANSI.into_iter().enumerate() {
                for (place, depth) in gap.places(surface, radius) {
                    let found = gap.profile.contact(place, radius);
                    assert_eq!(found.surface, surface);
                    assert_eq!(found.region as usize, 4 + number);
                    assert!((found.penetration - depth).abs() <= ROUNDING * gap.roller);
                }
            }
        }
    }
}

#[test]
fn penetration_and_normal_are_continuous_across_the_junctions() {
    for gap in every_profile() {
        let p = &gap.profile;
        let junctions = [
            (Surface::SEATING, Surface::WORKING, gap.seat_end),
            (Surface::WORKING, Surface::FLAT, gap.flat),
            (Surface::FLAT, Surface::TOPPING, gap.flat),
        ];
        for (before, after, slope) in junctions {
            let (normal, tangent) = (Gap::normal(slope), Vec2::new(slope.sin(), slope.cos()));
            let junction = gap.point(before, slope, 1.0);
            for radius in [0.02, 0.1, 0.3, 0.45, 0.5].map(|share| share * gap.roller) {
                for depth in [-0.03, -1e-3, 0.0, 1e-4, 0.01].map(|share| share * gap.roller) {
                    if before == Surface::SEATING && depth <= radius - gap.curves().seating.radius {
                        continue; // the seat is too narrow to be that far from it
                    }
                    let place = junction + (depth - radius) * normal;
                    let one = p.contact_with(before, place, radius);
                    let other = p.contact_with(after, place, radius);
                    assert!((one.penetration - other.penetration).abs() <= ROUNDING * gap.roller);
                    // A rounding error across the line turns the normal by it over the distance to the arc's centre.
                    let lever = [
                        gap.curves().seating.radius - radius + depth,
                        gap.curves().topping.radius + radius - depth,
                    ];
                    let turn = ROUNDING * (1.0 + gap.roller / lever[0].min(lever[1]).abs());
                    assert!(
                        (one.normal - other.normal).norm() <= turn,
                        "{before:?} {after:?}"
                    );
                    // The choice of the surface changes on this very line.
                    let off = 1e-9 * gap.roller * tangent;
                    assert_eq!(p.surface_at(place - off), before);
                    assert_eq!(p.surface_at(place + off), after);
                }
            }
        }
    }
}

#[test]
fn nothing_touches_where_the_nearest_flank_changes_sides() {
    // On the middle line above the seat the normal jumps from one flank to the other; a roller there is clear of both.
    for gap in every_profile() {
        let p = &gap.profile;
        for step in 1..200 {
            let place = Vec2::new(0.0, 0.02 * f64::from(step) * gap.roller);
            assert!(p.contact(place, 0.5 * gap.roller).penetration < 0.0);
        }
    }
}

/// The contact that parry finds between `shape`, placed at `at`, and a ball.
fn by_parry(shape: &dyn Shape, at: Vec2, place: Vec2, radius: f64) -> Contact {
    let pose = |p: Vec2| Pose::translation(p.x, p.y);
    contact(&pose(at), shape, &pose(place), &Ball::new(radius), 1.0)
        .unwrap()
        .unwrap()
}

fn vector(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

/// Asserts that parry's penetration and normal (which points out of the tooth) are those found here.
fn assert_same(found: &ToothContact, penetration: f64, out: Vector, roller: f64, distance: f64) {
    // A few ulps of the coordinates, at most two roller diameters; the normal's error is that over the centres' distance.
    let ulps = 8.0 * f64::EPSILON * 2.0 * roller;
    assert!(
        (found.penetration - penetration).abs() <= ulps,
        "{found:?} against {penetration}"
    );
    let difference = Vec2::new(found.normal.x + out.x, found.normal.y + out.y).norm();
    assert!(
        difference <= ulps / distance + 4.0 * f64::EPSILON,
        "{found:?} against {out:?}"
    );
}

#[test]
fn parry_finds_the_same_contacts_with_the_flat_and_the_topping_curve() {
    for gap in every_profile() {
        let p = &gap.profile;
        let flat = Segment::new(
            vector(gap.curves().flat.start),
            vector(gap.curves().flat.end()),
        );
        let tip = Ball::new(gap.curves().topping.radius);
        for radius in [0.2, 0.5].map(|share| share * gap.roller) {
            for (place, _) in gap.places(Surface::FLAT, radius) {
                let parry = by_parry(&flat, Vec2::zeros(), place, radius);
                let found = p.contact(place, radius);
                assert_same(
                    &found,
                    -parry.dist,
                    parry.normal1,
                    gap.roller,
                    radius + parry.dist,
                );
            }
            for (place, _) in gap.places(Surface::TOPPING, radius) {
                let parry = by_parry(&tip, gap.curves().topping.center, place, radius);
                let found = p.contact(place, radius);
                assert_same(
                    &found,
                    -parry.dist,
                    parry.normal1,
                    gap.roller,
                    gap.curves().topping.radius + radius + parry.dist,
                );
            }
        }
    }
}

#[test]
fn parry_s_distances_from_the_centres_give_the_same_contacts_with_the_concave_curves() {
    // A cylinder inside a bore is as deep as its centre is outside the disc of radius R - r.
    for gap in every_profile() {
        let p = &gap.profile;
        for (surface, arc) in [
            (Surface::SEATING, gap.curves().seating),
            (Surface::WORKING, gap.curves().working),
        ] {
            for radius in [0.2, 0.4].map(|share| share * gap.roller) {
                let within = Ball::new(arc.radius - radius);
                for (place, _) in gap.places(surface, radius) {
                    let parry = by_parry(&within, arc.center, place, 0.0);
                    let found = p.contact(place, radius);
                    // The disc's normal points away from the centre, which is into the tooth.
                    assert_same(
                        &found,
                        parry.dist,
                        -parry.normal1,
                        gap.roller,
                        arc.radius - radius + parry.dist,
                    );
                }
            }
        }
    }
}

#[test]
fn parry_finds_the_same_penetrations_with_a_fine_polyline_of_the_whole_gap() {
    const PIECES: u32 = 300;
    for gap in some_profiles() {
        let p = &gap.profile;
        let mut right = Vec::new();
        // What a chord misses of its arc: r (1 - cos(half step)). It lies inside a bore and inside a tip's disc.
        let mut sagitta = [0.0; 4];
        for surface in [Surface::SEATING, Surface::WORKING, Surface::TOPPING] {
            let (from, to) = gap.slopes(surface);
            let step = (to - from) / f64::from(PIECES);
            let radius = [
                gap.curves().seating.radius,
                gap.curves().working.radius,
                0.0,
                gap.curves().topping.radius,
            ][surface.index()];
            sagitta[surface.index()] = 2.0 * radius * (0.25 * step).sin().powi(2);
            right.extend((0..=PIECES).map(|i| gap.point(surface, from + step * f64::from(i), 0.0)));
        }
        let mirrored = right.iter().rev().map(|q| Vec2::new(-q.x, q.y));
        let outline = Polyline::new(
            mirrored.chain(right.iter().copied()).map(vector).collect(),
            None,
        );
        let [seating, working, _, topping] = sagitta;
        let (concave, convex) = (seating.max(working), topping);
        assert!(
            concave.max(convex) < 1e-5 * gap.roller,
            "fine enough to tell the curves apart"
        );
        let rounding = ROUNDING * gap.roller;
        let radius = 0.5 * gap.roller;
        for surface in Surface::ANSI {
            for (place, _) in gap.places(surface, radius) {
                for side in [1.0, -1.0] {
                    let place = Vec2::new(side * place.x, place.y);
                    let deeper = -by_parry(&outline, Vec2::zeros(), place, radius).dist
                        - p.contact(place, radius).penetration;
                    assert!(
                        (-convex - rounding..=concave + rounding).contains(&deeper),
                        "{surface:?} {deeper:e}"
                    );
                }
            }
        }
    }
}
