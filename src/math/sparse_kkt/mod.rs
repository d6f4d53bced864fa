//! Sparse factors of the constrained equations: structure, L D Lᵀ, L U of blocks, redundant rows.

pub(crate) mod block_lu;
pub(crate) mod ldlt;
pub(crate) mod null_space;
pub(crate) mod symbolic;
