//! Numerics without physics: SIMD arithmetic, functions of time and of rows, factorisations.

pub(crate) mod dense;
pub(crate) mod double_double;
mod piecewise;
mod real;
mod scalar;
mod signal;
pub mod simd;
pub(crate) mod sparse_kkt;
#[cfg(test)]
pub(crate) mod testing;

pub use piecewise::{Spline, Table};
pub(crate) use real::{Real, Truth};
pub(crate) use scalar::{bisected, largest_magnitude};
pub use signal::Signal;
