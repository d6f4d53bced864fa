//! Layouts of many sprockets that several tests use.

use rustchain::drive::{AnsiTooth, Bearing, Drive, Faults, Motion, Sprocket, Tip};
use rustchain::geometry::belt::Side;
use rustchain::geometry::{Seat, Vec2};
use rustchain::state::links_around;

pub const PITCH: f64 = 0.0127;

pub fn sprocket(teeth: u32, x: f64, y: f64, side: Side, motion: Motion) -> Sprocket {
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
