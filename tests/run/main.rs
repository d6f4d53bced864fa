//! What all runs share: energy balance, reports, states, ensembles.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

mod co_simulation;
mod energy_balance;
mod energy_meter;
mod ensemble;
mod panics;
mod recorded_groups;
mod rows_in_pieces;
mod state;
