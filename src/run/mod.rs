//! Runs of a system: stepping, reports, energy balance, states, static equilibrium, ensembles.

pub mod ensemble;
pub(crate) mod equilibrium;
#[cfg(feature = "python")]
pub(crate) mod ideal_drive;
pub mod mechanism;
pub mod recorder;
pub mod simulation;
