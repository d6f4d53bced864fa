//! Mechanisms: joints, forces, contacts, runs.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

mod clearance;
mod friction;
mod from_drive;
mod inputs;
mod joints;
mod large;
mod mechanism;
mod newton;
mod outlines;
mod redundant;
mod singular;
mod spin;
mod starts;
