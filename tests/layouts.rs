//! Chains round any number of sprockets, inside and outside of them: starts that close, touch nothing, move together and run; or
//! refusals with numbers.

#![allow(clippy::unwrap_used)]

mod common;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rustchain::drive::{
    AnsiTooth, Bearing, BeltLine, Drive, Motion, Sprocket, Tensioner, TimeTable,
};
use rustchain::geometry::belt::Side;
use rustchain::geometry::{Seat, Vec2, turned_left, unit};
use rustchain::state::{Start, closing_move, links_around};
use rustchain::{Equilibrium, Error, ForceLaws, Groups, Model, Simulation};

const PITCH: f64 = 0.0127;

fn sprocket(teeth: u32, x: f64, y: f64, side: Side, motion: Motion) -> Sprocket {
    Sprocket {
        teeth,
        center: Vec2::new(x, y),
        motion,
        profile: AnsiTooth {
            seat: Seat::BottomDiameter,
            roller_diameter: None,
        },
        mass: None,
        inertia: None,
        initial_speed: None,
        bearing: Bearing::Fixed,
        side,
        load_inertia: 0.0,
    }
}

fn drive_of(sprockets: Vec<Sprocket>, links: u32) -> Drive {
    let mut chain = common::paper_chain();
    chain.links = links;
    Drive {
        chain,
        sprockets,
        tensioner: None,
        gravity: Vec2::new(0.0, -9.81),
    }
}

/// A driver, two shafts and a reverse idler on the upper strand.
fn three_shafts() -> Drive {
    let mut drive = drive_of(
        vec![
            sprocket(
                17,
                0.0,
                0.0,
                Side::Inside,
                Motion::PrescribedSpeed(20.0.into()),
            ),
            sprocket(25, 0.35, -0.05, Side::Inside, Motion::Free),
            sprocket(21, 0.25, 0.22, Side::Inside, Motion::Free),
            sprocket(13, 0.092, 0.107, Side::Outside, Motion::Free),
        ],
        100,
    );
    drive.chain.links = links_around(&drive).unwrap();
    drive
}

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
                    Motion::PrescribedSpeed(self.speed.into())
                } else {
                    Motion::Free
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
            let radius = rustchain::geometry::wrap::pitch_radius(PITCH, teeth);
            let point = span.from + share * span.length * span.direction;
            let center = point - (radius - depth * 3.0 * PITCH) * turned_left(span.direction);
            let mut idler = sprocket(teeth, center.x, center.y, Side::Outside, Motion::Free);
            idler.profile.seat = Seat::PitchCircle;
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
fn ends(start: &Start, link: usize) -> [(Vec2, Vec2); 2] {
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
    let (start, layout) = Start::generate(drive).unwrap();
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
    assert!(present.hinges.penetration.iter().all(|&depth| depth < 0.0));
    assert!(present.teeth.penetration.iter().all(|&depth| depth < 0.0));
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
        let deepest = present.hinges.penetration.iter().fold(0.0_f64, |a, &b| a.max(b));
        // A millimetre of force law would be meganewtons.
        prop_assert!(deepest < 5e-5, "{deepest}");
        let elastic = present.teeth.penetration.iter().fold(0.0_f64, |a, &b| a.max(b));
        prop_assert!(elastic < 5e-5, "{elastic}");
    }
}

#[test]
fn three_shafts_and_an_idler_are_laid_as_listed_or_the_other_way_round() {
    let drive = three_shafts();
    let (start, layout) = Start::generate(&drive).unwrap();
    assert_eq!(layout.order, [0, 1, 2, 3]);
    assert_eq!(layout.strands[3], [3, 0]);
    let mut backward = drive.clone();
    backward.sprockets[1..].reverse();
    let (same, layout) = Start::generate(&backward).unwrap();
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
        sprocket.profile.seat = Seat::PitchCircle;
    }
    let s = closing_move(&wide, 1, direction, 0.1).unwrap();
    wide.sprockets[1].center += s * direction.normalize();
    let (_, layout) = Start::generate(&wide).unwrap();
    let most = layout.slack.iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
    assert!(most < 1e-11, "{most}");
    assert!(layout.hinge_stretch < 1e-11);
}

#[test]
fn what_cannot_be_laid_is_refused_with_numbers() {
    let refusal = |drive: &Drive| match Start::generate(drive) {
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
    let curve = TimeTable::against(
        "curve",
        ("speed", "rad/s"),
        "N m",
        &[(0.0, 4.0), (40.0, 0.0)],
    );
    let mut drive = three_shafts();
    drive.sprockets[0].motion = Motion::TorqueCurve {
        torque: 0.0.into(),
        curve: curve.unwrap(),
    };
    drive.sprockets[0].initial_speed = Some(28.0);
    drive.sprockets[0].load_inertia = 2e-3;
    drive.sprockets[1].motion = Motion::AppliedTorque((-25.0 / 17.0).into());
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

/// Tension of every strand of a drive at rest \[N\].
fn tensions_at_rest(drive: &Drive) -> (Equilibrium, Vec<f64>) {
    let laws = ForceLaws::default();
    let rest = Equilibrium::find(drive, &laws).unwrap();
    let mut held = drive.clone();
    for sprocket in &mut held.sprockets {
        if let Motion::PrescribedSpeed(speed) = &mut sprocket.motion {
            *speed = 0.0.into();
        }
    }
    if let Some(tensioner) = &mut held.tensioner {
        tensioner.ramp_time = 0.0;
    }
    let mut start = rest.start.clone();
    start.velocities.fill([0.0; 3]);
    let model = Arc::new(Model::compile(&held, &laws, &start).unwrap());
    let control = rustchain::integrator::StepControl::default();
    let mut simulation = Simulation::new(model, &start, control).unwrap();
    let groups = Groups {
        hinges: true,
        ..Groups::default()
    };
    let recording = common::record(&mut simulation, 1e-6, 1e-6, groups);
    let strands = drive.sprockets.len();
    let tension = common::channel(&recording, "strand_tension")[..strands].to_vec();
    (rest, tension)
}

fn tensioner(number: usize, pretension: f64) -> Tensioner {
    Tensioner {
        sprocket: number,
        ..common::tensioner(pretension, 0.1)
    }
}

#[test]
fn every_tensioner_gives_its_strands_the_tension_it_is_asked_for() {
    let mut drive = three_shafts();
    drive.gravity = Vec2::zeros();
    let spring = Tensioner {
        stiffness: 2000.0,
        ..tensioner(4, 80.0)
    };
    let arm = Tensioner {
        pivot: Some(Vec2::new(0.0, 0.15)),
        ..tensioner(4, 80.0)
    };
    for (name, tensioner) in [
        ("slide", tensioner(4, 80.0)),
        ("slide of a shaft", tensioner(2, 80.0)),
        ("arm", arm),
        ("spring", spring),
    ] {
        drive.tensioner = Some(tensioner);
        let (rest, tension) = tensions_at_rest(&drive);
        assert!(rest.residual < 1e-4, "{name}: {} N left", rest.residual);
        // Bushings are pushed up the flanks of the teeth: with the play of the seats the strands pull on slightly other arms.
        for (i, tension) in tension.iter().enumerate() {
            assert!(
                (tension - 80.0).abs() < 4.0,
                "{name}, strand {}: {tension} N",
                i + 1
            );
        }
    }
}

#[test]
fn a_slack_strand_comes_to_rest_on_its_catenary() {
    let mut drive = common::paper_drive();
    drive.chain.links = 60;
    let taut = rustchain::state::closing_center_distance(PITCH, [17, 17], 60).unwrap();
    drive.sprockets[1].center.x = taut - 2e-3;
    drive.sprockets[1].motion = Motion::AppliedTorque((-2.0).into());
    let (rest, _) = tensions_at_rest(&drive);
    assert!(rest.residual < 1e-4);
    // The hanging strand: hinges of links near mid-span.
    let (_, layout) = Start::generate(&drive).unwrap();
    let links: Vec<&[f64; 3]> = rest.start.positions[..60]
        .iter()
        .filter(|p| p[1] < 0.0 && p[0] > 0.02 && p[0] < taut - 0.02)
        .collect();
    // Weight w of a metre and tension H at the lowest point give tan(angle) = w s / H along the arc s: a straight line.
    let slope: Vec<f64> = links.iter().map(|p| p[2].tan()).collect();
    let steps: Vec<f64> = slope.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    assert!(mean > 0.0 && layout.slack[1] > 0.0);
    for step in &steps {
        // Inner and outer links weigh 6.5 and 8.3 g: 12 % either way of the mean.
        assert!((step / mean - 1.0).abs() < 0.2, "{step} of {mean}");
    }
}

#[test]
fn a_torque_that_nothing_holds_has_no_rest() {
    let mut drive = common::paper_drive();
    drive.sprockets[0].motion = Motion::AppliedTorque(1.0.into());
    let error = Equilibrium::find(&drive, &ForceLaws::default()).unwrap_err();
    assert!(
        error.to_string().contains("does not come to rest"),
        "{error}"
    );
}

#[test]
fn an_arm_with_spring_leak_and_inertia_keeps_the_energy_balance() {
    let mut drive = three_shafts();
    drive.tensioner = Some(Tensioner {
        ramp_time: 0.01,
        damping: 100.0,
        damping_back: Some(5e3),
        stiffness: 4e3,
        pivot: Some(Vec2::new(0.0, 0.15)),
        arm_inertia: 5e-4,
        travel: [1e-3, 0.012],
        ..tensioner(4, 60.0)
    });
    let control = rustchain::integrator::StepControl::default();
    let mut simulation = common::simulation(&drive, &ForceLaws::default(), control);
    let energies = common::energies(&mut simulation, 0.04, 1e-3);
    let (missing, dissipated) = (
        energies.residual.last().unwrap().abs(),
        *energies.dissipated.last().unwrap(),
    );
    // The bound that a run warns at is 5 %.
    assert!(dissipated > 0.01, "{dissipated}");
    assert!(missing < 0.03 * dissipated, "{missing} J of {dissipated} J");
    // The centre stays on the circle about the pivot.
    let body = drive.chain.links as usize + 3;
    let motion = simulation.motion();
    let arm = Vec2::new(motion.x[body], motion.y[body]) - Vec2::new(0.0, 0.15);
    let length = (drive.sprockets[3].center - Vec2::new(0.0, 0.15)).norm();
    assert!((arm.norm() - length).abs() < 1e-14);
    let moved = (Vec2::new(motion.x[body], motion.y[body]) - drive.sprockets[3].center).norm();
    assert!(moved > 1e-4);
}
