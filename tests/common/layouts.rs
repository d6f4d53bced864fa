//! Layouts of many sprockets that several tests use.

use rustchain::drive::{
    AnsiTooth, Arm, Bearing, Drive, Faults, HingeKind, Mount, Rail, RailShape, Sprocket,
    SprocketMotion, Tensioner, Tip,
};
use rustchain::geometry::path::belt::Side;
use rustchain::geometry::{Seat, Vec2};
use rustchain::layout::links_around;

pub const PITCH: f64 = 0.0127;

pub fn sprocket(teeth: u32, x: f64, y: f64, side: Side, motion: SprocketMotion) -> Sprocket {
    Sprocket {
        teeth,
        center: Vec2::new(x, y),
        motion,
        profile: AnsiTooth {
            seat: Seat::BottomDiameter,
            roller_diameter: None,
            tip: Tip::Full,
            edge_radius: None,
        }
        .into(),
        mass: None,
        inertia: None,
        initial_speed: None,
        bearing: Bearing::Fixed,
        faults: Faults::default(),
        side,
        load_inertia: 0.0,
    }
}

pub fn drive_of(sprockets: Vec<Sprocket>, links: u32) -> Drive {
    let mut chain = super::paper_chain();
    chain.links = links;
    Drive {
        chain,
        sprockets,
        tensioner: None,
        gravity: Vec2::new(0.0, -9.81),
        guides: Vec::new(),
        ends: None,
        hinge_kind: HingeKind::Clearance,
    }
}

/// A driver, two shafts and a reverse idler on the upper strand.
pub fn three_shafts() -> Drive {
    let mut drive = drive_of(
        vec![
            sprocket(
                17,
                0.0,
                0.0,
                Side::Inside,
                SprocketMotion::PrescribedSpeed(20.0.into()),
            ),
            sprocket(25, 0.35, -0.05, Side::Inside, SprocketMotion::Free),
            sprocket(21, 0.25, 0.22, Side::Inside, SprocketMotion::Free),
            sprocket(13, 0.092, 0.107, Side::Outside, SprocketMotion::Free),
        ],
        100,
    );
    drive.chain.links = links_around(&drive).unwrap();
    drive
}

/// The same with an arm that pulls the idler and loads on both shafts, a fixed rail beside the strand between the shafts, and a blade
/// on an arm that presses on the lowest strand.
pub fn guided_shafts() -> Drive {
    let mut drive = three_shafts();
    drive.sprockets[0].motion = SprocketMotion::PrescribedSpeed((-40.0).into());
    for shaft in [1, 2] {
        drive.sprockets[shaft].motion = SprocketMotion::AppliedTorque(2.0.into());
        drive.sprockets[shaft].load_inertia = 5e-3;
    }
    drive.tensioner = Some(Tensioner {
        sprocket: 4,
        pivot: Some(Vec2::new(0.0, 0.05)),
        ..super::tensioner(60.0, 0.01)
    });
    let rail = Rail {
        shape: RailShape::Bar {
            length: 0.12,
            radius: None,
            end_radius: 0.005,
        },
        center: Vec2::new(0.3517, 0.1058),
        direction: Vec2::new(-0.928, -0.372),
        mount: Mount::Fixed,
        material: None,
        plate_height: None,
    };
    let blade = Rail {
        shape: RailShape::Bar {
            length: 0.16,
            radius: Some(0.4),
            end_radius: 0.006,
        },
        center: Vec2::new(0.163, -0.083),
        direction: Vec2::new(0.186, 0.983),
        mount: Mount::Arm(Arm {
            pivot: Vec2::new(0.07, -0.08),
            force: 30.0,
            ramp_time: 0.01,
            stiffness: 0.0,
            damping: 50.0,
            damping_back: Some(1000.0),
            travel: [0.05, 0.05],
            inertia: 5e-4,
            ratchet: None,
        }),
        material: None,
        plate_height: None,
    };
    drive.guides = vec![rail, blade];
    drive
}
