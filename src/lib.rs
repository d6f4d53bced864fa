//! Chain drives as planar multibody systems: clearance hinges, compliant contact with standard teeth, an embedded
//! variable-order Adams integrator.
//!
//! The flow, each module importing from its left:
//!
//! ```text
//! drive -> layout::Start -> model -> contact -> dynamics -> integrator -> recorder -> simulate -> ensemble
//! ```
//!
//! Three leaves stand free of the chain and are tested without one: [`geometry`] (plane curves), [`force_law`] (numbers in,
//! newtons out) and [`integrator`] (knows only [`integrator::OdeSystem`]).

pub mod chain;
pub mod drive;
mod error;
pub mod force_law;
pub mod geometry;
pub mod integrator;
pub mod layout;
pub mod math;
pub mod multibody;
mod panics;
pub mod run;

#[cfg(feature = "python")]
mod python;

pub use chain::model::{ForceLaws, Model};
pub use drive::Drive;
pub use error::{Error, Result};
pub use run::equilibrium::Equilibrium;
pub use run::recorder::{Channel, Groups, Recording, Values};
pub use run::simulation::{Simulation, Snapshot, Statistics, check_reports, check_rows};
