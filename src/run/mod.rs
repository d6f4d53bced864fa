//! Runs of a system: stepping, reports, energy balance, states, static equilibrium, ensembles.

mod any;
mod drive;
pub mod ensemble;
pub(crate) mod equilibrium;
pub(crate) mod ideal_drive;
mod mechanism;
pub(crate) mod recorder;
pub mod simulation;

pub use any::AnySimulation;
pub use ideal_drive::{IdealDrive, IdealGroups};
pub use mechanism::MechanismSimulation;
