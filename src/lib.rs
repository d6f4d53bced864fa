//! Chain drives as planar multibody systems: clearance hinges, compliant contact with standard teeth, an embedded
//! variable-order Adams integrator.
//!
//! # Flow of data
//!
//! ```text
//! Drive ──> InitialConfiguration ──> Model ──> Simulation ──> Recording
//!                                                 │  ^
//!                                      time step  v  │  accelerations
//!                                              Adams <──> Dynamics
//! ```
//!
//! 1. A [`Drive`] describes chain, sprockets, tensioner, guides and gravity in SI units; `Drive::validate` checks it.
//! 2. [`layout::InitialConfiguration::generate`] computes positions and velocities without contact at time zero.
//!    [`Equilibrium::find`] computes the static equilibrium from there.
//! 3. [`Model::compile`] combines drive, force laws and initial configuration to flat tables, which are constant during a run.
//! 4. A [`Simulation`] steps the [`integrator::Adams`] integrator. The right-hand side is that of [`chain::dynamics::Dynamics`]: contact
//!    detection, contact forces from [`force_law`], accelerations. It writes to scratch arrays only, so that a step can be repeated.
//! 5. Between steps, the dynamics store the initial impact velocity of each new contact and integrate the energies.
//! 6. [`Simulation::record`] evaluates the dense output at the report times. [`Simulation::take_recording`] returns one row of each
//!    [`Channel`] per report time. A [`Snapshot`] is the complete state of a run.
//!
//! A planar mechanism has the same flow: [`multibody::Mechanism`], [`multibody::MechanismModel`], [`run::MechanismSimulation`].
//!
//! # Example
//!
//! Two sprockets of 17 teeth and 38 links at 120 rpm: 6 ms, in which the first bushings meet teeth. The energy balance residual is
//! small beside the kinetic energy.
//!
//! ```
//! use std::{f64::consts::PI, sync::Arc, time::Duration};
//!
//! use rustchain::drive::{
//!     AnsiTooth, Bearing, Chain, ClearanceHinge, Drive, Faults, HingeKind, Link, Material, Sprocket, SprocketMotion, Variation,
//! };
//! use rustchain::geometry::{Seat, Vec2, path::belt::Side};
//! use rustchain::integrator::StepControl;
//! use rustchain::layout::{InitialConfiguration, closing_center_distance};
//! use rustchain::{ForceLaws, Groups, Model, Simulation};
//!
//! let chain = Chain {
//!     pitch: 12.7e-3, // lengths in m, masses in kg, moments of inertia in kg m²
//!     links: 38,
//!     inner: Link { mass: 6.474e-3, inertia: 0.1795e-6 },
//!     outer: Link { mass: 8.265e-3, inertia: 0.1174e-6 },
//!     hinge: ClearanceHinge { pin_radius: 2.22e-3, bore_radius: 2.245e-3, length: 11e-3 },
//!     bushing_radius: 3.96875e-3,
//!     tooth_contact_length: 7e-3,
//!     material: Material::default(),
//!     offset: None,
//!     strands: 1,
//!     variation: Variation::default(),
//!     roller: None,
//!     link_stiffness: None,
//!     carried: Vec::new(),
//! };
//! let distance = closing_center_distance(chain.pitch, [17, 17], chain.links).ok_or("no such distance")?;
//! let sprocket = |x: f64, motion| Sprocket {
//!     teeth: 17,
//!     center: Vec2::new(x, 0.0),
//!     motion,
//!     profile: AnsiTooth { seat: Seat::PitchCircle, ..AnsiTooth::default() }.into(),
//!     faults: Faults::default(),
//!     mass: None, // of a steel disc
//!     inertia: None,
//!     initial_speed: None,
//!     bearing: Bearing::Fixed,
//!     side: Side::Inside,
//!     load_inertia: 0.0,
//! };
//! let speed = SprocketMotion::PrescribedSpeed((4.0 * PI).into()); // rad/s
//! let drive = Drive {
//!     chain,
//!     sprockets: vec![sprocket(0.0, speed), sprocket(distance, SprocketMotion::Free)],
//!     tensioner: None,
//!     gravity: Vec2::new(0.0, -9.81),
//!     guides: Vec::new(),
//!     ends: None,
//!     hinge_kind: HingeKind::Clearance,
//! };
//!
//! let (start, layout) = InitialConfiguration::generate(&drive)?;
//! assert_eq!(layout.strand_pitches, [10, 11]);
//! let model = Arc::new(Model::compile(&drive, &ForceLaws::default(), &start)?);
//! let mut simulation = Simulation::new(model, &start, StepControl::default())?;
//! let groups = Groups { teeth: true, energy: true, ..Groups::default() };
//! simulation.start_recording(6e-3, 1e-4, groups); // duration and report step [s]
//! while !simulation.record(Duration::from_secs(1))? {} // returns after each second of run time
//! let recording = simulation.take_recording();
//!
//! assert_eq!(recording.time.len(), 61);
//! let tooth_force = recording.real("peak_tooth_force"); // [N], a row of bushings by report
//! assert!(tooth_force.iter().any(|&force| force > 1.0));
//! let last = |name: &str| *recording.real(name).last().unwrap();
//! assert!(last("energy_residual").abs() < 1e-6 * last("energy_kinetic"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Modules
//!
//! A module imports from those on its left:
//!
//! ```text
//! math -> geometry -> force_law -> integrator -> drive -> layout -> system -> chain | multibody -> run -> fmu
//! ```
//!
//! [`geometry`] (plane curves), [`force_law`] (numbers in, newtons out) and [`integrator`] (depends only on
//! [`integrator::OdeSystem`]) are tested without a chain.

pub mod chain;
pub mod drive;
mod error;
pub mod fmu;
pub mod force_law;
pub mod geometry;
pub mod integrator;
pub mod layout;
pub mod math;
pub mod multibody;
mod panics;
pub mod run;
pub mod system;

#[cfg(feature = "python")]
mod python;

pub use chain::Groups;
pub use chain::model::{ForceLaws, Model};
pub use drive::Drive;
pub use error::{Error, Result};
pub use run::equilibrium::Equilibrium;
pub use run::simulation::{Simulation, Snapshot, Statistics, check_reports};
pub use system::{Channel, Recording, Values};
