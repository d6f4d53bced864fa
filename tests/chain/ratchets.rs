//! Ratchets of tensioners and of blades' arms: what they let go and hold, their energy, both methods, states.

use crate::common;
use crate::common::{advance, control, paper_drive, simulation, tensioner};
use rustchain::drive::{Arm, Drive, Mount, Rail, RailShape, SprocketMotion, Tensioner};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, StepControl};
use rustchain::{ForceLaws, Groups, Snapshot};

/// A drive whose load comes on after its tensioner has tightened the chain, and pulls it back.
fn pulled_back(ratchet: Option<f64>) -> Drive {
    let mut drive = paper_drive();
    drive.gravity = Vec2::zeros();
    let rows = [(0.0, 0.0), (0.008, 0.0), (0.012, -2.0)];
    let load = rustchain::math::Table::new("load", "N m", &rows).unwrap();
    drive.sprockets[1].motion = SprocketMotion::AppliedTorque(load.into());
    drive.tensioner = Some(Tensioner {
        damping: 100.0,
        ratchet,
        ..tensioner(10.0, 0.002)
    });
    drive
}

/// How far the tensioner has moved \[m\], every 0.1 ms of 30 ms.
fn way_of_tensioner(drive: &Drive) -> Vec<f64> {
    let mut run = simulation(drive, &ForceLaws::default(), control(1e-6));
    let body = drive.chain.links as usize + 1;
    (1..=300)
        .map(|i| {
            advance(&mut run, 1e-4 * f64::from(i));
            run.motion().positions()[body][0] - drive.sprockets[1].center.x
        })
        .collect()
}

/// How far the way falls back behind where a ratchet of these teeth holds it \[m\].
fn fallen_back(way: &[f64], step: f64) -> f64 {
    let (mut farthest, mut most) = (0.0_f64, 0.0_f64);
    for &s in way {
        farthest = farthest.max(s);
        let held = if step > 0.0 {
            (farthest / step).floor() * step
        } else {
            farthest
        };
        most = most.max(held - s);
    }
    most
}

#[test]
fn a_load_pulls_a_tensioner_back_but_for_its_ratchet() {
    let loose = way_of_tensioner(&pulled_back(None));
    assert!(
        fallen_back(&loose, 0.0) > 2e-4,
        "{}",
        fallen_back(&loose, 0.0)
    );
    for step in [0.0, 5e-5] {
        let held = way_of_tensioner(&pulled_back(Some(step)));
        let farthest = held.iter().copied().fold(0.0, f64::max);
        assert!(farthest > 2e-4, "{farthest}");
        // Strands of some hundred newtons at the most on a stop of 1e7 N/m.
        let back = fallen_back(&held, step);
        assert!(back < 1e-4, "{step}: {back}");
        assert!(back > 0.0, "{step}: the ratchet bears nothing");
        if step > 0.0 {
            // It gives way as far as the tooth, not only to where it has been.
            assert!(fallen_back(&held, 0.0) > back);
        }
    }
}

#[test]
fn the_energy_balance_closes_with_a_ratchet() {
    for step in [0.0, 5e-5] {
        let mut run = simulation(
            &pulled_back(Some(step)),
            &ForceLaws::default(),
            control(1e-7),
        );
        let found = common::energies(&mut run, 0.02, 1e-3);
        let (missing, dissipated) = (found.largest_residual(), *found.dissipated.last().unwrap());
        assert!(dissipated > 1e-3);
        assert!(missing < 1e-4 * dissipated, "{missing} of {dissipated}");
    }
}

#[test]
fn both_methods_agree_with_a_ratchet() {
    // Held from the first moment: a pull of nothing, and a load that draws the sprockets together.
    let mut drive = pulled_back(Some(0.0));
    drive.sprockets[1].motion = SprocketMotion::AppliedTorque((-2.0).into());
    drive.tensioner.as_mut().unwrap().pretension = 0.0;
    let explicit = control(1e-9);
    let implicit = StepControl {
        corrector: Corrector::Newton,
        accuracy: 1e-12,
        ..StepControl::default()
    };
    let places = [explicit, implicit].map(|control| {
        let mut run = simulation(&drive, &ForceLaws::default(), control);
        advance(&mut run, 2e-3);
        run.motion().positions()
    });
    for (one, other) in places[0].iter().zip(&places[1]) {
        assert!((one[0] - other[0]).hypot(one[1] - other[1]) < 2e-7);
    }
    let back = drive.sprockets[1].center.x - places[0][drive.chain.links as usize + 1][0];
    assert!(back.abs() < 5e-5, "{back}");
}

/// A blade on the lower strand whose plunger moves out on teeth of a millimetre, on either side of its pivot.
fn with_blade(side: f64) -> Drive {
    let mut drive = paper_drive();
    let middle = 0.5 * drive.sprockets[1].center.x;
    drive.gravity = Vec2::zeros();
    drive.guides = vec![Rail {
        shape: RailShape::Bar {
            length: 0.12,
            radius: Some(0.25),
            end_radius: 0.006,
        },
        center: Vec2::new(middle, -0.057),
        direction: Vec2::y(),
        mount: Mount::Arm(Arm {
            pivot: Vec2::new(middle - side * 0.08, -0.075),
            force: 40.0,
            ramp_time: 1e-3,
            stiffness: 0.0,
            damping: 50.0,
            damping_back: None,
            travel: [0.02, 0.04],
            inertia: 2e-4,
            ratchet: Some(1e-3),
        }),
        material: None,
        plate_height: None,
    }];
    drive
}

/// The way of the plunger in 19 ms, along its lever of 0.08 m: out of the face \[m\].
fn way_of_plunger(side: f64, ratchet: Option<f64>) -> Vec<f64> {
    let mut drive = with_blade(side);
    let Mount::Arm(arm) = &mut drive.guides[0].mount else {
        panic!("an arm");
    };
    arm.ratchet = ratchet;
    let mut run = simulation(&drive, &ForceLaws::default(), control(1e-6));
    let body = drive.chain.links as usize + 2;
    let described = std::f64::consts::FRAC_PI_2;
    (0..=95)
        .map(|i| {
            advance(&mut run, 2e-4 * f64::from(i));
            0.08 * side * (run.motion().positions()[body][2] - described)
        })
        .collect()
}

#[test]
fn a_blade_moves_out_on_its_ratchet_and_is_not_pressed_back() {
    for side in [1.0, -1.0] {
        let [loose, held] = [None, Some(1e-4)].map(|ratchet| way_of_plunger(side, ratchet));
        let farthest = held.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!(farthest > held[0] + 5e-3, "{farthest}");
        // Once it bears, the chain, which cannot press it back, is drawn tight by its driver and bends the stop.
        let [free, bent] = [(&loose, 0.0), (&held, 1e-4)].map(|(way, step)| fallen_back(way, step));
        assert!(bent < 0.5 * free, "{bent} {free}");
    }
}

#[test]
fn a_state_has_the_pawl_in_it() {
    let drive = pulled_back(Some(5e-5));
    let mut run = simulation(&drive, &ForceLaws::default(), control(1e-5));
    advance(&mut run, 0.011);
    let state = Snapshot::from_bytes(&run.snapshot().to_bytes().unwrap()).unwrap();
    let mut other = simulation(&drive, &ForceLaws::default(), control(1e-5));
    other.restore(&state).unwrap();
    for run in [&mut run, &mut other] {
        let groups = Groups {
            energy: true,
            ..Groups::default()
        };
        common::record(run, 0.004, 1e-3, groups);
    }
    assert_eq!(run.motion().positions(), other.motion().positions());
}
