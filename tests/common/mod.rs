//! Drives and runs that several tests use.

// Every test binary compiles this file anew and uses a part of it.
#![allow(dead_code, unreachable_pub)]

pub mod agreement;
pub mod checks;
pub mod layouts;
pub mod mechanisms;
pub mod open;
pub mod rubbing;
pub mod scalar_reference;
pub mod scenes;

use std::sync::Arc;
use std::time::Duration;

use rustchain::drive::{
    AnsiTooth, Bearing, Chain, ClearanceHinge, Drive, Faults, HingeKind, Link, Material, Roller,
    Sprocket, SprocketMotion, Tensioner, Variation,
};
use rustchain::geometry::path::belt::Side;
use rustchain::geometry::{Seat, Vec2};
use rustchain::integrator::{Corrector, StepControl};
use rustchain::layout::{InitialConfiguration, closing_center_distance};
use rustchain::{ForceLaws, Groups, Model, Recording, Simulation, Values};

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
        bushing_radius: 3.968_75e-3,
        tooth_contact_length: 0.007,
        material: Material::default(),
        offset: None,
        strands: 1,
        variation: Variation::default(),
        roller: None,
        link_stiffness: None,
        carried: Vec::new(),
    }
}

/// The same chain with rollers of the same outside radius, whose mass the inner links go without.
pub fn roller_chain() -> Chain {
    let chain = paper_chain();
    let roller = Roller {
        radius: chain.bushing_radius,
        bore_radius: 2.848e-3,
        length: 7.9375e-3,
        mass: 1.497e-3,
        inertia: 1.786e-8,
    };
    Chain {
        inner: Link {
            mass: chain.inner.mass - 2.0 * roller.mass,
            ..chain.inner
        },
        bushing_radius: 2.798e-3,
        roller: Some(roller),
        ..chain
    }
}

/// The paper's drive with rollers.
pub fn roller_drive() -> Drive {
    Drive {
        chain: roller_chain(),
        ..paper_drive()
    }
}

/// The paper's drive without pretension.
pub fn paper_drive() -> Drive {
    let chain = paper_chain();
    let distance = closing_center_distance(chain.pitch, [17, 17], chain.links).unwrap();
    let sprocket = |x: f64, motion: SprocketMotion| Sprocket {
        teeth: 17,
        center: Vec2::new(x, 0.0),
        motion,
        profile: AnsiTooth {
            seat: Seat::PitchCircle,
            ..AnsiTooth::default()
        }
        .into(),
        faults: Faults::default(),
        mass: Some(0.817),
        inertia: Some(588.29e-6),
        initial_speed: None,
        bearing: Bearing::Fixed,
        side: Side::Inside,
        load_inertia: 0.0,
    };
    let driver = SprocketMotion::PrescribedSpeed((4.0 * std::f64::consts::PI).into());
    Drive {
        sprockets: vec![
            sprocket(0.0, driver),
            sprocket(distance, SprocketMotion::Free),
        ],
        chain,
        tensioner: None,
        gravity: Vec2::new(0.0, -9.81),
        guides: Vec::new(),
        ends: None,
        hinge_kind: HingeKind::Clearance,
    }
}

/// The paper's tensioner, on the driven sprocket.
pub fn tensioner(pretension: f64, ramp_time: f64) -> Tensioner {
    Tensioner {
        sprocket: 2,
        pretension,
        ramp_time,
        damping: 2000.0,
        damping_back: None,
        direction: None,
        stiffness: 0.0,
        travel: [f64::INFINITY; 2],
        pivot: None,
        arm_inertia: 0.0,
        ratchet: None,
    }
}

/// The explicit method at one tolerance, relative and absolute.
pub fn control(tolerance: f64) -> StepControl {
    StepControl {
        rtol: tolerance,
        atol: tolerance,
        corrector: Corrector::Pece,
        ..StepControl::default()
    }
}

/// A run of `drive` from its generated start.
pub fn simulation(drive: &Drive, laws: &ForceLaws, control: StepControl) -> Simulation {
    let (start, _) = InitialConfiguration::generate(drive).unwrap();
    let model = Arc::new(Model::compile(drive, laws, &start).unwrap());
    Simulation::new(model, &start, control).unwrap()
}

/// Goes on to `time` \[s\], however long it takes.
pub fn advance(simulation: &mut Simulation, time: f64) {
    assert!(simulation.advance(time, Duration::MAX).unwrap());
    assert_eq!(simulation.time(), time);
}

/// Records `groups` from now for `duration` \[s\], every `report_step` \[s\].
pub fn record(
    simulation: &mut Simulation,
    duration: f64,
    report_step: f64,
    groups: Groups,
) -> Recording {
    simulation.start_recording(duration, report_step, groups);
    assert!(simulation.record(Duration::MAX).unwrap());
    simulation.take_recording()
}

/// The values of one channel of real numbers.
pub fn channel(recording: &Recording, name: &str) -> Vec<f64> {
    let channel = recording
        .channels
        .iter()
        .find(|channel| channel.name == name)
        .unwrap();
    match &channel.values {
        Values::Real(values) => values.clone(),
        Values::Whole(_) => panic!("{name} has whole numbers"),
    }
}

/// The energy balance at each report \[J\].
pub struct Energies {
    pub kinetic: Vec<f64>,
    pub elastic: Vec<f64>,
    pub dissipated: Vec<f64>,
    pub external_work: Vec<f64>,
    pub residual: Vec<f64>,
}

impl Energies {
    /// Largest residual of all reports \[J\].
    pub fn largest_residual(&self) -> f64 {
        self.residual
            .iter()
            .fold(0.0, |largest, r| largest.max(r.abs()))
    }
}

/// Runs for `duration` \[s\] with the energy balance.
pub fn energies(simulation: &mut Simulation, duration: f64, report_step: f64) -> Energies {
    let groups = Groups {
        energy: true,
        ..Groups::default()
    };
    energies_of(&record(simulation, duration, report_step, groups))
}

/// The energy balance of a recording.
pub fn energies_of(recording: &Recording) -> Energies {
    Energies {
        kinetic: channel(recording, "energy_kinetic"),
        elastic: channel(recording, "energy_elastic"),
        dissipated: channel(recording, "energy_dissipated"),
        external_work: channel(recording, "energy_external_work"),
        residual: channel(recording, "energy_residual"),
    }
}
