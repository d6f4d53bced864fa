//! Sparse factors of the constrained equations: structure, L D Lᵀ, redundant rows.

pub(crate) mod ldlt;
pub(crate) mod null_space;
pub(crate) mod symbolic;
