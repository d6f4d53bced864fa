//! Runs of a system: stepping, reports, energy balance, states, static equilibrium, ensembles.

mod any;
mod drive;
pub mod ensemble;
pub(crate) mod equilibrium;
mod mechanism;
pub(crate) mod recorder;
pub mod simulation;

pub use any::AnySimulation;
pub use mechanism::MechanismSimulation;
