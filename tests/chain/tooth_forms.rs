//! Tooth forms beside the ANSI one: their numbers, joints, nearest surfaces, and what cannot be cut.

use std::f64::consts::PI;

use crate::common::paper_chain;
use crate::common::scenes::Noise;
use rustchain::drive::{
    AnsiTooth, Bearing, Chain, CustomTooth, Faults, IsoTooth, Sprocket, SprocketMotion,
    StraightTooth, Tip, ToothForm,
};
use rustchain::geometry::path::belt::Side;
use rustchain::geometry::{
    Blank, Damage, IsoGap, OutlinePiece, Seat, SurfaceCurve, SurfacePiece, ToothProfile, Vec2,
    iso_tip_diameters, unit,
};

/// Rounding of a coordinate of a gap, a few roller diameters, over about ten operations.
const ROUNDING: f64 = 20.0 * f64::EPSILON;

fn iso(gap: f64, seat: Seat) -> ToothForm {
    ToothForm::Iso(IsoTooth {
        gap,
        seat,
        roller_diameter: None,
        tip_diameter: None,
        edge_radius: None,
    })
}

fn straight(flank_angle: f64) -> ToothForm {
    ToothForm::Straight(StraightTooth {
        flank_angle,
        seat_radius: None,
        seat: Seat::BottomDiameter,
        roller_diameter: None,
        tip_diameter: None,
        edge_radius: None,
    })
}

fn cut_ansi() -> ToothForm {
    ToothForm::Ansi(AnsiTooth {
        tip: Tip::Cut,
        ..AnsiTooth::default()
    })
}

fn sprocket(form: ToothForm, teeth: u32, damage: Vec<Damage>) -> Sprocket {
    Sprocket {
        teeth,
        center: Vec2::zeros(),
        motion: SprocketMotion::Free,
        profile: form,
        mass: None,
        inertia: None,
        initial_speed: None,
        bearing: Bearing::Fixed,
        side: Side::Inside,
        load_inertia: 0.0,
        faults: Faults {
            damage,
            ..Faults::default()
        },
    }
}

fn profile(form: ToothForm, teeth: u32) -> ToothProfile {
    sprocket(form, teeth, Vec::new())
        .tooth_profile(&paper_chain())
        .unwrap()
}

/// All forms with few and many teeth.
fn profiles() -> Vec<ToothProfile> {
    let mut all = Vec::new();
    for teeth in [9, 10, 13, 17, 25, 60, 150] {
        for gap in [0.0, 0.25, 0.5, 1.0] {
            all.push(profile(iso(gap, Seat::BottomDiameter), teeth));
            all.push(profile(iso(gap, Seat::PitchCircle), teeth));
        }
        all.push(profile(cut_ansi(), teeth));
        all.push(profile(straight(0.45), teeth));
    }
    all
}

fn distance_from(piece: &SurfacePiece, point: Vec2) -> f64 {
    piece.curve.depth(point, 0.0).0.abs()
}

#[test]
fn pieces_meet_with_one_tangent_and_end_in_the_middle_of_the_tooth() {
    let chain = paper_chain();
    let size = 2.0 * chain.bushing_radius;
    for profile in profiles() {
        let pieces = profile.whole();
        for pair in pieces.windows(2) {
            let joint = pair[0].end;
            assert_eq!(joint, pair[1].start);
            for piece in pair {
                assert!(distance_from(piece, joint) <= ROUNDING * profile.outside_radius);
            }
            let [before, after] = [0, 1].map(|i| pair[i].curve.tangent(joint));
            // A tangent is off by the rounding of a point over the radius, the edge's at least.
            let off = ROUNDING * profile.outside_radius / (0.025 * size);
            assert!((before - after).norm() <= off, "{} teeth", profile.teeth);
        }
        let first = pieces[0];
        assert!(first.start.x == 0.0 && first.curve.tangent(first.start).y.abs() <= ROUNDING);
        let tip = pieces[pieces.len() - 1].end - profile.center();
        assert!((tip.norm() / profile.outside_radius - 1.0).abs() <= ROUNDING);
        let middle = unit(PI / 2.0 - 0.5 * profile.gap_angle());
        assert!(tip.perp(&middle).abs() <= ROUNDING * tip.norm());
    }
}

/// Against the standard's own construction: the seat ends at half the seating angle, the flank's centre lies on the line from
/// the seat's centre through there.
#[test]
fn an_iso_flank_begins_where_the_standard_has_it() {
    let d1 = 7.92e-3;
    for teeth in 9..=150 {
        for share in [0.0, 0.5, 1.0] {
            let z = f64::from(teeth);
            let alpha = (140.0 - 90.0 / z - 20.0 * share).to_radians();
            let ri = 0.505 * d1 + share * 0.069e-3 * 7.92_f64.cbrt();
            let (least, most) = (0.12 * d1 * (z + 2.0), 0.008 * d1 * (z * z + 180.0));
            let re = least + share * (most - least);
            let [low, high] = iso_tip_diameters(12.7e-3, d1, teeth);
            let blank = Blank {
                pitch: 12.7e-3,
                roller_diameter: d1,
                teeth,
                seat: Seat::BottomDiameter,
                outside_radius: 0.5 * low.min(high),
                edge_radius: 2e-4,
            };
            let profile = ToothProfile::iso(&blank, &IsoGap::new(d1, teeth, share)).unwrap();
            let [seat, flank, ..] = profile.whole() else {
                panic!()
            };
            let (sin, cos) = (0.5 * alpha).sin_cos();
            let end = Vec2::new(ri * sin, -ri * cos);
            assert!((seat.end - end).norm() <= ROUNDING * d1);
            let SurfaceCurve::Convex(arc) = flank.curve else {
                panic!()
            };
            let center = Vec2::new((ri + re) * sin, -(ri + re) * cos);
            assert!((arc.center - center).norm() <= ROUNDING * re);
            assert!((arc.radius - re).abs() <= ROUNDING * re);
        }
    }
}

#[test]
fn a_seated_roller_just_touches_or_has_the_seat_s_play() {
    let radius = paper_chain().bushing_radius;
    for teeth in [9, 17, 40, 150] {
        for share in [0.0, 0.6, 1.0] {
            let play = IsoGap::new(2.0 * radius, teeth, share).seat_radius - radius;
            for (seat, depth) in [(Seat::BottomDiameter, 0.0), (Seat::PitchCircle, -play)] {
                let profile = profile(iso(share, seat), teeth);
                let seated = profile.center() + Vec2::new(0.0, profile.pitch_radius);
                let found = profile.contact(seated, radius);
                assert!((found.penetration - depth).abs() <= ROUNDING * profile.pitch_radius);
            }
        }
    }
}

/// Largest depth of a cylinder, found from points on the outline alone; what lies between two of them is left out.
fn depth_by_points(outline: &[Vec2], place: Vec2, radius: f64) -> f64 {
    let nearest = outline.iter().map(|p| (p - place).norm());
    radius - nearest.fold(f64::INFINITY, f64::min)
}

/// In the sprocket's frame, with the gap found by the angle.
fn depth_on(profile: &ToothProfile, place: Vec2, radius: f64) -> (f64, Vec2, u8) {
    let gap = profile.nearest_gap(place.y.atan2(place.x));
    let v = unit(f64::from(gap) * profile.gap_angle());
    let u = Vec2::new(v.y, -v.x);
    let in_gap = Vec2::new(place.dot(&u), place.dot(&v) - profile.seat_center_radius);
    let found = profile.contact_in(gap, in_gap, radius);
    let normal = found.normal.x * u + found.normal.y * v;
    (found.penetration, normal, found.region)
}

#[test]
fn the_surface_found_is_the_nearest_one_damaged_teeth_too() {
    let chain = paper_chain();
    let radius = chain.bushing_radius;
    let mut noise = Noise(3);
    for (form, teeth) in [
        (iso(0.0, Seat::BottomDiameter), 11),
        (iso(1.0, Seat::BottomDiameter), 30),
        (cut_ansi(), 17),
        (straight(0.4), 14),
    ] {
        let damage = [(0, 0.0), (1, 0.3), (4, 0.8), (teeth - 1, 0.05)]
            .map(|(tooth, height)| Damage { tooth, height });
        for damage in [Vec::new(), damage.to_vec()] {
            let profile = sprocket(form.clone(), teeth, damage)
                .tooth_profile(&chain)
                .unwrap();
            let points = 60;
            let corners = profile.outline(points);
            let next = corners.iter().cycle().skip(1);
            let outline: Vec<Vec2> = corners
                .iter()
                .zip(next)
                .flat_map(|(a, b)| {
                    // Straight lines have their two ends only.
                    let parts = ((b - a).norm() / 1e-4).ceil().max(1.0);
                    (0..100)
                        .map(f64::from)
                        .take_while(move |&i| i < parts)
                        .map(move |i| a + i / parts * (b - a))
                })
                .collect();
            let mut touching = 0;
            for _ in 0..250 {
                let bottom = profile.pitch_radius - 0.2e-3;
                let reach = profile.reach(radius);
                let distance = bottom + (reach - bottom) * noise.share();
                let place = distance * unit(PI * noise.sign());
                let seen = depth_by_points(&outline, place, radius);
                let (depth, normal, _) = depth_on(&profile, place, radius);
                if !(-1e-3..=0.5e-3).contains(&depth) {
                    // Deep inside a tooth, or far from all: which surface is named there is of no consequence.
                    assert_eq!(depth > 0.0, seen > 0.0);
                    continue;
                }
                touching += 1;
                // Points are up to a twentieth of a millimetre apart: at the least distance from a bushing of 4 mm that is a few
                // micrometres; across it, the direction is good to the hundredth.
                assert!(depth >= seen - 1e-9, "{depth:e} {seen:e} at {place:?}");
                assert!(depth <= seen + 5e-6, "{depth:e} {seen:e} at {place:?}");
                let foot = place + (radius - depth) * normal;
                let off = outline.iter().map(|p| (p - foot).norm());
                assert!(off.fold(f64::INFINITY, f64::min) < 1e-4);
            }
            assert!(touching > 20, "{touching}");
        }
    }
}

#[test]
fn a_missing_tooth_leaves_the_bottom_and_a_stump_its_share_of_the_height() {
    let chain = paper_chain();
    let damage = [(2, 0.0), (5, 0.25)].map(|(tooth, height)| Damage { tooth, height });
    let form = iso(0.0, Seat::BottomDiameter);
    let profile = sprocket(form, 17, damage.to_vec())
        .tooth_profile(&chain)
        .unwrap();
    let bottom = profile.seat_center_radius - 0.505 * 2.0 * chain.bushing_radius;
    for (tooth, height) in [(2.0, 0.0), (5.0, 0.25), (3.0, 1.0)] {
        let top = bottom + height * (profile.outside_radius - bottom);
        let middle = unit((tooth + 0.5) * profile.gap_angle());
        for beside in [-1e-9, 1e-9] {
            let place = (top + chain.bushing_radius) * unit(middle.y.atan2(middle.x) + beside);
            let (depth, ..) = depth_on(&profile, place, chain.bushing_radius);
            assert!(depth.abs() < 1e-12, "{depth:e}");
        }
    }
}

#[test]
fn every_ansi_size_keeps_a_land_at_its_tip() {
    for share in [0.52, 0.612, 0.625, 0.64] {
        for teeth in 5..=120 {
            let full = ToothProfile::ansi(12.7e-3, share * 12.7e-3, teeth, Seat::BottomDiameter);
            let outside = full.outside_radius;
            assert!(full.cut(outside, 1e-4).is_ok(), "{share} {teeth}");
        }
    }
}

#[test]
fn a_cut_tooth_is_the_full_one_up_to_its_edge() {
    let radius = paper_chain().bushing_radius;
    for teeth in [9, 17, 60] {
        let full = profile(AnsiTooth::default().into(), teeth);
        let cut = profile(cut_ansi(), teeth);
        let edge = cut.whole()[4].start;
        let mut noise = Noise(u64::from(teeth));
        let mut both = 0;
        for _ in 0..2000 {
            let place = Vec2::new(8e-3 * noise.sign(), 8e-3 * noise.sign());
            let on = cut.surface_at(place);
            if on.index() >= 4 {
                continue;
            }
            both += 1;
            let (one, other) = (cut.contact(place, radius), full.contact(place, radius));
            assert_eq!(one.penetration, other.penetration);
            assert_eq!(one.normal, other.normal);
        }
        assert!(both > 500);
        // Its edge ends at the outside circle, a broken edge's radius within it.
        assert!((edge - cut.center()).norm() < cut.outside_radius);
    }
}

#[test]
fn a_pointed_tooth_is_refused_with_the_diameter_at_which_it_ends() {
    let chain = paper_chain();
    let [_, largest] = iso_tip_diameters(chain.pitch, 2.0 * chain.bushing_radius, 17);
    let pointed = ToothForm::Iso(IsoTooth {
        gap: 1.0,
        seat: Seat::BottomDiameter,
        roller_diameter: None,
        tip_diameter: Some(largest),
        edge_radius: None,
    });
    let refused = sprocket(pointed, 17, Vec::new())
        .tooth_profile(&chain)
        .unwrap_err();
    let message = refused.to_string();
    assert!(
        message.contains("IsoTooth.tip_diameter") && message.contains("pointed"),
        "{message}"
    );
    assert!(message.contains("meet at a diameter of 0.07"), "{message}");
}

#[test]
fn a_bushing_that_cannot_roll_along_the_gap_is_refused() {
    let narrow = Chain {
        bushing_radius: 4.1e-3,
        ..paper_chain()
    };
    let tooth = ToothForm::Custom(custom(17, 0.0));
    let refused = sprocket(tooth, 17, Vec::new())
        .tooth_profile(&narrow)
        .unwrap_err();
    assert!(
        refused.to_string().contains("room for the bushing"),
        "{refused}"
    );
}

/// An ISO tooth of the paper's chain as a user would draw it, its flank moved up by `gap` \[m\].
fn custom(teeth: u32, gap: f64) -> CustomTooth {
    let chain = paper_chain();
    let profile = profile(iso(0.0, Seat::BottomDiameter), teeth);
    let [seat, flank, edge, _] = profile.whole() else {
        panic!()
    };
    let up = Vec2::new(0.0, profile.seat_center_radius);
    let center = |piece: &SurfacePiece| match piece.curve {
        SurfaceCurve::Concave(arc) | SurfaceCurve::Convex(arc) => arc.center,
        SurfaceCurve::Straight(_) => panic!(),
    };
    let lift = Vec2::new(0.0, gap);
    CustomTooth {
        pieces: vec![
            OutlinePiece {
                start: seat.start + up,
                end: seat.end + up,
                center: Some(center(seat) + up),
            },
            OutlinePiece {
                start: flank.start + up + lift,
                end: edge.end + up + lift,
                center: None,
            },
        ]
        .into_iter()
        .take(1)
        .chain([OutlinePiece {
            start: flank.start + up + lift,
            // Past the edge, which the cut makes anew.
            end: up + lift + center(flank) + {
                let SurfaceCurve::Convex(arc) = flank.curve else {
                    panic!()
                };
                arc.radius * (edge.end - center(flank)).normalize()
            },
            center: Some(center(flank) + up + lift),
        }])
        .collect(),
        tip_diameter: Some(2.0 * profile.outside_radius),
        edge_radius: Some(0.025 * 2.0 * chain.bushing_radius),
    }
}

#[test]
fn a_tooth_drawn_piece_by_piece_is_the_one_by_name() {
    let chain = paper_chain();
    for teeth in [9, 17, 45] {
        let drawn = profile(ToothForm::Custom(custom(teeth, 0.0)), teeth);
        let named = profile(iso(0.0, Seat::BottomDiameter), teeth);
        assert_eq!(drawn.whole().len(), named.whole().len());
        let mut noise = Noise(9);
        for _ in 0..250 {
            let place = Vec2::new(6e-3 * noise.sign(), 4e-3 * noise.sign());
            let [a, b] = [&drawn, &named].map(|p| p.contact(place, chain.bushing_radius));
            assert_eq!(a.region, b.region);
            assert!((a.penetration - b.penetration).abs() < 1e-15);
            assert!((a.normal - b.normal).norm() < 1e-11);
        }
    }
}

#[test]
fn a_joint_that_does_not_fit_is_named_with_its_gap_or_angle() {
    let chain = paper_chain();
    let refused = |tooth: CustomTooth| {
        sprocket(ToothForm::Custom(tooth), 17, Vec::new())
            .tooth_profile(&chain)
            .unwrap_err()
            .to_string()
    };
    let apart = refused(custom(17, 1e-5));
    assert!(
        apart.contains("pieces.1 and .2") && apart.contains("1.000e-5 m"),
        "{apart}"
    );
    let mut turned = custom(17, 0.0);
    let line = OutlinePiece {
        start: turned.pieces[0].end,
        end: turned.pieces[0].end + 4e-3 * unit(1.0),
        center: None,
    };
    turned.pieces[1] = line;
    let corner = refused(turned);
    // The seat ends at a slope of alpha/2 = 67.35 degrees, the line rises at 57.30.
    assert!(
        corner.contains("turn of -10.0") && corner.contains("tangent"),
        "{corner}"
    );
    let mut open = custom(17, 0.0);
    open.tip_diameter = None;
    assert!(refused(open).contains("middle of the tooth"));
    let mut beside = custom(17, 0.0);
    beside.pieces[0].start.x += 1e-4;
    assert!(refused(beside).contains("u = 1.000e-4 m"));
    let none = CustomTooth {
        pieces: Vec::new(),
        ..custom(17, 0.0)
    };
    assert!(refused(none).contains("at least one piece"));
}

#[test]
fn teeth_out_of_a_form_s_range_are_refused() {
    for (form, teeth) in [
        (iso(0.0, Seat::BottomDiameter), 8),
        (iso(0.0, Seat::BottomDiameter), 151),
        (cut_ansi(), 4),
    ] {
        let refused = sprocket(form, teeth, Vec::new()).validate().unwrap_err();
        assert!(refused.to_string().contains("Sprocket.teeth"), "{refused}");
    }
}
