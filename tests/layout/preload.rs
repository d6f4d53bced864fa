//! Static preload of every kind of tensioner: forces and moments of the strands beside it, cut free, against its own.

use crate::common;
use std::sync::Arc;

use crate::common::checks::lacks;
use crate::common::layouts::{PITCH, drive_of, sprocket, three_shafts};
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::{Arm, Drive, Mount, Rail, RailShape, SprocketMotion, Tensioner};
use rustchain::geometry::Vec2;
use rustchain::geometry::path::belt::Side;
use rustchain::integrator::{OdeSystem, StepControl};
use rustchain::layout::closing_center_distance;
use rustchain::{Equilibrium, ForceLaws, Model, Simulation};

/// Stiffness of stops \[N/m\].
const STOP: f64 = 1e7;

/// What the rest of the drive does to a wheel or guide and the chain on it, cut free between hinges of both strands.
struct Cut {
    /// Pull of both strands and weight of the links between \[N\].
    force: Vec2,
    /// Its moment about the origin \[N m\].
    moment: f64,
    /// Tensions of the strands where they are cut \[N\].
    tensions: [f64; 2],
    /// Place \[m\] and angle \[rad\] of the wheel.
    place: [f64; 3],
    /// Weight of the wheel, where its bearing moves \[N\].
    weight: Vec2,
}

fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The rest of `drive`, and the dynamics and the state there.
fn at_rest(drive: &Drive) -> (Equilibrium, Dynamics, Vec<f64>) {
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
    let simulation = Simulation::new(model, &start, StepControl::default()).unwrap();
    let y = simulation.integrator().y().to_vec();
    (rest, simulation.dynamics().clone(), y)
}

/// Cuts wheel `s` free, a link away from the teeth that bear, at the rest of `drive`.
fn cut(drive: &Drive, s: usize) -> Cut {
    let (rest, mut dynamics, y) = at_rest(drive);
    let mut slope = vec![0.0; y.len()];
    dynamics.derivative(0.0, &y, &mut slope);
    dynamics.evaluate(0.0, &y);
    let model = Arc::clone(dynamics.model());
    let n = model.links;
    let bears = |k: usize| dynamics.evaluated.teeth.penetration[s * n + k % n] > 0.0;
    // The run of bushings that bear, with gaps of one between them.
    let first = (0..n)
        .find(|&k| bears(k) && (1..8).all(|i| !bears(k + n - i)))
        .unwrap();
    let count = (0..n - 8).rev().find(|&i| bears(first + i)).unwrap();
    let (rear, front) = (first + n - 1, first + n + count + 1);
    // No other wheel bears what is cut free.
    for (pair, depth) in dynamics.evaluated.teeth.penetration.iter().enumerate() {
        let inside = (pair % n + 2 * n - rear % n) % n <= front - rear;
        assert!(
            pair / n == s || !inside || *depth <= 0.0,
            "wheel {}",
            pair / n + 1
        );
    }
    let hinges = &dynamics.evaluated.hinges;
    let point = |k: usize| hinges.bushing(k % n);
    let on_rear = -hinges.force_on_front(rear % n);
    let on_front = hinges.force_on_front(front % n);
    let mut force = on_rear + on_front;
    let mut moment = cross(point(rear), on_rear) + cross(point(front), on_front);
    for k in rear + 1..=front {
        let i = k % n;
        let [x, y, _] = rest.start.positions[i];
        let weight = model.chain.mass[i] * drive.gravity;
        force += weight;
        moment += cross(Vec2::new(x, y), weight);
    }
    Cut {
        force,
        moment,
        tensions: [on_rear.norm(), on_front.norm()],
        place: rest.start.positions[n + s],
        weight: model.sprockets[s].mass * drive.gravity,
    }
}

fn tensioner(number: usize, pretension: f64) -> Tensioner {
    Tensioner {
        sprocket: number,
        ..common::tensioner(pretension, 0.1)
    }
}

/// Along the way of a slide: strands, weights, full pull, spring and stops.
fn assert_slide_balances(drive: &Drive, name: &str) -> Cut {
    let tensioner = drive.tensioner.unwrap();
    let line = tensioner.line(drive).unwrap();
    let found = cut(drive, tensioner.sprocket - 1);
    let described = drive.sprockets[tensioner.sprocket - 1].center;
    let moved = Vec2::new(found.place[0], found.place[1]) - described;
    let s = moved.dot(&line.direction);
    let [back, forth] = tensioner.travel;
    let stop = if s > forth {
        -STOP * (s - forth)
    } else if s < -back {
        STOP * (-back - s)
    } else {
        0.0
    };
    let own = line.pull - tensioner.stiffness * s + stop;
    let chain = (found.force + found.weight).dot(&line.direction);
    let size = line
        .pull
        .abs()
        .max(found.tensions[0])
        .max(found.tensions[1]);
    assert!(
        (chain + own).abs() < 1e-5 * size,
        "{name}: the chain pulls with {chain} N, the tensioner with {own} N, {s} m along"
    );
    found
}

#[test]
fn a_sliding_sprocket_balances_its_strands_by_force_spring_or_stop() {
    for gravity in [0.0, -9.81] {
        for (pretension, number, torque) in [(20.0, 4, 0.0), (80.0, 4, -1.5), (300.0, 2, 0.0)] {
            let mut drive = three_shafts();
            drive.gravity = Vec2::new(0.0, gravity);
            drive.sprockets[2].motion = SprocketMotion::AppliedTorque(torque.into());
            drive.tensioner = Some(tensioner(number, pretension));
            let name = format!("{pretension} N on {number}, gravity {gravity}");
            let by_force = assert_slide_balances(&drive, &name);
            // What was asked for, where nothing else pulls: bushings in the play of their seats end beside the belt line.
            if torque == 0.0 && gravity == 0.0 {
                for tension in by_force.tensions {
                    assert!(
                        (tension - pretension).abs() < 0.05 * pretension,
                        "{name}: {tension}"
                    );
                }
            }
            // A spring that has lost a tenth of the force a millimetre further out.
            drive.tensioner = Some(Tensioner {
                stiffness: 100.0 * pretension,
                ..tensioner(number, pretension)
            });
            assert_slide_balances(&drive, &format!("{name}, spring"));
        }
    }
}

#[test]
fn a_slides_stops_take_what_the_strands_do_not() {
    let mut drive = three_shafts();
    drive.gravity = Vec2::zeros();
    for (pretension, forth) in [(80.0, 5e-3), (20.0, 2e-3)] {
        // Before the slack is taken up: all of the pull.
        drive.tensioner = Some(Tensioner {
            travel: [0.0, forth],
            ..tensioner(4, pretension)
        });
        let found = assert_slide_balances(&drive, "out");
        assert!(found.tensions[0].max(found.tensions[1]) < 1.0);
    }
    // Pulled back by a load that the pull does not hold.
    let mut taut = common::paper_drive();
    taut.gravity = Vec2::zeros();
    for (pretension, torque) in [(5.0, -4.0), (20.0, -8.0)] {
        taut.sprockets[1].motion = SprocketMotion::AppliedTorque(f64::into(torque));
        taut.tensioner = Some(Tensioner {
            travel: [1e-5, 1e-2],
            ..tensioner(2, pretension)
        });
        let found = assert_slide_balances(&taut, "back");
        let arm = 0.5 * PITCH / (std::f64::consts::PI / 17.0).sin();
        assert!(found.tensions[0].max(found.tensions[1]) > 0.9 * torque.abs() / arm);
    }
}

#[test]
fn the_strands_at_an_idler_on_an_arm_balance_its_moment() {
    for (pivot, pretension, gravity) in [
        (Vec2::new(0.0, 0.05), 80.0, 0.0),
        (Vec2::new(0.2, 0.0), 40.0, 0.0),
        (Vec2::new(0.0, 0.05), 150.0, -9.81),
        (Vec2::new(0.2, 0.0), 90.0, -9.81),
    ] {
        for stiffness in [0.0, 2e3] {
            let mut drive = three_shafts();
            drive.gravity = Vec2::new(0.0, gravity);
            drive.tensioner = Some(Tensioner {
                pivot: Some(pivot),
                arm_inertia: 3e-4,
                stiffness,
                ..tensioner(4, pretension)
            });
            let line = drive.tensioner.unwrap().line(&drive).unwrap();
            let found = cut(&drive, 3);
            let center = Vec2::new(found.place[0], found.place[1]);
            let (from, to) = (drive.sprockets[3].center - pivot, center - pivot);
            // Pull and spring act along the tangent, at the arm's length.
            let length = from.norm();
            let sense = cross(from, line.direction).signum();
            let turned = cross(from, to).atan2(from.dot(&to)) * sense;
            let own = sense * length * (line.pull - stiffness * length * turned);
            let chain = found.moment - cross(pivot, found.force) + cross(to, found.weight);
            assert!(
                (chain + own).abs() < 1e-5 * own.abs().max(length * found.tensions[0]),
                "pivot {pivot}, {pretension} N: the chain turns by {chain} N m, the arm by {own} N m"
            );
        }
    }
}

#[test]
fn the_matrix_at_rest_is_that_of_finite_differences_in_long_steps() {
    // Without what forces do to links and sprockets that turn under them, strands would be softer: at 1 ms by half, at 10 ms altogether.
    let spring = Tensioner {
        stiffness: 2e3,
        ..tensioner(4, 80.0)
    };
    let arm = Tensioner {
        pivot: Some(Vec2::new(0.0, 0.05)),
        arm_inertia: 3e-4,
        ..tensioner(4, 150.0)
    };
    for (name, tensioner) in [("slide", spring), ("arm", arm)] {
        let mut drive = three_shafts();
        drive.tensioner = Some(tensioner);
        let (_, mut dynamics, y) = at_rest(&drive);
        for gamma in [1e-4, 1e-3, 1e-2] {
            let lacking = lacks(&mut dynamics, 0.0, &y, gamma);
            assert!(lacking < 1e-3, "{name}, {gamma:e} s: {lacking:e}");
        }
    }
}

/// Two sprockets of 17 teeth on a level and a blade below the lower strand that presses upward.
fn bladed(links: u32, radius: Option<f64>, arm: Arm) -> Drive {
    let taut = closing_center_distance(PITCH, [17, 17], links).unwrap();
    let wheel = |x: f64, motion: SprocketMotion| sprocket(17, x, 0.0, Side::Inside, motion);
    let mut drive = drive_of(
        vec![
            wheel(0.0, SprocketMotion::PrescribedSpeed(10.0.into())),
            wheel(taut - 2e-3, SprocketMotion::AppliedTorque((-1.0).into())),
        ],
        links,
    );
    let middle = 0.5 * drive.sprockets[1].center.x;
    drive.guides = vec![Rail {
        shape: RailShape::Bar {
            length: 0.12,
            radius,
            end_radius: 0.006,
        },
        center: Vec2::new(middle, -0.07),
        direction: Vec2::new(0.0, 1.0),
        mount: Mount::Arm(Arm {
            pivot: Vec2::new(middle - 0.08, -0.075),
            ..arm
        }),
        material: None,
        plate_height: None,
    }];
    drive
}

fn plunger(force: f64) -> Arm {
    Arm {
        pivot: Vec2::zeros(),
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

/// Moment of the strands about a blade's pivot, and of its plunger, by the angle that it has turned by \[N m\].
fn moments(drive: &Drive) -> [f64; 2] {
    let Mount::Arm(arm) = drive.guides[0].mount else {
        panic!("an arm");
    };
    let found = cut(drive, 2);
    let chain = found.moment - cross(arm.pivot, found.force);
    let lever = drive.guides[0].lever(&arm);
    let turned = found.place[2] - drive.guides[0].angle();
    // The spring acts with the lever that the plunger has where the rail is described.
    let own = lever * (arm.force - arm.stiffness * lever * turned);
    [chain, own]
}

#[test]
fn the_strands_on_a_blade_or_shoe_balance_its_plunger() {
    for gravity in [0.0, -9.81] {
        for (radius, force, stiffness) in [
            (Some(0.25), 20.0, 0.0),
            (Some(0.25), 100.0, 0.0),
            (Some(0.2), 40.0, 300.0),
            (Some(0.4), 60.0, 2000.0),
        ] {
            let mut drive = bladed(
                60,
                radius,
                Arm {
                    stiffness,
                    ..plunger(force)
                },
            );
            drive.gravity = Vec2::new(0.0, gravity);
            let [chain, own] = moments(&drive);
            assert!(
                (chain + own).abs() < 1e-5 * force * 0.08, // the lever
                "{radius:?}, {force} N, {stiffness} N/m: {chain} N m and {own} N m"
            );
        }
    }
}

#[test]
fn a_hydraulic_plunger_rests_as_one_without_its_valve() {
    for force in [25.0, 90.0] {
        let mut plain = bladed(60, Some(0.25), plunger(force));
        let mut hydraulic = bladed(
            60,
            Some(0.25),
            Arm {
                damping: 40.0,
                damping_back: Some(4000.0),
                ..plunger(force)
            },
        );
        for drive in [&mut plain, &mut hydraulic] {
            drive.gravity = Vec2::zeros();
        }
        let [chain, own] = moments(&hydraulic);
        assert!((chain + own).abs() < 1e-5 * own.abs(), "{chain} {own}");
        let [other, _] = moments(&plain);
        assert!((chain - other).abs() < 1e-5 * own.abs());
    }
}

#[test]
fn a_hydraulic_plunger_leaks_down_at_its_force_over_its_leak() {
    // A blade away from the chain, with a spring that pulls it back to where it is described.
    for (damping, damping_back) in [(50.0, 800.0), (50.0, 3000.0)] {
        let stiffness = 2e4;
        let drive = bladed(
            60,
            Some(0.25),
            Arm {
                stiffness,
                damping,
                damping_back: Some(damping_back),
                inertia: 1e-7,
                ..plunger(0.0)
            },
        );
        let mut drive = drive;
        drive.gravity = Vec2::zeros();
        drive.sprockets[0].motion = SprocketMotion::PrescribedSpeed(0.0.into());
        drive.sprockets[1].motion = SprocketMotion::Free;
        drive.guides[0].center.y -= 0.05;
        let (mut start, _) = rustchain::layout::InitialConfiguration::generate(&drive).unwrap();
        let Mount::Arm(arm) = drive.guides[0].mount else {
            panic!("an arm");
        };
        let lever = drive.guides[0].lever(&arm);
        let described = drive.guides[0].angle();
        // Both ways: out, where the leak holds it; back, where the check valve lets it follow.
        for (out, dashpot) in [(1e-3, damping_back), (-1e-3, damping)] {
            let last = start.positions.len() - 1;
            start.positions[last][2] = described + out / lever;
            let model = Model::compile(&drive, &ForceLaws::default(), &start).unwrap();
            let mut run = Simulation::new(model.into(), &start, StepControl::default()).unwrap();
            let time = 0.3 * dashpot / stiffness;
            common::advance(&mut run, time);
            let left = lever * (run.present().evaluated.motion.angle[last] - described);
            let expected = out * (-stiffness * time / dashpot).exp();
            // Inertia takes J/(d lever²), a thousandth of that time at most.
            assert!(
                (left / expected - 1.0).abs() < 1e-2,
                "{dashpot}: {left} of {expected}"
            );
        }
    }
}
