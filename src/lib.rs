//! Chain drives as planar multibody systems: clearance hinges, compliant contact with standard teeth, an embedded
//! variable-order Adams integrator.
//!
//! The flow, each module importing from its left:
//!
//! ```text
//! drive -> state::Start -> model -> contact -> dynamics -> integrator -> recorder -> simulate -> ensemble
//! ```
//!
//! Three leaves stand free of the chain and are tested without one: [`geometry`] (plane curves), [`force_law`] (numbers in,
//! newtons out) and [`integrator`] (knows only [`integrator::OdeSystem`]).

pub mod contact;
pub mod drive;
pub mod dynamics;
pub mod ensemble;
mod equilibrium;
mod error;
pub mod force_law;
pub mod geometry;
pub mod integrator;
mod kernels;
pub mod mechanism;
pub mod model;
mod panics;
mod recorder;
mod simulate;
pub mod state;
pub mod vector;

#[cfg(feature = "python")]
mod python;

pub use drive::Drive;
pub use equilibrium::Equilibrium;
pub use error::{Error, Result};
pub use model::{ForceLaws, Model};
pub use recorder::{Channel, Groups, Recording, Values};
pub use simulate::{Simulation, Snapshot, Statistics, check_reports, check_rows};
