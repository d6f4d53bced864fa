//! Force laws and their slopes.

#![allow(clippy::unwrap_used)]

mod bristle_law;
mod complex_step;
