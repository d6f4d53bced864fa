//! Chains round any number of sprockets, inside and outside of them: starts that close, touch nothing, move together and run; or
//! refusals with numbers.

use crate::common;
use crate::common::layouts::{PITCH, drive_of, sprocket, three_shafts};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rustchain::drive::{AnsiTooth, BeltLine, Drive, Sprocket, SprocketMotion};
use rustchain::geometry::path::belt::Side;
use rustchain::geometry::{Seat, Vec2, turned_left, unit};
use rustchain::layout::{InitialConfiguration, closing_move, links_around};
use rustchain::math::Table;
use rustchain::{Error, ForceLaws, Simulation};
use std::f64::consts::{PI, TAU};

/// Inside sprockets on an ellipse about the origin, and perhaps a reverse idler on one of the strands.
#[derive(Debug, Clone)]
struct Choice {
    inside: Vec<(u32, f64)>,
    size: [f64; 2],
    tilt: f64,
    idler: Option<(usize, u32, f64, f64)>,
    more_links: u32,
    down: f64,
    speed: f64,
    clockwise: bool,
}

fn choices() -> impl Strategy<Value = Choice> {
    let inside = prop::collection::vec((9..=34u32, -0.25..0.25), 3..=5);
    let idler = prop::option::of((0..5usize, 9..=19u32, 0.3..0.7, 0.3..1.2));
    (
        inside,
        [0.32..0.7, 0.28..0.5],
        -PI..PI,
        idler,
        0..2u32,
        -PI..PI,
        -30.0..30.0,
        any::<bool>(),
    )
        .prop_map(
            |(inside, size, tilt, idler, more, down, speed, clockwise)| Choice {
                inside,
                size,
                tilt,
                idler,
                more_links: 2 * more,
                down,
                speed,
                clockwise,
            },
        )
}

impl Choice {
    /// The drive, when its sprockets stand clear of one another and of the strands.
    fn drive(&self) -> Option<Drive> {
        let n = self.inside.len();
        let mut sprockets: Vec<Sprocket> = self
            .inside
            .iter()
            .enumerate()
            .map(|(i, &(teeth, off))| {
                let angle = (i as f64 + off) * TAU / n as f64;
                let at = Vec2::new(self.size[0] * angle.cos(), self.size[1] * angle.sin());
                let (sin, cos) = self.tilt.sin_cos();
                let motion = if i == 0 {
                    SprocketMotion::PrescribedSpeed(self.speed.into())
                } else {
                    SprocketMotion::Free
                };
                sprocket(
                    teeth,
                    cos * at.x - sin * at.y,
                    sin * at.x + cos * at.y,
                    Side::Inside,
                    motion,
                )
            })
            .collect();
        let mut drive = drive_of(sprockets.clone(), 40);
        drive.gravity = 9.81 * unit(self.down);
        if let Some((strand, teeth, share, depth)) = self.idler {
            let line = BeltLine::of(&drive).ok()?;
            let strand = strand % n;
            let span = line.belt.spans[strand];
            let radius = rustchain::geometry::path::wrap::pitch_radius(PITCH, teeth);
            let point = span.from + share * span.length * span.direction;
            let center = point - (radius - depth * 3.0 * PITCH) * turned_left(span.direction);
            let mut idler = sprocket(
                teeth,
                center.x,
                center.y,
                Side::Outside,
                SprocketMotion::Free,
            );
            idler.profile = AnsiTooth {
                seat: Seat::PitchCircle,
                ..AnsiTooth::default()
            }
            .into();
            sprockets.insert(line.strands()[strand][0] + 1, idler);
            drive.sprockets = sprockets;
        }
        if self.clockwise {
            drive.sprockets[1..].reverse();
        }
        BeltLine::of(&drive).ok()?;
        drive.chain.links = links_around(&drive).unwrap() + self.more_links;
        Some(drive)
    }
}

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 200,
        failure_persistence: None,
        max_global_rejects: 10_000,
        // The same cases in every run.
        rng_seed: RngSeed::Fixed(20_100_519),
        ..ProptestConfig::default()
    }
}

/// The two hinges of a link, rear and front, and their velocities, from the body's own motion.
fn ends(start: &InitialConfiguration, link: usize) -> [(Vec2, Vec2); 2] {
    let ([x, y, angle], [vx, vy, spin]) = (start.positions[link], start.velocities[link]);
    [-0.5, 0.5].map(|share| {
        let arm = share * PITCH * unit(angle);
        (
            Vec2::new(x, y) + arm,
            Vec2::new(vx, vy) + spin * turned_left(arm),
        )
    })
}

fn assert_good(drive: &Drive) {
    let (start, layout) = InitialConfiguration::generate(drive).unwrap();
    let n = drive.chain.links as usize;
    assert_eq!(
        layout
            .seated
            .iter()
            .chain(&layout.strand_pitches)
            .sum::<u32>(),
        drive.chain.links
    );
    // Seats outside the pitch circle and a chain that is a hair short open hinges: by a fraction of their clearance.
    let clearance = drive.chain.hinge.clearance();
    assert!(layout.hinge_stretch <= 0.9 * clearance);
    let loose = layout.hinge_stretch + 1e-12;
    let speed = layout.speeds[0].abs() * layout.pitch_radius[0];
    let mut turned = 0.0;
    for k in 0..n {
        let next = (k + 1) % n;
        let [(rear, rear_velocity), _] = ends(&start, next);
        let [_, (front, front_velocity)] = ends(&start, k);
        assert!((front - rear).norm() <= loose, "hinge {}", k + 1);
        // Links cannot grow; those of a nearly straight slack strand between wheels of few teeth would have to.
        let parting = (front_velocity - rear_velocity).norm();
        assert!(
            parting <= 0.03 * speed,
            "hinge {}: {parting} of {speed} m/s",
            k + 1
        );
        let turn = start.positions[next][2] - start.positions[k][2];
        turned += turn - TAU * (turn / TAU).round();
    }
    assert!((turned - TAU).abs() <= 1e-9, "once round, counterclockwise");
    for (i, sprocket) in drive.sprockets.iter().enumerate() {
        let mean = layout.speeds[0] * layout.speed_ratio[i];
        assert!((layout.speeds[i] - mean).abs() <= 1e-14 * mean.abs());
        let turns_back = layout.speed_ratio[i] < 0.0;
        assert_eq!(turns_back, sprocket.side != drive.sprockets[0].side);
        // The seated hinges are where the belt line has the wheel wrapped.
        let gap = TAU / f64::from(sprocket.teeth);
        let seated = f64::from(layout.seated[i]) * gap;
        assert!((seated - layout.belt_wrap[i]).abs() <= 1.05 * gap);
    }
    let mut simulation: Simulation =
        common::simulation(drive, &ForceLaws::default(), common::control(1e-5));
    let present = simulation.present();
    assert!(
        present
            .evaluated
            .hinges
            .penetration
            .iter()
            .all(|&depth| depth < 0.0)
    );
    assert!(
        present
            .evaluated
            .teeth
            .penetration
            .iter()
            .all(|&depth| depth < 0.0)
    );
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_chain_round_many_sprockets_closes_touches_nothing_and_moves_together(choice in choices()) {
        let drive = choice.drive();
        prop_assume!(drive.is_some());
        assert_good(&drive.unwrap());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..config() })]

    #[test]
    fn ten_milliseconds_of_any_layout_run_without_tearing_the_chain(choice in choices()) {
        let drive = choice.drive();
        prop_assume!(drive.is_some());
        let drive = drive.unwrap();
        let mut simulation =
            common::simulation(&drive, &ForceLaws::default(), rustchain::integrator::StepControl::default());
        common::advance(&mut simulation, 0.01);
        let present = simulation.present();
        let deepest = present.evaluated.hinges.penetration.iter().fold(0.0_f64, |a, &b| a.max(b));
        // A millimetre of force law would be meganewtons.
        prop_assert!(deepest < 5e-5, "{deepest}");
        let elastic = present.evaluated.teeth.penetration.iter().fold(0.0_f64, |a, &b| a.max(b));
        prop_assert!(elastic < 5e-5, "{elastic}");
    }
}

#[test]
fn three_shafts_and_an_idler_are_laid_as_listed_or_the_other_way_round() {
    let drive = three_shafts();
    let (start, layout) = InitialConfiguration::generate(&drive).unwrap();
    assert_eq!(layout.order, [0, 1, 2, 3]);
    assert_eq!(layout.strands[3], [3, 0]);
    let mut backward = drive.clone();
    backward.sprockets[1..].reverse();
    let (same, layout) = InitialConfiguration::generate(&backward).unwrap();
    assert_eq!(layout.order, [0, 3, 2, 1]);
    let links = drive.chain.links as usize;
    assert_eq!(start.positions[..links], same.positions[..links]);
}

#[test]
fn a_moved_centre_closes_the_chain_to_rounding() {
    let drive = three_shafts();
    let direction = Vec2::new(1.0, 0.3);
    let mut wide = drive.clone();
    for sprocket in &mut wide.sprockets {
        sprocket.profile = AnsiTooth {
            seat: Seat::PitchCircle,
            ..AnsiTooth::default()
        }
        .into();
    }
    let s = closing_move(&wide, 1, direction, 0.1).unwrap();
    wide.sprockets[1].center += s * direction.normalize();
    let (_, layout) = InitialConfiguration::generate(&wide).unwrap();
    let most = layout.slack.iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
    assert!(most < 1e-11, "{most}");
    assert!(layout.hinge_stretch < 1e-11);
}

#[test]
fn a_centre_is_looked_for_as_far_as_it_may_move_and_no_farther() {
    let drive = three_shafts();
    let direction = Vec2::new(1.0, 0.3);
    let needed = closing_move(&drive, 1, direction, 0.1).unwrap();
    for more in [1e-4, 1e-3] {
        let again = closing_move(&drive, 1, direction, needed.abs() + more).unwrap();
        // Both bisect to rounding, from brackets of different ends.
        assert!((again - needed).abs() < 1e-11, "{again} {needed}");
    }
    for less in [1e-9, 1e-4, 0.9 * needed.abs()] {
        let refused = closing_move(&drive, 1, direction, needed.abs() - less).unwrap_err();
        assert!(
            refused.to_string().contains("no place of sprocket 2"),
            "{refused}"
        );
    }
}

#[test]
fn what_cannot_be_laid_is_refused_with_numbers() {
    let refusal = |drive: &Drive| match InitialConfiguration::generate(drive) {
        Err(Error::Impossible(message)) => message,
        other => panic!("{other:?}"),
    };
    let good = three_shafts();

    let mut crossed = good.clone();
    crossed.sprockets.swap(2, 3);
    assert!(
        refusal(&crossed).contains("1, 2, 4, 3 would do"),
        "{}",
        refusal(&crossed)
    );

    let mut inside = good.clone();
    inside.sprockets[3].side = Side::Inside;
    inside.sprockets[3].center = Vec2::new(0.13, 0.08);
    let message = refusal(&inside);
    assert!(
        message.contains("sprocket 4") && message.contains("outside"),
        "{message}"
    );

    let mut overlapping = good.clone();
    overlapping.sprockets[3].center = Vec2::new(0.03, 0.03);
    assert!(refusal(&overlapping).contains("sprockets 1 and 4 overlap"));

    let mut far = good.clone();
    far.sprockets[3].center = Vec2::new(0.02, 0.19);
    let message = refusal(&far);
    assert!(message.contains("sprocket 4"), "{message}");

    let mut short = good.clone();
    short.chain.links -= 2;
    let message = refusal(&short);
    let enough = format!("take {} links", good.chain.links);
    assert!(
        message.contains("mm too short") && message.contains(&enough),
        "{message}"
    );

    let mut through = good;
    through.sprockets[3].side = Side::Inside;
    through.sprockets[3].center = Vec2::new(0.2, 0.07);
    let message = refusal(&through);
    assert!(message.contains("sprocket 4"), "{message}");
}

#[test]
fn a_torque_curve_turns_a_shaft_at_the_speed_where_motor_and_load_meet() {
    // 4 N m at rest, none at 40 rad/s, against 1 N m through the chain: 30 rad/s.
    let curve = Table::against(
        "curve",
        ("speed", "rad/s"),
        "N m",
        &[(0.0, 4.0), (40.0, 0.0)],
    );
    let mut drive = three_shafts();
    drive.sprockets[0].motion = SprocketMotion::TorqueCurve {
        torque: 0.0.into(),
        curve: curve.unwrap(),
    };
    drive.sprockets[0].initial_speed = Some(28.0);
    drive.sprockets[0].load_inertia = 2e-3;
    drive.sprockets[1].motion = SprocketMotion::AppliedTorque((-25.0 / 17.0).into());
    let mut simulation = common::simulation(
        &drive,
        &ForceLaws::default(),
        rustchain::integrator::StepControl::default(),
    );
    common::advance(&mut simulation, 0.3);
    let spin = simulation.motion().spin[drive.chain.links as usize];
    // Impacts of the chain brake a little, and the polygon effect makes the speed swing.
    assert!((spin - 30.0).abs() < 1.0, "{spin}");
}
