//! Numerics without physics: SIMD arithmetic, piecewise functions, factorisations, roots along a step.

pub(crate) mod cholesky;
pub(crate) mod double_double;
pub mod piecewise;
mod real;
pub mod simd;
pub(crate) mod sparse_kkt;

pub(crate) use real::{Real, Truth};
