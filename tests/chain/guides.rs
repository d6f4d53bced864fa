//! Rails, blades and smooth idlers: forces at rest against statics, energy, stops, and Newton's method against the explicit one.

use crate::common;
use std::sync::Arc;

use crate::common::layouts::{PITCH, drive_of, sprocket};
use crate::common::scalar_reference::Reference;
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::{Arm, Drive, Material, Mount, Rail, RailShape, SprocketMotion};
use rustchain::geometry::Vec2;
use rustchain::geometry::path::belt::Side;
use rustchain::integrator::{Corrector, OdeSystem, StepControl};
use rustchain::layout::{InitialConfiguration, closing_center_distance};
use rustchain::{Equilibrium, ForceLaws, Model, Simulation};

/// Two sprockets of 17 teeth on a level, the chain a little slack.
fn level(links: u32, slack: f64) -> Drive {
    let taut = closing_center_distance(PITCH, [17, 17], links).unwrap();
    let mut drive = drive_of(
        vec![
            sprocket(
                17,
                0.0,
                0.0,
                Side::Inside,
                SprocketMotion::PrescribedSpeed(10.0.into()),
            ),
            sprocket(
                17,
                taut - slack,
                0.0,
                Side::Inside,
                SprocketMotion::AppliedTorque((-1.0).into()),
            ),
        ],
        links,
    );
    drive.gravity = Vec2::zeros();
    drive
}

fn plunger(pivot: Vec2, force: f64) -> Arm {
    Arm {
        pivot,
        force,
        ramp_time: 0.005,
        stiffness: 0.0,
        damping: 50.0,
        damping_back: None,
        travel: [f64::INFINITY; 2],
        inertia: 2e-4,
        ratchet: None,
    }
}

/// A blade below the lower strand that presses upward.
fn blade(drive: &Drive, radius: Option<f64>, force: f64) -> Rail {
    let middle = 0.5 * drive.sprockets[1].center.x;
    Rail {
        shape: RailShape::Bar {
            length: 0.12,
            radius,
            end_radius: 0.006,
        },
        center: Vec2::new(middle, -0.07),
        direction: Vec2::new(0.0, 1.0),
        mount: Mount::Arm(plunger(Vec2::new(middle - 0.08, -0.075), force)),
        material: None,
        plate_height: None,
    }
}

/// Force of guide `g` on the chain and its moment about its bearing, at rest.
fn force_of_guide(drive: &Drive, g: usize) -> (Vec2, f64, Equilibrium) {
    let laws = ForceLaws::default();
    let rest = Equilibrium::find(drive, &laws).unwrap();
    let mut still = drive.clone();
    for sprocket in &mut still.sprockets {
        if let SprocketMotion::PrescribedSpeed(speed) = &mut sprocket.motion {
            *speed = 0.0.into();
        }
    }
    let mut start = rest.start.clone();
    start.velocities.fill([0.0; 3]);
    let model = Arc::new(Model::compile(&still, &laws, &start).unwrap());
    let s = model.toothed() + g;
    let mut simulation = Simulation::new(model, &start, StepControl::default()).unwrap();
    let load = simulation.present().evaluated.accelerations.chain[s];
    (-load.force, -load.moment, rest)
}

#[test]
fn a_blade_presses_on_the_chain_with_its_plungers_moment() {
    for (radius, force) in [(0.25, 20.0), (0.25, 100.0), (0.15, 40.0)] {
        let mut drive = level(60, 2e-3);
        drive.guides = vec![blade(&drive, Some(radius), force)];
        let Mount::Arm(arm) = drive.guides[0].mount else {
            panic!("an arm");
        };
        let plunger = force * drive.guides[0].lever(&arm);
        let (on_chain, moment, rest) = force_of_guide(&drive, 0);
        assert!(
            (moment - plunger).abs() < 1e-5 * plunger,
            "{moment} of {plunger}"
        );
        assert!(on_chain.y > 0.5 * force, "{on_chain}");
        assert!(rest.residual < 1e-4);
    }
}

#[test]
fn a_frictionless_idler_bears_the_pull_of_both_strands_bent_round_it() {
    // A smooth wheel pressed into the lower strand by its bearing's place: both sides have one tension.
    let mut drive = level(60, 2e-3);
    drive.guides = vec![blade(&drive, Some(0.07), 60.0)];
    let (on_chain, _, rest) = force_of_guide(&drive, 0);
    // The chain beside the blade: links whose hinges are off it point where they pull.
    let links = &rest.start.positions[..60];
    let middle = 0.5 * drive.sprockets[1].center.x;
    let lower = |from: f64, to: f64| {
        let angles: Vec<f64> = links
            .iter()
            .filter(|p| p[1] < 0.0 && p[0] > from && p[0] < to)
            .map(|p| p[2])
            .collect();
        angles.iter().sum::<f64>() / angles.len() as f64
    };
    let half = 0.06 + PITCH;
    let left = lower(0.02, middle - half);
    let right = lower(middle + half, 2.0 * middle - 0.02);
    // Tension T along both: the force is T times the difference of the directions.
    let bend = Vec2::new(right.cos() - left.cos(), right.sin() - left.sin());
    let tension = on_chain.norm() / bend.norm();
    let across = on_chain.perp(&bend).abs() / (on_chain.norm() * bend.norm());
    // The chain is a polygon: the normals of the first and last bushing on the arch do not halve the angle of their links.
    assert!(across < 0.02, "{across}");
    // A torque of 1 N m more in the other strand.
    assert!(tension > 10.0 && tension < 1e4, "{tension}");
}

fn energies(drive: &Drive, control: StepControl) -> (f64, f64) {
    let mut simulation = common::simulation(drive, &ForceLaws::default(), control);
    let energies = common::energies(&mut simulation, 0.03, 1e-3);
    (
        energies.residual.last().unwrap().abs(),
        *energies.dissipated.last().unwrap(),
    )
}

/// A drive with a hydraulic blade with spring and stops on one strand, a rail of plastic and an idler that turns on the other.
fn guided() -> Drive {
    let mut drive = level(60, 2e-3);
    let mut soft = blade(&drive, Some(0.25), 60.0);
    if let Mount::Arm(arm) = &mut soft.mount {
        arm.damping_back = Some(2000.0);
        arm.stiffness = 500.0;
        arm.travel = [0.01, 0.03];
    }
    let top = drive.sprockets[0]
        .tooth_profile(&drive.chain)
        .unwrap()
        .pitch_radius;
    let above = top + drive.chain.bushing_radius;
    let plastic = Material {
        elastic_modulus: 3e9,
        poisson_ratio: 0.4,
        restitution: 0.5,
    };
    let rail = Rail {
        shape: RailShape::Bar {
            length: 0.08,
            radius: None,
            end_radius: 0.004,
        },
        center: Vec2::new(0.08, above + 0.0045),
        direction: Vec2::new(0.0, -1.0),
        mount: Mount::Fixed,
        material: Some(plastic),
        plate_height: None,
    };
    let idler = Rail {
        shape: RailShape::Wheel { radius: 0.015 },
        center: Vec2::new(0.18, above + 0.0155),
        direction: Vec2::x(),
        mount: Mount::Turning { inertia: 1e-5 },
        material: None,
        plate_height: None,
    };
    drive.guides = vec![soft, rail, idler];
    drive.gravity = Vec2::new(0.0, -9.81);
    drive
}

#[test]
fn the_energy_balance_closes_with_guides() {
    for corrector in [Corrector::Pece, Corrector::Auto] {
        let control = StepControl {
            corrector,
            ..if corrector == Corrector::Pece {
                common::control(1e-7)
            } else {
                StepControl::default()
            }
        };
        let (missing, dissipated) = energies(&guided(), control);
        assert!(dissipated > 1e-3);
        assert!(missing < 0.03 * dissipated, "{missing} of {dissipated}");
    }
}

#[test]
fn both_methods_agree_with_guides() {
    let mut places = Vec::new();
    for corrector in [Corrector::Pece, Corrector::Newton] {
        let control = StepControl {
            corrector,
            ..if corrector == Corrector::Pece {
                common::control(1e-9)
            } else {
                StepControl {
                    accuracy: 1e-12,
                    ..StepControl::default()
                }
            }
        };
        let mut simulation = common::simulation(&guided(), &ForceLaws::default(), control);
        common::advance(&mut simulation, 1.5e-3);
        places.push(simulation.motion().positions());
    }
    let [one, other] = [&places[0], &places[1]];
    for (a, b) in one.iter().zip(other) {
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 3e-7, "{a:?} {b:?}");
    }
}

#[test]
fn the_kernels_agree_with_the_scalar_reference_on_guides() {
    let drive = guided();
    let laws = ForceLaws::default();
    let rest = Equilibrium::find(&drive, &laws).unwrap();
    let model = Arc::new(Model::compile(&drive, &laws, &rest.start).unwrap());
    let mut dynamics = Dynamics::new(Arc::clone(&model));
    let mut motion = rustchain::chain::motion::Motion::new(model.bodies());
    motion.set(&rest.start.positions, &rest.start.velocities);
    let mut y = vec![0.0; 2 * model.coordinates];
    motion.write(&model, &mut y);
    let mut rates = vec![0.0; y.len()];
    dynamics.derivative(0.0, &y, &mut rates);
    let reference = Reference::of(&dynamics, 0.0, &y);
    let n = model.links;
    let on_guides = reference.teeth[n * model.toothed()..].iter().flatten();
    let touching = on_guides.filter(|guided| guided.contact.force > 0.0);
    assert!(touching.count() > 0);
    let largest = rates[model.coordinates..]
        .iter()
        .fold(1.0, |a: f64, b| a.max(b.abs()));
    for i in 0..n {
        let kernel = rates[model.coordinates + n + i];
        assert!((kernel - reference.accelerations[1][i]).abs() < 1e-9 * largest);
    }
}

#[test]
fn a_blade_begins_clear_of_the_chain_and_a_rail_in_it_is_refused() {
    let mut drive = level(60, 2e-3);
    let mut near = blade(&drive, None, 20.0);
    near.center.y = -0.045;
    drive.guides = vec![near];
    let (start, layout) = InitialConfiguration::generate(&drive).unwrap();
    assert!(start.positions.last().unwrap()[2] < near.angle());
    assert!(layout.start_gap > 0.0);
    drive.guides[0].mount = Mount::Fixed;
    drive.guides[0].center.y = -0.05;
    let message = InitialConfiguration::generate(&drive)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("guide 1 overlaps the chain of the initial configuration by"),
        "{message}"
    );
}

#[test]
fn three_shafts_with_rail_and_blade_rest_and_run() {
    let drive = common::layouts::guided_shafts();
    let laws = ForceLaws::default();
    let rest = Equilibrium::find(&drive, &laws).unwrap();
    let model = Arc::new(Model::compile(&drive, &laws, &rest.start).unwrap());
    let mut simulation = Simulation::new(model, &rest.start, StepControl::default()).unwrap();
    common::advance(&mut simulation, 2e-3);
    let present = simulation.present();
    let deepest = present.evaluated.teeth.penetration.iter().copied();
    assert!(deepest.fold(0.0, f64::max) < 5e-5);
}

#[test]
fn plates_bear_on_a_rail_as_far_above_it_as_they_reach_round_the_hinges() {
    let height = 0.0116;
    // The last is so slightly hollow that the thickness of its middle determines its depth.
    for radius in [0.25, -0.09, -0.5] {
        let mut drive = level(60, 2e-3);
        drive.guides = vec![blade(&drive, Some(radius), 40.0)];
        drive.guides[0].plate_height = Some(height);
        let rail = drive.guides[0];
        let (on_chain, moment, rest) = force_of_guide(&drive, 0);
        let Mount::Arm(arm) = rail.mount else {
            panic!("an arm");
        };
        assert!((moment / (40.0 * rail.lever(&arm)) - 1.0).abs() < 1e-5);
        assert!(on_chain.y > 20.0);
        let [x, y, angle] = rest.start.positions[62];
        let along = Vec2::new(angle.cos(), angle.sin());
        let (offset, left) = (rail.offset(), Vec2::new(-along.y, along.x));
        let middle = Vec2::new(x, y) + offset.x * along + offset.y * left;
        let profile = rail.profile().unwrap();
        let reach = rest.start.positions[..60]
            .iter()
            .map(|p| {
                let hinge = Vec2::new(
                    p[0] + 0.5 * PITCH * p[2].cos(),
                    p[1] + 0.5 * PITCH * p[2].sin(),
                );
                let off = hinge - middle;
                let out = if off.dot(&along) < 0.0 { -along } else { along };
                let place = Vec2::new(off.perp(&out), off.dot(&out));
                -profile.contact(place, 0.0).penetration
            })
            .fold(f64::INFINITY, f64::min);
        // A pin is within its clearance of the bushing whose plates bear.
        assert!((reach - 0.5 * height).abs() < 6e-5, "{radius}: {reach}");
    }
}

#[test]
fn plates_that_do_not_fit_a_guide_are_refused_by_its_fields() {
    let mut drive = level(60, 2e-3);
    drive.guides = vec![blade(&drive, Some(-0.09), 40.0)];
    let refusal = |drive: &Drive| drive.validate().unwrap_err().to_string();
    drive.guides[0].plate_height = Some(0.5 * drive.chain.bushing_radius);
    let low = refusal(&drive);
    assert!(low.starts_with("GuideRail.plate_height = "), "{low}");
    drive.guides[0].shape = RailShape::Wheel { radius: 0.02 };
    let low = refusal(&drive);
    assert!(low.starts_with("SmoothIdler.plate_height = "), "{low}");
    // Plates 8 mm above the bushings: a radius of 0.06 + 2 * 0.008 m.
    let hollow = |radius: f64| {
        let mut drive = level(60, 2e-3);
        drive.guides = vec![blade(&drive, Some(radius), 40.0)];
        drive.guides[0].plate_height = Some(2.0 * (drive.chain.bushing_radius + 0.008));
        drive
    };
    let high = refusal(&hollow(-0.075));
    assert!(high.starts_with("GuideRail.radius = -0.075: "), "{high}");
    assert!(high.contains("below -0.076000 m"), "{high}");
    hollow(-0.077).validate().unwrap();
}

#[test]
fn a_strand_lies_in_a_hollow_rail() {
    // Two level shafts in gravity, and a trough pressed up into the slack lower strand.
    let mut drive = level(60, 2e-3);
    drive.gravity = Vec2::new(0.0, -9.81);
    let lowest = InitialConfiguration::generate(&drive).unwrap().0.positions[..60]
        .iter()
        .fold(0.0, |low: f64, p| low.min(p[1]));
    drive.guides = vec![Rail {
        shape: RailShape::Bar {
            length: 0.12,
            radius: Some(-0.09),
            end_radius: 0.004,
        },
        center: Vec2::new(0.5 * drive.sprockets[1].center.x, lowest),
        direction: Vec2::y(),
        mount: Mount::Arm(Arm {
            travel: [0.05, 0.02],
            ..plunger(Vec2::new(-0.2, -0.08), 3.0)
        }),
        material: None,
        plate_height: None,
    }];
    let rest = Equilibrium::find(&drive, &ForceLaws::default()).unwrap();
    let start = &rest.start;
    let [x, y, angle] = start.positions[62];
    let rail = drive.guides[0];
    let along = Vec2::new(angle.cos(), angle.sin());
    let (offset, left) = (rail.offset(), Vec2::new(-along.y, along.x));
    let middle = Vec2::new(x, y) + offset.x * along + offset.y * left;
    let profile = rail.profile().unwrap();
    let mut borne = 0;
    for p in &start.positions[..60] {
        let end = Vec2::new(p[0], p[1]) + 0.5 * PITCH * Vec2::new(p[2].cos(), p[2].sin());
        let off = end - middle;
        if off.dot(&along) < 0.0 {
            continue;
        }
        let place = Vec2::new(off.perp(&along), off.dot(&along));
        let depth = profile
            .contact(place, drive.chain.bushing_radius)
            .penetration;
        // A pin is within its clearance of the bushing that bears.
        assert!(depth < 6e-5, "{depth}");
        borne += u32::from(depth > -6e-5);
    }
    // A bar with a straight face would bear at its ends, or at two bushings.
    assert!(borne >= 3, "{borne}");
    let (missing, dissipated) = energies(&drive, common::control(1e-7));
    assert!(
        missing < 1e-3 * dissipated.max(1e-3),
        "{missing} of {dissipated}"
    );
}

#[test]
fn the_layout_says_where_guides_begin_and_refuses_one_in_a_sprocket() {
    let drive = guided();
    let (_, layout) = InitialConfiguration::generate(&drive).unwrap();
    let [blade, rail, idler] = layout.guides.as_slice() else {
        panic!("three guides");
    };
    assert_eq!(blade.place, "strand lower");
    assert_eq!(rail.place, "strand upper");
    assert_eq!(idler.place, "strand upper");
    assert!(blade.gap >= 0.0 && blade.travel[0] + blade.travel[1] > 0.0399);
    assert!((rail.gap - 5e-4).abs() < 1e-4, "{rail:?}");
    assert_eq!((rail.turn, rail.travel), (0.0, [0.0; 2]));
    // A rail of 80 mm spans six or seven pitches.
    assert!((6..=8).contains(&rail.bushings), "{rail:?}");
    let mut wrong = drive.clone();
    wrong.guides[2].center = wrong.sprockets[1].center;
    let message = InitialConfiguration::generate(&wrong)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("guide 3 stands in sprocket 2 by"),
        "{message}"
    );
    let mut lost = drive.clone();
    lost.guides[1].center.y += 0.1;
    let (_, layout) = InitialConfiguration::generate(&lost).unwrap();
    let told = layout
        .warnings
        .iter()
        .any(|w| w.contains("guide 2 has no bushing"));
    assert!(told, "{:?}", layout.warnings);
}
