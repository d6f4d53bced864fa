//! Loads on the bodies and their derivatives.

pub(crate) mod force_slopes;
pub(crate) mod loads;
