//! Linear system of the implicit corrector.

pub(crate) mod implicit_matrix;
pub(crate) mod joints;
pub(crate) mod matrix;
pub(crate) mod sparse_system;
pub(crate) mod stage;
