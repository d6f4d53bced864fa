//! Runs of a system: stepping, reports, energy balance, states, static equilibrium, ensembles.

pub mod ensemble;
pub(crate) mod equilibrium;
pub mod mechanism;
pub mod recorder;
pub mod simulation;
