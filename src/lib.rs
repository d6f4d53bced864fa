//! Chain drives as planar multibody systems: clearance hinges, compliant contact with standard teeth, an embedded
//! variable-order Adams integrator.
//!
//! A module imports from those on its left:
//!
//! ```text
//! math -> geometry -> force_law -> integrator -> drive -> layout -> system -> chain | multibody -> run -> fmu
//! ```
//!
//! [`drive`] describes a chain drive, [`layout`] makes its initial configuration, [`chain::model`] compiles both, and [`run`] integrates
//! the equations of motion of [`chain::dynamics`] with [`integrator`]. [`multibody`] does the same for any planar mechanism. [`geometry`]
//! (plane curves), [`force_law`] (numbers in, newtons out) and [`integrator`] (depends only on [`integrator::OdeSystem`]) are tested
//! without a chain.

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
