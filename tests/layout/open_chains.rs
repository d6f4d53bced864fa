//! Open chains at rest: exact catenaries of rigid links, hoists, what is laid and what is refused.

use crate::common;
use crate::common::layouts::{PITCH, sprocket};
use crate::common::open::{at_rest, first_row, hoist, strand};
use crate::common::{channel, paper_chain};
use rustchain::drive::{ChainEnd, Drive, SprocketMotion, Variation};
use rustchain::geometry::Vec2;
use rustchain::geometry::path::belt::Side;
use rustchain::geometry::path::hanging::{Hanging, HangingLink, hang};
use rustchain::integrator::StepControl;
use rustchain::layout::InitialConfiguration;
use rustchain::{ForceLaws, Model};

const GRAVITY: f64 = 9.81;

/// Points of a row of numbers (x, y).
fn points(values: &[f64]) -> Vec<Vec2> {
    values.chunks(2).map(|p| Vec2::new(p[0], p[1])).collect()
}

/// Links between two points with their hinges as weightless links: as long as pins lie off their bushings' middles.
fn with_hinges(drive: &Drive, ends: [Vec2; 2], offsets: &[f64]) -> Hanging {
    let pitches = drive.chain.link_pitches();
    let mut links = Vec::new();
    for (i, &offset) in offsets.iter().enumerate() {
        links.push(HangingLink {
            length: offset,
            weight: 0.0,
        });
        if let Some(&length) = pitches.get(i) {
            links.push(HangingLink {
                length,
                weight: GRAVITY * drive.chain.strand_link(i).mass,
            });
        }
    }
    hang(ends[0], ends[1], -Vec2::y(), &links).unwrap()
}

#[test]
fn a_hanging_chain_rests_on_the_exact_catenary_of_its_rigid_links() {
    for (links, share, rise, strands) in [
        (12, 0.5, 0.0, 1),
        (12, 0.97, 0.3, 1),
        (25, 0.3, -0.5, 2),
        (25, 0.8, 0.6, 1),
        (40, 0.6, 0.0, 1),
        (40, 0.95, -0.2, 3),
        (41, 0.15, 0.9, 1),
        (120, 0.7, 0.4, 1),
    ] {
        let length = f64::from(links) * PITCH;
        let along = Vec2::new(1.0, rise).normalize();
        let ends = [
            Vec2::new(0.2, -0.1),
            Vec2::new(0.2, -0.1) + share * length * along,
        ];
        let mut drive = strand(links, ends.map(ChainEnd::anchored));
        drive.chain.strands = strands;
        let (mut run, rest) = at_rest(&drive, &ForceLaws::default(), StepControl::default());
        let row = first_row(&mut run);
        let (force, depth) = (
            channel(&row, "hinge_force"),
            channel(&row, "hinge_penetration"),
        );
        let n = links as usize;
        let in_order = |values: &[f64]| -> Vec<f64> {
            [values[n + 1]]
                .into_iter()
                .chain(values[..n].iter().copied())
                .collect()
        };
        let clearance = drive.chain.hinge.clearance();
        let offsets: Vec<f64> = in_order(&depth).iter().map(|d| d + clearance).collect();
        let exact = with_hinges(&drive, ends, &offsets);
        let scene = format!("{links} links, {share} of their length, rise {rise}");
        for (i, [x, y, _]) in rest.start.positions[..n].iter().enumerate() {
            let middle = 0.5 * (exact.points[2 * i + 1] + exact.points[2 * i + 2]);
            let off = (Vec2::new(*x, *y) - middle).norm();
            // The rest is found to 1e-7 of the largest force.
            assert!(
                off < 2e-7 * length,
                "{scene}, link {}: {off:e} m off",
                i + 1
            );
        }
        for (i, force) in in_order(&force).iter().enumerate() {
            let tension = exact.tensions[2 * i].norm();
            assert!(
                (force - tension).abs() < 1e-6 * exact.tensions[0].norm(),
                "{scene}, hinge {i}: {force} N of {tension} N"
            );
        }
        let on_ends = points(&channel(&row, "end_force")[..4]);
        let last = exact.tensions.len() - 1;
        for (found, wanted) in [
            (on_ends[0], exact.tensions[0]),
            (on_ends[1], -exact.tensions[last]),
        ] {
            assert!(
                (found - wanted).norm() < 1e-6 * wanted.norm(),
                "{scene}: {found} {wanted}"
            );
        }
        let places = points(&channel(&row, "end_position")[..4]);
        for (place, end) in places.iter().zip(ends) {
            assert!((place - end).norm() < 1e-15);
        }
    }
}

#[test]
fn the_chain_is_laid_on_the_polygon_of_its_links_to_round_off() {
    let ends = [Vec2::new(-0.1, 0.3), Vec2::new(0.25, 0.1)];
    let mut drive = strand(51, ends.map(ChainEnd::anchored));
    drive.chain.variation = Variation {
        elongation: vec![0.01],
        pitch_spread: 1e-3,
        seed: 4,
    };
    let (start, layout) = InitialConfiguration::generate(&drive).unwrap();
    let exact = with_hinges(&drive, ends, &[0.0; 52]);
    for (i, [x, y, angle]) in start.positions[..51].iter().enumerate() {
        let [rear, front] = [exact.points[2 * i + 1], exact.points[2 * i + 2]];
        assert!((Vec2::new(*x, *y) - 0.5 * (rear + front)).norm() < 1e-14);
        let along = front - rear;
        assert!((angle - along.y.atan2(along.x)).abs() < 1e-12);
    }
    assert!(layout.hinge_stretch < 1e-14, "{:e}", layout.hinge_stretch);
    assert_eq!(layout.strand_pitches, [51]);
    assert_eq!(layout.strand_name(0), "end_1-end_2");
}

#[test]
fn tension_in_a_hanging_chain_is_the_weight_below_and_the_load() {
    for (links, load) in [(7, 0.1), (30, 5.0), (31, 400.0)] {
        let drive = strand(
            links,
            [
                ChainEnd::anchored(Vec2::zeros()),
                ChainEnd::loaded(load, 1e-3 * load),
            ],
        );
        let (mut run, rest) = at_rest(&drive, &ForceLaws::default(), StepControl::default());
        let row = first_row(&mut run);
        let force = channel(&row, "hinge_force");
        let n = links as usize;
        let total: f64 = (0..n).map(|i| drive.chain.strand_link(i).mass).sum();
        assert!(rest.residual < 1e-6 * GRAVITY * (load + total));
        for (k, force) in force[..n].iter().enumerate() {
            let below: f64 = (k + 1..n).map(|i| drive.chain.strand_link(i).mass).sum();
            let weight = GRAVITY * (below + load);
            assert!(
                (force - weight).abs() < 2e-7 * GRAVITY * (load + total),
                "{force} {weight}"
            );
        }
        let top = channel(&row, "end_force");
        assert!((top[1] + GRAVITY * (load + total)).abs() < 2e-7 * GRAVITY * (load + total));
        assert!((top[3] - GRAVITY * load).abs() < 2e-7 * GRAVITY * (load + total));
        assert_eq!(force[n], 0.0);
    }
}

#[test]
fn a_hoist_rests_with_its_load_on_the_wheels_torque_and_its_slack_on_a_catenary() {
    for (links, slack, load) in [(40, 14, 2.0), (60, 25, 20.0), (41, 12, 1.0)] {
        let drive = hoist(
            links,
            slack,
            load,
            SprocketMotion::PrescribedSpeed(0.0.into()),
        );
        let (mut run, _) = at_rest(&drive, &ForceLaws::default(), StepControl::default());
        let row = first_row(&mut run);
        let n = links as usize;
        let (start, layout) = InitialConfiguration::generate(&drive).unwrap();
        assert_eq!(layout.strand_pitches[0], slack);
        // The slack side pulls a little on the wheel as well: its tension at the seat, along the tangent there.
        let below: f64 = (n - layout.strand_pitches[1] as usize..n)
            .map(|i| drive.chain.strand_link(i).mass)
            .sum();
        let torque = channel(&row, "sprocket_torque")[0];
        let radius = layout.pitch_radius[0];
        // The load turns the wheel clockwise; the motor holds it the other way. The chain is a polygon: its arm may be shorter by
        // 1 - cos(pi/13), and the slack side takes some newtons.
        let most = GRAVITY * (load + below + 0.3) * radius;
        assert!(
            torque < 1.01 * most && torque > 0.9 * (GRAVITY * load * radius) - 0.05,
            "{torque} N m of {most} N m"
        );
        let tension = channel(&row, "strand_tension");
        let mean = GRAVITY * (load + 0.5 * below);
        assert!(
            (tension[1] - mean).abs() < 0.03 * mean,
            "{tension:?}, {mean}"
        );
        assert!(tension[0] > 0.0 && tension[0] < 2.0, "{tension:?}");
        let pull = channel(&row, "end_force");
        assert!(
            (pull[3] - GRAVITY * load).abs() < 1e-5 * GRAVITY * load,
            "{pull:?}"
        );
        // Its body hangs below its pin.
        let [x, y, angle] = run.dynamics().evaluated.motion.positions()[n];
        assert!(
            (angle + std::f64::consts::FRAC_PI_2).abs() < 1e-4,
            "{angle}"
        );
        let pin = channel(&row, "end_position");
        assert!((x - pin[2]).abs() < 1e-5 && (pin[3] - y - 0.05).abs() < 1e-7);
        assert!(start.positions[n][1] < -0.1);
    }
}

#[test]
fn torque_on_a_free_wheel_balances_two_loads_at_its_lever() {
    // Equal loads on both sides rest without torque.
    let mut drive = strand(
        40,
        [ChainEnd::loaded(3.0, 1e-3), ChainEnd::loaded(3.0, 1e-3)],
    );
    drive.sprockets = vec![sprocket(
        17,
        0.0,
        0.0,
        Side::Inside,
        SprocketMotion::PrescribedSpeed(0.0.into()),
    )];
    let (mut run, _) = at_rest(&drive, &ForceLaws::default(), StepControl::default());
    let row = first_row(&mut run);
    let torque = channel(&row, "sprocket_torque")[0];
    // Seats are at most half a tooth off the tangent points: arms of both loads differ by 1 - cos(pi/17) at most.
    assert!(torque.abs() < 0.02 * 3.0 * GRAVITY * 0.0346, "{torque}");
    let tension = channel(&row, "strand_tension");
    assert!((tension[0] / tension[1] - 1.0).abs() < 0.01, "{tension:?}");
}

#[test]
fn every_way_to_lay_a_chain_begins_with_nothing_in_contact() {
    let anchor = |x: f64, y: f64| ChainEnd::anchored(Vec2::new(x, y));
    let wheel = |teeth, x, y, side| sprocket(teeth, x, y, side, SprocketMotion::Free);
    let hung = |links: u32| ChainEnd::Free {
        position: None,
        links: Some(links),
    };
    let mut drives = Vec::new();
    for links in [62, 63, 74] {
        for teeth in [9, 17, 40] {
            let one = vec![wheel(teeth, 0.0, 0.0, Side::Inside)];
            drives.push((
                links,
                one.clone(),
                [anchor(-0.2, -0.2), ChainEnd::loaded(2.0, 1e-3)],
            ));
            drives.push((
                links,
                one.clone(),
                [ChainEnd::loaded(2.0, 1e-3), anchor(0.2, -0.21)],
            ));
            drives.push((links, one.clone(), [hung(8), ChainEnd::loaded(2.0, 1e-3)]));
            drives.push((links, one, [anchor(-0.17, -0.15), anchor(0.13, -0.16)]));
        }
        let idler = vec![
            wheel(17, 0.0, 0.0, Side::Inside),
            wheel(13, 0.2, -0.05, Side::Outside),
        ];
        drives.push((links, idler.clone(), [hung(5), anchor(0.33, 0.03)]));
        let level = vec![
            wheel(17, 0.0, 0.0, Side::Inside),
            wheel(15, 0.19, 0.02, Side::Inside),
        ];
        drives.push((links, level, [hung(7), ChainEnd::free()]));
    }
    for (links, sprockets, ends) in drives {
        let mut drive = strand(links, ends);
        drive.sprockets = sprockets;
        let (start, layout) = InitialConfiguration::generate(&drive)
            .unwrap_or_else(|error| panic!("{links} {:?}: {error}", drive.sprockets));
        assert!(layout.start_gap > 0.9e-6, "{links}: {:e}", layout.start_gap);
        assert!(layout.hinge_stretch < 0.1 * drive.chain.hinge.clearance());
        let seated: u32 = layout.seated.iter().sum();
        let strands: u32 = layout.strand_pitches.iter().sum();
        assert_eq!(seated + strands, links);
        // As the model has it, too.
        let model = Model::compile(&drive, &ForceLaws::default(), &start).unwrap();
        let mut dynamics = rustchain::chain::dynamics::Dynamics::new(model.into());
        dynamics
            .evaluated
            .motion
            .set(&start.positions, &start.velocities);
        dynamics.evaluate_motion(0.0);
        assert!(
            dynamics
                .evaluated
                .hinges
                .penetration
                .iter()
                .all(|&depth| depth < 0.0)
        );
        assert!(
            dynamics
                .evaluated
                .teeth
                .penetration
                .iter()
                .all(|&depth| depth < 0.0)
        );
    }
}

#[test]
fn a_moving_chain_is_laid_with_links_that_keep_their_lengths() {
    let drive = hoist(50, 16, 10.0, SprocketMotion::PrescribedSpeed(5.0.into()));
    let (start, layout) = InitialConfiguration::generate(&drive).unwrap();
    let n = 50;
    // Counterclockwise: the load, on the right, goes up.
    let up = start.velocities[n][1];
    assert!(
        (up - 5.0 * layout.pitch_radius[0]).abs() < 0.03 * up,
        "{up}"
    );
    let half = 0.5 * PITCH;
    for k in 0..n - 1 {
        let end = |i: usize, side: f64| {
            let ([_, _, angle], [vx, vy, spin]) = (start.positions[i], start.velocities[i]);
            Vec2::new(vx, vy) + side * half * spin * Vec2::new(-angle.sin(), angle.cos())
        };
        let apart = end(k, 1.0) - end(k + 1, -1.0);
        assert!(apart.norm() < 0.02 * up, "hinge {k}: {apart}");
    }
}

fn refusal(drive: &Drive) -> String {
    InitialConfiguration::generate(drive)
        .unwrap_err()
        .to_string()
}

#[test]
fn what_cannot_be_laid_is_refused_with_numbers() {
    let anchor = |x: f64, y: f64| ChainEnd::anchored(Vec2::new(x, y));
    let short = strand(20, [anchor(0.0, 0.0), anchor(0.3, 0.0)]);
    let said = refusal(&short);
    assert!(
        said.contains("20 links reach 0.254") && said.contains("24 links would do"),
        "{said}"
    );
    let mut hoist_of = hoist(20, 14, 1.0, SprocketMotion::Free);
    let said = refusal(&hoist_of);
    assert!(
        said.contains("0 links are left for the strand at end 2"),
        "{said}"
    );
    hoist_of.ends.as_mut().unwrap()[0] = ChainEnd::Anchored {
        position: Vec2::new(-0.12, -0.05),
        velocity: [0.0.into(), 0.0.into()],
        links: Some(2),
    };
    hoist_of.chain.links = 40;
    let said = refusal(&hoist_of);
    assert!(
        said.contains("2 links are left for the strand at end 1"),
        "{said}"
    );
    let mut weightless = strand(20, [anchor(0.0, 0.0), ChainEnd::free()]);
    weightless.gravity = Vec2::zeros();
    assert!(refusal(&weightless).contains("without gravity the strand at end 2 has no direction"));
    let nowhere = strand(20, [ChainEnd::free(), ChainEnd::free()]);
    assert!(refusal(&nowhere).contains("its position is undefined"));
    let mut beside = hoist(40, 14, 1.0, SprocketMotion::Free);
    beside
        .sprockets
        .push(sprocket(13, 0.5, -2.0, Side::Inside, SprocketMotion::Free));
    beside.sprockets[1].center = Vec2::new(0.03, 0.0);
    assert!(
        refusal(&beside).contains("sprockets 1 and 2 overlap"),
        "{}",
        refusal(&beside)
    );
    let mut offset = strand(21, [anchor(0.0, 0.0), ChainEnd::free()]);
    offset.chain.offset = Some(paper_chain().inner);
    assert!(refusal(&offset).contains("must be absent in an open chain"));
    let mut tight = strand(20, [anchor(0.0, 0.0), ChainEnd::free()]);
    tight.tensioner = Some(common::tensioner(10.0, 0.1));
    assert!(refusal(&tight).contains("Tensioner.sprocket"));
    let heavy = strand(20, [anchor(0.0, 0.0), ChainEnd::loaded(-1.0, 1e-3)]);
    assert!(refusal(&heavy).contains("LoadedEnd.mass"));
    let mut closed = strand(20, [anchor(0.0, 0.0), ChainEnd::free()]);
    closed.ends = None;
    assert!(refusal(&closed).contains("must be at least two"));
}
