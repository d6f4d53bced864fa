//! The chain-drive system: contacts, kernels, the matrix of the implicit corrector, runs.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

mod bristles;
mod candidates;
mod elastic_links;
mod film;
mod friction;
mod guides;
mod ideal_hinges;
mod inputs;
mod kernel_edges;
mod kernels;
mod newton;
mod onsets;
mod open_motion;
mod open_tensioners;
mod paper_drive;
mod ratchets;
mod rollers;
mod signals;
mod tensioners;
mod tooth_forms;
