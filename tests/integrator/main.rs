//! Orders, restarts and correctors of the integrator.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

mod bouncing_pin;
mod corrector_switching;
mod implicit_accuracy;
mod order;
mod restart;
