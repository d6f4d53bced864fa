//! Kernels and the scalar reference at the edges: nothing between the centres, no speed, surfaces that just touch, numbers that are none.

use std::sync::Arc;

use crate::common::agreement::{Agreement, compare};
use crate::common::paper_drive;
use crate::common::scalar_reference::Reference;
use crate::common::scenes::{Noise, Scene, laws};
use rustchain::ForceLaws;
use rustchain::chain::dynamics::Dynamics;
use rustchain::chain::model::Support;
use rustchain::drive::Bearing;
use rustchain::force_law::{Damping, Elastic, Regions};
use rustchain::geometry::{Vec2, unit};
use rustchain::integrator::OdeSystem;
use rustchain::math::simd::InstructionSet;

/// One law of each form.
const LAWS: [Elastic; 4] = [
    Elastic::Hertz,
    Elastic::Johnson,
    Elastic::EnhancedCylinder,
    Elastic::LiuConformal,
];

fn all_laws() -> impl Iterator<Item = ForceLaws> {
    LAWS.into_iter().flat_map(|elastic| {
        [Damping::None, Damping::LankaraniNikravesh].map(|d| laws(elastic, d, Regions::Sharp))
    })
}

/// As for random states.
fn assert_agreement(a: &Agreement, what: &str) {
    assert!(
        a.hinge_depth <= 4.5 && a.tooth_depth <= 2.0,
        "{what}: {a:?}"
    );
    assert!(a.elastic <= 4.0 && a.force <= 2.0, "{what}: {a:?}");
    assert!(
        a.link <= 1.0 && a.sprocket <= 0.5 && a.power <= 0.35,
        "{what}: {a:?}"
    );
}

/// A straight row of links whose hinges open by `gap`, along y; all its numbers are sums of powers of two, so that nothing is rounded.
fn row(laws: &ForceLaws, clearance: f64, gap: f64) -> Scene {
    let mut scene = Scene::laid(&paper_drive(), laws);
    let model = Arc::get_mut(&mut scene.model).unwrap();
    model.half_pitch = 1.0 / 128.0;
    model.chain.arms.fill(1.0 / 128.0);
    model.hinges.clearance = clearance;
    for i in 0..model.links {
        scene.motion.x[i] = 10.0 + i as f64 / 64.0;
        scene.motion.y[i] = if i % 2 == 0 { 0.0 } else { gap };
        scene.motion.angle[i] = 0.0;
    }
    for speed in [
        &mut scene.motion.vx,
        &mut scene.motion.vy,
        &mut scene.motion.spin,
    ] {
        speed.fill(0.0);
    }
    scene
}

fn hinge_depths(scene: &Scene, set: InstructionSet) -> Vec<f64> {
    let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
    dynamics.use_instructions(set);
    dynamics.derivative(0.0, &scene.y(), &mut vec![0.0; scene.dimension()]);
    let closing = scene.model.links - 1;
    dynamics
        .hinge_contacts()
        .take(closing)
        .map(|(depth, _)| depth)
        .collect()
}

#[test]
fn coincident_centres_have_no_depth_and_no_force() {
    for laws in all_laws() {
        for clearance in [1.0 / 32768.0, 0.0] {
            let scene = row(&laws, clearance, 0.0);
            for set in InstructionSet::available() {
                assert!(hinge_depths(&scene, set).iter().all(|&depth| depth == 0.0));
                let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
                dynamics.use_instructions(set);
                assert_agreement(&compare(&mut dynamics, 0.0, &scene.y()), set.name());
            }
        }
    }
}

#[test]
fn a_distance_of_exactly_the_clearance_does_not_touch_and_the_next_number_does() {
    let clearance: f64 = 1.0 / 32768.0;
    for laws in all_laws() {
        for set in InstructionSet::available() {
            for gap in [clearance, clearance.next_down(), -clearance] {
                let depths = hinge_depths(&row(&laws, clearance, gap), set);
                assert!(depths.iter().all(|&depth| depth == 0.0), "{}", set.name());
            }
            for gap in [clearance.next_up(), -clearance.next_up()] {
                let depths = hinge_depths(&row(&laws, clearance, gap), set);
                let ulp = clearance.next_up() - clearance;
                // The square is rounded, and may fall on that of the clearance.
                assert!(depths.iter().all(|&depth| depth == ulp || depth == 0.0));
            }
            let gap = clearance + 1.0 / f64::from(1 << 24);
            let depths = hinge_depths(&row(&laws, clearance, gap), set);
            assert!(depths.iter().all(|&depth| depth == gap - clearance));
        }
    }
}

#[test]
fn without_clearance_a_hinge_is_as_deep_as_it_is_open() {
    for laws in all_laws() {
        let open = 1.0 / f64::from(1 << 24);
        let scene = row(&laws, 0.0, open);
        for set in InstructionSet::available() {
            assert!(hinge_depths(&scene, set).iter().all(|&depth| depth == open));
            let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
            dynamics.use_instructions(set);
            assert_agreement(&compare(&mut dynamics, 0.0, &scene.y()), set.name());
        }
    }
}

#[test]
fn denormal_places_and_speeds_are_those_of_the_scalar_reference() {
    let mut noise = Noise(5);
    for laws in all_laws() {
        for size in [5e-324, 1e-310, 1e-160] {
            let mut scene = Scene::laid(&paper_drive(), &laws);
            let bodies = scene.motion.x.len();
            scene
                .motion
                .set(&vec![[0.0; 3]; bodies], &vec![[0.0; 3]; bodies]);
            scene.shake(&mut noise, size, size);
            for set in InstructionSet::available() {
                let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
                dynamics.use_instructions(set);
                dynamics.keep_energy(true);
                assert_agreement(&compare(&mut dynamics, 0.0, &scene.y()), set.name());
            }
        }
    }
}

#[test]
fn links_that_have_turned_by_huge_angles_are_those_of_the_scalar_reference() {
    for laws in all_laws() {
        for angle in [1e5, 1e6, 1.000_001e6, 1e9, 1e15] {
            for away in [0.0, 1.0] {
                let mut scene = Scene::laid(&paper_drive(), &laws);
                scene.shake(&mut Noise(6), 1e-4, 0.1);
                let turn = 2.0 * std::f64::consts::PI;
                for (i, place) in scene.motion.angle.iter_mut().enumerate() {
                    *place += turn * (angle / turn).round() * [1.0, -1.0][i % 2] + away * i as f64;
                }
                for set in InstructionSet::available() {
                    let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
                    dynamics.use_instructions(set);
                    dynamics.keep_energy(true);
                    let agreement = compare(&mut dynamics, 0.0, &scene.y());
                    assert_agreement(&agreement, set.name());
                    assert!(agreement.touching > 5);
                }
            }
        }
    }
}

/// Bushing 1, seen from the first sprocket, turned back to angle zero, at this distance and angle, on a link that
/// points to the centre; the other links far away.
fn bushing_at(laws: &ForceLaws, distance: f64, angle: f64) -> Scene {
    let mut scene = Scene::laid(&paper_drive(), laws);
    let n = scene.model.links;
    let model = Arc::get_mut(&mut scene.model).unwrap();
    model.sprockets[0].phase = 0.0;
    model.hinges.clearance = 1e3;
    for i in 0..n {
        scene.motion.x[i] = 10.0 + i as f64;
    }
    let place = (distance + model.half_pitch) * unit(angle);
    (scene.motion.x[0], scene.motion.y[0]) = (place.x, place.y);
    scene.motion.angle[0] = angle + std::f64::consts::PI;
    scene
}

#[test]
fn a_bushing_on_the_tooth_s_centre_line_is_pushed_to_one_side_or_the_other() {
    for laws in LAWS.map(|elastic| laws(elastic, Damping::None, Regions::Sharp)) {
        let scene = bushing_at(&laws, 1.0, 0.0);
        let sprocket = &scene.model.sprockets[0];
        for gap in 0..sprocket.profile.teeth {
            let angle = (f64::from(gap) + 0.5) * sprocket.profile.gap_angle();
            let at = |turn: f64| bushing_at(&laws, sprocket.reach - 1e-5, angle + turn);
            let slope = |scene: &Scene, set: Option<InstructionSet>| {
                let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
                let y = scene.y();
                let mut dydt = vec![0.0; y.len()];
                if let Some(set) = set {
                    dynamics.use_instructions(set);
                    dynamics.derivative(0.0, &y, &mut dydt);
                    let nq = scene.model.coordinates;
                    return Vec2::new(dydt[nq], dydt[nq + scene.model.links]);
                }
                let [x, y, _] = Reference::of(&dynamics, 0.0, &y).accelerations;
                Vec2::new(x[0], y[0])
            };
            let sides = [-1e-13, 1e-13].map(|turn| slope(&at(turn), None));
            assert!(
                (sides[0] - sides[1]).norm() > 1e-3 * sides[0].norm(),
                "{sides:?}"
            );
            for set in InstructionSet::available() {
                let found = slope(&at(0.0), Some(set));
                let off = sides.map(|side| (found - side).norm() / side.norm());
                assert!(
                    off[0].min(off[1]) < 1e-8,
                    "{} gap {gap}: {off:?}",
                    set.name()
                );
            }
        }
    }
}

/// A shaken drive with a floating sprocket: hinges and teeth that touch, others that do not.
fn shaken(laws: &ForceLaws, shake: f64) -> Scene {
    let mut drive = paper_drive();
    drive.sprockets[1].bearing = Bearing::Floating;
    let mut scene = Scene::laid(&drive, laws);
    scene.shake(&mut Noise(8), shake, 0.1);
    scene
}

/// Accelerations (x, y, angle) of link `i`: of the kernels in a step, of the kernels for readers, of the scalar reference.
fn link_accelerations(dynamics: &mut Dynamics, y: &[f64], i: usize) -> [[f64; 3]; 3] {
    let mut dydt = vec![0.0; y.len()];
    dynamics.derivative(0.0, y, &mut dydt);
    dynamics.evaluate(0.0, y);
    let (n, nq) = (dynamics.model().links, dynamics.model().coordinates);
    let read = &dynamics.evaluated.accelerations;
    [
        [dydt[nq + i], dydt[nq + n + i], dydt[nq + 2 * n + i]],
        [read.x[i], read.y[i], read.angle[i]],
        Reference::of(dynamics, 0.0, y)
            .accelerations
            .map(|axis| axis[i]),
    ]
}

fn any_nan(values: [f64; 3]) -> bool {
    values.iter().any(|value| value.is_nan())
}

#[test]
fn a_place_that_is_no_number_comes_out_at_both_hinges() {
    for laws in all_laws() {
        let scene = shaken(&laws, 1e-4);
        let n = scene.model.links;
        let y = scene.y();
        for set in InstructionSet::available() {
            for coordinate in 0..3 * n {
                let (i, mut y) = (coordinate % n, y.clone());
                y[coordinate] = f64::NAN;
                // Once from nothing, and once with candidates that were chosen before.
                for before in [None, Some(scene.y())] {
                    let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
                    dynamics.use_instructions(set);
                    if let Some(before) = before {
                        let mut dydt = vec![0.0; y.len()];
                        dynamics.derivative(0.0, &before, &mut dydt);
                    }
                    for link in [(i + n - 1) % n, i, (i + 1) % n] {
                        let found = link_accelerations(&mut dynamics, &y, link);
                        assert!(
                            found.into_iter().all(any_nan),
                            "{} {laws:?}: coordinate {coordinate}, link {link}: {found:?}",
                            set.name()
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_speed_that_is_no_number_comes_out_where_a_damped_contact_feels_it() {
    for elastic in LAWS {
        let laws = laws(elastic, Damping::LankaraniNikravesh, Regions::Kept);
        let scene = shaken(&laws, 1.5e-5);
        let (n, nq) = (scene.model.links, scene.model.coordinates);
        for set in InstructionSet::available() {
            let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
            dynamics.use_instructions(set);
            dynamics.evaluate(0.0, &scene.y());
            let deep: Vec<bool> = dynamics
                .evaluated
                .hinges
                .penetration
                .iter()
                .map(|&d| d > 0.0)
                .collect();
            assert!(deep.iter().any(|&deep| deep) && deep.iter().any(|&deep| !deep));
            for i in 0..n {
                let mut y = scene.y();
                y[nq + i] = f64::NAN;
                let mut dydt = vec![0.0; y.len()];
                dynamics.derivative(0.0, &y, &mut dydt);
                assert!(dydt[i].is_nan());
                for k in [(i + n - 1) % n, i] {
                    for link in [k, (k + 1) % n] {
                        let found = link_accelerations(&mut dynamics, &y, link);
                        let expected = !deep[k] || found.into_iter().all(any_nan);
                        assert!(expected, "{} link {link}: {found:?}", set.name());
                    }
                }
            }
        }
    }
}

#[test]
fn a_sprocket_that_is_nowhere_is_felt_by_every_bushing_near_it_and_by_itself() {
    for laws in all_laws() {
        let scene = shaken(&laws, 1e-4);
        let Support::Floating { x, y: up } = scene.model.sprockets[1].support else {
            unreachable!()
        };
        let nq = scene.model.coordinates;
        for set in InstructionSet::available() {
            for before in [None, Some(scene.y())] {
                let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
                dynamics.use_instructions(set);
                let mut y = scene.y();
                let mut dydt = vec![0.0; y.len()];
                if let Some(before) = before {
                    dynamics.derivative(0.0, &before, &mut dydt);
                }
                y[x] = f64::NAN;
                dynamics.derivative(0.0, &y, &mut dydt);
                let touched = dynamics.candidates().filter(|c| c.0 == 1 && c.2.is_nan());
                assert!(touched.count() > 5);
                assert!(
                    dydt[nq + x].is_nan() && dydt[nq + up].is_nan(),
                    "{}",
                    set.name()
                );
                dynamics.evaluate(0.0, &y);
                let wheel = scene.model.links + 1;
                assert!(dynamics.evaluated.accelerations.x[wheel].is_nan());
                let reference = Reference::of(&dynamics, 0.0, &y);
                assert!(reference.loads[1].force.x.is_nan());
            }
        }
    }
}

/// What was evaluated before leaves no trace: bits on links and contacts, the order of a sum on sprockets.
#[test]
fn an_evaluation_is_the_same_after_any_other() {
    let mut noise = Noise(9);
    for laws in all_laws() {
        let scene = shaken(&laws, 1e-4);
        let (n, nq) = (scene.model.links, scene.model.coordinates);
        let good = scene.y();
        for set in InstructionSet::available() {
            let fresh = |y: &[f64]| {
                let mut dynamics = Dynamics::new(Arc::clone(&scene.model));
                dynamics.use_instructions(set);
                let mut dydt = vec![0.0; y.len()];
                dynamics.derivative(0.0, y, &mut dydt);
                (dynamics, dydt)
            };
            let (_, expected) = fresh(&good);
            for coordinate in 0..2 * nq {
                for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200, 1e5] {
                    let mut other = good.clone();
                    other[coordinate] = bad;
                    let (mut dynamics, mut dydt) = match noise.next() % 2 {
                        0 => fresh(&good),
                        _ => fresh(&other),
                    };
                    // Turned by some links, so that other runs go past the last bushing to the first.
                    let mut turned = other.clone();
                    for block in turned[..6 * n].chunks_mut(n) {
                        block.rotate_left((noise.next() % 3) as usize * 7);
                    }
                    for y in [&other, &turned, &other] {
                        dynamics.derivative(0.0, y, &mut dydt);
                    }
                    dynamics.derivative(0.0, &good, &mut dydt);
                    for (j, (found, expected)) in dydt.iter().zip(&expected).enumerate() {
                        let links = j < nq + 3 * n;
                        let near = (found - expected).abs() <= 1e-12 * expected.abs().max(1.0);
                        assert!(
                            if links {
                                found.to_bits() == expected.to_bits()
                            } else {
                                near
                            },
                            "{} {laws:?} after {bad} at {coordinate}: {j}: {found:e} {expected:e}",
                            set.name()
                        );
                    }
                }
            }
        }
    }
}
