//! Initial configurations of chain drives.

#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

mod generated_drives;
mod layouts;
mod open_chains;
mod preload;
mod starts;
