//! Drives that several tests and benchmarks use.

use rustchain::drive::{AnsiTooth, Bearing, Chain, ClearanceHinge, Drive, Link, Material, Motion, Sprocket};
use rustchain::geometry::{Seat, Vec2};
use rustchain::state::closing_center_distance;

/// The chain of the paper's drive.
pub fn paper_chain() -> Chain {
    Chain {
        pitch: 0.0127,
        links: 38,
        inner: Link {
            mass: 6.474e-3,
            inertia: 0.1795e-6,
        },
        outer: Link {
            mass: 8.265e-3,
            inertia: 0.1174e-6,
        },
        hinge: ClearanceHinge {
            pin_radius: 2.22e-3,
            bore_radius: 2.245e-3,
            length: 0.011,
        },
        bushing_radius: 3.96875e-3,
        tooth_contact_length: 0.007,
        material: Material::default(),
    }
}

/// The paper's drive without pretension.
pub fn paper_drive() -> Drive {
    let chain = paper_chain();
    let distance = closing_center_distance(chain.pitch, [17, 17], chain.links).unwrap();
    let sprocket = |x: f64, motion: Motion| Sprocket {
        teeth: 17,
        center: Vec2::new(x, 0.0),
        motion,
        profile: AnsiTooth {
            seat: Seat::PitchCircle,
            roller_diameter: None,
        },
        mass: Some(0.817),
        inertia: Some(588.29e-6),
        initial_speed: None,
        bearing: Bearing::Fixed,
    };
    let driver = Motion::PrescribedSpeed((4.0 * std::f64::consts::PI).into());
    Drive {
        sprockets: vec![sprocket(0.0, driver), sprocket(distance, Motion::Free)],
        chain,
        tensioner: None,
        gravity: Vec2::new(0.0, -9.81),
    }
}
